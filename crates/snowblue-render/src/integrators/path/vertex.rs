//! Surfaces on a path, and the light that they reflect of skies which nothing hides, without noise, for the filter.

use std::f32::consts::{FRAC_1_PI, PI, TAU};

use glam::Vec3A;
use snowblue_geometry::ray::SurfacePoint;
use snowblue_light_field::SnowAt;
use snowblue_scene::directions::Directions;
use snowblue_scene::light::{Light, LightOrigin};
use snowblue_scene::material::deep_snow::DeepSnow;
use snowblue_scene::objects::SurfaceInteraction;
use snowblue_scene::spectrum::Spectrum;

use crate::integrators::snow_vertex::SnowVertex;

/// A surface on a path, ready to be shaded.
pub(in crate::integrators) struct Vertex<'v, 'a> {
    pub(in crate::integrators) surface: &'v SurfaceInteraction,
    /// The normal that light is reflected by: that for shading with a light field, for PCASnow the geometric one.
    pub(in crate::integrators) normal: Vec3A,
    /// Directions from which the surface reflects light, for samples.
    pub(in crate::integrators) directions: Directions<'a>,
    pub(in crate::integrators) shading: Shading<'v>,
}

/// What a surface reflects and transmits.
pub(in crate::integrators) enum Shading<'a> {
    /// Reflectance of a plain diffuse surface.
    Diffuse(&'a Spectrum),
    /// Reflectance of a textured diffuse surface.
    Textured(Spectrum),
    /// Deep snow.
    Ground(&'a DeepSnow),
    /// Snow by PCASnow.
    Snow(SnowVertex<'a>),
    /// Snow with the light field inside.
    Field(SnowAt<'a>),
}

impl Vertex<'_, '_> {
    /// The point with the normal that light is reflected by.
    #[inline]
    pub(in crate::integrators) fn shading_point(&self) -> SurfacePoint {
        SurfacePoint { point: self.surface.point, normal: self.normal }
    }

    /// Reflectance for light from a direction above the surface, π times the reflection function.
    pub(in crate::integrators) fn reflectance(&self, to_light: Vec3A) -> Spectrum {
        match &self.shading {
            Shading::Diffuse(reflectance) => **reflectance,
            Shading::Textured(reflectance) => *reflectance,
            Shading::Ground(ground) => ground.reflectance(self.normal, self.surface.direction, to_light),
            Shading::Snow(snow) => snow.reflectance(self.normal.dot(to_light).max(0.0)),
            Shading::Field(snow) => {
                let per_sr = snow.optics.surface().reflection_per_sr(self.normal, self.surface.direction, to_light);
                Spectrum::constant(PI * per_sr)
            }
        }
    }
}

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
