//! `snowblue figures`: files, printed tables and errors.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use snowblue_figures::RECIPES;

use shell::{assert_names, assert_refused, stdout};

#[test]
fn a_figure_has_a_drawing_numbers_tables_and_a_page() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("figures");
    let printed = stdout(&["figures", "-o", place.to_str().unwrap(), "--only", "s2"]);
    let read = |name: &str| std::fs::read_to_string(place.join(name)).unwrap();
    let mut names: Vec<String> =
        std::fs::read_dir(&place).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    assert_eq!(names, ["index.html", "s2.csv", "s2.svg", "s2_transmittance.csv"]);

    let numbers = read("s2.csv");
    assert!(numbers.starts_with("thickness_cm,wavelength_nm,reflectance,transmittance\n"));
    assert_eq!(numbers.lines().count(), 1 + 4 * 81);
    assert_names(&read("s2.svg"), &["<svg", "Wavelength (nm)", "curves ours"]);
    assert_names(
        &read("index.html"),
        &["s2.svg", "s2.csv", "s2_transmittance.csv", "All curves are ours", "<dt>The paper</dt>"],
    );
    // The printed table equals its file.
    let table = read("s2_transmittance.csv");
    let last: Vec<&str> = table.lines().last().unwrap().split(',').collect();
    assert!(printed.lines().any(|line| line.split_whitespace().eq(last.iter().copied())), "{printed}");
}

#[test]
fn unknown_figures_are_refused_before_anything_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("figures");
    let known = RECIPES.map(|recipe| recipe.name).join(", ");
    assert_refused(&["figures", "-o", place.to_str().unwrap(), "--only", "s2,fig99"], &["'fig99'", &known]);
    assert!(!place.exists());
}

#[test]
fn files_and_missing_folders_are_refused_as_output() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("figures");
    std::fs::write(&place, "").unwrap();
    assert_refused(&["figures", "-o", place.to_str().unwrap(), "--only", "s2"], &["figures"]);
    let deep = folder.path().join("new/figures");
    assert_refused(&["figures", "-o", deep.to_str().unwrap(), "--only", "s2"], &["new/figures", "folder"]);
    assert!(!folder.path().join("new").exists());
}
