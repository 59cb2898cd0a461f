//! What a sample's camera ray hits first, for channels beside the colour: the surface, and the snow behind it.
//!
//! It is found separately from the path of light, so that pictures without such channels take no time for them.

use snowblue_color::LinearRgb;

use crate::film::aov::{Aov, Aovs};
use crate::film::pixel_accumulator::PixelAccumulator;
use crate::geometry::chord::{ChordEnd, Exit, Line};
use crate::geometry::ray::{Ray, narrow};
use crate::scene::Scene;
use crate::scene::light::{Light, SHADOW_EPSILON};
use crate::scene::material::Material;
use crate::scene::objects::SurfaceInteraction;
use crate::scene::queries::SceneQueries;
use crate::spectrum::Spectrum;

/// Adds what a camera ray hits first to the features of its pixel.
pub(crate) fn add_first_hit(
    scene: &Scene,
    probe: &mut SceneQueries,
    ray: &Ray,
    pixel: &mut PixelAccumulator,
    channels: Aovs,
) {
    if channels.emitter {
        let seen = sees_emitter(scene, probe, ray);
        pixel.add_aov(Aov::Emitter, [if seen { 1.0 } else { 0.0 }, 0.0, 0.0]);
    }
    if !channels.need_first_surface() {
        return;
    }
    let Some(surface) = probe.camera_hit(ray) else { return };
    pixel.add_aov(Aov::Normal, surface.normal.to_array());
    let behind = match &scene.materials[surface.material] {
        Material::PcaSnow(_) | Material::LayeredSnow(_) if channels.thickness || channels.angle || channels.albedo => {
            behind(scene, probe, &surface)
        }
        _ => None,
    };
    if channels.albedo {
        let depth_m = behind.map_or(0.0, |behind| behind.depth_m);
        let LinearRgb { r, g, b } = scene.sensor.albedo_rgb(&reflectance(scene, probe, &surface, depth_m));
        pixel.add_aov(Aov::Albedo, [r, g, b].map(narrow));
    }
    if let Some(Behind { depth_m, angle_deg }) = behind {
        pixel.add_aov(Aov::Thickness, [depth_m, 0.0, 0.0]);
        if let Some(angle_deg) = angle_deg {
            pixel.add_aov(Aov::Angle, [angle_deg, 0.0, 0.0]);
        }
    }
}

/// Whether a camera ray meets a lamp or the sun before any surface. Few rays pass a lamp at all, and only they ask for
/// the surface.
fn sees_emitter(scene: &Scene, probe: &mut SceneQueries, ray: &Ray) -> bool {
    let sees = |limit_m: f32| scene.lights.iter().any(|light| light.is_seen_as_emitter(ray, limit_m));
    sees(f32::INFINITY) && probe.camera_hit(ray).is_none_or(|surface| sees(light_limit_m(ray, &surface)))
}

/// The distance within which a camera ray sees lights before a surface. A light that lies on the surface counts, as for
/// shadow rays.
pub(super) fn light_limit_m(ray: &Ray, surface: &SurfaceInteraction) -> f32 {
    surface.point.distance(ray.origin) / (1.0 - SHADOW_EPSILON)
}

/// The snow behind a point that is seen.
#[derive(Debug, Clone, Copy)]
struct Behind {
    depth_m: f32,
    /// Between the normal where the path comes out and the first light; above 90° the exit lies in its own shade.
    angle_deg: Option<f32>,
}

/// The path through snow that does not depend on the lights: along the view in that mode, else straight in.
fn behind(scene: &Scene, probe: &mut SceneQueries, surface: &SurfaceInteraction) -> Option<Behind> {
    let SurfaceInteraction { object, point, normal, .. } = *surface;
    let (direction, exit) = match &scene.materials[surface.material] {
        Material::Diffuse(_) => return None,
        Material::PcaSnow(snow) => (snow.path.straight_direction(surface), snow.exit),
        Material::LayeredSnow(_) => (-normal, Exit::default()),
    };
    let chord = probe.chord(object, &Line { point, normal, direction, end_m: f32::INFINITY }, exit)?;
    let angle_deg = match (chord.exit, scene.lights.first().and_then(Light::central_sample)) {
        (ChordEnd::Surface { point, normal, .. }, Some(sample)) => {
            let cos = normal.dot(sample.origin.direction_from(point).direction);
            Some(cos.clamp(-1.0, 1.0).acos().to_degrees())
        }
        _ => None,
    };
    Some(Behind { depth_m: chord.depth_m, angle_deg })
}

/// Reflectance of what is seen; of snow for light that comes straight from above. A layer counts as deep.
fn reflectance(scene: &Scene, probe: &SceneQueries, surface: &SurfaceInteraction, depth_m: f32) -> Spectrum {
    match &scene.materials[surface.material] {
        Material::Diffuse(diffuse) => diffuse.reflectance(probe.objects(), surface),
        Material::PcaSnow(snow) => snow.reflectance(&snow.curves.at(probe.objects(), surface), 100.0 * depth_m, 1.0),
        Material::LayeredSnow(_) => {
            let field = scene.light_field.as_ref().and_then(|all| all.of_object(surface.object));
            let at = field.map(|field| field.at(probe.objects(), surface.object, &surface.surface_point()));
            at.map_or(Spectrum::ZERO, |at| at.layer.deep_reflectance(1.0))
        }
    }
}
