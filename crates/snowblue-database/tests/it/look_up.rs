//! Laws of the look-up, and the errors of its grid and of interpolated samples.

use std::sync::LazyLock;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use snowblue_color::{Colorimeter, Illuminant, Lab, Observer};
use snowblue_database::fill::{self, FillOptions};
use snowblue_database::lookup::SnowMix;
use snowblue_database::{Axes, CompressedTable, PcaSnow, Property, PropertyAxis, Quantity, Space, Table, TableSample};
use snowblue_transport::optics::Substance;

const SNOW: TableSample = TableSample::new(300.0, 0.3, 300.0);

fn fill(axes: &Axes) -> Table {
    fill::fill(axes, &FillOptions::by_ordinates(1 << 12), &|_| ()).unwrap()
}

static TABLE: LazyLock<Table> = LazyLock::new(|| {
    fill(&Axes {
        grain_sizes_um: vec![200.0, 250.0, 300.0, 350.0],
        facetness: vec![0.3],
        densities_kg_m3: vec![250.0, 300.0],
        ..Axes::with_thin_and_thick_knots()
    })
});
static COMPRESSED: LazyLock<CompressedTable> = LazyLock::new(|| CompressedTable::new(&TABLE, Space::Log, 6).unwrap());
static LOOKED_UP: LazyLock<PcaSnow> = LazyLock::new(|| PcaSnow::new(&COMPRESSED, &SNOW).unwrap());

fn transmittance(snow: &PcaSnow, thickness_cm: f32, angle_deg: f32) -> [f32; 31] {
    let mut spectrum = [f32::NAN; 31];
    snow.transmittance(thickness_cm, angle_deg, &mut spectrum);
    spectrum
}

fn reflectance(snow: &PcaSnow, thickness_cm: f32, angle_deg: f32) -> [f32; 31] {
    let mut spectrum = [f32::NAN; 31];
    snow.reflectance(thickness_cm, angle_deg, &mut spectrum);
    spectrum
}

fn config(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, failure_persistence: None, rng_seed: RngSeed::Fixed(3), ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(config(15))]

    /// Projected sums are those of the spectrum, for any observer.
    #[test]
    fn projected_sums_are_those_of_the_spectrum(
        places in prop::array::uniform20((-9.0..4.6_f32, 0.0..89.0_f32)),
        middle in 0.0..30.0_f32, width in 1.0..10.0_f32,
    ) {
        let bell = |k: f32| (-((k - middle) / width).powi(2)).exp();
        let weights: Vec<[f32; 4]> = (0..31_u8).map(f32::from).map(|k| [bell(k), 1.0, k, 0.0]).collect();
        let projected = LOOKED_UP.project(&weights).unwrap();
        let sums = |spectrum: [f32; 31]| {
            let sum = |c: usize| spectrum.iter().zip(&weights).map(|(value, weight)| value * weight[c]).sum::<f32>();
            [0, 1, 2, 3].map(sum)
        };
        for (logarithm, angle_deg) in places {
            let thickness_cm = logarithm.exp();
            let spectra =
                [transmittance, reflectance].map(|look_up| sums(look_up(&LOOKED_UP, thickness_cm, angle_deg)));
            let pairs = [
                (projected.transmittance(thickness_cm, angle_deg), spectra[0]),
                (projected.reflectance(thickness_cm, angle_deg), spectra[1]),
            ];
            for (looked_up, summed) in pairs {
                for (one, other) in looked_up.into_iter().zip(summed) {
                    // The logarithm of a mean of exponentials curves by the variance of their rates, (0.1/cm)² in the
                    // deepest snow, whose cells are 0.5 cm wide: at most 0.01 · 0.25/8, and less because few
                    // wavelengths remain.
                    prop_assert!((one - other).abs() <= 2e-4 * other, "{thickness_cm} cm, {angle_deg}°: {one} {other}");
                }
            }
            prop_assert!((projected.transmittance(0.0, angle_deg)[1] - 31.0).abs() < 1e-5);
            prop_assert!(projected.transmittance(thickness_cm, 90.0)[1] <= 0.0);
        }
    }
}

