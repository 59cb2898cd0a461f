//! `snowblue spectrum --broadband` and wavelengths at the ends of the tables.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use shell::{refused, stdout};

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
fn engines_and_layers_have_bands_too() {
    let common = ["spectrum", "--thickness", "1", "--broadband", "near-infrared,par"];
    let solved = rows(&common, HEADER);
    let header = format!("{HEADER},reflectance_se,transmittance_se,absorptance_se");
    let walked = rows(&[&common[..], &["--engine", "montecarlo", "--rays", "2000"]].concat(), &header);
    assert_eq!((solved.len(), walked.len()), (2, 2));
    for (walked, solved) in walked.iter().zip(&solved) {
        for quantity in 3..6 {
            let gap = (number(walked, quantity) - number(solved, quantity)).abs();
            assert!(gap < 4.0 * number(walked, quantity + 3), "{walked:?} {solved:?}");
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
    assert!(std::fs::read_to_string(&figure).unwrap().contains("ASTM G173-03"));
}

#[test]
fn metadata_name_the_sun() {
    let text = stdout(&["spectrum", "--broadband", "par", "--format", "json"]);
    assert!(text.contains("ASTM G173-03 global on a plane tilted by 37°") && text.contains("1977.87 µmol m⁻² s⁻¹"));
}

#[test]
fn what_the_tables_do_not_reach_is_told() {
    let wavelengths = |nm: &str, more: &[&str]| refused(&[&["spectrum", "--wavelengths", nm], more].concat());
    assert!(wavelengths("299", &[]).contains("wavelength is 299 nm, but must lie in 300–2500 nm"));
    assert!(wavelengths("2501", &[]).contains("wavelength is 2501 nm, but must lie in 300–2500 nm"));
    assert!(wavelengths("319", &["--ice", "picard2016"]).contains("wavelength is 319 nm, but must lie in 320–2500 nm"));
    assert!(wavelengths("400:700:10", &["--broadband"]).contains("none from 300 to 400 nm"));
    assert!(wavelengths("400,700", &["--broadband", "par"]).contains("none from 400 to 700 nm"));
    assert!(wavelengths("700,650", &["--broadband", "par"]).contains("must ascend"));
    assert!(refused(&["spectrum", "--broadband", "blue"]).contains("'blue' is no band"));
    for other in [&["--spread"][..], &["--depths", "1"]] {
        assert!(refused(&[&["spectrum", "--broadband"], other].concat()).contains("cannot be used with"));
    }
}
