//! A grey texture that lets a flat colour look like snow: grains, and the soft light and shade of an uneven surface.
//!
//! Varsa & Baranoski (2024, Fig. 3) lay a greyscale texture over their swatches; this one is computed. Three things make it:
//! a surface of gradient noise (Perlin 1985) in octaves, and one of small domes, both lit from the upper left; and
//! crystals, each a little lighter or darker as its facets face the light. The factors have the mean 1: the average of a
//! textured colour, as light, is the colour itself.

use snowblue_transport::rng::split_mix_64;

/// A factor on light for each pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct SnowTexture {
    width: u32,
    height: u32,
    factors: Vec<f64>,
}

/// Towards the light: leftwards, upwards, towards the eye.
const LIGHT: [f64; 3] = [-0.54, -0.48, 0.69];
/// Widths of hills and hollows in pixels, and their steepness.
const HILLS: [(f64, f64); 3] = [(120.0, 0.12), (48.0, 0.10), (20.0, 0.08)];
const HILLS_CONTRAST: f64 = 0.8;
/// Distance of domes in pixels, and their height to their breadth.
const DOMES: (f64, f64) = (3.2, 0.3);
const DOMES_CONTRAST: f64 = 0.45;
/// Distances of crystals in pixels, how sharp their edges are, and how much their greys differ.
const CRYSTALS: [(f64, f64, f64); 2] = [(1.7, 6.0, 0.07), (3.4, 8.0, 0.03)];
/// Light and shade bend softly towards these bounds on both sides of the mean.
const LIGHTEST: f64 = 0.21;
const DARKEST: f64 = 0.5;

impl SnowTexture {
    /// No factor is greater: a colour whose greatest channel is at most 1 over this fits a screen under any texture.
    pub const BRIGHTEST: f64 = 1.25;

