//! Landscapes: surfaces of heights, snow on them, and prints in the snow.

use std::sync::Arc;

use glam::DVec2;
use snowblue_geometry::mesh_files::read_mesh_from;
use snowblue_geometry::ray::narrow;
use snowblue_geometry::triangle_mesh::TriangleMesh;
use snowblue_shapes::drift::{Mound, drift, drift_heights};
use snowblue_shapes::height_field::Heights;
use snowblue_shapes::height_files::{Georeference, HeightGrid, Window};
use snowblue_shapes::imprint::{Foot, Imprint, ImprintKind, Sole, Wall};
use snowblue_shapes::snow_on_mesh::snow_on_mesh;
use snowblue_shapes::terrain::{Depth, DepthImage, Filling, SnowCover, Terrain};

use crate::assembling::placing::upright;
use crate::assembling::sources::Sources;
use crate::description::value::point;
use crate::description::{
    DepthDescription, DriftDescription, FootDescription, FootprintDescription, GridSettings, GroundSource,
    HeightFieldDescription, HeightSource, HoleDescription, ImprintDescription, SnowpackDescription, UpAxis,
};
use crate::error::SceneError;
use snowblue_base::{KeyError, KeyPath};

/// Default tolerance of the triangles of a map, in distances between two heights.
const TOLERANCE_OF_CELL: f64 = 0.05;
/// How far the bottom of a map lies below its least height by default, as a fraction of its longer side.
const BOTTOM_OF_SIDE: f64 = 0.01;
/// Default gap between ground and snow, in m, beside the tolerance of both.
const GAP_M: f64 = 1e-3;
/// The part of the gap for the rounding of coordinates and the offsets of rays from surfaces, as a fraction of the
/// longer side: four times the greatest offset.
const GAP_OF_SIDE: f64 = 1.0 / (1 << 19) as f64;

/// Refuses the shapes of the feature `shapes` in a build without it. The compiler then drops the code that follows.
#[inline]
pub(super) fn check_shapes(path: &KeyPath) -> Result<(), KeyError> {
    if cfg!(feature = "shapes") {
        return Ok(());
    }
    Err(path.key("shape").error("is one that this build does not make"))
}

/// A solid with a surface of heights.
pub(super) struct Land {
    pub(super) solid: TriangleMesh,
    /// The surface before prints were pressed into it, if any were.
    pub(super) undisturbed: Option<Arc<Terrain>>,
}

impl From<TriangleMesh> for Land {
    fn from(solid: TriangleMesh) -> Self {
        Self { solid, undisturbed: None }
    }
}

/// Heights in their place, relative to the object's origin.
struct PlacedGrid {
    heights: Heights,
    far_left_m: DVec2,
    cell_m: DVec2,
    tolerance_m: f64,
    /// The object's origin in the coordinates of the file, if that says where its heights lie.
    origin_on_map_m: Option<DVec2>,
}

/// A solid below heights.
pub(super) fn height_field(
    path: &KeyPath,
    description: &HeightFieldDescription,
    imprints: &[ImprintDescription],
    sources: &Sources,
) -> Result<Land, SceneError> {
    let HeightFieldDescription { source, grid: settings, bottom } = description;
    let (grid, key) = match source {
        HeightSource::Rows { heights } => (grid_of_rows(heights), path.key("heights")),
        HeightSource::File { file } => (read_grid(&path.key("file"), file, sources)?, path.key("file")),
    };
    let is_missing = || path.key("bottom").error("is missing");
    // The reason begins with the name of the key.
    let wrong = |reason: String| match reason.strip_prefix("bottom ") {
        Some(reason) => path.key("bottom").error(reason),
        None => path.error(reason),
    };
    if let (Some(size), [], true) =
        (settings.size, imprints, GridSettings { size: None, ..settings.clone() }.is_plain())
    {
        let heights = heights_of(filled(grid, None, &key)?, &key)?;
        let bottom = narrow(bottom.ok_or_else(is_missing)?);
        return Ok(Land::from(heights.solid(point(size).into(), bottom).map_err(wrong)?));
    }
    check_shapes(path)?;
    let placed = place(path, &key, grid, settings)?;
    let longer_m = placed.size_m().max_element();
    let bottom_m = match bottom {
        Some(bottom) => f64::from(narrow(*bottom)),
        None if placed.origin_on_map_m.is_some() => f64::from(placed.least_m()) - BOTTOM_OF_SIDE * longer_m,
        None => return Err(is_missing().into()),
    };
    let tolerance_m = placed.tolerance_m;
    let terrain = placed.terrain(path, Filling::Below(bottom_m), imprints)?;
    Ok(land(terrain, tolerance_m).map_err(wrong)?)
}

