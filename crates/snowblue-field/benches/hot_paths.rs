//! Grid and solution of a block, on one thread: `cargo bench -p snowblue-field`.

#![allow(clippy::unwrap_used, reason = "a benchmark may panic")]

use divan::{Bencher, black_box};
use glam::DVec3;
use snowblue_field::shapes::BoxBody;
use snowblue_field::{Diffusion, GridOptions, SnowBody, SolveOptions, SurfaceElement};
use wide::f32x4;

fn main() {
    divan::main();
}

const Q: f64 = 0.714;
/// Coarse cells, of 12 ℓ*: some 8,000 nodes.
const STEP_M: f64 = 0.024;
/// Two groups of four wavelengths.
const ABSORPTION_PER_M: [[f32; 4]; 2] = [[0.0015, 0.02, 0.08, 0.23], [0.003, 0.04, 0.12, 0.4]];

fn block() -> SnowBody {
    let snow = ABSORPTION_PER_M.map(|absorption| Diffusion {
        transport_length_m: f32x4::splat(0.002),
        absorption_per_m: f32x4::from(absorption),
    });
    let body = BoxBody::aligned(DVec3::ZERO, DVec3::new(0.6, 0.3, 0.6));
    let options = GridOptions { step_m: STEP_M, shift: DVec3::ZERO, sizes: None };
    SnowBody::uniform(&body, options, &snow, Q)
}

/// The grid and its matrices.
#[divan::bench]
fn grid_of_a_block(bencher: Bencher) {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    bencher.bench_local(|| one.install(block));
}

/// The solution for a lamp at a new position.
#[divan::bench]
fn solution_for_a_lamp(bencher: Bencher) {
    let block = block();
    let lamp = DVec3::new(0.1, 0.6, 0.05).as_vec3();
    let lit = |element: &SurfaceElement| {
        let way = lamp - element.point;
        f32x4::splat(element.normal.dot(way).max(0.0) / way.length().powi(3))
    };
    let light: Vec<f32x4> = block.surface().iter().map(lit).collect();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let light = [light.clone(), light];
    bencher.bench_local(|| one.install(|| block.solve(black_box(&light), SolveOptions::default())));
}
