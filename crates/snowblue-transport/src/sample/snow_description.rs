//! Snow by the properties that are known, as values, or as words and numbers.

use std::collections::BTreeMap;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::grain_size::GrainSize;
use super::snow_sample::SnowSample;
use super::snow_type::SnowType;
use super::truncated_normal::TruncatedNormal;
use crate::TransportError;
use crate::grain::SizeMeasure;
use crate::optics::{IceTable, Impurities, Substance};

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

/// What is known of a snow, as words and numbers by the keys of a [file of layers](crate::layer_file).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SnowKeys {
    /// Kind of snow.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub snow: Option<String>,
    /// Grain size, in µm: a mean, or the ends of a range.
    #[serde(with = "one_or_several", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<f64>>")]
    pub grain_size_um: Option<Vec<f64>>,
    /// What the grain size measures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size_measure: Option<String>,
    /// Specific surface area, in m²/kg.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ssa_m2_kg: Option<f64>,
    /// Facetness: a mean, or range, mean and standard deviation.
    #[serde(with = "one_or_several", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<f64>>")]
    pub facetness: Option<Vec<f64>>,
    /// Sphericity: one value, or range, mean and standard deviation.
    #[serde(with = "one_or_several", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<f64>>")]
    pub sphericity: Option<Vec<f64>>,
    /// Density of the dry snow, in kg/m³.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density_kg_m3: Option<f64>,
    /// Fraction of the pore volume that is filled with water.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub water_saturation: Option<f64>,
    /// Mass fractions of impurities by name, in ng/g.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub impurities_ng_g: BTreeMap<String, f64>,
    /// Temperature, in °C.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature_c: Option<f64>,
    /// Table of the absorption of ice.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ice: Option<String>,
}

/// A key of a snow whose value is wrong.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{key}: {error}")]
pub struct SnowKeyError {
    /// The key.
    pub key: &'static str,
    /// The name of the impurity, if the key is that of the impurities.
    pub impurity: Option<String>,
    /// What is wrong.
    #[source]
    pub error: TransportError,
}

impl SnowKeys {
    /// The same with all words resolved.
    ///
    /// # Errors
    /// If a word is not known, an impurity is given twice, or sphericity or facetness are out of range.
    pub fn description(&self) -> Result<SnowDescription, TransportError> {
        let (mut impurities, mut given) = (Impurities::none(), Vec::new());
        for (name, mass_fraction_ng_g) in &self.impurities_ng_g {
            let substance: Substance = name.parse()?;
            if given.contains(&substance) {
                let rule = "is given twice, with a hyphen and with an underscore";
                return Err(TransportError::Combination { quantity: substance.name(), rule });
            }
            given.push(substance);
            impurities = impurities.with(substance, *mass_fraction_ng_g);
        }
        Ok(SnowDescription {
            snow_type: parsed(self.snow.as_deref())?,
            grain_size_um: self.grain_size_um.clone(),
            size_measure: parsed(self.size_measure.as_deref())?,
            surface_area_m2_kg: self.ssa_m2_kg,
            sphericity: self.sphericity.as_deref().map(TruncatedNormal::sphericity).transpose()?,
            facetness: self.facetness.as_deref().map(TruncatedNormal::facetness).transpose()?,
            density_kg_m3: self.density_kg_m3,
            water_saturation: self.water_saturation,
            impurities,
            temperature_c: self.temperature_c,
            ice: parsed(self.ice.as_deref())?,
        })
    }

