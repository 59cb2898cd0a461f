//! Random numbers of a pixel sample, and directions from them.
//!
//! Numbers come from the Sobol sequence with Owen scrambling (Burley 2020, "Practical hash-based Owen scrambling",
//! Journal of Computer Graphics Techniques 9(4), 1–20), one scramble per pixel. A number depends on (seed, pixel,
//! sample, dimension) alone, so that neither threads nor the order of work change an image.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};
use std::ops::Range;

use glam::Vec3A;
use snowblue_base::narrow;
use sobol_burley::{NUM_DIMENSION_SETS_4D, sample_4d};

/// Length of one scrambled sequence. Further samples use a new scramble.
const SEQUENCE_LENGTH: u32 = 1 << 16;

/// The random numbers of one sample of one pixel.
#[derive(Debug, Clone, Copy)]
pub struct Sampler {
    scramble: u32,
    index: u32,
    next_set: u32,
}

/// The random numbers of the samples of one pixel.
#[derive(Debug, Clone, Copy)]
pub struct PixelSampler(u32);

impl PixelSampler {
    /// The numbers of the pixel with number `pixel`.
    pub fn new(seed: u32, pixel: u32) -> Self {
        Self(mixed(mixed(seed) ^ pixel))
    }

    /// The numbers of one sample.
    #[inline]
    pub fn sampler(&self, sample: u32) -> Sampler {
        Sampler {
            scramble: mixed(self.0.wrapping_add(sample / SEQUENCE_LENGTH)),
            index: sample % SEQUENCE_LENGTH,
            next_set: 0,
        }
    }
}

impl Sampler {
    /// The numbers of sample `sample` of the pixel with number `pixel`.
    pub fn new(seed: u32, pixel: u32, sample: u32) -> Self {
        PixelSampler::new(seed, pixel).sampler(sample)
    }

    /// The identity of this sample in the image: the scramble of its pixel and its index.
    pub fn address(&self) -> [u32; 2] {
        [self.scramble, self.index]
    }

    /// The next four numbers, in [0, 1).
    #[inline]
    pub fn next_four(&mut self) -> [f32; 4] {
        let round = self.next_set / NUM_DIMENSION_SETS_4D;
        let scramble = if round == 0 { self.scramble } else { mixed(self.scramble.wrapping_add(round)) };
        let numbers = sample_4d(self.index, self.next_set % NUM_DIMENSION_SETS_4D, scramble);
        self.next_set += 1;
        numbers
    }
}

/// Positions of a range of samples within their pixels.
///
/// One scrambled Sobol sequence serves all pixels. Each pixel moves the sequence by a random digital shift (Kollig &
/// Keller 2002, "Efficient multidimensional sampling", doi:10.1111/1467-8659.00706), which keeps the stratification
/// of the sequence. A position is then a table look-up and an exclusive or. The position depends on (seed, pixel,
/// sample) alone.
#[derive(Debug)]
pub struct PixelPattern {
    seed: u32,
    /// The samples that have a position.
    pub samples: Range<u32>,
    /// Binary digits of each sample's position, from left to right and downwards, and of two further numbers.
    digits: Vec<[u32; 4]>,
}

impl PixelPattern {
    /// The positions of some samples.
    pub fn new(seed: u32, samples: Range<u32>) -> Self {
        let digits = samples.clone().map(|sample| {
            let scramble = mixed(mixed(seed ^ PATTERN_SALT).wrapping_add(sample / SEQUENCE_LENGTH));
            sample_4d(sample % SEQUENCE_LENGTH, 0, scramble).map(digits)
        });
        Self { seed, digits: digits.collect(), samples }
    }

    /// Digital shift of the pixel with number `pixel`.
    pub fn shift(&self, pixel: u32) -> [u32; 2] {
        let across = mixed(mixed(self.seed ^ PATTERN_SALT) ^ pixel);
        [across, mixed(across)].map(|bits| bits >> (32 - DIGITS))
    }

    /// Position of a sample in a pixel with the digital shift `shift`, in [0, 1)²: from left to right, and downwards.
    #[inline]
    pub fn position(&self, shift: [u32; 2], sample: u32) -> [f32; 2] {
        let [across, down, ..] = self.digits[(sample - self.samples.start) as usize];
        [across ^ shift[0], down ^ shift[1]].map(|digits| digits as f32 * UNIT)
    }

    /// Two further numbers of a sample in [0, 1), from the same sequence, for the lens.
    #[inline]
    pub fn lens_numbers(&self, shift: [u32; 2], sample: u32) -> [f32; 2] {
        let [.., first, second] = self.digits[(sample - self.samples.start) as usize];
        let of_first = mixed(mixed(shift[0]) ^ shift[1]);
        let shift = [of_first, mixed(of_first)].map(|bits| bits >> (32 - DIGITS));
        [first ^ shift[0], second ^ shift[1]].map(|digits| digits as f32 * UNIT)
    }
}

