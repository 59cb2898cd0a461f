//! Ranges of the values of a description.

use glam::Vec3A;
use snowblue_transport::{ParameterRange, short_number};

use snowblue_base::{KeyError, KeyPath};

/// Greatest coordinate of anything in a scene, in m.
pub(crate) const GREATEST_COORDINATE_M: f64 = 1e5;
/// Greatest power of a light, in any unit.
const GREATEST_POWER: f64 = 1e12;

/// A coordinate of anything in a scene.
pub(crate) const COORDINATE: Range = Range::new(-GREATEST_COORDINATE_M, GREATEST_COORDINATE_M, "m");
/// A component of a direction of any length.
pub(crate) const DIRECTION: Range = Range::new(-1e6, 1e6, "");
/// An angle about an axis.
pub(crate) const ROTATION: Range = Range::new(-360.0, 360.0, "deg");
/// A part of a whole.
pub(crate) const FRACTION: Range = Range::new(0.0, 1.0, "");

pub(super) type Checked = Result<(), KeyError>;

/// The range of a value that its key names.
#[derive(Clone, Copy)]
pub(crate) struct Range(pub(super) ParameterRange);

impl Range {
    pub(crate) const fn new(least: f64, greatest: f64, unit: &'static str) -> Self {
        Self(ParameterRange { quantity: "", least, greatest, unit })
    }

    /// That of a parameter.
    pub(super) const fn of(parameter: ParameterRange) -> Self {
        Self(parameter)
    }

    /// Powers in a unit.
    pub(crate) const fn power(unit: &'static str) -> Self {
        Self::new(0.0, GREATEST_POWER, unit)
    }

    /// Whether a value lies in the range.
    pub(crate) fn check(&self, path: &KeyPath, value: f64) -> Checked {
        if self.0.contains(value) {
            return Ok(());
        }
        let ParameterRange { least, greatest, unit, .. } = self.0;
        let space = if unit.is_empty() { "" } else { " " };
        let value = short_number(value);
        Err(path.error(format!("is {value}{space}{unit}, but must lie in {least} to {greatest}{space}{unit}")))
    }

    /// Whether all values lie in the range.
    pub(crate) fn check_all(&self, path: &KeyPath, values: &[f64]) -> Checked {
        values.iter().try_for_each(|value| self.check(path, *value))
    }
}

/// A unit vector in a direction, which `reason` refuses if its length is zero.
pub(crate) fn unit_vector(path: &KeyPath, direction: Vec3A, reason: &str) -> Result<Vec3A, KeyError> {
    direction.try_normalize().ok_or_else(|| path.error(reason))
}
