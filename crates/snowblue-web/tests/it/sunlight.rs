//! Sunlight, light at depth and measured curves of the web page agree with the crates below.

use serde_json::{Value, json};
use snowblue_transport::ordinates::{OrdinatesOptions, solve_stack, solve_without_errors};
use snowblue_transport::sample::SnowSample;
use snowblue_transport::slab::{Fluxes, Incidence, Slab};
use snowblue_transport::stack::{Layer, Stack};
use snowblue_transport::sunlight::{Band, BandWeights, SPECTRUM, irradiance_w_m2, photon_flux_umol_m2_s};
use snowblue_web::{depth, measured, sunlight};

const OPTIONS: fn() -> OrdinatesOptions = || OrdinatesOptions { tally_rays: 1024, ..OrdinatesOptions::default() };
const INCIDENCE: Incidence = Incidence::Beam { angle_deg: 60.0 };

/// A sample with some keys of its own.
fn sample(changes: Value) -> Value {
    let mut sample = json!({ "layers": [{ "thickness_cm": 5.0 }], "angle_deg": 60.0, "tally_rays": 1024 });
    for (key, value) in changes.as_object().unwrap() {
        sample[key] = value.clone();
    }
    sample
}

fn parsed(answer: Result<String, String>) -> Value {
    serde_json::from_str(&answer.unwrap()).unwrap()
}

/// Reading JSON may round the last bit.
fn assert_same(found: &Value, expected: f64) {
    assert!((found.as_f64().unwrap() / expected - 1.0).abs() < 1e-15, "{found} is not {expected}");
}

fn slab(wavelengths_nm: Vec<f64>) -> Slab {
    Slab { sample: SnowSample::default(), thicknesses_cm: vec![5.0], incidences: vec![INCIDENCE], wavelengths_nm }
}

#[test]
fn the_solar_spectrum_and_its_bands_are_those_of_the_engine() {
    let answer = parsed(sunlight::answer(&sample(json!({})).to_string()));
    let wavelengths_nm: Vec<f64> = (300..=2500).step_by(10).map(f64::from).collect();
    assert_eq!(answer["wavelengths_nm"], json!(wavelengths_nm));
    let rows = solve_without_errors(&slab(wavelengths_nm.clone()), &OPTIONS()).unwrap();
    for (index, row) in rows.iter().enumerate() {
        assert_same(&answer["reflectance"][index], row.fluxes.reflectance.value);
        assert_same(&answer["transmittance"][index], row.fluxes.transmittance.value);
        assert_same(&answer["absorptance"][index], row.fluxes.absorptance.value);
    }
    let fluxes: Vec<Fluxes> = rows.iter().map(|row| row.fluxes).collect();
    for (index, band) in Band::ALL.into_iter().enumerate() {
        let weights = BandWeights::new(band, &wavelengths_nm).unwrap();
        let (mean, range) = (weights.broadband(&fluxes), band.wavelength_range());
        let found = &answer["bands"][index];
        assert_eq!((&found["name"], &found["first_nm"]), (&json!(band.name()), &json!(range.first_nm)));
        let full_sun = if band == Band::Par { photon_flux_umol_m2_s } else { irradiance_w_m2 };
        assert_same(&found["full_sun"], full_sun(range));
        assert_same(&found["reflectance"], mean.reflectance.value);
        assert_same(&found["transmittance"], mean.transmittance.value);
        assert_same(&found["absorptance"], mean.absorptance.value);
    }
    assert_eq!(sunlight::sunlight_name(), SPECTRUM);
}

/// Soot and water do not change the bands, and darken all of them.
#[test]
fn soot_and_water_darken_every_band() {
    let reflectances = |layer: Value| -> Vec<f64> {
        let answer = parsed(sunlight::answer(&sample(json!({ "layers": [layer] })).to_string()));
        assert_eq!(answer["wavelengths_nm"].as_array().unwrap().last().unwrap(), &json!(2500.0));
        answer["bands"].as_array().unwrap().iter().map(|band| band["reflectance"].as_f64().unwrap()).collect()
    };
    let clean = reflectances(json!({ "thickness_cm": 5.0 }));
    let sooty = json!({ "thickness_cm": 5.0, "impurities_ng_g": { "black-carbon": 100.0 } });
    for dark in [sooty, json!({ "thickness_cm": 5.0, "water_saturation": 0.1 })].map(reflectances) {
        assert!(dark.iter().zip(&clean).all(|(dark, clean)| dark < clean), "{dark:?} {clean:?}");
    }
}

#[test]
fn light_at_depth_is_that_of_the_engine() {
    let layers = json!([{ "thickness_cm": 2.0 }, { "thickness_cm": 8.0, "density_kg_m3": 400.0 }]);
    let (depths_cm, wavelengths_nm) = (vec![0.0, 2.0, 5.0, 10.0], vec![450.0, 650.0]);
    let request = json!({
        "sample": sample(json!({ "layers": layers, "ground_albedo": 0.3 })),
        "depths_cm": depths_cm, "wavelengths_nm": wavelengths_nm,
    });
    let answer = parsed(depth::answer(&request.to_string()));
    let dense = SnowSample { density_kg_m3: 400.0, ..SnowSample::default() };
    let layer = Layer::snow;
    let stack = Stack {
        layers: vec![layer(SnowSample::default(), 2.0), layer(dense, 8.0)],
        ground_albedo: 0.3.into(),
        depths_cm,
        incidences: vec![INCIDENCE],
        wavelengths_nm,
    };
    for (profile, row) in answer.as_array().unwrap().iter().zip(solve_stack(&stack, &OPTIONS()).unwrap()) {
        assert_same(&profile["wavelength_nm"], row.whole.wavelength_nm);
        for (index, at) in row.profile.iter().enumerate() {
            assert_same(&profile["down"][index], at.down.value);
            assert_same(&profile["up"][index], at.up.value);
            assert_same(&profile["fluence"][index], at.fluence.value);
            assert_same(&profile["e_folding_depth_cm"][index], at.e_folding_depth_cm.value);
        }
    }
    let too_deep = json!({ "sample": sample(json!({})), "depths_cm": [6.0], "wavelengths_nm": [450.0] });
    assert_eq!(depth::answer(&too_deep.to_string()).unwrap_err(), "depth is 6 cm, but must lie in 0–5 cm");
}