/// Ground under snow, with mounds.
pub(super) fn drift_land(
    path: &KeyPath,
    description: &DriftDescription,
    imprints: &[ImprintDescription],
) -> Result<Land, KeyError> {
    check_shapes(path)?;
    let single = |number: f64| f64::from(narrow(number));
    let mounds = description.mounds.iter().map(|mound| Mound {
        centre_m: DVec2::new(single(mound.x), single(mound.y)),
        height_m: single(mound.height),
        radius_m: single(mound.radius),
    });
    let mounds: Vec<_> = mounds.collect();
    let size_m = point(description.size).as_dvec3();
    let too_small = |reason: String| path.key("size").error(format!("is too small: {reason}"));
    if imprints.is_empty() {
        let solid = drift(size_m, &mounds, description.relief, description.seed);
        return Ok(Land::from(solid.map_err(too_small)?));
    }
    let heights = drift_heights(size_m, &mounds, description.relief, description.seed).map_err(too_small)?;
    let cells = DVec2::new((heights.columns() - 1) as f64, (heights.rows() - 1) as f64);
    let placed = PlacedGrid {
        far_left_m: 0.5 * size_m.truncate() * DVec2::new(-1.0, 1.0),
        cell_m: size_m.truncate() / cells,
        heights,
        tolerance_m: 0.0,
        origin_on_map_m: None,
    };
    let terrain = placed.terrain(path, Filling::Below(-size_m.z), imprints)?;
    land(terrain, 0.0).map_err(|reason| match reason.strip_prefix("bottom ") {
        Some(_) => too_small(reason),
        None => path.error(reason),
    })
}

/// Snow on ground.
pub(super) fn snowpack(
    path: &KeyPath,
    description: &SnowpackDescription,
    imprints: &[ImprintDescription],
    sources: &Sources,
) -> Result<Land, SceneError> {
    check_shapes(path)?;
    let (grid, settings, key) = match &description.ground {
        GroundSource::Mesh { ground, part, up } => {
            let file = MeshGround { file: ground, part: part.as_deref(), up: *up };
            return Ok(Land::from(snow_on_mesh_file(path, description, &file, sources)?));
        }
        GroundSource::Rows { heights, grid } => (grid_of_rows(heights), grid, path.key("heights")),
        GroundSource::Heights { ground, grid } => {
            (read_grid(&path.key("ground"), ground, sources)?, grid, path.key("ground"))
        }
    };
    let placed = place(path, &key, grid, settings)?;
    let tolerance_m = placed.tolerance_m;
    let cover = SnowCover {
        depth: depth(&path.key("depth"), &description.depth, &placed, sources)?,
        gap_m: description.gap.unwrap_or(GAP_M + 2.0 * tolerance_m + GAP_OF_SIDE * placed.size_m().max_element()),
        least_depth_m: description.least_depth,
    };
    let terrain = placed.terrain(path, Filling::Snow(cover), imprints)?;
    Ok(land(terrain, tolerance_m).map_err(|reason| path.error(reason))?)
}

