//! Colours as users ask for them: transmitted and reflected, exposed, out of files, and snow for a wanted one.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use shell::{refused, snowblue, stdout};

/// Rows of CSV by field, without the header.
fn rows(text: &str) -> Vec<Vec<String>> {
    text.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn number(row: &[String], column: usize) -> f64 {
    row[column].parse().unwrap()
}

const LUMINANCE: usize = 4;

#[test]
fn reflected_light_is_what_does_not_come_through() {
    let transmitted = rows(&stdout(&["color", "--thickness", "0,5,50"]));
    let reflected = rows(&stdout(&["color", "--thickness", "0,5,50", "--reflected"]));
    assert!(number(&reflected[0], LUMINANCE).abs() < 1e-12, "nothing sends no light back");
    for (passed, sent) in transmitted.iter().zip(&reflected) {
        let sum = number(passed, LUMINANCE) + number(sent, LUMINANCE);
        assert!(sum <= 1.0 + 1e-8 && sum > 0.93, "clean snow absorbs little: {sum}");
    }
    let told = String::from_utf8(snowblue(&["color", "--reflected"]).stderr).unwrap();
    assert!(told.contains("light reflected"), "{told}");
}

#[test]
fn exposure_changes_hex_alone() {
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
    let message = refused(&["color", "--exposure", "bright"]);
    assert!(message.contains("neither stops nor 'auto'"), "{message}");
    assert!(refused(&["color", "--exposure", "101"]).contains("must lie in -100 to 100 stops"));
}

#[test]
fn spectra_of_a_file_have_the_colours_of_their_snow() {
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
    let wrong = |change: &dyn Fn(&str) -> String| {
        let broken = at("broken.csv");
        std::fs::write(&broken, change(&text)).unwrap();
        refused(&["color", "--spectrum", &broken])
    };
    let line = |number: usize| text.lines().nth(number - 1).unwrap();
    assert!(wrong(&|text| text.replace(line(40), "2,diffuse,480,blue")).contains("broken.csv:40: expected 6 fields"));
    assert!(
        wrong(&|text| text.replace(line(40), "2,diffuse,480,0.9,blue,0"))
            .contains("broken.csv:40: expected a wavelength")
    );
    let gap = wrong(&|text| text.replace(&format!("{}\n{}\n", line(40), line(41)), ""));
    assert!(
        gap.contains("broken.csv:33: 490 nm follows 460 nm, but steps within 400–700 nm must be at most 20 nm"),
        "{gap}"
    );
    assert!(wrong(&|text| text.replacen("transmittance", "passed", 1)).contains("broken.csv:1: expected the columns"));
    assert!(wrong(&|_| "wavelength_nm,value\n".to_owned()).contains("broken.csv: holds no spectrum"));
}

/// What lies beyond 400–700 nm does not count; steps that are not equal, or miss an end, are filled on straight lines.
#[test]
fn spectra_of_any_reach_and_steps_are_summed() {
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
    // A straight line is found again whatever its steps; the cells have nine digits.
    for same in [every(300, 900, 10), every(397, 717, 20), [every(400, 500, 4), every(510, 710, 20)].concat()] {
        assert!((luminance(&same) / tens - 1.0).abs() < 1e-8, "{same:?}");
    }
    let short = every(410, 700, 10);
    std::fs::write(&file, short.iter().map(|nm| format!("{nm},1\n")).collect::<String>()).unwrap();
    let message = refused(&["color", "--spectrum", file.to_str().unwrap()]);
    assert!(message.contains("any.csv:1: the wavelengths are 410–700 nm, but must cover 400–700 nm"), "{message}");
}

const THICKNESS: usize = 2;
const DELTA_E: usize = 5;

#[test]
fn match_finds_snow_whose_colour_is_what_it_says() {
    let text = stdout(&["match", "--target", "#5fa8c4"]);
    assert!(text.starts_with(
        "grain_size_um,density_kg_m3,thickness_cm,angle_deg,illuminant,delta_e,delta_e_2000,within_reach,Y,exposure_stops,hex,hex_transmitted\n"
    ));
    let family = rows(&text);
    assert_eq!((family.len(), family[0][0].as_str(), family[0][1].as_str()), (5, "400", "300"));
    for row in &family {
        assert_eq!(row[7], "yes", "{row:?}");
        let common = ["--grain-size", &row[0], "--density", &row[1], "--thickness", &row[THICKNESS]];
        let color = rows(&stdout(&[&["color"][..], &common].concat()));
        // The tally of grains is another one only in how far its absorption reaches.
        assert!((number(&color[0], LUMINANCE) / number(row, 8) - 1.0).abs() < 1e-4, "{row:?} {color:?}");
        assert_eq!(color[0][12], row[11]);
        let exposed = rows(&stdout(&[&["color", "--exposure", &row[9]][..], &common].concat()));
        assert_eq!(exposed[0][12], row[10]);
    }
    assert_eq!(stdout(&["match", "--target", "#5fa8c4", "--threads", "1"]), text);
}

#[test]
fn match_takes_what_is_given() {
    let given = ["--grain-size", "250", "--density", "200", "--thickness", "5:60", "--angle", "diffuse"];
    let found = rows(&stdout(&[&["match", "--target", "#5fa8c4", "--illuminant", "D55"][..], &given].concat()));
    assert_eq!((found.len(), &found[0][0], &found[0][1]), (1, &"250".to_owned(), &"200".to_owned()));
    assert!((5.0..60.0).contains(&number(&found[0], THICKNESS)));
    let fixed = rows(&stdout(&["match", "--target", "#7fb5c8", "--thickness", "10"]));
    assert!(fixed.iter().all(|row| row[THICKNESS] == "10") && number(&fixed[0], DELTA_E) < 2.3, "{fixed:?}");
}

#[test]
fn match_says_what_is_out_of_reach() {
    let output = snowblue(&["match", "--target", "#30a040"]);
    assert_eq!(output.status.code(), Some(0));
    let found = rows(&String::from_utf8(output.stdout).unwrap());
    assert!(found.iter().all(|row| row[7] == "no"), "{found:?}");
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(told.contains("#30a040 is out of reach: it is greener than the nearest light, ΔE*ab"), "{told}");
    let fixed =
        snowblue(&["match", "--target", "#5fa8c4", "--thickness", "1", "--grain-size", "400", "--density", "300"]);
    let told = String::from_utf8(fixed.stderr).unwrap();
    assert!(told.contains("is out of reach with what is given: it is more saturated than the nearest light"), "{told}");
    // Dark targets are compared at L* = 50 too, where a red is no blue.
    let dark = rows(&stdout(&["match", "--target", "#050000"]));
    assert!(dark.iter().all(|row| row[7] == "no" && number(row, DELTA_E) > 50.0), "{dark:?}");
    assert_eq!(rows(&stdout(&["match", "--target", "#ffffff"])).len(), 1, "no snow is the same whatever its grains");
    let message = refused(&["match", "--target", "#5fa8c4", "--thickness", "50000:100000"]);
    assert!(message.contains("no light that an eye could see comes through"), "{message}");
    let message = refused(&["match", "--target", "#000000"]);
    assert!(message.contains("--target #000000: the target is black"), "{message}");
    for (wrong, words) in [
        (&["--target", "blue"][..], "must be `#` and six hexadecimal digits"),
        (&["--target", "#5fa8c4", "--thickness", "30:5"], "must ascend"),
        (&["--target", "#5fa8c4", "--angle", "90"], "must lie in 0–89.99°"),
        (&["--target", "#5fa8c4", "--density", "1200"], "must lie in 10–900 kg/m³"),
        (&[], "--target"),
    ] {
        let message = refused(&[&["match"], wrong].concat());
        assert!(message.contains(words), "{message}");
    }
}
