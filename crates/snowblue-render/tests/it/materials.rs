//! Diffuse colours, textures and varying snow, each against an equivalent constant material.

use std::f64::consts::PI;
use std::fmt::Write;
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use glam::Vec3A;
use snowblue_color::LinearRgb;
use snowblue_database::{CompressedTable, PcaSnow, TableSample};
use snowblue_render::Integrator;
use snowblue_render::scene::Scene;
use snowblue_render::scene::spectrum::{SAMPLES, Spectrum, wavelengths_nm};

use crate::snow::{self, SAMPLE, analytic_table, pcasnow, prepared, radiance};

/// A scene's folder with its files.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn write(&self, name: &str, content: &str) {
        std::fs::write(self.path().join(name), content).unwrap();
    }

    /// An 8-bit RGB image.
    fn image(&self, name: &str, columns: usize, pixels: &[[u8; 3]]) {
        let file = std::fs::File::create(self.path().join(name)).unwrap();
        let rows = pixels.len() / columns;
        let mut encoder = png::Encoder::new(file, u32::try_from(columns).unwrap(), u32::try_from(rows).unwrap());
        encoder.set_color(png::ColorType::Rgb);
        encoder.write_header().unwrap().write_image_data(pixels.as_flattened()).unwrap();
    }

    /// A 16-bit grey image of one pixel.
    fn grey(&self, name: &str, value: f64) {
        let file = std::fs::File::create(self.path().join(name)).unwrap();
        let mut encoder = png::Encoder::new(file, 1, 1);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(png::BitDepth::Sixteen);
        let code = (value * 65_535.0).round() as u16;
        encoder.write_header().unwrap().write_image_data(&code.to_be_bytes()).unwrap();
    }

    fn load(&self, text: &str) -> Result<Scene, String> {
        let path = self.path().join("scene.toml");
        std::fs::write(&path, format!("{}{text}", snow::CAMERA)).unwrap();
        Scene::load(&path).map_err(|error| error.to_string())
    }

    /// The integrator of a scene, with a table where there is snow.
    fn integrator(&self, text: &str, table: Option<&CompressedTable>) -> Integrator {
        prepared(&self.load(text).unwrap(), table)
    }
}

/// Equal-energy directional light from above and in front.
const SUN: &str =
    "[[light]]\ntype = \"directional\"\ndirection = [0, 0.6, -0.8]\nirradiance_w_m2 = 10\nilluminant = \"E\"\n";

fn diffuse(keys: &str) -> String {
    format!("[material.paint]\ntype = \"diffuse\"\n{keys}\n{SUN}[[object]]\nmaterial = \"paint\"\n")
}

/// The reflectance at a target, seen from above and in front, where `cos` is the cosine of the light.
fn reflectance(integrator: &mut Integrator, target: Vec3A, cos: f64) -> Spectrum {
    let radiance = radiance(integrator, target + Vec3A::new(0.0, -3.0, 4.0), target);
    Spectrum(radiance.0.map(|sample| (f64::from(sample) * PI / (10.0 * cos)) as f32))
}

fn assert_near(found: &Spectrum, expected: &Spectrum, tolerance: f64, what: &str) {
    for (k, (found, expected)) in found.0.iter().zip(expected.0).enumerate() {
        let allowed = tolerance * f64::from(expected.abs().max(1e-6));
        assert!(f64::from((found - expected).abs()) <= allowed, "{what}, sample {k}: {found} for {expected}");
    }
}

#[test]
fn reflectance_files_are_interpolated() {
    let folder = Folder::new();
    folder.write("paint.csv", "wavelength_nm,value\n380,0\n500,0.6\n700,0.2\n");
    let text = diffuse("reflectance_spectrum = \"paint.csv\"") + "shape = \"plane\"\n";
    let found = reflectance(&mut folder.integrator(&text, None), Vec3A::ZERO, 0.8);
    let line = |nm: f64| if nm < 500.0 { 0.6 * (nm - 380.0) / 120.0 } else { 0.6 - 0.4 * (nm - 500.0) / 200.0 };
    assert_near(&found, &Spectrum(wavelengths_nm().map(|nm| line(nm) as f32)), 1e-5, "file");
}

