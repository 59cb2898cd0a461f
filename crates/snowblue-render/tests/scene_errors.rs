//! Scenes with a mistake: one line that says where and what.

#![allow(clippy::unwrap_used, clippy::cast_possible_truncation, reason = "tests may panic, and rays are single")]

mod snow;

use snow::simple_law;
use snowblue_render::film::exposure::Exposure;
use snowblue_render::scene::Scene;
use snowblue_render::scene::file::Overrides;
use snowblue_render::scene::material::pca_snow::PathMode;

const SCENE: &str = r#"[camera]
position = [1, -2, 0.5]
look_at = [0, 0, 0]
[film]
exposure = "auto"
[material.drift]
type = "pca_snow"
grain_size_um = 400
facetness = 0.3
density_kg_m3 = 300
[material.floor]
type = "diffuse"
reflectance = 0.5
[[light]]
type = "point"
position = [0, 1.5, 0.6]
illuminant = "D65"
radiant_intensity_w_sr = 40
[[object]]
shape = "box"
size = [1, 1, 1]
material = "drift"
[[object]]
mesh = "gone.ply"
material = "floor"
"#;

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

fn load(text: &str, mesh: Option<&str>, overrides: &Overrides) -> Result<Scene, String> {
    let folder = tempfile::tempdir().unwrap();
    if let Some(content) = mesh {
        std::fs::write(folder.path().join("gone.ply"), content).unwrap();
    }
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, text).unwrap();
    Scene::load(&path, &simple_law(), overrides).map_err(|error| error.to_string())
}

#[test]
fn the_scene_without_a_mistake_is_read() {
    let scene = load(SCENE, Some(PLY), &Overrides::default()).unwrap();
    assert_eq!((scene.objects.list().len(), scene.materials.len(), scene.lights.len()), (2, 2, 1));
    assert_eq!((scene.film.width, scene.integrator.max_bounces), (1080, 8));
}

#[test]
fn mistakes_are_named_with_file_line_value_and_range() {
    let cases = [
        ("facetness = 0.3", "facetnes = 0.3", 9, "unknown key `facetnes`"),
        ("facetness = 0.3\n", "", 6, "material.drift.facetness is missing"),
        (
            "density_kg_m3 = 300",
            "density_kg_m3 = 1200",
            10,
            "density_kg_m3 is 1200 kg/m³, but must lie in 10 to 900 kg/m³",
        ),
        ("grain_size_um = 400", "grain_size_um = 410", 8, "grain size is 410 µm, but the table has only 400 µm"),
        (
            "density_kg_m3 = 300",
            "density_kg_m3 = 300\nwater_saturation = 0.1",
            11,
            "water saturation is 0.1, but the table has no such axis and holds only 0",
        ),
        (
            "density_kg_m3 = 300",
            "density_kg_m3 = 300\nimpurities_ng_g = { black-carbon = 5 }",
            11,
            "black-carbon is 5 ng/g, but the table has no axis of it",
        ),
        (
            "density_kg_m3 = 300",
            "density_kg_m3 = 300\nimpurities_ng_g = { soot = 5 }",
            11,
            "unknown key `soot` in material.drift.impurities_ng_g; known are black-carbon, saharan-dust",
        ),
        ("density_kg_m3 = 300", "density_kg_m3 = \"300\"", 10, "is a text, but must be a number"),
        ("density_kg_m3 = 300", "density_kg_m3 = nan", 10, "is NaN kg/m³"),
        (
            "density_kg_m3 = 300",
            "density_kg_m3 = 300\npath = \"shortest\"",
            11,
            "must be one of brightest, normal, light, view",
        ),
        (
            "density_kg_m3 = 300",
            "density_kg_m3 = 300\nreflectance = 1.5",
            11,
            "reflectance is 1.5, but must lie in 0 to 1",
        ),
        ("[film]", "[flim]", 4, "unknown table `flim`"),
        ("\"auto\"", "\"bright\"", 5, "film.exposure is \"bright\""),
        ("[film]", "[film]\nwidth = 0", 5, "film.width is 0, but must lie in 1–16384"),
        ("[film]", "[film]\nwidth = 1.5", 5, "film.width is a number, but must be a whole number"),
        ("look_at = [0, 0, 0]", "look_at = [1, -2, 0.5]", 3, "must lie off the camera's position"),
        ("look_at = [0, 0, 0]", "look_at = [0, 0]", 3, "must be a list of three numbers"),
        ("\"D65\"", "\"D66\"", 17, "D66"),
        ("type = \"point\"", "type = \"torch\"", 15, "light.type is \"torch\", but must be one of point, spot"),
        ("size = [1, 1, 1]", "size = [1, 0, 1]", 21, "object.size is 0 m"),
        ("material = \"drift\"", "material = \"drfit\"", 22, "but must be one of drift, floor"),
        ("shape = \"box\"\nsize = [1, 1, 1]", "", 19, "either `shape` or `mesh`"),
        ("[camera]", "[camera", 1, ""),
        ("position = [1, -2, 0.5]", "position = [1, -2, 0.5]]", 2, ""),
    ];
    assert_named(&cases);
}

