//! `snowblue spectrum` with layers, ground and depths: columns, and agreement with single slabs.

use crate::shell::{Folder, assert_names, stderr, stdout};

pub(crate) const PACK: &str = "\
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
fn rows(text: &str, header: &str) -> Vec<Vec<f64>> {
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(header));
    lines.map(|line| line.split(',').map(|field| field.parse().unwrap_or(f64::NAN)).collect()).collect()
}

const WHOLE: &str = "thickness_cm,angle_deg,wavelength_nm,reflectance,transmittance,absorptance";
const PROFILE: &str = "thickness_cm,depth_cm,angle_deg,wavelength_nm,down,up,net,fluence,e_folding_depth_cm";

#[test]
fn a_file_of_layers_has_fluxes_and_a_profile() {
    let folder = Folder::new();
    folder.write("pack.toml", PACK);
    let common = "spectrum --layers pack.toml --ground-albedo 0.3 --wavelengths 450,500 --angle 0,89,diffuse";
    let whole = rows(&folder.stdout(common), WHOLE);
    assert_eq!(whole.len(), 6);
    for row in &whole {
        // Nine significant digits each.
        assert!((row[3] + row[5] + 0.7 * row[4] - 1.0).abs() < 2e-8 && (row[0] - 10.5).abs() < 1e-12, "{row:?}");
    }
    let profile = rows(&folder.stdout(&format!("{common} --depths 0,2,10.5")), PROFILE);
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
    let common = "spectrum --thickness 1,5 --wavelengths 500 --angle 0,85";
    let [plain, grounded] = ["", "--ground-albedo 0"].map(|ground| rows(&stdout(&format!("{common} {ground}")), WHOLE));
    assert_eq!(plain.len(), 4);
    for (a, b) in plain.iter().flatten().zip(grounded.iter().flatten()) {
        assert!((a - b).abs() <= 2e-9 * b.abs(), "{plain:?} {grounded:?}");
    }
}

/// The column keeps its name, so metadata and plot say what it is.
#[test]
fn the_flux_at_a_white_ground_exceeds_the_incident_flux_and_is_named() {
    let folder = Folder::new();
    let on = |albedo: &str| format!("spectrum --thickness 1 --wavelengths 450 --ground-albedo {albedo}");
    for row in rows(&stdout(&on("0.9")), WHOLE) {
        assert!((row[3] + row[5] + 0.1 * row[4] - 1.0).abs() < 2e-9, "{row:?}");
    }
    let white = rows(&stdout(&on("1")), WHOLE);
    assert!(white[0][4] > 1.2 && (white[0][3] + white[0][5] - 1.0).abs() < 2e-9, "{white:?}");
    let said = folder.stderr(&format!("{} --plot plot.svg", on("0.9")));
    assert_names(&said, &["ground albedo 0.9;", "transmittance is the downward flux", "1 - reflectance - 0.1 trans"]);
    assert_names(&folder.text("plot.svg"), &["Downward flux at the ground"]);
    assert!(!stderr("spectrum --thickness 1 --wavelengths 450").contains("ground"));
}

#[test]
fn a_file_has_at_most_a_thousand_layers() {
    let folder = Folder::new();
    folder.write("pack.toml", "[[layer]]\nthickness_cm = 1\n".repeat(1001));
    folder.assert_refused("spectrum --layers pack.toml", &["pack.toml:2001: ", "1001 [[layer]]", "at most 1000"]);
}

#[test]
fn the_last_layer_may_be_a_half_space() {
    let folder = Folder::new();
    folder.write("pack.toml", PACK.replace("thickness_cm = 8.5", "thickness_cm = inf"));
    let profile = rows(&folder.stdout("spectrum --layers pack.toml --depths 0,50 --wavelengths 450"), PROFILE);
    assert!(profile[0][0].is_infinite() && profile[1][4] > 0.0 && profile[1][4] < profile[0][4], "{profile:?}");
}

