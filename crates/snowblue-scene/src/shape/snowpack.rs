//! Snow of some depth on a surface of heights or on a mesh.

use std::fmt;

use glam::{DVec2, DVec3};
use schemars::JsonSchema;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, IntoDeserializer, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use snowblue_base::files::extension;
use snowblue_base::toml_table::Table;
use snowblue_base::{KeyError, KeyPath, Number, Numbers, ParameterRange, ParseError, narrow, quantities};
use snowblue_geometry::mesh_bvh::MeshBvh;
use snowblue_geometry::mesh_files::{MESH_EXTENSIONS, ReadMesh, read_mesh_from};
use snowblue_geometry::ray::MeshLocation;
use snowblue_geometry::triangle_mesh::TriangleMesh;
use snowblue_shapes::height_field::Heights;
use snowblue_shapes::height_files::Georeference;
use snowblue_shapes::snow_on_mesh::{SnowLayer, snow_on_mesh};
use snowblue_shapes::terrain::{Depth, DepthImage, Filling, SnowCover};

use super::grid::{GridSettings, GridSource, LengthUnit, NoData, PlacedGrid, note_on_unit, read_grid, stated};
use super::keys::{BuiltShape, ObjectContext, ShapeKeys, check_shapes};
use super::placing::upright;
use crate::error::SceneError;
use crate::sources::Sources;
use crate::values::{SmallLength, UpAxis, only_one};

quantities! {
    /// Depth of snow; a varying depth below 0 is no snow.
    pub SnowDepth = ParameterRange::new("depth", -100.0, 100.0, "m");
    /// Height of the underside of snow above the ground.
    pub Gap = ParameterRange::new("gap", 0.0, 10.0, "m");
    /// The slope from which snow slides.
    pub SlideAngle = ParameterRange::new("angle", 10.0, 80.0, "°");
}

/// Least depth of snow of uniform depth, in m.
const MIN_DEPTH_M: f64 = 1e-3;
/// Default gap between ground and snow, in m, in addition to the tolerance of both.
const GAP_M: f64 = 1e-3;
/// Default slope from which snow slides, in degrees.
const SLIDE_DEG: f64 = 50.0;
/// The part of the gap for the rounding of coordinates and the offsets of rays from surfaces, as a fraction of the
/// longer side: four times the greatest offset.
const GAP_OF_SIDE: f64 = 1.0 / (1 << 19) as f64;

/// Snow of some depth on a surface of heights or on a mesh. The ground is another object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SnowpackDescription {
    /// A PNG, OpenEXR, ESRI ASCII grid or GeoTIFF of heights, or a PLY, OBJ, STL, glTF or GLB file. Snow lies on what
    /// is seen of a mesh from above.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ground: Option<String>,
    /// Rows of heights from far (greatest y) to near, each from left to right, all of one length, instead of a file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heights: Option<Vec<Vec<f64>>>,
    /// Where heights lie.
    #[serde(flatten, skip_deserializing)]
    #[schemars(!skip_deserializing)]
    pub grid: GridSettings,
    /// An object, group or material of an OBJ file, or a node or mesh of a glTF; the whole file if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// The axis that points upwards in a mesh file; y in glTF and z in other formats if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<UpAxis>,
    /// Depth of the snow, measured vertically: a number in m, or a table.
    pub depth: DepthDescription,
    /// Depth below which there is no snow, in m.
    #[serde(default = "SnowpackDescription::default_least_depth")]
    pub least_depth: Number<SmallLength>,
    /// Height of the underside above the ground, in m, so that the two do not cross; by default 1 mm, and as much as
    /// triangles and rounding may miss.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gap: Option<Number<Gap>>,
    /// The slope from which snow slides off a mesh, in degrees; 50 if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slide_deg: Option<Number<SlideAngle>>,
}

/// The depth of snow.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum DepthDescription {
    /// One depth, in m.
    Uniform(Number<SnowDepth>),
    /// Depths of an image of heights that covers the ground from edge to edge, or of an attribute of a mesh.
    Varying(VaryingDepth),
}