/// Makes the pattern's numbers independent of the numbers of [`Sampler`].
const PATTERN_SALT: u32 = 0x5eed_f11a;
/// Binary digits of a position.
const DIGITS: u32 = 24;
/// Weight of the last digit.
const UNIT: f32 = 1.0 / (1u32 << DIGITS) as f32;

/// The binary digits of a number in [0, 1).
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative and below 2²⁴")]
fn digits(number: f32) -> u32 {
    (number / UNIT) as u32
}

/// Hashes 32 bits: two rounds of xor-shift and multiplication with the constants of Wellons (2018, "Prospecting for
/// hash functions").
fn mixed(mut bits: u32) -> u32 {
    bits = bits.wrapping_add(0x9e37_79b9);
    bits = (bits ^ (bits >> 16)).wrapping_mul(0x7feb_352d);
    bits = (bits ^ (bits >> 15)).wrapping_mul(0x846c_a68b);
    bits ^ (bits >> 16)
}

/// A point of the unit disc, evenly distributed, from two numbers in [0, 1) (P. Shirley & K. Chiu 1997, *A low
/// distortion map between disk and square*, Journal of Graphics Tools 2(3), 45–52, doi:10.1080/10867651.1997.10487479).
#[inline]
pub fn concentric_disc([u, v]: [f32; 2]) -> [f32; 2] {
    let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    if x == 0.0 && y == 0.0 {
        return [0.0; 2];
    }
    let (radius, angle) =
        if x.abs() > y.abs() { (x, FRAC_PI_4 * (y / x)) } else { (y, FRAC_PI_2 - FRAC_PI_4 * (x / y)) };
    [radius * angle.cos(), radius * angle.sin()]
}

/// A unit direction about a normal with density cos θ / π, from two numbers in [0, 1).
///
/// The basis about the normal follows Duff et al. (2017, "Building an orthonormal basis, revisited", Journal of
/// Computer Graphics Techniques 6(1), 1–8).
#[inline]
pub fn cosine_direction(normal: Vec3A, u: f32, v: f32) -> Vec3A {
    let (side, ahead) = normal.any_orthonormal_pair();
    let radius = u.sqrt();
    let (sin, cos) = (std::f32::consts::TAU * v).sin_cos();
    (side * (radius * cos) + ahead * (radius * sin) + normal * (1.0 - u).sqrt()).normalize()
}

/// A unit direction above a normal with the constant density 1 / 2π, from two numbers in [0, 1).
#[inline]
pub fn uniform_hemisphere_direction(normal: Vec3A, u: f32, v: f32) -> Vec3A {
    let (side, ahead) = normal.any_orthonormal_pair();
    let radius = (u * (2.0 - u)).sqrt();
    let (sin, cos) = (std::f32::consts::TAU * v).sin_cos();
    (side * (radius * cos) + ahead * (radius * sin) + normal * (1.0 - u)).normalize()
}

/// The sum of weights, and their cumulative fractions.
pub(crate) fn cumulative(weights: impl Iterator<Item = f32>) -> (f64, Vec<f32>) {
    let mut total = 0.0;
    let sums: Vec<f64> = weights
        .map(|weight| {
            total += f64::from(weight);
            total
        })
        .collect();
    (total, sums.into_iter().map(|sum| if total > 0.0 { narrow(sum / total) } else { 0.0 }).collect())
}

/// The step of a cumulative sum that contains a number in [0, 1), and the position within it.
pub(crate) fn invert(sums: &[f32], u: f32) -> (usize, f32) {
    let index = sums.partition_point(|&sum| sum <= u).min(sums.len() - 1);
    let before = if index == 0 { 0.0 } else { sums[index - 1] };
    (index, ((u - before) / (sums[index] - before)).min(1.0))
}

