//! A full table: one value for every curve and wavelength.

use crate::Axes;

/// The quantity of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Light that leaves at the bottom over light that falls on the top.
    Transmittance,
    /// Light that leaves at the top over light that falls on the top.
    Reflectance,
}

impl Quantity {
    /// Both, in the order of files.
    pub const ALL: [Self; 2] = [Self::Transmittance, Self::Reflectance];

    /// Name in files and messages.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Transmittance => "transmittance",
            Self::Reflectance => "reflectance",
        }
    }
}

/// A line of a table's provenance.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Attribute {
    /// Name. In files it is the name of a global attribute.
    pub name: String,
    /// Value.
    pub value: String,
}

impl Attribute {
    /// An attribute of a name and a value.
    pub fn new(name: impl Into<String>, value: impl Into<String>) -> Self {
        Self { name: name.into(), value: value.into() }
    }
}

/// Standard errors of the values of a table, in the order of the values.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StandardErrors {
    /// Standard errors of transmittance.
    pub transmittance: Vec<f64>,
    /// Standard errors of reflectance.
    pub reflectance: Vec<f64>,
}

/// Values of the curves of a table or of a part of a table. The wavelength runs fastest.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CurveValues {
    /// Transmittance.
    pub transmittance: Vec<f64>,
    /// Reflectance.
    pub reflectance: Vec<f64>,
    /// Standard errors, if the values are estimates.
    pub errors: Option<StandardErrors>,
}

/// Transmittance and reflectance on all axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// The axes.
    pub axes: Axes,
    /// Transmittance. The wavelength runs fastest.
    pub transmittance: Vec<f64>,
    /// Reflectance, in the order of the transmittance.
    pub reflectance: Vec<f64>,
    /// Standard errors, if the values are estimates.
    pub errors: Option<StandardErrors>,
    /// Provenance.
    pub metadata: Vec<Attribute>,
}

impl StandardErrors {
    /// Standard errors of a quantity.
    #[must_use]
    pub fn of(&self, quantity: Quantity) -> &[f64] {
        match quantity {
            Quantity::Transmittance => &self.transmittance,
            Quantity::Reflectance => &self.reflectance,
        }
    }
}

impl CurveValues {
    /// Values of a quantity.
    #[must_use]
    pub fn of(&self, quantity: Quantity) -> &[f64] {
        match quantity {
            Quantity::Transmittance => &self.transmittance,
            Quantity::Reflectance => &self.reflectance,
        }
    }
}

impl Table {
    /// Puts axes, values and provenance together.
    pub(crate) fn new(axes: Axes, values: CurveValues, metadata: Vec<Attribute>) -> Self {
        let CurveValues { transmittance, reflectance, errors } = values;
        Self { axes, transmittance, reflectance, errors, metadata }
    }

    /// All values of a quantity.
    #[must_use]
    pub fn values(&self, quantity: Quantity) -> &[f64] {
        match quantity {
            Quantity::Transmittance => &self.transmittance,
            Quantity::Reflectance => &self.reflectance,
        }
    }

    /// The curves of a quantity in order, each with one value per wavelength.
    pub fn curves(&self, quantity: Quantity) -> std::slice::ChunksExact<'_, f64> {
        self.values(quantity).chunks_exact(self.axes.wavelengths_nm.len())
    }
}
