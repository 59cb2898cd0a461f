//! `snowblue spectrum` with many slabs: files of slabs, options with several values, and NetCDF.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use std::path::Path;

use netcdf3::FileReader;
use shell::{assert_refused, snowblue, stdout};

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
    let names = ["upper ridge,60,120,0,2,0.1,60,", "valley,25,300,5,15,0,60,", "glacier,3,300,400,40,0,60,"];
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
    wrong("# pits\nname;ssa_m2_kg\na;20\n", &[":2: column 'name;ssa_m2_kg' is not known: columns", "has semicolons"]);
    wrong("name\tssa_m2_kg\n", &[":1: ", "columns are separated by commas", "has tabs"]);
    wrong("ssa_m2_kg\n20;5\n", &[":2: ssa_m2_kg: '20;5' is not a number: columns are separated by commas"]);
    let decimals = "decimals have a point, but this line has more commas";
    wrong("ssa_m2_kg,thickness_cm\n20,5,3\n", &[":2: has 3 cells, but there are 2 columns", decimals]);
    wrong("name,snow,name\n", &[":1: column name is given twice"]);
    wrong("name,snow\n", &[" has no slab"]);
    wrong("", &[" has no line of names"]);
    wrong("ssa_m2_kg,grain_size_um\n20,300\n", &[":2: ssa_m2_kg cannot be given with grain_size_um"]);
    let pits = file(folder.path(), "pits.csv", PITS);
    assert_refused(&["spectrum", "--batch", &pits, "--wavelengths", "5000"], &["snowblue: wavelength is 5000 nm"]);
    assert_refused(&["spectrum", "--batch", &pits, "--temperature=-70"], &["snowblue: temperature is -70"]);
    assert_refused(&["spectrum", "--batch", &pits, "--angle", "0,60"], &["--angle has several values", "column"]);
    assert_refused(&["spectrum", "--batch", &pits, "--ssa", "10,20"], &["several values", "--batch"]);
    assert_refused(&["spectrum", "--batch", "missing.csv"], &["missing.csv"]);
}

fn data_attr(read: &FileReader, variable: &str, name: &str) -> String {
    read.data_set().get_var_attr_as_string(variable, name).unwrap()
}

#[test]
fn comments_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let rows =
        |text: &str| stdout(&["spectrum", "--batch", &file(folder.path(), "pits.csv", text), "--wavelengths", "500"]);
    let plain = rows("ssa_m2_kg,thickness_cm\n20,5\n30,7\n");
    assert_eq!(rows("# pits\n\n  # of May\nssa_m2_kg,thickness_cm\n20,5\n# later\n30,7\n"), plain);
    // A name may begin as a comment does.
    let named = rows("# pits\nname,ssa_m2_kg,thickness_cm\n#1,20,5\n#2,30,7\n");
    assert!(named.contains("#1,20,5,") && named.contains("#2,30,7,"), "{named}");
}

/// An empty cell has the option's value, in the figures and in the row.
#[test]
fn options_count_where_cells_are_empty() {
    let folder = tempfile::tempdir().unwrap();
    let text = "density_kg_m3,black_carbon_ng_g,angle_deg,thickness_cm\n,,,\n400,90,60,4\n";
    let pits = file(folder.path(), "pits.csv", text);
    let slab = ["--density", "150", "--angle", "diffuse", "--thickness", "3", "--wavelengths", "500"];
    let options = [&slab[..], &["--impurity", "black-carbon=7,saharan-dust=5"]].concat();
    let printed = stdout(&[&["spectrum", "--batch", &pits][..], &options].concat());
    let own = stdout(&[&["spectrum"][..], &options].concat());
    let figures = own.lines().nth(1).unwrap().strip_prefix("3,diffuse,500,").unwrap();
    assert_eq!(printed.lines().nth(1), Some(&*format!("150,7,diffuse,3,500,{figures}")));
    assert!(printed.lines().nth(2).unwrap().starts_with("400,90,60,4,500,"), "{printed}");
    let full = file(folder.path(), "full.csv", "density_kg_m3,black_carbon_ng_g\n200,10\n300,20\n");
    for [option, value] in [["--density", "150"], ["--impurity", "black-carbon=3"]] {
        assert_refused(&["spectrum", "--batch", &full, option, value], &[option, "has no effect", "each line", "full"]);
    }
    stdout(&["spectrum", "--batch", &full, "--impurity", "saharan-dust=3"]);
}

