//! `snowblue bsdf`, and the charts of `--plot`.

use std::path::Path;

use svg::parser::Event;

use crate::shell::{Folder, assert_names, stdout};

/// All text of an SVG file, which must be well-formed and have finite numbers.
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

/// Patches by ordinates have the fluxes of random walks, on any depth.
#[test]
fn bsdf_by_ordinates_has_no_noise() {
    let common = "bsdf --thickness 0.3 --wavelengths 500 --angle 50 --engine ordinates";
    let text = stdout(common);
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("side,theta_deg,phi_deg,solid_angle_sr,wavelength_nm,bsdf_per_sr"));
    let values: Vec<f64> = lines.map(|line| line.rsplit(',').next().unwrap().parse().unwrap()).collect();
    assert_eq!(values.len(), 2 * 120);
    // 3 mm absorb almost nothing, and let a quarter of a per cent through unscattered.
    let flux = values.iter().sum::<f64>() * std::f64::consts::PI / 120.0;
    assert!((0.985..1.003).contains(&flux), "{flux}");
    let folder = Folder::new();
    folder.stdout("bsdf --thickness inf --engine ordinates --wavelengths 900 --plot bsdf.svg");
    assert!(!words(&folder.path("bsdf.svg")).contains("standard error"));
    folder.assert_refused(&format!("{common} --rays 100"), &["--rays has no effect: ", "--engine ordinates"]);
}

#[test]
fn bsdf_prints_patches_that_add_up() {
    let common = "bsdf --thickness 0.3 --wavelengths 500 --rays 2000 --seed 7";
    let text = stdout(&format!("{common} --angle 50 --patches 4x3"));
    let mut lines = text.lines();
    let header = "side,theta_deg,phi_deg,solid_angle_sr,wavelength_nm,bsdf_per_sr,bsdf_se_per_sr";
    assert_eq!(lines.next(), Some(header));
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 2 * 4 * 3);
    let number = |row: &[&str], column: usize| row[column].parse::<f64>().unwrap();
    // 3 mm absorb almost nothing, and almost no light crosses 6 optical depths unscattered.
    let flux: f64 = rows.iter().map(|row| number(row, 5) * std::f64::consts::PI / 12.0).sum();
    assert!((0.985..1.0).contains(&flux), "{flux}");
    for side in ["reflection", "transmission"] {
        let solid: f64 = rows.iter().filter(|row| row[0] == side).map(|row| number(row, 3)).sum();
        assert!((solid - std::f64::consts::TAU).abs() < 1e-7);
    }
    // At normal incidence there is one sector.
    assert_eq!(stdout(common).lines().count(), 1 + 2 * 10);
    let json = stdout(&format!("{common} --format json"));
    assert_names(&json, &["\"reflectance\": \"", "\"transmittance\": \"", "\"direct\": \""]);
}

#[test]
fn plots_have_axes_units_and_a_legend() {
    let folder = Folder::new();
    let draw = |name: &str, line: &str| {
        folder.stdout(&format!("{line} --plot {name}"));
        words(&folder.path(name))
    };
    let text = draw("several.svg", "spectrum --thickness 1,30 --angle 0,diffuse --wavelengths 400:700:100");
    let expected =
        ["Transmittance|", "Reflectance|", "Wavelength (nm)|", "30 cm|", "diffuse|", "0.01|", "550|", "seed 1"];
    assert_names(&text, &expected);
    // Extremes: no snow, no transmitted light, one wavelength.
    draw("nothing.svg", "spectrum --thickness 0 --wavelengths 500");
    draw("dark.svg", "spectrum --thickness 1000 --wavelengths 1990,2000");
    let text = draw("bsdf.svg", "bsdf --thickness 0.2 --angle 60 --wavelengths 450,650 --rays 500");
    let expected =
        ["BRDF (1/sr)|", "BTDF (1/sr)|", "450 nm|", "650 nm|", "60°|", "0.2 cm of snow|", "± 1 standard error"];
    assert_names(&text, &expected);
    draw("black.svg", "bsdf --thickness 50 --wavelengths 2000 --rays 100 --angle diffuse");
    assert!(folder.files().keys().all(|name| name.to_str().unwrap().ends_with(".svg")), "no other file is left");
}
