//! Arguments from Python: snow, light and engines.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use snowblue_color::{Colorimeter, Illuminant, Observer};
use snowblue_transport::ordinates::{OrdinatesOptions, Streams};
use snowblue_transport::sample::{SnowKeys, SnowSample};
use snowblue_transport::slab::{Incidence, Slab};

use crate::work::input;

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
