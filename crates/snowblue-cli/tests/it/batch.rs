//! `snowblue spectrum` with many slabs: files of slabs, options with several values, and NetCDF.

use crate::shell::{Folder, assert_names, snowblue, stdout};
use netcdf3::FileReader;

pub(crate) const PITS: &str = "\
name,ssa_m2_kg,density_kg_m3,black_carbon_ng_g,thickness_cm,ground_albedo
\"upper ridge\",60,120,0,2,0.1

valley,25,300,5,15,
glacier,3,,400,40,0
";

const ALONE: &str = "thickness_cm,angle_deg,wavelength_nm,reflectance,transmittance,absorptance";

/// Lines of a CSV after its header.
fn lines(text: &str, header: &str) -> Vec<String> {
    let mut lines = text.lines().map(str::to_owned);
    assert_eq!(lines.next().as_deref(), Some(header));
    lines.collect()
}

#[test]
fn a_line_of_a_file_has_the_figures_of_its_options() {
    let folder = Folder::new();
    folder.write("pits.csv", PITS);
    let common = "--angle 60 --wavelengths 450,500";
    let header = "name,ssa_m2_kg,density_kg_m3,black_carbon_ng_g,thickness_cm,ground_albedo,angle_deg,wavelength_nm,\
                  reflectance,transmittance,absorptance";
    let batch = lines(&folder.stdout(&format!("spectrum --batch pits.csv {common}")), header);
    assert_eq!(batch.len(), 6);
    let alone = [
        "--ssa 60 --density 120 --thickness 2 --ground-albedo 0.1",
        "--ssa 25 --density 300 --thickness 15 --impurity black-carbon=5",
        "--ssa 3 --thickness 40 --impurity black-carbon=400",
    ];
    let names = ["upper ridge,60,120,0,2,0.1,60,", "valley,25,300,5,15,0,60,", "glacier,3,300,400,40,0,60,"];
    for ((slab, options), name) in batch.chunks(2).zip(alone).zip(names) {
        let own = lines(&stdout(&format!("spectrum {options} {common}")), ALONE);
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
    let common = "--thickness 3,6 --wavelengths 500";
    let several = stdout(&format!("spectrum --ssa 10,40 --density 200,300 --impurity black-carbon=0:50 {common}"));
    let all = lines(&several, header);
    assert_eq!(all.len(), 16);
    assert!(all[0].starts_with("10,200,0,3,0,500,") && all[15].starts_with("40,300,50,6,0,500,"), "{all:?}");
    let one = stdout(&format!("spectrum --ssa 40 --density 200 --impurity black-carbon=50 {common}"));
    for (line, own) in all[10..12].iter().zip(lines(&one, ALONE)) {
        assert_eq!(line, &format!("40,200,50,{own}"));
    }
}

/// Spheres of a radius r have the area 3/(ρ r): 3/(917.7 · 10⁻⁴) = 32.69 m²/kg at 100 µm.
#[test]
fn an_optical_radius_is_a_surface_area() {
    let number = |size: &str| -> f64 {
        let lines = lines(&stdout(&format!("spectrum --wavelengths 1000 --thickness 2 {size}")), ALONE);
        lines[0].split(',').nth(3).unwrap().parse().unwrap()
    };
    let area = number(&format!("--ssa {}", 3.0 / (917.7015 * 1e-4)));
    let radius = number("--optical-radius 100");
    // Nine digits are printed.
    assert!((radius - area).abs() < 2e-9, "{radius} {area}");
}

#[test]
fn comments_are_left_out() {
    let folder = Folder::new();
    let rows = |text: &str| {
        folder.write("pits.csv", text);
        folder.stdout("spectrum --batch pits.csv --wavelengths 500")
    };
    let plain = rows("ssa_m2_kg,thickness_cm\n20,5\n30,7\n");
    assert_eq!(rows("# pits\n\n  # of May\nssa_m2_kg,thickness_cm\n20,5\n# later\n30,7\n"), plain);
    // A name may begin as a comment does.
    let named = rows("# pits\nname,ssa_m2_kg,thickness_cm\n#1,20,5\n#2,30,7\n");
    assert!(named.contains("#1,20,5,") && named.contains("#2,30,7,"), "{named}");
}

/// An empty cell has the option's value, in the figures and in the row.
#[test]
fn options_count_where_cells_are_empty() {
    let folder = Folder::new();
    folder.write("pits.csv", "density_kg_m3,black_carbon_ng_g,angle_deg,thickness_cm\n,,,\n400,90,60,4\n");
    let options = "--density 150 --angle diffuse --thickness 3 --wavelengths 500 \
                   --impurity black-carbon=7,saharan-dust=5";
    let printed = folder.stdout(&format!("spectrum --batch pits.csv {options}"));
    let own = stdout(&format!("spectrum {options}"));
    let figures = own.lines().nth(1).unwrap().strip_prefix("3,diffuse,500,").unwrap();
    assert_eq!(printed.lines().nth(1), Some(&*format!("150,7,diffuse,3,500,{figures}")));
    assert!(printed.lines().nth(2).unwrap().starts_with("400,90,60,4,500,"), "{printed}");
    // A substance without a column is that of the option.
    folder.write("full.csv", "density_kg_m3,black_carbon_ng_g\n200,10\n");
    folder.stdout("spectrum --batch full.csv --impurity saharan-dust=3 --wavelengths 500");
}

/// Distributions have no number: the metadata describe them.
#[test]
fn rows_and_metadata_say_what_empty_cells_stand_for() {
    let folder = Folder::new();
    let run = |header: &str, line: &str, options: &str| {
        folder.write("pits.csv", format!("{header}\n{line}\n"));
        let output = folder.run(&format!("spectrum --batch pits.csv --wavelengths 500 --format csv {options}"));
        let [out, errors] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
        (out.lines().nth(1).unwrap_or_else(|| panic!("{errors}")).to_owned(), errors)
    };
    for (header, options, start) in [
        ("ssa_m2_kg,ice", "--ssa 20 --ice picard2016", "20,picard2016,"),
        ("ssa_m2_kg,snow", "--snow firn", ",firn,"),
        ("grain_size_um,size_measure", "--grain-size 300:500", "300:500,,"),
        ("optical_radius_um,name", "--optical-radius 80", "80,,"),
    ] {
        let (row, _) = run(header, ",", options);
        assert!(row.starts_with(start), "{row}");
    }
    let (cells, metadata) = run("facetness,sphericity", ",0.8", "--facetness 0.4");
    assert!(cells.starts_with(",0.8,"), "{cells}");
    assert!(metadata.contains("facetness 0.3–0.5 about 0.4") && !metadata.contains("sphericity"), "{metadata}");
}

/// One line has a grain size, another an optical radius.
#[test]
fn each_line_may_have_its_own_size_of_grains() {
    let folder = Folder::new();
    folder.write("pits.csv", "size_measure,grain_size_um,optical_radius_um\nvolume-diameter,300,\n,,50\n");
    assert_eq!(folder.stdout("spectrum --batch pits.csv --wavelengths 500").lines().count(), 3);
}

#[test]
fn metadata_say_what_no_column_says() {
    let folder = Folder::new();
    folder.write("pits.csv", "density_kg_m3,black_carbon_ng_g\n200,5\n");
    folder.stdout(
        "spectrum --batch pits.csv --grain-size 300:500 --facetness 0.4 --temperature=-9 --water-saturation 0.1 \
         --impurity saharan-dust=8 --wavelengths 500 -o pits.json",
    );
    let written: serde_json::Value = serde_json::from_str(&folder.text("pits.json")).unwrap();
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

#[test]
fn more_values_than_fit_into_memory_are_refused() {
    let thicknesses: Vec<String> = (1..=1100).map(|thickness_cm| thickness_cm.to_string()).collect();
    let output = snowblue(&format!("spectrum --wavelengths 400:700:0.0031 --thickness {}", thicknesses.join(",")));
    assert_eq!(output.status.code(), Some(2));
    assert_names(&String::from_utf8(output.stderr).unwrap(), &["106452500 spectral values", "at most 100000000"]);
}

/// A half-space has no transmittance, and is the limit of thick slabs.
#[test]
fn thicknesses_may_be_infinite() {
    let folder = Folder::new();
    folder.write("pits.csv", "thickness_cm\ninf\n5000\n");
    for slabs in ["--batch pits.csv", "--thickness inf,5000"] {
        let text = folder.stdout(&format!("spectrum --wavelengths 600 --format json {slabs}"));
        let answer: serde_json::Value = serde_json::from_str(&text).unwrap();
        let [endless, thick] = [0, 1].map(|row| &answer["rows"][row]);
        assert_eq!((&endless["thickness_cm"], &endless["transmittance"]), (&"inf".into(), &0.into()), "{answer}");
        let [endless, thick] = [endless, thick].map(|row| row["reflectance"].as_f64().unwrap());
        assert!((endless / thick - 1.0).abs() < 1e-8, "{answer}");
    }
}

/// The values lie in their intervals, which are wider for less known snow.
#[test]
fn deviations_give_intervals() {
    let header = "thickness_cm,angle_deg,wavelength_nm,reflectance,transmittance,absorptance,reflectance_lower,\
                  reflectance_upper,transmittance_lower,transmittance_upper,absorptance_lower,absorptance_upper";
    let widths = ["ssa=1,density=10", "ssa=3,density=50,ice"].map(|deviations| {
        let slab = "--ssa 20 --thickness 10 --wavelengths 450,500 --streams 4";
        let text = stdout(&format!("spectrum {slab} --plus-minus {deviations}"));
        let row = |line: String| line.split(',').map(|word| word.parse().unwrap()).collect::<Vec<f64>>();
        let rows: Vec<Vec<f64>> = lines(&text, header).into_iter().map(row).collect();
        for row in &rows {
            for (value, lower) in [(3, 6), (4, 8), (5, 10)] {
                assert!(row[lower] < row[value] && row[value] < row[lower + 1], "{row:?}");
            }
        }
        rows[1][7] - rows[1][6]
    });
    assert!(widths[1] > 2.0 * widths[0], "{widths:?}");
}

#[test]
fn spectra_are_written_as_netcdf_with_dimensions() {
    let folder = Folder::new();
    folder.write("pits.csv", PITS);
    folder.stdout("spectrum --batch pits.csv --wavelengths 450,500 -o pits.nc");
    let mut read = FileReader::open(folder.path("pits.nc")).unwrap();
    let data = read.data_set();
    let dims = |name: &str| data.get_var(name).unwrap().dim_names();
    assert_eq!(
        (dims("reflectance"), dims("thickness")),
        (vec!["slab".into(), "wavelength".into()], vec!["slab".to_owned()])
    );
    let attribute = |variable: &str, name: &str| data.get_var_attr_as_string(variable, name);
    assert_eq!(attribute("specific_surface_area", "units").as_deref(), Some("m2 kg-1"));
    assert_eq!(attribute("black_carbon", "units").as_deref(), Some("ng g-1"));
    assert_eq!(attribute("name", "_Encoding").as_deref(), Some("utf-8"));
    let ground = data.get_global_attr_as_string("ground").unwrap();
    assert!(ground.ends_with("absorptance is that of the snow, 1 - reflectance - (1 - ground_albedo) transmittance"));
    let coordinates = "name specific_surface_area density black_carbon thickness ground_albedo angle";
    assert_eq!(attribute("reflectance", "coordinates").as_deref(), Some(coordinates));
    let density = read.read_var_f64("density").unwrap();
    assert!(density == [120.0, 300.0, 300.0], "{density:?}");
    assert_eq!(read.read_var_u8("name").unwrap()[..11], *b"upper ridge");
    let printed = folder.stdout("spectrum --batch pits.csv --wavelengths 450,500");
    let reflectance = read.read_var_f64("reflectance").unwrap();
    for (line, value) in printed.lines().skip(1).zip(&reflectance) {
        let printed: f64 = line.split(',').nth(8).unwrap().parse().unwrap();
        assert!((printed - value).abs() < 1e-8, "{line} {value}");
    }
    // Also lines that are all combinations are slabs.
    folder.write("regular.csv", "thickness_cm\n1\n2\n");
    folder.stdout("spectrum --batch regular.csv --wavelengths 450 -o pits.nc");
    let regular = FileReader::open(folder.path("pits.nc")).unwrap();
    assert_eq!(regular.data_set().get_var("reflectance").unwrap().dim_names(), ["slab", "wavelength"]);
    // All combinations of axes are axes.
    folder.stdout("spectrum -o grid.nc --ssa 10,40 --thickness 1,2,5 --angle 0,diffuse --wavelengths 450,500");
    let mut read = FileReader::open(folder.path("grid.nc")).unwrap();
    let dims = read.data_set().get_var("transmittance").unwrap().dim_names();
    assert_eq!(dims, ["specific_surface_area", "thickness", "angle", "wavelength"]);
    assert_eq!(read.read_var_f64("angle").unwrap(), [0.0, -1.0]);
    assert_eq!(read.data_set().get_global_attr_as_string("ice").as_deref(), Some("warren2008"));
    // Coordinates of a dimension differ. A plot is drawn beside any output.
    folder.stdout("spectrum -o twice.nc --thickness 5,5 --wavelengths 450,500 --plot twice.svg");
    let twice = FileReader::open(folder.path("twice.nc")).unwrap();
    assert_eq!(twice.data_set().get_var("reflectance").unwrap().dim_names(), ["slab", "wavelength"]);
    assert!(folder.text("twice.svg").contains("<svg"));
}

/// A line with NaN has no fluxes, and the others have those that they have without it. Empty cells are named.
#[test]
fn lines_with_gaps_have_no_fluxes() {
    let folder = Folder::new();
    folder.write("pits.csv", "name,ssa_m2_kg,density_kg_m3,thickness_cm\na,20,200,5\nb,NaN,300,5\nc,30,nan,5\nd,,,7\n");
    folder.write("whole.csv", "name,ssa_m2_kg,density_kg_m3,thickness_cm\na,20,200,5\nd,,,7\n");
    for options in ["--wavelengths 500,900", "--broadband par", "--wavelengths 500 --plus-minus density=10 --streams 4"]
    {
        let run = |file: &str, quiet: &str| {
            let output = folder.run(&format!("spectrum {quiet} --batch {file} {options} --format csv"));
            [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap())
        };
        let [[printed, notes], [whole, _], [_, quiet]] =
            [run("pits.csv", ""), run("whole.csv", ""), run("pits.csv", "--quiet")];
        let of = |name: &str| printed.lines().filter(|line| line.starts_with(name)).collect::<Vec<_>>();
        for name in ["b,NaN,300,", "c,30,NaN,"] {
            assert!(!of(name).is_empty(), "{printed}");
            assert!(of(name).iter().all(|line| line.ends_with("NaN,NaN,NaN")), "{printed}");
        }
        let known: Vec<&str> = whole.lines().skip(1).collect();
        assert_eq!([of("a,"), of("d,")].concat(), known);
        assert_names(
            &notes,
            &[
                "pits.csv: 1 of 4 lines have no density_kg_m3: 300 is taken",
                "pits.csv: 1 of 4 lines have no ssa_m2_kg: a grain size of 350–450 µm, unless another column has one,",
            ],
        );
        assert!(!quiet.contains("is taken"), "{quiet}");
    }
    folder.write("pits.csv", "thickness_cm\nNaN\n");
    folder.stdout("spectrum --batch pits.csv --wavelengths 500 -o pits.nc");
    let reflectance = FileReader::open(folder.path("pits.nc")).unwrap().read_var_f64("reflectance").unwrap();
    assert!(reflectance[0].is_nan());
    // Other cells of a line with a gap are checked.
    folder.write("pits.csv", "density_kg_m3,ssa_m2_kg\nNaN,5000\n");
    folder.assert_refused("spectrum --batch pits.csv", &["pits.csv:2", "5000"]);
    folder.write("pits.csv", "density_kg_m3,thickness_cm\nNaN,-5\n");
    folder.assert_refused("spectrum --batch pits.csv", &["pits.csv:2", "thickness is -5 cm"]);
}

/// A spectrum as ground: each wavelength has the fluxes on the grey ground of its albedo there.
#[test]
fn a_ground_may_have_a_spectrum() {
    let folder = Folder::new();
    folder.write("soil.csv", "wavelength_nm,albedo\n400,0.1\n600,0.3\n1200,0.6\n");
    folder.write("pits.csv", "thickness_cm,ground_albedo\n5,soil.csv\n5,0.2\n5,\n");
    folder.assert_refused("spectrum --ground-albedo soil.csv -o soil.csv", &["soil.csv"]);
    folder.write("pack.toml", "[[layer]]\nthickness_cm = 5\n");
    let row = |options: &str, row: usize| {
        let text = folder.stdout(&format!("spectrum --wavelengths 500,900 {options}"));
        text.lines().nth(row).unwrap().rsplitn(4, ',').take(3).map(str::to_owned).collect::<Vec<_>>()
    };
    for snow in ["--thickness 5", "--layers pack.toml"] {
        let spectrum = format!("{snow} --ground-albedo soil.csv");
        assert_eq!(row(&spectrum, 1), row(&format!("{snow} --ground-albedo 0.2"), 1));
        assert_eq!(row(&spectrum, 2), row(&format!("{snow} --ground-albedo 0.45"), 2));
    }
    let batch = |place: usize| row("--batch pits.csv --ground-albedo soil.csv", place);
    assert_eq!([batch(1), batch(2)], [batch(5), batch(6)]);
    assert_eq!(batch(1), batch(3));
    assert_ne!(batch(2), batch(4));
    for (options, words) in [
        ("--wavelengths 350", &["wavelength above the ground is 350 nm", "400–1200 nm"][..]),
        ("--wavelengths 500 --ground-albedo none.csv", &["none.csv", "cannot be read"]),
        ("--wavelengths 500 --ground-albedo soil", &["'soil' is neither a number nor the name of a CSV file"]),
    ] {
        let ground = if options.contains("ground") { "" } else { "--ground-albedo soil.csv" };
        let output = folder.run(&format!("spectrum {options} {ground}"));
        assert_eq!(output.status.code(), Some(2));
        assert_names(&String::from_utf8(output.stderr).unwrap(), words);
    }
    folder.write("bright.csv", "wavelength_nm,albedo\n400,0.1\n600,1.3\n");
    let output = folder.run("spectrum --ground-albedo bright.csv");
    assert_names(&String::from_utf8(output.stderr).unwrap(), &["bright.csv:3", "ground albedo is 1.3", "0–1"]);
}
