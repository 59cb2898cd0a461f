//! Random walks that enter a half-space of snow: where walks from grain to grain end; and where the light of a narrow
//! beam leaves, after how many scattering events, and how much of it passes a depth.
//!
//! The walks of a beam use a phase function; lengths are in mean free paths. The walks do not include absorption:
//! light with the co-albedo 1 − ω keeps the fraction ωⁿ over a walk of n events, so that one set of walks serves all
//! wavelengths. The first passage of a walk below a depth is the transmission of a slab of this thickness.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::VolumeNode;
use crate::medium::PhaseFunction;
use crate::rng::Stream;
use crate::slab::Incidence;

/// Steps of the cosine of incidence.
const CELLS: u32 = 16;
/// Walks at each cosine: the displacement has a standard error of 0.02 transport mean free paths.
const WALKS: u32 = 1 << 13;

/// Ends of the walks that enter a half-space and come to a scattering deeper than a bound.
///
/// Lengths are in transport mean free paths ℓ*. A walk ends at x + ℓ* w, one transport mean free path beyond its last
/// scattering x in its next direction w. The light that diffuses there equals the light that the walk would find (Li,
/// Pellacini & Torrance 2005, *A hybrid Monte Carlo method for accurate and efficient subsurface scattering*).
#[derive(Debug, Clone, PartialEq)]
pub struct WalkEnds {
    /// Means at equal steps of the cosine from 0 to 1.
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

/// Walks of a beam that enters a half-space at one point.
#[derive(Debug, Clone, PartialEq)]
pub struct NarrowBeam {
    walks: u32,
    /// Exits by increasing distance.
    exits: Vec<BeamExit>,
    /// Scattering events before the first passage of each depth, one for each walk that passes it.
    passages: Vec<Vec<u32>>,
}

/// Where a walk leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
struct BeamExit {
    /// Distance from the entry, in mean free paths.
    distance: f64,
    /// Scattering events.
    events: u32,
}

/// Options of the walks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BeamPlan {
    /// Number of walks.
    pub walks: u32,
    /// Straight flights after which a walk ends.
    pub most_flights: u32,
    /// Seed of all randomness.
    pub seed: u64,
}

/// Result of one walk.
struct Walk {
    exit: Option<BeamExit>,
    /// Events before the first passage of each depth that it passes, from the shallowest.
    passages: Vec<u32>,
}

impl NarrowBeam {
    /// Follows walks into a half-space. The depths are in mean free paths.
    ///
    /// Half of the light that snow sends back leaves within a few mean free paths of where it came in:
    /// ```
    /// # use snowblue_transport::{Incidence, PhaseFunction};
    /// # use snowblue_transport::monte_carlo::{BeamPlan, NarrowBeam};
    /// let plan = BeamPlan { walks: 1 << 12, most_flights: 10_000, seed: 1 };
    /// let phase = PhaseFunction::henyey_greenstein(0.7);
    /// let beam = NarrowBeam::new(&phase, Incidence::Beam { angle_deg: 0.0 }, &[], &plan);
    /// let radius = beam.radius(0.5, |_| 1.0).unwrap();
    /// assert!((3.0..10.0).contains(&radius));
    /// ```
    ///
    /// # Panics
    /// If there is no walk, or depths decrease.
    #[must_use]
    pub fn new(phase: &PhaseFunction, incidence: Incidence, depths: &[f64], plan: &BeamPlan) -> Self {
        assert!(plan.walks > 0 && depths.is_sorted(), "some walks, and depths {depths:?} that do not decrease");
        let found: Vec<Walk> = (0..plan.walks)
            .into_par_iter()
            .map(|walk| follow(phase, incidence, depths, plan.most_flights, Stream::new(plan.seed, walk.into())))
            .collect();
        let mut exits: Vec<BeamExit> = found.iter().filter_map(|walk| walk.exit).collect();
        exits.sort_by(|first, second| first.distance.total_cmp(&second.distance));
        let passages = (0..depths.len())
            .map(|depth| found.iter().filter_map(|walk| walk.passages.get(depth).copied()).collect())
            .collect();
        Self { walks: plan.walks, exits, passages }
    }

