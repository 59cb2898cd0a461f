//! First hits of camera rays, for channels beside the colour: the surface, and the snow behind it.
//!
//! A surface that lets more than half of the light pass, as glass does, does not count.
//!
//! First hits are found separately from the path of light, so that pictures without such channels take no time for
//! them.

use snowblue_base::narrow;
use snowblue_color::LinearRgb;
use snowblue_geometry::body::{ChordEnd, Line};
use snowblue_geometry::ray::Ray;

use crate::film::aov::{Aov, Aovs};
use crate::film::cryptomatte::{Matte, NO_SURFACE, PixelMattes, id};
use crate::film::pixel_accumulator::PixelAccumulator;
use crate::integrators::method::Prepared;
use snowblue_scene::Scene;
use snowblue_scene::light::SHADOW_EPSILON;
use snowblue_scene::objects::SurfaceInteraction;
use snowblue_scene::queries::SceneQueries;
use snowblue_scene::spectrum::Spectrum;

/// Finds first hits. Its queries are not part of the light transport and do not count.
#[derive(Debug)]
pub(crate) struct FirstHits<'a> {
    prepared: &'a Prepared,
    scene: &'a Scene,
    queries: SceneQueries<'a>,
}

/// The distance within which a light lies before a surface on a camera ray. A light on the surface counts, as for
/// shadow rays.
pub(super) fn light_limit_m(ray: &Ray, surface: &SurfaceInteraction) -> f32 {
    surface.point.distance(ray.origin) / (1.0 - SHADOW_EPSILON)
}

/// The snow behind a visible point.
#[derive(Debug, Clone, Copy)]
struct Behind {
    depth_m: f32,
    /// Angle between the normal at the exit of the path and the direction to the first light; above 90° the exit
    /// faces away from the light.
    angle_deg: Option<f32>,
}

impl<'a> FirstHits<'a> {
    pub(in crate::integrators) fn new(prepared: &'a Prepared) -> Self {
        let scene = &prepared.scene;
        Self { prepared, scene, queries: SceneQueries::new(scene.objects(), scene.materials()) }
    }

    /// Adds the first hit of a camera ray to the AOVs of its pixel, and to its mattes, if there are any.
    pub(crate) fn add(
        &mut self,
        ray: &Ray,
        pixel: &mut PixelAccumulator,
        mattes: Option<&mut PixelMattes>,
        channels: Aovs,
    ) {
        if channels.emitter {
            let seen = self.sees_emitter(ray);
            pixel.add_aov(Aov::Emitter, [if seen { 1.0 } else { 0.0 }, 0.0, 0.0]);
        }
        if !channels.need_first_surface() {
            return;
        }
        let hit = self.hit(ray);
        if let Some(mattes) = mattes {
            for matte in channels.mattes() {
                let id = hit.as_ref().map_or(NO_SURFACE, |surface| id(self.name(matte, surface)));
                mattes[matte as usize].add(id, 1);
            }
        }
        let Some(surface) = hit else { return };
        pixel.add_aov(Aov::Normal, surface.normal.to_array());
        if let Ok(camera) = self.scene.camera() {
            pixel.add_aov(Aov::Depth, [camera.depth_m(surface.point), 0.0, 0.0]);
        }
        pixel.add_aov(Aov::Position, surface.point.to_array());
        let is_needed = channels.thickness || channels.angle || channels.albedo;
        let is_snow = self.scene.materials()[surface.material].is_snow();
        let behind = if is_needed && is_snow { self.behind(&surface) } else { None };
        if channels.albedo {
            let depth_m = behind.map_or(0.0, |behind| behind.depth_m);
            let LinearRgb { r, g, b } = self.scene.sensor().albedo_rgb(&self.reflectance(&surface, depth_m));
            pixel.add_aov(Aov::Albedo, [r, g, b].map(narrow));
        }
        if let Some(Behind { depth_m, angle_deg }) = behind {
            pixel.add_aov(Aov::Thickness, [depth_m, 0.0, 0.0]);
            if let Some(angle_deg) = angle_deg {
                pixel.add_aov(Aov::Angle, [angle_deg, 0.0, 0.0]);
            }
        }
    }

    /// The name of what has mattes.
    fn name(&self, matte: Matte, surface: &SurfaceInteraction) -> &'a str {
        match matte {
            Matte::Object => &self.scene.objects().list()[surface.object].name,
            Matte::Material => &self.scene.material_names()[surface.material],
        }
    }

    /// Whether a camera ray meets a lamp or the sun before any surface. Few rays meet a lamp at all, and only these
    /// rays search for the surface.
    fn sees_emitter(&mut self, ray: &Ray) -> bool {
        let scene = self.scene;
        let sees = |limit_m: f32| scene.lights().iter().any(|light| light.is_seen_as_emitter(ray, limit_m));
        sees(f32::INFINITY) && self.hit(ray).is_none_or(|surface| sees(light_limit_m(ray, &surface)))
    }

    /// The first hit of a camera ray.
    fn hit(&mut self, ray: &Ray) -> Option<SurfaceInteraction> {
        let mut ray = *ray;
        self.queries.hit(&mut ray, || 0.5, |_| {})
    }

    /// The snow behind a surface, along the path that does not depend on the lights.
    fn behind(&mut self, surface: &SurfaceInteraction) -> Option<Behind> {
        let SurfaceInteraction { object, point, normal, .. } = *surface;
        let direction = self.prepared.method.straight_direction(self.scene, surface);
        let chord = self.queries.chord(object, &Line { point, normal, direction, end_m: f32::INFINITY })?;
        let light = self.scene.lights().first().and_then(|light| light.central_sample());
        let angle_deg = match (chord.exit, light) {
            (ChordEnd::Surface { point, normal, .. }, Some(sample)) => {
                let cos = normal.dot(sample.origin.direction_from(point).direction);
                Some(cos.clamp(-1.0, 1.0).acos().to_degrees())
            }
            _ => None,
        };
        Some(Behind { depth_m: chord.depth_m, angle_deg })
    }

    /// Reflectance of a visible surface. At snow it holds for light from straight above, and for deep snow except by
    /// PCASnow.
    fn reflectance(&self, surface: &SurfaceInteraction, depth_m: f32) -> Spectrum {
        let albedo = self.scene.materials()[surface.material].albedo(self.queries.objects(), surface);
        albedo.unwrap_or_else(|| self.prepared.snow_reflectance(surface, depth_m))
    }
}
