//! Watertight ray-triangle intersection without double hits.
//!
//! After Woop, Benthin & Wald (2013, "Watertight ray/triangle intersection", Journal of Computer Graphics Techniques
//! 2(1), 65–82): the ray's dominant axis becomes z, and a shear maps its direction to (0, 0, 1). The ray hits the
//! triangle if the origin lies inside the projected triangle. Each vertex is sheared on its own, so that triangles
//! with a common edge share two sheared points. The edge functions are computed in double precision: the product of
//! two `f32` is exact, so that the sign of the difference is correct. A zero, where the ray hits an edge or vertex,
//! is resolved as if the ray passed at (ε, ε²) ("simulation of simplicity", Edelsbrunner & Mücke 1990,
//! doi:10.1145/77635.77639). Every line therefore crosses a closed surface an even number of times, which depths
//! through snow rely on.

use glam::{DVec3, Vec3};
use wide::f32x4;

use crate::ray::Ray;

/// A ray prepared for triangle tests.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ShearedRay {
    origin: Vec3,
    remainder: Vec3,
    axes: [usize; 3],
    shear: [f32; 2],
    direction: DVec3,
}

/// The crossing of a line with a triangle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TriangleHit {
    /// Distance along the ray, in m; negative behind the origin.
    pub(crate) distance_m: f64,
    /// Barycentric weights of the corners.
    pub(crate) weights: [f64; 3],
    /// Whether the line enters through the side from which the corners run counter-clockwise.
    pub(crate) is_entry: bool,
}

/// Up to four triangles that are tested together.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FourTriangles {
    /// Coordinates by corner and axis, with a lane for each triangle.
    corners: [[f32x4; 3]; 3],
    /// One bit for each lane in use.
    used: u32,
}

impl FourTriangles {
    /// Packs at most four triangles.
    pub(crate) fn new(triangles: impl Iterator<Item = [Vec3; 3]>) -> Self {
        let (mut corners, mut used) = ([[[0.0; 4]; 3]; 3], 0);
        for (place, triangle) in triangles.enumerate() {
            used |= 1 << place;
            for (corners, corner) in corners.iter_mut().zip(triangle) {
                corners.iter_mut().zip(corner.to_array()).for_each(|(four, at)| four[place] = at);
            }
        }
        Self { corners: corners.map(|corner| corner.map(f32x4::new)), used }
    }

    /// The corners of a triangle.
    #[inline]
    pub(crate) fn corners(&self, place: usize) -> [Vec3; 3] {
        let corner = |number: usize| {
            let [x, y, z] = &self.corners[number];
            Vec3::new(x.as_array()[place], y.as_array()[place], z.as_array()[place])
        };
        [corner(0), corner(1), corner(2)]
    }
}

impl ShearedRay {
    /// Chooses the axes and the shear.
    pub(crate) fn new(ray: &Ray) -> Self {
        let direction = Vec3::from(ray.direction);
        let size = direction.abs();
        let z = if size.x > size.y && size.x > size.z {
            0
        } else if size.y > size.z {
            1
        } else {
            2
        };
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        let along = direction[z];
        Self {
            origin: ray.origin.into(),
            remainder: ray.remainder.into(),
            axes: [x, y, z],
            shear: [direction[x] / along, direction[y] / along],
            direction: direction.as_dvec3(),
        }
    }

    /// The crossing of the ray's line with a triangle of either orientation. None if the rounded triangle is edge-on.
    #[inline]
    pub(crate) fn intersect(&self, corners: &[Vec3; 3]) -> Option<TriangleHit> {
        let [a, b, c] = corners;
        let (a, b, c) = (self.sheared(*a), self.sheared(*b), self.sheared(*c));
        let is_left = is_left_of(b, c);
        if is_left_of(c, a) != is_left || is_left_of(a, b) != is_left {
            return None;
        }
        // Three corners in one place have an edge function of 0 and pass the test wherever they are.
        if a.truncate() == b.truncate() && b.truncate() == c.truncate() {
            return None;
        }
        // The corners of a large triangle are far from the ray, where single precision is too coarse for the distance.
        let [a, b, c] = corners.map(|corner| self.exactly_sheared(corner));
        let areas = DVec3::new(area(b, c), area(c, a), area(a, b));
        let sum = areas.element_sum();
        // By rounding, the ray may pass beside the exact triangle, or see it edge-on.
        let weights = if sum == 0.0 { DVec3::ONE } else { (areas / sum).clamp(DVec3::ZERO, DVec3::ONE) };
        let weights = weights / weights.element_sum();
        let depth = weights.dot(DVec3::new(a.z, b.z, c.z));
        let along = self.direction[self.axes[2]];
        // The sheared axes are right-handed if the ray runs along the positive axis.
        let is_entry = is_left != (along > 0.0);
        Some(TriangleHit { distance_m: depth / along, weights: weights.to_array(), is_entry })
    }

