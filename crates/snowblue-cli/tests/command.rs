//! Columns, exit codes, errors in one line and atomic output, over several commands.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use std::path::Path;

use shell::{assert_names, assert_refused, shipped_scene, snowblue, stderr, stdout};

/// The scene of the README with one change, in another folder.
fn changed_scene(folder: &Path, from: &str, to: &str) -> String {
    let scene = std::fs::read_to_string(shipped_scene("block_30cm.toml")).unwrap();
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
fn engines_agree() {
    let common = ["spectrum", "--thickness", "2", "--wavelengths", "500"];
    let numbers = |text: String| -> Vec<f64> {
        text.lines().nth(1).unwrap().split(',').map(|field| field.parse().unwrap()).collect()
    };
    let solved = numbers(stdout(&common));
    let sampled = stdout(&[&common[..], &["--engine", "montecarlo", "--rays", "4000"]].concat());
    assert!(sampled.starts_with(
        "thickness_cm,angle_deg,wavelength_nm,reflectance,transmittance,absorptance,\
         reflectance_se,transmittance_se,absorptance_se\n"
    ));
    let sampled = numbers(sampled);
    for quantity in 3..6 {
        assert!((sampled[quantity] - solved[quantity]).abs() < 4.0 * sampled[quantity + 3], "{sampled:?} {solved:?}");
    }
}

#[test]
fn color_of_no_snow_is_white_and_files_have_their_colour() {
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
        (&[450, 550, 650][..], ["half.csv:1:", "step", "450", "550 nm", "20 nm"]),
        (&[400, 420, 430, 450], ["half.csv:1:", "wavelengths", "400–450 nm", "cover", "400–700 nm"]),
        (&[500, 510, 520], ["half.csv:1:", "wavelengths", "500–520 nm", "cover", "400–700 nm"]),
    ] {
        std::fs::write(&path, rows(wavelengths)).unwrap();
        assert_refused(&["color", "--spectrum", path.to_str().unwrap()], &words);
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
    assert_refused(&["color", "--false-color", "1030,860"], &["--false-color", "1030,860", "nm"]);
    assert_refused(&["color", "--false-color", "2600,860,550"], &["wavelength", "2600 nm", "300–2500 nm"]);
    assert_refused(&["color", "--false-color", "--illuminant", "E"], &["--false-color", "--illuminant"]);
}

#[test]
fn bad_input_is_refused_in_one_line() {
    for (arguments, words) in [
        (&["spectrum", "--densty", "300"][..], &["'--densty'"][..]),
        (&["spectrum", "--density", "1200"], &["density", "1200 kg/m³", "10–900 kg/m³"]),
        (&["spectrum", "--grain-size", "60"], &["grain size", "70–4950 µm"]),
        (&["spectrum", "--streams", "7"], &["7", "even"]),
        (&["spectrum", "--wavelengths", "100"], &["wavelength", "100 nm", "300–2500 nm"]),
        (&["spectrum", "--thickness", "1e99"], &["thickness is 1e99 cm", "0–100000 cm"]),
        (&["spectrum", "--broadband", "blue"], &["'blue'", "solar, visible, near-infrared, par"]),
        (&["spectrum", "--plot", "plot.png"], &["plot.png", ".svg"]),
        (&["color", "--illuminant", "D66"], &["D66", "D65"]),
        (&["match", "#5fa8c4"], &["a colour is given as --target '#5fa8c4'"]),
        (&["match", "5fa8c4"], &["a colour is given as --target '#5fa8c4'"]),
        (&["match", "blue"], &["a colour is given as --target '#rrggbb'"]),
        (&["match", "#5fa8c4", "--thickness", "10"], &["a colour is given as --target '#5fa8c4'"]),
        (&["spectrum", "-o", "a.xlsx"], &["a.xlsx: the file must end in .csv, .json, .txt or .nc, or give --format"]),
        (&["color", "-o", "a.xlsx"], &["a.xlsx: the file must end in .csv, .json or .txt, or give --format"]),
        (&["slab", "--one-minus-omega", "2", "--g", "0", "--tau", "1"], &["--one-minus-omega", "2", "0–1"]),
        (&["database", "info", "no.nc"], &["no.nc"]),
        (&["render", "no.toml", "-o", "picture.png"], &["no.toml"]),
        (&["render", "no.toml", "-o", "picture.gif"], &["picture.gif", ".png", ".exr"]),
    ] {
        assert_refused(arguments, words);
    }
}

/// All options that take a number of a range refuse others in the same words.
#[test]
fn numbers_out_of_range_are_refused_in_the_same_words() {
    let picture = ["render", "--scene", "block_30cm", "-o", "never.png"];
    for (command, option, wrong, range) in [
        (&["spectrum"][..], "--threads", "0", "a whole number of 1–1024"),
        (&["spectrum"], "--seed", "-1", "a whole number of 0–18446744073709551615"),
        (&["spectrum"], "--seed", "99999999999999999999", "a whole number of 0–18446744073709551615"),
        (&["spectrum"], "--rays", "99999999999999999999", "a whole number of 2–1000000000000"),
        (&["bsdf"], "--rays", "1", "a whole number of 2–1000000000000"),
        (&["database", "fidelity"], "--components", "32", "a whole number of 1–31"),
        (&picture, "--spp", "1.5", "a whole number of 1–16777216"),
        (&picture, "--seed", "4294967296", "a whole number of 0–4294967295"),
        (&picture, "--noise-target", "1%", "a number of 0.0001–1"),
    ] {
        let expected = format!("invalid value '{wrong}' for '{option} <");
        assert_refused(&[command, &[option, wrong]].concat(), &[&expected, &format!(">': must be {range}\n")]);
    }
}

#[test]
fn an_unknown_option_has_no_misleading_tip() {
    let message = |option: &str| {
        let arguments = ["spectrum", option];
        assert_refused(&arguments, &[]);
        String::from_utf8(snowblue(&arguments).stderr).unwrap()
    };
    assert_eq!(message("--field"), "snowblue: unexpected argument '--field' found\n");
    let near = "snowblue: unexpected argument '--densty' found; a similar argument exists: '--density'\n";
    assert_eq!(message("--densty"), near);
}

/// Without a command, the help precedes the error.
#[test]
fn a_command_is_required() {
    let output = snowblue(&[]);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{message}");
    assert_names(&message, &["Usage: snowblue", "spectrum"]);
    assert_names(message.lines().last().unwrap(), &["snowblue:", "command"]);
}

#[test]
fn broken_scenes_meshes_and_tables_are_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let picture = at("picture.png");
    let typo = changed_scene(folder.path(), "facetness = 0.3", "facetnes = 0.3");
    assert_refused(&["render", &typo, "-o", &picture], &["scene.toml:", "facetnes"]);
    std::fs::write(at("latin1.toml"), b"[camera]\n# \xe9\n").unwrap();
    assert_refused(&["render", &at("latin1.toml"), "-o", &picture], &["latin1.toml:2: the line is not text (UTF-8)"]);
    assert_refused(&["spectrum", "--layers", &at("latin1.toml")], &["latin1.toml: is not text (UTF-8)"]);
    let missing = changed_scene(folder.path(), "shape = \"box\"\nsize = [0.6, 0.3, 0.6]", "mesh = \"none.ply\"");
    assert_refused(&["render", &missing, "-o", &picture], &["none.ply"]);
    std::fs::write(at("none.ply"), "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n").unwrap();
    assert_refused(&["render", &missing, "-o", &picture], &["none.ply"]);
    snowblue_data::embedded().write(Path::new(&at("cut.nc"))).unwrap();
    let table = std::fs::read(at("cut.nc")).unwrap();
    std::fs::write(at("cut.nc"), &table[..table.len() / 2]).unwrap();
    assert_refused(&["database", "info", &at("cut.nc")], &["cut.nc"]);
    let block = ["render", "--scene", "block_30cm", "--integrator", "pcasnow", "-o", &picture];
    assert_refused(&[&block[..], &["--database", &at("cut.nc")]].concat(), &["cut.nc"]);
    assert!(!Path::new(&picture).exists());
}

