//! The scenes of the repository: each renders, and its snow is watertight.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use std::path::PathBuf;

use shell::{assert_names, assert_refused, shipped_scene, stderr, stdout};
use snowblue_render::SceneFile;
use snowblue_render::render::render;
use snowblue_render::scene::description::SceneDescription;
use snowblue_render::scene::inspection::inspect;

fn scenes() -> Vec<PathBuf> {
    let folder = shipped_scene("");
    let mut scenes: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    scenes.retain(|scene| scene.extension().is_some_and(|ending| ending == "toml"));
    scenes.sort();
    scenes
}

#[test]
fn scenes_have_a_description_render_and_are_watertight() {
    let scenes = scenes();
    assert!(scenes.len() >= 8, "{scenes:?}");
    for path in &scenes {
        let text = std::fs::read_to_string(path).unwrap();
        let name = path.to_str().unwrap();
        assert!(text.starts_with("# "), "{name}: the first line describes the scene");
        if text.contains("dragon.ply") && !path.with_file_name("../models/dragon.ply").is_file() {
            assert_refused(&["render", name, "--check"], &["dragon.ply"]);
            continue;
        }
        let mut file = SceneFile::open(path).unwrap();
        let SceneDescription { film, integrator, light_field, .. } = &mut file.description;
        (film.width, film.height, integrator.samples_per_pixel) = (8, 8, 1);
        // Coarse cells: whether the scene renders does not depend on their size, and its time does.
        match &mut light_field.step_mm {
            Some(step_mm) => *step_mm *= 4.0,
            None => light_field.memory_mib = 16,
        }
        // Built once for both: the meshes of the large scenes take seconds.
        let scene = file.build().unwrap();
        let film = render(&scene).unwrap().film;
        assert!(film.pixels().iter().all(|xyz| xyz.y.is_finite()), "{name}");
        assert!(film.pixels().iter().any(|xyz| xyz.y > 0.0), "{name} is black");
        let objects = inspect(&scene);
        assert!(!objects.is_empty(), "{name}");
        let open: Vec<_> = objects.iter().filter(|object| object.is_snow && !object.is_watertight()).collect();
        assert!(open.is_empty(), "{name}: {open:?}");
    }
}

#[test]
fn an_igloo_has_a_watertight_object_for_each_block() {
    let igloo = scenes().into_iter().find(|scene| scene.ends_with("fig10_igloo.toml")).unwrap();
    let objects = stdout(&["render", igloo.to_str().unwrap(), "--check", "--format", "csv"]);
    let blocks: Vec<&str> = objects.lines().filter(|line| line.contains(",igloo,")).collect();
    assert!(blocks.len() > 50 && blocks.iter().all(|block| block.contains(",igloo,yes,yes,")), "{objects}");
}

#[test]
fn impossible_igloos_and_drifts_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bad.toml");
    let head = "[camera]\nposition = [0, -9, 9]\nlook_at = [0, 0, 0]\n[environment]\nradiance_w_m2_sr = 1\n\
                [material.snow]\ntype = \"snow\"\ngrain_size_um = 400\nfacetness = 0.3\ndensity_kg_m3 = 300\n\
                [[object]]\nmaterial = \"snow\"\n";
    let cases = [
        ("shape = \"igloo\"\nwall = 3", &["wall", "3 m", "0.02"][..]),
        ("shape = \"igloo\"\nsize = [1, 1, 1]", &["size"]),
        ("shape = \"igloo\"\nseam_depth = 0.1", &["seam_depth", "0.1 m"]),
        ("shape = \"drift\"\nsize = [1, 1, 0.2]\nmounds = [[0, 0, 1]]", &["mounds"]),
        ("shape = \"drift\"\nsize = [1, 1, 0.2]\nmounds = [[0, 0, 1, 0]]", &["mounds"]),
        ("shape = \"drift\"\nsize = [1, 1, 0.01]\nrelief = 0.5", &["-0.01 m", "height"]),
    ];
    for (object, expected) in cases {
        std::fs::write(&file, format!("{head}{object}\n")).unwrap();
        assert_refused(&["render", file.to_str().unwrap(), "--check"], &[&["bad.toml:"], expected].concat());
    }
}

/// Fig. 9 has twelve blocks, of which those lit from behind are rendered in two ways. Fig. 11 reports a missing mesh.
#[test]
fn figures_show_renderings_and_report_a_missing_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().to_str().unwrap();
    assert_names(&stderr(&["figures", "-o", place, "--only", "fig9,fig11"]), &["fig11", "models/dragon.ply"]);
    let page = std::fs::read_to_string(folder.path().join("index.html")).unwrap();
    assert_names(&page, &["Not rendered", "models/dragon.ply", "scripts/fetch-models"]);
    let views = [("front", ""), ("back", ""), ("back", "_ours"), ("oblique", ""), ("oblique", "_ours")];
    for (view, way) in views {
        for thickness in [5, 10, 15, 30] {
            let name = format!("fig9_{view}_{thickness}{way}.png");
            assert!(page.contains(&format!("src=\"{name}\"")) && folder.path().join(&name).is_file(), "{name}");
        }
    }
    let numbers = std::fs::read_to_string(folder.path().join("fig9.csv")).unwrap();
    assert_eq!(numbers.lines().count(), 1 + 20);
    assert!(numbers.lines().skip(1).all(|line| line.ends_with(",0")), "no ray found snow open: {numbers}");
}
