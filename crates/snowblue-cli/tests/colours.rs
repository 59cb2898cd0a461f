//! `snowblue color` and `snowblue match`.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use shell::{assert_names, assert_refused, stderr, stdout};

/// Rows of CSV by field, without the header.
fn rows(text: &str) -> Vec<Vec<String>> {
    text.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn number(row: &[String], column: usize) -> f64 {
    row[column].parse().unwrap()
}

const LUMINANCE: usize = 4;

#[test]
fn clean_snow_reflects_what_it_does_not_transmit() {
    let transmitted = rows(&stdout(&["color", "--thickness", "0,5,50"]));
    let reflected = rows(&stdout(&["color", "--thickness", "0,5,50", "--reflected"]));
    assert!(number(&reflected[0], LUMINANCE).abs() < 1e-12, "no snow reflects no light");
    for (passed, sent) in transmitted.iter().zip(&reflected) {
        let sum = number(passed, LUMINANCE) + number(sent, LUMINANCE);
        assert!(sum <= 1.0 + 1e-8 && sum > 0.93, "clean snow absorbs little: {sum}");
    }
    assert_names(&stderr(&["color", "--reflected"]), &["light reflected"]);
}

#[test]
fn exposure_changes_only_hex() {
    let plain = rows(&stdout(&["color", "--thickness", "5,15"]));
    for exposure in ["auto", "5.5", "-1"] {
        let exposed = rows(&stdout(&["color", "--thickness", "5,15", "--exposure", exposure]));
        for (one, other) in plain.iter().zip(&exposed) {
            assert_eq!(one[..12], other[..12]);
            assert_ne!(one[12], other[12]);
        }
    }
    let brightest = |row: &[String]| u8::from_str_radix(&row[12][5..], 16).unwrap();
    let auto = rows(&stdout(&["color", "--thickness", "5,15", "--exposure", "auto"]));
    // 0.9 encoded: 1.055 · 0.9^(1/2.4) − 0.055 = 0.955, of 255.
    assert_eq!(brightest(&auto[0]), 243);
    assert!(brightest(&auto[1]) < 200, "one exposure for all");
    assert_refused(&["color", "--exposure", "bright"], &["--exposure", "'bright'", "stops", "'auto'"]);
    assert_refused(&["color", "--thickness", "5,inf"], &["thickness is inf cm", "--reflected"]);
    assert_eq!(stdout(&["color", "--thickness", "inf", "--reflected"]).lines().count(), 2);
    assert_refused(&["color", "--exposure", "101"], &["exposure", "101", "-100 to 100 stops"]);
}

#[test]
fn spectra_from_a_file_have_the_colours_of_their_snow() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let file = at("snow.csv");
    let slab = ["--thickness", "2,15", "--angle", "0,diffuse"];
    stdout(&[&["spectrum", "-o", &file][..], &slab].concat());
    for quantity in [&[][..], &["--reflected"]] {
        let read = rows(&stdout(&[&["color", "--spectrum", &file][..], quantity].concat()));
        let solved = rows(&stdout(&[&["color"][..], &slab, quantity].concat()));
        assert_eq!(read.len(), 4);
        for (read, solved) in read.iter().zip(&solved) {
            assert_eq!((&read[..3], &read[12]), (&solved[..3], &solved[12]));
            // The file has nine digits.
            assert!((number(read, LUMINANCE) / number(solved, LUMINANCE) - 1.0).abs() < 1e-8);
        }
    }
    let text = std::fs::read_to_string(&file).unwrap();
    let refused = |changed: &str, words: &[&str]| {
        let broken = at("broken.csv");
        std::fs::write(&broken, changed).unwrap();
        assert_refused(&["color", "--spectrum", &broken], words);
    };
    let line = |number: usize| text.lines().nth(number - 1).unwrap();
    refused(&text.replace(line(40), "2,diffuse,480,blue"), &["broken.csv:40:", "6", "4"]);
    refused(&text.replace(line(40), "2,diffuse,480,0.9,blue,0"), &["broken.csv:40:", "blue"]);
    let gap = text.replace(&format!("{}\n{}\n", line(40), line(41)), "");
    refused(&gap, &["broken.csv:33:", "step", "460", "490 nm", "20 nm"]);
    refused(&text.replacen("transmittance", "passed", 1), &["broken.csv:1:", "wavelength_nm", "transmittance"]);
    refused("# measured\n400;0.5\n", &["broken.csv:2: expected a wavelength", "400;0.5", "this line has semicolons"]);
    refused("400,0.5\n410,0,5\n", &["broken.csv:2:", "decimals have a point, but this line has more commas"]);
    refused("wavelength_nm,value\n", &["broken.csv:", "spectrum"]);
}

