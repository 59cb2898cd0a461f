//! The light that surfaces reflect of skies which nothing hides, without noise, for the filter.

use std::f32::consts::{FRAC_1_PI, TAU};

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
        let directions = (0..RINGS).flat_map(|ring| (0..AZIMUTHS).map(move |azimuth| direction(ring, azimuth)));
        let lit = directions.filter(|_| !skies.is_empty()).map(|direction| {
            let mut radiance = Spectrum::ZERO;
            skies.iter().for_each(|sky| radiance += sky.power(&LightOrigin::Distant(direction)));
            (direction, radiance * (TAU / f32::from(RINGS * AZIMUTHS)))
        });
        Self(lit.collect())
    }

    /// The radiance that leaves a surface, as a band density.
    pub(super) fn reflected(&self, vertex: &Vertex) -> Spectrum {
        let (normal, view) = (vertex.normal, vertex.surface.direction);
        // Of deep snow absorption hardly depends on the direction.
        let ground = if let Shading::Ground(ground) = &vertex.shading { Some(ground) } else { None };
        let per_sr = |direction: Vec3A| match ground {
            Some(ground) => ground.surface().reflection_per_sr(normal, view, direction),
            None => FRAC_1_PI,
        };
        let mut sum = Spectrum::ZERO;
        for (direction, radiance) in &self.0 {
            let cos = normal.dot(*direction);
            if cos > 0.0 {
                sum += *radiance * (cos * per_sr(*direction));
            }
        }
        sum * ground.map_or_else(|| vertex.reflectance(normal), |ground| *ground.albedo())
    }
}

/// The middle of a part of the sky.
fn direction(ring: u8, azimuth: u8) -> Vec3A {
    let cosine = (f32::from(ring) + 0.5) / f32::from(RINGS);
    let sine = (1.0 - cosine * cosine).sqrt();
    // Each ring is turned against the one before.
    let (sin, cos) = (TAU * (f32::from(azimuth) / f32::from(AZIMUTHS) + 0.382 * f32::from(ring))).sin_cos();
    Vec3A::new(sine * cos, sine * sin, cosine)
}
