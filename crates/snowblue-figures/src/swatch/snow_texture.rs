//! Procedural greyscale snow texture: grains, and the soft shading of an uneven surface.
//!
//! Varsa & Baranoski (2024, Fig. 3) multiply their swatches by a greyscale texture; this one is computed. It is the sum
//! of two height fields lit from the upper left (octaves of gradient noise, Perlin 1985, and small domes) and of
//! crystals with random greys. The factors have the mean 1, so that the mean linear colour of a textured swatch is the
//! colour itself.

use snowblue_transport::rng::split_mix_64;

/// A factor on the linear colour of each pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct SnowTexture {
    width: u32,
    height: u32,
    factors: Vec<f64>,
}

/// Direction to the light: to the left, upwards, and towards the viewer.
const LIGHT: [f64; 3] = [-0.54, -0.48, 0.69];
/// Octaves of gradient noise.
const HILLS: [Octave; 3] = [
    Octave { width_px: 120.0, steepness: 0.12 },
    Octave { width_px: 48.0, steepness: 0.10 },
    Octave { width_px: 20.0, steepness: 0.08 },
];
const HILLS_CONTRAST: f64 = 0.8;
/// Spacing of domes in pixels, and their height over their width.
const DOME_SPACING_PX: f64 = 3.2;
const DOME_STEEPNESS: f64 = 0.3;
const DOMES_CONTRAST: f64 = 0.45;
/// Layers of crystals.
const CRYSTALS: [CrystalLayer; 2] = [
    CrystalLayer { spacing_px: 1.7, edge_sharpness: 6.0, contrast: 0.07 },
    CrystalLayer { spacing_px: 3.4, edge_sharpness: 8.0, contrast: 0.03 },
];
/// Soft limits on the deviation from the mean, above and below.
const LIGHTEST: f64 = 0.21;
const DARKEST: f64 = 0.5;

/// An octave of gradient noise.
struct Octave {
    width_px: f64,
    steepness: f64,
}

/// A layer of crystals with random greys.
#[derive(Clone, Copy)]
struct CrystalLayer {
    spacing_px: f64,
    edge_sharpness: f64,
    contrast: f64,
}

impl SnowTexture {
    /// Upper bound of all factors: a colour with channels of at most 1 over this is displayable under any texture.
    pub const BRIGHTEST: f64 = 1.25;

    /// A texture of `width` × `height` pixels. A seed gives the same texture on every machine.
    pub fn new(width: u32, height: u32, seed: u64) -> Self {
        let random = |kind: u64| LatticeRandom(split_mix_64(seed ^ split_mix_64(kind)));
        let hills = |x: f64, y: f64| -> f64 {
            let octave = |(kind, octave): (u64, Octave)| {
                octave.steepness * octave.width_px * random(kind).noise(x / octave.width_px, y / octave.width_px)
            };
            (0..).zip(HILLS).map(octave).sum()
        };
        let domes = |x: f64, y: f64| DOME_STEEPNESS * random(8).domes(x, y, DOME_SPACING_PX);
        let shade = |x: f64, y: f64| {
            let crystals = (16..).zip(CRYSTALS);
            let facets = crystals.map(|(kind, layer)| layer.contrast * random(kind).crystal(x, y, layer));
            HILLS_CONTRAST * lit(&hills, x, y) + DOMES_CONTRAST * lit(&domes, x, y) + facets.sum::<f64>()
        };
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (f64::from(x), f64::from(y))));
        let shades: Vec<f64> = pixels.map(|(x, y)| shade(x, y)).collect();
        let mean_shade = mean(&shades);
        let compress = |shade: f64| {
            let deviation = shade - mean_shade;
            let bound = if deviation > 0.0 { LIGHTEST } else { DARKEST };
            1.0 + bound * (deviation / bound).tanh()
        };
        let compressed: Vec<f64> = shades.into_iter().map(compress).collect();
        let mean = mean(&compressed);
        Self { width, height, factors: compressed.into_iter().map(|factor| factor / mean).collect() }
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

/// Lambertian shading of a height field, relative to that of a level surface.
fn lit(height: &impl Fn(f64, f64) -> f64, x: f64, y: f64) -> f64 {
    let own_height = height(x, y);
    let (across, down) = (height(x + 1.0, y) - own_height, height(x, y + 1.0) - own_height);
    (LIGHT[2] - across * LIGHT[0] - down * LIGHT[1]) / (1.0 + across * across + down * down).sqrt() - LIGHT[2]
}

/// Random numbers of lattice points.
#[derive(Debug, Clone, Copy)]
struct LatticeRandom(u64);

/// A lattice point.
#[derive(Debug, Clone, Copy)]
struct LatticePoint {
    i: i64,
    j: i64,
}

/// A jittered lattice point near a position, and its squared distance from there.
struct NearPoint {
    point: LatticePoint,
    squared_distance: f64,
}

/// Offsets of the lattice points that can influence a position.
const NEIGHBOUR_OFFSETS: [i64; 5] = [-2, -1, 0, 1, 2];

