//! Snow as a volume: what light meets that walks through it in space, for a body of any shape.
//!
//! Who walks draws free flights with the extinction coefficient, meets a grain or a particle at the end of each
//! ([`VolumeNode::turns`]), turns by its angle about a random azimuth, and adds up the lengths of the way; these tell at
//! its end what is left of each wavelength ([`Volume::left`]). As in a slab, the way depends on the wavelength through
//! the index of ice alone: walks at a few nodes of the index serve all wavelengths, each composed of them by its weights.
//!
//! The grains are met beforehand, a million at each node, and ways go along that list from random places on: what a grain does
//! knows nothing of where the light is. The list stands for all grains as far as it is long: of its 1 − ⟨cos Θ⟩, with which the
//! light through deep snow goes, the standard error is .4 %.
//!
//! **The phase function** joins two points of a way by force: from each scattering straight to a lamp. It is the share of
//! light, per sr, that leaves a grain in a direction,
//!
//! ```text
//! P(Θ; λ) = ⟨exp(−γ(λ) ℓ) δ(Ω − Ω′)⟩,   ∫ P dΩ = ω(λ), the single-scattering albedo,
//! ```
//!
//! tabulated from the same grains in bins that are even in sin Θ/2, narrow where light goes straight on and none too small
//! where it comes back.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::spectral::nodes;
use super::walk::Scatterers;
use crate::TransportError;
use crate::medium::{Constituents, hit_size_m};
use crate::rng::Stream;
use crate::sample::SnowSample;
use crate::slab::check_wavelengths;

/// Bins of the phase function.
const BINS: usize = 128;
/// Grains that one task meets.
const GRAINS_PER_TASK: usize = 1 << 12;

/// Snow that light walks through, at some wavelengths.
#[derive(Debug, Clone)]
pub struct Volume {
    nodes: Vec<VolumeNode>,
    /// [wavelength]
    absorptions: Vec<Absorption>,
    least: Absorption,
}

/// Snow as light sees it at one index of ice.
#[derive(Debug, Clone)]
pub struct VolumeNode {
    extinction_per_m: f64,
    weights: Vec<f32>,
    turns: Vec<Turn>,
    /// [bin][wavelength], in 1/sr
    phase_per_sr: Vec<f32>,
}

/// What becomes of light that meets a grain or a particle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    /// Cosine of the scattering angle.
    pub cos_scattering: f32,
    /// Path through the ice of a grain that lies in air, and of one in water, in m.
    pub ice_m: [f32; 2],
}

/// How far light went, in m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Lengths {
    /// Through the ice of grains in air, and of grains in water.
    pub ice_m: [f64; 2],
    /// Between grains.
    pub pores_m: f64,
}

/// How many grains are met beforehand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GrainPlan {
    /// Grains per index node.
    pub grains: u32,
    /// Seed of all randomness.
    pub seed: u64,
}

/// What lengths cost at one wavelength, in 1/m.
#[derive(Debug, Clone, Copy)]
struct Absorption {
    ice_per_m: [f64; 2],
    pores_per_m: f64,
}

impl Default for GrainPlan {
    /// Some thousand grains a bin: P is right to 1.5 % in each, and far better in the mean over them.
    fn default() -> Self {
        Self { grains: 1 << 20, seed: 1 }
    }
}

impl Volume {
    /// The volume that snow is at some wavelengths.
    ///
    /// # Errors
    /// If a property of the snow is out of range, or a wavelength beyond the tables.
    pub fn new(sample: &SnowSample, wavelengths_nm: &[f64], plan: &GrainPlan) -> Result<Self, TransportError> {
        sample.check()?;
        check_wavelengths(wavelengths_nm, sample)?;
        let constituents = |wavelength_nm: &f64| Constituents::new(sample, *wavelength_nm);
        let met: Vec<Constituents> = wavelengths_nm.iter().map(constituents).collect();
        let absorptions: Vec<Absorption> = met.iter().map(Absorption::new).collect();
        let (nodes_nm, weights) = nodes(sample, wavelengths_nm, &met);
        let node = |(number, wavelength_nm): (usize, &f64)| {
            let scatterers = Scatterers::new(sample, &constituents(wavelength_nm));
            #[expect(clippy::cast_possible_truncation, reason = "weights are of the order of one")]
            let weights: Vec<f32> = weights.iter().map(|weights| weights[number] as f32).collect();
            let turns = meet(&scatterers, plan);
            let phase_per_sr = tabulate(&turns, &absorptions);
            VolumeNode { extinction_per_m: scatterers.extinction_per_m, weights, turns, phase_per_sr }
        };
        let nodes = nodes_nm.iter().enumerate().map(node).collect();
        let least = absorptions.iter().copied().reduce(Absorption::least).unwrap_or(absorptions[0]);
        Ok(Self { nodes, absorptions, least })
    }

