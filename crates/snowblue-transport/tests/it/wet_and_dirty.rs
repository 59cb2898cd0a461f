//! Wet snow and impurities: laws, limits, and the agreement of both engines.

use snowblue_transport::monte_carlo::{self, MonteCarloOptions};
use snowblue_transport::optics::{Impurities, Substance};
use snowblue_transport::ordinates::{self, OrdinatesOptions, Streams};
use snowblue_transport::sample::{GrainSize, SizeMeasure, SnowSample, TruncatedNormal};
use snowblue_transport::slab::{Estimate, Fluxes, Incidence, Radiometry, Slab};
use snowblue_transport::stack::{Layer, Stack};
use snowblue_transport::sunlight::{Band, BandWeights, irradiance_w_m2, wavelengths_nm};
use snowblue_transport::{Demand, GrainTallies, Medium, Population, TallyPlan};

/// A small tally, for laws that hold for any phase function.
const FEW_RAYS: OrdinatesOptions = OrdinatesOptions { streams: Streams::Auto, tally_rays: 1 << 10, seed: 1 };

fn wet(water_saturation: f64) -> SnowSample {
    SnowSample { water_saturation, ..SnowSample::default() }
}

fn sooty(ng_g: f64) -> SnowSample {
    SnowSample { impurities: Impurities::none().with(Substance::BLACK_CARBON, ng_g), ..SnowSample::default() }
}

fn slab(sample: SnowSample, thickness_cm: f64, wavelengths_nm: &[f64]) -> Slab {
    Slab {
        sample,
        thicknesses_cm: vec![thickness_cm],
        incidences: vec![Incidence::Beam { angle_deg: 0.0 }],
        wavelengths_nm: wavelengths_nm.to_vec(),
    }
}

fn one_layer(sample: SnowSample, thickness_cm: f64) -> Stack {
    Stack {
        layers: vec![Layer::snow(sample, thickness_cm)],
        ground_albedo: 0.0.into(),
        depths_cm: vec![],
        incidences: vec![Incidence::Beam { angle_deg: 0.0 }],
        wavelengths_nm: vec![400.0, 1000.0],
    }
}

fn medium(sample: &SnowSample, wavelength_nm: f64) -> Medium {
    let plan = TallyPlan { degree: 2, rays: 1 << 18, seed: 5 };
    GrainTallies::new(&Population::of_sample(sample), &Demand::of_sample(sample, &[wavelength_nm]), &plan)
        .medium(sample, wavelength_nm)
}

fn transmittance(sample: SnowSample, thickness_cm: f64, wavelength_nm: f64) -> f64 {
    let slab = slab(sample, thickness_cm, &[wavelength_nm]);
    ordinates::solve_without_errors(&slab, &OrdinatesOptions::default()).unwrap()[0].fluxes.transmittance.value
}

/// Grains entirely in water at 550 nm, n = 1.3110/1.3347: 1 − g is 0.0040 for a smooth sphere, 0.0044 for the default
/// grains, near the 0.004 expected.
#[test]
fn grains_in_water_scatter_forward() {
    let one = |sphericity, facetness| SnowSample {
        sphericity: TruncatedNormal::exactly(sphericity),
        facetness: TruncatedNormal::exactly(facetness),
        ..wet(1.0)
    };
    for (sample, name) in [(one(1.0, 0.0), "smooth sphere"), (one(0.8, 0.3), "rough spheroid"), (wet(1.0), "default")] {
        let sideways = 1.0 - medium(&sample, 550.0).scattering.asymmetry();
        assert!((0.0038..0.0046).contains(&sideways), "{name}: 1 − g = {sideways}");
    }
}

