//! Four samples side by side, one in each lane of a register: vectors, rays and places.
//!
//! What is done in a lane rests on nothing in the others. Lanes that hold nothing go along, and what comes of them is not looked
//! at: which count is told by bits.

use std::iter;
use std::ops::{Add, Div, Mul, Neg, Sub};

use glam::{Mat3A, Vec3A};
use wide::{f32x4, i32x4};

use crate::geometry::bounds::LEAST_COMPONENT;
use crate::geometry::ray::Ray;

/// Numbers in a register.
pub(crate) const LANES: usize = 4;

/// Some of the lanes, as bits.
pub(crate) type LaneMask = u32;

/// A vector in each lane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Vec3x4 {
    pub(crate) x: f32x4,
    pub(crate) y: f32x4,
    pub(crate) z: f32x4,
}

/// A ray in each lane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RayPacket4 {
    /// Where they start, in m.
    pub(crate) origin: Vec3x4,
    /// Where they go, unit vectors.
    pub(crate) direction: Vec3x4,
    /// One over each component of the directions, as by [`finite_inverse`](crate::geometry::bounds::finite_inverse).
    pub(crate) inverse: Vec3x4,
}

/// A surface point with its normal in each lane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SurfacePoints4 {
    /// The points.
    pub(crate) point: Vec3x4,
    /// Unit normals.
    pub(crate) normal: Vec3x4,
}

/// Where rays meet a shape first.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hits {
    /// A mask of the lanes that meet it; in others the rest means nothing.
    pub(crate) met: f32x4,
    /// Distances along the rays, in m.
    pub(crate) distance_m: f32x4,
    /// The points, and normals of either sense.
    pub(crate) places: SurfacePoints4,
}

impl Vec3x4 {
    pub(crate) const ZERO: Self = Self { x: f32x4::ZERO, y: f32x4::ZERO, z: f32x4::ZERO };

    /// The same in all lanes.
    #[inline]
    pub(crate) fn splat(vector: Vec3A) -> Self {
        Self { x: f32x4::splat(vector.x), y: f32x4::splat(vector.y), z: f32x4::splat(vector.z) }
    }

    /// That of one lane.
    #[inline]
    pub(crate) fn lane(&self, lane: usize) -> Vec3A {
        Vec3A::new(self.x.as_array()[lane], self.y.as_array()[lane], self.z.as_array()[lane])
    }

    /// Puts one into a lane.
    #[inline]
    pub(crate) fn set(&mut self, lane: usize, vector: Vec3A) {
        for (four, value) in [&mut self.x, &mut self.y, &mut self.z].into_iter().zip(vector.to_array()) {
            four.as_mut_array()[lane] = value;
        }
    }

    /// Each component by itself.
    #[inline]
    pub(crate) fn map(self, f: impl Fn(f32x4) -> f32x4) -> Self {
        Self { x: f(self.x), y: f(self.y), z: f(self.z) }
    }

    /// Each pair of components by itself.
    #[inline]
    pub(crate) fn zip(self, other: Self, f: impl Fn(f32x4, f32x4) -> f32x4) -> Self {
        Self { x: f(self.x, other.x), y: f(self.y, other.y), z: f(self.z, other.z) }
    }

    #[inline]
    pub(crate) fn dot(self, other: Self) -> f32x4 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline]
    pub(crate) fn length(self) -> f32x4 {
        self.dot(self).sqrt()
    }

    /// Of unit length.
    #[inline]
    pub(crate) fn normalized(self) -> Self {
        self / self.length()
    }

    /// The greatest of the components.
    #[inline]
    pub(crate) fn greatest(self) -> f32x4 {
        self.x.fast_max(self.y).fast_max(self.z)
    }

    /// The least of the components.
    #[inline]
    pub(crate) fn least(self) -> f32x4 {
        self.x.fast_min(self.y).fast_min(self.z)
    }

    /// Those of one where a mask has ones, and of the other where it has zeros.
    #[inline]
    pub(crate) fn select(mask: f32x4, one: Self, other: Self) -> Self {
        one.zip(other, |one, other| mask.bitselect(one, other))
    }

    /// The same with a mask for each component.
    #[inline]
    pub(crate) fn choose(self, one: Self, other: Self) -> Self {
        Self {
            x: self.x.bitselect(one.x, other.x),
            y: self.y.bitselect(one.y, other.y),
            z: self.z.bitselect(one.z, other.z),
        }
    }

    /// Each times a matrix.
    #[inline]
    pub(crate) fn turned(self, matrix: &Mat3A) -> Self {
        let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(Self::splat);
        x * self.x + y * self.y + z * self.z
    }

    /// Negatives where a mask has ones.
    #[inline]
    pub(crate) fn negated_where(self, mask: f32x4) -> Self {
        let sign = mask & f32x4::splat(-0.0);
        self.map(|component| component ^ sign)
    }
}

