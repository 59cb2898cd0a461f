//! The composition of snow: grains of a size, shape and facetness, packed to a density.
//!
//! The parameters follow Tables 1 and S1 of the paper (Varsa & Baranoski 2024, doi:10.1109/MCG.2023.3307517).

use super::grain_size::{GrainSize, MEAN_SIZE_HALF_RANGE_UM};
use super::truncated_normal::TruncatedNormal;
use crate::TransportError;
use crate::grain::{SizeMeasure, Spheroid};
use crate::optics::Impurities;
use crate::optics::ice::{self, IceTable};
use crate::parameters::{DENSITY, FACETNESS, GRAIN_SIZE, SPHERICITY, TEMPERATURE, WATER_SATURATION};

/// The composition of snow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SnowSample {
    /// Grain sizes.
    pub grain_size: GrainSize,
    /// Riley sphericity Ψ of the grains.
    pub sphericity: TruncatedNormal,
    /// Facetness of the grains, which sets the roughness of their surface.
    pub facetness: TruncatedNormal,
    /// Density of the dry snow, in kg/m³.
    pub density_kg_m3: f64,
    /// Fraction of the pore volume that water fills.
    pub water_saturation: f64,
    /// Particles between the grains.
    pub impurities: Impurities,
    /// Temperature, in °C; it affects only the density of ice.
    pub temperature_c: f64,
    /// Published absorption of ice.
    pub ice: IceTable,
    /// A fraction of tests.
    #[cfg(any(test, feature = "test-rows"))]
    pub test_fraction: f64,
}

impl SnowSample {
    /// Volume fraction of ice, φ = ρ/ρ_ice.
    #[must_use]
    pub fn ice_fraction(&self) -> f64 {
        self.density_kg_m3 / ice::density_kg_m3(self.temperature_c)
    }

    /// Extinction coefficient of the grains in 1/m: κ = φ ⟨S/4⟩/⟨V⟩. A convex body in random orientation has
    /// the mean projected area S/4 (Cauchy).
    ///
    /// ```
    /// # use snowblue_transport::sample::{GrainSize, SnowSample};
    /// // At equal density extinction is inversely proportional to grain size.
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

    /// Checks that the tables of ice and of the impurities in the sample cover `wavelength_nm`.
    ///
    /// # Errors
    /// [`TransportError::Range`] if a table does not cover it.
    pub fn check_wavelength(&self, wavelength_nm: f64) -> Result<(), TransportError> {
        self.ice.check_wavelength(wavelength_nm)?;
        self.impurities.present().try_for_each(|(substance, _)| substance.check_wavelength(wavelength_nm))
    }

    /// Whether one tally serves both samples: equal shape, facetness, size measure and ice table.
    pub(crate) fn has_grains_of(&self, other: &Self) -> bool {
        (self.sphericity, self.facetness, self.grain_size.measure, self.ice)
            == (other.sphericity, other.facetness, other.grain_size.measure, other.ice)
    }
}

impl Default for SnowSample {
    /// Sizes 350–450 µm, sphericity 0.7–0.9 about 0.8 ± 0.1, facetness 0.3 (0.2–0.4 ± 0.075), 300 kg/m³, −5 °C, dry and
    /// clean.
    fn default() -> Self {
        Self {
            grain_size: GrainSize {
                min_um: GRAIN_SIZE.default - MEAN_SIZE_HALF_RANGE_UM,
                max_um: GRAIN_SIZE.default + MEAN_SIZE_HALF_RANGE_UM,
                measure: SizeMeasure::default(),
            },
            sphericity: TruncatedNormal { min: 0.7, max: 0.9, mean: SPHERICITY.default, standard_deviation: 0.1 },
            facetness: TruncatedNormal::facetness_around(FACETNESS.default),
            density_kg_m3: DENSITY.default,
            water_saturation: WATER_SATURATION.default,
            impurities: Impurities::none(),
            temperature_c: TEMPERATURE.default,
            ice: IceTable::default(),
            #[cfg(any(test, feature = "test-rows"))]
            test_fraction: WATER_SATURATION.default,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::optics::Substance;

    #[test]
    fn messages_name_quantity_value_range_and_unit() {
        let sample = SnowSample { density_kg_m3: 1200.0, ..SnowSample::default() };
        assert_eq!(sample.check().unwrap_err().to_string(), "density is 1200 kg/m³, but must lie in 10–900 kg/m³");
        for mean_um in [60.0, 12_000.0] {
            let message = GrainSize::around(mean_um).unwrap_err().to_string();
            assert!(message.contains(&format!("{mean_um} µm")) && message.contains("70–4950 µm"), "{message}");
        }
        let sample = SnowSample { facetness: TruncatedNormal::facetness_around(1.3), ..SnowSample::default() };
        assert_eq!(sample.check().unwrap_err().to_string(), "facetness is 1.3, but must lie in 0–1");
    }

    #[test]
    fn the_identifier_depends_on_each_property() {
        let usual = SnowSample::default();
        let mut others: Vec<SnowSample> = Substance::all()
            .map(|substance| SnowSample { impurities: Impurities::none().with(substance, 1.0), ..usual })
            .collect();
        let mut add = |change: &dyn Fn(&mut SnowSample)| {
            let mut other = usual;
            change(&mut other);
            others.push(other);
        };
        let fields: [fn(&mut TruncatedNormal) -> &mut f64; 4] =
            [|one| &mut one.min, |one| &mut one.max, |one| &mut one.mean, |one| &mut one.standard_deviation];
        for field in fields {
            add(&|sample| *field(&mut sample.sphericity) += 0.01);
            add(&|sample| *field(&mut sample.facetness) += 0.01);
        }
        add(&|sample| sample.grain_size.min_um += 1.0);
        add(&|sample| sample.grain_size.max_um += 1.0);
        add(&|sample| sample.density_kg_m3 += 1.0);
        add(&|sample| sample.water_saturation += 0.01);
        add(&|sample| sample.temperature_c += 1.0);
        add(&|sample| sample.ice = IceTable::Picard2016);
        for measure in SizeMeasure::ALL.into_iter().filter(|measure| *measure != usual.grain_size.measure) {
            add(&|sample| sample.grain_size.measure = measure);
        }
        let ids: HashSet<String> = others.iter().chain([&usual]).map(SnowSample::id).collect();
        assert_eq!(ids.len(), others.len() + 1);
    }

    #[test]
    fn specific_surface_area_sets_the_optical_diameter() {
        let size = GrainSize::from_specific_surface_area(16.0, -5.0).unwrap();
        let sample = SnowSample { grain_size: size, ..SnowSample::default() };
        // κ = ρ SSA / 4 for any convex grain.
        assert!((sample.extinction_per_m() / (300.0 * 16.0 / 4.0) - 1.0).abs() < 1e-12);
    }
}
