//! Pictures over a plate: alpha, depth, position and mattes.

use snowblue_base::Number;
use snowblue_base::files::FilesInMemory;
use snowblue_render::film::channels::channels;
use snowblue_render::render::{RenderControl, accumulator, all_samples, render_missing};
use snowblue_render::{Aovs, FilmAccumulator, SceneDescription};

use crate::snow::{SNOW, analytic_table, parsed, prepared};

/// Pixels of a row, and of a column.
const SIDE: usize = 8;
/// Distance of the wall along the viewing axis, and the place of its edge to the right of the axis, in m. A pixel is
/// 0.25 m wide there, and the edge crosses the fifth pixel of a row at 0.4 of its width.
const DISTANCE_M: f32 = 2.0;
const EDGE_M: f64 = 0.1;

/// A wall before a grey sky, left of an edge, moved by some lengths in m, and further tables.
fn wall(method: &str, [x, y, z]: [f64; 3], tables: &str) -> SceneDescription {
    // The image plane at distance 1 is 1 wide and high.
    let fov_deg = 2.0 * 0.5_f64.atan().to_degrees();
    parsed(format!(
        "[camera]\nposition = [{x}, {y}, {z}]\nlook_at = [{x}, {}, {z}]\nvertical_fov_deg = {fov_deg}\n\
         [film]\nwidth = {SIDE}\nheight = {SIDE}\n\
         [integrator]\ntype = \"{method}\"\nsamples_per_pixel = 256\nmax_bounces = 1\nseed = 3\n\
         [environment]\nradiance_w_m2_sr = 3\n\
         [material.wall]\ntype = \"diffuse\"\nreflectance = 0.5\n{SNOW}{tables}\
         [[object]]\nshape = \"box\"\nsize = [9, 0.1, 9]\nmaterial = \"wall\"\nposition = [{}, {}, {z}]\n",
        y + 1.0,
        x + EDGE_M - 4.5,
        y + f64::from(DISTANCE_M) + 0.05,
    ))
}

fn sums(description: &SceneDescription, aovs: Aovs) -> FilmAccumulator {
    let scene = description.build(&FilesInMemory::default()).unwrap_or_else(|error| panic!("{error}"));
    let (integrator, all) = (prepared(&scene, Some(&analytic_table())), all_samples(&scene));
    let mut sums = accumulator(&scene, aovs, &all.window());
    render_missing(&integrator, &all, &mut sums, RenderControl::default());
    sums
}

/// A function that gives a channel by its name.
fn rendered(description: &SceneDescription, aovs: Aovs) -> impl Fn(&str) -> Vec<f32> + use<> {
    let channels = channels(&sums(description, aovs));
    move |name| channels.iter().find(|channel| channel.name == name).map(|one| one.values.clone()).unwrap()
}

fn all_three() -> Aovs {
    Aovs { alpha: true, depth: true, position: true, ..Aovs::default() }
}

#[test]
fn alpha_is_the_covered_area() {
    let of = rendered(&wall("pcasnow", [0.0; 3], ""), all_three());
    for (index, alpha) in of("A").into_iter().enumerate() {
        match index % SIDE {
            0..4 => assert!(alpha >= 1.0, "{alpha}"),
            // 256 independent samples have a standard error of 0.03, and the stratified samples err less.
            4 => assert!((alpha - 0.4).abs() < 0.02, "{alpha}"),
            _ => assert!(alpha <= 0.0, "{alpha}"),
        }
    }
}

/// The colours are premultiplied: with the sky as the plate, the picture over the plate is the picture with its sky.
#[test]
fn a_picture_over_its_sky_is_the_picture_without_alpha() {
    let glass = "[material.pane]\ntype = \"glass\"\n\
                 [[object]]\nshape = \"box\"\nsize = [0.3, 0.01, 9]\nposition = [0.25, 1, 0]\nmaterial = \"pane\"\n";
    let lamp = "[[light]]\ntype = \"sphere\"\nposition = [0.9, 1.9, 0.3]\nradius = 0.05\nradiance_w_m2_sr = 50\n";
    for (method, tables, spectrum) in [
        ("pcasnow", String::new(), false),
        ("pcasnow", String::new(), true),
        ("hybrid", String::new(), false),
        ("reference", String::new(), false),
        ("pcasnow", glass.to_owned(), false),
        ("pcasnow", lamp.to_owned(), false),
    ] {
        let description = wall(method, [0.0; 3], &tables);
        let own = |alpha: bool| rendered(&description, Aovs { alpha, spectrum, ..Aovs::default() });
        let (plain, with_alpha) = (own(false), own(true));
        let alpha = with_alpha("A");
        assert!(alpha[0] >= 1.0);
        let empty = alpha.iter().position(|alpha| *alpha <= 0.0).unwrap();
        for name in ["R", "G", "B"] {
            let (plain, premultiplied) = (plain(name), with_alpha(name));
            let sky = plain[empty];
            for ((plain, premultiplied), alpha) in plain.iter().zip(premultiplied).zip(&alpha) {
                if *alpha >= 1.0 {
                    assert_eq!(premultiplied.to_bits(), plain.to_bits());
                } else if *alpha <= 0.0 {
                    assert_eq!(premultiplied.to_bits(), 0, "no sky, and no lamp before it");
                }
                let over = premultiplied + (1.0 - alpha) * sky;
                let shows_lamp = !tables.is_empty() && *plain > 2.0 * sky;
                assert!(shows_lamp || (over / plain - 1.0).abs() < 1e-5, "{method}: {over} {plain}");
            }
        }
    }
}

