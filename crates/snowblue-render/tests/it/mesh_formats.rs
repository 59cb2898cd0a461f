//! One mesh in every format, and malformed files.

use std::fmt::Write;
use std::path::Path;

use glam::{Vec2, Vec3, Vec3A};
use snowblue_geometry::mesh_files::{read_mesh_file, stl_bytes};
use snowblue_geometry::ray::Ray;
use snowblue_geometry::triangle_mesh::TriangleMesh;
use snowblue_render::scene::Scene;
use snowblue_render::scene::inspection::inspect;

use crate::snow::{SNOW, directions};

/// An irregular octahedron with texture coordinates, oriented outwards.
fn stone() -> TriangleMesh {
    let positions =
        vec![Vec3::new(0.6, 0.1, 0.0), Vec3::new(-0.5, 0.0, 0.1), Vec3::new(0.0, 0.4, 0.0), Vec3::new(0.1, -0.6, 0.0)]
            .into_iter()
            .chain([Vec3::new(0.0, 0.1, 0.7), Vec3::new(0.05, 0.0, -0.4)])
            .collect::<Vec<_>>();
    let uv = positions.iter().map(|place| Vec2::new(0.5 + place.x * 0.5, 0.25 + place.y * 0.5)).collect();
    let indices = vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    TriangleMesh { positions, indices, uv, ..TriangleMesh::default() }
}

fn ply(mesh: &TriangleMesh) -> Vec<u8> {
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         property float u\n\
         property float v\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.indices.len()
    );
    for (p, uv) in mesh.positions.iter().zip(&mesh.uv) {
        writeln!(text, "{} {} {} {} {}", p.x, p.y, p.z, uv.x, uv.y).unwrap();
    }
    for [a, b, c] in &mesh.indices {
        writeln!(text, "3 {a} {b} {c}").unwrap();
    }
    text.into_bytes()
}

fn obj(mesh: &TriangleMesh) -> Vec<u8> {
    let mut text = String::from("o stone\n");
    for (p, uv) in mesh.positions.iter().zip(&mesh.uv) {
        writeln!(text, "v {} {} {}\nvt {} {}", p.x, p.y, p.z, uv.x, uv.y).unwrap();
    }
    for corners in &mesh.indices {
        let [a, b, c] = corners.map(|corner| corner + 1);
        writeln!(text, "f {a}/{a} {b}/{b} {c}/{c}").unwrap();
    }
    text.into_bytes()
}

/// The mesh with y up, translated by its node, with a camera, a point light and a second instance.
fn glb(mesh: &TriangleMesh) -> Vec<u8> {
    let mut binary = Vec::new();
    // The node translates it by (1, 2, 3).
    for p in &mesh.positions {
        for value in [p.x - 1.0, p.z - 2.0, -p.y - 3.0] {
            binary.extend(value.to_le_bytes());
        }
    }
    for uv in &mesh.uv {
        // In glTF the origin of texture coordinates is the upper left corner.
        binary.extend(uv.x.to_le_bytes().into_iter().chain((1.0 - uv.y).to_le_bytes()));
    }
    for &corner in mesh.indices.iter().flatten() {
        binary.extend(u16::try_from(corner).unwrap().to_le_bytes());
    }
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0,1,2,3]}}],
        "extensionsUsed":["KHR_lights_punctual"],
        "extensions":{{"KHR_lights_punctual":{{"lights":[{{"type":"point","intensity":30,"color":[1,0.5,0.25]}}]}}}},
        "nodes":[{{"name":"stone","mesh":0,"translation":[1,2,3]}},{{"name":"far","mesh":0,"translation":[1,2,-5]}},
        {{"camera":0,"translation":[0,0,4]}},
        {{"name":"lamp","translation":[0,3,0],"extensions":{{"KHR_lights_punctual":{{"light":0}}}}}}],
        "cameras":[{{"type":"perspective","perspective":{{"yfov":0.5,"znear":0.1}}}}],
        "materials":[{{"name":"snow","pbrMetallicRoughness":{{"baseColorFactor":[0.2,0.4,0.6,1]}}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"indices":2,"material":0}}]}}],
        "buffers":[{{"byteLength":{total}}}],
        "bufferViews":[{{"buffer":0,"byteLength":72}},{{"buffer":0,"byteOffset":72,"byteLength":48}},
        {{"buffer":0,"byteOffset":120,"byteLength":48}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":6,"type":"VEC3","min":[-2,-3,-4],"max":[1,1,1]}},
        {{"bufferView":1,"componentType":5126,"count":6,"type":"VEC2"}},
        {{"bufferView":2,"componentType":5123,"count":24,"type":"SCALAR"}}]}}"#,
        total = binary.len()
    );
    let mut json = json.into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + json.len() + 8 + binary.len();
    let word = |value: usize| u32::try_from(value).unwrap().to_le_bytes();
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend(word(total));
    file.extend(word(json.len()).into_iter().chain(*b"JSON"));
    file.extend(json);
    file.extend(word(binary.len()).into_iter().chain(*b"BIN\0"));
    file.extend(binary);
    file
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        folder.write("stone.ply", &ply(&stone()));
        folder.write("stone.obj", &obj(&stone()));
        folder.write("stone.glb", &glb(&stone()));
        folder
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn write(&self, name: &str, content: &[u8]) {
        std::fs::write(self.path().join(name), content).unwrap();
    }

    fn load(&self, text: &str) -> Result<Scene, String> {
        let path = self.path().join("scene.toml");
        std::fs::write(&path, format!("{text}\n[integrator]\ntype = \"pcasnow\"\n")).unwrap();
        Scene::load(&path).map_err(|error| error.to_string())
    }
}

