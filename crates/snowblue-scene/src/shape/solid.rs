//! Solids of carved snow.

use glam::DVec3;
use schemars::JsonSchema;
use serde::de::Deserializer;
use serde::{Deserialize, Serialize};
use snowblue_base::{KeyError, KeyPath, Number, Numbers, ParameterRange, quantities};
use snowblue_shapes::carved::Solid;

use super::placing::rotation;
use crate::values::{Direction, Notations, Rotation, point, things, unit_vector};

/// Greatest coordinate of carved snow, which a mesh of single precision resolves, in m.
pub(super) const MAX_REACH_M: f64 = 1000.0;

quantities! {
    /// A coordinate of carved snow.
    pub CarvedCoordinate = ParameterRange::new("coordinate", -MAX_REACH_M, MAX_REACH_M, "m");
    /// A size of a solid of carved snow.
    pub SolidSize = ParameterRange::new("size of a solid", 1e-4, MAX_REACH_M, "m");
    /// Radius of the edges of a solid.
    pub EdgeRadius = ParameterRange::new("radius of edges", 0.0, MAX_REACH_M, "m");
}

things! {
    /// A solid to add or to remove.
    SolidDescription by "type": dyn SolidKeys {
        /// An ellipsoid.
        "ellipsoid" => Ellipsoid(SolidEllipsoidDescription),
        /// A box.
        "box" => Box(SolidBoxDescription),
        /// The convex hull of two balls, as a round tunnel.
        "capsule" => Capsule(CapsuleDescription),
        /// A round cylinder with level ends.
        "cylinder" => Cylinder(CylinderDescription),
        /// The space behind a plane. It has no end and can only be removed.
        "half_space" => HalfSpace(HalfSpaceDescription),
    }
}

/// The keys of one kind of solid.
pub(crate) trait SolidKeys {
    /// Builds the solid.
    fn build(&self, path: &KeyPath) -> Result<Solid, KeyError>;
}

/// An ellipsoid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SolidEllipsoidDescription {
    /// Its centre, in m.
    pub centre: Numbers<CarvedCoordinate, 3>,
    /// Half its lengths along x, y and z before its rotation, in m.
    pub radii: Numbers<SolidSize, 3>,
    /// Rotations about x, then y, then z, in degrees.
    #[serde(default)]
    pub rotation_deg: Numbers<Rotation, 3>,
}

/// A box.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SolidBoxDescription {
    /// Its centre, in m.
    pub centre: Numbers<CarvedCoordinate, 3>,
    /// Its lengths along x, y and z before its rotation, in m.
    pub size: Numbers<SolidSize, 3>,
    /// Rotations about x, then y, then z, in degrees.
    #[serde(default)]
    pub rotation_deg: Numbers<Rotation, 3>,
    /// Radius of its edges, in m; at most half its shortest length.
    #[serde(default)]
    pub edge: Number<EdgeRadius>,
}

/// The convex hull of two balls.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CapsuleDescription {
    /// Centre of the first ball, in m.
    pub from: Numbers<CarvedCoordinate, 3>,
    /// Centre of the second ball, in m.
    pub to: Numbers<CarvedCoordinate, 3>,
    /// Their radius, or the radius of each, in m.
    pub radius: Radii,
}

/// Radii of the two ends of a capsule: one for both, or one for each.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Radii {
    /// The radius of both ends, in m.
    Both(Number<SolidSize>),
    /// At the first and at the second end, in m.
    Ends(Numbers<SolidSize, 2>),
}

/// A round cylinder with level ends.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CylinderDescription {
    /// Centre of its first end, in m.
    pub from: Numbers<CarvedCoordinate, 3>,
    /// Centre of its second end, in m.
    pub to: Numbers<CarvedCoordinate, 3>,
    /// Its radius, in m.
    pub radius: Number<SolidSize>,
    /// Radius of its edges, in m; at most its radius and half its length.
    #[serde(default)]
    pub edge: Number<EdgeRadius>,
}

/// The space behind a plane.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HalfSpaceDescription {
    /// A point of the plane, in m.
    pub point: Numbers<CarvedCoordinate, 3>,
    /// Direction out of the half-space, of any length.
    pub normal: Numbers<Direction, 3>,
}

impl SolidDescription {
    /// Whether the solid is bounded in all directions.
    pub(super) fn is_bounded(&self) -> bool {
        !matches!(self, Self::HalfSpace(_))
    }
}

impl SolidKeys for SolidEllipsoidDescription {
    fn build(&self, _: &KeyPath) -> Result<Solid, KeyError> {
        Ok(Solid::Ellipsoid {
            centre: self.centre.get().into(),
            axes: rotation(self.rotation_deg),
            radii_m: self.radii.get().into(),
        })
    }
}

impl SolidKeys for SolidBoxDescription {
    fn build(&self, path: &KeyPath) -> Result<Solid, KeyError> {
        let size_m = self.size.get();
        Ok(Solid::Box {
            centre: self.centre.get().into(),
            axes: rotation(self.rotation_deg),
            size_m: size_m.into(),
            edge_m: edge_of_at_most(path, self.edge, 0.5 * size_m.into_iter().fold(f64::INFINITY, f64::min))?,
        })
    }
}

impl SolidKeys for CapsuleDescription {
    fn build(&self, path: &KeyPath) -> Result<Solid, KeyError> {
        length_m(path, self.from, self.to)?;
        let radii_m = match self.radius {
            Radii::Both(radius) => [radius.get(); 2],
            Radii::Ends(radii) => radii.get(),
        };
        Ok(Solid::Capsule { from: self.from.get().into(), to: self.to.get().into(), radii_m })
    }
}

impl<'de> Deserialize<'de> for Radii {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Notations {
            expected: "a number or a list of two",
            number: Some(Self::Both),
            word: None,
            list: Some(Self::Ends),
        })
    }
}

impl SolidKeys for CylinderDescription {
    fn build(&self, path: &KeyPath) -> Result<Solid, KeyError> {
        let (half_m, radius_m) = (0.5 * length_m(path, self.from, self.to)?, self.radius.get());
        Ok(Solid::Cylinder {
            from: self.from.get().into(),
            to: self.to.get().into(),
            radius_m,
            edge_m: edge_of_at_most(path, self.edge, half_m.min(radius_m))?,
        })
    }
}

impl SolidKeys for HalfSpaceDescription {
    fn build(&self, path: &KeyPath) -> Result<Solid, KeyError> {
        unit_vector(&path.key("normal"), point(self.normal), "is [0, 0, 0], but must not be zero")?;
        let normal = DVec3::from(self.normal.get()).normalize();
        Ok(Solid::HalfSpace { point: self.point.get().into(), normal })
    }
}

/// The distance between two points that must not coincide, in m.
fn length_m(
    path: &KeyPath,
    from: Numbers<CarvedCoordinate, 3>,
    to: Numbers<CarvedCoordinate, 3>,
) -> Result<f64, KeyError> {
    let axis = point(to) - point(from);
    unit_vector(&path.key("to"), axis, "must not be the point `from`")?;
    Ok(axis.length().into())
}

fn edge_of_at_most(path: &KeyPath, edge: Number<EdgeRadius>, most_m: f64) -> Result<f64, KeyError> {
    let edge_m = edge.get();
    if edge_m <= most_m {
        return Ok(edge_m);
    }
    Err(path.key("edge").error(format!("is {edge_m} m, but must be at most {most_m} m for its size")))
}
