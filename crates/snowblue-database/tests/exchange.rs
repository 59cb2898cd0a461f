//! Import and export of tables, and readers that survive any damaged file.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::path::Path;

use snowblue_database::exchange::{self, FixedValues};
use snowblue_database::file::{self, AnyTable};
use snowblue_database::fill::{self, FillOptions};
use snowblue_database::shard::{self, Part};
use snowblue_database::{Axes, CompressedTable, Property, PropertyAxis, Space, Table};
use snowblue_transport::optics::Substance;

fn axes() -> Axes {
    Axes {
        grain_sizes_um: vec![200.0, 400.0],
        facetness: vec![0.3],
        densities_kg_m3: vec![300.0],
        properties: vec![
            PropertyAxis { property: Property::Temperature, values: vec![-5.0, -1.0] },
            PropertyAxis { property: Property::Impurity(Substance::BlackCarbon), values: vec![0.0, 20.0] },
        ],
        diffuse: true,
        angles_deg: vec![0.0, 60.0],
        thicknesses_cm: vec![0.5, 3.0],
        wavelengths_nm: vec![400.0, 550.0, 700.0],
    }
}

fn table() -> Table {
    fill::fill(&axes(), &FillOptions::by_ordinates(1 << 10), &|_| ()).unwrap()
}

/// A repeatable number below `count`.
fn choose(state: &mut u64, count: usize) -> usize {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    usize::try_from(*state >> 33).unwrap() % count
}

/// Values are the same bits after export and import, in any order of rows. Fixed values complete the rows.
#[test]
fn csv_is_imported_as_exported() {
    let folder = tempfile::tempdir().unwrap();
    let (path, reordered) = (folder.path().join("table.csv"), folder.path().join("reordered.csv"));
    let table = table();
    exchange::export_csv(&AnyTable::Full(table.clone()), &path).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    let (header, rows) = text.split_once('\n').unwrap();
    assert!(header.starts_with("grain_size_um,facetness,density_kg_m3,temperature_c,black_carbon_ng_g,angle_deg,"));
    let reversed: Vec<&str> = rows.lines().rev().collect();
    std::fs::write(&reordered, format!("{header}\n{}\n", reversed.join("\n"))).unwrap();
    let read = exchange::import_csv(&reordered, &FixedValues::new()).unwrap();
    assert_eq!((read.axes, read.transmittance, read.reflectance), (table.axes, table.transmittance, table.reflectance));

    let few = "thickness_cm,wavelength_nm,angle_deg,transmittance,transmittance_se,reflectance_se,absorptance\n\
               1,400,diffuse,.5,.01,.02,.1\n1,500,diffuse,.4,.01,.02,.1\n\
               2,400,diffuse,.3,.01,.02,.1\n2,500,diffuse,.2,.01,.02,.1\n";
    std::fs::write(&path, few).unwrap();
    let set = [("grain_size_um", 300.0), ("facetness", 0.3), ("density", 250.0), ("reflectance", 0.45)];
    let fixed: FixedValues = set.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
    let read = exchange::import_csv(&path, &fixed).unwrap();
    assert!(read.axes.diffuse && read.axes.angles_deg.is_empty());
    assert_eq!((read.transmittance, read.reflectance), (vec![0.5, 0.4, 0.3, 0.2], vec![0.45; 4]));
    assert_eq!(read.errors.unwrap().reflectance, vec![0.02; 4]);
}