const CAMERA: &str = "[camera]\nposition = [0, -9, 0]\nlook_at = [0, 0, 0]\n\
    [[light]]\ntype = \"point\"\nposition = [0, -5, 0]\nradiant_intensity_w_sr = 10\n";

#[test]
fn every_format_gives_the_same_hits_and_texture_coordinates() {
    let folder = Folder::new();
    let of = |object: &str| folder.load(&format!("{CAMERA}{SNOW}[[object]]\n{object}\nmaterial = \"snow\"\n")).unwrap();
    let from_ply = of("mesh = \"stone.ply\"");
    for other in [
        of("mesh = \"stone.obj\""),
        of("mesh = \"stone.obj\"\npart = \"stone\""),
        of("mesh = \"stone.glb\"\npart = \"stone\""),
        // With z declared as up it lies on its side; a rotation sets it upright.
        of("mesh = \"stone.glb\"\npart = \"stone\"\nup = \"z\"\nrotation_deg = [90, 0, 0]"),
    ] {
        let mut hits = 0;
        for (k, direction) in directions(1000).enumerate() {
            let side = direction.any_orthonormal_vector() * (0.5 * (k % 13) as f32 / 13.0);
            let ray = Ray::new(side - direction * 2.0, direction);
            let (one, two) = (from_ply.objects().first_hit(&ray), other.objects().first_hit(&ray));
            let (Some(one), Some(two)) = (one, two) else {
                assert!(one.is_none() && two.is_none(), "ray {k}");
                continue;
            };
            // Coordinates of up to 4 m in the GLB are rounded by 2.4e-7 m, more at grazing hits.
            assert!((one.point - two.point).length() * one.normal.dot(direction).abs() < 2e-6, "ray {k}");
            // At an edge, rounding decides between two triangles.
            let least = one.location.weights.into_iter().fold(1.0, f32::min);
            assert!(one.location.triangle == two.location.triangle || least < 1e-5, "ray {k}: {least}");
            let (uv, other_uv) = (from_ply.objects().uv(&one).unwrap(), other.objects().uv(&two).unwrap());
            assert!((uv - other_uv).length() * one.normal.dot(direction).abs() < 2e-6, "ray {k}");
            // The texture coordinates are a function of the position.
            assert!((uv - Vec2::new(0.5 + one.point.x * 0.5, 0.25 + one.point.y * 0.5)).length() < 1e-6);
            hits += 1;
        }
        assert!(hits > 500, "{hits}");
    }
}

