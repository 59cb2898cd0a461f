//! The scenes that ship: each is read and rendered, and its snow is watertight.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use std::path::{Path, PathBuf};

use shell::{refused, snowblue, stdout};

fn scenes() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut scenes: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    scenes.retain(|scene| scene.extension().is_some_and(|ending| ending == "toml"));
    scenes.sort();
    scenes
}

#[test]
fn each_tells_what_it_shows_is_rendered_and_holds_watertight_snow() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("small.png");
    let picture = picture.to_str().unwrap();
    let scenes = scenes();
    assert!(scenes.len() >= 8, "{scenes:?}");
    for scene in &scenes {
        let text = std::fs::read_to_string(scene).unwrap();
        assert!(text.starts_with("# "), "{}: a first line says what it shows", scene.display());
        let scene = scene.to_str().unwrap();
        if text.contains("dragon.ply") && !Path::new(scene).with_file_name("../models/dragon.ply").is_file() {
            assert!(refused(&["render", scene, "-o", picture]).contains("dragon.ply does not exist"));
            continue;
        }
        stdout(&["render", scene, "--width", "8", "--height", "8", "--spp", "1", "-o", picture]);
        assert_eq!(std::fs::read(picture).unwrap()[..8], *b"\x89PNG\r\n\x1a\n", "{scene}");
        let objects = stdout(&["render", scene, "--check", "--format", "csv"]);
        assert!(objects.lines().count() >= 2, "{objects}");
    }
}

#[test]
fn an_igloo_is_one_watertight_object_for_each_block() {
    let igloo = scenes().into_iter().find(|scene| scene.ends_with("fig10_igloo.toml")).unwrap();
    let objects = stdout(&["render", igloo.to_str().unwrap(), "--check", "--format", "csv"]);
    let blocks: Vec<&str> = objects.lines().filter(|line| line.contains(",igloo,")).collect();
    assert!(blocks.len() > 50 && blocks.iter().all(|block| block.contains(",igloo,yes,yes,")), "{objects}");
}

#[test]
fn igloos_and_drifts_that_cannot_be_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bad.toml");
    let head = "[camera]\nposition = [0, -9, 9]\nlook_at = [0, 0, 0]\n[environment]\nradiance_w_m2_sr = 1\n\
                [material.snow]\ntype = \"pca_snow\"\ngrain_size_um = 400\nfacetness = 0.3\ndensity_kg_m3 = 300\n\
                [[object]]\nmaterial = \"snow\"\n";
    let cases = [
        ("shape = \"igloo\"\nwall = 3", "object.wall is 3 m, but must lie in 0.02 to 0.75 m"),
        ("shape = \"igloo\"\nsize = [1, 1, 1]", "unknown key `size`"),
        ("shape = \"igloo\"\nseam_depth = 0.1", "object.seam_depth is 0.1 m"),
        (
            "shape = \"drift\"\nsize = [1, 1, 0.2]\nmounds = [[0, 0, 1]]",
            "object.mounds must be rows of x, y, height and radius",
        ),
        ("shape = \"drift\"\nsize = [1, 1, 0.2]\nmounds = [[0, 0, 1, 0]]", "object.mounds must be rows"),
        ("shape = \"drift\"\nsize = [1, 1, 0.01]\nrelief = 0.5", "must lie below the least height"),
    ];
    for (object, expected) in cases {
        std::fs::write(&file, format!("{head}{object}\n")).unwrap();
        let message = refused(&["render", file.to_str().unwrap(), "--check"]);
        assert!(message.contains("bad.toml:") && message.contains(expected), "{message}");
    }
}

/// There are twelve blocks, and the figure of the dragon says what is missing.
#[test]
fn figures_show_pictures_and_tell_of_a_missing_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().to_str().unwrap();
    let output = snowblue(&["figures", "-o", place, "--only", "fig9,fig11"]);
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && told.contains("scripts/fetch-models"), "{told}");
    let page = std::fs::read_to_string(folder.path().join("index.html")).unwrap();
    assert!(page.contains("Not rendered. models/dragon.ply is not here: run scripts/fetch-models"), "{page}");
    for view in ["front", "back", "oblique"] {
        for thickness in [5, 10, 15, 30] {
            let name = format!("fig9_{view}_{thickness}.png");
            assert!(page.contains(&format!("src=\"{name}\"")) && folder.path().join(&name).is_file(), "{name}");
        }
    }
    let numbers = std::fs::read_to_string(folder.path().join("fig9.csv")).unwrap();
    assert_eq!(numbers.lines().count(), 1 + 12);
    assert!(numbers.lines().skip(1).all(|line| line.ends_with(",0")), "no line found snow open: {numbers}");
}
