//! False colour: images of infrared wavelengths, from a table that holds them.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

mod snow;

use snow::{CAMERA, SAMPLE, SNOW};
use snowblue_color::LinearRgb;
use snowblue_database::{Axes, CompressedTable, PcaSnow, Space, fill};
use snowblue_render::files::FilesInMemory;
use snowblue_render::{FalseColor, SceneFile, render};

const COLOUR: FalseColor = FalseColor { red_nm: 1030.0, green_nm: 850.0, blue_nm: 550.0 };

/// A table of one snow from 400 to 1300 nm, every 30 nm.
fn infrared() -> CompressedTable {
    let axes = Axes {
        grain_sizes_um: vec![SAMPLE.grain_size_um],
        facetness: vec![SAMPLE.facetness],
        densities_kg_m3: vec![SAMPLE.density_kg_m3],
        thicknesses_cm: vec![0.1, 0.5, 1.0, 2.0, 5.0],
        wavelengths_nm: (0..31).map(|k| 400.0 + 30.0 * f64::from(k)).collect(),
        ..Axes::paper()
    };
    let table = fill::fill(&axes, &fill::FillOptions::by_ordinates(1 << 12), &|_| {}).unwrap();
    CompressedTable::new(&table, Space::Log, 5).unwrap()
}

/// A picture of one pixel in false colour, of a scene with these files.
fn rendered(table: &CompressedTable, text: &str, files: &[(&str, &str)]) -> LinearRgb {
    let mut scene = SceneFile::parse(format!("{CAMERA}{text}"), "scene.toml").unwrap().description;
    scene.film.false_color = Some(COLOUR);
    let mut in_memory = FilesInMemory::default();
    files.iter().for_each(|(name, content)| in_memory.insert(*name, *content));
    let scene = scene.build(table, &in_memory).unwrap_or_else(|error| panic!("{error}"));
    LinearRgb::from_xyz(render(&scene, &|_| {}).film.pixels()[0])
}

/// Two centimetres of snow between the camera and a distant light.
fn through_snow(table: &CompressedTable, light: &str) -> LinearRgb {
    let slab = "[[object]]\nshape = \"box\"\nsize = [50, 0.02, 50]\nmaterial = \"snow\"\n";
    rendered(table, &format!("{SNOW}path = \"normal\"\n{slab}{light}"), &[])
}

/// A diffuse wall, lit from behind the camera.
fn wall(table: &CompressedTable, keys: &str) -> LinearRgb {
    let wall = "[[object]]\nshape = \"box\"\nsize = [50, 0.02, 50]\nmaterial = \"paint\"\n[[light]]\n\
        type = \"directional\"\ndirection = [0, 1, 0]\nirradiance_w_m2 = 1\n";
    let rising = ("rising.csv", "400,0\n1300,0.9\n");
    rendered(table, &format!("[material.paint]\ntype = \"diffuse\"\n{keys}\n{wall}"), &[rising])
}

fn light(illuminant: &str) -> String {
    format!(
        "[[light]]\ntype = \"point\"\nposition = [0, 1e5, 0]\nilluminant = \"{illuminant}\"\n\
         radiant_intensity_w_sr = 1e10\n"
    )
}

#[test]
fn channels_are_t_e_over_pi_at_three_wavelengths() {
    let table = infrared();
    let seen = through_snow(&table, &light("D65"));
    let mut transmittance = [0.0; 31];
    let snow = PcaSnow::new(&table, &SAMPLE).unwrap();
    snow.transmittance(2.0, 0.0, &mut transmittance);
    // The light is so far away that the irradiance is 1 W/m² everywhere.
    for (channel, place) in [(seen.r, 21), (seen.g, 15), (seen.b, 5)] {
        let expected = f64::from(transmittance[place]) / std::f64::consts::PI;
        assert!((channel / expected - 1.0).abs() < 1e-4, "{seen:?}: {channel}, not {expected}");
    }
    assert!(seen.b > 3.0 * seen.r, "snow transmits less infrared: {seen:?}");
    assert_eq!(through_snow(&table, &light("A")), seen, "lights are white in false colour");
}

#[test]
fn reflectances_use_the_wavelengths_of_the_table_and_rgb_colours_are_grey() {
    let table = infrared();
    let LinearRgb { r, g, b } = wall(&table, "reflectance_spectrum = \"rising.csv\"");
    let grey = wall(&table, "reflectance_rgb = [0.2, 0.5, 0.1]");
    let luminance = LinearRgb { r: 0.2, g: 0.5, b: 0.1 }.luminance();
    let expected = [0.63, 0.45, 0.15, luminance, luminance, luminance].map(|share| share / std::f64::consts::PI);
    for (channel, expected) in [r, g, b, grey.r, grey.g, grey.b].into_iter().zip(expected) {
        // Tolerance: single precision of the light and of the sums.
        assert!((channel / expected - 1.0).abs() < 1e-5, "{channel} for {expected}");
    }
}

#[test]
fn images_of_visible_light_need_the_visible_grid() {
    let mut file = SceneFile::parse(format!("{CAMERA}{SNOW}"), "scene.toml").unwrap();
    let mut refused = |table: &CompressedTable, false_color| {
        file.description.film.false_color = false_color;
        file.build(table).unwrap_err().to_string()
    };
    let message = refused(&infrared(), None);
    assert!(message.contains("700 nm") && message.contains("10 nm"), "{message}");
    let message = refused(&snow::analytic_table(), Some(COLOUR));
    assert!(message.contains("1030 nm") && message.contains("400–700 nm"), "{message}");
}
