//! Bodies with simple shapes.

use glam::{DMat3, DVec3};

use crate::body::{AxisCrossing, Body};

/// A box.
#[derive(Debug, Clone, Copy)]
pub struct BoxBody {
    /// Centre, in m.
    pub centre: DVec3,
    /// Full size along its own axes, in m.
    pub size: DVec3,
    /// Its axes, as columns.
    pub axes: DMat3,
}

/// A ball.
#[derive(Debug, Clone, Copy)]
pub struct Ball {
    /// Centre, in m.
    pub centre: DVec3,
    /// Radius, in m.
    pub radius: f64,
}

impl BoxBody {
    /// A box with the axes of the coordinates.
    #[must_use]
    pub fn aligned(centre: DVec3, size: DVec3) -> Self {
        Self { centre, size, axes: DMat3::IDENTITY }
    }
}

impl Body for BoxBody {
    fn bounds(&self) -> [DVec3; 2] {
        let half = 0.5 * self.size;
        let reach = self.axes.x_axis.abs() * half.x + self.axes.y_axis.abs() * half.y + self.axes.z_axis.abs() * half.z;
        [self.centre - reach, self.centre + reach]
    }

    fn crossings(&self, axis: usize, point: DVec3, crossings: &mut Vec<AxisCrossing>) {
        let to_local = self.axes.transpose();
        let mut start = point - self.centre;
        start[axis] = 0.0;
        let (start, direction) = (to_local * start, to_local * DVec3::AXES[axis]);
        let (mut enter, mut leave) = ((f64::NEG_INFINITY, DVec3::ZERO), (f64::INFINITY, DVec3::ZERO));
        for k in 0..3 {
            let half = 0.5 * self.size[k];
            if direction[k].abs() < 1e-12 {
                if start[k].abs() >= half {
                    return;
                }
                continue;
            }
            let (near, far) = (-start[k] / direction[k], half / direction[k].abs());
            if near - far > enter.0 {
                enter = (near - far, DVec3::AXES[k]);
            }
            if near + far < leave.0 {
                leave = (near + far, DVec3::AXES[k]);
            }
        }
        if enter.0 < leave.0 {
            crossings.extend([enter, leave].map(|(distance, normal)| AxisCrossing {
                coordinate_m: self.centre[axis] + distance,
                normal: (self.axes * normal).as_vec3(),
            }));
        }
    }
}

impl Body for Ball {
    fn bounds(&self) -> [DVec3; 2] {
        [self.centre - self.radius, self.centre + self.radius]
    }

    fn crossings(&self, axis: usize, point: DVec3, crossings: &mut Vec<AxisCrossing>) {
        let mut aside = point - self.centre;
        aside[axis] = 0.0;
        let square = self.radius * self.radius - aside.length_squared();
        if square > 0.0 {
            crossings.extend([-square.sqrt(), square.sqrt()].map(|along| AxisCrossing {
                coordinate_m: self.centre[axis] + along,
                normal: ((aside + DVec3::AXES[axis] * along) / self.radius).as_vec3(),
            }));
        }
    }
}
