//! The light that surfaces reflect of skies which nothing hides, without noise, for the filter.

use std::f32::consts::{PI, TAU};

use glam::Vec3A;

use super::vertex::{Shading, Vertex};
use snowblue_scene::light::{Light, LightOrigin};
use snowblue_scene::spectrum::Spectrum;

/// Directions that stand for the sky: rings of equal solid angle, and azimuths.
const RINGS: u8 = 6;
const AZIMUTHS: u8 = 8;

/// The skies of a scene that have no edges, as light from a few directions.
#[derive(Debug)]
pub(in crate::integrators) struct OpenSky(Vec<(Vec3A, Spectrum)>);

impl OpenSky {
    /// That of some lights. The radiance of each direction is multiplied by its share of the hemisphere, in sr.
    pub(in crate::integrators) fn new<'l>(lights: impl Iterator<Item = &'l Light>) -> Self {
        let skies: Vec<&Light> = lights.filter(|light| light.is_smooth_sky() || light.is_diffuse()).collect();
        let count = f32::from(if skies.is_empty() { 0 } else { RINGS * AZIMUTHS });
        let direction = |number: f32| {
            let (ring, azimuth) = ((number / f32::from(AZIMUTHS)).floor(), number % f32::from(AZIMUTHS));
            let cosine = (ring + 0.5) / f32::from(RINGS);
            let sine = (1.0 - cosine * cosine).sqrt();
            // Each ring is turned against the one before.
            let (sin, cos) = (TAU * (azimuth / f32::from(AZIMUTHS) + 0.382 * ring)).sin_cos();
            Vec3A::new(sine * cos, sine * sin, cosine)
        };
        let directions = (0..u8::MAX).map(f32::from).take_while(|number| *number < count).map(direction);
        let lit = directions.map(|direction| {
            let mut radiance = Spectrum::ZERO;
            skies.iter().for_each(|sky| radiance += sky.power(&LightOrigin::Distant(direction)));
            (direction, radiance * (TAU / count))
        });
        Self(lit.collect())
    }

    /// The radiance that leaves a surface, as a band density.
    pub(super) fn reflected(&self, vertex: &Vertex) -> Spectrum {
        let mut sum = Spectrum::ZERO;
        let mut add = |reflection: &dyn Fn(Vec3A) -> f32| {
            for (direction, radiance) in &self.0 {
                let cos = vertex.normal.dot(*direction);
                if cos > 0.0 {
                    sum += *radiance * (cos * reflection(*direction));
                }
            }
        };
        match &vertex.shading {
            // Absorption hardly depends on the direction.
            Shading::Ground(ground) => {
                let view = vertex.surface.direction;
                add(&|direction| ground.surface().reflection_per_sr(vertex.normal, view, direction));
                sum * *ground.albedo()
            }
            Shading::Diffuse(_) | Shading::Textured(_) | Shading::Snow(_) | Shading::Field(_) => {
                add(&|_| 1.0 / PI);
                vertex.reflectance(vertex.normal) * sum
            }
        }
    }
}
