//! Shading of snow surfaces by a method, for the path tracer.
//!
//! Snow by PCASnow is a surface that transmits and reflects light, and paths go on from it. The light field of other
//! snow contains the light of further surfaces. Sparkle is a part of the reflection in both cases.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3A;
use snowblue_geometry::ray::Ray;
use snowblue_scene::Scene;
use snowblue_scene::directions::Directions;
use snowblue_scene::light::{IncidentLight, Light, LightSample};
use snowblue_scene::objects::SurfaceInteraction;
use snowblue_scene::queries::{SceneQueries, Statistics};
use snowblue_scene::sampling::Sampler;
use snowblue_scene::spectrum::Spectrum;

use crate::integrators::camera_terms::CameraTerms;
use crate::integrators::diffusion::FieldShader;
use crate::integrators::light_tables::{Carried, LightTables};
use crate::integrators::pcasnow::PcaSnow;
use crate::integrators::sparkle::SparkleReader;
use crate::integrators::surface::{OpenSky, Shading, Surface};

/// Shades the surface of snow, for one task.
#[derive(Debug)]
pub(super) struct SnowShader<'a> {
    pub(super) method: ShadingMethod<'a>,
    /// Sparkle, if any snow has it.
    pub(super) sparkle: Option<SparkleReader<'a>>,
}

