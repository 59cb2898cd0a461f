//! Texture coordinates of points on shapes.

use glam::{Vec2, Vec3A};

/// Texture coordinates of a surface point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TextureCoordinates {
    /// Relative to an image: (0, 0) is its lower left corner, (1, 1) the upper right.
    Image(Vec2),
    /// In metres from the centre of a face, to the right and upwards.
    Metres(Vec2),
}

impl TextureCoordinates {
    /// The coordinates of a point on a box around the origin, with the outward normal.
    pub fn on_box(point: Vec3A, normal: Vec3A) -> Self {
        let size = normal.abs();
        Self::Metres(if size.z >= size.x.max(size.y) {
            Vec2::new(point.x * normal.z.signum(), point.y)
        } else if size.x > size.y {
            Vec2::new(point.y * normal.x.signum(), point.z)
        } else {
            Vec2::new(-point.x * normal.y.signum(), point.z)
        })
    }

    /// The coordinates of a point on the unit sphere.
    pub fn on_sphere(point: Vec3A) -> Self {
        use std::f32::consts::{PI, TAU};
        Self::Image(Vec2::new(0.5 + point.x.atan2(-point.y) / TAU, 0.5 + point.z.clamp(-1.0, 1.0).asin() / PI))
    }
}
