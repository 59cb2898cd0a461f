//! Snow as discrete ordinates see it: an extinction coefficient and the law of single scattering, mixed from tallies of
//! grains in air and in water, particles, and what is absorbed in between.
//!
//! Each constituent j adds κ_j to the extinction; what is scattered is averaged with the weights κ_j ω_j, and 1 − ω is
//! carried as the sum of what is absorbed, never as a difference.

use crate::constituents::Constituents;
use crate::ice::{self, Ice, IceTable};
use crate::ordinates::{Fluxes, HomogeneousMedium, Light, MOST_STREAMS, Peak, Scattering, Streams};
use crate::population::Population;
use crate::sample::{GrainSize, SnowSample};
use crate::slab::Incidence;
use crate::tally::{Tally, TallyPlan};

/// A homogeneous medium at one wavelength.
#[derive(Debug, Clone, PartialEq)]
pub struct Medium {
    /// Extinction coefficient κ, in 1/m.
    pub extinction_per_m: f64,
    /// Single scattering per unit of optical depth.
    pub scattering: Scattering,
}

impl Medium {
    /// Fluxes of slabs of this medium over nothing that reflects: for each thickness, then each incidence.
    #[must_use]
    pub fn fluxes(
        &self,
        thicknesses_cm: &[f64],
        incidences: &[Incidence],
        (streams, peak): (Streams, Peak),
    ) -> Vec<Fluxes> {
        let nothing = Fluxes { reflectance: 0.0, transmittance: 0.0, direct: 0.0 };
        let mut filled = vec![nothing; thicknesses_cm.len() * incidences.len()];
        for (streams, places) in streams.groups(incidences, peak) {
            let modes = HomogeneousMedium::new(&self.scattering, streams);
            let lights: Vec<Light> = places.iter().map(|place| modes.light(&incidences[*place])).collect();
            for (row, thickness_cm) in filled.chunks_exact_mut(incidences.len()).zip(thicknesses_cm) {
                let optical_depth = self.extinction_per_m * thickness_cm * 0.01;
                for (place, fluxes) in places.iter().zip(modes.fluxes(optical_depth, &lights)) {
                    row[*place] = fluxes;
                }
            }
        }
        filled
    }
}

/// What snow of a density and a surface area further has to tell of itself: three numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GrainOptics {
    /// Extinction coefficient over that of convex grains, ρ SSA/4.
    pub extinction_ratio: f64,
    /// B: mean ice path per hit over the mean chord 4V/S of convex grains.
    pub path_enhancement: f64,
    /// Asymmetry parameter of refraction and reflection, without diffraction.
    pub asymmetry: f64,
}

/// Extinction coefficient of convex grains in random orientation, κ = ρ SSA/4, in 1/m.
#[must_use]
pub fn convex_extinction_per_m(density_kg_m3: f64, surface_area_m2_kg: f64) -> f64 {
    0.25 * density_kg_m3 * surface_area_m2_kg
}

impl GrainOptics {
    /// The medium that snow with these properties is for light that ice absorbs with γ = `absorption_per_m`: a metre of snow
    /// absorbs γ B φ, and what it scatters goes by Henyey & Greenstein's law.
    #[must_use]
    pub fn medium(&self, density_kg_m3: f64, surface_area_m2_kg: f64, absorption_per_m: f64) -> Medium {
        let extinction_per_m = self.extinction_ratio * convex_extinction_per_m(density_kg_m3, surface_area_m2_kg);
        let ice_fraction = density_kg_m3 / ice::density_kg_m3(0.0);
        let one_minus_albedo = absorption_per_m * self.path_enhancement * ice_fraction / extinction_per_m;
        Medium {
            extinction_per_m,
            scattering: Scattering::henyey_greenstein(one_minus_albedo, self.asymmetry, MOST_STREAMS),
        }
    }
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
        mix(&parts, met.pore_absorption_per_m)
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
