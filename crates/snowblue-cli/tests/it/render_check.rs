//! `snowblue render --check`: closed meshes pass, and open snow fails.

use std::fmt::Write;

use crate::shell::Folder;

/// Corners of the outward sides of a cube of 2 m.
const SIDES: [[usize; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

fn corner(bits: usize) -> [i32; 3] {
    [1, 2, 4].map(|bit| if bits & bit == 0 { -1 } else { 1 })
}

fn obj(vertices: &[[f64; 3]], faces: &[Vec<usize>]) -> String {
    let mut text = String::new();
    for [x, y, z] in vertices {
        writeln!(text, "v {x} {y} {z}").unwrap();
    }
    for face in faces {
        let corners: Vec<String> = face.iter().map(|corner| (corner + 1).to_string()).collect();
        writeln!(text, "f {}", corners.join(" ")).unwrap();
    }
    text
}

/// A cube whose sides do not share vertices, as in a mesh with texture seams.
fn cube(sides: usize) -> String {
    let vertices: Vec<_> = SIDES.iter().flatten().map(|&bits| corner(bits).map(f64::from)).collect();
    let faces: Vec<_> = (0..sides).map(|side| (4 * side..4 * side + 4).collect()).collect();
    obj(&vertices, &faces)
}

/// An icosahedron, subdivided twice and projected to a sphere of radius 1 m.
fn icosphere() -> String {
    let golden = 0.5 * (1.0 + 5f64.sqrt());
    let mut vertices: Vec<[f64; 3]> = Vec::new();
    for (a, b) in [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)] {
        vertices.extend([[a, b, 0.0], [0.0, a, b], [b, 0.0, a]]);
    }
    let apart = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>();
    let mut faces = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                let [p, q, r] = [a, b, c].map(|index| &vertices[index]);
                if [apart(p, q), apart(q, r), apart(r, p)].iter().all(|&length| length < 4.5) {
                    let volume = p[0] * (q[1] * r[2] - q[2] * r[1])
                        + p[1] * (q[2] * r[0] - q[0] * r[2])
                        + p[2] * (q[0] * r[1] - q[1] * r[0]);
                    faces.push(if volume > 0.0 { vec![a, b, c] } else { vec![a, c, b] });
                }
            }
        }
    }
    assert_eq!(faces.len(), 20);
    for _ in 0..2 {
        let whole = std::mem::take(&mut faces);
        for face in whole {
            let mut middle = |a: usize, b: usize| {
                // The same sum for both triangles of an edge, so that they get the same vertex.
                let (p, q) = (vertices[a.min(b)], vertices[a.max(b)]);
                vertices.push([p[0] + q[0], p[1] + q[1], p[2] + q[2]]);
                vertices.len() - 1
            };
            let (a, b, c) = (face[0], face[1], face[2]);
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            faces.extend([vec![a, ab, ca], vec![ab, b, bc], vec![ca, bc, c], vec![ab, bc, ca]]);
        }
        for vertex in &mut vertices {
            let length = vertex.iter().map(|x| x * x).sum::<f64>().sqrt();
            *vertex = vertex.map(|x| x / length);
        }
    }
    obj(&vertices, &faces)
}

const CAMERA: &str = "[camera]\nposition = [0, -9, 0]\nlook_at = [0, 0, 0]\n";
const DRIFT: &str = "[material.drift]\ntype = \"snow\"\ngrain_size_um = 400\nfacetness = 0.3\ndensity_kg_m3 = 300\n";
const REST: &str = "[[light]]\ntype = \"point\"\nposition = [0, -5, 0]\nradiant_intensity_w_sr = 10\n\
    [[object]]\nmesh = \"mesh.obj\"\nmaterial = \"drift\"\n";

/// A folder with a mesh and a scene of it.
fn scene(mesh: &str) -> Folder {
    let folder = Folder::new();
    folder.write("mesh.obj", mesh);
    folder.write("scene.toml", format!("{CAMERA}{DRIFT}{REST}"));
    folder
}