/// κ(1 − g) decreases as 1 − S_w (1 − 1/r), where κ(1 − g) of grains in water is r times smaller than in air: 54 for
/// the smooth sphere to 70 for rough grains.
#[test]
fn water_dilutes_scattering() {
    let turned = |medium: &Medium| medium.extinction_per_m * (1.0 - medium.scattering.asymmetry());
    let dry = turned(&medium(&wet(0.0), 550.0));
    for saturation in [0.1, 0.2, 0.5, 1.0] {
        let found = turned(&medium(&wet(saturation), 550.0)) / dry;
        let between = |r: f64| 1.0 - saturation * (1.0 - 1.0 / r);
        // The tallies' error is some 10⁻³.
        assert!(between(70.0) - 1e-3 < found && found < between(54.0) + 1e-3, "S_w = {saturation}: {found}");
    }
}

/// In the blue, where neither ice nor water absorbs much, wet snow attenuates less than dry snow of equal dry density
/// (measured: Fukami). In the red the absorption by water can outweigh this.
#[test]
fn wet_snow_transmits_more_blue_light() {
    for thickness_cm in [1.0, 5.0, 15.0] {
        let passed: Vec<f64> =
            [0.0, 0.1, 0.3, 0.6, 1.0].map(|saturation| transmittance(wet(saturation), thickness_cm, 450.0)).to_vec();
        assert!(passed.is_sorted_by(|a, b| a < b), "{thickness_cm} cm: {passed:?}");
    }
}

/// In wet snow: under Lambertian light the mean path through ice, with n_water² times the path in grains in
/// water, is 2hφ n_ice². The law of dry snow is among those of all snow.
#[test]
fn mean_ice_path_does_not_depend_on_water() {
    let n: f64 = 1.3130;
    for saturation in [0.3, 0.8, 1.0] {
        let sample = SnowSample { facetness: TruncatedNormal::exactly(0.6), ..wet(saturation) };
        let slab = Slab { incidences: vec![Incidence::Diffuse], ..slab(sample, 0.5, &[500.0]) };
        let options = MonteCarloOptions { rays: 60_000, seed: 6, ..MonteCarloOptions::default() };
        let paths = monte_carlo::mean_paths(&slab, &options).unwrap();
        for (found, expected, what) in [
            (paths.ice_m, 0.01 * sample.ice_fraction() * n * n, "ice path"),
            (paths.pore_m, 0.01, "pore path"),
            (paths.hits, 0.01 * sample.extinction_per_m(), "hits"),
        ] {
            let z = (found.value - expected) / found.standard_error;
            assert!(z.abs() < 4.0, "S_w = {saturation}, {what}: {found:?}, expected {expected}");
        }
    }
}

/// The absorption of black carbon, σ_a = ρ c E (1 − ω), adds to that of ice, κ (1 − ω_grain), in a slab so thick that
/// T ∝ e^{−h √(3 σ_a κ(1 − g))}.
#[test]
fn absorption_of_black_carbon_adds_to_that_of_ice() {
    let clean = medium(&sooty(0.0), 500.0);
    let dirty = medium(&sooty(10.0), 500.0);
    let absorbed = |medium: &Medium| medium.extinction_per_m * medium.scattering.one_minus_albedo;
    // 10⁻⁸ · 300 kg/m³ · 12,583 m²/kg · 0.6313.
    assert!((absorbed(&dirty) - absorbed(&clean) - 0.02383).abs() < 2e-5);
    let rate = |medium: &Medium| {
        (3.0 * absorbed(medium) * medium.extinction_per_m * (1.0 - medium.scattering.asymmetry())).sqrt()
    };
    let faded =
        |sample: SnowSample| (transmittance(sample, 100.0, 500.0) / transmittance(sample, 120.0, 500.0)).ln() / 0.2;
    let ratio = faded(sooty(10.0)) / rate(&dirty);
    // √(1 − g) from two tallies with other seeds, each within some 10⁻³; e^{−2x} is 10⁻⁶.
    assert!((ratio - 1.0).abs() < 2e-3, "{ratio}");
}

