//! Triangle meshes from PLY files (Turk 1994, "The PLY polygon file format"), ASCII or binary.
//!
//! Read are the vertices' `x y z` and the faces' `vertex_indices` (or `vertex_index`); faces with more than three
//! corners are cut into a fan. All other elements and properties are passed over.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use glam::Vec3;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{DefaultElement, ElementDef, Property, PropertyAccess, PropertyAccessResult, PropertyType};

use crate::error::RenderError;
use crate::ray::narrow;

#[derive(Default)]
struct Vertex([f32; 3]);

#[derive(Default)]
struct Face(Vec<i64>);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let axis = match name {
            "x" => 0,
            "y" => 1,
            "z" => 2,
            _ => return PropertyAccessResult::Ignored,
        };
        self.0[axis] = match property {
            Property::Float(value) => value,
            Property::Double(value) => narrow(value),
            Property::Int(value) => narrow(f64::from(value)),
            Property::Short(value) => f32::from(value),
            Property::Char(value) => f32::from(value),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !is_corner_list(name) {
            return PropertyAccessResult::Ignored;
        }
        self.0 = match property {
            Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUInt(list) => list.into_iter().map(i64::from).collect(),
            Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUChar(list) => list.into_iter().map(i64::from).collect(),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

fn is_corner_list(name: &str) -> bool {
    name == "vertex_indices" || name == "vertex_index"
}

/// The triangles of a PLY file, by their corners in the file's own unit.
///
/// # Errors
///
/// When the file cannot be read, is cut short or malformed, has no faces, or has a vertex that is not finite or a face
/// that names a vertex which is not there.
pub fn read_triangles(path: &Path) -> Result<Vec<[Vec3; 3]>, RenderError> {
    let file = File::open(path).map_err(|source| RenderError::ReadFile { path: path.into(), source })?;
    let wrong = |reason: String| RenderError::Mesh { path: path.into(), reason };
    let malformed = |error: ParseError| wrong(format!("not a readable PLY file: {}", one_line(&error.to_string())));

    let mut reader = Reader::new(BufReader::new(file));
    let header = Parser::<Vertex>::new().read_header(&mut reader).map_err(malformed)?;
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for element in header.elements.values() {
        match element.name.as_str() {
            "vertex" => {
                check_properties(element, &["x", "y", "z"]).map_err(wrong)?;
                vertices = Parser::<Vertex>::new()
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(malformed)?;
            }
            "face" => {
                faces =
                    Parser::<Face>::new().read_payload_for_element(&mut reader, element, &header).map_err(malformed)?;
            }
            _ => {
                Parser::<DefaultElement>::new()
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(malformed)?;
            }
        }
    }
    triangles(&vertices, &faces).map_err(wrong)
}

fn check_properties(element: &ElementDef, names: &[&str]) -> Result<(), String> {
    for &name in names {
        match element.properties.get(name).map(|property| &property.data_type) {
            Some(PropertyType::Scalar(_)) => {}
            _ => return Err(format!("vertices have no coordinate `{name}`")),
        }
    }
    Ok(())
}

fn triangles(vertices: &[Vertex], faces: &[Face]) -> Result<Vec<[Vec3; 3]>, String> {
    if faces.is_empty() {
        return Err("the mesh has no faces, but must have at least one".into());
    }
    for (number, vertex) in vertices.iter().enumerate() {
        if let Some(value) = vertex.0.iter().find(|value| !value.is_finite()) {
            return Err(format!("a coordinate of vertex {number} is {value}, but must be finite"));
        }
    }
    let mut triangles = Vec::with_capacity(faces.len());
    for (number, face) in faces.iter().enumerate() {
        if face.0.len() < 3 {
            return Err(format!("face {number} has {} corners, but must have at least 3", face.0.len()));
        }
        let corner = |index: i64| {
            usize::try_from(index)
                .ok()
                .and_then(|index| vertices.get(index))
                .map(|vertex| Vec3::from_array(vertex.0))
                .ok_or_else(|| {
                    format!("face {number} names vertex {index}, but there are {} (0 is the first)", vertices.len())
                })
        };
        for pair in face.0[1..].windows(2) {
            triangles.push([corner(face.0[0])?, corner(pair[0])?, corner(pair[1])?]);
        }
    }
    Ok(triangles)
}

fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt::Write;

    const HEADER: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
        property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n";
    const VERTICES: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

    fn read(content: &[u8]) -> Result<Vec<[Vec3; 3]>, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.ply");
        std::fs::write(&path, content).unwrap();
        read_triangles(&path).map_err(|error| error.to_string())
    }

    #[test]
    fn polygons_become_fans() {
        let triangles = read(format!("{HEADER}{VERTICES}4 0 1 2 3\n3 0 1 2\n").as_bytes()).unwrap();
        assert_eq!(triangles.len(), 3);
        assert_eq!(triangles[1], [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0), Vec3::Y]);
    }

    #[test]
    fn binary_files_with_other_properties_are_read() {
        let mut content = b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty double x\n\
            property double y\nproperty uchar red\nproperty double z\nelement face 1\nproperty uchar flags\n\
            property list uchar uint vertex_index\nend_header\n"
            .to_vec();
        for [x, y, z] in [[0.0f64, 0.0, 0.5], [1.0, 0.0, 0.5], [0.0, 1.0, 0.5]] {
            content.extend(x.to_le_bytes().into_iter().chain(y.to_le_bytes()));
            content.push(255);
            content.extend(z.to_le_bytes());
        }
        content.extend([7, 3]);
        content.extend([0u32, 1, 2].into_iter().flat_map(u32::to_le_bytes));
        assert_eq!(
            read(&content).unwrap(),
            [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
                .map(|[x, y]| Vec3::new(x, y, 0.5))
                .chunks(3)
                .map(|c| [c[0], c[1], c[2]])
                .collect::<Vec<_>>()
        );
        // Every shorter file is refused, wherever it is cut.
        for length in 0..content.len() {
            assert!(read(&content[..length]).is_err(), "cut to {length} bytes");
        }
    }

    #[test]
    fn what_is_wrong_is_said_in_one_line_with_the_file() {
        let face = "3 0 1 2\n";
        let mut no_faces = HEADER.replace("element face 2\nproperty list uchar int vertex_indices\n", "");
        write!(no_faces, "{VERTICES}").unwrap();
        let cases = [
            (String::new(), "not a readable PLY"),
            ("solid stl\n".into(), "not a readable PLY"),
            (format!("{HEADER}{VERTICES}{face}"), "not a readable PLY"),
            (format!("{HEADER}0 0 0\n"), "not a readable PLY"),
            (no_faces, "no faces"),
            (format!("{HEADER}0 0 0\n1 1e99 0\n1 1 0\n0 1 0\n{face}{face}"), "vertex 1 is inf"),
            (format!("{HEADER}{VERTICES}{face}3 0 1 4\n"), "face 1 names vertex 4"),
            (format!("{HEADER}{VERTICES}{face}3 0 1 -1\n"), "face 1 names vertex -1"),
            (format!("{HEADER}{VERTICES}{face}2 0 1\n"), "face 1 has 2 corners"),
            (HEADER.replace(" z", " w") + VERTICES + face + face, "no coordinate `z`"),
            (HEADER.replace("vertex 4", "vertex 4000000000000000000") + VERTICES, "not a readable PLY"),
        ];
        for (content, expected) in cases {
            let message = read(content.as_bytes()).unwrap_err();
            assert!(message.contains(expected) && message.contains("mesh.ply"), "{message}");
            assert!(!message.contains('\n'), "{message}");
        }
    }
}
