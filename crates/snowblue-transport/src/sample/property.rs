//! The table of the properties of snow that are numbers. Everything that enumerates them reads it.

use snowblue_base::hash::Fnv1a;
use snowblue_base::{Parameter, ParameterRange};

use super::grain_size::{GrainSize, MEAN_SIZE_HALF_RANGE_UM};
use super::snow_sample::SnowSample;
use super::truncated_normal::{FACETNESS_RANGES, SPHERICITY_RANGES, TruncatedNormal};
use crate::error::TransportError;
use crate::optics::{Impurities, Substance};
use crate::parameters::{
    ANGLE, DENSITY, FACETNESS, GRAIN_SIZE, GROUND_ALBEDO, MASS_FRACTION, SPHERICITY, SURFACE_AREA, TEMPERATURE,
    THICKNESS, WATER_SATURATION, name_and_unit,
};

/// A property of snow that is a number, or a distribution about one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Property {
    /// Mean grain size, in µm; its range is ± 50 µm.
    GrainSize,
    /// Specific surface area, in m²/kg, of grains of one optical diameter.
    SurfaceArea,
    /// Mean facetness.
    Facetness,
    /// Mean sphericity.
    Sphericity,
    /// Density of the dry snow, in kg/m³.
    Density,
    /// Fraction of the pore volume that water fills.
    WaterSaturation,
    /// Temperature, in °C.
    Temperature,
    /// Mass fraction of an impurity, in ng/g.
    Impurity(Substance),
    /// A fraction of tests.
    #[cfg(any(test, feature = "test-rows"))]
    TestFraction,
}

/// Greatest density that is taken for a density of ice, in kg/m³. Ice at −60 °C has 925.4 kg/m³.
const DENSEST_ICE_KG_M3: f64 = 926.0;

struct Row {
    property: Property,
    parameter: Parameter,
    get: fn(&SnowSample) -> f64,
    set: fn(&mut SnowSample, f64),
    /// Whether fluxes may be differentiated with respect to it.
    has_derivative: bool,
}

static ROWS: &[Row] = &[
    Row {
        property: Property::GrainSize,
        parameter: GRAIN_SIZE,
        get: |sample| sample.grain_size.middle_um(),
        set: |sample, mean_um| {
            sample.grain_size.min_um = mean_um - MEAN_SIZE_HALF_RANGE_UM;
            sample.grain_size.max_um = mean_um + MEAN_SIZE_HALF_RANGE_UM;
        },
        has_derivative: false,
    },
    Row {
        property: Property::SurfaceArea,
        parameter: SURFACE_AREA,
        get: |sample| 4.0 * sample.extinction_per_m() / sample.density_kg_m3,
        set: |sample, area_m2_kg| {
            sample.grain_size = GrainSize::of_surface_area(area_m2_kg, sample.temperature_c);
        },
        has_derivative: true,
    },
    Row {
        property: Property::Facetness,
        parameter: FACETNESS,
        get: |sample| sample.facetness.mean,
        set: |sample, mean| sample.facetness = TruncatedNormal::facetness_around(mean),
        has_derivative: false,
    },
    Row {
        property: Property::Sphericity,
        parameter: SPHERICITY,
        get: |sample| sample.sphericity.mean,
        set: |sample, value| sample.sphericity = TruncatedNormal::exactly(value),
        has_derivative: false,
    },
    Row {
        property: Property::Density,
        parameter: DENSITY,
        get: |sample| sample.density_kg_m3,
        set: |sample, density_kg_m3| sample.density_kg_m3 = density_kg_m3,
        has_derivative: true,
    },
    Row {
        property: Property::WaterSaturation,
        parameter: WATER_SATURATION,
        get: |sample| sample.water_saturation,
        set: |sample, saturation| sample.water_saturation = saturation,
        has_derivative: true,
    },
    Row {
        property: Property::Temperature,
        parameter: TEMPERATURE,
        get: |sample| sample.temperature_c,
        set: |sample, temperature_c| sample.temperature_c = temperature_c,
        has_derivative: false,
    },
    #[cfg(any(test, feature = "test-rows"))]
    Row {
        property: Property::TestFraction,
        parameter: Parameter { key: "test_fraction", ..WATER_SATURATION },
        get: |sample| sample.test_fraction,
        set: |sample, fraction| sample.test_fraction = fraction,
        has_derivative: false,
    },
];

