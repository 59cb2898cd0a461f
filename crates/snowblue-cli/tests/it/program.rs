//! The program itself: its name, the scenes inside it, completions and manual pages.

use std::collections::BTreeSet;
use std::path::PathBuf;

use crate::shell::{Folder, assert_names, decoded, shipped_scene, stdout};

#[test]
fn the_program_has_one_name_and_version() {
    let version = env!("CARGO_PKG_VERSION");
    assert_eq!(stdout("--version"), format!("snowblue {version}\n"));
    assert_eq!(stdout("database build --version"), format!("snowblue-database-build {version}\n"));
}

/// A scene that is added to the folder must be added to the program.
#[test]
fn all_scenes_of_the_repository_are_inside_the_program() {
    let listed = stdout("render --list-scenes");
    let names: BTreeSet<&str> = listed.lines().map(|line| line.split_whitespace().next().unwrap()).collect();
    let files = std::fs::read_dir(shipped_scene("")).unwrap();
    let files: BTreeSet<String> = files
        .map(|file| PathBuf::from(file.unwrap().file_name()))
        .filter(|file| file.extension().is_some_and(|extension| extension == "toml"))
        .map(|file| file.file_stem().unwrap().to_str().unwrap().to_owned())
        .collect();
    assert_eq!(names, files.iter().map(String::as_str).collect());
    for line in listed.lines() {
        assert!(line.ends_with('.') && line.split_whitespace().count() > 5, "a summary: {line}");
    }
    for name in names {
        let file = shipped_scene(&format!("{name}.toml"));
        assert_eq!(stdout(&format!("render --scene {name} --print")), std::fs::read_to_string(file).unwrap());
    }
    assert_names(listed.lines().find(|line| line.contains("dragon")).unwrap(), &["models/dragon.ply"]);
}

#[test]
fn a_scene_inside_the_program_is_that_of_its_file() {
    let folder = Folder::new();
    let file = shipped_scene("block_30cm.toml").display().to_string();
    let picture = |scene: &str, name: &str| {
        let small = "--width 8 --height 8 --spp 2 --integrator pcasnow --quiet";
        folder.stdout(&format!("render {scene} {small} -o {name}"));
        decoded(&folder.bytes(name))
    };
    let inside = picture("--scene block_30cm", "inside.png");
    assert_eq!(inside, picture(&file, "file.png"));
    assert!(inside.1.iter().any(|channel| *channel > 0));
}

/// The samples are the same, and so are all bytes of the file.
#[test]
fn two_runs_write_the_same_bytes() {
    let folder = Folder::new();
    let [first, second] = ["a.exr", "b.exr"].map(|name| {
        let small = "--width 8 --height 8 --spp 2 --integrator pcasnow --keep-sums --aovs spectrum,angle";
        folder.stdout(&format!("render --scene block_30cm {small} -o {name}"));
        folder.bytes(name)
    });
    assert!(first == second);
}

#[test]
fn completions_know_commands_and_options() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        assert_names(&stdout(&format!("completions {shell}")), &["snowblue", "spectrum", "grain-size", "list-scenes"]);
    }
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = Folder::new();
    folder.stdout("man -o man1");
    let pages = folder.path("man1");
    let page = |name: &str| std::fs::read_to_string(pages.join(name)).unwrap();
    assert_names(&page("snowblue-spectrum.1"), &[".TH snowblue-spectrum 1  \"snowblue ", "thickness", "Examples"]);
    assert_names(&page("snowblue-database-build.1"), &["preset"]);
    assert_eq!(page("snowblue.1"), stdout("man"));
    let help = stdout("--help");
    let commands =
        help.lines().skip_while(|line| !line.starts_with("Commands:")).skip(1).take_while(|line| !line.is_empty());
    let commands: Vec<&str> = commands.filter(|line| line.starts_with("  ") && !line.starts_with("   ")).collect();
    assert!(commands.len() > 12, "{help}");
    for name in commands.into_iter().filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help") {
        assert!(pages.join(format!("snowblue-{name}.1")).exists(), "{name}");
    }
}
