//! Automatic exposure does not depend on lamps and the sun that the camera sees.

use snowblue_color::LinearRgb;
use snowblue_render::SceneFile;
use snowblue_render::film::image_file::to_raster;
use snowblue_render::render::{RenderControl, accumulator, all_samples, render_all, render_missing};
use snowblue_render::{Aovs, Development, Exposure, Integrator, Rendering};

use crate::snow::{SNOW, analytic_table, prepared};

/// A ball of snow close to the camera, before a white wall, lit from the left. It is small, for the sake of the
/// reference. A lamp hangs at the upper right, within the picture.
fn lamp_beside_snow(method: &str, lamp: &str) -> Integrator {
    let text = format!(
        "[camera]\nposition = [0, -4, 0]\nlook_at = [0, 0, 0]\nvertical_fov_deg = 30\n\
         [film]\nwidth = 24\nheight = 16\n\
         [integrator]\nsamples_per_pixel = 4\nmax_bounces = 2\ntype = \"{method}\"\n{SNOW}\
         [material.wall]\ntype = \"diffuse\"\nreflectance = 0.8\n\
         [[light]]\ntype = \"directional\"\ndirection = [1, 1, -0.5]\nirradiance_w_m2 = 3\nilluminant = \"D65\"\n\
         {lamp}\
         [[object]]\nshape = \"sphere\"\nradius = 0.004\nposition = [-0.01, -3.95, 0]\nmaterial = \"snow\"\n\
         [[object]]\nshape = \"box\"\nsize = [9, 0.1, 9]\nposition = [0, 2, 0]\nmaterial = \"wall\"\n"
    );
    let mut file = SceneFile::parse(text, "scene.toml").unwrap_or_else(|error| panic!("{error}"));
    // The pictures are compared with each other only.
    file.description.light_field.grain_rays = 4096;
    prepared(&file.build().unwrap_or_else(|error| panic!("{error}")), Some(&analytic_table()))
}

/// A rectangle that faces the camera and takes about an eighth of the picture.
fn lamp(visible: bool) -> String {
    format!(
        "[[light]]\ntype = \"rectangle\"\nposition = [1, 0.5, 0.6]\nlook_at = [1, -9, 0.6]\nsize = [1, 0.9]\n\
         radiance_w_m2_sr = 1e5\nilluminant = \"D65\"\nvisible = {visible}\n"
    )
}

/// Far above all that the lamp lights, and below a quarter of the lamp: pixels have four samples.
const LAMP: f64 = 1e4;

fn stops(rendering: &Rendering) -> f64 {
    rendering.film.display_factor(Exposure::Auto).log2()
}

#[test]
fn a_lamp_in_view_leaves_the_exposure_to_what_it_lights() {
    for method in ["pcasnow", "diffusion", "hybrid", "reference"] {
        let [none, hidden, seen] =
            [String::new(), lamp(false), lamp(true)].map(|lamp| render_all(&lamp_beside_snow(method, &lamp), &|_| {}));
        // Paths that find the lamp by chance, as those of the reference do, are in both pictures.
        let pairs = seen.film.pixels().iter().zip(hidden.film.pixels());
        let shows_lamp: Vec<bool> = pairs.map(|(seen, hidden)| seen.y - hidden.y > LAMP).collect();
        let bright = shows_lamp.iter().filter(|shows| **shows).count();
        assert!(bright > 20, "{method}: {bright}");
        assert_eq!(seen.film.metered_pixels().count(), 24 * 16 - bright, "{method}");
        // The other pixels are those of the picture without the sight of the lamp.
        let others = hidden.film.pixels().iter().zip(&shows_lamp).filter(|(_, shows)| !**shows);
        let others: Vec<LinearRgb> = others.map(|(pixel, _)| LinearRgb::from_xyz(*pixel)).collect();
        assert!(seen.film.snow_pixels().eq(hidden.film.snow_pixels()) && seen.film.snow_pixels().count() > 8);
        let snow = hidden.film.snow_pixels().map(LinearRgb::from_xyz);
        let expected = Development::from(Exposure::Auto).display_factor(others.into_iter(), snow).log2();
        assert!((stops(&seen) - expected).abs() < 1e-9, "{method}: {} {expected}", stops(&seen));
        assert!((expected - (0.9 / 1e5_f64).log2()).abs() > 3.0, "{method}: not that of the lamp, {expected}");
        assert_eq!(none.film.metered_pixels().count(), 24 * 16);
    }
}

