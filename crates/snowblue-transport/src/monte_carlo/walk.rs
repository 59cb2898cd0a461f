//! One ray's way through a slab: free flights between what turns light, until it leaves.

use crate::medium::{Constituents, HitSizes, Population, hit_size_m};
use crate::rng::{Stream, unit_circle};
use crate::sample::SnowSample;

/// All that turns light in snow, at one wavelength.
#[derive(Debug, Clone)]
pub(crate) struct Scatterers {
    population: Population,
    /// Sizes of the grains that are hit.
    pub(crate) size: HitSizes,
    /// Index of ice over that of air, and of water.
    index_in_air: f64,
    index_in_water: f64,
    /// Shares of what is met up to and with grains in air, grains in water, and each kind of particle, with the
    /// asymmetry of the last.
    air_share: f64,
    grain_share: f64,
    particles: Vec<(f64, f64)>,
    /// Extinction coefficient of all of it, in 1/m.
    pub(crate) extinction_per_m: f64,
}

/// What becomes of light that meets something.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Encounter {
    pub(crate) cos_scattering: f64,
    /// Path through ice over the grain's size, where the grain lies in air, and where it lies in water.
    pub(crate) ice_path: [f64; 2],
}

/// How far a ray went.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Paths {
    /// Through the ice of grains in air and in water, in m.
    pub(crate) ice_m: [f64; 2],
    /// Between what it met, in optical depths.
    pub(crate) free: f64,
}

/// What paths cost at one wavelength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Absorption {
    /// Absorption coefficient of ice in air and of ice in water, as light there counts, in 1/m.
    ice_per_m: [f64; 2],
    /// Absorption on the way, per optical depth.
    pub(crate) free: f64,
}

/// A ray's life between entering and leaving a slab.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Passage {
    /// Whether it left through the far face.
    pub(crate) transmitted: bool,
    /// How many times it was turned.
    pub(crate) hits: u32,
    pub(crate) paths: Paths,
}

impl Scatterers {
    /// Those of a sample.
    pub(crate) fn new(sample: &SnowSample, met: &Constituents) -> Self {
        let extinction_per_m = met.turning_per_m();
        let air = met.in_air.extinction_per_m;
        let grains = air + met.in_water.extinction_per_m;
        let mut sum = grains;
        let particles = met.particles.iter().map(|particle| {
            sum += particle.scattering_per_m;
            (sum / extinction_per_m, particle.asymmetry)
        });
        Self {
            particles: particles.collect(),
            population: Population::of_sample(sample),
            size: HitSizes::new(&sample.grain_size),
            index_in_air: met.in_air.relative_index,
            index_in_water: met.in_water.relative_index,
            air_share: air / extinction_per_m,
            grain_share: grains / extinction_per_m,
            extinction_per_m,
        }
    }

    /// Meets the next grain or particle.
    #[inline]
    pub(crate) fn meet(&self, stream: &mut Stream) -> Encounter {
        // In dry and clean snow there is nothing to choose, and no random number is spent on it.
        let choice = if self.air_share < 1.0 { stream.uniform() } else { 0.0 };
        if choice >= self.grain_share {
            let kind = self.particles.iter().find(|(share, _)| choice < *share).or(self.particles.last());
            let asymmetry = kind.map_or(0.0, |(_, asymmetry)| *asymmetry);
            return Encounter { cos_scattering: henyey_greenstein(asymmetry, stream.uniform()), ice_path: [0.0; 2] };
        }
        let in_air = choice < self.air_share;
        let relative_index = if in_air { self.index_in_air } else { self.index_in_water };
        let grain = self.population.grain([stream.uniform(), stream.uniform()], relative_index);
        let scattered = grain.scatter(stream);
        let path = scattered.ice_path;
        let ice_path = if in_air { [path, 0.0] } else { [0.0, path] };
        Encounter { cos_scattering: scattered.cos_scattering, ice_path }
    }
}

