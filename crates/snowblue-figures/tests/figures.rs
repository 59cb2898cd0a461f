//! Drawings, numbers and links of the figures.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeMap;

use snowblue_figures::{Figure, FigureError, FigureFile, Recipe, page, recipes};

/// Text files by name, with `index.html`.
fn files(names: &[&str]) -> BTreeMap<String, String> {
    let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
    let made: Vec<(&Recipe, Figure)> =
        recipes(&names).unwrap().into_iter().map(|recipe| (recipe, recipe.make().unwrap())).collect();
    let mut files = BTreeMap::from([("index.html".to_owned(), page(&made))]);
    for FigureFile { name, bytes } in made.iter().flat_map(|(recipe, figure)| figure.files(recipe.name)) {
        files.insert(name, String::from_utf8(bytes).unwrap());
    }
    files
}

/// The words of a drawing, which must be well-formed XML with finite numbers.
fn words(drawing: &str) -> Vec<String> {
    let document = roxmltree::Document::parse(drawing).unwrap();
    assert_eq!(document.root_element().tag_name().name(), "svg");
    for attribute in document.descendants().flat_map(|node| node.attributes()) {
        assert!(!["NaN", "inf"].iter().any(|word| attribute.value().contains(word)), "{attribute:?}");
    }
    document.descendants().filter_map(|node| node.text()).map(|text| text.trim().to_owned()).collect()
}

#[test]
fn unknown_figures_are_refused() {
    let error = recipes(&["s2".to_owned(), "fig99".to_owned()]).unwrap_err();
    assert!(matches!(error, FigureError::UnknownFigure { ref name, .. } if name == "fig99"), "{error}");
}

/// Table 1 and Fig. S2: values, words and links.
#[test]
fn pages_link_to_all_files_of_their_figures() {
    let files = files(&["table1", "s2"]);
    // Every value of Table 1 is in ours: 9 + 5 + 5 + 11 + 10 + 31.
    assert_eq!(files["table1.csv"].lines().filter(|line| line.ends_with(",yes")).count(), 71);
    assert!(files["table1_table.csv"].lines().any(|line| line.starts_with("curves,24750,")));
    assert!(words(&files["s2.svg"]).iter().any(|word| word == "Thickness"));
    assert!(files.keys().all(|name| name == "index.html" || files["index.html"].contains(name)));

    let page = &files["index.html"];
    let links = ["href=\"", "src=\""].into_iter().flat_map(|mark| page.split(mark).skip(1));
    for link in links.filter_map(|rest| rest.split('"').next()) {
        match link.strip_prefix('#') {
            Some(section) => assert!(page.contains(&format!("id=\"{section}\"")), "{link}"),
            None => assert!(link.starts_with("https://doi.org/") || files.contains_key(link), "{link}"),
        }
    }
}

/// The 225 curves and the choice of l' use one table. Two linear components give negative values; logarithms cannot.
#[test]
fn the_papers_curves_are_reconstructed() {
    let files = files(&["s1", "lprime"]);
    let row = |line: &str| -> Vec<f64> { line.split(',').filter_map(|cell| cell.parse().ok()).collect() };

    let drawing = &files["s1.svg"];
    assert!(words(drawing).iter().any(|word| word == "Grain size"));
    assert!(drawing.len() < 300_000, "{}", drawing.len());
    let curves: Vec<Vec<f64>> = files["s1.csv"].lines().skip(1).map(row).collect();
    assert_eq!(curves.len(), 225 * 31);
    assert!(curves.iter().all(|one| one.len() == 7 && one[4] > 0.0 && one[6] > 0.0));
    // Six components of the logarithms keep the paper's table within 0.5 %.
    assert!(curves.iter().all(|one| (one[6] / one[4] - 1.0).abs() < 0.005));

    words(&files["lprime.svg"]);
    let costs: Vec<Vec<f64>> = files["lprime.csv"].lines().skip(1).map(row).collect();
    assert_eq!(costs.len(), 2 * 8);
    let (linear, log) = costs.split_at(8);
    let (worst_delta_e, negative) = (1, 8);
    for space in [linear, log] {
        assert!(space[7][worst_delta_e] < 0.01 * space[0][worst_delta_e]);
    }
    assert!(linear[1][negative] > 0.0 && log.iter().all(|one| one[negative].abs() < 0.5));
}

#[test]
fn swatches_of_the_paper_are_drawn_with_their_numbers() {
    let files = files(&["fig3", "fig5-8"]);
    for (drawing, swatches) in [("fig3.svg", 10), ("fig5-8.svg", 48)] {
        let drawing = &files[drawing];
        assert!(words(drawing).iter().any(|word| word.contains("exposure +")), "{drawing}");
        // Another rectangle is the background.
        assert_eq!(drawing.matches("<rect").count(), 1 + swatches);
    }
    assert_eq!(files["fig5-8.csv"].lines().count(), 1 + 48);
    // Five illuminants every 5 nm, and the curves of 31 and of 3 wavelengths.
    assert_eq!(files["fig3.csv"].lines().count(), 1 + 5 * 61 + 31 + 3);
    for lamp in files["fig3_table.csv"].lines().skip(1) {
        let difference: f64 = lamp.split(',').nth(7).unwrap().parse().unwrap();
        assert!(difference > 2.3, "3 samples differ visibly from 31 (the paper's Fig. 3): {lamp}");
    }
    // Each row of six angles becomes darker (the paper's Figs. 5–8).
    let colours = &files["fig5-8.csv"];
    let luminances: Vec<f64> =
        colours.lines().skip(1).map(|line| line.split(',').nth(5).unwrap().parse().unwrap()).collect();
    assert!(luminances.chunks_exact(6).all(|row| row.is_sorted_by(|steep, oblique| steep > oblique)), "{colours}");
}
