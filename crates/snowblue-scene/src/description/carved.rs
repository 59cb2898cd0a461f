//! Snow heaped up and hollowed out, as data.

use serde::{Deserialize, Serialize};

use super::value::{Radii, numbers};

/// Solids heaped up and taken away, as one closed mesh.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CarvedDescription {
    /// Length of the cells of the mesh, in m.
    pub cell: f64,
    /// Distance from the edge at which joints of solids begin to be rounded, in m.
    #[serde(default)]
    pub rounding: f64,
    /// Height of the unevenness, in m.
    #[serde(default)]
    pub relief: f64,
    /// Length of the coarsest unevenness, in m.
    #[serde(default = "relief_length")]
    pub relief_length: f64,
    /// Seed of the unevenness.
    #[serde(default = "seed")]
    pub seed: u32,
    /// What is heaped up, at least one. The reader of scene files reads solids by their type.
    #[serde(skip_deserializing)]
    pub add: Vec<SolidDescription>,
    /// What is taken away.
    #[serde(skip_deserializing, skip_serializing_if = "Vec::is_empty")]
    pub remove: Vec<SolidDescription>,
}

fn relief_length() -> f64 {
    0.3
}

fn seed() -> u32 {
    1
}

/// A solid to heap up or to take away.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum SolidDescription {
    /// An ellipsoid.
    Ellipsoid(SolidEllipsoidDescription),
    /// A box.
    Box(SolidBoxDescription),
    /// The convex hull of two balls, as a round tunnel.
    Capsule(CapsuleDescription),
    /// A round cylinder with level ends.
    Cylinder(CylinderDescription),
    /// All behind a plane. It has no end and can only be taken away.
    HalfSpace(HalfSpaceDescription),
}

/// An ellipsoid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SolidEllipsoidDescription {
    /// Its centre, in m.
    #[serde(deserialize_with = "numbers")]
    pub centre: [f64; 3],
    /// Half its lengths along x, y and z before its rotation, in m.
    #[serde(deserialize_with = "numbers")]
    pub radii: [f64; 3],
    /// Rotations about x, then y, then z, in degrees.
    #[serde(default, deserialize_with = "numbers")]
    pub rotation_deg: [f64; 3],
}

/// A box.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SolidBoxDescription {
    /// Its centre, in m.
    #[serde(deserialize_with = "numbers")]
    pub centre: [f64; 3],
    /// Its lengths along x, y and z before its rotation, in m.
    #[serde(deserialize_with = "numbers")]
    pub size: [f64; 3],
    /// Rotations about x, then y, then z, in degrees.
    #[serde(default, deserialize_with = "numbers")]
    pub rotation_deg: [f64; 3],
    /// Radius of its edges, in m.
    #[serde(default)]
    pub edge: f64,
}

/// The convex hull of two balls.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CapsuleDescription {
    /// Centre of the first ball, in m.
    #[serde(deserialize_with = "numbers")]
    pub from: [f64; 3],
    /// Centre of the second ball, in m.
    #[serde(deserialize_with = "numbers")]
    pub to: [f64; 3],
    /// Their radius, or the radius of each, in m.
    pub radius: Radii,
}

/// A round cylinder with level ends.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CylinderDescription {
    /// Centre of its first end, in m.
    #[serde(deserialize_with = "numbers")]
    pub from: [f64; 3],
    /// Centre of its second end, in m.
    #[serde(deserialize_with = "numbers")]
    pub to: [f64; 3],
    /// Its radius, in m.
    pub radius: f64,
    /// Radius of its edges, in m.
    #[serde(default)]
    pub edge: f64,
}

/// All behind a plane.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HalfSpaceDescription {
    /// A point of the plane, in m.
    #[serde(deserialize_with = "numbers")]
    pub point: [f64; 3],
    /// Direction out of the half-space, of any length.
    #[serde(deserialize_with = "numbers")]
    pub normal: [f64; 3],
}
