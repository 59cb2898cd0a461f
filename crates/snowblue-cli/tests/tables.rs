//! `snowblue database`: any axes, shards, criteria of compression, and export.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use std::path::Path;

use shell::{assert_names, assert_refused, snowblue, stderr, stdout};

/// Axes of a small table.
const SMALL: [&str; 8] =
    ["--grain-size", "200,400", "--facetness", "0.2,0.6", "--density", "300", "--thickness", "1,5"];

fn build(options: &[&str], output: &Path) {
    let output = ["-o", output.to_str().unwrap()];
    let tally: &[&str] = if options.contains(&"montecarlo") { &[] } else { &["--tally-rays", "1024"] };
    stdout(&[&["database", "build", "--quiet"], &SMALL[..], tally, options, &output].concat());
}

fn names(paths: &[std::path::PathBuf]) -> Vec<&str> {
    paths.iter().map(|path| path.to_str().unwrap()).collect()
}

#[test]
fn shards_merge_to_the_same_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    build(&[], &path("whole.nc"));
    let parts: Vec<_> = (1..=3).map(|number| path(&format!("part{number}.nc"))).collect();
    for (number, part) in parts.iter().enumerate() {
        build(&["--shard", &format!("{}/3", number + 1)], part);
    }
    let merged = path("merged.nc");
    let output = ["-o", merged.to_str().unwrap()];
    stdout(&[&["merge"], &names(&parts)[..], &output].concat());
    assert!(std::fs::read(path("whole.nc")).unwrap() == std::fs::read(&merged).unwrap());
    std::fs::remove_file(&merged).unwrap();
    let two = names(&parts)[..2].to_vec();
    assert_refused(&[&["merge"], &two[..], &output[..]].concat(), &["3", "missing"]);
    assert_refused(&[&["merge"], &[two[0], two[0]][..], &output].concat(), &["part1.nc", "1/3"]);
    assert!(!merged.exists(), "no partial file is left");
    let whole = path("whole.nc");
    let with_whole = [&["merge", two[0], whole.to_str().unwrap()], &output[..]].concat();
    assert_refused(&with_whole, &["whole.nc: is a full table, not a shard"]);
    assert_refused(&[&["database", "build", "--shard", "9/3"], &SMALL[..], &output].concat(), &["9/3"]);
}

/// The message says which command makes a table that can be rendered.
#[test]
fn a_full_table_is_compressed_by_the_command_that_rendering_names() {
    let folder = tempfile::tempdir().unwrap();
    let [full, small] = ["full.nc", "small.nc"].map(|name| folder.path().join(name));
    let snow = ["--grain-size", "200,300,400,500", "--facetness", "0.3", "--preset", "default"];
    let full = full.to_str().unwrap();
    stdout(&[&["database", "build", "--quiet", "--tally-rays", "1024", "-o", full], &snow[..]].concat());
    let picture = ["render", "--scene", "block_30cm", "--integrator", "pcasnow", "--width", "4", "--height", "4", "-o"];
    let render = [&picture[..], &["never.png", "--database", full]].concat();
    assert_refused(&render, &["full.nc: is a full table, not a compressed one"]);
    let message = String::from_utf8(snowblue(&render).stderr).unwrap();
    let named = message.trim_end().split_once(": snowblue ").unwrap().1.replace("FILE.nc", small.to_str().unwrap());
    stdout(&named.split(' ').collect::<Vec<_>>());
    let output = folder.path().join("a.png");
    stdout(&[&picture[..], &[output.to_str().unwrap(), "--database", small.to_str().unwrap()]].concat());
}