#[test]
fn a_table_from_a_file_renders_a_picture() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (table, picture) = (at("paper.nc"), at("picture.exr"));
    let build = ["database", "build", "--tally-rays", "1024", "--streams", "8", "--quiet"];
    stdout(&[&build[..], &["--space", "linear", "--components", "2", "-o", &table]].concat());
    assert_names(&stdout(&["database", "info", &table]), &["24750 curves", "225", "2 components", "linear"]);
    let scene = shipped_scene("block_30cm.toml");
    let scene = scene.to_str().unwrap();
    let small = ["--width", "24", "--height", "24", "--spp", "2", "--path", "view"];
    stdout(&[&["render", scene, "--database", &table, "-o", &picture][..], &small].concat());
    assert_eq!(std::fs::read(&picture).unwrap()[..4], [0x76, 0x2f, 0x31, 0x01], "the magic number of OpenEXR");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "no other file is left");
}

/// T and R, on the grid and between its values, at steep and grazing angles.
#[test]
fn look_ups_are_compared_with_direct_solutions() {
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
    assert_ne!(stdout(&[&judge[..], &["--seed", "2"]].concat()), text, "other points");
    assert_refused(&[&judge[..], &["--interpolation", "paper"]].concat(), &["small.nc"]);
    assert_refused(&["database", "fidelity", &table, "--seed", "2"], &["--seed"]);
}

#[test]
fn spread_has_rows_for_each_alternative() {
    let text = stdout(&["spectrum", "--spread", "--thickness", "30", "--wavelengths", "450"]);
    let rows: Vec<Vec<&str>> = text.lines().skip(1).map(|line| line.split(',').collect()).collect();
    assert!(text.starts_with("alternative,thickness_cm,angle_deg,wavelength_nm,"));
    assert_eq!((rows.len(), rows[0][0], rows[1][0]), (8, "as given", "ice picard2016"));
    let passed = |row: usize| rows[row][5].parse::<f64>().unwrap();
    assert!(passed(1) < 0.9 * passed(0), "Picard's ice is darker in the blue");
    assert!(passed(3) < passed(0) && passed(2) > passed(0), "facetness darkens");
}

#[test]
fn metadata_of_csv_go_to_stderr() {
    let spectrum = ["spectrum", "--wavelengths", "500"];
    assert_names(&stderr(&spectrum), &["ice warren2008", "seed 1", env!("CARGO_PKG_VERSION")]);
    assert!(stderr(&[&spectrum[..], &["--quiet"]].concat()).is_empty());
}
