//! Scenes with a mistake: one line that says where and what.

use serde::Deserialize;
use snowblue_base::Count;
use snowblue_render::Integrator;
use snowblue_render::SceneFile;
use snowblue_render::scene::description::SceneDescription;
use snowblue_render::scene::film::{Exposure, FilmSettings};
use snowblue_render::scene::integrator::SamplesPerPixel;
use snowblue_render::scene::{PathMode, Scene};

use crate::snow::prepared;

const SCENE: &str = r#"[camera]
position = [1, -2, 0.5]
look_at = [0, 0, 0]
[film]
exposure = "auto"
[material.drift]
type = "snow"
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
[integrator]
type = "pcasnow"
"#;

/// The keys of its snow, in lines 8 to 10.
const SNOW_KEYS: &str = "grain_size_um = 400\nfacetness = 0.3\ndensity_kg_m3 = 300";

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

fn load(text: &str, mesh: Option<&str>) -> Result<Scene, String> {
    let folder = tempfile::tempdir().unwrap();
    if let Some(content) = mesh {
        std::fs::write(folder.path().join("gone.ply"), content).unwrap();
    }
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, text).unwrap();
    Scene::load(&path).map_err(|error| error.to_string())
}

#[test]
fn the_scene_without_a_mistake_is_read() {
    let scene = load(SCENE, Some(PLY)).unwrap();
    assert_eq!((scene.objects().list().len(), scene.materials().len(), scene.lights().len()), (2, 2, 1));
    assert_eq!((scene.film().width.get(), scene.integrator().max_bounces.get()), (1080, 8));
}

#[test]
fn mistakes_are_named_with_file_line_value_and_range() {
    let cases = [
        ("facetness = 0.3", "facetnes = 0.3", 9, "material.drift.facetnes: unknown field `facetnes`"),
        ("[film]", "[flim]", 4, "unknown key `flim`"),
        ("[film]", "[keyframes]\nsky.turbidity = [2, 4]\n[film]", 4, "unknown key `keyframes`"),
        ("\"auto\"", "\"bright\"", 5, "film.exposure is \"bright\""),
        ("[film]", "[film]\nwidth = 0", 5, "film.width is 0, but must lie in 1–16384"),
        ("[film]", "[film]\ntone = \"hable\"", 5, "tone curve is `hable`, but must be one of filmic, agx, none"),
        ("[film]", "[film]\nwhite = 500", 5, "film.white is 500 K, but must lie in 2000–25000 K"),
        ("[film]", "[film]\nwhite = \"26000K\"", 5, "colour temperature is 26000 K, but must lie in 2000–25000 K"),
        ("[film]", "[film]\nwidth = 1.5", 5, "film.width is 1.5, but must be a whole number"),
        ("look_at = [0, 0, 0]", "look_at = [1, -2, 0.5]", 3, "must not lie at the camera's position"),
        (
            "look_at = [0, 0, 0]",
            "look_at = [0, 0, 0]\naperture = -1",
            4,
            "camera.aperture is -1 m, but must lie in 0–10 m",
        ),
        (
            "look_at = [0, 0, 0]",
            "look_at = [0, 0, 0]\nfocus = 0",
            4,
            "camera.focus is 0 m, but must lie in 0.001–100000 m",
        ),
        (
            "look_at = [0, 0, 0]",
            "look_at = [3, -1, 0.5]\naperture = 4.4",
            4,
            "camera.aperture reaches into the snow of",
        ),
        ("look_at = [0, 0, 0]", "look_at = [0, 0]", 3, "has 2 numbers, but must have 3"),
        ("\"D65\"", "\"D66\"", 17, "D66"),
        ("type = \"point\"", "type = \"torch\"", 15, "light[0].type is \"torch\", but must be one of point, spot"),
        ("size = [1, 1, 1]", "size = [1, 0, 1]", 21, "object[0].size[1] is 0 m"),
        ("material = \"drift\"", "material = \"drfit\"", 22, "but must be one of drift, floor"),
        ("shape = \"box\"\nsize = [1, 1, 1]", "", 19, "either `shape` or `mesh`"),
        ("[camera]", "[camera", 1, ""),
        ("position = [1, -2, 0.5]", "position = [1, -2, 0.5]]", 2, ""),
    ];
    assert_named(&cases);
}

/// Asserts messages on keys of the snow of the scene.
fn assert_named_in_snow(cases: &[(&str, &str)]) {
    for (wrong, expected) in cases {
        let message = load(&SCENE.replacen(SNOW_KEYS, wrong, 1), Some(PLY)).unwrap_err();
        let expected = format!("scene.toml:8: material.drift.{expected}");
        assert!(message.contains(&expected) && !message.contains('\n'), "{wrong}: {message}");
    }
}

#[test]
fn mistakes_on_the_surface_of_snow_are_named_with_file_line_value_and_range() {
    assert_named_in_snow(&[
        ("sparkle = 1", "sparkle must be true, false or a table"),
        ("sparkle = { facet_size_um = 2 }", "sparkle.facet_size_um is 2 µm, but must lie in 5–5000 µm"),
        ("sparkle = { facet_size_um = nan }", "sparkle.facet_size_um is NaN µm, but must lie in 5–5000 µm"),
        (
            "sparkle = { facet_size_um = 401 }",
            "sparkle.facet_size_um is 401 µm, but must be at most 400 µm, the mean size of the grains",
        ),
        ("sparkle = { flat_fraction = 1.5 }", "sparkle.flat_fraction is 1.5, but must lie in 0–1"),
        ("relief = true", "relief must be a kind of snow or a table"),
        ("relief = \"icy\"", "relief is \"icy\", but must be one of fresh, wind-packed, melt-forms"),
        ("relief = { height_mm = 1 }", "relief: missing field `correlation_mm`"),
        ("relief = { height_mm = 40, correlation_mm = 99 }", "relief.height_mm is 40 mm, but must lie in 0.01–30 mm"),
        ("relief = { height_mm = 1, correlation_mm = 1 }", "relief.correlation_mm is 1 mm, but must lie in 2–1000 mm"),
        ("relief = { height_mm = 1, correlation_mm = 9, hurst = nan }", "relief.hurst is NaN, but must lie in 0.1–1"),
        (
            "relief = { height_mm = 5, correlation_mm = 9 }",
            "relief.height_mm is 5 mm, but must be at most 1.76 mm for a correlation_mm of 9 and a hurst of 0.5",
        ),
    ]);
}