/// A method that shades snow.
#[derive(Debug)]
pub(super) enum ShadingMethod<'a> {
    PcaSnow(PcaSnow<'a>),
    /// `diffusion` and, with random walks, `hybrid`.
    Field(Box<FieldShader<'a>>),
}

impl<'a> SnowShader<'a> {
    /// The snow at a hit.
    #[inline]
    pub(super) fn at<'v>(
        &mut self,
        hit: &'v SurfaceInteraction,
        queries: &mut SceneQueries,
        sampler: &mut Sampler,
    ) -> Shading<'v, 'a>
    where
        'a: 'v,
    {
        match &self.method {
            ShadingMethod::PcaSnow(pcasnow) => Shading::Snow(pcasnow.at(hit, queries)),
            ShadingMethod::Field(shader) => Shading::Field(shader.at(hit, sampler)),
        }
    }

    /// The terms of the light that a surface sends along a camera ray.
    #[inline]
    pub(super) fn camera_terms(
        &mut self,
        surface: &Surface<'_, 'a>,
        camera_ray: &Ray,
        sampler: &mut Sampler,
    ) -> CameraTerms<'a> {
        let mut terms = match (&mut self.method, &surface.shading) {
            (ShadingMethod::Field(shader), Shading::Field(snow)) => {
                shader.camera_terms(*snow, surface, camera_ray, sampler)
            }
            _ => CameraTerms::default(),
        };
        if let Some(sparkle) = &self.sparkle
            && let Some(kind) = surface.kind_of_snow(sparkle.objects(), sampler)
        {
            terms.sparkling = sparkle.at((surface.hit, kind, surface.normal), camera_ray);
        }
        terms
    }

    /// The terms of the light that a later surface of a path sends back along the path.
    pub(super) fn later_terms(surface: &Surface) -> CameraTerms<'a> {
        CameraTerms { from_inside: surface.light_from_inside(), ..CameraTerms::default() }
    }

    /// Light of lamps and skies that comes through snow.
    #[inline]
    pub(super) fn transmitted<C: Carried>(
        surface: &Surface,
        scene: &Scene,
        tables: &LightTables,
        queries: &mut SceneQueries,
        sampler: &mut Sampler,
    ) -> C {
        match &surface.shading {
            Shading::Snow(snow) => snow.transmitted(scene, tables, queries, sampler),
            Shading::Field(_) | Shading::Ground(_) | Shading::Diffuse(_) | Shading::Textured(_) => C::ZERO,
        }
    }

    /// The radiance by a random walk in snow that replaces the terms of the surface; none if there are no walks.
    #[inline]
    pub(super) fn walk(&mut self, surface: &Surface, camera_ray: &Ray, sampler: &mut Sampler) -> Option<Spectrum> {
        match (&mut self.method, &surface.shading) {
            (ShadingMethod::Field(shader), Shading::Field(snow)) => {
                shader.walk(*snow, surface.hit, camera_ray, sampler)
            }
            _ => None,
        }
    }

    /// The change of the light that leaves a surface by sparkle, in the incident light of a light sample.
    #[inline]
    pub(super) fn sparkle(
        &mut self,
        terms: &CameraTerms,
        surface: &Surface,
        (light, sample): (&Light, &LightSample),
        incident: &IncidentLight,
    ) -> Option<Spectrum> {
        let (Some(sparkle), Some(sparkling)) = (&mut self.sparkle, &terms.sparkling) else { return None };
        // At most the whole reflection by the curves of PCASnow.
        let most_per_sr = match &surface.shading {
            Shading::Snow(snow) => FRAC_1_PI * snow.reflectance(incident.cos_incidence).minimum(),
            Shading::Field(_) | Shading::Ground(_) | Shading::Diffuse(_) | Shading::Textured(_) => f32::INFINITY,
        };
        let change = sparkle.change(sparkling, light, sample, most_per_sr)?;
        Some(change * light.power(&sample.origin) * incident.irradiance_per_power)
    }

    /// The single scattering of a light sample that the reflection function of a half-space misses. `incident` is the
    /// light on the surface, if the sample is visible there.
    #[inline]
    pub(super) fn single_scattering(
        &mut self,
        terms: &CameraTerms,
        surface: &Surface,
        (light, sample): (&Light, &LightSample),
        incident: Option<IncidentLight>,
    ) -> Option<Spectrum> {
        let (ShadingMethod::Field(shader), Some(point)) = (&mut self.method, &terms.scattering) else { return None };
        // The half-space that the ray enters has the geometric normal.
        let on_plane = incident.and_then(|visible| {
            let on_plane = sample.incident_at(&surface.hit.surface_point())?;
            let irradiance_per_power = visible.irradiance_per_power / visible.cos_incidence * on_plane.cos_incidence;
            Some(IncidentLight { irradiance_per_power, ..on_plane })
        });
        Some(light.power(&sample.origin) * shader.single_scattering.correction(point, sample, on_plane.as_ref()))
    }

    /// The light of smooth skies that a surface sends out, without noise. At snow with a light field it follows from
    /// the irradiance of the field; in wide cells the light that enters decreases the light from inside. At other
    /// surfaces it is the light as if only snow hid the skies, with the light of that snow.
    pub(super) fn smooth_sky(&self, surface: &Surface, terms: &CameraTerms, open_sky: &OpenSky) -> Spectrum {
        if let Shading::Field(snow) = &surface.shading {
            let irradiance = snow.field.sky_irradiance(&surface.shading_point());
            let mut light = irradiance * FRAC_1_PI;
            if let Some(decrease_per_sr) = terms.from_inside.as_ref().and_then(|inside| inside.decrease_per_sr.as_ref())
            {
                light.add_product(-1.0, decrease_per_sr, &irradiance);
            }
            return light;
        }
        let mut light = open_sky.reflected(surface);
        if let ShadingMethod::Field(shader) = &self.method {
            let snow = shader.field.snow_seen_from(&surface.shading_point());
            light = light * (1.0 - snow.share);
            light += surface.reflectance(surface.normal) * snow.irradiance * FRAC_1_PI;
        }
        light
    }

    /// Samples the next direction of a path from three numbers in [0, 1), with the weight cos θ / (π p). With a light
    /// field, half of the directions that find further surfaces go towards bright snow.
    #[inline]
    pub(super) fn sample_direction(
        &self,
        directions: &Directions,
        numbers: [f32; 3],
        finds_surfaces: bool,
    ) -> (Vec3A, f32) {
        match &self.method {
            ShadingMethod::Field(shader) if finds_surfaces => shader.field.sample_reflection(directions, numbers),
            _ => directions.sample_weighted([numbers[0], numbers[1]]),
        }
    }

    /// Counts of the queries so far.
    pub(super) fn statistics(&self) -> Statistics {
        match &self.method {
            ShadingMethod::PcaSnow(_) => Statistics::default(),
            ShadingMethod::Field(shader) => shader.statistics(),
        }
    }
}
