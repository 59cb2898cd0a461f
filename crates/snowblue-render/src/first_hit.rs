//! What a sample's camera ray hits first, for channels beside the colour: the surface, and the snow behind it.
//!
//! It is asked anew, beside the path of light, so that pictures without such channels pay nothing for them.

use snowblue_color::LinearRgb;

use crate::channels::{Channels, Feature};
use crate::chord::{ChordEnd, Line};
use crate::light::Light;
use crate::material::Material;
use crate::material::pca_snow::PathMode;
use crate::objects::Surface;
use crate::pixel_sums::PixelSums;
use crate::probe::Probe;
use crate::ray::{Ray, narrow};
use crate::scene::Scene;
use crate::spectrum::Spectrum;

/// Adds what a camera ray hits first to the features of its pixel.
pub(crate) fn add_first_hit(scene: &Scene, probe: &mut Probe, ray: &Ray, pixel: &mut PixelSums, channels: Channels) {
    let Some(surface) = probe.camera_hit(ray) else { return };
    pixel.add_feature(Feature::Normal, surface.normal.to_array());
    let behind = match &scene.materials[surface.material] {
        Material::PcaSnow(_) if channels.thickness || channels.angle || channels.albedo => {
            behind(scene, probe, &surface)
        }
        _ => None,
    };
    if channels.albedo {
        let depth_m = behind.map_or(0.0, |behind| behind.depth_m);
        let LinearRgb { r, g, b } = scene.retina.surface_colour(&reflectance(scene, probe, &surface, depth_m));
        pixel.add_feature(Feature::Albedo, [r, g, b].map(narrow));
    }
    if let Some(Behind { depth_m, angle_deg }) = behind {
        pixel.add_feature(Feature::Thickness, [depth_m, 0.0, 0.0]);
        if let Some(angle_deg) = angle_deg {
            pixel.add_feature(Feature::Angle, [angle_deg, 0.0, 0.0]);
        }
    }
}

/// The snow behind a point that is seen.
#[derive(Debug, Clone, Copy)]
struct Behind {
    depth_m: f32,
    /// Between the normal where the path comes out and the first light; above 90° the exit lies in its own shade.
    angle_deg: Option<f32>,
}

/// The path through snow that does not depend on the lights: along the view in that mode, else straight in.
fn behind(scene: &Scene, probe: &mut Probe, surface: &Surface) -> Option<Behind> {
    let Material::PcaSnow(snow) = &scene.materials[surface.material] else { return None };
    let direction = if snow.path == PathMode::View { surface.direction } else { -surface.normal };
    let Surface { object, point, normal, .. } = *surface;
    let chord = probe.chord(object, &Line { point, normal, direction, end_m: f32::INFINITY }, snow.exit)?;
    let angle_deg = match (chord.exit, scene.lights.first().and_then(Light::relative_from_middle)) {
        (ChordEnd::Surface { point, normal, .. }, Some(beam)) => {
            let cos = normal.dot(beam.origin.way(point).direction);
            Some(cos.clamp(-1.0, 1.0).acos().to_degrees())
        }
        _ => None,
    };
    Some(Behind { depth_m: chord.depth_m, angle_deg })
}

/// Reflectance of what is seen; of snow for light that comes straight from above.
fn reflectance(scene: &Scene, probe: &Probe, surface: &Surface, depth_m: f32) -> Spectrum {
    match &scene.materials[surface.material] {
        Material::Diffuse(diffuse) => diffuse.reflectance(probe.objects(), surface),
        Material::PcaSnow(snow) => snow.hit(probe.objects(), surface).reflectance(100.0 * depth_m, 1.0),
    }
}