#[test]
fn mistakes_in_snow_are_named_with_file_line_value_and_range() {
    let cases = [
        ("density_kg_m3 = 1200", "density_kg_m3 is 1200 kg/m³, but must lie in 10–900 kg/m³"),
        ("density_kg_m3 = nan", "density_kg_m3 is NaN kg/m³, but must lie in 10–900 kg/m³"),
        ("density_kg_m3 = \"300\"", "density_kg_m3: invalid type: string \"300\""),
        ("grain_size_um = 5000", "grain_size_um is 5000 µm, but its range of ± 50 µm must lie in 20–5000 µm"),
        ("grain_size_um = [500, 100]", "grain_size_um has the range 500:100 µm, whose ends are in the wrong order"),
        ("grain_size_um = [1, 2, 3]", "grain_size_um has 3 numbers, but must be a mean (400) or a range (350, 450)"),
        ("grain_size_um = \"fine\"", "grain_size_um must be a number or a list of numbers"),
        ("size_measure = \"radius\"", "size_measure: unknown variant `radius`, expected one of `greatest-extension`"),
        ("snow = \"powder\"", "snow: unknown variant `powder`, expected one of `fresh`, `rounded`, `faceted`"),
        ("ssa_m2_kg = 1000", "ssa_m2_kg is 1000 m²/kg, but must lie in 1.4–300 m²/kg"),
        ("ssa_m2_kg = 20\ngrain_size_um = 400", "ssa_m2_kg cannot be given with a grain size"),
        ("facetness = 2", "facetness is 2, but must lie in 0–1"),
        ("sphericity = 0.1", "sphericity is 0.1, but must lie in 0.5–1"),
        ("water_saturation = 2", "water_saturation is 2, but must lie in 0–1"),
        ("temperature_c = 5", "temperature_c is 5 °C, but must lie in -60–0 °C"),
        ("ice = \"rime\"", "ice: unknown variant `rime`, expected `warren2008` or `picard2016`"),
        (
            "impurities_ng_g = { soot = 5 }",
            "impurities_ng_g: impurity 'soot' is not known; there are black-carbon, black-carbon-coated, saharan-dust",
        ),
        (
            "impurities_ng_g = { black_carbon = -5 }",
            "impurities_ng_g.black_carbon is -5 ng/g, but must lie in 0–10000000 ng/g",
        ),
        (
            "impurities_ng_g = { black-carbon = 5, black_carbon = 5 }",
            "impurities_ng_g: black-carbon is given twice, with a hyphen and with an underscore",
        ),
        (
            "impurities_ng_g = { black-carbon = -5 }",
            "impurities_ng_g.black-carbon is -5 ng/g, but must lie in 0–10000000 ng/g",
        ),
    ];
    assert_named_in_snow(&cases);
    assert_named(&[
        (SNOW_KEYS, "path = \"view\"", 8, "material.drift.path: unknown field `path`"),
        (SNOW_KEYS, "sparkle = { size = 80 }", 8, "material.drift.sparkle.size: unknown field `size`"),
        (
            "type = \"snow\"",
            "type = \"pca_snow\"",
            7,
            "drift.type is \"pca_snow\", but must be one of diffuse, glass, snow",
        ),
    ]);
}

#[test]
fn mistakes_in_a_mask_between_two_snows_are_named_with_file_line_value_and_range() {
    let mask = "mask = { attribute = \"age\" }\n";
    let two = |first: &str, second: &str| format!("{mask}between = [{{ {first} }}, {{ {second} }}]");
    let cases = [
        (mask.to_owned(), 6, " needs both `mask` and `between`"),
        ("between = [{}, {}]".to_owned(), 6, " needs both `mask` and `between`"),
        (format!("{mask}between = [{{}}, {{}}, {{}}]"), 9, "between has 3 snows, but must have two"),
        (format!("{mask}between = 3"), 9, "between must be written as [[material.drift.between]]"),
        (two("", "density_kg_m3 = 3"), 9, "between[1].density_kg_m3 is 3 kg/m³, but must lie in 10–900 kg/m³"),
        (two("impurities_ng_g = { soot = 1 }", ""), 9, "between[0].impurities_ng_g: impurity 'soot' is not known"),
        (two("", "snow = \"fresh\""), 9, "between has two measures of grain size, but must have one"),
        (two("", "ice = \"picard2016\""), 9, "between has two tables of ice, but must have one"),
    ];
    for (wrong, line, expected) in cases {
        let message = load(&SCENE.replacen(SNOW_KEYS, &wrong, 1), Some(PLY)).unwrap_err();
        let dot = if expected.starts_with(' ') { "" } else { "." };
        let expected = format!("scene.toml:{line}: material.drift{dot}{expected}");
        assert!(message.contains(&expected) && !message.contains('\n'), "{wrong}: {message}");
    }
    let unknown = two("", "density = 3");
    let beside = two("", "") + "\ngrain_size_um = [100, 500]";
    let once = two("", "").replace("\"age\"", "\"age\", range = [1, 1]");
    assert_named(&[
        (SNOW_KEYS, &unknown, 9, "material.drift.between[1].density: unknown field `density`"),
        (SNOW_KEYS, &beside, 10, "material.drift.grain_size_um stands beside `mask`: give one of them"),
        (SNOW_KEYS, &once, 8, "material.drift.mask.range is 1 twice, but must have two ends"),
    ]);
}

