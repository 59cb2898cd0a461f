//! STL files (3D Systems 1989, "StereoLithography Interface Specification"), binary or ASCII.
//!
//! Each triangle has its own corners. Coincident corners become one vertex. Normals, names and the two bytes of
//! further data of a binary triangle are ignored.

use glam::Vec3;
use snowblue_base::files::{FileError, NamedFile};

use crate::coincident::{keep_used, merged};
use crate::mesh_files::coordinates::{check_finite, number};
use crate::triangle_mesh::TriangleMesh;

/// Length in bytes of the header before the triangles of a binary file: a text, and the number of triangles.
const HEADER: usize = 80 + 4;

/// Length in bytes of a triangle of a binary file: its normal, its corners, and two bytes of further data.
const TRIANGLE: usize = 12 + 36 + 2;

/// Reads a file. An ASCII file begins with `solid`, and so do some binary files. A binary file has the length that
/// follows from its number of triangles.
pub(super) fn read(file: &NamedFile) -> Result<TriangleMesh, FileError> {
    let wrong = |reason| FileError::Content { path: file.path.clone(), reason };
    let triangles = match binary(&file.bytes) {
        Ok(triangles) => check_triangles(&triangles).map(|()| triangles).map_err(wrong)?,
        Err(reason) => {
            let text = file.text();
            let begins_as_text = text.trim_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case("solid"));
            if !begins_as_text || text.contains('\0') {
                return Err(wrong(reason));
            }
            ascii(&text).map_err(|(line, reason)| FileError::Line { path: file.path.clone(), line, reason })?
        }
    };
    Ok(welded(&triangles))
}

/// Checks that all corners are finite, while triangles and corners still have the numbers of the file.
fn check_triangles(triangles: &[[Vec3; 3]]) -> Result<(), String> {
    for (number, corners) in triangles.iter().enumerate() {
        for (corner, position) in corners.iter().enumerate() {
            check_finite(*position, || format!("vertex {corner} of triangle {number} (0 is the first)"))?;
        }
    }
    Ok(())
}

/// Joins coincident corners.
fn welded(triangles: &[[Vec3; 3]]) -> TriangleMesh {
    let mut mesh = TriangleMesh::from_triangles(triangles);
    let first = merged(&mesh.positions, &mesh.indices);
    mesh.indices.iter_mut().flatten().for_each(|corner| *corner = first[*corner as usize]);
    keep_used(&mut mesh.positions, &mut mesh.indices);
    mesh
}

fn binary(bytes: &[u8]) -> Result<Vec<[Vec3; 3]>, String> {
    let Some((header, triangles)) = bytes.split_at_checked(HEADER) else {
        return Err(format!("not a readable STL file: it has {} bytes, but must have at least {HEADER}", bytes.len()));
    };
    let count = u32::from_le_bytes([header[80], header[81], header[82], header[83]]);
    let needed = HEADER as u64 + u64::from(count) * TRIANGLE as u64;
    if bytes.len() as u64 != needed {
        return Err(format!(
            "not a readable STL file: it has {} bytes, but a binary one of {count} triangles must have {needed}",
            bytes.len()
        ));
    }
    let number = |bytes: &[u8]| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    let corner = |bytes: &[u8]| Vec3::new(number(&bytes[..4]), number(&bytes[4..8]), number(&bytes[8..]));
    let corners = |bytes: &[u8]| [corner(&bytes[12..24]), corner(&bytes[24..36]), corner(&bytes[36..48])];
    Ok(triangles.chunks_exact(TRIANGLE).map(corners).collect())
}

/// Reads the text of a file. An error comes with its line.
fn ascii(text: &str) -> Result<Vec<[Vec3; 3]>, (usize, String)> {
    let mut parser = Parser::default();
    for (number, line) in text.lines().enumerate() {
        parser.line(line).map_err(|reason| (number + 1, reason))?;
    }
    if parser.in_solid {
        return Err((text.lines().count(), "the file ends within a solid".into()));
    }
    Ok(parser.triangles)
}

