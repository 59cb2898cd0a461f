//! Light from all directions: even light, or an image.

use schemars::JsonSchema;
use serde::Serialize;
use snowblue_base::files::FileError;
use snowblue_base::toml_table::Table;
use snowblue_base::{KeyPath, Number, ParseError, narrow};

use crate::error::SceneError;
use crate::light::image::{ImageSkyDescription, SkyImage};
use crate::light::keys::LightKeys;
use crate::light::panorama::Panorama;
use crate::light::techniques::Light;
use crate::light::uniform_sky::SkyGlow;
use crate::sources::Sources;
use crate::spectrum::emission::EmissionSpectrum;

/// Light from all directions.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum EnvironmentDescription {
    /// Even light.
    Uniform {
        /// The shape of its spectrum.
        #[serde(flatten)]
        spectrum: EmissionSpectrum,
        /// Its strength.
        #[serde(flatten)]
        glow: SkyGlow,
    },
    /// The light of an image.
    Image(ImageSkyDescription),
}

impl EnvironmentDescription {
    /// Reads the light of an image if the table has the key `image`, otherwise even light.
    pub(crate) fn read(mut table: Table) -> Result<Self, ParseError> {
        if table.has("image") {
            return table.read().map(Self::Image);
        }
        let spectrum = table.split(&EmissionSpectrum::KEYS).read()?;
        Ok(Self::Uniform { spectrum, glow: table.read()? })
    }

    /// Builds the light.
    pub(crate) fn build(&self, path: &KeyPath, sources: &Sources) -> Result<Light, SceneError> {
        match self {
            Self::Uniform { spectrum, glow } => Ok(glow.light(path, &spectrum.build(path, sources)?)?),
            Self::Image(sky) => {
                let max_radiance = sky.max_radiance.map(Number::get);
                let panorama = Panorama::read(sources.files, &sky.image, sky.layer.as_deref(), max_radiance)
                    .map_err(|error| sources.named(&path.key("image"), &sky.image, error))?;
                let [scale, turn_deg] = [sky.scale.get(), sky.rotation_deg.get()].map(narrow);
                let image = SkyImage::new(&panorama, scale, turn_deg);
                let image = image.map_err(|reason| {
                    SceneError::File(FileError::Content { path: sources.files.display_name(&sky.image), reason })
                })?;
                Ok(Light::new(image).with_visibility(sky.visible))
            }
        }
    }
}
