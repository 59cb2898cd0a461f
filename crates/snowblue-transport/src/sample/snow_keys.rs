//! Snow by its known properties, by the keys of scenes, layer files, the command and Python.

use schemars::JsonSchema;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use snowblue_base::Number;

use super::grain_size::GrainSize;
use super::property::{Property, check_density};
use super::snow_sample::SnowSample;
use super::snow_type::SnowType;
use super::truncated_normal::TruncatedNormal;
use crate::TransportError;
use crate::grain::SizeMeasure;
use crate::optics::{IceTable, Impurities};
use crate::parameters::{
    Density, FACETNESS, GRAIN_SIZE, MASS_FRACTION, SPHERICITY, SURFACE_AREA, SurfaceArea, Temperature, WaterSaturation,
};

/// What is known of a snow. The specific surface area and the density that it lacks are those of its kind; all else has
/// its default.
///
/// ```
/// use snowblue_base::Number;
/// use snowblue_transport::sample::{SnowKeys, SnowType};
///
/// // Firn with finer grains than usual is still as dense.
/// let usual = SnowKeys { snow: Some(SnowType::Firn), ..SnowKeys::default() };
/// let fine = SnowKeys { ssa_m2_kg: Some(Number::of(20.0)), ..usual.clone() };
/// let (usual, fine) = (usual.sample()?, fine.sample()?);
/// assert!(fine.density_kg_m3 == usual.density_kg_m3 && fine.extinction_per_m() > 3.0 * usual.extinction_per_m());
/// # Ok::<(), snowblue_transport::sample::SnowKeyError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SnowKeys {
    /// Kind of snow.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub snow: Option<SnowType>,
    /// Grain size, in µm: a mean, or the ends of a range.
    #[serde(with = "one_or_several", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<one_or_several::Numbers>")]
    pub grain_size_um: Option<Vec<f64>>,
    /// What the grain size measures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size_measure: Option<SizeMeasure>,
    /// Specific surface area, in m²/kg, instead of a grain size.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ssa_m2_kg: Option<Number<SurfaceArea>>,
    /// Facetness: a mean, or range, mean and standard deviation.
    #[serde(with = "one_or_several", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<one_or_several::Numbers>")]
    pub facetness: Option<Vec<f64>>,
    /// Sphericity: one value, or range, mean and standard deviation.
    #[serde(with = "one_or_several", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<one_or_several::Numbers>")]
    pub sphericity: Option<Vec<f64>>,
    /// Density of the dry snow, in kg/m³.
    #[serde(deserialize_with = "read_density", skip_serializing_if = "Option::is_none")]
    pub density_kg_m3: Option<Number<Density>>,
    /// Fraction of the pore volume that is filled with water.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub water_saturation: Option<Number<WaterSaturation>>,
    /// Mass fractions of impurities by name, in ng/g.
    #[serde(skip_serializing_if = "Impurities::is_none")]
    pub impurities_ng_g: Impurities,
    /// Temperature, in °C.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature_c: Option<Number<Temperature>>,
    /// Table of the absorption of ice.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ice: Option<IceTable>,
    /// A fraction of tests.
    #[cfg(any(test, feature = "test-rows"))]
    pub test_fraction: Option<Number<WaterSaturation>>,
}

/// A key of a snow whose value is wrong.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{key}: {error}")]
pub struct SnowKeyError {
    /// The key.
    pub key: &'static str,
    /// The name of the impurity, if `key` is the key of the impurities.
    pub impurity: Option<String>,
    /// The error in the value.
    #[source]
    pub error: TransportError,
}

impl SnowKeys {
    /// The snow.
    ///
    /// # Errors
    /// With the key of the first value that is out of range, or that cannot be given with others.
    pub fn sample(&self) -> Result<SnowSample, SnowKeyError> {
        let wrong = |key| move |error| SnowKeyError { key, impurity: None, error };
        let mut sample = SnowSample::default();
        sample.ice = self.ice.unwrap_or(sample.ice);
        sample.density_kg_m3 = self.snow.map_or(sample.density_kg_m3, SnowType::density_kg_m3);
        sample.impurities = self.impurities_ng_g;
        let numbers = [
            (Property::Density, self.density_kg_m3.map(Number::get)),
            (Property::WaterSaturation, self.water_saturation.map(Number::get)),
            (Property::Temperature, self.temperature_c.map(Number::get)),
            #[cfg(any(test, feature = "test-rows"))]
            (Property::TestFraction, self.test_fraction.map(Number::get)),
        ];
        for (property, value) in numbers.into_iter().filter_map(|(property, value)| Some((property, value?))) {
            property.set(&mut sample, value);
        }
        if let Some(numbers) = &self.facetness {
            sample.facetness = TruncatedNormal::facetness(numbers).map_err(wrong(FACETNESS.key))?;
        }
        if let Some(numbers) = &self.sphericity {
            sample.sphericity = TruncatedNormal::sphericity(numbers).map_err(wrong(SPHERICITY.key))?;
        }
        self.set_grain_size(&mut sample)?;
        for property in Property::of_impurities(&sample.impurities) {
            MASS_FRACTION.range.check(property.get(&sample)).map_err(|error| SnowKeyError {
                impurity: Some(property.parameter().title.to_owned()),
                ..wrong(MASS_FRACTION.key)(error.into())
            })?;
        }
        Ok(sample)
    }

