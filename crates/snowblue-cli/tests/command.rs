//! The command as users meet it: columns, exit codes, one clear line for bad input, nothing half-written.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use std::path::Path;

use shell::{refused, snowblue, stdout};

/// The scene of the README, in a folder of its own with one thing changed.
fn changed_scene(folder: &Path, from: &str, to: &str) -> String {
    let scene = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/block_30cm.toml")).unwrap();
    assert!(scene.contains(from), "the scene has no '{from}'");
    let path = folder.join("scene.toml");
    std::fs::write(&path, scene.replacen(from, to, 1)).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn slab_prints_van_de_hulsts_numbers() {
    let text = stdout(&["slab", "--one-minus-omega", "0.1", "--g", "0.75", "--tau", "2", "--mu0", "1"]);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "reflectance,transmittance,direct");
    let values: Vec<f64> = lines[1].split(',').map(|field| field.parse().unwrap()).collect();
    assert!((values[0] - 0.09739).abs() < 5e-6 && (values[1] - 0.66096).abs() < 5e-6, "{text}");
}

#[test]
fn spectrum_has_its_columns_and_adds_up() {
    let text = stdout(&["spectrum", "--thickness", "1,15", "--angle", "0,diffuse", "--wavelengths", "450,700"]);
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
fn engines_print_the_same_figures() {
    let common = ["spectrum", "--thickness", "2", "--wavelengths", "500"];
    let numbers = |text: String| -> Vec<f64> {
        text.lines().nth(1).unwrap().split(',').map(|field| field.parse().unwrap()).collect()
    };
    let solved = numbers(stdout(&common));
    let walked = stdout(&[&common[..], &["--engine", "montecarlo", "--rays", "4000"]].concat());
    assert!(walked.starts_with(
        "thickness_cm,angle_deg,wavelength_nm,reflectance,transmittance,absorptance,\
         reflectance_se,transmittance_se,absorptance_se\n"
    ));
    let walked = numbers(walked);
    for quantity in 3..6 {
        assert!((walked[quantity] - solved[quantity]).abs() < 4.0 * walked[quantity + 3], "{walked:?} {solved:?}");
    }
}

#[test]
fn color_of_nothing_is_white_and_of_a_file_is_its_own() {
    let text = stdout(&["color", "--thickness", "0", "--illuminant", "E"]);
    assert!(text.starts_with("thickness_cm,angle_deg,illuminant,X,Y,Z,L,a,b,r_linear,g_linear,b_linear,hex\n0,0,E,"));
    let luminance: f64 = text.lines().nth(1).unwrap().split(',').nth(4).unwrap().parse().unwrap();
    assert!((luminance - 1.0).abs() < 1e-8);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("half.csv");
    let rows = |wavelengths: &[u32]| wavelengths.iter().map(|nm| format!("{nm},0.5\n")).collect::<String>();
    let close: Vec<u32> = (400..=700).step_by(20).collect();
    std::fs::write(&path, format!("wavelength_nm,value\n{}", rows(&close))).unwrap();
    let text = stdout(&["color", "--spectrum", path.to_str().unwrap()]);
    let half: f64 = text.lines().nth(1).unwrap().split(',').nth(4).unwrap().parse().unwrap();
    assert!((half - 0.5).abs() < 1e-8);
    for (wavelengths, words) in [
        (&[450, 550, 650][..], "half.csv:1: 550 nm follows 450 nm, but steps within 400–700 nm must be at most 20 nm"),
        (&[400, 420, 430, 450], "are 400–450 nm, but must cover 400–700 nm"),
        (&[500, 510, 520], "are 500–520 nm, but must cover 400–700 nm"),
    ] {
        std::fs::write(&path, rows(wavelengths)).unwrap();
        let message = refused(&["color", "--spectrum", path.to_str().unwrap()]);
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn false_colours_are_transmittances() {
    let text = stdout(&["color", "--thickness", "0,1", "--false-color", "--format", "csv"]);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[..2], ["thickness_cm,angle_deg,r_linear,g_linear,b_linear,hex", "0,0,1,1,1,#ffffff"]);
    let common = ["--thickness", "1", "--seed", "3"];
    let false_color = stdout(&[&["color", "--false-color", "1030,860,550"][..], &common].concat());
    let spectrum = stdout(&[&["spectrum", "--wavelengths", "1030,860,550"][..], &common].concat());
    let colours: Vec<&str> = false_color.lines().nth(1).unwrap().split(',').skip(2).take(3).collect();
    let transmittances: Vec<&str> = spectrum.lines().skip(1).map(|line| line.split(',').nth(4).unwrap()).collect();
    assert_eq!(colours, transmittances);
    assert!(refused(&["color", "--false-color", "1030,860"]).contains("three wavelengths"));
    assert!(refused(&["color", "--false-color", "2600,860,550"]).contains("wavelength is 2600 nm"));
    assert!(refused(&["color", "--false-color", "--illuminant", "E"]).contains("cannot be used with"));
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/block_30cm.toml");
    let message = refused(&["render", scene, "-o", "never.png", "--false-color"]);
    assert!(message.contains("false colour at 1030 nm, but the table holds 400–700 nm"), "{message}");
}

#[test]
fn bad_input_gets_one_clear_line() {
    assert!(refused(&["spectrum", "--densty", "300"]).contains("'--densty'"));
    assert!(
        refused(&["spectrum", "--density", "1200"]).contains("density is 1200 kg/m³, but must lie in 10–900 kg/m³")
    );
    assert!(refused(&["spectrum", "--grain-size", "60"]).contains("below 20 µm"));
    assert!(refused(&["spectrum", "--streams", "7"]).contains("even"));
    assert!(refused(&["spectrum", "--wavelengths", "100"]).contains("300–2500 nm"));
    assert!(refused(&["color", "--illuminant", "D66"]).contains("D65"));
    assert!(refused(&["slab", "--one-minus-omega", "2", "--g", "0", "--tau", "1"]).contains("0–1"));
    assert!(refused(&["database", "info", "no.nc"]).contains("no.nc: cannot be read"));
    assert!(refused(&["render", "no.toml", "-o", "picture.png"]).contains("no.toml"));
    assert!(refused(&["render", "no.toml", "-o", "picture.gif"]).contains(".png or .exr"));
}

#[test]
fn broken_scenes_meshes_and_tables_get_one_clear_line() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let picture = at("picture.png");
    let typo = changed_scene(folder.path(), "facetness = 0.3", "facetnes = 0.3");
    assert!(refused(&["render", &typo, "-o", &picture]).contains("scene.toml:"));
    let missing = changed_scene(folder.path(), "shape = \"box\"\nsize = [0.6, 0.3, 0.6]", "mesh = \"none.ply\"");
    assert!(refused(&["render", &missing, "-o", &picture]).contains("none.ply"));
    std::fs::write(at("none.ply"), "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n").unwrap();
    assert!(refused(&["render", &missing, "-o", &picture]).contains("none.ply"));
    let table = include_bytes!("../../snowblue-data/data/snow.nc");
    std::fs::write(at("cut.nc"), &table[..table.len() / 2]).unwrap();
    assert!(refused(&["database", "info", &at("cut.nc")]).contains("cut.nc"));
    assert!(refused(&["render", &typo, "--database", &at("cut.nc"), "-o", &picture]).contains("cut.nc"));
    assert!(!Path::new(&picture).exists());
}

#[test]
fn a_table_goes_through_its_file_into_a_picture() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (table, picture) = (at("paper.nc"), at("picture.exr"));
    let build = ["database", "build", "--tally-rays", "1024", "--streams", "8", "--quiet"];
    stdout(&[&build[..], &["--space", "linear", "--components", "2", "-o", &table]].concat());
    assert!(
        stdout(&["database", "info", &table])
            .contains("24750 curves of 225 kinds of snow, 2 components in linear space")
    );
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/block_30cm.toml");
    let small = ["--width", "24", "--height", "24", "--spp", "2", "--path", "view"];
    stdout(&[&["render", scene, "--database", &table, "-o", &picture][..], &small].concat());
    assert_eq!(std::fs::read(&picture).unwrap()[..4], [0x76, 0x2f, 0x31, 0x01], "the magic number of OpenEXR");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "nothing is left beside the files");
}