/// The state of the parser.
#[derive(Default)]
struct Parser {
    triangles: Vec<[Vec3; 3]>,
    /// Corners of the current facet, if the line lies in a facet.
    facet: Option<Vec<Vec3>>,
    in_solid: bool,
}

impl Parser {
    fn line(&mut self, line: &str) -> Result<(), String> {
        let mut words = line.split_whitespace();
        let Some(keyword) = words.next() else { return Ok(()) };
        match (&*keyword.to_ascii_lowercase(), &mut self.facet) {
            ("solid", None) if !self.in_solid => self.in_solid = true,
            ("endsolid", None) if self.in_solid => self.in_solid = false,
            ("facet", facet @ None) if self.in_solid => *facet = Some(Vec::with_capacity(3)),
            ("outer" | "endloop", Some(_)) => {}
            ("vertex", Some(corners)) if corners.len() < 3 => corners.push(position(words)?),
            ("vertex", Some(_)) => return Err("a facet has more than 3 vertices".into()),
            ("endfacet", facet @ Some(_)) => {
                let corners = facet.take().unwrap_or_default();
                let triangle = <[Vec3; 3]>::try_from(corners);
                self.triangles.push(
                    triangle.map_err(|corners| format!("a facet has {} vertices, but must have 3", corners.len()))?,
                );
            }
            ("solid" | "endsolid" | "facet" | "outer" | "endloop" | "vertex" | "endfacet", _) => {
                return Err(format!("`{keyword}` is out of place"));
            }
            _ => return Err(format!("\"{keyword}\" is not a keyword of STL")),
        }
        Ok(())
    }
}

fn position<'line>(words: impl Iterator<Item = &'line str>) -> Result<Vec3, String> {
    let numbers = words.map(|word| number(word, "a coordinate of a vertex")).collect::<Result<Vec<f32>, _>>()?;
    let &[x, y, z] = numbers.as_slice() else {
        return Err(format!("a vertex has {} numbers, but must have 3", numbers.len()));
    };
    let position = Vec3::new(x, y, z);
    check_finite(position, || "a vertex".to_owned()).map(|()| position)
}