#[test]
fn mistakes_in_lights_are_named_with_file_line_value_and_range() {
    assert_named(&[
        ("type = \"point\"", "type = \"sphere\"", 18, "unknown key `radiant_intensity_w_sr` in light; known are type"),
        ("illuminant = \"D65\"", "spectrum = \"gone.csv\"", 17, "gone.csv does not exist"),
        (
            "illuminant = \"D65\"",
            "illuminant = \"D65\"\nspectrum = \"gone.csv\"",
            18,
            "either `illuminant` or `spectrum`, not both",
        ),
        ("[[object]]", "[environment]\nradiance_w_m2_sr = -1\n[[object]]", 20, "is -1 W/(m² sr), but must lie in 0 to"),
        ("[[object]]", "[environment]\n[[object]]", 19, "environment.radiance_w_m2_sr is missing"),
        ("[[object]]", "[environment]\nimage = \"sky.exr\"\n[[object]]", 20, "sky.exr does not exist"),
        (
            "[[object]]",
            "[environment]\nradiance_w_m2_sr = 1\nvisible = 1\n[[object]]",
            21,
            "environment.visible is a whole number, but must be true or false",
        ),
    ]);
}

/// Puts each second text in place of the first; the message then has this line and these words.
fn assert_named(cases: &[(&str, &str, usize, &str)]) {
    for (right, wrong, line, expected) in cases {
        let message = load(&SCENE.replacen(right, wrong, 1), Some(PLY), &Overrides::default()).unwrap_err();
        assert!(message.contains(&format!("scene.toml:{line}: ")), "{wrong}: {message}");
        assert!(message.contains(expected), "{wrong}: {message}");
        assert!(!message.contains('\n'), "{message}");
    }
}

#[test]
fn mistakes_in_shapes_are_named_too() {
    let cases = [
        ("shape = \"box\"\nsize = [1, 1, 1]", "shape = \"plane\"", 21, "a plane has no inside and cannot be snow"),
        ("mesh = \"gone.ply\"", "shape = \"cone\"", 24, "must be one of box, sphere, plane, heights"),
        ("mesh = \"gone.ply\"", "shape = \"sphere\"\nradius = 0", 25, "object.radius is 0 m, but must lie in"),
        ("mesh = \"gone.ply\"", "mesh = \"gone.ply\"\nscale = [1, 0, 1]", 25, "object.scale is 0, but must lie in"),
        (
            "mesh = \"gone.ply\"",
            "shape = \"heights\"\nsize = [1, 1, 1]\nbottom = 0\nheights = [[1, 2], [1, 0]]",
            26,
            "object.bottom is 0 m, but must lie below the least height of 0 m",
        ),
        (
            "mesh = \"gone.ply\"",
            "shape = \"heights\"\nsize = [1, 1, 1]\nbottom = -1\nheights = [[1, 2], [1]]",
            27,
            "a list of lists of numbers, all of one length",
        ),
        ("material = \"floor\"", "material = \"floor\"\nbody = \"a\"", 26, "material \"floor\" is diffuse"),
        ("position = [1, -2, 0.5]", "position = [0.1, 0.2, 0.3]", 2, "camera.position lies inside the snow of \"box\""),
    ];
    for case in cases {
        check_mistake(case);
    }
}