fn land(terrain: Terrain, tolerance_m: f64) -> Result<Land, String> {
    let solid = terrain.solid(tolerance_m)?;
    let undisturbed = (!terrain.imprints.is_empty()).then(|| Arc::new(terrain));
    Ok(Land { solid, undisturbed })
}

impl GridSettings {
    /// Whether nothing is set.
    fn is_plain(&self) -> bool {
        *self == Self::default()
    }
}

impl PlacedGrid {
    fn size_m(&self) -> DVec2 {
        self.cell_m * DVec2::new((self.heights.columns() - 1) as f64, (self.heights.rows() - 1) as f64)
    }

    fn least_m(&self) -> f32 {
        self.heights.values().iter().copied().fold(f32::INFINITY, f32::min)
    }

    fn terrain(self, path: &KeyPath, filling: Filling, imprints: &[ImprintDescription]) -> Result<Terrain, KeyError> {
        let (low, high) = (
            DVec2::new(self.far_left_m.x, self.far_left_m.y - self.size_m().y),
            DVec2::new(self.far_left_m.x + self.size_m().x, self.far_left_m.y),
        );
        for (index, imprint) in imprints.iter().enumerate() {
            let position = DVec2::from(imprint.position());
            if position.cmplt(low).any() || position.cmpgt(high).any() {
                let reason = format!(
                    "is {position}, but must lie on the surface: x = {} to {} m and y = {} to {} m",
                    low.x, high.x, low.y, high.y
                );
                return Err(path.key("imprint").index(index).key("position").error(reason));
            }
        }
        let Self { heights, far_left_m, cell_m, .. } = self;
        Ok(Terrain { heights, far_left_m, cell_m, filling, imprints: imprints.iter().map(imprint).collect() })
    }
}

fn grid_of_rows(rows: &[Vec<f64>]) -> HeightGrid {
    HeightGrid {
        columns: rows.first().map_or(0, Vec::len),
        values: rows.iter().flatten().copied().map(narrow).collect(),
        georeference: None,
        no_data: None,
    }
}

fn read_grid(path: &KeyPath, file: &str, sources: &Sources) -> Result<HeightGrid, SceneError> {
    HeightGrid::read(sources.files, file).map_err(|error| sources.named(path, file, error))
}

/// Puts heights where there are none; `key` is the path to the heights.
fn filled(grid: HeightGrid, fill: Option<f64>, key: &KeyPath) -> Result<HeightGrid, KeyError> {
    grid.filled(fill.map(narrow)).map_err(|reason| {
        key.error(format!("cannot be used: {reason}; `fill` gives a height for them, and `crop` leaves them out"))
    })
}

fn heights_of(grid: HeightGrid, key: &KeyPath) -> Result<Heights, KeyError> {
    Heights::new(grid.columns, grid.values).map_err(|reason| key.error(format!("cannot be used: {reason}")))
}

