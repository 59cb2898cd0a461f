//! The table of `render --stats`.

use std::collections::BTreeMap;

use crate::shell::Folder;

const PHASES: [&str; 5] = ["meshes", "snow", "cells", "light", "samples"];

/// The first number after each name of a table, and the names in their order. Names that come twice keep the first.
fn values(table: &str) -> (Vec<String>, BTreeMap<String, f64>) {
    let rows: Vec<(String, f64)> = table
        .lines()
        .filter_map(|line| line.strip_prefix("    "))
        .map(|row| {
            let (name, rest) = row.split_once("   ").unwrap();
            let number = rest.split_whitespace().next().unwrap().replace(',', "");
            (name.to_owned(), number.parse().unwrap())
        })
        .collect();
    let names = rows.iter().map(|(name, _)| name.clone()).collect();
    (names, rows.into_iter().rev().collect())
}

#[test]
fn statistics_add_up_and_do_not_change_the_picture() {
    let folder = Folder::new();
    let render = |name: &str, more: &str| {
        let small = "--width 12 --height 10 --spp 3 --field-step-mm 50";
        let message = folder.stderr(&format!("render --scene block_30cm -o {name} {small} {more}"));
        (folder.bytes(name), message)
    };
    let ((plain, nothing), (picture, table)) = (render("a.exr", ""), render("b.exr", "--stats --quiet"));
    assert!(!nothing.contains("Statistics"));
    assert!(plain == picture);
    let (names, of) = values(&table);
    assert_eq!(names[..6], ["meshes", "snow", "cells", "light", "samples", "total"], "{table}");
    let phases: f64 = PHASES.iter().map(|phase| of[*phase]).sum();
    // Each time is rounded to 10 ms.
    assert!(phases <= of["total"] + 0.005 * 6.0, "{table}");
    assert_eq!(of["samples of pixels"], 12.0 * 10.0 * 3.0);
    assert_eq!(of["camera rays"], of["samples of pixels"]);
    assert!(of["walks into snow"] > 0.0 && of["walks into snow"] <= of["camera rays"], "{table}");
    assert!(of["walks that ended in the light field"] <= of["walks into snow"]);
    assert!(of["flights from grain to grain"] >= of["walks into snow"]);
    for name in [
        "objects",
        "bodies of snow",
        "cells of all bodies",
        "nodes of all bodies",
        "solves for a body and a group",
        "shadow rays",
    ] {
        assert!(of[name] >= 1.0, "{name}: {table}");
    }
    assert!(of["iterations"] >= of["solves for a body and a group"], "{table}");
    // A solution for each light of one spectrum, group of wavelengths and round; one body sees no other.
    let solutions = of["lights of one spectrum"] * of["groups of four wavelengths"];
    assert!(of["solves for a body and a group"] >= solutions, "{table}");
    assert!(!cfg!(target_os = "linux") || table.lines().nth(2).unwrap().ends_with(" MiB"), "{table}");
}

/// A picture without a light field has no such part, and no walks.
#[test]
fn statistics_of_curves_have_no_light_field() {
    let folder = Folder::new();
    let small = "--integrator pcasnow --width 8 --height 8 --spp 1";
    let table = folder.stderr(&format!("render --scene fig9_back {small} --stats -o a.png"));
    let (names, of) = values(&table);
    assert_eq!(names[..4], ["meshes", "snow", "samples", "total"], "{table}");
    assert!(!table.contains("Light field"), "{table}");
    assert_eq!((of["samples of pixels"], of["walks into snow"]), (64.0, 0.0));
}
