//! Bodies of snow, as the grid sees them: bounds, and where lines parallel to an axis cross the surface.
//!
//! Lines give all that the grid needs: the parts of a line inside the body are its volume, and the crossings sample its
//! surface. Any shape that rays can be traced through is a body, also a union of touching blocks.

use glam::{DVec3, Vec3};

/// A solid body of snow.
pub trait Body: Sync {
    /// The corner of least coordinates and the corner of greatest coordinates of an axis-aligned box around the body,
    /// in m.
    fn bounds(&self) -> [DVec3; 2];

    /// Adds all crossings of a line with the surface, in any order. The line is parallel to axis 0, 1 or 2, in the
    /// direction of growing coordinates, and goes through `point`, in m.
    fn crossings(&self, axis: usize, point: DVec3, crossings: &mut Vec<AxisCrossing>);
}

/// A crossing of a line parallel to an axis with a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisCrossing {
    /// Coordinate on the axis, in m.
    pub coordinate_m: f64,
    /// Unit normal of the surface, on either side.
    pub normal: Vec3,
}

/// A segment of a line inside a body, with outward normals at its ends.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Segment {
    pub(crate) enter: AxisCrossing,
    pub(crate) leave: AxisCrossing,
}

/// Traces lines through a body.
pub(crate) struct Scanner<'b> {
    body: &'b dyn Body,
    crossings: Vec<AxisCrossing>,
}

impl Segment {
    pub(crate) fn length_m(&self) -> f64 {
        self.leave.coordinate_m - self.enter.coordinate_m
    }
}

impl<'b> Scanner<'b> {
    pub(crate) fn new(body: &'b dyn Body) -> Self {
        Self { body, crossings: Vec::new() }
    }

    /// The segments of a line inside the body, in order. A line with an odd number of crossings, which grazes an edge
    /// or passes through a hole, has none.
    pub(crate) fn segments(&mut self, axis: usize, point: DVec3) -> impl Iterator<Item = Segment> {
        if !self.cast(axis, point) {
            self.crossings.clear();
        }
        self.found(axis)
    }

    /// The segments of the first of some lines that has an even number of crossings.
    pub(crate) fn sound_segments(
        &mut self,
        axis: usize,
        points: impl IntoIterator<Item = DVec3>,
    ) -> impl Iterator<Item = Segment> {
        if !points.into_iter().any(|point| self.cast(axis, point)) {
            self.crossings.clear();
        }
        self.found(axis)
    }

    /// Finds the crossings of a line, and whether their number is even.
    fn cast(&mut self, axis: usize, point: DVec3) -> bool {
        self.crossings.clear();
        self.body.crossings(axis, point, &mut self.crossings);
        self.crossings.sort_unstable_by(|a, b| a.coordinate_m.total_cmp(&b.coordinate_m));
        self.crossings.len().is_multiple_of(2)
    }

    /// The segments between the crossings that were found.
    fn found(&self, axis: usize) -> impl Iterator<Item = Segment> {
        let outward = move |crossing: AxisCrossing, sign: f32| {
            let flip = if crossing.normal[axis] * sign < 0.0 { -1.0 } else { 1.0 };
            AxisCrossing { normal: crossing.normal * flip, ..crossing }
        };
        let pairs = self.crossings.as_chunks::<2>().0;
        pairs.iter().map(move |[enter, leave]| Segment { enter: outward(*enter, -1.0), leave: outward(*leave, 1.0) })
    }
}