/// Cosine of the angle of scattering by Henyey & Greenstein's law that belongs to a uniform number: the inverse of its
/// cumulative distribution, (1 + g² − ((1 − g²)/(1 + g s))²)/2g with s = 2u − 1, written without the division by g.
fn henyey_greenstein(g: f64, uniform: f64) -> f64 {
    let s = 2.0 * uniform - 1.0;
    let numerator = s + g * (0.5 * (s * s + 3.0) + g * (s + 0.5 * g * (s * s - 1.0)));
    (numerator / ((1.0 + g * s) * (1.0 + g * s))).clamp(-1.0, 1.0)
}

impl Encounter {
    /// Adds the path through a grain of the given size to a ray's.
    #[inline]
    pub(crate) fn lengthen(&self, size_m: f64, paths: &mut Paths) {
        paths.ice_m[0] += self.ice_path[0] * size_m;
        paths.ice_m[1] += self.ice_path[1] * size_m;
    }
}

impl Absorption {
    /// What paths cost where `scatterers` turn the light.
    pub(crate) fn new(met: &Constituents, scatterers: &Scatterers) -> Self {
        Self {
            ice_per_m: [met.in_air.absorption_per_m, met.in_water.absorption_per_m],
            free: met.pore_absorption_per_m / scatterers.extinction_per_m,
        }
    }

    /// Optical depth of absorption in grains of the given paths.
    #[inline]
    pub(crate) fn in_ice(&self, ice_m: [f64; 2]) -> f64 {
        self.ice_per_m[0] * ice_m[0] + self.ice_per_m[1] * ice_m[1]
    }

    /// The share of light that is left after these paths.
    #[inline]
    pub(crate) fn left(&self, paths: &Paths) -> f64 {
        (-(self.in_ice(paths.ice_m) + self.free * paths.free)).exp()
    }
}

/// Follows a ray that enters a slab of `optical_depth` with the given cosine from the normal.
///
/// A grain is a point here: its chord does not move the ray. Grains have no preferred direction, so the azimuth of
/// each scattering is uniform and the ray's cosine from the normal is all that need be known.
pub(crate) fn walk(scatterers: &Scatterers, optical_depth: f64, cos_incidence: f64, stream: &mut Stream) -> Passage {
    let (mut depth, mut cosine) = (0.0, cos_incidence);
    let mut passage = Passage { transmitted: false, hits: 0, paths: Paths::default() };
    loop {
        let flight = -stream.uniform().ln();
        let next = depth + flight * cosine;
        if next <= 0.0 || next >= optical_depth {
            passage.transmitted = next > 0.0;
            let face = if passage.transmitted { optical_depth } else { 0.0 };
            passage.paths.free += (face - depth) / cosine;
            return passage;
        }
        depth = next;
        passage.paths.free += flight;
        passage.hits += 1;
        let met = scatterers.meet(stream);
        met.lengthen(hit_size_m(&scatterers.size, stream), &mut passage.paths);
        cosine = turn(cosine, met.cos_scattering, stream);
    }
}

/// The cosine from the normal after scattering through an angle with a random azimuth.
#[inline]
pub(crate) fn turn(cosine: f64, cos_scattering: f64, stream: &mut Stream) -> f64 {
    let sines = ((1.0 - cosine * cosine) * (1.0 - cos_scattering * cos_scattering)).max(0.0).sqrt();
    (cosine * cos_scattering + sines * unit_circle(stream.uniform()).0).clamp(-1.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean cosine of Henyey & Greenstein's law is g, by the midpoint rule; and it is the formula with the division.
    #[test]
    fn henyey_greenstein_has_its_asymmetry() {
        for g in [-0.5_f64, 0.0, 1e-9, 0.4, 0.96] {
            let count = 100_000;
            let uniform = |i: u32| (f64::from(i) + 0.5) / f64::from(count);
            let mean = (0..count).map(|i| henyey_greenstein(g, uniform(i))).sum::<f64>() / f64::from(count);
            // The rule's error is f'' h²/24, and f'' is 10⁴ at the most, at g = .96.
            assert!((mean - g).abs() < 1e-7, "{g} {mean}");
        }
        let (g, s) = (0.7_f64, 0.3);
        let ratio: f64 = (1.0 - g * g) / (1.0 + g * s);
        assert!((henyey_greenstein(g, 0.65) - (1.0 + g * g - ratio * ratio) / (2.0 * g)).abs() < 1e-14);
    }
}
