//! Laws of the goniometric mode: flux, reciprocity, limits, and correct standard errors.
//!
//! Each family of comparisons has a level of 10⁻³: a false alarm in a thousand seeds.

use std::f64::consts::PI;

use snowblue_stat::{Moments, chi_squared_p_value, sidak_level, z_p_value};
use snowblue_transport::monte_carlo::{self, Distribution, GoniometricOptions, MonteCarloOptions, Patch, PatchGrid};
use snowblue_transport::ordinates::{self, OrdinatesOptions};
use snowblue_transport::sample::SnowSample;
use snowblue_transport::slab::{Estimate, Incidence, Slab};

const LEVEL: f64 = 1e-3;

fn slab(thickness_cm: f64, angles_deg: &[f64], wavelengths_nm: &[f64]) -> Slab {
    Slab {
        sample: SnowSample::default(),
        thicknesses_cm: vec![thickness_cm],
        incidences: angles_deg.iter().map(|angle_deg| Incidence::Beam { angle_deg: *angle_deg }).collect(),
        wavelengths_nm: wavelengths_nm.to_vec(),
    }
}

fn distribute(slab: &Slab, rays: u64, seed: u64, patches: PatchGrid) -> Vec<Distribution> {
    let options = GoniometricOptions { rays, seed, patches };
    monte_carlo::distribute(slab, &options, &|_| ()).unwrap()
}

/// p-value of a difference between two independent estimates.
fn p_value(a: Estimate, b: Estimate) -> f64 {
    z_p_value((a.value - b.value) / a.standard_error.hypot(b.standard_error))
}

/// The least of many p-values, and the level that it must exceed.
fn worst(p_values: &[f64]) -> (f64, f64) {
    (p_values.iter().copied().fold(1.0, f64::min), sidak_level(LEVEL, p_values.len()))
}

/// ∫ f cosθ dω over all patches is the flux, and the flux is that of the spectral mode: within the standard error of
/// its shared paths, and to rounding for the same rays, traced one wavelength at a time.
#[test]
fn patches_add_up_to_the_flux() {
    let slab = Slab {
        incidences: vec![Incidence::Beam { angle_deg: 0.0 }, Incidence::Beam { angle_deg: 70.0 }, Incidence::Diffuse],
        ..slab(0.5, &[], &[500.0, 1300.0])
    };
    let spread = distribute(&slab, 10_000, 1, PatchGrid { rings: 10, sectors: 12 });
    let fluxes = |seed, per_wavelength| {
        let options = MonteCarloOptions { rays: 10_000, seed, per_wavelength };
        monte_carlo::solve(&slab, &options, &|_| ()).unwrap()
    };
    let (same_rays, fluxes) = (fluxes(1, true), fluxes(2, false));
    assert_eq!((spread.len(), spread.len()), (same_rays.len(), fluxes.len()));
    let mut p_values = Vec::new();
    for (spread, (same_rays, fluxes)) in spread.iter().zip(same_rays.iter().zip(&fluxes)) {
        assert_eq!((spread.incidence, spread.wavelength_nm), (fluxes.incidence, fluxes.wavelength_nm));
        // 10,000 terms below 1, summed in another order.
        assert!((spread.reflectance.value - same_rays.fluxes.reflectance.value).abs() < 1e-12);
        assert!((spread.transmittance.value - same_rays.fluxes.transmittance.value).abs() < 1e-12);
        let integral = |patches: &[Patch]| -> f64 {
            patches.iter().map(|patch| patch.bsdf_per_sr.value * PI / patches.len() as f64).sum()
        };
        assert!((integral(&spread.reflection) - spread.reflectance.value).abs() < 1e-12);
        let below = integral(&spread.transmission) + spread.direct.value;
        assert!((below - spread.transmittance.value).abs() < 1e-12);
        p_values.extend([
            p_value(spread.reflectance, fluxes.fluxes.reflectance),
            p_value(spread.transmittance, fluxes.fluxes.transmittance),
        ]);
        if let Incidence::Beam { angle_deg } = spread.incidence {
            let path = slab.optical_depth(slab.thicknesses_cm[0]) / angle_deg.to_radians().cos();
            let exact = Estimate { value: (-path).exp(), standard_error: 0.0 };
            // At 70° one ray in 2·10⁸ is transmitted unscattered, so there must be none.
            if exact.value > 1e-4 {
                p_values.push(p_value(spread.direct, exact));
            } else {
                assert!(spread.direct.value <= 0.0);
            }
        }
    }
    let (least, level) = worst(&p_values);
    assert!(least > level, "{p_values:?}");
}

