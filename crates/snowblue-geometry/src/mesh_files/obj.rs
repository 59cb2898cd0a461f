//! Wavefront OBJ files. Reads `v`, `vt`, `vn`, `f`, `o` and `g`; other keywords are ignored.
//!
//! Faces with more than three corners become triangle fans. A vertex with two texture coordinates or two normals
//! becomes two vertices. Six numbers after `v` are position and colour, stored as the attributes `red`, `green` and
//! `blue`.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fmt::{Display, Write};

use glam::{Vec2, Vec3};
use snowblue_base::files::{FileError, NamedFile};

use crate::mesh_files::coordinates::{check_finite, number};
use crate::triangle_mesh::TriangleMesh;
use crate::vertex_normals::VertexNormals;

const COLOUR: [&str; 3] = ["red", "green", "blue"];

/// Reads a file, or its object or group of a given name.
pub(super) fn read(file: &NamedFile, part: Option<&str>) -> Result<TriangleMesh, FileError> {
    let (path, text) = (&file.path, file.text());
    let mut parser = Parser { in_part: part.is_none(), ..Parser::default() };
    for (number, line) in text.lines().enumerate() {
        parser.line(line, part).map_err(|reason| FileError::Line { path: path.clone(), line: number + 1, reason })?;
    }
    match part {
        Some(part) if !parser.found => Err(FileError::Content {
            path: path.clone(),
            reason: format!("there is no object or group named \"{part}\""),
        }),
        _ => Ok(parser.finish()),
    }
}

