//! Conservation, invariance and limits, which hold for any snow.

use proptest::prelude::*;
use snowblue_transport::batch::{Batch, SlabCase};
use snowblue_transport::grain::Grain;
use snowblue_transport::grain::Spheroid;
use snowblue_transport::monte_carlo::{self, GoniometricOptions, MonteCarloOptions, PatchGrid};
use snowblue_transport::ordinates::{self, HomogeneousMedium, MediumFluxes, ModalLight, OrdinatesOptions, Streams};
use snowblue_transport::rng::Stream;
use snowblue_transport::sample::{GrainSize, SizeMeasure, SnowSample, TruncatedNormal};
use snowblue_transport::slab::{Estimate, Incidence, Radiometry, Slab};
use snowblue_transport::stack::{Layer, Stack};
use snowblue_transport::{HenyeyGreenstein, Scattering};

const NORMAL: Incidence = Incidence::Beam { angle_deg: 0.0 };

fn beam(medium: &Scattering, depth: f64, cos_incidence: f64, streams: usize) -> MediumFluxes {
    let medium = HomogeneousMedium::new(medium, streams);
    medium.fluxes(depth, &[medium.beam(cos_incidence)])[0]
}

fn isotropic(one_minus_albedo: f64, streams: usize) -> Scattering {
    HenyeyGreenstein { one_minus_albedo, asymmetry: 0.0 }.scattering(streams)
}

/// Asserts that two estimates, or an estimate and a number without error, differ by at most 4 standard errors.
fn assert_within_four_sigma(estimate: Estimate, expected: f64, what: &str) {
    let gap = (estimate.value - expected).abs();
    assert!(gap <= 4.0 * estimate.standard_error, "{what}: {estimate:?}, expected {expected}");
}

/// Without absorption R + T = 1.
#[test]
fn energy_is_conserved() {
    for g in [-0.3, 0.0, 0.75, 0.89, 0.996] {
        for depth in [1e-6, 1e-2, 1.0, 30.0, 1e3, 1e5] {
            for cos_incidence in [1.0, 0.5, 0.017] {
                let fluxes = beam(
                    &HenyeyGreenstein { one_minus_albedo: 0.0, asymmetry: g }.scattering(32),
                    depth,
                    cos_incidence,
                    32,
                );
                let sum = fluxes.reflectance + fluxes.transmittance;
                // Rounding of sums over 16 modes, some ten times larger than their result at grazing incidence.
                assert!((sum - 1.0).abs() < 1e-11, "g {g} τ {depth} μ₀ {cos_incidence}: R + T = {sum}");
            }
        }
    }
}

/// Grains that neither deflect nor absorb transmit everything, and black grains transmit only direct light.
#[test]
fn invisible_and_black_grains() {
    let straight_on = Scattering { one_minus_albedo: 0.0, moments: vec![1.0; 33] };
    assert!((beam(&straight_on, 500.0, 0.3, 32).transmittance - 1.0).abs() < 1e-15);
    let black = Scattering { one_minus_albedo: 1.0, moments: vec![1.0; 33] };
    let fluxes = beam(&black, 3.0, 0.5, 32);
    assert!((fluxes.transmittance / (-6.0_f64).exp() - 1.0).abs() < 1e-13);
    assert!((fluxes.direct / (-6.0_f64).exp() - 1.0).abs() < 1e-13);
}

