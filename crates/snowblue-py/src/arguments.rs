//! Arguments from Python: snow, light and engines.

use std::collections::BTreeMap;

use pyo3::prelude::*;
use snowblue_color::{Colorimeter, Illuminant, Observer};
use snowblue_transport::ordinates::{OrdinatesOptions, Streams};
use snowblue_transport::sample::{Property, SnowKeys, SnowSample};
use snowblue_transport::slab::{Incidence, Slab};
use snowblue_transport::{GroundAlbedo, TransportError};

use crate::work::{input, input_in_row};

/// The known properties of a snow, by the names of the keyword arguments.
#[derive(FromPyObject)]
pub(crate) struct GivenSnow(BTreeMap<String, Option<Given>>);

/// The value of a property of snow.
#[derive(FromPyObject)]
enum Given {
    Number(f64),
    Numbers(Vec<f64>),
    Word(String),
    /// Mass fraction of each impurity.
    Impurities(BTreeMap<String, f64>),
}

/// The values of a property of snow, one for each of several snows.
#[derive(FromPyObject)]
pub(crate) enum Column {
    Numbers(Vec<f64>),
    Words(Vec<String>),
    /// Mass fractions of each impurity.
    Impurities(BTreeMap<String, Vec<f64>>),
}

/// Sets a property of snow by the name of the keyword argument. A key that is unknown is an error.
fn set(snow: &mut SnowKeys, key: &str, value: &Given) -> Result<(), TransportError> {
    match (key, value) {
        ("snow", Given::Word(word)) => snow.snow = Some(word.parse()?),
        ("size_measure", Given::Word(word)) => snow.size_measure = Some(word.parse()?),
        ("ice", Given::Word(word)) => snow.ice = Some(word.parse()?),
        (_, Given::Number(number)) => snow.set(Property::of_key(key)?, &[*number])?,
        (_, Given::Numbers(numbers)) => snow.set(Property::of_key(key)?, numbers)?,
        ("impurities_ng_g", Given::Impurities(mass_fractions_ng_g)) => {
            for (name, mass_fraction_ng_g) in mass_fractions_ng_g {
                snow.set(Property::Impurity(name.parse()?), &[*mass_fraction_ng_g])?;
            }
        }
        _ => drop(Property::of_key(key)?),
    }
    Ok(())
}

impl Column {
    /// The value in a row.
    fn value(&self, row: usize) -> Given {
        match self {
            Self::Numbers(values) => Given::Number(values[row]),
            Self::Words(words) => Given::Word(words[row].clone()),
            Self::Impurities(columns) => {
                Given::Impurities(columns.iter().map(|(name, values)| (name.clone(), values[row])).collect())
            }
        }
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

/// An albedo of the ground, or the wavelengths and the albedos of a spectrum.
#[derive(FromPyObject)]
pub(crate) enum GivenGround {
    Grey(f64),
    Spectrum(Vec<f64>, Vec<f64>),
}

impl GivenGround {
    pub(crate) fn albedo(&self) -> Result<GroundAlbedo, TransportError> {
        match self {
            Self::Grey(albedo) => Ok((*albedo).into()),
            Self::Spectrum(wavelengths_nm, albedos) => GroundAlbedo::spectrum(wavelengths_nm.clone(), albedos.clone()),
        }
    }
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
pub(crate) struct Colorimetry {
    pub(crate) illuminant: String,
    observer: String,
}

impl GivenSnow {
    /// Several snows that differ in some properties. An error has the row of the first wrong snow.
    pub(crate) fn samples(&self, columns: &BTreeMap<String, Column>, count: usize) -> PyResult<Vec<SnowSample>> {
        if !columns.values().all(|column| column.is_of_length(count)) {
            return Err(input(format!("a property does not have {count} values")));
        }
        let fixed = self.keys();
        let sample = |row: usize| {
            let mut snow = fixed.clone()?;
            columns.iter().try_for_each(|(key, column)| set(&mut snow, key, &column.value(row)))?;
            snow.sample().map_err(|wrong| wrong.error)
        };
        (0..count).map(|row| sample(row).map_err(|error| input_in_row(error, row))).collect()
    }

    /// The snow.
    pub(crate) fn sample(&self) -> Result<SnowSample, TransportError> {
        self.keys().and_then(|snow| snow.sample().map_err(|wrong| wrong.error))
    }

    fn keys(&self) -> Result<SnowKeys, TransportError> {
        let mut snow = SnowKeys::default();
        let given = self.0.iter().filter_map(|(key, value)| Some((key, value.as_ref()?)));
        given.into_iter().try_for_each(|(key, value)| set(&mut snow, key, value))?;
        Ok(snow)
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
    pub(crate) fn slab(&self, snow: &GivenSnow) -> PyResult<Slab> {
        let slab = Slab {
            sample: snow.sample().map_err(input)?,
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

impl Colorimetry {
    /// The colorimeter of spectra on these wavelengths, which must cover 400–700 nm.
    pub(crate) fn colorimeter(&self, wavelengths_nm: &[f64]) -> PyResult<Colorimeter> {
        let illuminant: Illuminant = self.illuminant.parse().map_err(input)?;
        let observer: Observer = self.observer.parse().map_err(input)?;
        Colorimeter::for_spectrum(observer, illuminant, wavelengths_nm).map_err(input)
    }
}
