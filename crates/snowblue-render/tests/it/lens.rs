//! The thin lens: depth of field.

use snowblue_render::SceneFile;
use snowblue_render::render::{RenderControl, accumulator, all_samples, render_all, render_missing};
use snowblue_render::{Aovs, Film, FilmAccumulator, Integrator, SampleBlock};

use crate::snow::{SNOW, analytic_table, prepared};

/// A view along y with some keys of the camera, and further tables.
fn integrator(camera: &str, tables: &str) -> Integrator {
    let text = format!(
        "[camera]\nposition = [0, 0, 0]\nlook_at = [0, 2, 0]\nvertical_fov_deg = 30\n{camera}\n\
         [film]\nwidth = 60\nheight = 60\n\
         [integrator]\nsamples_per_pixel = 400\nmax_bounces = 1\ntype = \"pcasnow\"\n{tables}"
    );
    let scene = SceneFile::parse(text, "scene.toml").and_then(|file| file.build());
    prepared(&scene.unwrap_or_else(|error| panic!("{error}")), Some(&analytic_table()))
}

/// A small lamp on the axis.
fn lamp(distance_m: f64) -> String {
    let radius_m = 0.01 * distance_m;
    format!(
        "[[light]]\ntype = \"sphere\"\nposition = [0, {distance_m}, 0]\nradius = {radius_m}\n\
         radiance_w_m2_sr = 100\n"
    )
}

/// Sum of the light, and radius of the even disc with its second moment, in pixels.
fn blur(film: &Film) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for (index, pixel) in film.pixels().iter().enumerate() {
        let [x, y] = [index % 60, index / 60].map(|place| place as f64 - 29.5);
        sums[0] += pixel.y;
        sums[1] += pixel.y * (x * x + y * y);
    }
    [sums[0], (2.0 * sums[1] / sums[0]).sqrt()]
}

/// The circle of confusion is A |1/f − 1/z| wide, in units of the image plane, on which 60 pixels are 2 tan 15° high.
#[test]
fn a_point_out_of_focus_is_a_disc_by_the_lens_equation() {
    let pixels = 60.0 / (2.0 * 15.0_f64.to_radians().tan());
    for (focus, focus_m, distance_m) in
        [("", 2.0, 1.2), ("", 2.0, 5.0), ("focus = 0.8", 0.8, 2.0), ("focus = 100000", 1e5, 1.0)]
    {
        let [sharp, blurred] = ["", "aperture = 0.3\n"].map(|aperture| {
            blur(&render_all(&integrator(&format!("{aperture}{focus}"), &lamp(distance_m)), &|_| {}).film)
        });
        let expected = 0.5 * 0.3 * f64::abs(1.0 / focus_m - 1.0 / distance_m) * pixels;
        // The second moments of the lamp and of a pixel add to that of the disc.
        let found = (blurred[1] * blurred[1] - sharp[1] * sharp[1]).sqrt();
        // Some 1500 samples find the lamp. Its light then has a random error of 2.5 %, the radius of 1.3 %, less by the
        // stratification of the samples.
        assert!((found / expected - 1.0).abs() < 0.04, "{focus_m} {distance_m}: {found} {expected}");
        assert!((blurred[0] / sharp[0] - 1.0).abs() < 0.05, "light is kept: {blurred:?} {sharp:?}");
    }
    // In focus the lens changes little.
    let [sharp, lens] =
        ["", "aperture = 0.3\n"].map(|keys| blur(&render_all(&integrator(keys, &lamp(2.0)), &|_| {}).film));
    assert!((lens[1] / sharp[1] - 1.0).abs() < 0.05, "{lens:?} {sharp:?}");
}

/// A block of snow before a wall.
fn block() -> String {
    format!(
        "{SNOW}[material.wall]\ntype = \"diffuse\"\nreflectance = 0.3\n\
         [[light]]\ntype = \"directional\"\ndirection = [0.3, 1, -0.5]\nirradiance_w_m2 = 3\n\
         [[object]]\nshape = \"box\"\nsize = [0.4, 0.1, 0.4]\nposition = [-0.1, 1, 0]\nrotation_deg = [0, 0, 35]\n\
         material = \"snow\"\n\
         [[object]]\nshape = \"box\"\nsize = [9, 0.1, 9]\nposition = [0, 4, 0]\nmaterial = \"wall\"\n"
    )
}

fn sums(integrator: &Integrator, aovs: Aovs, target: &SampleBlock) -> FilmAccumulator {
    let mut sums = accumulator(integrator.scene(), aovs, &target.window());
    render_missing(integrator, target, &mut sums, RenderControl::default());
    sums
}

#[test]
fn an_aperture_of_zero_changes_no_bit() {
    let [absent, zero, wide] =
        ["", "aperture = 0\nfocus = 0.7\n", "aperture = 0.05\n"].map(|keys| integrator(keys, &block()));
    let film = |integrator: &Integrator| sums(integrator, Aovs::default(), &all_samples(integrator.scene()));
    assert!(film(&absent) == film(&zero));
    assert!(film(&absent) != film(&wide));
}

#[test]
fn parts_have_the_bits_of_the_whole() {
    let integrator = integrator("aperture = 0.05\n", &block());
    let all = SampleBlock { samples: 0..12, ..all_samples(integrator.scene()) };
    let whole = sums(&integrator, Aovs::default(), &all);
    let mut merged = sums(&integrator, Aovs::default(), &SampleBlock { samples: 0..5, ..all.clone() });
    for columns in [0..13, 13..60] {
        let part = SampleBlock { columns, samples: 5..12, ..all.clone() };
        merged.add(&sums(&integrator, Aovs::default(), &part)).unwrap();
    }
    assert!(merged == whole, "ranges and tiles");
}

/// AOVs are those of the rays through the lens: at the blurred rim of the block, pixels see it in part.
#[test]
fn aovs_follow_the_rays_through_the_lens() {
    let fractions = |keys: &str| {
        let integrator = integrator(keys, &block());
        let sums = sums(&integrator, Aovs { normal: true, ..Aovs::default() }, &all_samples(integrator.scene()));
        let channels = snowblue_render::film::channels::channels(&sums);
        let of = |name: &str| &channels.iter().find(|channel| channel.name == name).unwrap().values;
        let lengths = of("normal.X").iter().zip(of("normal.Y")).map(|(x, y)| x.hypot(*y));
        let mixed_normals = lengths.filter(|length| *length < 0.99).count();
        (of("snow").iter().filter(|snow| (0.05..0.95).contains(*snow)).count(), mixed_normals)
    };
    let (sharp, blurred) = (fractions(""), fractions("aperture = 0.08\n"));
    assert!(sharp.0 > 0 && blurred.0 > 2 * sharp.0 && blurred.1 > 2 * sharp.1, "{sharp:?} {blurred:?}");
}
