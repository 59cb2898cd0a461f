//! The embedded table agrees with the engine at random rows and between its values.

use snowblue_base::hash::Fnv1a;
use snowblue_color::{Colorimeter, Illuminant, Lab, Observer};
use snowblue_data::embedded;
use snowblue_database::fill::{self, FillOptions};
use snowblue_database::{Axes, PcaSnow, Quantity, Space, TableSample};

/// A repeatable random number below `count`.
fn choose(state: &mut u64, count: usize) -> usize {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    usize::try_from(*state >> 33).unwrap() % count
}

#[test]
fn has_the_documented_axes_and_components() {
    let table = embedded();
    assert_eq!(table.axes, Axes::with_thin_and_thick_knots());
    assert_eq!((table.space, table.transmittance.count, table.reflectance.count), (Space::Log, 6, 6));
}

/// The coefficients are those that were computed and rounded, in whatever way the file holds them.
#[test]
fn the_file_holds_every_bit_of_the_rounded_coefficients() {
    let mut hash = Fnv1a::default();
    for quantity in Quantity::ALL {
        let coefficients = &embedded().components(quantity).coefficients;
        coefficients.iter().for_each(|coefficient| hash.add(&coefficient.to_le_bytes()));
    }
    assert_eq!(hash.value(), 0xef20_88a3_2294_e437);
}

#[test]
fn the_file_takes_about_a_tenth_of_the_bytes_of_the_coefficients() {
    let coefficients: usize = Quantity::ALL.iter().map(|q| embedded().components(*q).coefficients.len()).sum();
    let share = include_bytes!("../../data/snow.nc").len() as f64 / (4 * coefficients) as f64;
    assert!((0.09..0.115).contains(&share), "{share}");
}

/// The coefficients are multiples of 2⁻¹⁴, so that the file is small. This changes a value by at most
/// half a step times the sum of the absolute entries of the basis.
#[test]
fn rounding_changes_values_by_at_most_0_0061_percent() {
    const STEP: f32 = 1.0 / 16384.0;
    for quantity in Quantity::ALL {
        let components = embedded().components(quantity);
        assert!(components.coefficients.iter().all(|coefficient| (coefficient / STEP).fract().abs() <= 0.0));
        let sums = components.basis.chunks_exact(components.count).map(|row| row.iter().map(|v| v.abs()).sum::<f32>());
        let worst = 0.5 * STEP * sums.fold(0.0, f32::max);
        assert!(worst < 6.1e-5, "{} {worst}", quantity.name());
    }
}

/// Random rows of one random facetness and density, computed with the same rays as the file, differ only by
/// compression. The bounds are the worst cases of the fidelity report over all rows (RMSE 0.00013, ΔE 0.0043), with a
/// margin.
#[test]
fn random_rows_are_those_of_the_engine() {
    let table = embedded();
    let mut state = 20_261_121;
    let facetness = choose(&mut state, table.axes.facetness.len());
    let density = choose(&mut state, table.axes.densities_kg_m3.len());
    let axes = Axes {
        facetness: vec![table.axes.facetness[facetness]],
        densities_kg_m3: vec![table.axes.densities_kg_m3[density]],
        ..table.axes.clone()
    };
    let computed = fill::fill(&axes, &FillOptions::default(), &|_| ()).unwrap();
    let colorimeter = Colorimeter::new(Observer::Cie1931, Illuminant::D65, &axes.wavelengths_nm).unwrap();
    let lab = |curve: &[f64]| Lab::from_xyz(colorimeter.xyz(curve), colorimeter.white());
    let curves = [Quantity::Transmittance, Quantity::Reflectance].map(|q| computed.curves(q).collect::<Vec<_>>());
    for _ in 0..500 {
        let row = choose(&mut state, axes.curves());
        let (size, curve) = (row / axes.curves_per_sample(), row % axes.curves_per_sample());
        let sample = (size * table.axes.facetness.len() + facetness) * table.axes.densities_kg_m3.len() + density;
        let embedded_row = sample * table.axes.curves_per_sample() + curve;
        for (quantity, curves) in Quantity::ALL.into_iter().zip(&curves) {
            let mut rebuilt = vec![0.0; 31];
            table.components(quantity).rebuild(embedded_row, table.space, &mut rebuilt);
            let squares: f64 = curves[row].iter().zip(&rebuilt).map(|(a, b)| (a - b).powi(2)).sum();
            let delta_e = lab(curves[row]).delta_e_1976(lab(&rebuilt));
            let place = axes.describe(row);
            assert!((squares / 31.0).sqrt() < 0.00014 && delta_e < 0.005, "{} {place}: ΔE {delta_e}", quantity.name());
        }
    }
}

/// Between knots and angles, for samples on the grid and between its sizes and densities, look-ups agree with direct
/// solutions by the same rays within about half a percent.
#[test]
fn look_ups_between_the_values_agree_with_the_engine() {
    for (sample, most_error) in [
        (TableSample::new(400.0, 0.3, 300.0), 0.005),
        (TableSample::new(130.0, 0.3, 260.0), 0.007),
        (TableSample::new(470.0, 0.3, 90.0), 0.007),
    ] {
        let error = worst_error(&sample);
        assert!(error < most_error, "{sample:?}: {error}");
    }
}

/// Between two values of facetness the grains differ, and so does the noise of their tally: 2 % deep in snow.
#[test]
fn look_ups_between_the_facetness_values_agree_with_the_engine() {
    let error = worst_error(&TableSample::new(300.0, 0.4, 300.0));
    assert!(error < 0.02, "{error}");
}

/// The largest relative error of T and R at points where they exceed 10⁻⁶.
fn worst_error(sample: &TableSample) -> f64 {
    let axes = Axes {
        grain_sizes_um: vec![sample.grain_size_um],
        facetness: vec![sample.facetness],
        densities_kg_m3: vec![sample.density_kg_m3],
        angles_deg: vec![0.0, 25.0, 55.0, 65.0, 77.0],
        thicknesses_cm: vec![0.012, 0.05, 0.4, 1.2, 4.0, 12.0, 30.0, 60.0, 85.0],
        ..Axes::paper()
    };
    // The tally has as many moments as the table's, whose last angle is 89°.
    let axes = Axes { angles_deg: [&axes.angles_deg[..], &[89.0]].concat(), ..axes };
    let computed = fill::fill(&axes, &FillOptions::default(), &|_| ()).unwrap();
    let snow = PcaSnow::new(embedded(), sample).unwrap();
    let mut worst = 0.0_f64;
    for quantity in Quantity::ALL {
        for (number, curve) in computed.curves(quantity).take(5 * 9).enumerate() {
            let (thickness_cm, angle_deg) =
                (single(axes.thicknesses_cm[number % 9]), single(axes.angles_deg[number / 9]));
            let mut found = [0.0_f32; 31];
            match quantity {
                Quantity::Transmittance => snow.transmittance(thickness_cm, angle_deg, &mut found),
                Quantity::Reflectance => snow.reflectance(thickness_cm, angle_deg, &mut found),
            }
            let errors = found.iter().zip(curve).filter(|(_, solved)| **solved > 1e-6);
            worst = errors.fold(worst, |worst, (found, solved)| worst.max((f64::from(*found) / solved - 1.0).abs()));
        }
    }
    worst
}

#[expect(clippy::cast_possible_truncation, reason = "look-ups take single precision")]
fn single(value: f64) -> f32 {
    value as f32
}
