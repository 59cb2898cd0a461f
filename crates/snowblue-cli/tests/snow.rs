//! Options of snow: kinds, water and impurities.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use shell::{assert_names, assert_refused, stderr, stdout};

/// A kind of snow at a temperature is the same in a file of layers and as options.
#[test]
fn layers_and_options_mean_the_same_snow() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pack.toml");
    std::fs::write(&path, "[[layer]]\nthickness_cm = 5\nsnow = \"firn\"\ntemperature_c = -60\n").unwrap();
    let layered = stdout(&["spectrum", "--wavelengths", "450", "--layers", path.to_str().unwrap()]);
    let alone = transmittance(&["--snow", "firn", "--temperature", "-60"]);
    assert!((last_row(&layered, 4)[0] / alone - 1.0).abs() < 1e-8, "{layered} {alone}");
}

/// The last row's numbers from the given column on.
fn last_row(text: &str, from: usize) -> Vec<f64> {
    text.lines().last().unwrap().split(',').skip(from).map(|field| field.parse().unwrap()).collect()
}

fn transmittance(options: &[&str]) -> f64 {
    last_row(&stdout(&[&["spectrum", "--wavelengths", "450", "--thickness", "5"], options].concat()), 4)[0]
}

#[test]
fn kinds_of_snow_set_surface_area_and_density() {
    let kind = transmittance(&["--snow", "rounded"]);
    let numbers = transmittance(&["--ssa", "25", "--density", "250"]);
    assert!((kind / numbers - 1.0).abs() < 1e-9, "{kind} {numbers}");
    // Given quantities override those of the kind.
    assert!(transmittance(&["--snow", "rounded", "--density", "500"]) < 0.7 * kind);
    assert!(transmittance(&["--snow", "rounded", "--grain-size", "2000"]) > 2.0 * kind);
    assert!(transmittance(&["--snow", "fresh"]) < transmittance(&["--snow", "melt-forms"]));
    let words = ["slushy", "fresh", "rounded", "faceted", "wind-packed", "melt-forms", "firn"];
    assert_refused(&["spectrum", "--snow", "slushy"], &words);
}

#[test]
fn water_transmits_blue_and_soot_absorbs_it() {
    let dry = transmittance(&[]);
    assert!(transmittance(&["--water-saturation", "0.3"]) > 1.2 * dry);
    let sooty = transmittance(&["--impurity", "black-carbon=100"]);
    // σ_a = 0.24/m more, κ(1 − g) = 500/m: x/sinh x with x = 0.05 √(3 · 0.24 · 500) = 0.95 is 0.87.
    assert!((sooty / dry - 0.87).abs() < 0.03);
    let both = transmittance(&["--impurity", "black-carbon=100,saharan-dust=500"]);
    let underscores = transmittance(&["--impurity", "black_carbon=100,saharan_dust=500"]);
    assert_eq!(underscores.to_bits(), both.to_bits());
    let repeated = transmittance(&["--impurity", "saharan-dust=500", "--impurity", "black-carbon=100"]);
    assert!(both < sooty && (both / repeated - 1.0).abs() < 1e-12);
}

#[test]
fn metadata_describe_the_snow() {
    let options = [
        "spectrum",
        "--wavelengths",
        "500",
        "--snow",
        "firn",
        "--water-saturation",
        "0.1",
        "--impurity",
        "snow-algae=2e4",
    ];
    let words = ["Cuffey & Paterson", "saturation 0.1", "snow-algae=20000 ng/g (Chevrollier et al. 2023"];
    assert_names(&stderr(&options), &words);
}

#[test]
fn impossible_snow_is_refused() {
    for (options, words) in [
        (&["--water-saturation", "1.2"][..], &["water saturation", "1.2", "0–1"][..]),
        (&["--water-saturation", "0.1", "--wavelengths", "1500"], &["wavelength", "wet snow", "1500 nm"]),
        (&["--impurity", "soot=3"], &["'soot'", "black-carbon"]),
        (&["--impurity", "black-carbon"], &["--impurity", "black-carbon=10"]),
        (&["--impurity", "black-carbon=-3"], &["mass fraction", "-3 ng/g"]),
        (&["--impurity", "black-carbon=3", "--wavelengths", "300"], &["wavelength", "300 nm", "305–1495 nm"]),
        (&["--impurity", "black-carbon=5,black-carbon=50"], &["black-carbon", "twice"]),
        (&["--snow", "firn", "--size-measure", "volume-diameter"], &["--size-measure", "--grain-size"]),
    ] {
        assert_refused(&[&["spectrum"], options].concat(), words);
    }
}

#[test]
fn layers_can_differ_in_composition() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pack.toml");
    let pack = "[[layer]]\nthickness_cm = 2\nsnow = \"fresh\"\nimpurities_ng_g = { black-carbon = 20 }\n\
                [[layer]]\nthickness_cm = 10\nsnow = \"melt-forms\"\nwater_saturation = 0.05\n";
    std::fs::write(&path, pack).unwrap();
    let name = path.to_str().unwrap();
    let layered = stdout(&["spectrum", "--wavelengths", "500", "--layers", name]);
    // Soot in the top layer absorbs blue light that clean snow reflects.
    std::fs::write(&path, pack.replace("= 20 }", "= 0 }")).unwrap();
    let clean = stdout(&["spectrum", "--wavelengths", "500", "--layers", name]);
    assert!(last_row(&layered, 3)[0] < last_row(&clean, 3)[0] - 5e-4, "{layered} {clean}");
    for (wrong, words) in [
        (pack.replace("black-carbon", "soot"), ["pack.toml:4:", "'soot'"]),
        (pack.replace("= 20 }", "= -20 }"), ["pack.toml:4:", "-20 ng/g"]),
        (pack.replace("0.05", "1.05"), ["pack.toml:8:", "1.05"]),
        (pack.replace("melt-forms", "melting"), ["pack.toml:7:", "'melting'"]),
    ] {
        std::fs::write(&path, wrong).unwrap();
        assert_refused(&["spectrum", "--wavelengths", "500", "--layers", name], &words);
    }
}
