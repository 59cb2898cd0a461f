//! Surfaces on a path, and, for the filter, the light of unoccluded skies that they reflect, without noise.

use std::f32::consts::{FRAC_1_PI, PI, TAU};

use glam::Vec3A;
use snowblue_geometry::ray::SurfacePoint;
use snowblue_light_field::{LightFromInside, SnowAt};
use snowblue_scene::Scene;
use snowblue_scene::directions::Directions;
use snowblue_scene::light::{Light, LightOrigin, LightSample};
use snowblue_scene::material::Material;
use snowblue_scene::material::deep_snow::DeepSnow;
use snowblue_scene::material::diffuse::Diffuse;
use snowblue_scene::objects::{Objects, SurfaceInteraction};
use snowblue_scene::sampling::Sampler;
use snowblue_scene::spectrum::Spectrum;

use crate::integrators::pcasnow::SnowVertex;

/// A surface on a path, ready to be shaded.
pub(super) struct Surface<'v, 'a> {
    pub(super) hit: &'v SurfaceInteraction,
    /// The normal for reflection: the shading normal of snow with a light field, the geometric normal of other
    /// surfaces.
    pub(super) normal: Vec3A,
    /// Directions from which the surface reflects light, for samples.
    pub(super) directions: Directions<'a>,
    pub(super) shading: Shading<'v, 'a>,
}

