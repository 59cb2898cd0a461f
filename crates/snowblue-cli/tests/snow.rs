//! What snow can hold, as users ask for it: kinds of snow, water, impurities; and what is refused.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use shell::{refused, snowblue, stdout};

/// A layer of a kind of snow is that kind at its temperature, as the options have it.
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
fn kinds_of_snow_stand_for_a_surface_area_and_a_density() {
    let kind = transmittance(&["--snow", "rounded"]);
    let numbers = transmittance(&["--ssa", "25", "--density", "250"]);
    assert!((kind / numbers - 1.0).abs() < 1e-9, "{kind} {numbers}");
    // What is given goes before the kind.
    assert!(transmittance(&["--snow", "rounded", "--density", "500"]) < 0.7 * kind);
    assert!(transmittance(&["--snow", "rounded", "--grain-size", "2000"]) > 2.0 * kind);
    assert!(transmittance(&["--snow", "fresh"]) < transmittance(&["--snow", "melt-forms"]));
    let message = refused(&["spectrum", "--snow", "slushy"]);
    assert!(message.contains("fresh, rounded, faceted, wind-packed, melt-forms, firn"), "{message}");
}

#[test]
fn water_lets_blue_through_and_soot_does_not() {
    let dry = transmittance(&[]);
    assert!(transmittance(&["--water-saturation", "0.3"]) > 1.2 * dry);
    let sooty = transmittance(&["--impurity", "black-carbon=100"]);
    // σ_a = .24/m more, κ(1 − g) = 500/m: x/sinh x with x = .05 √(3 · .24 · 500) = .95 is .87.
    assert!((sooty / dry - 0.87).abs() < 0.03);
    let both = transmittance(&["--impurity", "black-carbon=100,saharan-dust=500"]);
    let repeated = transmittance(&["--impurity", "saharan-dust=500", "--impurity", "black-carbon=100"]);
    assert!(both < sooty && (both / repeated - 1.0).abs() < 1e-12);
}

#[test]
fn results_say_what_is_in_the_snow() {
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
    let told = String::from_utf8(snowblue(&options).stderr).unwrap();
    for word in ["Cuffey & Paterson", "saturation 0.1", "snow-algae=20000 ng/g (Chevrollier et al. 2023"] {
        assert!(told.contains(word), "{word}: {told}");
    }
}

#[test]
fn impossible_snow_is_refused() {
    for (options, words) in [
        (&["--water-saturation", "1.2"][..], "water saturation is 1.2, but must lie in 0–1"),
        (&["--water-saturation", "0.1", "--wavelengths", "1500"], "wavelength in wet snow is 1500 nm"),
        (&["--impurity", "soot=3"], "impurity 'soot' is not known; there are black-carbon"),
        (&["--impurity", "black-carbon"], "black-carbon=10"),
        (&["--impurity", "black-carbon=-3"], "mass fraction of an impurity is -3 ng/g"),
        (&["--impurity", "black-carbon=3", "--wavelengths", "300"], "must lie in 305–1495 nm"),
        (&["--impurity", "black-carbon=5,black-carbon=50"], "black-carbon is given twice"),
        (&["--snow", "firn", "--size-measure", "volume-diameter"], "--size-measure"),
    ] {
        let message = refused(&[&["spectrum"], options].concat());
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn layers_may_differ_in_what_they_hold() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pack.toml");
    let pack = "[[layer]]\nthickness_cm = 2\nsnow = \"fresh\"\nimpurities_ng_g = { black-carbon = 20 }\n\
                [[layer]]\nthickness_cm = 10\nsnow = \"melt-forms\"\nwater_saturation = 0.05\n";
    std::fs::write(&path, pack).unwrap();
    let name = path.to_str().unwrap();
    let layered = stdout(&["spectrum", "--wavelengths", "500", "--layers", name]);
    // Soot on top takes up blue light that the same pack without it sends back.
    std::fs::write(&path, pack.replace("= 20 }", "= 0 }")).unwrap();
    let clean = stdout(&["spectrum", "--wavelengths", "500", "--layers", name]);
    assert!(last_row(&layered, 3)[0] < last_row(&clean, 3)[0] - 5e-4, "{layered} {clean}");
    for (wrong, place, words) in [
        (pack.replace("black-carbon", "soot"), "pack.toml:4", "impurity 'soot' is not known"),
        (pack.replace("= 20 }", "= -20 }"), "pack.toml:4", "-20 ng/g"),
        (pack.replace("0.05", "1.05"), "pack.toml:8", "water saturation is 1.05"),
        (pack.replace("melt-forms", "melting"), "pack.toml:7", "snow 'melting'"),
    ] {
        std::fs::write(&path, wrong).unwrap();
        let message = refused(&["spectrum", "--wavelengths", "500", "--layers", name]);
        assert!(message.contains(words), "{message}");
        assert!(message.contains(place), "{message}");
    }
}