/// Every parameter of snow and of the light on it, once. All impurities share one parameter.
pub fn parameters() -> impl Iterator<Item = Parameter> {
    ROWS.iter().map(|row| row.parameter).chain([MASS_FRACTION, THICKNESS, ANGLE, GROUND_ALBEDO])
}

impl Property {
    /// Every property.
    pub fn all() -> impl Iterator<Item = Self> + Clone {
        ROWS.iter().map(|row| row.property).chain(Substance::all().map(Self::Impurity))
    }

    /// The property of a key, such as `density_kg_m3` or `black_carbon_ng_g`.
    ///
    /// # Errors
    /// [`TransportError::Unknown`] if there is none.
    pub fn of_key(key: &str) -> Result<Self, TransportError> {
        let own = || key.strip_suffix("_ng_g")?.parse().ok().map(Self::Impurity);
        Self::all().find(|property| property.key() == key).or_else(own).ok_or_else(|| TransportError::Unknown {
            quantity: "property of snow",
            name: key.to_owned(),
            known: Self::all().map(Self::key).collect::<Vec<_>>().join(", "),
        })
    }

    /// The parameter of this property.
    #[must_use]
    pub fn parameter(self) -> Parameter {
        match self {
            Self::Impurity(substance) => Parameter {
                key: substance.key(),
                title: substance.name(),
                range: ParameterRange { quantity: substance.name(), ..MASS_FRACTION.range },
                text: substance.text(),
                source: substance.source(),
                ..MASS_FRACTION
            },
            _ => self.row().parameter,
        }
    }

    /// Its key in files and interfaces.
    #[must_use]
    pub fn key(self) -> &'static str {
        self.parameter().key
    }

    /// Its key without the unit: its name in tables and, with hyphens, of options.
    #[must_use]
    pub fn name(self) -> &'static str {
        name_and_unit(self.key()).0
    }

    /// Whether fluxes may be differentiated with respect to it.
    #[must_use]
    pub fn has_derivative(self) -> bool {
        matches!(self, Self::Impurity(_)) || self.row().has_derivative
    }

    /// Its value in a sample, in its unit.
    #[must_use]
    pub fn get(self, sample: &SnowSample) -> f64 {
        match self {
            Self::Impurity(substance) => sample.impurities.ng_g(substance),
            _ => (self.row().get)(sample),
        }
    }

    /// Sets its value in a sample, in its unit, not checked.
    pub fn set(self, sample: &mut SnowSample, value: f64) {
        match self {
            Self::Impurity(substance) => sample.impurities = sample.impurities.with(substance, value),
            _ => (self.row().set)(sample, value),
        }
    }

    /// The mass fractions of impurities that are not 0.
    pub(super) fn of_impurities(impurities: &Impurities) -> impl Iterator<Item = Self> + use<> {
        impurities.given().map(|(substance, _)| Self::Impurity(substance))
    }

    /// The properties that are numbers by themselves, beside grain size, shape, density and impurities.
    fn plain() -> impl Iterator<Item = Self> {
        use Property::{Density, Facetness, GrainSize, Sphericity, SurfaceArea};
        let all = ROWS.iter().map(|row| row.property);
        all.filter(|one| !matches!(one, GrainSize | SurfaceArea | Facetness | Sphericity | Density))
    }

    /// Its row. Impurities have rows of their own.
    fn row(self) -> &'static Row {
        ROWS.iter().find(|row| row.property == self).unwrap_or_else(|| unreachable!("{self:?} has a row"))
    }
}