fn curve(text: &str, quantity: &str) -> Result<String, String> {
    measured::curve(&json!({ "name": "field.csv", "text": text, "quantity": quantity }).to_string())
}

#[test]
fn a_measured_curve_is_read_as_by_the_command() {
    let read = parsed(curve("# panel\nwavelength_nm,albedo\n400,0.97\n1030.5,0.6\n", "reflectance"));
    assert_eq!(read, json!({ "wavelengths_nm": [400.0, 1030.5], "values": [0.97, 0.6], "notes": [] }));
    // Noise around 0 in the infrared.
    assert_eq!(parsed(curve("2500,-0.01\n", "reflectance"))["values"], json!([-0.01]));
    let table = "wavelength_nm,reflectance,transmittance\n400,0.9,0.1\n500,0.8,0.2\n";
    assert_eq!(parsed(curve(table, "transmittance"))["values"], json!([0.1, 0.2]));
    for (text, quantity, expected) in [
        ("400;bright", "reflectance", "field.csv:1: expected a wavelength in nm and a value, but found '400,bright'"),
        ("500\t0.9\n400\t90\n", "reflectance", "field.csv:2: albedo is 90, but must lie in -0.5–1.5"),
        (
            "400,0.9\n400,0.9",
            "reflectance",
            "field.csv:2: wavelength is 400 nm, but must lie above 400 nm, the one before",
        ),
        ("", "reflectance", "field.csv: holds no spectrum"),
        ("400,90\n", "reflectance", "field.csv:1: albedo is 90, but must lie in -0.5–1.5"),
        ("400,0.9\n2500,-0.6\n", "reflectance", "field.csv:2: albedo is -0.6, but must lie in -0.5–1.5"),
        ("400,3\n", "transmittance", "field.csv:1: transmittance is 3, but must lie in -0.5–2"),
        (
            "wavelength_nm,reflectance,angle_deg\n400,0.9,0\n410,0.9,0\n400,0.9,60\n",
            "reflectance",
            "field.csv: holds 2 spectra, but must hold one",
        ),
    ] {
        let message = curve(text, quantity).unwrap_err();
        assert!(message.starts_with(expected), "{message}");
    }
}

/// Files as instruments and their programs write them hold the same curve.
#[test]
fn files_of_instruments_are_read_as_they_are_written() {
    let expected = json!([[400.0, 500.0], [0.97, 0.6]]);
    for (text, notes) in [
        ("400\t0.97\n500\t0.6\n", json!([])),
        ("Wellenlänge;Albedo\n400;0,97\n500;0,6;\n", json!([])),
        ("nm;R\n500;0,6\n400;0,97\n", json!([])),
        ("Wavelength (nm)\tReflectance (%)\n400\t97\n500\t60\n", json!(["its values are in percent"])),
        ("Wavelength [µm],Reflectance\n0.4,0.97\n0.5,0.6\n", json!(["its wavelengths are in µm"])),
        ("wavelength_um,reflectance,sd\n0.4,0.97,NaN\n0.5,0.6,0\n", json!(["its wavelengths are in µm"])),
        ("400,0.97\n450,NaN\n500,0.6\n", json!(["rows without a value, which are left out: 1"])),
        (
            "ASD FieldSpec\nGPS\tnone\nWavelength\tx\n400\t0.97\n500\t0.6\n",
            json!(["lines above the names of its columns, which are not read: 2"]),
        ),
    ] {
        let read = parsed(curve(text, "reflectance"));
        assert_eq!(json!([read["wavelengths_nm"], read["values"]]), expected, "{text}");
        assert_eq!(read["notes"], notes, "{text}");
    }
}

/// A curve that is the computed one and a constant differs from it by the constant.
#[test]
fn the_difference_of_a_measured_curve_is_that_from_the_engine() {
    let wavelengths_nm = vec![350.0, 417.0, 865.5, 1240.0];
    let rows = solve_without_errors(&slab(wavelengths_nm[1..3].to_vec()), &OPTIONS()).unwrap();
    let offsets = [0.03, -0.01];
    let mut values = vec![0.5; 4];
    for (place, (row, offset)) in rows.iter().zip(offsets).enumerate() {
        values[place + 1] = row.fluxes.reflectance.value + offset;
    }
    let compared = |first_nm: f64, last_nm: f64| {
        let request = json!({
            "sample": sample(json!({})), "quantity": "reflectance", "wavelengths_nm": wavelengths_nm, "values": values,
            "first_nm": first_nm, "last_nm": last_nm,
        });
        measured::difference(&request.to_string())
    };
    let found = parsed(compared(400.0, 1000.0));
    assert_eq!((&found["count"], &found["first_nm"], &found["last_nm"]), (&json!(2), &json!(417.0), &json!(865.5)));
    let near = |key: &str, expected: f64| assert!((found[key].as_f64().unwrap() - expected).abs() < 1e-14, "{found}");
    near("root_mean_square", (0.5 * (0.03_f64.powi(2) + 0.01_f64.powi(2))).sqrt());
    near("mean", 0.01);
    let message = compared(2000.0, 2500.0).unwrap_err();
    assert_eq!(message, "no wavelength of the measured curve lies in 2000–2500 nm");
}
