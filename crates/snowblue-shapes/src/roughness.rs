//! The height of a rough surface: a stationary random field in space whose statistics are known.
//!
//! It is a sum of octaves of gradient noise N of variance 1 (Perlin 1985, doi:10.1145/325334.325247; 2002,
//! doi:10.1145/566654.566636),
//!
//! ```text
//! h(x) = σ Σ √w_i N_i(x/λ_i),   λ_i = λ_0 2^{−i},   w_i ∝ λ_i^{2H},   Σ w_i = 1.
//! ```
//!
//! Below the correlation length the surface is self-affine with the Hurst exponent H: the mean square of the height
//! difference at a distance r is proportional to r^{2H}, down to the least wavelength. With H = 1/2 the
//! autocorrelation is nearly exponential.
//!
//! Each octave has a lattice of a random orientation and place, so that a plane passes through all parts of its cells.
//! Over all places and orientations the autocorrelation of N is
//!
//! ```text
//! ρ(r) = ⟨ Σ_k A(r_k) B(r_l) B(r_m) ⟩ / (3 A(0) B(0)²)
//! A(s) = ∫ t w(t) (t + s) w(t + s) dt,   B(s) = ∫ w(t) w(t + s) dt
//! ```
//!
//! where w is the weight of a lattice point, and the mean is over the directions of r with the components r_k, r_l,
//! r_m. The wavelength λ_0 is chosen such that Σ w_i ρ(r/λ_i) = 1/e at the correlation length.

use std::f64::consts::TAU;
use std::sync::LazyLock;

use glam::{DAffine3, DQuat, DVec3, IVec3};

use crate::relief::{interpolate, uniform, uniform_corners};

/// Least wavelength of an octave, in m. Smaller structures are the grains, which belong to the optics of the snow and
/// not to its surface.
pub const MIN_WAVELENGTH_M: f64 = 1e-3;
/// Edge lengths of a mesh, as fractions of a wavelength, between which an octave fades out. An octave is complete
/// where edges are shorter than the first length, and left out where edges are longer than the second length.
const EDGES_PER_WAVELENGTH: [f64; 2] = [0.55, 1.0];
/// Shortest edge length that the heights need, as a fraction of the least wavelength.
const MIN_EDGE: f64 = 0.25;
/// Greatest magnitude of gradient noise with unit gradients: the value in the middle of a cell if the gradients at all
/// corners point to the middle, 8 · (1/8) · √3/2.
const MAX_NOISE: f64 = 0.867;

/// The statistics of the heights of a rough surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoughnessStatistics {
    /// Root mean square of the heights, in m.
    pub height_m: f64,
    /// The distance at which the autocorrelation is 1/e, in m.
    pub correlation_m: f64,
    /// Hurst exponent, 0–1.
    pub hurst: f64,
}

/// A random field of heights.
#[derive(Debug, Clone)]
pub struct Roughness {
    /// The octaves, the greatest wavelength first.
    octaves: Vec<Octave>,
}

/// Gradient noise of one wavelength.
#[derive(Debug, Clone)]
struct Octave {
    wavelength_m: f64,
    /// Root mean square of its heights, in m.
    height_m: f64,
    /// Transform to the coordinates of its lattice.
    to_lattice: DAffine3,
    seed: u32,
}

impl Roughness {
    /// A field with the given statistics. Different seeds give different fields.
    pub fn new(statistics: &RoughnessStatistics, seed: u32) -> Self {
        let wavelengths_m = wavelengths_m(statistics);
        let weights = weights(&wavelengths_m, statistics.hurst);
        let octave = |(number, (wavelength_m, weight)): (u32, (&f64, f64))| {
            let seed = seed.wrapping_mul(0x9e37_79b9).wrapping_add(number);
            Octave {
                wavelength_m: *wavelength_m,
                height_m: statistics.height_m * weight.sqrt(),
                to_lattice: random_placement(seed) * DAffine3::from_scale(DVec3::splat(wavelength_m.recip())),
                seed,
            }
        };
        Self { octaves: (0..).zip(wavelengths_m.iter().zip(weights)).map(octave).collect() }
    }