#[test]
fn mistakes_in_the_settings_of_pcasnow_are_named_with_file_line_value_and_range() {
    let cases = [
        (
            "path = \"shortest\"",
            "integrator.pcasnow.path: unknown variant `shortest`, expected one of `view`, `normal`, `light`, ",
        ),
        ("reflectance = 1.5", "integrator.pcasnow.reflectance is 1.5, but must lie in 0–1"),
        ("paths = 1", "integrator.pcasnow.paths: unknown field `paths`"),
    ];
    for (wrong, expected) in cases {
        let message = load(&format!("{SCENE}[integrator.pcasnow]\n{wrong}\n"), Some(PLY)).unwrap_err();
        assert!(message.contains("scene.toml:29: "), "{wrong}: {message}");
        assert!(message.contains(expected) && !message.contains('\n'), "{wrong}: {message}");
    }
    let scene = load(&format!("{SCENE}[integrator.pcasnow]\ntable = \"gone.nc\"\n"), Some(PLY)).unwrap();
    let message = Integrator::prepare(&scene).unwrap_err().to_string();
    assert!(
        message.starts_with("integrator.pcasnow.table cannot be used: ")
            && message.contains("gone.nc: ")
            && !message.contains('\n'),
        "{message}"
    );
}

#[test]
fn mistakes_in_the_light_field_are_named_with_file_line_value_and_range() {
    assert_named(&[
        (
            "[film]",
            "[light_field]\nmemory_mib = 8\n[film]",
            5,
            "light_field.memory_mib is 8 MiB, but must lie in 16–1048576 MiB",
        ),
        (
            "[film]",
            "[light_field]\nstep_mm = 0\n[film]",
            5,
            "light_field.step_mm is 0 mm, but must lie in 0.01–1000 mm",
        ),
        ("[film]", "[light_field]\nstep = 1\n[film]", 5, "light_field.step: unknown field `step`"),
        ("[film]", "[light_field]\nnodes = 10\n[film]", 5, "light_field.nodes is 10, but must lie in 100–100000000"),
        (
            "[film]",
            "[light_field]\nstep_mm = 5\nnodes = 1000\n[film]",
            6,
            "light_field.nodes has no effect, since `step_mm` sets the cells",
        ),
    ]);
}

#[test]
fn mistakes_in_lights_are_named_with_file_line_value_and_range() {
    assert_named(&[
        (
            "type = \"point\"",
            "type = \"sphere\"",
            18,
            "light[0].radiant_intensity_w_sr: unknown field `radiant_intensity_w_sr`",
        ),
        ("facetness = 0.3", "facetness = .7", 9, "invalid mantissa, expected digits"),
        ("facetness = 0.3", "facetness = 0,7", 9, ""),
        ("size = [1, 1, 1]", "size = [1, .5, 1]", 21, ""),
        ("illuminant = \"D65\"", "spectrum = \"gone.csv\"", 17, "gone.csv does not exist"),
        (
            "illuminant = \"D65\"",
            "illuminant = \"D65\"\nspectrum = \"gone.csv\"",
            18,
            "light[0].spectrum stands beside `illuminant`: give one of them",
        ),
        (
            "illuminant = \"D65\"",
            "temperature_k = 100",
            17,
            "light[0].temperature_k is 100 K, but must lie in 2000–25000 K",
        ),
        ("illuminant = \"D65\"", "color = \"#000000\"", 17, "light[0].color is black, but must be a colour"),
        (
            "illuminant = \"D65\"",
            "illuminant = \"D65\"\ncolor = [1, 0.5, 0.2]",
            18,
            "light[0].color stands beside `illuminant`: give one of them",
        ),
        ("[[object]]", "[environment]\nradiance_w_m2_sr = -1\n[[object]]", 20, "is -1 W/(m² sr), but must lie in 0–"),
        ("[[object]]", "[environment]\n[[object]]", 19, "environment: missing field `radiance_w_m2_sr`"),
        ("[[object]]", "[environment]\nimage = \"sky.exr\"\n[[object]]", 20, "sky.exr does not exist"),
        (
            "[[object]]",
            "[environment]\nradiance_w_m2_sr = 1\nvisible = 1\n[[object]]",
            21,
            "environment.visible: invalid type: integer `1`, expected a boolean",
        ),
    ]);
}

/// Puts each second text in place of the first; the message then has this line and these words.
fn assert_named(cases: &[(&str, &str, usize, &str)]) {
    for (right, wrong, line, expected) in cases {
        let message = load(&SCENE.replacen(right, wrong, 1), Some(PLY)).unwrap_err();
        assert!(message.contains(&format!("scene.toml:{line}: ")), "{wrong}: {message}");
        assert!(message.contains(expected), "{wrong}: {message}");
        assert!(!message.contains('\n'), "{message}");
    }
}

