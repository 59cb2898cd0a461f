//! `snowblue spectrum` with layers, ground and depths: columns, agreement with single slabs, errors.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use shell::{assert_names, assert_refused, stderr, stdout};

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
const PROFILE: &str = "thickness_cm,depth_cm,angle_deg,wavelength_nm,down,up,net,fluence,e_folding_depth_cm";

#[test]
fn a_file_of_layers_has_fluxes_and_a_profile() {
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
        assert!(three.is_sorted_by(|a, b| a[6] > b[6]) && three.iter().all(|row| row[8] > 0.0), "{three:?}");
        // From all directions there is more than through a plane, and at most light along the plane.
        assert!(three.iter().all(|row| row[7] > row[4] + row[5]), "{three:?}");
    }
}

#[test]
fn black_ground_changes_nothing() {
    let common = ["spectrum", "--thickness", "1,5", "--wavelengths", "500", "--angle", "0,85"];
    let (plain, grounded) = (rows(&common, WHOLE), rows(&[&common[..], &["--ground-albedo", "0"]].concat(), WHOLE));
    assert_eq!(plain.len(), 4);
    for (a, b) in plain.iter().flatten().zip(grounded.iter().flatten()) {
        assert!((a - b).abs() <= 2e-9 * b.abs(), "{plain:?} {grounded:?}");
    }
}

/// The column keeps its name, so metadata and plot say what it is.
#[test]
fn the_flux_at_a_white_ground_exceeds_the_incident_flux_and_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let plot = folder.path().join("plot.svg");
    let common = ["spectrum", "--thickness", "1", "--ground-albedo", "0.9", "--wavelengths", "450"];
    for row in rows(&common, WHOLE) {
        assert!((row[3] + row[5] + 0.1 * row[4] - 1.0).abs() < 2e-9, "{row:?}");
    }
    let white = rows(&common.map(|word| if word == "0.9" { "1" } else { word }), WHOLE);
    assert!(white[0][4] > 1.2 && (white[0][3] + white[0][5] - 1.0).abs() < 2e-9, "{white:?}");
    let said = stderr(&[&common[..], &["--plot", plot.to_str().unwrap()]].concat());
    assert_names(&said, &["ground albedo 0.9;", "transmittance is the downward flux", "1 - reflectance - 0.1 trans"]);
    assert_names(&std::fs::read_to_string(plot).unwrap(), &["Downward flux at the ground"]);
    assert!(!stderr(&["spectrum", "--thickness", "1", "--wavelengths", "450"]).contains("ground"));
}

#[test]
fn bad_layers_are_refused_with_file_and_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pack.toml");
    for (from, to, line, words) in [
        ("facetness = 0.6", "facetnes = 0.6", 5, &["facetnes"][..]),
        ("density_kg_m3 = 120", "density_kg_m3 = 1200", 6, &["density", "1200 kg/m³", "10–900 kg/m³"]),
        ("density_kg_m3 = 120", "density_kg_m3 = \"light\"", 6, &["light"]),
        ("[100, 200]", "[200, 100]", 4, &["grain size", "200", "100"]),
        ("[100, 200]", "60", 4, &["grain size", "70–4950 µm"]),
        ("[100, 200]", "true", 4, &["number"]),
        ("facetness = 0.6", "facetness = 1.6", 5, &["facetness", "1.6", "0–1"]),
        ("sphericity = [0.6, 0.9, 0.7, 0.1]", "sphericity = 0.3", 10, &["sphericity", "0.3"]),
        ("ssa_m2_kg = 12", "ssa_m2_kg = 12\ngrain_size_um = 300", 9, &["specific surface area", "grain size"]),
        ("thickness_cm = 8.5", "thickness_cm = -1", 8, &["thickness", "-1 cm"]),
        ("thickness_cm = 8.5", "", 7, &["thickness_cm"]),
        ("picard2016", "hale1973", 1, &["hale1973", "picard2016"]),
        ("[[layer]]", "[[layer]", 2, &["unclosed"]),
    ] {
        assert!(PACK.contains(from), "{from}");
        std::fs::write(&path, PACK.replacen(from, to, 1)).unwrap();
        let place = format!("pack.toml:{line}: ");
        assert_refused(&["spectrum", "--layers", path.to_str().unwrap()], &[&[place.as_str()], words].concat());
    }
    std::fs::write(&path, "").unwrap();
    assert_refused(&["spectrum", "--layers", path.to_str().unwrap()], &["pack.toml", "[[layer]]"]);
    assert_refused(&["spectrum", "--layers", "none.toml"], &["none.toml"]);
    std::fs::write(&path, "[[layer]]\nthickness_cm = 1\n".repeat(1001)).unwrap();
    let refused = ["pack.toml:2001: ", "1001 [[layer]]", "at most 1000"];
    assert_refused(&["spectrum", "--layers", path.to_str().unwrap()], &refused);
}

