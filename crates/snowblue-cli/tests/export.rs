//! `snowblue export`: text for shaders, look-up tables, and errors.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use shell::{assert_names, assert_refused, stdout};

#[test]
fn functions_state_their_snow_and_their_error() {
    let wgsl = stdout(&["export", "wgsl", "--grain-size", "800", "--illuminant", "A"]);
    assert_names(&wgsl, &["750–850 µm", "illuminant: A", "greatest error", "fn snow_transmittance(thickness_m: f32"]);
    let glsl = stdout(&["export", "glsl"]);
    assert_names(&glsl, &["vec3 snow_transmittance(float thickness_m", "vec3 snow_reflectance(float thickness_m"]);
    let osl = stdout(&["export", "osl"]);
    assert_names(&osl, &["color snow_transmittance(float thickness_m", "shader snow(", "output closure color BSDF"]);
}

/// A shader must be short to be compiled and read: 12 kB at most, and shorter the more error it may add.
#[test]
fn functions_are_as_short_as_their_error_allows() {
    let length = |error: &str| {
        let text = stdout(&["export", "wgsl", "--added-error", error]);
        let (_, stated) = text.split_once("greatest error of the fit: ").unwrap();
        let stated: f64 = stated.split(' ').next().unwrap().parse().unwrap();
        // The fit's own error is below 6e-4, and two digits are written.
        let added: f64 = error.parse().unwrap();
        assert!(stated > added && stated < 1.05 * (added + 6e-4), "{stated} {added}");
        text.len()
    };
    let [exact, default, rough] = ["0.0001", "0.005", "0.01"].map(length);
    assert!(exact > default && default > rough && default < 12_000, "{exact} {default} {rough}");
    assert_eq!(stdout(&["export", "wgsl"]).len(), default);
    for error in ["0", "0.2", "nan"] {
        assert_refused(&["export", "wgsl", "--added-error", error], &["--added-error"]);
    }
}

#[test]
fn a_table_is_an_image_of_its_quantity() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    stdout(&["export", "lut", "-o", &file("t.exr")]);
    stdout(&["export", "lut", "--quantity", "reflectance", "-o", &file("r.exr")]);
    let pixels = |name: &str| exr::prelude::read_first_flat_layer_from_file(file(name)).unwrap().layer_data;
    let (transmittance, reflectance) = (pixels("t.exr"), pixels("r.exr"));
    assert_eq!((transmittance.size.x(), transmittance.size.y()), (256, 64));
    // Green is Y; the last row is normal incidence, the last column 1 m.
    let last = |layer: &exr::prelude::Layer<exr::prelude::AnyChannels<exr::prelude::FlatSamples>>| {
        let green = layer.channel_data.list.iter().find(|channel| channel.name == *"G").unwrap();
        green.sample_data.value_by_flat_index(256 * 64 - 1).to_f32()
    };
    assert!(last(&transmittance) < -9.0 && last(&reflectance) > -0.1);
}

#[test]
fn bad_options_are_refused_before_work() {
    assert_refused(&["export", "lut", "-o", "snow.png"], &["snow.png", ".exr or .json"]);
    assert_refused(&["export", "wgsl", "-o", "missing/snow.wgsl"], &["missing/snow.wgsl", "folder"]);
    assert_refused(&["export", "wgsl", "--max-thickness", "5000"], &["5000 cm", "0.1–1000 cm"]);
    assert_refused(&["export", "wgsl", "--impurity", "black-carbon=1e6"], &["no light", "smaller greatest thickness"]);
    assert_refused(&["export", "wgsl", "--water-saturation", "1"], &["fit to 100 cm", "error", "0.01"]);
    assert_refused(&["export", "glsl", "--density", "2000"], &["density", "2000 kg/m³", "10–900 kg/m³"]);
}

