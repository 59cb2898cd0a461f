//! Closes a mesh with small defects, so that it can be snow.
//!
//! Merges coincident vertices, drops degenerate triangles and fills holes. If the mesh is still open then, the task
//! fails and writes nothing. The output is a binary PLY file of positions and triangles.

use std::error::Error;
use std::io::Write as _;
use std::path::Path;

use snowblue_base::atomic_file::write_atomically;
use snowblue_geometry::mesh_files::read_mesh_file;
use snowblue_geometry::repair::repair;
use snowblue_geometry::topology::Topology;
use snowblue_geometry::triangle_mesh::TriangleMesh;

/// Returns what was done.
pub(crate) fn run(input: &Path, output: &Path) -> Result<String, Box<dyn Error>> {
    let repaired = repair(&read_mesh_file(input, None)?);
    let topology = Topology::of(&repaired.mesh);
    if !topology.is_closed() {
        let (open, odd) = (topology.open_edges, topology.odd_shared_edges);
        return Err(format!("{}: {open} edges are still open and {odd} are shared oddly", input.display()).into());
    }
    write_atomically(output, |file| file.write_all(&ply(&repaired.mesh)))
        .map_err(|error| format!("cannot write {}: {error}", output.display()))?;
    Ok(format!(
        "{}: {} triangles, watertight ({} vertices merged, {} triangles dropped, holes filled: {})",
        output.display(),
        topology.triangles,
        repaired.merged_vertices,
        repaired.dropped_triangles,
        repaired.filled_holes.len()
    ))
}

/// A binary PLY file (Turk 1994).
fn ply(mesh: &TriangleMesh) -> Vec<u8> {
    let mut content = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nelement face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.indices.len()
    )
    .into_bytes();
    content.extend(mesh.positions.iter().flat_map(|position| position.to_array()).flat_map(f32::to_le_bytes));
    for triangle in &mesh.indices {
        content.push(3);
        content.extend(triangle.iter().copied().flat_map(u32::to_le_bytes));
    }
    content
}
