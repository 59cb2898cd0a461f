//! Energy conservation: R + T ≤ 1 for every sample of the embedded table, at the table's thicknesses and angles and
//! between them, within the errors of six components and of interpolation.

use snowblue_database::{PcaSnow, TableSample};

/// A range of thicknesses and angles.
struct Range {
    thicknesses_cm: [f32; 2],
    angles_deg: [f32; 2],
    /// Largest R + T − 1.
    tolerance: f32,
}

const RANGES: [Range; 4] = [
    Range { thicknesses_cm: [0.1, 300.0], angles_deg: [0.0, 89.0], tolerance: 1e-3 },
    Range { thicknesses_cm: [0.01, 0.1], angles_deg: [0.0, 89.0], tolerance: 1e-2 },
    // Thinner than the smallest grain. Paths of grazing light are a hundred times longer, and curves vary fastest.
    Range { thicknesses_cm: [5e-4, 0.01], angles_deg: [0.0, 80.0], tolerance: 1e-2 },
    Range { thicknesses_cm: [5e-4, 0.01], angles_deg: [80.0, 89.0], tolerance: 0.17 },
];

#[test]
fn reflectance_and_transmittance_add_up_to_at_most_one() {
    let table = snowblue_data::embedded();
    let axes = &table.axes;
    for (&grain_size_um, &facetness) in
        axes.grain_sizes_um.iter().flat_map(|size| axes.facetness.iter().map(move |facetness| (size, facetness)))
    {
        let snow = PcaSnow::new(table, &TableSample::new(grain_size_um, facetness, 300.0)).unwrap();
        let (mut reflected, mut transmitted) = ([0.0; 31], [0.0; 31]);
        for Range { thicknesses_cm: [thin, thick], angles_deg: [low, high], tolerance } in RANGES {
            for (step, angle) in (0u8..=48).flat_map(|step| (0u8..=24).map(move |angle| (step, angle))) {
                let thickness_cm = thin * (thick / thin).powf(f32::from(step) / 48.0);
                let angle_deg = low + (high - low) * f32::from(angle) / 24.0;
                snow.reflectance(thickness_cm, angle_deg, &mut reflected);
                snow.transmittance(thickness_cm, angle_deg, &mut transmitted);
                for (reflected, transmitted) in reflected.iter().zip(transmitted) {
                    let sum = reflected + transmitted;
                    assert!(
                        *reflected >= 0.0 && transmitted >= 0.0 && sum < 1.0 + tolerance,
                        "R {reflected} + T {transmitted}: {thickness_cm} cm, {angle_deg}°, {grain_size_um} µm, \
                         {facetness}"
                    );
                }
            }
        }
    }
}