#[test]
fn mistakes_in_shapes_are_named_too() {
    let cases = [
        (
            "shape = \"box\"\nsize = [1, 1, 1]",
            "shape = \"plane\"\nbody = \"all\"",
            21,
            "body joins snow, but a plane has no inside",
        ),
        ("mesh = \"gone.ply\"", "shape = \"cone\"", 24, "must be one of box, sphere, plane, heights"),
        ("mesh = \"gone.ply\"", "shape = \"sphere\"\nradius = 0", 25, "object[1].radius is 0 m, but must lie in"),
        (
            "mesh = \"gone.ply\"",
            "mesh = \"gone.ply\"\nscale = [1, 0, 1]",
            25,
            "object[1].scale[1] is 0, but must lie in",
        ),
        (
            "mesh = \"gone.ply\"",
            "shape = \"heights\"\nsize = [1, 1, 1]\nbottom = 0\nheights = [[1, 2], [1, 0]]",
            26,
            "object[1].bottom is 0 m, but must lie below the least height of 0 m",
        ),
        (
            "mesh = \"gone.ply\"",
            "shape = \"heights\"\nsize = [1, 1, 1]\nbottom = -1\nheights = [[1, 2], [1]]",
            27,
            "a list of lists of numbers, all of one length",
        ),
        ("material = \"floor\"", "material = \"floor\"\nbody = \"a\"", 26, "material \"floor\" is diffuse"),
        ("position = [1, -2, 0.5]", "position = [0.1, 0.2, 0.3]", 2, "camera.position lies inside the snow of \"box\""),
        (
            "mesh = \"gone.ply\"\nmaterial = \"floor\"",
            "shape = \"plane\"\nposition = [0, 0, 5]\nmaterial = \"drift\"",
            2,
            "camera.position lies inside the snow of \"plane\"",
        ),
    ];
    for case in cases {
        check_mistake(case);
    }
}

/// A map of 3 × 2 heights, 10 m apart, as the file that the scene lacks.
const MAP: &str = "ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 10\nnodata_value -1\n5 5 5\n5 5 -1\n";

#[test]
fn mistakes_in_landscapes_are_named() {
    let cases = [
        ("shape = \"heights\"\nfile = \"gone.asc\"", 25, "object[1].file cannot be used: 1 of 6 heights are missing"),
        ("shape = \"heights\"\nfile = \"gone.tif\"", 25, "gone.tif does not exist"),
        ("shape = \"heights\"\nheights = [[1, 2], [1, 2]]\nbottom = 0", 23, "object[1].size is missing"),
        ("shape = \"heights\"", 23, "object[1] needs one of heights, file"),
        (
            "shape = \"heights\"\nfile = \"gone.asc\"\nfill = 5\ncrop = { centre = [50, 10], size = [20, 10] }",
            27,
            "object[1].crop reaches beyond the grid, which covers x = 5 to 25 m and y = 5 to 15 m",
        ),
        (
            "shape = \"heights\"\nfile = \"gone.asc\"\nfill = 5\ncrop = { center = [15, 10], size = [20, 10] }",
            27,
            "object[1].crop.center: unknown field `center`",
        ),
        ("shape = \"heights\"\nfile = \"gone.asc\"\nfill = 5\ntolerance = -1", 27, "object[1].tolerance is -1 m"),
        ("shape = \"snowpack\"\nground = \"gone.asc\"\nfill = 5", 23, "object[1]: missing field `depth`"),
        ("shape = \"snowpack\"\ndepth = 1", 23, "object[1] needs one of ground, heights"),
        ("shape = \"snowpack\"\nground = \"gone.asc\"\nfill = 5\ndepth = -1", 27, "object[1].depth is -1 m"),
        (
            "shape = \"snowpack\"\nground = \"gone.asc\"\nfill = 5\ndepth = { texure = \"a.png\" }",
            27,
            "depth.texure: unknown field `texure`",
        ),
        (
            "shape = \"snowpack\"\nground = \"gone.asc\"\nfill = 5\ndepth = { texture = \"no.png\" }",
            27,
            "no.png does not exist",
        ),
        (
            "shape = \"snowpack\"\nground = \"gone.asc\"\nfill = 5\ndepth = { attribute = \"snow\" }",
            27,
            "object[1].depth is an attribute, but the ground is no mesh",
        ),
        (
            "shape = \"snowpack\"\nground = \"gone.ply\"\ndepth = { attribute = \"snow\" }",
            26,
            "depth.attribute is \"snow\", but gone.ply has only []",
        ),
        (
            "shape = \"snowpack\"\nground = \"gone.ply\"\ndepth = { texture = \"no.png\" }",
            26,
            "depth.texture is \"no.png\", but gone.ply has no texture coordinates",
        ),
        (
            "shape = \"snowpack\"\nground = \"gone.ply\"\ndepth = 1\nfill = 2",
            27,
            "object[1].fill is of heights, but the ground is a mesh",
        ),
        (
            "shape = \"snowpack\"\nground = \"gone.asc\"\npart = \"a\"\ndepth = 1",
            26,
            "object[1].part is of meshes, but the ground is none",
        ),
        (
            "shape = \"snowpack\"\nground = \"gone.asc\"\nslide_deg = 40\ndepth = 1",
            26,
            "object[1].slide_deg is of meshes, but the ground is none",
        ),
    ];
    cases.into_iter().for_each(check_landscape_mistake);
}

