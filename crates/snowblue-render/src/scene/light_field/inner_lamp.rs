//! A lamp inside a body of snow.
//!
//! The fluence rate is φ = φ₀ + φ₁. In snow without end a point source of radiant intensity I has
//!
//! φ₀ = 3 I/ℓ* · e^{−κ_e r} / r,   κ_e = √(3 μ_a/ℓ*),
//!
//! and φ₁ obeys the same equation without a source, with the surface condition φ₁ + q ℓ* ∂φ₁/∂n = −(φ₀ + q ℓ* ∂φ₀/∂n).
//! So the lamp enters like light at the surface of −(φ₀ + q ℓ* ∂φ₀/∂n)/4, and the net flux lacks −(ℓ*/3) ∂φ₀/∂n.

use glam::Vec3A;
use snowblue_field::SnowOptics;

use crate::geometry::ray::narrow;
use crate::scene::light::Light;
use crate::spectrum::{SAMPLES, Spectrum};

/// A point lamp or a sphere inside snow.
#[derive(Debug, Clone)]
pub(crate) struct InnerLamp {
    position: Vec3A,
    /// Radius in m. Inside a sphere the fluence rate is that of its surface.
    radius_m: f32,
    /// Radiant intensity in W/sr, as a band density.
    pub(super) intensity: Spectrum,
}

/// The fluence rate of a lamp in snow without end, and its derivative along a direction, at a wavelength.
#[derive(Debug, Clone, Copy)]
pub(super) struct FreeFluence {
    /// φ₀, in W/m².
    pub(super) fluence: f32,
    /// ∂φ₀/∂n, in W/m³.
    pub(super) slope_per_m: f32,
}

impl InnerLamp {
    /// A light as a lamp inside snow; none if it is not a point that shines in all directions, or a sphere.
    pub(crate) fn new(light: &Light) -> Option<Self> {
        match light {
            Light::Point(point) if point.cone.is_none() => {
                Some(Self { position: point.position, radius_m: 1e-4, intensity: point.intensity })
            }
            Light::Sphere(sphere) => {
                let radius_m = sphere.shape.radius_m;
                let area_m2 = std::f32::consts::PI * radius_m * radius_m;
                Some(Self { position: sphere.shape.centre, radius_m, intensity: sphere.radiance * area_m2 })
            }
            _ => None,
        }
    }

    /// Its fluence rate at a point, in m, and the derivative along a direction.
    pub(super) fn free(&self, optics: &SnowOptics, wavelength: usize, point: Vec3A, direction: Vec3A) -> FreeFluence {
        let length_m = narrow(optics.transport_lengths_m[wavelength]);
        let decay_per_m = (3.0 * narrow(optics.absorption_per_m[wavelength]) / length_m).sqrt();
        let offset = point - self.position;
        let distance_m = offset.length().max(self.radius_m);
        let fluence = 3.0 * self.intensity.0[wavelength] / length_m * (-decay_per_m * distance_m).exp() / distance_m;
        let slope_per_m = -fluence * (decay_per_m + distance_m.recip()) * offset.dot(direction) / distance_m;
        FreeFluence { fluence, slope_per_m }
    }

    /// The light at the surface that stands for it, −(φ₀ + q ℓ* ∂φ₀/∂n)/4.
    pub(super) fn entering(&self, optics: &SnowOptics, point: Vec3A, normal: Vec3A) -> Spectrum {
        let extrapolation = narrow(optics.half_space.extrapolation());
        Spectrum(std::array::from_fn::<_, SAMPLES, _>(|wavelength| {
            let FreeFluence { fluence, slope_per_m } = self.free(optics, wavelength, point, normal);
            let length_m = narrow(optics.transport_lengths_m[wavelength]);
            -0.25 * (fluence + extrapolation * length_m * slope_per_m)
        }))
    }

    /// What the net flux lacks, −(ℓ*/3) ∂φ₀/∂n, at a wavelength.
    pub(super) fn flux(&self, optics: &SnowOptics, wavelength: usize, point: Vec3A, normal: Vec3A) -> f32 {
        let length_m = narrow(optics.transport_lengths_m[wavelength]);
        -length_m / 3.0 * self.free(optics, wavelength, point, normal).slope_per_m
    }
}
