//! `snowblue spectrum` with many slabs: files of slabs, options with several values, and NetCDF.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use std::path::Path;

use netcdf3::FileReader;
use shell::{assert_refused, stdout};

const PITS: &str = "\
name,ssa_m2_kg,density_kg_m3,black_carbon_ng_g,thickness_cm,ground_albedo
\"upper ridge\",60,120,0,2,0.1

valley,25,300,5,15,
glacier,3,,400,40,0
";

/// Lines of a CSV after its header.
fn lines(arguments: &[&str], header: &str) -> Vec<String> {
    let text = stdout(arguments);
    let mut lines = text.lines().map(str::to_owned);
    assert_eq!(lines.next().as_deref(), Some(header));
    lines.collect()
}

fn file(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn a_line_of_a_file_has_the_figures_of_its_options() {
    let folder = tempfile::tempdir().unwrap();
    let pits = file(folder.path(), "pits.csv", PITS);
    let common = ["--angle", "60", "--wavelengths", "450,1000"];
    let header = "name,ssa_m2_kg,density_kg_m3,black_carbon_ng_g,thickness_cm,ground_albedo,angle_deg,wavelength_nm,\
                  reflectance,transmittance,absorptance";
    let batch = lines(&[&["spectrum", "--batch", &pits][..], &common].concat(), header);
    assert_eq!(batch.len(), 6);
    let alone: [&[&str]; 3] = [
        &["--ssa", "60", "--density", "120", "--thickness", "2", "--ground-albedo", "0.1"],
        &["--ssa", "25", "--density", "300", "--thickness", "15", "--impurity", "black-carbon=5"],
        &["--ssa", "3", "--thickness", "40", "--impurity", "black-carbon=400"],
    ];
    let names = ["upper ridge,60,120,0,2,0.1,60,", "valley,25,300,5,15,,60,", "glacier,3,,400,40,0,60,"];
    for ((slab, options), name) in batch.chunks(2).zip(alone).zip(names) {
        let header = "thickness_cm,angle_deg,wavelength_nm,reflectance,transmittance,absorptance";
        let own = lines(&[&["spectrum"][..], options, &common].concat(), header);
        for (line, own) in slab.iter().zip(&own) {
            let figures = |line: &str| line.rsplitn(5, ',').take(4).map(str::to_owned).collect::<Vec<_>>();
            assert!(line.starts_with(name), "{line}");
            assert_eq!(figures(line), figures(own));
        }
    }
}

#[test]
fn options_with_several_values_combine() {
    let header = "ssa_m2_kg,density_kg_m3,black_carbon_ng_g,thickness_cm,angle_deg,wavelength_nm,reflectance,\
                  transmittance,absorptance";
    let common = ["--thickness", "3,6", "--wavelengths", "500"];
    let several = ["spectrum", "--ssa", "10,40", "--density", "200,300", "--impurity", "black-carbon=0:50"];
    let all = lines(&[&several[..], &common].concat(), header);
    assert_eq!(all.len(), 16);
    assert!(all[0].starts_with("10,200,0,3,0,500,") && all[15].starts_with("40,300,50,6,0,500,"), "{all:?}");
    let one = ["spectrum", "--ssa", "40", "--density", "200", "--impurity", "black-carbon=50"];
    let own = "thickness_cm,angle_deg,wavelength_nm,reflectance,transmittance,absorptance";
    for (line, own) in all[10..12].iter().zip(lines(&[&one[..], &common].concat(), own)) {
        assert_eq!(line, &format!("40,200,50,{own}"));
    }
    assert_refused(&["color", "--ssa", "10,40"], &["--ssa has several values", "spectrum"]);
    assert_refused(&[&several[..], &["--spread"]].concat(), &["--spread", "single snow"]);
}

/// Spheres of a radius r have the area 3/(ρ r): 3/(917.7 · 10⁻⁴) = 32.69 m²/kg at 100 µm.
#[test]
fn an_optical_radius_is_a_surface_area() {
    let header = "thickness_cm,angle_deg,wavelength_nm,reflectance,transmittance,absorptance";
    let of =
        |size: &[&str]| lines(&[&["spectrum", "--wavelengths", "1000", "--thickness", "2"], size].concat(), header);
    let number = |lines: Vec<String>| lines[0].split(',').nth(3).unwrap().parse::<f64>().unwrap();
    let area = (3.0 / (917.7015 * 1e-4)).to_string();
    let (radius, area) = (number(of(&["--optical-radius", "100"])), number(of(&["--ssa", &area])));
    // Nine digits are printed.
    assert!((radius - area).abs() < 2e-9, "{radius} {area}");
    assert_refused(&["spectrum", "--optical-radius", "100", "--ssa", "20"], &["--optical-radius", "--ssa"]);
    assert_refused(&["spectrum", "--optical-radius", "1"], &["grain size is 2", "20–5000 µm"]);
}

#[test]
fn nothing_is_computed_or_written_if_a_line_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("pits.nc").to_str().unwrap().to_owned();
    let wrong = |text: &str, words: &[&str]| {
        let pits = file(folder.path(), "pits.csv", text);
        let place = [&["pits.csv:"][..], words].concat();
        assert_refused(&["spectrum", "--batch", &pits, "-o", &output], &place);
        assert!(!Path::new(&output).exists());
    };
    let with_last = |line: &str| format!("{PITS}{line}\n");
    wrong(&with_last("steep,25,1200,0,1,0"), &[":6: density is 1200 kg/m³, but must lie in 10–900 kg/m³"]);
    wrong(&with_last("deep,25,300,0,-1,0"), &[":6: thickness is -1 cm"]);
    wrong(&with_last("bright,25,300,0,1,2"), &[":6: ground albedo is 2"]);
    wrong(&with_last("fine,400,300,0,1,0"), &[":6: specific surface area is 400 m²/kg"]);
    wrong(&with_last("word,many,300,0,1,0"), &[":6: ssa_m2_kg: 'many' is not a number"]);
    wrong(&with_last("short,25"), &[":6: has 2 cells, but there are 6 columns"]);
    wrong("name,ssa\na,20\n", &[":1: column 'ssa' is not known; there are name", "ssa_m2_kg"]);
    wrong("name,snow,name\n", &[":1: column name is there twice"]);
    wrong("name,snow\n", &[" has no slab"]);
    wrong("", &[" has no line of names"]);
    wrong("ssa_m2_kg,grain_size_um\n20,300\n", &[":2: specific surface area cannot be given with a grain size"]);
    let pits = file(folder.path(), "pits.csv", PITS);
    assert_refused(&["spectrum", "--batch", &pits, "--density", "200"], &[":1: column density_kg_m3 and --density"]);
    assert_refused(&["spectrum", "--batch", &pits, "--angle", "0,60"], &["--angle has several values", "column"]);
    assert_refused(&["spectrum", "--batch", &pits, "--ssa", "10,20"], &["several values", "--batch"]);
    assert_refused(&["spectrum", "--batch", "missing.csv"], &["missing.csv"]);
}

