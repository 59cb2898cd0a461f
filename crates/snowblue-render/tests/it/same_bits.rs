//! An image depends on its scene and seed only.

use std::path::Path;
use std::sync::Mutex;

use glam::Vec3A;
use snowblue_base::Count;
use snowblue_color::LinearRgb;
use snowblue_render::files::FilesInMemory;
use snowblue_render::film::Film;
use snowblue_render::film::image_file::write_exr;
use snowblue_render::raster::PixelPosition;
use snowblue_render::render::{
    self, RenderControl, Rendering, accumulator, pixel_radiance, render_all, render_missing,
};
use snowblue_render::scene::camera::View;
use snowblue_render::scene::film::ImageSize;
use snowblue_render::scene::{IntegratorKind, Scene};
use snowblue_render::{Aovs, Integrator, Progress, SceneFile};

use crate::snow::{SNOW, analytic_table, computed_table, load, pcasnow, prepared, scene};

fn shipped() -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/block_30cm.toml");
    let mut scene = load(&path);
    scene.set_image_size(ImageSize { width: 48, height: 40 });
    scene.set_samples_per_pixel(Count::of(4));
    scene
}

fn on_threads(threads: usize, integrator: &Integrator) -> Rendering {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| render_all(integrator, &|_| {}))
}

/// A block on a floor with a point light behind it and a directional light in front.
const BLOCK: &str = "[material.floor]\ntype = \"diffuse\"\nreflectance = 0.4\n\
    [[light]]\ntype = \"point\"\nposition = [0.1, 0.6, 0.2]\nradiant_intensity_w_sr = 9\n\
    [[light]]\ntype = \"directional\"\ndirection = [0.5, 0.6, -0.4]\nirradiance_w_m2 = 1\nilluminant = \"A\"\n\
    [[object]]\nshape = \"box\"\nsize = [0.4, 0.1, 0.4]\nposition = [0, 0, 0.2]\nmaterial = \"snow\"\nbody = \"wall\"\n\
    [[object]]\nshape = \"box\"\nsize = [3, 3, 0.1]\nposition = [0, 0, -0.05]\nmaterial = \"floor\"\n";

/// A sphere, a rotated box in the body of the block, and a plane behind them.
const MORE: &str = "[[object]]\nshape = \"sphere\"\nradius = 0.1\nposition = [-0.3, 0.1, 0.15]\nmaterial = \"snow\"\n\
    [[object]]\nshape = \"box\"\nsize = [0.3, 0.2, 0.2]\nposition = [0.25, 0.05, 0.1]\nrotation_deg = [10, 5, 30]\n\
    material = \"snow\"\nbody = \"wall\"\n\
    [[object]]\nshape = \"plane\"\nposition = [0, 1.5, 0]\nrotation_deg = [90, 0, 0]\nmaterial = \"floor\"\n";

/// A drift with hollows, and a box deeper than the table, lit at its far end.
const DEEP: &str = "[[object]]\nshape = \"drift\"\nsize = [0.6, 0.4, 0.2]\nposition = [-0.2, -0.5, 0]\n\
    material = \"snow\"\n\
    [[object]]\nshape = \"box\"\nsize = [0.2, 4, 0.1]\nposition = [-0.8, 2.5, 0.3]\nmaterial = \"snow\"\n\
    [[light]]\ntype = \"point\"\nposition = [-0.8, 4.7, 0.3]\nradiant_intensity_w_sr = 1e4\n";

/// A point light in the block, and a spotlight.
const LAMPS: &str = "[[light]]\ntype = \"point\"\nposition = [0.05, 0.01, 0.25]\nradiant_intensity_w_sr = 0.1\n\
    [[light]]\ntype = \"spot\"\nposition = [0.5, -0.5, 1]\nlook_at = [0, 0, 0.3]\nouter_cone_deg = 25\n\
    radiant_intensity_w_sr = 2\n";

/// Small boxes: enough objects for a BVH over objects.
fn pebbles() -> String {
    let pebble = |k: i32| {
        let x = 0.1 * f64::from(k - 4);
        format!(
            "[[object]]\nshape = \"box\"\nsize = [0.05, 0.03, 0.04]\nposition = [{x}, -0.2, 0.02]\n\
             material = \"snow\"\n"
        )
    };
    (0..8).map(pebble).collect()
}

/// A sphere, a rectangle and a sky that emit.
const AREA_LIGHTS: &str = "[[light]]\ntype = \"sphere\"\nposition = [-0.2, 0.5, 0.5]\nradius = 0.1\n\
    radiance_w_m2_sr = 20\nilluminant = \"A\"\n\
    [[light]]\ntype = \"rectangle\"\nposition = [0.6, -0.6, 0.9]\nlook_at = [0, 0, 0.2]\nsize = [0.3, 0.2]\n\
    radiance_w_m2_sr = 5\n[environment]\nradiance_w_m2_sr = 0.3\n";

