//! Checks of a glTF.
//!
//! [`valid`] checks the conditions under which the `gltf` crate does not panic, since it unwraps: all indices are in
//! range, and everything that a part requires is present. [`numbers`]: accessors are read from buffers with all
//! lengths checked (glTF 2.0 specification, section 3.6, Khronos Group 2021).

use gltf::accessor::{DataType, Dimensions};
use gltf::json::Root;
use gltf::json::camera::Type;
use gltf::json::mesh::Semantic;
use gltf::json::validation::{Checked, Validate};
use gltf::{Accessor, Document, Gltf};

/// Length of the header of a GLB, in bytes: three numbers of 32 bits. The last number is the length of the file.
const GLB_HEADER: usize = 12;

/// Greatest number of mistakes that a message names.
const MAX_NAMED: usize = 3;

/// Reads a glTF or GLB, such that access to its parts does not panic.
pub(super) fn valid(bytes: &[u8]) -> Result<Gltf, String> {
    if let (true, Some(&[a, b, c, d])) = (bytes.starts_with(b"glTF"), bytes.get(8..GLB_HEADER)) {
        let length = u32::from_le_bytes([a, b, c, d]);
        if (length as usize) < GLB_HEADER {
            return Err(format!("its length is {length} bytes, but must be at least {GLB_HEADER} bytes"));
        }
    }
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(|error| one_line(&error))?;
    let root = document.into_json();
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
        let more = if count > named.len() { format!(", and {} more", count - named.len()) } else { String::new() };
        return Err(format!("{}{more}", named.join(", ")));
    }
    check_images(&root)?;
    check_cameras(&root)?;
    Ok(Gltf { document: Document::from_json_without_validation(root), blob })
}

fn one_line(error: &gltf::Error) -> String {
    error.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
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

/// An image is a file, or a part of a buffer with its type.
fn check_images(root: &Root) -> Result<(), String> {
    let is_whole = |image: &gltf::json::Image| match image.buffer_view {
        Some(_) => image.mime_type.is_some(),
        None => image.uri.is_some(),
    };
    match root.images.iter().position(|image| !is_whole(image)) {
        Some(number) => Err(format!("image {number} has neither a `uri` nor a `bufferView` with its `mimeType`")),
        None => Ok(()),
    }
}

/// A camera has the lens of its type.
fn check_cameras(root: &Root) -> Result<(), String> {
    let is_whole = |camera: &gltf::json::Camera| match camera.type_ {
        Checked::Valid(Type::Perspective) => camera.perspective.is_some(),
        Checked::Valid(Type::Orthographic) => camera.orthographic.is_some(),
        Checked::Invalid => false,
    };
    match root.cameras.iter().position(|camera| !is_whole(camera)) {
        Some(number) => Err(format!("camera {number} has no lens of its type")),
        None => Ok(()),
    }
}

/// The numbers of an accessor, element by element. Normalised integers become fractions of 1.
///
/// # Errors
///
/// When the elements have other dimensions or reach beyond the end of their buffer, or when the accessor is sparse,
/// which is not supported.
pub(super) fn numbers(accessor: &Accessor, dimensions: Dimensions, buffers: &[Vec<u8>]) -> Result<Vec<f64>, String> {
    let number = accessor.index();
    let wrong = |reason: &str| format!("accessor {number} {reason}");
    if accessor.sparse().is_some() {
        return Err(wrong("is sparse, which is not supported"));
    }
    if accessor.dimensions() != dimensions {
        let (found, wanted) = (accessor.dimensions(), dimensions);
        return Err(format!("accessor {number} has elements of type {found:?}, but must have {wanted:?}"));
    }
    let view = accessor.view().ok_or_else(|| wrong("has no data"))?;
    let beyond = || wrong("reaches beyond the end of its buffer: the file is truncated or malformed");
    let part = buffers
        .get(view.buffer().index())
        .and_then(|buffer| buffer.get(view.offset()..view.offset().checked_add(view.length())?))
        .ok_or_else(beyond)?;
    let (size, width) = (accessor.size(), accessor.data_type().size());
    let stride = view.stride().unwrap_or(size);
    let end =
        accessor.count().saturating_sub(1).checked_mul(stride).and_then(|last| {
            last.checked_add(accessor.offset())?.checked_add(if accessor.count() > 0 { size } else { 0 })
        });
    if end.is_none_or(|end| end > part.len()) {
        return Err(beyond());
    }
    let mut values = Vec::with_capacity(accessor.count() * dimensions.multiplicity());
    for element in 0..accessor.count() {
        let start = accessor.offset() + element * stride;
        let bytes = &part[start..start + size];
        values.extend(bytes.chunks_exact(width).map(|bytes| value(bytes, accessor.data_type(), accessor.normalized())));
    }
    Ok(values)
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
        assert!(valid(many.as_bytes()).unwrap_err().ends_with(", and 2 more"));
        let message = valid(b"glTF\x02\0\0\0\x03\0\0\0").unwrap_err();
        assert_eq!(message, "its length is 3 bytes, but must be at least 12 bytes");
    }
}