/// Under Lambertian light the mean paths depend on the grains through B only (Blanco & Fournier 2003,
/// doi:10.1209/epl/i2003-00208-x): 2h through pores, 2κh scattering events, 2hφB through ice, with B = n² for rough
/// grains.
#[test]
fn mean_paths_are_invariant() {
    let rough = |psi| SnowSample {
        sphericity: TruncatedNormal::exactly(psi),
        facetness: TruncatedNormal::exactly(0.6),
        ..SnowSample::default()
    };
    let smooth_balls = SnowSample {
        sphericity: TruncatedNormal::exactly(1.0),
        facetness: TruncatedNormal::exactly(0.0),
        ..SnowSample::default()
    };
    let n: f64 = 1.3130;
    let ball = (n.powi(3) - (n * n - 1.0).powf(1.5)) / n;
    for (sample, enhancement) in [(rough(0.9), n * n), (rough(0.6), n * n), (smooth_balls, ball)] {
        let slab = Slab {
            sample,
            thicknesses_cm: vec![1.0],
            incidences: vec![Incidence::Diffuse],
            wavelengths_nm: vec![500.0],
        };
        let paths = monte_carlo::mean_paths(
            &slab,
            &MonteCarloOptions { rays: 40_000, seed: 5, ..MonteCarloOptions::default() },
        )
        .unwrap();
        assert_within_four_sigma(paths.pore_m, 0.02, "pore path");
        assert_within_four_sigma(paths.hits, 0.02 * sample.extinction_per_m(), "hits");
        assert_within_four_sigma(paths.ice_m, 0.02 * sample.ice_fraction() * enhancement, "ice path");
    }
}

/// A thick conservative isotropic slab has T = (√3/4) H(μ₀) (4/3)/(τ + 2·0.710446), with H from Chandrasekhar
/// (1960). The error of the formula decays as e^{−τ}; H has seven figures.
#[test]
fn conservative_isotropic_slab() {
    for (cos_incidence, h) in [(1.0, 2.907_811), (0.5, 2.012_779)] {
        for depth in [10.0, 50.0, 200.0] {
            let expected = 3_f64.sqrt() / 4.0 * h * (4.0 / 3.0) / (depth + 1.420_892);
            let fluxes = beam(&isotropic(0.0, 64), depth, cos_incidence, 64);
            assert!(
                (fluxes.transmittance / expected - 1.0).abs() < 1e-6 + (-depth).exp(),
                "{depth} {cos_incidence} {fluxes:?}"
            );
        }
    }
    assert!((beam(&isotropic(0.0, 64), 1.0, 1.0, 64).reflectance - 0.341_329).abs() < 1e-6);
}

/// Plane albedo of a semi-infinite isotropic medium at normal incidence, 1 − √(1 − ω) H(1) (Chandrasekhar 1960).
#[test]
fn semi_infinite_isotropic_albedo() {
    for (one_minus_albedo, expected) in [(0.1, 0.414_947), (0.01, 0.752_721), (0.001, 0.912_845)] {
        let fluxes = beam(&isotropic(one_minus_albedo, 64), 1e4, 1.0, 64);
        assert!((fluxes.reflectance - expected).abs() < 1e-6, "{fluxes:?}");
        assert!((0.0..1e-100).contains(&fluxes.transmittance), "10⁴ optical depths transmit almost nothing");
    }
}

/// Asymptotic theory (Kokhanovsky & Zege 2004, doi:10.1364/AO.43.001589) within its 2 %.
#[test]
fn asymptotic_transmittance() {
    let g = 0.7;
    for one_minus_albedo in [1e-7, 1e-5, 1e-4, 1e-3_f64] {
        for depth in [20.0, 100.0, 300.0_f64] {
            for cos_incidence in [0.5, 0.8, 1.0] {
                let x = depth * (3.0 * one_minus_albedo * (1.0 - g)).sqrt();
                if x > 8.0 {
                    continue;
                }
                let y = 4.0 * (one_minus_albedo / (3.0 * (1.0 - g))).sqrt();
                let escape = 3.0 / 7.0 * (1.0 + 2.0 * cos_incidence);
                let expected = escape * y.sinh() / (x + 1.07 * y).sinh();
                let medium = HenyeyGreenstein { one_minus_albedo, asymmetry: g }.scattering(32);
                let transmittance = beam(&medium, depth, cos_incidence, 32).transmittance;
                assert!((transmittance / expected - 1.0).abs() < 0.02, "{one_minus_albedo} {depth} {cos_incidence}");
            }
        }
    }
}

fn default_slab(sample: SnowSample, thickness_cm: f64) -> Slab {
    Slab {
        sample,
        thicknesses_cm: vec![thickness_cm],
        incidences: vec![NORMAL],
        wavelengths_nm: vec![400.0, 500.0, 600.0, 700.0],
    }
}