/// How a surface reflects and transmits light.
pub(super) enum Shading<'v, 'a> {
    /// Reflectance of a plain diffuse surface.
    Diffuse(&'a Spectrum),
    /// Reflectance of a textured diffuse surface.
    Textured(Spectrum),
    /// Deep snow.
    Ground(&'a DeepSnow),
    /// Snow by PCASnow.
    Snow(SnowVertex<'v>),
    /// Snow with the light field inside.
    Field(SnowAt<'a>),
}

impl<'v, 'a: 'v> Surface<'v, 'a> {
    /// The surface at a hit; `snow` shades snow.
    #[inline]
    pub(super) fn new(scene: &'a Scene, hit: &'v SurfaceInteraction, snow: impl FnOnce() -> Shading<'v, 'a>) -> Self {
        let shading = match &scene.materials()[hit.material] {
            Material::Diffuse(Diffuse::Uniform(reflectance), _) => Shading::Diffuse(reflectance),
            Material::Diffuse(diffuse, _) => Shading::Textured(diffuse.reflectance(scene.objects(), hit)),
            // Rays end at a pane only after many others.
            Material::Glass(_) => Shading::Textured(Spectrum::ZERO),
            Material::Ground(ground) => Shading::Ground(ground),
            Material::Snow(_) => snow(),
        };
        let point = hit.surface_point();
        let (normal, directions) = match &shading {
            Shading::Diffuse(_) | Shading::Textured(_) | Shading::Snow(_) => (hit.normal, Directions::Cosine(point)),
            Shading::Ground(ground) => (hit.normal, ground.surface().directions(point, hit.direction)),
            Shading::Field(snow) => {
                let point = SurfacePoint { normal: hit.shading_normal, ..point };
                (hit.shading_normal, snow.optics.surface().directions(point, hit.direction))
            }
        };
        Self { hit, normal, directions, shading }
    }
}

impl Surface<'_, '_> {
    /// The point with the normal for reflection.
    #[inline]
    pub(super) fn shading_point(&self) -> SurfacePoint {
        SurfacePoint { point: self.hit.point, normal: self.normal }
    }

    /// Reflectance for light from a direction above the surface, π times the reflection function.
    pub(super) fn reflectance(&self, to_light: Vec3A) -> Spectrum {
        match &self.shading {
            Shading::Diffuse(reflectance) => **reflectance,
            Shading::Textured(reflectance) => *reflectance,
            Shading::Ground(ground) => ground.reflectance(self.normal, self.hit.direction, to_light),
            Shading::Snow(snow) => snow.reflectance(self.normal.dot(to_light).max(0.0)),
            Shading::Field(snow) => {
                let per_sr = snow.optics.surface().reflection_per_sr(self.normal, self.hit.direction, to_light);
                Spectrum::constant(PI * per_sr)
            }
        }
    }

    /// The light from inside of snow with a light field that leaves the surface along the ray.
    pub(super) fn light_from_inside(&self) -> Option<LightFromInside> {
        let Shading::Field(snow) = &self.shading else { return None };
        Some(snow.light_from_inside(&self.shading_point(), -self.normal.dot(self.hit.direction)))
    }

    /// Whether the surface is snow with a light field.
    #[inline]
    pub(super) fn has_field(&self) -> bool {
        matches!(self.shading, Shading::Field(_))
    }

    /// Samples of a light with extent for reflection, whose contributions add up. Snow with a light field gets one
    /// sample per technique of the light, because further rays of the path find no lamps there.
    #[inline]
    pub(super) fn samples_of(&self, light: &Light, sampler: &mut Sampler) -> [Option<LightSample>; 2] {
        match &self.shading {
            Shading::Field(_) if light.is_diffuse() => [None, None],
            Shading::Field(_) => light.samples_at(&self.directions, sampler),
            _ => [light.sample_for_reflection(&self.directions, sampler), None],
        }
    }

    /// The number of the kind of snow at the surface, drawn at random where kinds are mixed; none if the surface is
    /// not snow.
    pub(super) fn kind_of_snow(&self, objects: &Objects, sampler: &mut Sampler) -> Option<usize> {
        match &self.shading {
            Shading::Field(snow) => Some(snow.kind),
            Shading::Snow(snow) => Some(snow.kinds().at_surface(objects, self.hit).draw(|| sampler.next_four()[0])),
            Shading::Ground(_) | Shading::Diffuse(_) | Shading::Textured(_) => None,
        }
    }
}

/// Directions that stand for the sky: rings of equal solid angle, and azimuths.
const RINGS: u8 = 6;
const AZIMUTHS: u8 = 8;

/// The skies of a scene that have no edges, as light from a few directions.
#[derive(Debug)]
pub(super) struct OpenSky(Vec<(Vec3A, Spectrum)>);

impl OpenSky {
    /// The open sky of some lights. The radiance of each direction is multiplied by its share of the hemisphere, in
    /// sr.
    pub(super) fn new<'l>(lights: impl Iterator<Item = &'l Light>) -> Self {
        let skies: Vec<&Light> = lights.filter(|light| light.is_smooth_sky() || light.is_diffuse()).collect();
        let directions = (0..RINGS).flat_map(|ring| (0..AZIMUTHS).map(move |azimuth| direction(ring, azimuth)));
        let lit = directions.filter(|_| !skies.is_empty()).map(|direction| {
            let mut radiance = Spectrum::ZERO;
            skies.iter().for_each(|sky| radiance += sky.power(&LightOrigin::Distant(direction)));
            (direction, radiance * (TAU / f32::from(RINGS * AZIMUTHS)))
        });
        Self(lit.collect())
    }

    /// The radiance of the sky that a surface reflects, as a band density.
    pub(super) fn reflected(&self, surface: &Surface) -> Spectrum {
        let (normal, view) = (surface.normal, surface.hit.direction);
        // The absorption of deep snow hardly depends on the direction.
        let ground = if let Shading::Ground(ground) = &surface.shading { Some(ground) } else { None };
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
        sum * ground.map_or_else(|| surface.reflectance(normal), |ground| *ground.albedo())
    }
}

/// The middle direction of a part of the sky.
fn direction(ring: u8, azimuth: u8) -> Vec3A {
    let cosine = (f32::from(ring) + 0.5) / f32::from(RINGS);
    let sine = (1.0 - cosine * cosine).sqrt();
    // Each ring is turned relative to the ring before.
    let (sin, cos) = (TAU * (f32::from(azimuth) / f32::from(AZIMUTHS) + 0.382 * f32::from(ring))).sin_cos();
    Vec3A::new(sine * cos, sine * sin, cosine)
}
