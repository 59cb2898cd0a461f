//! Axis-aligned bounding boxes and their intersection with rays.

use glam::{Vec3, Vec3A};

use crate::ray::Ray;

/// An interval of distances along a ray, in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Where it starts; negative behind the ray's origin.
    pub start_m: f32,
    /// Where it ends.
    pub end_m: f32,
}

/// An axis-aligned box, in m.
#[derive(Debug, Clone, Copy)]
pub struct Bounds {
    /// The corner of least coordinates.
    pub low: Vec3A,
    /// The corner of greatest coordinates.
    pub high: Vec3A,
}

impl Bounds {
    /// The bounds of points; an inverted, empty box if there are none.
    pub fn of(points: impl Iterator<Item = Vec3>) -> Self {
        let nothing = Self { low: Vec3A::INFINITY, high: Vec3A::NEG_INFINITY };
        points.fold(nothing, |bounds, point| bounds.around(Self { low: point.into(), high: point.into() }))
    }

    /// The bounds of two boxes.
    #[must_use]
    pub fn around(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// The box that two boxes share; none if they neither touch nor overlap.
    pub fn common(self, other: Self) -> Option<Self> {
        let common = Self { low: self.low.max(other.low), high: self.high.min(other.high) };
        common.low.cmple(common.high).all().then_some(common)
    }

    /// Moves all sides outwards.
    pub fn padded(self, padding_m: f32) -> Self {
        Self { low: self.low - padding_m, high: self.high + padding_m }
    }

    /// The eight corners.
    pub fn corners(&self) -> [Vec3A; 8] {
        let side = |bits: usize, axis: usize| if bits >> axis & 1 == 0 { self.low[axis] } else { self.high[axis] };
        std::array::from_fn(|bits| Vec3A::new(side(bits, 0), side(bits, 1), side(bits, 2)))
    }

    /// Whether a point is inside or on the surface.
    #[inline]
    pub fn contains(&self, point: Vec3A) -> bool {
        point.cmpge(self.low).all() && point.cmple(self.high).all()
    }

    /// Length of the diagonal, in m.
    pub fn diagonal_m(&self) -> f32 {
        (self.high - self.low).length()
    }

    /// Greatest magnitude of a coordinate, in m. Rounding errors are proportional to it.
    pub fn greatest_coordinate(&self) -> f32 {
        self.low.abs().max(self.high.abs()).max_element()
    }

    /// The part of an interval of a ray that lies in the box, if there is one.
    #[inline]
    pub fn intersect(&self, ray: &Ray, interval: Interval) -> Option<Interval> {
        let inverse = finite_inverse(ray.direction);
        let to_low = (self.low - ray.origin) * inverse;
        let to_high = (self.high - ray.origin) * inverse;
        let start_m = to_low.min(to_high).max_element().max(interval.start_m);
        let end_m = to_low.max(to_high).min_element().min(interval.end_m);
        (start_m <= end_m).then_some(Interval { start_m, end_m })
    }
}

/// Least magnitude of a component in [`finite_inverse`].
const MIN_COMPONENT: f32 = 1e-18;

/// The reciprocal of each component. Components near zero count as ±1e-18, so that no product is undefined.
///
/// A negative zero counts as positive, since `direction < 0`, which selects the near planes of boxes, is false for it.
#[inline]
pub(crate) fn finite_inverse(direction: Vec3A) -> Vec3A {
    direction.abs().max(Vec3A::splat(MIN_COMPONENT)).copysign(direction + Vec3A::ZERO).recip()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_parallel_to_an_axis_intersects_a_box() {
        let unit = Bounds { low: Vec3A::ZERO, high: Vec3A::ONE };
        let ahead = Interval { start_m: 0.0, end_m: f32::INFINITY };
        let ray = Ray::new(Vec3A::new(-2.0, 0.0, 0.5), Vec3A::X);
        let inside = unit.intersect(&ray, ahead).unwrap();
        assert!((inside.start_m - 2.0).abs() < 1e-6 && (inside.end_m - 3.0).abs() < 1e-6);
        assert!(unit.intersect(&ray, Interval { end_m: 1.9, ..ahead }).is_none());
        let beside = Ray::new(Vec3A::new(-2.0, 1.1, 0.5), Vec3A::X);
        assert!(unit.intersect(&beside, ahead).is_none());
    }
}
