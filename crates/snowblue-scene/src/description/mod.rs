//! A scene as plain data, which mirrors the tables and keys of a scene file.
//!
//! [`SceneDescription::build`] makes a [`Scene`](crate::Scene) of it; a [`SceneFile`](crate::file::SceneFile)
//! is read from TOML. Lengths are in metres; other units stand in the names of the keys.

pub(crate) mod camera;
pub(crate) mod carved;
mod check;
pub(crate) mod landscape;
pub(crate) mod light;
pub(crate) mod material;
pub(crate) mod object;
pub(crate) mod range;
mod scene;
pub(crate) mod sky;
pub(crate) mod value;

pub use camera::CameraDescription;
pub use carved::{
    CapsuleDescription, CarvedDescription, CylinderDescription, HalfSpaceDescription, SolidBoxDescription,
    SolidDescription, SolidEllipsoidDescription,
};
pub use check::{BOUNCES, FIELD_MEMORY_MIB, FIELD_STEP_RANGE, NOISE_TARGET_RANGE, SAMPLES_PER_PIXEL, SIDE_PIXELS};
pub use landscape::{
    CropDescription, DepthDescription, FootDescription, FootprintDescription, GridSettings, GroundSource,
    HeightFieldDescription, HeightSource, HoleDescription, ImprintDescription, SnowpackDescription,
};
pub use light::{EnvironmentDescription, LampDescription, LightDescription, UniformSkyDescription};
pub use material::{
    DiffuseDescription, LayeredSnowDescription, LayersTop, MaskDescription, MaskedSnowDescription, MaterialDescription,
    ReliefDescription, ReliefKind, SnowDescription, SnowMaterialDescription, SparkleDescription, TextureDescription,
};
pub use object::{
    BoxDescription, DriftDescription, IglooDescription, MeshDescription, MoundDescription, ObjectDescription,
    ObjectSettings, PlaneDescription, ShapeDescription, SphereDescription,
};
pub use scene::SceneDescription;
pub use sky::{ClearSkyDescription, OvercastSkyDescription, OvercastStrength, SkyDescription, SunDescription};
pub use value::{ColorDescription, Radii, Scale, UpAxis};

pub use crate::light::descriptions::*;
pub use crate::light::image::ImageSkyDescription;
pub use crate::light::uniform_sky::SkyGlow;