#[test]
fn incomplete_grids_are_refused_with_the_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rows.csv");
    let header =
        "grain_size_um,facetness,density_kg_m3,angle_deg,thickness_cm,wavelength_nm,transmittance,reflectance\n";
    let good = ["400,.3,300,0,1,500,.2,.7", "400,.3,300,0,2,500,.1,.8"];
    let message = |text: &str| {
        std::fs::write(&path, text).unwrap();
        let message = exchange::import_csv(&path, &FixedValues::new()).unwrap_err().to_string();
        let by_bytes = exchange::import_csv_bytes("rows.csv", text.as_bytes(), &FixedValues::new()).unwrap_err();
        assert!(message.ends_with(&by_bytes.to_string()), "{by_bytes}");
        assert!(message.contains("rows.csv") && !message.contains('\n'), "{message}");
        message
    };
    let rows = |rows: &[&str]| format!("{header}{}\n", rows.join("\n"));
    for (text, words) in [
        (
            rows(&[good[0], good[1], "400,.3,300,0,2,600,.1,.8"]),
            "there is no row for 400 µm, facetness 0.3, 300 kg/m³, 0°, 1 cm, 600 nm",
        ),
        (rows(&[good[0], good[1], good[0]]), "lines 2 and 4 are the same point of the grid"),
        (rows(&[good[0], "400,.3,300,0,2,500,bright,.8"]), "line 3: 'bright' is not a number"),
        (rows(&[good[0], "400,.3,300,0,2,500,20,.8"]), "line 3: transmittance is 20"),
        (rows(&[good[0], "400,.3,300"]), "line: 3"),
        (rows(&[good[0]]), "two values or more"),
        (
            (0..20)
                .map(|i| format!("{0},{1},3{2},{2},{0},{0},.2,.7\n", 400 + i, 0.01 * f64::from(i), 10 + i))
                .fold(header.to_owned(), |all, row| all + &row),
            "is not a grid: 20 rows, but its axes have 20 × 20",
        ),
        (rows(&[&good[0].replace("500", "0.5"), &good[1].replace("500", "0.5")]), "wavelength is 0.5 nm"),
        (rows(&good).replace("facetness", "shininess"), "column 'shininess' is unknown"),
        (rows(&good).replace("facetness", "density"), "occurs twice"),
        (rows(&good).replace("reflectance", "absorptance"), "--set reflectance=VALUE"),
        (rows(&good).replace("grain_size_um,", "").replace("400,", ""), "--set grain_size_um=VALUE"),
        (String::new(), "has no"),
    ] {
        let message = message(&text);
        assert!(message.contains(words), "{words}: {message}");
    }
}

#[test]
fn netcdf_is_imported_as_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.nc");
    let table = table();
    table.write(&path).unwrap();
    let read = exchange::import_netcdf(&path, &FixedValues::new()).unwrap();
    assert_eq!((read.axes, read.transmittance, read.reflectance), (table.axes, table.transmittance, table.reflectance));
    let set = FixedValues::from([("angle".to_owned(), 0.0)]);
    assert!(exchange::import_netcdf(&path, &set).unwrap_err().to_string().contains("cannot be set"));
    // Bytes and a wrong unit.
    let bytes = std::fs::read(&path).unwrap();
    let from_bytes = exchange::import_netcdf_bytes("table.nc", &bytes, &FixedValues::new()).unwrap();
    assert_eq!(from_bytes, exchange::import_netcdf(&path, &FixedValues::new()).unwrap());
    let place = bytes.windows(4).position(|four| four == b"cm\0\0").unwrap();
    std::fs::write(&path, [&bytes[..place], b"mm", &bytes[place + 2..]].concat()).unwrap();
    let message = exchange::import_netcdf(&path, &FixedValues::new()).unwrap_err().to_string();
    assert!(message.contains("'thickness' has the unit 'mm', but must be in cm"), "{message}");
    std::fs::write(&path, b"\x89HDF\r\n\x1a\n").unwrap();
    for message in [exchange::import_netcdf(&path, &FixedValues::new()).unwrap_err(), file::read(&path).unwrap_err()]
        .map(|e| e.to_string())
    {
        assert!(message.contains("is NetCDF-4 (HDF5)"), "{message}");
    }
}

