//! Scenes from TOML files: metres, degrees, watts; z is up unless the camera says otherwise.
//!
//! ```toml
//! gltf = "FILE.glb"        # all its meshes and lights, and its camera where there is no [camera]; before all tables
//! [camera]                 # position, look_at, up = [0, 0, 1], vertical_fov_deg = 40, aperture = 0, focus
//! [film]                   # width = 1080, height = 1080, exposure = "auto" or stops, white = "D65" or "sky"
//! [integrator]             # samples_per_pixel = 64, noise_target, filter = true, max_bounces = 8, seed = 1,
//!                          # type = "hybrid" | "diffusion" | "pcasnow" | "reference"
//! [integrator.pcasnow]     # path = "brightest" | "normal" | "light" | "view", reflectance (else that of the curves),
//!                          #   table = "FILE.nc" (else the embedded one)
//! [light_field]            # of diffusion and hybrid: memory_mib = 1024, step_mm (of cells at the surface)
//!                          #   or nodes (of a body, about), else as its snow needs; views = "camera" | "all"
//! [material.NAME]          # type = "diffuse": one of reflectance = 0.5,
//!                          #   reflectance_rgb = [r, g, b] (linear sRGB) or "#rrggbb" (encoded sRGB),
//!                          #   reflectance_spectrum = "FILE.csv" (wavelength_nm,value),
//!                          #   texture = "FILE.png" (encoded sRGB), texture_scale_m = 1
//!                          # type = "snow": what it is made of (`snowblue_transport::sample::SnowKeys`):
//!                          #   snow = "fresh" | … (a kind), grain_size_um = 400 or [LEAST, GREATEST], size_measure,
//!                          #   ssa_m2_kg, facetness = 0.3, sphericity, density_kg_m3 = 300, water_saturation = 0,
//!                          #   impurities_ng_g = { black-carbon = 0, … }, temperature_c = -5, ice; or two of these,
//!                          #   between = [{ … }, { … }], and mask = { texture = "FILE.png", texture_scale_m = 1 } or
//!                          #   mask = { attribute = "NAME", range = [0, 1] }; or
//!                          #   layers = "FILE.toml" (as `spectrum --layers`), layers_top = "surface" or a height z;
//!                          #   and sparkle = false, true or { facet_size_um, flat_fraction = 1 },
//!                          #   relief = "fresh" | … (a kind) or { height_mm, correlation_mm, hurst = 0.5, seed = 1 }
//! [[light]]                # illuminant = "D65" or spectrum = "FILE.csv" (wavelength_nm,value), and
//!                          # type = "point": position, radiant_intensity_w_sr
//!                          # type = "spot": position, look_at, radiant_intensity_w_sr, inner_cone_deg = 0,
//!                          #   outer_cone_deg = 45
//!                          # type = "directional": direction (in which it shines), irradiance_w_m2
//!                          # type = "sphere": position, radius, radiance_w_m2_sr, visible = true
//!                          # type = "rectangle": position, look_at, up = [0, 0, 1], size (width, height),
//!                          #   radiance_w_m2_sr, visible = true
//! [environment]            # radiance_w_m2_sr, illuminant or spectrum, visible = true; or
//!                          # image = "FILE.exr", scale = 1, rotation_deg = 0 (about z), visible = true
//! [sky]                    # type = "clear" (default): sun, turbidity = 3 (1 to 10), ground_albedo (else that of the
//!                          #   snow), scale = 1, aerial_perspective = false, visible = true; type = "overcast":
//!                          #   irradiance_w_m2 (of level ground) or sun, illuminant or spectrum, visible = true
//!                          # sun = { towards = [x, y, z] }, { elevation_deg, azimuth_deg = 180 } or { latitude_deg,
//!                          #   longitude_deg, date = "2026-02-01", time = "12:00", utc_offset_h = 0 }
//! [[object]]               # shape = "box": size; shape = "sphere": radius; shape = "plane";
//!                          # shape = "heights": bottom, heights = [[…], …] or file = "FILE.png" | "FILE.exr" |
//!                          #   "FILE.asc" | "FILE.tif", and the keys of a grid: size (else the map's), datum, fill,
//!                          #   crop = { centre, size }, tolerance;
//!                          # shape = "snowpack": heights = [[…], …] or ground = "FILE.tif" | …, with the keys of a
//!                          #   grid, or ground = "FILE.ply" | … with part, up;
//!                          #   depth = 0.8 | { texture = "FILE.png", range = [0, 1] } |
//!                          #   { attribute = "NAME", range = [0, 1] }, least_depth = 0.001, gap;
//!                          # shape = "drift": size (x, y, depth), mounds = [[x, y, height, radius], …],
//!                          #   relief = 0, seed = 1;
//!                          # shape = "igloo": inner_radius = 1.5, wall = 0.15, courses = 6, block_width = 0.6,
//!                          #   seam_depth = wall / 4, seam_width = 0.05, seed = 1;
//!                          # shape = "carved": cell, rounding = 0, relief = 0, relief_length = 0.3, seed = 1, and
//!                          #   below it [[object.add]] and [[object.remove]];
//!                          # or mesh = "FILE.ply" | "FILE.obj" | "FILE.stl" | "FILE.glb" | "FILE.gltf": part,
//!                          #   up = "y" | "z", smooth = true
//!                          # scale = 1 or [1, 1, 1], position = [0, 0, 0], rotation_deg = [0, 0, 0], material, body
//! [[object.imprint]]       # into heights, drift, and snowpack on heights:
//!                          # type = "hole": position = [x, y], radius, depth, taper_deg = 2, rim = 0,
//!                          #   rim_width = 2 radius
//!                          # type = "footprint": position = [x, y], heading_deg = 0, foot = "right" | "left",
//!                          #   length = 0.3, depth, toe_depth = depth, tread = 0.004, taper_deg = 8, rim = 0,
//!                          #   rim_width = length / 6
//! [[object.add]]           # of carved snow, as [[object.remove]]:
//!                          # type = "ellipsoid": centre, radii, rotation_deg = [0, 0, 0];
//!                          # type = "box": centre, size, rotation_deg = [0, 0, 0], edge = 0;
//!                          # type = "capsule": from, to, radius or radius = [at from, at to];
//!                          # type = "cylinder": from, to, radius, edge = 0;
//!                          # type = "half_space" (only removed): point, normal (out of it)
//! ```
//!
//! Powers of lights are totals of 31 bands of 10 nm around 400, 410, …, 700 nm.
//!
//! Boxes and spheres are placed by their centre, a mesh by its own origin, a plane by any point of it. A plane faces z
//! until it is turned. Rotations are about x, then y, then z, each counter-clockwise seen from the axis' tip; scale
//! comes before rotation, position after. File names are relative to the folder of the scene file. glTF has y upwards
//! and is turned to z; `up` overrides this for single meshes. `part` is an object or group of an OBJ file, or a node or
//! mesh of a glTF. With `smooth = false` the faces of a mesh are shaded as flat ones. A glTF's materials are those of
//! the scene file under the same names, and else diffuse, with their base colour. Heights, row by row from far to near,
//! are multiplied by the third number of `size`; a level `bottom` closes the solid. On a georeferenced map, x is east
//! and y is north, the origin is the middle of the map or of `crop`, and the height there lies at z = 0 unless `datum`
//! says another. Snow of a depth lies on ground that is another object. Prints are pressed into surfaces of heights. A
//! drift is snow of a depth below z = 0, with mounds above it. An igloo is one object for each block, all of one body.
//! Carved snow is the union of the solids that it adds without those that it removes. Snow objects of one `body` are
//! one solid. [`texture`](crate::material::texture) says where an image lies on a shape,
//! [`snow`](crate::material::snow) what a mask does, [`layer_file`](snowblue_transport::layer_file) what a file
//! of layers is.
//!
//! Under a sky x points east and y north; azimuths run from north by way of east, and the sun must be above the
//! horizon. Below the horizon the sky is dark.

