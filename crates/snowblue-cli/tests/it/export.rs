//! `snowblue export`: text for shaders, look-up tables, and errors.

use crate::shell::{Folder, assert_names, stdout};

#[test]
fn functions_state_their_snow_and_their_error() {
    let wgsl = stdout("export wgsl --grain-size 800 --illuminant A");
    assert_names(&wgsl, &["750–850 µm", "illuminant: A", "greatest error", "fn snow_transmittance(thickness_m: f32"]);
    let glsl = stdout("export glsl");
    assert_names(&glsl, &["vec3 snow_transmittance(float thickness_m", "vec3 snow_reflectance(float thickness_m"]);
    let osl = stdout("export osl");
    assert_names(&osl, &["color snow_transmittance(float thickness_m", "shader snow(", "output closure color BSDF"]);
}

/// A shader must be short to be compiled and read: 12 kB at most, and shorter the more error it may add. By default it
/// may add 0.005.
#[test]
fn functions_are_as_short_as_their_error_allows() {
    let length = |(option, added): (&str, f64)| {
        let text = stdout(&format!("export wgsl {option}"));
        let (_, stated) = text.split_once("greatest error of the fit: ").unwrap();
        let stated: f64 = stated.split(' ').next().unwrap().parse().unwrap();
        // The fit's own error is below 6e-4, and two digits are written.
        assert!(stated > added && stated < 1.05 * (added + 6e-4), "{stated} {added}");
        text.len()
    };
    let [exact, default, rough] =
        [("--added-error 0.0001", 0.0001), ("", 0.005), ("--added-error 0.01", 0.01)].map(length);
    assert!(exact > default && default > rough && default < 12_000, "{exact} {default} {rough}");
}

/// What is found only by the fit.
#[test]
fn snow_that_cannot_be_fitted_is_refused() {
    let folder = Folder::new();
    let words = ["no light", "smaller greatest thickness"];
    folder.assert_refused("export wgsl --impurity black-carbon=1e6", &words);
    folder.assert_refused("export wgsl --water-saturation 1", &["fit to 100 cm", "error", "0.01"]);
}

#[test]
fn a_table_is_an_image_of_its_quantity() {
    let folder = Folder::new();
    folder.stdout("export lut -o t.exr");
    folder.stdout("export lut --quantity reflectance -o r.exr");
    let pixels = |name: &str| exr::prelude::read_first_flat_layer_from_file(folder.path(name)).unwrap().layer_data;
    let (transmittance, reflectance) = (pixels("t.exr"), pixels("r.exr"));
    assert_eq!((transmittance.size.x(), transmittance.size.y()), (256, 64));
    // Green is Y; the last row is normal incidence, the last column 1 m.
    let last = |layer: &exr::prelude::Layer<exr::prelude::AnyChannels<exr::prelude::FlatSamples>>| {
        let green = layer.channel_data.list.iter().find(|channel| channel.name == *"G").unwrap();
        green.sample_data.value_by_flat_index(256 * 64 - 1).to_f32()
    };
    assert!(last(&transmittance) < -9.0 && last(&reflectance) > -0.1);
}

/// The values of an attribute or a socket.
fn numbers(text: &str, name: &str) -> Vec<f64> {
    let line = text.lines().find(|line| line.contains(name)).unwrap();
    let after = line.split_once(name).unwrap().1;
    let words = after.split(|sign: char| !(sign.is_ascii_digit() || ".e-".contains(sign)));
    words.filter_map(|word| word.parse().ok()).collect()
}

/// Writes a preset of fresh snow, which states its snow and its errors, is whole, and leaves no other file.
fn preset(format: &str, ending: &str, end: &str) -> String {
    let folder = Folder::new();
    let name = format!("snow.{ending}");
    assert_eq!(folder.stdout(&format!("export {format} --snow fresh -o {name}")), "");
    assert_eq!(folder.files().len(), 1);
    let text = folder.text(&name);
    assert_names(&text, &["snowblue", "kind: fresh", "ice: warren2008", "white: D65", "albedo, deep"]);
    assert_names(&text, &["through 5 cm", "through 15 cm", "through 30 cm", "half radius, mm", "Three channels"]);
    assert!(text.trim_end().ends_with(end), "{text}");
    text
}

/// A metre has 100 cm, and a colour has no unit.
#[test]
fn presets_state_their_snow_and_their_errors_in_units_of_the_scene() {
    let open_pbr = preset("openpbr --scene-unit m", "mtlx", "</materialx>");
    assert_names(&open_pbr, &["<open_pbr_surface", "linear ACEScg", "colorspace=\"acescg\"", "<surfacematerial"]);
    let arnold = preset("arnold", "mtlx", "</materialx>");
    assert_names(&arnold, &["<standard_surface", "leaves the inversion to the renderer"]);
    let usd = preset("usd --scene-unit cm", "usda", "}");
    assert_names(&usd, &["#usda 1.0", "UsdPreviewSurface", "ND_open_pbr_surface_surfaceshader", "lin_ap1_scene"]);
    assert_names(&usd, &["metersPerUnit = 0.01"]);
    // Three files of one medium.
    let colors = numbers(&open_pbr, "subsurface_color");
    assert_eq!(colors.len(), 4, "{colors:?}");
    assert_eq!(numbers(&arnold, "\"subsurface_color"), colors);
    assert_eq!(numbers(&usd, "subsurface_color"), colors[1..]);

    let millimetres = stdout("export openpbr --snow fresh --scene-unit mm");
    for name in ["subsurface_color", "subsurface_radius_scale", "subsurface_scatter_anisotropy"] {
        assert_eq!(numbers(&open_pbr, name), numbers(&millimetres, name));
    }
    let radius = |text: &str| numbers(text, "\"subsurface_radius\" type=\"float\" value=")[0];
    // Seven digits are written.
    assert!((radius(&millimetres) / radius(&open_pbr) / 1000.0 - 1.0).abs() < 1e-6);
    assert!((numbers(&usd, "subsurface_radius =")[0] / radius(&open_pbr) / 100.0 - 1.0).abs() < 1e-6);
}

#[test]
fn a_script_for_blender_states_its_snow_and_its_errors() {
    let principled = preset("principled", "py", "snow_material()");
    assert_names(&principled, &["import bpy", "linear sRGB", "256 flights", "def snow_material"]);
}