#[test]
fn mistakes_in_units_and_marks_of_missing_heights_are_named() {
    let cases = [
        (
            "shape = \"snowpack\"\nground = \"gone.asc\"\nfill = 5\ndepth = { texture = \"gone.asc\" }",
            27,
            "column 3 (1 is the first); `fill` gives a depth for them",
        ),
        (
            "shape = \"snowpack\"\nground = \"gone.asc\"\nfill = 5\ndepth = { attribute = \"snow\", nodata = 1 }",
            27,
            "object[1].depth.nodata is of images, but the depth is an attribute",
        ),
        (
            "shape = \"heights\"\nheights = [[1, -9999], [1, 2]]\nsize = [1, 1, 1]",
            25,
            "object[1].heights cannot be used: 1 of 4 heights are -9999.0, which often marks missing heights",
        ),
        (
            "shape = \"heights\"\nheights = [[1, 2], [1, 2]]\nsize = [1, 1, 1]\nunit = \"ft\"",
            27,
            "object[1].unit is the unit of a map, whose place and unit `size` replaces",
        ),
        ("shape = \"heights\"\nfile = \"gone.asc\"\nunit = \"feet\"", 26, "expected one of `m`, `cm`, `ft`, `us-ft`"),
        (
            "shape = \"heights\"\nfile = \"gone.asc\"\nnodata = 5\nmap_unit = \"cm\"\nunit = \"m\"\n\
             crop = { centre = [0, 0], size = [9, 9] }",
            29,
            "crop reaches beyond the grid, which covers x = 0.05 to 0.25 m and y = 0.0",
        ),
    ];
    cases.into_iter().for_each(check_landscape_mistake);
}

#[test]
fn mistakes_in_prints_are_named() {
    let flat = "shape = \"heights\"\nsize = [1, 1, 1]\nbottom = -1\nheights = [[0, 0], [0, 0]]";
    let hole = "type = \"hole\"\nposition = [0, 0]\nradius = 0.03\ndepth = 0.4\n";
    let cases = [
        ("type = \"pit\"\n".to_owned(), 30, "imprint[0].type is \"pit\", but must be one of hole, footprint"),
        ("position = [0, 0]\n".to_owned(), 29, "object[1].imprint[0].type is missing"),
        (hole.replace("0.03", "3e1"), 32, "imprint[0].radius is 30 m, but must lie in 0.001–10 m"),
        (hole.replace("[0, 0]", "[0, 0.6]"), 31, "imprint[0].position is [0, 0.6], but must lie on the surface"),
        (hole.replace("[0, 0]", "[0]"), 31, "has 1 numbers, but must have 2"),
        (format!("{hole}taper_deg = 5\n"), 34, "taper_deg is 5°, which closes the hole above its depth"),
        (format!("{hole}tread = 0.1\n"), 34, "object[1].imprint[0].tread: unknown field `tread`"),
        ("type = \"footprint\"\nposition = [0, 0]\n".to_owned(), 29, "imprint[0]: missing field `depth`"),
        (
            "type = \"footprint\"\nposition = [0, 0]\ndepth = 0.05\ntread = 0.06\n".to_owned(),
            33,
            "tread is 0.06 m, but must be at most 0.05 m",
        ),
    ];
    let scene = |shape: &str, imprint: &str| {
        let scene = SCENE.replacen("mesh = \"gone.ply\"", shape, 1);
        scene.replacen("[integrator]", &format!("[[object.imprint]]\n{imprint}[integrator]"), 1)
    };
    for (wrong, line, expected) in cases {
        let message = landscape_mistake(&scene(flat, &wrong));
        assert!(message.contains(&format!("scene.toml:{line}: ")), "{wrong}: {message}");
        assert!(message.contains(expected) && !message.contains('\n'), "{wrong}: {message}");
    }
    let message = landscape_mistake(&scene("shape = \"sphere\"\nradius = 1", hole));
    assert!(message.contains("object[1].imprint needs a surface of heights"), "{message}");
}

/// Checks the line and the message of a mistake of a scene in which the mesh is replaced.
fn check_landscape_mistake((wrong, line, expected): (&str, u32, &str)) {
    let message = landscape_mistake(&SCENE.replacen("mesh = \"gone.ply\"", wrong, 1));
    assert!(message.contains(&format!("scene.toml:{line}: ")), "{wrong}: {message}");
    assert!(message.contains(expected) && !message.contains('\n'), "{wrong}: {message}");
}

/// The mistake of a scene beside a map and a mesh.
fn landscape_mistake(text: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("gone.asc"), MAP).unwrap();
    std::fs::write(folder.path().join("gone.ply"), PLY).unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, text).unwrap();
    Scene::load(&path).unwrap_err().to_string()
}

/// A ball of carved snow in place of the mesh, which ends on line 33.
const CARVED: &str = "material = \"floor\"\nshape = \"carved\"\ncell = 0.05\nrounding = 0.1\nrelief = 0.01\n\
    [[object.add]]\ntype = \"ellipsoid\"\ncentre = [0, 0, 0]\nradii = [0.5, 0.5, 0.5]\n\
    [[object.remove]]\ntype = \"capsule\"\nfrom = [0, 0, 0]\nto = [0, 0, 1]\nradius = [0.2, 0.1]\n";