/// The triangles of a mesh as a binary file.
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "a mesh in memory has fewer than 2^32 triangles")]
pub fn stl_bytes(mesh: &TriangleMesh) -> Vec<u8> {
    let mut content = vec![b' '; 80];
    content[..10].copy_from_slice(b"binary STL");
    content.extend((mesh.indices.len() as u32).to_le_bytes());
    for corners in (0..mesh.indices.len()).map(|triangle| mesh.corners(triangle)) {
        let [a, b, c] = corners.map(|corner| corner.as_dvec3());
        let normal = (b - a).cross(c - a).normalize_or_zero().as_vec3();
        let numbers = [[normal].as_slice(), &corners].concat().into_iter().flat_map(|vector| vector.to_array());
        content.extend(numbers.flat_map(f32::to_le_bytes));
        content.extend([0; 2]);
    }
    content
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh_files::read_mesh_from;
    use crate::topology::Topology;
    use snowblue_base::files::FilesInMemory;

    const TEXT: &str = "solid two words\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   \
        vertex 1.0e0 1 0\n  endloop\n endfacet\n FACET NORMAL 0 0 1\n OUTER LOOP\n VERTEX 0 -0 0\n VERTEX 1 1 0\n \
        VERTEX 0 1 0\n ENDLOOP\n ENDFACET\nendsolid two words\n";

    fn read(content: &[u8]) -> Result<TriangleMesh, String> {
        let files = FilesInMemory::from([("mesh.stl", content)]);
        read_mesh_from(&files, "mesh.stl", None).map(|read| read.mesh).map_err(|error| error.to_string())
    }

    fn tetrahedron() -> TriangleMesh {
        let indices = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        TriangleMesh { positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z], indices, ..TriangleMesh::default() }
    }

    #[test]
    fn corners_at_the_same_position_are_one_vertex() {
        let square = read(TEXT.as_bytes()).unwrap();
        assert_eq!(square.positions, [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y]);
        assert_eq!(square.indices, [[0, 1, 2], [0, 2, 3]]);
        let utf16: Vec<u8> = format!("\u{feff}{TEXT}").encode_utf16().flat_map(u16::to_le_bytes).collect();
        for bytes in [utf16, format!("\u{feff}{TEXT}").into(), TEXT.replace('\n', "\r").into()] {
            assert_eq!(read(&bytes).unwrap(), square);
        }
    }

    #[test]
    fn a_written_file_is_read_as_it_was_whatever_its_text_begins_with() {
        let mut content = stl_bytes(&tetrahedron());
        for text in [b"binary", b"solid "] {
            content[..6].copy_from_slice(text);
            let again = read(&content).unwrap();
            assert!(Topology::of(&again).is_closed());
            assert_eq!(again.positions.len(), 4);
            let corners = |mesh: &TriangleMesh| (0..4).map(|triangle| mesh.corners(triangle)).collect::<Vec<_>>();
            assert_eq!(corners(&again), corners(&tetrahedron()));
        }
        assert_eq!(content[84 + 50 * 3..][..12], [3f32.sqrt().recip(); 3].map(f32::to_le_bytes).concat());
    }

    #[test]
    fn truncated_files_and_counts_without_triangles_are_refused() {
        let content = stl_bytes(&tetrahedron());
        for length in 0..content.len() {
            assert!(read(&content[..length]).is_err(), "truncated to {length} bytes");
        }
        for length in 0..TEXT.rfind("endsolid").unwrap() {
            assert!(read(&TEXT.as_bytes()[..length]).is_err(), "truncated to {length} bytes");
        }
        let mut many = content;
        many[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        let message = read(&many).unwrap_err();
        assert!(message.contains("284 bytes") && message.contains("4294967295 triangles"), "{message}");
        many[80..84].copy_from_slice(&0u32.to_le_bytes());
        assert!(read(&many[..84]).unwrap_err().contains("no faces"));
    }

    #[test]
    fn errors_name_the_line_or_the_vertex() {
        for (right, wrong, line, expected) in [
            ("vertex 1 0 0", "vertex 1 0", 5, "a vertex has 2 numbers, but must have 3"),
            ("vertex 1 0 0", "vertex 1 0 one", 5, "a coordinate of a vertex is \"one\", but must be a number"),
            ("vertex 1 0 0", "vertex 1 0 0,5", 5, "is \"0,5\", but must be a number with a decimal point"),
            ("vertex 1 0 0", "vertex 1 0 nan", 5, "coordinate z of a vertex is NaN, but must be finite"),
            ("vertex 1 0 0\n", "\n", 8, "a facet has 2 vertices, but must have 3"),
            ("endloop", "vertex 1 1 1", 7, "a facet has more than 3 vertices"),
            ("endloop", "end", 7, "\"end\" is not a keyword of STL"),
            ("endfacet\n", "\n", 9, "`FACET` is out of place"),
            ("endsolid two words\n", "", 15, "the file ends within a solid"),
        ] {
            let message = read(TEXT.replacen(right, wrong, 1).as_bytes()).unwrap_err();
            assert!(message.contains(&format!("mesh.stl:{line}: ")) && message.contains(expected), "{message}");
        }
        let mut content = stl_bytes(&tetrahedron());
        content[84 + 50 + 12 + 16..][..4].copy_from_slice(&f32::INFINITY.to_le_bytes());
        let message = read(&content).unwrap_err();
        assert!(message.contains("coordinate y of vertex 1 of triangle 1 (0 is the first) is inf"), "{message}");
        let files = FilesInMemory::from([("mesh.stl", TEXT)]);
        assert!(read_mesh_from(&files, "mesh.stl", Some("two")).unwrap_err().to_string().contains("has no parts"));
    }
}