    /// Snow at each node of the index. The mean over walks at every node, times the node's weights and summed, is unbiased.
    #[must_use]
    pub fn nodes(&self) -> &[VolumeNode] {
        &self.nodes
    }

    /// An optical depth of absorption that light of no wavelength falls short of on such a way: who lets chance end ways
    /// with the probability 1 − e^{−depth} may count it as paid.
    #[inline]
    #[must_use]
    pub fn least_absorbed(&self, way: &Lengths) -> f64 {
        self.least.depth(way)
    }

    /// The share of light of each wavelength that is left after a way, with an optical depth of absorption already paid.
    pub fn left(&self, way: &Lengths, paid: f64, left: &mut [f32]) {
        for (left, absorption) in left.iter_mut().zip(&self.absorptions) {
            #[expect(clippy::cast_possible_truncation, reason = "single precision holds a share of light")]
            let depth = (absorption.depth(way) - paid) as f32;
            *left = (-depth).exp();
        }
    }
}

impl VolumeNode {
    /// Extinction coefficient of all that turns light, in 1/m.
    #[inline]
    #[must_use]
    pub fn extinction_per_m(&self) -> f64 {
        self.extinction_per_m
    }

    /// What a walk at this node counts for each wavelength; the weights of all nodes sum up to 1.
    #[must_use]
    pub fn weights(&self) -> &[f32] {
        &self.weights
    }

    /// What the grains and particles do that light meets here, in no order. Of all nodes those at the same place did it by the same
    /// chance.
    #[inline]
    #[must_use]
    pub fn turns(&self) -> &[Turn] {
        &self.turns
    }

    /// The share of light, per sr, that leaves a grain at an angle with this cosine from where it was going, wavelength by
    /// wavelength: P(Θ; λ), with ∫ P dΩ = ω.
    #[inline]
    #[must_use]
    pub fn phase_per_sr(&self, cos_scattering: f64) -> &[f32] {
        let wavelengths = self.weights.len();
        &self.phase_per_sr[bin(cos_scattering) * wavelengths..][..wavelengths]
    }
}

impl Absorption {
    fn new(met: &Constituents) -> Self {
        let ice_per_m = [met.in_air.absorption_per_m, met.in_water.absorption_per_m];
        Self { ice_per_m, pores_per_m: met.pore_absorption_per_m }
    }

    fn least(self, other: Self) -> Self {
        Self {
            ice_per_m: [0, 1].map(|i| self.ice_per_m[i].min(other.ice_per_m[i])),
            pores_per_m: self.pores_per_m.min(other.pores_per_m),
        }
    }

    #[inline]
    fn depth(&self, way: &Lengths) -> f64 {
        self.ice_per_m[0] * way.ice_m[0] + self.ice_per_m[1] * way.ice_m[1] + self.pores_per_m * way.pores_m
    }
}

/// The bin of an angle: even in sin Θ/2 = √((1 − cos Θ)/2).
#[inline]
fn bin(cos_scattering: f64) -> usize {
    let place = (0.5 * (1.0 - cos_scattering)).max(0.0).sqrt() * BINS as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 ≤ place, and kept below the end")]
    let bin = (place as usize).min(BINS - 1);
    bin
}

/// Solid angle of a bin, 2π (cos Θ₁ − cos Θ₂) = 4π (u₂² − u₁²), in sr.
fn solid_angle_sr(bin: usize) -> f64 {
    let (first, last) = (bin as f64 / BINS as f64, (bin + 1) as f64 / BINS as f64);
    4.0 * PI * (last * last - first * first)
}

/// Meets many grains.
fn meet(scatterers: &Scatterers, plan: &GrainPlan) -> Vec<Turn> {
    let turn = |grain: u32| {
        let mut stream = Stream::new(plan.seed, grain.into());
        let met = scatterers.meet(&mut stream);
        let size_m = hit_size_m(&scatterers.size, &mut stream);
        #[expect(clippy::cast_possible_truncation, reason = "single precision is far finer than the grains' scatter")]
        let narrow = |value: f64| value as f32;
        Turn { cos_scattering: narrow(met.cos_scattering), ice_m: met.ice_path.map(|path| narrow(path * size_m)) }
    };
    (0..plan.grains).into_par_iter().map(turn).collect()
}