#[test]
fn snow_from_stl_is_closed_and_has_the_same_hits() {
    let folder = Folder::new();
    folder.write("stone.stl", &stl_bytes(&stone()));
    let of = |file: &str| {
        let object = format!("[[object]]\nmesh = \"{file}\"\nsmooth = false\nmaterial = \"snow\"\n");
        folder.load(&format!("{CAMERA}{SNOW}{object}")).unwrap()
    };
    let (from_ply, from_stl) = (of("stone.ply"), of("stone.stl"));
    let [inspection] = &inspect(&from_stl)[..] else { panic!("one object") };
    assert!(inspection.is_watertight(), "{inspection:?}");
    assert_eq!(inspection.topology.merged_vertices, 0);
    for direction in directions(100) {
        let ray = Ray::new(-2.0 * direction, direction);
        let [one, two] = [&from_ply, &from_stl].map(|scene| scene.objects().first_hit(&ray).unwrap());
        assert_eq!((one.point, one.normal), (two.point, two.normal));
    }
}

/// A triangle with slanted normals, as PLY, OBJ and glTF; the glTF has y up.
fn triangle_with_normals(folder: &Folder) {
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        property float nx\nproperty float ny\nproperty float nz\nelement face 1\n\
        property list uchar int vertex_indices\nend_header\n";
    folder.write("tilted.ply", format!("{header}0 0 0 0 0 2\n1 0 0 1 0 1\n0 1 0 0 0 1\n3 0 1 2\n").as_bytes());
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 2\nvn 1 0 1\nf 1//1 2//2 3//1\n";
    folder.write("tilted.obj", obj.as_bytes());
    // Three positions and three normals as 18 numbers.
    let numbers = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\
        AAAAAAAAAAAAAABAAACAPwAAAAAAAIA/AAAAAAAAAAAAAIA/";
    let gltf = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1}}]}],
        "buffers":[{"byteLength":72,"uri":"data:application/octet-stream;base64,NUMBERS"}],
        "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":36}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
        {"bufferView":1,"componentType":5126,"count":3,"type":"VEC3"}]}"#;
    folder.write("tilted.gltf", gltf.replace("NUMBERS", numbers).as_bytes());
}

#[test]
fn every_format_gives_its_vertex_normals_for_shading_only() {
    let folder = Folder::new();
    triangle_with_normals(&folder);
    let paint = "[material.paint]\ntype = \"diffuse\"\nreflectance = 0.5\n";
    let of = |keys: &str| {
        folder.load(&format!("{CAMERA}{paint}[[object]]\n{keys}\nmaterial = \"paint\"\n")).map(|scene| {
            let ray = Ray::new(Vec3A::new(0.25, 0.25, 1.0), Vec3A::NEG_Z);
            scene.objects().first_hit(&ray).unwrap()
        })
    };
    // A quarter of the weight is at the second vertex.
    let slanted = Vec3A::new(0.5f32.sqrt() * 0.25, 0.0, 0.75 + 0.5f32.sqrt() * 0.25).normalize();
    for file in ["mesh = \"tilted.ply\"", "mesh = \"tilted.obj\"", "mesh = \"tilted.gltf\"\nup = \"z\""] {
        let hit = of(file).unwrap();
        assert!(hit.shading_normal.abs_diff_eq(slanted, 1e-6), "{file}: {}", hit.shading_normal);
        assert_eq!(hit.normal, Vec3A::Z);
        // Normals are not stretched as points are.
        let stretched = of(&format!("{file}\nscale = [2, 1, 3]\nposition = [-0.25, 0, 0]")).unwrap().shading_normal;
        let expected = (slanted / Vec3A::new(2.0, 1.0, 3.0)).normalize();
        assert!(stretched.abs_diff_eq(expected, 1e-6), "{file}: {stretched} {expected}");
        let flat = of(&format!("{file}\nsmooth = false")).unwrap();
        assert_eq!((flat.normal, flat.shading_normal), (Vec3A::Z, Vec3A::Z));
    }
    let wrong = of("mesh = \"tilted.ply\"\nsmooth = 1").unwrap_err();
    assert!(
        wrong.contains("scene.toml:13: object[0].smooth: invalid type: integer `1`, expected a boolean"),
        "{wrong}"
    );
}