/// Mean BSDF between rings of incidence and patches of exit: [ring in][ring out][sector] on either side.
///
/// The mean over incidence within a ring is Gauss's with three nodes in sin²θ, in which the BSDF is smooth away from
/// the horizon: the outermost ring is left out.
fn between_rings(slab: &Slab, PatchGrid { rings, sectors }: PatchGrid, rays: u64) -> Vec<Vec<[Estimate; 2]>> {
    let nodes = [(0.5 - 0.15_f64.sqrt(), 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.5 + 0.15_f64.sqrt(), 5.0 / 18.0)];
    let angle = |ring: usize, node: f64| ((ring as f64 + node) / rings as f64).sqrt().asin().to_degrees();
    let angles: Vec<f64> = (0..rings - 1).flat_map(|ring| nodes.map(|(node, _)| angle(ring, node))).collect();
    let incidences = angles.iter().map(|angle_deg| Incidence::Beam { angle_deg: *angle_deg }).collect();
    let spread = distribute(&Slab { incidences, ..slab.clone() }, rays, 3, PatchGrid { rings, sectors });
    let mean = |beams: &[Distribution], patch: usize| {
        let over = |estimate: &dyn Fn(&Distribution) -> Estimate| {
            let terms = || nodes.iter().zip(beams).map(|((_, share), beam)| (share, estimate(beam)));
            Estimate {
                value: terms().map(|(share, term)| share * term.value).sum(),
                standard_error: terms().map(|(share, term)| (share * term.standard_error).powi(2)).sum::<f64>().sqrt(),
            }
        };
        [over(&|beam| beam.reflection[patch].bsdf_per_sr), over(&|beam| beam.transmission[patch].bsdf_per_sr)]
    };
    spread.chunks_exact(3).map(|beams| (0..rings * sectors).map(|patch| mean(beams, patch)).collect()).collect()
}

/// Helmholtz: f(θ → θ', φ) = f(θ' → θ, φ), in reflection, and in transmission of a slab that is equal from both sides;
/// with absorption and without. Negative control: f cosθ', the intensity, is not reciprocal.
#[test]
fn the_bsdf_is_reciprocal() {
    let (rings, sectors) = (5, 3);
    let (mut reciprocal, mut control) = (Vec::new(), Vec::new());
    for wavelength_nm in [500.0, 1300.0] {
        let between = between_rings(&slab(0.3, &[], &[wavelength_nm]), PatchGrid { rings, sectors }, 25_000);
        let cosine = |ring: usize| (1.0 - (ring as f64 + 0.5) / rings as f64).sqrt();
        let scaled = |e: Estimate, by: f64| Estimate { value: e.value * by, standard_error: e.standard_error * by };
        for (i, j) in (0..rings - 1).flat_map(|j| (0..j).map(move |i| (i, j))) {
            for (sector, side) in (0..sectors).flat_map(|sector| [(sector, 0), (sector, 1)]) {
                let there = between[i][j * sectors + sector][side];
                let back = between[j][i * sectors + sector][side];
                reciprocal.push(p_value(there, back));
                control.push(p_value(scaled(there, cosine(j)), scaled(back, cosine(i))));
            }
        }
    }
    let (least, level) = worst(&reciprocal);
    assert!(least > level, "{least} {level} {reciprocal:?}");
    let (least, level) = worst(&control);
    assert!(least < 1e-6 * level, "the intensity passes as reciprocal: {least}");
}

/// Standard errors are correct: over many seeds, deviations from the mean in units of the error have unit variance.
/// Negative control: errors a tenth too small are detected.
#[test]
fn standard_errors_are_correct() {
    const SEEDS: u64 = 600;
    let slab = slab(0.1, &[50.0], &[1300.0]);
    let runs: Vec<Distribution> = (0..SEEDS)
        .map(|seed| distribute(&slab, 1000, 100 + seed, PatchGrid { rings: 3, sectors: 2 }).remove(0))
        .collect();
    let estimates = |run: &Distribution| -> Vec<Estimate> {
        let patches = run.reflection.iter().chain(&run.transmission).map(|patch| patch.bsdf_per_sr);
        patches.chain([run.reflectance, run.transmittance, run.direct]).collect()
    };
    let count = estimates(&runs[0]).len();
    let p_values = |factor: f64| -> Vec<f64> {
        let p_value = |i: usize| {
            let (mut values, mut squared_errors) = (Moments::default(), Moments::default());
            for run in &runs {
                let estimate = estimates(run)[i];
                values.push(estimate.value);
                squared_errors.push((factor * estimate.standard_error).powi(2));
            }
            let freedom = (SEEDS - 1) as f64;
            let upper = chi_squared_p_value(freedom * values.variance() / squared_errors.mean(), freedom);
            2.0 * upper.min(1.0 - upper)
        };
        (0..count).map(p_value).collect()
    };
    let (least, level) = worst(&p_values(1.0));
    assert!(least > level, "{least} {level}");
    let (least, level) = worst(&p_values(0.9));
    assert!(least < level, "errors a tenth too small pass: {least} {level}");
}

