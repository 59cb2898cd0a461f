//! Answers of the web page's engine agree with the crates below, and its refusals have their words.

use serde_json::{Value, json};
use snowblue_transport::ordinates::{OrdinatesOptions, solve};
use snowblue_transport::slab::{Incidence, Slab};
use snowblue_web::spectrum::answer;

fn request(changes: Value) -> Value {
    let mut request = json!({
        "sample": { "layers": [{ "thickness_cm": 5.0 }], "angle_deg": 60.0, "tally_rays": 1024 },
        "illuminant": "D65",
        "observer": "1931",
        "exposure": "auto",
    });
    for (key, value) in changes.as_object().unwrap() {
        let is_of_sample = ["layers", "ground_albedo", "angle_deg"].contains(&key.as_str());
        let part = if is_of_sample { &mut request["sample"] } else { &mut request };
        part[key] = value.clone();
    }
    request
}

fn answered(changes: Value) -> Value {
    serde_json::from_str(&answer(&request(changes).to_string()).unwrap()).unwrap()
}

fn refusal(changes: Value) -> String {
    answer(&request(changes).to_string()).unwrap_err()
}

#[test]
fn a_slab_is_that_of_the_engine() {
    let answer = answered(json!({ "standard_errors": true }));
    let slab = Slab {
        sample: Default::default(),
        thicknesses_cm: vec![5.0],
        incidences: vec![Incidence::Beam { angle_deg: 60.0 }],
        wavelengths_nm: (400..=700).step_by(10).map(f64::from).collect(),
    };
    let rows = solve(&slab, &OrdinatesOptions { tally_rays: 1024, ..OrdinatesOptions::default() }).unwrap();
    for (k, row) in rows.iter().enumerate() {
        for (name, estimate) in [
            ("reflectance", row.fluxes.reflectance),
            ("transmittance", row.fluxes.transmittance),
            ("absorptance", row.fluxes.absorptance),
        ] {
            // The three wavelengths of the paper are tallied too, but change neither the ends of the range nor the
            // strongest absorption. Reading JSON may round the last bit.
            let same = |one: &Value, other: f64| (one.as_f64().unwrap() / other - 1.0).abs() < 1e-15;
            assert!(same(&answer[name][k], estimate.value), "{name} {k}");
            assert!(same(&answer[format!("{name}_se")][k], estimate.standard_error), "{name} {k}");
        }
    }
}

/// Layers of the same snow are one slab, and a white ground returns what would go on.
#[test]
fn layers_and_ground_change_what_they_should() {
    let number = |answer: &Value, name: &str| answer[name][5].as_f64().unwrap();
    let slab = answered(json!({}));
    let layers = answered(json!({ "layers": [{ "thickness_cm": 2.0 }, { "thickness_cm": 3.0 }] }));
    for name in ["reflectance", "transmittance"] {
        // Adding layers repeats sums in another order.
        assert!((number(&slab, name) / number(&layers, name) - 1.0).abs() < 1e-6, "{name}");
    }
    let on_white = answered(json!({ "ground_albedo": 1.0 }));
    let [white, black] = [&on_white, &slab].map(|answer| number(answer, "reflectance"));
    assert!(white > 0.99 && black < white - 0.02, "{white} {black}");
}

#[test]
fn thick_snow_lets_blue_light_through() {
    let answer = answered(json!({ "layers": [{ "thickness_cm": 30.0 }], "angle_deg": 0.0 }));
    let [r, g, b] = [0, 1, 2].map(|channel| answer["transmitted"]["linear_rgb"][channel].as_f64().unwrap());
    assert!(b > g && g > r && b > 0.0, "{r} {g} {b}");
    // At automatic exposure the greatest channel is 0.9, in sRGB 243.
    assert_eq!(&answer["transmitted"]["hex"].as_str().unwrap()[5..], "f3");
}

#[test]
fn refusals_name_quantity_value_and_range() {
    let cases = [
        (json!({ "angle_deg": 95.0 }), "angle is 95°, but must lie in 0–89.99°"),
        (
            json!({ "layers": [{ "thickness_cm": 1.0, "density_kg_m3": 5000.0 }] }),
            "density_kg_m3 is 5000 kg/m³, but must lie in 10–900 kg/m³",
        ),
        (json!({ "layers": [] }), "layer"),
        (json!({ "layers": [{ "thickness_cm": 1.0, "depth": 1.0 }] }), "unknown field `depth`"),
        (json!({ "layers": [{ "thickness_cm": 1.0, "impurities_ng_g": { "gold": 1.0 } }] }), "gold"),
        (json!({ "illuminant": "D64" }), "D64"),
        (json!({ "angle_deg": "flat" }), "'flat' is neither an angle in degrees nor 'diffuse'"),
        (json!({ "exposure": "dark" }), "'dark' is neither a number of stops nor 'auto'"),
    ];
    for (changes, words) in cases {
        let message = refusal(changes);
        assert!(message.contains(words), "{message}");
    }
    assert!(answer("{").unwrap_err().contains("line 1"));
}
