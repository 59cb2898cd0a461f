//! Parameters as every interface describes them: key, limits, default and text.

use crate::range::ParameterRange;

/// A parameter of snow, or of the light on it, as the command, Python, Blender and the page offer it.
///
/// ```
/// use snowblue_base::{Parameter, ParameterRange};
///
/// let tilt = Parameter {
///     key: "tilt_deg",
///     title: "Tilt",
///     range: ParameterRange { quantity: "tilt", least: 0.0, greatest: 90.0, unit: "°" },
///     default: 0.0,
///     text: "Angle of the slope from the horizontal",
///     effect: "Steep slopes face the winter sun.",
///     source: "geometry",
/// };
/// assert_eq!(tilt.describe(), "Angle of the slope from the horizontal in degrees");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Key in files and interfaces.
    pub key: &'static str,
    /// Name of a control.
    pub title: &'static str,
    /// The values that it may take, and their unit.
    pub range: ParameterRange,
    /// The value where none is given.
    pub default: f64,
    /// Description of the parameter, without a full stop.
    pub text: &'static str,
    /// Effect of the parameter on the light, as a sentence.
    pub effect: &'static str,
    /// Where the definition or the effect comes from: author and year.
    pub source: &'static str,
}

impl Parameter {
    /// Description of the parameter, and its unit.
    #[must_use]
    pub fn describe(&self) -> String {
        let Self { text, range, .. } = self;
        match range.unit {
            "" => (*text).to_owned(),
            "°" => format!("{text} in degrees"),
            unit => format!("{text} in {unit}"),
        }
    }
}
