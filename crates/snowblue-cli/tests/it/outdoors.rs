//! The scene of the chapter on snow outdoors shows bright snow. `scripts/check_commands` runs the chapter's commands.

use crate::shell::{Folder, decoded};

const CHAPTER: &str = include_str!("../../../../docs/src/outdoors.md");

/// The scene of the chapter: its blocks of TOML, one after the other.
fn scene() -> String {
    CHAPTER.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next()).collect()
}

#[test]
fn the_scene_of_the_chapter_is_bright_snow() {
    let folder = Folder::new();
    folder.write("path.toml", scene());
    let small = "--width 12 --height 8 --spp 4 --integrator diffusion --field-step-mm 100 --field-memory-mib 16";
    folder.stdout(&format!("render path.toml -o path.png {small}"));
    let (_, channels) = decoded(&folder.bytes("path.png"));
    // Little of it clips.
    let mean = channels.iter().map(|value| f64::from(*value)).sum::<f64>() / channels.len() as f64;
    assert!((110.0..235.0).contains(&mean), "{mean}");
}