#[test]
fn a_gltf_scene_has_its_meshes_camera_and_materials() {
    let folder = Folder::new();
    let light = "[[light]]\ntype = \"point\"\nposition = [0, -5, 0]\nradiant_intensity_w_sr = 10\n";
    let scene = folder.load(&format!("gltf = \"stone.glb\"\n{SNOW}{light}")).unwrap();
    let names: Vec<_> = scene.objects().list().iter().map(|object| object.name.as_str()).collect();
    assert_eq!(names, ["stone", "far"]);
    assert_eq!(scene.materials().len(), 1, "the scene replaces the snow of the glTF");
    // The camera is at z = 4 in the glTF, y = −4 in the scene, and faces the stone. The second instance is behind it.
    let camera = scene.camera().unwrap();
    let ahead = camera.ray(0.5, 0.5);
    assert!((ahead.origin - Vec3A::new(0.0, -4.0, 0.0)).length() < 1e-6);
    assert!((ahead.direction - Vec3A::Y).length() < 1e-6);
    assert!((camera.ray(0.5, 0.0).direction.angle_between(ahead.direction) - 0.25).abs() < 1e-5);
    assert_eq!(scene.objects().first_hit(&ahead).unwrap().object, 0);
    let back = Ray::new(Vec3A::new(0.0, 20.0, 0.0), Vec3A::NEG_Y);
    assert_eq!(scene.objects().first_hit(&back).unwrap().object, 1);
    // Without a material in the scene that of the glTF is used.
    let plain = folder.load(&format!("gltf = \"stone.glb\"\n{light}")).unwrap();
    assert_eq!(plain.materials().len(), 1);
    let none = folder.load(&format!("gltf = \"gone.glb\"\n{light}")).unwrap_err();
    assert!(none.contains("scene.toml:1: ") && none.contains("gone.glb"), "{none}");
}

#[test]
fn a_truncated_glb_is_an_error_in_one_line() {
    let folder = Folder::new();
    let whole = glb(&stone());
    for length in (0..whole.len()).step_by(7).chain([whole.len() - 1]) {
        folder.write("cut.glb", &whole[..length]);
        let message = read_mesh_file(&folder.path().join("cut.glb"), None).unwrap_err().to_string();
        assert!(message.contains("cut.glb: ") && !message.contains('\n'), "{length}: {message}");
    }
}

#[test]
fn malformed_meshes_are_errors_in_one_line() {
    let folder = Folder::new();
    let broken = |from: &str, to: &str| {
        let text = glb(&stone());
        let at = text.windows(from.len()).position(|part| part == from.as_bytes()).unwrap();
        assert_eq!(from.len(), to.len());
        let mut changed = text.clone();
        changed[at..at + to.len()].copy_from_slice(to.as_bytes());
        folder.write("broken.glb", &changed);
        read_mesh_file(&folder.path().join("broken.glb"), None).unwrap_err().to_string()
    };
    for (from, to, expected) in [
        (r#""count":24"#, r#""count":99"#, "accessor 2"),
        (r#""count":6,"type":"VEC3""#, r#""count":2,"type":"VEC3""#, "refers to vertex"),
        (r#""byteOffset":120"#, r#""byteOffset":920"#, "accessor 2"),
        (r#""indices":2"#, r#""indices":7"#, "not a readable glTF file"),
        (r#""scene":0,"#, r#""scene":9,"#, "not a readable glTF file"),
    ] {
        let message = broken(from, to);
        assert!(message.contains(expected) && message.contains("broken.glb: "), "{message}");
        assert!(!message.contains('\n'), "{message}");
    }
    folder.write("stone.3ds", b"MM");
    let message = read_mesh_file(&folder.path().join("stone.3ds"), None).unwrap_err().to_string();
    assert!(message.contains("\"3ds\", but must be ply, obj, stl, gltf or glb"), "{message}");
    let message = read_mesh_file(&folder.path().join("stone.glb"), Some("tree")).unwrap_err().to_string();
    assert!(message.contains("\"tree\""), "{message}");
}

#[test]
fn a_camera_inside_snow_is_an_error_with_its_line() {
    let folder = Folder::new();
    let text = |position: &str| {
        format!(
            "[camera]\nposition = {position}\nlook_at = [9, 9, 9]\n{SNOW}[[object]]\nmesh = \"stone.obj\"\n\
             material = \"snow\"\n[[light]]\ntype = \"point\"\nposition = [0, -5, 0]\nradiant_intensity_w_sr = 10\n"
        )
    };
    let message = folder.load(&text("[0.1, 0, 0.1]")).unwrap_err();
    assert!(message.contains("scene.toml:2: camera.position") && message.contains("\"stone.obj\""), "{message}");
    assert!(folder.load(&text("[0.6, 0.4, 0.1]")).is_ok());
}