/// Absorptance is the difference of the net fluxes at the top and at the bottom, which are computed separately.
#[test]
fn energy_is_conserved() {
    for sample in [wet(0.4), sooty(1e5), SnowSample { water_saturation: 0.7, ..sooty(1e3) }] {
        let stack = Stack { depths_cm: vec![0.0, 2.0], ..one_layer(sample, 2.0) };
        for row in ordinates::solve_stack_without_errors(&stack, &FEW_RAYS).unwrap() {
            let net = row.profile[0].net.value - row.profile[1].net.value;
            let absorbed = row.whole.fluxes.absorptance.value;
            // Discrete ordinates integrate the flux at the top within 10⁻⁵.
            assert!(net > 0.0 && (net - absorbed).abs() < 1e-5, "{net} {absorbed}");
        }
    }
}

/// Automatic streams resolve the forward peak of grains in water: T within 10⁻⁴ of 128 streams up to 80°.
#[test]
fn automatic_streams_suffice_in_wet_snow() {
    for saturation in [0.1, 0.5, 1.0] {
        let slab = Slab {
            thicknesses_cm: vec![0.1, 5.0],
            incidences: vec![
                Incidence::Beam { angle_deg: 0.0 },
                Incidence::Beam { angle_deg: 80.0 },
                Incidence::Diffuse,
            ],
            ..slab(wet(saturation), 5.0, &[450.0, 1100.0])
        };
        let solve = |streams| {
            let options = OrdinatesOptions { streams, tally_rays: 1 << 14, ..OrdinatesOptions::default() };
            ordinates::solve_without_errors(&slab, &options).unwrap()
        };
        for (some, many) in solve(Streams::Auto).iter().zip(&solve(Streams::Exactly(128))) {
            let ratio = some.fluxes.transmittance.value / many.fluxes.transmittance.value;
            assert!((ratio - 1.0).abs() < 1e-4, "S_w = {saturation}: {some:?} {many:?}");
        }
    }
}

/// Without snow both engines give the reflection of the ground.
#[test]
fn light_without_snow_reaches_the_ground() {
    for albedo in [0.0, 0.5] {
        let stack = Stack { ground_albedo: albedo.into(), ..one_layer(SnowSample::default(), 0.0) };
        let options = MonteCarloOptions { rays: 4000, seed: 3, ..MonteCarloOptions::default() };
        let simulated = &monte_carlo::solve_stack(&stack, &options, &|_| ()).unwrap()[0];
        let solved = &ordinates::solve_stack_without_errors(&stack, &FEW_RAYS).unwrap()[0].whole;
        for answer in [simulated, solved] {
            // 4 σ of a probability of a half, √(1/4 /4000).
            assert!((answer.fluxes.reflectance.value - albedo).abs() < 4.0 * 0.0079, "{answer:?}");
            assert!((answer.fluxes.transmittance.value - 1.0).abs() < 1e-12, "{answer:?}");
        }
    }
}

/// All impurities at several saturations, in the ultraviolet, blue, red and infrared.
#[test]
fn engines_agree_about_wet_and_dirty_snow() {
    let dust = Impurities::none().with(Substance::SAHARAN_DUST, 2e6).with(Substance::COLORADO_DUST, 1e6);
    let living = Impurities::none().with(Substance::SNOW_ALGAE, 3e5).with(Substance::BROWN_CARBON, 2e4);
    let coarse = SnowSample { grain_size: GrainSize::around(1500.0).unwrap(), ..SnowSample::default() };
    let cases = [
        (wet(0.3), 0.5, [400.0, 700.0, 1100.0]),
        (wet(1.0), 2.0, [320.0, 600.0, 950.0]),
        (sooty(500.0), 0.7, [310.0, 550.0, 1300.0]),
        (SnowSample { impurities: dust, ..coarse }, 2.0, [350.0, 500.0, 800.0]),
        (SnowSample { impurities: living, water_saturation: 0.6, ..coarse }, 1.0, [450.0, 550.0, 680.0]),
    ];
    for (number, (sample, thickness_cm, wavelengths_nm)) in cases.into_iter().enumerate() {
        let slab = Slab {
            thicknesses_cm: vec![thickness_cm, 0.2],
            incidences: vec![Incidence::Beam { angle_deg: 40.0 }, Incidence::Diffuse],
            ..slab(sample, thickness_cm, &wavelengths_nm)
        };
        let simulate = |per_wavelength| {
            let options = MonteCarloOptions { rays: 6_000, seed: 9, per_wavelength };
            monte_carlo::solve(&slab, &options, &|_| ()).unwrap()
        };
        // Sharp forward peaks take more streams than dry snow. The noise of these tallies, some .4 % of T, is less than
        // that of the Monte Carlo engine.
        let options =
            OrdinatesOptions { streams: Streams::Exactly(48), tally_rays: 1 << 16, ..OrdinatesOptions::default() };
        let solved = ordinates::solve(&slab, &options).unwrap();
        // 5 cases of 36 comparisons, many of them correlated: 4 σ is a false alarm in a hundred seeds.
        assert_agree(&simulate(false), &solved, &format!("case {number}, shared"));
        assert_agree(&simulate(true), &solved, &format!("case {number}, each wavelength"));
    }
}