/// A lamp that may be seen but is not, since it hangs behind the wall, changes no bit of the exposure.
#[test]
fn a_lamp_out_of_sight_changes_nothing() {
    let behind = |visible: bool| lamp(visible).replace("0.5, 0.6", "3, 0.6").replace("-9, 0.6", "9, 0.6");
    let [hidden, covered] = [false, true].map(|visible| lamp_beside_snow("pcasnow", &behind(visible)));
    let [hidden, covered] = [hidden, covered].map(|integrator| render_all(&integrator, &|_| {}));
    assert!(hidden.film == covered.film);
    assert_eq!(stops(&hidden).to_bits(), stops(&covered).to_bits());
}

/// Merged parts have the exposure of the whole: which pixels show a lamp is a sum as all others.
#[test]
fn the_aov_says_where_a_lamp_is() {
    let integrator = lamp_beside_snow("pcasnow", &lamp(true));
    let target = all_samples(integrator.scene());
    let mut sums = accumulator(integrator.scene(), Aovs::default(), &target.window());
    assert_eq!(sums.aovs().to_string(), "rgb,emitter,snow");
    render_missing(&integrator, &target, &mut sums, RenderControl::default());
    let channels = snowblue_render::film::channels::channels(&sums);
    let emitter = &channels.iter().find(|channel| channel.name == "emitter").unwrap().values;
    let film = sums.film();
    for (pixel, fraction) in film.pixels().iter().zip(emitter) {
        assert_eq!(pixel.y > LAMP, *fraction > 0.0, "{pixel:?} {fraction}");
    }
    assert!(emitter.contains(&1.0) && emitter.contains(&0.0));
}

/// An even plane of snow under a uniform sky, as bright as snow in the sun, with a dark floor at its side, is displayed
/// at 0.8, code 231, and by AgX at 0.6, code 203.
#[test]
fn a_plane_of_snow_is_white() {
    for (method, tone, expected) in
        [("diffusion", "filmic", 231), ("hybrid", "agx", 203), ("pcasnow", "none", 231), ("reference", "filmic", 231)]
    {
        let text = format!(
            "[camera]\nposition = [0, -0.02, 0.6]\nlook_at = [0, 0, 0]\nvertical_fov_deg = 8\n\
             [film]\nwidth = 16\nheight = 8\ntone = \"{tone}\"\n\
             [integrator]\nsamples_per_pixel = 64\nmax_bounces = 0\ntype = \"{method}\"\n{SNOW}\
             [material.floor]\ntype = \"diffuse\"\nreflectance = 0.1\n\
             [environment]\nradiance_w_m2_sr = 150\nvisible = false\n\
             [[object]]\nshape = \"box\"\nsize = [0.3, 0.3, 0.1]\nposition = [-0.15, 0, -0.05]\nmaterial = \"snow\"\n\
             [[object]]\nshape = \"box\"\nsize = [0.3, 0.3, 0.1]\nposition = [0.15, 0, -0.05]\nmaterial = \"floor\"\n"
        );
        let scene = SceneFile::parse(text, "scene.toml").and_then(|file| file.build()).unwrap();
        let integrator = prepared(&scene, Some(&analytic_table()));
        let Rendering { film, development, .. } = render_all(&integrator, &|_| {});
        assert_eq!(film.snow_pixels().count(), 8 * 8, "{method}: the left half is snow");
        let raster = to_raster(&film, development);
        for (place, pixel) in raster.pixels().iter().enumerate() {
            let (code, is_snow) = (pixel.r.max(pixel.g).max(pixel.b), place % 16 < 4);
            // The noise of 64 samples. Near its edge a body loses light.
            assert!(!is_snow || code.abs_diff(expected) <= 9, "{method}: {place} {pixel}");
            assert!(place % 16 < 9 || code < 165, "{method}: {place} {pixel}");
        }
    }
}
