//! Snow returns no more light than it gets: R + T ≤ 1 for every sample of the embedded table, at depths and angles of the
//! table and between them, but for what its six components and its splines round.

#![allow(clippy::unwrap_used, reason = "tests may panic")]

use snowblue_database::{PcaSnow, TableSample};

/// A range of depths and angles, and by how much R + T passes 1 at most in it.
struct Range {
    depths_cm: [f32; 2],
    angles_deg: [f32; 2],
    rounding: f32,
}

const RANGES: [Range; 4] = [
    Range { depths_cm: [0.1, 300.0], angles_deg: [0.0, 89.0], rounding: 1e-3 },
    Range { depths_cm: [0.01, 0.1], angles_deg: [0.0, 89.0], rounding: 1e-2 },
    // Less than the smallest grain: light that grazes it meets a hundred times the depth, and curves change fastest.
    Range { depths_cm: [5e-4, 0.01], angles_deg: [0.0, 80.0], rounding: 1e-2 },
    Range { depths_cm: [5e-4, 0.01], angles_deg: [80.0, 89.0], rounding: 0.17 },
];

#[test]
fn reflected_and_transmitted_light_are_no_more_than_all_of_it() {
    let table = snowblue_data::embedded();
    let axes = &table.axes;
    for (&grain_size_um, &facetness) in
        axes.grain_sizes_um.iter().flat_map(|size| axes.facetness.iter().map(move |facetness| (size, facetness)))
    {
        let snow = PcaSnow::new(table, &TableSample::new(grain_size_um, facetness, 300.0)).unwrap();
        let (mut reflected, mut passed) = ([0.0; 31], [0.0; 31]);
        for Range { depths_cm: [thin, thick], angles_deg: [low, high], rounding } in RANGES {
            for (depth, angle) in (0u8..=48).flat_map(|depth| (0u8..=24).map(move |angle| (depth, angle))) {
                let depth_cm = thin * (thick / thin).powf(f32::from(depth) / 48.0);
                let angle_deg = low + (high - low) * f32::from(angle) / 24.0;
                snow.reflectance(depth_cm, angle_deg, &mut reflected);
                snow.transmittance(depth_cm, angle_deg, &mut passed);
                for (reflected, passed) in reflected.iter().zip(passed) {
                    let sum = reflected + passed;
                    assert!(
                        *reflected >= 0.0 && passed >= 0.0 && sum < 1.0 + rounding,
                        "{reflected} + {passed} = {sum} at {depth_cm} cm, {angle_deg}°, {grain_size_um} µm, {facetness}"
                    );
                }
            }
        }
    }
}