#[test]
fn numbers_are_linear_rgb_and_hexadecimals_are_srgb() {
    let folder = Folder::new();
    let of = |keys: &str| {
        let text = diffuse(keys) + "shape = \"plane\"\n";
        reflectance(&mut folder.integrator(&text, None), Vec3A::ZERO, 0.8)
    };
    assert_near(&of("reflectance_rgb = [0.25, 0.25, 0.25]"), &of("reflectance = 0.25"), 1e-5, "grey");
    // Code 188 is 0.5029 in linear RGB (IEC 61966-2-1), code 255 is 1.
    let linear = of("reflectance_rgb = [0.5029, 1.0, 0]");
    assert_near(&of("reflectance_rgb = \"#bcff00\""), &linear, 1e-4, "hexadecimal");
    assert!(linear.0[14] > 0.99 && linear.0[2] < 0.02, "{linear:?}");
}

/// Red and green above blue and white.
const FOUR: [[u8; 3]; 4] = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255]];

/// The index in [`FOUR`] of a reflectance.
fn nearest(found: &Spectrum) -> usize {
    let [blue, green, red] = [4, 14, 24].map(|k| found.0[k] > 0.5);
    [(true, false, false), (false, true, false), (false, false, true), (true, true, true)]
        .iter()
        .position(|known| *known == (red, green, blue))
        .unwrap_or_else(|| panic!("{found:?}"))
}

#[test]
fn textures_are_upright_on_every_shape() {
    let folder = Folder::new();
    folder.image("four.png", 2, &FOUR);
    let two_triangles = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
        property float z\n\
        property float u\nproperty float v\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
        -1 -1 0 0 0\n1 -1 0 1 0\n1 1 0 1 1\n-1 1 0 0 1\n4 0 1 2 3\n";
    folder.write("sheet.ply", two_triangles);
    let scaled = "texture = \"four.png\"\ntexture_scale_m = 2";
    for (keys, object) in [
        (scaled, "shape = \"plane\""),
        (scaled, "shape = \"box\"\nsize = [2, 2, 2]\nposition = [0, 0, -1]"),
        (scaled, "shape = \"heights\"\nsize = [2, 2, 1]\nheights = [[0, 0], [0, 0]]\nbottom = -1"),
        ("texture = \"four.png\"", "mesh = \"sheet.ply\""),
    ] {
        let mut integrator = folder.integrator(&format!("{}{object}\n", diffuse(keys)), None);
        // The centres of the pixels of a texture 2 m wide, from above.
        for (at, expected) in [([-0.5, 0.5], 0), ([0.5, 0.5], 1), ([-0.5, -0.5], 2), ([0.5, -0.5], 3)] {
            let found = reflectance(&mut integrator, Vec3A::new(at[0], at[1], 0.0), 0.8);
            assert_eq!(nearest(&found), expected, "{object} at {at:?}");
        }
    }
    let text = diffuse("texture = \"four.png\"") + "shape = \"sphere\"\nradius = 1\n";
    let mut sphere = folder.integrator(&text, None);
    // 45° to the left and right of the front, above the centre: the upper half of the texture.
    for (x, strongest) in [(-1.0, 24), (1.0, 14)] {
        let normal = Vec3A::new(x, -1.0, 0.9).normalize();
        let found = radiance(&mut sphere, normal * 3.0, normal);
        for other in [4, 14, 24].into_iter().filter(|k| *k != strongest) {
            assert!(found.0[strongest] > 1.5 * found.0[other], "{x}: {found:?}");
        }
    }
}

/// The analytic table for grains of 100 to 500 µm: extinction is proportional to √(400 µm / grain size).
fn many_grains() -> CompressedTable {
    let mut table = analytic_table();
    table.axes.grain_sizes_um = vec![100.0, 150.0, 200.0, 300.0, 400.0, 500.0];
    let copies = |values: &[f32], scale: &dyn Fn(f64) -> f64| -> Vec<f32> {
        let sizes = &table.axes.grain_sizes_um;
        sizes.iter().flat_map(|size| values.iter().map(|value| (f64::from(*value) * scale(*size)) as f32)).collect()
    };
    table.transmittance.coefficients = copies(&table.transmittance.coefficients, &|size| (400.0 / size).sqrt());
    table.reflectance.coefficients = copies(&table.reflectance.coefficients, &|size| (400.0 / size).sqrt());
    table
}

