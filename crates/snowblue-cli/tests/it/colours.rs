//! `snowblue color` and `snowblue match`.

use crate::shell::{Folder, assert_names, snowblue, stderr, stdout};

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
    let transmitted = rows(&stdout("color --thickness 0,5,50"));
    let reflected = rows(&stdout("color --thickness 0,5,50 --reflected"));
    assert!(number(&reflected[0], LUMINANCE).abs() < 1e-12, "no snow reflects no light");
    for (passed, sent) in transmitted.iter().zip(&reflected) {
        let sum = number(passed, LUMINANCE) + number(sent, LUMINANCE);
        assert!(sum <= 1.0 + 1e-8 && sum > 0.93, "clean snow absorbs little: {sum}");
    }
    assert_names(&stderr("color --reflected"), &["light reflected"]);
}

#[test]
fn exposure_changes_only_hex() {
    let color = |exposure: &str| rows(&stdout(&format!("color --thickness 5,15 {exposure}")));
    let plain = color("");
    let [auto, ..] = ["auto", "5.5", "-1"].map(|exposure| {
        let exposed = color(&format!("--exposure {exposure}"));
        for (one, other) in plain.iter().zip(&exposed) {
            assert_eq!(one[..12], other[..12]);
            assert_ne!(one[12], other[12]);
        }
        exposed
    });
    let brightest = |row: &[String]| u8::from_str_radix(&row[12][5..], 16).unwrap();
    // 0.9 encoded: 1.055 · 0.9^(1/2.4) − 0.055 = 0.955, of 255.
    assert_eq!(brightest(&auto[0]), 243);
    assert!(brightest(&auto[1]) < 200, "one exposure for all");
    assert_eq!(stdout("color --thickness inf --reflected").lines().count(), 2);
}

#[test]
fn spectra_from_a_file_have_the_colours_of_their_snow() {
    let folder = Folder::new();
    let slab = "--thickness 2,15 --angle 0,diffuse";
    folder.stdout(&format!("spectrum -o snow.csv {slab}"));
    for quantity in ["", "--reflected"] {
        let read = rows(&folder.stdout(&format!("color --spectrum snow.csv {quantity}")));
        let solved = rows(&stdout(&format!("color {slab} {quantity}")));
        assert_eq!(read.len(), 4);
        for (read, solved) in read.iter().zip(&solved) {
            assert_eq!((&read[..3], &read[12]), (&solved[..3], &solved[12]));
            // The file has nine digits.
            assert!((number(read, LUMINANCE) / number(solved, LUMINANCE) - 1.0).abs() < 1e-8);
        }
    }
    let text = folder.text("snow.csv");
    let line = |number: usize| text.lines().nth(number - 1).unwrap();
    let gap = text.replace(&format!("{}\n{}\n", line(40), line(41)), "");
    for (changed, words) in [
        (text.replace(line(40), "2,diffuse,480,blue"), &["broken.csv:40:", "6", "4"][..]),
        (text.replace(line(40), "2,diffuse,480,0.9,blue,0"), &["broken.csv:40:", "blue"]),
        (gap, &["broken.csv:33:", "step", "460", "490 nm", "20 nm"]),
        (text.replacen("transmittance", "passed", 1), &["broken.csv:1:", "wavelength_nm", "transmittance"]),
    ] {
        folder.write("broken.csv", changed);
        folder.assert_refused("color --spectrum broken.csv", words);
    }
}

/// Values outside 400–700 nm are ignored; unequal steps, or steps that miss an end, are interpolated linearly.
#[test]
fn spectra_of_any_range_and_steps_are_summed() {
    let folder = Folder::new();
    let luminance = |wavelengths_nm: &[f64]| {
        let line = |nm: &f64| format!("{nm},{}\n", 0.001 * nm);
        folder.write("any.csv", wavelengths_nm.iter().map(line).collect::<String>());
        number(&rows(&folder.stdout("color --spectrum any.csv"))[0], LUMINANCE)
    };
    let every =
        |first: u32, last: u32, step: usize| -> Vec<f64> { (first..=last).step_by(step).map(f64::from).collect() };
    let tens = luminance(&every(400, 700, 10));
    // Linear interpolation reproduces a straight line from any steps; cells have nine digits.
    for same in [every(300, 900, 10), every(397, 717, 20), [every(400, 500, 4), every(510, 710, 20)].concat()] {
        assert!((luminance(&same) / tens - 1.0).abs() < 1e-8, "{same:?}");
    }
    folder.write("any.csv", every(410, 700, 10).iter().map(|nm| format!("{nm},1\n")).collect::<String>());
    folder.assert_refused("color --spectrum any.csv", &["any.csv:1:", "wavelengths", "410–700 nm", "400–700 nm"]);
}