    /// The height in m at a place in m, without the octaves that edges of a length in m cannot resolve.
    pub fn height_m(&self, place_m: DVec3, edge_m: f64) -> f64 {
        let heights = self.octaves.iter().map_while(|octave| {
            let share = octave.share(edge_m);
            (share > 0.0).then(|| {
                share * octave.height_m * gradient_noise(octave.to_lattice.transform_point3(place_m), octave.seed)
            })
        });
        heights.sum()
    }

    /// Shortest edge length that the heights need, in m.
    pub fn least_edge_m(&self) -> f64 {
        self.octaves.last().map_or(f64::INFINITY, |octave| MIN_EDGE * octave.wavelength_m)
    }

    /// Edge length from which on all octaves are left out, in m.
    pub fn greatest_edge_m(&self) -> f64 {
        self.octaves.first().map_or(0.0, |octave| EDGES_PER_WAVELENGTH[1] * octave.wavelength_m)
    }

    /// Upper bound of the magnitude of the heights, in m.
    pub fn greatest_m(&self) -> f64 {
        MAX_NOISE * INVERSE_DEVIATION * self.octaves.iter().map(|octave| octave.height_m).sum::<f64>()
    }

    /// Root mean square of the slope of the surface.
    pub fn slope(&self) -> f64 {
        let of_octave = |octave: &Octave| (octave.height_m / octave.wavelength_m).powi(2);
        let sum: f64 = self.octaves.iter().map(of_octave).sum();
        // Two of the three directions lie in the surface.
        (2.0 / 3.0 * SQUARE_OF_GRADIENT * sum).sqrt()
    }
}

impl Octave {
    /// Share of the octave that edges of a length in m resolve, 0–1.
    fn share(&self, edge_m: f64) -> f64 {
        let [whole, none] = EDGES_PER_WAVELENGTH.map(|edges| edges * self.wavelength_m);
        let share = ((none - edge_m) / (none - whole)).clamp(0.0, 1.0);
        share * share * (3.0 - 2.0 * share)
    }
}

/// A random rotation and shift of a lattice: all points of a cell are equally likely to lie at the origin.
fn random_placement(seed: u32) -> DAffine3 {
    // These lattice points are far from the lattice points whose gradients any place uses.
    let number = |axis: i32| uniform(IVec3::new(i32::MIN, i32::MIN, axis), seed);
    // A quaternion that is uniform on the sphere (Shoemake 1992, "Uniform random rotations").
    let [share, first, second] = [0, 1, 2].map(number);
    let [(first_sin, first_cos), (second_sin, second_cos)] = [first, second].map(|turn| (TAU * turn).sin_cos());
    let [long, short] = [(1.0 - share).sqrt(), share.sqrt()];
    let rotation = DQuat::from_xyzw(first_sin * long, first_cos * long, second_sin * short, second_cos * short);
    DAffine3::from_rotation_translation(rotation, DVec3::from_array([3, 4, 5].map(number)))
}

/// The wavelengths of the octaves, in m, the greatest first.
fn wavelengths_m(statistics: &RoughnessStatistics) -> Vec<f64> {
    let octaves = |longest_m: f64| {
        let next = |wavelength_m: &f64| Some(0.5 * wavelength_m).filter(|half_m| *half_m >= MIN_WAVELENGTH_M);
        std::iter::successors(Some(longest_m), next).collect::<Vec<_>>()
    };
    let correlation = |longest_m: f64| {
        let wavelengths_m = octaves(longest_m);
        let of_octaves = wavelengths_m.iter().zip(weights(&wavelengths_m, statistics.hurst));
        of_octaves.map(|(own_m, weight)| weight * noise_correlation(statistics.correlation_m / own_m)).sum::<f64>()
    };
    let [mut low_m, mut high_m] = [0.5, 16.0].map(|factor| factor * statistics.correlation_m);
    for _ in 0..30 {
        let middle_m = 0.5 * (low_m + high_m);
        *(if correlation(middle_m) < (-1f64).exp() { &mut low_m } else { &mut high_m }) = middle_m;
    }
    octaves(0.5 * (low_m + high_m))
}

