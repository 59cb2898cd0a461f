//! An image rendered in parts has the same bits: ranges of samples, tiles, interruptions and files.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};

use exr::prelude::{FlatSamples, ReadChannels, ReadLayers, read};
use snowblue_base::Count;
use snowblue_color::{Illuminant, LinearRgb};
use snowblue_render::Exposure;
use snowblue_render::SceneFile;
use snowblue_render::files::FilesInMemory;
use snowblue_render::film::Film;
use snowblue_render::film::aov::Aovs;
use snowblue_render::film::image_file::write_exr;
use snowblue_render::film::resumable_file::{self, ResumableImage};
use snowblue_render::render::{RenderControl, accumulator, all_samples, render_all, render_missing};
use snowblue_render::scene::film::white_balance::{PictureWhite, WhiteBalance};
use snowblue_render::scene::film::{ImageSize, PictureSettings};
use snowblue_render::{FilmAccumulator, Integrator, SampleBlock};

use crate::snow::{SNOW, analytic_table, camera_of, computed_table, parsed, prepared, scene, scene_of_few_grains};

const ALL: Aovs = Aovs {
    spectrum: true,
    variance: true,
    normal: true,
    albedo: true,
    thickness: true,
    angle: true,
    emitter: true,
    snow: true,
    alpha: false,
    depth: true,
    position: true,
    object: true,
    material: true,
    residual: false,
};

const TEXT: &str = "[material.grey]\ntype = \"diffuse\"\nreflectance = 0.5\n\
    [[object]]\nshape = \"box\"\nsize = [2, 0.3, 4]\nposition = [-1, 0, 0]\nmaterial = \"snow\"\n\
    [[object]]\nshape = \"sphere\"\nradius = 1.2\nposition = [1.5, 0, 0]\nmaterial = \"grey\"\n\
    [[light]]\ntype = \"point\"\nposition = [0, 1, 0.5]\nradiant_intensity_w_sr = 10\n\
    [[light]]\ntype = \"sphere\"\nposition = [0, -3, 2]\nradius = 0.2\nradiance_w_m2_sr = 5\nilluminant = \"A\"\n";

/// A light field that is prepared quickly. Its pictures are compared with each other only.
const COARSE: &str = "[light_field]\nnodes = 3000\n";

/// A block of snow and a grey sphere, lit by two lights.
fn two_lights() -> Integrator {
    let mut scene = scene(&format!("{SNOW}{TEXT}"), &[]);
    scene.set_image_size(ImageSize { width: 23, height: 17 });
    scene.set_samples_per_pixel(Count::of(37));
    scene.set_max_bounces(Count::of(3));
    prepared(&scene, Some(&analytic_table()))
}

/// The same in direct light from the point light only.
fn direct_light() -> Integrator {
    let (text, _) = TEXT.rsplit_once("[[light]]").unwrap();
    let mut scene = scene(&format!("{SNOW}{text}"), &[]);
    scene.set_image_size(ImageSize { width: 23, height: 17 });
    scene.set_samples_per_pixel(Count::of(37));
    scene.set_max_bounces(Count::of(0));
    prepared(&scene, Some(&computed_table()))
}

fn block(columns: Range<u32>, rows: Range<u32>, samples: Range<u32>) -> SampleBlock {
    SampleBlock { columns, rows, samples }
}

fn sums_of(integrator: &Integrator, channels: Aovs, block: &SampleBlock) -> FilmAccumulator {
    let mut sums = accumulator(integrator.scene(), channels, &block.window());
    render_missing(integrator, block, &mut sums, RenderControl::default());
    sums
}

fn added(integrator: &Integrator, channels: Aovs, parts: &[SampleBlock]) -> FilmAccumulator {
    let mut sums = accumulator(integrator.scene(), channels, &all_samples(integrator.scene()).window());
    let mut parts = parts.to_vec();
    parts.sort_by_key(|part| part.samples.start);
    parts.iter().for_each(|part| sums.add(&sums_of(integrator, channels, part)).unwrap());
    sums
}