    /// A texture of `width` × `height` pixels; a seed gives the same on every machine.
    pub fn new(width: u32, height: u32, seed: u64) -> Self {
        let chance = |kind: u64| Chance(split_mix_64(seed ^ split_mix_64(kind)));
        let hills = |x: f64, y: f64| -> f64 {
            let octave = |(kind, (cell, steepness)): (u64, (f64, f64))| {
                steepness * cell * chance(kind).noise(x / cell, y / cell)
            };
            (0..).zip(HILLS).map(octave).sum()
        };
        let domes = |x: f64, y: f64| DOMES.1 * chance(8).domes((x, y), DOMES.0);
        let shade = |x: f64, y: f64| {
            let crystals = (16..).zip(CRYSTALS);
            let facets =
                crystals.map(|(kind, (cell, edge, contrast))| contrast * chance(kind).crystal((x, y), cell, edge));
            HILLS_CONTRAST * lit(&hills, x, y) + DOMES_CONTRAST * lit(&domes, x, y) + facets.sum::<f64>()
        };
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (f64::from(x), f64::from(y))));
        let shades: Vec<f64> = places.map(|(x, y)| shade(x, y)).collect();
        let middle = mean(&shades);
        let bent = |shade: f64| {
            let from_middle = shade - middle;
            let bound = if from_middle > 0.0 { LIGHTEST } else { DARKEST };
            1.0 + bound * (from_middle / bound).tanh()
        };
        let bent: Vec<f64> = shades.into_iter().map(bent).collect();
        let mean = mean(&bent);
        Self { width, height, factors: bent.into_iter().map(|factor| factor / mean).collect() }
    }

    /// Pixels from left to right.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Pixels from top to bottom.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Factors, row by row from the upper left.
    pub fn factors(&self) -> &[f64] {
        &self.factors
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Light on a surface of heights, over that on a level one: the cosine to the light.
fn lit(height: &impl Fn(f64, f64) -> f64, x: f64, y: f64) -> f64 {
    let here = height(x, y);
    let (across, down) = (height(x + 1.0, y) - here, height(x, y + 1.0) - here);
    (LIGHT[2] - across * LIGHT[0] - down * LIGHT[1]) / (1.0 + across * across + down * down).sqrt() - LIGHT[2]
}

/// Random numbers that belong to the points of a lattice.
#[derive(Debug, Clone, Copy)]
struct Chance(u64);

/// Of a lattice's points those that matter at a place, two to each side.
const AROUND: [i64; 5] = [-2, -1, 0, 1, 2];

impl Chance {
    /// Uniform in 0–1; `which` tells several numbers of one point apart.
    fn at(self, (i, j): (i64, i64), which: u64) -> f64 {
        let point = split_mix_64(split_mix_64(self.0 ^ i.cast_unsigned()) ^ j.cast_unsigned());
        (split_mix_64(point ^ which) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Gradient noise: smooth, 0 at the lattice's points, with a random slope at each.
    fn noise(self, x: f64, y: f64) -> f64 {
        let (i, j) = (cell(x), cell(y));
        let (u, v) = (x - x.floor(), y - y.floor());
        let corner = |across: i64, down: i64| {
            let (sin, cos) = (std::f64::consts::TAU * self.at((i + across, j + down), 0)).sin_cos();
            cos * (u - across as f64) + sin * (v - down as f64)
        };
        // 6t⁵ − 15t⁴ + 10t³ has no slope and no curvature at both ends (Perlin 2002).
        let smooth = |t: f64| t * t * t * (t * (6.0 * t - 15.0) + 10.0);
        let mix = |low: f64, high: f64, share: f64| low + smooth(share) * (high - low);
        mix(mix(corner(0, 0), corner(1, 0), u), mix(corner(0, 1), corner(1, 1), u), v)
    }

    /// The randomly placed points around a place: which they are, and their squared distance.
    fn points(self, (x, y): (f64, f64), spacing: f64) -> impl Iterator<Item = ((i64, i64), f64)> {
        let (i, j) = (cell(x / spacing), cell(y / spacing));
        let around = AROUND.into_iter().flat_map(move |a| AROUND.into_iter().map(move |b| (i + a, j + b)));
        around.map(move |point| {
            let across = (point.0 as f64 + self.at(point, 0)) * spacing - x;
            let down = (point.1 as f64 + self.at(point, 1)) * spacing - y;
            (point, across * across + down * down)
        })
    }

    /// Height of the highest of many caps of spheres, in pixels.
    fn domes(self, place: (f64, f64), spacing: f64) -> f64 {
        let cap = |(point, square): ((i64, i64), f64)| {
            let radius = spacing * (0.6 + 0.6 * self.at(point, 2));
            let foot = 0.9 * spacing * self.at(point, 3) - 0.5 * radius;
            if square < radius * radius { foot + (radius * radius - square).sqrt() } else { -spacing }
        };
        self.points(place, spacing).map(cap).fold(-spacing, f64::max)
    }

    /// The grey of the crystal at a place, of mean 0 and deviation 1 over crystals, softened where they touch.
    fn crystal(self, place: (f64, f64), spacing: f64, edge: f64) -> f64 {
        let (mut grey, mut weight) = (0.0, 0.0);
        for (point, square) in self.points(place, spacing) {
            let share = (-edge * square / (spacing * spacing)).exp();
            grey += share * (self.at(point, 2) - 0.5) * 12_f64.sqrt();
            weight += share;
        }
        grey / weight
    }
}

#[expect(clippy::cast_possible_truncation, reason = "pictures have fewer than 2³² pixels to a side")]
fn cell(place: f64) -> i64 {
    place.floor() as i64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn textures_are_neutral_modest_and_fit_a_screen() {
        for (width, height, seed) in [(160, 160, 1), (64, 200, 2), (16, 16, 3), (1, 1, 4)] {
            let texture = SnowTexture::new(width, height, seed);
            let factors = texture.factors();
            // Sums of fewer than 10⁵ numbers near 1 keep twelve digits.
            assert!((mean(factors) - 1.0).abs() < 1e-12);
            assert!(factors.iter().all(|factor| (0.4..=SnowTexture::BRIGHTEST).contains(factor)), "{width} {seed}");
        }
        let factors = SnowTexture::new(160, 160, 1).factors;
        let deviation = mean(&factors.iter().map(|factor| (factor - 1.0).powi(2)).collect::<Vec<_>>()).sqrt();
        assert!((0.05..0.15).contains(&deviation), "{deviation}");
    }

    /// White noise has no like neighbours; smooth clouds have no grains.
    #[test]
    fn textures_are_neither_noise_nor_clouds() {
        let texture = SnowTexture::new(200, 200, 1);
        let at = |x: usize, y: usize| texture.factors[200 * y + x] - 1.0;
        let likeness = |apart: usize| {
            let pairs = (0..200).flat_map(|y| (0..200 - apart).map(move |x| (x, y)));
            let (mut product, mut square) = (0.0, 0.0);
            for (x, y) in pairs {
                product += at(x, y) * at(x + apart, y);
                square += at(x, y).powi(2);
            }
            product / square
        };
        assert!((0.4..0.9).contains(&likeness(1)), "{}", likeness(1));
        assert!((0.05..0.6).contains(&likeness(8)), "{}", likeness(8));
    }

    #[test]
    fn seeds_differ_and_are_kept() {
        assert_eq!(SnowTexture::new(20, 10, 7), SnowTexture::new(20, 10, 7));
        assert_ne!(SnowTexture::new(20, 10, 7), SnowTexture::new(20, 10, 8));
    }
}