/// T and R, on the grid and between its values, at steep and grazing angles.
#[test]
fn look_ups_are_judged_between_the_values_of_a_table() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("small.nc").to_str().unwrap().to_owned();
    let snow = ["--grain-size", "200,300,400,500", "--facetness", "0.3", "--preset", "default", "--tally-rays", "1024"];
    let form = ["--space", "log", "--components", "6", "--quiet", "-o", &table];
    stdout(&[&["database", "build"][..], &snow, &form].concat());
    let judge = ["database", "fidelity", "--off-grid", "5", &table];
    let text = stdout(&judge);
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    let samples = rows.iter().position(|row| row[0] == "quantity").unwrap();
    let between = rows[samples + 1..].iter().filter(|row| row[1] == "log" && row[3] == "between").count();
    assert_eq!((rows.len() - samples - 1, between), (8, 4), "{text}");
    assert_ne!(stdout(&[&judge[..], &["--seed", "2"]].concat()), text, "other places");
    assert!(refused(&[&judge[..], &["--interpolation", "paper"]].concat()).contains("small.nc"));
    assert!(refused(&["database", "fidelity", &table, "--seed", "2"]).contains("--seed"));
}

#[test]
fn spread_names_its_alternatives() {
    let text = stdout(&["spectrum", "--spread", "--thickness", "30", "--wavelengths", "450"]);
    let rows: Vec<Vec<&str>> = text.lines().skip(1).map(|line| line.split(',').collect()).collect();
    assert!(text.starts_with("alternative,thickness_cm,angle_deg,wavelength_nm,"));
    assert_eq!((rows.len(), rows[0][0], rows[1][0]), (8, "as given", "ice picard2016"));
    let passed = |row: usize| rows[row][5].parse::<f64>().unwrap();
    assert!(passed(1) < 0.9 * passed(0), "Picard's ice is darker in the blue");
    assert!(passed(3) < passed(0) && passed(2) > passed(0), "facetness darkens");
}

#[test]
fn csv_tells_what_made_it_on_stderr() {
    let run = |quiet: &[&str]| snowblue(&[&["spectrum", "--wavelengths", "500"][..], quiet].concat());
    let told = String::from_utf8(run(&[]).stderr).unwrap();
    assert!(told.contains("ice warren2008") && told.contains("seed 1") && told.contains(env!("CARGO_PKG_VERSION")));
    assert!(run(&["--quiet"]).stderr.is_empty());
}
