//! Scenes from TOML files: metres, degrees, watts; z is up unless the camera says otherwise.
//!
//! The types of [`description`](crate::description) are the tables and keys of a file, each with its unit and range.
//!
//! Powers of lights are totals of 31 bands of 10 nm around 400, 410, …, 700 nm.
//!
//! Boxes and spheres are placed by their centre, a mesh by its own origin, a plane by any point of it. A plane faces z
//! until it is turned. Rotations are about x, then y, then z, each counter-clockwise seen from the axis' tip; scale
//! comes before rotation, position after. File names are relative to the folder of the scene file. glTF has y upwards
//! and is turned to z; `up` overrides this for single meshes. `part` is an object, group or material of an OBJ file, or
//! a node or mesh of a glTF. With `smooth = false` the faces of a mesh are shaded as flat faces. A material of a glTF
//! is the material of the same name in the scene file; without such a material it is diffuse, with its base colour.
//! Heights, row by row from far to near, are multiplied by the third number of `size`; a level `bottom` closes the
//! solid. On a georeferenced map, x is east and y is north, the origin is the middle of the map or of `crop`, and the
//! height at the origin lies at z = 0 unless `datum` gives another height. Snow of a depth lies on ground that is
//! another object. Prints are pressed into surfaces of heights. A drift is snow of a depth below z = 0, with mounds
//! above it. An igloo has one object for each block; all its blocks belong to one body. Carved snow is the union of the
//! added solids without the union of the removed solids. Snow objects with the same `body` are one solid.
//! [`texture`](crate::material::texture) describes where an image lies on a shape, [`snow`](crate::material::snow) the
//! effect of a mask, and [`layer_file`](snowblue_transport::layer_file) the format of a file of layers.
//!
//! Under a sky x points east and y north; azimuths run from north by way of east, and the sun must be above the
//! horizon. Below the horizon the sky is dark.

use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::de::Error;
use serde::{Deserialize, Deserializer};
use snowblue_base::ParseError;
use snowblue_base::files::{FileError, FileSource, FilesIn, checked_text};
use snowblue_base::toml_table::Table;
use snowblue_transport::layer_file::declare_substances;

use crate::error::SceneError;
use crate::light::{EnvironmentDescription, LightDescription};
use crate::material::MaterialDescription;
use crate::scene::{Scene, SceneDescription};
use crate::shape::ObjectDescription;
use crate::sky::SkyDescription;

/// A scene file that was read: its description, and where in the file its values stand.
#[derive(Debug, Clone)]
pub struct SceneFile {
    /// The content of the file. It may be changed before the scene is built.
    pub description: SceneDescription,
    path: PathBuf,
    text: String,
}

impl SceneFile {
    /// Reads a scene file.
    ///
    /// # Errors
    ///
    /// When it cannot be read, a key is unknown or missing, or a value is out of range. The message names the file and
    /// the line.
    pub fn open(path: &Path) -> Result<Self, SceneError> {
        let bytes = std::fs::read(path).map_err(|source| FileError::Read { path: path.into(), source })?;
        let text = checked_text(path, &bytes)?;
        Self::parse(text, path)
    }

    /// Reads a scene from its text. Errors name `path`, and [`build`](Self::build) looks for files beside it.
    ///
    /// # Errors
    ///
    /// This fails as [`open`](Self::open) does.
    pub fn parse(text: impl Into<String>, path: impl Into<PathBuf>) -> Result<Self, SceneError> {
        let mut file = Self { description: SceneDescription::default(), path: path.into(), text: text.into() };
        file.description = SceneDescription::parse(&file.text).map_err(|error| file.error(error))?;
        Ok(file)
    }

    /// Builds the scene, with the files beside the scene file.
    ///
    /// # Errors
    ///
    /// When a changed value is out of range, or a file is missing or malformed.
    pub fn build(&self) -> Result<Scene, SceneError> {
        self.build_smooth()?.with_relief(&|_| {}).map_err(|error| self.locate(error))
    }

    /// Builds the scene like [`build`](Self::build), without the relief of its snow, which [`Scene::with_relief`] adds.
    ///
    /// # Errors
    ///
    /// As [`build`](Self::build).
    pub fn build_smooth(&self) -> Result<Scene, SceneError> {
        self.description.build_smooth(&FilesIn::beside(&self.path)).map_err(|error| self.locate(error))
    }

    /// The paths of this file and of all files that were read when it was built as `scene`.
    pub fn inputs(&self, scene: &Scene) -> Vec<PathBuf> {
        let files = FilesIn::beside(&self.path);
        let others = scene.file_hashes().into_keys().map(|name| files.display_name(name));
        std::iter::once(self.path.clone()).chain(others).collect()
    }

    /// Adds the file and the line to an error about a value.
    #[must_use]
    pub fn locate(&self, error: SceneError) -> SceneError {
        match error {
            SceneError::Description(error) => self.error(error.in_text(&self.text)),
            other => other,
        }
    }

    /// The error at a place of the text.
    fn error(&self, error: ParseError) -> SceneError {
        SceneError::Text { path: self.path.clone(), line: error.line(&self.text), reason: error.reason }
    }
}

/// Reads a description from any format that serde reads, with the keys of a scene file.
impl<'de> Deserialize<'de> for SceneDescription {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = toml::Table::deserialize(deserializer)?.to_string();
        Self::parse(&text).map_err(D::Error::custom)
    }
}

impl SceneDescription {
    /// Reads the text of a scene file.
    fn parse(text: &str) -> Result<Self, ParseError> {
        let mut root = Table::parse(text)?;
        let substances = declare_substances(&mut root)?;
        let mut things = |key| root.take_tables(key);
        let lights: Result<_, _> = things("light")?.into_iter().map(LightDescription::read).collect();
        let objects: Result<_, _> = things("object")?.into_iter().map(ObjectDescription::read).collect();
        let materials = root.take_table("material")?.map_or(Ok(Vec::new()), Table::into_tables)?;
        let materials = materials.into_iter().map(|(name, table)| Ok((name, MaterialDescription::read(table)?)));
        let scene = Self {
            gltf: root.take_as("gltf")?,
            camera: root.take_as("camera")?,
            film: root.take_as("film")?.unwrap_or_default(),
            integrator: root.take_as("integrator")?.unwrap_or_default(),
            light_field: root.take_as("light_field")?.unwrap_or_default(),
            substances,
            materials: materials.collect::<Result<_, ParseError>>()?,
            lights: lights?,
            environment: root.take_table("environment")?.map(EnvironmentDescription::read).transpose()?,
            sky: root.take_table("sky")?.map(SkyDescription::read).transpose()?,
            objects: objects?,
            local_origin: DVec3::ZERO,
        };
        root.finish()?;
        Ok(scene)
    }
}

impl Scene {
    /// Reads a scene file and builds it with the files beside it.
    ///
    /// # Errors
    ///
    /// When a file is missing or malformed, a key is unknown or missing, or a value is out of range. The message names
    /// the file and the line.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        SceneFile::open(path.as_ref())?.build()
    }
}
