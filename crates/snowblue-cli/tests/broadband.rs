//! `snowblue spectrum --broadband`, and wavelengths at the ends of the tables.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use shell::{assert_names, assert_refused, stdout};

const HEADER: &str = "thickness_cm,angle_deg,band,reflectance,transmittance,absorptance";

/// Rows of a CSV that must begin with `header`.
fn rows(arguments: &[&str], header: &str) -> Vec<Vec<String>> {
    let text = stdout(arguments);
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(header));
    lines.map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn number(row: &[String], column: usize) -> f64 {
    row[column].parse().unwrap()
}

#[test]
fn bands_have_a_row_for_each_thickness_and_angle() {
    let rows = rows(&["spectrum", "--broadband", "--thickness", "1,15", "--angle", "0,diffuse"], HEADER);
    assert_eq!(rows.len(), 16);
    let names: Vec<&str> = rows[..4].iter().map(|row| row[2].as_str()).collect();
    assert_eq!(names, ["solar-300-2500", "visible-400-700", "near-infrared-700-2500", "par-400-700"]);
    assert_eq!((rows[4][0].as_str(), rows[4][1].as_str(), rows[8][0].as_str()), ("1", "diffuse", "15"));
    for row in &rows {
        let sum: f64 = (3..6).map(|column| number(row, column)).sum();
        // Nine significant digits each.
        assert!((sum - 1.0).abs() < 2e-8, "{row:?}");
    }
    let [solar, visible, infrared] = [8, 9, 10].map(|row| number(&rows[row], 3));
    assert!(infrared < 0.6 && (0.75..0.8).contains(&solar) && visible > 0.96, "{solar} {visible} {infrared}");
}

#[test]
fn monte_carlo_and_layers_have_bands() {
    let common = ["spectrum", "--thickness", "1", "--broadband", "near-infrared,par"];
    let solved = rows(&common, HEADER);
    let header = format!("{HEADER},reflectance_se,transmittance_se,absorptance_se");
    let sampled = rows(&[&common[..], &["--engine", "montecarlo", "--rays", "2000"]].concat(), &header);
    assert_eq!((solved.len(), sampled.len()), (2, 2));
    for (sampled, solved) in sampled.iter().zip(&solved) {
        for quantity in 3..6 {
            let gap = (number(sampled, quantity) - number(solved, quantity)).abs();
            assert!(gap < 4.0 * number(sampled, quantity + 3), "{sampled:?} {solved:?}");
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let (pack, figure) = (folder.path().join("pack.toml"), folder.path().join("pack.svg"));
    std::fs::write(&pack, "ice = \"picard2016\"\n[[layer]]\nthickness_cm = 0.5\n[[layer]]\nthickness_cm = 0.5\n")
        .unwrap();
    let layered = ["spectrum", "--layers", pack.to_str().unwrap(), "--plot", figure.to_str().unwrap(), "--broadband"];
    let layered = rows(&layered, HEADER);
    assert_eq!((layered.len(), layered[0][2].as_str()), (4, "solar-320-2500"));
    assert!((number(&layered[2], 3) - number(&solved[0], 3)).abs() < 2e-3, "{layered:?} {solved:?}");
    assert_names(&std::fs::read_to_string(&figure).unwrap(), &["ASTM G173-03"]);
}

#[test]
fn metadata_name_the_solar_spectrum() {
    let text = stdout(&["spectrum", "--broadband", "par", "--format", "json"]);
    assert_names(&text, &["ASTM G173-03", "37°", "1977.87 µmol m⁻² s⁻¹"]);
}

#[test]
fn wavelengths_outside_the_tables_are_refused() {
    let refused = |nm: &str, more: &[&str], words: &[&str]| {
        assert_refused(&[&["spectrum", "--wavelengths", nm], more].concat(), words);
    };
    refused("299", &[], &["wavelength", "299 nm", "300–2500 nm"]);
    refused("2501", &[], &["wavelength", "2501 nm", "300–2500 nm"]);
    refused("319", &["--ice", "picard2016"], &["wavelength", "319 nm", "320–2500 nm"]);
    refused("400:700:10", &["--broadband"], &["300", "400 nm"]);
    refused("400,700", &["--broadband", "par"], &["400", "700 nm"]);
    refused("700,650", &["--broadband", "par"], &["ascend"]);
    assert_refused(&["spectrum", "--broadband", "blue"], &["'blue'", "near-infrared"]);
    for other in [&["--spread"][..], &["--depths", "1"]] {
        assert_refused(&[&["spectrum", "--broadband"], other].concat(), &["--broadband", other[0]]);
    }
}