/// Distributions have no number: the metadata describe them.
#[test]
fn rows_and_metadata_say_what_empty_cells_stand_for() {
    let folder = tempfile::tempdir().unwrap();
    let row = |header: &str, line: &str, options: &[&str]| {
        let pits = file(folder.path(), "pits.csv", &format!("{header}\n{line}\n"));
        let base = ["spectrum", "--batch", &pits, "--wavelengths", "500", "--format", "csv"];
        let output = snowblue(&[&base[..], options].concat());
        let [out, errors] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
        (out.lines().nth(1).unwrap_or_else(|| panic!("{errors}")).to_owned(), errors)
    };
    let starts = |header: &str, options: &[&str], start: &str| {
        let (row, _) = row(header, ",", options);
        assert!(row.starts_with(start), "{row}");
    };
    starts("ssa_m2_kg,ice", &["--ssa", "20", "--ice", "picard2016"], "20,picard2016,");
    starts("ssa_m2_kg,snow", &["--snow", "firn"], ",firn,");
    starts("grain_size_um,size_measure", &["--grain-size", "300:500"], "300:500,,");
    starts("optical_radius_um,name", &["--optical-radius", "80"], "80,,");
    let (cells, metadata) = row("facetness,sphericity", ",0.8", &["--facetness", "0.4"]);
    assert!(cells.starts_with(",0.8,"), "{cells}");
    assert!(metadata.contains("facetness 0.3–0.5 about 0.4") && !metadata.contains("sphericity"), "{metadata}");
}

#[test]
fn a_line_has_one_size_of_grains() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |text: &str, options: &[&str], words: &[&str]| {
        let pits = file(folder.path(), "pits.csv", text);
        assert_refused(&[&["spectrum", "--batch", &pits][..], options].concat(), words);
    };
    let both = "size_measure,grain_size_um,optical_radius_um\n";
    refused(&format!("{both},300,50\n"), &[], &[":2: grain_size_um cannot be given with optical_radius_um"]);
    refused(&format!("{both}volume-diameter,,50\n"), &[], &[":2: size_measure cannot be given with optical_radius_um"]);
    refused("optical_radius_um\n50\n", &["--grain-size", "300:800"], &[":1:", "optical_radius_um", "--grain-size"]);
    refused("optical_radius_um\n50\n", &["--size-measure", "volume-diameter"], &[":1:", "--size-measure"]);
    refused("grain_size_um\n300\n", &["--optical-radius", "50"], &[":1:", "grain_size_um", "--optical-radius"]);
    refused("ssa_m2_kg\n20\n", &["--grain-size", "300"], &[":1:", "ssa_m2_kg", "--grain-size"]);
    // Each line may have its own.
    let pits = file(folder.path(), "pits.csv", &format!("{both}volume-diameter,300,\n,,50\n"));
    assert_eq!(stdout(&["spectrum", "--batch", &pits, "--wavelengths", "500"]).lines().count(), 3);
}

#[test]
fn inputs_are_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let pits = file(folder.path(), "pits.csv", PITS);
    assert_refused(&["spectrum", "--batch", &pits, "-o", &pits], &["pits.csv: would be overwritten"]);
    assert_eq!(std::fs::read_to_string(&pits).unwrap(), PITS);
    let layers = file(folder.path(), "pack.toml", "[[layer]]\nthickness_cm = 3\n");
    assert_refused(
        &["spectrum", "--layers", &layers, "--format", "csv", "-o", &layers],
        &["pack.toml: would be overwritten"],
    );
    assert_eq!(std::fs::read_to_string(&layers).unwrap(), "[[layer]]\nthickness_cm = 3\n");
    let text = stdout(&["spectrum", "--wavelengths", "400:700:100"]);
    let spectrum = file(folder.path(), "spectrum.csv", &text);
    assert_refused(&["color", "--spectrum", &spectrum, "-o", &spectrum], &["spectrum.csv: would be overwritten"]);
    assert_eq!(std::fs::read_to_string(&spectrum).unwrap(), text);
}

#[test]
fn metadata_say_what_no_column_says() {
    let folder = tempfile::tempdir().unwrap();
    let pits = file(folder.path(), "pits.csv", "density_kg_m3,black_carbon_ng_g\n200,5\n");
    let output = folder.path().join("pits.json");
    let options = ["--grain-size", "300:500", "--facetness", "0.4", "--temperature=-9", "--water-saturation", "0.1"];
    let dust = ["--impurity", "saharan-dust=8", "--wavelengths", "500", "-o", output.to_str().unwrap()];
    stdout(&[&["spectrum", "--batch", &pits][..], &options, &dust].concat());
    let written: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(&output).unwrap()).unwrap();
    let metadata = &written["metadata"];
    for (name, value) in [
        ("grain_size_um", "300–500"),
        ("size_measure", "greatest extension"),
        ("water_saturation", "0.1"),
        ("temperature_c", "-9"),
        ("ice", "warren2008"),
    ] {
        assert_eq!(metadata[name], value);
    }
    assert!(metadata["facetness"].as_str().unwrap().contains("about 0.4"), "{metadata}");
    let impurities = metadata["impurities"].as_str().unwrap();
    assert!(impurities.contains("black-carbon (") && impurities.contains("saharan-dust=8 ng/g ("), "{impurities}");
    assert!(metadata.get("density_kg_m3").is_none());
}

