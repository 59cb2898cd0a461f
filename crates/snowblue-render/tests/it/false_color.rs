//! False colour: images of three wavelengths, of the infrared too, with curves from a table of just the picture's
//! wavelengths or else solved for.

use std::f64::consts::PI;

use snowblue_color::LinearRgb;
use snowblue_database::{Axes, CompressedTable, PcaSnow, Space, fill};
use snowblue_render::files::FilesInMemory;
use snowblue_render::render::render_all;
use snowblue_render::{FalseColor, Integrator, Preparation};

use crate::snow::{self, SAMPLE, SNOW, analytic_table, camera_of, parsed, pcasnow};

const COLOUR: FalseColor = FalseColor { red_nm: 1150.0, green_nm: 850.0, blue_nm: 550.0 };

/// A table of one snow at the wavelengths of such a picture.
fn infrared() -> CompressedTable {
    let axes = Axes {
        grain_sizes_um: vec![SAMPLE.grain_size_um],
        facetness: vec![SAMPLE.facetness],
        densities_kg_m3: vec![SAMPLE.density_kg_m3],
        thicknesses_cm: vec![0.1, 0.5, 1.0, 2.0, 5.0],
        wavelengths_nm: (0..31).map(|k| 550.0 + 20.0 * f64::from(k)).collect(),
        ..Axes::paper()
    };
    let table = fill::fill(&axes, &fill::FillOptions::by_ordinates(1 << 18), &|_| {}).unwrap();
    CompressedTable::new(&table, Space::Log, 8).unwrap()
}

/// The integrator of a picture of one pixel in false colour, of a scene with these files.
fn prepared(
    method: &str,
    colour: FalseColor,
    table: Option<&CompressedTable>,
    text: &str,
    files: &[(&str, &str)],
) -> Integrator {
    let mut scene = parsed(format!("{}{text}", camera_of(method)));
    scene.camera.as_mut().unwrap().vertical_fov_deg = 1.0;
    scene.film.false_color = Some(colour);
    scene.light_field.grain_rays = 1 << 12;
    let mut in_memory = FilesInMemory::default();
    files.iter().for_each(|(name, content)| in_memory.insert(*name, *content));
    let scene = scene.build(&in_memory).unwrap_or_else(|error| panic!("{error}"));
    Integrator::prepare_with(&scene, Preparation { table, ..Preparation::default() }).unwrap()
}

fn seen(integrator: &Integrator) -> LinearRgb {
    LinearRgb::from_xyz(render_all(integrator, &|_| {}).film.pixels()[0])
}

/// Two centimetres of snow between the camera and a distant light.
fn slab(illuminant: &str) -> String {
    format!(
        "{}{SNOW}[[object]]\nshape = \"box\"\nsize = [50, 0.02, 50]\nmaterial = \"snow\"\n\
         [[light]]\ntype = \"point\"\nposition = [0, 1e5, 0]\nilluminant = \"{illuminant}\"\n\
         radiant_intensity_w_sr = 1e10\n",
        pcasnow("path = \"normal\"")
    )
}

/// The colour of a diffuse wall, lit from behind the camera.
fn wall(keys: &str) -> LinearRgb {
    let text = format!(
        "[material.paint]\ntype = \"diffuse\"\n{keys}\n\
         [[object]]\nshape = \"box\"\nsize = [50, 0.02, 50]\nmaterial = \"paint\"\n\
         [[light]]\ntype = \"directional\"\ndirection = [0, 1, 0]\nirradiance_w_m2 = 1\n"
    );
    seen(&prepared("pcasnow", COLOUR, None, &text, &[("rising.csv", "400,0\n1300,0.9\n")]))
}

/// The channels of T E / π behind the slab, by a table.
fn transmitted(table: &CompressedTable) -> [f64; 3] {
    let mut transmittance = [0.0; 31];
    PcaSnow::new(table, &SAMPLE).unwrap().transmittance(2.0, 0.0, &mut transmittance);
    // The light is so far away that the irradiance is 1 W/m² everywhere.
    [30, 15, 0].map(|place: usize| f64::from(transmittance[place]) / PI)
}

