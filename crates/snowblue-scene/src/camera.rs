//! A pinhole camera.

use glam::Vec3A;

use snowblue_geometry::ray::Ray;

/// A pinhole camera: all distances are in focus.
#[derive(Debug, Clone, Copy)]
pub struct PinholeCamera {
    position: Vec3A,
    forward: Vec3A,
    /// From the middle of the image plane at distance 1 to its right edge, and to its upper edge.
    right: Vec3A,
    up: Vec3A,
}

/// Position and orientation of a camera.
#[derive(Debug, Clone, Copy)]
pub struct View {
    /// Position, in m.
    pub position: Vec3A,
    /// The point at the centre of the image, in m.
    pub look_at: Vec3A,
    /// The direction that is up in the image, of any length.
    pub up: Vec3A,
    /// Angle between the upper and the lower edge of the image, in degrees.
    pub vertical_fov_deg: f32,
}

impl PinholeCamera {
    /// A camera for images of a width-to-height ratio. None if `look_at` is the position or along the up direction.
    pub fn new(view: &View, aspect: f32) -> Option<Self> {
        let forward = (view.look_at - view.position).try_normalize()?;
        let right = forward.cross(view.up.try_normalize()?);
        let right = (right.length() > 1e-6).then(|| right.normalize())?;
        let half_height = (0.5 * view.vertical_fov_deg.to_radians()).tan();
        Some(Self {
            position: view.position,
            forward,
            right: right * (half_height * aspect),
            up: right.cross(forward) * half_height,
        })
    }

    /// Position, in m.
    pub fn position(&self) -> Vec3A {
        self.position
    }

    /// The ray through a point of the image: (0, 0) is the upper left corner and (1, 1) the lower right.
    #[inline]
    pub fn ray(&self, across: f32, down: f32) -> Ray {
        let direction = self.forward + self.right * (2.0 * across - 1.0) + self.up * (1.0 - 2.0 * down);
        Ray { origin: self.position, direction: direction / direction.length() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIEW: View = View { position: Vec3A::NEG_Y, look_at: Vec3A::ZERO, up: Vec3A::Z, vertical_fov_deg: 90.0 };

    #[test]
    fn the_image_is_upright_and_not_mirrored() {
        let camera = PinholeCamera::new(&VIEW, 2.0).unwrap();
        assert!((camera.ray(0.5, 0.5).direction - Vec3A::Y).length() < 1e-6);
        let top_right = camera.ray(1.0, 0.0).direction;
        assert!((top_right - Vec3A::new(2.0, 1.0, 1.0).normalize()).length() < 1e-6);
    }

    #[test]
    fn a_view_along_up_or_without_a_direction_is_refused() {
        assert!(PinholeCamera::new(&View { up: Vec3A::NEG_Y, ..VIEW }, 1.0).is_none());
        assert!(PinholeCamera::new(&View { look_at: Vec3A::NEG_Y, ..VIEW }, 1.0).is_none());
    }
}