/// Keys of snow of a grain size, in an inline table.
fn grains(size_um: f64) -> String {
    format!("{{ grain_size_um = {size_um}, facetness = 0.3, density_kg_m3 = 300 }}")
}

/// Keys of snow between 100 µm and 500 µm by a mask.
fn varying(mask: &str) -> String {
    format!("mask = {mask}\nbetween = [{}, {}]", grains(100.0), grains(500.0))
}

/// Keys of snow of one grain size.
fn uniform(size_um: f64) -> String {
    format!("grain_size_um = {size_um}\nfacetness = 0.3\ndensity_kg_m3 = 300")
}

/// Backlit snow with a front at y = −0.1.
fn backlit(keys: &str, object: &str) -> String {
    format!(
        "{}[material.snow]\ntype = \"snow\"\n{keys}\n[[object]]\n{object}\nmaterial = \"snow\"\n\
         [[light]]\ntype = \"directional\"\ndirection = [0, -1, 0]\nirradiance_w_m2 = 10\nilluminant = \"E\"\n\
         [[light]]\ntype = \"directional\"\ndirection = [0, 1, 0]\nirradiance_w_m2 = 0.01\nilluminant = \"E\"\n",
        pcasnow("path = \"normal\"")
    )
}

const SLAB: &str = "shape = \"box\"\nsize = [2, 0.2, 2]";

/// Radiance of a point of the slab's front.
fn at_front(integrator: &mut Integrator, x: f32) -> Spectrum {
    radiance(integrator, Vec3A::new(x, -3.0, 0.1), Vec3A::new(x, -0.1, 0.1))
}

#[test]
fn a_mask_interpolates_between_two_grain_sizes() {
    let (folder, table) = (Folder::new(), many_grains());
    for (mask, grain_size_um, tolerance) in [
        (0.0, 100.0, 1e-6),
        (1.0, 500.0, 1e-6),
        // 0.5 is a node of the curves. The 16 bits of the mask change a ln T of 7 by 2e-5.
        (0.5, 300.0, 1e-4),
        // Between nodes the scattering and absorption coefficients err by at most 1 %.
        (0.37, 248.0, 1e-2),
        (0.0331, 113.24, 1e-2),
    ] {
        folder.grey("age.png", mask);
        let varying = backlit(&varying("{ texture = \"age.png\" }"), SLAB);
        let found = at_front(&mut folder.integrator(&varying, Some(&table)), 0.3);
        let plain = backlit(&uniform(grain_size_um), SLAB);
        let expected = at_front(&mut folder.integrator(&plain, Some(&table)), 0.3);
        assert_near(&found, &expected, tolerance, &format!("mask {mask}"));
    }
    // The expectation itself, for one of them.
    let mut curve = [0.0; SAMPLES];
    let sample = TableSample { grain_size_um: 300.0, ..SAMPLE };
    PcaSnow::new(&table, &sample).unwrap().transmittance(20.0, 0.0, &mut curve);
    assert!((curve[0] / (-20.0 * 0.02 * (4.0f32 / 3.0).sqrt()).exp() - 1.0).abs() < 1e-3);
}

#[test]
fn radiance_is_monotonic_along_a_linear_mask() {
    let (folder, table) = (Folder::new(), many_grains());
    let codes: Vec<[u8; 3]> = (0..256).map(|code| [code as u8; 3]).collect();
    folder.image("ramp.png", 256, &codes);
    let keys = varying("{ texture = \"ramp.png\", texture_scale_m = 2 }");
    let mut integrator = folder.integrator(&backlit(&keys, SLAB), Some(&table));
    let mut before = 0.0;
    for step in 0..199 {
        let x = (step as f32 - 99.0) / 100.0;
        let now = at_front(&mut integrator, x).mean();
        assert!(now > before, "{now} after {before} at {x}");
        before = now;
    }
}

