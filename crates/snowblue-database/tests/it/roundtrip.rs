//! Packed tables are read as rounded; other files are refused in one line.

use std::path::Path;

use snowblue_database::file::{self, AnyTable};
use snowblue_database::fill::{self, Engine, FillOptions};
use snowblue_database::{Axes, CompressedTable, DatabaseError, PcaSnow, Property, Quantity, Space, Table, TableSample};
use snowblue_transport::ordinates::Streams;

fn small_table() -> Table {
    let axes = Axes {
        grain_sizes_um: vec![200.0, 400.0],
        facetness: vec![0.3],
        densities_kg_m3: vec![250.0, 300.0],
        angles_deg: vec![0.0, 60.0],
        thicknesses_cm: vec![1.0, 3.0, 10.0],
        ..Axes::paper()
    };
    let options = FillOptions {
        engine: Engine::Ordinates { streams: Streams::Exactly(8), tally_rays: 1 << 10 },
        ..FillOptions::default()
    };
    fill::fill(&axes, &options, &|_| ()).unwrap()
}

/// A packed table is the rounded one in a smaller file.
#[test]
fn packed_table_is_read_as_rounded() {
    const STEP: f32 = 1.0 / 1024.0;
    let folder = tempfile::tempdir().unwrap();
    for space in [Space::Linear, Space::Log] {
        let [plain, packed] = ["plain.nc", "packed.nc"].map(|name| folder.path().join(name));
        let compressed = CompressedTable::new(&small_table(), space, 3).unwrap();
        compressed.write(&plain).unwrap();
        compressed.write_packed(&packed, STEP).unwrap();
        assert_eq!(file::read(&packed).unwrap(), AnyTable::Compressed(compressed.rounded(STEP)));
        let [plain, packed] = [&plain, &packed].map(|path| path.metadata().unwrap().len());
        assert!(packed < plain, "{packed} {plain}");
    }
}

#[test]
fn a_step_that_is_too_small_is_refused() {
    let compressed = CompressedTable::new(&small_table(), Space::Log, 3).unwrap();
    let message = compressed.write_packed(Path::new("no/file.nc"), f32::MIN_POSITIVE).unwrap_err().to_string();
    assert!(message.starts_with("no/file.nc: cannot be written: the coefficient -"), "{message}");
    assert!(message.ends_with(" of transmittance has more than 2²⁴ steps"), "{message}");
}

/// All components together rebuild the table to single precision.
#[test]
fn all_components_rebuild_the_table() {
    let table = small_table();
    for space in [Space::Linear, Space::Log] {
        let compressed = CompressedTable::new(&table, space, 24).unwrap();
        for quantity in Quantity::ALL {
            let mut rebuilt = vec![0.0; 31];
            for (number, curve) in table.curves(quantity).enumerate() {
                compressed.components(quantity).rebuild(number, space, &mut rebuilt);
                for (a, b) in curve.iter().zip(&rebuilt) {
                    // Coefficients up to 60 in single precision; in log space this is the error of the logarithm.
                    assert!((a - b).abs() < 1e-5, "{a} {b}");
                }
            }
        }
    }
}

/// Rounding moves a curve by at most half a step along each vector of the orthonormal basis.
#[test]
fn rounded_coefficients_change_curves_within_the_bound() {
    const STEP: f32 = 1.0 / 1024.0;
    let exact = CompressedTable::new(&small_table(), Space::Log, 3).unwrap();
    let rounded = exact.clone().rounded(STEP);
    let bound = 0.5 * f64::from(STEP) * (3.0_f64 / 31.0).sqrt();
    let mut worst = 0.0_f64;
    for quantity in Quantity::ALL {
        let [exact, rounded] = [&exact, &rounded].map(|table| table.components(quantity));
        assert!(rounded.coefficients.iter().all(|coefficient| (coefficient / STEP).fract().abs() <= 0.0));
        for curve in 0..exact.coefficients.len() / 3 {
            let (mut before, mut after) = (vec![0.0; 31], vec![0.0; 31]);
            exact.rebuild(curve, Space::Log, &mut before);
            rounded.rebuild(curve, Space::Log, &mut after);
            let squares: f64 = before.iter().zip(&after).map(|(before, after)| (after / before).ln().powi(2)).sum();
            worst = worst.max((squares / 31.0).sqrt());
        }
    }
    // The basis is in single precision.
    assert!(worst > 0.3 * bound && worst < 1.001 * bound, "{worst} of {bound}");
}