/// The fraction of one step of a cumulative sum.
pub(crate) fn share(sums: &[f32], index: usize) -> f32 {
    sums[index] - if index == 0 { 0.0 } else { sums[index - 1] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_have_the_cosine_density() {
        // ⟨cos θ⟩ = 2/3 and ⟨cos² θ⟩ = 1/2 under the density cos θ / π. 4,096 points of a scrambled Sobol set are far
        // better than random points, whose standard errors would be 0.0037 and 0.0045.
        let normal = Vec3A::new(0.6, -0.48, 0.64);
        let (mut first, mut second, mut sideways) = (0.0, 0.0, Vec3A::ZERO);
        for sample in 0..4096 {
            let [u, v, ..] = Sampler::new(1, 7, sample).next_four();
            let direction = cosine_direction(normal, u, v);
            let cos = normal.dot(direction);
            assert!(cos >= 0.0);
            first += cos / 4096.0;
            second += cos * cos / 4096.0;
            sideways += (direction - normal * cos) / 4096.0;
        }
        assert!((first - 2.0 / 3.0).abs() < 1e-3, "{first}");
        assert!((second - 0.5).abs() < 1e-3, "{second}");
        assert!(sideways.length() < 2e-3, "{sideways}");
    }

    #[test]
    fn seeds_pixels_and_dimensions_differ_and_repeat() {
        let numbers = |seed, pixel, sample| {
            let mut sampler = Sampler::new(seed, pixel, sample);
            [sampler.next_four(), sampler.next_four()]
        };
        let one = numbers(1, 2, 3);
        assert_eq!(one, numbers(1, 2, 3));
        assert_ne!(one[0].map(f32::to_bits), one[1].map(f32::to_bits));
        for other in [numbers(2, 2, 3), numbers(1, 3, 3), numbers(1, 2, 4), numbers(1, 2, 3 + SEQUENCE_LENGTH)] {
            assert_ne!(one, other);
        }
    }

    /// Every elementary interval of area 1/16 holds one of 16 samples, in every pixel: a (0, 4, 2)-net.
    #[test]
    fn positions_in_pixels_are_stratified() {
        let pattern = PixelPattern::new(3, 16..32);
        let mut first = Vec::new();
        for pixel in [0, 1, 77_777] {
            let shift = pattern.shift(pixel);
            let places: Vec<[f32; 2]> = (16..32).map(|sample| pattern.position(shift, sample)).collect();
            for columns in [1.0_f32, 2.0, 4.0, 8.0, 16.0] {
                let rows = 16.0 / columns;
                let strip = |[across, down]: &[f32; 2]| (across * columns).floor() * rows + (down * rows).floor();
                let mut strips: Vec<f32> = places.iter().map(strip).collect();
                strips.sort_unstable_by(f32::total_cmp);
                let all = (0..16_u8).map(f32::from);
                assert!(
                    strips.iter().zip(all).all(|(strip, k)| (strip - k).abs() < 0.5),
                    "{pixel} {columns}: {places:?}"
                );
            }
            first.push(places[0].map(f32::to_bits));
        }
        assert!(first[0] != first[1] && first[1] != first[2]);
        // The same as from another run.
        let other = PixelPattern::new(3, 20..21);
        let [one, same] = [&other, &pattern].map(|pattern| pattern.position(pattern.shift(1), 20).map(f32::to_bits));
        assert_eq!(one, same);
    }

    /// The numbers for the lens are stratified, differ from pixel to pixel, and cover the disc evenly.
    #[test]
    fn points_of_the_lens_cover_its_disc() {
        let pattern = PixelPattern::new(3, 0..4096);
        let mut first = Vec::new();
        for pixel in [0, 1, 77_777] {
            let shift = pattern.shift(pixel);
            let points: Vec<[f32; 2]> =
                (0..4096).map(|sample| concentric_disc(pattern.lens_numbers(shift, sample))).collect();
            let mean = |of: &dyn Fn(&[f32; 2]) -> f32| points.iter().map(of).sum::<f32>() / 4096.0;
            // ⟨r²⟩ = 1/2, ⟨x⟩ = ⟨y⟩ = ⟨xy⟩ = 0. The standard errors of random points would be 0.005, 0.008 and 0.003.
            assert!((mean(&|[x, y]| x * x + y * y) - 0.5).abs() < 2e-3);
            assert!(mean(&|[x, _]| *x).abs() < 2e-3 && mean(&|[_, y]| *y).abs() < 2e-3);
            assert!(mean(&|[x, y]| x * y).abs() < 2e-3);
            assert!(points.iter().all(|[x, y]| x.hypot(*y) <= 1.0 + 1e-6));
            first.push(points[0].map(f32::to_bits));
        }
        assert!(first[0] != first[1] && first[1] != first[2]);
        assert!(concentric_disc([0.5, 0.5]).iter().all(|part| part.abs() < 1e-12));
    }

    #[test]
    fn many_bounces_do_not_run_out_of_dimensions() {
        let mut sampler = Sampler::new(1, 1, 1);
        let first = sampler.next_four();
        for _ in 1..NUM_DIMENSION_SETS_4D {
            sampler.next_four();
        }
        assert_ne!(first.map(f32::to_bits), sampler.next_four().map(f32::to_bits));
    }
}