/// The positions and triangles of a mesh as a file.
#[must_use]
pub fn obj_text(mesh: &TriangleMesh) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    for Vec3 { x, y, z } in &mesh.positions {
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for triangle in &mesh.indices {
        let [a, b, c] = triangle.map(|vertex| u64::from(vertex) + 1);
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    text
}

/// The state of the parser.
#[derive(Default)]
struct Parser {
    positions: Vec<Vec3>,
    colours: Vec<[f32; 3]>,
    uv: Vec<Vec2>,
    normals: Vec<Vec3>,
    /// Vertex of the mesh for indices of a position, a texture coordinate and a normal.
    vertices: BTreeMap<(usize, Option<usize>, Option<usize>), u32>,
    mesh: TriangleMesh,
    vertex_normals: Vec<Vec3>,
    vertex_colours: Vec<[f32; 3]>,
    /// Whether the current line belongs to the requested part.
    in_part: bool,
    /// Whether the requested part has occurred.
    found: bool,
}

impl Parser {
    fn line(&mut self, line: &str, part: Option<&str>) -> Result<(), String> {
        let line = line.split('#').next().unwrap_or_default();
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let quantity = format_args!("a number of vertex {} (1 is the first)", self.positions.len() + 1);
                self.position(&numbers(words, quantity)?)?;
            }
            Some("vt") => match numbers(words, "a texture coordinate")?[..] {
                [u, v, ..] => self.uv.push(Vec2::new(u, v)),
                [u] => self.uv.push(Vec2::new(u, 0.0)),
                [] => return Err("texture coordinates are missing after `vt`".into()),
            },
            Some("vn") => match numbers(words, "a number of a normal")?[..] {
                [x, y, z] => self.normals.push(Vec3::new(x, y, z)),
                ref numbers => return Err(format!("a normal has {} numbers, but must have 3", numbers.len())),
            },
            Some("f") if self.in_part => self.face(words)?,
            Some("o" | "g") => {
                if let Some(part) = part {
                    self.in_part = words.any(|word| word == part);
                    self.found |= self.in_part;
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn position(&mut self, numbers: &[f32]) -> Result<(), String> {
        let (&[x, y, z, ref more @ ..], 3..=7) = (numbers, numbers.len()) else {
            return Err(format!("a vertex has {} numbers, but must have 3 to 7", numbers.len()));
        };
        let position = Vec3::new(x, y, z);
        check_finite(position, || format!("vertex {} (1 is the first)", self.positions.len() + 1))?;
        self.positions.push(position);
        if let &[.., red, green, blue] = more {
            self.colours.push([red, green, blue]);
        }
        Ok(())
    }

    fn face<'line>(&mut self, words: impl Iterator<Item = &'line str>) -> Result<(), String> {
        let corners = words.map(|word| self.corner(word)).collect::<Result<Vec<_>, _>>()?;
        let [first, rest @ ..] = corners.as_slice() else {
            return Err("a face has no corners, but must have at least 3".into());
        };
        if rest.len() < 2 {
            return Err(format!("a face has {} corners, but must have at least 3", corners.len()));
        }
        self.mesh.indices.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
        Ok(())
    }

    /// The vertex of a face corner such as `7`, `7/3`, `7//5` or `-1/-1/-1`.
    fn corner(&mut self, word: &str) -> Result<u32, String> {
        let mut indices = word.split('/');
        let position = index(indices.next().unwrap_or_default(), self.positions.len(), "vertex")?;
        let uv = match indices.next() {
            None | Some("") => None,
            Some(word) => Some(index(word, self.uv.len(), "texture coordinate")?),
        };
        let normal = match indices.next() {
            None | Some("") => None,
            Some(word) => Some(index(word, self.normals.len(), "normal")?),
        };
        let fresh = u32::try_from(self.mesh.positions.len()).map_err(|_| "there are too many vertices")?;
        let Entry::Vacant(entry) = self.vertices.entry((position, uv, normal)) else {
            return Ok(self.vertices[&(position, uv, normal)]);
        };
        entry.insert(fresh);
        self.mesh.positions.push(self.positions[position]);
        self.mesh.uv.extend(uv.map(|uv| self.uv[uv]));
        self.vertex_normals.extend(normal.map(|normal| self.normals[normal]));
        self.vertex_colours.extend(self.colours.get(position));
        Ok(fresh)
    }

    /// Drops texture coordinates, normals and colours unless every vertex has them.
    fn finish(mut self) -> TriangleMesh {
        let count = self.mesh.positions.len();
        if self.mesh.uv.len() != count {
            self.mesh.uv.clear();
        }
        if self.vertex_normals.len() == count {
            self.mesh.normals = VertexNormals::new(self.vertex_normals);
        }
        if self.vertex_colours.len() == count && self.colours.len() == self.positions.len() {
            for (channel, name) in COLOUR.into_iter().enumerate() {
                let values = self.vertex_colours.iter().map(|colour| colour[channel]).collect();
                self.mesh.attributes.insert(name.to_owned(), values);
            }
        }
        self.mesh
    }
}

fn numbers<'line>(words: impl Iterator<Item = &'line str>, quantity: impl Display + Copy) -> Result<Vec<f32>, String> {
    words.map(|word| number(word, quantity)).collect()
}

/// Converts an OBJ index, which counts from 1 or backwards from -1, to an index that counts from 0.
fn index(word: &str, count: usize, what: &str) -> Result<usize, String> {
    let index: i64 = word.parse().map_err(|_| format!("\"{word}\" is not a {what} index"))?;
    let counted = usize::try_from(index.unsigned_abs()).unwrap_or(usize::MAX);
    match (index, counted) {
        (1.., _) if counted <= count => Ok(counted - 1),
        (..=-1, _) if counted <= count => Ok(count - counted),
        _ => Err(format!("a face refers to {what} {index}, but there are {count} so far (1 is the first)")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: &str = "mtllib a.mtl\no left\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0 # note\nv 1 1 0 0 0 1\nv 0 1 0 1 1 1\n\
        vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\nf 1/1/1 2/2/1 3/3/1 4/4/1\no right\n\
        g inner other\nf -4/1 -3/4 -2/3\n";

    fn read_text(text: &str, part: Option<&str>) -> Result<TriangleMesh, String> {
        let file = NamedFile { path: "mesh.obj".into(), bytes: text.as_bytes().into() };
        read(&file, part).map_err(|error| error.to_string())
    }

    #[test]
    fn reads_polygons_texture_seams_colours_and_negative_indices() {
        let all = read_text(SQUARE, None).unwrap();
        assert_eq!(all.indices.len(), 3);
        assert_eq!(all.positions.len(), 7, "one vertex has two texture coordinates, and three have a normal or none");
        assert!(all.normals.is_empty(), "some vertices have none");
        assert_eq!(all.corners(1), [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0), Vec3::Y]);
        assert_eq!(all.uv[all.indices[2][1] as usize], Vec2::Y);
        assert_eq!(all.attributes["green"][all.indices[2][1] as usize].to_bits(), 1f32.to_bits());
    }

    #[test]
    fn reads_a_part_by_name() {
        let left = read_text(SQUARE, Some("left")).unwrap();
        assert_eq!((left.indices.len(), left.positions.len()), (2, 4));
        assert_eq!(left.normals.at(1, left.indices[1], [0.2, 0.3, 0.5]), Some(Vec3::Z));
        assert_eq!(read_text(SQUARE, Some("other")).unwrap().corners(0)[1], Vec3::X);
        assert!(
            read_text(SQUARE, Some("middle")).unwrap_err().contains("there is no object or group named \"middle\"")
        );
    }

    #[test]
    fn errors_name_the_line() {
        for (right, wrong, line, expected) in [
            ("f 1/1/1", "f 0/1/1", 12, "refers to vertex 0, but there are 4"),
            ("f 1/1/1", "f 1/5/1", 12, "refers to texture coordinate 5"),
            ("f -4/1", "f -5/1", 15, "refers to vertex -5"),
            ("f -4/1 -3/4 -2/3", "f -4/1 -3/4", 15, "a face has 2 corners"),
            ("v 1 1 0 0 0 1", "v 1 1", 5, "a vertex has 2 numbers"),
            ("v 1 1 0 0 0 1", "v 1 nan 0", 5, "coordinate y of vertex 3 (1 is the first) is NaN, but must be finite"),
            ("v 1 1 0 0 0 1", "v 1 1 1e99", 5, "coordinate z of vertex 3 (1 is the first) is inf, but must be finite"),
            ("v 1 1 0 0 0 1", "v 1,5 1 0", 5, "is \"1,5\", but must be a number with a decimal point"),
            ("f 1/1/1", "f 1/1/2", 12, "refers to normal 2, but there are 1"),
            ("vn 0 0 1", "vn 0 1", 11, "a normal has 2 numbers, but must have 3"),
            ("vt 1 1", "vt 1 one", 9, "a texture coordinate is \"one\", but must be a number"),
        ] {
            let message = read_text(&SQUARE.replacen(right, wrong, 1), None).unwrap_err();
            assert!(message.contains(&format!("mesh.obj:{line}: ")) && message.contains(expected), "{message}");
        }
    }
}