/// A half-space has no transmittance, is the limit of thick slabs, and has no random walks.
#[test]
fn thicknesses_may_be_infinite() {
    let folder = tempfile::tempdir().unwrap();
    let pits = file(folder.path(), "pits.csv", "thickness_cm\ninf\n5000\n");
    let common = ["spectrum", "--wavelengths", "600", "--format", "json"];
    let json =
        |more: &[&str]| -> serde_json::Value { serde_json::from_str(&stdout(&[&common[..], more].concat())).unwrap() };
    for more in [&["--batch", &pits][..], &["--thickness", "inf,5000"]] {
        let answer = json(more);
        let [endless, thick] = [0, 1].map(|row| &answer["rows"][row]);
        assert_eq!((&endless["thickness_cm"], &endless["transmittance"]), (&"inf".into(), &0.into()), "{answer}");
        let [endless, thick] = [endless, thick].map(|row| row["reflectance"].as_f64().unwrap());
        assert!((endless / thick - 1.0).abs() < 1e-8, "{answer}");
    }
    let walks = ["spectrum", "--thickness", "inf", "--engine", "montecarlo"];
    assert_refused(&walks, &["thickness is inf cm", "0–100000 cm"]);
    assert_refused(&["spectrum", "--thickness", "inf", "--plot", "x.svg"], &["--plot", "half-space"]);
}

/// The values lie in their intervals, which are wider for less known snow.
#[test]
fn deviations_give_intervals() {
    let header = "thickness_cm,angle_deg,wavelength_nm,reflectance,transmittance,absorptance,reflectance_lower,\
                  reflectance_upper,transmittance_lower,transmittance_upper,absorptance_lower,absorptance_upper";
    let common = ["spectrum", "--ssa", "20", "--thickness", "10", "--wavelengths", "450,700", "--plus-minus"];
    let widths = ["ssa=1,density=10", "ssa=3,density=50,ice"].map(|deviations| {
        let text = stdout(&[&common[..], &[deviations]].concat());
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some(header));
        let row = |line: &str| line.split(',').map(|word| word.parse().unwrap()).collect::<Vec<f64>>();
        let rows: Vec<Vec<f64>> = lines.map(row).collect();
        for row in &rows {
            for (value, lower) in [(3, 6), (4, 8), (5, 10)] {
                assert!(row[lower] < row[value] && row[value] < row[lower + 1], "{row:?}");
            }
        }
        rows[1][7] - rows[1][6]
    });
    assert!(widths[1] > 2.0 * widths[0], "{widths:?}");
    assert_refused(&["spectrum", "--plus-minus", "ssa=2"], &["specific surface area", "needs snow"]);
    assert_refused(&["spectrum", "--plus-minus", "soot=2"], &["'soot'", "black-carbon"]);
    let walks = ["spectrum", "--plus-minus", "density=2", "--engine", "montecarlo"];
    assert_refused(&walks, &["--plus-minus", "--engine ordinates"]);
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
    assert!(density == [120.0, 300.0, 300.0], "{density:?}");
    assert_eq!(read.read_var_u8("name").unwrap()[..11], *b"upper ridge");
    assert_eq!(data_attr(&read, "name", "_Encoding"), "utf-8");
    let coordinates = data_attr(&read, "reflectance", "coordinates");
    assert_eq!(coordinates, "name specific_surface_area density black_carbon thickness ground_albedo angle");
    let printed = stdout(&["spectrum", "--batch", &pits, "--wavelengths", "450,1000"]);
    let reflectance = read.read_var_f64("reflectance").unwrap();
    for (line, value) in printed.lines().skip(1).zip(&reflectance) {
        let printed: f64 = line.split(',').nth(8).unwrap().parse().unwrap();
        assert!((printed - value).abs() < 1e-8, "{line} {value}");
    }
    // Also lines that are all combinations are slabs.
    let regular = file(folder.path(), "regular.csv", "thickness_cm\n1\n2\n");
    stdout(&["spectrum", "--batch", &regular, "--wavelengths", "450", "-o", written]);
    let regular = FileReader::open(&output).unwrap();
    assert_eq!(regular.data_set().get_var("reflectance").unwrap().dim_names(), ["slab", "wavelength"]);
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
