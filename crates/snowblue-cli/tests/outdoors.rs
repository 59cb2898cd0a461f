//! The scene of the chapter on snow outdoors renders as the chapter builds it.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use shell::{decoded, stdout};

const CHAPTER: &str = include_str!("../../../docs/src/outdoors.md");

/// The scene of the chapter: its blocks of TOML, one after the other.
fn scene() -> String {
    CHAPTER.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next()).collect()
}

#[test]
fn the_scene_of_the_chapter_is_bright_snow() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::write(path("path.toml"), scene()).unwrap();
    let small = ["--width", "36", "--height", "24", "--integrator", "diffusion", "--field-step-mm", "70"];
    stdout(&[&["render", &*path("path.toml"), "-o", &*path("path.png")], &small[..]].concat());
    let (_, channels) = decoded(&std::fs::read(path("path.png")).unwrap());
    // Little of it clips.
    let mean = channels.iter().map(|value| f64::from(*value)).sum::<f64>() / channels.len() as f64;
    assert!((110.0..235.0).contains(&mean), "{mean}");
}
