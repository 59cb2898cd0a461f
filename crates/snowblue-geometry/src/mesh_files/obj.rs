//! Wavefront OBJ files (Wavefront 1992, "Object Files (.obj)", appendix B1 of the Advanced Visualizer manual). Reads
//! `v`, `vt`, `vn`, `f` (in old files `fo`), `o`, `g` and `usemtl`. Refuses surfaces that are not polygons, and content
//! in other files. Ignores smoothing groups and the files of materials. All other statements have a note.
//!
//! A face with a corner that has no `vn` has the normal of its plane, if other faces have `vn`.
//!
//! A line that ends with `\` continues on the next line. A vertex with two texture coordinates or two normals becomes
//! two vertices. Six numbers after `v` are position and colour, stored as the attributes `red`, `green` and `blue`.

use std::borrow::Cow;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::{Display, Write};
use std::str::FromStr;

use glam::{DVec3, Vec2, Vec3};
use snowblue_base::files::{FileError, NamedFile, first_names};
use snowblue_base::narrow;

use crate::mesh_files::coordinates::{check_finite, number};
use crate::mesh_files::faces::Faces;
use crate::mesh_files::read_mesh::ReadMesh;
use crate::transform::origin_near;
use crate::triangle_mesh::TriangleMesh;
use crate::vertex_normals::VertexNormals;

const COLOUR: [&str; 3] = ["red", "green", "blue"];

/// Greatest number of letters of an unknown keyword in a note.
const MAX_SHOWN: usize = 24;
/// Statements that change no shape: names, smoothing groups, materials, and levels of detail.
const WITHOUT_SHAPE: [&str; 9] = ["o", "g", "s", "mg", "usemtl", "mtllib", "usemap", "maplib", "lod"];

/// Reads a file, or its part of a given name.
pub(super) fn read(file: &NamedFile, part: Option<&str>) -> Result<ReadMesh, FileError> {
    let (path, text) = (&file.path, file.text());
    let naming =
        part.map(|part| Naming::of(&text, part).map_err(|reason| FileError::Content { path: path.clone(), reason }));
    let naming = naming.transpose()?;
    let mut parser = Parser { in_part: part.is_none(), ..Parser::default() };
    for (line, content) in lines(&text) {
        parser.line(&content, naming).map_err(|reason| FileError::Line { path: path.clone(), line, reason })?;
    }
    Ok(parser.finish())
}

/// The lines of a text with their numbers from 1. Lines joined by `\` have the number of the first of them. A `\` in a
/// comment joins no lines.
fn lines(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut physical = (1..).zip(text.lines());
    std::iter::from_fn(move || {
        let (number, mut end) = physical.next()?;
        let mut line = Cow::Borrowed(end);
        while let Some(begin) = end.trim_end().strip_suffix('\\')
            && !end.contains('#')
        {
            let kept = line.len() - (end.len() - begin.len());
            end = physical.next().map_or("", |(_, next)| next);
            let joined = line.to_mut();
            joined.truncate(kept);
            joined.extend([" ", end]);
        }
        Some((number, line))
    })
}

/// The keyword of a line, and its words as a name. A comment, which begins with `#` between spaces, is no part of it.
fn statement(line: &str) -> (&str, &str) {
    let line = line.trim();
    let (keyword, words) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    (keyword, words.split(" # ").next().unwrap_or_default().trim())
}

/// The statements that begin a part of a given name.
#[derive(Clone, Copy)]
struct Naming<'part> {
    part: &'part str,
    /// The keyword of the statements.
    keyword: &'static str,
    /// Whether the words of a statement are names of several groups.
    of_several: bool,
}

impl<'part> Naming<'part> {
    /// The first of these statements that has the name: an object, a group, one of several groups, a material.
    fn of(text: &str, part: &'part str) -> Result<Self, String> {
        let all = [("o", false), ("g", false), ("g", true), ("usemtl", false)];
        let all = all.map(|(keyword, of_several)| Self { part, keyword, of_several });
        let mut found = [false; 4];
        let mut names = BTreeSet::new();
        for (_, line) in lines(text) {
            let (keyword, name) = statement(&line);
            all.iter().zip(&mut found).for_each(|(naming, found)| *found |= naming.fits(keyword, name) == Some(true));
            if all.iter().any(|naming| naming.keyword == keyword) {
                names.insert(format!("\"{name}\""));
            }
        }
        let naming = all.into_iter().zip(found).find(|(_, found)| *found);
        naming.map(|(naming, _)| naming).ok_or_else(|| {
            let names = first_names(&Vec::from_iter(names.iter().cloned()), names.len());
            let some = if names.is_empty() { "it has no names".into() } else { format!("names in it are {names}") };
            format!("there is no object, group or material named \"{part}\": {some}")
        })
    }

