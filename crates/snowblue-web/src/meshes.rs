//! Mesh files of visitors as closed meshes.

use std::path::Path;

use serde_json::json;
use snowblue_base::files::FilesInMemory;
use snowblue_geometry::bounds::Bounds;
use snowblue_geometry::mesh_files::gltf::Y_UP_TO_Z_UP;
use snowblue_geometry::mesh_files::{ReadMesh, is_y_up, obj_text, read_mesh_from};
use snowblue_geometry::repair::repair;
use snowblue_geometry::topology::{Topology, volume};
use wasm_bindgen::prelude::*;

use crate::text;

/// Least volume of a solid, in cubes of the diagonal of its bounds. The volume of a sheet is only rounding.
const MIN_VOLUME: f64 = 1e-9;

/// A closed mesh with z upwards.
#[wasm_bindgen]
#[derive(Debug)]
pub struct ClosedMesh {
    about: String,
    obj: String,
}

/// Reads a PLY, OBJ, STL or GLB file and closes its holes.
///
/// # Errors
///
/// With the error message of the command, or if the mesh is open after the repair or has nothing inside.
#[wasm_bindgen]
pub fn closed_mesh(name: &str, content: &[u8]) -> Result<ClosedMesh, JsError> {
    closed(name, content).map_err(|reason| JsError::new(&reason))
}

#[wasm_bindgen]
impl ClosedMesh {
    /// JSON: the number of its triangles, its least coordinates and its lengths in the unit of the file, the number of
    /// edges of the holes that were filled, and notes on what of the file was not read.
    #[must_use]
    pub fn about(&self) -> String {
        self.about.clone()
    }

    /// The mesh as a Wavefront OBJ file.
    #[must_use]
    pub fn obj(&self) -> Vec<u8> {
        self.obj.clone().into_bytes()
    }
}

fn closed(name: &str, content: &[u8]) -> Result<ClosedMesh, String> {
    let mut files = FilesInMemory::default();
    files.insert(name, content);
    let ReadMesh { mut mesh, mut origin, notes } = read_mesh_from(&files, name, None).map_err(text)?;
    if is_y_up(Path::new(name)) {
        mesh.positions.iter_mut().for_each(|position| *position = (Y_UP_TO_Z_UP * position.as_dvec3()).as_vec3());
        origin = Y_UP_TO_Z_UP * origin;
    }
    let repaired = repair(&mesh, 0.0);
    let mesh = repaired.mesh;
    let topology = Topology::of(&mesh);
    if !topology.is_closed() {
        let Topology { open_edges, odd_shared_edges, .. } = topology;
        return Err(format!(
            "{name}: after a repair {open_edges} edges are still open and {odd_shared_edges} have an odd number of \
             triangles"
        ));
    }
    let bounds = Bounds::of(mesh.positions.iter().copied());
    if mesh.indices.is_empty() || volume(&mesh) < MIN_VOLUME * f64::from(bounds.diagonal_m()).powi(3) {
        return Err(format!("{name}: nothing is inside: the triangles are sheets"));
    }
    let about = json!({
        "triangles": mesh.indices.len(),
        "least": (origin + bounds.low.as_dvec3()).to_array(),
        "lengths": (bounds.high - bounds.low).to_array(),
        "open_edges": repaired.filled_holes.iter().sum::<usize>(),
        "notes": notes,
    });
    Ok(ClosedMesh { about: about.to_string(), obj: obj_text(&mesh, origin) })
}