    /// Culls four triangles: one bit for each that the line may cross.
    ///
    /// The result includes all triangles that [`intersect`](Self::intersect) accepts, and few further triangles. The
    /// error of an edge function in single precision is at most 2⁻²² times the greatest product in it. A triangle is
    /// culled if one edge function is positive and another is negative beyond that error.
    #[inline(always)]
    pub(crate) fn candidates(&self, four: &FourTriangles) -> u32 {
        let relative_error = f32x4::splat(4.0 * f32::EPSILON);
        let [x, y, z] = self.axes;
        let relative = |corner: usize, axis: usize| {
            four.corners[corner][axis] - f32x4::splat(self.origin[axis]) - f32x4::splat(self.remainder[axis])
        };
        let sheared = |corner: usize| {
            let along = relative(corner, z);
            let [shear_x, shear_y] = [f32x4::splat(self.shear[0]), f32x4::splat(self.shear[1])];
            [relative(corner, x) - shear_x * along, relative(corner, y) - shear_y * along]
        };
        let (a, b, c) = (sheared(0), sheared(1), sheared(2));
        let edge = |from: [f32x4; 2], to: [f32x4; 2]| from[0] * to[1] - from[1] * to[0];
        let (edge_a, edge_b, edge_c) = (edge(b, c), edge(c, a), edge(a, b));
        let greatest = |axis: usize| a[axis].abs().fast_max(b[axis].abs()).fast_max(c[axis].abs());
        let error = greatest(0) * greatest(1) * relative_error + f32x4::splat(f32::MIN_POSITIVE);
        let most = edge_a.fast_max(edge_b).fast_max(edge_c);
        let least = edge_a.fast_min(edge_b).fast_min(edge_c);
        let outside = most.simd_gt(error) & least.simd_lt(-error);
        four.used & !outside.to_bitmask()
    }

    #[inline(always)]
    fn sheared(&self, corner: Vec3) -> Vec3 {
        let relative = corner - self.origin - self.remainder;
        let [x, y, z] = self.axes;
        let along = relative[z];
        Vec3::new(relative[x] - self.shear[0] * along, relative[y] - self.shear[1] * along, along)
    }

    #[inline(always)]
    fn exactly_sheared(&self, corner: Vec3) -> DVec3 {
        let relative = corner.as_dvec3() - self.origin.as_dvec3() - self.remainder.as_dvec3();
        let [x, y, z] = self.axes;
        let along = relative[z] / self.direction[z];
        DVec3::new(relative[x] - self.direction[x] * along, relative[y] - self.direction[y] * along, relative[z])
    }
}

/// Twice the signed area of the triangle of an edge and the ray's position (0, 0).
#[inline(always)]
fn area(from: DVec3, to: DVec3) -> f64 {
    from.x * to.y - from.y * to.x
}

