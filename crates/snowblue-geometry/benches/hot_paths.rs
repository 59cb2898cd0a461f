//! Rays through a mesh, on one thread: `cargo bench -p snowblue-geometry`.

#![allow(clippy::unwrap_used, reason = "a benchmark may panic")]

use std::f32::consts::{PI, TAU};

use divan::{Bencher, black_box};
use glam::{DAffine3, Vec3, Vec3A};
use snowblue_geometry::instance::Instance;
use snowblue_geometry::mesh_bvh::MeshBvh;
use snowblue_geometry::ray::Ray;
use snowblue_geometry::transform::Transform;
use snowblue_geometry::triangle_mesh::TriangleMesh;

fn main() {
    divan::main();
}

/// A sphere of a million triangles, radius 1 m.
fn sphere() -> Instance {
    const ROWS: u16 = 708;
    let place = |row: u16, column: u16| {
        let (polar, turn) = (PI * f32::from(row) / f32::from(ROWS), TAU * f32::from(column % ROWS) / f32::from(ROWS));
        Vec3::new(polar.sin() * turn.cos(), polar.sin() * turn.sin(), polar.cos())
    };
    let cells = (0..ROWS).flat_map(|row| (0..ROWS).map(move |column| (row, column)));
    let triangles: Vec<[Vec3; 3]> = cells
        .flat_map(|(row, column)| {
            let [a, b] = [column, column + 1].map(|column| place(row, column));
            let [c, d] = [column, column + 1].map(|column| place(row + 1, column));
            [[a, c, b], [b, c, d]]
        })
        .collect();
    let here = Transform::new(&DAffine3::IDENTITY).unwrap();
    Instance::new(MeshBvh::new(TriangleMesh::from_triangles(&triangles)).into(), here)
}

/// Incoherent rays through the sphere.
fn rays() -> Vec<Ray> {
    let ray = |number: u16| {
        let turn = 2.399_963 * f32::from(number);
        let height = 1.0 - (f32::from(number) + 0.5) / 512.0;
        let out = Vec3A::new(turn.cos(), turn.sin(), 0.0) * (1.0 - height * height).sqrt() + Vec3A::Z * height;
        let aside = out.any_orthonormal_vector() * (0.618_034 * f32::from(number)).fract();
        Ray::new(out * 3.0, (aside - out * 3.0).normalize())
    };
    (0..1024).map(ray).collect()
}

/// The first hit of a ray.
#[divan::bench]
fn first_hit_of_a_million_triangles(bencher: Bencher) {
    let (mesh, rays) = (sphere(), rays());
    let mut next = 0;
    bencher.bench_local(|| {
        next = (next + 1) % rays.len();
        mesh.first_hit(black_box(&rays[next]), f32::INFINITY)
    });
}

/// All crossings of a line.
#[divan::bench]
fn crossings_of_a_million_triangles(bencher: Bencher) {
    let (mesh, rays) = (sphere(), rays());
    let (mut next, mut crossings) = (0, Vec::new());
    bencher.bench_local(|| {
        next = (next + 1) % rays.len();
        crossings.clear();
        mesh.crossings(black_box(&rays[next]), &mut crossings);
        crossings.len()
    });
}
