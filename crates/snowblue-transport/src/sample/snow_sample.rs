//! What snow is: grains of a size, a shape and a facetness, packed to a density.
//!
//! The parameters are those of the paper's Tables 1 and S1 (Varsa & Baranoski 2024, doi:10.1109/MCG.2023.3307517).

use super::grain_size::GrainSize;
use super::truncated_normal::{FACETNESS_RANGE, SPHERICITY_RANGE, TruncatedNormal};
use crate::TransportError;
use crate::grain::{SizeMeasure, Spheroid};
use crate::optics::ice::{self, Ice, IceTable};
use crate::optics::impurity::{self, Impurities};
use crate::optics::water;

const DENSITY_RANGE_KG_M3: (f64, f64) = (10.0, 900.0);
const TEMPERATURE_RANGE_C: (f64, f64) = (-60.0, 0.0);

/// Snow: what light meets in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SnowSample {
    /// Grain sizes.
    pub grain_size: GrainSize,
    /// Riley sphericity Ψ of the grains.
    pub sphericity: TruncatedNormal,
    /// Facetness of the grains, which becomes the roughness of their surface.
    pub facetness: TruncatedNormal,
    /// Density of the dry snow, in kg/m³.
    pub density_kg_m3: f64,
    /// Share of the pores' volume that water fills.
    pub water_saturation: f64,
    /// Particles between the grains.
    pub impurities: Impurities,
    /// Temperature, in °C; it changes nothing but the density of ice.
    pub temperature_c: f64,
    /// Whose absorption of ice is used.
    pub ice: IceTable,
}

impl SnowSample {
    /// Volume fraction of ice, φ = ρ/ρ_ice.
    #[must_use]
    pub fn ice_fraction(&self) -> f64 {
        self.density_kg_m3 / ice::density_kg_m3(self.temperature_c)
    }

    /// Extinction coefficient of the grains in 1/m: κ = φ ⟨S/4⟩/⟨V⟩, since a convex body in random orientation has the mean
    /// projected area S/4 (Cauchy).
    ///
    /// ```
    /// # use snowblue_transport::sample::{GrainSize, SnowSample};
    /// // Finer grains at equal density cut off light sooner: extinction goes as 1/size.
    /// let fine = SnowSample { grain_size: GrainSize::around(100.0).unwrap(), ..SnowSample::default() };
    /// let coarse = SnowSample { grain_size: GrainSize::around(500.0).unwrap(), ..SnowSample::default() };
    /// assert!(fine.extinction_per_m() > 4.0 * coarse.extinction_per_m());
    /// ```
    #[must_use]
    pub fn extinction_per_m(&self) -> f64 {
        let unit = |sphericity| Spheroid::of_unit_size(sphericity, self.grain_size.measure);
        let area = self.sphericity.mean_of(|psi| unit(psi).surface()) * self.grain_size.mean_square_um2();
        let volume = self.sphericity.mean_of(|psi| unit(psi).volume()) * self.grain_size.mean_cube_um3();
        self.ice_fraction() * 0.25 * area / (volume * 1e-6)
    }

    /// Whether the grains are alike in all that a tally sees: shape, facetness, what their size measures, ice.
    pub(crate) fn has_grains_of(&self, other: &Self) -> bool {
        (self.sphericity, self.facetness, self.grain_size.measure, self.ice)
            == (other.sphericity, other.facetness, other.grain_size.measure, other.ice)
    }

    /// Checks every parameter.
    ///
    /// # Errors
    /// The first quantity that lies outside its range.
    pub fn check(&self) -> Result<(), TransportError> {
        self.grain_size.check()?;
        self.sphericity.check(["sphericity", "standard deviation of sphericity"], SPHERICITY_RANGE)?;
        self.facetness.check(["facetness", "standard deviation of facetness"], FACETNESS_RANGE)?;
        TransportError::check("density", self.density_kg_m3, DENSITY_RANGE_KG_M3, " kg/m³")?;
        TransportError::check("water saturation", self.water_saturation, (0.0, 1.0), "")?;
        self.impurities.check()?;
        TransportError::check("temperature", self.temperature_c, TEMPERATURE_RANGE_C, " °C")
    }

    /// First and last wavelength, in nm, that the tables of all that the snow holds reach.
    #[must_use]
    pub fn range_nm(&self) -> (f64, f64) {
        let mut range = Ice::new(self.ice).range_nm();
        let mut cut = |(low, high): (f64, f64)| range = (range.0.max(low), range.1.min(high));
        if self.water_saturation > 0.0 {
            cut(water::RANGE_NM);
        }
        if !self.impurities.is_none() {
            cut(impurity::RANGE_NM);
        }
        range
    }

    /// Checks that the tables of all that the snow holds reach `wavelength_nm`.
    ///
    /// # Errors
    /// [`TransportError::OutOfRange`] if one does not.
    pub fn check_wavelength(&self, wavelength_nm: f64) -> Result<(), TransportError> {
        Ice::new(self.ice).check_wavelength(wavelength_nm)?;
        if self.water_saturation > 0.0 {
            water::check_wavelength(wavelength_nm)?;
        }
        self.impurities.check_wavelength(wavelength_nm)
    }
}

impl Default for SnowSample {
    /// Sizes 350–450 µm, sphericity .7–.9 about .8 ± .1, facetness .3 (.2–.4 ± .075), 300 kg/m³, −5 °C, dry and
    /// clean.
    fn default() -> Self {
        Self {
            grain_size: GrainSize { min_um: 350.0, max_um: 450.0, measure: SizeMeasure::default() },
            sphericity: TruncatedNormal { min: 0.7, max: 0.9, mean: 0.8, standard_deviation: 0.1 },
            facetness: TruncatedNormal::facetness_around(0.3),
            density_kg_m3: 300.0,
            water_saturation: 0.0,
            impurities: Impurities::none(),
            temperature_c: -5.0,
            ice: IceTable::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_quantity_value_range_and_unit() {
        let sample = SnowSample { density_kg_m3: 1200.0, ..SnowSample::default() };
        assert_eq!(sample.check().unwrap_err().to_string(), "density is 1200 kg/m³, but must lie in 10–900 kg/m³");
        assert!(GrainSize::around(60.0).unwrap_err().to_string().contains("below 20 µm"));
    }

    #[test]
    fn surface_area_and_optical_diameter_are_one_thing() {
        let size = GrainSize::from_specific_surface_area(16.0, -5.0).unwrap();
        let sample = SnowSample { grain_size: size, ..SnowSample::default() };
        // κ = ρ SSA / 4 for any convex grain.
        assert!((sample.extinction_per_m() / (300.0 * 16.0 / 4.0) - 1.0).abs() < 1e-12);
    }
}
