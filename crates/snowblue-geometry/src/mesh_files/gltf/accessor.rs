//! glTF accessors: numbers read from buffers with all lengths checked (glTF 2.0 specification, section 3.6, Khronos
//! Group 2021).

use gltf::Accessor;
use gltf::accessor::{DataType, Dimensions};

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
