//! `snowblue repair`: closes a mesh with small defects, so that it can be snow.

use std::path::PathBuf;

use clap::Args;
use snowblue_geometry::bounds::Bounds;
use snowblue_geometry::mesh_files::gltf::Y_UP_TO_Z_UP;
use snowblue_geometry::mesh_files::{is_y_up, obj_text, ply_bytes, read_mesh_file};
use snowblue_geometry::repair::{RepairedMesh, repair};
use snowblue_geometry::topology::{Topology, volume};

use crate::output::{Failure, Outcome, check_not_input, check_path, ending, output_path, print_message, write_file};

/// Least volume of a solid, in cubes of the diagonal of its bounds. That of a sheet is rounding.
const LEAST_VOLUME: f64 = 1e-9;

/// Close a mesh with small defects, so that it can be snow
#[derive(Debug, Args)]
#[command(after_help = "\
Vertices at the same position become one. Triangles with coincident corners or that coincide with others are dropped. \
All triangles of a part are turned to face outwards. Holes are filled. A mesh that is open then, where holes meet at a \
vertex or an edge belongs to three triangles, is an error. The output has positions and triangles only; a glTF is \
turned to z up.

'snowblue render --check' says what is wrong with the meshes of a scene.

Examples:
  snowblue repair scan.ply -o closed.ply
  snowblue repair model.glb --part body -o body.obj")]
pub(crate) struct Repair {
    /// Mesh: .ply, .obj, .gltf or .glb
    #[arg(value_name = "MESH")]
    input: PathBuf,
    /// File to write: .ply (binary) or .obj
    #[arg(short, long, value_name = "FILE", value_parser = output_path())]
    output: PathBuf,
    /// Object or group of an .obj, or node or mesh of a glTF, instead of all
    #[arg(long, value_name = "NAME")]
    part: Option<String>,
}

impl Repair {
    pub(crate) fn run(&self, quiet: bool) -> Outcome {
        let (input, output) = (self.input.display(), self.output.display());
        let is_ply = match &*ending(&self.output, "ply") {
            "ply" => true,
            "obj" => false,
            _ => return Err(Failure::Input(format!("{output}: the repaired mesh must end in .ply or .obj"))),
        };
        check_not_input(&self.input, &self.output)?;
        check_path(&self.output)?;
        let mut mesh = read_mesh_file(&self.input, self.part.as_deref()).map_err(Failure::input)?;
        if is_y_up(&self.input) {
            mesh.positions.iter_mut().for_each(|position| *position = (Y_UP_TO_Z_UP * position.as_dvec3()).as_vec3());
        }
        let RepairedMesh { mesh, merged_vertices, dropped_triangles, turned_triangles, filled_holes } = repair(&mesh);
        let topology = Topology::of(&mesh);
        if !topology.is_closed() {
            let Topology { open_edges, odd_shared_edges, .. } = topology;
            return Err(Failure::Input(format!(
                "{input}: {open_edges} edges are still open and {odd_shared_edges} have an odd number of triangles"
            )));
        }
        let size = Bounds::of(mesh.positions.iter().copied()).diagonal_m();
        if mesh.indices.is_empty() || volume(&mesh) < LEAST_VOLUME * f64::from(size).powi(3) {
            return Err(Failure::Input(format!("{input}: nothing is inside: the triangles are sheets")));
        }
        write_file(&self.output, &if is_ply { ply_bytes(&mesh) } else { obj_text(&mesh).into_bytes() })?;
        if !quiet {
            print_message(&format!(
                "{output}: {} triangles, watertight ({merged_vertices} vertices merged, {dropped_triangles} triangles \
                 dropped, {turned_triangles} turned, {} holes filled)\n",
                topology.triangles,
                filled_holes.len()
            ));
        }
        Ok(())
    }
}
