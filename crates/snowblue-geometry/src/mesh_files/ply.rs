//! PLY files (Turk 1994, "The PLY polygon file format"), ASCII or binary.
//!
//! Reads vertex positions `x y z`, normals `nx ny nz`, texture coordinates (`u v`, `s t` or `texture_u texture_v`), all
//! scalar vertex properties but positions as attributes, and `vertex_indices` (or `vertex_index`) of faces and of the
//! element `tristrips`, where -1 ends a strip. Other elements and properties are ignored.

use std::borrow::Cow;
use std::io::{Cursor, Seek};
use std::path::Path;

use glam::{DVec3, Vec2, Vec3};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyDef, PropertyType, ScalarType,
};
use snowblue_base::files::{FileError, NamedFile, one_line};

use crate::mesh_files::coordinates::{COORDINATES, check_all_finite, number as mesh_number};
use crate::mesh_files::faces::{Faces, strip};
use crate::mesh_files::read_mesh::ReadMesh;
use crate::transform::origin_near;
use crate::triangle_mesh::TriangleMesh;
use crate::vertex_normals::VertexNormals;
use snowblue_base::narrow;

const NORMAL: [&str; 3] = ["nx", "ny", "nz"];

/// Common names of texture coordinates.
const TEXTURE_COORDINATES: [[&str; 2]; 3] = [["u", "v"], ["s", "t"], ["texture_u", "texture_v"]];

/// A vertex: its position, and its attributes in the order of the header.
#[derive(Default)]
struct Vertex {
    position: [f64; 3],
    attributes: Vec<f32>,
}

#[derive(Default)]
struct Face(Vec<i64>);

/// An element that is not used.
struct Ignored;

impl PropertyAccess for Ignored {
    fn new() -> Self {
        Self
    }
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let value = match property {
            Property::Float(value) => value.into(),
            Property::Double(value) => value,
            Property::Int(value) => value.into(),
            Property::UInt(value) => value.into(),
            Property::Short(value) => value.into(),
            Property::UShort(value) => value.into(),
            Property::Char(value) => value.into(),
            Property::UChar(value) => value.into(),
            _ => return PropertyAccessResult::Ignored,
        };
        match COORDINATES.iter().position(|axis| *axis == name) {
            Some(axis) => self.position[axis] = value,
            None => self.attributes.push(narrow(value)),
        }
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !is_index_list(name) {
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

fn is_index_list(name: &str) -> bool {
    name == "vertex_indices" || name == "vertex_index"
}

fn is_index_list_of_integers((name, definition): (&String, &PropertyDef)) -> bool {
    let PropertyType::List(_, item) = &definition.data_type else { return false };
    is_index_list(name) && !matches!(item, ScalarType::Float | ScalarType::Double)
}

/// Reads a PLY file, in the file's own unit.
pub(super) fn read(file: &NamedFile) -> Result<ReadMesh, FileError> {
    let path = &file.path;
    let wrong = |reason: String| FileError::Content { path: path.clone(), reason };
    // A file with a byte order mark is a text. Otherwise the header says whether the file is a text.
    let marked = (!file.bytes.starts_with(b"ply")).then(|| file.text());
    let mut reader = Reader::new(Cursor::new(marked.as_ref().map_or(&*file.bytes, |text| text.as_bytes())));
    let header = Parser::<Vertex>::new().read_header(&mut reader).map_err(|error| malformed(path, &error, None))?;
    let content = if header.encoding == Encoding::Ascii { file.text() } else { Cow::default() };
    let mut text = TextLines::after_header(&content);
    let (mut vertices, mut faces, mut names) = (Vec::new(), Vec::new(), Vec::new());
    let mut tristrips: Vec<Face> = Vec::new();
    for element in header.elements.values() {
        if element.properties.is_empty() {
            return Err(wrong(format!("element {} has no properties", element.name)));
        }
        let mut payload = Payload { reader: &mut reader, text: &mut text, element, header: &header, path };
        match element.name.as_str() {
            "vertex" => {
                names = attribute_names(element).map_err(wrong)?;
                vertices = payload.read()?;
            }
            "face" | "tristrips" if !element.properties.iter().any(is_index_list_of_integers) => {
                return Err(wrong(format!("element {} has no list `vertex_indices` of integers", element.name)));
            }
            "face" => faces = payload.read()?,
            "tristrips" => tristrips = payload.read()?,
            _ => drop(payload.read::<Ignored>()?),
        }
    }
    mesh(&vertices, &faces, &tristrips, &names).map_err(wrong)
}

/// The part of a file that holds an element.
struct Payload<'file, 'a> {
    /// The reader of a binary file.
    reader: &'a mut Reader<Cursor<&'file [u8]>>,
    /// The lines of a text file.
    text: &'a mut TextLines<'file>,
    element: &'a ElementDef,
    header: &'a Header,
    path: &'a Path,
}

impl Payload<'_, '_> {
    fn read<T: PropertyAccess>(&mut self) -> Result<Vec<T>, FileError> {
        if self.header.encoding == Encoding::Ascii {
            return self.read_text();
        }
        let read = Parser::<T>::new().read_payload_for_element(self.reader, self.element, self.header);
        // Binary files have no lines, so the message gives the byte.
        read.map_err(|error| malformed(self.path, &error, self.reader.get_mut().stream_position().ok()))
    }

    /// Reads a line for each element. Words after the last property are ignored.
    fn read_text<T: PropertyAccess>(&mut self) -> Result<Vec<T>, FileError> {
        let ElementDef { name, count, .. } = self.element;
        let mut read = Vec::new();
        for number in 0..*count {
            let Some((line, words)) = self.text.next() else {
                let reason = format!("not a readable PLY file: it ends after {number} of {count} elements `{name}`");
                return Err(FileError::Content { path: self.path.into(), reason });
            };
            let wrong = |reason| FileError::Line { path: self.path.into(), line, reason };
            read.push(text_element(self.element, number, words).map_err(wrong)?);
        }
        Ok(read)
    }
}

/// The lines of a text that are not blank.
struct TextLines<'file>(std::iter::Enumerate<std::str::Lines<'file>>);

impl<'file> TextLines<'file> {
    /// The lines after the header.
    fn after_header(text: &'file str) -> Self {
        let mut lines = text.lines().enumerate();
        lines.find(|(_, line)| line.trim_end() == "end_header");
        Self(lines)
    }

