//! Principal components of a table: the singular value decomposition M = U Σ Vᵀ, uncentred, and C = M V.
//!
//! M has a row for each curve and a column for each wavelength; the first l' columns of C and V are kept (the paper's
//! sidebar, after Pratt 2007). In the `linear` space M holds the values themselves, as in the paper; in the `log` space
//! their natural logarithms, so that a rebuilt value is never negative and its relative error is what is kept small.

use faer::Mat;

use crate::{Axes, DatabaseError, Quantity, Table};

/// Most components that a compressed table keeps.
pub const MAX_COMPONENTS: usize = 31;

/// Shares of light below this are one to the log space: beyond the reach of single precision, and of any use.
pub const DARKEST: f64 = 1e-40;

/// What the principal components are taken of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Space {
    /// The values, as in the paper.
    Linear,
    /// Their natural logarithms.
    Log,
}

/// A table reduced to a few coefficients a curve.
#[derive(Debug, Clone, PartialEq)]
pub struct CompressedTable {
    /// The axes.
    pub axes: Axes,
    /// What the components are taken of.
    pub space: Space,
    /// Transmittance.
    pub transmittance: Components,
    /// Reflectance, on a basis of its own.
    pub reflectance: Components,
    /// How the table was made, by name.
    pub metadata: Vec<(String, String)>,
}

/// Curves as coefficients on a basis of spectra.
#[derive(Debug, Clone, PartialEq)]
pub struct Components {
    /// l', the number of components.
    pub count: usize,
    /// The component runs fastest, then the curve.
    pub coefficients: Vec<f32>,
    /// The component runs fastest, then the wavelength.
    pub basis: Vec<f32>,
    /// σ_1 ≥ σ_2 ≥ …, all of them.
    pub singular_values: Vec<f64>,
}

impl Space {
    /// How many components are kept where nothing is said: the paper's two in linear space; in log space the six that keep
    /// the embedded table's transmittance within .5 % everywhere.
    #[must_use]
    pub fn usual_components(self) -> usize {
        match self {
            Self::Linear => 2,
            Self::Log => 6,
        }
    }

    /// Its name in files and options.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Log => "log",
        }
    }

    /// From a value into this space; in the log space what is darker than [`DARKEST`] counts as that.
    #[must_use]
    pub fn enter(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Log => value.max(DARKEST).ln(),
        }
    }

    /// From this space back to a value.
    #[must_use]
    pub fn leave(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Log => value.exp(),
        }
    }
}

/// All singular values and the basis V of one quantity, the component running along the columns.
pub struct Decomposition {
    space: Space,
    wavelengths: usize,
    singular_values: Vec<f64>,
    basis: Mat<f64>,
}

impl Decomposition {
    /// Decomposes the curves of a quantity.
    ///
    /// # Errors
    /// In the log space, if a value is negative, or if it is 0 for want of rays.
    pub fn new(table: &Table, quantity: Quantity, space: Space) -> Result<Self, DatabaseError> {
        let wavelengths = table.axes.wavelengths_nm.len();
        let values = table.values(quantity);
        if space == Space::Log
            && let Some(place) =
                values.iter().position(|value| *value < 0.0 || (*value == 0.0 && table.errors.is_some()))
        {
            let curve = table.axes.describe(place / wavelengths);
            return Err(DatabaseError::NoLogarithm { quantity: quantity.name(), curve, value: values[place] });
        }
        let matrix = Mat::from_fn(table.axes.curves(), wavelengths, |i, j| space.enter(values[i * wavelengths + j]));
        let decomposition = matrix.thin_svd().map_err(|_| DatabaseError::Decomposition)?;
        let singular_values = decomposition.S().column_vector().iter().copied().collect();
        Ok(Self { space, wavelengths, singular_values, basis: decomposition.V().to_owned() })
    }

    /// σ_1 ≥ σ_2 ≥ …
    #[must_use]
    pub fn singular_values(&self) -> &[f64] {
        &self.singular_values
    }

    /// The first `count` columns of C = M V and of V.
    ///
    /// # Errors
    /// [`DatabaseError::Components`] if there are not so many.
    pub fn keep(&self, table: &Table, quantity: Quantity, count: usize) -> Result<Components, DatabaseError> {
        let most = self.basis.ncols().min(MAX_COMPONENTS);
        if count == 0 || count > most {
            return Err(DatabaseError::Components { components: count, most });
        }
        let mut coefficients = Vec::with_capacity(table.axes.curves() * count);
        for curve in table.curves(quantity) {
            for component in 0..count {
                let terms = curve.iter().enumerate().map(|(j, v)| self.space.enter(*v) * self.basis[(j, component)]);
                coefficients.push(single(terms.sum()));
            }
        }
        let entry = |i: usize| single(self.basis[(i / count, i % count)]);
        let basis = (0..self.wavelengths * count).map(entry).collect();
        Ok(Components { count, coefficients, basis, singular_values: self.singular_values.clone() })
    }
}

impl CompressedTable {
    /// Keeps `count` components of both quantities.
    ///
    /// # Errors
    /// If there are not so many, or a value has no logarithm.
    pub fn new(table: &Table, space: Space, count: usize) -> Result<Self, DatabaseError> {
        let components = |quantity| Decomposition::new(table, quantity, space)?.keep(table, quantity, count);
        Ok(Self {
            axes: table.axes.clone(),
            space,
            transmittance: components(Quantity::Transmittance)?,
            reflectance: components(Quantity::Reflectance)?,
            metadata: table.metadata.clone(),
        })
    }

    /// The components of a quantity.
    #[must_use]
    pub fn components(&self, quantity: Quantity) -> &Components {
        match quantity {
            Quantity::Transmittance => &self.transmittance,
            Quantity::Reflectance => &self.reflectance,
        }
    }
}

impl Components {
    /// Rebuilds curve number `curve`, C'_i V'ᵀ, as values.
    pub fn rebuild(&self, curve: usize, space: Space, values: &mut [f64]) {
        let coefficients = &self.coefficients[curve * self.count..(curve + 1) * self.count];
        for (value, basis) in values.iter_mut().zip(self.basis.chunks_exact(self.count)) {
            let sum = coefficients.iter().zip(basis).map(|(c, v)| f64::from(*c) * f64::from(*v)).sum();
            *value = space.leave(sum);
        }
    }
}

/// Coefficients and basis are stored in single precision.
#[expect(clippy::cast_possible_truncation, reason = "single precision is what is stored")]
pub(crate) fn single(value: f64) -> f32 {
    value as f32
}
