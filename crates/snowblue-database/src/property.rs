//! What snow may differ in beside grain size, facetness and density: further axes of a table.

use snowblue_transport::optics::Substance;
use snowblue_transport::sample::SnowSample;

/// A property of snow that a table may have an axis of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Property {
    /// Share of the pores that water fills.
    WaterSaturation,
    /// Temperature, in °C.
    Temperature,
    /// Mass fraction of an impurity, in ng/g.
    Impurity(Substance),
}

impl Property {
    /// Every property.
    pub fn all() -> impl Iterator<Item = Self> {
        [Self::WaterSaturation, Self::Temperature].into_iter().chain(Substance::ALL.into_iter().map(Self::Impurity))
    }

    /// Its name in files.
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

    /// Its unit in files.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::WaterSaturation => "1",
            Self::Temperature => "degree_Celsius",
            Self::Impurity(_) => "ng g-1",
        }
    }

    /// Whether it is the mass fraction of an impurity.
    #[must_use]
    pub fn is_impurity(self) -> bool {
        matches!(self, Self::Impurity(_))
    }

    /// Its name in messages.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::WaterSaturation => "water saturation",
            Self::Temperature => "temperature",
            Self::Impurity(substance) => substance.name(),
        }
    }

    /// Its unit behind a number in messages: with a leading space, or nothing.
    #[must_use]
    pub fn unit_beside(self) -> &'static str {
        match self {
            Self::WaterSaturation => "",
            Self::Temperature => " °C",
            Self::Impurity(_) => " ng/g",
        }
    }

    /// The value that snow has where nothing is said of it: dry, clean, −5 °C.
    #[must_use]
    pub fn usual(self) -> f64 {
        match self {
            Self::WaterSaturation | Self::Impurity(_) => 0.0,
            Self::Temperature => SnowSample::default().temperature_c,
        }
    }

    /// Gives a sample this property.
    pub fn set(self, sample: &mut SnowSample, value: f64) {
        match self {
            Self::WaterSaturation => sample.water_saturation = value,
            Self::Temperature => sample.temperature_c = value,
            Self::Impurity(substance) => sample.impurities = sample.impurities.with(substance, value),
        }
    }
}
