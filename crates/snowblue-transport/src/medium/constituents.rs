//! The constituents of snow at one wavelength: grains in air, grains in water, particles, and the medium between them.
//! Both engines start here.
//!
//! **Water in the pores.** A grain lies entirely in water with the probability S_w, the saturation of the pores. It
//! then refracts with n_ice/n_water, and κ(1 − g) is some 60 times smaller. In equilibrium, radiance is proportional to
//! the square of the index, so paths in water, and in grains in water, count n_water² times for absorption. The water
//! itself absorbs
//!
//! ```text
//! (1 − φ) S_w n_water² γ_water   per metre of snow.
//! ```
//!
//! The mean path through ice in Lambertian light is 2hφ n_ice² at any saturation.
//!
//! **Particles** lie in the air of the pores at any saturation. A mass fraction c of [`crate::optics::impurity`] adds
//! ρ c E (1 − ω) to the absorption of the pores and ρ c E ω to the scattering.

use crate::dual::{Dual, Real};
use crate::optics::ice::IceTable;
use crate::optics::impurity::Substance;
use crate::optics::water;
use crate::sample::{Property, SnowSample};
use crate::variable::Variable;

/// The constituents of snow at one wavelength.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Constituents<T = f64> {
    /// Grains in air.
    pub(crate) in_air: Grains<T>,
    /// Grains in water; their extinction is 0 in dry snow.
    pub(crate) in_water: Grains<T>,
    /// Scattering by particles of each substance.
    pub(crate) particles: Vec<Scatterer<T>>,
    /// Absorption coefficient of the water and particles between grains, in 1/m.
    pub(crate) pore_absorption_per_m: T,
}

/// Grains in air or in water.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Grains<T = f64> {
    /// Extinction coefficient, in 1/m.
    pub(crate) extinction_per_m: T,
    /// Relative refractive index: ice over the surrounding medium.
    pub(crate) relative_index: f64,
    /// Effective absorption coefficient of the ice, in 1/m.
    pub(crate) absorption_per_m: T,
}

/// Particles with the Henyey–Greenstein phase function.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scatterer<T = f64> {
    /// Scattering coefficient, in 1/m.
    pub(crate) scattering_per_m: T,
    /// Asymmetry parameter.
    pub(crate) asymmetry: f64,
}

/// The composition of snow, which gives the constituents at any wavelength.
#[derive(Debug, Clone)]
pub(crate) struct Composition<T = f64> {
    ice: IceTable,
    /// Extinction coefficient of all grains, in 1/m.
    extinction_per_m: T,
    /// Factor of all sizes of the sample. The fraction that a grain absorbs depends on the product of its size and
    /// the absorption coefficient.
    size_factor: T,
    ice_fraction: T,
    density_kg_m3: T,
    water_saturation: T,
    /// Mass fraction of each substance, in ng/g.
    mass_fractions: Vec<(Substance, T)>,
}

impl Composition {
    /// The composition of a sample.
    pub(crate) fn new(sample: &SnowSample) -> Self {
        Self {
            ice: sample.ice,
            extinction_per_m: sample.extinction_per_m(),
            size_factor: 1.0,
            ice_fraction: sample.ice_fraction(),
            density_kg_m3: sample.density_kg_m3,
            water_saturation: sample.water_saturation,
            mass_fractions: sample.impurities.present().collect(),
        }
    }

    /// The composition with its derivatives by `variables`, and with the substances among the variables.
    ///
    /// At a given shape of the grains extinction goes as ρ SSA, and sizes go as 1/SSA.
    pub(crate) fn differentiated(&self, variables: &[Variable]) -> Composition<Dual> {
        let number = |variable: Variable, value: f64| variable.number(value, variables);
        let relative = |variable: Variable, value: f64| number(variable, value) / value;
        let denser = relative(Variable::Snow(Property::Density), self.density_kg_m3);
        let finer = relative(Variable::Snow(Property::SurfaceArea), 4.0 * self.extinction_per_m / self.density_kg_m3);
        let added = variables.iter().filter_map(|variable| match variable {
            Variable::Snow(Property::Impurity(substance)) => Some((*substance, 0.0)),
            _ => None,
        });
        let is_present =
            |(substance, _): &(Substance, f64)| self.mass_fractions.iter().any(|(one, _)| one == substance);
        let mass_fractions = self.mass_fractions.iter().copied().chain(added.filter(|one| !is_present(one)));
        let mass_fractions =
            mass_fractions.map(|(substance, ng_g)| (substance, number(Variable::impurity(substance), ng_g)));
        Composition {
            ice: self.ice,
            extinction_per_m: denser * finer * self.extinction_per_m,
            size_factor: Dual::from(1.0) / finer,
            ice_fraction: denser * self.ice_fraction,
            density_kg_m3: denser * self.density_kg_m3,
            water_saturation: number(Variable::Snow(Property::WaterSaturation), self.water_saturation),
            mass_fractions: mass_fractions.collect(),
        }
    }
}