#[test]
fn broken_and_foreign_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let [plain, packed] = ["plain.nc", "packed.nc"].map(|name| folder.path().join(name));
    let compressed = CompressedTable::new(&small_table(), Space::Log, 3).unwrap();
    compressed.write(&plain).unwrap();
    compressed.write_packed(&packed, 1.0 / 1024.0).unwrap();
    let path = folder.path().join("broken.nc");
    let refuse = |contents: &[u8]| {
        std::fs::write(&path, contents).unwrap();
        let message = file::read(&path).unwrap_err().to_string();
        assert!(message.contains("broken.nc") && !message.contains('\n'), "{message}");
    };
    // Every truncation, and every damaged byte of the header.
    for bytes in [plain, packed].map(|path| std::fs::read(path).unwrap()) {
        for length in (0..bytes.len() - 4).step_by(97) {
            refuse(&bytes[..length]);
        }
        for place in (0..bytes.len()).step_by(11) {
            let mut damaged = bytes.clone();
            damaged[place] ^= 0xff;
            std::fs::write(&path, &damaged).unwrap();
            // Damage to a number may go undetected; damage to the layout is an error, never a panic.
            drop(file::read(&path));
        }
    }
    refuse(b"");
    refuse(b"PK\x03\x04 not a table");
    let missing = file::read(Path::new("no/such/file.nc")).unwrap_err().to_string();
    assert!(missing.starts_with("no/such/file.nc: cannot be read"), "{missing}");
}

#[test]
fn messages_name_the_axis_and_its_values() {
    let message = |space, sample: TableSample| {
        let compressed = CompressedTable::new(&small_table(), space, 3).unwrap();
        PcaSnow::new(&compressed, &sample).unwrap_err().to_string()
    };
    assert_eq!(
        message(Space::Linear, TableSample::new(400.0, 0.3, 320.0)),
        "density is 320 kg/m³, but the paper's scheme has only the table's own values: 250, 300 kg/m³"
    );
    assert_eq!(
        message(Space::Log, TableSample::new(401.0, 0.3, 320.0)),
        "grain size is 401 µm, but the table covers 200–400 µm"
    );
    assert_eq!(
        message(Space::Log, TableSample::new(400.0, 0.4, 320.0)),
        "facetness is 0.4, but the table has only 0.3"
    );
    assert_eq!(
        message(Space::Log, TableSample::new(400.0, 0.3, 950.0)),
        "density is 950 kg/m³, but must lie in 10–900 kg/m³"
    );
    let wet = TableSample::new(400.0, 0.3, 300.0).with(Property::WaterSaturation, 0.1);
    let missing = "water saturation is 0.1, but the table has no such axis and holds only 0";
    assert_eq!([Space::Linear, Space::Log].map(|space| message(space, wet.clone())), [missing; 2]);
    assert!(matches!(
        CompressedTable::new(&small_table(), Space::Log, 0),
        Err(DatabaseError::Components { components: 0, .. })
    ));
}

/// Axes that allow no spline or no slab are refused, in memory and in files.
#[test]
fn invalid_axes_are_refused() {
    let table = small_table();
    for (thicknesses_cm, angles_deg) in [
        (vec![-1.0, 1.0, 3.0], vec![0.0, 60.0]),
        (vec![0.0, 1.0, 3.0], vec![0.0, 60.0]),
        (vec![15.0], vec![0.0]),
        (vec![3.0, 1.0, 10.0], vec![0.0, 60.0]),
        (vec![1.0, 3.0, 10.0], vec![0.0, 90.0]),
        (vec![1.0, 3.0, f64::NAN], vec![0.0, 60.0]),
    ] {
        let axes = Axes { thicknesses_cm, angles_deg, ..table.axes.clone() };
        assert!(fill::fill(&axes, &FillOptions::default(), &|_| ()).is_err(), "{axes:?}");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("axes.nc");
        let values = vec![0.5; axes.curves() * 31];
        Table { axes, transmittance: values.clone(), reflectance: values, errors: None, metadata: vec![] }
            .write(&path)
            .unwrap();
        assert!(file::read(&path).is_err());
    }
}
