//! The whole scene as data.

use std::collections::BTreeMap;

use serde::Serialize;

use super::camera::CameraDescription;
use super::light::{EnvironmentDescription, LightDescription};
use super::material::MaterialDescription;
use super::object::ObjectDescription;
use super::sky::SkyDescription;
use crate::film::FilmSettings;
use crate::integrator::{IntegratorSettings, LightFieldSettings};

/// A scene as plain data.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct SceneDescription {
    /// A glTF whose meshes, lights and materials belong to the scene, and its camera where there is no other.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gltf: Option<String>,
    /// The camera; that of the glTF if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraDescription>,
    /// Size and brightness of the picture.
    pub film: FilmSettings,
    /// The integrator and its settings.
    pub integrator: IntegratorSettings,
    /// The grid of the light field in snow.
    pub light_field: LightFieldSettings,
    /// Materials by name.
    #[serde(rename = "material", skip_serializing_if = "BTreeMap::is_empty")]
    pub materials: BTreeMap<String, MaterialDescription>,
    /// Lights with a position or a direction.
    #[serde(rename = "light", skip_serializing_if = "Vec::is_empty")]
    pub lights: Vec<LightDescription>,
    /// Light from all directions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub environment: Option<EnvironmentDescription>,
    /// Sun and sky.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sky: Option<SkyDescription>,
    /// What is there.
    #[serde(rename = "object", skip_serializing_if = "Vec::is_empty")]
    pub objects: Vec<ObjectDescription>,
}

impl SceneDescription {
    /// Whether the camera may see a lamp or the sun.
    pub fn has_visible_emitters(&self) -> bool {
        let shows_sun = self.sky.as_ref().is_some_and(SkyDescription::has_visible_sun);
        shows_sun || self.lights.iter().any(|light| light.source.keys().is_visible_emitter())
    }

    /// Whether a material is snow.
    pub fn has_snow(&self) -> bool {
        self.materials.values().any(|material| matches!(material, MaterialDescription::Snow(_)))
    }

    /// Whether noise is filtered: that of random walks, of samples of a `sky`, and of light by other surfaces.
    pub fn is_filtered(&self) -> bool {
        self.integrator.filter && self.integrator.kind.has_light_field()
    }

    /// The scene as the text of a scene file.
    ///
    /// # Panics
    ///
    /// Never: every value has a notation in TOML.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("every value has a notation in TOML")
    }
}
