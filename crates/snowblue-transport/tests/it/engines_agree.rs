//! Two independent engines agree within 4 standard errors, for snow that differs in all parameters.
//!
//! The Monte Carlo engine traces grain by grain through the slab; discrete ordinates solve the equation of transfer
//! with the moments of the same grains. They share only the scattering by a single grain.

use snowblue_transport::monte_carlo::{self, MonteCarloOptions};
use snowblue_transport::optics::IceTable;
use snowblue_transport::ordinates::{self, OrdinatesOptions, Streams};
use snowblue_transport::sample::{GrainSize, SizeMeasure, SnowSample, TruncatedNormal};
use snowblue_transport::slab::{Estimate, Incidence, Radiometry, Slab};
use snowblue_transport::stack::{Layer, Stack};

const RAYS: u64 = 20_000;
/// Rays of the tests with many paths. They find differences of 2 % in probabilities of a half: 4 σ of √(1/4 /8000).
const FEW_RAYS: u64 = 8_000;
/// The noise of these tallies, some 0.4 % of T, is less than that of the random walks, and part of the standard errors.
const ORDINATES: OrdinatesOptions = OrdinatesOptions { streams: Streams::Auto, tally_rays: 1 << 16, seed: 3 };

/// A slab: size range (µm), sphericity, facetness, density (kg/m³), thickness (cm), angle (degrees, or none for diffuse
/// light), wavelength (nm).
type Case = ((f64, f64), f64, f64, f64, f64, Option<f64>, f64);

const CASES: [Case; 14] = [
    ((350.0, 450.0), 0.8, 0.3, 300.0, 3.0, Some(0.0), 500.0),
    ((50.0, 150.0), 0.9, 0.1, 200.0, 1.0, Some(30.0), 400.0),
    ((450.0, 550.0), 0.7, 0.9, 400.0, 2.0, Some(60.0), 700.0),
    ((200.0, 200.0), 0.6, 0.5, 250.0, 0.5, None, 600.0),
    ((300.0, 900.0), 0.8, 0.7, 350.0, 5.0, Some(80.0), 650.0),
    ((1000.0, 1000.0), 1.0, 0.0, 450.0, 8.0, Some(10.0), 450.0),
    ((2000.0, 4000.0), 0.5, 0.2, 500.0, 20.0, None, 700.0),
    ((400.0, 400.0), 1.0, 0.3, 917.0 * 0.9, 1.0, Some(45.0), 550.0),
    ((100.0, 100.0), 0.9, 0.0, 100.0, 0.02, Some(89.0), 500.0),
    ((400.0, 600.0), 0.8, 0.4, 300.0, 1.0, Some(20.0), 1000.0),
    ((800.0, 1200.0), 0.7, 0.6, 200.0, 0.4, None, 1300.0),
    ((200.0, 300.0), 0.8, 0.15, 360.0, 0.1, Some(50.0), 1500.0),
    ((250.0, 350.0), 0.9, 0.8, 150.0, 0.05, Some(75.0), 320.0),
    ((4900.0, 5000.0), 0.6, 1.0, 600.0, 30.0, Some(0.0), 750.0),
];

/// Negative control: the engines disagree about different snow.
#[test]
fn engines_agree() {
    let solve = |slab: &Slab| {
        let options = MonteCarloOptions { rays: RAYS, seed: 11, ..MonteCarloOptions::default() };
        let simulated = monte_carlo::solve(slab, &options, &|_| ()).unwrap()[0];
        [simulated, ordinates::solve(slab, &ORDINATES).unwrap()[0]]
    };
    let answers: Vec<[Radiometry; 2]> = (0..).zip(CASES).map(|(number, case)| solve(&slab(case, number))).collect();
    for (number, [simulated, solved]) in answers.iter().enumerate() {
        for (quantity, a, b) in [
            ("reflectance", simulated.fluxes.reflectance, solved.fluxes.reflectance),
            ("transmittance", simulated.fluxes.transmittance, solved.fluxes.transmittance),
            ("absorptance", simulated.fluxes.absorptance, solved.fluxes.absorptance),
        ] {
            let z = z_score(a, b);
            // 42 comparisons at 4 σ: a false alarm in 400 seeds.
            assert!(z.abs() <= 4.0, "case {number}, {quantity}: simulated {a:?}, solved {b:?}, z = {z:.1}");
        }
    }
    assert!(z_score(answers[0][0].fluxes.transmittance, answers[1][1].fluxes.transmittance).abs() > 10.0);
}

fn z_score(a: Estimate, b: Estimate) -> f64 {
    (a.value - b.value) / a.standard_error.hypot(b.standard_error)
}