proptest! {
    #![proptest_config(config(300))]

    /// Thicker snow transmits less and reflects no less, and R + T stays at most 1, at any angle and across all cells.
    /// At 89° the sum is 1.0535 in 9 µm of snow.
    #[test]
    fn thicker_snow_transmits_less(logarithm in -9.0..5.0_f32, angle_deg in 0.0..88.9_f32, step in 0.01..0.5_f32) {
        let (thin, thick) = (logarithm.exp(), (logarithm + step).exp());
        let (before, after) = (transmittance(&LOOKED_UP, thin, angle_deg), transmittance(&LOOKED_UP, thick, angle_deg));
        let (dark, bright) = (reflectance(&LOOKED_UP, thin, angle_deg), reflectance(&LOOKED_UP, thick, angle_deg));
        for w in 0..31 {
            prop_assert!(before[w] >= after[w] && before[w] < 1.0 + 1e-6, "{thin} {angle_deg} {w}");
            prop_assert!(bright[w] >= dark[w] * (1.0 - 1e-4), "{thin} {angle_deg} {w}");
            // Errors of the linear interpolation; the table has few knots in layers of a few grains' thickness.
            let most = if thin < 0.01 { 1.05 } else { 1.005 };
            prop_assert!(before[w] + dark[w] <= most, "{thin} {angle_deg} {w}");
        }
    }

    /// A step of a millionth changes little anywhere: neither cells nor knots are discontinuities.
    #[test]
    fn transmittance_is_continuous(logarithm in -9.0..4.6_f32, angle_deg in 0.0..88.9_f32) {
        let thickness_cm = logarithm.exp();
        let here = transmittance(&LOOKED_UP, thickness_cm, angle_deg);
        for beside in [
            transmittance(&LOOKED_UP, thickness_cm * (1.0 + 1e-6), angle_deg),
            transmittance(&LOOKED_UP, thickness_cm, angle_deg + 1e-5),
        ] {
            for (a, b) in here.iter().zip(beside) {
                // ln T of up to 50, times a millionth, and rounding.
                prop_assert!((a - b).abs() <= 1e-4 * a.abs(), "{thickness_cm} {angle_deg}: {a} {b}");
            }
        }
    }
}

#[test]
fn transmittance_at_zero_thickness_is_one() {
    for angle_deg in [0.0, 33.0, 88.0] {
        assert!(transmittance(&LOOKED_UP, 0.0, angle_deg).iter().all(|t| t.to_bits() == 1.0_f32.to_bits()));
        assert!(transmittance(&LOOKED_UP, 1e-7, angle_deg).iter().all(|t| (t - 1.0).abs() < 1e-3));
        assert!(reflectance(&LOOKED_UP, 1e-7, angle_deg).iter().all(|r| *r < 1e-3));
    }
}

/// At the table's own points the resampled curves are the table's within the linear interpolation: 0.3 % of T and, in
/// layers from 0.008 cm, 0.6 % of R.
#[test]
fn resampling_preserves_the_table() {
    let axes = &TABLE.axes;
    let sample = 2 * 2 + 1;
    let mut rebuilt = [0.0; 31];
    for (quantity, most) in [(Quantity::Transmittance, 0.003), (Quantity::Reflectance, 0.006)] {
        for (a, angle_deg) in axes.angles_deg.iter().enumerate() {
            for (t, thickness_cm) in axes.thicknesses_cm.iter().enumerate().filter(|(_, h)| **h > 0.007) {
                let curve = sample * axes.curves_per_sample() + a * axes.thicknesses_cm.len() + t;
                COMPRESSED.components(quantity).rebuild(curve, Space::Log, &mut rebuilt);
                let look_up = if quantity == Quantity::Transmittance { transmittance } else { reflectance };
                for (found, table) in look_up(&LOOKED_UP, *thickness_cm as f32, *angle_deg as f32).iter().zip(&rebuilt)
                {
                    let error = (f64::from(*found) / table - 1.0).abs();
                    assert!(error < most, "{}: {error}", axes.describe(curve));
                }
            }
        }
    }
}

