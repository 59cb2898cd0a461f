//! `snowblue bake`: files that other renderers read, and what is found only once the light field is solved for.

use crate::shell::{Folder, assert_names};

/// A small cube of snow, a lamp and the sky, with coarse cells of the light field.
const CUBE: &str = "\
[camera]
position = [0, -2, 0.5]
look_at = [0, 0, 0.1]
[environment]
radiance_w_m2_sr = 1
[[light]]
type = \"point\"
position = [0, 1, 0.3]
radiant_intensity_w_sr = 10
[light_field]
step_mm = 50
[material.drift]
type = \"snow\"
grain_size_um = 400
facetness = 0.3
density_kg_m3 = 300
[[object]]
material = \"drift\"
";

const SHAPE: &str = "shape = \"box\"\nsize = [0.2, 0.2, 0.2]\n";

/// A folder with the scene.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("cube.toml", format!("{CUBE}{SHAPE}"));
    folder
}

#[test]
fn a_scene_is_baked_and_is_snow_again() {
    let folder = folder();
    folder.stdout("bake cube.toml --step-mm 50 -o snow.glb");
    assert_eq!(folder.bytes("snow.glb")[..4], *b"glTF");
    folder.stdout("bake cube.toml --step-mm 50 --spectrum --max-bounces 0 -o snow.ply");
    let bytes = folder.bytes("snow.ply");
    let header = String::from_utf8_lossy(&bytes[..bytes.len().min(8000)]).into_owned();
    let names = ["comment lamp_0: point", "max_bounces: 0", "property float lamp_0_400nm", "property float sky_700nm"];
    assert_names(&header, &names);
    folder.write("again.toml", format!("{CUBE}mesh = \"snow.ply\"\n"));
    let objects = folder.stdout("render again.toml --check --format csv");
    assert_names(&objects, &[",snow.ply,yes,yes,"]);
}

#[test]
fn pictures_need_a_camera_and_bakes_do_not() {
    let folder = folder();
    let (_, seen_by_none) = CUBE.split_once("[environment]").unwrap();
    folder.write("bare.toml", format!("[environment]{seen_by_none}{SHAPE}"));
    // The headers have comments of their own.
    let baked = |scene: &str| {
        folder.stdout(&format!("bake {scene}.toml --step-mm 50 -o {scene}.ply"));
        let file = folder.bytes(&format!("{scene}.ply"));
        let header = file.windows(10).position(|part| part == b"end_header").unwrap();
        file[header..].to_vec()
    };
    assert!(baked("bare") == baked("cube"));
    for words in ["render bare.toml -o bare.png", "render bare.toml --check"] {
        folder
            .assert_refused(words, &["bare.toml", "camera is missing, and there is no glTF with a perspective camera"]);
    }
}

#[test]
fn the_cells_of_the_light_field_set_the_default_of_the_vertices() {
    let folder = folder();
    let baked = |step_mm: &str| {
        folder.stdout(&format!("bake cube.toml --field-memory-mib 16 --field-step-mm {step_mm} -o cells.glb"));
        folder.bytes("cells.glb").len()
    };
    assert!(baked("60") < baked("30"));
}

/// 2²⁸ numbers are the most: of 31 wavelengths, 32 lamps and all other light, that is 262400 vertices. With fewer lamps
/// there are as many vertices as the help of the command states.
#[test]
fn too_many_vertices_are_refused() {
    let folder = folder();
    let lamp = "[[light]]\ntype = \"point\"\nposition = [0, 2, 0.3]\nradiant_intensity_w_sr = 10\n";
    folder.write("cube.toml", format!("{CUBE}{SHAPE}{}", lamp.repeat(31)));
    let words = ["262400 vertices", "0.1 mm", "--step-mm"];
    folder.assert_refused("bake cube.toml --spectrum --step-mm 0.1 -o a.ply", &words);
}

#[test]
fn a_lightmap_takes_the_place_of_the_colours() {
    let folder = folder();
    folder.stdout("bake cube.toml --step-mm 100 --lightmap 256 -o snow.glb");
    let bytes = folder.bytes("snow.glb");
    let text = String::from_utf8_lossy(&bytes);
    assert_names(&text, &["TEXCOORD_0", "baseColorTexture", "image/png", "lightmap_texel_m"]);
    assert!(!text.contains("COLOR_0"));
}

#[test]
fn a_lightmap_for_more_parts_than_it_has_texels_is_refused() {
    let folder = folder();
    // A hundred more blocks have 600 faces, each of 5 × 5 texels at least.
    let block = |number: u32| {
        let x = 0.1 * f64::from(number);
        format!(
            "[[object]]\nshape = \"box\"\nsize = [0.06, 0.06, 0.06]\nposition = [{x}, 5, 0.3]\nmaterial = \"drift\"\n"
        )
    };
    let many: String = (0..100).map(block).collect();
    folder.write("cube.toml", format!("{CUBE}{SHAPE}{many}"));
    let words = ["606 parts", "64 × 64 texels", "125 × 125 suffice", "--lightmap"];
    folder.assert_refused("bake cube.toml --step-mm 100 --lightmap 64 --max-bounces 0 -o a.glb", &words);
}

/// The same mesh twice, whose second texture coordinates place both in the same texels.
#[test]
fn second_texture_coordinates_that_overlap_are_refused() {
    let folder = folder();
    folder.stdout("bake cube.toml --step-mm 100 --lightmap 64 --max-bounces 0 -o snow.glb");
    let mut bytes = folder.bytes("snow.glb");
    for start in 0..bytes.len() - 10 {
        if bytes[start..].starts_with(b"TEXCOORD_0") {
            bytes[start + 9] = b'1';
        }
    }
    folder.write("one.glb", &bytes);
    folder.write("other.glb", &bytes);
    let mesh = |name: &str, x: u8| format!("mesh = \"{name}.glb\"\nposition = [{x}, 0, 0]\n");
    let (one, other) = (mesh("one", 0), mesh("other", 1));
    folder.write("twice.toml", format!("{CUBE}{one}[[object]]\nmaterial = \"drift\"\n{other}"));
    let words = ["twice.toml: the second UV set of object \"other.glb\" overlaps that of object \"one.glb\" at u 0."];
    folder.assert_refused("bake twice.toml --step-mm 100 --lightmap 64 --max-bounces 0 -o a.glb", &words);
    folder.write("once.toml", format!("{CUBE}{one}"));
    folder.stdout("bake once.toml --step-mm 100 --lightmap 64 --max-bounces 0 -o once.glb");
}
