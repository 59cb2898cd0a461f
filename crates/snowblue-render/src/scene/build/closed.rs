//! Whether meshes of snow are closed. Integrators that solve for the light inside snow need it: through a hole, a line
//! enters and never leaves, and nothing says what is inside.

use crate::geometry::triangle_mesh::TriangleMesh;
use crate::mesh_tools::topology::Topology;

/// Refuses an open mesh.
pub(super) fn check_closed(mesh: &TriangleMesh) -> Result<(), String> {
    let topology = Topology::of(mesh);
    if topology.is_closed() {
        return Ok(());
    }
    let Topology { open_edges, odd_shared_edges, .. } = topology;
    let odd = match odd_shared_edges {
        0 => String::new(),
        count => format!(" and {count} edges of an odd number of triangles"),
    };
    Err(format!(
        "it has {open_edges} open edges{odd}, but this integrator needs closed snow; close its holes with \
         `cargo run -p xtask -- repair-mesh IN OUT.ply`"
    ))
}
