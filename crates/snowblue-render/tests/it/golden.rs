//! Images against stored statistics: EXR files in `golden/` hold each pixel's mean and variance over many seeds, in the
//! channels `mean.X` … `variance.Z`. An image with another seed must agree with them.
//!
//! `UPDATE_GOLDEN=1 cargo test -p snowblue-render --test it golden` renders and stores them again. An image that
//! fails is written to the temporary folder that the message names.

use std::path::{Path, PathBuf};

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, ReadChannels, ReadLayers,
    WritableImage, read,
};
use glam::Vec3A;
use snowblue_base::Count;
use snowblue_color::{LinearRgb, Xyz};
use snowblue_render::Integrator;
use snowblue_render::film::Film;
use snowblue_render::film::image_file::write_exr;
use snowblue_render::render::render_all;
use snowblue_render::scene::Scene;
use snowblue_render::scene::camera::View;
use snowblue_render::scene::film::ImageSize;
use snowblue_stat::{Moments, chi_squared_p_value, sidak_level, t_p_value};

use crate::snow::{SNOW, analytic_table_of_grains, pcasnow, prepared, scene, scene_of_many_grains};

const SIZE: ImageSize = ImageSize { width: 32, height: 24 };
/// Number of images of the stored statistics; their seeds are 1 to 128.
const IMAGE_COUNT: u32 = 128;
/// Seeds of the images whose mean is compared. A single image is far from normally distributed because of rare bright
/// paths.
const TEST_SEEDS: std::ops::Range<u32> = 1000..1008;
/// Probability of a false alarm per test, over random seeds.
const LEVEL: f64 = 1e-3;
/// Relative rounding error between processors.
const ROUNDING: f64 = 1e-5;
const NAMES: [&str; 6] = ["mean.X", "mean.Y", "mean.Z", "variance.X", "variance.Y", "variance.Z"];

/// A block of snow that a lamp lights from a side, by `hybrid`. The camera sees two lit faces and one that is not.
fn block(grain_size_um: f64) -> Integrator {
    let text = format!(
        "filter = false\n{}\
         [[object]]\nshape = \"box\"\nsize = [0.08, 0.04, 0.08]\nposition = [0, 0, 0.04]\nrotation_deg = [0, 0, 15]\n\
         material = \"snow\"\n\
         [[light]]\ntype = \"point\"\nposition = [-0.3, -0.1, 0.15]\nradiant_intensity_w_sr = 5\n",
        snow_of(grain_size_um)
    );
    let view = View {
        position: Vec3A::new(0.1, -0.12, 0.12),
        look_at: Vec3A::new(0.0, 0.0, 0.04),
        up: Vec3A::Z,
        vertical_fov_deg: 45.0,
    };
    prepared(&seen(scene_of_many_grains("hybrid", &text, &[]), &view, 64), None)
}

/// Two spheres of triangles in one body and a third that is not, under sun and blue sky, on a height field, by
/// `diffusion`.
fn drift(grain_size_um: f64) -> Integrator {
    let text = format!(
        "filter = false\n{}[material.ground]\ntype = \"diffuse\"\nreflectance = 0.2\n\
         [[object]]\nmesh = \"ball.ply\"\nscale = [0.04, 0.03, 0.03]\nposition = [-0.02, 0, 0.03]\n\
         material = \"snow\"\nbody = \"drift\"\n\
         [[object]]\nmesh = \"ball.ply\"\nscale = 0.03\nposition = [0.02, 0.01, 0.03]\nmaterial = \"snow\"\n\
         body = \"drift\"\n\
         [[object]]\nmesh = \"ball.ply\"\nscale = 0.012\nposition = [0.05, -0.05, 0.015]\nmaterial = \"snow\"\n\
         [[object]]\nshape = \"heights\"\nsize = [0.3, 0.3, 0.01]\nheights = [[1, 0, 1], [0, 0, 0], [0.5, 0, 0.5]]\n\
         bottom = -0.01\n\
         material = \"ground\"\n\
         [[light]]\ntype = \"directional\"\ndirection = [0.3, -0.8, -0.5]\nirradiance_w_m2 = 10\nilluminant = \"D55\"\n\
         [environment]\nradiance_w_m2_sr = 0.6\nilluminant = \"D75\"\n",
        snow_of(grain_size_um)
    );
    let view = View {
        position: Vec3A::new(0.1, -0.14, 0.08),
        look_at: Vec3A::new(0.01, 0.0, 0.025),
        up: Vec3A::Z,
        vertical_fov_deg: 45.0,
    };
    prepared(&seen(scene_of_many_grains("diffusion", &text, &[("ball.ply", sphere())]), &view, 128), None)
}

/// [`SNOW`] of another grain size.
fn snow_of(grain_size_um: f64) -> String {
    SNOW.replace("400", &grain_size_um.to_string())
}

