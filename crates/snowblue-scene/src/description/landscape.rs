//! Landscapes as data: surfaces of heights, snow on them, and prints in the snow.

use serde::{Deserialize, Serialize};
use snowblue_base::files::extension;
use snowblue_geometry::mesh_files::MESH_EXTENSIONS;

use super::value::{UpAxis, numbers, some_numbers};

/// A solid under a surface of heights.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "HeightFieldKeys")]
pub struct HeightFieldDescription {
    /// The heights.
    #[serde(flatten)]
    pub source: HeightSource,
    /// Where they lie.
    #[serde(flatten)]
    pub grid: GridSettings,
    /// Where the solid ends below, in m. Of a georeferenced file, by default a hundredth of its longer side below the
    /// least height.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bottom: Option<f64>,
}

/// Where heights come from.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum HeightSource {
    /// Rows from far (greatest y) to near, each from left to right.
    Rows {
        /// The rows, all of one length.
        heights: Vec<Vec<f64>>,
    },
    /// A grey PNG, white being 1, the first channel of an OpenEXR image, an ESRI ASCII grid or a GeoTIFF.
    File {
        /// The file.
        file: String,
    },
}

/// Where heights on a grid lie.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct GridSettings {
    /// Lengths along x and y, and the height of the value 1, in m; by default those of a georeferenced file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<[f64; 3]>,
    /// The height that lies at z = 0; by default the one at the object's origin in a georeferenced file, else 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub datum: Option<f64>,
    /// The height where the file has none. Without it, missing heights are an error.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fill: Option<f64>,
    /// The part that is used; all if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub crop: Option<CropDescription>,
    /// How far the triangles may lie above or below the heights, in m; by default a twentieth of the distance between
    /// two heights of a georeferenced file, else 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
}

/// A part of a grid. Its middle becomes the object's origin.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CropDescription {
    /// Its middle, in the coordinates of a georeferenced file or else from the middle of the grid, in m.
    #[serde(deserialize_with = "numbers")]
    pub centre: [f64; 2],
    /// Its lengths along x and y, in m.
    #[serde(deserialize_with = "numbers")]
    pub size: [f64; 2],
}

/// The keys of a height field.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct HeightFieldKeys {
    heights: Option<Vec<Vec<f64>>>,
    file: Option<String>,
    #[serde(default, deserialize_with = "some_numbers")]
    size: Option<[f64; 3]>,
    bottom: Option<f64>,
    datum: Option<f64>,
    fill: Option<f64>,
    crop: Option<CropDescription>,
    tolerance: Option<f64>,
}

impl TryFrom<HeightFieldKeys> for HeightFieldDescription {
    type Error = &'static str;

    fn try_from(keys: HeightFieldKeys) -> Result<Self, &'static str> {
        let HeightFieldKeys { heights, file, size, bottom, datum, fill, crop, tolerance } = keys;
        let source = match (heights, file) {
            (Some(heights), None) => HeightSource::Rows { heights },
            (None, Some(file)) => HeightSource::File { file },
            _ => return Err("needs either `heights` or `file`"),
        };
        Ok(Self { source, grid: GridSettings { size, datum, fill, crop, tolerance }, bottom })
    }
}

/// Snow of some depth on a surface of heights or on a mesh.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "SnowpackKeys")]
pub struct SnowpackDescription {
    /// What it lies on.
    #[serde(flatten)]
    pub ground: GroundSource,
    /// Depth of the snow, measured vertically.
    pub depth: DepthDescription,
    /// Depth below which there is no snow, in m.
    pub least_depth: f64,
    /// Height of the underside above the ground, in m, so that the two do not cross; by default 1 mm, and as much as
    /// triangles and rounding may miss.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap: Option<f64>,
}

/// What snow lies on.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum GroundSource {
    /// Heights that are given as rows.
    Rows {
        /// Rows from far (greatest y) to near, each from left to right, all of one length.
        heights: Vec<Vec<f64>>,
        /// Where they lie.
        #[serde(flatten)]
        grid: GridSettings,
    },
    /// Heights of a file.
    Heights {
        /// A PNG, OpenEXR, ESRI ASCII grid or GeoTIFF.
        ground: String,
        /// Where they lie.
        #[serde(flatten)]
        grid: GridSettings,
    },
    /// A mesh; snow lies on all its faces that look upwards.
    Mesh {
        /// A PLY, OBJ, STL, glTF or GLB file.
        ground: String,
        /// As that of a mesh.
        #[serde(skip_serializing_if = "Option::is_none")]
        part: Option<String>,
        /// As that of a mesh.
        #[serde(skip_serializing_if = "Option::is_none")]
        up: Option<UpAxis>,
    },
}

/// The depth of snow.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged, from = "DepthNotation")]
pub enum DepthDescription {
    /// The same everywhere, in m.
    Uniform(f64),
    /// By an image of heights that covers the ground from edge to edge.
    Texture {
        /// A grey PNG, white being 1, the first channel of an OpenEXR image, an ESRI ASCII grid or a GeoTIFF.
        texture: String,
        /// The depths where its value is 0 and where it is 1, in m.
        range: [f64; 2],
    },
    /// By an attribute of the vertices of a mesh.
    Attribute {
        /// Its name in the mesh file.
        attribute: String,
        /// The depths where its value is 0 and where it is 1, in m.
        range: [f64; 2],
    },
}

