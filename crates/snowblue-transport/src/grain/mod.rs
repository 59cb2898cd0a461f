//! A single grain of ice: its shape, its rough surface, and its scattering of a ray of light, given by the direction
//! in which the light leaves the grain and its path through the ice.
//!
//! Light is reflected or enters, crosses the ice in straight segments between interfaces, and leaves. Grains that are
//! nearly smooth trap some light: below a roughness of about 0.025 the distribution of ice paths is heavy-tailed. The
//! mean ice path is discontinuous at roughness 0: it is n² times the mean chord for any roughness above 0. A facetness
//! of 0 is smooth.
//!
//! Directions depend on shape, roughness and index alone; the ice path is proportional to the size.

pub(crate) mod microsurface;
mod spheroid;

use crate::rng::Stream;
use microsurface::{Outcome, interact};
use spheroid::{Frame, Hit};
pub use spheroid::{SizeMeasure, Spheroid};

/// Roughness α of the microsurface per unit of facetness: α = 0.25 f. The factor is our choice: with it f = 0.5 has the
/// asymmetry of natural snow.
pub(crate) const ROUGHNESS_PER_FACETNESS: f64 = 0.25;

/// The optical properties of a grain, except its size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grain {
    /// Shape, in units of the size.
    pub shape: Spheroid,
    /// Roughness α of the surface.
    pub roughness: f64,
    /// Relative refractive index: ice over the surrounding medium.
    pub relative_index: f64,
}

/// Light scattered by a grain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scattered {
    /// Cosine of the scattering angle.
    pub cos_scattering: f64,
    /// Path through the ice, over the grain's size.
    pub ice_path: f64,
}

impl Grain {
    /// Scatters a random ray of isotropic light.
    ///
    /// ```
    /// # use snowblue_transport::{grain::{Grain, SizeMeasure, Spheroid}, rng::Stream};
    /// // A grain with a relative index of 1 does not deflect light.
    /// let shape = Spheroid::of_unit_size(0.8, SizeMeasure::GreatestExtension);
    /// let grain = Grain { shape, roughness: 0.1, relative_index: 1.0 };
    /// let scattered = grain.scatter(&mut Stream::new(1, 0));
    /// assert!((scattered.cos_scattering - 1.0).abs() < 1e-12);
    /// ```
    #[inline]
    pub fn scatter(&self, stream: &mut Stream) -> Scattered {
        self.scatter_hit(self.shape.random_hit(stream), stream)
    }

    /// Traces a ray from its entry until it leaves the grain.
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
            let chord = self.shape.chord(Hit { point: hit.point, direction });
            ice_path += chord.length;
            hit = Hit { point: chord.end, direction };
        }
    }
}
