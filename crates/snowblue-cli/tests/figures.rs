//! `snowblue figures` writes what it says, and refuses what it does not know.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use std::path::Path;

use shell::{refused, snowblue, stdout};

/// Makes some figures in a new folder below `within`, and returns it with what was printed.
fn make(within: &Path, names: &str) -> (std::path::PathBuf, String) {
    let place = within.join("figures");
    let printed = stdout(&["figures", "-o", place.to_str().unwrap(), "--only", names]);
    (place, printed)
}

/// The words of a drawing, which is well-formed XML of finite places.
fn words(drawing: &str) -> Vec<String> {
    let document = roxmltree::Document::parse(drawing).unwrap();
    assert_eq!(document.root_element().tag_name().name(), "svg");
    for attribute in document.descendants().flat_map(|node| node.attributes()) {
        assert!(!["NaN", "inf"].iter().any(|word| attribute.value().contains(word)), "{attribute:?}");
    }
    document.descendants().filter_map(|node| node.text()).map(|text| text.trim().to_owned()).collect()
}

#[test]
fn a_figure_is_a_drawing_its_numbers_and_a_page() {
    let folder = tempfile::tempdir().unwrap();
    let (place, printed) = make(folder.path(), "s2");
    let read = |name: &str| std::fs::read_to_string(place.join(name)).unwrap();
    let mut names: Vec<String> =
        std::fs::read_dir(&place).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    assert_eq!(names, ["index.html", "s2.csv", "s2.svg", "s2_transmittance.csv"]);

    let numbers = read("s2.csv");
    assert!(numbers.starts_with("thickness_cm,wavelength_nm,reflectance,transmittance\n"));
    assert_eq!(numbers.lines().count(), 1 + 4 * 81);
    let words = words(&read("s2.svg"));
    assert!(
        words.iter().any(|word| word == "Wavelength (nm)") && words.iter().any(|word| word.contains("curves ours"))
    );
    let page = read("index.html");
    for word in ["s2.svg", "s2.csv", "s2_transmittance.csv", "All curves are ours", "<dt>The paper</dt>"] {
        assert!(page.contains(word), "{word}");
    }
    // What is printed is what the table's file holds.
    let table = read("s2_transmittance.csv");
    let last: Vec<&str> = table.lines().last().unwrap().split(',').collect();
    assert!(printed.lines().any(|line| line.split_whitespace().eq(last.iter().copied())), "{printed}");
}

/// Table 1 and both diagrams: words, rows, and links that lead somewhere.
#[test]
fn the_papers_table_and_sketches_are_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let (place, _) = make(folder.path(), "table1,fig2,fig4");
    let read = |name: &str| std::fs::read_to_string(place.join(name)).unwrap();
    for (name, word) in [("table1", "Thickness"), ("fig2", "light in ice"), ("fig4", "brightest")] {
        assert!(words(&read(&format!("{name}.svg"))).iter().any(|one| one == word), "{name}: {word}");
    }
    // Every value of Table 1 is in ours: 9 + 5 + 5 + 11 + 10 + 31.
    let values = read("table1.csv");
    assert_eq!(values.lines().filter(|line| line.ends_with(",yes,yes")).count(), 71);
    assert_eq!(values.lines().filter(|line| line.contains(",yes,no")).count(), 0);
    assert!(read("table1_values.csv").lines().any(|line| line.starts_with("Curves,24750,")));
    let ways = read("fig2.csv");
    assert!(ways.contains(",ice\n") && ways.lines().last().unwrap().starts_with("3,"));
    // The brightest path is as bright as the brighter of the normal one and that towards the light.
    let paths = read("fig4.csv");
    let brightness = |name: &str| -> f64 {
        paths.lines().find(|line| line.starts_with(name)).unwrap().rsplit(',').next().unwrap().parse().unwrap()
    };
    let brighter = brightness("normal,").max(brightness("light,"));
    assert!(brighter > 0.0 && (brightness("brightest,") / brighter - 1.0).abs() < 1e-9, "{paths}");

    let page = read("index.html");
    let links = ["href=\"", "src=\""].into_iter().flat_map(|mark| page.split(mark).skip(1));
    for link in links.filter_map(|rest| rest.split('"').next()) {
        match link.strip_prefix('#') {
            Some(section) => assert!(page.contains(&format!("id=\"{section}\"")), "{link}"),
            None => assert!(link.starts_with("https://doi.org/") || place.join(link).is_file(), "{link}"),
        }
    }
}

