//! Where walks from grain to grain end that enter a half-space of snow.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::VolumeNode;
use crate::rng::Stream;

/// Steps of the cosine of incidence.
const CELLS: u32 = 16;
/// Walks at each cosine: the displacement has a standard error of 0.02 transport mean free paths.
const WALKS: u32 = 1 << 13;

/// Where walks end that enter a half-space: those that come to a scattering deeper than a bound.
///
/// Lengths are in transport mean free paths ℓ*. A walk ends at x + ℓ* w, one transport mean free path from its last
/// scattering x on in its next direction w. The light that diffuses there is what the walk would find (Li, Pellacini &
/// Torrance 2005, *A hybrid Monte Carlo method for accurate and efficient subsurface scattering*).
#[derive(Debug, Clone, PartialEq)]
pub struct WalkEnds {
    /// At equal steps of the cosine from 0 to 1.
    means: Vec<MeanEnd>,
}

/// Means over all walks of a cosine of incidence. A walk that leaves counts as nothing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MeanEnd {
    /// Fraction of walks that end inside.
    pub probability: f64,
    /// Depth of the end, in ℓ*.
    pub depth: f64,
    /// Displacement of the end from the entry, along the surface in the direction of incidence, in ℓ*.
    pub displacement: f64,
}

impl WalkEnds {
    /// Follows walks through snow until a scattering lies deeper than `depth` transport mean free paths, each of
    /// `transport_length_m`.
    #[must_use]
    pub fn new(node: &VolumeNode, transport_length_m: f64, depth: f64) -> Self {
        let mean_flight = 1.0 / (node.extinction_per_m() * transport_length_m);
        let mean_end = |cell: u32| {
            let cos = f64::from(cell) / f64::from(CELLS);
            let mut sum = MeanEnd::default();
            for walk in 0..WALKS {
                let stream = Stream::new(u64::from(cell), u64::from(walk));
                if let Some([end_depth, displacement]) = end(node, stream, cos, mean_flight, depth) {
                    sum.probability += 1.0;
                    sum.depth += end_depth;
                    sum.displacement += displacement;
                }
            }
            let share = f64::from(WALKS).recip();
            MeanEnd {
                probability: share * sum.probability,
                depth: share * sum.depth,
                displacement: share * sum.displacement,
            }
        };
        Self { means: (0..=CELLS).into_par_iter().map(mean_end).collect() }
    }

    /// The means at a cosine of incidence in 0–1.
    #[must_use]
    pub fn at(&self, cos: f64) -> MeanEnd {
        let place = cos.clamp(0.0, 1.0) * f64::from(CELLS);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the table")]
        let cell = (place as usize).min(self.means.len() - 2);
        let (part, first, last) = (place - cell as f64, self.means[cell], self.means[cell + 1]);
        let between = |value: fn(MeanEnd) -> f64| value(first) + part * (value(last) - value(first));
        MeanEnd {
            probability: between(|mean| mean.probability),
            depth: between(|mean| mean.depth),
            displacement: between(|mean| mean.displacement),
        }
    }
}

/// Depth and displacement of a walk's end, in transport mean free paths; none if it leaves.
fn end(node: &VolumeNode, mut stream: Stream, cos: f64, mean_flight: f64, depth: f64) -> Option<[f64; 2]> {
    // Components along the displacement, along the surface across it, and downwards.
    let mut direction = [(1.0 - cos * cos).sqrt(), 0.0, cos];
    let mut events = node.events_from(stream.uniform());
    let (mut displacement, mut down) = (0.0, 0.0);
    loop {
        let flight = -stream.uniform().ln() * mean_flight;
        displacement += flight * direction[0];
        down += flight * direction[2];
        if down < 0.0 {
            return None;
        }
        let cos_scattering = events.next()?.cos_scattering;
        direction = turned(direction, cos_scattering.into(), TAU * stream.uniform());
        if down > depth {
            return Some([down + direction[2], displacement + direction[0]]);
        }
    }
}

/// A unit vector turned by the angle of a cosine, at an azimuth.
pub(super) fn turned([x, y, z]: [f64; 3], cos: f64, azimuth: f64) -> [f64; 3] {
    // Two vectors perpendicular to it and to each other (Duff et al. 2017, *Building an orthonormal basis, revisited*).
    let sign = 1.0_f64.copysign(z);
    let a = -1.0 / (sign + z);
    let b = x * y * a;
    let (tangent, bitangent) = ([1.0 + sign * x * x * a, sign * b, -sign * x], [b, sign + y * y * a, -y]);
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let (across, aside) = (sin * azimuth.cos(), sin * azimuth.sin());
    let turned: [f64; 3] = std::array::from_fn(|k| cos * [x, y, z][k] + across * tangent[k] + aside * bitangent[k]);
    let length = turned.iter().map(|part| part * part).sum::<f64>().sqrt();
    turned.map(|part| part / length)
}

#[cfg(test)]
mod tests {
    use super::super::{GrainPlan, Volume};
    use super::*;
    use crate::medium::{PhaseFunction, PhasePlan};
    use crate::ordinates::HalfSpace;
    use crate::sample::SnowSample;

    /// Light that rises from far below has the fluence rate (q + z) at the depth z, and leaves as 4/3 K(μ) / 4π. So the
    /// ends of walks have the mean of q + z equal to 4/3 K, by reciprocity.
    #[test]
    fn the_ends_of_walks_see_the_light_that_the_half_space_sends_out() {
        let sample = SnowSample::default();
        let plan = GrainPlan { grains: 1 << 18, seed: 3 };
        let volume = Volume::with_one_index(&sample, &[550.0], &plan).unwrap();
        let node = &volume.nodes()[0];
        let phase = PhaseFunction::of_sample(&sample, 550.0, &PhasePlan::default()).unwrap();
        let transport_length_m = 1.0 / (node.extinction_per_m() * (1.0 - phase.asymmetry()));
        let half_space = HalfSpace::new(&phase);
        let ends = WalkEnds::new(node, transport_length_m, 2.0);
        for cell in [1, 4, 8, 12, 16] {
            let cos = f64::from(cell) / 16.0;
            let MeanEnd { probability, depth, displacement } = ends.at(cos);
            let ratio = 0.75 * (half_space.extrapolation() * probability + depth) / half_space.escape(cos);
            // The noise of the walks is 1 %, and light at 2 ℓ* diffuses to 1 %.
            assert!((ratio - 1.0).abs() < 0.03, "{cos}: {ratio}");
            assert!((0.0..0.5).contains(&displacement) && (cell < 16 || displacement < 0.05), "{cos}: {displacement}");
        }
    }
}