/// The values of an attribute or a socket.
fn numbers(text: &str, name: &str) -> Vec<f64> {
    let line = text.lines().find(|line| line.contains(name)).unwrap();
    let after = line.split_once(name).unwrap().1;
    let words = after.split(|sign: char| !(sign.is_ascii_digit() || ".e-".contains(sign)));
    words.filter_map(|word| word.parse().ok()).collect()
}

#[test]
fn presets_state_their_snow_and_their_errors() {
    let files = ["openpbr", "arnold", "usd", "principled"].map(|format| stdout(&["export", format, "--snow", "fresh"]));
    for text in &files {
        assert_names(
            text,
            &["snowblue", "kind: fresh", "ice: warren2008", "white: D65", "albedo, deep", "through 5 cm"],
        );
        assert_names(text, &["through 15 cm", "through 30 cm", "half radius, mm", "Three channels"]);
    }
    let [open_pbr, arnold, usd, principled] = files;
    assert_names(&open_pbr, &["<open_pbr_surface", "linear ACEScg", "colorspace=\"acescg\"", "<surfacematerial"]);
    assert_names(&arnold, &["<standard_surface", "leaves the inversion to the renderer"]);
    assert_names(&usd, &["#usda 1.0", "UsdPreviewSurface", "ND_open_pbr_surface_surfaceshader", "lin_ap1_scene"]);
    assert_names(&principled, &["import bpy", "linear sRGB", "256 flights", "def snow_material"]);
    // Three files of one medium.
    let colors = numbers(&open_pbr, "subsurface_color");
    assert_eq!(colors.len(), 4, "{colors:?}");
    assert_eq!(numbers(&arnold, "\"subsurface_color"), colors);
    assert_eq!(numbers(&usd, "subsurface_color"), colors[1..]);
}

/// A metre has 100 cm, and a colour has no unit.
#[test]
fn radii_are_in_units_of_the_scene() {
    let of = |unit: &str| stdout(&["export", "openpbr", "--scene-unit", unit, "--color-space", "rec2020"]);
    let [metres, millimetres] = ["m", "mm"].map(of);
    let radius = |text: &str| numbers(text, "\"subsurface_radius\" type=\"float\" value=")[0];
    // Seven digits are written.
    assert!((radius(&millimetres) / radius(&metres) / 1000.0 - 1.0).abs() < 1e-6);
    for name in ["subsurface_color", "subsurface_radius_scale", "subsurface_scatter_anisotropy"] {
        assert_eq!(numbers(&metres, name), numbers(&millimetres, name));
    }
    let usd = stdout(&["export", "usd", "--scene-unit", "cm", "--color-space", "rec2020"]);
    assert_names(&usd, &["metersPerUnit = 0.01"]);
    assert!((numbers(&usd, "subsurface_radius =")[0] / radius(&metres) / 100.0 - 1.0).abs() < 1e-6);
}

#[test]
fn a_preset_is_written_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    for (format, ending, other, end) in [
        ("openpbr", "mtlx", "xml", "</materialx>"),
        ("arnold", "mtlx", "usda", "</materialx>"),
        ("usd", "usda", "usd", "}"),
        ("principled", "py", "blend", "snow_material()"),
    ] {
        let (path, refused) = (file(&format!("snow.{ending}")), file(&format!("snow.{other}")));
        assert_eq!(stdout(&["export", format, "-o", &path]), "");
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.trim_end().ends_with(end), "{text}");
        assert_refused(&["export", format, "-o", &refused], &[&refused, &format!("must end in .{ending}")]);
        std::fs::remove_file(path).unwrap();
    }
    assert_refused(&["export", "usd", "--density", "5"], &["density is 5 kg/m³", "10–900 kg/m³"]);
    assert_refused(&["export", "usd", "--scene-unit", "km"], &["km", "--scene-unit"]);
    assert_refused(&["export", "arnold", "-o", "missing/snow.mtlx"], &["missing/snow.mtlx", "folder"]);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
