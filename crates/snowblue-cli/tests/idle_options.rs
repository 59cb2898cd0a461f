//! An option that is given and has no effect is an error in one line that says why.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use shell::{assert_refused, snowblue, stdout};

#[test]
fn options_without_effect_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let montecarlo = ["spectrum", "--engine", "montecarlo"];
    let cases: Vec<(Vec<String>, &str, &str)> = [
        (&["spectrum"][..], &["--rays", "100"][..], "--engine ordinates"),
        (&["spectrum"], &["--per-wavelength"], "--engine ordinates"),
        (&montecarlo, &["--streams", "auto"], "--engine montecarlo"),
        (&montecarlo, &["--per-wavelength", "--ground-albedo", "0.5"], "each wavelength has its own rays"),
        (&["spectrum", "--grain-size", "300", "--density", "200"], &["--snow", "firn"], "--grain-size and --density"),
        (&["color", "--ssa", "30", "--density", "200"], &["--snow", "fresh"], "--ssa and --density"),
        (&["database", "build", "-o", "t.nc"], &["--rays", "100"], "--engine montecarlo"),
        (
            &["database", "build", "-o", "t.nc", "--engine", "montecarlo"],
            &["--tally-rays", "2048"],
            "--engine ordinates",
        ),
        (&["database", "build", "-o", "t.nc", "--engine", "montecarlo"], &["--streams", "16"], "--engine ordinates"),
        (&["database", "fidelity"], &["--rays", "100"], "--engine montecarlo"),
        (&["database", "fidelity", "none.nc"], &["--seed", "1"], "the table is from a file"),
        (
            &["database", "fidelity", "--off-grid", "5", "--interpolation", "log"],
            &["--density", "300"],
            "the embedded table",
        ),
        (
            &["swatch", "--rows", "grain-size=100,500", "--density", "300", "-o", "s.png"],
            &["--snow", "fresh"],
            "grain size and density",
        ),
        (&["export", "lut", "-o", "t.json"], &["--quantity", "reflectance"], "has both"),
        (&["figures", "-o", "figures", "--only", "water"], &["--truth-samples", "2"], "leaves truth out"),
        (&["bake", "--scene", "block_30cm", "-o", "a.ply"], &["--exposure", "1"], "no preview"),
        (&["render", "--scene", "block_30cm", "-o", "a.exr"], &["--exposure", "1"], "holds light as it is"),
        (&["render", "--scene", "block_30cm", "-o", "a.exr"], &["--tone", "agx"], "holds light as it is"),
        (&["render", "--scene", "block_30cm", "-o", "a.exr"], &["--bloom", "0.1"], "holds light as it is"),
        (&["render", "scene.toml"], &["--print"], "--scene NAME"),
        (&["render", "--scene", "block_30cm", "--check"], &["--spp", "4"], "--check renders no picture"),
        (&["render", "--scene", "block_30cm", "--check"], &["--integrator", "hybrid"], "--check renders no picture"),
        (&["render", "--list-scenes"], &["--width", "4"], "--list-scenes renders no picture"),
        (
            &["render", "--scene", "block_30cm", "--integrator", "reference", "-o", "a.png"],
            &["--field-step-mm", "2"],
            "the integrator reference solves for no light field",
        ),
        (
            &["render", "--scene", "block_30cm", "--path", "view", "-o", "a.png"],
            &["--field-memory-mib", "64"],
            "the integrator pcasnow solves for no light field",
        ),
        (
            &["render", "--scene", "block_30cm", "--integrator", "diffusion", "-o", "a.png"],
            &["--path", "normal"],
            "the integrator diffusion has no path modes",
        ),
    ]
    .into_iter()
    .map(|(command, option, why)| {
        // Outputs lie in the folder.
        let place =
            |word: &&str| if word.contains('.') && !word.starts_with("0.") { at(word) } else { (*word).to_owned() };
        (command.iter().chain(option).map(place).collect(), option[0], why)
    })
    .collect();
    for (arguments, option, why) in cases {
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        assert_refused(&arguments, &[&format!("{option} has no effect: "), why]);
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing was written");
    assert_refused(&["render", "my.toml", "--list-scenes"], &["SCENE has no effect: --list-scenes lists all scenes"]);
}

/// Options that matter are not refused: a kind of snow of which one quantity is left, and the seed of the ordinates.
#[test]
fn options_with_effect_are_taken() {
    let common = ["spectrum", "--wavelengths", "500", "--thickness", "2"];
    let with = |options: &[&str]| stdout(&[&common[..], options].concat());
    assert_ne!(with(&["--snow", "firn", "--density", "300"]), with(&["--density", "300"]));
    assert_ne!(with(&["--snow", "firn", "--grain-size", "400"]), with(&["--grain-size", "400"]));
    assert_ne!(with(&["--seed", "2"]), with(&[]));
    assert!(snowblue(&["render", "--scene", "block_30cm", "--check", "--format", "csv"]).status.success());
    let picture = |integrator: &[&str]| {
        let small = ["--width", "6", "--height", "4", "--spp", "1", "--path", "view", "-o", "-"];
        snowblue(&[&["render", "--scene", "block_30cm"], &small[..], integrator].concat()).stdout
    };
    let by_path_mode = picture(&[]);
    assert!(by_path_mode.starts_with(b"\x89PNG") && by_path_mode == picture(&["--integrator", "pcasnow"]));
}
