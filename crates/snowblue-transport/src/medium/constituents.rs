//! What light meets in a metre of snow at one wavelength: grains in air, grains in water, particles, and what lies
//! between them. Both engines start here.
//!
//! **Water in the pores.** Each grain that light meets lies in water as a whole with the probability S_w, the saturation
//! of the pores. It then refracts with n_ice/n_water only, and its surface scatters some 60 times less. In equilibrium
//! radiance grows as the square of the index, so that light spends n_water² times as long in water and in what lies in
//! it: the path in a grain in water counts n_water² times towards absorption, and the water itself absorbs
//!
//! ```text
//! (1 − φ) S_w n_water² γ_water   per metre of snow.
//! ```
//!
//! The mean path through ice in Lambertian light remains 2hφ n_ice² however wet the snow is.
//!
//! **Particles** lie in the air of the pores, however wet the snow is. They are [`crate::optics::impurity`]: ρ c E (1 − ω) joins what the pores absorb, ρ c E ω scatters.

use crate::optics::ice::Ice;
use crate::optics::water;
use crate::sample::SnowSample;

/// What light of one wavelength meets in snow.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Constituents {
    /// Grains with air around them.
    pub(crate) in_air: Grains,
    /// Grains with water around them; none are met in dry snow.
    pub(crate) in_water: Grains,
    /// Light that scatters off particles, substance by substance.
    pub(crate) particles: Vec<Scatterer>,
    /// What water and particles absorb on the way between grains, in 1/m.
    pub(crate) pore_absorption_per_m: f64,
}

/// Grains in one surrounding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Grains {
    /// Extinction coefficient, in 1/m.
    pub(crate) extinction_per_m: f64,
    /// Refractive index of ice over that of the surrounding.
    pub(crate) relative_index: f64,
    /// What counts as the absorption coefficient of the ice, in 1/m.
    pub(crate) absorption_per_m: f64,
}

/// Particles that scatter by Henyey & Greenstein's law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scatterer {
    /// Scattering coefficient, in 1/m.
    pub(crate) scattering_per_m: f64,
    /// Asymmetry parameter.
    pub(crate) asymmetry: f64,
}

impl Constituents {
    /// What a sample holds at a wavelength that its tables reach.
    pub(crate) fn new(sample: &SnowSample, wavelength_nm: f64) -> Self {
        let (ice, wet) = (Ice::new(sample.ice), sample.water_saturation);
        let (index, absorption_per_m) = (ice.index(wavelength_nm), ice.absorption_per_m(wavelength_nm));
        let extinction_per_m = sample.extinction_per_m();
        let (water_index, water_absorption_per_m) =
            if wet > 0.0 { (water::index(wavelength_nm), water::absorption_per_m(wavelength_nm)) } else { (1.0, 0.0) };
        let radiance_gain = water_index * water_index;
        let mut pore_absorption_per_m = (1.0 - sample.ice_fraction()) * wet * radiance_gain * water_absorption_per_m;
        let mut particles = Vec::new();
        for (substance, mass_fraction_ng_g) in sample.impurities.present() {
            let of = substance.at(wavelength_nm);
            let extinction_per_m = sample.density_kg_m3 * mass_fraction_ng_g * 1e-9 * of.extinction_m2_kg;
            pore_absorption_per_m += (1.0 - of.albedo) * extinction_per_m;
            particles.push(Scatterer { scattering_per_m: of.albedo * extinction_per_m, asymmetry: of.asymmetry });
        }
        let grains = |share: f64, relative_index, absorption_per_m| Grains {
            extinction_per_m: share * extinction_per_m,
            relative_index,
            absorption_per_m,
        };
        Self {
            in_air: grains(1.0 - wet, index, absorption_per_m),
            in_water: grains(wet, index / water_index, radiance_gain * absorption_per_m),
            particles,
            pore_absorption_per_m,
        }
    }

    /// Extinction coefficient of all that turns light, in 1/m: grains and particles.
    pub(crate) fn turning_per_m(&self) -> f64 {
        let particles: f64 = self.particles.iter().map(|particle| particle.scattering_per_m).sum();
        self.in_air.extinction_per_m + self.in_water.extinction_per_m + particles
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::impurity::{Impurities, Substance};

    /// 10 ng/g of black carbon in snow of 300 kg/m³ absorb .024 per metre at 500 nm: 12,583 m²/kg · (1 − .3687) · 3·10⁻⁶.
    #[test]
    fn soot_absorbs_by_its_mass() {
        let impurities = Impurities::none().with(Substance::BlackCarbon, 10.0);
        let sooty = Constituents::new(&SnowSample { impurities, ..SnowSample::default() }, 500.0);
        assert!((sooty.pore_absorption_per_m - 0.0238).abs() < 1e-4, "{}", sooty.pore_absorption_per_m);
        assert!((sooty.particles[0].scattering_per_m - 0.0139).abs() < 1e-4);
    }

    #[test]
    fn water_takes_its_share_of_the_grains() {
        let dry = Constituents::new(&SnowSample::default(), 600.0);
        let wet = Constituents::new(&SnowSample { water_saturation: 0.25, ..SnowSample::default() }, 600.0);
        assert!((wet.turning_per_m() / dry.turning_per_m() - 1.0).abs() < 1e-15);
        assert!((wet.in_water.extinction_per_m / wet.in_air.extinction_per_m - 1.0 / 3.0).abs() < 1e-15);
        // φ = 300/917.7, n = 1.33302 and γ = .23525/m.
        let expected = (1.0 - 300.0 / 917.701_5) * 0.25 * 1.333_02 * 1.333_02 * 0.235_25;
        assert!((wet.pore_absorption_per_m / expected - 1.0).abs() < 1e-6);
        assert!(dry.pore_absorption_per_m.abs() < f64::MIN_POSITIVE && dry.particles.is_empty());
    }
}
