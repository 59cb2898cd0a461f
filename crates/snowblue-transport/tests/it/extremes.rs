//! The laws at the ends of all ranges: fluxes are fractions, energy is conserved, and both engines agree.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use snowblue_transport::ParameterRange;
use snowblue_transport::monte_carlo::{self, MonteCarloOptions};
use snowblue_transport::optics::{IceTable, Impurities, Substance};
use snowblue_transport::ordinates::{self, OrdinatesOptions, Streams};
use snowblue_transport::parameters::{
    ANGLE, DENSITY, FACETNESS, GRAIN_SIZE, MASS_FRACTION, SPHERICITY, TEMPERATURE, THICKNESS, WATER_SATURATION,
};
use snowblue_transport::sample::{GrainSize, SizeMeasure, SnowSample, TruncatedNormal};
use snowblue_transport::slab::{Estimate, Incidence, Slab};

/// A small tally: the laws hold for any phase function, and standard errors include its noise.
const FEW_RAYS: OrdinatesOptions = OrdinatesOptions { streams: Streams::Auto, tally_rays: 4096, seed: 1 };

/// Either end of a range or any value between them, as often each.
fn within(range: ParameterRange) -> impl Strategy<Value = f64> {
    let ParameterRange { least, greatest, .. } = range;
    prop_oneof![Just(least), Just(greatest), least..=greatest]
}

/// Two values of a range in order, equal to each other if both are at the same end.
fn interval(range: ParameterRange) -> impl Strategy<Value = [f64; 2]> {
    [within(range), within(range)].prop_map(|[a, b]| [a.min(b), a.max(b)])
}

fn distribution(range: ParameterRange) -> impl Strategy<Value = TruncatedNormal> {
    (interval(range), within(range), prop_oneof![Just(1e-3), Just(10.0), 0.01..1.0]).prop_map(
        |([min, max], mean, standard_deviation)| TruncatedNormal {
            min,
            max,
            mean: mean.clamp(min, max),
            standard_deviation,
        },
    )
}

prop_compose! {
    fn samples()(
        size_um in interval(GRAIN_SIZE.range), sphericity in distribution(SPHERICITY.range),
        facetness in distribution(FACETNESS.range), density_kg_m3 in within(DENSITY.range),
        water_saturation in within(WATER_SATURATION.range), temperature_c in within(TEMPERATURE.range),
        impurity in prop::option::of((
            prop::sample::select(Substance::all().collect::<Vec<_>>()),
            within(MASS_FRACTION.range),
        )),
        is_picard in any::<bool>(),
    ) -> SnowSample {
        SnowSample {
            grain_size: GrainSize::from_numbers(&size_um, SizeMeasure::default()).unwrap(),
            sphericity,
            facetness,
            density_kg_m3,
            water_saturation,
            impurities: impurity.iter().fold(Impurities::none(), |all, (substance, ng_g)| all.with(*substance, *ng_g)),
            temperature_c,
            ice: if is_picard { IceTable::Picard2016 } else { IceTable::WarrenBrandt2008 },
        }
    }
}

/// The first and the last wavelength that the table of ice covers, and one between them, in nm.
fn wavelengths_nm(sample: &SnowSample) -> Vec<f64> {
    let range = sample.ice.wavelength_range();
    vec![range.first_nm, 0.7 * range.first_nm + 0.3 * range.last_nm, range.last_nm]
}

fn config(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, failure_persistence: None, rng_seed: RngSeed::Fixed(17), ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(config(40))]

    /// In any snow R, T and A are fractions with the sum 1, and thicker snow transmits less and reflects more.
    #[test]
    fn fluxes_are_fractions_in_any_snow(
        sample in samples(), thickness_cm in within(THICKNESS.range), angle_deg in within(ANGLE.range),
    ) {
        let thicknesses_cm = vec![0.0, 1e-3 * thickness_cm, thickness_cm];
        let incidences = vec![Incidence::Beam { angle_deg }, Incidence::Diffuse];
        let wavelengths_nm = wavelengths_nm(&sample);
        let count = incidences.len() * wavelengths_nm.len();
        let slab = Slab { sample, thicknesses_cm, incidences, wavelengths_nm };
        let options = OrdinatesOptions { tally_rays: 1 << 10, ..FEW_RAYS };
        let solved = ordinates::solve_without_errors(&slab, &options).unwrap();
        for one in &solved {
            let [r, t, a] = one.fluxes.to_array().map(|estimate| estimate.value);
            // Rounding of sums over modes, some ten times larger at grazing incidence, as without absorption.
            prop_assert!((r + t + a - 1.0).abs() < 1e-10, "{one:?}");
            prop_assert!([r, t, a].iter().all(|part| (-1e-10..=1.0 + 1e-10).contains(part)), "{one:?}");
        }
        for (thin, thick) in solved.iter().zip(&solved[count..]) {
            let (thin, thick) = (thin.fluxes, thick.fluxes);
            prop_assert!(thick.transmittance.value <= thin.transmittance.value + 1e-10, "{thin:?} {thick:?}");
            prop_assert!(thick.reflectance.value >= thin.reflectance.value - 1e-10, "{thin:?} {thick:?}");
        }
    }
}

proptest! {
    #![proptest_config(config(12))]

    /// Both engines agree about any snow, in slabs through which light scatters some times.
    #[test]
    fn engines_agree_about_any_snow(sample in samples(), depth in 0.5..6.0_f64, angle_deg in 0.0..85.0_f64) {
        // Spheres of diameter d and volume fraction φ have an extinction of 3φ/2d without diffraction.
        let mean_m = 0.5e-6 * (sample.grain_size.min_um + sample.grain_size.max_um);
        let thickness_m = depth * mean_m * 917.0 / (1.5 * sample.density_kg_m3);
        let slab = Slab {
            thicknesses_cm: vec![100.0 * thickness_m],
            incidences: vec![Incidence::Beam { angle_deg }, Incidence::Diffuse],
            wavelengths_nm: wavelengths_nm(&sample),
            sample,
        };
        let options = MonteCarloOptions { rays: 4000, seed: 5, ..MonteCarloOptions::default() };
        let simulated = monte_carlo::solve(&slab, &options, &|_| ()).unwrap();
        let solved = ordinates::solve(&slab, &FEW_RAYS).unwrap();
        for (a, b) in simulated.iter().zip(&solved) {
            let (a, b) = (a.fluxes, b.fluxes);
            for (a, b) in [(a.reflectance, b.reflectance), (a.transmittance, b.transmittance)] {
                // 144 comparisons, most of them correlated; 4 σ is a false alarm in a hundred seeds. Where no ray or
                // few end, the error is that of one ray.
                let one_ray = 4.0 / options.rays as f64;
                prop_assert!((a.value - b.value).abs() < 4.0 * error(a, b) + one_ray, "{:?}: {a:?} {b:?}", slab);
            }
        }
    }
}

fn error(a: Estimate, b: Estimate) -> f64 {
    a.standard_error.hypot(b.standard_error)
}
