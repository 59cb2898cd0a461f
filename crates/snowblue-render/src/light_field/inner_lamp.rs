//! A lamp inside a body of snow.

use std::f32::consts::PI;

use glam::Vec3A;
use snowblue_field::{SpectralNodes, VolumeSource};

use crate::scene::light::Light;
use crate::spectrum::Spectrum;

/// A point lamp or a sphere inside snow.
#[derive(Debug, Clone)]
pub(crate) struct InnerLamp {
    position: Vec3A,
    radius_m: f32,
    /// Radiant intensity in W/sr, as a band density.
    intensity: Spectrum,
}

impl InnerLamp {
    /// A light as a lamp inside snow; none if it is not a point that shines in all directions, or a sphere.
    pub(crate) fn new(light: &Light) -> Option<Self> {
        match light {
            Light::Point(point) if point.cone.is_none() => {
                Some(Self { position: point.position, radius_m: 0.0, intensity: point.intensity })
            }
            Light::Sphere(sphere) => {
                let radius_m = sphere.shape.radius_m;
                let intensity = sphere.radiance * (PI * radius_m * radius_m);
                Some(Self { position: sphere.shape.centre, radius_m, intensity })
            }
            _ => None,
        }
    }

    /// The source of diffuse light that it is.
    pub(super) fn source(&self, nodes: &SpectralNodes) -> VolumeSource {
        VolumeSource {
            centre: self.position.as_dvec3(),
            radius_m: self.radius_m.into(),
            power: nodes.gather(|wavelength| 4.0 * PI * self.intensity.0[wavelength]).collect(),
        }
    }
}