/// The 225 curves and the choice of l' come from one table, whose two linear components turn values negative, while
/// logarithms cannot.
#[test]
fn the_papers_curves_are_rebuilt() {
    let folder = tempfile::tempdir().unwrap();
    let (place, _) = make(folder.path(), "s1,lprime");
    let read = |name: &str| std::fs::read_to_string(place.join(name)).unwrap();
    let row = |line: &str| -> Vec<f64> { line.split(',').filter_map(|cell| cell.parse().ok()).collect() };

    let drawing = read("s1.svg");
    assert!(words(&drawing).iter().any(|word| word == "Grain size"));
    assert!(drawing.len() < 300_000, "{}", drawing.len());
    let curves: Vec<Vec<f64>> = read("s1.csv").lines().skip(1).map(row).collect();
    assert_eq!(curves.len(), 225 * 31);
    assert!(curves.iter().all(|one| one.len() == 7 && one[4] > 0.0 && one[6] > 0.0));
    // Six components of the logarithms keep the paper's table within .5 %, as they keep the embedded one.
    assert!(curves.iter().all(|one| (one[6] / one[4] - 1.0).abs() < 0.005));

    words(&read("lprime.svg"));
    let costs: Vec<Vec<f64>> = read("lprime.csv").lines().skip(1).map(row).collect();
    assert_eq!(costs.len(), 2 * 8);
    let (linear, log) = costs.split_at(8);
    let (worst_delta_e, negative) = (4, 8);
    for space in [linear, log] {
        assert!(space[7][worst_delta_e] < 0.01 * space[0][worst_delta_e]);
    }
    assert!(linear[1][negative] > 0.0 && log.iter().all(|one| one[negative].abs() < 0.5));
}

#[test]
fn unknown_figures_are_refused_before_anything_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("figures");
    let message = refused(&["figures", "-o", place.to_str().unwrap(), "--only", "s2,fig99"]);
    assert!(message.contains("'fig99'"), "{message}");
    assert!(
        message.contains("table1, fig1, fig2, fig3, fig4, fig5-8, fig9, fig10, fig11, s1, lprime, s2, simplifications, water, albedo, microct, truth"),
        "{message}"
    );
    assert!(!place.exists());
}

#[test]
fn a_file_is_no_folder() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("figures");
    std::fs::write(&place, "").unwrap();
    let output = snowblue(&["figures", "-o", place.to_str().unwrap(), "--only", "s2"]);
    assert_eq!(output.status.code(), Some(2));
    let deep = folder.path().join("new/figures");
    let message = refused(&["figures", "-o", deep.to_str().unwrap(), "--only", "s2"]);
    assert!(message.contains("its folder does not exist") && !folder.path().join("new").exists(), "{message}");
}

#[test]
fn swatches_of_the_paper_are_drawn_and_told() {
    let folder = tempfile::tempdir().unwrap();
    stdout(&["figures", "-o", folder.path().to_str().unwrap(), "--only", "fig3,fig5-8"]);
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    for (name, table, swatches) in [("fig3", "fig3_swatches", 10), ("fig5-8", "fig5-8", 48)] {
        assert_eq!(read(&format!("{name}.svg")).matches("data:image/png;base64,").count(), swatches);
        assert_eq!(read(&format!("{table}.csv")).lines().count(), 1 + swatches);
    }
    // Five lamps every 5 nm, and the curve of 31 and of 3 wavelengths.
    assert_eq!(read("fig3.csv").lines().count(), 1 + 5 * 61 + 31 + 3);
    let differences = read("fig3_samples.csv");
    for lamp in differences.lines().skip(1) {
        let difference: f64 = lamp.split(',').nth(10).unwrap().parse().unwrap();
        assert!(difference > 2.3, "3 samples differ visibly from 31 (the paper's Fig. 3): {lamp}");
    }
    // Each row of six angles darkens (the paper's Figs. 5–8).
    let colours = read("fig5-8.csv");
    let luminances: Vec<f64> =
        colours.lines().skip(1).map(|line| line.split(',').nth(5).unwrap().parse().unwrap()).collect();
    assert!(luminances.chunks_exact(6).all(|row| row.is_sorted_by(|steep, slanting| steep > slanting)), "{colours}");
}