fn by_ordinates(slab: &Slab) -> Vec<Radiometry> {
    let options = OrdinatesOptions { tally_rays: 1 << 16, ..OrdinatesOptions::default() };
    ordinates::solve_without_errors(slab, &options).unwrap()
}

/// Dry snow depends on the load ρh only, and ln T of deep snow has the slope √(3 σ_a κ (1 − g)).
#[test]
fn transmittance_depends_on_load_and_becomes_exponential() {
    let dense = SnowSample { density_kg_m3: 400.0, ..SnowSample::default() };
    let loose = SnowSample { density_kg_m3: 200.0, ..SnowSample::default() };
    for (a, b) in by_ordinates(&default_slab(dense, 10.0)).iter().zip(&by_ordinates(&default_slab(loose, 20.0))) {
        assert!((a.fluxes.transmittance.value / b.fluxes.transmittance.value - 1.0).abs() < 1e-12);
    }
    // HG with k small: the diffusion exponent k² = 3(1 − ω)(1 − ωg)(1 + O(1 − ω)).
    let (one_minus_albedo, g) = (1e-6_f64, 0.7);
    let medium = HenyeyGreenstein { one_minus_albedo, asymmetry: g }.scattering(32);
    let (near, far) = (beam(&medium, 2e4, 1.0, 32).transmittance, beam(&medium, 3e4, 1.0, 32).transmittance);
    let slope = (near / far).ln() / 1e4;
    let expected = (3.0 * one_minus_albedo * (1.0 - g * (1.0 - one_minus_albedo))).sqrt();
    assert!((slope / expected - 1.0).abs() < 1e-5, "{slope} {expected}");
}

/// The paper's trends: T increases with grain size, decreases with facetness, density, thickness and angle, and
/// is larger in the blue than in the red.
#[test]
fn trends() {
    let base = SnowSample::default();
    let transmittances = |sample: SnowSample, thickness_cm: f64, angle_deg: f64| -> Vec<f64> {
        let incidences = vec![Incidence::Beam { angle_deg }];
        by_ordinates(&Slab { incidences, ..default_slab(sample, thickness_cm) })
            .iter()
            .map(|r| r.fluxes.transmittance.value)
            .collect()
    };
    let reference = transmittances(base, 15.0, 0.0);
    assert!(reference.is_sorted_by(|a, b| a > b), "T is larger in the blue than in the red: {reference:?}");
    let coarse = transmittances(SnowSample { grain_size: GrainSize::around(500.0).unwrap(), ..base }, 15.0, 0.0);
    let faceted = transmittances(SnowSample { facetness: TruncatedNormal::facetness_around(0.7), ..base }, 15.0, 0.0);
    let dense = transmittances(SnowSample { density_kg_m3: 400.0, ..base }, 15.0, 0.0);
    let (thick, slanted) = (transmittances(base, 25.0, 0.0), transmittances(base, 15.0, 60.0));
    for (i, value) in reference.iter().enumerate() {
        assert!(coarse[i] > *value);
        for darker in [&faceted, &dense, &thick, &slanted] {
            assert!(darker[i] < *value);
        }
    }
}

/// g and B of a single kind of grain, with their standard errors.
fn single_grain(sphericity: f64, roughness: f64, relative_index: f64) -> (Estimate, Estimate) {
    const RAYS: u64 = 400_000;
    let shape = Spheroid::of_unit_size(sphericity, SizeMeasure::GreatestExtension);
    let grain = Grain { shape, roughness, relative_index };
    let (mut cosines, mut paths) = (Vec::new(), Vec::new());
    for ray in 0..RAYS {
        let scattered = grain.scatter(&mut Stream::new(17, ray));
        cosines.push(scattered.cos_scattering);
        paths.push(scattered.ice_path / shape.mean_chord());
    }
    (estimate(&cosines), estimate(&paths))
}

fn estimate(values: &[f64]) -> Estimate {
    let mut moments = snowblue_stat::Moments::default();
    values.iter().for_each(|value| moments.push(*value));
    Estimate { value: moments.mean(), standard_error: moments.standard_error() }
}