    /// The most scattering events of a walk that leaves.
    #[must_use]
    pub fn most_events(&self) -> u32 {
        self.exits.iter().map(|exit| exit.events).max().unwrap_or(0)
    }

    /// The fraction of light that leaves, where light keeps the fraction `kept(n)` over n events.
    #[must_use]
    pub fn reflectance(&self, kept: impl Fn(u32) -> f64) -> f64 {
        self.exits.iter().map(|exit| kept(exit.events)).sum::<f64>() / f64::from(self.walks)
    }

    /// The fraction of light that passes depth number `depth`.
    ///
    /// # Panics
    /// If there are fewer depths.
    #[must_use]
    pub fn transmittance(&self, depth: usize, kept: impl Fn(u32) -> f64) -> f64 {
        self.passages[depth].iter().map(|events| kept(*events)).sum::<f64>() / f64::from(self.walks)
    }

    /// Number of walks of equal weight that would give [`transmittance`](Self::transmittance) as well: (Σw)² / Σw².
    ///
    /// # Panics
    /// If there are fewer depths.
    #[must_use]
    pub fn effective_walks(&self, depth: usize, kept: impl Fn(u32) -> f64) -> f64 {
        let (mut sum, mut squares) = (0.0, 0.0);
        for weight in self.passages[depth].iter().map(|events| kept(*events)) {
            (sum, squares) = (sum + weight, squares + weight * weight);
        }
        if squares > 0.0 { sum * sum / squares } else { 0.0 }
    }

    /// The radius, in mean free paths, of the circle about the entry through which the fraction `fraction` of the light
    /// leaves; none if less leaves in all.
    #[must_use]
    pub fn radius(&self, fraction: f64, kept: impl Fn(u32) -> f64) -> Option<f64> {
        let wanted = fraction * f64::from(self.walks);
        let mut sum = 0.0;
        let reached = self.exits.iter().find(|exit| {
            sum += kept(exit.events);
            sum >= wanted
        });
        reached.map(|exit| exit.distance)
    }
}

/// Follows a walk until it leaves or has had all its flights.
fn follow(phase: &PhaseFunction, incidence: Incidence, depths: &[f64], most: u32, mut stream: Stream) -> Walk {
    let cos = match incidence {
        Incidence::Beam { angle_deg } => angle_deg.to_radians().cos(),
        Incidence::Diffuse => stream.uniform().sqrt(),
    };
    let mut direction = [(1.0 - cos * cos).sqrt(), 0.0, cos];
    let mut place = [0.0; 3];
    let mut passages = Vec::new();
    for events in 0..most {
        let flight = -stream.uniform().ln();
        let before = place;
        place.iter_mut().zip(direction).for_each(|(place, part)| *place += flight * part);
        while depths.get(passages.len()).is_some_and(|depth| place[2] > *depth) {
            passages.push(events);
        }
        if place[2] < 0.0 {
            // Back along the flight to the surface.
            let part = before[2] / (before[2] - place[2]);
            let [x, y] = [0, 1].map(|axis| before[axis] + part * (place[axis] - before[axis]));
            return Walk { exit: Some(BeamExit { distance: x.hypot(y), events }), passages };
        }
        direction = turned(direction, phase.sample_cos(stream.uniform()), TAU * stream.uniform());
    }
    Walk { exit: None, passages }
}

