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

/// A box with a box-shaped hole. The hole has the same axes, and is enclosed by the box or open to its surface.
#[derive(Debug, Clone, Copy)]
pub struct BoxWithHole {
    /// The box.
    pub outer: BoxBody,
    /// Centre of the hole, in m.
    pub hole_centre: DVec3,
    /// Full size of the hole along the axes of the box, in m.
    pub hole_size: DVec3,
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

    /// The points where a line parallel to an axis enters and leaves the box.
    fn segment(&self, axis: usize, point: DVec3) -> Option<[AxisCrossing; 2]> {
        let to_local = self.axes.transpose();
        let mut start = point - self.centre;
        start[axis] = 0.0;
        let (start, direction) = (to_local * start, to_local * DVec3::AXES[axis]);
        let (mut enter, mut leave) = ((f64::NEG_INFINITY, DVec3::ZERO), (f64::INFINITY, DVec3::ZERO));
        for k in 0..3 {
            let half = 0.5 * self.size[k];
            if direction[k].abs() < 1e-12 {
                if start[k].abs() >= half {
                    return None;
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
        let crossing = |(distance, normal): (f64, DVec3)| AxisCrossing {
            coordinate_m: self.centre[axis] + distance,
            normal: (self.axes * normal).as_vec3(),
        };
        (enter.0 < leave.0).then(|| [enter, leave].map(crossing))
    }
}

impl Body for BoxBody {
    fn bounds(&self) -> [DVec3; 2] {
        let half = 0.5 * self.size;
        let reach = self.axes.x_axis.abs() * half.x + self.axes.y_axis.abs() * half.y + self.axes.z_axis.abs() * half.z;
        [self.centre - reach, self.centre + reach]
    }

    fn crossings(&self, axis: usize, point: DVec3, crossings: &mut Vec<AxisCrossing>) {
        crossings.extend(self.segment(axis, point).into_iter().flatten());
    }
}

impl Body for BoxWithHole {
    fn bounds(&self) -> [DVec3; 2] {
        self.outer.bounds()
    }

    fn crossings(&self, axis: usize, point: DVec3, crossings: &mut Vec<AxisCrossing>) {
        let hole = BoxBody { centre: self.hole_centre, size: self.hole_size, axes: self.outer.axes };
        let Some([enter, leave]) = self.outer.segment(axis, point) else { return };
        let meets = |hole: &[AxisCrossing; 2]| {
            hole[0].coordinate_m < leave.coordinate_m && enter.coordinate_m < hole[1].coordinate_m
        };
        let Some([hole_enter, hole_leave]) = hole.segment(axis, point).filter(meets) else {
            crossings.extend([enter, leave]);
            return;
        };
        if enter.coordinate_m < hole_enter.coordinate_m {
            crossings.extend([enter, hole_enter]);
        }
        if hole_leave.coordinate_m < leave.coordinate_m {
            crossings.extend([hole_leave, leave]);
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
