//! Mesh files: PLY, Wavefront OBJ, STL, glTF 2.0 and GLB, chosen by file extension.

mod coordinates;
pub(crate) mod faces;
pub mod gltf;
mod obj;
mod ply;
mod stl;

use std::path::Path;

use snowblue_base::files::{FileError, FileSource, FilesIn, NamedFile, check_formats, extension};

use crate::mesh_files::coordinates::check_all_finite;
use crate::mesh_files::gltf::GltfFile;
use crate::triangle_mesh::TriangleMesh;

pub use faces::ReadMesh;
pub use obj::obj_text;
pub use ply::ply_bytes;
pub use stl::stl_bytes;

/// The extensions of mesh files.
pub const MESH_EXTENSIONS: [&str; 5] = ["ply", "obj", "stl", "gltf", "glb"];

/// Reads a mesh file, in the file's own unit and axes. The node transforms of a glTF are applied.
///
/// `part` selects a part by name: an object, group or material of an OBJ file, or a node or mesh of a glTF with its
/// descendants. PLY and STL files have no parts.
///
/// # Errors
///
/// When the extension is unknown, or the file cannot be read, is truncated or malformed, has no faces or no such part,
/// has a vertex that is not finite, or a face with an index out of range.
pub fn read_mesh_file(path: &Path, part: Option<&str>) -> Result<ReadMesh, FileError> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    read_mesh_from(&FilesIn::beside(path), &name, part)
}

/// Reads a mesh file from a source of files; otherwise as [`read_mesh_file`].
///
/// # Errors
///
/// As [`read_mesh_file`].
pub fn read_mesh_from(files: &dyn FileSource, name: &str, part: Option<&str>) -> Result<ReadMesh, FileError> {
    let path = files.display_name(name);
    let wrong = |reason: String| FileError::Content { path: path.clone(), reason };
    let read = match extension(&path).as_str() {
        "ply" if part.is_some() => return Err(wrong("a PLY file has no parts".into())),
        "stl" if part.is_some() => return Err(wrong("an STL file has no parts".into())),
        "ply" => {
            check_formats(&path)?;
            ply::read(&NamedFile::read(files, name)?)?
        }
        "obj" => obj::read(&NamedFile::read(files, name)?, part)?,
        "stl" => {
            check_formats(&path)?;
            ReadMesh { mesh: stl::read(&NamedFile::read(files, name)?)?, notes: Vec::new() }
        }
        "gltf" | "glb" => {
            check_formats(&path)?;
            let file = GltfFile::read(files, name)?;
            ReadMesh { mesh: file.mesh(part)?, notes: file.notes() }
        }
        other => {
            let [others @ .., last] = MESH_EXTENSIONS;
            let others = others.join(", ");
            return Err(wrong(format!("the extension is \"{other}\", but must be {others} or {last}")));
        }
    };
    check(&read.mesh).map_err(wrong)?;
    Ok(read)
}

/// Whether the format of a mesh file defines y as up, as glTF does.
pub fn is_y_up(path: &Path) -> bool {
    matches!(extension(path).as_str(), "gltf" | "glb")
}

/// Checks that there are faces, and that positions are finite.
fn check(mesh: &TriangleMesh) -> Result<(), String> {
    if mesh.indices.is_empty() {
        return Err("the mesh has no faces, but must have at least one".into());
    }
    check_all_finite(&mesh.positions)
}
