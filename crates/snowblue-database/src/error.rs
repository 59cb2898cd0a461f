//! What can be wrong with a table, its file or a question to it.

use std::path::PathBuf;

use snowblue_transport::TransportError;

/// Why a table cannot be made, read or asked.
#[derive(Debug, thiserror::Error)]
pub enum DatabaseError {
    /// An axis is empty or its values do not ascend.
    #[error("the axis {name} must ascend, but {why}")]
    Axis {
        /// The axis.
        name: &'static str,
        /// What it does instead.
        why: String,
    },
    /// The values of an axis are out of range.
    #[error("the axis {name} must have {what}")]
    AxisRange {
        /// The axis.
        name: &'static str,
        /// What it must have.
        what: &'static str,
    },
    /// The snow of an axis value is out of the model's range.
    #[error(transparent)]
    Transport(#[from] TransportError),
    /// A number of components that the table does not have.
    #[error("components are {components}, but must lie in 1–{most}")]
    Components {
        /// What was asked.
        components: usize,
        /// How many there can be.
        most: usize,
    },
    /// Criteria that no number of components meets.
    #[error("even {most} components do not keep {quantity} within the criteria")]
    Criteria {
        /// Transmittance or reflectance.
        quantity: &'static str,
        /// How many there can be.
        most: usize,
    },
    /// A curve has a value whose logarithm does not exist.
    #[error("{quantity} of the curve {curve} is {value}, which has no logarithm; use the linear space")]
    NoLogarithm {
        /// Transmittance or reflectance.
        quantity: &'static str,
        /// Which snow.
        curve: String,
        /// The value.
        value: f64,
    },
    /// A sample that is not on the grid of a table in linear space.
    #[error("{quantity} is {value}{unit}, but the paper's form takes the table's own values alone: {known}{unit}")]
    OffGrid {
        /// The axis.
        quantity: &'static str,
        /// What was asked.
        value: f64,
        /// The values on the axis.
        known: String,
        /// Unit with a leading space, or nothing.
        unit: &'static str,
    },
    /// A sample beyond the table.
    #[error("{quantity} is {value}{unit}, but the table {covered}")]
    OffAxis {
        /// The axis.
        quantity: &'static str,
        /// What was asked.
        value: f64,
        /// What the table covers, in words.
        covered: String,
        /// Unit with a leading space, or nothing.
        unit: &'static str,
    },
    /// A property that the table knows nothing of.
    #[error("{quantity} is {value}{unit}, but the table has no axis of it and holds {usual}{unit} alone")]
    NoAxis {
        /// The property.
        quantity: &'static str,
        /// What was asked.
        value: f64,
        /// Unit with a leading space, or nothing.
        unit: &'static str,
        /// What the table's snow has.
        usual: f64,
    },
    /// A table that does not say how it was filled.
    #[error(
        "the table's attribute {name} does not tell how discrete ordinates filled it, so that nothing can be computed to compare with"
    )]
    Metadata {
        /// The attribute.
        name: &'static str,
    },
    /// The singular value decomposition did not converge.
    #[error("the singular value decomposition did not converge")]
    Decomposition,
    /// A part of a table that there is not.
    #[error("part is {number}/{of}, but parts count from 1, and {grains} kinds of grain make at most {grains} parts")]
    Part {
        /// The part that was requested.
        number: usize,
        /// The number of parts.
        of: usize,
        /// The largest number of parts.
        grains: usize,
    },
    /// Shards that are not those of one table.
    #[error("the shards do not make a table: {what}")]
    Shards {
        /// What is wrong with them, by their names.
        what: String,
    },
    /// A file that is not a table of snow.
    #[error("{path}: {what}")]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// A colour without light has no hue to look for.
    #[error("the target is black, which has no hue: its luminance must be above 0")]
    DarkTarget,
    /// Snow so thick that its transmitted light has no colour.
    #[error(
        "no light that an eye could see comes through {thickness_cm} cm of this snow: less than 1e-12 of the bare light's luminance"
    )]
    NoLight {
        /// The thickness in cm.
        thickness_cm: f64,
    },
    /// Colour of these wavelengths cannot be judged.
    #[error(transparent)]
    Color(#[from] snowblue_color::ColorError),
}