#[test]
fn a_mask_can_be_a_vertex_attribute() {
    let (folder, table) = (Folder::new(), many_grains());
    folder.write("block.ply", &block("age", |x| 15.0 * (x + 1.0)));
    let keys = varying("{ attribute = \"age\", range = [0, 30] }");
    let mut integrator = folder.integrator(&backlit(&keys, "mesh = \"block.ply\""), Some(&table));
    for x in [-0.9f32, -0.31, 0.6] {
        let grain_size_um = 300.0 + 200.0 * f64::from(x);
        let plain = backlit(&uniform(grain_size_um), SLAB);
        let expected = at_front(&mut folder.integrator(&plain, Some(&table)), x);
        assert_near(&at_front(&mut integrator, x), &expected, 1e-2, &format!("x = {x}"));
    }
}

/// The slab as a mesh, with a vertex attribute that depends on x.
fn block(attribute: &str, value: impl Fn(f32) -> f32) -> String {
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n\
         property float {attribute}\nelement face 6\nproperty list uchar int vertex_indices\nend_header\n"
    );
    for corner in 0..8 {
        let [x, y, z] =
            [(0, 1.0), (1, 0.1), (2, 1.0)].map(|(bit, half)| if corner >> bit & 1 == 0 { -half } else { half });
        writeln!(text, "{x} {y} {z} {}", value(x)).unwrap();
    }
    text + "4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n"
}

#[test]
fn two_snow_materials_in_one_scene_are_independent() {
    let (folder, table) = (Folder::new(), many_grains());
    let alone = |size_um| at_front(&mut folder.integrator(&backlit(&uniform(size_um), SLAB), Some(&table)), 0.3);
    let (fine, coarse) = (alone(100.0), alone(500.0));
    let other = format!(
        "[material.coarse]\ntype = \"snow\"\n{}\n[[object]]\nshape = \"box\"\nsize = [2, 0.2, 2]\n\
         position = [5, 0, 0]\nmaterial = \"coarse\"\n",
        uniform(500.0)
    );
    let mut both = folder.integrator(&(backlit(&uniform(100.0), SLAB) + &other), Some(&table));
    assert_near(&at_front(&mut both, 0.3), &fine, 1e-6, "fine");
    // Depths from coordinates of about 5 m have an error of 5e-7 m in 0.2 m, times a ln T of 4.
    assert_near(&at_front(&mut both, 5.3), &coarse, 1e-4, "coarse");
    assert!(coarse.mean() > 1.5 * fine.mean());
}

/// A glTF of one horizontal square with a material and lights. Buffer view 3, the last, holds an image.
fn gltf(material: &str, lights: &str, nodes: &str, image: &[u8]) -> String {
    let mut bytes = Vec::new();
    // In glTF y is up, z is towards the viewer, and texture coordinates count downwards.
    for place in [[-1.0f32, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 0.0, -1.0]] {
        bytes.extend(place.iter().flat_map(|value| value.to_le_bytes()));
    }
    for place in [[0.0f32, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]] {
        bytes.extend(place.iter().flat_map(|value| value.to_le_bytes()));
    }
    bytes.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|index| index.to_le_bytes()));
    bytes.extend(image);
    let data: String = base64(&bytes);
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0{nodes}]}}],
        "extensionsUsed":["KHR_lights_punctual"],"extensions":{{"KHR_lights_punctual":{{"lights":[{lights}]}}}},
        "nodes":[{{"name":"floor","mesh":0}},{{"translation":[0,2,0],"rotation":[-0.70710678,0,0,0.70710678],
        "extensions":{{"KHR_lights_punctual":{{"light":0}}}}}}],
        {material},
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"indices":2,"material":0}}]}}],
        "buffers":[{{"byteLength":{},"uri":"data:application/octet-stream;base64,{data}"}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":32}},
        {{"buffer":0,"byteOffset":80,"byteLength":12}},{{"buffer":0,"byteOffset":92,"byteLength":{}}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[-1,0,-1],"max":[1,0,1]}},
        {{"bufferView":1,"componentType":5126,"count":4,"type":"VEC2"}},
        {{"bufferView":2,"componentType":5123,"count":6,"type":"SCALAR"}}]}}"#,
        bytes.len(),
        image.len()
    )
}