/// Values outside 400–700 nm are ignored; unequal steps, or steps that miss an end, are interpolated linearly.
#[test]
fn spectra_of_any_range_and_steps_are_summed() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("any.csv");
    let luminance = |wavelengths_nm: &[f64]| {
        let line = |nm: &f64| format!("{nm},{}\n", 0.001 * nm);
        std::fs::write(&file, wavelengths_nm.iter().map(line).collect::<String>()).unwrap();
        number(&rows(&stdout(&["color", "--spectrum", file.to_str().unwrap()]))[0], LUMINANCE)
    };
    let every =
        |first: u32, last: u32, step: usize| -> Vec<f64> { (first..=last).step_by(step).map(f64::from).collect() };
    let tens = luminance(&every(400, 700, 10));
    // Linear interpolation reproduces a straight line from any steps; cells have nine digits.
    for same in [every(300, 900, 10), every(397, 717, 20), [every(400, 500, 4), every(510, 710, 20)].concat()] {
        assert!((luminance(&same) / tens - 1.0).abs() < 1e-8, "{same:?}");
    }
    let short = every(410, 700, 10);
    std::fs::write(&file, short.iter().map(|nm| format!("{nm},1\n")).collect::<String>()).unwrap();
    let words = ["any.csv:1:", "wavelengths", "410–700 nm", "400–700 nm"];
    assert_refused(&["color", "--spectrum", file.to_str().unwrap()], &words);
}

#[test]
fn a_constant_spectrum_has_the_colour_of_the_light_at_any_step() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("grey.csv");
    let white = rows(&stdout(&["color", "--thickness", "0", "--exposure", "-1"]));
    for step in [1, 5, 10, 12, 15, 20] {
        let text: String = (400..=719).step_by(step).map(|nm| format!("{nm},1\n")).collect();
        std::fs::write(&file, text).unwrap();
        let grey = rows(&stdout(&["color", "--spectrum", file.to_str().unwrap(), "--exposure", "-1"]));
        assert_eq!(grey[0][3..], white[0][3..], "{step} nm");
    }
}

const THICKNESS: usize = 2;
const DELTA_E: usize = 5;

#[test]
fn match_finds_snow_of_the_printed_colour() {
    let text = stdout(&["match", "--target", "#5fa8c4"]);
    assert!(text.starts_with(
        "grain_size_um,density_kg_m3,thickness_cm,angle_deg,illuminant,delta_e,delta_e_2000,within_reach,Y,\
         exposure_stops,hex,hex_transmitted\n"
    ));
    let family = rows(&text);
    assert_eq!((family.len(), family[0][0].as_str(), family[0][1].as_str()), (5, "400", "300"));
    for row in &family {
        assert_eq!(row[7], "yes", "{row:?}");
        let common = ["--grain-size", &row[0], "--density", &row[1], "--thickness", &row[THICKNESS]];
        let color = rows(&stdout(&[&["color"][..], &common].concat()));
        // The scattering tallies differ only in their range of absorption.
        assert!((number(&color[0], LUMINANCE) / number(row, 8) - 1.0).abs() < 1e-4, "{row:?} {color:?}");
        assert_eq!(color[0][12], row[11]);
        let exposed = rows(&stdout(&[&["color", "--exposure", &row[9]][..], &common].concat()));
        assert_eq!(exposed[0][12], row[10]);
    }
    assert_eq!(stdout(&["match", "--target", "#5fa8c4", "--threads", "1"]), text);
}

#[test]
fn match_keeps_given_quantities() {
    let given = ["--grain-size", "250", "--density", "200", "--thickness", "5:60", "--angle", "diffuse"];
    let found = rows(&stdout(&[&["match", "--target", "#5fa8c4", "--illuminant", "D55"][..], &given].concat()));
    assert_eq!((found.len(), &found[0][0], &found[0][1]), (1, &"250".to_owned(), &"200".to_owned()));
    assert!((5.0..60.0).contains(&number(&found[0], THICKNESS)));
    let fixed = rows(&stdout(&["match", "--target", "#7fb5c8", "--thickness", "10"]));
    assert!(fixed.iter().all(|row| row[THICKNESS] == "10") && number(&fixed[0], DELTA_E) < 2.3, "{fixed:?}");
}

#[test]
fn match_reports_targets_out_of_reach() {
    let green = ["match", "--target", "#30a040"];
    let found = rows(&stdout(&green));
    assert!(found.iter().all(|row| row[7] == "no"), "{found:?}");
    assert_names(&stderr(&green), &["#30a040", "greener", "ΔE*ab"]);
    let fixed = ["match", "--target", "#5fa8c4", "--thickness", "1", "--grain-size", "400", "--density", "300"];
    assert_names(&stderr(&fixed), &["#5fa8c4", "given options", "more saturated"]);
    // Dark targets are also compared at L* = 50, where red is far from blue.
    let dark = rows(&stdout(&["match", "--target", "#050000"]));
    assert!(dark.iter().all(|row| row[7] == "no" && number(row, DELTA_E) > 50.0), "{dark:?}");
    let white = rows(&stdout(&["match", "--target", "#ffffff"]));
    assert_eq!(white.len(), 1, "without snow the grains do not matter");
}

#[test]
fn match_refuses_impossible_targets_and_snow() {
    for (arguments, words) in [
        (&["--target", "#5fa8c4", "--thickness", "50000:100000"][..], &["100000 cm", "luminance"][..]),
        (&["--target", "#000000"], &["--target", "#000000", "black"]),
        (&["--target", "blue"], &["--target", "blue", "hexadecimal"]),
        (&["--target", "#5fa8c4", "--thickness", "30:5"], &["--thickness", "30", "5", "ascend"]),
        (&["--target", "#5fa8c4", "--angle", "90"], &["angle", "90°", "0–89.99°"]),
        (&["--target", "#5fa8c4", "--density", "1200"], &["density", "1200 kg/m³", "10–900 kg/m³"]),
        (&[], &["--target"]),
    ] {
        assert_refused(&[&["match"], arguments].concat(), words);
    }
}
