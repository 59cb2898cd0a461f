//! Export of tables, and a reader that survives any damaged file.

use std::path::Path;

use snowblue_database::file::{self, AnyTable};
use snowblue_database::fill::{self, FillOptions};
use snowblue_database::shard::{self, Part};
use snowblue_database::{Axes, CompressedTable, Property, PropertyAxis, Space, Table, export_csv};
use snowblue_transport::optics::Substance;

fn axes() -> Axes {
    Axes {
        grain_sizes_um: vec![200.0, 400.0],
        facetness: vec![0.3],
        densities_kg_m3: vec![300.0],
        properties: vec![
            PropertyAxis { property: Property::Temperature, values: vec![-5.0, -1.0] },
            PropertyAxis { property: Property::Impurity(Substance::BLACK_CARBON), values: vec![0.0, 20.0] },
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

/// Every value of a full table stands in a row with its coordinates, to the bit.
#[test]
fn csv_has_a_row_for_each_value() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.csv");
    let table = table();
    export_csv(&AnyTable::Full(table.clone()), &path).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    let (header, rows) = text.split_once('\n').unwrap();
    assert_eq!(
        header,
        "grain_size_um,facetness,density_kg_m3,temperature_c,black_carbon_ng_g,angle_deg,thickness_cm,wavelength_nm,\
         transmittance,reflectance"
    );
    let rows: Vec<Vec<&str>> = rows.lines().map(|row| row.split(',').collect()).collect();
    let column = |index: usize| rows.iter().map(|row| row[index].parse().unwrap()).collect::<Vec<f64>>();
    assert_eq!((column(8), column(9)), (table.transmittance, table.reflectance));
    assert_eq!(rows[0][..8], ["200", "0.3", "300", "-5", "0", "diffuse", "0.5", "400"]);
    assert_eq!(rows[rows.len() - 1][..8], ["400", "0.3", "300", "-1", "20", "60", "3", "700"]);
}

#[test]
fn tables_of_another_layout_are_refused_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.nc");
    table().write(&path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let message = |bytes: &[u8]| {
        let message = AnyTable::from_bytes("table.nc", bytes).unwrap_err().to_string();
        std::fs::write(&path, bytes).unwrap();
        assert!(file::read(&path).unwrap_err().to_string().ends_with(&message), "{message}");
        message
    };
    assert!(message(b"\x89HDF\r\n\x1a\n").contains("is NetCDF-4 (HDF5)"));
    // The first two dimensions of transmittance in the other order. They follow its name and their number.
    let name = b"transmittance\0\0\0\0\0\0\x08";
    let place = bytes.windows(name.len()).position(|found| found == name).unwrap() + name.len();
    let swapped = [&bytes[..place], &bytes[place + 4..place + 8], &bytes[place..place + 4], &bytes[place + 8..]];
    let expected = "has not the dimensions grain_size, facetness, density, temperature, black_carbon, angle, \
                    thickness, wavelength in this order";
    let message = message(&swapped.concat());
    assert!(message.contains(expected), "{message}");
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
        }
    }
}

/// One line that names the file.
fn check_message(message: Option<String>) {
    if let Some(message) = message {
        assert!(message.contains("damaged.") && !message.contains('\n'), "{message}");
        assert!(Path::new(&message).to_str().is_some() && message.len() < 600, "{message}");
    }
}