#[test]
fn a_constant_spectrum_has_the_colour_of_the_light_at_any_step() {
    let folder = Folder::new();
    let white = rows(&stdout("color --thickness 0 --exposure -1"));
    for step in [1, 5, 10, 12, 15, 20] {
        folder.write("grey.csv", (400..=719).step_by(step).map(|nm| format!("{nm},1\n")).collect::<String>());
        let grey = rows(&folder.stdout("color --spectrum grey.csv --exposure -1"));
        assert_eq!(grey[0][3..], white[0][3..], "{step} nm");
    }
}

const THICKNESS: usize = 2;
const DELTA_E: usize = 5;

#[test]
fn match_finds_snow_of_the_printed_colour() {
    let text = stdout("match --target #5fa8c4");
    assert!(text.starts_with(
        "grain_size_um,density_kg_m3,thickness_cm,angle_deg,illuminant,delta_e,delta_e_2000,within_reach,Y,\
         exposure_stops,hex,hex_transmitted\n"
    ));
    let family = rows(&text);
    assert_eq!((family.len(), family[0][0].as_str(), family[0][1].as_str()), (5, "400", "300"));
    for (number_of_row, row) in family.iter().enumerate() {
        assert_eq!(row[7], "yes", "{row:?}");
        let common = format!("color --grain-size {} --density {} --thickness {}", row[0], row[1], row[THICKNESS]);
        let exposed = rows(&stdout(&format!("{common} --exposure {}", row[9])));
        // The scattering tallies differ only in their range of absorption.
        assert!((number(&exposed[0], LUMINANCE) / number(row, 8) - 1.0).abs() < 1e-4, "{row:?} {exposed:?}");
        assert_eq!(exposed[0][12], row[10]);
        if number_of_row == 0 {
            assert_eq!(rows(&stdout(&common))[0][12], row[11]);
        }
    }
}

#[test]
fn match_keeps_given_quantities() {
    let given = "--grain-size 250 --density 200 --thickness 5:60 --angle diffuse";
    let found = rows(&stdout(&format!("match --target #5fa8c4 --illuminant D55 {given}")));
    assert_eq!((found.len(), &found[0][0], &found[0][1]), (1, &"250".to_owned(), &"200".to_owned()));
    assert!((5.0..60.0).contains(&number(&found[0], THICKNESS)));
    let ten = "match --target #7fb5c8 --thickness 10";
    let text = stdout(ten);
    assert_eq!(stdout(&format!("{ten} --threads 1")), text);
    let fixed = rows(&text);
    assert!(fixed.iter().all(|row| row[THICKNESS] == "10") && number(&fixed[0], DELTA_E) < 2.3, "{fixed:?}");
}

#[test]
fn match_reports_targets_out_of_reach() {
    let output = snowblue("match --target #30a040");
    let [found, message] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    let found = rows(&found);
    assert!(!found.is_empty() && found.iter().all(|row| row[7] == "no"), "{found:?}");
    assert_names(&message, &["#30a040", "greener", "ΔE*ab"]);
    let fixed = "match --target #5fa8c4 --thickness 1 --grain-size 400 --density 300";
    assert_names(&stderr(fixed), &["#5fa8c4", "given options", "more saturated"]);
    // Dark targets are also compared at L* = 50, where red is far from blue.
    let dark = rows(&stdout("match --target #050000"));
    assert!(dark.iter().all(|row| row[7] == "no" && number(row, DELTA_E) > 50.0), "{dark:?}");
    let white = rows(&stdout("match --target #ffffff"));
    assert_eq!(white.len(), 1, "without snow the grains do not matter");
}
