//! A picture rendered in parts is the picture: ranges of samples, tiles, interrupts and files change no bit.

#![allow(clippy::unwrap_used, clippy::cast_possible_truncation, reason = "tests may panic, and channels are single")]

mod snow;

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};

use exr::prelude::{FlatSamples, ReadChannels, ReadLayers, read};
use snow::{SNOW, real, scene, simple_law};
use snowblue_color::LinearRgb;
use snowblue_render::film::Film;
use snowblue_render::film::aov::Aovs;
use snowblue_render::film::exposure::Exposure;
use snowblue_render::film::image_file::write_exr;
use snowblue_render::film::provenance::Provenance;
use snowblue_render::film::resumable_file::{self, ResumableImage, ResumeData};
use snowblue_render::images::raster::ImageSize;
use snowblue_render::render::{RenderControl, accumulator, all_samples, render, render_missing};
use snowblue_render::scene::Scene;
use snowblue_render::{FilmAccumulator, SampleBlock};

const ALL: Aovs = Aovs { spectrum: true, variance: true, normal: true, albedo: true, thickness: true, angle: true };

const TEXT: &str = "path = \"brightest\"\n[material.grey]\ntype = \"diffuse\"\nreflectance = 0.5\n\
    [[object]]\nshape = \"box\"\nsize = [2, 0.3, 4]\nposition = [-1, 0, 0]\nmaterial = \"snow\"\n\
    [[object]]\nshape = \"sphere\"\nradius = 1.2\nposition = [1.5, 0, 0]\nmaterial = \"grey\"\n\
    [[light]]\ntype = \"point\"\nposition = [0, 1, 0.5]\nradiant_intensity_w_sr = 10\n\
    [[light]]\ntype = \"sphere\"\nposition = [0, -3, 2]\nradius = 0.2\nradiance_w_m2_sr = 5\nilluminant = \"A\"\n";

/// A block of snow and a grey ball, lit by two lamps.
fn pictured() -> Scene {
    let mut scene = scene(&format!("{SNOW}{TEXT}"), &simple_law(), &[]);
    scene.set_image_size(ImageSize { width: 23, height: 17 });
    scene.set_samples_per_pixel(37);
    scene.set_max_bounces(3);
    scene
}

/// The same in light straight from the lamp without extent, which goes a way of its own.
fn lit_directly() -> Scene {
    let (text, _) = TEXT.rsplit_once("[[light]]").unwrap();
    let mut scene = scene(&format!("{SNOW}{text}"), &real(), &[]);
    scene.set_image_size(ImageSize { width: 23, height: 17 });
    scene.set_samples_per_pixel(37);
    scene.set_max_bounces(0);
    scene
}

fn portion(columns: Range<u32>, rows: Range<u32>, samples: Range<u32>) -> SampleBlock {
    SampleBlock { columns, rows, samples }
}

fn sums_of(scene: &Scene, channels: Aovs, portion: &SampleBlock) -> FilmAccumulator {
    let mut sums = accumulator(scene, channels, &portion.window());
    render_missing(scene, portion, &mut sums, RenderControl::default());
    sums
}

fn added(scene: &Scene, channels: Aovs, parts: &[SampleBlock]) -> FilmAccumulator {
    let mut sums = accumulator(scene, channels, &all_samples(scene).window());
    parts.iter().for_each(|part| sums.add(&sums_of(scene, channels, part)));
    sums
}

