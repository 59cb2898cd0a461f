//! `snowblue spectrum --broadband`.

use crate::shell::{Folder, assert_names, stdout};

const HEADER: &str = "thickness_cm,angle_deg,band,reflectance,transmittance,absorptance";

/// Rows of a CSV that must begin with `header`.
fn rows(text: &str, header: &str) -> Vec<Vec<String>> {
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(header));
    lines.map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn number(row: &[String], column: usize) -> f64 {
    row[column].parse().unwrap()
}

/// Also by random walks.
#[test]
fn bands_have_a_row_for_each_thickness_and_angle() {
    let solved = rows(&stdout("spectrum --broadband --thickness 1,15 --angle 0,diffuse --streams 8"), HEADER);
    assert_eq!(solved.len(), 16);
    let names: Vec<&str> = solved[..4].iter().map(|row| row[2].as_str()).collect();
    assert_eq!(names, ["solar-320-2500", "visible-400-700", "near-infrared-700-2500", "par-400-700"]);
    assert_eq!((solved[4][0].as_str(), solved[4][1].as_str(), solved[8][0].as_str()), ("1", "diffuse", "15"));
    for row in &solved {
        let sum: f64 = (3..6).map(|column| number(row, column)).sum();
        // Nine significant digits each.
        assert!((sum - 1.0).abs() < 2e-8, "{row:?}");
    }
    let [solar, visible, infrared] = [8, 9, 10].map(|row| number(&solved[row], 3));
    assert!(infrared < 0.6 && (0.75..0.8).contains(&solar) && visible > 0.96, "{solar} {visible} {infrared}");

    let header = format!("{HEADER},reflectance_se,transmittance_se,absorptance_se");
    let walks = "spectrum --broadband near-infrared,par --thickness 1 --engine montecarlo --rays 2000";
    let sampled = rows(&stdout(walks), &header);
    assert_eq!(sampled.len(), 2);
    for (sampled, solved) in sampled.iter().zip(&solved[2..4]) {
        for quantity in 3..6 {
            let gap = (number(sampled, quantity) - number(solved, quantity)).abs();
            assert!(gap < 4.0 * number(sampled, quantity + 3), "{sampled:?} {solved:?}");
        }
    }
}

#[test]
fn layers_have_the_bands_of_a_slab() {
    let folder = Folder::new();
    folder.write("pack.toml", "ice = \"picard2016\"\n[[layer]]\nthickness_cm = 0.5\n[[layer]]\nthickness_cm = 0.5\n");
    let layered = "spectrum --layers pack.toml --plot pack.svg --broadband --streams 4";
    let layered = rows(&folder.stdout(layered), HEADER);
    assert_eq!((layered.len(), layered[0][2].as_str()), (4, "solar-320-2500"));
    let slab = rows(&stdout("spectrum --thickness 1 --broadband visible,par"), HEADER);
    for (layered, slab) in [(&layered[1], &slab[0]), (&layered[3], &slab[1])] {
        assert_eq!(layered[2], slab[2]);
        assert!((number(layered, 3) - number(slab, 3)).abs() < 2e-3, "{layered:?} {slab:?}");
    }
    assert_names(&folder.text("pack.svg"), &["ASTM G173-03"]);
}

/// Each line of a file and each value of an option has the bands that it has alone. Kinds of snow whose tables reach
/// differently far have no solar band in common.
#[test]
fn files_and_options_with_several_values_have_bands() {
    let folder = Folder::new();
    folder.write("pits.csv", "ssa_m2_kg\n10\n40\n");
    let common = "--thickness 5 --broadband visible,par";
    let alone = |area: &str| rows(&stdout(&format!("spectrum --ssa {area} {common}")), HEADER);
    let alone = [alone("10"), alone("40")].concat();
    for slabs in ["--ssa 10,40", "--batch pits.csv"] {
        let all = rows(&folder.stdout(&format!("spectrum {slabs} {common}")), &format!("ssa_m2_kg,{HEADER}"));
        assert_eq!(all.len(), 4);
        for (row, alone) in all.iter().zip(&alone) {
            assert_eq!(&row[1..], alone, "{slabs}");
        }
    }
}

#[test]
fn metadata_name_the_solar_spectrum() {
    let text = stdout("spectrum --broadband par --format json --wavelengths 400:700:50");
    assert_names(&text, &["ASTM G173-03", "37°", "1977.87 µmol m⁻² s⁻¹"]);
}