#[test]
fn ranges_and_tiles_sum_to_the_same_image() {
    for integrator in [two_lights(), direct_light()] {
        let at_once = sums_of(&integrator, Aovs::default(), &all_samples(integrator.scene()));
        assert!(at_once.film() == render_all(&integrator, &|_| {}).film);
        let (all_columns, all_rows) = (0..23, 0..17);
        let ranges = [30..37, 0..1, 1..6, 6..30].map(|samples| block(all_columns.clone(), all_rows.clone(), samples));
        let tiles = [(0..9, 0..17), (9..23, 5..17), (9..10, 0..5), (10..23, 0..5)]
            .map(|(columns, rows)| block(columns, rows, 0..37));
        let both = tiles.iter().flat_map(|tile| [11..37, 0..11].map(|samples| SampleBlock { samples, ..tile.clone() }));
        for parts in [ranges.to_vec(), tiles.to_vec(), both.collect()] {
            assert!(added(&integrator, Aovs::default(), &parts) == at_once, "{parts:?}");
        }
        let pixel = block(17..18, 5..6, 0..37);
        let place = 5 * 23 + 17;
        assert_eq!(sums_of(&integrator, Aovs::default(), &pixel).film().pixels()[0], at_once.film().pixels()[place]);
        // Fewer samples give a different image.
        assert!(sums_of(&integrator, Aovs::default(), &block(0..23, 0..17, 0..36)).film() != at_once.film());
    }
}

/// The filter of random walks works on the sums of the whole image.
#[test]
fn filtered_parts_are_the_filtered_image() {
    let (text, _) = TEXT.rsplit_once("[[light]]").unwrap();
    let mut scene = scene_of_few_grains("hybrid", &format!("{COARSE}{SNOW}{text}"), &[]);
    scene.set_image_size(ImageSize { width: 23, height: 17 });
    scene.set_samples_per_pixel(Count::of(9));
    let integrator = prepared(&scene, None);
    for aovs in [Aovs::default(), Aovs { spectrum: true, variance: true, ..Aovs::default() }] {
        let at_once = sums_of(&integrator, aovs, &all_samples(integrator.scene()));
        let parts = [block(0..9, 0..17, 0..9), block(9..23, 0..17, 4..9), block(9..23, 0..17, 0..4)];
        let merged = added(&integrator, aovs, &parts);
        assert!(merged == at_once && merged.film() == at_once.film());
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sums.exr");
        let provenance = integrator.provenance();
        resumable_file::write(&at_once, PictureSettings::default(), Some(&provenance), &[], &path).unwrap();
        assert!(ResumableImage::open(&path).unwrap().read_sums().unwrap() == at_once);
        // The colours of the file are those of the film.
        let channels = channels_of(&path);
        for (k, pixel) in at_once.film().pixels().iter().enumerate() {
            let LinearRgb { r, g, b } = LinearRgb::from_xyz(*pixel);
            for (name, value) in [("R", r), ("G", g), ("B", b)] {
                assert!((f64::from(channels[name][k]) - value).abs() <= 1e-6 * value.abs(), "{name} of pixel {k}");
            }
        }
    }
}

/// Which pixels are done is decided at the start of a pass, and holds when it goes on after an interrupt.
#[test]
fn a_noise_target_does_not_depend_on_threads_and_interrupts() {
    let (text, _) = TEXT.rsplit_once("[[light]]").unwrap();
    let with_target = |key: &str| {
        let settings = camera_of("hybrid").replace("[integrator]", &format!("[integrator]\n{key}"));
        let mut file = SceneFile::parse(format!("{settings}{COARSE}{SNOW}{text}"), Path::new("block.toml")).unwrap();
        file.description.light_field.grain_rays = 4096;
        let mut scene = file.build().unwrap();
        scene.set_image_size(ImageSize { width: 23, height: 17 });
        scene.set_samples_per_pixel(Count::of(40));
        prepared(&scene, None)
    };
    let (integrator, without) = (with_target("noise_target = 0.05"), with_target(""));
    let target = all_samples(integrator.scene());
    let at_once = sums_of(&integrator, Aovs::default(), &target);
    let all = sums_of(&without, Aovs::default(), &target);
    assert!(all.film() != at_once.film(), "some pixels are done before all samples");
    for (threads, questions) in [(1, 13), (3, 150)] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut sums = accumulator(integrator.scene(), Aovs::default(), &target.window());
        while sums.missing_count(&target) > 0 {
            let asked = AtomicU32::new(0);
            let stop = || asked.fetch_add(1, Ordering::Relaxed) > questions;
            let control = RenderControl { stop: &stop, ..RenderControl::default() };
            pool.install(|| render_missing(&integrator, &target, &mut sums, control));
        }
        assert!(sums == at_once, "{threads} threads, {questions} questions");
    }
}

