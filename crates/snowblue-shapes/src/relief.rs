//! Surface relief of snow: smooth, seeded noise in space.

use glam::{DVec3, IVec3};

/// Number of octaves of noise, each with half the scale and about half the amplitude of the previous one.
const OCTAVES: u32 = 4;

/// Greatest magnitude of the noise.
pub(crate) const MAX_RELIEF: f64 = 2.0;

/// Smooth noise of mean 0, mostly within ±1. The scale of the coarsest octave is `size_m`.
pub(crate) fn relief(position: DVec3, size_m: f64, seed: u32) -> f64 {
    relief_above(position, size_m, 0.0, seed)
}

/// Noise as of [`relief`], without octaves whose scale is below `least_m`.
pub(crate) fn relief_above(position: DVec3, size_m: f64, least_m: f64, seed: u32) -> f64 {
    let octave = |number: u32| {
        let finer = f64::from(1 << number);
        // The octaves are shifted, so that their lattices do not coincide at the origin.
        value_noise(position * (finer / size_m) + 17.3 * f64::from(number), seed.wrapping_add(number)) / finer
    };
    (0..OCTAVES).take_while(|number| size_m >= least_m * f64::from(1 << number)).map(octave).sum()
}

/// Value noise: random numbers at the points of the integer lattice, interpolated by 6t⁵ − 15t⁴ + 10t³ (Perlin 2002,
/// "Improving noise", doi:10.1145/566654.566636).
fn value_noise(position: DVec3, seed: u32) -> f64 {
    let cell = position.floor();
    let within = position - cell;
    let weight = within * within * within * (within * (within * 6.0 - 15.0) + 10.0);
    let numbers = uniform_corners(cell.as_ivec3(), seed);
    2.0 * interpolate(weight, |x, y, z| numbers[x][y][z]) - 1.0
}

/// Interpolates between the values at the eight corners of a cell. `weight` holds the weights of the upper corners
/// along x, y and z.
#[inline]
pub(crate) fn interpolate(weight: DVec3, at: impl Fn(usize, usize, usize) -> f64) -> f64 {
    let lerp = |from: f64, to: f64, weight: f64| from + weight * (to - from);
    let along_x = |y: usize, z: usize| lerp(at(0, y, z), at(1, y, z), weight.x);
    let along_y = |z: usize| lerp(along_x(0, z), along_x(1, z), weight.y);
    lerp(along_y(0), along_y(1), weight.z)
}

/// A pseudo-random number in [0, 1) from lattice coordinates and a seed: the mixing steps of `MurmurHash3` (Appleby
/// 2011).
pub(crate) fn uniform(position: IVec3, seed: u32) -> f64 {
    unit(position.to_array().into_iter().fold(first_mix(seed), mix))
}

/// The pseudo-random numbers of the eight corners of a cell of the lattice, by their steps along x, y and z from its
/// lowest corner.
pub(crate) fn uniform_corners(cell: IVec3, seed: u32) -> [[[f64; 2]; 2]; 2] {
    let mut numbers = [[[0.0; 2]; 2]; 2];
    // Corners share the first steps of mixing.
    for (x, numbers) in (0..).zip(&mut numbers) {
        let mixed = mix(first_mix(seed), cell.x.wrapping_add(x));
        for (y, numbers) in (0..).zip(numbers) {
            let mixed = mix(mixed, cell.y.wrapping_add(y));
            for (z, number) in (0..).zip(numbers) {
                *number = unit(mix(mixed, cell.z.wrapping_add(z)));
            }
        }
    }
    numbers
}

fn first_mix(seed: u32) -> u32 {
    seed ^ 0x9e37_79b9
}

fn mix(mixed: u32, coordinate: i32) -> u32 {
    let part = coordinate.cast_unsigned().wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    (mixed ^ part).rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64)
}

/// The number in [0, 1) of mixed coordinates.
fn unit(mixed: u32) -> f64 {
    let mixed = (mixed ^ (mixed >> 16)).wrapping_mul(0x85eb_ca6b);
    let mixed = (mixed ^ (mixed >> 13)).wrapping_mul(0xc2b2_ae35);
    f64::from(mixed ^ (mixed >> 16)) / (f64::from(u32::MAX) + 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relief_is_smooth_and_centred_and_depends_on_the_seed() {
        let places = || (0..4000).map(|k| DVec3::new(0.013 * f64::from(k), 0.7, -0.021 * f64::from(k)));
        let values: Vec<f64> = places().map(|at| relief(at, 0.3, 5)).collect();
        let mean = values.iter().sum::<f64>() / 4000.0;
        // About 170 independent cells with standard deviations below 0.5: the mean lies within ±0.16 at 4 σ.
        assert!(mean.abs() < 0.16, "{mean}");
        assert!(values.iter().any(|&value| value > 0.4) && values.iter().any(|&value| value < -0.4));
        for at in places().take(200) {
            // The greatest slope of an octave is 2 · 15/8 · √3 per cell, and all octaves are equally steep.
            let steepest = 4.0 * 2.0 * 1.875 * 3f64.sqrt() / 0.3;
            assert!((relief(at + DVec3::X * 1e-6, 0.3, 5) - relief(at, 0.3, 5)).abs() < steepest * 1e-6);
        }
        assert!((relief(DVec3::ONE, 0.3, 5) - relief(DVec3::ONE, 0.3, 6)).abs() > 1e-3);
    }

    #[test]
    fn fine_octaves_can_be_left_out() {
        let at = DVec3::new(0.31, -0.17, 0.05);
        assert_eq!(relief_above(at, 0.4, 0.05, 3).to_bits(), relief(at, 0.4, 3).to_bits());
        assert_eq!(relief_above(at, 0.4, 0.3, 3).to_bits(), value_noise(at * (1.0 / 0.4), 3).to_bits());
        assert!(relief_above(at, 0.4, 0.5, 3).abs() <= 0.0);
        // The second octave adds at most half the height of the first.
        let second = relief_above(at, 0.4, 0.2, 3) - relief_above(at, 0.4, 0.3, 3);
        assert!(second.abs() > 1e-3 && second.abs() <= 0.5, "{second}");
    }
}
