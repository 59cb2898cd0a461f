//! The random walk of a ray through a slab: free flights between scattering events, until it leaves.

use crate::medium::{Constituents, HitSizes, Population, hit_size_m};
use crate::rng::{Stream, unit_circle};
use crate::sample::SnowSample;

/// All scatterers in snow at one wavelength.
#[derive(Debug, Clone)]
pub(crate) struct Scatterers {
    population: Population,
    /// Sizes of grains, weighted by their projected area.
    pub(crate) size: HitSizes,
    /// Refractive index of ice relative to air.
    index_in_air: f64,
    /// Refractive index of ice relative to water.
    index_in_water: f64,
    /// Probability that the scatterer is a grain in air.
    air_probability: f64,
    /// Probability that the scatterer is a grain.
    grain_probability: f64,
    particles: Vec<ParticleChoice>,
    /// Extinction coefficient of all scatterers, in 1/m.
    pub(crate) extinction_per_m: f64,
}

/// A kind of particle.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ParticleChoice {
    /// Probability that the scatterer is a grain, a particle of an earlier kind, or one of this kind.
    cumulative_probability: f64,
    asymmetry: f64,
}

/// A scattering event.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Collision {
    pub(crate) cos_scattering: f64,
    /// Path through ice over the grain's size, for a grain in air and for a grain in water.
    pub(crate) ice_path: [f64; 2],
}

/// Path lengths of a ray.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Paths {
    /// Through the ice of grains in air and in water, in m.
    pub(crate) ice_m: [f64; 2],
    /// Between scattering events, in optical depths.
    pub(crate) free: f64,
}

/// Absorption along paths at one wavelength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Absorption {
    /// Effective absorption coefficients of ice in air and of ice in water, in 1/m.
    ice_per_m: [f64; 2],
    /// Absorption between scattering events, per optical depth.
    pub(crate) free: f64,
}

/// A completed random walk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Passage {
    /// Whether the ray left through the bottom.
    pub(crate) transmitted: bool,
    /// Number of scattering events.
    pub(crate) hits: u32,
    pub(crate) paths: Paths,
}

impl Scatterers {
    /// The scatterers of a sample.
    pub(crate) fn new(sample: &SnowSample, constituents: &Constituents) -> Self {
        let extinction_per_m = constituents.scatterer_extinction_per_m();
        let air = constituents.in_air.extinction_per_m;
        let grains = air + constituents.in_water.extinction_per_m;
        let mut sum = grains;
        let particles = constituents.particles.iter().map(|particle| {
            sum += particle.scattering_per_m;
            ParticleChoice { cumulative_probability: sum / extinction_per_m, asymmetry: particle.asymmetry }
        });
        Self {
            particles: particles.collect(),
            population: Population::of_sample(sample),
            size: HitSizes::new(&sample.grain_size),
            index_in_air: constituents.in_air.relative_index,
            index_in_water: constituents.in_water.relative_index,
            air_probability: air / extinction_per_m,
            grain_probability: grains / extinction_per_m,
            extinction_per_m,
        }
    }

    /// Draws the next scatterer and its scattering.
    #[inline]
    pub(crate) fn collide(&self, stream: &mut Stream) -> Collision {
        // Dry and clean snow has one kind of scatterer and takes no random number here.
        let choice = if self.air_probability < 1.0 { stream.uniform() } else { 0.0 };
        if choice >= self.grain_probability {
            let drawn = self.particles.iter().find(|kind| choice < kind.cumulative_probability);
            let asymmetry = drawn.or(self.particles.last()).map_or(0.0, |kind| kind.asymmetry);
            return Collision { cos_scattering: henyey_greenstein(asymmetry, stream.uniform()), ice_path: [0.0; 2] };
        }
        let in_air = choice < self.air_probability;
        let relative_index = if in_air { self.index_in_air } else { self.index_in_water };
        let grain = self.population.grain([stream.uniform(), stream.uniform()], relative_index);
        let scattered = grain.scatter(stream);
        let path = scattered.ice_path;
        let ice_path = if in_air { [path, 0.0] } else { [0.0, path] };
        Collision { cos_scattering: scattered.cos_scattering, ice_path }
    }
}

