//! The unevenness of snow that was cut, trodden or blown: smooth noise in space, the same for the same seed everywhere.

use glam::{DVec3, IVec3};

/// Noise is made of this many layers, each twice as fine and about half as high as the one before.
const LAYERS: u32 = 4;

/// Smooth noise of mean 0, mostly within ±1, that varies over about `size_m` and in finer layers over less.
pub(crate) fn relief(at: DVec3, size_m: f64, seed: u32) -> f64 {
    let layer = |number: u32| {
        let finer = f64::from(1 << number);
        // Layers are moved apart, lest their lattices meet in the origin.
        value(at * (finer / size_m) + 17.3 * f64::from(number), seed.wrapping_add(number)) / finer
    };
    (0..LAYERS).map(layer).sum()
}

/// Numbers at the corners of a lattice of unit cells, joined smoothly (Perlin 2002, "Improving noise",
/// doi:10.1145/566654.566636, for the polynomial 6t⁵ − 15t⁴ + 10t³).
fn value(at: DVec3, seed: u32) -> f64 {
    let cell = at.floor();
    let within = at - cell;
    let weight = within * within * within * (within * (within * 6.0 - 15.0) + 10.0);
    (0..8)
        .map(|corner: i32| {
            let step = IVec3::new(corner & 1, (corner >> 1) & 1, corner >> 2);
            let share = DVec3::select(step.cmpeq(IVec3::ONE), weight, 1.0 - weight);
            share.element_product() * (2.0 * uniform(cell.as_ivec3() + step, seed) - 1.0)
        })
        .sum()
}

/// A number in [0, 1) that looks random, of a place and a seed: the mixing steps of `MurmurHash3` (Appleby 2011).
pub(crate) fn uniform(place: IVec3, seed: u32) -> f64 {
    let mixed = place.to_array().into_iter().fold(seed ^ 0x9e37_79b9, |mixed, coordinate| {
        let part = coordinate.cast_unsigned().wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
        (mixed ^ part).rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64)
    });
    let mixed = (mixed ^ (mixed >> 16)).wrapping_mul(0x85eb_ca6b);
    let mixed = (mixed ^ (mixed >> 13)).wrapping_mul(0xc2b2_ae35);
    f64::from(mixed ^ (mixed >> 16)) / (f64::from(u32::MAX) + 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_smooth_centred_and_of_its_seed() {
        let places = || (0..4000).map(|k| DVec3::new(0.013 * f64::from(k), 0.7, -0.021 * f64::from(k)));
        let values: Vec<f64> = places().map(|at| relief(at, 0.3, 5)).collect();
        let mean = values.iter().sum::<f64>() / 4000.0;
        // Some 170 independent cells of deviation below 0.5: a mean of ±0.04, here within 4 deviations.
        assert!(mean.abs() < 0.16, "{mean}");
        assert!(values.iter().any(|&value| value > 0.4) && values.iter().any(|&value| value < -0.4));
        for at in places().take(200) {
            // The steepest a layer can be is 2 · 15/8 · √3 per cell, and all layers are equally steep.
            let steepest = 4.0 * 2.0 * 1.875 * 3f64.sqrt() / 0.3;
            assert!((relief(at + DVec3::X * 1e-6, 0.3, 5) - relief(at, 0.3, 5)).abs() < steepest * 1e-6);
        }
        assert!((relief(DVec3::ONE, 0.3, 5) - relief(DVec3::ONE, 0.3, 6)).abs() > 1e-3);
    }
}
