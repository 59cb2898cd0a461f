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
