//! Checks of a glTF.
//!
//! [`valid`] refuses files that require extensions that are not read. It checks the conditions under which the `gltf`
//! crate does not panic, since it unwraps: all indices are in range, and everything that a part requires is present.
//! [`numbers`]: accessors are read from buffers with all lengths checked (glTF 2.0 specification, section 3.6, Khronos
//! Group 2021). The readers of the crate check less, and take integers for single-precision numbers.

use std::borrow::Cow;

use glam::DVec3;
use gltf::accessor::sparse::IndexType;
use gltf::accessor::{DataType, Dimensions};
use gltf::binary::Glb;
use gltf::buffer::View;
use gltf::json::camera::Type;
use gltf::json::deserialize::from_slice;
use gltf::json::mesh::Semantic;
use gltf::json::validation::{Checked, Validate};
use gltf::json::{Root, Value};
use gltf::{Accessor, Document};
use snowblue_base::files::{MAX_NAMED, check_memory, decode_text, first_names, one_line};

/// Length of the header of a GLB, in bytes: three numbers of 32 bits. The last number is the length of the file.
const GLB_HEADER: usize = 12;

/// The extensions that are read, and an extension that only says which triangles were a polygon.
pub(super) const READ_EXTENSIONS: [&str; 7] = [
    "EXT_mesh_gpu_instancing",
    "FB_ngon_encoding",
    "KHR_lights_punctual",
    "KHR_materials_ior",
    "KHR_materials_transmission",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// The content of a file.
#[derive(Debug)]
pub(super) struct ValidGltf {
    pub(super) document: Document,
    /// The binary chunk.
    pub(super) blob: Option<Vec<u8>>,
    /// The translation of each node in double precision, unlike in the document; none if it is not stated.
    pub(super) translations: Vec<Option<DVec3>>,
}

/// Reads a glTF or GLB, such that access to its parts does not panic.
pub(super) fn valid(bytes: &[u8]) -> Result<ValidGltf, String> {
    if let (true, Some(&[a, b, c, d])) = (bytes.starts_with(b"glTF"), bytes.get(8..GLB_HEADER)) {
        let length = u32::from_le_bytes([a, b, c, d]);
        if (length as usize) < GLB_HEADER {
            return Err(format!("its length is {length} bytes, but must be at least {GLB_HEADER} bytes"));
        }
    }
    let (text, blob) = if bytes.starts_with(b"glTF") {
        let Glb { json, bin, .. } = Glb::from_slice(bytes).map_err(|error| one_line(&error.to_string()))?;
        (json, bin.map(Cow::into_owned))
    } else {
        (decode_text(bytes).into_owned().into_bytes().into(), None)
    };
    let mut root: Root = from_slice(&text).map_err(|error| one_line(&error.to_string()))?;
    let json: Value = from_slice(&text).map_err(|error| one_line(&error.to_string()))?;
    let translations = json["nodes"].as_array().into_iter().flatten().map(translation).collect();
    check_required(&root)?;
    // The crate refuses extensions that it does not know.
    root.extensions_required.clear();
    // The crate's own validation looks up this accessor without a check.
    check_positions(&root)?;
    let (mut named, mut count) = (Vec::new(), 0);
    root.validate(&root, gltf::json::Path::new, &mut |path, error| {
        count += 1;
        if named.len() < MAX_NAMED {
            named.push(format!("{} {error}", path()));
        }
    });
    if count > 0 {
        return Err(first_names(&named, count));
    }
    check_images_and_cameras(&root)?;
    Ok(ValidGltf { document: Document::from_json_without_validation(root), blob, translations })
}

/// The translation of a node, alone or in its matrix.
fn translation(node: &Value) -> Option<DVec3> {
    let number = |key: &str, place: usize| node[key].get(place)?.as_f64();
    let vector = |key: &str, first: usize| {
        Some(DVec3::new(number(key, first)?, number(key, first + 1)?, number(key, first + 2)?))
    };
    vector("translation", 0).or_else(|| vector("matrix", 12))
}

/// Refuses extensions without which the file has another meaning, and says how to write the file without them.
fn check_required(root: &Root) -> Result<(), String> {
    let unknown = root.extensions_required.iter().find(|name| !READ_EXTENSIONS.contains(&name.as_str()));
    let Some(name) = unknown else { return Ok(()) };
    let way_out = match name.as_str() {
        "KHR_draco_mesh_compression" => "export it from Blender with Data > Compression switched off",
        "EXT_meshopt_compression" | "KHR_meshopt_compression" => "run `gltfpack` without `-c`, `-cc` and `-cz`",
        "KHR_texture_basisu" => "run `gltfpack` without `-tc`, with textures as PNG or JPEG",
        "EXT_texture_webp" | "EXT_texture_avif" => "write its textures as PNG or JPEG (in Blender: Images > Automatic)",
        _ => "export it without this extension",
    };
    Err(format!("it requires the extension {name}, which is not read: {way_out}"))
}

fn check_positions(root: &Root) -> Result<(), String> {
    let count = root.accessors.len();
    for (number, mesh) in root.meshes.iter().enumerate() {
        for primitive in &mesh.primitives {
            let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
            if let Some(index) = positions.map(|index| index.value()).filter(|index| *index >= count) {
                return Err(format!("the positions of mesh {number} are accessor {index}, but there are {count}"));
            }
        }
    }
    Ok(())
}

/// An image is a file, or a part of a buffer with its type. A camera has the lens of its type.
fn check_images_and_cameras(root: &Root) -> Result<(), String> {
    let image = root.images.iter().position(|image| match image.buffer_view {
        Some(_) => image.mime_type.is_none(),
        None => image.uri.is_none(),
    });
    let camera = root.cameras.iter().position(|camera| match camera.type_ {
        Checked::Valid(Type::Perspective) => camera.perspective.is_none(),
        Checked::Valid(Type::Orthographic) => camera.orthographic.is_none(),
        Checked::Invalid => true,
    });
    match (image, camera) {
        (Some(image), _) => Err(format!("image {image} has neither a `uri` nor a `bufferView` with its `mimeType`")),
        (_, Some(camera)) => Err(format!("camera {camera} has no lens of its type")),
        (None, None) => Ok(()),
    }
}

/// The numbers of an accessor, element by element. Normalised integers become fractions of 1. Without data, numbers
/// are 0; a sparse accessor replaces some of its elements.
///
/// # Errors
///
/// When the elements have other dimensions or reach beyond the end of their buffer, or take too much memory.
pub(super) fn numbers(accessor: &Accessor, dimensions: Dimensions, buffers: &[Vec<u8>]) -> Result<Vec<f64>, String> {
    let wrong = |reason: &str| format!("accessor {} {reason}", accessor.index());
    if accessor.dimensions() != dimensions {
        let found = accessor.dimensions();
        return Err(wrong(&format!("has elements of type {found:?}, but must have {dimensions:?}")));
    }
    let width = dimensions.multiplicity();
    let own = Elements { kind: accessor.data_type(), is_normalized: accessor.normalized(), width, buffers };
    let beyond = || wrong("reaches beyond the end of its buffer: the file is truncated or malformed");
    let read = |elements: Elements, view, offset, count| elements.read(&view, offset, count).ok_or_else(beyond);
    let mut values = match accessor.view() {
        Some(view) => read(own, view, accessor.offset(), accessor.count())?,
        None => {
            let count = accessor.count().saturating_mul(width);
            check_memory("its numbers", 8.0 * count as f64, buffers.iter().map(Vec::len).sum())
                .map_err(|reason| wrong(&format!("is too large: {reason}")))?;
            vec![0.0; count]
        }
    };
    if let Some(sparse) = accessor.sparse() {
        let kind = match sparse.indices().index_type() {
            IndexType::U8 => DataType::U8,
            IndexType::U16 => DataType::U16,
            IndexType::U32 => DataType::U32,
        };
        let index = Elements { kind, is_normalized: false, width: 1, buffers };
        let indices = read(index, sparse.indices().view(), sparse.indices().offset(), sparse.count())?;
        let replaced = read(own, sparse.values().view(), sparse.values().offset(), sparse.count())?;
        for (index, element) in indices.into_iter().zip(replaced.chunks_exact(width)) {
            let place = values.chunks_exact_mut(width).nth(whole(index) as usize);
            place.ok_or_else(|| wrong(&format!("replaces element {index}, but has fewer")))?.copy_from_slice(element);
        }
    }
    Ok(values)
}

/// An index that was read as a number.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "indices are unsigned integers of at most 32 bits"
)]
pub(super) fn whole(index: f64) -> u32 {
    index as u32
}