#[test]
fn spectra_are_written_as_netcdf_with_dimensions() {
    let folder = tempfile::tempdir().unwrap();
    let (pits, output) = (file(folder.path(), "pits.csv", PITS), folder.path().join("pits.nc"));
    let written = output.to_str().unwrap();
    stdout(&["spectrum", "--batch", &pits, "--wavelengths", "450,1000", "-o", written]);
    let mut read = FileReader::open(&output).unwrap();
    let data = read.data_set();
    let dims = |name: &str| data.get_var(name).unwrap().dim_names();
    assert_eq!(
        (dims("reflectance"), dims("thickness")),
        (vec!["slab".into(), "wavelength".into()], vec!["slab".to_owned()])
    );
    assert_eq!(data.get_var_attr_as_string("specific_surface_area", "units").as_deref(), Some("m2 kg-1"));
    assert_eq!(data.get_var_attr_as_string("black_carbon", "units").as_deref(), Some("ng g-1"));
    let density = read.read_var_f64("density").unwrap();
    assert!(density[..2] == [120.0, 300.0] && density[2].is_nan(), "{density:?}");
    assert_eq!(read.read_var_u8("name").unwrap()[..11], *b"upper ridge");
    let printed = stdout(&["spectrum", "--batch", &pits, "--wavelengths", "450,1000"]);
    let reflectance = read.read_var_f64("reflectance").unwrap();
    for (line, value) in printed.lines().skip(1).zip(&reflectance) {
        let printed: f64 = line.split(',').nth(8).unwrap().parse().unwrap();
        assert!((printed - value).abs() < 1e-8, "{line} {value}");
    }
    // All combinations of axes are axes.
    let grid = folder.path().join("grid.nc");
    let axes = ["--ssa", "10,40", "--thickness", "1,2,5", "--angle", "0,diffuse", "--wavelengths", "450,550,650,750"];
    stdout(&[&["spectrum", "-o", grid.to_str().unwrap()][..], &axes].concat());
    let mut read = FileReader::open(&grid).unwrap();
    let dims = read.data_set().get_var("transmittance").unwrap().dim_names();
    assert_eq!(dims, ["specific_surface_area", "thickness", "angle", "wavelength"]);
    assert_eq!(read.read_var_f64("angle").unwrap(), [0.0, -1.0]);
    assert_eq!(read.data_set().get_global_attr_as_string("ice").as_deref(), Some("warren2008"));
    assert_refused(&["spectrum", "--broadband", "-o", grid.to_str().unwrap()], &["grid.nc", "NetCDF needs spectra"]);
}