#[test]
fn samples_that_do_not_follow_are_refused_and_nothing_is_added() {
    let integrator = direct_light();
    let parts = [block(0..23, 0..17, 2..5), block(3..9, 4..8, 4..7), block(3..9, 4..8, 6..7), block(3..9, 4..8, 0..2)];
    let [mut sums, overlap, gap, before] = parts.map(|part| sums_of(&integrator, Aovs::default(), &part));
    let alone = sums.clone();
    for (part, samples) in [(&overlap, "4:7"), (&gap, "6:7"), (&before, "0:2"), (&alone, "2:5")] {
        let message = sums.add(part).unwrap_err().to_string();
        let pixel = if part == &alone { "0,0" } else { "3,4" };
        assert_eq!(message, format!("the samples {samples} of pixel {pixel} do not follow 2:5"));
        assert!(sums == alone);
    }
    sums.add(&sums_of(&integrator, Aovs::default(), &block(3..9, 4..8, 5..7))).unwrap();
    let counts = sums.samples_per_pixel();
    assert_eq!((counts.fewest, counts.most), (3, 5));
}

#[test]
fn aovs_sum_to_the_same_image_and_only_the_spectrum_changes_colours_within_the_tables_error() {
    let integrator = two_lights();
    let at_once = sums_of(&integrator, ALL, &all_samples(integrator.scene()));
    let parts = [block(0..23, 0..7, 0..37), block(0..23, 7..17, 20..37), block(0..23, 7..17, 0..20)];
    assert!(added(&integrator, ALL, &parts) == at_once);
    let image = render_all(&integrator, &|_| {}).film;
    let without_spectrum = sums_of(&integrator, Aovs { spectrum: false, ..ALL }, &all_samples(integrator.scene()));
    assert!(without_spectrum.film() == image);
    // With spectra, colours are computed from them instead of from projected tables, whose error is below 2·10⁻⁴.
    for (with, without) in at_once.film().pixels().iter().zip(image.pixels()) {
        for (with, without) in [(with.x, without.x), (with.y, without.y), (with.z, without.z)] {
            assert!((with - without).abs() <= 2e-4 * without, "{with} {without}");
        }
    }
}

/// Snow by each method under any white has the colours of its spectra, also where PCASnow has a table of responses.
#[test]
fn any_light_may_be_white() {
    let temperatures = [2000, 2500, 3200, 4500, 6500, 9000, 15_000, 20_000].map(|kelvin| format!("{kelvin}K"));
    let whites: Vec<String> = Illuminant::all().map(|light| light.name().to_owned()).chain(temperatures).collect();
    let scene_under = |method: &str, white: &str| {
        let film = format!("width = 3\nheight = 3\nwhite = \"{white}\"");
        let text = camera_of(method).replace("width = 1\nheight = 1", &film);
        let body = "[[object]]\nshape = \"box\"\nsize = [2, 0.3, 4]\nmaterial = \"snow\"\n\
                    [[light]]\ntype = \"point\"\nposition = [0, 1, 0.5]\nradiant_intensity_w_sr = 10\n\
                    [[light]]\ntype = \"point\"\nposition = [0, -2, 0.5]\nradiant_intensity_w_sr = 1\n";
        parsed(format!("{text}{SNOW}{COARSE}{body}")).build(&FilesInMemory::default()).unwrap()
    };
    for method in ["pcasnow", "diffusion", "hybrid", "reference"] {
        // The light field does not depend on the white.
        let few = if method == "pcasnow" { 1 } else { 14 };
        for white in whites.iter().step_by(few) {
            let integrator = prepared(&scene_under(method, white), None);
            let [film, of_spectra] = [false, true].map(|spectrum| {
                let aovs = Aovs { spectrum, ..Aovs::default() };
                sums_of(&integrator, aovs, &all_samples(integrator.scene())).film()
            });
            for (pixel, of_spectrum) in film.pixels().iter().zip(of_spectra.pixels()) {
                let pairs = [(pixel.x, of_spectrum.x), (pixel.y, of_spectrum.y), (pixel.z, of_spectrum.z)];
                for (value, of_spectrum) in pairs {
                    assert!((value - of_spectrum).abs() <= 1e-3 * of_spectrum.abs(), "{method} {white}: {pixel:?}");
                }
            }
            assert!(film.pixels().iter().any(|pixel| pixel.y > 0.0), "{method} {white}");
        }
    }
}

