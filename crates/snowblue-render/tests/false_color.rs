//! Pictures of wavelengths that no eye sees, from a table that holds them.

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
fn seen(table: &CompressedTable, text: &str, files: &[(&str, &str)]) -> LinearRgb {
    let mut scene = SceneFile::parse(format!("{CAMERA}{text}"), "scene.toml").unwrap().description;
    scene.film.false_color = Some(COLOUR);
    let mut in_memory = FilesInMemory::default();
    files.iter().for_each(|(name, content)| in_memory.insert(*name, *content));
    let scene = scene.build(table, &in_memory).unwrap_or_else(|error| panic!("{error}"));
    LinearRgb::from_xyz(render(&scene, &|_| {}).film.pixels()[0])
}

/// Two centimetres of snow between the eye and a far lamp.
fn through_snow(table: &CompressedTable, lamp: &str) -> LinearRgb {
    let slab = "[[object]]\nshape = \"box\"\nsize = [50, 0.02, 50]\nmaterial = \"snow\"\n";
    seen(table, &format!("{SNOW}path = \"normal\"\n{slab}{lamp}"), &[])
}

/// A wall of paint before the eye, lit from behind it.
fn paint(table: &CompressedTable, keys: &str) -> LinearRgb {
    let wall = "[[object]]\nshape = \"box\"\nsize = [50, 0.02, 50]\nmaterial = \"paint\"\n[[light]]\n\
        type = \"directional\"\ndirection = [0, 1, 0]\nirradiance_w_m2 = 1\n";
    let rising = ("rising.csv", "400,0\n1300,0.9\n");
    seen(table, &format!("[material.paint]\ntype = \"diffuse\"\n{keys}\n{wall}"), &[rising])
}

fn lamp(illuminant: &str) -> String {
    format!(
        "[[light]]\ntype = \"point\"\nposition = [0, 1e5, 0]\nilluminant = \"{illuminant}\"\n\
         radiant_intensity_w_sr = 1e10\n"
    )
}

/// T E/π at three wavelengths, with the lamp's irradiance alike at all of them.
#[test]
fn channels_are_transmittances_of_the_table() {
    let table = infrared();
    let seen = through_snow(&table, &lamp("D65"));
    let mut transmittance = [0.0; 31];
    let snow = PcaSnow::new(&table, &SAMPLE).unwrap();
    snow.transmittance(2.0, 0.0, &mut transmittance);
    // The lamp is so far away that irradiance is 1 W/m² everywhere.
    for (channel, place) in [(seen.r, 21), (seen.g, 15), (seen.b, 5)] {
        let expected = f64::from(transmittance[place]) / std::f64::consts::PI;
        assert!((channel / expected - 1.0).abs() < 1e-4, "{seen:?}: {channel}, not {expected}");
    }
    assert!(seen.b > 3.0 * seen.r, "snow passes less of the infrared: {seen:?}");
    assert_eq!(through_snow(&table, &lamp("A")), seen, "lamps are white in false colour");
}

#[test]
fn paints_reflect_at_the_tables_wavelengths_and_colours_are_grey() {
    let table = infrared();
    let LinearRgb { r, g, b } = paint(&table, "reflectance_spectrum = \"rising.csv\"");
    let grey = paint(&table, "reflectance_rgb = [0.2, 0.5, 0.1]");
    let luminance = LinearRgb { r: 0.2, g: 0.5, b: 0.1 }.luminance();
    let expected = [0.63, 0.45, 0.15, luminance, luminance, luminance].map(|share| share / std::f64::consts::PI);
    for (channel, expected) in [r, g, b, grey.r, grey.g, grey.b].into_iter().zip(expected) {
        // The lamp's single precision, and that of the sums.
        assert!((channel / expected - 1.0).abs() < 1e-5, "{channel} for {expected}");
    }
}

#[test]
fn eyes_need_the_visible_grid() {
    let mut file = SceneFile::parse(format!("{CAMERA}{SNOW}"), "scene.toml").unwrap();
    let mut refused = |table: &CompressedTable, false_color| {
        file.description.film.false_color = false_color;
        file.build(table).unwrap_err().to_string()
    };
    assert!(refused(&infrared(), None).contains("400 to 700 nm in steps of 10 nm"));
    assert_eq!(refused(&snow::simple_law(), Some(COLOUR)), "false colour at 1030 nm, but the table holds 400–700 nm");
}
