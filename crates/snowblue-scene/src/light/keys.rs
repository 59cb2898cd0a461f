//! The keys of one kind of light in a scene file: what they have in common.

use crate::description::range::Range;
use crate::light::techniques::Light;
use crate::spectrum::light_spectrum::LightSpectrum;
use snowblue_base::{KeyError, KeyPath};

/// A side or a radius of an area light.
pub(super) const AREA_LIGHT_SIZE: Range = Range::new(1e-6, 1e5, "m");
/// The radiance of an area light or a sky.
pub(super) const RADIANCE: Range = Range::power("W/(m² sr)");
/// A factor of the light of a sky.
pub(crate) const SKY_SCALE: Range = Range::new(1e-9, 1e9, "");

/// The keys of one kind of light, without those of its spectrum.
pub(crate) trait LightKeys {
    /// The light with a spectrum.
    ///
    /// # Errors
    ///
    /// With the first value that is out of its range.
    fn light(&self, path: &KeyPath, spectrum: &LightSpectrum) -> Result<Light, KeyError>;

    /// Whether the camera may see it as a lamp, which must have an extent.
    fn is_visible_emitter(&self) -> bool {
        false
    }
}
