//! The scene of the chapter on snow outdoors renders as the chapter builds it.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use shell::{decoded, stderr};

const CHAPTER: &str = include_str!("../../../docs/src/outdoors.md");

/// The blocks of the chapter in a language, one after the other.
fn blocks(language: &str) -> String {
    let fence = format!("```{language}\n");
    CHAPTER.split(&fence).skip(1).filter_map(|rest| rest.split("```").next()).collect()
}

#[test]
fn the_scene_of_the_chapter_is_a_film_of_an_afternoon() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::write(path("path.toml"), blocks("toml")).unwrap();
    let small = ["--width", "36", "--height", "24", "--integrator", "diffusion", "--field-step-mm", "70"];
    let (scene, output) = (path("path.toml"), path("{}.png"));
    let said = stderr(&[&["render", &*scene, "--frames", "2", "-o", &*output], &small[..]].concat());
    for name in ["0000.png", "0001.png"] {
        let (_, channels) = decoded(&std::fs::read(path(name)).unwrap());
        // Snow is bright at either exposure, and little of it clips.
        let mean = channels.iter().map(|value| f64::from(*value)).sum::<f64>() / channels.len() as f64;
        assert!((110.0..235.0).contains(&mean), "{name}: {mean} {said}");
    }
}