/// The shares of the octaves in the variance.
fn weights(wavelengths_m: &[f64], hurst: f64) -> Vec<f64> {
    let powers: Vec<f64> = wavelengths_m.iter().map(|wavelength_m| wavelength_m.powf(2.0 * hurst)).collect();
    let sum: f64 = powers.iter().sum();
    powers.into_iter().map(|power| power / sum).collect()
}

/// Gradient noise of mean 0 and variance 1.
fn gradient_noise(place: DVec3, seed: u32) -> f64 {
    let cell = place.floor();
    let within = place - cell;
    let weight = within * within * within * (within * (within * 6.0 - 15.0) + 10.0);
    let numbers = uniform_corners(cell.as_ivec3(), seed);
    let at = |x: usize, y: usize, z: usize| {
        let corner = DVec3::from_array([x, y, z].map(|step| step as f64));
        gradient(numbers[x][y][z]).dot(within - corner)
    };
    interpolate(weight, at) * INVERSE_DEVIATION
}

/// The gradient for a random number in [0, 1): a unit vector towards the middle of one of the twelve edges of a cube.
/// The mean of its outer product with itself is a third of the unit matrix.
fn gradient(number: f64) -> DVec3 {
    const PART: f64 = std::f64::consts::FRAC_1_SQRT_2;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number below 12")]
    let number = (12.0 * number) as u32;
    let sign = |bit: u32| if number & bit == 0 { PART } else { -PART };
    match number >> 2 {
        0 => DVec3::new(sign(1), sign(2), 0.0),
        1 => DVec3::new(0.0, sign(1), sign(2)),
        _ => DVec3::new(sign(1), 0.0, sign(2)),
    }
}

/// One over the standard deviation of gradient noise with unit gradients, 1/√(A(0) B(0)²).
const INVERSE_DEVIATION: f64 = 5.237_147_522;
/// The mean square of the gradient of gradient noise of variance 1 and wavelength 1, ∫ (t w)'² / A(0) + 2 ∫ w'² / B(0).
const SQUARE_OF_GRADIENT: f64 = 20.414_313;

