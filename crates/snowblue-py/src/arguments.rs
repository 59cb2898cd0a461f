//! Arguments from Python: snow, light and engines.

use std::collections::BTreeMap;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use snowblue_color::{Colorimeter, Illuminant, Observer};
use snowblue_transport::ordinates::{OrdinatesOptions, Streams};
use snowblue_transport::sample::{SnowKeys, SnowSample};
use snowblue_transport::slab::{Incidence, Slab};

use crate::work::{input, input_in_row};

/// A number or several.
#[derive(FromPyObject)]
pub(crate) enum Numbers {
    One(f64),
    Several(Vec<f64>),
}

/// What is known of a snow, by the names of the keyword arguments.
pub(crate) struct Snow(SnowKeys);

/// Reads a dictionary. A key that is unknown is an error.
impl<'py> FromPyObject<'_, 'py> for Snow {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let mut snow = SnowKeys::default();
        let numbers = |value: Bound<'py, PyAny>| -> PyResult<Option<Vec<f64>>> {
            Ok(value.extract::<Option<Numbers>>()?.map(Numbers::into_vec))
        };
        for (key, value) in &*given.cast::<PyDict>()? {
            let key: String = key.extract()?;
            match &*key {
                "snow" => snow.snow = value.extract()?,
                "grain_size_um" => snow.grain_size_um = numbers(value)?,
                "size_measure" => snow.size_measure = value.extract()?,
                "ssa_m2_kg" => snow.ssa_m2_kg = value.extract()?,
                "facetness" => snow.facetness = numbers(value)?,
                "sphericity" => snow.sphericity = numbers(value)?,
                "density_kg_m3" => snow.density_kg_m3 = value.extract()?,
                "water_saturation" => snow.water_saturation = value.extract()?,
                "impurities_ng_g" => snow.impurities_ng_g = value.extract()?,
                "temperature_c" => snow.temperature_c = value.extract()?,
                "ice" => snow.ice = value.extract()?,
                _ => return Err(input(format!("'{key}' is not a property of snow"))),
            }
        }
        Ok(Self(snow))
    }
}

/// The values of a property of snow, one for each of several snows.
#[derive(FromPyObject)]
pub(crate) enum Column {
    Numbers(Vec<f64>),
    Words(Vec<String>),
    /// Mass fractions of each impurity.
    Impurities(BTreeMap<String, Vec<f64>>),
}

impl Column {
    /// Sets the property `key` of the snow in row `row`.
    fn set(&self, snow: &mut SnowKeys, key: &str, row: usize) -> PyResult<()> {
        let unknown = || input(format!("'{key}' is not a property of snow that may vary"));
        match self {
            Self::Numbers(values) => {
                let value = values[row];
                match key {
                    "grain_size_um" => snow.grain_size_um = Some(vec![value]),
                    "ssa_m2_kg" => snow.ssa_m2_kg = Some(value),
                    "facetness" => snow.facetness = Some(vec![value]),
                    "sphericity" => snow.sphericity = Some(vec![value]),
                    "density_kg_m3" => snow.density_kg_m3 = Some(value),
                    "water_saturation" => snow.water_saturation = Some(value),
                    "temperature_c" => snow.temperature_c = Some(value),
                    _ => return Err(unknown()),
                }
            }
            Self::Words(words) => {
                let word = Some(words[row].clone());
                match key {
                    "snow" => snow.snow = word,
                    "size_measure" => snow.size_measure = word,
                    "ice" => snow.ice = word,
                    _ => return Err(unknown()),
                }
            }
            Self::Impurities(columns) => {
                for (name, mass_fractions_ng_g) in columns {
                    snow.impurities_ng_g.insert(name.clone(), mass_fractions_ng_g[row]);
                }
            }
        }
        Ok(())
    }

    fn is_of_length(&self, count: usize) -> bool {
        match self {
            Self::Numbers(values) => values.len() == count,
            Self::Words(words) => words.len() == count,
            Self::Impurities(columns) => columns.values().all(|values| values.len() == count),
        }
    }
}

