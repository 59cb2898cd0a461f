//! The embedded table is what the engine computes: random rows, and places between the knots, solved directly.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use snowblue_color::{Colorimeter, Illuminant, Lab, Observer};
use snowblue_data::embedded;
use snowblue_database::fill::{self, FillOptions};
use snowblue_database::{Axes, GridSample, PcaSnow, Quantity, Space};

/// A repeatable choice out of `count`.
fn choose(state: &mut u64, count: usize) -> usize {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    usize::try_from(*state >> 33).unwrap() % count
}

#[test]
fn has_the_axes_and_the_space_it_is_said_to_have() {
    let table = embedded();
    assert_eq!(table.axes, Axes::with_thin_and_thick_knots());
    assert_eq!((table.space, table.transmittance.count, table.reflectance.count), (Space::Log, 3, 3));
}

/// Random rows of one random facetness, computed with the same rays as the file: what differs is the compression alone,
/// so the bounds are the worst cases of the fidelity report (RMSE .0012, ΔE .41 over all rows), a little widened.
#[test]
fn random_rows_are_those_of_the_engine() {
    let table = embedded();
    let mut state = 20_261_121;
    let facetness = table.axes.facetness[choose(&mut state, 5)];
    let axes = Axes { facetness: vec![facetness], ..table.axes.clone() };
    let (anew, _) = fill::fill(&axes, &FillOptions::default(), &|_, _| ()).unwrap();
    let colorimeter = Colorimeter::new(Observer::Cie1931, Illuminant::D65, &axes.wavelengths_nm).unwrap();
    let lab = |curve: &[f64]| Lab::from_xyz(colorimeter.xyz(curve), colorimeter.white());
    let curves = [Quantity::Transmittance, Quantity::Reflectance].map(|q| anew.curves(q).collect::<Vec<_>>());
    for _ in 0..500 {
        let row = choose(&mut state, axes.curves());
        let per_size = axes.curves() / axes.grain_sizes_um.len();
        let which = table.axes.facetness.iter().position(|f| f.to_bits() == facetness.to_bits()).unwrap();
        let embedded_row = (row / per_size * table.axes.facetness.len() + which) * per_size + row % per_size;
        for (quantity, curves) in Quantity::ALL.into_iter().zip(&curves) {
            let mut rebuilt = vec![0.0; 31];
            table.components(quantity).rebuild(embedded_row, table.space, &mut rebuilt);
            let squares: f64 = curves[row].iter().zip(&rebuilt).map(|(a, b)| (a - b).powi(2)).sum();
            let delta_e = lab(curves[row]).delta_e_1976(lab(&rebuilt));
            let place = axes.describe(row);
            assert!((squares / 31.0).sqrt() < 0.0013 && delta_e < 0.45, "{} {place}: ΔE {delta_e}", quantity.name());
        }
    }
}

/// Between the knots and the angles the look-up stays near a direct solution: 2.5 % come from three components in the
/// deep red, and up to 2 % from the straight line between the angles at 75°.
#[test]
fn places_between_the_knots_are_near_the_engine() {
    let sample = GridSample { grain_size_um: 400.0, facetness: 0.3, density_kg_m3: 300.0 };
    let axes = Axes {
        grain_sizes_um: vec![sample.grain_size_um],
        facetness: vec![sample.facetness],
        densities_kg_m3: vec![sample.density_kg_m3],
        angles_deg: vec![0.0, 25.0, 55.0, 75.0],
        thicknesses_cm: vec![0.005, 0.05, 0.4, 1.2, 4.0, 12.0, 30.0, 60.0, 85.0],
        ..Axes::paper()
    };
    let (anew, _) = fill::fill(&axes, &FillOptions::default(), &|_, _| ()).unwrap();
    let snow = PcaSnow::new(embedded(), sample).unwrap();
    let mut found = [0.0_f32; 31];
    for (number, curve) in anew.curves(Quantity::Transmittance).enumerate() {
        let (thickness_cm, angle_deg) = (axes.thicknesses_cm[number % 9], axes.angles_deg[number / 9]);
        #[expect(clippy::cast_possible_truncation, reason = "look-ups take single precision")]
        snow.transmittance(thickness_cm as f32, angle_deg as f32, &mut found);
        for (w, (a, b)) in found.iter().zip(curve).enumerate() {
            let error = f64::from(*a) / b - 1.0;
            let allowed = if angle_deg < 60.0 { 0.025 } else { 0.04 };
            assert!(error.abs() < allowed, "{thickness_cm} cm, {angle_deg}°, number {w}: {a}, solved {b}");
        }
    }
}