/// Dry snow depends only on the product of density and thickness: any density, also beyond the table's, is exact.
#[test]
fn density_scales_the_thickness() {
    for (density_kg_m3, known) in [(100.0, 250.0), (280.0, 300.0), (600.0, 300.0)] {
        let one = PcaSnow::new(&COMPRESSED, &TableSample { density_kg_m3, ..SNOW }).unwrap();
        let other = PcaSnow::new(&COMPRESSED, &TableSample { density_kg_m3: known, ..SNOW }).unwrap();
        for thickness_cm in [0.01, 0.5, 20.0_f32] {
            let thicker = thickness_cm * (density_kg_m3 / known) as f32;
            for look_up in [transmittance, reflectance] {
                for (a, b) in look_up(&one, thickness_cm, 40.0).iter().zip(look_up(&other, thicker, 40.0)) {
                    assert!((a - b).abs() < 1e-5 * b, "{density_kg_m3} kg/m³, {thickness_cm} cm: {a} {b}");
                }
            }
        }
    }
}

/// Mixes have the mean of the logarithms, also of densities on different sides of the table's.
#[test]
fn mixes_interpolate_logarithms() {
    let snow = |grain, density| PcaSnow::new(&COMPRESSED, &TableSample::new(grain, 0.3, density)).unwrap();
    let (first, second) = (snow(220.0, 230.0), snow(350.0, 320.0));
    for fraction in [0.0, 0.25, 1.0_f32] {
        let mixed = SnowMix::new(&first, &second, fraction);
        for (thickness_cm, angle_deg) in [(0.02, 10.0), (3.0, 0.0), (40.0, 75.0), (90.0, 88.0)] {
            let mut found = [[f32::NAN; 31]; 2];
            mixed.transmittance(thickness_cm, angle_deg, &mut found[0]);
            mixed.reflectance(thickness_cm, angle_deg, &mut found[1]);
            let ends = [&first, &second]
                .map(|snow| [transmittance(snow, thickness_cm, angle_deg), reflectance(snow, thickness_cm, angle_deg)]);
            for (quantity, found) in found.iter().enumerate() {
                for (k, found) in found.iter().enumerate() {
                    let [one, other] = [0, 1].map(|end: usize| f64::from(ends[end][quantity][k]).ln());
                    let expected = (one + f64::from(fraction) * (other - one)).exp();
                    // A logarithm of up to 50 in single precision, rounded once more than in the ends.
                    assert!(
                        (f64::from(*found) / expected - 1.0).abs() < 2e-5,
                        "{fraction} {thickness_cm} {quantity} {k}"
                    );
                }
            }
        }
    }
    let mut none = [f32::NAN; 31];
    SnowMix::new(&first, &second, 0.5).transmittance(0.0, 30.0, &mut none);
    assert!(none.iter().all(|value| (value - 1.0).abs() < 1e-6));
}

/// Wet, cold and sooty snow between the values of its axes is close to a direct solution with the same rays. Small
/// amounts of soot are the hardest case, since ice absorbs almost no blue light.
#[test]
fn further_properties_are_interpolated() {
    let soot = Property::Impurity(Substance::BLACK_CARBON);
    let compressed = |properties: Vec<PropertyAxis>| {
        let axes = Axes {
            grain_sizes_um: vec![300.0],
            facetness: vec![0.3],
            densities_kg_m3: vec![200.0, 300.0, 400.0],
            properties,
            wavelengths_nm: (0..16).map(|i| 400.0 + 20.0 * f64::from(i)).collect(),
            ..Axes::with_thin_and_thick_knots()
        };
        CompressedTable::new(&fill(&axes), Space::Log, 6).unwrap()
    };
    let wet = compressed(vec![
        PropertyAxis { property: Property::WaterSaturation, values: vec![0.0, 0.1, 0.2, 0.3] },
        PropertyAxis { property: Property::Temperature, values: vec![-20.0, -5.0] },
    ]);
    let sooty = compressed(vec![PropertyAxis { property: soot, values: vec![0.0, 1.0, 3.0, 10.0, 30.0, 100.0] }]);
    let between = |properties: Vec<PropertyAxis>| Axes {
        densities_kg_m3: vec![230.0, 370.0],
        properties,
        wavelengths_nm: wet.axes.wavelengths_nm.clone(),
        ..BETWEEN.clone()
    };
    let wet_points = between(vec![
        PropertyAxis { property: Property::WaterSaturation, values: vec![0.0, 0.05, 0.16, 0.27, 0.3] },
        PropertyAxis { property: Property::Temperature, values: vec![-20.0, -11.0, -5.0] },
    ]);
    let sooty_points =
        between(vec![PropertyAxis { property: soot, values: vec![0.0, 0.4, 0.7, 2.0, 7.0, 15.0, 50.0, 80.0] }]);
    for (table, points, most_steep) in [(&wet, &wet_points, 0.015), (&sooty, &sooty_points, 0.06)] {
        let errors = worst_errors(table, points);
        assert!(errors.steep < most_steep && errors.grazing < 2.0 * most_steep && errors.delta_e < 0.5, "{errors:?}");
    }
    assert_eq!(
        PcaSnow::new(&sooty, &SNOW.with(soot, 200.0)).unwrap_err().to_string(),
        "black-carbon is 200 ng/g, but the table covers 0–100 ng/g"
    );
}