#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "is no depth: write a number, { texture = \"FILE\", range = [0, 1] } or { attribute = \"NAME\", \
                 range = [0, 1] }"
)]
enum DepthNotation {
    Uniform(f64),
    Texture(DepthTexture),
    Attribute(DepthAttribute),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DepthTexture {
    texture: String,
    #[serde(default = "unit_range", deserialize_with = "numbers")]
    range: [f64; 2],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DepthAttribute {
    attribute: String,
    #[serde(default = "unit_range", deserialize_with = "numbers")]
    range: [f64; 2],
}

impl From<DepthNotation> for DepthDescription {
    fn from(notation: DepthNotation) -> Self {
        match notation {
            DepthNotation::Uniform(depth) => Self::Uniform(depth),
            DepthNotation::Texture(DepthTexture { texture, range }) => Self::Texture { texture, range },
            DepthNotation::Attribute(DepthAttribute { attribute, range }) => Self::Attribute { attribute, range },
        }
    }
}

/// The keys of snow on the ground.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SnowpackKeys {
    ground: Option<String>,
    heights: Option<Vec<Vec<f64>>>,
    depth: DepthDescription,
    #[serde(default = "millimetre")]
    least_depth: f64,
    gap: Option<f64>,
    part: Option<String>,
    up: Option<UpAxis>,
    #[serde(default, deserialize_with = "some_numbers")]
    size: Option<[f64; 3]>,
    datum: Option<f64>,
    fill: Option<f64>,
    crop: Option<CropDescription>,
    tolerance: Option<f64>,
}

impl TryFrom<SnowpackKeys> for SnowpackDescription {
    type Error = &'static str;

    fn try_from(keys: SnowpackKeys) -> Result<Self, &'static str> {
        let SnowpackKeys { ground, heights, depth, least_depth, gap, part, up, .. } = keys;
        let grid = GridSettings {
            size: keys.size,
            datum: keys.datum,
            fill: keys.fill,
            crop: keys.crop,
            tolerance: keys.tolerance,
        };
        let is_mesh = |name: &String| MESH_EXTENSIONS.contains(&extension(name.as_ref()).as_str());
        let ground = match (ground, heights) {
            (Some(ground), None) if is_mesh(&ground) => {
                if grid != GridSettings::default() {
                    return Err("has a mesh as ground: `size`, `datum`, `fill`, `crop` and `tolerance` are of heights");
                }
                GroundSource::Mesh { ground, part, up }
            }
            _ if part.is_some() || up.is_some() => return Err("has no mesh as ground: `part` and `up` are of meshes"),
            (Some(ground), None) => GroundSource::Heights { ground, grid },
            (None, Some(heights)) => GroundSource::Rows { heights, grid },
            _ => return Err("needs either `ground` or `heights`"),
        };
        Ok(Self { ground, depth, least_depth, gap })
    }
}

/// A print in snow.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum ImprintDescription {
    /// The hole of a pole.
    Hole(HoleDescription),
    /// The print of a boot.
    Footprint(FootprintDescription),
}

/// A hole with a vertical axis, narrower below.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HoleDescription {
    /// Its middle, in m.
    #[serde(deserialize_with = "numbers")]
    pub position: [f64; 2],
    /// Radius at the surface, in m.
    pub radius: f64,
    /// Depth below the surface, in m.
    pub depth: f64,
    /// Angle between its wall and the vertical, in degrees.
    #[serde(default = "hole_taper_deg")]
    pub taper_deg: f64,
    /// Height of the snow pushed up around it, in m.
    #[serde(default)]
    pub rim: f64,
    /// Width of this rim, in m; twice the radius if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rim_width: Option<f64>,
}

/// The print of a boot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FootprintDescription {
    /// Its middle, in m.
    #[serde(deserialize_with = "numbers")]
    pub position: [f64; 2],
    /// Direction of the toe, counter-clockwise from the x axis, in degrees.
    #[serde(default)]
    pub heading_deg: f64,
    /// Which foot.
    #[serde(default)]
    pub foot: FootDescription,
    /// Length of the boot, in m.
    #[serde(default = "boot_length")]
    pub length: f64,
    /// Depth at the heel, in m, and at the toe unless that has its own.
    pub depth: f64,
    /// Depth at the toe, in m; that at the heel if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub toe_depth: Option<f64>,
    /// Depth of the tread of the sole, in m.
    #[serde(default = "tread_depth")]
    pub tread: f64,
    /// Angle between its wall and the vertical, in degrees.
    #[serde(default = "footprint_taper_deg")]
    pub taper_deg: f64,
    /// Height of the snow pushed up around it, in m.
    #[serde(default)]
    pub rim: f64,
    /// Width of this rim, in m; a sixth of the length if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rim_width: Option<f64>,
}

/// A foot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FootDescription {
    /// The left one.
    Left,
    /// The right one.
    #[default]
    Right,
}

impl ImprintDescription {
    /// Its middle, in m.
    pub fn position(&self) -> [f64; 2] {
        match self {
            Self::Hole(hole) => hole.position,
            Self::Footprint(footprint) => footprint.position,
        }
    }
}

fn unit_range() -> [f64; 2] {
    [0.0, 1.0]
}

fn millimetre() -> f64 {
    1e-3
}

fn hole_taper_deg() -> f64 {
    2.0
}

fn footprint_taper_deg() -> f64 {
    8.0
}

fn boot_length() -> f64 {
    0.3
}

fn tread_depth() -> f64 {
    4e-3
}
