//! `snowblue database`: any axes, shards, criteria of compression, and export.

use crate::shell::{Folder, assert_names};

/// A file of axes.
pub(crate) const AXES: &str = "\
preset = \"paper\"
grain_size_um = [300]
facetness = [0.3]
density_kg_m3 = [300]
angle_deg = [0, \"diffuse\"]
thickness_cm = [1, 10]
wavelength_nm = \"400:700:50\"
water_saturation = [0, 0.2]
impurities_ng_g = { black-carbon = [0, 100] }
";

/// A small table.
const SMALL: &str = "database build --quiet --grain-size 200,400 --facetness 0.2,0.6 --density 300 --thickness 1,5";

/// A small table with few rays through grains.
fn small(rest: &str) -> String {
    format!("{SMALL} --tally-rays 1024 {rest}")
}

#[test]
fn shards_merge_to_the_same_file() {
    let folder = Folder::new();
    folder.stdout(&small("-o whole.nc"));
    for number in 1..=3 {
        folder.stdout(&small(&format!("--shard {number}/3 -o part{number}.nc")));
    }
    folder.stdout("merge part1.nc part2.nc part3.nc -o merged.nc");
    assert!(folder.bytes("whole.nc") == folder.bytes("merged.nc"));
    folder.assert_refused("merge part1.nc part2.nc -o new.nc", &["3", "missing"]);
    folder.assert_refused("merge part1.nc part1.nc -o new.nc", &["part1.nc", "1/3"]);
    folder.assert_refused("merge part1.nc whole.nc -o new.nc", &["whole.nc: is a full table, not a shard"]);
}

/// The message says which command makes a table that can be rendered.
#[test]
fn a_full_table_is_compressed_by_the_command_that_rendering_names() {
    let folder = Folder::new();
    let snow = "--grain-size 200,300,400,500 --facetness 0.3 --preset default";
    folder.stdout(&format!("database build --quiet --tally-rays 1024 -o full.nc {snow}"));
    let render = "render --scene block_30cm --integrator pcasnow --width 4 --height 4 --spp 1 -o a.png --database";
    let refused = format!("{render} full.nc");
    folder.assert_refused(&refused, &["full.nc: is a full table, not a compressed one"]);
    let message = String::from_utf8(folder.run(&refused).stderr).unwrap();
    folder.stdout(&message.trim_end().split_once(": snowblue ").unwrap().1.replace("FILE.nc", "small.nc"));
    folder.stdout(&format!("{render} small.nc"));
}

#[test]
fn axes_come_from_a_file_and_options() {
    let folder = Folder::new();
    folder.write("axes.toml", AXES);
    folder.stdout("database build --axes axes.toml --tally-rays 1024 --temperature=-10,-1 --quiet -o table.nc");
    let expected = [
        "32 curves",
        "  water_saturation: 0 0.2\n",
        "  temperature (degC): -10 -1\n",
        "  black_carbon (ng g-1): 0 100\n",
        "  angle (degree): diffuse 0\n",
        "  wavelength (nm): 400 450 500 550 600 650 700\n",
    ];
    assert_names(&folder.stdout("database info table.nc"), &expected);
}

#[test]
fn components_are_chosen_by_criteria() {
    let folder = Folder::new();
    let log = small("--space log").replace(" --quiet", "");
    let build = |criteria: &str| folder.stderr(&format!("{log} {criteria} -o table.nc"));
    assert_names(&build("--max-delta-e 100 --max-rmse 1"), &["1 components", "log"]);
    let strict = build("--max-delta-e 0.3 --max-rmse 0.002 --illuminant D65,E");
    assert!(strict.contains("3 components") || strict.contains("2 components"), "{strict}");
    folder.assert_refused(&small("--space log --max-rmse 1e-9 -o table.nc"), &["31", "components", "transmittance"]);
}

#[test]
fn monte_carlo_fills_tables_and_its_noise_is_measured() {
    let folder = Folder::new();
    folder.stdout(&format!("{SMALL} --engine montecarlo --rays 500 --angle 0 -o sampled.nc"));
    folder.stdout(&small("--angle 0 -o solved.nc"));
    let text = folder.stdout("database fidelity sampled.nc --truth solved.nc --components 1 --format csv");
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!((rows.len(), &rows[0][13..]), (5, &["worst_rmse_curve", "worst_delta_e_curve"][..]));
    assert!(rows[1][13].contains("µm; facetness"), "{text}");
}

#[test]
fn full_tables_are_compressed_and_exported() {
    let folder = Folder::new();
    let log = "--space log --components 2";
    folder.stdout(&small("-o full.nc"));
    folder.stdout(&small(&format!("{log} -o at_once.nc")));
    let said = folder.stderr(&format!("merge full.nc -o snow.nc {log}"));
    assert_names(&said, &["curves from 1 file, 2 components in log space"]);
    assert!(folder.bytes("snow.nc") == folder.bytes("at_once.nc"));
    folder.assert_refused("merge at_once.nc -o new.nc", &["at_once.nc: is a compressed table, not a shard"]);
    folder.stdout("database export full.nc -o rows.csv");
    let header = "grain_size_um,facetness,density_kg_m3,angle_deg,thickness_cm,wavelength_nm,transmittance,";
    assert!(folder.text("rows.csv").starts_with(header));
}
