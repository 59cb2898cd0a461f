//! Lights.

use snowblue_base::files::FileError;
use snowblue_geometry::ray::narrow;

use crate::assembling::sources::Sources;
use crate::description::{EnvironmentDescription, LampDescription, LightDescription};
use crate::error::SceneError;
use crate::light::image::SkyImage;
use crate::light::keys::LightKeys;
use crate::light::{Light, Panorama};
use crate::spectrum::light_spectrum::LightSpectrum;
use snowblue_base::KeyPath;

/// Builds a light.
pub(super) fn build_light(path: &KeyPath, light: &LightDescription, sources: &Sources) -> Result<Light, SceneError> {
    let spectrum = spectrum(path, &light.lamp, sources)?;
    Ok(light.source.keys().light(path, &spectrum)?)
}

/// Builds the light from all directions.
pub(super) fn build_environment(
    path: &KeyPath,
    environment: &EnvironmentDescription,
    sources: &Sources,
) -> Result<Light, SceneError> {
    match environment {
        EnvironmentDescription::Uniform(sky) => {
            let spectrum = spectrum(path, &sky.lamp, sources)?;
            Ok(sky.glow.light(path, &spectrum)?)
        }
        EnvironmentDescription::Image(sky) => {
            let panorama = Panorama::read_exr(sources.files, &sky.image)
                .map_err(|error| sources.named(&path.key("image"), &sky.image, error))?;
            let image = SkyImage::new(&panorama, narrow(sky.scale), narrow(sky.rotation_deg));
            let image = image.map_err(|reason| {
                SceneError::File(FileError::Content { path: sources.files.display_name(&sky.image), reason })
            })?;
            Ok(Light::new(image).with_visibility(sky.visible))
        }
    }
}

/// The spectrum of a light.
pub(super) fn spectrum(path: &KeyPath, lamp: &LampDescription, sources: &Sources) -> Result<LightSpectrum, SceneError> {
    match lamp {
        LampDescription::Illuminant(illuminant) => LightSpectrum::illuminant(*illuminant)
            .map_err(|error| path.key("illuminant").error(format!("is \"{illuminant}\": {error}")).into()),
        LampDescription::File(file) => {
            LightSpectrum::read(sources.files, file).map_err(|error| sources.named(&path.key("spectrum"), file, error))
        }
    }
}
