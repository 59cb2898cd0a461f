//! One grain: which way light leaves it, and how far it went through the ice.
//!
//! Light meets a grain, is reflected or enters, crosses the ice in straight segments between interfaces, and leaves.
//! Grains that are nearly smooth keep some light inside for long: below a roughness of about .025 the ice paths are
//! heavy-tailed, and their mean steps from the smooth grain's to n² times the mean chord as the roughness leaves 0.
//! Only a facetness of 0 is smooth.
//!
//! The grain does not turn its size into anything: directions depend on shape, roughness and index alone, and the ice
//! path is proportional to the size.

use super::microsurface::{Outcome, interact};
use super::spheroid::{Frame, Hit, Spheroid};
use crate::rng::Stream;

/// Roughness α of the microsurface per unit of facetness: α = .25 f. It puts f = .5 at the asymmetry of natural snow.
pub const ROUGHNESS_PER_FACETNESS: f64 = 0.25;

/// What a grain is to light, size apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grain {
    /// Its shape, in units of its size.
    pub shape: Spheroid,
    /// Roughness α of its surface.
    pub roughness: f64,
    /// Refractive index of the ice over that of what surrounds it.
    pub relative_index: f64,
}

/// Light that has left a grain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scattered {
    /// Cosine of the scattering angle.
    pub cos_scattering: f64,
    /// Path through the ice, over the grain's size.
    pub ice_path: f64,
}

impl Grain {
    /// Scatters one ray of isotropic light off the grain.
    ///
    /// ```
    /// # use snowblue_transport::{grain::{Grain, SizeMeasure, Spheroid}, rng::Stream};
    /// // Grains that do not refract pass light straight on.
    /// let shape = Spheroid::of_unit_size(0.8, SizeMeasure::GreatestExtension);
    /// let grain = Grain { shape, roughness: 0.1, relative_index: 1.0 };
    /// let scattered = grain.scatter(&mut Stream::new(1, 0));
    /// assert!((scattered.cos_scattering - 1.0).abs() < 1e-12);
    /// ```
    #[inline]
    pub fn scatter(&self, stream: &mut Stream) -> Scattered {
        self.scatter_hit(self.shape.random_hit(stream), stream)
    }

    /// Follows a ray from where it meets the grain until it leaves.
    pub(crate) fn scatter_hit(&self, entry: Hit, stream: &mut Stream) -> Scattered {
        let (mut inside, mut hit) = (false, entry);
        let mut ice_path = 0.0;
        loop {
            let outward = self.shape.normal(hit.point);
            let (near_side, relative_index) =
                if inside { (-outward, 1.0 / self.relative_index) } else { (outward, self.relative_index) };
            let frame = Frame::around(near_side);
            let Outcome { direction, transmitted } =
                interact(frame.to_local(hit.direction), self.roughness, relative_index, stream);
            let direction = frame.to_world(direction);
            inside ^= transmitted;
            if !inside {
                let cos_scattering = direction.dot(entry.direction).clamp(-1.0, 1.0);
                return Scattered { cos_scattering, ice_path };
            }
            let (length, end) = self.shape.cross(Hit { point: hit.point, direction });
            ice_path += length;
            hit = Hit { point: end, direction };
        }
    }
}
