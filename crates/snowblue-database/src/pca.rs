//! Principal components of a table: the singular value decomposition M = U Σ Vᵀ, uncentred, and C = M V.
//!
//! M has a row for each curve and a column for each wavelength. The first l' columns of C and V are kept (the paper's
//! sidebar, after Pratt 2007). In the `linear` space M holds the values themselves, as in the paper. In the `log` space
//! it holds their natural logarithms, so that a rebuilt value is never negative and the relative error is kept small.
//!
//! The sign of a component is fixed: the largest entry of its basis spectrum is positive (`svd`).

use nalgebra::DMatrix;

use crate::svd::Svd;
use crate::table::Attribute;
use crate::{Axes, DatabaseError, Quantity, Table};

/// Largest number of components of a compressed table.
pub const MAX_COMPONENTS: usize = 31;

/// Smallest value in log space. Smaller values are raised to it. Single precision does not hold much smaller values.
pub const LOG_FLOOR: f64 = 1e-40;

/// The space in which principal components are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Space {
    /// The values, as in the paper.
    Linear,
    /// Their natural logarithms.
    Log,
}

/// A table reduced to a few coefficients per curve.
#[derive(Debug, Clone, PartialEq)]
pub struct CompressedTable {
    /// The axes.
    pub axes: Axes,
    /// The space of the components.
    pub space: Space,
    /// Transmittance.
    pub transmittance: Components,
    /// Reflectance, on its own basis.
    pub reflectance: Components,
    /// Provenance.
    pub metadata: Vec<Attribute>,
}

/// Curves as coefficients on a basis of spectra.
#[derive(Debug, Clone, PartialEq)]
pub struct Components {
    /// l', the number of components.
    pub count: usize,
    /// C', `[curve][component]`.
    pub coefficients: Vec<f32>,
    /// V', `[wavelength][component]`.
    pub basis: Vec<f32>,
    /// All singular values, σ_1 ≥ σ_2 ≥ …
    pub singular_values: Vec<f64>,
}

impl Space {
    /// Number of components kept by default: the paper's two in linear space, six in log space, which keep the embedded
    /// table's transmittance within 0.5 % everywhere.
    #[must_use]
    pub fn default_components(self) -> usize {
        match self {
            Self::Linear => 2,
            Self::Log => 6,
        }
    }

    /// Name in files and options.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Log => "log",
        }
    }

    /// Converts a value into this space. In log space, values below [`LOG_FLOOR`] are raised to [`LOG_FLOOR`].
    #[must_use]
    pub fn encode(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Log => value.max(LOG_FLOOR).ln(),
        }
    }

    /// Converts a number of this space into a value.
    #[must_use]
    pub fn decode(self, encoded: f64) -> f64 {
        match self {
            Self::Linear => encoded,
            Self::Log => encoded.exp(),
        }
    }
}

/// All singular values and the whole basis V of one quantity.
pub struct Decomposition {
    space: Space,
    svd: Svd,
}

impl Decomposition {
    /// Decomposes the curves of a quantity.
    ///
    /// # Errors
    /// [`DatabaseError::NoLogarithm`] if in log space a value is negative, or 0 as an estimate.
    pub fn new(table: &Table, quantity: Quantity, space: Space) -> Result<Self, DatabaseError> {
        let wavelengths = table.axes.wavelengths_nm.len();
        let values = table.values(quantity);
        if space == Space::Log
            && let Some(index) =
                values.iter().position(|value| *value < 0.0 || (*value == 0.0 && table.errors.is_some()))
        {
            let curve = table.axes.describe(index / wavelengths);
            return Err(DatabaseError::NoLogarithm { quantity: quantity.name(), curve, value: values[index] });
        }
        let matrix =
            DMatrix::from_fn(table.axes.curves(), wavelengths, |i, j| space.encode(values[i * wavelengths + j]));
        let svd = Svd::new(matrix).ok_or(DatabaseError::Decomposition)?;
        Ok(Self { space, svd })
    }

    /// σ_1 ≥ σ_2 ≥ …
    #[must_use]
    pub fn singular_values(&self) -> &[f64] {
        &self.svd.singular_values
    }

    /// The first `count` columns of C = M V and of V.
    ///
    /// # Errors
    /// [`DatabaseError::Components`] if `count` is 0 or too large.
    pub fn keep(&self, table: &Table, quantity: Quantity, count: usize) -> Result<Components, DatabaseError> {
        let basis = &self.svd.right_vectors;
        let max = basis.ncols().min(MAX_COMPONENTS);
        if count == 0 || count > max {
            return Err(DatabaseError::Components { components: count, max });
        }
        let mut coefficients = Vec::with_capacity(table.axes.curves() * count);
        for curve in table.curves(quantity) {
            for component in 0..count {
                let terms = curve.iter().enumerate().map(|(j, v)| self.space.encode(*v) * basis[(j, component)]);
                coefficients.push(single(terms.sum()));
            }
        }
        let entry = |i: usize| single(basis[(i / count, i % count)]);
        let kept = (0..basis.nrows() * count).map(entry).collect();
        Ok(Components { count, coefficients, basis: kept, singular_values: self.svd.singular_values.clone() })
    }
}

impl CompressedTable {
    /// Keeps `count` components of both quantities.
    ///
    /// # Errors
    /// If `count` is 0 or too large, or a value has no logarithm.
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

    /// The table with its coefficients rounded to multiples of a step.
    ///
    /// In log space the error of a curve is relative. The basis is orthonormal. Over n wavelengths the root mean
    /// square of the error is therefore at most step √(l'/n) / 2, and step √(l'/(12 n)) for a usual curve.
    ///
    /// # Panics
    /// If the step is not a positive power of two, whose multiples single precision holds without rounding.
    #[must_use]
    pub fn rounded(mut self, step: f32) -> Self {
        assert!(step.is_normal() && step.to_bits() << 9 == 0 && step > 0.0, "the step must be a power of two");
        for components in [&mut self.transmittance, &mut self.reflectance] {
            components
                .coefficients
                .iter_mut()
                .for_each(|coefficient| *coefficient = step * (*coefficient / step).round());
        }
        self
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
    /// Rebuilds a curve by its number, C'_i V'ᵀ, and writes its values.
    pub fn rebuild(&self, curve: usize, space: Space, values: &mut [f64]) {
        let coefficients = &self.coefficients[curve * self.count..(curve + 1) * self.count];
        for (value, basis) in values.iter_mut().zip(self.basis.chunks_exact(self.count)) {
            let sum = coefficients.iter().zip(basis).map(|(c, v)| f64::from(*c) * f64::from(*v)).sum();
            *value = space.decode(sum);
        }
    }
}

/// Rounds to single precision, in which coefficients and basis are stored.
#[expect(clippy::cast_possible_truncation, reason = "tables store single precision")]
pub(crate) fn single(value: f64) -> f32 {
    value as f32
}