    /// The number of the next line, from 1, and the line.
    fn next(&mut self) -> Option<(usize, &'file str)> {
        let (number, line) = self.0.find(|(_, line)| !line.trim().is_empty())?;
        Some((number + 1, line))
    }
}

/// An element from its line. Numbers may have any text form, whatever types the header names.
fn text_element<T: PropertyAccess>(element: &ElementDef, number: usize, line: &str) -> Result<T, String> {
    let mut words = line.split_whitespace();
    let (mut read, name) = (T::new(), &element.name);
    for (property, definition) in &element.properties {
        let is_coordinate = name == "vertex" && COORDINATES.contains(&property.as_str());
        let kind = if is_coordinate { "coordinate" } else { "property" };
        let quantity = format_args!("{kind} {property} of {name} {number}");
        let mut word = || words.next().ok_or_else(|| format!("{quantity} is missing"));
        let value = match definition.data_type {
            PropertyType::Scalar(_) => {
                let value: f64 = mesh_number(word()?, quantity)?;
                if is_coordinate && !narrow(value).is_finite() {
                    return Err(format!("{quantity} is {}, but must be finite", narrow(value)));
                }
                Property::Double(value)
            }
            PropertyType::List(..) => {
                let whole = |word: &str| {
                    word.parse::<i32>().map_err(|_| format!("{quantity} has \"{word}\", but must have whole numbers"))
                };
                let word_of_count = word()?;
                let count: u32 = word_of_count
                    .parse()
                    .map_err(|_| format!("{quantity} has \"{word_of_count}\" items, but must have a whole number"))?;
                // Unused lists may have any numbers.
                let item = |_| if is_index_list(property) { whole(word()?) } else { word().map(|_| 0) };
                Property::ListInt((0..count).map(item).collect::<Result<_, _>>()?)
            }
        };
        read.set_property(property, value);
    }
    Ok(read)
}

fn malformed(path: &Path, error: &ParseError, byte: Option<u64>) -> FileError {
    let path = path.into();
    let message = one_line(&error.to_string());
    let message = error.line().and_then(|line| message.strip_prefix(&format!("Line {line}: "))).unwrap_or(&message);
    let reason = format!("not a readable PLY file: {message}");
    match (byte, error.line()) {
        (Some(byte), _) => FileError::Content { path, reason: format!("{reason} (near byte {byte})") },
        (None, Some(line)) => FileError::Line { path, line, reason },
        (None, None) => FileError::Content { path, reason },
    }
}

/// The names of the scalar vertex properties other than the position, in file order.
fn attribute_names(element: &ElementDef) -> Result<Vec<String>, String> {
    let scalars: Vec<&String> = element
        .properties
        .iter()
        .filter(|(_, property)| matches!(property.data_type, PropertyType::Scalar(_)))
        .map(|(name, _)| name)
        .collect();
    match COORDINATES.iter().find(|axis| !scalars.iter().any(|name| name == *axis)) {
        Some(axis) => Err(format!("vertices have no coordinate `{axis}`")),
        None => Ok(scalars.into_iter().filter(|name| !COORDINATES.contains(&name.as_str())).cloned().collect()),
    }
}

fn mesh(vertices: &[Vertex], faces: &[Face], tristrips: &[Face], names: &[String]) -> Result<ReadMesh, String> {
    let origin = vertices.first().map_or(DVec3::ZERO, |vertex| origin_near(vertex.position.into()));
    let positions = vertices.iter().map(|vertex| (DVec3::from(vertex.position) - origin).as_vec3()).collect();
    let mut mesh = TriangleMesh { positions, ..TriangleMesh::default() };
    check_all_finite(&mesh.positions)?;
    let mut read = Faces::default();
    read.triangles.reserve(faces.len());
    let corner = |what: &str, number: usize, index: i64| {
        u32::try_from(index).ok().filter(|&index| (index as usize) < vertices.len()).ok_or_else(|| {
            format!("{what} {number} refers to vertex {index}, but there are {} (0 is the first)", vertices.len())
        })
    };
    let mut corners = Vec::new();
    for (number, face) in faces.iter().enumerate() {
        corners.clear();
        for index in &face.0 {
            corners.push(corner("face", number, *index)?);
        }
        read.add(&corners, &mesh.positions)?;
    }
    for (number, Face(indices)) in tristrips.iter().enumerate() {
        for part in indices.split(|index| *index == -1) {
            let part = part.iter().map(|index| corner("strip", number, *index)).collect::<Result<Vec<_>, _>>()?;
            read.triangles.extend(strip(&part));
        }
    }
    let notes = read.notes();
    mesh.indices = read.triangles;
    let values = |column: usize| vertices.iter().map(move |vertex| vertex.attributes[column]);
    let column = |name: &str| names.iter().position(|other| other == name);
    for [u, v] in TEXTURE_COORDINATES {
        if let (Some(u), Some(v)) = (column(u), column(v)) {
            mesh.uv = values(u).zip(values(v)).map(|(u, v)| Vec2::new(u, v)).collect();
        }
    }
    if let [Some(x), Some(y), Some(z)] = NORMAL.map(column) {
        let normal = |vertex: &Vertex| Vec3::from_array([x, y, z].map(|column| vertex.attributes[column]));
        mesh.normals = VertexNormals::new(vertices.iter().map(normal));
    }
    for (index, name) in names.iter().enumerate() {
        mesh.attributes.insert(name.clone(), values(index).collect());
    }
    Ok(ReadMesh { mesh, origin, notes })
}

/// The positions and triangles of a mesh, whose coordinates begin at `origin`, as a binary file (Turk 1994, "The PLY
/// polygon file format"). Away from the origin of the file, positions have double precision.
#[must_use]
pub fn ply_bytes(mesh: &TriangleMesh, origin: DVec3) -> Vec<u8> {
    let number = if origin == DVec3::ZERO { "float" } else { "double" };
    let mut content = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty {number} x\nproperty {number} y\n\
         property {number} z\nelement face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.indices.len()
    )
    .into_bytes();
    if origin == DVec3::ZERO {
        content.extend(mesh.positions.iter().flat_map(|position| position.to_array()).flat_map(f32::to_le_bytes));
    } else {
        let exact = mesh.positions.iter().map(|position| position.as_dvec3() + origin);
        content.extend(exact.flat_map(|position| position.to_array()).flat_map(f64::to_le_bytes));
    }
    for triangle in &mesh.indices {
        content.push(3);
        content.extend(triangle.iter().copied().flat_map(u32::to_le_bytes));
    }
    content
}