/// Depth is measured along the axis, as in Blender and Nuke: on a plane across the axis it is the same everywhere.
#[test]
fn depth_is_planar_and_positions_lie_on_the_surface() {
    for is_lens in [false, true] {
        let mut description = wall("pcasnow", [0.0; 3], "");
        if is_lens {
            let camera = description.camera.as_mut().unwrap();
            (camera.aperture, camera.focus) = (Number::new(0.1).unwrap(), Some(Number::new(1.0).unwrap()));
        }
        let of = rendered(&description, all_three());
        let [alpha, depth, x, y, z] = ["A", "depth.Z", "position.X", "position.Y", "position.Z"].map(of);
        for (index, alpha) in alpha.iter().enumerate() {
            if *alpha <= 0.0 {
                let values = [depth[index], x[index], y[index], z[index]].map(f32::to_bits);
                assert_eq!(values, [1e10_f32.to_bits(), 0, 0, 0]);
                continue;
            }
            assert!((depth[index] - DISTANCE_M).abs() < 1e-5, "{}", depth[index]);
            assert!((y[index] - DISTANCE_M).abs() < 1e-5, "{}", y[index]);
            if *alpha >= 1.0 && !is_lens {
                let [column, row] = [index % SIDE, index / SIDE].map(|place| 0.25 * (place as f32 + 0.5) - 1.0);
                assert!((x[index] - column).abs() < 0.01 && (z[index] + row).abs() < 0.01, "{} {}", x[index], z[index]);
            }
        }
    }
}

/// Positions count from the local origin of the scene. In a national grid, floats have steps of half a metre.
#[test]
fn positions_in_a_national_grid_are_as_fine_as_near_its_origin() {
    let of = rendered(&wall("pcasnow", [54_300.0, 5_190_200.0, 2400.0], ""), all_three());
    let [depth, x, y, z] = ["depth.Z", "position.X", "position.Y", "position.Z"].map(|name| of(name)[0]);
    assert!((depth - DISTANCE_M).abs() < 1e-3, "{depth}");
    // The origin lies at 54,000, 5,190,000 and 2000 m.
    assert!((x - 299.125).abs() < 0.02 && (z - 400.875).abs() < 0.02, "{x} {z}");
    assert!((y - 202.0).abs() < 1e-3, "{y}");
}

/// The fraction of each pixel that a name covers, by the manifest of the mattes.
fn matte(sums: &FilmAccumulator, layer: &str, name: &str) -> Vec<f32> {
    let attributes = sums.attributes();
    let (key, _) = attributes.iter().find(|(key, text)| key.ends_with("/name") && *text == layer).unwrap();
    let manifest = &attributes[&key.replace("/name", "/manifest")];
    let manifest: serde_json::Value = serde_json::from_str(manifest).unwrap();
    let id = u32::from_str_radix(manifest[name].as_str().unwrap(), 16).unwrap();
    let (channels, mut coverage) = (channels(sums), vec![0.0; SIDE * SIDE]);
    let values = |name: String| channels.iter().find(|channel| channel.name == name).map(|channel| &channel.values);
    for (number, [of_ids, of_coverage]) in (0..4).flat_map(|number| [(number, ["R", "G"]), (number, ["B", "A"])]) {
        let Some(ids) = values(format!("{layer}{number:02}.{of_ids}")) else { continue };
        let covered = values(format!("{layer}{number:02}.{of_coverage}")).unwrap();
        let of_name =
            ids.iter().zip(covered).map(|(found, covered)| if found.to_bits() == id { *covered } else { 0.0 });
        coverage.iter_mut().zip(of_name).for_each(|(sum, covered)| *sum += covered);
    }
    coverage
}

/// A wall that covers 0.4 of the fifth pixel of a row, a ball before it, and a pane before the last row.
fn scene_with_mattes(noise_target: Option<f64>) -> SceneDescription {
    let more = "[material.pane]\ntype = \"glass\"\n\
                [[object]]\nshape = \"box\"\nsize = [9, 0.01, 0.2]\nposition = [0, 0.5, -0.3]\nmaterial = \"pane\"\n\
                [[object]]\nname = \"Ball \\\"1\\\"\"\nshape = \"sphere\"\nradius = 0.3\nposition = [-0.5, 1.5, 0]\n\
                material = \"snow\"\n";
    let mut description = wall("pcasnow", [0.0; 3], more);
    description.integrator.noise_target = noise_target.map(|target| Number::new(target).unwrap());
    description
}

#[test]
fn mattes_are_the_covered_areas() {
    let mattes = Aovs { object: true, material: true, alpha: true, snow: true, ..Aovs::default() };
    for noise_target in [None, Some(0.5)] {
        let sums = sums(&scene_with_mattes(noise_target), mattes);
        let [ball, boxes] = ["Ball \"1\"", "box"].map(|name| matte(&sums, "CryptoObject", name));
        let [snow, wall] = ["snow", "wall"].map(|name| matte(&sums, "CryptoMaterial", name));
        assert!(matte(&sums, "CryptoMaterial", "pane").iter().all(|coverage| *coverage <= 0.0), "panes do not count");
        assert_eq!((&ball, &boxes), (&snow, &wall));
        assert!(ball.iter().any(|coverage| *coverage >= 1.0));
        let edge = |row: usize| boxes[row * SIDE + 4];
        assert!((edge(0) - 0.4).abs() < if noise_target.is_none() { 0.02 } else { 0.15 }, "{}", edge(0));
        if noise_target.is_none() {
            let channels = channels(&sums);
            let of = |name: &str| &channels.iter().find(|channel| channel.name == name).unwrap().values;
            for (pixel, (alpha, of_snow)) in of("A").iter().zip(of("snow")).enumerate().take(7 * SIDE) {
                assert!((ball[pixel] + boxes[pixel] - alpha).abs() < 1e-6 && (ball[pixel] - of_snow).abs() < 1e-6);
            }
        }
    }
}
