//! Snow samples by the quantities that a table has axes of: grain size, facetness, density and further properties.

use snowblue_transport::optics::IceTable;
use snowblue_transport::parameters::name_and_unit;
use snowblue_transport::sample::{GrainSize, Property, SnowSample, TruncatedNormal};

use crate::DatabaseError;

/// A property with a value in its unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PropertyValue {
    /// The property.
    pub property: Property,
    /// Its value.
    pub value: f64,
}

/// A property with its values along an axis of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct PropertyAxis {
    /// The property.
    pub property: Property,
    /// Its values, ascending.
    pub values: Vec<f64>,
}

/// The properties that a table has an axis of.
const OF_EVERY_TABLE: [Property; 3] = [Property::GrainSize, Property::Facetness, Property::Density];

/// The properties that a table may have an axis of. All grains of a table have one sphericity. The only measure of
/// their size is the grain size.
pub fn axis_properties() -> impl Iterator<Item = Property> + Clone {
    let others = [Property::SurfaceArea, Property::Sphericity];
    Property::all().filter(move |property| !others.contains(property))
}

/// The properties that a table may have an axis of, beside the axes that every table has.
pub(crate) fn further_properties() -> impl Iterator<Item = Property> {
    axis_properties().filter(|property| !OF_EVERY_TABLE.contains(property))
}

/// Unit of a property in files.
#[must_use]
pub fn unit_in_files(property: Property) -> &'static str {
    name_and_unit(property.key()).1
}

/// A snow sample described by the quantities that a table has axes of.
#[derive(Debug, Clone, PartialEq)]
pub struct TableSample {
    /// Mean grain size, in µm.
    pub grain_size_um: f64,
    /// Mean facetness.
    pub facetness: f64,
    /// Density of the dry snow, in kg/m³.
    pub density_kg_m3: f64,
    /// Further properties. Unlisted properties have their default values.
    pub properties: Vec<PropertyValue>,
}

impl TableSample {
    /// Dry and clean snow.
    #[must_use]
    pub const fn new(grain_size_um: f64, facetness: f64, density_kg_m3: f64) -> Self {
        Self { grain_size_um, facetness, density_kg_m3, properties: Vec::new() }
    }

    /// A sample of the engines by the quantities of a table; none if its grains differ from the grains of tables in
    /// the measure or range of sizes, the sphericity or the width of facetness.
    #[must_use]
    pub fn of(sample: &SnowSample) -> Option<Self> {
        let mut named = Self::new(sample.grain_size.middle_um(), sample.facetness.mean, sample.density_kg_m3);
        named.properties = further_properties()
            .map(|property| PropertyValue { property, value: property.get(sample) })
            .filter(|PropertyValue { property, value }| !matches!(property, Property::Impurity(_)) || *value > 0.0)
            .collect();
        let again = named.snow(sample.ice).ok()?;
        // The middle of a range is rounded.
        let [one, other] = [&again, sample].map(|sample| [sample.grain_size.min_um, sample.grain_size.max_um]);
        let has_sizes = one.iter().zip(other).all(|(one, other)| (one - other).abs() < 1e-9 * other);
        (has_sizes && SnowSample { grain_size: sample.grain_size, ..again } == *sample).then_some(named)
    }

    /// The sample with a further property.
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
        given.map_or(property.parameter().default, |given| given.value)
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

#[cfg(test)]
mod tests {
    use super::*;
    use snowblue_transport::optics::{Impurities, Substance};

    #[test]
    fn samples_of_a_table_are_recognised_and_others_are_not() {
        let ice = IceTable::default();
        let dirty = TableSample::new(333.3, 0.05, 250.0).with(Property::Impurity(Substance::BLACK_CARBON), 20.0);
        let sample = dirty.snow(ice).unwrap();
        let found = TableSample::of(&sample).unwrap();
        assert_eq!(found.snow(ice).unwrap().impurities, Impurities::none().with(Substance::BLACK_CARBON, 20.0));
        assert!((found.grain_size_um - 333.3).abs() < 1e-9 && found.facetness.total_cmp(&0.05).is_eq());
        let round = SnowSample { sphericity: TruncatedNormal::exactly(0.9), ..sample };
        assert_eq!(TableSample::of(&round), None);
        let one_size = GrainSize { min_um: 400.0, max_um: 400.0, ..sample.grain_size };
        assert_eq!(TableSample::of(&SnowSample { grain_size: one_size, ..sample }), None);
    }
}