/// Depths by an image or an attribute.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VaryingDepth {
    /// A grey PNG, white being 1, an OpenEXR image of one channel, an ESRI ASCII grid or a GeoTIFF; a map in m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub texture: Option<String>,
    /// The name of an attribute of the vertices of a mesh, instead of an image.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub attribute: Option<String>,
    /// The depths where the value is 0 and where it is 1, in m.
    #[serde(default = "VaryingDepth::default_range")]
    pub range: Numbers<SnowDepth, 2>,
    /// The unit of the depths of a map; by default the unit that the file states, or m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<LengthUnit>,
    /// The unit of the coordinates of a map; by default the unit that the file states, or m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub map_unit: Option<LengthUnit>,
    /// A value that marks missing depths, besides the value that the file states.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nodata: Option<Number<NoData>>,
    /// The depth where the file has none, in m. Without it, missing depths are an error.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fill: Option<Number<SnowDepth>>,
}

impl<'de> Deserialize<'de> for DepthDescription {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Notation;
        impl<'de> Visitor<'de> for Notation {
            type Value = DepthDescription;

            fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
                formatter.write_str(
                    "a number, { texture = \"FILE\", range = [0, 1] } or { attribute = \"NAME\", range = [0, 1] }",
                )
            }

            fn visit_f64<E: Error>(self, value: f64) -> Result<DepthDescription, E> {
                Number::deserialize(value.into_deserializer()).map(DepthDescription::Uniform)
            }

            fn visit_i64<E: Error>(self, value: i64) -> Result<DepthDescription, E> {
                Number::deserialize(value.into_deserializer()).map(DepthDescription::Uniform)
            }

            fn visit_u64<E: Error>(self, value: u64) -> Result<DepthDescription, E> {
                Number::deserialize(value.into_deserializer()).map(DepthDescription::Uniform)
            }

            fn visit_map<A: MapAccess<'de>>(self, entries: A) -> Result<DepthDescription, A::Error> {
                VaryingDepth::deserialize(MapAccessDeserializer::new(entries)).map(DepthDescription::Varying)
            }
        }
        deserializer.deserialize_any(Notation)
    }
}

/// The source of varying depths.
enum DepthSource<'keys> {
    Texture(&'keys str),
    Attribute(&'keys str),
}

impl VaryingDepth {
    fn default_range() -> Numbers<SnowDepth, 2> {
        Numbers::of([0.0, 1.0])
    }

    fn source(&self, path: &KeyPath) -> Result<DepthSource<'_>, KeyError> {
        let of_files = [
            ("unit", self.unit.is_some()),
            ("map_unit", self.map_unit.is_some()),
            ("nodata", self.nodata.is_some()),
            ("fill", self.fill.is_some()),
        ];
        if let (Some(_), Some((key, _))) = (&self.attribute, of_files.into_iter().find(|(_, is_given)| *is_given)) {
            return Err(path.key(key).error("is of images, but the depth is an attribute"));
        }
        only_one(
            path,
            [
                ("texture", self.texture.as_deref().map(DepthSource::Texture)),
                ("attribute", self.attribute.as_deref().map(DepthSource::Attribute)),
            ],
        )
    }

    /// Depths from edge to edge of a file, and their place if the file is a map. `path` leads to these keys.
    fn image(
        &self,
        path: &KeyPath,
        file: &str,
        sources: &Sources,
    ) -> Result<(DepthImage, Option<Georeference>), SceneError> {
        let key = path.key("texture");
        let wrong = |reason: String| key.error(format!("is \"{file}\": {reason}"));
        let mut grid = read_grid(&key, file, sources, &stated(self.unit, self.map_unit, self.nodata))?;
        let place = grid.georeference.clone().map_err(wrong)?;
        let units = [("unit", self.unit), ("map_unit", self.map_unit)];
        if let (None, Some((key, _))) = (place, units.into_iter().find(|(_, unit)| unit.is_some())) {
            return Err(path.key(key).error(format!("is of maps, but \"{file}\" is none")).into());
        }
        let unit_m = place.map_or(1.0, |map| map.height_unit_m);
        grid.values.iter_mut().for_each(|value| *value *= narrow(unit_m));
        let [from_m, to_m] = self.range.get();
        let fill = self.fill.map(|fill_m| narrow((fill_m.get() - from_m) / (to_m - from_m)));
        let grid = grid.filled(fill).map_err(|reason| wrong(format!("{reason}; `fill` gives a depth for them")))?;
        let values = Heights::new(grid.columns, grid.values).map_err(wrong)?;
        Ok((DepthImage::from_edge_to_edge(values, [from_m, to_m]), place))
    }
}

