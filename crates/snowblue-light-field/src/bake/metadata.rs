//! What the files say about their attributes.

use serde_json::{Value, json};

use crate::bake::{BakedObject, BakedScene, Channels};
use snowblue_scene::provenance::Provenance;

/// What is said of the whole file: names and values.
pub(super) fn of_file(baked: &BakedScene, provenance: &Provenance) -> Vec<(&'static str, String)> {
    let weighting = match baked.channels {
        Channels::Rgb => {
            "W/m2 as linear sRGB, unclipped; 1 is the luminance of 1 W/m2 of equal-energy light over 400-700 nm"
        }
        Channels::Spectrum => "W/(m2 nm)",
    };
    let mut entries = vec![
        ("generator", generator(provenance)),
        ("content", "net flux J of light outwards through the surface of snow; negative on lit faces".to_owned()),
        ("units", format!("positions in m; fluxes in {weighting}")),
        ("shading", "L(mu) = sum of R0 F over direct lights + K(mu) J / pi, R0 nearly 1/pi, J a sum".to_owned()),
    ];
    for name in ["scene", "table", "max bounces", "white"] {
        entries.extend(provenance.get(name).map(|value| (key(name), value.to_owned())));
    }
    entries
}

/// The program, for files that name it.
pub(super) fn generator(provenance: &Provenance) -> String {
    format!("snowblue {}", provenance.get("version").unwrap_or_default())
}

/// The key of a name in the provenance.
fn key(name: &str) -> &'static str {
    match name {
        "scene" => "scene_hash",
        "table" => "table_hash",
        "max bounces" => "max_bounces",
        _ => "white",
    }
}

/// The names of the attributes, lamps first, by a function of the lamp's number, and what each of them is.
pub(super) fn attributes(baked: &BakedScene, lamp: impl Fn(usize) -> String, sky: &str) -> Vec<(String, &'static str)> {
    let lamps = baked.lamps.iter().enumerate().map(|(number, one)| (lamp(number), one.kind));
    lamps.chain([(sky.to_owned(), "sky, and all light by way of other surfaces")]).collect()
}

/// What is said of the snow of an object: names and values.
pub(super) fn of_snow(object: &BakedObject, attributes: &[(String, &'static str)]) -> Vec<(&'static str, Value)> {
    let snow = &object.snow;
    vec![
        ("escape_polynomial", json!(snow.escape.coefficients)),
        ("escape_greatest_error", json!(snow.escape.greatest_error)),
        ("extrapolation_length", json!(snow.extrapolation)),
        ("transport_mean_free_path_m", json!(snow.transport_length_m)),
        ("greatest_edge_m", json!(snow.step_m)),
        ("glsl", json!(glsl(object, attributes))),
    ]
}

/// A line of GLSL that shades the snow of an object.
fn glsl(object: &BakedObject, attributes: &[(String, &'static str)]) -> String {
    let [k0, k1, k2, k3] = object.snow.escape.coefficients;
    let names: Vec<&str> = attributes.iter().map(|(name, _)| name.as_str()).collect();
    format!(
        "vec3 radiance = (irradiance + ({k0:.6} + mu * ({k1:.6} + mu * ({k2:.6} + mu * ({k3:.6})))) * ({})) / \
         3.14159265; // mu: cosine between normal and direction to the eye; irradiance: of all light on the surface",
        names.join(" + ")
    )
}
