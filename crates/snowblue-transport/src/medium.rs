//! Snow as discrete ordinates see it: an extinction coefficient and the law of single scattering, mixed from tallies of
//! grains in air and in water, particles, and what is absorbed in between.
//!
//! Each constituent j adds κ_j to the extinction; what is scattered is averaged with the weights κ_j ω_j, and 1 − ω is
//! carried as the sum of what is absorbed, never as a difference.

use crate::constituents::Constituents;
use crate::ice::IceTable;
use crate::ordinates::Scattering;
use crate::population::Population;
use crate::sample::SnowSample;
use crate::tally::{Tally, TallyPlan};

/// A homogeneous medium at one wavelength.
#[derive(Debug, Clone, PartialEq)]
pub struct Medium {
    /// Extinction coefficient κ, in 1/m.
    pub extinction_per_m: f64,
    /// Single scattering per unit of optical depth.
    pub scattering: Scattering,
}

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
        let tally = |grains: &dyn Fn(&Constituents) -> crate::constituents::Grains| {
            let indices = || met.iter().map(|met| grains(met).relative_index);
            let range = (indices().fold(f64::INFINITY, f64::min), indices().fold(f64::NEG_INFINITY, f64::max));
            let strongest = met.iter().map(|met| grains(met).absorption_per_m).fold(0.0, f64::max);
            Tally::new(population, range, strongest * demand.largest_um * 1e-6, plan)
        };
        Self { in_air: tally(&|met| met.in_air), in_water: demand.wet.then(|| tally(&|met| met.in_water)) }
    }

    /// The medium that a sample of these grains, within what was demanded, is at a wavelength; without one of the tallies' 16 batches, for the
    /// jackknife (Tukey 1958).
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
        mix(&parts, met.pore_absorption_per_m)
    }
}

/// A medium of several scatterers, each with its extinction coefficient, and of something that only absorbs.
fn mix(parts: &[(f64, Scattering)], absorption_per_m: f64) -> Medium {
    let (mut extinction_per_m, mut absorbed_per_m, mut scattered_per_m) = (absorption_per_m, absorption_per_m, 0.0);
    let mut moments = vec![0.0; parts[0].1.moments.len()];
    for (part_per_m, scattering) in parts {
        let kept_per_m = part_per_m * (1.0 - scattering.one_minus_albedo);
        extinction_per_m += part_per_m;
        absorbed_per_m += part_per_m * scattering.one_minus_albedo;
        scattered_per_m += kept_per_m;
        for (sum, moment) in moments.iter_mut().zip(&scattering.moments) {
            *sum += kept_per_m * moment;
        }
    }
    moments.iter_mut().for_each(|moment| *moment /= scattered_per_m);
    // The mean of one is one.
    moments[0] = 1.0;
    let scattering = Scattering { one_minus_albedo: absorbed_per_m / extinction_per_m, moments };
    Medium { extinction_per_m, scattering }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mixture_keeps_what_is_absorbed_and_where_light_goes() {
        let parts = [
            (3.0, Scattering { one_minus_albedo: 0.1, moments: vec![1.0, 0.8, 0.6] }),
            (1.0, Scattering { one_minus_albedo: 0.4, moments: vec![1.0, 0.2, 0.1] }),
        ];
        let Medium { extinction_per_m, scattering } = mix(&parts, 0.5);
        assert!((extinction_per_m - 4.5).abs() < 1e-15);
        assert!((scattering.one_minus_albedo - (0.3 + 0.4 + 0.5) / 4.5).abs() < 1e-15);
        assert!((scattering.moments[1] - (2.7 * 0.8 + 0.6 * 0.2) / 3.3).abs() < 1e-15);
    }
}
