//! Where in a texture a point of a surface lies.

use glam::{Vec2, Vec3A};

/// Where on a shape's surface a point lies, for textures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TextureCoordinates {
    /// In pictures: (0, 0) is the lower left corner of one, (1, 1) the upper right.
    Pictures(Vec2),
    /// In metres from the middle of a face, to the right and upwards.
    Metres(Vec2),
}

impl TextureCoordinates {
    /// The place of a point on a box about the origin, whose normal is that of the side that is seen.
    pub(crate) fn on_box(own: Vec3A, normal: Vec3A) -> Self {
        let steep = normal.abs();
        Self::Metres(if steep.z >= steep.x.max(steep.y) {
            Vec2::new(own.x * normal.z.signum(), own.y)
        } else if steep.x > steep.y {
            Vec2::new(own.y * normal.x.signum(), own.z)
        } else {
            Vec2::new(-own.x * normal.y.signum(), own.z)
        })
    }

    /// The place of a point on the unit sphere.
    pub(crate) fn on_sphere(own: Vec3A) -> Self {
        use std::f32::consts::{PI, TAU};
        Self::Pictures(Vec2::new(0.5 + own.x.atan2(-own.y) / TAU, 0.5 + own.z.clamp(-1.0, 1.0).asin() / PI))
    }
}
