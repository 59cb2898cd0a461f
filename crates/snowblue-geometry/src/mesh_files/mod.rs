//! Mesh files: PLY, Wavefront OBJ, STL, glTF 2.0 and GLB, chosen by file extension.

mod coordinates;
pub(crate) mod faces;
pub mod gltf;
mod obj;
mod ply;
mod read_mesh;
mod stl;

use std::path::Path;

use glam::DVec3;
use snowblue_base::files::{FileError, FileSource, FilesIn, NamedFile, check_formats, extension};
use snowblue_base::short_number;

use crate::bounds::Bounds;
use crate::mesh_files::coordinates::check_all_finite;
use crate::mesh_files::gltf::GltfFile;
use crate::triangle_mesh::TriangleMesh;

pub use obj::obj_text;
pub use ply::ply_bytes;
pub use read_mesh::ReadMesh;
pub use stl::stl_bytes;

/// The extensions of mesh files.
pub const MESH_EXTENSIONS: [&str; 5] = ["ply", "obj", "stl", "gltf", "glb"];

/// Reads a mesh file, in the file's own unit and axes, from an origin near the mesh. The node transforms of a glTF are
/// applied.
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
    let mut read = match extension(&path).as_str() {
        "ply" if part.is_some() => return Err(wrong("a PLY file has no parts".into())),
        "stl" if part.is_some() => return Err(wrong("an STL file has no parts".into())),
        "ply" => {
            check_formats(&path)?;
            ply::read(&NamedFile::read(files, name)?)?
        }
        "obj" => obj::read(&NamedFile::read(files, name)?, part)?,
        "stl" => {
            check_formats(&path)?;
            ReadMesh { mesh: stl::read(&NamedFile::read(files, name)?)?, origin: DVec3::ZERO, notes: Vec::new() }
        }
        "gltf" | "glb" => {
            check_formats(&path)?;
            GltfFile::read(files, name)?.mesh(part)?
        }
        other => {
            let [others @ .., last] = MESH_EXTENSIONS;
            let others = others.join(", ");
            return Err(wrong(format!("the extension is \"{other}\", but must be {others} or {last}")));
        }
    };
    check(&read.mesh).map_err(wrong)?;
    read.notes.extend(coarse_note(&read));
    Ok(read)
}

/// A note on positions of single precision that are so far from the origin of the file that they are coarse for the
/// mesh.
fn coarse_note(ReadMesh { mesh, origin, .. }: &ReadMesh) -> Option<String> {
    /// Ratio of the size of the mesh to the spacing of its coordinates below which they are coarse.
    const COARSE: f64 = 1e4;
    let exact = || mesh.positions.iter().map(|position| position.as_dvec3() + origin);
    let spacing = exact().map(|position| position.abs().max_element()).fold(0.0, f64::max) * f64::from(f32::EPSILON);
    let size = f64::from(Bounds::of(mesh.positions.iter().copied()).diagonal_m());
    let is_coarse = spacing * COARSE > size && exact().all(|position| position.as_vec3().as_dvec3() == position);
    is_coarse.then(|| {
        format!(
            "its coordinates are multiples of about {}, which is coarse for a size of {}: export it near the origin, \
             as PLY with `double` coordinates, or as OBJ",
            short_number(spacing),
            short_number(size)
        )
    })
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