impl SnowpackDescription {
    /// Reads the keys of a table.
    pub(super) fn read(mut table: Table) -> Result<Self, ParseError> {
        let grid = table.split(&GridSettings::KEYS).read()?;
        Ok(Self { grid, ..table.read()? })
    }

    fn default_least_depth() -> Number<SmallLength> {
        Number::of(1e-3)
    }
}

impl ShapeKeys for SnowpackDescription {
    fn build(&self, object: &mut ObjectContext) -> Result<BuiltShape, SceneError> {
        let path = object.path;
        check_shapes(path)?;
        if let DepthDescription::Uniform(depth) = self.depth
            && depth.get() < MIN_DEPTH_M
        {
            let reason = format!("is {} m, but must be at least {MIN_DEPTH_M} m", depth.get());
            return Err(path.key("depth").error(reason).into());
        }
        let is_mesh = |name: &String| MESH_EXTENSIONS.contains(&extension(name.as_ref()).as_str());
        if let Some(file) = self.ground.as_ref().filter(|name| self.heights.is_none() && is_mesh(name)) {
            if let Some(key) = self.grid.first_key() {
                return Err(path.key(key).error("is of heights, but the ground is a mesh").into());
            }
            let (origin, snow) = self.on_mesh(path, file, object)?;
            return Ok(object.place_from(origin, snow)?.into());
        }
        let of_meshes =
            [("part", self.part.is_some()), ("up", self.up.is_some()), ("slide_deg", self.slide_deg.is_some())];
        if let Some((key, _)) = of_meshes.into_iter().find(|(_, is_given)| *is_given) {
            return Err(path.key(key).error("is of meshes, but the ground is none").into());
        }
        let given = [
            ("ground", self.ground.as_ref().map(GridSource::File)),
            ("heights", self.heights.as_ref().map(GridSource::Rows)),
        ];
        let (grid, key) = self.grid.read(given, object)?;
        let placed = PlacedGrid::new(path, &key, grid, &self.grid, object.notes)?;
        let usual_gap_m = GAP_M + 2.0 * placed.tolerance_m + GAP_OF_SIDE * placed.size_m().max_element();
        let cover = SnowCover {
            depth: self.depth.over(&path.key("depth"), &placed, object)?,
            gap_m: self.gap.map_or(usual_gap_m, Number::get),
            least_depth_m: self.least_depth.get(),
        };
        placed.build(object, Filling::Snow(cover), |reason| path.error(reason).into())
    }

    fn takes_imprints(&self) -> bool {
        !self.ground.as_ref().is_some_and(|name| MESH_EXTENSIONS.contains(&extension(name.as_ref()).as_str()))
    }
}