/// A grey room with a spherical and a rectangular light, and a wall of snow before the rectangle.
fn room() -> Integrator {
    let text = format!(
        "{}{SNOW}[material.grey]\ntype = \"diffuse\"\nreflectance = 0.6\n\
         [[object]]\nshape = \"box\"\nsize = [3, 3, 2.4]\nposition = [0, 0, 1.2]\nmaterial = \"grey\"\n\
         [[object]]\nshape = \"sphere\"\nradius = 0.3\nposition = [0.6, 0.2, 0.3]\nmaterial = \"grey\"\n\
         [[object]]\nshape = \"box\"\nsize = [0.9, 0.15, 0.9]\nposition = [-0.5, 0.5, 0.45]\nmaterial = \"snow\"\n\
         [[light]]\ntype = \"rectangle\"\nposition = [-0.5, 1.4, 0.9]\nlook_at = [-0.5, 0, 0.5]\nsize = [0.6, 0.6]\n\
         radiance_w_m2_sr = 6\nilluminant = \"A\"\n\
         [[light]]\ntype = \"sphere\"\nposition = [0.7, -0.5, 1.7]\nradius = 0.15\nradiance_w_m2_sr = 4\n",
        pcasnow("path = \"normal\"")
    );
    by_pcasnow(&text, Vec3A::new(0.1, -1.4, 1.3), Vec3A::new(0.0, 0.6, 0.6), 75.0)
}

/// A sphere and a slab of snow with path mode `view`, under an image sky.
fn sky() -> Integrator {
    // Bluer towards the zenith, with one bright spot.
    let colour = |k: u32| {
        let (row, column) = (f64::from(k / 16), k % 16);
        let sun = if row < 3.5 && row > 1.5 && column == 4 { 12.0 } else { 0.0 };
        LinearRgb { r: 0.2 + sun, g: 0.3 + sun, b: 0.8 - 0.05 * row + 0.8 * sun }.xyz()
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sky.exr");
    write_exr(&Film::new(ImageSize { width: 16, height: 8 }, (0..128).map(colour).collect()), &[], &path).unwrap();
    let text = format!(
        "{}{SNOW}[material.ground]\ntype = \"diffuse\"\nreflectance = 0.3\n\
         [[object]]\nshape = \"sphere\"\nradius = 0.3\nposition = [0.3, 0, 0.3]\nmaterial = \"snow\"\n\
         [[object]]\nshape = \"box\"\nsize = [0.5, 0.1, 0.7]\nposition = [-0.4, 0.2, 0.35]\nmaterial = \"snow\"\n\
         [[object]]\nshape = \"plane\"\nmaterial = \"ground\"\n[environment]\nimage = \"{}\"\nrotation_deg = 60\n",
        pcasnow("path = \"view\""),
        path.display()
    );
    by_pcasnow(&text, Vec3A::new(0.4, -1.6, 0.7), Vec3A::new(0.0, 0.0, 0.3), 45.0)
}

/// A closed sphere of 512 triangles, radius 1.
fn sphere() -> String {
    let (rings, turns) = (16, 16);
    let mut vertices = String::new();
    for (ring, turn) in (0..=rings).flat_map(|ring| (0..turns).map(move |turn| (ring, turn))) {
        let (radius, z) = (std::f32::consts::PI * ring as f32 / rings as f32).sin_cos();
        let (sin, cos) = (std::f32::consts::TAU * turn as f32 / turns as f32).sin_cos();
        vertices += &format!("{} {} {z}\n", radius * cos, radius * sin);
    }
    let mut faces = String::new();
    for (ring, turn) in (0..rings).flat_map(|ring| (0..turns).map(move |turn| (ring, turn))) {
        let next = (turn + 1) % turns;
        let [a, b, c, d] = [(ring, turn), (ring + 1, turn), (ring + 1, next), (ring, next)].map(|(i, j)| i * turns + j);
        faces += &format!("4 {a} {b} {c} {d}\n");
    }
    format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\n\
         property list uchar int vertex_indices\nend_header\n{vertices}{faces}",
        (rings + 1) * turns,
        rings * turns
    )
}

/// A scene with the image of the tests: a camera and samples per pixel.
fn seen(mut scene: Scene, view: &View, samples: u32) -> Scene {
    scene.set_image_size(SIZE);
    scene.set_samples_per_pixel(Count::of(samples));
    scene.set_max_bounces(Count::of(2));
    assert!(scene.set_view(view));
    scene
}

/// PCASnow of a scene, by a table whose interpolation is exact.
fn by_pcasnow(text: &str, position: Vec3A, look_at: Vec3A, vertical_fov_deg: f32) -> Integrator {
    let view = View { position, look_at, up: Vec3A::Z, vertical_fov_deg };
    prepared(&seen(scene(text, &[]), &view, 64), Some(&analytic_table_of_grains()))
}

/// The mean of the images of some seeds.
fn rendered(mut integrator: Integrator, seeds: std::ops::Range<u32>) -> Film {
    let fraction = f64::from(seeds.end - seeds.start).recip();
    let mut sum = vec![Xyz::default(); SIZE.pixel_count()];
    for seed in seeds {
        integrator.set_seed(seed);
        let film = render_all(&integrator, &|_| {}).film;
        sum.iter_mut().zip(film.pixels()).for_each(|(sum, &xyz)| *sum = *sum + xyz * fraction);
    }
    Film::new(SIZE, sum)
}

