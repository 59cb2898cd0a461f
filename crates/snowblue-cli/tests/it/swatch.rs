//! `snowblue swatch`: pictures with the colours of `snowblue color`.

use crate::shell::{Folder, decoded, stdout};

fn last_column(csv: &str) -> Vec<String> {
    csv.lines().skip(1).map(|line| line.rsplit(',').next().unwrap().to_owned()).collect()
}

#[test]
fn swatches_have_the_colours_of_the_color_command() {
    let folder = Folder::new();
    let flat = "--exposure 0 --size 16 -o flat.png";
    folder.stdout(&format!("swatch --rows grain-size=200,500 --columns thickness=0,1,5 {flat}"));
    let (_, channels) = decoded(&folder.bytes("flat.png"));
    let hex = |rgb: &[u8]| format!("#{:02x}{:02x}{:02x}", rgb[0], rgb[1], rgb[2]);
    let pixels: Vec<String> = channels.chunks_exact(3).map(hex).collect();
    for size in ["200", "500"] {
        for hex in last_column(&stdout(&format!("color --grain-size {size} --thickness 1,5"))) {
            let count = pixels.iter().filter(|pixel| **pixel == hex).count();
            assert_eq!(count, 16 * 16, "{size} µm: {hex}");
        }
    }
}

#[test]
fn colours_are_written_with_the_varying_parameters() {
    let folder = Folder::new();
    let common = "--thickness 3 --facetness 0.5";
    let run = |samples: &str| {
        let axes = "--columns illuminant=E,FL3.15 --rows density=200,400 --size 16";
        folder.stdout(&format!("swatch {axes} {common} --colors a.csv -o a.png {samples}"));
        folder.text("a.csv")
    };
    let many = run("");
    let mut lines = many.lines();
    assert_eq!(
        lines.next().unwrap(),
        "density_kg_m3,thickness_cm,angle_deg,illuminant,X,Y,Z,L,a,b,r_linear,g_linear,b_linear,hex"
    );
    assert!(many.lines().nth(2).unwrap().starts_with("200,3,0,FL3.15,"), "{many}");
    let color = stdout(&format!("color --density 400 --illuminant E {common}"));
    let luminance = |line: &str, column: usize| line.split(',').nth(column).unwrap().parse::<f64>().unwrap();
    let (one, other) = (luminance(color.lines().nth(1).unwrap(), 4), luminance(many.lines().nth(3).unwrap(), 5));
    // The same grains, tallied once for both densities; sums in another order.
    assert!((one / other - 1.0).abs() < 1e-7, "{one} {other}");
    let few = run("--samples 3");
    assert!(last_column(&few).iter().zip(last_column(&many)).all(|(few, many)| *few != many), "{few}\n{many}");
    // Automatic exposure: the greatest channel of all is 0.9, code 243.
    assert!(last_column(&many).iter().any(|hex| hex.contains("f3")), "{many}");
}

#[test]
fn pictures_do_not_depend_on_the_number_of_threads() {
    let folder = Folder::new();
    let run = |name: &str, more: &str| {
        let axes = "--columns facetness=0.1,0.9 --rows angle=0,diffuse --size 16 --samples 3";
        folder.stdout(&format!("swatch {axes} -o {name} {more}"));
        folder.bytes(name)
    };
    let one = run("1.png", "--threads 1");
    assert!(one == run("3.png", "--threads 3"));
    assert!(one != run("back.png", "--reflected"));
}

/// Options that are given apply to all swatches, also those that take several words or have a form of their own.
#[test]
fn given_options_apply_to_all_swatches() {
    let folder = Folder::new();
    let snow = "--ssa 16 --facetness 0.1:0.5:0.3:0.2 --temperature -20 --impurity black-carbon=100,saharan-dust=500";
    folder.stdout(&format!("swatch --columns thickness=1,2.5 --size 16 --colors a.csv -o a.png {snow} --exposure 0"));
    let colours = stdout(&format!("color --thickness 1,2.5 {snow}"));
    assert_eq!(last_column(&folder.text("a.csv")), last_column(&colours));
}

#[test]
fn observers_see_different_colours() {
    let folder = Folder::new();
    let seen = ["1931", "1964"].map(|observer| {
        let files = "--colors a.csv -o a.png";
        folder.stdout(&format!("swatch --columns thickness=15 --size 16 --observer {observer} {files}"));
        let swatch = last_row(&folder.text("a.csv"));
        let color = last_row(&stdout(&format!("color --thickness 15 --observer {observer}")));
        assert_eq!(swatch[..5], color[..5]);
        swatch
    });
    assert_ne!(seen[0], seen[1]);
}

fn last_row(csv: &str) -> Vec<String> {
    csv.lines().last().unwrap().split(',').map(str::to_owned).collect()
}