    /// The snow, checked.
    ///
    /// # Errors
    /// With the key of the first value that is wrong.
    pub fn sample(&self) -> Result<SnowSample, SnowKeyError> {
        type Add = fn(&mut SnowKeys, &SnowKeys);
        // A surface area after the grain size, and both after the kind and the temperature that they depend on.
        const KEYS: [(&str, Add); 10] = [
            ("ice", |known, given| known.ice.clone_from(&given.ice)),
            ("snow", |known, given| known.snow.clone_from(&given.snow)),
            ("water_saturation", |known, given| known.water_saturation = given.water_saturation),
            ("density_kg_m3", |known, given| known.density_kg_m3 = given.density_kg_m3),
            ("temperature_c", |known, given| known.temperature_c = given.temperature_c),
            ("facetness", |known, given| known.facetness.clone_from(&given.facetness)),
            ("sphericity", |known, given| known.sphericity.clone_from(&given.sphericity)),
            ("grain_size_um", |known, given| known.grain_size_um.clone_from(&given.grain_size_um)),
            ("size_measure", |known, given| known.size_measure.clone_from(&given.size_measure)),
            ("ssa_m2_kg", |known, given| known.ssa_m2_kg = given.ssa_m2_kg),
        ];
        let (mut known, mut sample) = (Self::default(), SnowSample::default());
        for (key, add) in KEYS {
            add(&mut known, self);
            sample = known.checked().map_err(|error| SnowKeyError { key, impurity: None, error })?;
        }
        for (name, mass_fraction_ng_g) in &self.impurities_ng_g {
            known.impurities_ng_g.insert(name.clone(), *mass_fraction_ng_g);
            let wrong = |error| SnowKeyError { key: "impurities_ng_g", impurity: Some(name.clone()), error };
            sample = known.checked().map_err(wrong)?;
        }
        Ok(sample)
    }

    fn checked(&self) -> Result<SnowSample, TransportError> {
        let sample = self.description()?.sample()?;
        sample.check()?;
        Ok(sample)
    }
}

fn parsed<T: FromStr<Err = TransportError>>(word: Option<&str>) -> Result<Option<T>, TransportError> {
    word.map(str::parse).transpose()
}

/// A number, or a list of numbers.
mod one_or_several {
    use super::{Deserialize, Deserializer, Serialize, Serializer};

    #[expect(clippy::ref_option, reason = "the signature that serde calls")]
    pub(super) fn serialize<S: Serializer>(numbers: &Option<Vec<f64>>, serializer: S) -> Result<S::Ok, S::Error> {
        match numbers.as_deref() {
            Some([number]) => number.serialize(serializer),
            numbers => numbers.serialize(serializer),
        }
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Vec<f64>>, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged, expecting = "must be a number or a list of numbers")]
        enum Numbers {
            One(f64),
            Several(Vec<f64>),
        }
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

    #[test]
    fn the_key_of_a_wrong_value_is_named() {
        let wrong = |snow: SnowKeys| {
            let SnowKeyError { key, impurity, error } = snow.sample().unwrap_err();
            (key, impurity.unwrap_or_default(), error.to_string())
        };
        let dense = SnowKeys { snow: Some("fresh".to_owned()), density_kg_m3: Some(1200.0), ..SnowKeys::default() };
        let (key, _, reason) = wrong(dense);
        assert_eq!((key, &*reason), ("density_kg_m3", "density is 1200 kg/m³, but must lie in 10–900 kg/m³"));
        let dirty = SnowKeys { impurities_ng_g: [("salt".to_owned(), 3.0)].into(), ..SnowKeys::default() };
        let (key, impurity, _) = wrong(dirty);
        assert_eq!((key, &*impurity), ("impurities_ng_g", "salt"));
        let twice = [("black-carbon".to_owned(), 3.0), ("black_carbon".to_owned(), 0.0)];
        let (key, impurity, message) = wrong(SnowKeys { impurities_ng_g: twice.into(), ..SnowKeys::default() });
        assert_eq!((key, &*impurity), ("impurities_ng_g", "black_carbon"));
        assert!(message.starts_with("black-carbon is given twice"), "{message}");
        let twice = SnowKeys { grain_size_um: Some(vec![400.0]), ssa_m2_kg: Some(20.0), ..SnowKeys::default() };
        assert_eq!(wrong(twice).0, "ssa_m2_kg");
    }
}
