//! Thickness of a mesh along parallel lines on grids in three directions, as CSV on stdout.
//!
//! A row for each line: its origin and direction, the distance of the first hit, the number of crossings and the length
//! inside, all in the unit of the mesh. Numbers are printed in full precision, so that another program can trace the
//! same lines (`scripts/check_embree.py`).

use std::error::Error;
use std::io::{BufWriter, Write};
use std::path::Path;

use glam::Vec3A;
use snowblue_geometry::bounds::Bounds;
use snowblue_geometry::instance::Instance;
use snowblue_geometry::mesh_bvh::MeshBvh;
use snowblue_geometry::mesh_files::read_mesh_file;
use snowblue_geometry::ray::{Crossing, Ray};
use snowblue_geometry::transform::Transform;

/// Most lines along a side of a grid.
const MAX_LINES: u16 = 10_000;

/// Directions of the lines: an oblique one, one in a coordinate plane, and an axis.
const DIRECTIONS: [Vec3A; 3] = [Vec3A::new(0.36, -0.48, -0.8), Vec3A::new(-0.6, 0.0, -0.8), Vec3A::Y];

pub(crate) fn run(mesh: &Path, lines: &str) -> Result<(), Box<dyn Error>> {
    let Some(lines) = lines.parse().ok().filter(|lines| (1..=MAX_LINES).contains(lines)) else {
        return Err(format!("number of lines is {lines}, but must lie in 1–{MAX_LINES}").into());
    };
    let triangles = read_mesh_file(mesh, None)?;
    let bounds = Bounds::of(triangles.positions.iter().copied());
    let centred = triangles.centred();
    let transform = Transform::new(&centred.to_original).ok_or("the mesh has no extent")?;
    let instance = Instance::new(MeshBvh::new(centred.mesh).into(), transform);
    let mut out = BufWriter::new(std::io::stdout().lock());
    writeln!(out, "x,y,z,along_x,along_y,along_z,hit,crossings,thickness")?;
    for ray in DIRECTIONS.into_iter().flat_map(|direction| grid(&bounds, lines, direction)) {
        let hit = instance.first_hit(&ray, f32::INFINITY).map_or(f32::INFINITY, |hit| hit.distance_m);
        let mut crossings = Vec::new();
        instance.crossings(&ray, &mut crossings);
        for coordinate in ray.origin.to_array().into_iter().chain(ray.direction.to_array()) {
            write!(out, "{coordinate},")?;
        }
        writeln!(out, "{hit},{},{}", crossings.len(), thickness(&mut crossings))?;
    }
    out.flush()?;
    Ok(())
}

/// Parallel lines that cover the bounding sphere.
fn grid(bounds: &Bounds, lines: u16, direction: Vec3A) -> impl Iterator<Item = Ray> {
    let (u, v) = direction.any_orthonormal_pair();
    let (centre, radius) = (0.5 * (bounds.low + bounds.high), 0.5 * bounds.diagonal_m());
    let offset = move |step: u16| radius * (2.0 * (f32::from(step) + 0.5) / f32::from(lines) - 1.0);
    (0..lines).flat_map(move |row| {
        (0..lines).map(move |column| Ray {
            origin: centre - direction * (1.5 * radius) + u * offset(column) + v * offset(row),
            direction,
        })
    })
}

/// Length inside. An unpaired last crossing, where the mesh is open, does not count.
fn thickness(crossings: &mut [Crossing]) -> f32 {
    crossings.sort_unstable_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
    let (pairs, _) = crossings.as_chunks::<2>();
    pairs.iter().map(|[enter, leave]| leave.distance_m - enter.distance_m).sum()
}
