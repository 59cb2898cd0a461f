//! Tables as users make them: on any axes, in shards, chosen by criteria, brought in and taken out.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use std::path::Path;

use shell::{refused, snowblue, stdout};

/// Axes that are filled in a moment.
const SMALL: [&str; 10] = [
    "--grain-size",
    "200,400",
    "--facetness",
    "0.2,0.6",
    "--density",
    "300",
    "--thickness",
    "1,5",
    "--tally-rays",
    "1024",
];

fn build(options: &[&str], output: &Path) {
    let output = ["-o", output.to_str().unwrap()];
    stdout(&[&["database", "build", "--quiet"], &SMALL[..], options, &output].concat());
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
    let message = refused(&[&["merge"], &two[..], &output[..]].concat());
    assert!(message.contains("of 3 parts these are missing: 3"), "{message}");
    let message = refused(&[&["merge"], &[two[0], two[0]][..], &output].concat());
    assert!(message.contains("are both part 1/3"), "{message}");
    assert!(!merged.exists(), "nothing is half-written");
    let message = refused(&["merge", path("whole.nc").to_str().unwrap(), "-o", "x.nc"]);
    assert!(message.contains("is a full table, not a shard"), "{message}");
    let message = refused(&[&["database", "build", "--shard", "9/3"], &SMALL[..], &output].concat());
    assert!(message.contains("part 9/3"), "{message}");
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
    for line in [
        "32 curves of 8 kinds of snow",
        "  water_saturation: 0 0.2\n",
        "  temperature (degree_Celsius): -10 -1\n",
        "  black_carbon (ng g-1): 0 100\n",
        "  angle (degree): diffuse 0\n",
        "  wavelength (nm): 400 450 500 550 600 650 700\n",
    ] {
        assert!(info.contains(line), "{line}: {info}");
    }
    for (from, to, words) in [
        ("\"diffuse\"", "\"difuse\"", "axes.toml:5: 'difuse' is neither"),
        ("[1, 10]", "[10, 1]", "axes.toml: the axis thickness must ascend"),
        ("black-carbon", "soot", "axes.toml:9: impurity 'soot' is not known"),
        ("preset", "presets", "axes.toml:1: unknown field `presets`"),
        ("[0, 0.2]", "[0, 1.2]", "axes.toml: water saturation is 1.2"),
        ("400:700:50", "400:1500:50", "axes.toml: wavelength in snow with impurities is 1500 nm"),
    ] {
        std::fs::write(axes, text.replacen(from, to, 1)).unwrap();
        let message = refused(&["database", "build", "--axes", axes, "-o", table]);
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn components_are_chosen_by_criteria() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.nc");
    let output = ["-o", path.to_str().unwrap()];
    let told = |criteria: &[&str]| {
        let output = snowblue(&[&["database", "build", "--space", "log"], &SMALL[..], criteria, &output].concat());
        String::from_utf8(output.stderr).unwrap()
    };
    assert!(told(&["--max-delta-e", "100", "--max-rmse", "1"]).contains(", 1 components in log space"));
    let strict = told(&["--max-delta-e", "0.3", "--max-rmse", "0.002", "--illuminant", "D65,E"]);
    assert!(strict.contains("3 components") || strict.contains("2 components"), "{strict}");
    let message =
        refused(&[&["database", "build", "--space", "log", "--max-rmse", "1e-9"], &SMALL[..], &output].concat());
    assert!(message.contains("even 31 components do not keep transmittance"), "{message}");
    let message = refused(&[&["database", "build", "--space", "log"], &SMALL[..], &output].concat());
    assert!(message.contains("--space needs --components"), "{message}");
}

#[test]
fn the_walk_fills_tables_too_and_its_noise_is_judged() {
    let folder = tempfile::tempdir().unwrap();
    let (walked, solved) = (folder.path().join("walked.nc"), folder.path().join("solved.nc"));
    build(&["--engine", "montecarlo", "--rays", "500", "--angle", "0"], &walked);
    build(&["--angle", "0"], &solved);
    let text = stdout(&[
        "database",
        "fidelity",
        walked.to_str().unwrap(),
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
    assert!(std::fs::read_to_string(drawing).unwrap().contains("Singular value over the first"));
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!((rows.len(), &rows[0][13..]), (5, &["worst_rmse_curve", "worst_delta_e_curve"][..]));
    assert!(rows[1][13].contains("µm; facetness"), "{text}");
}

#[test]
fn what_spectrum_prints_becomes_a_table_and_goes_out_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (curves, table, rows) = (path("s.csv"), path("s.nc"), path("rows.csv"));
    stdout(&[
        "spectrum",
        "--thickness",
        "1,5",
        "--angle",
        "0,diffuse",
        "--wavelengths",
        "400,700",
        "-o",
        &curves,
        "--quiet",
    ]);
    let set = ["--set", "grain_size=400", "--set", "facetness=0.3", "--set", "density=300"];
    stdout(&[&["database", "import", &curves, "--quiet", "-o", &table], &set[..]].concat());
    stdout(&["database", "export", &table, "-o", &rows]);
    let text = std::fs::read_to_string(&rows).unwrap();
    assert!(
        text.starts_with("grain_size_um,facetness,density_kg_m3,angle_deg,thickness_cm,wavelength_nm,transmittance,")
    );
    assert_eq!(
        (text.lines().count(), text.lines().nth(1).unwrap().starts_with("400,0.3,300,diffuse,1,400,")),
        (9, true)
    );
    let message = refused(&["database", "import", &curves, "-o", &table]);
    assert!(message.contains("s.csv: has no 'grain_size_um'"), "{message}");
    stdout(&["database", "export", "-o", &path("snow.json")]);
    assert!(Path::new(&path("snow.f32")).exists());
    let message = refused(&["database", "export", "-o", &path("snow.xyz")]);
    assert!(message.contains("must end in .json or .csv"), "{message}");
}
