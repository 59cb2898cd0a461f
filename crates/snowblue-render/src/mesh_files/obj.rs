//! Triangle meshes from Wavefront OBJ files: `v`, `vt`, `f`, `o` and `g`; every other keyword is passed over.
//!
//! Faces with more than three corners are cut into a fan. A vertex with two texture coordinates becomes two vertices.
//! Six numbers after `v` are place and colour: the attributes `red`, `green` and `blue`.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use glam::{Vec2, Vec3};

use crate::error::RenderError;
use crate::files::SceneFile;
use crate::geometry::triangles::Triangles;

const COLOUR: [&str; 3] = ["red", "green", "blue"];

/// Reads a file, or the object or group of it with a name.
pub(super) fn read(file: &SceneFile, part: Option<&str>) -> Result<Triangles, RenderError> {
    let (path, text) = (&file.path, file.text());
    let mut reading = Reading { taking: part.is_none(), ..Reading::default() };
    for (number, line) in text.lines().enumerate() {
        reading.line(line, part).map_err(|reason| RenderError::MeshLine {
            path: path.clone(),
            line: number + 1,
            reason,
        })?;
    }
    match part {
        Some(part) if !reading.found => {
            Err(RenderError::Mesh { path: path.clone(), reason: format!("no object or group is called \"{part}\"") })
        }
        _ => Ok(reading.finish()),
    }
}

/// What has been read so far.
#[derive(Default)]
struct Reading {
    places: Vec<Vec3>,
    colours: Vec<[f32; 3]>,
    texture_places: Vec<Vec2>,
    /// Number of the vertex for a place and texture coordinates.
    vertices: BTreeMap<(usize, Option<usize>), u32>,
    triangles: Triangles,
    vertex_colours: Vec<[f32; 3]>,
    /// Whether faces are those of the part asked for.
    taking: bool,
    found: bool,
}