/// Differences of 2 % in probabilities of a half are found: 4 σ of √(1/4 /8000), and some 0.4 % of T by the tallies.
#[test]
fn engines_agree_about_wet_and_dirty_layers() {
    let layer = Layer::snow;
    let stack = Stack {
        layers: vec![layer(sooty(300.0), 0.5), layer(wet(0.5), 1.0), layer(SnowSample::default(), 0.5)],
        ground_albedo: 0.3.into(),
        depths_cm: vec![],
        incidences: vec![Incidence::Beam { angle_deg: 30.0 }, Incidence::Diffuse],
        wavelengths_nm: vec![450.0, 650.0, 1000.0],
    };
    let options = MonteCarloOptions { rays: 8_000, seed: 13, ..MonteCarloOptions::default() };
    let simulated = monte_carlo::solve_stack(&stack, &options, &|_| ()).unwrap();
    let options = OrdinatesOptions { tally_rays: 1 << 16, ..OrdinatesOptions::default() };
    let solved = ordinates::solve_stack(&stack, &options).unwrap();
    assert_agree(&simulated, &solved.iter().map(|answer| answer.whole).collect::<Vec<_>>(), "layers");
}

/// A stack of one wet and dirty layer has the fluxes of the slab.
#[test]
fn one_layer_is_the_slab() {
    let sample = SnowSample { water_saturation: 0.2, ..sooty(50.0) };
    let slab = slab(sample, 3.0, &[450.0, 650.0]);
    let stack =
        Stack { depths_cm: vec![0.0, 3.0], wavelengths_nm: slab.wavelengths_nm.clone(), ..one_layer(sample, 3.0) };
    let alone = ordinates::solve_without_errors(&slab, &FEW_RAYS).unwrap();
    let piled = ordinates::solve_stack_without_errors(&stack, &FEW_RAYS).unwrap();
    for (alone, piled) in alone.iter().zip(&piled) {
        for (a, b) in [
            (alone.fluxes.reflectance.value, piled.whole.fluxes.reflectance.value),
            (alone.fluxes.transmittance.value, piled.whole.fluxes.transmittance.value),
            (alone.fluxes.transmittance.value, piled.profile[1].down.value),
        ] {
            assert!((a / b - 1.0).abs() < 1e-11, "{alone:?} {piled:?}");
        }
    }
}

fn assert_agree(some: &[Radiometry], others: &[Radiometry], what: &str) {
    assert_eq!(some.len(), others.len());
    let z_score = |a: Estimate, b: Estimate| {
        (a.value - b.value) / a.standard_error.hypot(b.standard_error).max(f64::MIN_POSITIVE)
    };
    for (a, b) in some.iter().zip(others) {
        assert_eq!((a.wavelength_nm.to_bits(), a.incidence), (b.wavelength_nm.to_bits(), b.incidence));
        for (a, b, quantity) in [
            (a.fluxes.reflectance, b.fluxes.reflectance, "reflectance"),
            (a.fluxes.transmittance, b.fluxes.transmittance, "transmittance"),
            (a.fluxes.absorptance, b.fluxes.absorptance, "absorptance"),
        ] {
            let z = z_score(a, b);
            assert!(z.abs() < 4.0, "{what}, {quantity}: {a:?} {b:?}, z = {z:.1}");
        }
    }
}