/// How elements lie in buffers.
#[derive(Clone, Copy)]
struct Elements<'file> {
    kind: DataType,
    is_normalized: bool,
    /// Numbers of an element.
    width: usize,
    buffers: &'file [Vec<u8>],
}

impl Elements<'_> {
    /// The numbers of `count` elements from `offset` in a view; none if they reach beyond the end of their buffer.
    fn read(self, view: &View, offset: usize, count: usize) -> Option<Vec<f64>> {
        let buffer = self.buffers.get(view.buffer().index())?;
        let part = buffer.get(view.offset()..view.offset().checked_add(view.length())?)?;
        let size = self.kind.size() * self.width;
        let stride = view.stride().unwrap_or(size);
        let Some(last) = count.checked_sub(1) else { return Some(Vec::new()) };
        if last.checked_mul(stride)?.checked_add(offset)?.checked_add(size)? > part.len() {
            return None;
        }
        let elements =
            (0..count).flat_map(|element| part[offset + element * stride..][..size].chunks_exact(self.kind.size()));
        Some(elements.map(|bytes| value(bytes, self.kind, self.is_normalized)).collect())
    }
}

fn value(bytes: &[u8], kind: DataType, normalized: bool) -> f64 {
    let (value, greatest) = match (kind, bytes) {
        (DataType::U8, &[a]) => (f64::from(a), 255.0),
        (DataType::I8, &[a]) => (f64::from(a.cast_signed()), 127.0),
        (DataType::U16, &[a, b]) => (f64::from(u16::from_le_bytes([a, b])), 65_535.0),
        (DataType::I16, &[a, b]) => (f64::from(i16::from_le_bytes([a, b])), 32_767.0),
        (DataType::U32, &[a, b, c, d]) => (f64::from(u32::from_le_bytes([a, b, c, d])), 4_294_967_295.0),
        (DataType::F32, &[a, b, c, d]) => return f64::from(f32::from_le_bytes([a, b, c, d])),
        // Unreachable: the caller passes as many bytes as the type has.
        _ => (f64::NAN, 1.0),
    };
    if normalized { (value / greatest).max(-1.0) } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "camera": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 1}}],
        "images": [{"bufferView": 0, "mimeType": "image/png"}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36}], "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3,
        "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]}, {"bufferView": 0, "componentType": 5123,
        "count": 3, "type": "SCALAR"}]}"#;

    #[test]
    fn a_file_whose_parts_cannot_be_asked_for_is_refused() {
        assert!(valid(FILE.as_bytes()).is_ok());
        for (right, wrong, expected) in [
            (r#""POSITION": 0"#, r#""POSITION": 9"#, "the positions of mesh 0 are accessor 9, but there are 2"),
            (r#""indices": 1"#, r#""indices": 9"#, "meshes[0].primitives[0].indices"),
            (r#""scene": 0"#, r#""scene": 9"#, "scene"),
            (r#""nodes": [0]"#, r#""nodes": [9]"#, "scenes[0].nodes[0]"),
            (r#""mesh": 0"#, r#""mesh": 9"#, "nodes[0].mesh"),
            (r#""camera": 0"#, r#""camera": 9"#, "nodes[0].camera"),
            (
                r#"[{"bufferView": 0, "componentType""#,
                r#"[{"bufferView": 9, "componentType""#,
                "accessors[0].bufferView",
            ),
            (r#""buffer": 0"#, r#""buffer": 9"#, "bufferViews[0].buffer"),
            (r#", "mimeType": "image/png""#, "", "image 0 has neither a `uri` nor a `bufferView` with its `mimeType`"),
            (
                r#""perspective": {"yfov": 1"#,
                r#""orthographic": {"xmag": 1, "ymag": 1, "zfar": 1"#,
                "camera 0 has no lens",
            ),
        ] {
            let message = valid(FILE.replacen(right, wrong, 1).as_bytes()).unwrap_err();
            assert!(message.contains(expected) && !message.contains('\n'), "{message}");
        }
        let many = FILE.replacen("[0]", "[9, 9, 9, 9, 9]", 1);
        assert!(valid(many.as_bytes()).unwrap_err().ends_with(" and 2 more"));
        let message = valid(b"glTF\x02\0\0\0\x03\0\0\0").unwrap_err();
        assert_eq!(message, "its length is 3 bytes, but must be at least 12 bytes");
    }
}
