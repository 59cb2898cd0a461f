//! A slab of snow under light, and its reflectance, transmittance and absorptance.

use std::fmt;
use std::str::FromStr;

use snowblue_base::RangeError;

use crate::TransportError;
use crate::parameters::{ANGLE, THICKNESS};
use crate::sample::SnowSample;

/// Light on the top of a slab.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Incidence {
    /// A parallel beam.
    Beam {
        /// Angle from the normal, in degrees.
        angle_deg: f64,
    },
    /// Lambertian light: equal radiance from the whole hemisphere.
    Diffuse,
}

/// Formats as the angle in degrees, or `diffuse`.
impl fmt::Display for Incidence {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Beam { angle_deg } => write!(formatter, "{angle_deg}"),
            Self::Diffuse => formatter.write_str("diffuse"),
        }
    }
}

/// An angle in degrees, or `diffuse`.
impl FromStr for Incidence {
    type Err = TransportError;

    fn from_str(word: &str) -> Result<Self, TransportError> {
        if word == "diffuse" {
            return Ok(Self::Diffuse);
        }
        let angle_deg = word.trim().parse().map_err(|_| TransportError::NoAngle { word: word.to_owned() })?;
        Ok(Self::Beam { angle_deg })
    }
}

/// Slabs of one snow sample: every thickness under every incidence at every wavelength.
#[derive(Debug, Clone, PartialEq)]
pub struct Slab {
    /// The snow.
    pub sample: SnowSample,
    /// Thicknesses, in cm; infinity for a half-space, by ordinates only.
    pub thicknesses_cm: Vec<f64>,
    /// Incident light.
    pub incidences: Vec<Incidence>,
    /// Wavelengths, in nm.
    pub wavelengths_nm: Vec<f64>,
}

/// A value and its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Best value.
    pub value: f64,
    /// Standard error of the value.
    pub standard_error: f64,
}

/// Reflectance, transmittance and absorptance of a slab: fluxes over the incident flux on a horizontal plane. With
/// another `T`, another quantity of each of the three, such as its derivative.
///
/// On a ground that reflects, the transmittance is the downward flux at the ground, and the snow absorbs 1 − R − (1 −
/// albedo) T.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fluxes<T = Estimate> {
    /// Fraction that leaves the top.
    pub reflectance: T,
    /// Fraction that arrives at the bottom, direct and diffuse.
    pub transmittance: T,
    /// Fraction that the snow absorbs.
    pub absorptance: T,
}

impl Fluxes {
    /// Names of the three.
    pub const NAMES: [&'static str; 3] = ["reflectance", "transmittance", "absorptance"];
}

impl<T> Fluxes<T> {
    /// The three, in this order.
    pub fn to_array(self) -> [T; 3] {
        [self.reflectance, self.transmittance, self.absorptance]
    }

    /// A quantity of each of the three.
    pub fn map<U>(self, quantity: impl FnMut(T) -> U) -> Fluxes<U> {
        self.to_array().map(quantity).into()
    }
}

impl<T> From<[T; 3]> for Fluxes<T> {
    fn from([reflectance, transmittance, absorptance]: [T; 3]) -> Self {
        Self { reflectance, transmittance, absorptance }
    }
}

/// Fluxes of a slab at one wavelength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Radiometry {
    /// Thickness of the slab, in cm.
    pub thickness_cm: f64,
    /// Incident light.
    pub incidence: Incidence,
    /// Wavelength, in nm.
    pub wavelength_nm: f64,
    /// Fluxes.
    pub fluxes: Fluxes,
}

impl Slab {
    /// Checks the sample and every thickness, angle and wavelength.
    ///
    /// # Errors
    /// Reports the first quantity that is missing or lies outside its range.
    pub fn check(&self) -> Result<(), TransportError> {
        self.sample.check()?;
        if self.thicknesses_cm.is_empty() {
            return Err(TransportError::Missing { quantity: "thickness" });
        }
        self.thicknesses_cm.iter().try_for_each(|thickness_cm| check_thickness(*thickness_cm))?;
        check_incidences(&self.incidences)?;
        check_wavelengths(&self.wavelengths_nm, &self.sample)
    }

    /// As [`check`](Self::check), for random walks, which have no end in a half-space.
    pub(crate) fn check_finite(&self) -> Result<(), TransportError> {
        self.check()?;
        self.thicknesses_cm.iter().try_for_each(|thickness_cm| Ok(THICKNESS.range.check(*thickness_cm)?))
    }

    /// Optical depth of the grains in a thickness, κh.
    #[must_use]
    pub fn optical_depth(&self, thickness_cm: f64) -> f64 {
        self.sample.extinction_per_m() * thickness_cm * 0.01
    }
}

/// Checks a thickness, which may be infinite.
pub(crate) fn check_thickness(thickness_cm: f64) -> Result<(), RangeError> {
    if thickness_cm.is_infinite() && thickness_cm > 0.0 { Ok(()) } else { THICKNESS.range.check(thickness_cm) }
}

/// Checks that there is an incidence and that every angle is in range.
pub(crate) fn check_incidences(incidences: &[Incidence]) -> Result<(), TransportError> {
    if incidences.is_empty() {
        return Err(TransportError::Missing { quantity: "angle" });
    }
    incidences.iter().try_for_each(|incidence| match incidence {
        Incidence::Beam { angle_deg } => Ok(ANGLE.range.check(*angle_deg)?),
        Incidence::Diffuse => Ok(()),
    })
}

/// Checks that there are wavelengths and that the tables of the sample's constituents cover them.
pub(crate) fn check_wavelengths(wavelengths_nm: &[f64], sample: &SnowSample) -> Result<(), TransportError> {
    if wavelengths_nm.is_empty() {
        return Err(TransportError::Missing { quantity: "wavelength" });
    }
    wavelengths_nm.iter().try_for_each(|wavelength_nm| sample.check_wavelength(*wavelength_nm))
}
