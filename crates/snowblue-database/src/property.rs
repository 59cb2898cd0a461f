//! Snow samples by the quantities that a table has axes of: grain size, facetness, density and further properties.

use snowblue_transport::optics::{IceTable, Substance};
use snowblue_transport::sample::{GrainSize, SnowSample, TruncatedNormal};

use crate::DatabaseError;

/// A property of snow that a table may have an axis of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Property {
    /// Fraction of the pore volume filled with water.
    WaterSaturation,
    /// Temperature, in °C.
    Temperature,
    /// Mass fraction of an impurity, in ng/g.
    Impurity(Substance),
}

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

impl Property {
    /// Every property.
    pub fn all() -> impl Iterator<Item = Self> {
        [Self::WaterSaturation, Self::Temperature].into_iter().chain(Substance::ALL.into_iter().map(Self::Impurity))
    }

    /// Name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::WaterSaturation => "water_saturation",
            Self::Temperature => "temperature",
            Self::Impurity(Substance::BlackCarbon) => "black_carbon",
            Self::Impurity(Substance::SaharanDust) => "saharan_dust",
            Self::Impurity(Substance::ColoradoDust) => "colorado_dust",
            Self::Impurity(Substance::BrownCarbon) => "brown_carbon",
            Self::Impurity(Substance::SnowAlgae) => "snow_algae",
        }
    }

    /// Unit in files.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::WaterSaturation => "1",
            Self::Temperature => "degree_Celsius",
            Self::Impurity(_) => "ng g-1",
        }
    }

    /// Whether the property is the mass fraction of an impurity.
    #[must_use]
    pub fn is_impurity(self) -> bool {
        matches!(self, Self::Impurity(_))
    }

    /// Name in messages.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::WaterSaturation => "water saturation",
            Self::Temperature => "temperature",
            Self::Impurity(substance) => substance.name(),
        }
    }

    /// Unit after a number in messages, with a leading space, or empty.
    #[must_use]
    pub fn unit_suffix(self) -> &'static str {
        match self {
            Self::WaterSaturation => "",
            Self::Temperature => " °C",
            Self::Impurity(_) => " ng/g",
        }
    }

    /// Value of snow whose property is not given: dry, clean, −5 °C.
    #[must_use]
    pub fn default_value(self) -> f64 {
        match self {
            Self::WaterSaturation | Self::Impurity(_) => 0.0,
            Self::Temperature => SnowSample::default().temperature_c,
        }
    }

    /// Sets the property of a sample.
    pub fn set(self, sample: &mut SnowSample, value: f64) {
        match self {
            Self::WaterSaturation => sample.water_saturation = value,
            Self::Temperature => sample.temperature_c = value,
            Self::Impurity(substance) => sample.impurities = sample.impurities.with(substance, value),
        }
    }
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
    /// Further properties; the others have their default values.
    pub properties: Vec<PropertyValue>,
}

impl TableSample {
    /// Dry and clean snow.
    #[must_use]
    pub const fn new(grain_size_um: f64, facetness: f64, density_kg_m3: f64) -> Self {
        Self { grain_size_um, facetness, density_kg_m3, properties: Vec::new() }
    }

    /// A sample of the engines by the quantities of a table; none if it has other grains than tables have: another
    /// measure or range of sizes, sphericity or width of facetness.
    #[must_use]
    pub fn of(sample: &SnowSample) -> Option<Self> {
        let named = Self::new(sample.grain_size.middle_um(), sample.facetness.mean, sample.density_kg_m3)
            .with(Property::WaterSaturation, sample.water_saturation)
            .with(Property::Temperature, sample.temperature_c);
        let impurities = sample.impurities.present();
        let named =
            impurities.fold(named, |named, (substance, value)| named.with(Property::Impurity(substance), value));
        let again = named.snow(sample.ice).ok()?;
        // The middle of a range is rounded.
        let [one, other] = [&again, sample].map(|sample| [sample.grain_size.min_um, sample.grain_size.max_um]);
        let has_sizes = one.iter().zip(other).all(|(one, other)| (one - other).abs() < 1e-9 * other);
        (has_sizes && SnowSample { grain_size: sample.grain_size, ..again } == *sample).then_some(named)
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

#[cfg(test)]
mod tests {
    use super::*;
    use snowblue_transport::optics::Impurities;

    #[test]
    fn samples_of_a_table_are_recognised_and_others_are_not() {
        let ice = IceTable::default();
        let dirty = TableSample::new(333.3, 0.05, 250.0).with(Property::Impurity(Substance::BlackCarbon), 20.0);
        let sample = dirty.snow(ice).unwrap();
        let found = TableSample::of(&sample).unwrap();
        assert_eq!(found.snow(ice).unwrap().impurities, Impurities::none().with(Substance::BlackCarbon, 20.0));
        assert!((found.grain_size_um - 333.3).abs() < 1e-9 && found.facetness.total_cmp(&0.05).is_eq());
        let round = SnowSample { sphericity: TruncatedNormal::exactly(0.9), ..sample };
        assert_eq!(TableSample::of(&round), None);
        let one_size = GrainSize { min_um: 400.0, max_um: 400.0, ..sample.grain_size };
        assert_eq!(TableSample::of(&SnowSample { grain_size: one_size, ..sample }), None);
    }
}
