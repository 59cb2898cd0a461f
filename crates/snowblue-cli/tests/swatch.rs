//! `snowblue swatch`: pictures with the colours of `snowblue color`, and errors in one line.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use std::path::Path;

use shell::{assert_refused, decoded, stdout};

/// Width, and pixels as hex.
fn pixels(path: &Path) -> (usize, Vec<String>) {
    let (width, channels) = decoded(&std::fs::read(path).unwrap());
    let hex = |rgb: &[u8]| format!("#{:02x}{:02x}{:02x}", rgb[0], rgb[1], rgb[2]);
    (width, channels.chunks_exact(3).map(hex).collect())
}

fn last_column(csv: &str) -> Vec<String> {
    csv.lines().skip(1).map(|line| line.rsplit(',').next().unwrap().to_owned()).collect()
}

#[test]
fn swatches_have_the_colours_of_the_color_command() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("flat.png");
    let flat = ["--no-texture", "--exposure", "0", "--size", "40", "-o", picture.to_str().unwrap()];
    stdout(&[&["swatch", "--rows", "grain-size=200,500", "--columns", "thickness=0,1,5"][..], &flat].concat());
    let (_, pixels) = pixels(&picture);
    for size in ["200", "500"] {
        for hex in last_column(&stdout(&["color", "--grain-size", size, "--thickness", "1,5"])) {
            let count = pixels.iter().filter(|pixel| **pixel == hex).count();
            assert!(count >= 40 * 40, "{size} µm: {hex} on {count} pixels");
        }
    }
}

#[test]
fn colours_are_written_with_the_varying_parameters() {
    let folder = tempfile::tempdir().unwrap();
    let (picture, table) = (folder.path().join("a.png"), folder.path().join("a.csv"));
    let files = ["--colors", table.to_str().unwrap(), "-o", picture.to_str().unwrap()];
    let common = ["--thickness", "3", "--facetness", "0.5"];
    let axes = ["swatch", "--columns", "illuminant=E,FL3.15", "--rows", "density=200,400", "--size", "16"];
    let run = |samples: &[&str]| {
        stdout(&[&axes[..], &common, &files, samples].concat());
        std::fs::read_to_string(&table).unwrap()
    };
    let many = run(&[]);
    let mut lines = many.lines();
    assert_eq!(
        lines.next().unwrap(),
        "density_kg_m3,thickness_cm,angle_deg,illuminant,X,Y,Z,L,a,b,r_linear,g_linear,b_linear,hex"
    );
    assert!(many.lines().nth(2).unwrap().starts_with("200,3,0,FL3.15,"), "{many}");
    let color = stdout(&[&["color", "--density", "400", "--illuminant", "E"][..], &common].concat());
    let luminance = |line: &str, column: usize| line.split(',').nth(column).unwrap().parse::<f64>().unwrap();
    let (one, other) = (luminance(color.lines().nth(1).unwrap(), 4), luminance(many.lines().nth(3).unwrap(), 5));
    // The same grains, tallied once for both densities; sums in another order.
    assert!((one / other - 1.0).abs() < 1e-7, "{one} {other}");
    let few = run(&["--samples", "3"]);
    assert!(last_column(&few).iter().zip(last_column(&many)).all(|(few, many)| *few != many), "{few}\n{many}");
    // Automatic exposure: the greatest channel of all is 0.8, code 231.
    assert!(last_column(&many).iter().any(|hex| hex.contains("e7")), "{many}");
}

#[test]
fn pictures_do_not_depend_on_the_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, more: &[&str]| {
        let path = folder.path().join(name);
        let axes = ["swatch", "--columns", "facetness=0.1,0.9", "--rows", "angle=0,diffuse", "--size", "24"];
        stdout(&[&axes[..], &["-o", path.to_str().unwrap()], more].concat());
        std::fs::read(path).unwrap()
    };
    let one = run("1.png", &["--threads", "1"]);
    assert!(one == run("3.png", &["--threads", "3"]));
    assert!(one != run("flat.png", &["--no-texture"]) && one != run("back.png", &["--reflected"]));
    assert!(holds(&one, "Light through snow"), "the file holds the title");
}

fn holds(picture: &[u8], words: &str) -> bool {
    picture.windows(words.len()).any(|window| window == words.as_bytes())
}

/// The file holds the measure of grain size, and properties that are not in the title.
#[test]
fn a_sheet_describes_its_snow() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let axes = ["swatch", "--columns", "thickness=1e1,2.50", "--size", "16", "-o", path.to_str().unwrap()];
    stdout(&[&axes[..], &["--ssa", "16", "--facetness", "0.1:0.5:0.3:0.2", "--observer", "1964"]].concat());
    let picture = std::fs::read(path).unwrap();
    for words in ["optical diameter 408.6 ", "optical diameter 408.629603 ", "sphericity 0.7", "-5 ", "CIE 1964 10"] {
        assert!(holds(&picture, words), "{words}");
    }
}

#[test]
fn observers_see_different_colours() {
    let folder = tempfile::tempdir().unwrap();
    let (picture, table) = (folder.path().join("a.png"), folder.path().join("a.csv"));
    let files = ["--colors", table.to_str().unwrap(), "-o", picture.to_str().unwrap()];
    let seen = ["1931", "1964"].map(|observer| {
        let sheet = ["swatch", "--columns", "thickness=15", "--size", "16", "--observer", observer];
        stdout(&[&sheet[..], &files].concat());
        let swatch = last_row(&std::fs::read_to_string(&table).unwrap());
        let color = last_row(&stdout(&["color", "--thickness", "15", "--observer", observer]));
        assert_eq!(swatch[..5], color[..5]);
        swatch
    });
    assert_ne!(seen[0], seen[1]);
}

fn last_row(csv: &str) -> Vec<String> {
    csv.lines().last().unwrap().split(',').map(str::to_owned).collect()
}

#[test]
fn impossible_sheets_are_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("never.png");
    for (more, words) in [
        (&["--rows", "angle=0,60", "--columns", "angle=1"][..], &["angle", "--rows", "--columns"][..]),
        (&["--columns", "density=200,1200"], &["density", "1200 kg/m³", "10–900 kg/m³"]),
        (&["--columns", "angle=0,95"], &["angle", "95°"]),
        (&["--columns", "grain-size=60"], &["grain size", "70–4950 µm"]),
        (&["--columns", "depth=1"], &["'depth'", "grain-size", "facetness", "density"]),
        (&["--columns", "density=200,400", "--density", "300"], &["density", "--columns", "--density"]),
        (&["--rows", "grain-size=200", "--ssa", "20"], &["grain-size", "--rows", "--ssa"]),
        (&["--columns", "angle=0,60", "--thickness", "1,5"], &["--thickness", "2"]),
        (&["--columns", "illuminant=E,A", "--false-color"], &["--columns", "illuminant", "--false-color"]),
        (&["--columns", "thickness=1,inf"], &["thickness is inf cm", "--reflected"]),
        (&["--columns", "angle=0", "--exposure", "inf"], &["exposure", "inf stops"]),
        (&["--columns", "angle=0,1,2,3,4,5,6,7,8", "--size", "2048"], &["18432", "16384"]),
        (&["--columns", "angle=0", "--colors", "colours.txt"], &["colours.txt", ".csv"]),
        (&["--columns", "thickness=1,5,1"], &["1 cm", "twice"]),
        (&["--density", "300"], &["--columns"]),
    ] {
        assert_refused(&[&["swatch", "-o", path.to_str().unwrap()][..], more].concat(), words);
    }
    assert!(!path.exists());
}
