//! `bsdf` as users meet it, and the figures that commands draw.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use std::path::Path;

use shell::{snowblue, stdout};

use svg::parser::Event;

/// All text of a figure, which must be well-formed and free of numbers that are none.
fn words(path: &Path) -> String {
    let mut content = String::new();
    let (mut depth, mut words) = (0_i32, String::new());
    for event in svg::open(path, &mut content).unwrap() {
        match event {
            Event::Tag(_, svg::node::element::tag::Type::Start, _) => depth += 1,
            Event::Tag(_, svg::node::element::tag::Type::End, _) => depth -= 1,
            Event::Text(text) => words.push_str(&format!("{text}|")),
            Event::Error(error) => panic!("{}: {error}", path.display()),
            _ => {}
        }
    }
    assert_eq!(depth, 0);
    assert!(!content.contains("NaN") && !content.contains("inf"), "{content}");
    words
}

#[test]
fn bsdf_prints_patches_that_add_up() {
    let common = ["bsdf", "--thickness", "0.3", "--wavelengths", "500", "--rays", "2000", "--seed", "7"];
    let text = stdout(&[&common[..], &["--angle", "50", "--patches", "4x3"]].concat());
    let mut lines = text.lines();
    let header = "side,theta_deg,phi_deg,solid_angle_sr,wavelength_nm,bsdf_per_sr,bsdf_se_per_sr";
    assert_eq!(lines.next(), Some(header));
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 2 * 4 * 3);
    let number = |row: &[&str], column: usize| row[column].parse::<f64>().unwrap();
    // Nothing to speak of is absorbed in 3 mm, and next to nothing passes 6 optical depths untouched.
    let flux: f64 = rows.iter().map(|row| number(row, 5) * std::f64::consts::PI / 12.0).sum();
    assert!((0.985..1.0).contains(&flux), "{flux}");
    for side in ["reflection", "transmission"] {
        let solid: f64 = rows.iter().filter(|row| row[0] == side).map(|row| number(row, 3)).sum();
        assert!((solid - std::f64::consts::TAU).abs() < 1e-7);
    }
    // Where no azimuth differs from another, there is one sector.
    assert_eq!(stdout(&common).lines().count(), 1 + 2 * 10);
    let json = stdout(&[&common[..], &["--format", "json"]].concat());
    for name in ["\"reflectance\": \"", "\"transmittance\": \"", "\"direct\": \""] {
        assert!(json.contains(name), "{name}");
    }
    for (option, value, complaint) in
        [("--angle", "90", "angle"), ("--patches", "4", "RINGSxSECTORS"), ("--rays", "1", "rays")]
    {
        let output = snowblue(&["bsdf", option, value]);
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && message.contains(complaint), "{message}");
    }
}

#[test]
fn figures_have_axes_units_and_a_legend() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let draw = |name: &str, arguments: &[&str]| {
        stdout(&[arguments, &["--plot", at(name).to_str().unwrap()]].concat());
        words(&at(name))
    };
    let several = ["spectrum", "--thickness", "1,30", "--angle", "0,diffuse", "--wavelengths", "400:700:100"];
    let text = draw("several.svg", &several);
    for word in ["Transmittance|", "Reflectance|", "Wavelength (nm)|", "30 cm|", "diffuse|", "0.01|", "550|", "seed 1"]
    {
        assert!(text.contains(word), "{word} in {text}");
    }
    // White light through nothing, no light through ten metres, and one wavelength are drawn too.
    draw("nothing.svg", &["spectrum", "--thickness", "0", "--wavelengths", "500"]);
    draw("dark.svg", &["spectrum", "--thickness", "1000", "--wavelengths", "1500,2000"]);
    let scatter = ["bsdf", "--thickness", "0.2", "--angle", "60", "--wavelengths", "450,650", "--rays", "500"];
    let text = draw("bsdf.svg", &scatter);
    for word in ["BRDF (1/sr)|", "BTDF (1/sr)|", "450 nm|", "650 nm|", "60°|", "0.2 cm of snow|", "± 1 standard error"]
    {
        assert!(text.contains(word), "{word} in {text}");
    }
    draw("black.svg", &["bsdf", "--thickness", "50", "--wavelengths", "2000", "--rays", "100", "--angle", "diffuse"]);
    let names = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name());
    assert!(names.into_iter().all(|name| name.to_str().unwrap().ends_with(".svg")), "nothing is left beside");
}
