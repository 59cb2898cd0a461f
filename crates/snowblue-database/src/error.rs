//! Errors of tables, of their files and of look-ups.

use std::path::{Path, PathBuf};

use snowblue_base::unit_suffix;
use snowblue_transport::TransportError;

/// Why a table cannot be filled, read, written or looked up.
#[derive(Debug, thiserror::Error)]
pub enum DatabaseError {
    /// The values of an axis do not ascend, or there are none.
    #[error("the axis {name} must ascend, but {why}")]
    Axis {
        /// The axis.
        name: &'static str,
        /// Description of the error.
        why: String,
    },
    /// The values of an axis are out of range.
    #[error("the axis {name} must have {what}")]
    AxisRange {
        /// The axis.
        name: &'static str,
        /// Requirement on the axis.
        what: &'static str,
    },
    /// Axes of a table that would not fit in memory, or never be computed.
    #[error(
        "the axes have {lengths} values: {samples} samples and {values} values of a quantity, but must have at most \
         {most_samples} and {most_values}"
    )]
    TooManyValues {
        /// The lengths of the axes.
        lengths: String,
        /// Number of samples.
        samples: String,
        /// Number of values of a quantity.
        values: String,
        /// The greatest number of samples.
        most_samples: usize,
        /// The greatest number of values.
        most_values: usize,
    },
    /// A sample of the axes is out of the model's range.
    #[error(transparent)]
    Transport(#[from] TransportError),
    /// A number of components that the table does not have.
    #[error("components is {components}, but must lie in 1–{max}")]
    Components {
        /// The number requested.
        components: usize,
        /// The largest number.
        max: usize,
    },
    /// Criteria that no number of components meets.
    #[error("{max} components, the most there are, do not keep {quantity} within the criteria")]
    Criteria {
        /// Transmittance or reflectance.
        quantity: &'static str,
        /// The largest number of components.
        max: usize,
    },
    /// A curve has a value without a logarithm.
    #[error("{quantity} of the curve {curve} is {value}, which has no logarithm; use the linear space")]
    NoLogarithm {
        /// Transmittance or reflectance.
        quantity: &'static str,
        /// The curve.
        curve: String,
        /// The value.
        value: f64,
    },
    /// A sample that is not on the grid of a table in linear space.
    #[error(
        "{quantity} is {value}{unit}, but the paper's scheme has only the table's own values: {known}{unit}",
        unit = unit_suffix(.unit)
    )]
    OffGrid {
        /// The axis.
        quantity: &'static str,
        /// The value requested.
        value: f64,
        /// The values on the axis.
        known: String,
        /// Unit; empty for a ratio.
        unit: &'static str,
    },
    /// A sample beyond an axis of the table.
    #[error("{quantity} is {value}{unit}, but the table {covered}", unit = unit_suffix(.unit))]
    OffAxis {
        /// The axis.
        quantity: &'static str,
        /// The value requested.
        value: f64,
        /// The range of the axis, in words.
        covered: String,
        /// Unit; empty for a ratio.
        unit: &'static str,
    },
    /// A property that the table has no axis of.
    #[error(
        "{quantity} is {value}{unit}, but the table has no such axis and holds only {default}{unit}",
        unit = unit_suffix(.unit)
    )]
    NoAxis {
        /// The property.
        quantity: &'static str,
        /// The value requested.
        value: f64,
        /// Unit; empty for a ratio.
        unit: &'static str,
        /// The value of the table's samples.
        default: f64,
    },
    /// A table whose metadata do not say how it was filled.
    #[error("the table's attribute {name} is missing or invalid")]
    Metadata {
        /// The attribute.
        name: &'static str,
    },
    /// The singular value decomposition did not converge, or a value is not finite.
    #[error("the singular value decomposition failed: the table has values that are not finite")]
    Decomposition,
    /// A part that a table does not have.
    #[error("part is {number}/{of}, but parts count from 1, and {grains} kinds of grain make at most {grains} parts")]
    Part {
        /// The part requested.
        number: usize,
        /// The number of parts requested.
        of: usize,
        /// The largest number of parts.
        grains: usize,
    },
    /// Shards of different tables, or shards that do not make up a table.
    #[error("the shards do not make a table: {what}")]
    Shards {
        /// Description of the error, with the names of the shards.
        what: String,
    },
    /// A file that cannot be read or written, or is not a table of snow.
    #[error("{path}: {what}")]
    File {
        /// The file.
        path: PathBuf,
        /// Description of the error.
        what: String,
    },
    /// A target colour without luminance.
    #[error("the target is black, which has no hue: its luminance must be above 0")]
    DarkTarget,
    /// Snow so thick that the transmitted light is invisible.
    #[error("{thickness_cm} cm of this snow transmit less than 1e-12 of the luminance, too little to have a colour")]
    NoLight {
        /// The thickness in cm.
        thickness_cm: f64,
    },
    /// Wavelengths that do not determine a colour.
    #[error(transparent)]
    Color(#[from] snowblue_color::ColorError),
}

impl DatabaseError {
    pub(crate) fn file(path: &Path, what: impl Into<String>) -> Self {
        Self::File { path: path.to_owned(), what: what.into() }
    }
}
