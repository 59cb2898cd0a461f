//! Lights.

use snowblue_base::files::FileError;
use snowblue_geometry::ray::narrow;

use crate::error::RenderError;
use crate::scene::build::sources::Sources;
use crate::scene::description::value::point;
use crate::scene::description::{EnvironmentDescription, KeyPath, LampDescription, LightDescription, LightSource};
use crate::scene::light::{
    DiffuseEmitter, DirectionalLight, Light, Panorama, PointLight, RectangleLight, RectanglePlace, SkyImage,
    SphereLight, SpotCone, UniformSky,
};
use crate::spectrum::light_spectrum::LightSpectrum;

/// Builds a light.
pub(super) fn build_light(path: &KeyPath, light: &LightDescription, sources: &Sources) -> Result<Light, RenderError> {
    let lamp = spectrum(path, &light.lamp, sources)?;
    Ok(match &light.source {
        LightSource::Point(light) => {
            Light::Point(PointLight::new(point(light.position), &lamp, narrow(light.radiant_intensity_w_sr)))
        }
        LightSource::Spot(spot) => {
            let mut light = PointLight::new(point(spot.position), &lamp, narrow(spot.radiant_intensity_w_sr));
            let axis = (point(spot.look_at) - light.position).try_normalize();
            let axis = axis.ok_or_else(|| path.key("look_at").error("must not be the light's position"))?;
            light.cone = Some(SpotCone::new(axis, narrow(spot.inner_cone_deg), narrow(spot.outer_cone_deg)));
            Light::Point(light)
        }
        LightSource::Directional(light) => {
            let direction = point(light.direction).try_normalize();
            let direction = direction.ok_or_else(|| path.key("direction").error("must not be zero"))?;
            let irradiance = lamp.unit * narrow(light.irradiance_w_m2);
            Light::Directional(DirectionalLight { to_light: -direction, irradiance, relative: lamp.relative })
        }
        LightSource::Sphere(light) => {
            let shape = SphereLight { centre: point(light.position), radius_m: narrow(light.radius) };
            Light::Sphere(emitter(shape, &lamp, light.radiance_w_m2_sr, light.visible))
        }
        LightSource::Rectangle(light) => {
            let [width_m, height_m] = light.size.map(narrow);
            let place = RectanglePlace {
                centre: point(light.position),
                look_at: point(light.look_at),
                up: point(light.up),
                width_m,
                height_m,
            };
            let shape = RectangleLight::new(&place);
            let shape = shape.ok_or_else(|| {
                path.key("look_at").error("must not lie at the light's position or along its up axis")
            })?;
            Light::Rectangle(emitter(shape, &lamp, light.radiance_w_m2_sr, light.visible))
        }
    })
}

/// Builds the light from all directions.
pub(super) fn build_environment(
    path: &KeyPath,
    environment: &EnvironmentDescription,
    sources: &Sources,
) -> Result<Light, RenderError> {
    match environment {
        EnvironmentDescription::Uniform(sky) => {
            let lamp = spectrum(path, &sky.lamp, sources)?;
            Ok(Light::Sky(emitter(UniformSky, &lamp, sky.glow.radiance_w_m2_sr, sky.glow.visible)))
        }
        EnvironmentDescription::Image(sky) => {
            let panorama = Panorama::read_exr(sources.files, &sky.image)
                .map_err(|error| sources.named(&path.key("image"), &sky.image, error))?;
            let image = SkyImage::new(&panorama, narrow(sky.scale), narrow(sky.rotation_deg), !sources.is_false_color);
            let image = image.map_err(|reason| {
                RenderError::File(FileError::Content { path: sources.files.display_name(&sky.image), reason })
            })?;
            Ok(Light::Image(Box::new(image), sky.visible))
        }
    }
}

fn emitter<Shape>(shape: Shape, lamp: &LightSpectrum, radiance: f64, visible: bool) -> DiffuseEmitter<Shape> {
    let mut emitter = DiffuseEmitter::new(shape, lamp, narrow(radiance));
    emitter.visible = visible;
    emitter
}

/// The spectrum of a light; in false colour all are alike.
pub(super) fn spectrum(
    path: &KeyPath,
    lamp: &LampDescription,
    sources: &Sources,
) -> Result<LightSpectrum, RenderError> {
    let spectrum = match lamp {
        LampDescription::Illuminant(illuminant) => LightSpectrum::illuminant(*illuminant)
            .map_err(|error| path.key("illuminant").error(format!("is \"{illuminant}\": {error}")))?,
        LampDescription::File(file) => LightSpectrum::read(sources.files, file)
            .map_err(|error| sources.named(&path.key("spectrum"), file, error))?,
    };
    Ok(if sources.is_false_color { LightSpectrum::EQUAL_ENERGY } else { spectrum })
}
