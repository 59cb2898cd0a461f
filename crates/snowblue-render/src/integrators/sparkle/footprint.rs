//! The part of a surface that a camera sample sees: an ellipse in which all facets have equal weight.
//!
//! A pixel of the image is a parallelogram on the plane that is tangent to the surface. Samples lie evenly in their
//! pixel. Each sample sees an ellipse around itself with the area of the pixel. So a pixel sees the surface within
//! some 1.1 pixels of its middle, as through a filter that keeps the sum.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3A;

/// An ellipse on a plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Footprint {
    /// Its conjugate semi-axes, in m.
    semi_axes: [Vec3A; 2],
    /// Its area, in m².
    pub(super) area_m2: f32,
}

/// The footprint projected along a coordinate axis: an ellipse in the plane of the other two axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct FlatFootprint {
    /// Matrix from the plane to the unit disc, by rows.
    to_disc: [[f32; 2]; 2],
    /// Half of its greatest width along each axis of the plane, in m.
    pub(super) half_width_m: [f32; 2],
    /// Shift of the middle of a row of the ellipse per m along the second axis, and half of the width of the middle
    /// row, in m.
    pub(super) shear: f32,
    pub(super) half_row_m: f32,
}

impl Footprint {
    /// The footprint on a plane with a unit normal, at a distance along a ray, for changes of the ray's direction
    /// from pixel to pixel. None where the ray grazes the plane.
    pub(super) fn new(direction: Vec3A, distance_m: f32, changes: [Vec3A; 2], normal: Vec3A) -> Option<Self> {
        let along_normal = direction.dot(normal);
        // A disc of radius 1/√π has the area of a square of side 1.
        let radius = FRAC_1_PI.sqrt();
        let on_plane = |change: Vec3A| (change - direction * (change.dot(normal) / along_normal)) * distance_m;
        let semi_axes = changes.map(|change| on_plane(change) * radius);
        Self::of(semi_axes)
    }

    fn of(semi_axes: [Vec3A; 2]) -> Option<Self> {
        let area_m2 = semi_axes[0].cross(semi_axes[1]).length() / FRAC_1_PI;
        (area_m2 > 0.0 && area_m2.is_finite()).then_some(Self { semi_axes, area_m2 })
    }

    /// The footprint enlarged for facets of a diameter: it is no smaller than one facet.
    pub(super) fn around_facets(self, diameter_m: f32) -> Option<Self> {
        let grown = |axis: Vec3A| axis * (1.0 + 0.25 * diameter_m * diameter_m / axis.length_squared()).sqrt();
        Self::of(self.semi_axes.map(grown))
    }

    /// The ellipse, shrunk to a share of its area.
    pub(super) fn shrunk(self, share: f32) -> Self {
        Self { semi_axes: self.semi_axes.map(|axis| axis * share.sqrt()), area_m2: self.area_m2 * share }
    }

    /// The greatest distance of a point from the middle, in m, or a little more.
    pub(super) fn reach_m(&self) -> f32 {
        let [a, b] = self.semi_axes.map(Vec3A::length_squared);
        (a + b).sqrt()
    }

    /// The greatest distance of a point from the middle as seen from a direction, in m, or a little more.
    pub(super) fn reach_across_m(&self, direction: Vec3A) -> f32 {
        let [a, b] = self.semi_axes.map(|axis| axis.cross(direction).length_squared());
        (a + b).sqrt()
    }

    /// The image of a point of the unit disc, relative to the middle of the footprint, in m.
    #[inline]
    pub(super) fn offset(&self, [x, y]: [f32; 2]) -> Vec3A {
        self.semi_axes[0] * x + self.semi_axes[1] * y
    }

    /// The footprint projected along a coordinate axis, which must not lie in the plane.
    pub(super) fn flat(&self, axis: usize) -> Option<FlatFootprint> {
        let [first, second] = other_axes(axis);
        let [a, b] = self.semi_axes;
        let (ax, ay, bx, by) = (a[first], a[second], b[first], b[second]);
        let determinant = ax * by - bx * ay;
        let square = ay * ay + by * by;
        let half_width_m = [(ax * ax + bx * bx).sqrt(), square.sqrt()];
        (determinant.abs() > 0.0 && square > 0.0).then(|| FlatFootprint {
            to_disc: [[by / determinant, -bx / determinant], [-ay / determinant, ax / determinant]],
            half_width_m,
            shear: (ax * ay + bx * by) / square,
            half_row_m: determinant.abs() / square.sqrt(),
        })
    }
}

impl FlatFootprint {
    /// The point of the unit disc whose image is a point of the plane.
    #[inline]
    pub(super) fn on_disc(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        self.to_disc.map(|[by_x, by_y]| by_x * x + by_y * y)
    }
}

/// The other two axes, in cyclic order.
#[inline]
pub(super) fn other_axes(axis: usize) -> [usize; 2] {
    [(axis + 1) % 3, (axis + 2) % 3]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_footprint_has_the_area_of_a_pixel() {
        // A pixel of 1 mrad seen from 2 m at 60° from the normal: 2 mm by 4 mm.
        let direction = Vec3A::new(0.75_f32.sqrt(), 0.0, -0.5);
        let changes = [Vec3A::Y * 1e-3, Vec3A::new(0.5, 0.0, 0.75_f32.sqrt()) * 1e-3];
        let footprint = Footprint::new(direction, 2.0, changes, Vec3A::Z).unwrap();
        assert!((footprint.area_m2 / 8e-6 - 1.0).abs() < 1e-4, "{}", footprint.area_m2);
        assert!((footprint.shrunk(0.25).area_m2 / 2e-6 - 1.0).abs() < 1e-4);
        let of_facets = footprint.around_facets(0.1).unwrap();
        // A disc of the facet's diameter, a little larger.
        assert!((of_facets.area_m2 / (0.25 * 0.01 / FRAC_1_PI) - 1.0).abs() < 2e-3);
        assert!(Footprint::new(Vec3A::X, 1.0, changes, Vec3A::Z).is_none());
    }

    #[test]
    fn flat_footprints_hold_the_points_of_the_ellipse() {
        let changes = [Vec3A::new(0.1, 1.0, 0.3) * 1e-3, Vec3A::new(0.5, 0.2, 0.7) * 1e-3];
        let normal = Vec3A::new(0.4, -0.3, 0.8).normalize();
        let footprint = Footprint::new(Vec3A::new(0.6, 0.0, -0.8), 3.0, changes, normal).unwrap();
        for axis in 0..3 {
            let flat = footprint.flat(axis).unwrap();
            let [first, second] = other_axes(axis);
            let mut widest = [0.0_f32; 2];
            for step in 0..64_u16 {
                let (y, x) = (f32::from(step) / 64.0 * std::f32::consts::TAU).sin_cos();
                let point = footprint.offset([x, y]);
                let flattened = [point[first], point[second]];
                let back = flat.on_disc(flattened);
                assert!((back[0] - x).abs() + (back[1] - y).abs() < 1e-4);
                let aside = (flattened[0] - flat.shear * flattened[1]).abs();
                assert!(aside < flat.half_row_m * 1.0001);
                widest = [0, 1].map(|k| widest[k].max(flattened[k].abs()));
            }
            for (found, width) in widest.into_iter().zip(flat.half_width_m) {
                assert!(found <= width * 1.0001 && found > width * 0.99, "{found} {width}");
            }
        }
    }
}
