//! The content of a mesh file.

use glam::DVec3;

use crate::triangle_mesh::TriangleMesh;

/// The mesh of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadMesh {
    /// The mesh.
    pub mesh: TriangleMesh,
    /// The origin of its coordinates in the coordinates of the file, which single precision may be too coarse for.
    pub origin: DVec3,
    /// Sentences on content of the file that the mesh lacks.
    pub notes: Vec<String>,
}