/// Exit code, and the values of the first object by column.
fn checked(folder: &Folder) -> (Option<i32>, serde_json::Value) {
    let output = folder.run("render scene.toml --check --format json");
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    (output.status.code(), report["rows"][0].clone())
}

fn number(row: &serde_json::Value, column: &str) -> f64 {
    row[column].as_f64().unwrap()
}

#[test]
fn a_closed_cube_with_duplicate_vertices_passes() {
    let (code, row) = checked(&scene(&cube(6)));
    assert_eq!((code, row["watertight"].as_str()), (Some(0), Some("yes")), "{row}");
    for (column, value) in [("triangles", 12.0), ("size_x_m", 2.0), ("volume_m3", 8.0), ("open_edges", 0.0)] {
        assert!((number(&row, column) - value).abs() < 1e-6, "{column}: {row}");
    }
    assert_eq!((row["triangles"].as_i64(), row["size_x_m"].as_i64()), (Some(12), Some(2)), "whole numbers: {row}");
    assert!((number(&row, "merged_vertices") - 16.0).abs() < 1e-6 && number(&row, "lines") > 3000.0, "{row}");
}

#[test]
fn a_cube_without_a_side_fails_with_four_open_edges() {
    let (code, row) = checked(&scene(&cube(5)));
    assert_eq!(
        (code, row["watertight"].as_str(), row["volume_m3"].as_str()),
        (Some(1), Some("no"), Some("-")),
        "{row}"
    );
    assert!((number(&row, "open_edges") - 4.0).abs() < 1e-6, "{row}");
    // A ray through a cube crosses two of its six sides: one in three crosses the missing one.
    let odd = number(&row, "odd_lines") / number(&row, "lines");
    assert!(odd > 0.25 && odd < 0.45, "{odd}");
}

#[test]
fn integrators_with_a_light_field_refuse_open_snow_and_name_its_holes() {
    let folder = scene(&cube(5));
    for integrator in ["diffusion", "hybrid"] {
        let words = ["scene.toml:", "mesh.obj", "4 open edges", "snowblue repair"];
        folder.assert_refused(&format!("render scene.toml --integrator {integrator} -o a.png"), &words);
    }
}

#[test]
fn snow_of_layers_is_checked_whatever_integrator_the_scene_names() {
    let folder = scene(&cube(5));
    folder.write("pack.toml", "[[layer]]\nthickness_cm = 5\ndensity_kg_m3 = 150\n[[layer]]\nthickness_cm = 20\n");
    for integrator in ["pcasnow", "diffusion", "hybrid", "reference"] {
        for snow in ["layers = \"pack.toml\"", "layers = \"pack.toml\"\nlayers_top = 0.5"] {
            let material = format!("[material.drift]\ntype = \"snow\"\n{snow}\n");
            let integrator = format!("[integrator]\ntype = \"{integrator}\"\n");
            folder.write("scene.toml", format!("{CAMERA}{material}{REST}{integrator}"));
            let report = folder.run("render scene.toml --check --format json");
            let message = String::from_utf8(report.stderr).unwrap();
            assert_eq!(report.status.code(), Some(1), "{message}");
            assert!(message.contains("snow is not watertight") && message.contains("snowblue repair"), "{message}");
        }
    }
}

#[test]
fn an_icosphere_passes_with_almost_the_volume_of_a_ball() {
    let (code, row) = checked(&scene(&icosphere()));
    assert_eq!((code, number(&row, "odd_lines").to_bits()), (Some(0), 0f64.to_bits()), "{row}");
    assert!((number(&row, "triangles") - 320.0).abs() < 1e-6, "{row}");
    let ball = 4.0 / 3.0 * std::f64::consts::PI;
    // 320 flat sides inside the ball have about 3 % less volume.
    let ratio = number(&row, "volume_m3") / ball;
    assert!(ratio > 0.95 && ratio < 1.0, "{ratio}");
}

#[test]
fn a_vertex_that_does_not_exist_is_refused() {
    let folder = scene(&cube(6).replace("f 1 ", "f 99 "));
    folder.assert_refused("render scene.toml --check", &["mesh.obj:25:", "99", "24"]);
}
