//! Light sources: their emission, the sampling of their points, and the light that arrives at a surface.
//!
//! A point of an area light acts as a point light, and a direction of the sky acts as a distant light. A surface
//! therefore asks for one `LightSample` after the other:
//!
//! | light | sample | irradiance E of a surface |
//! |---|---|---|
//! | point, spot | the point | I cos θ / r² |
//! | directional | the direction | E⊥ cos θ |
//! | sphere, rectangle | a point, by solid angle | L cos θ cos θ_l / (r² p), θ_l at the light, p per m² |
//! | sky of any kind, sun | a direction | L cos θ / p, p per sr |
//!
//! Where several techniques sample a light, p is the sum of their densities (see [`Light`]). Area lights are visible
//! but occlude nothing.
//!
//! **A new kind of light** needs a file here and a line in the list below. The file declares the keys of the light in
//! a scene file with their ranges (`LightKeys`), and implements `Emitter`: the place of the light, its sampling and
//! the density of its samples, and its emission. Everything else follows from these.

pub(crate) mod direction_table;
pub(crate) mod directional;
pub(crate) mod dome;
pub mod emitter;
pub(crate) mod environment;
pub(crate) mod image;
pub(crate) mod keys;
mod panorama;
pub(crate) mod point;
mod rectangle;
pub(crate) mod sample;
mod sphere;
pub(crate) mod spot;
pub(crate) mod sun;
mod techniques;
pub(crate) mod uniform_sky;

use schemars::JsonSchema;
use serde::Serialize;
use snowblue_base::toml_table::Table;
use snowblue_base::{KeyPath, ParseError};

use crate::error::SceneError;
use crate::sources::Sources;
use crate::spectrum::emission::EmissionSpectrum;
use crate::values::things;
use keys::LightKeys;

pub use directional::DirectionalLightDescription;
pub use environment::EnvironmentDescription;
pub use image::ImageSkyDescription;
pub use keys::{Irradiance, LightSize, PixelValue, Radiance, RadiantIntensity, SkyScale};
pub use panorama::Panorama;
pub use point::PointLightDescription;
pub use rectangle::RectangleLightDescription;
pub use sample::{IncidentLight, LightDirection, LightOrigin, LightSample, SHADOW_EPSILON};
pub use sphere::SphereLightDescription;
pub use spot::SpotLightDescription;
pub use techniques::{Light, LightHit, SamplingTechniques, irradiance_by_sky};
pub use uniform_sky::SkyGlow;

things! {
    /// The geometry and the strength of a light.
    LightSource by "type": dyn LightKeys {
        /// Shines from a point in all directions.
        "point" => Point(PointLightDescription),
        /// Shines from a point into a cone.
        "spot" => Spot(SpotLightDescription),
        /// Parallel light.
        "directional" => Directional(DirectionalLightDescription),
        /// A sphere that emits uniformly.
        "sphere" => Sphere(SphereLightDescription),
        /// A rectangle that emits from one side.
        "rectangle" => Rectangle(RectangleLightDescription),
    }
}

/// A light with a position or a direction.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct LightDescription {
    /// The shape of its spectrum.
    #[serde(flatten)]
    pub spectrum: EmissionSpectrum,
    /// Its geometry and strength.
    #[serde(flatten)]
    pub source: LightSource,
}

impl LightDescription {
    /// Reads a light.
    pub(crate) fn read(mut table: Table) -> Result<Self, ParseError> {
        Ok(Self { spectrum: table.split(&EmissionSpectrum::KEYS).read()?, source: LightSource::read(table)? })
    }

    /// Builds the light.
    pub(crate) fn build(&self, path: &KeyPath, sources: &Sources) -> Result<Light, SceneError> {
        Ok(self.source.keys().light(path, &self.spectrum.build(path, sources)?)?)
    }
}

impl From<LightSource> for LightDescription {
    /// A light of daylight, D65.
    fn from(source: LightSource) -> Self {
        Self { spectrum: EmissionSpectrum::default(), source }
    }
}

#[cfg(test)]
mod tests;
