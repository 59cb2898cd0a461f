//! Properties of snow beyond grain size, facetness and density: optional axes of a table.

use snowblue_transport::optics::Substance;
use snowblue_transport::sample::SnowSample;

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
