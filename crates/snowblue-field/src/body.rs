//! Interface between the grid and a body of snow: its bounds, and the crossings of axis-parallel lines with its
//! surface.
//!
//! The grid needs little else: the segments of lines inside the body measure its volume, and the crossings sample its
//! surface. Any shape that rays can be traced through is a body, for example a union of touching blocks.

use glam::{DVec3, Vec3};

/// A solid body of snow.
pub trait Body: Sync {
    /// Opposite corners of an axis-aligned bounding box, in m: the corner of least coordinates, then the corner of
    /// greatest coordinates.
    fn bounds(&self) -> [DVec3; 2];

    /// Adds all crossings of a line with the surface, in any order. The line is parallel to axis 0, 1 or 2, in the
    /// direction of growing coordinates, and goes through `point`, in m.
    fn crossings(&self, axis: usize, point: DVec3, crossings: &mut Vec<AxisCrossing>);

    /// Whether other snow covers the surface at a point, in m, with an outward unit normal. No light passes there.
    fn is_covered(&self, _point: DVec3, _normal: Vec3) -> bool {
        false
    }
}

/// A crossing of a line parallel to an axis with a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisCrossing {
    /// Coordinate on the axis, in m.
    pub coordinate_m: f64,
    /// Unit normal of the surface. It may point to either side.
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

    /// The segments of a line inside the body, in order. A line with an odd number of crossings grazes an edge or
    /// passes through a hole, and has no segments.
    pub(crate) fn segments(&mut self, axis: usize, point: DVec3) -> impl Iterator<Item = Segment> {
        if !self.cast(axis, point) {
            self.crossings.clear();
        }
        self.found(axis)
    }

    /// The segments of the first line with an even number of crossings, among the lines through `points`.
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

    /// Thickness of the body at a point near its surface with a normal, in m: the length of the line through the point
    /// along the nearest axis, times the cosine between both. It is 0 outside of the body.
    pub(crate) fn thickness_m(&mut self, point: DVec3, normal: Vec3) -> f64 {
        let axis = normal.abs().max_position();
        let holds =
            |segment: &Segment| (segment.enter.coordinate_m..=segment.leave.coordinate_m).contains(&point[axis]);
        let length_m = self.segments(axis, point).find(holds).map_or(0.0, |segment| segment.length_m());
        length_m * f64::from(normal[axis].abs())
    }

    /// Finds the crossings of a line, and returns whether their number is even.
    fn cast(&mut self, axis: usize, point: DVec3) -> bool {
        self.crossings.clear();
        self.body.crossings(axis, point, &mut self.crossings);
        self.crossings.sort_unstable_by(|a, b| a.coordinate_m.total_cmp(&b.coordinate_m));
        self.crossings.len().is_multiple_of(2)
    }

    /// The segments between the crossings that the last cast found.
    fn found(&self, axis: usize) -> impl Iterator<Item = Segment> {
        let outward = move |crossing: AxisCrossing, sign: f32| {
            let flip = if crossing.normal[axis] * sign < 0.0 { -1.0 } else { 1.0 };
            AxisCrossing { normal: crossing.normal * flip, ..crossing }
        };
        let pairs = self.crossings.as_chunks::<2>().0;
        pairs.iter().map(move |[enter, leave]| Segment { enter: outward(*enter, -1.0), leave: outward(*leave, 1.0) })
    }
}