fn channels(xyz: &Xyz) -> [f64; 3] {
    [xyz.x, xyz.y, xyz.z]
}

/// Each pixel's mean and variance, in the channels of [`NAMES`].
struct Golden([Vec<f32>; 6]);

impl Golden {
    fn path(name: &str) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/golden/{name}.exr"))
    }

    fn of_seeds(mut integrator: Integrator) -> Self {
        let mut moments = vec![[Moments::default(); 3]; SIZE.pixel_count()];
        for seed in 1..=IMAGE_COUNT {
            integrator.set_seed(seed);
            for (moments, xyz) in moments.iter_mut().zip(render_all(&integrator, &|_| {}).film.pixels()) {
                moments.iter_mut().zip(channels(xyz)).for_each(|(moments, value)| moments.push(value));
            }
        }
        Self(std::array::from_fn(|channel| {
            let values = moments.iter().map(|pixel| &pixel[channel % 3]);
            values.map(|one| if channel < 3 { one.mean() as f32 } else { one.variance() as f32 }).collect()
        }))
    }

    fn store(self, name: &str) {
        let channels = NAMES.iter().zip(self.0).map(|(&name, values)| AnyChannel::new(name, FlatSamples::F32(values)));
        let size = (SIZE.width as usize, SIZE.height as usize);
        let channels = AnyChannels::sort(channels.collect());
        let layer = Layer::new(size, LayerAttributes::default(), Encoding::SMALL_LOSSLESS, channels);
        Image::from_layer(layer).write().to_file(Self::path(name)).unwrap();
    }

    fn load(name: &str) -> Self {
        let reader =
            read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
        let path = Self::path(name);
        let image = reader.from_file(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let list = image.layer_data.channel_data.list;
        Self(NAMES.map(|name| {
            let channel = list.iter().find(|channel| channel.name.eq(name)).unwrap();
            channel.sample_data.values_as_f32().collect()
        }))
    }

    /// The first mismatch of an image: a channel of a pixel, or the luminance of all pixels together.
    fn mismatch(&self, film: &Film) -> Option<String> {
        let degrees = f64::from(IMAGE_COUNT - 1);
        // The stored mean has an error too.
        let fraction = 1.0 / TEST_SEEDS.len() as f64 + 1.0 / f64::from(IMAGE_COUNT);
        let level = sidak_level(LEVEL, 3 * film.pixels().len());
        let (mut chi_squared, mut noisy) = (0.0, 0.0);
        for (pixel, xyz) in film.pixels().iter().enumerate() {
            for (channel, found) in channels(xyz).into_iter().enumerate() {
                let [mean, variance] = [channel, channel + 3].map(|plane| f64::from(self.0[plane][pixel]));
                let error = (variance * fraction).sqrt().hypot(ROUNDING * mean);
                let t = if (found - mean).abs() > 0.0 { (found - mean) / error } else { 0.0 };
                if t_p_value(t, degrees) < level {
                    let (column, row) = (pixel as u32 % SIZE.width, pixel as u32 / SIZE.width);
                    let name = NAMES[channel];
                    return Some(format!("{name} at {column}, {row} is {found}, stored {mean} ± {error}, t = {t:.1}"));
                }
                if channel == 1 && error > 0.0 {
                    // The variance of t is ν / (ν − 2).
                    chi_squared += t * t * (degrees - 2.0) / degrees;
                    noisy += 1.0;
                }
            }
        }
        let p = chi_squared_p_value(chi_squared, noisy);
        (p < LEVEL).then(|| format!("luminance of all pixels: χ² = {chi_squared:.0} of {noisy}, p = {p:.1e}"))
    }
}

/// Compares a scene's image with the stored statistics; the same image brighter by 3 % must fail. Or stores it.
fn check(name: &str, integrator: Integrator) {
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        Golden::of_seeds(integrator).store(name);
        return;
    }
    let (golden, film) = (Golden::load(name), rendered(integrator, TEST_SEEDS));
    if let Some(reason) = golden.mismatch(&film) {
        let found = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("golden_{name}.exr"));
        write_exr(&film, &[], &found).unwrap();
        panic!("{name}: {reason}; the image is {}", found.display());
    }
    let brighter = film.pixels().iter().map(|&xyz| xyz * 1.03).collect();
    assert!(golden.mismatch(&Film::new(SIZE, brighter)).is_some(), "{name} brighter by 3 %");
}

#[test]
fn a_block_lit_from_a_side_by_hybrid_matches() {
    check("block", block(400.0));
}

#[test]
fn meshes_under_sun_and_sky_by_diffusion_match() {
    check("drift", drift(400.0));
}

#[test]
fn a_room_with_area_lights_matches() {
    check("room", room());
}

#[test]
fn snow_under_an_image_sky_matches() {
    check("sky", sky());
}

#[test]
fn other_grain_sizes_do_not_match() {
    for (name, integrator) in [("block", block(430.0)), ("drift", drift(430.0))] {
        let image = rendered(integrator, TEST_SEEDS);
        assert!(Golden::load(name).mismatch(&image).is_some(), "{name}: 430 µm instead of 400 µm");
    }
}