#[test]
fn carved_snow_is_read_and_its_mistakes_are_named() {
    let carved = SCENE.replace("mesh = \"gone.ply\"\nmaterial = \"floor\"\n", CARVED);
    assert!(load(&carved, None).is_ok());
    let cases = [
        ("cell = 0.05\n", "", 23, "object[1]: missing field `cell`"),
        ("cell = 0.05", "cell = 0", 26, "object[1].cell is 0 m, but must lie in 0.0001–1000 m"),
        ("cell = 0.05", "cell = 0.001", 26, "object[1].cell is 0.001 m, but must be at least 0.0013 m for solids of"),
        ("cell = 0.05", "cel = 0.05", 26, "object[1].cel: unknown field `cel`"),
        ("rounding = 0.1", "rounding = -1", 27, "object[1].rounding is -1 m, but must lie in 0–1000 m"),
        ("relief = 0.01", "relief = 0.1", 28, "object[1].relief is 0.1 m, but must be at most 0.075 m"),
        ("relief = 0.01", "relief = 0.01\nrelief_length = 0.08", 29, "is 0.08 m, but must be at least 0.1 m"),
        ("[0.5, 0.5, 0.5]", "[0.5, 0, 0.5]", 32, "object[1].add[0].radii[1] is 0 m, but must lie in"),
        ("[0.5, 0.5, 0.5]", "[0.5, 0.5]", 32, "object[1].add[0].radii has 2 numbers, but must have 3"),
        ("[0.5, 0.5, 0.5]", "[1, 1, 1]\nsize = 1", 33, "object[1].add[0].size: unknown field `size`"),
        ("centre = [0, 0, 0]", "centre = [0, 2000, 0]", 31, "is 2000 m, but must lie in -1000–1000 m"),
        (
            "type = \"ellipsoid\"",
            "type = \"cone\"",
            30,
            "object[1].add[0].type is \"cone\", but must be one of ellipsoid",
        ),
        ("type = \"ellipsoid\"\n", "", 29, "object[1].add[0].type is missing"),
        ("[[object.add]]", "[[object.remove]]", 23, "object[1].add is empty, but must have at least one solid"),
        ("[[object.add]]", "[object.add]", 29, "object[1].add must be written as [[object.add]]"),
        ("to = [0, 0, 1]", "to = [0, 0, 0]", 36, "object[1].remove[0].to must not be the point `from`"),
        (
            "[0.2, 0.1]",
            "\"wide\"",
            37,
            "object[1].remove[0].radius: invalid type: string \"wide\", expected a number or a list of",
        ),
        ("[0.2, 0.1]", "[9, 9]", 23, "object[1] is empty: its solids are removed, rounded away, or smaller"),
        (
            "type = \"ellipsoid\"\ncentre = [0, 0, 0]\nradii = [0.5, 0.5, 0.5]",
            "type = \"half_space\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]",
            30,
            "object[1].add[0].type is \"half_space\", which has no end and can only be removed",
        ),
        (
            "type = \"capsule\"\nfrom = [0, 0, 0]\nto = [0, 0, 1]\nradius = [0.2, 0.1]",
            "type = \"half_space\"\npoint = [0, 0, 0]\nnormal = [0, 0, 0]",
            36,
            "object[1].remove[0].normal is [0, 0, 0], but must not be zero",
        ),
        (
            "type = \"capsule\"\nfrom = [0, 0, 0]\nto = [0, 0, 1]\nradius = [0.2, 0.1]",
            "type = \"box\"\ncentre = [0, 0, 0]\nsize = [1, 1, 0.2]\nedge = 0.2",
            37,
            "object[1].remove[0].edge is 0.2 m, but must be at most 0.1 m",
        ),
        (
            "type = \"capsule\"\nfrom = [0, 0, 0]\nto = [0, 0, 1]\nradius = [0.2, 0.1]",
            "type = \"cylinder\"\nfrom = [0, 0, 0]\nto = [0, 0, 1]\nradius = 0.2\nedge = 0.3",
            38,
            "object[1].remove[0].edge is 0.3 m, but must be at most 0.2 m",
        ),
    ];
    for (right, wrong, line, expected) in cases {
        assert!(carved.contains(right), "{right}");
        let message = load(&carved.replacen(right, wrong, 1), None).unwrap_err();
        assert!(message.contains(&format!("scene.toml:{line}: ")), "{wrong}: {message}");
        assert!(message.contains(expected), "{wrong}: {message}");
        assert!(!message.contains('\n'), "{message}");
    }
}

/// Replaces something right by something wrong, and looks for the line and the words of the complaint.
fn check_mistake((right, wrong, line, expected): (&str, &str, usize, &str)) {
    let message = load(&SCENE.replacen(right, wrong, 1), Some(PLY)).unwrap_err();
    assert!(message.contains(&format!("scene.toml:{line}: ")), "{wrong}: {message}");
    assert!(message.contains(expected), "{wrong}: {message}");
    assert!(!message.contains('\n'), "{message}");
}

#[test]
fn missing_and_broken_meshes_and_scenes_are_named() {
    let missing = load(SCENE, None).unwrap_err();
    assert!(missing.contains("scene.toml:24: ") && missing.contains("gone.ply does not exist"), "{missing}");
    let truncated = load(SCENE, Some(&PLY[..PLY.len() - 12])).unwrap_err();
    assert!(truncated.contains("gone.ply:12: coordinate y of vertex 2 is missing"), "{truncated}");
    let infinite = load(SCENE, Some(&PLY.replacen("0 1 0", "0 inf 0", 1))).unwrap_err();
    assert!(infinite.contains("gone.ply:12: coordinate y of vertex 2 is inf, but must be finite"), "{infinite}");
    let nowhere = Scene::load("no/such/scene.toml").unwrap_err().to_string();
    assert!(nowhere.contains("cannot read no/such/scene.toml"), "{nowhere}");
}

#[test]
fn snow_smaller_than_a_grain_has_a_note() {
    let of = |size: &str, keys: &str| {
        let scene = SCENE.replacen("size = [1, 1, 1]", size, 1).replacen("grain_size_um = 400", keys, 1);
        load(&scene, Some(PLY)).unwrap().notes().to_vec()
    };
    assert_eq!(
        of("size = [1, 0.0003, 1]", "grain_size_um = 400"),
        ["\"box\" is 1000 × 0.3 × 1000 mm, smaller than a grain of its snow, which is 0.4 mm: light is computed \
          as in many grains"]
    );
    assert!(of("size = [0.001, 0.001, 0.001]", "grain_size_um = 400").is_empty());
    assert_eq!(of("size = [0.001, 0.001, 0.001]", "grain_size_um = [1000, 1200]").len(), 1);
    // Two halves of one body are as large as both.
    let body = "material = \"drift\"\nbody = \"pair\"\n";
    let half = |place: &str| format!("shape = \"box\"\nposition = [0, {place}, 0]\nsize = [1, 0.0003, 1]\n{body}");
    let halves = format!("{}[[object]]\n{}", half("0"), half("0.0003"));
    let whole = SCENE.replacen("shape = \"box\"\nsize = [1, 1, 1]\nmaterial = \"drift\"\n", &halves, 1);
    let notes = load(&whole, Some(PLY)).unwrap().notes().to_vec();
    assert!(whole.contains("pair") && notes.is_empty(), "{notes:?}");
}

