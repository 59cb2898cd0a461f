//! `snowblue figures`: files and printed tables.

use crate::shell::{Folder, assert_names};

#[test]
fn a_figure_has_a_drawing_numbers_tables_and_a_page() {
    let folder = Folder::new();
    let printed = folder.stdout("figures -o figures --only s2");
    let place = folder.path("figures");
    let read = |name: &str| std::fs::read_to_string(place.join(name)).unwrap();
    let mut names: Vec<String> =
        std::fs::read_dir(&place).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    assert_eq!(names, ["index.html", "s2.csv", "s2.svg", "s2_table.csv"]);

    let numbers = read("s2.csv");
    assert!(numbers.starts_with("thickness_cm,wavelength_nm,reflectance,transmittance\n"));
    assert_eq!(numbers.lines().count(), 1 + 4 * 81);
    assert_names(&read("s2.svg"), &["<svg", "Wavelength (nm)", "engine discrete ordinates"]);
    assert_names(&read("index.html"), &["s2.svg", "s2.csv", "s2_table.csv", "All curves are ours", "<b>The paper</b>"]);
    // The printed table equals its file.
    let table = read("s2_table.csv");
    let last: Vec<&str> = table.lines().last().unwrap().split(',').collect();
    assert!(printed.lines().any(|line| line.split_whitespace().eq(last.iter().copied())), "{printed}");
}

#[test]
fn a_missing_mesh_is_reported() {
    let folder = Folder::new();
    assert_names(&folder.stderr("figures -o . --only fig11"), &["fig11", "models/dragon.ply"]);
    assert_names(&folder.text("index.html"), &["Not rendered", "models/dragon.ply", "scripts/fetch-models"]);
}