/// Sorts what grains let out by its angle: [bin][wavelength], in 1/sr.
fn tabulate(turns: &[Turn], absorptions: &[Absorption]) -> Vec<f32> {
    let wavelengths = absorptions.len();
    let task = |turns: &[Turn]| {
        let mut sums = vec![0.0; BINS * wavelengths];
        for turn in turns {
            let way = Lengths { ice_m: turn.ice_m.map(f64::from), pores_m: 0.0 };
            let sums = &mut sums[bin(turn.cos_scattering.into()) * wavelengths..][..wavelengths];
            for (sum, absorption) in sums.iter_mut().zip(absorptions) {
                *sum += (-absorption.depth(&way)).exp();
            }
        }
        sums
    };
    let parts: Vec<Vec<f64>> = turns.par_chunks(GRAINS_PER_TASK).map(task).collect();
    let mut sums = vec![0.0; BINS * wavelengths];
    for part in parts {
        sums.iter_mut().zip(part).for_each(|(sum, term)| *sum += term);
    }
    #[expect(clippy::cast_possible_truncation, reason = "its own scatter is far above single precision")]
    let per_sr = |(place, sum): (usize, f64)| (sum / (turns.len() as f64 * solid_angle_sr(place / wavelengths))) as f32;
    sums.into_iter().enumerate().map(per_sr).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Demand, GrainTallies, Population, TallyPlan};

    /// ∫ P dΩ is the albedo and ∫ P cos Θ dΩ over it the asymmetry that the ordinates' tally of other rays finds, in dry
    /// and in wet snow, where ice absorbs a hundred-thousandth and where it absorbs a third.
    #[test]
    fn the_phase_function_has_the_albedo_and_the_asymmetry_of_the_medium() {
        let wavelengths_nm = [450.0, 700.0, 1500.0];
        let plan = GrainPlan { grains: 1 << 18, seed: 7 };
        for water_saturation in [0.0, 0.3] {
            let sample = SnowSample { water_saturation, ..SnowSample::default() };
            let wavelengths_nm = &wavelengths_nm[..if water_saturation > 0.0 { 2 } else { 3 }];
            let volume = Volume::new(&sample, wavelengths_nm, &plan).unwrap();
            let demand = Demand::of_sample(&sample, wavelengths_nm);
            let tally = TallyPlan { degree: 2, rays: 1 << 18, seed: 1 };
            let tallies = GrainTallies::new(&Population::of_sample(&sample), &demand, &tally);
            for (k, wavelength_nm) in wavelengths_nm.iter().enumerate() {
                let (mut albedo, mut along) = (0.0, 0.0);
                for bin in 0..BINS {
                    let middle_cos = 1.0 - ((bin * bin) as f64 + ((bin + 1) * (bin + 1)) as f64) / (BINS * BINS) as f64;
                    for node in volume.nodes() {
                        let share =
                            f64::from(node.weights()[k] * node.phase_per_sr(middle_cos)[k]) * solid_angle_sr(bin);
                        albedo += share;
                        along += share * middle_cos;
                    }
                }
                let medium = tallies.medium(&sample, *wavelength_nm, None);
                let lost = medium.scattering.one_minus_albedo * medium.extinction_per_m;
                let in_pores = Constituents::new(&sample, *wavelength_nm).pore_absorption_per_m;
                let expected = (lost - in_pores) / (medium.extinction_per_m - in_pores);
                // 2¹⁸ ice paths of a deviation as great as their mean, on both sides: 4 σ are 1.1 %; and single precision.
                let allowed = 0.011 * expected + 3e-6;
                assert!((1.0 - albedo - expected).abs() < allowed, "{wavelength_nm}: {albedo} {expected}");
                // The cosine's deviation is .4: 4 σ are .0044 of 2¹⁸ grains on both sides. Bins add less than 10⁻⁴.
                let asymmetry = medium.scattering.asymmetry();
                assert!((along / albedo - asymmetry).abs() < 0.0045, "{wavelength_nm}: {} {asymmetry}", along / albedo);
            }
        }
    }

    /// Chance ends no more light than the least absorbed wavelength loses.
    #[test]
    fn what_is_paid_is_less_than_any_wavelength_owes() {
        let volume = Volume::new(&SnowSample::default(), &[420.0, 550.0, 700.0], &GrainPlan { grains: 1, seed: 1 });
        let volume = volume.unwrap();
        let way = Lengths { ice_m: [2.0, 0.0], pores_m: 9.0 };
        let mut left = [0.0; 3];
        volume.left(&way, volume.least_absorbed(&way), &mut left);
        assert!(left.iter().all(|left| *left <= 1.0) && left.iter().any(|left| *left >= 1.0), "{left:?}");
        assert!(left[2] < 0.5 * left[1], "{left:?}");
    }
}