/// Methods that concern every property.
impl SnowSample {
    /// An identifier of the snow: 16 hexadecimal digits, by its properties, rounded to nine significant digits.
    ///
    /// ```
    /// # use snowblue_transport::sample::SnowSample;
    /// let snow = SnowSample { density_kg_m3: 0.1 + 0.2 + 299.7, ..SnowSample::default() };
    /// assert_eq!(snow.id(), SnowSample::default().id());
    /// assert_ne!(SnowSample { density_kg_m3: 301.0, ..snow }.id(), snow.id());
    /// ```
    #[must_use]
    pub fn id(&self) -> String {
        let GrainSize { min_um, max_um, measure } = self.grain_size;
        let ranges = [self.sphericity, self.facetness]
            .map(|TruncatedNormal { min, max, mean, standard_deviation }| [min, max, mean, standard_deviation]);
        let single = [min_um, max_um, self.density_kg_m3, self.water_saturation, self.temperature_c];
        let mut hash = Fnv1a::default();
        // A sum with 0 has no negative zero.
        for number in single.iter().chain(ranges.as_flattened()) {
            hash.add(format!("{:.8e} ", number + 0.0).as_bytes());
        }
        for (substance, mass_fraction_ng_g) in self.impurities.present() {
            hash.add(format!("{} {mass_fraction_ng_g:.8e} ", substance.name()).as_bytes());
            hash.add(substance.own_table().unwrap_or_default().as_bytes());
        }
        // Later properties count where they differ from their defaults, so that identifiers stay as they are.
        for property in Property::plain() {
            let (Parameter { key, default, .. }, value) = (property.parameter(), property.get(self));
            let has_counted = matches!(property, Property::WaterSaturation | Property::Temperature);
            if !has_counted && value.total_cmp(&default).is_ne() {
                hash.add(format!("{key} {value:.8e} ").as_bytes());
            }
        }
        hash.add(format!("{} {}", measure.name(), self.ice.name()).as_bytes());
        format!("{:016x}", hash.value())
    }

    /// Checks every property.
    ///
    /// # Errors
    /// Reports the first quantity that lies outside its range.
    pub fn check(&self) -> Result<(), TransportError> {
        self.grain_size.check()?;
        self.sphericity.check(&SPHERICITY_RANGES)?;
        self.facetness.check(&FACETNESS_RANGES)?;
        check_density(self.density_kg_m3)?;
        for property in Property::plain().chain(Property::of_impurities(&self.impurities)) {
            property.parameter().range.check(property.get(self))?;
        }
        Ok(())
    }

    /// The snow between two snows with one measure of size and one table of ice: every property is interpolated
    /// linearly. `at` is 0 for the first snow and 1 for the last snow.
    #[must_use]
    pub fn between([first, last]: &[Self; 2], at: f64) -> Self {
        let between = |first: f64, last: f64| first + at * (last - first);
        let law = |first: &TruncatedNormal, last: &TruncatedNormal| TruncatedNormal {
            min: between(first.min, last.min),
            max: between(first.max, last.max),
            mean: between(first.mean, last.mean),
            standard_deviation: between(first.standard_deviation, last.standard_deviation),
        };
        let mut sample = Self {
            grain_size: GrainSize {
                min_um: between(first.grain_size.min_um, last.grain_size.min_um),
                max_um: between(first.grain_size.max_um, last.grain_size.max_um),
                ..first.grain_size
            },
            sphericity: law(&first.sphericity, &last.sphericity),
            facetness: law(&first.facetness, &last.facetness),
            density_kg_m3: between(first.density_kg_m3, last.density_kg_m3),
            ..*first
        };
        let impurities = [first, last].into_iter().flat_map(|one| Property::of_impurities(&one.impurities));
        for property in Property::plain().chain(impurities) {
            property.set(&mut sample, between(property.get(first), property.get(last)));
        }
        sample
    }
}

/// Checks a density, in kg/m³. A density of ice has a message of its own.
pub(super) fn check_density(density_kg_m3: f64) -> Result<(), TransportError> {
    DENSITY.range.check(density_kg_m3).map_err(|error| {
        if (DENSITY.range.greatest..DENSEST_ICE_KG_M3).contains(&density_kg_m3) {
            TransportError::ClearIce { error }
        } else {
            error.into()
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::SnowType;

    #[test]
    fn the_default_sample_has_the_defaults_of_its_properties() {
        for property in Property::all() {
            let value = match property {
                Property::SurfaceArea => SnowType::Rounded.surface_area_m2_kg(),
                _ => property.get(&SnowSample::default()),
            };
            assert!((property.parameter().default - value).abs() < 1e-12, "{property:?}: {value}");
        }
    }

    #[test]
    fn values_are_those_that_were_set() {
        for property in Property::all() {
            let Parameter { key, range, default, .. } = property.parameter();
            let (mut sample, value) = (SnowSample::default(), 0.5 * (range.least + range.greatest.min(1000.0)));
            property.set(&mut sample, value);
            sample.check().unwrap();
            assert!((property.get(&sample) / value - 1.0).abs() < 1e-12, "{key}");
            assert_ne!(sample.id(), SnowSample::default().id(), "{key} is in the identifier");
            property.set(&mut sample, default);
            assert_eq!(Property::of_key(key), Ok(property));
            assert!(key.starts_with(property.name()) && range.contains(default), "{key}");
        }
    }
}