/// Replaces something right by something wrong, and looks for the line and the words of the complaint.
fn check_mistake((right, wrong, line, expected): (&str, &str, usize, &str)) {
    let message = load(&SCENE.replacen(right, wrong, 1), Some(PLY), &Overrides::default()).unwrap_err();
    assert!(message.contains(&format!("scene.toml:{line}: ")), "{wrong}: {message}");
    assert!(message.contains(expected), "{wrong}: {message}");
    assert!(!message.contains('\n'), "{message}");
}

#[test]
fn missing_and_broken_meshes_and_scenes_are_named() {
    let missing = load(SCENE, None, &Overrides::default()).unwrap_err();
    assert!(missing.contains("scene.toml:24: ") && missing.contains("gone.ply does not exist"), "{missing}");
    let truncated = load(SCENE, Some(&PLY[..PLY.len() - 12]), &Overrides::default()).unwrap_err();
    assert!(truncated.contains("gone.ply:12: not a readable PLY file"), "{truncated}");
    let table = simple_law();
    let nowhere = Scene::load("no/such/scene.toml".as_ref(), &table, &Overrides::default()).unwrap_err().to_string();
    assert!(nowhere.contains("cannot read no/such/scene.toml"), "{nowhere}");
}

#[test]
fn lamps_with_mistakes_are_named() {
    let light = |keys: &str| {
        let (before, after) = (SCENE.split("[[light]]").next().unwrap(), SCENE.split("[[object]]").nth(1).unwrap());
        load(&format!("{before}{keys}[[object]]{after}"), Some(PLY), &Overrides::default()).unwrap_err()
    };
    assert!(light("").ends_with(": the scene has no light: neither [[light]] nor [environment]"));
    for (keys, expected) in [
        ("type = \"directional\"\ndirection = [0, 0, 0]\nirradiance_w_m2 = 1\n", "light.direction is [0, 0, 0]"),
        ("type = \"directional\"\ndirection = [0, 0, 1]\n", "light.irradiance_w_m2 is missing"),
        ("type = \"sphere\"\nposition = [0, 0, 1]\nradius = 0\n", "light.radius is 0 m, but must lie in 0.000001 to"),
        (
            "type = \"rectangle\"\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nsize = [1, 1]\nradiance_w_m2_sr = 1\n",
            "light.look_at must lie off the light's position and up axis",
        ),
        (
            "type = \"rectangle\"\nposition = [0, 0, 1]\nlook_at = [0, 1, 0]\nsize = 1\nradiance_w_m2_sr = 1\n",
            "light.size is a whole number, but must be a list of two numbers",
        ),
    ] {
        let message = light(&format!("[[light]]\n{keys}"));
        assert!(message.contains("scene.toml:") && message.contains(expected), "{message}");
    }
}

#[test]
fn skies_that_are_no_images_are_named() {
    let text = format!("{SCENE}[environment]\nimage = \"gone.ply\"\n")
        .replace("mesh = \"gone.ply\"", "shape = \"box\"\nsize = [1, 1, 1]");
    let message = load(&text, Some(PLY), &Overrides::default()).unwrap_err();
    assert!(message.contains("gone.ply: ") && !message.contains('\n'), "{message}");
}

#[test]
fn overrides_replace_and_are_checked() {
    let overrides = Overrides {
        path: Some(PathMode::View),
        width: Some(7),
        exposure: Some(Exposure::Stops(2.0)),
        ..Overrides::default()
    };
    let scene = load(SCENE, Some(PLY), &overrides).unwrap();
    assert_eq!((scene.film.width, scene.film.height), (7, 1080));
    assert_eq!(scene.film.exposure, Exposure::Stops(2.0));
    let snow = scene.materials.iter().find_map(|material| match material {
        snowblue_render::scene::material::Material::PcaSnow(snow) => Some(snow),
        snowblue_render::scene::material::Material::Diffuse(_) => None,
    });
    assert_eq!(snow.unwrap().path, PathMode::View);
    let none = Overrides { samples_per_pixel: Some(0), ..Overrides::default() };
    let message = load(SCENE, Some(PLY), &none).unwrap_err();
    assert_eq!(message, "samples per pixel is 0, but must lie in 1–16777216");
}