/// The albedo of deep snow of smooth spheres of 100 µm radius under a sun at 60°.
fn albedo_of_spheres(impurities: Impurities, wavelengths_nm: &[f64]) -> Vec<Fluxes> {
    let sample = SnowSample {
        grain_size: GrainSize { min_um: 200.0, max_um: 200.0, measure: SizeMeasure::OpticalDiameter },
        sphericity: TruncatedNormal::exactly(1.0),
        facetness: TruncatedNormal::exactly(0.0),
        impurities,
        ..SnowSample::default()
    };
    let incidences = vec![Incidence::Beam { angle_deg: 60.0 }];
    let slab = Slab { incidences, ..slab(sample, f64::INFINITY, wavelengths_nm) };
    let solved = ordinates::solve_without_errors(&slab, &OrdinatesOptions::default()).unwrap();
    solved.iter().map(|row| row.fluxes).collect()
}

/// BioSNICAR (Cook et al. 2020) for Mie spheres, with the impurities in its own broadband irradiance of a clear winter
/// day, which is redder than ours. The algae are 21,810 cells/g.
#[test]
fn albedos_of_dirty_snow_are_those_of_biosnicar() {
    let wavelengths_nm = wavelengths_nm(Band::Solar.wavelength_range());
    let weights = BandWeights::new(Band::Solar, &wavelengths_nm).unwrap();
    let none = Impurities::none();
    for (impurities, expected) in [
        (none, 0.829),
        (none.with(Substance::BLACK_CARBON, 100.0), 0.811),
        (none.with(Substance::BLACK_CARBON, 1000.0), 0.759),
        (none.with(Substance::SAHARAN_DUST, 50_000.0), 0.789),
    ] {
        let found = weights.broadband(&albedo_of_spheres(impurities, &wavelengths_nm)).reflectance.value;
        assert!((found - expected).abs() < 0.005, "{impurities}: {found}, but BioSNICAR has {expected}");
    }
    let found = albedo_of_spheres(none.with(Substance::SNOW_ALGAE, 21_810.0), &[405.0])[0].reflectance.value;
    assert!((found - 0.912).abs() < 0.002, "{found}");
}

/// More of an impurity raises no band's albedo. By energy, the visible and the near-infrared band leave an albedo of
/// the ultraviolet.
#[test]
fn impurities_lower_the_albedo_of_every_band() {
    let wavelengths_nm = wavelengths_nm(Band::Solar.wavelength_range());
    let weights = Band::ALL.map(|band| BandWeights::new(band, &wavelengths_nm).unwrap());
    let albedos = |impurities| {
        let fluxes = albedo_of_spheres(impurities, &wavelengths_nm);
        weights.each_ref().map(|band| band.broadband(&fluxes).reflectance.value)
    };
    for substance in Substance::all() {
        let rows = [0.0, 100.0, 10_000.0].map(|ng_g| albedos(Impurities::none().with(substance, ng_g)));
        for band in 0..Band::ALL.len() {
            // Large grains of dust scatter between the grains of snow in the infrared, by less than 10⁻⁵ of the albedo.
            let falls = rows.windows(2).all(|pair| pair[1][band] < pair[0][band] + 1e-5);
            assert!(falls && rows[2][band] < rows[0][band] + 1e-5, "{substance}, {:?}: {rows:?}", Band::ALL[band]);
        }
        assert!(rows[2][0] < rows[0][0], "{substance} absorbs sunlight: {rows:?}");
        let energies = Band::ALL.map(|band| irradiance_w_m2(band.wavelength_range()));
        let rest = |of: &dyn Fn(usize) -> f64| of(0) - of(1) - of(2);
        let ultraviolet = rest(&|band| rows[2][band] * energies[band]) / rest(&|band| energies[band]);
        assert!((0.0..1.0).contains(&ultraviolet), "{substance}: {ultraviolet}");
    }
}
