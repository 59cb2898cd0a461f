//! Columns, tables, help and messages of several commands.

use crate::shell::{Folder, assert_names, snowblue, stderr, stdout};

/// The numbers of a line of a CSV.
fn numbers(line: &str) -> Vec<f64> {
    line.split(',').map(|field| field.parse().unwrap()).collect()
}

#[test]
fn slab_prints_van_de_hulsts_numbers() {
    let text = stdout("slab --one-minus-omega 0.1 --g 0.75 --tau 2 --mu0 1");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "reflectance,transmittance,direct");
    let values = numbers(lines[1]);
    assert!((values[0] - 0.09739).abs() < 5e-6 && (values[1] - 0.66096).abs() < 5e-6, "{text}");
}

#[test]
fn spectrum_has_its_columns_and_adds_up() {
    let text = stdout("spectrum --thickness 1,15 --angle 0,diffuse --wavelengths 450,700");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("thickness_cm,angle_deg,wavelength_nm,reflectance,transmittance,absorptance"));
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 8);
    assert_eq!((rows[0][1], rows[2][1]), ("0", "diffuse"));
    for row in rows {
        let sum: f64 = row[3..].iter().map(|field| field.parse::<f64>().unwrap()).sum();
        // Nine significant digits each.
        assert!((sum - 1.0).abs() < 2e-8, "{row:?}");
    }
}

#[test]
fn engines_agree() {
    let common = "spectrum --thickness 2 --wavelengths 500";
    let solved = numbers(stdout(common).lines().nth(1).unwrap());
    let sampled = stdout(&format!("{common} --engine montecarlo --rays 4000"));
    assert!(sampled.starts_with(
        "thickness_cm,angle_deg,wavelength_nm,reflectance,transmittance,absorptance,\
         reflectance_se,transmittance_se,absorptance_se\n"
    ));
    let sampled = numbers(sampled.lines().nth(1).unwrap());
    for quantity in 3..6 {
        assert!((sampled[quantity] - solved[quantity]).abs() < 4.0 * sampled[quantity + 3], "{sampled:?} {solved:?}");
    }
}

#[test]
fn color_of_no_snow_is_white_and_files_have_their_colour() {
    let text = stdout("color --thickness 0 --illuminant E");
    assert!(text.starts_with("thickness_cm,angle_deg,illuminant,X,Y,Z,L,a,b,r_linear,g_linear,b_linear,hex\n0,0,E,"));
    let luminance = |text: &str| text.lines().nth(1).unwrap().split(',').nth(4).unwrap().parse::<f64>().unwrap();
    assert!((luminance(&text) - 1.0).abs() < 1e-8);
    let folder = Folder::new();
    let rows: String = (400..=700).step_by(20).map(|nm| format!("{nm},0.5\n")).collect();
    folder.write("half.csv", format!("wavelength_nm,value\n{rows}"));
    assert!((luminance(&folder.stdout("color --spectrum half.csv")) - 0.5).abs() < 1e-8);
}

/// Without a command, the help precedes the error.
#[test]
fn a_command_is_required() {
    let output = snowblue("");
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{message}");
    assert_names(&message, &["Usage: snowblue", "spectrum"]);
    assert_names(message.lines().last().unwrap(), &["snowblue:", "command"]);
}

#[test]
fn a_table_that_ends_early_is_refused() {
    let folder = Folder::new();
    snowblue_data::embedded().write(&folder.path("cut.nc")).unwrap();
    let table = folder.bytes("cut.nc");
    folder.write("cut.nc", &table[..table.len() / 2]);
    folder.assert_refused("database info cut.nc", &["cut.nc"]);
    folder.assert_refused("render --scene block_30cm --integrator pcasnow -o a.png --database cut.nc", &["cut.nc"]);
}

#[test]
fn a_table_from_a_file_renders_a_picture() {
    let folder = Folder::new();
    let form = "--space linear --components 2 -o paper.nc";
    folder.stdout(&format!("database build --tally-rays 1024 --streams 8 --quiet {form}"));
    let words = ["24750 curves", "225", "2 components", "linear"];
    assert_names(&folder.stdout("database info paper.nc"), &words);
    let small = "--width 6 --height 6 --spp 1 --path view";
    folder.stdout(&format!("render --scene block_30cm --database paper.nc -o picture.exr {small}"));
    assert_eq!(folder.bytes("picture.exr")[..4], [0x76, 0x2f, 0x31, 0x01], "the magic number of OpenEXR");
    assert_eq!(folder.files().len(), 2, "no other file is left");
}

#[test]
fn metadata_of_csv_go_to_stderr() {
    let spectrum = "spectrum --wavelengths 500";
    assert_names(&stderr(spectrum), &["ice warren2008", "seed 1", env!("CARGO_PKG_VERSION")]);
    assert!(stderr(&format!("{spectrum} --quiet")).is_empty());
}
