//! What a slope of 100 m × 100 m × 1 m with a hole of 10 cm costs, seen from 1 m above the hole:
//! `cargo run --release -p snowblue-field --example landscape`.

#![allow(clippy::print_stdout, reason = "an example")]

use std::slice::from_ref;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use glam::{DMat3, DVec3};
use snowblue_field::shapes::{BoxBody, BoxWithHole};
use snowblue_field::{
    AxisCrossing, Body, Diffusion, GridOptions, ScaledSizes, SizesByDistance, SnowBody, SolveOptions, fit_sizes,
};
use wide::f32x4;

/// Angle of a pixel, in rad: 1000 pixels over 57°.
const ANGLE_PER_PIXEL: f64 = 1e-3;

/// Size of the finest cells, in m: as far as 4 pixels at 1 m.
const STEP_M: f64 = 0.0039;
/// Memory for the grid, in MiB.
const MEMORY_MIB: u64 = 256;

/// A body that counts its lines.
struct Counted<'b> {
    body: &'b dyn Body,
    lines: [AtomicUsize; 3],
}

impl Body for Counted<'_> {
    fn bounds(&self) -> [DVec3; 2] {
        self.body.bounds()
    }

    fn crossings(&self, axis: usize, point: DVec3, crossings: &mut Vec<AxisCrossing>) {
        self.lines[axis].fetch_add(1, Ordering::Relaxed);
        self.body.crossings(axis, point, crossings);
    }
}

fn main() {
    let axes = DMat3::from_rotation_y(20_f64.to_radians());
    let size = DVec3::new(100.0, 100.0, 1.0);
    let top = axes * DVec3::new(0.0, 0.0, 0.5);
    let slope = BoxWithHole {
        outer: BoxBody { centre: DVec3::ZERO, size, axes },
        hole_centre: top,
        hole_size: DVec3::new(0.1, 0.1, 0.2),
    };
    let viewpoint = top + axes.z_axis;
    let sizes = SizesByDistance::of_picture(viewpoint, ANGLE_PER_PIXEL, 1.0, 0.002);
    let start = Instant::now();
    let (factor, nodes) = fit_sizes(&slope, STEP_M, &sizes, 1, MEMORY_MIB).expect("the grid fits into the memory");
    println!("sizes of the picture times {factor:.2}, some {nodes} nodes: {:.2?}", start.elapsed());
    let sizes = ScaledSizes { sizes: &sizes, factor };
    let counted = Counted { body: &slope, lines: [0, 1, 2].map(|_| AtomicUsize::new(0)) };
    let snow = Diffusion {
        transport_length_m: f32x4::splat(0.002),
        absorption_per_m: f32x4::from([0.0015, 0.02, 0.08, 0.23]),
    };
    let options = GridOptions { step_m: STEP_M, shift: DVec3::ZERO, sizes: Some(&sizes) };
    let start = Instant::now();
    let body = SnowBody::uniform(&counted, options, &[snow], 0.714);
    let built = start.elapsed();
    let up = axes.z_axis.as_vec3();
    let light: Vec<f32x4> = body.surface().iter().map(|one| f32x4::splat(one.normal.dot(up).max(0.0))).collect();
    let fluence = body.solve(from_ref(&light), SolveOptions::default());
    let solved = start.elapsed() - built;
    let lines = counted.lines.map(AtomicUsize::into_inner);
    println!("nodes: {}, surface elements: {}", body.node_count(), body.surface().len());
    println!("lines along x, y and z: {lines:?}");
    println!("grid and matrices of four wavelengths: {built:.2?}, solution: {solved:.2?}");
    println!("memory: {:.0} MB", body.bytes() as f64 / 1e6);
    for depth_m in [0.0, 0.1, 0.3] {
        let point = top - axes.z_axis * (0.1 + depth_m);
        let under = body.fluence(&fluence, point).map(|mut groups| groups.next().unwrap_or_default().to_array());
        let beside = point + axes.x_axis * 20.0 + axes.z_axis * 0.1;
        let beside = body.fluence(&fluence, beside).map(|mut groups| groups.next().unwrap_or_default().to_array());
        println!("fluence rate {depth_m} m under the hole: {under:.3?}, under the slope: {beside:.3?}");
    }
}