#[test]
fn the_last_layer_may_be_a_half_space() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pack.toml");
    let arguments = ["spectrum", "--layers", path.to_str().unwrap(), "--depths", "0,50", "--wavelengths", "450"];
    std::fs::write(&path, PACK.replace("thickness_cm = 8.5", "thickness_cm = inf")).unwrap();
    let profile = rows(&arguments, PROFILE);
    assert!(profile[0][0].is_infinite() && profile[1][4] > 0.0 && profile[1][4] < profile[0][4], "{profile:?}");
    std::fs::write(&path, PACK.replace("thickness_cm = 2\n", "thickness_cm = inf\n")).unwrap();
    assert_refused(&arguments, &["pack.toml:3: ", "thickness is inf cm", "0–100000 cm"]);
    std::fs::write(&path, PACK.replace("density_kg_m3 = 120", "density_kg_m3 = 917")).unwrap();
    assert_refused(&arguments, &["pack.toml:6: ", "density is 917 kg/m³", "kind = \"ice\""]);
}

/// Ice between snow dims what is below it, and has no property of snow.
#[test]
fn a_layer_may_be_clear_ice() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pack.toml");
    let arguments = ["spectrum", "--layers", path.to_str().unwrap(), "--wavelengths", "450", "--depths"];
    let profile = |text: &str, depths: &'static str| {
        std::fs::write(&path, text).unwrap();
        rows(&[&arguments[..], &[depths]].concat(), PROFILE)
    };
    let (first, second) = PACK.split_at(PACK.rfind("[[layer]]").unwrap());
    let ice = "[[layer]]\nkind = \"ice\"\nthickness_cm = 1\n";
    let iced = profile(&format!("{first}{ice}{second}"), "0,2,2.5,11.5");
    assert_eq!((iced.len(), iced[0][0]), (4, 11.5));
    // The same without ice, with the ground 1 cm higher.
    let plain = profile(PACK, "0,2,10.5");
    assert!(iced[0][5] > 0.5 && iced[3][4] < plain[2][4], "{iced:?} {plain:?}");
    // In the ice, of which 0.03 per m absorb, hardly any net flux is lost.
    assert!((iced[2][6] / iced[1][6] - 1.0).abs() < 1e-2 && iced[2][8] > 1000.0, "{iced:?}");
    std::fs::write(&path, format!("{first}{ice}ssa_m2_kg = 20\n{second}")).unwrap();
    assert_refused(&arguments[..5], &["pack.toml:10: ", "ssa_m2_kg is a property of snow"]);
    std::fs::write(&path, format!("{first}{}{second}", ice.replace('1', "0.001"))).unwrap();
    assert_refused(&arguments[..5], &["pack.toml:9: ", "thickness of ice is 0.001 cm", "0.01–100000 cm"]);
}

const SKY_BANDS: &str = "depth_cm,bottom_cm,band,unit,down_per_m2,up_per_m2,net_per_m2,actinic_per_m2,absorbed_per_m2,\
absorbed_per_m3,warming_k_h";

