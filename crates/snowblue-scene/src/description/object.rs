//! Objects as data.

use serde::{Deserialize, Serialize};

use super::carved::CarvedDescription;
use super::landscape::{HeightFieldDescription, ImprintDescription, SnowpackDescription};
use super::value::{Scale, UpAxis, numbers};

/// A shape with a transform and a material.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ObjectDescription {
    /// Its shape.
    #[serde(flatten)]
    pub shape: ShapeDescription,
    /// What it is made of and where it is.
    #[serde(flatten)]
    pub common: ObjectSettings,
    /// What is pressed into its surface: into heights, drifts and snow on heights.
    #[serde(rename = "imprint", skip_serializing_if = "Vec::is_empty")]
    pub imprints: Vec<ImprintDescription>,
}

/// What all objects have.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectSettings {
    /// Name of its material.
    pub material: String,
    /// Snow objects of the same body are one solid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub body: Option<String>,
    /// Where its origin lies, in m.
    #[serde(default, deserialize_with = "numbers")]
    pub position: [f64; 3],
    /// Rotations about x, then y, then z, in degrees; counter-clockwise seen from the axis' tip.
    #[serde(default, deserialize_with = "numbers")]
    pub rotation_deg: [f64; 3],
    /// The stretch before the rotation.
    #[serde(default)]
    pub scale: Scale,
}

impl ObjectSettings {
    /// Names of the keys.
    pub(crate) const NAMES: [&str; 5] = ["material", "body", "position", "rotation_deg", "scale"];
}

impl ObjectDescription {
    /// A shape of a material, unturned at the origin.
    pub fn new(shape: ShapeDescription, material: impl Into<String>) -> Self {
        let common = ObjectSettings {
            material: material.into(),
            body: None,
            position: [0.0; 3],
            rotation_deg: [0.0; 3],
            scale: Scale::default(),
        };
        Self { shape, common, imprints: Vec::new() }
    }

    /// The same shape with another transform.
    #[must_use]
    pub fn at(mut self, position: [f64; 3]) -> Self {
        self.common.position = position;
        self
    }
}

impl Default for Scale {
    fn default() -> Self {
        Self::Uniform(1.0)
    }
}

/// A shape.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "shape", rename_all = "snake_case")]
pub enum ShapeDescription {
    /// A box about the origin.
    Box(BoxDescription),
    /// A sphere about the origin.
    Sphere(SphereDescription),
    /// The endless plane z = 0.
    Plane(PlaneDescription),
    /// A solid under a surface of heights.
    Heights(HeightFieldDescription),
    /// Ground under snow, with mounds.
    Drift(DriftDescription),
    /// Snow on a surface of heights or on a mesh.
    Snowpack(SnowpackDescription),
    /// An igloo, one object for each block.
    Igloo(IglooDescription),
    /// Snow heaped up and hollowed out.
    Carved(CarvedDescription),
    /// A mesh from a file.
    #[serde(untagged)]
    Mesh(MeshDescription),
}

/// A box about the origin.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxDescription {
    /// Its lengths along x, y and z, in m.
    #[serde(deserialize_with = "numbers")]
    pub size: [f64; 3],
}

/// A sphere about the origin.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SphereDescription {
    /// Its radius, in m.
    pub radius: f64,
}

/// The endless plane z = 0.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaneDescription {}

/// Ground under snow, with mounds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DriftDescription {
    /// Lengths along x and y, and the depth below z = 0, in m.
    #[serde(deserialize_with = "numbers")]
    pub size: [f64; 3],
    /// The mounds.
    #[serde(default)]
    pub mounds: Vec<MoundDescription>,
    /// Height of the unevenness, in m.
    #[serde(default)]
    pub relief: f64,
    /// Seed of the unevenness.
    #[serde(default = "one")]
    pub seed: u32,
}

/// A mound, written as a list of four numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(from = "MoundRow", into = "[f64; 4]")]
pub struct MoundDescription {
    /// Its middle, in m.
    pub x: f64,
    /// Its middle, in m.
    pub y: f64,
    /// Its height, in m.
    pub height: f64,
    /// Distance from its middle to where its side is steepest, in m.
    pub radius: f64,
}

#[derive(Deserialize)]
struct MoundRow(#[serde(deserialize_with = "numbers")] [f64; 4]);

impl From<MoundRow> for MoundDescription {
    fn from(MoundRow([x, y, height, radius]): MoundRow) -> Self {
        Self { x, y, height, radius }
    }
}

impl From<MoundDescription> for [f64; 4] {
    fn from(mound: MoundDescription) -> Self {
        [mound.x, mound.y, mound.height, mound.radius]
    }
}

/// An igloo about the origin.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct IglooDescription {
    /// Radius inside, in m.
    pub inner_radius: f64,
    /// Thickness of the blocks in their middle, in m.
    pub wall: f64,
    /// Courses of blocks below the king block.
    pub courses: u32,
    /// Width of a block, in m.
    pub block_width: f64,
    /// Depth of the seams on either face, in m; a quarter of the wall if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seam_depth: Option<f64>,
    /// Width of the seams, in m.
    pub seam_width: f64,
    /// Seed of the unevenness.
    pub seed: u32,
}

impl Default for IglooDescription {
    fn default() -> Self {
        Self {
            inner_radius: 1.5,
            wall: 0.15,
            courses: 6,
            block_width: 0.6,
            seam_depth: None,
            seam_width: 0.05,
            seed: 1,
        }
    }
}

/// A mesh from a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeshDescription {
    /// A PLY, OBJ, STL, glTF or GLB file.
    pub mesh: String,
    /// An object or group of an OBJ file, or a node or mesh of a glTF; the whole file if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// The axis that points upwards in the file; y in glTF and z in other formats if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<UpAxis>,
    /// Whether it is shaded by interpolated vertex normals: those of the file, or else the means of its faces. If not,
    /// or at edges of more than [`CREASE_DEG`](snowblue_geometry::vertex_normals::CREASE_DEG), faces are flat.
    #[serde(default = "smooth", skip_serializing_if = "Clone::clone")]
    pub smooth: bool,
}

impl MeshDescription {
    /// All of a file.
    pub fn new(file: impl Into<String>) -> Self {
        Self { mesh: file.into(), part: None, up: None, smooth: smooth() }
    }
}

fn one() -> u32 {
    1
}

fn smooth() -> bool {
    true
}