/// Ice between snow dims what is below it.
#[test]
fn a_layer_may_be_clear_ice() {
    let folder = Folder::new();
    let profile = |text: &str, depths: &str| {
        folder.write("pack.toml", text);
        rows(&folder.stdout(&format!("spectrum --layers pack.toml --wavelengths 450 --depths {depths}")), PROFILE)
    };
    let (first, second) = PACK.split_at(PACK.rfind("[[layer]]").unwrap());
    let iced = profile(&format!("{first}[[layer]]\nkind = \"ice\"\nthickness_cm = 1\n{second}"), "0,2,2.5,11.5");
    assert_eq!((iced.len(), iced[0][0]), (4, 11.5));
    // The same without ice, with the ground 1 cm higher.
    let plain = profile(PACK, "0,2,10.5");
    assert!(iced[0][5] > 0.5 && iced[3][4] < plain[2][4], "{iced:?} {plain:?}");
    // In the ice, of which 0.03 per m absorb, hardly any net flux is lost.
    assert!((iced[2][6] / iced[1][6] - 1.0).abs() < 1e-2 && iced[2][8] > 1000.0, "{iced:?}");
}

const SKY_BANDS: &str = "depth_cm,bottom_cm,band,unit,down_per_m2,up_per_m2,net_per_m2,actinic_per_m2,absorbed_per_m2,\
absorbed_per_m3,warming_k_h";

/// What the layers take is what does not reach the half-space below them, which takes the rest.
#[test]
fn a_sky_gives_bands_at_depth_and_in_layers() {
    let folder = Folder::new();
    let layers = "[[layer]]\nthickness_cm = 2\ngrain_size_um = [100, 200]\n[[layer]]\nthickness_cm = 8.5\n\
                  [[layer]]\nthickness_cm = inf\n";
    folder.write("pack.toml", format!("ice = \"picard2016\"\n{layers}"));
    let line = "spectrum --layers pack.toml --depths 0,10.5 --streams 4 --sky 25 --turbidity 2 --broadband par,solar";
    let bands = folder.stdout(line);
    let mut lines = bands.lines();
    assert_eq!(lines.next(), Some(SKY_BANDS));
    let cells: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(cells.len(), 10);
    let number = |row: usize, column: usize| cells[row][column].parse::<f64>().unwrap();
    for (first, band, unit) in [(0, "par-400-700", "µmol/s"), (5, "solar-320-2500", "W")] {
        assert!(cells[first..first + 5].iter().all(|row| row[2] == band && row[3] == unit), "{bands}");
        let [top, below] = [first, first + 1].map(|row| number(row, 6));
        let absorbed = [2, 3, 4].map(|row| number(first + row, 8));
        assert!(((absorbed[0] + absorbed[1]) / (top - below) - 1.0).abs() < 1e-7, "{bands}");
        assert!((absorbed[2] / below - 1.0).abs() < 1e-7 && number(first, 7) > number(first, 4), "{bands}");
        // A half-space has a power per area, but none per volume.
        assert!(cells[first + 4][1] == "inf" && cells[first + 4][9..].iter().all(|cell| cell.is_empty()), "{bands}");
    }
    assert!(cells[0][10].is_empty() && number(5, 10) > number(6, 10) && number(7, 10) > number(8, 10), "{bands}");
}

#[test]
fn a_sky_gives_spectra_by_day_nothing_by_night_and_sums_of_a_day() {
    let folder = Folder::new();
    folder.write("pack.toml", PACK);
    let sky =
        |sun: &str| folder.stdout(&format!("spectrum --layers pack.toml --depths 0,10.5 --streams 4 --sky {sun}"));
    let spectra = sky("25 --wavelengths 450,700");
    let header = "depth_cm,wavelength_nm,down_w_m2_nm,up_w_m2_nm,net_w_m2_nm,actinic_w_m2_nm,absorbed_w_m3_nm";
    assert_eq!((spectra.lines().next(), spectra.lines().count()), (Some(header), 5));
    let night = sky("-5 --wavelengths 450");
    assert!(night.lines().skip(1).all(|line| line.ends_with(",450,0,0,0,0,0")), "{night}");
    let day = sky("47.27,11.39,2026-02-01 --broadband par --wavelengths 400:700:50");
    assert_names(&day, &["warming_k\n", ",par-400-700,µmol,"]);
}

#[test]
fn monte_carlo_agrees_on_a_reflecting_ground() {
    let common = "spectrum --thickness 0.5 --ground-albedo 0.8 --wavelengths 600";
    let solved = rows(&stdout(common), WHOLE);
    let header = format!("{WHOLE},reflectance_se,transmittance_se,absorptance_se");
    let sampled = rows(&stdout(&format!("{common} --engine montecarlo --rays 4000")), &header);
    for quantity in 3..6 {
        let gap = (sampled[0][quantity] - solved[0][quantity]).abs();
        assert!(gap < 4.0 * sampled[0][quantity + 3], "{sampled:?} {solved:?}");
    }
}