#[test]
fn ranges_tiles_and_both_make_the_same_picture() {
    for scene in [pictured(), lit_directly()] {
        let at_once = sums_of(&scene, Aovs::default(), &all_samples(&scene));
        assert!(at_once.film() == render(&scene, &|_| {}).film);
        let (all_columns, all_rows) = (0..23, 0..17);
        let ranges = [30..37, 0..1, 1..6, 6..30].map(|samples| portion(all_columns.clone(), all_rows.clone(), samples));
        let tiles = [(0..9, 0..17), (9..23, 5..17), (9..10, 0..5), (10..23, 0..5)]
            .map(|(columns, rows)| portion(columns, rows, 0..37));
        let both = tiles.iter().flat_map(|tile| [11..37, 0..11].map(|samples| SampleBlock { samples, ..tile.clone() }));
        for parts in [ranges.to_vec(), tiles.to_vec(), both.collect()] {
            assert!(added(&scene, Aovs::default(), &parts) == at_once, "{parts:?}");
        }
        let pixel = portion(17..18, 5..6, 0..37);
        let place = 5 * 23 + 17;
        assert_eq!(sums_of(&scene, Aovs::default(), &pixel).film().pixels()[0], at_once.film().pixels()[place]);
        // A picture of fewer samples is another.
        assert!(sums_of(&scene, Aovs::default(), &portion(0..23, 0..17, 0..36)).film() != at_once.film());
    }
}

#[test]
fn all_channels_are_the_same_in_parts_and_leave_the_colours_alone() {
    let scene = pictured();
    let at_once = sums_of(&scene, ALL, &all_samples(&scene));
    let parts = [portion(0..23, 0..7, 0..37), portion(0..23, 7..17, 20..37), portion(0..23, 7..17, 0..20)];
    assert!(added(&scene, ALL, &parts) == at_once);
    assert!(at_once.film() == render(&scene, &|_| {}).film);
}

#[test]
fn stopped_and_continued_it_is_the_same_on_any_number_of_threads() {
    let scene = pictured();
    let target = all_samples(&scene);
    let at_once = sums_of(&scene, Aovs::default(), &target);
    for (threads, rows_at_a_time) in [(1, 1), (3, 5), (2, 40)] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut sums = accumulator(&scene, Aovs::default(), &target.window());
        let mut goes = 0;
        while !sums.coverage().missing_from(&target).is_empty() {
            let asked = AtomicU32::new(0);
            let stop = || asked.fetch_add(1, Ordering::Relaxed) > rows_at_a_time;
            let before = sums.coverage().clone();
            pool.install(|| {
                render_missing(&scene, &target, &mut sums, RenderControl { stop: &stop, ..RenderControl::default() })
            });
            assert_ne!(*sums.coverage(), before, "every go does something");
            goes += 1;
        }
        assert!(goes > 1);
        assert!(sums == at_once, "{threads} threads, {rows_at_a_time} rows at a time");
    }
}

/// The numbers of all channels of a file.
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
fn files_keep_the_sums_to_the_last_bit_and_their_place_in_the_picture() {
    let scene = pictured();
    let origin = Provenance::of(&scene, &simple_law());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part.exr");
    for channels in [Aovs::default(), ALL] {
        let mut sums = sums_of(&scene, channels, &portion(4..15, 3..12, 5..9));
        render_missing(&scene, &portion(4..6, 3..12, 9..12), &mut sums, RenderControl::default());
        let kept = ResumeData { provenance: &origin, exposure: Exposure::Stops(-1.2) };
        resumable_file::write(&sums, Some(kept), &[("seed", "1")], &path).unwrap();
        let part = ResumableImage::open(&path).unwrap();
        assert_eq!(
            (&part.provenance, part.aovs, part.image_size),
            (&origin, channels, ImageSize { width: 23, height: 17 })
        );
        assert_eq!((&part.coverage, part.exposure), (sums.coverage(), kept.exposure));
        let back = part.read_sums().unwrap();
        assert!(back == sums);
        let grown = |sums: FilmAccumulator| {
            let mut sums = sums.extended_to(&all_samples(&scene).window());
            render_missing(&scene, &all_samples(&scene), &mut sums, RenderControl::default());
            sums
        };
        assert!(grown(back) == grown(sums));
    }
    // Without sums a file is a picture only.
    resumable_file::write(&sums_of(&scene, Aovs::default(), &all_samples(&scene)), None, &[], &path).unwrap();
    assert_eq!(channels_of(&path).into_keys().collect::<Vec<_>>(), ["B", "G", "R"]);
    assert!(ResumableImage::open(&path).unwrap_err().to_string().contains("no sums"));
    write_exr(&Film::new(ImageSize { width: 1, height: 1 }, vec![LinearRgb::default().xyz()]), &[], &path).unwrap();
    assert!(ResumableImage::open(&path).is_err());
    std::fs::write(&path, "v/1\u{1}nonsense").unwrap();
    assert!(ResumableImage::open(&path).unwrap_err().to_string().contains("not a readable EXR file"));
}