/// Cosine of the scattering angle of the Henyey–Greenstein phase function for a uniform number: the inverse of the
/// cumulative distribution, (1 + g² − ((1 − g²)/(1 + g s))²)/2g with s = 2u − 1, written without the division by g.
fn henyey_greenstein(g: f64, uniform: f64) -> f64 {
    let s = 2.0 * uniform - 1.0;
    let numerator = s + g * (0.5 * (s * s + 3.0) + g * (s + 0.5 * g * (s * s - 1.0)));
    (numerator / ((1.0 + g * s) * (1.0 + g * s))).clamp(-1.0, 1.0)
}

impl Collision {
    /// Adds the path through ice, for a grain of the given size, to the paths of a ray.
    #[inline]
    pub(crate) fn add_ice_path(&self, size_m: f64, paths: &mut Paths) {
        paths.ice_m[0] += self.ice_path[0] * size_m;
        paths.ice_m[1] += self.ice_path[1] * size_m;
    }
}

impl Absorption {
    /// Absorption in snow with the given scatterers.
    pub(crate) fn new(constituents: &Constituents, scatterers: &Scatterers) -> Self {
        Self {
            ice_per_m: [constituents.in_air.absorption_per_m, constituents.in_water.absorption_per_m],
            free: constituents.pore_absorption_per_m / scatterers.extinction_per_m,
        }
    }

    /// Optical depth of absorption along the given paths in grains.
    #[inline]
    pub(crate) fn in_ice(&self, ice_m: [f64; 2]) -> f64 {
        self.ice_per_m[0] * ice_m[0] + self.ice_per_m[1] * ice_m[1]
    }

    /// Fraction of light that is not absorbed along the paths.
    #[inline]
    pub(crate) fn transmittance(&self, paths: &Paths) -> f64 {
        (-(self.in_ice(paths.ice_m) + self.free * paths.free)).exp()
    }
}

/// Traces a ray that enters a slab of `optical_depth` with the given cosine from the normal.
///
/// Grains are points: the path through a grain does not move the ray. Their orientation is random, so the azimuth of
/// each scattering is uniform and the direction reduces to its cosine from the normal.
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
        let collision = scatterers.collide(stream);
        collision.add_ice_path(hit_size_m(&scatterers.size, stream), &mut passage.paths);
        cosine = scattered_cosine(cosine, collision.cos_scattering, stream);
    }
}

/// The cosine from the normal after scattering with a random azimuth.
#[inline]
pub(crate) fn scattered_cosine(cosine: f64, cos_scattering: f64, stream: &mut Stream) -> f64 {
    let sines = ((1.0 - cosine * cosine) * (1.0 - cos_scattering * cos_scattering)).max(0.0).sqrt();
    (cosine * cos_scattering + sines * unit_circle(stream.uniform()).0).clamp(-1.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean cosine is g, by the midpoint rule, and the cosine agrees with the formula with the division by g.
    #[test]
    fn henyey_greenstein_has_the_given_asymmetry() {
        for g in [-0.5_f64, 0.0, 1e-9, 0.4, 0.96] {
            let count = 100_000;
            let uniform = |i: u32| (f64::from(i) + 0.5) / f64::from(count);
            let mean = (0..count).map(|i| henyey_greenstein(g, uniform(i))).sum::<f64>() / f64::from(count);
            // The rule's error is f'' h²/24, and f'' is 10⁴ at the most, at g = 0.96.
            assert!((mean - g).abs() < 1e-7, "{g} {mean}");
        }
        let (g, s) = (0.7_f64, 0.3);
        let ratio: f64 = (1.0 - g * g) / (1.0 + g * s);
        assert!((henyey_greenstein(g, 0.65) - (1.0 + g * g - ratio * ratio) / (2.0 * g)).abs() < 1e-14);
    }
}
