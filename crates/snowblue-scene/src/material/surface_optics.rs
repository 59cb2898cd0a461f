//! Reflection and escape of light at the surface of snow.

use glam::Vec3A;
use snowblue_base::narrow;
use snowblue_field::SnowOptics;
use snowblue_geometry::ray::SurfacePoint;
use snowblue_transport::ordinates::HalfSpace;

use crate::directions::{Directions, ReflectionTable};
use crate::spectrum::Spectrum;

/// The surface of one kind of snow: its reflection and escape functions, and the snow below.
#[derive(Debug)]
pub struct SurfaceOptics {
    optics: SnowOptics,
    table: ReflectionTable,
}

impl SurfaceOptics {
    /// The surface of some snow.
    pub fn new(optics: SnowOptics) -> Self {
        Self { table: ReflectionTable::new(&optics.half_space), optics }
    }

    /// The optics of the snow below the surface.
    #[inline]
    pub fn optics(&self) -> &SnowOptics {
        &self.optics
    }

    /// The half-space of the snow without absorption.
    #[inline]
    pub fn half_space(&self) -> &HalfSpace {
        &self.optics.half_space
    }

    /// The escape function K.
    #[inline]
    pub fn escape(&self, cos: f32) -> f32 {
        narrow(self.half_space().escape(f64::from(cos)))
    }

    /// The reflection function R₀ of a surface with a normal, in 1/sr. Light comes from the unit vector `to_light`
    /// and leaves against the unit vector `direction`. Both vectors are directions of rays that run backwards from
    /// the camera.
    pub fn reflection_per_sr(&self, normal: Vec3A, direction: Vec3A, to_light: Vec3A) -> f32 {
        reflection_per_sr(self.half_space(), normal, direction, to_light)
    }

    /// Directions from which the surface reflects light against the unit vector `direction`.
    pub fn directions(&self, surface: SurfacePoint, direction: Vec3A) -> Directions<'_> {
        Directions::Reflected(self.table.at(surface, direction))
    }

    /// Reflectance of deep snow for light at a cosine of incidence: e^{−4 K(μ₀) √(μ_a ℓ*/3)} (Kokhanovsky & Zege
    /// 2004, *Scattering optics of snow*, doi:10.1364/AO.43.001589).
    pub fn deep_reflectance(&self, cos: f32) -> Spectrum {
        let reflectance = |k: usize| (-self.escape(cos) * narrow(self.optics.half_space_absorption(k))).exp();
        Spectrum(std::array::from_fn(reflectance))
    }
}

/// The reflection function of a half-space in 1/sr, with directions as in [`SurfaceOptics::reflection_per_sr`].
/// Directions below the horizon count as grazing.
pub fn reflection_per_sr(half_space: &HalfSpace, normal: Vec3A, direction: Vec3A, to_light: Vec3A) -> f32 {
    let [cos_exit, cos_incidence] = [-direction, to_light].map(|to| normal.dot(to).max(0.0));
    // Both directions of propagation, projected on the surface.
    let incident = normal * cos_incidence - to_light;
    let exitant = -direction - normal * cos_exit;
    let lengths = (incident.length_squared() * exitant.length_squared()).sqrt();
    let cos_azimuth = if lengths > 1e-12 { incident.dot(exitant) / lengths } else { 0.0 };
    let [exit, incidence, azimuth] = [cos_exit, cos_incidence, cos_azimuth.clamp(-1.0, 1.0)].map(f64::from);
    narrow(half_space.reflection(exit, incidence, azimuth))
}