/// Thicknesses and angles between those of the tables. The last angle is theirs, so that tallies have as many moments.
static BETWEEN: LazyLock<Axes> = LazyLock::new(|| Axes {
    grain_sizes_um: vec![300.0],
    facetness: vec![0.3],
    angles_deg: vec![4.0, 33.0, 66.0, 78.0, 83.0, 87.0, 89.0],
    thicknesses_cm: vec![0.012, 0.05, 0.4, 1.2, 4.0, 12.0, 30.0, 60.0, 85.0],
    ..Axes::paper()
});

/// The largest relative error of T and R that exceed 10⁻⁶, up to 80° and above, and ΔE under D65.
#[derive(Debug, Default)]
struct WorstErrors {
    steep: f64,
    grazing: f64,
    delta_e: f64,
}

/// Compares look-ups with direct solutions by the same rays, so that the noise of the tally cancels.
fn worst_errors(table: &CompressedTable, points: &Axes) -> WorstErrors {
    let solved = fill(points);
    let colorimeter = Colorimeter::new(Observer::Cie1931, Illuminant::D65, &points.wavelengths_nm).unwrap();
    let lab = |curve: &[f64]| Lab::from_xyz(colorimeter.xyz(curve), colorimeter.white());
    let mut worst = WorstErrors::default();
    for quantity in Quantity::ALL {
        let curves: Vec<&[f64]> = solved.curves(quantity).collect();
        for (number, curves) in curves.chunks_exact(points.curves_per_sample()).enumerate() {
            let snow = PcaSnow::new(table, &points.table_sample(number)).unwrap();
            let places = points.angles_deg.iter().flat_map(|a| points.thicknesses_cm.iter().map(move |h| (*a, *h)));
            for ((angle_deg, thickness_cm), curve) in places.zip(curves) {
                let mut found = vec![0.0; curve.len()];
                match quantity {
                    Quantity::Transmittance => snow.transmittance(thickness_cm as f32, angle_deg as f32, &mut found),
                    Quantity::Reflectance => snow.reflectance(thickness_cm as f32, angle_deg as f32, &mut found),
                }
                let found: Vec<f64> = found.into_iter().map(f64::from).collect();
                let error =
                    |(found, exact): (&f64, &f64)| if *exact > 1e-6 { (found / exact - 1.0).abs() } else { 0.0 };
                let error = found.iter().zip(*curve).map(error).fold(0.0, f64::max);
                let most = if angle_deg < 80.0 { &mut worst.steep } else { &mut worst.grazing };
                *most = most.max(error);
                worst.delta_e = worst.delta_e.max(lab(&found).delta_e_1976(lab(curve)));
            }
        }
    }
    worst
}

#[test]
fn look_ups_between_the_values_agree_with_direct_solutions() {
    let points = |grain_sizes_um: Vec<f64>, densities_kg_m3: Vec<f64>| Axes {
        grain_sizes_um,
        densities_kg_m3,
        ..BETWEEN.clone()
    };
    let on_grid = points(vec![200.0, 350.0], vec![250.0, 300.0]);
    for points in [&on_grid, &points(vec![220.0, 280.0, 340.0], vec![265.0, 290.0])] {
        let errors = worst_errors(&COMPRESSED, points);
        assert!(errors.steep < 0.01 && errors.grazing < 0.03 && errors.delta_e < 1.0, "{errors:?}");
    }
    // The paper's scheme has large errors where there is least light.
    let linear = worst_errors(&CompressedTable::new(&TABLE, Space::Linear, 2).unwrap(), &on_grid);
    assert!(linear.steep > 0.1, "{linear:?}");
}