#[test]
fn axes_come_from_a_file_and_options() {
    let folder = tempfile::tempdir().unwrap();
    let (axes, table) = (folder.path().join("axes.toml"), folder.path().join("table.nc"));
    let text = "preset = \"paper\"\ngrain_size_um = [300]\nfacetness = [0.3]\ndensity_kg_m3 = [300]\n\
                angle_deg = [0, \"diffuse\"]\nthickness_cm = [1, 10]\nwavelength_nm = \"400:700:50\"\n\
                water_saturation = [0, 0.2]\nimpurities_ng_g = { black-carbon = [0, 100] }\n";
    std::fs::write(&axes, text).unwrap();
    let (axes, table) = (axes.to_str().unwrap(), table.to_str().unwrap());
    stdout(&[
        "database",
        "build",
        "--axes",
        axes,
        "--tally-rays",
        "1024",
        "--temperature=-10,-1",
        "--quiet",
        "-o",
        table,
    ]);
    let info = stdout(&["database", "info", table]);
    let expected = [
        "32 curves",
        "  water_saturation: 0 0.2\n",
        "  temperature (degree_Celsius): -10 -1\n",
        "  black_carbon (ng g-1): 0 100\n",
        "  angle (degree): diffuse 0\n",
        "  wavelength (nm): 400 450 500 550 600 650 700\n",
    ];
    assert_names(&info, &expected);
    for (from, to, words) in [
        ("\"diffuse\"", "\"difuse\"", ["axes.toml:5:", "'difuse'"]),
        ("[1, 10]", "[10, 1]", ["axes.toml:", "thickness"]),
        ("black-carbon", "soot", ["axes.toml:9:", "'soot'"]),
        ("preset", "presets", ["axes.toml:1:", "presets"]),
        ("[0, 0.2]", "[0, 1.2]", ["axes.toml:", "1.2"]),
        ("400:700:50", "400:1500:50", ["axes.toml:", "1500 nm"]),
    ] {
        std::fs::write(axes, text.replacen(from, to, 1)).unwrap();
        assert_refused(&["database", "build", "--axes", axes, "-o", table], &words);
    }
}

#[test]
fn components_are_chosen_by_criteria() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.nc");
    let output = ["-o", path.to_str().unwrap()];
    let log = ["database", "build", "--space", "log", "--tally-rays", "1024"];
    let build = |criteria: &[&str]| stderr(&[&log, &SMALL[..], criteria, &output].concat());
    assert_names(&build(&["--max-delta-e", "100", "--max-rmse", "1"]), &["1 components", "log"]);
    let strict = build(&["--max-delta-e", "0.3", "--max-rmse", "0.002", "--illuminant", "D65,E"]);
    assert!(strict.contains("3 components") || strict.contains("2 components"), "{strict}");
    let strictest = [&log, &SMALL[..], &["--max-rmse", "1e-9"], &output].concat();
    assert_refused(&strictest, &["31", "components", "transmittance"]);
    let unlimited = [&["database", "build", "--space", "log"], &SMALL[..], &output].concat();
    assert_refused(&unlimited, &["--space", "--components"]);
}

#[test]
fn monte_carlo_fills_tables_and_its_noise_is_measured() {
    let folder = tempfile::tempdir().unwrap();
    let (sampled, solved) = (folder.path().join("sampled.nc"), folder.path().join("solved.nc"));
    build(&["--engine", "montecarlo", "--rays", "500", "--angle", "0"], &sampled);
    build(&["--angle", "0"], &solved);
    let text = stdout(&[
        "database",
        "fidelity",
        sampled.to_str().unwrap(),
        "--truth",
        solved.to_str().unwrap(),
        "--components",
        "1",
        "--format",
        "csv",
    ]);
    let drawing = folder.path().join("cost.svg");
    let plot = ["--components", "2", "--plot", drawing.to_str().unwrap(), "--quiet"];
    stdout(&[&["database", "fidelity", solved.to_str().unwrap()], &plot[..]].concat());
    assert_names(&std::fs::read_to_string(drawing).unwrap(), &["Components", "RMSE", "Singular value"]);
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!((rows.len(), &rows[0][13..]), (5, &["worst_rmse_curve", "worst_delta_e_curve"][..]));
    assert!(rows[1][13].contains("µm; facetness"), "{text}");
}

#[test]
fn full_tables_are_compressed_and_exported() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (full, compressed, at_once, rows) = (path("full.nc"), path("snow.nc"), path("at_once.nc"), path("rows.csv"));
    let log = ["--space", "log", "--components", "2"];
    build(&[], Path::new(&full));
    build(&log, Path::new(&at_once));
    let said = stderr(&[&["merge", &*full, "-o", &*compressed], &log[..]].concat());
    assert_names(&said, &["curves from 1 file, 2 components in log space"]);
    assert!(std::fs::read(&compressed).unwrap() == std::fs::read(&at_once).unwrap());
    assert_refused(&["merge", &at_once, "-o", &compressed], &["at_once.nc: is a compressed table, not a shard"]);
    stdout(&["database", "export", &full, "-o", &rows]);
    let text = std::fs::read_to_string(&rows).unwrap();
    assert!(
        text.starts_with("grain_size_um,facetness,density_kg_m3,angle_deg,thickness_cm,wavelength_nm,transmittance,")
    );
    stdout(&["database", "export", "-o", &path("snow.json")]);
    assert!(Path::new(&path("snow.f32")).exists());
    assert_refused(&["database", "export", "-o", &path("snow.xyz")], &["snow.xyz", ".json", ".csv"]);
}
