//! Places of objects in the scene.

use glam::{DAffine3, DMat3, DVec3, EulerRot, Mat3A};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_base::{Numbers, narrow, short_number};
use snowblue_geometry::mesh_files::gltf::Y_UP_TO_Z_UP;
use snowblue_geometry::mesh_files::is_y_up;
use snowblue_geometry::shape::Shape;
use snowblue_geometry::transform::Transform;

use crate::values::{Coordinate, MAX_REACH_M, Rotation, Scale, UpAxis};

/// What all objects have.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ObjectSettings {
    /// Name of its material.
    pub material: String,
    /// The name in reports and mattes; by default the word of its shape, or the name of its mesh file. Several objects
    /// may have one name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Snow objects of the same body are one solid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub body: Option<String>,
    /// Where its origin lies, in m.
    #[serde(default)]
    pub position: Numbers<Coordinate, 3>,
    /// Rotations about x, then y, then z, in degrees; counter-clockwise seen from the axis' tip.
    #[serde(default)]
    pub rotation_deg: Numbers<Rotation, 3>,
    /// The stretch before the rotation: one factor, or one for each axis.
    #[serde(default)]
    pub scale: Scale,
}

impl ObjectSettings {
    /// The keys.
    pub(super) const KEYS: [&str; 6] = ["material", "name", "body", "position", "rotation_deg", "scale"];
}

/// Position, rotation and scale of a shape.
pub(crate) struct Placing {
    pub(super) position: DVec3,
    rotation: DMat3,
    pub(super) scale: DVec3,
}

impl Placing {
    /// The placing of an object.
    pub(super) fn of(settings: &ObjectSettings) -> Self {
        let scale = match settings.scale {
            Scale::Uniform(scale) => DVec3::splat(scale.get()),
            Scale::Axes(scales) => DVec3::from(scales.get().map(|scale| f64::from(narrow(scale)))),
        };
        Self { position: settings.position.get().into(), rotation: rotation(settings.rotation_deg), scale }
    }

    /// The directions of the shape's axes in the scene.
    pub(super) fn axes(&self) -> Mat3A {
        self.rotation.as_mat3().into()
    }

    /// The map from the shape's coordinates to the scene.
    pub(super) fn to_scene(&self) -> DAffine3 {
        DAffine3::from_mat3_translation(self.rotation * DMat3::from_diagonal(self.scale), self.position)
    }
}

/// The rotation that turns a mesh file upright, by the given upward axis or else by the upward axis of the file
/// format.
pub(super) fn upright(file: &str, up: Option<UpAxis>) -> DAffine3 {
    let y_up = up.map_or_else(|| is_y_up(file.as_ref()), |up| up == UpAxis::Y);
    DAffine3::from_mat3(if y_up { Y_UP_TO_Z_UP } else { DMat3::IDENTITY })
}

/// The rotations about x, then y, then z by some degrees.
pub(super) fn rotation(rotation_deg: Numbers<Rotation, 3>) -> DMat3 {
    let [x, y, z] = rotation_deg.get().map(|degrees| f64::from(narrow(degrees)).to_radians());
    DMat3::from_euler(EulerRot::ZYX, z, y, x)
}

/// The placement by a map, or the reason why the map is refused.
pub(crate) fn placement(to_scene: &DAffine3) -> Result<Transform, String> {
    Transform::new(to_scene).ok_or_else(|| "its transform flattens it, but must keep its volume".to_owned())
}

/// Refuses a shape that reaches farther than a scene may.
pub(crate) fn check_reach(shape: &Shape) -> Result<(), String> {
    let reach_m = shape.bounds().map_or(0.0, |bounds| bounds.greatest_coordinate());
    if f64::from(reach_m) <= MAX_REACH_M {
        return Ok(());
    }
    Err(format!(
        "reaches {} km from the origin around which the scene is computed, but must lie within {} km",
        short_number((f64::from(reach_m) / 1e3).round()),
        MAX_REACH_M / 1e3
    ))
}