fn base64(bytes: &[u8]) -> String {
    STANDARD.encode(bytes)
}

/// Placeholder where there is no image.
const NO_IMAGE: [u8; 4] = [0; 4];

const LAMP: &str = r#"{"type":"directional","intensity":1}"#;

#[test]
fn base_colours_and_textures_of_a_gltf_are_used() {
    let folder = Folder::new();
    folder.image("four.png", 2, &FOUR);
    let tint = [0.5, 0.25, 1.0];
    let coloured = r#""materials":[{"name":"floor","pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,1,1]}}]"#;
    folder.write("floor.gltf", &gltf(coloured, LAMP, "", &NO_IMAGE));
    let text = |keys: &str| format!("gltf = \"floor.gltf\"\n{}{keys}{SUN}", snow::CAMERA);
    let load = |keys: &str| {
        let path = folder.path().join("whole.toml");
        std::fs::write(&path, text(keys)).unwrap();
        prepared(&Scene::load(&path).unwrap(), None)
    };
    let colour = format!("[material.floor]\ntype = \"diffuse\"\nreflectance_rgb = {tint:?}\n");
    let own = reflectance(&mut load(""), Vec3A::ZERO, 0.8);
    assert_near(&own, &reflectance(&mut load(&colour), Vec3A::ZERO, 0.8), 1e-5, "base colour");
    let green = "[material.floor]\ntype = \"diffuse\"\nreflectance_rgb = [0, 1, 0]\n";
    assert_eq!(nearest(&reflectance(&mut load(green), Vec3A::ZERO, 0.8)), 1, "the scene replaces the material");
    let png = std::fs::read(folder.path().join("four.png")).unwrap();
    // The colours of "four.png" with 8 × 8 pixels each, as libjpeg writes them with quality 75.
    let jpeg = "/9j/4AAQSkZJRgABAQAAAQABAAD/2wBDAAgGBgcGBQgHBwcJCQgKDBQNDAsLDBkSEw8UHRofHh0aHBwgJC4nICIsIxwcKDcpLDAx\
        NDQ0Hyc5PTgyPC4zNDL/2wBDAQkJCQwLDBgNDRgyIRwhMjIyMjIyMjIyMjIyMjIyMjIyMjIyMjIyMjIyMjIyMjIyMjIyMjIyMjIyMjIyMjIyMj\
        L/wAARCAAQABADAREAAhEBAxEB/8QAFgABAQEAAAAAAAAAAAAAAAAABwYI/8QAFBABAAAAAAAAAAAAAAAAAAAAAP/EABcBAAMBAAAAAAAAAAAA\
        AAAAAAYHCAX/xAAUEQEAAAAAAAAAAAAAAAAAAAAA/9oADAMBAAIRAxEAPwCLDJ4koNIvAyvDMbiI5pv/2Q==";
    std::fs::write(folder.path().join("four.jpg"), STANDARD.decode(jpeg).unwrap()).unwrap();
    let uri = format!(r#""uri":"data:image/png;base64,{}""#, base64(&png));
    for image in [r#""uri":"four.png""#, r#""uri":"f%6Fur.jpg""#, &uri, r#""bufferView":3,"mimeType":"image/png""#] {
        folder.write("floor.gltf", &gltf(&textured(image), LAMP, "", &png));
        let mut integrator = load("");
        for (at, expected) in [([-0.5, 0.5], 0), ([0.5, 0.5], 1), ([-0.5, -0.5], 2), ([0.5, -0.5], 3)] {
            let found = reflectance(&mut integrator, Vec3A::new(at[0], at[1], 0.0), 0.8);
            assert_eq!(nearest(&found), expected, "{at:?}");
        }
    }
    // Moved by half the image to the right, and by half downwards.
    let moved = textured(r#""uri":"four.png""#)
        .replace(r#"{"index":0}"#, r#"{"index":0,"extensions":{"KHR_texture_transform":{"offset":[0.5,0.5]}}}"#);
    folder.write("floor.gltf", &gltf(&moved, LAMP, "", &png));
    let mut integrator = load("");
    for (at, expected) in [([-0.5, 0.5], 3), ([0.5, 0.5], 2), ([-0.5, -0.5], 1), ([0.5, -0.5], 0)] {
        assert_eq!(nearest(&reflectance(&mut integrator, Vec3A::new(at[0], at[1], 0.0), 0.8)), expected, "{at:?}");
    }
}

/// A material with a texture.
fn textured(image: &str) -> String {
    format!(
        r#""materials":[{{"name":"floor","pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}],
        "textures":[{{"source":0}}],"images":[{{{image}}}]"#
    )
}

#[test]
fn light_passes_a_gltf_by_its_alpha_and_its_transmission() {
    let folder = Folder::new();
    let path = folder.path().join("whole.toml");
    // Below the square, there is a white plane under the sun.
    let white = "[material.white]\ntype = \"diffuse\"\nreflectance = 1\n\
        [[object]]\nshape = \"plane\"\nposition = [0, 0, -1]\nmaterial = \"white\"\n";
    let passed = |material: &str, keys: &str| {
        let material = format!(r#""materials":[{{"name":"floor",{material}}}]"#);
        folder.write("floor.gltf", &gltf(&material, LAMP, "", &NO_IMAGE));
        std::fs::write(&path, format!("gltf = \"floor.gltf\"\n{}{keys}{white}{SUN}", snow::CAMERA)).unwrap();
        let scene = Scene::load(&path).unwrap();
        let notes = scene.notes().join(" ");
        let mut integrator = prepared(&scene, None);
        let mut lit = |y: f32| radiance(&mut integrator, Vec3A::new(0.0, 0.5, -0.5), Vec3A::new(0.0, y, -1.0)).mean();
        // The lamp of the glTF shines straight down, and is weak beside the sun.
        (lit(0.75) / lit(9.0), notes)
    };
    let factor =
        |rest: &str| format!(r#""pbrMetallicRoughness":{{"metallicFactor":0,"baseColorFactor":[1,1,1,0.25]}}{rest}"#);
    let transmission = |keys: &str| {
        format!(
            r#""pbrMetallicRoughness":{{"metallicFactor":0}},
            "extensions":{{"KHR_materials_transmission":{{{keys}}},"KHR_materials_ior":{{"ior":1.7}}}}"#
        )
    };
    let pane = "[material.floor]\ntype = \"glass\"\nrefractive_index = 1.7\n";
    let (by_pane, _) = passed(&factor(""), pane);
    assert!((0.8..0.9).contains(&by_pane), "{by_pane}");
    for (material, expected) in [
        (factor(""), 0.0),
        (factor(r#","alphaMode":"BLEND""#), 0.75),
        (factor(r#","alphaMode":"MASK""#), 1.0),
        (factor(r#","alphaMode":"MASK","alphaCutoff":0.2"#), 0.0),
        (transmission(r#""transmissionFactor":1"#), by_pane),
        (transmission(r#""transmissionFactor":0.4"#), 0.4),
    ] {
        let (found, notes) = passed(&material, "");
        assert!((found - expected).abs() < 1e-3 && notes.is_empty(), "{material}: {found} for {expected}; {notes}");
    }
    let textured = transmission(r#""transmissionFactor":1,"transmissionTexture":{"index":0}"#)
        + r#"}],"textures":[{"source":0}],"images":[{"bufferView":3,"mimeType":"image/png""#;
    let (found, notes) = passed(&textured, "");
    assert!(found < 1e-3 && notes.contains("\"floor\" blocks light"), "{found}; {notes}");
}

#[test]
fn invalid_base_colours_of_a_gltf_are_errors() {
    let folder = Folder::new();
    let path = folder.path().join("whole.toml");
    std::fs::write(&path, format!("gltf = \"floor.gltf\"\n{}{SUN}", snow::CAMERA)).unwrap();
    let bright = r#""materials":[{"name":"floor","pbrMetallicRoughness":{"baseColorFactor":[2,0,0,1]}}]"#;
    let jpeg = textured(r#""bufferView":3,"mimeType":"image/jpeg""#);
    let missing = textured(r#""uri":"gone.png""#);
    for (material, expected) in [
        (bright, &["floor.gltf: ", "\"floor\"", "2, 0, 0", "0–1"][..]),
        (&jpeg, &["floor.gltf: ", "\"floor\"", "not a readable JPEG file"]),
        (&missing, &["gone.png"]),
    ] {
        folder.write("floor.gltf", &gltf(material, LAMP, "", &[0xff, 0xd8, 0xff, 0xe0]));
        let message = Scene::load(&path).unwrap_err().to_string();
        assert!(expected.iter().all(|part| message.contains(part)) && !message.contains('\n'), "{message}");
    }
}

/// Luminance in cd/m², by ȳ and 683 lm/W.
fn luminance_cd_m2(radiance: &Spectrum) -> f64 {
    let eye = snowblue_color::Observer::Cie1931;
    let samples = wavelengths_nm().into_iter().zip(radiance.0);
    // A band density is the quantity per nm times 310 nm.
    samples.map(|(nm, sample)| 683.0 * eye.color_matching(nm).unwrap().y * f64::from(sample) / 310.0 * 10.0).sum()
}

#[test]
fn lights_of_a_gltf_have_their_photometric_intensity() {
    let folder = Folder::new();
    let white = r#""materials":[{"pbrMetallicRoughness":{"baseColorFactor":[1,1,1,1]}}]"#;
    let orange = LinearRgb { r: 1.0, g: 0.5, b: 0.25 };
    // The light is 2 m above the floor and points down. E in lx is given below it and 1 m beside.
    let beside = |full: f64| full * 0.25 / 1.25f64.powf(1.5);
    let fade = |inner: f64, outer: f64| {
        let cos = 2.0 / 5f64.sqrt();
        ((cos - outer.cos()) / (inner.cos() - outer.cos())).clamp(0.0, 1.0).powi(2)
    };
    for (light, middle, side) in [
        (r#""type":"point","intensity":30"#, 30.0 / 4.0, beside(30.0)),
        (r#""type":"directional","intensity":30"#, 30.0, 30.0),
        (
            r#""type":"spot","intensity":30,"spot":{"innerConeAngle":0.2,"outerConeAngle":0.6}"#,
            30.0 / 4.0,
            beside(30.0) * fade(0.2, 0.6),
        ),
        (r#""type":"spot","intensity":30,"spot":{"innerConeAngle":0.1,"outerConeAngle":0.4}"#, 30.0 / 4.0, 0.0),
        // The edge is hard. One metre beside the middle, the angle is 0.464.
        (r#""type":"spot","intensity":30,"spot":{"innerConeAngle":0.47,"outerConeAngle":0.47}"#, 7.5, beside(30.0)),
        (r#""type":"spot","intensity":30,"spot":{"innerConeAngle":0.46,"outerConeAngle":0.46}"#, 7.5, 0.0),
    ] {
        folder.write("floor.gltf", &gltf(white, &format!(r#"{{{light},"color":[1,0.5,0.25]}}"#), ",1", &NO_IMAGE));
        let path = folder.path().join("whole.toml");
        std::fs::write(&path, format!("gltf = \"floor.gltf\"\n{}", snow::CAMERA)).unwrap();
        let mut integrator = prepared(&Scene::load(&path).unwrap(), None);
        for (x, illuminance_lx) in [(0.0, middle), (0.999_999, side)] {
            let found = luminance_cd_m2(&radiance(&mut integrator, Vec3A::new(x, -3.0, 4.0), Vec3A::new(x, 0.0, 0.0)));
            let expected = orange.luminance() * illuminance_lx / PI;
            // Tolerance: six decimals of the basis, and white restricted to 400–700 nm.
            assert!((found - expected).abs() <= 5e-3 * expected, "{light} at {x}: {found} for {expected}");
        }
    }
}

#[test]
fn black_lights_of_a_gltf_and_properties_that_are_not_read_have_notes() {
    let folder = Folder::new();
    let path = folder.path().join("whole.toml");
    std::fs::write(&path, format!("gltf = \"floor.gltf\"\n{}{SUN}", snow::CAMERA)).unwrap();
    let notes = |material: &str, light: &str| {
        folder.write("floor.gltf", &gltf(&format!(r#""materials":[{material}]"#), light, ",1", &NO_IMAGE));
        let scene = Scene::load(&path).unwrap();
        (scene.lights().len(), scene.notes().join("\n"))
    };
    let plain = r#"{"name":"floor","pbrMetallicRoughness":{"metallicFactor":0}}"#;
    assert_eq!(notes(plain, LAMP), (2, String::new()));
    for black in [r#"{"type":"point","intensity":0}"#, r#"{"type":"point","intensity":9,"color":[0,0,0]}"#] {
        assert_eq!(notes(plain, black), (1, "light \"node 1\" is black and left out".to_owned()));
    }
    let shiny = r#"{"name":"floor","emissiveFactor":[1,0,0],"pbrMetallicRoughness":{"roughnessFactor":0.5}}"#;
    let (_, found) = notes(shiny, r#"{"type":"point","intensity":9,"range":5}"#);
    for what in ["emission is not read of \"floor\"", "gloss is", "metalness is", "\"node 1\" has a range"] {
        assert!(found.contains(what), "{what}: {found}");
    }
}

#[test]
fn invalid_materials_are_errors_with_their_line() {
    let folder = Folder::new();
    folder.image("four.png", 2, &FOUR);
    folder.write("block.ply", &block("age", |x| x));
    folder.write("bright.csv", "400,0.5\n700,1.5\n");
    let wrong = |text: &str| folder.load(text).unwrap_err();
    let paint = |keys: &str, object: &str| wrong(&(diffuse(keys) + object));
    let mask = |mask: &str, object: &str| wrong(&backlit(&varying(mask), object));
    let (plane, mesh) = ("shape = \"plane\"\n", "mesh = \"block.ply\"\n");
    for (message, expected) in [
        (paint("texture = \"gone.png\"", plane), ["scene.toml:13: material.paint.texture", "gone.png does not exist"]),
        (paint("texture = \"block.ply\"", plane), ["block.ply: not a readable PNG", ""]),
        (paint("texture = \"four.png\"", mesh), ["object[0].material is \"paint\"", "texture coordinates"]),
        (paint("reflectance_spectrum = \"bright.csv\"", plane), ["bright.csv:2: value is 1.5", "must lie in 0–1"]),
        (
            paint("reflectance_rgb = [0, 2, 0]", plane),
            ["scene.toml:13: ", "reflectance_rgb[1] is 2, but must lie in 0–1"],
        ),
        (paint("reflectance_rgb = \"#12345\"", plane), ["scene.toml:13: ", "`#12345`"]),
        (
            paint("reflectance = 1\nreflectance_rgb = \"#123456\"", plane),
            ["scene.toml:14: material.paint.reflectance_rgb ", "stands beside `reflectance`"],
        ),
        (
            paint("reflectance = 1\ntexture_scale_m = 1", plane),
            ["scene.toml:14: ", "material.paint.texture_scale_m needs a `texture`"],
        ),
        (paint("", plane), ["scene.toml:11: ", "material.paint needs one of reflectance, "]),
        (mask("{ attribute = \"wet\" }", mesh), ["attribute \"wet\"", "object are: age"]),
        (mask("{ attribute = \"age\" }", SLAB), ["attribute \"age\"", "object are: none"]),
        (mask("{ attribute = \"age\" }", mesh), ["\"age\" is -1", "must lie in 0 to 1"]),
        (mask("{ texture = \"four.png\" }", mesh), ["scene.toml:", "texture coordinates"]),
        (mask("{ texture = \"gone.png\" }", SLAB), ["scene.toml:15: material.snow.mask.texture", "does not exist"]),
    ] {
        assert!(expected.iter().all(|part| message.contains(part)) && !message.contains('\n'), "{message}");
    }
}
