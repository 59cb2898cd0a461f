//! A full table: one value for every curve and wavelength.

use crate::Axes;

/// What a curve tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Light that leaves below over light that falls on top.
    Transmittance,
    /// Light that leaves on top over light that falls on top.
    Reflectance,
}

impl Quantity {
    /// Both, in the order of files.
    pub const ALL: [Self; 2] = [Self::Transmittance, Self::Reflectance];

    /// Its name in files and messages.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Transmittance => "transmittance",
            Self::Reflectance => "reflectance",
        }
    }
}

/// Transmittance and reflectance on all axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// The axes.
    pub axes: Axes,
    /// Transmittance, the wavelength running fastest.
    pub transmittance: Vec<f64>,
    /// Reflectance, in the same order.
    pub reflectance: Vec<f64>,
    /// Standard errors of both in the same order, where they are known.
    pub errors: Option<[Vec<f64>; 2]>,
    /// How the table was made, by name.
    pub metadata: Vec<(String, String)>,
}

impl Table {
    /// All values of a quantity.
    #[must_use]
    pub fn values(&self, quantity: Quantity) -> &[f64] {
        match quantity {
            Quantity::Transmittance => &self.transmittance,
            Quantity::Reflectance => &self.reflectance,
        }
    }

    /// The curves of a quantity in order, each with a value for every wavelength.
    pub fn curves(&self, quantity: Quantity) -> std::slice::ChunksExact<'_, f64> {
        self.values(quantity).chunks_exact(self.axes.wavelengths_nm.len())
    }
}