#[test]
fn interrupted_and_resumed_rendering_gives_the_same_image_on_any_number_of_threads() {
    let integrator = two_lights();
    let target = all_samples(integrator.scene());
    let at_once = sums_of(&integrator, Aovs::default(), &target);
    // Whether to stop is asked before each pass, row and pixel: runs end within rows.
    for (threads, questions) in [(1, 13), (3, 150), (2, 1000)] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut sums = accumulator(integrator.scene(), Aovs::default(), &target.window());
        let mut runs = 0;
        while sums.missing_count(&target) > 0 {
            let asked = AtomicU32::new(0);
            let stop = || asked.fetch_add(1, Ordering::Relaxed) > questions;
            let before = sums.missing_count(&target);
            pool.install(|| {
                render_missing(
                    &integrator,
                    &target,
                    &mut sums,
                    RenderControl { stop: &stop, ..RenderControl::default() },
                )
            });
            assert!(sums.missing_count(&target) < before, "every run adds samples");
            runs += 1;
        }
        assert!(runs > 1);
        assert!(sums == at_once, "{threads} threads, {questions} questions");
    }
}

/// The values of all float channels of a file.
fn channels_of(path: &Path) -> BTreeMap<String, Vec<f32>> {
    let image = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let list = image.from_file(path).unwrap().layer_data.channel_data.list;
    let shown = list.into_iter().filter_map(|channel| match channel.sample_data {
        FlatSamples::F32(values) => Some((channel.name.to_string(), values)),
        _ => None,
    });
    shown.collect()
}

#[test]
fn files_keep_the_exact_sums_and_their_position_in_the_image() {
    let integrator = two_lights();
    let provenance = integrator.provenance();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part.exr");
    for channels in [Aovs::default(), ALL] {
        // Columns 4 and 5 have more samples.
        let mut sums = sums_of(&integrator, channels, &block(4..15, 3..12, 5..9));
        render_missing(&integrator, &block(4..6, 3..12, 5..12), &mut sums, RenderControl::default());
        let sky = LinearRgb { r: 0.5, g: 0.7, b: 1.0 }.xyz().with_luminance(1.0);
        let white = PictureWhite { white: WhiteBalance::Temperature(5123.4), sky: Some(sky) };
        let settings = PictureSettings { development: Exposure::Stops(-1.2).into(), white };
        resumable_file::write(&sums, settings, Some(&provenance), &[("seed", "1")], &path).unwrap();
        let file = ResumableImage::open(&path).unwrap();
        assert_eq!(
            (&file.provenance, file.aovs, file.image_size),
            (&provenance, sums.aovs(), ImageSize { width: 23, height: 17 })
        );
        assert_eq!((&file.samples, file.settings.development), (&(5..12), settings.development));
        assert_eq!(file.settings.white.white, white.white);
        let found = file.settings.white.sky.unwrap();
        assert!((found.x - sky.x).abs() + (found.z - sky.z).abs() < 1e-12, "{found:?} {sky:?}");
        let back = file.read_sums().unwrap();
        assert!(back == sums);
        let rest = SampleBlock { samples: 5..37, ..all_samples(integrator.scene()) };
        let mut completed = back.extended_to(&rest.window());
        render_missing(&integrator, &rest, &mut completed, RenderControl::default());
        assert!(completed == sums_of(&integrator, channels, &rest));
    }
    // A file without sums is not resumable.
    let sums = sums_of(&integrator, Aovs::default(), &all_samples(integrator.scene()));
    resumable_file::write(&sums, PictureSettings::default(), None, &[], &path).unwrap();
    // Automatic exposure needs to know where the picture shows a lamp, and where snow.
    assert_eq!(channels_of(&path).into_keys().collect::<Vec<_>>(), ["B", "G", "R", "emitter", "snow"]);
    assert!(ResumableImage::open(&path).unwrap_err().to_string().contains("no sums"));
    write_exr(&Film::new(ImageSize { width: 1, height: 1 }, vec![LinearRgb::default().xyz()]), &[], &path).unwrap();
    assert!(ResumableImage::open(&path).is_err());
    std::fs::write(&path, "v/1\u{1}nonsense").unwrap();
    assert!(ResumableImage::open(&path).unwrap_err().to_string().contains("not a readable EXR file"));
}

/// The encoder keeps attributes in a hash map, each with another order.
#[test]
fn files_of_the_same_sums_have_the_same_bytes() {
    let integrator = two_lights();
    let provenance = integrator.provenance();
    let folder = tempfile::tempdir().unwrap();
    let sums = sums_of(&integrator, ALL, &block(4..15, 3..12, 5..9));
    let written = |name: &str| {
        let path = folder.path().join(name);
        let settings = PictureSettings::default();
        resumable_file::write(&sums, settings, Some(&provenance), &[("seed", "1")], &path).unwrap();
        std::fs::read(path).unwrap()
    };
    let first = written("0.exr");
    for number in 1..8 {
        assert!(written(&format!("{number}.exr")) == first, "{number}");
    }
}

