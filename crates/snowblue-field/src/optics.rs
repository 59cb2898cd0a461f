//! Snow as a diffusing medium at some wavelengths.

use snowblue_transport::ordinates::HalfSpace;
use snowblue_transport::{
    Demand, GrainTallies, Medium, PhaseFunction, PhasePlan, Population, SnowSample, TallyPlan, TransportError,
};

/// Diffusion and absorption of snow, and the functions of its surface.
#[derive(Debug, Clone)]
pub struct SnowOptics {
    /// Transport mean free path ℓ* = 1/(κ (1 − ω g)) at each wavelength, in m.
    pub transport_lengths_m: Vec<f64>,
    /// Absorption coefficient μ_a = κ (1 − ω) at each wavelength, in 1/m.
    pub absorption_per_m: Vec<f64>,
    /// The half-space of the phase function at the middle wavelength, with the medium's asymmetry.
    pub half_space: HalfSpace,
}

impl SnowOptics {
    /// The optics of a sample at some wavelengths. `rays` is the number of rays through the grains per node of the
    /// refractive index: 2¹⁸ rays leave an error of 0.2 % in the transmittance of 15 cm.
    ///
    /// # Errors
    ///
    /// If a parameter of the sample is out of range, or the tables do not cover a wavelength.
    pub fn new(sample: &SnowSample, wavelengths_nm: &[f64], rays: u32) -> Result<Self, TransportError> {
        sample.check()?;
        wavelengths_nm.iter().try_for_each(|wavelength_nm| sample.check_wavelength(*wavelength_nm))?;
        let demand = Demand::of_sample(sample, wavelengths_nm);
        let plan = TallyPlan { degree: 1, rays, seed: 1 };
        let tallies = GrainTallies::new(&Population::of_sample(sample), &demand, &plan);
        let media: Vec<_> = wavelengths_nm.iter().map(|wavelength_nm| tallies.medium(sample, *wavelength_nm)).collect();
        let transport_length_m = |medium: &Medium| {
            let scattering = &medium.scattering;
            let albedo = 1.0 - scattering.one_minus_albedo;
            1.0 / (medium.extinction_per_m * (1.0 - albedo * scattering.asymmetry()))
        };
        let middle_nm = wavelengths_nm[wavelengths_nm.len() / 2];
        let phase = PhaseFunction::of_sample(sample, middle_nm, &PhasePlan::default())?;
        let phase = phase.with_asymmetry(media[wavelengths_nm.len() / 2].scattering.asymmetry());
        Ok(Self {
            transport_lengths_m: media.iter().map(transport_length_m).collect(),
            absorption_per_m: media
                .iter()
                .map(|medium| medium.extinction_per_m * medium.scattering.one_minus_albedo)
                .collect(),
            half_space: HalfSpace::new(&phase),
        })
    }

    /// α = 4 √(μ_a ℓ*/3) at wavelength number `k`: a half-space reflects e^{−α K(μ₀)} of a beam (Kokhanovsky & Zege
    /// 2004, *Scattering optics of snow*, doi:10.1364/AO.43.001589).
    pub fn half_space_absorption(&self, k: usize) -> f64 {
        4.0 * (self.absorption_per_m[k] * self.transport_lengths_m[k] / 3.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use snowblue_transport::sample::SnowKeys;
    use snowblue_transport::{Impurities, Number, Substance};

    use super::*;

    /// All kinds of snow in a body share one extrapolation length. The error of another kind of snow is as if the snow
    /// were thicker or thinner by 0.002 ℓ*.
    #[test]
    fn kinds_of_snow_have_nearly_the_same_extrapolation_length() {
        let facetness = |facetness: f64| SnowKeys { facetness: Some(vec![facetness]), ..SnowKeys::default() };
        let sphericity = |sphericity: f64| SnowKeys { sphericity: Some(vec![sphericity]), ..SnowKeys::default() };
        let wet = SnowKeys { water_saturation: Some(Number::of(0.5)), ..SnowKeys::default() };
        let soot = Impurities::none().with(Substance::BLACK_CARBON, 1000.0);
        let dirty = SnowKeys { impurities_ng_g: soot, ..SnowKeys::default() };
        for keys in [facetness(0.0), facetness(1.0), sphericity(0.6), sphericity(0.9), wet, dirty] {
            let sample = keys.sample().unwrap();
            let optics = SnowOptics::new(&sample, &[550.0], 1 << 14).unwrap();
            let extrapolation = optics.half_space.extrapolation();
            assert!((extrapolation - 0.7135).abs() < 0.002, "{keys:?}: {extrapolation}");
        }
    }
}