impl SnowpackDescription {
    /// Snow on a mesh, and the origin of its coordinates.
    fn on_mesh(
        &self,
        path: &KeyPath,
        file: &str,
        object: &mut ObjectContext,
    ) -> Result<(DVec3, TriangleMesh), SceneError> {
        let key = path.key("ground");
        let read = read_mesh_from(object.sources.files, file, self.part.as_deref());
        let ReadMesh { mesh: read, origin, notes } = read.map_err(|error| object.sources.named(&key, file, error))?;
        object.notes.extend(notes.into_iter().map(|note| format!("{key} is \"{file}\": {note}")));
        let sources = object.sources;
        let mut mesh = TriangleMesh::default();
        let wrong = |reason: String| key.error(format!("is \"{file}\", which {reason}"));
        let upright = upright(file, self.up);
        mesh.append(&read, &upright).map_err(wrong)?;
        let origin = upright.transform_vector3(origin);
        let reach_m = mesh.positions.iter().map(|position| position.abs().max_element()).fold(0.0, f32::max);
        let gap_m = self.gap.map_or(GAP_M + 2.0 * GAP_OF_SIDE * f64::from(reach_m), Number::get);
        let slide_slope = self.slide_deg.map_or(SLIDE_DEG, Number::get).to_radians().tan();
        let layer = |most_m: f64| SnowLayer { gap_m, most_m, slide_slope };
        let min_m = self.least_depth.get();
        let path = path.key("depth");
        let varying = match &self.depth {
            DepthDescription::Uniform(depth) => {
                let depth_m = depth.get();
                let snow = snow_on_mesh(mesh, &layer(depth_m), &|_, _| depth_m).map_err(wrong)?;
                return Ok((origin, snow));
            }
            DepthDescription::Varying(varying) => varying,
        };
        let [from_m, to_m] = varying.range.get();
        let solid = match varying.source(&path)? {
            DepthSource::Attribute(attribute) => {
                let path = path.key("attribute");
                let Some(values) = mesh.attributes.get(attribute) else {
                    let names: Vec<_> = mesh.attributes.keys().map(String::as_str).collect();
                    let reason = format!("is \"{attribute}\", but {file} has only [{}]", names.join(", "));
                    return Err(path.error(reason).into());
                };
                if let Some(value) = values.iter().find(|value| !value.is_finite()) {
                    return Err(path.error(format!("is {value} at a vertex, but must be finite")).into());
                }
                let depth_m = |value: f32| at_least(from_m + f64::from(value) * (to_m - from_m), min_m);
                let max_m = values.iter().map(|value| depth_m(*value)).fold(0.0, f64::max);
                let at = |mesh: &MeshBvh, place: &MeshLocation| mesh.attribute(attribute, place).map_or(0.0, depth_m);
                snow_on_mesh(mesh, &layer(max_m), &at)
            }
            DepthSource::Texture(texture) => {
                if mesh.uv.is_empty() {
                    let reason = format!("is \"{texture}\", but {file} has no texture coordinates");
                    return Err(path.key("texture").error(reason).into());
                }
                let (image, _) = varying.image(&path, texture, sources)?;
                let at = |mesh: &MeshBvh, place: &MeshLocation| {
                    mesh.uv(place).map_or(0.0, |uv| at_least(image.at(uv.as_dvec2()), min_m))
                };
                snow_on_mesh(mesh, &layer(image.greatest_m()), &at)
            }
        };
        Ok((origin, solid.map_err(wrong)?))
    }
}

impl DepthDescription {
    /// The depth of snow on heights.
    fn over(&self, path: &KeyPath, ground: &PlacedGrid, object: &mut ObjectContext) -> Result<Depth, SceneError> {
        let varying = match self {
            Self::Uniform(depth) => return Ok(Depth::Uniform(depth.get())),
            Self::Varying(varying) => varying,
        };
        let DepthSource::Texture(texture) = varying.source(path)? else {
            return Err(path.error("is an attribute, but the ground is no mesh and has none").into());
        };
        let (mut depth, place) = varying.image(path, texture, object.sources)?;
        let path = path.key("texture");
        // If both maps are georeferenced, the map of depths is placed by its coordinates on the map of heights.
        if let (Some(map), Some(origin_m)) = (place, ground.origin_on_map_m) {
            object.notes.extend(note_on_unit(&map, &path));
            let Georeference { far_left_m, cell_m, .. } = map;
            let to_cells = DVec2::new(1.0, -1.0) / cell_m;
            depth.first = (origin_m + ground.far_left_m - far_left_m) * to_cells;
            depth.span = ground.size_m() / cell_m;
            let last = depth.first + depth.span;
            let most = DVec2::new((depth.values.columns() - 1) as f64, (depth.values.rows() - 1) as f64);
            // At its edge, either map may leave half a cell uncovered.
            if depth.first.cmplt(DVec2::splat(-1.0)).any() || last.cmpgt(most + 1.0).any() {
                return Err(path.error(format!("is \"{texture}\", which does not cover the ground")).into());
            }
        }
        Ok(Depth::Varying(depth))
    }
}

/// The depth, or 0 if the depth is less than `min_m`.
fn at_least(depth_m: f64, min_m: f64) -> f64 {
    if depth_m < min_m { 0.0 } else { depth_m }
}
