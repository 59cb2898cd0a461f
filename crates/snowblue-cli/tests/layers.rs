//! `snowblue spectrum` on layers, grounds and depths: columns, agreement with plain slabs, and one clear line for bad files.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use shell::{refused, stdout};

const PACK: &str = "\
ice = \"picard2016\"
[[layer]]
thickness_cm = 2
grain_size_um = [100, 200]
facetness = 0.6
density_kg_m3 = 120
[[layer]]
thickness_cm = 8.5
ssa_m2_kg = 12
sphericity = [0.6, 0.9, 0.7, 0.1]
temperature_c = -12
";

/// Rows of a CSV that must begin with `header`.
fn rows(arguments: &[&str], header: &str) -> Vec<Vec<f64>> {
    let text = stdout(arguments);
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(header));
    lines.map(|line| line.split(',').map(|field| field.parse().unwrap_or(f64::NAN)).collect()).collect()
}

const WHOLE: &str = "thickness_cm,angle_deg,wavelength_nm,reflectance,transmittance,absorptance";
const PROFILE: &str = "thickness_cm,depth_cm,angle_deg,wavelength_nm,down,up,net,e_folding_depth_cm";

#[test]
fn a_file_of_layers_has_a_whole_and_a_profile() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pack.toml");
    std::fs::write(&path, PACK).unwrap();
    let common = ["spectrum", "--layers", path.to_str().unwrap(), "--ground-albedo", "0.3", "--wavelengths", "450,700"];
    let common = [&common[..], &["--angle", "0,89,diffuse"]].concat();
    let whole = rows(&common, WHOLE);
    assert_eq!(whole.len(), 6);
    for row in &whole {
        // Nine significant digits each.
        assert!((row[3] + row[5] + 0.7 * row[4] - 1.0).abs() < 2e-8 && (row[0] - 10.5).abs() < 1e-12, "{row:?}");
    }
    let profile = rows(&[&common[..], &["--depths", "0,2,10.5"]].concat(), PROFILE);
    assert_eq!(profile.len(), 18);
    for (three, whole) in profile.chunks_exact(3).zip(&whole) {
        assert!((three[0][4] - 1.0).abs() < 1e-8 && (three[0][5] - whole[3]).abs() < 1e-8, "{three:?}");
        assert!((three[2][4] - whole[4]).abs() < 1e-8 && (three[2][5] - 0.3 * whole[4]).abs() < 1e-8, "{three:?}");
        assert!(three.is_sorted_by(|a, b| a[6] > b[6]) && three.iter().all(|row| row[7] > 0.0), "{three:?}");
    }
}

#[test]
fn black_ground_is_the_plain_slab() {
    let common = ["spectrum", "--thickness", "1,5", "--wavelengths", "500", "--angle", "0,85"];
    let (plain, grounded) = (rows(&common, WHOLE), rows(&[&common[..], &["--ground-albedo", "0"]].concat(), WHOLE));
    assert_eq!(plain.len(), 4);
    for (a, b) in plain.iter().flatten().zip(grounded.iter().flatten()) {
        assert!((a - b).abs() <= 2e-9 * b.abs(), "{plain:?} {grounded:?}");
    }
}

#[test]
fn bad_layers_get_one_clear_line_with_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pack.toml");
    let with = |from: &str, to: &str| {
        assert!(PACK.contains(from), "{from}");
        std::fs::write(&path, PACK.replacen(from, to, 1)).unwrap();
        refused(&["spectrum", "--layers", path.to_str().unwrap()])
    };
    for (from, to, line, reason) in [
        ("facetness = 0.6", "facetnes = 0.6", 5, "unknown field `facetnes`"),
        ("density_kg_m3 = 120", "density_kg_m3 = 1200", 6, "density is 1200 kg/m³, but must lie in 10–900 kg/m³"),
        ("density_kg_m3 = 120", "density_kg_m3 = \"light\"", 6, "invalid type"),
        ("[100, 200]", "[200, 100]", 4, "wrong order"),
        ("[100, 200]", "60", 4, "below 20 µm"),
        ("[100, 200]", "true", 4, "a number or a list of numbers"),
        ("facetness = 0.6", "facetness = 1.6", 5, "0–1"),
        ("sphericity = [0.6, 0.9, 0.7, 0.1]", "sphericity = 0.3", 10, "sphericity is 0.3"),
        ("ssa_m2_kg = 12", "ssa_m2_kg = 12\ngrain_size_um = 300", 9, "instead of grain_size_um"),
        ("thickness_cm = 8.5", "thickness_cm = -1", 8, "thickness is -1 cm"),
        ("thickness_cm = 8.5", "", 7, "missing field `thickness_cm`"),
        ("picard2016", "hale1973", 1, "unknown variant `hale1973`"),
        ("[[layer]]", "[[layer]", 2, "unclosed array table"),
    ] {
        let message = with(from, to);
        assert!(message.contains(&format!("pack.toml:{line}: ")) && message.contains(reason), "{message}");
    }
    std::fs::write(&path, "").unwrap();
    assert!(refused(&["spectrum", "--layers", path.to_str().unwrap()]).contains("holds no [[layer]]"));
    assert!(refused(&["spectrum", "--layers", "none.toml"]).contains("none.toml: cannot be read"));
}

#[test]
fn conflicts_and_ranges_are_told() {
    for option in ["--grain-size", "--ssa", "--facetness", "--density", "--thickness", "--temperature"] {
        assert!(
            refused(&["spectrum", "--layers", "pack.toml", option, "1"]).contains("cannot be used with"),
            "{option}"
        );
    }
    assert!(refused(&["spectrum", "--layers", "x.toml", "--ice", "picard2016"]).contains("cannot be used with"));
    assert!(refused(&["spectrum", "--ground-albedo", "1.2"]).contains("ground albedo is 1.2, but must lie in 0–1"));
    assert!(refused(&["spectrum", "--depths", "16"]).contains("depth is 16 cm, but must lie in 0–15 cm"));
    let walked = ["spectrum", "--depths", "1", "--engine", "montecarlo"];
    assert!(refused(&walked).contains("--engine ordinates"));
    assert!(refused(&["spectrum", "--streams", "many"]).contains("neither a number nor 'auto'"));
}

#[test]
fn the_walk_goes_through_layers_too() {
    let common = ["spectrum", "--thickness", "0.5", "--ground-albedo", "0.8", "--wavelengths", "600"];
    let solved = rows(&common, WHOLE);
    let header = format!("{WHOLE},reflectance_se,transmittance_se,absorptance_se");
    let walked = rows(&[&common[..], &["--engine", "montecarlo", "--rays", "4000"]].concat(), &header);
    for quantity in 3..6 {
        let gap = (walked[0][quantity] - solved[0][quantity]).abs();
        assert!(gap < 4.0 * walked[0][quantity + 3], "{walked:?} {solved:?}");
    }
}