impl<T: Real> Composition<T> {
    /// The constituents at a wavelength that the tables cover.
    pub(crate) fn at(&self, wavelength_nm: f64) -> Constituents<T> {
        let (ice, wet) = (self.ice, self.water_saturation);
        let (index, absorption_per_m) = (ice.index(wavelength_nm), ice.absorption_per_m(wavelength_nm));
        let (water_index, water_absorption_per_m) = if wet.is_zero() {
            (1.0, 0.0)
        } else {
            (water::index(wavelength_nm), water::absorption_per_m(wavelength_nm))
        };
        let radiance_gain = water_index * water_index;
        let mut pore_absorption_per_m =
            (T::from(1.0) - self.ice_fraction) * wet * radiance_gain * water_absorption_per_m;
        let mut particles = Vec::new();
        for (substance, mass_fraction_ng_g) in &self.mass_fractions {
            let optics = substance.at(wavelength_nm);
            let extinction_per_m = self.density_kg_m3 * *mass_fraction_ng_g * 1e-9 * optics.extinction_m2_kg;
            pore_absorption_per_m += extinction_per_m * (1.0 - optics.albedo);
            let scattering_per_m = extinction_per_m * optics.albedo;
            particles.push(Scatterer { scattering_per_m, asymmetry: optics.asymmetry });
        }
        let grains = |fraction: T, relative_index, absorption_per_m: f64| Grains {
            extinction_per_m: fraction * self.extinction_per_m,
            relative_index,
            absorption_per_m: self.size_factor * absorption_per_m,
        };
        Constituents {
            in_air: grains(T::from(1.0) - wet, index, absorption_per_m),
            in_water: grains(wet, index / water_index, radiance_gain * absorption_per_m),
            particles,
            pore_absorption_per_m,
        }
    }
}

impl Constituents {
    /// The constituents of a sample at a wavelength that its tables cover.
    pub(crate) fn new(sample: &SnowSample, wavelength_nm: f64) -> Self {
        Composition::new(sample).at(wavelength_nm)
    }

    /// Extinction coefficient of all scatterers, in 1/m: grains and particles.
    pub(crate) fn scatterer_extinction_per_m(&self) -> f64 {
        let particles: f64 = self.particles.iter().map(|particle| particle.scattering_per_m).sum();
        self.in_air.extinction_per_m + self.in_water.extinction_per_m + particles
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::impurity::{Impurities, Substance};

    /// 10 ng/g of black carbon in snow of 300 kg/m³ absorb 0.024 per metre at 500 nm: 12,583 m²/kg · (1 − 0.3687) ·
    /// 3·10⁻⁶.
    #[test]
    fn absorption_is_proportional_to_the_mass_of_black_carbon() {
        let impurities = Impurities::none().with(Substance::BLACK_CARBON, 10.0);
        let sooty = Constituents::new(&SnowSample { impurities, ..SnowSample::default() }, 500.0);
        assert!((sooty.pore_absorption_per_m - 0.0238).abs() < 1e-4, "{}", sooty.pore_absorption_per_m);
        assert!((sooty.particles[0].scattering_per_m - 0.0139).abs() < 1e-4);
    }

    #[test]
    fn the_saturation_is_the_fraction_of_grains_in_water() {
        let dry = Constituents::new(&SnowSample::default(), 600.0);
        let wet = Constituents::new(&SnowSample { water_saturation: 0.25, ..SnowSample::default() }, 600.0);
        assert!((wet.scatterer_extinction_per_m() / dry.scatterer_extinction_per_m() - 1.0).abs() < 1e-15);
        assert!((wet.in_water.extinction_per_m / wet.in_air.extinction_per_m - 1.0 / 3.0).abs() < 1e-15);
        // φ = 300/917.7, n = 1.33302 and γ = 0.23525/m.
        let expected = (1.0 - 300.0 / 917.701_5) * 0.25 * 1.333_02 * 1.333_02 * 0.235_25;
        assert!((wet.pore_absorption_per_m / expected - 1.0).abs() < 1e-6);
        assert!(dry.pore_absorption_per_m.abs() < f64::MIN_POSITIVE && dry.particles.is_empty());
    }
}