/// A unit vector turned by the angle of a cosine, at an azimuth.
fn turned([x, y, z]: [f64; 3], cos: f64, azimuth: f64) -> [f64; 3] {
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
    use crate::medium::{HenyeyGreenstein, PhaseFunction, PhasePlan};
    use crate::ordinates::{HalfSpace, HomogeneousMedium};
    use crate::sample::SnowSample;

    /// Light that rises from far below has the fluence rate (q + z) at the depth z, and leaves as 4/3 K(μ) / 4π. By
    /// reciprocity the mean of q + z over the ends of walks is 4/3 K.
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

    const WALKS: u32 = 1 << 16;

    fn beam(asymmetry: f64, incidence: Incidence, most_flights: u32) -> NarrowBeam {
        let plan = BeamPlan { walks: WALKS, most_flights, seed: 5 };
        NarrowBeam::new(&PhaseFunction::henyey_greenstein(asymmetry), incidence, &[1.0, 10.0], &plan)
    }

    /// Walks and discrete ordinates agree within 4 standard errors, at most 0.5/√N of a fraction each.
    #[test]
    fn walks_agree_with_discrete_ordinates() {
        let tolerance = 4.0 * 0.5 / f64::from(WALKS).sqrt();
        for asymmetry in [0.0, 0.7] {
            for incidence in [Incidence::Beam { angle_deg: 0.0 }, Incidence::Diffuse] {
                // Absorption leaves 10⁻⁴ of the light of longer walks.
                let walks = beam(asymmetry, incidence, 1000);
                for one_minus_albedo in [0.01, 0.2] {
                    let medium =
                        HomogeneousMedium::new(&HenyeyGreenstein { one_minus_albedo, asymmetry }.scattering(32), 32);
                    let light = medium.light(&incidence);
                    let kept = |events: u32| (f64::from(events) * (-one_minus_albedo).ln_1p()).exp();
                    let reflectance = medium.fluxes(f64::INFINITY, [&light])[0].reflectance;
                    assert!((walks.reflectance(kept) - reflectance).abs() < tolerance, "{asymmetry} {incidence:?}");
                    for (number, depth) in [1.0, 10.0].into_iter().enumerate() {
                        let transmittance = medium.fluxes(depth, [&light])[0].transmittance;
                        let walked = walks.transmittance(number, kept);
                        assert!((walked - transmittance).abs() < tolerance, "{asymmetry} {depth}: {walked}");
                    }
                }
            }
        }
    }

    /// On an isotropic half-space that does not absorb, the walks of more than N flights keep the fraction 4/√(3πN)
    /// of Lambertian light: the singularity 1 − R = 4 √((1 − ω)/3) of the reflectance at ω = 1 has these
    /// coefficients.
    #[test]
    fn the_light_of_long_walks_follows_from_the_singularity_of_the_reflectance() {
        for flights in [256, 1024] {
            let lost = 1.0 - beam(0.0, Incidence::Diffuse, flights).reflectance(|_| 1.0);
            let expected = 4.0 / (3.0 * std::f64::consts::PI * f64::from(flights)).sqrt();
            // The next term is smaller by 1/√N, and the noise is 0.001 in the lost fraction of 0.04 to 0.08.
            let tolerance = 4.0 * (expected / f64::from(WALKS)).sqrt() + expected / f64::from(flights).sqrt();
            assert!((lost - expected).abs() < tolerance, "{flights}: {lost} {expected}");
        }
    }

    #[test]
    fn half_of_the_light_leaves_within_the_median_distance() {
        let walks = beam(0.5, Incidence::Beam { angle_deg: 0.0 }, 1000);
        let all = walks.reflectance(|_| 1.0);
        let (half, whole) = (walks.radius(0.5 * all, |_| 1.0).unwrap(), walks.radius(all, |_| 1.0).unwrap());
        let within = walks.exits.iter().filter(|exit| exit.distance <= half).count() as f64;
        assert!((within / walks.exits.len() as f64 - 0.5).abs() < 1e-4 && whole > 10.0 * half);
        // Absorption takes more from long walks, which go further.
        let absorbed = |events: u32| 0.9_f64.powi(events.cast_signed());
        let remaining = walks.reflectance(absorbed);
        assert!(walks.radius(0.5 * remaining, absorbed).unwrap() < half);
        assert_eq!(walks.radius(1.0, absorbed), None);
    }
}