    /// Whether the part begins with a statement; none if it neither begins nor ends.
    fn fits(self, keyword: &str, name: &str) -> Option<bool> {
        let is_named = || name == self.part || self.of_several && name.split_whitespace().any(|word| word == self.part);
        (keyword == self.keyword).then(is_named)
    }
}

/// The positions and triangles of a mesh, whose coordinates begin at `origin`, as a file.
#[must_use]
pub fn obj_text(mesh: &TriangleMesh, origin: DVec3) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    for position in &mesh.positions {
        // Only a sum needs more digits than a coordinate.
        let _ = if origin == DVec3::ZERO {
            writeln!(text, "v {} {} {}", position.x, position.y, position.z)
        } else {
            let [x, y, z] = (position.as_dvec3() + origin).to_array();
            writeln!(text, "v {x} {y} {z}")
        };
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
    /// Origin of the positions.
    origin: DVec3,
    colours: Vec<[f32; 3]>,
    uv: Vec<Vec2>,
    normals: Vec<Vec3>,
    /// Vertex of the mesh for indices of a position, a texture coordinate and a normal.
    vertices: BTreeMap<(usize, Option<usize>, Option<usize>), u32>,
    mesh: TriangleMesh,
    vertex_normals: Vec<Vec3>,
    vertex_colours: Vec<[f32; 3]>,
    faces: Faces,
    /// Keywords of the statements that are not read, in quotation marks.
    unread: BTreeSet<String>,
    /// Whether the current line belongs to the requested part.
    in_part: bool,
}

impl Parser {
    fn line(&mut self, line: &str, naming: Option<Naming>) -> Result<(), String> {
        if let Some(naming) = naming {
            let (keyword, name) = statement(line);
            self.in_part = naming.fits(keyword, name).unwrap_or(self.in_part);
        }
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
            Some("f" | "fo") if self.in_part => self.face(words)?,
            Some("f" | "fo") | None => {}
            Some(keyword @ ("surf" | "bzp" | "bsp" | "cdc" | "cdp")) => {
                return Err(format!("`{keyword}` is a free-form surface, which is not read: export it as polygons"));
            }
            Some(keyword @ ("call" | "csh")) => {
                return Err(format!("`{keyword}` takes lines from elsewhere, which are not read: export one file"));
            }
            Some(keyword) if self.in_part && !WITHOUT_SHAPE.contains(&keyword) => {
                self.unread.insert(format!("`{}`", keyword.chars().take(MAX_SHOWN).collect::<String>()));
            }
            Some(_) => {}
        }
        Ok(())
    }

    fn position(&mut self, numbers: &[f64]) -> Result<(), String> {
        let (&[x, y, z, ref more @ ..], 3..=7) = (numbers, numbers.len()) else {
            return Err(format!("a vertex has {} numbers, but must have 3 to 7", numbers.len()));
        };
        let position = DVec3::new(x, y, z);
        check_finite(position.as_vec3(), || format!("vertex {} (1 is the first)", self.positions.len() + 1))?;
        if self.positions.is_empty() {
            self.origin = origin_near(position);
        }
        self.positions.push((position - self.origin).as_vec3());
        if let &[.., red, green, blue] = more {
            self.colours.push([red, green, blue].map(narrow));
        }
        Ok(())
    }

    fn face<'line>(&mut self, words: impl Iterator<Item = &'line str>) -> Result<(), String> {
        let corners = words.map(|word| self.corner(word)).collect::<Result<Vec<_>, _>>()?;
        self.faces.add(&corners, &self.mesh.positions)
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
        self.vertex_normals.push(normal.map_or(Vec3::ZERO, |normal| self.normals[normal]));
        self.vertex_colours.extend(self.colours.get(position));
        Ok(fresh)
    }

    /// Drops texture coordinates and colours unless every vertex has them.
    fn finish(mut self) -> ReadMesh {
        let count = self.mesh.positions.len();
        if self.mesh.uv.len() != count {
            self.mesh.uv.clear();
        }
        self.mesh.normals = VertexNormals::new(self.vertex_normals);
        if self.vertex_colours.len() == count && self.colours.len() == self.positions.len() {
            for (channel, name) in COLOUR.into_iter().enumerate() {
                let values = self.vertex_colours.iter().map(|colour| colour[channel]).collect();
                self.mesh.attributes.insert(name.to_owned(), values);
            }
        }
        let mut notes = self.faces.notes();
        if !self.unread.is_empty() {
            let unread = first_names(&Vec::from_iter(self.unread.iter().cloned()), self.unread.len());
            notes.push(format!("statements that are not read: {unread}"));
        }
        self.mesh.indices = self.faces.triangles;
        ReadMesh { mesh: self.mesh, origin: self.origin, notes }
    }
}

