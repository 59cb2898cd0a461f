//! A snow sample described by the quantities that a table has axes of.

use snowblue_transport::optics::IceTable;
use snowblue_transport::sample::{GrainSize, SnowSample, TruncatedNormal};

use crate::{DatabaseError, Property, PropertyValue};

/// A snow sample described by the quantities that a table has axes of.
#[derive(Debug, Clone, PartialEq)]
pub struct TableSample {
    /// Mean grain size, in µm.
    pub grain_size_um: f64,
    /// Mean facetness.
    pub facetness: f64,
    /// Density of the dry snow, in kg/m³.
    pub density_kg_m3: f64,
    /// Further properties; the others have their default values.
    pub properties: Vec<PropertyValue>,
}

impl TableSample {
    /// Dry and clean snow.
    #[must_use]
    pub const fn new(grain_size_um: f64, facetness: f64, density_kg_m3: f64) -> Self {
        Self { grain_size_um, facetness, density_kg_m3, properties: Vec::new() }
    }

    /// The same snow with a further property.
    #[must_use]
    pub fn with(mut self, property: Property, value: f64) -> Self {
        self.properties.retain(|other| other.property != property);
        self.properties.push(PropertyValue { property, value });
        self
    }

    /// The value of a further property.
    #[must_use]
    pub fn property(&self, property: Property) -> f64 {
        let given = self.properties.iter().find(|other| other.property == property);
        given.map_or(property.default_value(), |given| given.value)
    }

    /// The sample that the engines solve, not checked.
    ///
    /// # Errors
    /// If there is no range of grain sizes around the mean.
    pub fn snow(&self, ice: IceTable) -> Result<SnowSample, DatabaseError> {
        let mut sample = SnowSample {
            grain_size: GrainSize::around(self.grain_size_um)?,
            facetness: TruncatedNormal::facetness_around(self.facetness),
            density_kg_m3: self.density_kg_m3,
            ice,
            ..SnowSample::default()
        };
        for PropertyValue { property, value } in &self.properties {
            property.set(&mut sample, *value);
        }
        Ok(sample)
    }
}