impl Add for Vec3x4 {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        self.zip(other, |one, other| one + other)
    }
}

impl Sub for Vec3x4 {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |one, other| one - other)
    }
}

/// Component by component.
impl Mul for Vec3x4 {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |one, other| one * other)
    }
}

impl Mul<f32x4> for Vec3x4 {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f32x4) -> Self {
        self.map(|component| component * factor)
    }
}

impl Div<f32x4> for Vec3x4 {
    type Output = Self;
    #[inline]
    fn div(self, divisor: f32x4) -> Self {
        self.map(|component| component / divisor)
    }
}

impl Neg for Vec3x4 {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        self.map(|component| -component)
    }
}

impl SurfacePoints4 {
    pub(crate) const NONE: Self = Self { point: Vec3x4::ZERO, normal: Vec3x4::ZERO };

    /// Those of one where a mask has ones, and of the other where it has zeros.
    #[inline]
    pub(crate) fn select(mask: f32x4, one: &Self, other: &Self) -> Self {
        Self {
            point: Vec3x4::select(mask, one.point, other.point),
            normal: Vec3x4::select(mask, one.normal, other.normal),
        }
    }
}

impl RayPacket4 {
    /// Rays from some points in unit directions.
    #[inline]
    pub(crate) fn new(origin: Vec3x4, direction: Vec3x4) -> Self {
        let least = f32x4::splat(LEAST_COMPONENT);
        let finite = |one: f32x4| copysign(one.abs().fast_max(least), one + f32x4::ZERO);
        Self { origin, direction, inverse: direction.map(|one| f32x4::ONE / finite(one)) }
    }

    /// The points at distances along the rays.
    #[inline]
    pub(crate) fn at(&self, distance_m: f32x4) -> Vec3x4 {
        self.origin + self.direction * distance_m
    }

    /// That of one lane.
    #[inline]
    pub(crate) fn lane(&self, lane: usize) -> Ray {
        Ray { origin: self.origin.lane(lane), direction: self.direction.lane(lane) }
    }
}

/// The magnitudes of the first, with the signs of the second.
#[inline]
pub(crate) fn copysign(magnitude: f32x4, sign: f32x4) -> f32x4 {
    magnitude.abs() | (sign & f32x4::splat(-0.0))
}

/// The first lanes, as many as there is use for.
#[inline]
pub(crate) fn first_lanes(count: u32) -> LaneMask {
    const ALL: LaneMask = (1 << LANES) - 1;
    ALL & !LaneMask::MAX.unbounded_shl(count)
}

/// The lanes of some bits, one after the other.
#[inline]
pub(crate) fn lanes(mut which: LaneMask) -> impl Iterator<Item = usize> {
    iter::from_fn(move || {
        let lane = (which != 0).then(|| which.trailing_zeros() as usize);
        which &= which.wrapping_sub(1);
        lane
    })
}

/// Those of some lanes of which something holds.
#[inline]
pub(crate) fn lanes_where(which: LaneMask, holds: impl Fn(usize) -> bool) -> LaneMask {
    lanes(which).fold(0, |bits, lane| bits | LaneMask::from(holds(lane)) << lane)
}

/// Lanes that have the same object together, group by group.
#[inline]
pub(crate) fn groups(mut which: LaneMask, objects: i32x4) -> impl Iterator<Item = (usize, LaneMask)> {
    iter::from_fn(move || {
        let object = objects.as_array()[lanes(which).next()?];
        let group = which & objects.simd_eq(i32x4::splat(object)).to_bitmask();
        which &= !group;
        Some((object.cast_unsigned() as usize, group))
    })
}

/// The index of an object as it stands in a lane.
#[inline]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    reason = "a scene in memory has fewer than 2^31 objects"
)]
pub(crate) fn in_lane(object: usize) -> i32 {
    object as i32
}