/// Without a spectral AOV, light at the first surface of a path comes from projected tables instead of spectra.
#[test]
fn projected_tables_and_spectra_give_the_same_colours() {
    let everything = format!("{BLOCK}{MORE}{LAMPS}");
    let paths = ["view", "normal", "light", "brightest"].map(|path| (format!("path = \"{path}\""), BLOCK.to_owned()));
    let cases = paths.into_iter().chain([
        (String::new(), everything.clone()),
        ("path = \"light\"\nreflectance = 0.7".to_owned(), everything),
        (String::new(), format!("{BLOCK}{MORE}{}", pebbles())),
        ("path = \"light\"".to_owned(), format!("{BLOCK}{DEEP}")),
        (String::new(), format!("{BLOCK}{MORE}{AREA_LIGHTS}")),
    ]);
    for ((keys, things), bounces) in cases.flat_map(|case| [(case.clone(), 0), (case, 3)]) {
        let case = format!("{keys}, {} objects and lights, {bounces} bounces", things.matches("[[").count());
        let mut scene = scene(&format!("{}{SNOW}{things}", pcasnow(&keys)), &[]);
        scene.set_image_size(ImageSize { width: 40, height: 40 });
        scene.set_samples_per_pixel(Count::of(5));
        scene.set_max_bounces(Count::of(bounces));
        let view = View {
            position: Vec3A::new(0.7, -1.2, 0.5),
            look_at: Vec3A::new(0.0, 0.0, 0.2),
            up: Vec3A::Z,
            vertical_fov_deg: 30.0,
        };
        assert!(scene.set_view(&view));
        let integrator = prepared(&scene, Some(&computed_table()));
        let short = render_all(&integrator, &|_| {});
        let target = render::all_samples(&scene);
        let mut sums = accumulator(&scene, Aovs { spectrum: true, ..Aovs::default() }, &target.window());
        let long = render_missing(&integrator, &target, &mut sums, RenderControl::default());
        assert_eq!(short.statistics, long, "{case}");
        let (mut lit, mut worst) = (0, 0.0_f64);
        for (short, long) in short.film.pixels().iter().zip(sums.film().pixels()) {
            for (short, long) in [(short.x, long.x), (short.y, long.y), (short.z, long.z)] {
                assert!((short > 0.0) == (long > 0.0), "{case}: {short} {long}");
                if long > 0.0 {
                    lit += 1;
                    worst = worst.max((short / long - 1.0).abs());
                }
            }
        }
        // Projected tables interpolate logarithms of colours linearly; tests of `lookup::projected` bound the error.
        assert!(lit > 1000 && worst < 2e-4, "{case}: {lit} lit, {worst}");
    }
}

#[test]
fn pixel_radiance_equals_the_pixel_of_the_image() {
    let scene = shipped();
    let integrator = prepared(&scene, Some(&analytic_table()));
    // Colours of spectra, as of a pixel's radiance, not of projected tables.
    let target = render::all_samples(&scene);
    let mut sums = accumulator(&scene, Aovs { spectrum: true, ..Aovs::default() }, &target.window());
    render_missing(&integrator, &target, &mut sums, RenderControl::default());
    let picture = sums.film();
    let weights = snowblue_color::Colorimeter::new(
        snowblue_color::Observer::Cie1931,
        snowblue_color::Illuminant::E,
        &snowblue_render::scene::spectrum::wavelengths_nm(),
    )
    .unwrap();
    for (x, y) in [(0, 39), (20, 20), (47, 25)] {
        let alone = weights.xyz(&pixel_radiance(&integrator, PixelPosition { x, y }).0.map(f64::from));
        let there = picture.pixels()[(y * 48 + x) as usize];
        // Sums of spectra and of the 31 products of a sample are in single precision: about 2⁻²² of the sum.
        for (alone, there) in [(alone.x, there.x), (alone.y, there.y), (alone.z, there.z)] {
            assert!((alone - there).abs() <= there * f64::from(1 << 22).recip(), "{alone} {there}");
        }
    }
}

#[test]
fn every_sample_is_reported_once() {
    let reported = Mutex::new(Vec::new());
    let report = |at: Progress| reported.lock().unwrap().push(at);
    render_all(&prepared(&shipped(), Some(&analytic_table())), &report);
    let mut reported = reported.into_inner().unwrap();
    reported.sort_unstable_by_key(|at| at.done);
    // Two passes, of one and of three samples.
    assert_eq!(reported.len(), 2 * 40);
    assert!(reported.iter().all(|at| at.total == 48 * 40 * 4));
    assert!(reported.windows(2).all(|pair| [48, 144].contains(&(pair[1].done - pair[0].done))));
    assert_eq!(reported[79].done, 48 * 40 * 4);
}

