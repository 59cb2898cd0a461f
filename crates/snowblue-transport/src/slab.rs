//! The question, and its answer: a slab of snow and what it does to light.

use std::fmt;

use crate::TransportError;
use crate::sample::SnowSample;

const THICKNESS_RANGE_CM: (f64, f64) = (0.0, 1e5);
const ANGLE_RANGE_DEG: (f64, f64) = (0.0, 89.99);

/// How light falls on the slab.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Incidence {
    /// A parallel beam.
    Beam {
        /// Angle from the normal, in degrees.
        angle_deg: f64,
    },
    /// Lambertian light: equal radiance from all the hemisphere.
    Diffuse,
}

/// The angle in degrees, or `diffuse`.
impl fmt::Display for Incidence {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Beam { angle_deg } => write!(formatter, "{angle_deg}"),
            Self::Diffuse => formatter.write_str("diffuse"),
        }
    }
}

/// Slabs of one kind of snow: every thickness under every light at every wavelength.
#[derive(Debug, Clone, PartialEq)]
pub struct Slab {
    /// The snow.
    pub sample: SnowSample,
    /// Thicknesses, in cm.
    pub thicknesses_cm: Vec<f64>,
    /// Directions of the light.
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

/// What one slab does to light of one wavelength: fluxes over the incident flux on a horizontal plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Radiometry {
    /// Thickness of the slab, in cm.
    pub thickness_cm: f64,
    /// Direction of the light.
    pub incidence: Incidence,
    /// Wavelength, in nm.
    pub wavelength_nm: f64,
    /// Share that leaves on top.
    pub reflectance: Estimate,
    /// Share that leaves below, direct and diffuse.
    pub transmittance: Estimate,
    /// Share that stays.
    pub absorptance: Estimate,
}

impl Slab {
    /// Checks the sample and every thickness, angle and wavelength.
    ///
    /// # Errors
    /// The first quantity that is missing or lies outside its range.
    pub fn check(&self) -> Result<(), TransportError> {
        self.sample.check()?;
        if self.thicknesses_cm.is_empty() {
            return Err(TransportError::Nothing { quantity: "thickness" });
        }
        self.thicknesses_cm.iter().try_for_each(|thickness_cm| check_thickness(*thickness_cm))?;
        check_incidences(&self.incidences)?;
        check_wavelengths(&self.wavelengths_nm, &self.sample)
    }

    /// Optical depth of the grains in a thickness, κh.
    #[must_use]
    pub fn optical_depth(&self, thickness_cm: f64) -> f64 {
        self.sample.extinction_per_m() * thickness_cm * 0.01
    }
}

/// Checks a thickness in cm.
pub(crate) fn check_thickness(thickness_cm: f64) -> Result<(), TransportError> {
    TransportError::check("thickness", thickness_cm, THICKNESS_RANGE_CM, " cm")
}

/// Checks that there is light and that it comes from above.
pub(crate) fn check_incidences(incidences: &[Incidence]) -> Result<(), TransportError> {
    if incidences.is_empty() {
        return Err(TransportError::Nothing { quantity: "angle" });
    }
    incidences.iter().try_for_each(|incidence| match incidence {
        Incidence::Beam { angle_deg } => TransportError::check("angle", *angle_deg, ANGLE_RANGE_DEG, "°"),
        Incidence::Diffuse => Ok(()),
    })
}

/// Checks that there are wavelengths and that the tables of all that the snow holds cover them.
pub(crate) fn check_wavelengths(wavelengths_nm: &[f64], sample: &SnowSample) -> Result<(), TransportError> {
    if wavelengths_nm.is_empty() {
        return Err(TransportError::Nothing { quantity: "wavelength" });
    }
    wavelengths_nm.iter().try_for_each(|wavelength_nm| sample.check_wavelength(*wavelength_nm))
}
