//! Deep snow as a surface: the land around a scene. Light leaves the surface at the point where it enters.
//!
//! The reflection function R₀ belongs to snow without absorption. Absorption follows Kokhanovsky & Zege (2004,
//! doi:10.1364/AO.43.001589): R = R₀ e^{−α K(μ) K(μ₀) / (π R₀)} in 1/sr, α = 4 √(μ_a ℓ*/3).

use std::f32::consts::PI;

use glam::Vec3A;
use snowblue_base::narrow;
use snowblue_field::SnowOptics;
use snowblue_transport::{SnowSample, TransportError};

use super::surface_optics::SurfaceOptics;
use crate::spectrum::{Spectrum, wavelengths_nm};

/// Number of rays through grains, per node of the refractive index. The error of an albedo is then less than 0.001.
const GRAIN_RAYS: u32 = 1 << 14;

/// The surface of deep snow of one kind.
#[derive(Debug)]
pub struct DeepSnow {
    surface: SurfaceOptics,
    albedo: Spectrum,
    /// α.
    absorption: Spectrum,
}

impl DeepSnow {
    pub(crate) fn new(sample: &SnowSample) -> Result<Self, TransportError> {
        let optics = SnowOptics::new(sample, &wavelengths_nm(), GRAIN_RAYS)?;
        Ok(Self {
            albedo: Spectrum(diffuse_albedo(&optics).map(narrow)),
            absorption: Spectrum(std::array::from_fn(|k| narrow(optics.half_space_absorption(k)))),
            surface: SurfaceOptics::new(optics),
        })
    }

    /// The albedo under a uniform sky.
    pub fn albedo(&self) -> &Spectrum {
        &self.albedo
    }

    /// The optics of the surface.
    pub fn surface(&self) -> &SurfaceOptics {
        &self.surface
    }

    /// π times the reflection function of a surface with a normal, for light from the unit vector `to_light` that
    /// leaves against the unit vector `direction`.
    pub fn reflectance(&self, normal: Vec3A, direction: Vec3A, to_light: Vec3A) -> Spectrum {
        let white = PI * self.surface.reflection_per_sr(normal, direction, to_light);
        if white <= 0.0 {
            return Spectrum::ZERO;
        }
        let escape = |cos: f32| self.surface.escape(cos.max(0.0));
        let escapes = escape(-normal.dot(direction)) * escape(normal.dot(to_light)) / white;
        Spectrum(self.absorption.0.map(|absorption| white * (-absorption * escapes).exp()))
    }
}

/// Albedo of deep snow under diffuse light at some wavelengths, in nm.
pub(crate) fn deep_albedo<const N: usize>(
    sample: &SnowSample,
    wavelengths_nm: &[f64; N],
) -> Result<[f64; N], TransportError> {
    Ok(diffuse_albedo(&SnowOptics::new(sample, wavelengths_nm, GRAIN_RAYS)?))
}

/// In diffusion the fluence rate under diffuse irradiance H is φ = 4H e^{−kz} / (1 + q ℓ* k) with k = √(3 μ_a/ℓ*), and
/// the flux (ℓ*/3) k φ(0) is absorbed.
fn diffuse_albedo<const N: usize>(optics: &SnowOptics) -> [f64; N] {
    let extrapolation = optics.half_space.extrapolation();
    std::array::from_fn(|index| {
        let decay = (3.0 * optics.absorption_per_m[index] * optics.transport_lengths_m[index]).sqrt();
        1.0 - 4.0 / 3.0 * decay / (1.0 + extrapolation * decay)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    #[test]
    fn the_reflection_is_reciprocal_and_redder_light_is_darker() {
        let snow = DeepSnow::new(&SnowSample::default()).unwrap();
        let [high, low] = [Vec3A::new(0.3, 0.2, 0.9), Vec3A::new(-0.9, 0.1, 0.2)].map(Vec3A::normalize);
        let (one, other) = (snow.reflectance(Vec3A::Z, -high, low), snow.reflectance(Vec3A::Z, -low, high));
        for (one, other) in one.0.iter().zip(other.0) {
            // Single precision.
            assert!((one / other - 1.0).abs() < 1e-5, "{one} {other}");
        }
        assert!(one.0[5] > one.0[15] && one.0[15] > one.0[30], "{one:?}");
    }
}