impl LatticeRandom {
    /// A uniform number in [0, 1); `which` selects one of several numbers of a point.
    fn at(self, point: LatticePoint, which: u64) -> f64 {
        let mixed_point = split_mix_64(split_mix_64(self.0 ^ point.i.cast_unsigned()) ^ point.j.cast_unsigned());
        (split_mix_64(mixed_point ^ which) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Gradient noise: 0 with a random slope at each lattice point.
    fn noise(self, x: f64, y: f64) -> f64 {
        let (i, j) = (cell(x), cell(y));
        let (u, v) = (x - x.floor(), y - y.floor());
        let corner = |across: i64, down: i64| {
            let (sin, cos) =
                (std::f64::consts::TAU * self.at(LatticePoint { i: i + across, j: j + down }, 0)).sin_cos();
            cos * (u - across as f64) + sin * (v - down as f64)
        };
        // 6t⁵ − 15t⁴ + 10t³ has zero slope and curvature at both ends (Perlin 2002).
        let smooth = |t: f64| t * t * t * (t * (6.0 * t - 15.0) + 10.0);
        let mix = |low: f64, high: f64, t: f64| low + smooth(t) * (high - low);
        mix(mix(corner(0, 0), corner(1, 0), u), mix(corner(0, 1), corner(1, 1), u), v)
    }

    /// The jittered lattice points around a position.
    fn points(self, x: f64, y: f64, spacing: f64) -> impl Iterator<Item = NearPoint> {
        let (i, j) = (cell(x / spacing), cell(y / spacing));
        let neighbours = NEIGHBOUR_OFFSETS
            .into_iter()
            .flat_map(move |a| NEIGHBOUR_OFFSETS.into_iter().map(move |b| LatticePoint { i: i + a, j: j + b }));
        neighbours.map(move |point| {
            let across = (point.i as f64 + self.at(point, 0)) * spacing - x;
            let down = (point.j as f64 + self.at(point, 1)) * spacing - y;
            NearPoint { point, squared_distance: across * across + down * down }
        })
    }

    /// Height of a union of spherical caps, in pixels.
    fn domes(self, x: f64, y: f64, spacing: f64) -> f64 {
        let cap = |NearPoint { point, squared_distance: square }: NearPoint| {
            let radius = spacing * (0.6 + 0.6 * self.at(point, 2));
            let foot = 0.9 * spacing * self.at(point, 3) - 0.5 * radius;
            if square < radius * radius { foot + (radius * radius - square).sqrt() } else { -spacing }
        };
        self.points(x, y, spacing).map(cap).fold(-spacing, f64::max)
    }

    /// Grey of the crystal at a position, with mean 0 and standard deviation 1 over crystals, blended at their edges.
    fn crystal(self, x: f64, y: f64, layer: CrystalLayer) -> f64 {
        let (spacing, edge) = (layer.spacing_px, layer.edge_sharpness);
        let (mut grey, mut total_weight) = (0.0, 0.0);
        for NearPoint { point, squared_distance } in self.points(x, y, spacing) {
            let weight = (-edge * squared_distance / (spacing * spacing)).exp();
            grey += weight * (self.at(point, 2) - 0.5) * 12_f64.sqrt();
            total_weight += weight;
        }
        grey / total_weight
    }
}

#[expect(clippy::cast_possible_truncation, reason = "images have fewer than 2³² pixels along a side")]
fn cell(place: f64) -> i64 {
    place.floor() as i64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_have_mean_one_and_stay_within_bounds() {
        for (width, height, seed) in [(160, 160, 1), (64, 200, 2), (16, 16, 3), (1, 1, 4)] {
            let texture = SnowTexture::new(width, height, seed);
            let factors = texture.factors();
            // Sums of fewer than 10⁵ numbers near 1 are accurate to twelve digits.
            assert!((mean(factors) - 1.0).abs() < 1e-12);
            assert!(factors.iter().all(|factor| (0.4..=SnowTexture::BRIGHTEST).contains(factor)), "{width} {seed}");
        }
        let factors = SnowTexture::new(160, 160, 1).factors;
        let deviation = mean(&factors.iter().map(|factor| (factor - 1.0).powi(2)).collect::<Vec<_>>()).sqrt();
        assert!((0.05..0.15).contains(&deviation), "{deviation}");
    }

    /// White noise has no correlation between neighbours; smooth noise has too much.
    #[test]
    fn neighbouring_pixels_are_partly_correlated() {
        let texture = SnowTexture::new(200, 200, 1);
        let at = |x: usize, y: usize| texture.factors[200 * y + x] - 1.0;
        let correlation = |distance: usize| {
            let pairs = (0..200).flat_map(|y| (0..200 - distance).map(move |x| (x, y)));
            let (mut product, mut square) = (0.0, 0.0);
            for (x, y) in pairs {
                product += at(x, y) * at(x + distance, y);
                square += at(x, y).powi(2);
            }
            product / square
        };
        assert!((0.4..0.9).contains(&correlation(1)), "{}", correlation(1));
        assert!((0.05..0.6).contains(&correlation(8)), "{}", correlation(8));
    }

    #[test]
    fn a_seed_determines_the_texture() {
        assert_eq!(SnowTexture::new(20, 10, 7), SnowTexture::new(20, 10, 7));
        assert_ne!(SnowTexture::new(20, 10, 7), SnowTexture::new(20, 10, 8));
    }
}
