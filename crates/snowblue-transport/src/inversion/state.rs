//! Elements of the state: logarithms of positive quantities and log-odds of fractions, so that all are unbounded and
//! priors are log-normal.

use snowblue_base::ParameterRange;

use crate::parameters::{GROUND_ALBEDO, THICKNESS};
use crate::sample::Property;
use crate::variable::Variable;

/// Least value of quantities that may be 0, in their units.
const LEAST: f64 = 1e-6;
/// Cosine of 89.988°, just within the range of angles.
const MIN_COSINE: f64 = 2e-4;

/// Prior of a variable: a log-normal distribution, or, for a fraction, a distribution with normal log-odds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prior {
    /// Median, in the unit of the variable; none for a variable whose value is part of the pack or the illumination.
    pub median: Option<f64>,
    /// Standard deviation of the logarithm or of the log-odds.
    pub deviation: f64,
}

impl Prior {
    /// A weak prior: 95 % of seasonal snow, and of the impurities deposited in it, lie within two standard
    /// deviations.
    ///
    /// The medians of density, thickness, the cosine of the sun and the albedo of the ground are their known values.
    #[must_use]
    pub fn weak(variable: Variable) -> Self {
        let (median, deviation) = match variable {
            Variable::Snow(Property::SurfaceArea) => (Some(20.0), 1.0),
            Variable::Snow(Property::WaterSaturation) => (Some(0.05), 1.5),
            Variable::Snow(Property::Impurity(substance)) => {
                let (median_ng_g, deviation) = substance.usual_ng_g();
                (Some(median_ng_g), deviation)
            }
            Variable::Snow(_) => (None, 0.4),
            Variable::Thickness => (None, 0.5),
            Variable::CosIncidence => (None, 0.2),
            Variable::GroundAlbedo => (None, 1.0),
        };
        Self { median, deviation }
    }
}

/// The range of a variable as an element of the state.
pub(super) fn state_range(variable: Variable) -> ParameterRange {
    let range = range(variable);
    let greatest = if is_fraction(variable) { 1.0 - LEAST } else { range.greatest };
    ParameterRange { least: range.least.max(LEAST), greatest, ..range }
}

fn range(variable: Variable) -> ParameterRange {
    match variable {
        Variable::Snow(property) => property.parameter().range,
        Variable::Thickness => THICKNESS.range,
        Variable::CosIncidence => ParameterRange::new("cosine of the angle", MIN_COSINE, 1.0, ""),
        Variable::GroundAlbedo => GROUND_ALBEDO.range,
    }
}

/// Whether the element is the log-odds of the variable, ln(v/(1 − v)), and not its logarithm.
fn is_fraction(variable: Variable) -> bool {
    range(variable).greatest <= 1.0
}

/// The element of the state.
pub(super) fn element(variable: Variable, value: f64) -> f64 {
    if is_fraction(variable) { (value / (1.0 - value)).ln() } else { value.ln() }
}

/// The value of the variable, within the range in spite of rounding.
pub(super) fn value(variable: Variable, element: f64) -> f64 {
    let value = if is_fraction(variable) { 1.0 / (1.0 + (-element).exp()) } else { element.exp() };
    let ParameterRange { least, greatest, .. } = state_range(variable);
    value.clamp(least, greatest)
}

/// The derivative of the value by the element.
pub(super) fn slope(variable: Variable, value: f64) -> f64 {
    if is_fraction(variable) { value * (1.0 - value) } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_elements_and_slopes_agree() {
        for variable in Variable::all() {
            let range = state_range(variable);
            let middle = 0.5 * (range.least + range.greatest.min(100.0));
            let at = element(variable, middle);
            assert!((value(variable, at) / middle - 1.0).abs() < 1e-14, "{variable}");
            // A central difference: h²/6 of its scale, and rounding over h.
            let difference = (value(variable, at + 1e-5) - value(variable, at - 1e-5)) / 2e-5;
            assert!((slope(variable, middle) / difference - 1.0).abs() < 1e-9, "{variable}");
            for end in [range.least, range.greatest] {
                assert!(range.contains(value(variable, element(variable, end))), "{variable}");
            }
            let Prior { median, deviation } = Prior::weak(variable);
            assert!(deviation > 0.0 && median.is_none_or(|median| range.contains(median)), "{variable}");
        }
    }
}