/// An angle in degrees, or `"diffuse"`.
#[derive(FromPyObject)]
pub(crate) enum Angle {
    Degrees(f64),
    Word(String),
}

/// Thicknesses, angles and wavelengths.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Cases {
    pub(crate) thickness_cm: Vec<f64>,
    pub(crate) angle_deg: Vec<Angle>,
    pub(crate) wavelength_nm: Vec<f64>,
}

/// A number of streams, or `"auto"`.
#[derive(FromPyObject)]
enum StreamCount {
    Exactly(usize),
    Word(String),
}

/// Options of the discrete ordinates.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Ordinates {
    streams: StreamCount,
    seed: u64,
}

/// The illuminant and observer of colours.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Light {
    pub(crate) illuminant: String,
    observer: String,
}

impl Numbers {
    fn into_vec(self) -> Vec<f64> {
        match self {
            Self::One(number) => vec![number],
            Self::Several(numbers) => numbers,
        }
    }
}

impl Snow {
    /// Several snows that differ in some properties. An error has the row of the first wrong snow. Only grain sizes
    /// are checked.
    pub(crate) fn samples(&self, columns: &BTreeMap<String, Column>, count: usize) -> PyResult<Vec<SnowSample>> {
        if !columns.values().all(|column| column.is_of_length(count)) {
            return Err(input(format!("a property does not have {count} values")));
        }
        let sample = |row: usize| {
            let mut snow = self.0.clone();
            columns.iter().try_for_each(|(key, column)| column.set(&mut snow, key, row))?;
            snow.description().and_then(|snow| snow.sample()).map_err(|error| input_in_row(error, row))
        };
        (0..count).map(sample).collect()
    }

    /// The snow. Only its grain size is checked.
    pub(crate) fn sample(&self) -> PyResult<SnowSample> {
        self.0.description().and_then(|snow| snow.sample()).map_err(input)
    }
}

impl Angle {
    pub(crate) fn incidence(&self) -> PyResult<Incidence> {
        match self {
            Self::Degrees(angle_deg) => Ok(Incidence::Beam { angle_deg: *angle_deg }),
            Self::Word(word) => word.parse().map_err(input),
        }
    }
}

impl Cases {
    pub(crate) fn incidences(&self) -> PyResult<Vec<Incidence>> {
        self.angle_deg.iter().map(Angle::incidence).collect()
    }

    /// Slabs of a snow, checked.
    pub(crate) fn slab(&self, snow: &Snow) -> PyResult<Slab> {
        let slab = Slab {
            sample: snow.sample()?,
            thicknesses_cm: self.thickness_cm.clone(),
            incidences: self.incidences()?,
            wavelengths_nm: self.wavelength_nm.clone(),
        };
        slab.check().map_err(input)?;
        Ok(slab)
    }
}

impl Ordinates {
    pub(crate) fn seed(&self) -> u64 {
        self.seed
    }

    pub(crate) fn options(&self) -> PyResult<OrdinatesOptions> {
        Ok(OrdinatesOptions { streams: self.streams.streams()?, seed: self.seed, ..OrdinatesOptions::default() })
    }
}

impl StreamCount {
    fn streams(&self) -> PyResult<Streams> {
        match self {
            Self::Exactly(streams) => Ok(Streams::Exactly(*streams)),
            Self::Word(word) if word == "auto" => Ok(Streams::Auto),
            Self::Word(word) => Err(input(format!("'{word}' is neither a number of streams nor 'auto'"))),
        }
    }
}

impl Light {
    /// The colorimeter of spectra on these wavelengths, which must cover 400–700 nm.
    pub(crate) fn colorimeter(&self, wavelengths_nm: &[f64]) -> PyResult<Colorimeter> {
        let illuminant: Illuminant = self.illuminant.parse().map_err(input)?;
        let observer: Observer = self.observer.parse().map_err(input)?;
        Colorimeter::for_spectrum(observer, illuminant, wavelengths_nm).map_err(input)
    }
}