#[test]
fn bodies_of_snow_that_meet_have_a_note() {
    let of = |keys: &str| {
        let other = format!("[[object]]\nshape = \"box\"\nsize = [1, 1, 1]\n{keys}\n");
        let scene = format!("{SCENE}{other}[material.old]\ntype = \"snow\"\n");
        load(&scene, Some(PLY)).unwrap().notes().to_vec()
    };
    let meet = "\"box\" and \"box\" are bodies of snow that meet, but light does not spread from one into the other: ";
    let note = |remedy: &str| vec![format!("{meet}{remedy}")];
    let on_top = |material: &str| format!("position = [0, 0, 1]\nmaterial = \"{material}\"");
    assert_eq!(of(&on_top("drift")), note("give both the same `body`"));
    assert_eq!(of(&on_top("old")), note("make them `layers` of one snow"));
    assert!(of(&on_top("floor")).is_empty(), "it is no snow");
    assert!(of("position = [0, 0, 1.001]\nmaterial = \"drift\"").is_empty());
}

/// A tetrahedron, and the same without a side.
fn tetrahedron(faces: usize) -> String {
    let header = PLY.split("0 0 0\n").next().unwrap().replace("vertex 3", "vertex 4");
    let header = header.replace("element face 1", &format!("element face {faces}"));
    let sides = ["3 0 2 1\n", "3 0 1 3\n", "3 1 2 3\n", "3 0 3 2\n"];
    format!("{header}0 0 0\n1 0 0\n0 1 0\n0 0 1\n{}", sides[..faces].concat())
}

#[test]
fn open_meshes_of_snow_are_refused_where_a_light_field_needs_closed_ones() {
    let of = |method: &str, material: &str, mesh: &str| {
        let scene = SCENE.replacen("[material.drift]\n", "[light_field]\nstep_mm = 90\n[material.drift]\n", 1);
        let scene = scene.replacen("\"pcasnow\"", &format!("\"{method}\""), 1);
        let scene = scene.replacen("material = \"floor\"", &format!("material = \"{material}\""), 1);
        load(&scene, Some(mesh))
    };
    for method in ["diffusion", "hybrid"] {
        let message = of(method, "drift", &tetrahedron(3)).unwrap_err();
        assert!(message.contains("scene.toml:26: object[1].mesh is \"gone.ply\": it has 3 open edges"), "{message}");
        assert!(message.contains("snowblue repair") && !message.contains('\n'), "{message}");
    }
    assert!(of("diffusion", "floor", &tetrahedron(3)).is_ok(), "paint may be open");
    prepared(&of("diffusion", "drift", &tetrahedron(4)).unwrap(), None);
    prepared(&of("pcasnow", "drift", &tetrahedron(3)).unwrap(), None);
}

