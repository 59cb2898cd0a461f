//! `snowblue repair`: closes a mesh with small defects, so that it can be snow.

use std::path::PathBuf;

use clap::Args;
use glam::DVec3;
use snowblue_base::ParameterRange;
use snowblue_geometry::bounds::Bounds;
use snowblue_geometry::mesh_files::gltf::Y_UP_TO_Z_UP;
use snowblue_geometry::mesh_files::{ReadMesh, is_y_up, obj_text, ply_bytes, read_mesh_file, stl_bytes};
use snowblue_geometry::repair::{RepairedMesh, repair};
use snowblue_geometry::topology::{Topology, volume};
use snowblue_geometry::triangle_mesh::TriangleMesh;

use crate::options::parse;
use crate::output::{Failure, Outcome, check_not_input, check_path, ending, output_path, print_notes, write_file};

/// Least volume of a solid, in cubes of the diagonal of its bounds. The volume of a sheet is only rounding.
const MIN_VOLUME: f64 = 1e-9;

/// The end of messages on meshes that are not closed.
const CLOSE_VERTICES: &str = "--merge-distance joins vertices that lie close together";

/// Distances within which vertices are joined.
const MERGE_DISTANCE: ParameterRange = ParameterRange::new("merge distance", 0.0, 1e6, "units of the file");

/// Close a mesh with small defects, so that it can be snow
#[derive(Debug, Args)]
#[command(after_help = "\
Vertices at the same position become one, and with --merge-distance vertices that lie close together. Triangles with \
coincident corners or that coincide with others are dropped. All triangles of a part are turned to face outwards, or \
inwards if the part is a cavity. Holes are filled. A mesh that is open then, where holes meet at a vertex or an edge \
belongs to three triangles, is an error. The output has positions and triangles only; a glTF is turned to z up.

'snowblue render --check' says what is wrong with the meshes of a scene.

Examples:
  snowblue repair scan.ply -o closed.ply
  snowblue repair model.glb --part body -o body.obj
  snowblue repair print.stl --merge-distance 0.01 -o print.ply")]
pub(crate) struct Repair {
    /// Mesh: .ply, .obj, .stl, .gltf or .glb
    #[arg(value_name = "MESH")]
    input: PathBuf,
    /// File to write: .ply (binary), .obj or .stl (binary)
    #[arg(short, long, value_name = "FILE", value_parser = output_path())]
    output: PathBuf,
    /// Object, group or material of an .obj, or node or mesh of a glTF, instead of all
    #[arg(long, value_name = "NAME")]
    part: Option<String>,
    /// Join vertices up to this distance, in the file's unit; those at the same position are always joined
    #[arg(long, value_name = "LENGTH", default_value = "0", value_parser = parse::parameter(MERGE_DISTANCE))]
    merge_distance: f64,
}

impl Repair {
    pub(crate) fn run(&self, quiet: bool) -> Outcome {
        let (input, output) = (self.input.display(), self.output.display());
        let content: fn(&TriangleMesh, DVec3) -> Vec<u8> = match &*ending(&self.output, "ply") {
            "ply" => ply_bytes,
            "obj" => |mesh, origin| obj_text(mesh, origin).into_bytes(),
            "stl" => |mesh, _| stl_bytes(mesh),
            _ => return Err(Failure::Input(format!("{output}: the repaired mesh must end in .ply, .obj or .stl"))),
        };
        check_not_input(&self.input, &self.output)?;
        check_path(&self.output)?;
        let ReadMesh { mut mesh, mut origin, notes } =
            read_mesh_file(&self.input, self.part.as_deref()).map_err(Failure::input)?;
        print_notes(quiet, notes.iter().map(|note| format!("{input}: {note}")));
        if is_y_up(&self.input) {
            mesh.positions.iter_mut().for_each(|position| *position = (Y_UP_TO_Z_UP * position.as_dvec3()).as_vec3());
            origin = Y_UP_TO_Z_UP * origin;
        }
        if origin != DVec3::ZERO && ending(&self.output, "ply") == "stl" {
            return Err(Failure::Input(format!(
                "{output}: an .stl is too coarse for coordinates near {origin}; write a .ply or an .obj"
            )));
        }
        let RepairedMesh { mesh, merged_vertices, dropped_triangles, turned_triangles: turned, filled_holes } =
            repair(&mesh, self.merge_distance);
        let topology = Topology::of(&mesh);
        if !topology.is_closed() {
            let Topology { open_edges, odd_shared_edges, .. } = topology;
            return Err(Failure::Input(format!(
                "{input}: {open_edges} edges are still open and {odd_shared_edges} have an odd number of triangles; \
                 {CLOSE_VERTICES}"
            )));
        }
        let size = Bounds::of(mesh.positions.iter().copied()).diagonal_m();
        if mesh.indices.is_empty() || volume(&mesh) < MIN_VOLUME * f64::from(size).powi(3) {
            return Err(Failure::Input(format!(
                "{input}: nothing is inside: the triangles are sheets; {CLOSE_VERTICES}"
            )));
        }
        write_file(&self.output, &content(&mesh, origin))?;
        let all = counted(topology.triangles, "triangle", "triangles");
        let merged = counted(merged_vertices, "vertex", "vertices");
        let dropped = counted(dropped_triangles, "triangle", "triangles");
        let filled = counted(filled_holes.len(), "hole", "holes");
        print_notes(
            quiet,
            [format!(
                "{output}: {all}, watertight ({merged} merged, {dropped} dropped, {turned} turned, {filled} filled)"
            )],
        );
        Ok(())
    }
}

/// A number of things, in the singular or plural.
fn counted(count: usize, singular: &str, plural: &str) -> String {
    format!("{count} {}", if count == 1 { singular } else { plural })
}