/// Asymmetry of smooth grains and the ice path in smooth and rough ones, as in geometric optics without diffraction.
/// The asymmetries are computed values with four digits, ± 0.0005.
#[test]
fn single_grain_facts() {
    let near = |estimate: Estimate, expected: f64, what: &str| {
        let allowed = (4.0 * estimate.standard_error).hypot(0.0005);
        assert!((estimate.value - expected).abs() < allowed, "{what}: {estimate:?}, expected {expected}");
    };
    for (n, g) in [(1.30, 0.7893), (1.31, 0.7816), (1.32, 0.7743), (1.33, 0.7668_f64)] {
        let (asymmetry, enhancement) = single_grain(1.0, 0.0, n);
        near(asymmetry, g, "sphere");
        let closed: f64 = (n.powi(3) - (n * n - 1.0).powf(1.5)) / n;
        assert_within_four_sigma(enhancement, closed, "ice path in a sphere");
    }
    for (psi, g) in [(0.9, 0.7490), (0.8, 0.7178), (0.7, 0.7372), (0.6, 0.8000)] {
        let (asymmetry, enhancement) = single_grain(psi, 0.0, 1.31);
        near(asymmetry, g, "smooth spheroid");
        if (psi - 0.8_f64).abs() < 1e-9 {
            near(enhancement, 1.385, "ice path in a smooth spheroid");
        }
    }
    for (roughness, g) in [(0.05, 0.708), (0.1, 0.676), (0.2, 0.602), (0.3, 0.550)] {
        let (asymmetry, enhancement) = single_grain(0.8, roughness, 1.311);
        near(asymmetry, g, "rough spheroid");
        assert_within_four_sigma(enhancement, 1.311 * 1.311, "ice path in a rough spheroid");
    }
}

/// Straight chords through an absorbing sphere: ⟨e^{−γℓ}⟩ = 2[1 − (1 + y)e^{−y}]/y², y = γd (van de Hulst 1957, §11.2).
#[test]
fn absorbing_sphere_without_refraction() {
    let shape = Spheroid::of_unit_size(1.0, SizeMeasure::GreatestExtension);
    let grain = Grain { shape, roughness: 0.1, relative_index: 1.0 };
    for y in [0.01, 1.0, 20.0_f64] {
        let left: Vec<f64> =
            (0..100_000).map(|ray| (-y * grain.scatter(&mut Stream::new(3, ray)).ice_path).exp()).collect();
        assert_within_four_sigma(estimate(&left), 2.0 * (1.0 - (1.0 + y) * (-y).exp()) / (y * y), "transmission");
    }
}

/// Asymmetry over the paper's population (Ψ 0.7–0.9) at 550 nm, computed, ± 0.0003.
#[test]
fn asymmetry_of_the_papers_population() {
    use snowblue_transport::{Demand, GrainTallies, Population, TallyPlan};
    for (facetness, g) in [(0.1, 0.722), (0.3, 0.698), (0.5, 0.661), (0.7, 0.622), (0.9, 0.589)] {
        let sample = SnowSample { facetness: TruncatedNormal::facetness_around(facetness), ..SnowSample::default() };
        let plan = TallyPlan { degree: 2, rays: 1 << 20, seed: 2 };
        let demand = Demand::of_sample(&sample, &[550.0]);
        let tallies = GrainTallies::new(&Population::of_sample(&sample), &demand, &plan);
        let asymmetry = tallies.medium(&sample, 550.0).scattering.asymmetry();
        // Rounding of the third digit, the stated 0.0003, and 4 σ of this tally, were its rays independent: 0.45/2¹⁰.
        assert!((asymmetry - g).abs() < 0.0005 + 0.0003 + 0.0018, "{facetness}: {asymmetry}, expected {g}");
    }
}

