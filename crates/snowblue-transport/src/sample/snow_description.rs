//! Snow by the properties that are known.

use super::grain_size::GrainSize;
use super::snow_sample::SnowSample;
use super::snow_type::SnowType;
use super::truncated_normal::TruncatedNormal;
use crate::TransportError;
use crate::grain::SizeMeasure;
use crate::optics::ice::IceTable;
use crate::optics::impurity::Impurities;

/// What is known of a snow. The specific surface area and the density that it lacks are those of its kind; all else is
/// that of [`SnowSample::default`].
///
/// ```
/// use snowblue_transport::sample::{SnowDescription, SnowType};
///
/// // Firn with finer grains than usual is still as dense.
/// let usual = SnowDescription { snow_type: Some(SnowType::Firn), ..SnowDescription::default() };
/// let fine = SnowDescription { surface_area_m2_kg: Some(20.0), ..usual.clone() };
/// let (usual, fine) = (usual.sample()?, fine.sample()?);
/// assert!(fine.density_kg_m3 == usual.density_kg_m3 && fine.extinction_per_m() > 3.0 * usual.extinction_per_m());
/// # Ok::<(), snowblue_transport::TransportError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SnowDescription {
    /// Kind of snow.
    pub snow_type: Option<SnowType>,
    /// Grain size, in µm: a mean, or the ends of a range ([`GrainSize::from_numbers`]).
    pub grain_size_um: Option<Vec<f64>>,
    /// What the grain size measures.
    pub size_measure: Option<SizeMeasure>,
    /// Specific surface area, in m²/kg, instead of a grain size.
    pub surface_area_m2_kg: Option<f64>,
    /// Sphericity of the grains.
    pub sphericity: Option<TruncatedNormal>,
    /// Facetness of the grains.
    pub facetness: Option<TruncatedNormal>,
    /// Density of the dry snow, in kg/m³.
    pub density_kg_m3: Option<f64>,
    /// Fraction of the pore volume that is filled with water.
    pub water_saturation: Option<f64>,
    /// Mass fractions of impurities.
    pub impurities: Impurities,
    /// Temperature, in °C.
    pub temperature_c: Option<f64>,
    /// Table of the absorption of ice.
    pub ice: Option<IceTable>,
}

impl SnowDescription {
    /// The snow. Only its grain size is checked.
    ///
    /// # Errors
    /// If the grain size is out of range, given twice, or has a measure without a value.
    pub fn sample(&self) -> Result<SnowSample, TransportError> {
        let default = SnowSample::default();
        let temperature_c = self.temperature_c.unwrap_or(default.temperature_c);
        Ok(SnowSample {
            grain_size: self.grain_size(temperature_c)?.unwrap_or(default.grain_size),
            sphericity: self.sphericity.unwrap_or(default.sphericity),
            facetness: self.facetness.unwrap_or(default.facetness),
            density_kg_m3: self
                .density_kg_m3
                .or(self.snow_type.map(SnowType::density_kg_m3))
                .unwrap_or(default.density_kg_m3),
            water_saturation: self.water_saturation.unwrap_or(default.water_saturation),
            impurities: self.impurities,
            temperature_c,
            ice: self.ice.unwrap_or(default.ice),
        })
    }

    /// The grain size, if anything is known of it.
    fn grain_size(&self, temperature_c: f64) -> Result<Option<GrainSize>, TransportError> {
        match (&self.grain_size_um, self.surface_area_m2_kg, self.size_measure) {
            (Some(_), Some(_), _) => Err(TransportError::Combination {
                quantity: "specific surface area",
                rule: "cannot be given with a grain size",
            }),
            (None, None, Some(measure)) if self.snow_type.is_none() => {
                Ok(Some(GrainSize { measure, ..SnowSample::default().grain_size }))
            }
            (None, _, Some(_)) => {
                Err(TransportError::Combination { quantity: "size measure", rule: "needs a grain size" })
            }
            (Some(numbers_um), None, measure) => {
                GrainSize::from_numbers(numbers_um, measure.unwrap_or_default()).map(Some)
            }
            (None, area_m2_kg, None) => {
                // The diameter that belongs to a surface area depends on the temperature of the ice.
                let area_m2_kg = area_m2_kg.or(self.snow_type.map(SnowType::surface_area_m2_kg));
                area_m2_kg.map(|area| GrainSize::from_specific_surface_area(area, temperature_c)).transpose()
            }
        }
    }
}