/// Arrays are at their positions in the JSON file, and its recipe rebuilds a value of the table.
#[test]
fn raw_numbers_are_at_their_positions_in_the_json() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("snow.json");
    let table = table();
    let compressed = CompressedTable::new(&table, Space::Log, 2).unwrap();
    exchange::export_raw(&AnyTable::Compressed(compressed.clone()), &path).unwrap();
    let document: serde_json::Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    let bytes = std::fs::read(folder.path().join(document["numbers"].as_str().unwrap())).unwrap();
    let numbers: Vec<f32> = bytes.chunks_exact(4).map(|four| f32::from_le_bytes(four.try_into().unwrap())).collect();
    let array = |name: &str| {
        let array = document["arrays"].as_array().unwrap().iter().find(|array| array["name"] == name).unwrap();
        let first = usize::try_from(array["first_number"].as_u64().unwrap()).unwrap();
        let count = usize::try_from(array["count"].as_u64().unwrap()).unwrap();
        &numbers[first..first + count]
    };
    let (coefficients, basis) = (array("transmittance_coefficients"), array("transmittance_basis"));
    assert_eq!(coefficients, compressed.transmittance.coefficients);
    let curve = 17;
    let value = (coefficients[2 * curve] * basis[2] + coefficients[2 * curve + 1] * basis[3]).exp();
    let mut rebuilt = [0.0; 3];
    compressed.transmittance.rebuild(curve, Space::Log, &mut rebuilt);
    assert!((f64::from(value) / rebuilt[1] - 1.0).abs() < 1e-5);
    assert_eq!(document["axes"][0]["values"], serde_json::json!([200.0, 400.0]));
}

/// Thousands of files of every kind with bytes changed, removed, inserted and truncated: an error or a table, never a
/// panic, and never more memory than the file could fill.
#[test]
fn damaged_files_cause_no_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged.nc");
    let table = table();
    table.write(&path).unwrap();
    let full = std::fs::read(&path).unwrap();
    CompressedTable::new(&table, Space::Log, 2).unwrap().write(&path).unwrap();
    let compressed = std::fs::read(&path).unwrap();
    let part = Part { number: 1, of: 2 };
    shard::fill_part(&axes(), &FillOptions::by_ordinates(1 << 10), part, &|_| ()).unwrap().write(&path).unwrap();
    let sharded = std::fs::read(&path).unwrap();
    let mut state = 4;
    for whole in [full, compressed, sharded] {
        for _ in 0..1500 {
            let mut bytes = whole.clone();
            for _ in 0..=choose(&mut state, 3) {
                // Mostly in the header, which has the layout.
                let reach = if choose(&mut state, 4) > 0 { bytes.len().min(2000) } else { bytes.len() };
                let place = choose(&mut state, reach);
                match choose(&mut state, 5) {
                    0 => bytes[place] = u8::try_from(choose(&mut state, 256)).unwrap(),
                    1 => bytes[place] ^= 1 << choose(&mut state, 8),
                    2 => bytes.truncate(place.max(1)),
                    3 => drop(bytes.drain(place..(place + 1 + choose(&mut state, 8)).min(bytes.len()))),
                    _ => bytes.insert(place, 0xff),
                }
                if bytes.is_empty() {
                    bytes.push(0);
                }
            }
            std::fs::write(&path, &bytes).unwrap();
            let read = file::read(&path);
            let from_bytes = AnyTable::from_bytes(path.to_str().unwrap(), &bytes);
            assert_eq!(read.as_ref().ok(), from_bytes.as_ref().ok());
            check_message(read.err().map(|error| error.to_string()));
            check_message(from_bytes.err().map(|error| error.to_string()));
            check_message(exchange::import_netcdf(&path, &FixedValues::new()).err().map(|error| error.to_string()));
        }
    }
}

#[test]
fn damaged_rows_cause_no_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged.csv");
    exchange::export_csv(&AnyTable::Full(table()), &path).unwrap();
    let whole = std::fs::read(&path).unwrap();
    let mut state = 5;
    for _ in 0..1500 {
        let mut bytes = whole[..1 + choose(&mut state, whole.len())].to_vec();
        for _ in 0..=choose(&mut state, 3) {
            let place = choose(&mut state, bytes.len());
            bytes[place] = b"\",\n\r.-e9x\xff\0"[choose(&mut state, 11)];
        }
        std::fs::write(&path, &bytes).unwrap();
        check_message(exchange::import_csv(&path, &FixedValues::new()).err().map(|error| error.to_string()));
    }
}

/// One line that names the file.
fn check_message(message: Option<String>) {
    if let Some(message) = message {
        assert!(message.contains("damaged.") && !message.contains('\n'), "{message}");
        assert!(Path::new(&message).to_str().is_some() && message.len() < 600, "{message}");
    }
}