/// Puts heights into their place.
fn place(path: &KeyPath, key: &KeyPath, grid: HeightGrid, settings: &GridSettings) -> Result<PlacedGrid, KeyError> {
    if grid.columns < 2 || grid.rows() < 2 {
        heights_of(grid.clone(), key)?;
    }
    let cells = DVec2::new((grid.columns - 1) as f64, (grid.rows() - 1) as f64);
    let (georeference, height_scale) = match (settings.size, grid.georeference) {
        (Some(size), _) => {
            let size = point(size).as_dvec3();
            let far_left_m = 0.5 * size.truncate() * DVec2::new(-1.0, 1.0);
            (Georeference { far_left_m, cell_m: size.truncate() / cells }, size.z)
        }
        (None, Some(georeference)) => (georeference, 1.0),
        (None, None) => return Err(path.key("size").error("is missing, and the file does not say it")),
    };
    let Georeference { far_left_m, cell_m } = georeference;
    let (grid, far_left_m, origin_m) = match settings.crop {
        None => (grid, far_left_m, far_left_m + 0.5 * cells * cell_m * DVec2::new(1.0, -1.0)),
        Some(crop) => {
            let window = Window { centre_m: crop.centre.into(), size_m: crop.size.into() };
            let (grid, far_left_m) =
                grid.cropped(&georeference, &window).map_err(|reason| path.key("crop").error(reason))?;
            (grid, far_left_m, window.centre_m)
        }
    };
    let heights = heights_of(filled(grid, settings.fill, key)?, key)?;
    let far_left_m = far_left_m - origin_m;
    let of_origin = || heights.at(-far_left_m * DVec2::new(1.0, -1.0) / cell_m);
    let is_map = settings.size.is_none();
    let datum_m = settings.datum.unwrap_or_else(|| if is_map { of_origin() } else { 0.0 });
    Ok(PlacedGrid {
        heights: heights.scaled(narrow(height_scale)).lowered(datum_m),
        far_left_m,
        cell_m,
        tolerance_m: settings.tolerance.unwrap_or(if is_map { TOLERANCE_OF_CELL * cell_m.min_element() } else { 0.0 }),
        origin_on_map_m: is_map.then_some(origin_m),
    })
}

/// The depth of snow on heights.
fn depth(
    path: &KeyPath,
    description: &DepthDescription,
    ground: &PlacedGrid,
    sources: &Sources,
) -> Result<Depth, SceneError> {
    match description {
        DepthDescription::Uniform(depth) => Ok(Depth::Uniform(*depth)),
        DepthDescription::Attribute { .. } => Err(path.error("is an attribute, but the ground has none").into()),
        DepthDescription::Texture { texture, range } => {
            let path = path.key("texture");
            let grid = read_grid(&path, texture, sources)?;
            let (place, origin_m) = (grid.georeference, ground.origin_on_map_m);
            let mut depth = depth_of_grid(&path, texture, grid, *range)?;
            // A map of depths on a map of heights lies in its place.
            if let (Some(Georeference { far_left_m, cell_m }), Some(origin_m)) = (place, origin_m) {
                let to_cells = DVec2::new(1.0, -1.0) / cell_m;
                depth.first = (origin_m + ground.far_left_m - far_left_m) * to_cells;
                depth.span = ground.size_m() / cell_m;
                let last = depth.first + depth.span;
                let most = DVec2::new((depth.values.columns() - 1) as f64, (depth.values.rows() - 1) as f64);
                // Half a cell of either map is not covered at its edge.
                if depth.first.cmplt(DVec2::splat(-1.0)).any() || last.cmpgt(most + 1.0).any() {
                    return Err(path.error(format!("is \"{texture}\", which does not cover the ground")).into());
                }
            }
            Ok(Depth::Varying(depth))
        }
    }
}

/// Depths from edge to edge of an image.
fn depth_of_grid(path: &KeyPath, file: &str, grid: HeightGrid, range_m: [f64; 2]) -> Result<DepthImage, KeyError> {
    let wrong = |reason: String| path.error(format!("is \"{file}\": {reason}"));
    let grid = grid.filled(None).map_err(wrong)?;
    let values = Heights::new(grid.columns, grid.values).map_err(wrong)?;
    Ok(DepthImage::from_edge_to_edge(values, range_m))
}

/// A mesh that snow lies on.
struct MeshGround<'a> {
    file: &'a str,
    part: Option<&'a str>,
    up: Option<UpAxis>,
}