/// What the layers take and what is left at the ground is what enters; by day, by night, and over a day.
#[test]
fn a_sky_gives_light_at_depth() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pack.toml");
    std::fs::write(&path, PACK).unwrap();
    let sky = |sun: &'static str, more: &[&str]| {
        let common = ["spectrum", "--layers", path.to_str().unwrap(), "--depths", "0,10.5", "--sky", sun];
        stdout(&[&common[..], more].concat())
    };
    let bands = sky("25", &["--broadband", "par,solar", "--turbidity", "2"]);
    let mut lines = bands.lines();
    assert_eq!(lines.next(), Some(SKY_BANDS));
    let cells: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(cells.len(), 8);
    let number = |row: usize, column: usize| cells[row][column].parse::<f64>().unwrap();
    for (first, band, unit) in [(0, "par-400-700", "µmol/s"), (4, "solar-320-2500", "W")] {
        assert!(cells[first..first + 4].iter().all(|row| row[2] == band && row[3] == unit), "{bands}");
        let kept = number(first, 6) - number(first + 1, 6);
        let absorbed = number(first + 2, 8) + number(first + 3, 8);
        assert!((absorbed / kept - 1.0).abs() < 1e-7 && number(first, 7) > number(first, 4), "{bands}");
    }
    assert!(cells[0][10].is_empty() && number(4, 10) > number(5, 10) && number(6, 10) > number(7, 10), "{bands}");
    let spectra = sky("25", &["--wavelengths", "450,700"]);
    let header = "depth_cm,wavelength_nm,down_w_m2_nm,up_w_m2_nm,net_w_m2_nm,actinic_w_m2_nm,absorbed_w_m3_nm";
    assert_eq!((spectra.lines().next(), spectra.lines().count()), (Some(header), 5));
    let night = sky("-5", &["--wavelengths", "450"]);
    assert!(night.lines().skip(1).all(|line| line.ends_with(",450,0,0,0,0,0")), "{night}");
    let day = sky("47.27,11.39,2026-02-01", &["--broadband", "par"]);
    assert_names(&day, &["warming_k\n", ",par-400-700,µmol,"]);
    // A half-space has a power per area, but none per volume.
    std::fs::write(&path, "[[layer]]\nthickness_cm = inf\n").unwrap();
    let endless =
        stdout(&["spectrum", "--layers", path.to_str().unwrap(), "--depths", "0", "--sky", "25", "--broadband"]);
    let row: Vec<&str> =
        endless.lines().find(|line| line.starts_with("0,inf,solar-320-2500,W,")).unwrap().split(',').collect();
    assert!(row[8].parse::<f64>().unwrap() > 0.0 && row[9..].iter().all(|cell| cell.is_empty()), "{endless}");
}

#[test]
fn skies_that_cannot_be_are_refused() {
    let refused = |more: &[&str], words: &[&str]| assert_refused(&[&["spectrum", "--sky"], more].concat(), words);
    refused(&["25"], &["--depths"]);
    refused(&["25", "--depths", "1", "--angle", "3"], &["--angle", "--sky"]);
    refused(&["25", "--depths", "1", "--engine", "montecarlo"], &["--sky", "--engine ordinates"]);
    refused(&["25", "--depths", "1", "--thickness", "2,5"], &["--sky", "--thickness"]);
    refused(&["25,3", "--depths", "1"], &["--sky", "LATITUDE,LONGITUDE,TIME"]);
    refused(&["95", "--depths", "1"], &["sun elevation", "95°", "-90–90°"]);
    refused(&["47,11,2026-02-30", "--depths", "1"], &["day is 30", "28 days"]);
    refused(&["25", "--depths", "1", "--turbidity", "20"], &["turbidity", "20", "1–10"]);
    refused(&["25", "--depths", "1", "--cloud-thickness", "20"], &["--overcast"]);
    refused(
        &["25", "--depths", "1", "--overcast", "--cloud-thickness", "0"],
        &["optical thickness of clouds", "0", "1–200"],
    );
    assert_refused(&["spectrum", "--depths", "1", "--turbidity", "2"], &["--sky"]);
    assert_refused(&["spectrum", "--depths", "1", "--broadband"], &["--broadband", "--sky"]);
}

#[test]
fn conflicts_and_values_out_of_range_are_refused() {
    for option in ["--grain-size", "--ssa", "--facetness", "--density", "--thickness", "--temperature"] {
        assert_refused(&["spectrum", "--layers", "pack.toml", option, "1"], &["--layers", option]);
    }
    assert_refused(&["spectrum", "--layers", "x.toml", "--ice", "picard2016"], &["--layers", "--ice"]);
    assert_refused(&["spectrum", "--ground-albedo", "1.2"], &["ground albedo", "1.2", "0–1"]);
    assert_refused(&["spectrum", "--depths", "16"], &["depth", "16 cm", "0–15 cm"]);
    assert_refused(&["spectrum", "--depths", "1", "--engine", "montecarlo"], &["--depths", "--engine ordinates"]);
    assert_refused(&["spectrum", "--streams", "many"], &["--streams", "'many'", "'auto'"]);
}

#[test]
fn monte_carlo_agrees_on_a_reflecting_ground() {
    let common = ["spectrum", "--thickness", "0.5", "--ground-albedo", "0.8", "--wavelengths", "600"];
    let solved = rows(&common, WHOLE);
    let header = format!("{WHOLE},reflectance_se,transmittance_se,absorptance_se");
    let sampled = rows(&[&common[..], &["--engine", "montecarlo", "--rays", "4000"]].concat(), &header);
    for quantity in 3..6 {
        let gap = (sampled[0][quantity] - solved[0][quantity]).abs();
        assert!(gap < 4.0 * sampled[0][quantity + 3], "{sampled:?} {solved:?}");
    }
}
