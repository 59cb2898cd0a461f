//! Maps of how thick a mesh is, along parallel lines on grids in three directions, as CSV on standard output:
//! `cargo run -p snowblue-render --example thickness_map -- MESH.ply 250`.
//!
//! A row per line: its origin and direction, the distance of the first hit, the number of crossings and the length inside,
//! all in the mesh's own unit. Numbers are as precise as they are traced, so that another program can trace the same
//! lines.

use std::io::{BufWriter, Write};
use std::path::Path;
use std::process::ExitCode;

use glam::Vec3A;
use snowblue_render::geometry::bounds::Bounds;
use snowblue_render::geometry::instance::Instance;
use snowblue_render::geometry::mesh_bvh::MeshBvh;
use snowblue_render::geometry::ray::{Crossing, Ray};
use snowblue_render::geometry::transform::Transform;
use snowblue_render::mesh_files::read_mesh_file;

/// Most lines along a side of the grid.
const GREATEST_SIDE: u16 = 10_000;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [mesh, lines] = &arguments[..] else {
        return refuse("usage: thickness_map MESH.ply|.obj|.glb LINES");
    };
    let Some(lines) = lines.parse().ok().filter(|lines| (1..=GREATEST_SIDE).contains(lines)) else {
        return refuse(&format!("lines along a side are {lines}, but must be a number in 1–{GREATEST_SIDE}"));
    };
    match write_map(Path::new(mesh), lines) {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => refuse(&reason),
    }
}

fn refuse(reason: &str) -> ExitCode {
    // There is no other place to tell it.
    let _ = writeln!(std::io::stderr(), "{reason}");
    ExitCode::from(2)
}

fn write_map(path: &Path, lines: u16) -> Result<(), String> {
    let triangles = read_mesh_file(path, None).map_err(|error| error.to_string())?;
    let box_around = Bounds::of(triangles.positions.iter().copied());
    let centred = triangles.centred();
    let placement = Transform::new(&centred.to_original).ok_or("the mesh has no extent")?;
    let instance = Instance::new(MeshBvh::new(centred.mesh).into(), placement);
    let mut out = BufWriter::new(std::io::stdout().lock());
    let failed = |error: std::io::Error| error.to_string();
    writeln!(out, "x,y,z,along_x,along_y,along_z,hit,crossings,thickness").map_err(failed)?;
    for ray in DIRECTIONS.into_iter().flat_map(|direction| grid(&box_around, lines, direction)) {
        let hit = instance.first_hit(&ray, f32::INFINITY).map_or(f32::INFINITY, |hit| hit.distance_m);
        let mut crossings = Vec::new();
        instance.crossings(&ray, &mut crossings);
        let (origin, along) = (ray.origin, ray.direction);
        writeln!(
            out,
            "{},{},{},{},{},{},{hit},{},{}",
            origin.x,
            origin.y,
            origin.z,
            along.x,
            along.y,
            along.z,
            crossings.len(),
            thickness(&mut crossings)
        )
        .map_err(failed)?;
    }
    out.flush().map_err(failed)
}

/// Directions of the lines: a slanting one, one in a plane of the axes, and an axis.
const DIRECTIONS: [Vec3A; 3] = [Vec3A::new(0.36, -0.48, -0.8), Vec3A::new(-0.6, 0.0, -0.8), Vec3A::Y];

/// Parallel lines that cover the ball around a box.
fn grid(box_around: &Bounds, lines: u16, direction: Vec3A) -> impl Iterator<Item = Ray> {
    let (side, ahead) = direction.any_orthonormal_pair();
    let (middle, radius) = (0.5 * (box_around.low + box_around.high), 0.5 * box_around.diagonal_m());
    let place = move |step: u16| radius * (2.0 * (f32::from(step) + 0.5) / f32::from(lines) - 1.0);
    (0..lines).flat_map(move |row| {
        (0..lines).map(move |column| Ray {
            origin: middle - direction * (1.5 * radius) + side * place(column) + ahead * place(row),
            direction,
        })
    })
}

/// The length inside; what is unpaired, where the mesh is open, is left out.
fn thickness(crossings: &mut [Crossing]) -> f32 {
    crossings.sort_unstable_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
    let (pairs, _) = crossings.as_chunks::<2>();
    pairs.iter().map(|[enter, leave]| leave.distance_m - enter.distance_m).sum()
}