#[test]
fn all_lights_and_path_modes_give_the_same_image_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let image = folder.path().join("sky.exr");
    let row = |k: u32| LinearRgb { r: f64::from(k % 7), g: f64::from(k % 5), b: f64::from(k % 3) }.xyz();
    write_exr(&Film::new(ImageSize { width: 8, height: 4 }, (0..32).map(row).collect()), &[], &image).unwrap();
    let skies = [
        "radiance_w_m2_sr = 1\nilluminant = \"D75\"\n".to_owned(),
        format!("image = \"{}\"\nrotation_deg = 30\n", image.display()),
    ];
    for (sky, path) in skies.iter().flat_map(|sky| ["brightest", "normal", "light", "view"].map(|path| (sky, path))) {
        let text = format!(
            "{}{SNOW}[material.grey]\ntype = \"diffuse\"\nreflectance = 0.5\n\
             [[object]]\nshape = \"box\"\nsize = [1, 0.3, 1]\nposition = [-0.6, 0, 0.5]\nmaterial = \"snow\"\n\
             body = \"one\"\n\
             [[object]]\nshape = \"box\"\nsize = [1, 0.5, 1]\nposition = [0.2, 0, 0.5]\nmaterial = \"snow\"\n\
             body = \"one\"\n\
             [[object]]\nshape = \"sphere\"\nradius = 0.4\nposition = [1.2, -0.5, 0.4]\nmaterial = \"snow\"\n\
             [[object]]\nshape = \"plane\"\nmaterial = \"grey\"\n\
             [[light]]\ntype = \"point\"\nposition = [0, 1, 0.5]\nradiant_intensity_w_sr = 10\n\
             [[light]]\ntype = \"directional\"\ndirection = [0.5, 0.3, -1]\nirradiance_w_m2 = 2\nilluminant = \"D55\"\n\
             [[light]]\ntype = \"sphere\"\nposition = [1, 1, 1]\nradius = 0.2\nradiance_w_m2_sr = 5\n\
             illuminant = \"A\"\n\
             [[light]]\ntype = \"rectangle\"\nposition = [-1, 1, 1]\nlook_at = [0, 0, 0]\nsize = [0.5, 0.3]\n\
             radiance_w_m2_sr = 5\n[environment]\n{sky}",
            pcasnow(&format!("path = \"{path}\""))
        );
        let mut scene = scene(&text, &[]);
        scene.set_image_size(ImageSize { width: 24, height: 18 });
        scene.set_samples_per_pixel(Count::of(4));
        for bounces in [6, 0] {
            scene.set_max_bounces(Count::of(bounces));
            let integrator = prepared(&scene, Some(&analytic_table()));
            let one = on_threads(1, &integrator);
            assert!(one.film.pixels().iter().any(|xyz| xyz.y > 0.0));
            assert_eq!(one.statistics.camera_rays, 24 * 18 * 4);
            for threads in [2, 7] {
                assert_eq!(one, on_threads(threads, &integrator), "{sky} {path} {bounces} on {threads} threads");
            }
        }
        let mut integrator = prepared(&scene, Some(&analytic_table()));
        let one = on_threads(1, &integrator);
        integrator.set_seed(scene.integrator().seed + 1);
        assert_ne!(one, on_threads(1, &integrator), "another seed");
    }
}

/// A rough L of two boxes that sees itself, and sparkling snow, on a floor, through a lens.
const CORNER: &str = "[camera]\nposition = [0.2, -0.4, 0.25]\nlook_at = [0, 0, 0.05]\nvertical_fov_deg = 20\n\
    aperture = 0.01\n\
    [film]\nwidth = 5\nheight = 5\n[integrator]\nsamples_per_pixel = 2\nmax_bounces = 4\n\
    [material.snow]\ntype = \"snow\"\nrelief = { height_mm = 0.8, correlation_mm = 8 }\n\
    [material.glitter]\ntype = \"snow\"\nsparkle = true\n[material.floor]\ntype = \"diffuse\"\nreflectance = 0.6\n\
    [[light]]\ntype = \"point\"\nposition = [0.8, -1.0, 0.6]\nradiant_intensity_w_sr = 40\n\
    [[object]]\nshape = \"plane\"\nmaterial = \"floor\"\n\
    [[object]]\nshape = \"box\"\nsize = [0.09, 0.03, 0.09]\nposition = [0, 0, 0.045]\n\
    material = \"snow\"\nbody = \"l\"\n\
    [[object]]\nshape = \"box\"\nsize = [0.03, 0.09, 0.09]\nposition = [-0.03, -0.03, 0.045]\nmaterial = \"snow\"\n\
    body = \"l\"\n\
    [[object]]\nshape = \"sphere\"\nradius = 0.02\nposition = [0.05, -0.05, 0.02]\nmaterial = \"glitter\"\n";

/// Meshes of rough snow, light fields, walks and paths of grains.
#[test]
fn every_integrator_prepares_and_renders_the_same_on_any_number_of_threads() {
    for kind in [IntegratorKind::Diffusion, IntegratorKind::Hybrid, IntegratorKind::Reference] {
        let on_threads = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut description = SceneFile::parse(CORNER, "corner.toml").unwrap().description;
                description.integrator.kind = kind;
                description.light_field.grain_rays = 1 << 12;
                render::render(&description.build(&FilesInMemory::default()).unwrap()).unwrap()
            })
        };
        let one = on_threads(1);
        assert!(one.film.pixels().iter().any(|xyz| xyz.y > 0.0));
        assert_eq!(one, on_threads(3), "{}", kind.name());
    }
}
