//! Makes a mesh closed, so that it can be snow: `mend IN.ply|obj|glb OUT.ply`.
//!
//! Vertices in one place become one, triangles without two sides go, and holes are filled; what is still open then is an
//! error, and nothing is written. The new file is a binary PLY of places and triangles alone.

#![allow(clippy::print_stderr, reason = "a program for people at a terminal")]

use std::io::Write as _;
use std::path::Path;
use std::process::ExitCode;

use snowblue_database::file::write_atomically;
use snowblue_render::geometry::triangle_mesh::TriangleMesh;
use snowblue_render::mesh_files::read_mesh_file;
use snowblue_render::mesh_tools::repair::repair;
use snowblue_render::mesh_tools::topology::Topology;

fn main() -> ExitCode {
    let arguments: Vec<_> = std::env::args_os().skip(1).collect();
    let [from, to] = arguments.as_slice() else {
        eprintln!("mend: needs two files, the mesh and where to write it");
        return ExitCode::from(2);
    };
    match run(Path::new(from), Path::new(to)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("mend: {reason}");
            ExitCode::FAILURE
        }
    }
}

fn run(from: &Path, to: &Path) -> Result<(), String> {
    let damaged = read_mesh_file(from, None).map_err(|error| error.to_string())?;
    let repaired = repair(&damaged);
    let topology = Topology::of(&repaired.mesh);
    if !topology.is_closed() {
        let (open, shared) = (topology.open_edges, topology.odd_shared_edges);
        return Err(format!("{}: {open} edges are open and {shared} are odd still", from.display()));
    }
    let written = write_atomically(to, |file| file.write_all(&ply(&repaired.mesh)));
    written.map_err(|error| format!("cannot write {}: {error}", to.display()))?;
    eprintln!(
        "{}: {} triangles, watertight ({} vertices merged, {} triangles dropped, holes filled: {})",
        to.display(),
        topology.triangles,
        repaired.merged_vertices,
        repaired.dropped_triangles,
        repaired.filled_holes.len()
    );
    Ok(())
}

/// A binary PLY file (Turk 1994).
fn ply(surface: &TriangleMesh) -> Vec<u8> {
    let mut content = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nelement face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        surface.positions.len(),
        surface.indices.len()
    )
    .into_bytes();
    content.extend(surface.positions.iter().flat_map(|place| place.to_array()).flat_map(f32::to_le_bytes));
    for corners in &surface.indices {
        content.push(3);
        content.extend(corners.iter().copied().flat_map(u32::to_le_bytes));
    }
    content
}