    /// Sets the grain size of a sample whose temperature is set, if the keys determine the grain size.
    fn set_grain_size(&self, sample: &mut SnowSample) -> Result<(), SnowKeyError> {
        let wrong = |key| move |error| SnowKeyError { key, impurity: None, error };
        let combination = |key, quantity, rule| Err(wrong(key)(TransportError::Combination { quantity, rule }));
        // The diameter that belongs to a surface area depends on the temperature of the ice.
        let area_m2_kg = self.ssa_m2_kg.map(Number::get).or(self.snow.map(SnowType::surface_area_m2_kg));
        match (&self.grain_size_um, area_m2_kg, self.size_measure) {
            (Some(_), _, _) if self.ssa_m2_kg.is_some() => {
                return combination(SURFACE_AREA.key, SURFACE_AREA.range.quantity, "cannot be given with a grain size");
            }
            (Some(numbers_um), _, measure) => {
                let size = GrainSize::from_numbers(numbers_um, measure.unwrap_or_default());
                sample.grain_size = size.map_err(wrong(GRAIN_SIZE.key))?;
            }
            (None, Some(_), Some(_)) => return combination("size_measure", "size measure", "needs a grain size"),
            (None, Some(area_m2_kg), None) => Property::SurfaceArea.set(sample, area_m2_kg),
            (None, None, measure) => sample.grain_size.measure = measure.unwrap_or_default(),
        }
        Ok(())
    }

    /// Sets a property to a number or, if the property is a distribution, to the numbers of a distribution.
    ///
    /// # Errors
    /// If there are too many or too few numbers, or one is out of range.
    pub fn set(&mut self, property: Property, numbers: &[f64]) -> Result<(), TransportError> {
        let one = || match *numbers {
            [number] => Ok(number),
            _ => Err(TransportError::Count {
                quantity: property.parameter().range.quantity,
                count: numbers.len(),
                expected: "one",
            }),
        };
        match property {
            Property::GrainSize => self.grain_size_um = Some(numbers.to_vec()),
            Property::Facetness => self.facetness = Some(numbers.to_vec()),
            Property::Sphericity => self.sphericity = Some(numbers.to_vec()),
            Property::SurfaceArea => self.ssa_m2_kg = Some(Number::new(one()?)?),
            Property::Density => self.density_kg_m3 = Some(density(one()?)?),
            Property::WaterSaturation => self.water_saturation = Some(Number::new(one()?)?),
            Property::Temperature => self.temperature_c = Some(Number::new(one()?)?),
            #[cfg(any(test, feature = "test-rows"))]
            Property::TestFraction => self.test_fraction = Some(Number::new(one()?)?),
            Property::Impurity(substance) => {
                property.parameter().range.check(one()?)?;
                self.impurities_ng_g = self.impurities_ng_g.with(substance, one()?);
            }
        }
        Ok(())
    }
}

/// Reads a density. A density of ice has a message of its own.
fn read_density<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Number<Density>>, D::Error> {
    match Option::<f64>::deserialize(deserializer)? {
        Some(density_kg_m3) => density(density_kg_m3).map(Some).map_err(|error| D::Error::custom(error.after_key())),
        None => Ok(None),
    }
}

/// A density of snow, in kg/m³.
fn density(density_kg_m3: f64) -> Result<Number<Density>, TransportError> {
    check_density(density_kg_m3)?;
    Ok(Number::new(density_kg_m3)?)
}

/// A number, or a list of numbers.
mod one_or_several {
    use super::{Deserialize, Deserializer, JsonSchema, Serialize, Serializer};

    #[derive(Deserialize, JsonSchema)]
    #[serde(untagged, expecting = "must be a number or a list of numbers")]
    pub(super) enum Numbers {
        One(f64),
        Several(Vec<f64>),
    }

    #[expect(clippy::ref_option, reason = "the signature that serde calls")]
    pub(super) fn serialize<S: Serializer>(numbers: &Option<Vec<f64>>, serializer: S) -> Result<S::Ok, S::Error> {
        match numbers.as_deref() {
            Some([number]) => number.serialize(serializer),
            numbers => numbers.serialize(serializer),
        }
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Vec<f64>>, D::Error> {
        let numbers = Option::<Numbers>::deserialize(deserializer)?;
        Ok(numbers.map(|numbers| match numbers {
            Numbers::One(number) => vec![number],
            Numbers::Several(numbers) => numbers,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Substance;

    #[test]
    fn the_schema_has_every_property() {
        let schema = schemars::schema_for!(SnowKeys).to_value();
        for property in Property::all() {
            let range = property.parameter().range;
            if let Property::Impurity(substance) = property {
                let names = &schema["$defs"]["Impurities"]["propertyNames"]["anyOf"][0]["enum"];
                assert!(names.as_array().unwrap().contains(&substance.name().into()), "{names}");
                continue;
            }
            let found = &schema["properties"][property.key()];
            assert!(found.is_object(), "{}", property.key());
            if let Some(greatest) = found["maximum"].as_f64() {
                assert_eq!(greatest.to_bits(), range.greatest.to_bits(), "{found}");
            }
        }
    }

    #[test]
    fn the_key_of_a_wrong_value_is_named() {
        let wrong = |snow: SnowKeys| {
            let SnowKeyError { key, impurity, error } = snow.sample().unwrap_err();
            (key, impurity.unwrap_or_default(), error.to_string())
        };
        let rough = SnowKeys { facetness: Some(vec![2.0]), ..SnowKeys::default() };
        let (key, _, reason) = wrong(rough);
        assert_eq!((key, &*reason), ("facetness", "facetness is 2, but must lie in 0–1"));
        let impurities_ng_g = Impurities::none().with(Substance::BLACK_CARBON, 2e7);
        let (key, impurity, _) = wrong(SnowKeys { impurities_ng_g, ..SnowKeys::default() });
        assert_eq!((key, &*impurity), ("impurities_ng_g", "black-carbon"));
        let twice =
            SnowKeys { grain_size_um: Some(vec![400.0]), ssa_m2_kg: Some(Number::of(20.0)), ..SnowKeys::default() };
        assert_eq!(wrong(twice).0, "ssa_m2_kg");
    }
}
