//! One ray's way through a slab: free flights between grains, until it leaves.

use crate::population::{HitSizes, Population, hit_size_m};
use crate::rng::{Stream, unit_circle};
use crate::sample::SnowSample;

/// Snow as a ray sees it.
#[derive(Debug, Clone)]
pub(crate) struct Medium {
    pub(crate) population: Population,
    pub(crate) size: HitSizes,
    pub(crate) relative_index: f64,
}

impl Medium {
    /// Snow whose ice has this index.
    pub(crate) fn new(sample: &SnowSample, relative_index: f64) -> Self {
        Self { population: Population::of_sample(sample), size: HitSizes::new(&sample.grain_size), relative_index }
    }
}

/// A ray's life between entering and leaving a slab.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Passage {
    /// Whether it left through the far face.
    pub(crate) transmitted: bool,
    /// Grains it hit.
    pub(crate) hits: u32,
    /// Length of its free flights, in optical depths.
    pub(crate) optical_path: f64,
    /// Path through ice, in m.
    pub(crate) ice_path_m: f64,
}

/// Follows a ray that enters a slab of `optical_depth` with the given cosine from the normal.
///
/// A grain is a point here: its chord does not move the ray. Grains have no preferred direction, so the azimuth of
/// each scattering is uniform and the ray's cosine from the normal is all that need be known.
pub(crate) fn walk(medium: &Medium, optical_depth: f64, cos_incidence: f64, stream: &mut Stream) -> Passage {
    let (mut depth, mut cosine) = (0.0, cos_incidence);
    let mut passage = Passage { transmitted: false, hits: 0, optical_path: 0.0, ice_path_m: 0.0 };
    loop {
        let flight = -stream.uniform().ln();
        let next = depth + flight * cosine;
        if next <= 0.0 || next >= optical_depth {
            passage.transmitted = next > 0.0;
            let face = if passage.transmitted { optical_depth } else { 0.0 };
            passage.optical_path += (face - depth) / cosine;
            return passage;
        }
        depth = next;
        passage.optical_path += flight;
        passage.hits += 1;
        let grain = medium.population.grain([stream.uniform(), stream.uniform()], medium.relative_index);
        let scattered = grain.scatter(stream);
        passage.ice_path_m += scattered.ice_path * hit_size_m(&medium.size, stream);
        cosine = turn(cosine, scattered.cos_scattering, stream);
    }
}

/// The cosine from the normal after scattering through an angle with a random azimuth.
#[inline]
pub(crate) fn turn(cosine: f64, cos_scattering: f64, stream: &mut Stream) -> f64 {
    let sines = ((1.0 - cosine * cosine) * (1.0 - cos_scattering * cos_scattering)).max(0.0).sqrt();
    (cosine * cos_scattering + sines * unit_circle(stream.uniform()).0).clamp(-1.0, 1.0)
}
