//! `snowblue figures` writes what it says, and refuses what it does not know.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use shell::{refused, snowblue, stdout};

#[test]
fn a_figure_is_a_drawing_its_numbers_and_a_page() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("new/figures");
    let printed = stdout(&["figures", "-o", place.to_str().unwrap(), "--only", "s2"]);
    let read = |name: &str| std::fs::read_to_string(place.join(name)).unwrap();
    let mut names: Vec<String> =
        std::fs::read_dir(&place).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    assert_eq!(names, ["index.html", "s2.csv", "s2.svg", "s2_transmittance.csv"]);

    let numbers = read("s2.csv");
    assert!(numbers.starts_with("thickness_cm,wavelength_nm,reflectance,transmittance\n"));
    assert_eq!(numbers.lines().count(), 1 + 4 * 81);
    let drawing = read("s2.svg");
    assert!(drawing.starts_with("<svg") && drawing.contains("Wavelength (nm)") && drawing.contains("curves ours"));
    let page = read("index.html");
    for word in ["s2.svg", "s2.csv", "s2_transmittance.csv", "All curves are ours"] {
        assert!(page.contains(word), "{word}");
    }
    // What is printed is what the table's file holds.
    let table = read("s2_transmittance.csv");
    let last: Vec<&str> = table.lines().last().unwrap().split(',').collect();
    assert!(printed.lines().any(|line| line.split_whitespace().eq(last.iter().copied())), "{printed}");
}

#[test]
fn unknown_figures_are_refused_before_anything_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("figures");
    let message = refused(&["figures", "-o", place.to_str().unwrap(), "--only", "s2,fig9"]);
    assert!(message.contains("'fig9'") && message.contains("water, albedo, microct, s2, simplifications"), "{message}");
    assert!(!place.exists());
}

#[test]
fn a_file_is_no_folder() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("figures");
    std::fs::write(&place, "").unwrap();
    let output = snowblue(&["figures", "-o", place.to_str().unwrap(), "--only", "s2"]);
    assert_eq!(output.status.code(), Some(2));
}