#[test]
fn channels_are_t_e_over_pi_at_three_wavelengths() {
    let table = infrared();
    let of_table = prepared("pcasnow", COLOUR, Some(&table), &slab("D65"), &[]);
    assert!(of_table.notes().is_empty(), "{:?}", of_table.notes());
    let seen_by_table = seen(&of_table);
    let expected = transmitted(&table);
    for (channel, expected) in [seen_by_table.r, seen_by_table.g, seen_by_table.b].into_iter().zip(expected) {
        assert!((channel / expected - 1.0).abs() < 1e-4, "{seen_by_table:?}: {channel}, not {expected}");
    }
    assert!(seen_by_table.b > 3.0 * seen_by_table.r, "snow transmits less infrared: {seen_by_table:?}");
    let other_light = seen(&prepared("pcasnow", COLOUR, Some(&table), &slab("A"), &[]));
    assert_eq!(other_light, seen_by_table, "lights are white in false colour");
}

#[test]
fn curves_are_solved_for_where_the_table_has_other_wavelengths() {
    let infrared = infrared();
    let solved = prepared("pcasnow", COLOUR, Some(&analytic_table()), &slab("D65"), &[]);
    assert_eq!(
        solved.notes(),
        ["material.snow: its curves are solved for, because the table has other wavelengths than the picture"]
    );
    let colour = seen(&solved);
    for (channel, expected) in [colour.r, colour.g, colour.b].into_iter().zip(transmitted(&infrared)) {
        // The tallies of grains differ, and each table is compressed by itself.
        assert!((channel / expected - 1.0).abs() < 0.01, "{colour:?}: {channel}, not {expected}");
    }
    // In a picture of visible light it is the table of the infrared that is not read.
    let scene = snow::scene(&slab("D65"), &[]);
    let visible =
        Integrator::prepare_with(&scene, Preparation { table: Some(&infrared), ..Preparation::default() }).unwrap();
    assert!(visible.notes()[0].contains("other wavelengths"), "{:?}", visible.notes());
}

#[test]
fn reflectances_use_the_wavelengths_of_the_picture_and_rgb_colours_are_grey() {
    let LinearRgb { r, g, b } = wall("reflectance_spectrum = \"rising.csv\"");
    let grey = wall("reflectance_rgb = [0.2, 0.5, 0.1]");
    let luminance = LinearRgb { r: 0.2, g: 0.5, b: 0.1 }.luminance();
    let expected = [0.75, 0.45, 0.15, luminance, luminance, luminance].map(|share| share / PI);
    for (channel, expected) in [r, g, b, grey.r, grey.g, grey.b].into_iter().zip(expected) {
        // Tolerance: single precision of the light and of the sums.
        assert!((channel / expected - 1.0).abs() < 1e-5, "{channel} for {expected}");
    }
}

/// At 300 nm snow is nearly white, also where all three wavelengths are 300 nm, the least that there is.
#[test]
fn the_three_wavelengths_may_be_the_least() {
    let text = format!(
        "{SNOW}[light_field]\nstep_mm = 10\n[environment]\nradiance_w_m2_sr = 1\n\
         [[object]]\nshape = \"box\"\nsize = [0.3, 0.1, 0.3]\nmaterial = \"snow\"\n"
    );
    let [violet, same] = [[400.0, 410.0, 300.0], [300.0; 3]].map(|[red_nm, green_nm, blue_nm]| {
        seen(&prepared("diffusion", FalseColor { red_nm, green_nm, blue_nm }, None, &text, &[]))
    });
    assert!((violet.b - 1.0).abs() < 0.1, "{violet:?}");
    for channel in [same.r, same.g, same.b] {
        assert!((channel / violet.b - 1.0).abs() < 0.02, "{same:?} {violet:?}");
    }
}
