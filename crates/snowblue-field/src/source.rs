//! Lamps inside a body.

use glam::DVec3;
use snowblue_base::narrow;
use wide::f32x4;

use crate::element::{CELL_PARTS, part_centre, shape};
use crate::grid::{Grid, Term};
use crate::system::Diffusion;

/// A lamp inside a body: a ball that emits evenly from its volume.
///
/// Outside the ball, its fluence rate equals the fluence rate of a point source of another power. The ball may
/// therefore be as wide as the grid needs.
#[derive(Debug, Clone)]
pub struct VolumeSource {
    /// Centre, in m.
    pub centre: DVec3,
    /// Least radius, in m. The ball is at least three cells wide.
    pub radius_m: f64,
    /// Power of the equivalent point source, in W, for each group of wavelengths.
    pub power: Vec<f32x4>,
}

/// Least radius of a source, in cells.
const MIN_CELLS: f64 = 1.5;

/// Adds the power of a source to a right-hand side, for one group of wavelengths. `diffusion` is the snow of each cell.
pub(crate) fn add_source(
    grid: &Grid,
    source: &VolumeSource,
    group: usize,
    diffusion: &[Diffusion],
    sums: &mut [f32x4],
) {
    let Some(number) = grid.number_at(source.centre) else { return };
    let radius_m = source.radius_m.max(MIN_CELLS * grid.cell_size(&grid.cells[number]).max_element());
    let mut parts: Vec<(usize, [f32; 3], f32)> = Vec::new();
    for (number, cell) in grid.cells.iter().enumerate() {
        let size = grid.cell_size(cell);
        let offset = (grid.cell_centre(cell) - source.centre).abs() - 0.5 * size;
        if offset.max(DVec3::ZERO).length_squared() > radius_m * radius_m {
            continue;
        }
        let low = grid.cell_centre(cell) - 0.5 * size;
        for part in 0..CELL_PARTS {
            let at = part_centre(part);
            if (low + at * size).distance_squared(source.centre) <= radius_m * radius_m {
                parts.push((number, at.as_vec3().to_array(), narrow(size.x * size.y * size.z)));
            }
        }
    }
    let volume: f32 = parts.iter().map(|(_, _, volume)| volume).sum();
    let density = source.power[group] * point_per_ball(&diffusion[number], radius_m) / f32x4::splat(volume);
    for (number, at, volume) in parts {
        for (node, value) in grid.cells[number].corners.iter().zip(shape(at)) {
            for Term { free, weight } in grid.terms(*node) {
                sums[*free as usize] += density * (volume * value * weight);
            }
        }
    }
}

/// Power of a ball divided by the power of the point source with an equal fluence rate outside the ball: z³ / (3 (z
/// cosh z − sinh z)) with z = κ_e a.
fn point_per_ball(snow: &Diffusion, radius_m: f64) -> f32x4 {
    let Diffusion { transport_length_m, absorption_per_m } = *snow;
    let (lengths, absorption) = (transport_length_m.to_array(), absorption_per_m.to_array());
    f32x4::from(std::array::from_fn(|k| {
        let z = (3.0 * f64::from(absorption[k]) / f64::from(lengths[k])).sqrt() * radius_m;
        // The series avoids a difference of nearly equal numbers.
        let ratio = if z < 0.1 { 1.0 - z * z / 10.0 } else { z * z * z / (3.0 * (z * z.cosh() - z.sinh())) };
        narrow(ratio)
    }))
}
