//! The program itself: its name, the scenes inside it, completions and manual pages.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use std::collections::BTreeSet;
use std::path::PathBuf;

use shell::{assert_names, assert_refused, decoded, shipped_scene, snowblue, stdout};

#[test]
fn the_program_has_one_name_and_version() {
    let version = env!("CARGO_PKG_VERSION");
    assert_eq!(stdout(&["--version"]), format!("snowblue {version}\n"));
    assert_eq!(stdout(&["database", "build", "--version"]), format!("snowblue-database-build {version}\n"));
}

/// A scene that is added to the folder must be added to the program.
#[test]
fn all_scenes_of_the_repository_are_inside_the_program() {
    let listed = stdout(&["render", "--list-scenes"]);
    let names: BTreeSet<&str> = listed.lines().map(|line| line.split_whitespace().next().unwrap()).collect();
    let files = std::fs::read_dir(shipped_scene("")).unwrap();
    let files: BTreeSet<String> = files
        .map(|file| PathBuf::from(file.unwrap().file_name()).file_stem().unwrap().to_str().unwrap().to_owned())
        .collect();
    assert_eq!(names, files.iter().map(String::as_str).collect());
    for line in listed.lines() {
        assert!(line.ends_with('.') && line.split_whitespace().count() > 5, "a summary: {line}");
    }
    for name in names {
        let file = shipped_scene(&format!("{name}.toml"));
        assert_eq!(stdout(&["render", "--scene", name, "--print"]), std::fs::read_to_string(file).unwrap());
    }
    assert_names(listed.lines().find(|line| line.contains("dragon")).unwrap(), &["models/dragon.ply"]);
}

#[test]
fn a_scene_inside_the_program_is_that_of_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let file = shipped_scene("block_30cm.toml");
    let small = ["--width", "20", "--height", "20", "--spp", "2", "--integrator", "pcasnow", "--quiet", "-o"];
    let picture = |scene: &[&str], name: &str| {
        stdout(&[&["render"][..], scene, &small, &[&at(name)]].concat());
        decoded(&std::fs::read(at(name)).unwrap())
    };
    let inside = picture(&["--scene", "block_30cm"], "inside.png");
    assert_eq!(inside, picture(&[file.to_str().unwrap()], "file.png"));
    assert!(inside.1.iter().any(|channel| *channel > 0));
    let never = at("never.png");
    let cases: [(&[&str], &[&str]); 5] = [
        (&["render", "-o", &never], &["scene file", "--scene NAME", "--list-scenes"]),
        (&["render", "--scene", "fig11_dragon", "-o", &never], &["fig11_dragon", "models/dragon.ply"]),
        (&["render", "--scene", "block", "-o", &never], &["'block'", "block_30cm", "igloo_clear"]),
        (&["render", "a.toml", "--scene", "block_30cm", "-o", &never], &["SCENE", "--scene"]),
        (&["bake", "-o", &at("never.glb")], &["scene file", "--scene NAME"]),
    ];
    for (arguments, words) in cases {
        assert_refused(arguments, words);
    }
}

/// The samples are the same, and so are all bytes of the file.
#[test]
fn two_runs_write_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let written = |name: &str| {
        let path = folder.path().join(name).to_str().unwrap().to_owned();
        let small = ["--width", "16", "--height", "16", "--spp", "2", "--integrator", "pcasnow", "--keep-sums"];
        stdout(&[&["render", "--scene", "block_30cm", "--aovs", "spectrum,angle", "-o", &path][..], &small].concat());
        std::fs::read(path).unwrap()
    };
    let first = written("a.exr");
    assert!(["b.exr", "c.exr"].into_iter().all(|name| written(name) == first));
}

#[test]
fn completions_know_commands_and_options() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        assert_names(&stdout(&["completions", shell]), &["snowblue", "spectrum", "grain-size", "list-scenes"]);
    }
    assert_refused(&["completions", "tcsh"], &["'tcsh'", "bash", "zsh"]);
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = tempfile::tempdir().unwrap();
    let pages = folder.path().join("man1");
    stdout(&["man", "-o", pages.to_str().unwrap()]);
    let page = |name: &str| std::fs::read_to_string(pages.join(name)).unwrap();
    assert_names(&page("snowblue-spectrum.1"), &[".TH snowblue-spectrum 1  \"snowblue ", "thickness", "Examples"]);
    assert_names(&page("snowblue-database-build.1"), &["preset"]);
    assert_eq!(page("snowblue.1"), stdout(&["man"]));
    let help = String::from_utf8(snowblue(&["--help"]).stdout).unwrap();
    let commands =
        help.lines().skip_while(|line| !line.starts_with("Commands:")).skip(1).take_while(|line| !line.is_empty());
    let commands: Vec<&str> = commands.filter(|line| line.starts_with("  ") && !line.starts_with("   ")).collect();
    assert!(commands.len() > 12, "{help}");
    for name in commands.into_iter().filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help") {
        assert!(pages.join(format!("snowblue-{name}.1")).exists(), "{name}");
    }
    assert_refused(&["man", "-o", folder.path().join("a/b").to_str().unwrap()], &["a/b"]);
}