mod place;
mod reader;

use std::path::{Path, PathBuf};

use serde::de::Error;
use serde::{Deserialize, Deserializer};
use toml::de::DeTable;

use crate::Scene;
use crate::description::SceneDescription;
use crate::error::SceneError;

use place::span_of;
use reader::read_description;
use snowblue_base::files::{FileError, FileSource, FilesIn};
use snowblue_base::toml_value::{Mistake, parse};

pub(crate) use place::line_of;

/// A scene file that was read: its description, and where in the file its values stand.
#[derive(Debug, Clone)]
pub struct SceneFile {
    /// What the file says. It may be changed before the scene is built.
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
        let bytes =
            std::fs::read(path).map_err(|source| SceneError::File(FileError::Read { path: path.into(), source }))?;
        let text = String::from_utf8(bytes).map_err(|error| {
            let text = &error.as_bytes()[..error.utf8_error().valid_up_to()];
            let line = 1 + text.iter().filter(|byte| **byte == b'\n').count();
            SceneError::Text { path: path.into(), line, reason: "the line is not text (UTF-8)".to_owned() }
        })?;
        Self::parse(text, path)
    }

    /// Reads a scene from its text. Errors name `path`, and [`build`](Self::build) looks for files beside it.
    ///
    /// # Errors
    ///
    /// As those of [`open`](Self::open).
    pub fn parse(text: impl Into<String>, path: impl Into<PathBuf>) -> Result<Self, SceneError> {
        let mut file = Self { description: SceneDescription::default(), path: path.into(), text: text.into() };
        file.description = description_of(&file.text).map_err(|mistake| file.mistake(mistake))?;
        file.description.check().map_err(|error| file.locate(error.into()))?;
        Ok(file)
    }

    /// Builds the scene, with the files beside the scene file.
    ///
    /// # Errors
    ///
    /// When a changed value is out of range, or a file is missing or malformed.
    pub fn build(&self) -> Result<Scene, SceneError> {
        // Values out of range are changed ones, since those of the file were checked: the file has no line of them.
        self.description.check()?;
        self.description.build_checked(&FilesIn::beside(&self.path)).map_err(|error| self.locate(error))
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
            SceneError::Description(error) => {
                let span = DeTable::parse(&self.text).map_or(0..0, |root| span_of(&root, &error.path));
                self.mistake(Mistake { span, reason: error.to_string() })
            }
            other => other,
        }
    }

    /// The error of a mistake in the text.
    fn mistake(&self, Mistake { span, reason }: Mistake) -> SceneError {
        SceneError::Text { path: self.path.clone(), line: line_of(&self.text, span.start), reason }
    }
}

/// Reads a description from any format that serde reads, with the keys of a scene file.
impl<'de> Deserialize<'de> for SceneDescription {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = toml::Table::deserialize(deserializer)?.to_string();
        description_of(&text).map_err(|mistake| D::Error::custom(mistake.reason))
    }
}

/// The description that a text gives.
fn description_of(text: &str) -> Result<SceneDescription, Mistake> {
    read_description(parse(text)?)
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
