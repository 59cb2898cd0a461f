//! `snowblue bake`: files that other renderers read, and errors.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use shell::{assert_names, assert_refused, shipped_scene, snowblue, stdout};

/// The scene of the block with coarse cells of the light field, which saves time.
fn coarse_block(file: &str) {
    let scene = std::fs::read_to_string(shipped_scene("block_30cm.toml")).unwrap();
    std::fs::write(file, format!("{scene}\n[light_field]\nstep_mm = 50\n")).unwrap();
}

#[test]
fn a_scene_of_any_integrator_is_baked() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (glb, ply) = (file("snow.glb"), file("snow.ply"));
    let scene = &*file("block.toml");
    coarse_block(scene);
    stdout(&["bake", scene, "--step-mm", "50", "-o", &glb]);
    assert_eq!(std::fs::read(&glb).unwrap()[..4], *b"glTF");
    stdout(&["bake", scene, "--step-mm", "50", "--spectrum", "--max-bounces", "0", "-o", &ply]);
    let bytes = std::fs::read(&ply).unwrap();
    let header = String::from_utf8_lossy(&bytes[..bytes.len().min(8000)]).into_owned();
    let names = ["comment lamp_0: point", "max_bounces: 0", "property float lamp_0_400nm", "property float sky_700nm"];
    assert_names(&header, &names);
    // The cells of the light field set the default of the vertices.
    let baked = |step_mm: &str| {
        let output = file("cells.glb");
        stdout(&["bake", scene, "--field-memory-mib", "16", "--field-step-mm", step_mm, "-o", &output]);
        std::fs::metadata(output).unwrap().len()
    };
    assert!(baked("60") < baked("30"));
    // What was baked is snow again.
    let text = std::fs::read_to_string(scene).unwrap();
    let place = text.find("shape = \"box\"").unwrap();
    let again = text[place..].replacen("shape = \"box\"", "mesh = \"snow.ply\"", 1);
    let again = again.replacen("size = [0.6, 0.3, 0.6]\nposition = [0.0, 0.0, 0.3]\n", "", 1);
    std::fs::write(file("again.toml"), format!("{}{again}", &text[..place])).unwrap();
    let objects = stdout(&["render", &file("again.toml"), "--check", "--format", "csv"]);
    assert_names(&objects, &[",snow.ply,yes,yes,"]);
}

#[test]
fn what_cannot_be_baked_is_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let scene = &*file("block.toml");
    coarse_block(scene);
    assert_refused(&["bake", scene, "-o", &file("snow.obj")], &["snow.obj", ".glb or .ply"]);
    assert_refused(&["bake", scene, "--spectrum", "-o", &file("snow.glb")], &["snow.glb", "--spectrum", ".ply"]);
    assert_refused(&["bake", scene, "-o", &file("missing/snow.glb")], &["missing/snow.glb", "folder"]);
    assert_refused(&["bake", scene, "--step-mm", "0", "-o", &file("a.glb")], &["0 mm", "0.01–100000 mm"]);
    assert_refused(&["bake", scene, "--field-memory-mib", "8", "-o", &file("a.glb")], &["'8'", "16–1048576"]);
    let many = ["4194304 vertices", "0.1 mm", "--step-mm"];
    assert_refused(&["bake", scene, "--step-mm", "0.1", "-o", &file("a.glb")], &many);
    let bare = "[camera]\nposition = [0, -9, 9]\nlook_at = [0, 0, 0]\n[environment]\nradiance_w_m2_sr = 1\n";
    std::fs::write(file("bare.toml"), bare).unwrap();
    assert_refused(&["bake", &file("bare.toml"), "-o", &file("a.glb")], &["bare.toml", "no snow"]);
    assert!(!snowblue(&["bake", scene]).status.success());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "nothing was written");
}

#[test]
fn a_lightmap_takes_the_place_of_the_colours() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let scene = &*file("block.toml");
    coarse_block(scene);
    let (glb, other) = (file("snow.glb"), file("a.glb"));
    let lightmap = ["bake", scene, "--step-mm", "100", "--lightmap"];
    stdout(&[&lightmap[..], &["256", "-o", &glb]].concat());
    let bytes = std::fs::read(file("snow.glb")).unwrap();
    let text = String::from_utf8_lossy(&bytes);
    assert_names(&text, &["TEXCOORD_0", "baseColorTexture", "image/png", "lightmap_texel_m"]);
    assert!(!text.contains("COLOR_0"));
    assert_refused(&[&lightmap[..], &["63", "-o", &other]].concat(), &["--lightmap", "63", "64–4096"]);
    let ply = file("a.ply");
    assert_refused(&[&lightmap[..], &["256", "-o", &ply]].concat(), &["--lightmap", "a .ply has no preview"]);
    // A hundred blocks have 600 faces, each of 5 × 5 texels at least.
    let scene_text = std::fs::read_to_string(scene).unwrap();
    let block = |number: u32| {
        let x = 0.1 * f64::from(number);
        format!(
            "[[object]]\nshape = \"box\"\nsize = [0.06, 0.06, 0.06]\nposition = [{x}, 5, 0.3]\nmaterial = \"drift\"\n"
        )
    };
    let many: String = (0..100).map(block).collect();
    std::fs::write(scene, format!("{scene_text}{many}")).unwrap();
    let words = ["606 parts", "64 × 64 texels", "128 × 128 suffice", "--lightmap"];
    let coarse = ["64", "--max-bounces", "0", "-o", &other];
    assert_refused(&[&lightmap[..], &coarse].concat(), &words);
}