impl Reading {
    fn line(&mut self, line: &str, part: Option<&str>) -> Result<(), String> {
        let line = line.split('#').next().unwrap_or_default();
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => self.place(&numbers(words)?)?,
            Some("vt") => match numbers(words)?[..] {
                [u, v, ..] => self.texture_places.push(Vec2::new(u, v)),
                [u] => self.texture_places.push(Vec2::new(u, 0.0)),
                [] => return Err("texture coordinates are missing after `vt`".into()),
            },
            Some("f") if self.taking => self.face(words)?,
            Some("o" | "g") => {
                if let Some(part) = part {
                    self.taking = words.any(|word| word == part);
                    self.found |= self.taking;
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn place(&mut self, numbers: &[f32]) -> Result<(), String> {
        let (&[x, y, z, ref more @ ..], 3..=7) = (numbers, numbers.len()) else {
            return Err(format!("a vertex has {} numbers, but must have 3 to 7", numbers.len()));
        };
        if let Some(value) = [x, y, z].into_iter().find(|value| !value.is_finite()) {
            return Err(format!("a coordinate is {value}, but must be finite"));
        }
        self.places.push(Vec3::new(x, y, z));
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
        self.triangles.corners.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
        Ok(())
    }

    /// The vertex of a corner like `7`, `7/3`, `7//5` or `-1/-1/-1`.
    fn corner(&mut self, word: &str) -> Result<u32, String> {
        let mut indices = word.split('/');
        let place = index(indices.next().unwrap_or_default(), self.places.len(), "vertex")?;
        let texture_place = match indices.next() {
            None | Some("") => None,
            Some(word) => Some(index(word, self.texture_places.len(), "texture coordinate")?),
        };
        let fresh = u32::try_from(self.triangles.positions.len()).map_err(|_| "there are too many vertices")?;
        let Entry::Vacant(entry) = self.vertices.entry((place, texture_place)) else {
            return Ok(self.vertices[&(place, texture_place)]);
        };
        entry.insert(fresh);
        self.triangles.positions.push(self.places[place]);
        self.triangles.uv.extend(texture_place.map(|texture_place| self.texture_places[texture_place]));
        self.vertex_colours.extend(self.colours.get(place));
        Ok(fresh)
    }

    /// Keeps texture coordinates and colours where every vertex has them.
    fn finish(mut self) -> Triangles {
        let count = self.triangles.positions.len();
        if self.triangles.uv.len() != count {
            self.triangles.uv.clear();
        }
        if self.vertex_colours.len() == count && self.colours.len() == self.places.len() {
            for (channel, name) in COLOUR.into_iter().enumerate() {
                let values = self.vertex_colours.iter().map(|colour| colour[channel]).collect();
                self.triangles.attributes.insert(name.to_owned(), values);
            }
        }
        self.triangles
    }
}

fn numbers<'line>(words: impl Iterator<Item = &'line str>) -> Result<Vec<f32>, String> {
    words.map(|word| word.parse().map_err(|_| format!("\"{word}\" is not a number"))).collect()
}

/// An index counted from 1, or from -1 backwards, as one counted from 0.
fn index(word: &str, count: usize, what: &str) -> Result<usize, String> {
    let index: i64 = word.parse().map_err(|_| format!("\"{word}\" is not the number of a {what}"))?;
    let counted = usize::try_from(index.unsigned_abs()).unwrap_or(usize::MAX);
    match (index, counted) {
        (1.., _) if counted <= count => Ok(counted - 1),
        (..=-1, _) if counted <= count => Ok(count - counted),
        _ => Err(format!("a face names {what} {index}, but there are {count} so far (1 is the first)")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: &str = "mtllib a.mtl\no left\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0 # note\nv 1 1 0 0 0 1\nv 0 1 0 1 1 1\n\
        vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\nf 1/1/1 2/2/1 3/3/1 4/4/1\no right\ng inner other\nf -4/1 -3/4 -2/3\n";

    fn read_text(text: &str, part: Option<&str>) -> Result<Triangles, String> {
        let file = SceneFile { path: "mesh.obj".into(), bytes: text.as_bytes().into() };
        read(&file, part).map_err(|error| error.to_string())
    }

    #[test]
    fn polygons_seams_colours_and_indices_from_the_end_are_read() {
        let all = read_text(SQUARE, None).unwrap();
        assert_eq!(all.corners.len(), 3);
        assert_eq!(all.positions.len(), 5, "one vertex has two texture coordinates");
        assert_eq!(all.places(1), [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0), Vec3::Y]);
        assert_eq!(all.uv[all.corners[2][1] as usize], Vec2::Y);
        assert_eq!(all.attributes["green"][all.corners[2][1] as usize].to_bits(), 1f32.to_bits());
    }

    #[test]
    fn a_part_is_taken_by_its_name() {
        assert_eq!(read_text(SQUARE, Some("left")).unwrap().corners.len(), 2);
        assert_eq!(read_text(SQUARE, Some("other")).unwrap().places(0)[1], Vec3::X);
        assert!(read_text(SQUARE, Some("middle")).unwrap_err().contains("no object or group is called \"middle\""));
    }

    #[test]
    fn mistakes_are_named_with_their_line() {
        for (right, wrong, line, expected) in [
            ("f 1/1/1", "f 0/1/1", 12, "names vertex 0, but there are 4"),
            ("f 1/1/1", "f 1/5/1", 12, "names texture coordinate 5"),
            ("f -4/1", "f -5/1", 15, "names vertex -5"),
            ("f -4/1 -3/4 -2/3", "f -4/1 -3/4", 15, "a face has 2 corners"),
            ("v 1 1 0 0 0 1", "v 1 1", 5, "a vertex has 2 numbers"),
            ("v 1 1 0 0 0 1", "v 1 nan 0", 5, "a coordinate is NaN"),
            ("vt 1 1", "vt 1 one", 9, "\"one\" is not a number"),
        ] {
            let message = read_text(&SQUARE.replacen(right, wrong, 1), None).unwrap_err();
            assert!(message.contains(&format!("mesh.obj:{line}: ")) && message.contains(expected), "{message}");
        }
    }
}
