//! Automatic exposure does not depend on lamps and the sun that the camera sees.

#![allow(clippy::unwrap_used, clippy::cast_possible_truncation, reason = "a test may panic")]

mod snow;

use snow::{SNOW, analytic_table};
use snowblue_database::CompressedTable;
use snowblue_database::table::Attribute;
use snowblue_render::film::exposure::Exposure;
use snowblue_render::render::{RenderControl, accumulator};
use snowblue_render::render::{all_samples, render, render_missing};
use snowblue_render::scene::Scene;
use snowblue_render::scene::file::SceneFile;
use snowblue_render::{Aovs, Rendering};

/// A ball of snow before a white wall, lit from the left. A lamp that lights nothing that is seen hangs at the upper
/// right, within the picture.
fn lamp_beside_snow(integrator: &str, lamp: &str) -> Scene {
    let text = format!(
        "[camera]\nposition = [0, -4, 0]\nlook_at = [0, 0, 0]\nvertical_fov_deg = 30\n\
         [film]\nwidth = 24\nheight = 16\n\
         [integrator]\nsamples_per_pixel = 4\nmax_bounces = 2\ntype = \"{integrator}\"\n{SNOW}\
         [material.wall]\ntype = \"diffuse\"\nreflectance = 0.8\n\
         [[light]]\ntype = \"directional\"\ndirection = [1, 1, -0.5]\nirradiance_w_m2 = 3\nilluminant = \"D65\"\n\
         {lamp}\
         [[object]]\nshape = \"sphere\"\nradius = 0.5\nmaterial = \"snow\"\n\
         [[object]]\nshape = \"box\"\nsize = [9, 0.1, 9]\nposition = [0, 2, 0]\nmaterial = \"wall\"\n"
    );
    let ice = Attribute::new("ice_constants", "Warren & Brandt 2008");
    let table = CompressedTable { metadata: vec![ice], ..analytic_table() };
    SceneFile::parse(text, "scene.toml").and_then(|file| file.build(&table)).unwrap_or_else(|error| panic!("{error}"))
}

/// A rectangle that faces the camera and takes about an eighth of the picture.
fn lamp(visible: bool) -> String {
    format!(
        "[[light]]\ntype = \"rectangle\"\nposition = [1, 0.5, 0.6]\nlook_at = [1, -9, 0.6]\nsize = [1, 0.9]\n\
         radiance_w_m2_sr = 1e5\nilluminant = \"D65\"\nvisible = {visible}\n"
    )
}

fn stops(rendering: &Rendering) -> f64 {
    rendering.film.display_factor(Exposure::Auto).log2()
}

#[test]
fn a_lamp_in_view_leaves_the_exposure_to_what_it_lights() {
    for integrator in ["pcasnow", "diffusion", "hybrid", "reference"] {
        let [none, hidden, seen] =
            [String::new(), lamp(false), lamp(true)].map(|lamp| render(&lamp_beside_snow(integrator, &lamp), &|_| {}));
        let bright = seen.film.pixels().iter().filter(|pixel| pixel.y > 1e3).count();
        let metered = seen.film.metered_pixels().count();
        assert!(bright > 20 && metered + bright >= 24 * 16 && metered <= 24 * 16 - bright, "{bright} {metered}");
        // Behind the lamp there is wall as elsewhere, so that leaving it out changes little.
        assert!((stops(&seen) - stops(&hidden)).abs() < 0.2, "{integrator}: {} {}", stops(&seen), stops(&hidden));
        assert_eq!(none.film.metered_pixels().count(), 24 * 16);
    }
}

/// A lamp that may be seen but is not, since it hangs behind the wall, changes no bit of the exposure.
#[test]
fn a_lamp_out_of_sight_changes_nothing() {
    let behind = |visible: bool| lamp(visible).replace("0.5, 0.6", "3, 0.6").replace("-9, 0.6", "9, 0.6");
    let [hidden, covered] = [false, true].map(|visible| lamp_beside_snow("pcasnow", &behind(visible)));
    let [hidden, covered] = [hidden, covered].map(|scene| render(&scene, &|_| {}));
    assert!(hidden.film == covered.film);
    assert_eq!(stops(&hidden).to_bits(), stops(&covered).to_bits());
}

/// Merged parts have the exposure of the whole: which pixels show a lamp is a sum as all others.
#[test]
fn the_aov_says_where_a_lamp_is() {
    let scene = lamp_beside_snow("pcasnow", &lamp(true));
    let target = all_samples(&scene);
    let mut sums = accumulator(&scene, Aovs::default(), &target.window());
    assert_eq!(sums.aovs().to_string(), "rgb,emitter");
    render_missing(&scene, &target, &mut sums, RenderControl::default());
    let channels = snowblue_render::film::channels::channels(&sums);
    let emitter = &channels.iter().find(|channel| channel.name == "emitter").unwrap().values;
    let film = sums.film();
    for (pixel, fraction) in film.pixels().iter().zip(emitter) {
        assert_eq!(pixel.y > 1e3, *fraction > 0.0, "{pixel:?} {fraction}");
    }
    assert!(emitter.contains(&1.0) && emitter.contains(&0.0));
}