/// Where the last knots transmit nothing measurable, thicker snow transmits nothing either: extrapolation to 30 m or 3
/// km does not increase transmittance.
#[test]
fn extrapolation_does_not_increase_transmittance() {
    let axes = Axes {
        grain_sizes_um: vec![400.0],
        facetness: vec![0.3],
        densities_kg_m3: vec![300.0],
        angles_deg: vec![0.0, 60.0],
        thicknesses_cm: vec![1.0, 5.0, 20.0],
        wavelengths_nm: vec![500.0, 1500.0],
        ..Axes::paper()
    };
    for dark in [[0.3, 0.1, 0.1, 0.0, 0.05, 0.0], [0.3, 0.2, 0.1, 1e-4, 0.05, 1e-4]] {
        let table = Table {
            axes: axes.clone(),
            transmittance: [dark, dark].concat(),
            reflectance: vec![0.5; 12],
            errors: None,
            metadata: vec![],
        };
        for count in [1, 2] {
            let compressed = CompressedTable::new(&table, Space::Log, count).unwrap();
            let snow = PcaSnow::new(&compressed, &TableSample::new(400.0, 0.3, 300.0)).unwrap();
            let at = |thickness_cm: f32| {
                let mut spectrum = [0.0; 2];
                snow.transmittance(thickness_cm, 30.0, &mut spectrum);
                spectrum
            };
            // Beyond the cell that holds the last knot.
            let last = at(23.0);
            for thickness_cm in [24.0, 30.0, 100.0, 3e3, 3e5] {
                let beyond = at(thickness_cm);
                assert!(beyond.iter().zip(last).all(|(t, last)| *t <= last && *t >= 0.0), "{last:?} {beyond:?}");
            }
        }
    }
}

/// In log space look-ups resolve angles up to the table's last, in the paper's scheme up to 89°. Larger angles are
/// looked up at that angle.
#[test]
fn last_angle_is_the_tables_in_log_space_and_89_degrees_in_the_papers_scheme() {
    let law = |thickness_cm: f64, angle_deg: f64| (-0.3 * thickness_cm * (1.0 + angle_deg / 100.0)).exp();
    let axes = Axes {
        grain_sizes_um: vec![300.0],
        facetness: vec![0.3],
        densities_kg_m3: vec![300.0],
        angles_deg: vec![0.0, 60.0, 89.0, 89.9],
        thicknesses_cm: vec![1.0, 4.0],
        wavelengths_nm: vec![500.0],
        ..Axes::paper()
    };
    let at_angle = |angle_deg: &f64| axes.thicknesses_cm.iter().map(|h| law(*h, *angle_deg)).collect::<Vec<f64>>();
    let transmittance: Vec<f64> = axes.angles_deg.iter().flat_map(at_angle).collect();
    let table = Table { reflectance: transmittance.clone(), transmittance, axes, errors: None, metadata: vec![] };
    let snow = |space| PcaSnow::new(&CompressedTable::new(&table, space, 1).unwrap(), &SNOW).unwrap();
    let looked_up = |snow: &PcaSnow, angle_deg: f32| {
        let mut found = [f32::NAN];
        snow.transmittance(4.0, snow.look_up_angle_deg(angle_deg.to_radians().cos()), &mut found);
        f64::from(found[0])
    };
    let (log, linear) = (snow(Space::Log), snow(Space::Linear));
    for (angle_deg, resolved_deg) in [(30.0, 30.0), (89.4, 89.4), (89.88, 89.88), (89.95, 89.9)] {
        let expected = law(4.0, resolved_deg);
        assert!((looked_up(&log, angle_deg) / expected - 1.0).abs() < 1e-4, "{angle_deg}°");
    }
    for angle_deg in [89.0, 89.4, 89.95] {
        assert!((looked_up(&linear, angle_deg) / law(4.0, 89.0) - 1.0).abs() < 1e-4, "{angle_deg}°");
    }
    assert_eq!([&log, &linear].map(|snow| snow.last_angle_deg().to_bits()), [89.9_f32, 89.0].map(f32::to_bits));
}