/// Monte Carlo standard errors are correct: over many seeds, deviations in units of the error have unit variance (χ²).
#[test]
fn standard_errors_are_correct() {
    const SEEDS: u64 = 300;
    for per_wavelength in [false, true] {
        let slab = Slab { wavelengths_nm: vec![450.0, 700.0], ..default_slab(SnowSample::default(), 0.1) };
        let run = |seed| {
            let options = MonteCarloOptions { rays: 1024, seed, per_wavelength };
            monte_carlo::solve(&slab, &options, &|_| ()).unwrap()
        };
        let answers: Vec<Vec<Radiometry>> = (0..SEEDS).map(run).collect();
        for (wavelength, quantity) in [(0, 0), (1, 0), (0, 1), (1, 1), (1, 2)] {
            let pick = |answer: &Vec<Radiometry>| {
                let row = answer[wavelength];
                [row.fluxes.reflectance, row.fluxes.transmittance, row.fluxes.absorptance][quantity]
            };
            let mean = answers.iter().map(|answer| pick(answer).value).sum::<f64>() / SEEDS as f64;
            let squares =
                answers.iter().map(|answer| ((pick(answer).value - mean) / pick(answer).standard_error).powi(2));
            // With errors from 64 batches the mean square is 63/61; 1 in 1000 at either end.
            let chi_squared = squares.sum::<f64>() * if per_wavelength { 1.0 } else { 61.0 / 63.0 };
            let above = snowblue_stat::chi_squared_p_value(chi_squared, SEEDS as f64 - 1.0);
            assert!((0.001..0.999).contains(&above), "{per_wavelength} {wavelength} {quantity}: {chi_squared}");
        }
    }
}

/// Standard errors of the ordinates are correct: over many seeds of the tallies, deviations in units of the error have
/// the mean square 15/13 of errors from 16 batches.
#[test]
fn standard_errors_of_tallies_are_correct() {
    const SEEDS: u64 = 200;
    let beam = |angle_deg| Incidence::Beam { angle_deg };
    let wet = SnowSample { water_saturation: 0.1, ..SnowSample::default() };
    for (sample, streams) in [(SnowSample::default(), Streams::Auto), (wet, Streams::Exactly(16))] {
        let slab = Slab {
            sample,
            thicknesses_cm: vec![0.02, 1.0, 30.0],
            incidences: vec![beam(0.0), beam(60.0), beam(88.0), Incidence::Diffuse],
            wavelengths_nm: vec![450.0, 1030.0, 1300.0],
        };
        let run = |seed| ordinates::solve(&slab, &OrdinatesOptions { tally_rays: 1 << 10, streams, seed }).unwrap();
        let answers: Vec<Vec<Radiometry>> = (0..SEEDS).map(run).collect();
        for row in 0..answers[0].len() {
            for quantity in 0..3 {
                let all = || answers.iter().map(|answer| answer[row].fluxes.to_array()[quantity]);
                let mean = all().map(|one| one.value).sum::<f64>() / SEEDS as f64;
                if mean < 1e-9 {
                    continue;
                }
                let square = all().map(|one| ((one.value - mean) / one.standard_error).powi(2)).sum::<f64>();
                let ratio = square / (SEEDS as f64 - 1.0) / (15.0 / 13.0);
                // Squares of Student's t with 15 degrees of freedom have a relative variance of 28/11.
                let allowed = 4.0 * (28.0 / 11.0 / SEEDS as f64).sqrt();
                assert!((ratio - 1.0).abs() < allowed, "{ratio} {quantity} {:?}", answers[0][row]);
            }
        }
    }
}

