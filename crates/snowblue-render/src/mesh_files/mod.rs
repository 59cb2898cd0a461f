//! Meshes from files: PLY, Wavefront OBJ, glTF 2.0 and GLB, told apart by the file's ending.

pub mod gltf;
mod obj;
mod ply;

use std::path::Path;

use crate::error::RenderError;
use crate::files::{FilesIn, SceneFile, SceneFiles, extension};
use crate::geometry::triangles::Triangles;
use crate::mesh_files::gltf::GltfFile;

/// The triangles of a mesh file, in the file's own unit and axes; of glTF with the transforms of its nodes.
///
/// `part` names a piece of it: an object or group of an OBJ file, a node of a glTF with all that hangs below it. PLY
/// files have no parts.
///
/// # Errors
///
/// When the file cannot be read, is cut short or malformed, has no faces or no such part, or has a vertex that is not
/// finite or a face that names a vertex which is not there; or when its ending is unknown.
pub fn read_triangles(path: &Path, part: Option<&str>) -> Result<Triangles, RenderError> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    triangles_of(&FilesIn::beside(path), &name, part)
}

/// The triangles of a mesh file that comes from anywhere; otherwise as [`read_triangles`].
///
/// # Errors
///
/// As those of [`read_triangles`].
pub fn triangles_of(files: &dyn SceneFiles, name: &str, part: Option<&str>) -> Result<Triangles, RenderError> {
    let path = files.display_name(name);
    let wrong = |reason: String| RenderError::Mesh { path: path.clone(), reason };
    let triangles = match extension(&path).as_str() {
        "ply" if part.is_some() => return Err(wrong("a PLY file has no parts; leave `part` out".into())),
        "ply" => ply::read(&SceneFile::read(files, name)?)?,
        "obj" => obj::read(&SceneFile::read(files, name)?, part)?,
        "gltf" | "glb" => GltfFile::read(files, name)?.all_triangles(part)?,
        other => return Err(wrong(format!("the ending is \"{other}\", but must be ply, obj, gltf or glb"))),
    };
    check(&triangles).map_err(wrong)?;
    Ok(triangles)
}

/// Whether a mesh file has y upwards by its format, as glTF says of itself.
pub fn is_y_up(path: &Path) -> bool {
    matches!(extension(path).as_str(), "gltf" | "glb")
}

/// Refuses what no mesh can be made of.
fn check(triangles: &Triangles) -> Result<(), String> {
    if triangles.corners.is_empty() {
        return Err("the mesh has no faces, but must have at least one".into());
    }
    for (number, place) in triangles.positions.iter().enumerate() {
        if let Some(value) = place.to_array().into_iter().find(|value| !value.is_finite()) {
            return Err(format!("a coordinate of vertex {number} is {value}, but must be finite"));
        }
    }
    let count = triangles.positions.len();
    for (number, corners) in triangles.corners.iter().enumerate() {
        if let Some(index) = corners.iter().find(|&&index| index as usize >= count) {
            return Err(format!("triangle {number} names vertex {index}, but there are {count} (0 is the first)"));
        }
    }
    Ok(())
}
