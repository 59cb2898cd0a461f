//! Snow as discrete ordinates see it: an extinction coefficient and the law of single scattering, mixed from tallies of
//! grains in air and in water, particles, and what is absorbed in between.
//!
//! Each constituent j adds κ_j to the extinction; what is scattered is averaged with the weights κ_j ω_j, and 1 − ω is
//! carried as the sum of what is absorbed, never as a difference.

use super::constituents::{Constituents, Grains};
use super::grain_optics::GrainOptics;
use super::population::Population;
use super::scattering::{Medium, Scattering};
use super::tally::{Tally, TallyPlan};
use crate::optics::ice::{Ice, IceTable};
use crate::sample::{GrainSize, SnowSample};

/// What all the snow has in common that one pair of tallies serves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Demand<'w> {
    /// Every wavelength, in nm.
    pub wavelengths_nm: &'w [f64],
    /// Whose ice.
    pub ice: IceTable,
    /// Size of the largest grain, in µm.
    pub largest_um: f64,
    /// Whether any of the snow is wet.
    pub wet: bool,
}

/// Tallies of the grains of one population, in air and, if there is any, in water.
#[derive(Debug, Clone)]
pub struct GrainTallies {
    in_air: Tally,
    in_water: Option<Tally>,
}

impl Demand<'_> {
    /// What a sample asks for by itself.
    #[must_use]
    pub fn of_sample<'w>(sample: &SnowSample, wavelengths_nm: &'w [f64]) -> Demand<'w> {
        Demand {
            wavelengths_nm,
            ice: sample.ice,
            largest_um: sample.grain_size.max_um,
            wet: sample.water_saturation > 0.0,
        }
    }

    /// What both ask for together; they have the ice and the wavelengths in common.
    #[must_use]
    pub fn and(self, other: &Self) -> Self {
        Self { largest_um: self.largest_um.max(other.largest_um), wet: self.wet || other.wet, ..self }
    }
}

impl GrainTallies {
    /// Sends rays at the grains of `population`.
    #[must_use]
    pub fn new(population: &Population, demand: &Demand, plan: &TallyPlan) -> Self {
        let saturation = if demand.wet { 0.5 } else { 0.0 };
        let sample = SnowSample { ice: demand.ice, water_saturation: saturation, ..SnowSample::default() };
        let met: Vec<Constituents> =
            demand.wavelengths_nm.iter().map(|wavelength_nm| Constituents::new(&sample, *wavelength_nm)).collect();
        let tally = |grains: &dyn Fn(&Constituents) -> Grains| {
            let indices = || met.iter().map(|met| grains(met).relative_index);
            let range = (indices().fold(f64::INFINITY, f64::min), indices().fold(f64::NEG_INFINITY, f64::max));
            let strongest = met.iter().map(|met| grains(met).absorption_per_m).fold(0.0, f64::max);
            Tally::new(population, range, strongest * demand.largest_um * 1e-6, plan)
        };
        Self { in_air: tally(&|met| met.in_air), in_water: demand.wet.then(|| tally(&|met| met.in_water)) }
    }

    /// The medium that a sample of these grains, within what was demanded, is at a wavelength; without one of the tallies'
    /// 16 batches, for the jackknife (Tukey 1958).
    ///
    /// # Panics
    /// If the sample is wet and the demand was not.
    #[must_use]
    pub fn medium(&self, sample: &SnowSample, wavelength_nm: f64, without: Option<usize>) -> Medium {
        assert!(sample.water_saturation <= 0.0 || self.in_water.is_some(), "no tally of grains in water was asked for");
        let met = Constituents::new(sample, wavelength_nm);
        let mut parts = Vec::new();
        for (tally, grains) in [(Some(&self.in_air), met.in_air), (self.in_water.as_ref(), met.in_water)] {
            if let Some(tally) = tally.filter(|_| grains.extinction_per_m > 0.0) {
                let scattering =
                    tally.scattering(&sample.grain_size, (grains.relative_index, grains.absorption_per_m), without);
                parts.push((grains.extinction_per_m, scattering));
            }
        }
        // Nothing but dry grains: no sums that would round.
        if parts.len() == 1 && met.particles.is_empty() && met.pore_absorption_per_m <= 0.0 {
            let (extinction_per_m, scattering) = parts.swap_remove(0);
            return Medium { extinction_per_m, scattering };
        }
        let degree = self.in_air.degree();
        for particle in &met.particles {
            parts.push((particle.scattering_per_m, Scattering::henyey_greenstein(0.0, particle.asymmetry, degree)));
        }
        Medium::mix(&parts, met.pore_absorption_per_m)
    }

    /// Asymmetry parameter and path enhancement B of a sample's grains in air at a wavelength, while absorption is weak:
    /// B = ⟨ℓ⟩/(4V/S), the mean ice path per hit over the mean chord.
    #[must_use]
    pub fn grain_optics(&self, sample: &SnowSample, wavelength_nm: f64) -> GrainOptics {
        const WEAK_PER_M: f64 = 1e-6;
        let scattering = self.in_air(&sample.grain_size, Ice::new(sample.ice).index(wavelength_nm), WEAK_PER_M);
        let per_ice = sample.extinction_per_m() / (sample.ice_fraction() * WEAK_PER_M);
        GrainOptics {
            extinction_ratio: 1.0,
            path_enhancement: scattering.one_minus_albedo * per_ice,
            asymmetry: scattering.asymmetry(),
        }
    }

    /// Single scattering by grains in air of a refractive index and an absorption coefficient, in 1/m, that need not be
    /// those of ice at any wavelength; the index lies among those of the demand.
    pub(crate) fn in_air(&self, size: &GrainSize, index: f64, absorption_per_m: f64) -> Scattering {
        self.in_air.scattering(size, (index, absorption_per_m), None)
    }
}