#[cfg(test)]
mod tests {
    use super::{DVec3, TriangleMesh, Vec2, Vec3, ply_bytes};
    use crate::mesh_files::read_mesh_from;
    use snowblue_base::files::FilesInMemory;
    use std::fmt::Write;

    const HEADER: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
        property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n";
    const VERTICES: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

    fn read(content: &[u8]) -> Result<TriangleMesh, String> {
        let files = FilesInMemory::from([("mesh.ply", content)]);
        read_mesh_from(&files, "mesh.ply", None).map(|read| read.mesh).map_err(|error| error.to_string())
    }

    #[test]
    fn polygons_become_fans() {
        let triangles = read(format!("{HEADER}{VERTICES}4 0 1 2 3\n3 0 1 2\n").as_bytes()).unwrap();
        assert_eq!(triangles.indices.len(), 3);
        assert_eq!(triangles.corners(1), [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0), Vec3::Y]);
    }

    #[test]
    fn reads_binary_files_with_other_properties() {
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
        let triangles = read(&content).unwrap();
        assert_eq!(triangles.corners(0), [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.5)));
        assert_eq!(triangles.attributes["red"], [255.0; 3]);
        assert!(triangles.uv.is_empty());
        // Every truncated file is refused.
        for length in 0..content.len() {
            assert!(read(&content[..length]).is_err(), "truncated to {length} bytes");
        }
        let cut = read(&content[..content.len() - 2]).unwrap_err();
        assert!(cut.contains("near byte "), "{cut}");
    }

    #[test]
    fn strips_turn_every_second_triangle_and_begin_again_after_minus_one() {
        let header = HEADER.replace("face 2", "tristrips 1").replace("uchar int", "int int");
        let strips = read(format!("{header}{VERTICES}8 0 1 3 2 -1 2 1 0\n").as_bytes()).unwrap();
        // All triangles of the first strip face up as its first one, and the triangle of the second strip faces down.
        assert_eq!(strips.indices, [[0, 1, 3], [1, 2, 3], [2, 1, 0]]);
        let message = read(format!("{header}{VERTICES}4 0 1 2 9\n").as_bytes()).unwrap_err();
        assert!(message.contains("strip 0 refers to vertex 9, but there are 4"), "{message}");
    }

    #[test]
    fn text_has_any_encoding_and_line_endings() {
        let text = format!("{HEADER}{VERTICES}4 0 1 2 3\n3 0 1 2\n");
        let expected = read(text.as_bytes()).unwrap();
        let utf16: Vec<u8> = format!("\u{feff}{text}").encode_utf16().flat_map(u16::to_be_bytes).collect();
        let files = [utf16, format!("\u{feff}{text}").into(), text.replace('\n', "\r\n").into()];
        assert!(files.iter().all(|bytes| read(bytes).unwrap() == expected));
        assert_eq!(read(&ply_bytes(&expected, DVec3::ZERO)).unwrap().indices, expected.indices);
    }

    #[test]
    fn positions_in_a_national_grid_keep_their_millimetres() {
        let origin = DVec3::new(455_000.0, 5_190_000.0, 3000.0);
        let positions = [Vec3::new(0.001, 0.0, 0.0), Vec3::new(0.0, 1.002, 0.0), Vec3::new(0.0, 0.0, 0.5)].into();
        let expected = TriangleMesh { positions, indices: vec![[0, 1, 2]], ..TriangleMesh::default() };
        for (name, bytes) in [
            ("mesh.ply", ply_bytes(&expected, origin)),
            ("mesh.obj", crate::mesh_files::obj_text(&expected, origin).into_bytes()),
        ] {
            let files = FilesInMemory::from([(name, &*bytes)]);
            let read = read_mesh_from(&files, name, None).unwrap();
            assert_eq!((read.origin, &read.notes[..]), (origin, &[][..]), "{name}");
            for (found, expected) in read.mesh.positions.iter().zip(&expected.positions) {
                assert!(found.distance(*expected) < 1e-8, "{name}: {found}");
            }
        }
        // Single precision has lost them.
        let mut coarse = expected;
        coarse.positions.iter_mut().for_each(|position| *position += origin.as_vec3());
        let files = FilesInMemory::from([("mesh.ply", &*ply_bytes(&coarse, DVec3::ZERO))]);
        let notes = read_mesh_from(&files, "mesh.ply", None).unwrap().notes;
        assert!(notes.iter().any(|note| note.contains("its coordinates are multiples of about")), "{notes:?}");
    }

    #[test]
    fn reads_texture_coordinates_by_their_common_names() {
        let header = HEADER.replace(
            "property float z\n",
            "property float z\nproperty float s\nproperty uchar wet\nproperty float t\n",
        );
        let vertices = "0 0 0 0.1 1 0.2\n1 0 0 0.3 2 0.4\n1 1 0 0.5 3 0.6\n0 1 0 0.7 4 0.8\n";
        let triangles = read(format!("{header}{vertices}4 0 1 2 3\n3 0 1 2\n").as_bytes()).unwrap();
        assert_eq!(triangles.uv[2], Vec2::new(0.5, 0.6));
        assert_eq!(triangles.attributes["wet"], [1.0, 2.0, 3.0, 4.0]);
    }

    #[test]
    fn reads_normals_of_any_length() {
        let normals = "property float z\nproperty float nx\nproperty float ny\nproperty double nz\n";
        let header = HEADER.replace("property float z\n", normals);
        let vertices = "0 0 0 0 0 2\n1 0 0 0 0 2\n1 1 0 1 0 1\n0 1 0 0 0 0\n";
        let triangles = read(format!("{header}{vertices}3 0 1 2\n3 0 2 3\n").as_bytes()).unwrap();
        let at_corner = |corner: usize| {
            let weights = std::array::from_fn(|k| if k == corner { 1.0 } else { 0.0 });
            triangles.normals.at(0, triangles.indices[0], weights).unwrap()
        };
        assert_eq!(at_corner(1), Vec3::Z);
        assert!(at_corner(2).abs_diff_eq(Vec3::new(0.5, 0.0, 0.5).normalize(), 1e-6));
        assert_eq!(triangles.normals.at(1, triangles.indices[1], [0.2, 0.3, 0.5]), None, "a vertex without a normal");
        let smooth = triangles.clone().smooth();
        assert_eq!(smooth, triangles, "the file's own normals stay");
        assert!(triangles.flat().normals.is_empty());
    }

    #[test]
    fn errors_are_one_line_and_name_the_file() {
        let face = "3 0 1 2\n";
        let mut no_faces = HEADER.replace("element face 2\nproperty list uchar int vertex_indices\n", "");
        write!(no_faces, "{VERTICES}").unwrap();
        let cases = [
            (String::new(), "not a readable PLY"),
            ("solid stl\n".into(), "not a readable PLY"),
            (format!("{HEADER}{VERTICES}{face}"), "not a readable PLY"),
            (
                format!("{HEADER}0 0 0\n1 0 oops\n1 1 0\n0 1 0\n{face}{face}"),
                "mesh.ply:11: coordinate z of vertex 1 is \"oops\", but must be a number",
            ),
            (
                format!("{HEADER}0 0 0\n1 nan 0\n1 1 0\n0 1 0\n{face}{face}"),
                "mesh.ply:11: coordinate y of vertex 1 is NaN",
            ),
            (
                format!("{HEADER}0 0 0\n\n1 0,5 0\n1 1 0\n0 1 0\n{face}{face}"),
                "mesh.ply:12: coordinate y of vertex 1 is \"0,5\", but must be a number with a decimal point",
            ),
            (
                format!("{HEADER}0 0 0\n1 0\n1 1 0\n0 1 0\n{face}{face}"),
                "mesh.ply:11: coordinate z of vertex 1 is missing",
            ),
            (format!("{HEADER}{VERTICES}{face}3 0 1\n"), "property vertex_indices of face 1 is missing"),
            (
                format!("{HEADER}{VERTICES}{face}3 0 1 2.5\n"),
                "property vertex_indices of face 1 has \"2.5\", but must have whole",
            ),
            (format!("{HEADER}0 0 0\n"), "not a readable PLY"),
            (no_faces, "no faces"),
            (
                format!("{HEADER}0 0 0\n1 1e99 0\n1 1 0\n0 1 0\n{face}{face}"),
                "mesh.ply:11: coordinate y of vertex 1 is inf, but must be finite",
            ),
            (format!("{HEADER}{VERTICES}{face}3 0 1 4\n"), "face 1 refers to vertex 4"),
            (format!("{HEADER}{VERTICES}{face}3 0 1 -1\n"), "face 1 refers to vertex -1"),
            (format!("{HEADER}{VERTICES}2 0 1\n0\n"), "the mesh has no faces"),
            (
                HEADER.replace("uchar int vertex", "uchar float vertex") + VERTICES + face + face,
                "element face has no list `vertex_indices` of integers",
            ),
            (HEADER.replace(" z", " w") + VERTICES + face + face, "no coordinate `z`"),
            (HEADER.replace("vertex 4", "vertex 4000000000000000000") + VERTICES, "not a readable PLY"),
            (
                HEADER.replace("element face", "element junk 400000000000\nelement face") + VERTICES,
                "element junk has no properties",
            ),
        ];
        for (content, expected) in cases {
            let message = read(content.as_bytes()).unwrap_err();
            assert!(message.contains(expected) && message.contains("mesh.ply"), "{message}");
            assert!(!message.contains('\n'), "{message}");
        }
    }
}
