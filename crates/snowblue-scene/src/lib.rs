#![doc = include_str!("../README.md")]
//!
//! # Data flow
//!
//! ```text
//! SceneFile (TOML) ─► SceneDescription ─► Scene ─┬─ objects: shapes and meshes, their intersections and chords
//!                             files ────────┘    ├─ materials: diffuse, glass and snow
//!                                                └─ lights, camera, film settings
//! ```
//!
//! A [`SceneDescription`] is plain data. [`SceneFile`] reads it from TOML, and [`SceneDescription::build`] makes a
//! [`Scene`] from it. The parts of a built scene fit together. To change the scene, change the description and build
//! it again.
//!
//! **Simplifications.** Faces are flat for depths, shadows and the offsets of rays; vertex normals are for shading
//! only.
//!
//! **Out of scope.** Light in snow, and pictures (`snowblue-light-field`, `snowblue-render`).

pub mod error;
mod sources;
mod values;

pub mod directions;
pub mod sampling;
pub mod spectrum;

pub mod film;
pub mod integrator;

pub mod camera;
pub mod light;
pub mod material;
pub mod objects;
pub mod queries;
pub mod seen;
pub mod transparency;
pub mod undisturbed;

mod layering;
mod local_origin;

pub mod air;
mod gltf;
pub mod shape;
pub mod sky;

mod build;
mod changes;
pub mod inspection;
pub mod progress;
pub mod provenance;
mod scene;
pub mod scene_file;

/// The tables and keys of a scene file, as plain data.
///
/// [`SceneDescription::build`] makes a [`Scene`] from them; a [`SceneFile`] is read from TOML. Lengths are in metres;
/// other units stand in the names of the keys.
pub mod description {
    pub use snowblue_base::{Count, Number, Numbers};

    pub use crate::camera::CameraDescription;
    pub use crate::light::{
        DirectionalLightDescription, EnvironmentDescription, ImageSkyDescription, LightDescription, LightSource,
        PointLightDescription, RectangleLightDescription, SkyGlow, SphereLightDescription, SpotLightDescription,
    };
    pub use crate::material::{
        DiffuseDescription, GlassDescription, LayeredSnowDescription, LayersTop, MaskDescription,
        MaskedSnowDescription, MaterialDescription, ReliefDescription, SnowDescription, SnowMaterialDescription,
        SparkleDescription, TextureDescription,
    };
    pub use crate::scene::SceneDescription;
    pub use crate::shape::{
        BoxDescription, CapsuleDescription, CarvedDescription, CropDescription, CylinderDescription, DepthDescription,
        DriftDescription, FootDescription, FootprintDescription, HalfSpaceDescription, HeightFieldDescription,
        HoleDescription, IglooDescription, ImprintDescription, MeshDescription, MoundDescription, NamedShape,
        ObjectDescription, ObjectSettings, PlaneDescription, ShapeDescription, SnowpackDescription,
        SolidBoxDescription, SolidDescription, SolidEllipsoidDescription, SphereDescription,
    };
    pub use crate::sky::{ClearSkyDescription, OvercastSkyDescription, SkyDescription, SunDescription};
    pub use crate::spectrum::emission::EmissionSpectrum;
    pub use crate::values::{ColorDescription, Coordinate, Direction, Fraction, Rotation, Scale, ShapeSize, UpAxis};
}

pub use changes::Changes;
pub use error::SceneError;
pub use integrator::{IntegratorKind, IntegratorSettings, LightFieldSettings, PathMode, PcaSnowSettings, Views};
pub use scene::{Scene, SceneDescription};
pub use scene_file::SceneFile;