#[test]
fn lamps_with_mistakes_are_named() {
    let light = |keys: &str| {
        let (before, after) = (SCENE.split("[[light]]").next().unwrap(), SCENE.split("[[object]]").nth(1).unwrap());
        let integrator = "[integrator]\ntype = \"pcasnow\"\n";
        load(&format!("{before}{keys}[[object]]{after}{integrator}"), Some(PLY)).unwrap_err()
    };
    assert!(light("").ends_with(": light is missing, and there is neither [environment] nor [sky]"));
    for (keys, expected) in [
        ("type = \"directional\"\ndirection = [0, 0, 0]\nirradiance_w_m2 = 1\n", "light[0].direction is [0, 0, 0]"),
        ("type = \"directional\"\ndirection = [0, 0, 1]\n", "light[0]: missing field `irradiance_w_m2`"),
        (
            "type = \"sphere\"\nposition = [0, 0, 1]\nradius = 0\nradiance_w_m2_sr = 1\n",
            "light[0].radius is 0 m, but must lie in 1e-6–100000 m",
        ),
        (
            "type = \"rectangle\"\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nsize = [1, 1]\nradiance_w_m2_sr = 1\n",
            "light[0].look_at must not lie at the light's position or along its up axis",
        ),
        (
            "type = \"rectangle\"\nposition = [0, 0, 1]\nlook_at = [0, 1, 0]\nsize = 1\nradiance_w_m2_sr = 1\n",
            "light[0].size: invalid type: integer `1`, expected a sequence",
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
    let message = load(&text, Some(PLY)).unwrap_err();
    assert!(message.contains("gone.ply: ") && !message.contains('\n'), "{message}");
}

#[test]
fn a_description_can_be_changed() {
    let mut file = SceneFile::parse(SCENE.replace("mesh = \"gone.ply\"", "shape = \"plane\""), "scene.toml").unwrap();
    file.description.film =
        FilmSettings { width: Count::of(7), exposure: Exposure::Stops(2.0), ..file.description.film };
    file.description.integrator.pcasnow.path = PathMode::View;
    let scene = file.build().unwrap();
    assert_eq!((scene.film().width.get(), scene.film().height.get()), (7, 1080));
    assert_eq!(scene.film().exposure, Exposure::Stops(2.0));
    assert_eq!(scene.integrator().pcasnow.path, PathMode::View);
    let error = Count::<SamplesPerPixel>::new(0).unwrap_err();
    assert_eq!(error.to_string(), "samples of a pixel is 0, but must lie in 1–16777216");
}

/// Every shape, light and material that scene files can have.
const EVERYTHING: &str = r##"gltf = "a.glb"
[camera]
position = [1, -2, 0.5]
look_at = [0, 0, 0]
[film]
exposure = -1.5
[integrator]
type = "reference"
seed = 7
[integrator.pcasnow]
path = "normal"
reflectance = 0.5
table = "snow.nc"
[light_field]
memory_mib = 4096
step_mm = 2.5
[material.a]
type = "diffuse"
reflectance_rgb = "#c08040"
[material.b]
type = "diffuse"
texture = "b.png"
[material.c]
type = "snow"
grain_size_um = [100, 500]
size_measure = "optical-diameter"
facetness = 0.3
sphericity = [0.7, 0.9, 0.8, 0.1]
density_kg_m3 = 300
water_saturation = 0.1
impurities_ng_g = { black-carbon = 20, snow-algae = 3 }
temperature_c = -1
ice = "picard2016"
[material.d]
type = "snow"
snow = "fresh"
ssa_m2_kg = 40
[material.e]
type = "snow"
layers = "pack.toml"
layers_top = 0.5
[material.f]
type = "snow"
mask = { attribute = "age", range = [0, 30] }
between = [{ grain_size_um = 100 }, { grain_size_um = 500, water_saturation = 0.2 }]
[material.g]
type = "snow"
mask = { texture = "mask.png", texture_scale_m = 2 }
[[material.g.between]]
snow = "fresh"
[[material.g.between]]
snow = "firn"
[[light]]
type = "point"
position = [0, 0, 1]
radiant_intensity_w_sr = 1
[[light]]
type = "spot"
position = [0, 0, 1]
look_at = [0, 0, 0]
radiant_intensity_w_sr = 1
spectrum = "lamp.csv"
[[light]]
type = "directional"
direction = [0, 0, -1]
irradiance_w_m2 = 1
[[light]]
type = "sphere"
position = [0, 0, 1]
radius = 0.1
radiance_w_m2_sr = 1
visible = false
illuminant = "A"
[[light]]
type = "rectangle"
position = [0, 0, 1]
look_at = [1, 0, 0]
size = [1, 2]
radiance_w_m2_sr = 1
[environment]
image = "sky.exr"
scale = 0.5
[[object]]
shape = "box"
size = [1, 1, 1]
scale = [1, 2, 3]
material = "c"
body = "one"
[[object]]
shape = "sphere"
radius = 1
scale = 2
material = "a"
[[object]]
shape = "plane"
material = "b"
[[object]]
shape = "heights"
size = [1, 1, 1]
bottom = -1
heights = [[0, 1], [2, 3]]
material = "a"
[[object]]
shape = "drift"
size = [3, 2, 0.2]
mounds = [[0, 0, 0.3, 0.5]]
material = "a"
[[object]]
shape = "heights"
file = "map.tif"
crop = { centre = [600000, 5200000], size = [100, 100] }
fill = 1200
tolerance = 0.1
material = "a"
[[object]]
shape = "snowpack"
ground = "map.tif"
depth = { texture = "depth.png", range = [0, 2] }
gap = 0.01
datum = 1000
material = "c"
[[object.imprint]]
type = "hole"
position = [1, 2]
radius = 0.03
depth = 0.4
rim = 0.01
[[object.imprint]]
type = "footprint"
position = [1, 3]
depth = 0.1
foot = "left"
[[object]]
shape = "snowpack"
heights = [[0, 1], [2, 3]]
size = [1, 1, 1]
depth = 0.8
material = "c"
[[object]]
shape = "snowpack"
ground = "ground.obj"
part = "hill"
depth = { attribute = "red" }
material = "c"
[[object]]
shape = "igloo"
courses = 4
material = "a"
[[object]]
shape = "carved"
cell = 0.1
rounding = 0.2
relief = 0.02
relief_length = 0.4
seed = 3
position = [1, 0, 0]
material = "a"
[[object.add]]
type = "ellipsoid"
centre = [0, 0, 0]
radii = [3, 2, 1]
rotation_deg = [0, 0, 30]
[[object.add]]
type = "box"
centre = [1, 0, 0]
size = [1, 1, 1]
rotation_deg = [0, 0, 45]
edge = 0.1
[[object.remove]]
type = "capsule"
from = [0, 0, 0]
to = [3, 0, 0]
radius = [0.5, 0.4]
[[object.remove]]
type = "cylinder"
from = [0, 0, 0]
to = [0, 0, 3]
radius = 0.3
edge = 0.05
[[object.remove]]
type = "half_space"
point = [0, 0, -0.5]
normal = [0, 0, 1]
[[object]]
mesh = "a.obj"
part = "stone"
up = "y"
smooth = false
material = "a"
"##;

#[test]
fn descriptions_survive_being_written_and_read() {
    let file = SceneFile::parse(EVERYTHING, "scene.toml").unwrap();
    let text = file.description.to_toml();
    let again = SceneFile::parse(text.as_str(), "again.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
    assert_eq!(again.description, file.description);
    let value: toml::Table = toml::from_str(&text).unwrap();
    assert_eq!(SceneDescription::deserialize(value).unwrap(), file.description, "by serde");
    let wrong =
        toml::Table::from_iter([("film".to_owned(), toml::Table::from_iter([("wide".to_owned(), 7.into())]).into())]);
    let message = SceneDescription::deserialize(wrong).unwrap_err().to_string();
    assert!(message.contains("film.wide: unknown field `wide`"), "{message}");
}