/// Deep snow diffuses the beam: the BTDF is the same at all azimuths and follows the escape function,
/// f = T K₀(μ)/π, K₀ = (3/7)(1 + 2μ) within 2 % (Kokhanovsky & Zege 2004, doi:10.1364/AO.43.001589).
/// Negative control: thin snow does not.
#[test]
fn deep_snow_transmits_independently_of_azimuth() {
    let (rings, sectors) = (4, 6);
    let azimuths = |spread: &Distribution| {
        let rings = spread.transmission.chunks_exact(sectors);
        let chi_squared: f64 = rings
            .map(|ring| {
                let mean = ring.iter().map(|patch| patch.bsdf_per_sr.value).sum::<f64>() / sectors as f64;
                let z = |patch: &Patch| (patch.bsdf_per_sr.value - mean) / patch.bsdf_per_sr.standard_error;
                ring.iter().map(|patch| z(patch).powi(2)).sum::<f64>()
            })
            .sum();
        chi_squared_p_value(chi_squared, 4.0 * 5.0)
    };
    let deep = distribute(&slab(2.5, &[60.0], &[500.0]), 60_000, 4, PatchGrid { rings, sectors }).remove(0);
    assert!(azimuths(&deep) > LEVEL, "{}", azimuths(&deep));
    let thin = distribute(&slab(0.1, &[60.0], &[500.0]), 60_000, 4, PatchGrid { rings, sectors }).remove(0);
    assert!(azimuths(&thin) < 1e-12);
    for hemisphere in [&thin.reflection, &thin.transmission] {
        let outermost = &hemisphere[(rings - 1) * sectors..];
        let (forward, backward) = (outermost[0].bsdf_per_sr, outermost[sectors - 1].bsdf_per_sr);
        assert!(forward.value > 2.0 * backward.value, "grains scatter forward: {outermost:?}");
    }
    for (number, ring) in deep.transmission.chunks_exact(sectors).enumerate() {
        // The mean of 1 + 2μ over the ring, where μ² is uniform.
        let cube = |ring: usize| (1.0 - ring as f64 / 4.0).powf(1.5);
        let expected =
            deep.transmittance.value / PI * 3.0 / 7.0 * (1.0 + 16.0 / 3.0 * (cube(number) - cube(number + 1)));
        let mean = ring.iter().map(|patch| patch.bsdf_per_sr.value).sum::<f64>() / sectors as f64;
        let error = ring[0].bsdf_per_sr.standard_error / (sectors as f64).sqrt();
        assert!((mean / expected - 1.0).abs() < 0.02 + 4.0 * error / expected, "ring {number}: {mean}, {expected}");
    }
}

/// Under Lambertian light the radiance towards θ is, by reciprocity, the flux under a beam from θ:
/// π f = T(θ) − direct below and R(θ) above. The fluxes are those of discrete ordinates.
#[test]
fn radiance_under_lambertian_light_has_the_fluxes_of_ordinates() {
    let rings = 6;
    let diffuse = Slab { incidences: vec![Incidence::Diffuse], ..slab(0.4, &[], &[600.0]) };
    let spread = distribute(&diffuse, 200_000, 5, PatchGrid { rings, sectors: 1 }).remove(0);
    // Midpoints in sin²θ, in which fluxes are smooth except at the horizon.
    let parts = 8;
    let angles: Vec<f64> =
        (0..rings * parts).map(|i| ((i as f64 + 0.5) / (rings * parts) as f64).sqrt().asin().to_degrees()).collect();
    let beams = slab(0.4, &angles, &[600.0]);
    let options = OrdinatesOptions { tally_rays: 1 << 16, ..OrdinatesOptions::default() };
    let fluxes = ordinates::solve_without_errors(&beams, &options).unwrap();
    let depth = beams.optical_depth(0.4);
    for ring in 0..rings {
        let fluxes = &fluxes[ring * parts..(ring + 1) * parts];
        let angles = &angles[ring * parts..(ring + 1) * parts];
        let direct: f64 = angles.iter().map(|deg| (-depth / deg.to_radians().cos()).exp()).sum();
        let transmittance: f64 = fluxes.iter().map(|flux| flux.fluxes.transmittance.value).sum();
        let reflectance: f64 = fluxes.iter().map(|flux| flux.fluxes.reflectance.value).sum();
        for (patch, flux) in
            [(spread.transmission[ring], transmittance - direct), (spread.reflection[ring], reflectance)]
        {
            let expected = flux / parts as f64 / PI;
            // 0.2 % for the tally and for the midpoints in the outermost ring.
            let allowed = 4.0 * patch.bsdf_per_sr.standard_error + 0.002 * expected;
            assert!((patch.bsdf_per_sr.value - expected).abs() < allowed, "ring {ring}: {patch:?}, {expected}");
        }
    }
}