/// Autocorrelation of gradient noise of wavelength 1 at a distance.
fn noise_correlation(distance: f64) -> f64 {
    /// Directions of the distance.
    const DIRECTIONS: u32 = 200;
    static TABLES: LazyLock<[Vec<f64>; 2]> = LazyLock::new(|| {
        let table =
            |factor: &dyn Fn(f64) -> f64| (0..=TABLE).map(|k| lagged(f64::from(k) / PER_UNIT, factor)).collect();
        [table(&|t| t * lattice_weight(t)), table(&lattice_weight)]
    });
    let read = |table: &[f64], lag: f64| {
        let place = lag * PER_UNIT;
        if place >= f64::from(TABLE) {
            return 0.0;
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an index of the table")]
        let first = place as usize;
        table[first] + (place - place.floor()) * (table[first + 1] - table[first])
    };
    let [a, b] = &*TABLES;
    let of_direction = |k: u32| {
        let height = (f64::from(k) + 0.5) / f64::from(DIRECTIONS);
        let (sin, cos) = (f64::from(k) * 2.399_963_229_728_653).sin_cos();
        let around = (1.0 - height * height).sqrt();
        let lag = DVec3::new(around * cos.abs(), around * sin.abs(), height) * distance;
        let [ax, ay, az] = lag.to_array().map(|lag| read(a, lag));
        let [bx, by, bz] = lag.to_array().map(|lag| read(b, lag));
        ax * by * bz + ay * bx * bz + az * bx * by
    };
    let sum: f64 = (0..DIRECTIONS).map(of_direction).sum();
    sum / (3.0 * a[0] * b[0] * b[0] * f64::from(DIRECTIONS))
}

/// Number of steps of the tables of [`noise_correlation`], and number of steps per unit of lag. Lags above 2 have no
/// correlation.
const TABLE: u32 = 256;
const PER_UNIT: f64 = 128.0;

/// ∫ f(t) f(t + lag) dt for a factor f that vanishes beyond ±1.
fn lagged(lag: f64, factor: &dyn Fn(f64) -> f64) -> f64 {
    const STEPS: u32 = 400;
    // From −1 to 1 − lag, by the midpoint rule.
    let step = (2.0 - lag).max(0.0) / f64::from(STEPS);
    let at = |k: u32| -1.0 + step * (f64::from(k) + 0.5);
    (0..STEPS).map(|k| factor(at(k)) * factor(at(k) + lag)).sum::<f64>() * step
}

/// The weight w of a lattice point at a distance along an axis.
fn lattice_weight(t: f64) -> f64 {
    let t = t.abs().min(1.0);
    1.0 - t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    impl Roughness {
        /// Autocorrelation of heights at a distance in m, over all places and directions in space.
        fn autocorrelation(&self, distance_m: f64) -> f64 {
            let variance: f64 = self.octaves.iter().map(|octave| octave.height_m.powi(2)).sum();
            let covariance =
                |octave: &Octave| octave.height_m.powi(2) * noise_correlation(distance_m / octave.wavelength_m);
            self.octaves.iter().map(covariance).sum::<f64>() / variance
        }
    }

    use super::*;

    const FIRN: RoughnessStatistics = RoughnessStatistics { height_m: 2e-3, correlation_m: 0.02, hurst: 0.5 };

    /// Heights on a square of a plane of any orientation, row by row, `step_m` apart.
    fn plane(roughness: &Roughness, side: u32, step_m: f64, turn: f64) -> Vec<f64> {
        let axes = DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(0.6, 0.64, 0.48), turn));
        let place = |k: u32| axes * DVec3::new(f64::from(k % side), f64::from(k / side), 0.3) * step_m;
        (0..side * side).map(|k| roughness.height_m(place(k), 0.0)).collect()
    }

    fn mean(values: impl Iterator<Item = f64>) -> f64 {
        let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
        sum / count
    }

    /// Heights at one place of many fields. The standard error of their mean square is √(2/400) = 7 %. The test allows
    /// 3 standard errors.
    #[test]
    fn no_place_is_special() {
        let statistics = RoughnessStatistics { height_m: 1e-3, correlation_m: 0.03, hurst: 0.7 };
        let square = |seed: u32| Roughness::new(&statistics, seed).height_m(DVec3::ZERO, 0.0).powi(2);
        let mean = (0..400).map(square).sum::<f64>() / 400.0;
        assert!((mean / 1e-6 - 1.0).abs() < 0.21, "{mean}");
    }

    /// A plane of 100 × 100 correlation lengths has at least 10⁴/π independent patches with a radius of one correlation
    /// length. The standard error of the mean is therefore 0.02 σ, and the standard error of the variance of a Gaussian
    /// field √(2/3200) = 2.5 %, as for the autocorrelation. The tests allow 4 standard errors, on planes of three
    /// orientations.
    #[test]
    fn heights_have_the_stated_statistics_on_any_plane() {
        for (statistics, turn) in [
            (FIRN, 0.0),
            (RoughnessStatistics { height_m: 5e-4, correlation_m: 0.006, hurst: 0.8 }, 0.7),
            (RoughnessStatistics { height_m: 8e-3, correlation_m: 0.3, hurst: 0.3 }, 2.0),
        ] {
            let roughness = Roughness::new(&statistics, 7);
            let (side, per_length) = (600, 6.0);
            let step_m = statistics.correlation_m / per_length;
            let heights = plane(&roughness, side, step_m, turn);
            let sigma = statistics.height_m;
            let average = mean(heights.iter().copied());
            assert!(average.abs() < 0.08 * sigma, "{statistics:?}: {average}");
            let variance = mean(heights.iter().map(|height| height * height));
            assert!((variance / (sigma * sigma) - 1.0).abs() < 0.1, "{statistics:?}: {variance}");
            assert!(heights.iter().all(|height| height.abs() <= roughness.greatest_m()));
            for lag in [1u32, 3, 6, 12, 30] {
                let pairs = heights.iter().zip(&heights[lag as usize..]).enumerate();
                let side = side as usize;
                let in_row = pairs.filter(|(at, _)| at % side + (lag as usize) < side);
                let found = mean(in_row.map(|(_, (one, other))| one * other)) / (sigma * sigma);
                let stated = roughness.autocorrelation(f64::from(lag) * step_m);
                assert!((found - stated).abs() < 0.1, "{statistics:?}, {lag} steps: {found}, stated {stated}");
            }
            let at_length = roughness.autocorrelation(statistics.correlation_m);
            assert!((at_length - (-1f64).exp()).abs() < 1e-3, "{at_length}");
        }
    }

    /// With H = 1/2 the stated autocorrelation is exponential between the least wavelength and the correlation length,
    /// within the ripples of octaves.
    #[test]
    fn a_hurst_exponent_of_one_half_is_nearly_exponential() {
        let roughness = Roughness::new(&RoughnessStatistics { correlation_m: 0.1, ..FIRN }, 1);
        for part in [0.05, 0.1, 0.2, 0.5, 1.0] {
            let found = roughness.autocorrelation(part * 0.1);
            assert!((found - (-part).exp()).abs() < 0.05, "{part}: {found}");
        }
    }

    /// The mean square of the difference of heights grows as r^{2H} well within the range of the wavelengths.
    #[test]
    fn below_the_correlation_length_the_surface_is_self_affine() {
        for hurst in [0.3, 0.5, 0.8] {
            let roughness = Roughness::new(&RoughnessStatistics { correlation_m: 1.0, hurst, ..FIRN }, 1);
            let difference = |distance_m: f64| 1.0 - roughness.autocorrelation(distance_m);
            let found = (difference(0.064) / difference(0.008)).log2() / 6.0;
            // The correlation length limits the range from above, and flattens the steepest curve.
            assert!((found - hurst).abs() < 0.08, "{hurst}: {found}");
        }
    }

    #[test]
    fn the_slope_is_that_of_the_heights() {
        let roughness = Roughness::new(&FIRN, 3);
        let [side, step_m] = [400.0, 1.7e-3];
        let slopes = (0..160_000u32).map(|k| {
            let place = DVec3::new(f64::from(k) % side, (f64::from(k) / side).floor(), 0.0) * step_m;
            let slope = |axis: DVec3| {
                let ahead = roughness.height_m(place + axis * 1e-6, 0.0);
                (ahead - roughness.height_m(place, 0.0)) / 1e-6
            };
            slope(DVec3::X).powi(2) + slope(DVec3::Y).powi(2)
        });
        let found = mean(slopes).sqrt();
        // A side of 680 mm is 34 correlation lengths, and far more of the short wavelengths that cause the slopes.
        assert!((found / roughness.slope() - 1.0).abs() < 0.03, "{found} {}", roughness.slope());
    }

    #[test]
    fn long_edges_leave_out_octaves_and_no_others() {
        let roughness = Roughness::new(&FIRN, 3);
        let place = DVec3::new(0.013, -0.2, 0.07);
        let whole = roughness.height_m(place, 0.0);
        assert_eq!(roughness.height_m(place, roughness.least_edge_m()).to_bits(), whole.to_bits());
        assert!(roughness.height_m(place, roughness.greatest_edge_m()).abs() <= 0.0);
        // The share of an octave changes without a step.
        let edges = (0..2000).map(|k| 1e-4 + 3e-5 * f64::from(k));
        let heights: Vec<f64> = edges.map(|edge_m| roughness.height_m(place, edge_m)).collect();
        assert!(heights.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 0.1 * FIRN.height_m));
        assert!((Roughness::new(&FIRN, 4).height_m(place, 0.0) - whole).abs() > 1e-6, "seeds differ");
    }
}