fn numbers<'line, T: FromStr>(
    words: impl Iterator<Item = &'line str>,
    quantity: impl Display + Copy,
) -> Result<Vec<T>, String> {
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
        read(&file, part).map(|read| read.mesh).map_err(|error| error.to_string())
    }

    #[test]
    fn reads_polygons_texture_seams_colours_and_negative_indices() {
        let all = read_text(SQUARE, None).unwrap();
        assert_eq!(all.indices.len(), 3);
        assert_eq!(all.positions.len(), 7, "one vertex has two texture coordinates, and three have a normal or none");
        let normal = |triangle: u32| all.normals.at(triangle, all.indices[triangle as usize], [0.2, 0.3, 0.5]);
        assert_eq!([normal(0), normal(1), normal(2)], [Some(Vec3::Z), Some(Vec3::Z), None], "the last face has none");
        assert!(read_text(&SQUARE.replace("/1 ", " ").replace("4/4/1", "4/4"), None).unwrap().normals.is_empty());
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
        let message = read_text(SQUARE, Some("middle")).unwrap_err();
        let names = r#"names in it are "inner other", "left", "right""#;
        assert!(message.ends_with(&format!(r#"no object, group or material named "middle": {names}"#)), "{message}");
    }

    #[test]
    fn names_of_parts_are_whole_and_groups_lie_within_objects() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\no Snow Drift\ng roof # of snow\nusemtl Old Snow\nf 1 2 3\n\
            o Snow\nusemtl New #2\nf 1 2 3\nf 1 2 4\ng\nf 1 3 4\nusemtl Old Snow\nf 2 3 4\n";
        for (part, count) in [
            ("Snow Drift", 1),
            ("Snow", 4),
            // A group lasts until the next group, and a material until the next material.
            ("roof", 3),
            ("Old Snow", 2),
            ("New #2", 3),
        ] {
            assert_eq!(read_text(text, Some(part)).unwrap().indices.len(), count, "{part}");
        }
        assert!(read_text(text, Some("Drift")).is_err() && read_text(text, Some("New")).is_err());
    }

    #[test]
    fn lines_that_end_with_a_backslash_continue() {
        let text = "v 0 0 \\\n 0\nv 1 0 0\r\nv 0 1 0 # \\\nf 1 2 \\ \n  3 \\\nv 9 9 9\n";
        assert_eq!(
            read_text("v 0 0 \\\n 0\r\nv 1 0 0\nv 0 1 0\nf 1 \\\n 2 \\ \r\n3", None).unwrap().indices,
            [[0, 1, 2]]
        );
        let message = read_text(text, None).unwrap_err();
        assert!(message.starts_with("mesh.obj:5: "), "{message}");
        assert_eq!(read_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 \\", None).unwrap().indices.len(), 1);
    }

    #[test]
    fn a_file_in_utf_16_is_read() {
        let bytes = format!("\u{feff}{SQUARE}").encode_utf16().flat_map(u16::to_le_bytes).collect();
        let file = NamedFile { path: "mesh.obj".into(), bytes };
        assert_eq!(read(&file, None).unwrap().mesh, read_text(SQUARE, None).unwrap());
    }

    #[test]
    fn faces_without_area_have_a_note() {
        let text = SQUARE.replacen("f -4/1 -3/4 -2/3", "f -4/1 -3/4\nf 1", 1);
        let file = NamedFile { path: "mesh.obj".into(), bytes: text.into() };
        let ReadMesh { mesh, notes, .. } = read(&file, None).unwrap();
        assert_eq!(mesh.indices.len(), 2);
        assert_eq!(notes, ["faces of less than three corners, which have no area, are left out: 2"]);
    }

    #[test]
    fn statements_that_are_not_read_have_a_note() {
        let notes = |text: &str, part| {
            let file = NamedFile { path: "mesh.obj".into(), bytes: text.into() };
            read(&file, part).unwrap().notes
        };
        assert!(notes(SQUARE, None).is_empty());
        // The old keyword of faces is read.
        let old = SQUARE.replacen("f 1/1/1", "fo 1/1/1", 1);
        assert_eq!(read_text(&old, None), read_text(SQUARE, None));
        let lines = format!("s off\nl 1 2\np 3\nl 2 3\n{SQUARE}curv 0 1 1 2\n");
        assert_eq!(notes(&lines, None), ["statements that are not read: `curv`, `l`, `p`"]);
        assert_eq!(notes(&lines, Some("left")), Vec::<String>::new(), "lines of other parts");
    }

    #[test]
    fn errors_name_the_line() {
        for (right, wrong, line, expected) in [
            ("f 1/1/1", "f 0/1/1", 12, "refers to vertex 0, but there are 4"),
            ("f 1/1/1", "f 1/5/1", 12, "refers to texture coordinate 5"),
            ("f -4/1", "f -5/1", 15, "refers to vertex -5"),
            ("o right", "surf 0 1 0 1 1 2 3 4", 13, "`surf` is a free-form surface, which is not read"),
            ("o right", "call more.obj", 13, "`call` takes lines from elsewhere"),
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
