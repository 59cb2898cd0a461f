//! Rays, hits and crossings, and the offset of secondary rays from their surface.

use glam::Vec3A;
use wide::bytemuck::cast;
use wide::{f32x4, i32x4};

/// A ray: an origin and a unit direction.
///
/// A kilometre from the coordinate origin, single precision resolves 0.06 mm, which is not small beside the distance
/// between two grains of snow. A ray that moves by [`advance`](Self::advance) therefore also keeps the remainder of its
/// origin that the rounded coordinates lack, and queries of shapes use both.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    /// Origin, in m.
    pub origin: Vec3A,
    /// Unit direction.
    pub direction: Vec3A,
    /// The exact origin less `origin`, in m: at most some units in the last place of the coordinates.
    pub(crate) remainder: Vec3A,
}

impl Ray {
    /// A ray.
    #[inline]
    pub fn new(origin: Vec3A, direction: Vec3A) -> Self {
        Self { origin, direction, remainder: Vec3A::ZERO }
    }

    /// A ray in another direction from the exact origin of this ray.
    #[inline]
    pub fn towards(&self, direction: Vec3A) -> Self {
        Self { direction, ..*self }
    }

    /// The vector from the exact origin of another ray to the exact origin of this ray, in m.
    #[inline]
    pub fn offset_from(&self, other: &Self) -> Vec3A {
        (self.origin - other.origin) + (self.remainder - other.remainder)
    }

    /// The point `distance_m` along the ray.
    #[inline]
    pub fn at(&self, distance_m: f32) -> Vec3A {
        self.origin + self.direction * distance_m
    }

    /// Moves the origin along the ray, without the error of rounded coordinates (sum with its error, Knuth 1997, *The
    /// Art of Computer Programming*, volume 2, section 4.2.2).
    #[inline]
    pub fn advance(&mut self, distance_m: f32) {
        let step = self.direction * distance_m + self.remainder;
        let sum = self.origin + step;
        let added = sum - self.origin;
        self.remainder = (self.origin - (sum - added)) + (step - added);
        self.origin = sum;
    }
}

/// A surface point with its normal.
#[derive(Debug, Clone, Copy)]
pub struct SurfacePoint {
    /// The point, in m.
    pub point: Vec3A,
    /// Unit normal of the side in question.
    pub normal: Vec3A,
}

/// A hit on a shape's surface.
#[derive(Debug, Clone, Copy)]
pub struct ShapeHit {
    /// Distance along the ray, in m.
    pub distance_m: f32,
    /// The point on the surface.
    pub point: Vec3A,
    /// Unit normal, on either side.
    pub normal: Vec3A,
    /// The location on the mesh, if the shape is one.
    pub location: MeshLocation,
}

/// A location on a mesh. It has no meaning on other shapes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MeshLocation {
    /// Index of the triangle.
    pub triangle: u32,
    /// Barycentric weights of the triangle's corners.
    pub weights: [f32; 3],
}

impl ShapeHit {
    /// A hit on a shape without triangles.
    pub(crate) fn plain(distance_m: f32, point: Vec3A, normal: Vec3A) -> Self {
        Self { distance_m, point, normal, location: MeshLocation::default() }
    }
}

/// A crossing of a line with a surface.
#[derive(Debug, Clone, Copy)]
pub struct Crossing {
    /// Distance along the line from the ray's origin, in m; negative behind it.
    pub distance_m: f32,
    /// Normal, on either side and of any length.
    pub normal: Vec3A,
    /// Index of the object whose surface it is; 0 for a shape outside a scene.
    pub object: u32,
    /// Whether the line passes from the outer side of the surface to its inner side, by the orientation of the surface.
    pub is_entry: bool,
}

impl Crossing {
    /// A crossing with object 0.
    pub(crate) fn new(distance_m: f32, normal: Vec3A, is_entry: bool) -> Self {
        Self { distance_m, normal, object: 0, is_entry }
    }
}

/// Moves a surface point off its surface towards `normal`, so that a ray from the moved point does not hit this
/// surface again.
///
/// A computed hit point lies a few rounding errors above or below its surface. Wächter & Binder (2019, "A fast and
/// robust method for avoiding self-intersection", Ray Tracing Gems, chapter 6, doi:10.1007/978-1-4842-4427-2_6) move
/// each coordinate by up to 256 units in its last place along the normal: 15 µm for coordinates of about 1 m. Within
/// 1/32 m of the coordinate origin, where such units become tiny, the offset is 1/65536 m · n, again 15 µm.
///
/// A wide mesh near the coordinate origin has greater rounding errors than the coordinates of the point suggest.
/// Another 2⁻²⁰ of `reach_m`, the greatest coordinate of the whole surface in m, covers these: 0.5 mm for a field 1 km
/// across.
pub fn off_surface(point: Vec3A, normal: Vec3A, reach_m: f32) -> Vec3A {
    let [point, normal] =
        [point + normal * (REACH_FRACTION * reach_m), normal].map(|vector| f32x4::from(vector.extend(0.0).to_array()));
    let [x, y, z, _] = offset(point, normal).to_array();
    Vec3A::new(x, y, z)
}

/// Offset of surface points as a fraction of the surface's greatest coordinate.
const REACH_FRACTION: f32 = 1.0 / (1 << 20) as f32;

/// Offsets each coordinate along the normal.
#[inline]
fn offset(coordinate: f32x4, normal: f32x4) -> f32x4 {
    const NEAR_ORIGIN_M: f32x4 = f32x4::splat(1.0 / 32.0);
    const NEAR_STEP_M: f32x4 = f32x4::splat(1.0 / 65536.0);
    const STEP_ULP: f32x4 = f32x4::splat(256.0);
    let even = coordinate + NEAR_STEP_M * normal;
    let ulps = (STEP_ULP * normal).fast_trunc_int();
    // The bits of a float, as an integer, increase with its magnitude on both sides of zero. Where the coordinate is
    // negative, `below` is −1 and (ulps ^ −1) − (−1) = −ulps.
    let below: i32x4 = cast(coordinate.simd_lt(f32x4::ZERO));
    let moved: f32x4 = cast(cast::<_, i32x4>(coordinate) + ((ulps ^ below) - below));
    coordinate.abs().simd_lt(NEAR_ORIGIN_M).bitselect(even, moved)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A thousand steps of a tenth of a millimetre far from the coordinate origin end where their sum says.
    #[test]
    fn steps_that_single_precision_does_not_resolve_add_up() {
        let direction = Vec3A::new(0.6, 0.0, -0.8);
        let mut ray = Ray::new(Vec3A::new(54_300.0, -1234.5, 2000.0), direction);
        let start = ray;
        let mut rounded = start;
        for _ in 0..1000 {
            ray.advance(1e-4);
            rounded = Ray::new(rounded.at(1e-4), direction);
        }
        let expected = direction * 0.1;
        assert!(ray.offset_from(&start).distance(expected) < 2e-6, "{}", ray.offset_from(&start));
        assert!(rounded.offset_from(&start).distance(expected) > 0.01, "{}", rounded.offset_from(&start));
    }

    #[test]
    fn the_offset_points_along_the_normal_and_is_some_micrometres() {
        for point in [Vec3A::new(1.0, -1.5, 0.01), Vec3A::new(-0.7, 0.0, 3.0)] {
            for normal in [Vec3A::X, Vec3A::NEG_Y, Vec3A::Z, Vec3A::new(0.6, 0.0, -0.8)] {
                let step = off_surface(point, normal, 3.0) - point;
                assert!(step.dot(normal) > 5e-6, "{step}");
                assert!(step.length() < 1e-4, "{step}");
            }
        }
    }
}
