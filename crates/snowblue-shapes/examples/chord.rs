//! Depth of snow along a line through a mesh: `cargo run -p snowblue-shapes --example chord`.
//!
//! A line enters a closed surface as often as it leaves it, so its sorted crossings pair up, and the depth is the sum
//! of the segments inside.

#![allow(clippy::print_stdout, reason = "an example that prints its result")]

use std::error::Error;

use glam::{DAffine3, DVec3, Vec3, Vec3A};
use snowblue_geometry::instance::Instance;
use snowblue_geometry::mesh_bvh::MeshBvh;
use snowblue_geometry::ray::Ray;
use snowblue_geometry::transform::Transform;
use snowblue_shapes::height_field::Heights;

fn main() -> Result<(), Box<dyn Error>> {
    // Two ridges of snow, 0.4 m high, with a valley of 0.2 m between them: a closed mesh of 2 m × 1 m.
    let heights = Heights::new(5, [0.2, 0.4, 0.2, 0.4, 0.2].repeat(2))?;
    let mesh = MeshBvh::new(heights.solid(Vec3::new(2.0, 1.0, 1.0), 0.0)?);

    // The same mesh can stand in a scene many times. This one is moved upwards by 1 m.
    let transform = Transform::new(&DAffine3::from_translation(DVec3::Z)).ok_or("the transform is singular")?;
    let drift = Instance::new(mesh.into(), transform);

    for height_m in [1.1, 1.3] {
        let ray = Ray::new(Vec3A::new(-3.0, 0.0, height_m), Vec3A::X);
        let mut crossings = Vec::new();
        drift.crossings(&ray, &mut crossings);
        crossings.sort_by(|a, b| a.distance_m.total_cmp(&b.distance_m));

        println!("A level line at {height_m} m:");
        let mut depth_m = 0.0;
        for pair in crossings.chunks_exact(2) {
            let (enter_m, leave_m) = (pair[0].distance_m, pair[1].distance_m);
            println!("  in snow from {enter_m:.2} m to {leave_m:.2} m");
            depth_m += leave_m - enter_m;
        }
        println!("  depth {depth_m:.2} m");
    }
    Ok(())
}
