//! Snow by the values that a table has axes of.

use snowblue_transport::optics::IceTable;
use snowblue_transport::sample::{GrainSize, SnowSample, TruncatedNormal};

use crate::{DatabaseError, Property};

/// Snow by the values that a table has axes of.
#[derive(Debug, Clone, PartialEq)]
pub struct TableSample {
    /// Mean grain size, in µm.
    pub grain_size_um: f64,
    /// Mean facetness.
    pub facetness: f64,
    /// Density of the dry snow, in kg/m³.
    pub density_kg_m3: f64,
    /// What else is said of it; what is not has its usual value.
    pub further: Vec<(Property, f64)>,
}

impl TableSample {
    /// Dry and clean snow.
    #[must_use]
    pub const fn new(grain_size_um: f64, facetness: f64, density_kg_m3: f64) -> Self {
        Self { grain_size_um, facetness, density_kg_m3, further: Vec::new() }
    }

    /// The same snow with a further property.
    #[must_use]
    pub fn with(mut self, property: Property, value: f64) -> Self {
        self.further.retain(|(other, _)| *other != property);
        self.further.push((property, value));
        self
    }

    /// The value of a further property.
    #[must_use]
    pub fn property(&self, property: Property) -> f64 {
        let said = self.further.iter().find(|(other, _)| *other == property);
        said.map_or(property.usual(), |(_, value)| *value)
    }

    /// The snow that this is to the engines, with ice after the given table, not checked.
    ///
    /// # Errors
    /// If the mean grain size stands for no range.
    pub fn snow(&self, ice: IceTable) -> Result<SnowSample, DatabaseError> {
        let mut sample = SnowSample {
            grain_size: GrainSize::around(self.grain_size_um)?,
            facetness: TruncatedNormal::facetness_around(self.facetness),
            density_kg_m3: self.density_kg_m3,
            ice,
            ..SnowSample::default()
        };
        for (property, value) in &self.further {
            property.set(&mut sample, *value);
        }
        Ok(sample)
    }
}