fn snow_on_mesh_file(
    path: &KeyPath,
    description: &SnowpackDescription,
    ground: &MeshGround,
    sources: &Sources,
) -> Result<TriangleMesh, SceneError> {
    let MeshGround { file, part, up } = *ground;
    let key = path.key("ground");
    let read = read_mesh_from(sources.files, file, part).map_err(|error| sources.named(&key, file, error))?;
    let mut mesh = TriangleMesh::default();
    let wrong = |reason: String| key.error(format!("is \"{file}\", which {reason}"));
    mesh.append(&read, &upright(file, up)).map_err(wrong)?;
    let reach_m = mesh.positions.iter().map(|position| position.abs().max_element()).fold(0.0, f32::max);
    let gap_m = description.gap.unwrap_or(GAP_M + 2.0 * GAP_OF_SIDE * f64::from(reach_m));
    let least_m = description.least_depth;
    let solid = match &description.depth {
        DepthDescription::Attribute { attribute, range: [from_m, to_m] } => {
            let path = path.key("depth").key("attribute");
            let Some(values) = mesh.attributes.get(attribute) else {
                let names: Vec<_> = mesh.attributes.keys().map(String::as_str).collect();
                let reason = format!("is \"{attribute}\", but {file} has only [{}]", names.join(", "));
                return Err(path.error(reason).into());
            };
            if let Some(value) = values.iter().find(|value| !value.is_finite()) {
                return Err(path.error(format!("is {value} at a vertex, but must be finite")).into());
            }
            let depth_m = |value: f32| at_least(from_m + f64::from(value) * (to_m - from_m), least_m);
            let most_m = values.iter().map(|value| depth_m(*value)).fold(0.0, f64::max);
            snow_on_mesh(mesh, gap_m, most_m, |mesh, vertex| depth_m(mesh.attributes[attribute][vertex]))
        }
        DepthDescription::Texture { texture, .. } if mesh.uv.is_empty() => {
            let reason = format!("is \"{texture}\", but {file} has no texture coordinates");
            return Err(path.key("depth").key("texture").error(reason).into());
        }
        DepthDescription::Texture { texture, range } => {
            let path = path.key("depth").key("texture");
            let image = depth_of_grid(&path, texture, read_grid(&path, texture, sources)?, *range)?;
            let depth_m = |mesh: &TriangleMesh, vertex: usize| at_least(image.at(mesh.uv[vertex].as_dvec2()), least_m);
            snow_on_mesh(mesh, gap_m, image.greatest_m(), depth_m)
        }
        DepthDescription::Uniform(depth_m) => snow_on_mesh(mesh, gap_m, *depth_m, |_, _| *depth_m),
    };
    Ok(solid.map_err(wrong)?)
}

/// A depth, or none if it is less than some.
fn at_least(depth_m: f64, least_m: f64) -> f64 {
    if depth_m < least_m { 0.0 } else { depth_m }
}

fn imprint(description: &ImprintDescription) -> Imprint {
    let wall = |depth_m: f64, taper_deg: f64, rim_m: f64, rim_width_m: f64| Wall {
        width_m: depth_m * taper_deg.to_radians().tan(),
        rim_m,
        rim_width_m,
    };
    match description {
        ImprintDescription::Hole(hole) => {
            let HoleDescription { position, radius, depth, taper_deg, rim, rim_width } = *hole;
            let kind = ImprintKind::Hole { radius_m: radius, depth_m: depth };
            Imprint::new(position.into(), kind, wall(depth, taper_deg, rim, rim_width.unwrap_or(2.0 * radius)))
        }
        ImprintDescription::Footprint(footprint) => {
            let FootprintDescription { position, heading_deg, foot, length, depth, toe_depth, tread, .. } = *footprint;
            let depths_m = [depth, toe_depth.unwrap_or(depth)];
            let foot = match foot {
                FootDescription::Left => Foot::Left,
                FootDescription::Right => Foot::Right,
            };
            let rim_width = footprint.rim_width.unwrap_or(length / 6.0);
            let wall = wall(depths_m[0].max(depths_m[1]), footprint.taper_deg, footprint.rim, rim_width);
            let sole = Sole::new(heading_deg, length, depths_m, tread, foot);
            Imprint::new(position.into(), ImprintKind::Footprint(sole), wall)
        }
    }
}