/// The slab of a case. Every third case uses the other ice table, and the size measures alternate.
fn slab(case: Case, number: usize) -> Slab {
    let ((min_um, max_um), sphericity, facetness, density_kg_m3, thickness_cm, angle_deg, wavelength_nm) = case;
    let measures = [SizeMeasure::GreatestExtension, SizeMeasure::VolumeDiameter, SizeMeasure::OpticalDiameter];
    let sample = SnowSample {
        grain_size: GrainSize { min_um, max_um, measure: measures[number % 3] },
        sphericity: TruncatedNormal {
            min: (sphericity - 0.1_f64).max(0.5),
            max: (sphericity + 0.1_f64).min(1.0),
            mean: sphericity,
            standard_deviation: if number.is_multiple_of(2) { 0.1 } else { 0.0 },
        },
        facetness: if facetness > 0.0 {
            TruncatedNormal::facetness_around(facetness)
        } else {
            TruncatedNormal::exactly(0.0)
        },
        density_kg_m3,
        ice: if number.is_multiple_of(3) { IceTable::Picard2016 } else { IceTable::WarrenBrandt2008 },
        ..SnowSample::default()
    };
    Slab {
        sample,
        thicknesses_cm: vec![thickness_cm],
        incidences: vec![angle_deg.map_or(Incidence::Diffuse, |angle_deg| Incidence::Beam { angle_deg })],
        wavelengths_nm: vec![wavelength_nm],
    }
}

/// Shared paths for all wavelengths and thicknesses agree with separate ones, and with ordinates.
#[test]
fn shared_paths_agree_with_separate_ones() {
    let slab = Slab {
        sample: SnowSample::default(),
        thicknesses_cm: vec![1.0, 0.3, 0.6],
        incidences: vec![Incidence::Beam { angle_deg: 40.0 }, Incidence::Diffuse],
        wavelengths_nm: vec![400.0, 550.0, 700.0],
    };
    let run = |per_wavelength| {
        monte_carlo::solve(&slab, &MonteCarloOptions { rays: FEW_RAYS, seed: 4, per_wavelength }, &|_| ()).unwrap()
    };
    let (shared, separate) = (run(false), run(true));
    let solved = ordinates::solve(&slab, &ORDINATES).unwrap();
    for ((a, b), c) in shared.iter().zip(&separate).zip(&solved) {
        assert_eq!((a.thickness_cm.to_bits(), a.incidence), (b.thickness_cm.to_bits(), b.incidence));
        for (a, b, c) in [
            (a.fluxes.reflectance, b.fluxes.reflectance, c.fluxes.reflectance),
            (a.fluxes.transmittance, b.fluxes.transmittance, c.fluxes.transmittance),
            (a.fluxes.absorptance, b.fluxes.absorptance, c.fluxes.absorptance),
        ] {
            // 108 comparisons, most of them correlated; 4 σ is a false alarm in a hundred seeds or more.
            assert!(z_score(a, b).abs() < 4.0 && z_score(a, c).abs() < 4.0, "{a:?} {b:?} {c:?}");
        }
    }
}

/// Layers of different snow on a ground.
#[test]
fn engines_agree_about_layers() {
    let sample = |size_um: f64, facetness: f64, density_kg_m3: f64, ice| SnowSample {
        grain_size: GrainSize::around(size_um).unwrap(),
        facetness: TruncatedNormal::facetness_around(facetness),
        density_kg_m3,
        ice,
        ..SnowSample::default()
    };
    let fresh = Layer::snow(sample(150.0, 0.7, 120.0, IceTable::WarrenBrandt2008), 0.3);
    let old = Layer::snow(sample(800.0, 0.2, 400.0, IceTable::Picard2016), 0.8);
    let crust = Layer::snow(sample(2000.0, 0.1, 700.0, IceTable::WarrenBrandt2008), 0.3);
    for (layers, ground_albedo) in [(vec![fresh, old], 0.0), (vec![old, fresh], 0.6), (vec![crust, fresh, old], 0.95)] {
        let stack = Stack {
            layers,
            ground_albedo: f64::into(ground_albedo),
            depths_cm: vec![],
            incidences: vec![Incidence::Beam { angle_deg: 50.0 }, Incidence::Diffuse],
            wavelengths_nm: vec![450.0, 700.0, 1030.0],
        };
        let options = MonteCarloOptions { rays: FEW_RAYS, seed: 21, ..MonteCarloOptions::default() };
        let simulated = monte_carlo::solve_stack(&stack, &options, &|_| ()).unwrap();
        let solved = ordinates::solve_stack(&stack, &ORDINATES).unwrap();
        for (a, b) in simulated.iter().zip(&solved) {
            for (a, b) in [
                (a.fluxes.reflectance, b.whole.fluxes.reflectance),
                (a.fluxes.transmittance, b.whole.fluxes.transmittance),
                (a.fluxes.absorptance, b.whole.fluxes.absorptance),
            ] {
                // 54 comparisons at 4 σ.
                assert!(z_score(a, b).abs() < 4.0, "albedo {ground_albedo}: {a:?} {b:?}");
            }
        }
    }
}