/// Whether the ray passes on the left of an edge, with ties resolved.
#[inline(always)]
fn is_left_of(from: Vec3, to: Vec3) -> bool {
    let area = area(from.as_dvec3(), to.as_dvec3());
    // If the area is zero, the sign of its derivative with the ray at (ε, ε²), in first and then second order.
    area > 0.0 || (area == 0.0 && (to.y < from.y || (to.y <= from.y && to.x > from.x)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3A;

    fn fan() -> [[Vec3; 3]; 4] {
        let centre = Vec3::new(0.25, 0.25, 0.0);
        let ring = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
        std::array::from_fn(|k| [centre, ring[k], ring[(k + 1) % 4]])
    }

    #[test]
    fn a_line_through_a_fan_crosses_exactly_one_triangle() {
        // Many of these dyadic points lie exactly on edges and on the shared vertex.
        for i in 1..16 {
            for j in 1..16 {
                let origin = Vec3A::new(i as f32 / 16.0, j as f32 / 16.0, 1.0);
                for direction in [Vec3A::NEG_Z, Vec3A::Z] {
                    let ray = ShearedRay::new(&Ray::new(origin, direction));
                    let hits: Vec<_> = fan().iter().filter_map(|corners| ray.intersect(corners)).collect();
                    assert_eq!(hits.len(), 1, "at {origin}");
                    assert!((hits[0].distance_m + f64::from(direction.z)).abs() < 1e-12);
                }
            }
        }
    }

    /// Lines through and beside edges and corners of triangles of several sizes.
    #[test]
    fn culling_keeps_all_crossed_triangles_and_few_others() {
        let number = |k: u32, salt: u32| {
            let bits = (k.wrapping_mul(0x9e37_79b9) ^ salt.wrapping_mul(0x85eb_ca6b)).wrapping_mul(0xc2b2_ae35);
            (bits >> 8) as f32 / (1u32 << 23) as f32 - 1.0
        };
        let point = |k: u32, salt: u32| Vec3::new(number(k, salt), number(k, salt + 1), number(k, salt + 2));
        let (mut crossed, mut kept, mut tested) = (0, 0, 0);
        for k in 0..20_000 {
            let size = [1.0, 1e-2, 1e-4][(k % 3) as usize];
            let triangles = [0, 100, 200, 300].map(|salt| {
                let corner = point(k, salt + 1);
                [corner, corner + point(k, salt + 11) * size, corner + point(k, salt + 21) * size]
            });
            let four = FourTriangles::new(triangles.into_iter());
            for (place, [a, b, c]) in triangles.iter().enumerate() {
                assert_eq!(four.corners(place), [*a, *b, *c]);
                let aim = [*a, a.lerp(*b, 0.3), (a + b + c) / 3.0, a.lerp(*b, 1.7)][(k / 3 % 4) as usize];
                let direction = (aim - 3.0 * point(k, 7)).normalize();
                let ray = ShearedRay::new(&Ray::new((aim - direction).into(), direction.into()));
                let candidates = ray.candidates(&four);
                for (other, triangle) in triangles.iter().enumerate() {
                    let hit = ray.intersect(triangle).is_some();
                    assert!(!hit || candidates >> other & 1 == 1, "line {k} at {place}, triangle {other}");
                    (crossed, kept, tested) = (crossed + u32::from(hit), kept + (candidates >> other & 1), tested + 1);
                }
            }
        }
        // A quarter of the 80,000 lines pass through the centre of a triangle, and half so near a corner or edge that
        // single precision cannot decide.
        assert!(crossed >= 20_000 && kept <= crossed + 40_000 && tested == 320_000, "{crossed} {kept}");
        let single_triangle = FourTriangles::new(fan().into_iter().take(1));
        let through = ShearedRay::new(&Ray::new(Vec3A::new(0.25, 0.1, 1.0), Vec3A::NEG_Z));
        assert_eq!(through.candidates(&single_triangle), 1, "unused lanes are culled");
    }

    #[test]
    fn lines_outside_and_edge_on_do_not_cross() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let miss = ShearedRay::new(&Ray::new(Vec3A::new(0.6, 0.6, 1.0), Vec3A::NEG_Z));
        assert!(miss.intersect(&corners).is_none());
        let edge_on = ShearedRay::new(&Ray::new(Vec3A::new(-1.0, 0.2, 0.0), Vec3A::X));
        assert!(edge_on.intersect(&corners).is_none());
    }

    /// A triangle of 1 m, a kilometre away and seen at a grazing angle: rounding decides whether rays along its edges
    /// hit it, but the hits lie on it.
    #[test]
    fn hits_of_distant_triangles_lie_within_them() {
        let corners = [Vec3::new(1000.0, 0.3, 0.0), Vec3::new(1001.0, 0.7, 0.02), Vec3::new(1000.3, -0.2, 0.01)];
        let mut hits = 0;
        for k in 0..2000 {
            let aim = corners[k % 3].lerp(corners[(k + 1) % 3], k as f32 / 2000.0);
            let direction = Vec3A::from(aim).normalize();
            let Some(hit) = ShearedRay::new(&Ray::new(Vec3A::ZERO, direction)).intersect(&corners) else { continue };
            hits += 1;
            let sum: f64 = hit.weights.iter().sum();
            assert!((sum - 1.0).abs() < 1e-12, "{:?}", hit.weights);
            assert!((999.9..1001.1).contains(&hit.distance_m), "{}", hit.distance_m);
        }
        assert!(hits > 500, "{hits}");
    }

    #[test]
    fn barycentric_weights_and_distance_are_correct() {
        let corners = [Vec3::new(0.0, 0.0, 2.0), Vec3::new(1.0, 0.0, 3.0), Vec3::new(0.0, 1.0, 1.0)];
        let ray = Ray::new(Vec3A::new(0.3, 0.1, 0.0), Vec3A::new(0.0, 0.0, 1.0));
        let hit = ShearedRay::new(&ray).intersect(&corners).unwrap();
        // The plane is z = 2 + x − y.
        assert!((hit.distance_m - 2.2).abs() < 1e-6);
        assert!((hit.weights[0] - 0.6).abs() < 1e-6 && (hit.weights[1] - 0.3).abs() < 1e-6);
    }
}
