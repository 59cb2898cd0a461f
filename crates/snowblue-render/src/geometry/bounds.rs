//! Axis-parallel boxes around things, and the part of a ray inside one.

use glam::{Vec3, Vec3A};

use crate::geometry::ray::Ray;

/// An axis-parallel box, in m.
#[derive(Debug, Clone, Copy)]
pub struct Bounds {
    /// The corner of least coordinates.
    pub low: Vec3A,
    /// The corner of greatest coordinates.
    pub high: Vec3A,
}

impl Bounds {
    /// The least box around points; around none it is inside out.
    pub fn of(points: impl Iterator<Item = Vec3>) -> Self {
        let mut bounds = Self { low: Vec3A::INFINITY, high: Vec3A::NEG_INFINITY };
        for point in points {
            bounds.low = bounds.low.min(point.into());
            bounds.high = bounds.high.max(point.into());
        }
        bounds
    }

    /// The box with every side moved outwards.
    pub fn padded(self, padding_m: f32) -> Self {
        Self { low: self.low - padding_m, high: self.high + padding_m }
    }

    /// Its eight corners.
    pub fn corners(&self) -> [Vec3A; 8] {
        let side = |bits: usize, axis: usize| if bits >> axis & 1 == 0 { self.low[axis] } else { self.high[axis] };
        std::array::from_fn(|bits| Vec3A::new(side(bits, 0), side(bits, 1), side(bits, 2)))
    }

    /// The length of its diagonal, in m.
    pub fn diagonal_m(&self) -> f32 {
        (self.high - self.low).length()
    }

    /// The magnitude of the greatest coordinate in it, in m: rounding errors go with it.
    pub fn greatest_coordinate(&self) -> f32 {
        self.low.abs().max(self.high.abs()).max_element()
    }

    /// Where a ray enters and leaves the box between `from_m` and `to_m`, in m along it.
    #[inline]
    pub fn span(&self, ray: &Ray, from_m: f32, to_m: f32) -> Option<(f32, f32)> {
        let inverse = finite_inverse(ray.direction);
        let to_low = (self.low - ray.origin) * inverse;
        let to_high = (self.high - ray.origin) * inverse;
        let enter = to_low.min(to_high).max_element().max(from_m);
        let leave = to_low.max(to_high).min_element().min(to_m);
        (enter <= leave).then_some((enter, leave))
    }
}

/// Components nearer to zero than this count as this far from it in [`finite_inverse`].
const LEAST_COMPONENT: f32 = 1e-18;

/// One over each component, and a huge number of the same sign for zero, so that no product is undefined.
///
/// A negative zero counts as a positive one: the hierarchy tells near from far sides by `direction < 0`, which it is not.
#[inline]
pub(crate) fn finite_inverse(direction: Vec3A) -> Vec3A {
    direction.abs().max(Vec3A::splat(LEAST_COMPONENT)).copysign(direction + Vec3A::ZERO).recip()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_parallel_to_an_axis_has_its_span() {
        let unit = Bounds { low: Vec3A::ZERO, high: Vec3A::ONE };
        let ray = Ray { origin: Vec3A::new(-2.0, 0.0, 0.5), direction: Vec3A::X };
        let (enter, leave) = unit.span(&ray, 0.0, f32::INFINITY).unwrap();
        assert!((enter - 2.0).abs() < 1e-6 && (leave - 3.0).abs() < 1e-6);
        assert!(unit.span(&ray, 0.0, 1.9).is_none());
        let beside = Ray { origin: Vec3A::new(-2.0, 1.1, 0.5), direction: Vec3A::X };
        assert!(unit.span(&beside, 0.0, f32::INFINITY).is_none());
    }
}