#[test]
fn channels_have_the_values_of_their_names() {
    let integrator = two_lights();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("all.exr");
    let sums = sums_of(&integrator, ALL, &all_samples(integrator.scene()));
    resumable_file::write(&sums, PictureSettings::default(), None, &[], &path).unwrap();
    let channels = channels_of(&path);
    assert_eq!(channels.len(), 3 + 31 + 3 + 3 + 3 + 1 + 1 + 1 + 1 + 1 + 3 + 2 * 4);
    // The camera is at (0, −9, 0). The block's front faces −y, in the left half of the image.
    let block = 8 * 23 + 7;
    let at = |name: &str| channels[name][block];
    assert!((at("normal.Y") + 1.0).abs() < 1e-6 && at("normal.X").abs() < 1e-6);
    assert!((at("thickness") - 0.3).abs() < 1e-6, "{}", at("thickness"));
    assert!((at("albedo.R") - 0.25).abs() < 0.003 && (at("albedo.B") - 0.25).abs() < 0.003, "R = 1/4");
    // The first light lies behind the block.
    assert!(at("angle") > 0.0 && at("angle") < 90.0);
    // A corner pixel shows nothing.
    for (name, values) in &channels {
        let expected: f32 = if name == "depth.Z" { 1e10 } else { 0.0 };
        assert_eq!(values[0].to_bits(), expected.to_bits(), "{name}");
    }
    // The spectrum has the colour of the pixel.
    let wavelengths = snowblue_render::scene::spectrum::wavelengths_nm();
    let names = wavelengths.map(|nm| format!("S0.{nm:.0},000000nm"));
    let observer = snowblue_color::Colorimeter::new(
        snowblue_color::Observer::Cie1931,
        snowblue_color::Illuminant::E,
        &wavelengths,
    );
    let spectrum: Vec<f64> = names.iter().map(|name| f64::from(channels[name][block]) * 310.0).collect();
    let LinearRgb { r, g, b } = LinearRgb::from_xyz(observer.unwrap().xyz(&spectrum.try_into().unwrap_or([0.0; 31])));
    for (name, expected) in [("R", r), ("G", g), ("B", b)] {
        assert!((f64::from(at(name)) - expected).abs() < 1e-6 * g, "{name}: {} {expected}", at(name));
    }
}

/// The variance estimated from 64 samples of one image, against the variance of means of 64 independent samples.
#[test]
fn the_variance_channel_agrees_with_the_variance_over_images() {
    let mut integrator = two_lights();
    let channels = Aovs { variance: true, ..Aovs::default() };
    let (pictures, samples) = (64u32, 16);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("variance.exr");
    let mut values: Vec<Vec<f64>> = Vec::new();
    let mut estimated = vec![0.0; 23 * 17];
    // The samples of a pixel are points of one Sobol sequence, whose mean varies less than that of independent points.
    // Single samples of different images are independent, so the means are taken across images.
    for sample in 0..samples {
        let mut across = vec![0.0; 23 * 17];
        for seed in 0..pictures {
            integrator.set_seed(1 + seed + pictures * sample);
            let one = sums_of(&integrator, channels, &block(0..23, 0..17, 0..1)).film();
            across.iter_mut().zip(one.pixels()).for_each(|(sum, xyz)| *sum += LinearRgb::from_xyz(*xyz).g);
        }
        values.push(across.iter().map(|sum| sum / f64::from(pictures)).collect());
    }
    let image_count = 8;
    for seed in 0..image_count {
        integrator.set_seed(5000 + seed);
        let sums = sums_of(&integrator, channels, &block(0..23, 0..17, 0..64));
        resumable_file::write(&sums, PictureSettings::default(), None, &[], &path).unwrap();
        let variance = &channels_of(&path)["variance.G"];
        estimated.iter_mut().zip(variance).for_each(|(sum, one)| *sum += f64::from(*one) / f64::from(image_count));
    }
    let (mut found, mut expected) = (0.0, 0.0);
    for pixel in 0..23 * 17 {
        let mean = values.iter().map(|one| one[pixel]).sum::<f64>() / f64::from(samples);
        found += values.iter().map(|one| (one[pixel] - mean).powi(2)).sum::<f64>() / f64::from(samples - 1);
        expected += estimated[pixel];
    }
    // 391 equal pixels with 15 degrees of freedom each would give 2 %. Most of the variance is at few edge pixels.
    assert!((found / expected - 1.0).abs() < 0.2, "{found} {expected}");
}
