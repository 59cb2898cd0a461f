//! `snowblue sky`: daylight on the ground.

use crate::shell::{assert_names, stderr, stdout};

const HEADER: &str = "wavelength_nm,direct_normal_w_m2_nm,direct_w_m2_nm,diffuse_w_m2_nm,global_w_m2_nm";

/// The numbers of a CSV.
fn rows(line: &str) -> Vec<Vec<f64>> {
    let text = stdout(line);
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(HEADER));
    lines.map(|line| line.split(',').map(|field| field.parse().unwrap()).collect()).collect()
}

#[test]
fn parts_add_up_at_an_elevation() {
    let rows = rows("sky --elevation 30 --turbidity 2 --wavelengths 450,650");
    assert_eq!(rows.len(), 2);
    for row in &rows {
        let [_, direct_normal, direct, diffuse, global] = row[..] else { panic!("{row:?}") };
        // Nine significant digits each.
        assert!((direct - 0.5 * direct_normal).abs() < 1e-8 && (direct + diffuse - global).abs() < 1e-8, "{row:?}");
    }
    assert!(rows[0][3] > 2.0 * rows[1][3], "the sky is blue: {rows:?}");
}

#[test]
fn defaults_cover_the_model() {
    let rows = rows("sky --elevation 30");
    assert_eq!(rows.len(), 41);
    assert!((rows[0][0] - 320.0).abs() < 1e-9 && (rows[40][0] - 720.0).abs() < 1e-9);
}

/// The example of Reda & Andreas 2004 (doi:10.1016/j.solener.2003.12.003): elevation 39.87° without and 39.89° with
/// refraction, azimuth 194.34°.
#[test]
fn place_and_time_give_the_sun() {
    let place = "sky --latitude 39.742476 --longitude -105.1786 --time 2003-10-17T12:30:30-07:00";
    let message = stderr(place);
    assert_names(&message, &["sky clear", "turbidity 3", "ground albedo 0.8", "sun elevation 39.87°"]);
    assert_names(&message, &["sun azimuth 194.34°", "illuminance ", " lx direct, ", "PAR ", " µmol/(m² s) diffuse"]);
    let refracted = stderr(&format!("{place} --refraction"));
    assert_names(&refracted, &["sun elevation 39.89°"]);
}

#[test]
fn an_overcast_sky_has_no_sun() {
    let overcast = "sky --elevation 30 --overcast --wavelengths 450,650";
    for row in rows(overcast) {
        assert!(row[1].abs() < 1e-300 && row[2].abs() < 1e-300 && row[3] > 0.05, "{row:?}");
    }
    assert_names(&stderr(overcast), &["sky overcast", "illuminance 0 lx direct, 10800 lx diffuse"]);
}

#[test]
fn json_has_metadata_and_rows() {
    let text = stdout("sky --elevation 30 --wavelengths 550 --format json");
    let document: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(document["metadata"]["sun elevation"], "30.00°");
    assert_eq!(document["rows"].as_array().unwrap().len(), 1);
}

/// At night there is no light; vapour dims its band at 940 nm and leaves the window at 1040 nm.
#[test]
fn the_night_is_dark_and_vapour_dims_its_bands() {
    for row in rows("sky --elevation -3.2 --wavelengths 450,1000") {
        assert!(row[1..].iter().all(|value| value.to_bits() == 0), "{row:?}");
    }
    let infrared = "sky --elevation 30 --wavelengths 940,1040 --precipitable-water";
    let [dry, wet] = ["0.1", "3"].map(|water| rows(&format!("{infrared} {water}")));
    assert!(wet[0][4] < 0.6 * dry[0][4] && (wet[1][4] / dry[1][4] - 1.0).abs() < 0.01, "{dry:?} {wet:?}");
}