/// Any number of threads gives the same bits, of rays and of what is solved at each wavelength.
#[test]
fn results_do_not_depend_on_threads() {
    let slab = Slab { wavelengths_nm: vec![450.0, 650.0], ..default_slab(SnowSample::default(), 0.5) };
    let wet = SnowSample { water_saturation: 0.2, ..slab.sample };
    let stack = Stack {
        layers: vec![Layer::snow(slab.sample, 0.5), Layer::snow(wet, 0.2)],
        ground_albedo: 0.3.into(),
        depths_cm: vec![0.1],
        incidences: slab.incidences.clone(),
        wavelengths_nm: slab.wavelengths_nm.clone(),
    };
    let case = |sample| SlabCase { sample, thickness_cm: 0.5, incidence: NORMAL, ground_albedo: 0.0.into() };
    let samples = vec![slab.sample, wet];
    let batch = Batch { samples, cases: vec![case(0), case(1)], wavelengths_nm: slab.wavelengths_nm.clone() };
    let by_rays = || {
        let options = |per_wavelength| MonteCarloOptions { rays: 1000, seed: 1, per_wavelength };
        let in_patches = GoniometricOptions { rays: 1000, seed: 1, patches: PatchGrid { rings: 5, sectors: 4 } };
        (
            [false, true].map(|each| monte_carlo::solve(&slab, &options(each), &|_| ()).unwrap()),
            monte_carlo::solve_stack(&stack, &options(false), &|_| ()).unwrap(),
            monte_carlo::distribute(&slab, &in_patches, &|_| ()).unwrap(),
        )
    };
    let by_ordinates = || {
        let options = OrdinatesOptions { tally_rays: 1 << 10, ..OrdinatesOptions::default() };
        (
            ordinates::solve(&slab, &options).unwrap(),
            ordinates::solve_stack(&stack, &options).unwrap(),
            ordinates::solve_batch(&batch, &options, true, &|_| ()).unwrap(),
        )
    };
    let on_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| (by_rays(), by_ordinates()))
    };
    assert_eq!(on_threads(1), on_threads(3));
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 400,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(7),
        ..ProptestConfig::default()
    })]

    /// For any medium, depth and angle R and T are fractions, and T decreases with depth.
    #[test]
    fn fluxes_are_fractions(
        exponent in -13.0..0.0_f64, g in -0.9..0.999_f64, depth_exponent in -6.0..5.0_f64,
        cos_incidence in 2e-4..1.0_f64, half_streams in prop::sample::select(vec![1_usize, 2, 4, 8, 16, 32]),
    ) {
        let (one_minus_albedo, depth) = (10_f64.powf(exponent), 10_f64.powf(depth_exponent));
        let streams = 2 * half_streams;
        let medium = HenyeyGreenstein { one_minus_albedo, asymmetry: g }.scattering(streams);
        let fluxes = beam(&medium, depth, cos_incidence, streams);
        let deeper = beam(&medium, 1.1 * depth, cos_incidence, streams);
        prop_assert!(fluxes.reflectance >= -1e-12 && fluxes.transmittance >= 0.0, "{fluxes:?}");
        prop_assert!(fluxes.reflectance + fluxes.transmittance <= 1.0 + 1e-10, "{fluxes:?}");
        prop_assert!(deeper.transmittance <= fluxes.transmittance * (1.0 + 1e-10) , "{fluxes:?} {deeper:?}");
    }

    /// Any phase function, as a mixture of single angles, is refused, or its fluxes are fractions.
    #[test]
    fn any_phase_function_is_solved_or_refused(
        exponent in -13.0..0.0_f64, cosines in prop::collection::vec(-1.0..1.0_f64, 1..6),
        depth_exponent in -3.0..4.0_f64, half_streams in prop::sample::select(vec![2_usize, 8, 16, 32]),
    ) {
        let streams = 2 * half_streams;
        let legendre = |l: usize, x: f64| {
            let (mut before, mut here) = (0.0, 1.0);
            for k in 0..l {
                (before, here) = (here, ((2 * k + 1) as f64 * x * here - k as f64 * before) / (k + 1) as f64);
            }
            here
        };
        let moment = |l| cosines.iter().map(|cosine| legendre(l, *cosine)).sum::<f64>() / cosines.len() as f64;
        let medium = Scattering {
            one_minus_albedo: 10_f64.powf(exponent),
            moments: (0..=streams).map(|l| moment(l).clamp(-1.0, 1.0)).collect(),
        };
        if HomogeneousMedium::check(&medium, streams).is_ok() {
            let solved = HomogeneousMedium::new(&medium, streams);
            let lambertian = solved.fluxes(10_f64.powf(depth_exponent), &[ModalLight::Lambertian])[0];
            prop_assert!(lambertian.reflectance >= -1e-10 && lambertian.transmittance >= -1e-10, "{lambertian:?}");
            prop_assert!(lambertian.reflectance + lambertian.transmittance <= 1.0 + 1e-9, "{lambertian:?}");
        }
    }
}