#[test]
fn channels_tell_what_they_are_named_for() {
    let scene = pictured();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("all.exr");
    let sums = sums_of(&scene, ALL, &all_samples(&scene));
    resumable_file::write(&sums, None, &[], &path).unwrap();
    let channels = channels_of(&path);
    assert_eq!(channels.len(), 3 + 31 + 3 + 3 + 3 + 1 + 1);
    // The camera is at (0, −9, 0): the block's front, towards −y, is on the left of the picture.
    let block = 8 * 23 + 7;
    let at = |name: &str| channels[name][block];
    assert!((at("normal.Y") + 1.0).abs() < 1e-6 && at("normal.X").abs() < 1e-6);
    assert!((at("thickness") - 0.3).abs() < 1e-6, "{}", at("thickness"));
    assert!((at("albedo.R") - 0.25).abs() < 0.003 && (at("albedo.B") - 0.25).abs() < 0.003, "R = 1/4");
    // The first light is behind the block.
    assert!(at("angle") > 0.0 && at("angle") < 90.0);
    // A corner shows nothing.
    assert!(channels.values().all(|values| values[0].to_bits() == 0), "nothing is there but darkness");
    // The mean of the spectrum is that of the colour: luminance by the observer's curve.
    let wavelengths = snowblue_render::spectrum::wavelengths_nm();
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

/// The variance of the mean of 64 samples of one picture against the scatter of means of 64 independent ones.
#[test]
fn variances_are_those_of_many_pictures() {
    let mut scene = pictured();
    let channels = Aovs { variance: true, ..Aovs::default() };
    let (pictures, samples) = (64u32, 16);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("variance.exr");
    let mut values: Vec<Vec<f64>> = Vec::new();
    let mut told = vec![0.0; 23 * 17];
    // A pixel's samples are points of one Sobol set, whose mean varies less than that of independent ones. One sample of
    // every picture is independent of the others, so means are taken across pictures.
    for sample in 0..samples {
        let mut across = vec![0.0; 23 * 17];
        for seed in 0..pictures {
            scene.set_seed(1 + seed + pictures * sample);
            let one = sums_of(&scene, channels, &portion(0..23, 0..17, 0..1)).film();
            across.iter_mut().zip(one.pixels()).for_each(|(sum, xyz)| *sum += LinearRgb::from_xyz(*xyz).g);
        }
        values.push(across.iter().map(|sum| sum / f64::from(pictures)).collect());
    }
    let told_by = 8;
    for seed in 0..told_by {
        scene.set_seed(5000 + seed);
        let sums = sums_of(&scene, channels, &portion(0..23, 0..17, 0..64));
        resumable_file::write(&sums, None, &[], &path).unwrap();
        let variance = &channels_of(&path)["variance.G"];
        told.iter_mut().zip(variance).for_each(|(sum, one)| *sum += f64::from(*one) / f64::from(told_by));
    }
    let (mut found, mut expected) = (0.0, 0.0);
    for pixel in 0..23 * 17 {
        let mean = values.iter().map(|one| one[pixel]).sum::<f64>() / f64::from(samples);
        found += values.iter().map(|one| (one[pixel] - mean).powi(2)).sum::<f64>() / f64::from(samples - 1);
        expected += told[pixel];
    }
    // 391 pixels of 15 degrees each, were they alike: 2 %; they are not, but edges make up most of the variance.
    assert!((found / expected - 1.0).abs() < 0.2, "{found} {expected}");
}
