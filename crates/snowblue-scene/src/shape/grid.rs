//! Heights on a grid, given as rows or as a file, and their placement.

use std::sync::Arc;

use glam::DVec2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_base::{KeyError, KeyPath, Number, Numbers, ParameterRange, narrow, quantities};
use snowblue_shapes::height_field::Heights;
use snowblue_shapes::height_files::{Georeference, HeightGrid, StatedByUser, Window, length_unit_m};
use snowblue_shapes::terrain::{Filling, Terrain};

use super::keys::{BuiltShape, ObjectContext};
use crate::error::SceneError;
use crate::sources::Sources;
use crate::undisturbed::UndisturbedSurface;
use crate::values::{ShapeSize, only_one, point};

quantities! {
    /// A height above the sea or above a floor.
    pub Height = ParameterRange::new("height", -1e5, 1e5, "m");
    /// A coordinate of a map.
    pub MapCoordinate = ParameterRange::new("coordinate", -1e8, 1e8, "m");
    /// A value of a file that marks missing heights.
    pub NoData = ParameterRange::new("value", -3.5e38, 3.5e38, "");
    /// How far triangles may lie from the heights.
    pub Tolerance = ParameterRange::new("tolerance", 0.0, 1e4, "m");
}

/// Default tolerance of the triangles of a map, as a fraction of the distance between two heights.
const TOLERANCE_OF_CELL: f64 = 0.05;

/// Where heights on a grid lie. On a georeferenced map x is east and y is north, the origin is the middle of the map or
/// of `crop`, and the height there lies at z = 0 unless `datum` says another.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct GridSettings {
    /// Lengths along x and y, and the height of the value 1, in m; by default those of a georeferenced file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<Numbers<ShapeSize, 3>>,
    /// The unit of the heights of a map; by default the unit that the file states, or m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<LengthUnit>,
    /// The unit of the coordinates of a map; by default the unit that the file states, or m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map_unit: Option<LengthUnit>,
    /// A value that marks missing heights, besides the value that the file states.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nodata: Option<Number<NoData>>,
    /// The height that lies at z = 0, in m; by default the height at the object's origin in a georeferenced file, else
    /// 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub datum: Option<Number<Height>>,
    /// The height where the file has none, in m. Without it, missing heights are an error.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fill: Option<Number<Height>>,
    /// The part that is used; the whole grid if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub crop: Option<CropDescription>,
    /// How far the triangles may lie above or below the heights, in m; by default a twentieth of the distance between
    /// two heights of a georeferenced file, else 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<Number<Tolerance>>,
}

/// A unit of length of a map, with its code in the EPSG register.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LengthUnit {
    /// Metre.
    M = 9001,
    /// Centimetre.
    Cm = 1033,
    /// International foot, 0.3048 m.
    Ft = 9002,
    /// US survey foot, 1200/3937 m.
    UsFt = 9003,
}

/// What the keys `unit`, `map_unit` and `nodata` say of a file, instead of the file.
pub(super) fn stated(
    unit: Option<LengthUnit>,
    map_unit: Option<LengthUnit>,
    no_data: Option<Number<NoData>>,
) -> StatedByUser {
    let [height_unit_m, map_unit_m] = [unit, map_unit].map(|unit| length_unit_m(unit? as u16));
    StatedByUser { no_data: no_data.map(|value| narrow(value.get())), height_unit_m, map_unit_m }
}

/// A part of a grid. Its middle becomes the object's origin.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CropDescription {
    /// Its middle, in the coordinates of a georeferenced file or else from the middle of the grid, in m.
    pub centre: Numbers<MapCoordinate, 2>,
    /// Its lengths along x and y, in m.
    pub size: Numbers<ShapeSize, 2>,
}

impl GridSettings {
    /// The keys.
    pub(super) const KEYS: [&str; 8] = ["size", "unit", "map_unit", "nodata", "datum", "fill", "crop", "tolerance"];

    /// The first key that is set; none if no key is set.
    pub(super) fn first_key(&self) -> Option<&'static str> {
        let Self { size, unit, map_unit, nodata, datum, fill, crop, tolerance } = self;
        let of_files = [unit.is_some(), map_unit.is_some(), nodata.is_some()];
        let of_grids = [datum.is_some(), fill.is_some(), crop.is_some(), tolerance.is_some()];
        let is_set = [size.is_some()].into_iter().chain(of_files).chain(of_grids);
        Self::KEYS.into_iter().zip(is_set).find_map(|(key, is_set)| is_set.then_some(key))
    }

    /// The heights of the one of two keys that is given, and its path.
    pub(super) fn read(
        &self,
        given: [(&str, Option<GridSource>); 2],
        object: &ObjectContext,
    ) -> Result<(HeightGrid, KeyPath), SceneError> {
        let with_key = |(name, source): (_, Option<_>)| (name, source.map(|source| (object.path.key(name), source)));
        let (key, source) = only_one(object.path, given.map(with_key))?;
        let grid = match source {
            GridSource::Rows(rows) => grid_of_rows(rows, &key, self.stated().no_data)?,
            GridSource::File(file) => read_grid(&key, file, object.sources, &self.stated())?,
        };
        Ok((grid, key))
    }

    /// What the keys say of a file, instead of the file.
    fn stated(&self) -> StatedByUser {
        stated(self.unit, self.map_unit, self.nodata)
    }
}

/// Where heights come from.
pub(super) enum GridSource<'keys> {
    Rows(&'keys Vec<Vec<f64>>),
    File(&'keys String),
}

/// Heights in their place, relative to the object's origin.
pub(super) struct PlacedGrid {
    pub(super) heights: Heights,
    pub(super) far_left_m: DVec2,
    pub(super) cell_m: DVec2,
    pub(super) tolerance_m: f64,
    /// The object's origin in the coordinates of the file, if the file gives the place of its heights.
    pub(super) origin_on_map_m: Option<DVec2>,
}

impl PlacedGrid {
    /// Places heights; `key` is the path to the heights.
    pub(super) fn new(
        path: &KeyPath,
        key: &KeyPath,
        grid: HeightGrid,
        settings: &GridSettings,
        notes: &mut Vec<String>,
    ) -> Result<Self, KeyError> {
        if grid.columns < 2 || grid.rows() < 2 {
            heights_of(grid.clone(), key)?;
        }
        let cells = DVec2::new((grid.columns - 1) as f64, (grid.rows() - 1) as f64);
        let georeference = match (settings.size, &grid.georeference) {
            (Some(size), _) => {
                let units = [("unit", settings.unit), ("map_unit", settings.map_unit)];
                if let Some((key, _)) = units.into_iter().find(|(_, unit)| unit.is_some()) {
                    return Err(path.key(key).error("is the unit of a map, whose place and unit `size` replaces"));
                }
                let size = point(size).as_dvec3();
                let far_left_m = 0.5 * size.truncate() * DVec2::new(-1.0, 1.0);
                Georeference { far_left_m, cell_m: size.truncate() / cells, height_unit_m: size.z, states_unit: true }
            }
            (None, Ok(Some(georeference))) => {
                notes.extend(note_on_unit(georeference, key));
                *georeference
            }
            (None, Ok(None)) => return Err(path.key("size").error("is missing, and the file does not say it")),
            (None, Err(reason)) => {
                return Err(key.error(format!("cannot be used: {reason}; `size` replaces the place of a map")));
            }
        };
        let Georeference { far_left_m, cell_m, height_unit_m, .. } = georeference;
        let (grid, far_left_m, origin_m) = match settings.crop {
            None => (grid, far_left_m, far_left_m + 0.5 * cells * cell_m * DVec2::new(1.0, -1.0)),
            Some(crop) => {
                let window = Window { centre_m: crop.centre.get().into(), size_m: crop.size.get().into() };
                let (grid, far_left_m) =
                    grid.cropped(&georeference, &window).map_err(|reason| path.key("crop").error(reason))?;
                (grid, far_left_m, window.centre_m)
            }
        };
        let fill = settings.fill.map(|fill_m| fill_m.get() / height_unit_m);
        let heights = heights_of(filled(grid, fill, key)?, key)?.scaled(narrow(height_unit_m));
        let far_left_m = far_left_m - origin_m;
        let of_origin = || heights.at(-far_left_m * DVec2::new(1.0, -1.0) / cell_m);
        let is_map = settings.size.is_none();
        let datum_m = settings.datum.map(Number::get).unwrap_or_else(|| if is_map { of_origin() } else { 0.0 });
        let usual_tolerance_m = if is_map { TOLERANCE_OF_CELL * cell_m.min_element() } else { 0.0 };
        Ok(Self {
            heights: heights.lowered(datum_m),
            far_left_m,
            cell_m,
            tolerance_m: settings.tolerance.map_or(usual_tolerance_m, Number::get),
            origin_on_map_m: is_map.then_some(origin_m),
        })
    }

    /// Lengths along x and y, in m.
    pub(super) fn size_m(&self) -> DVec2 {
        self.cell_m * DVec2::new((self.heights.columns() - 1) as f64, (self.heights.rows() - 1) as f64)
    }

    /// Least height, in m.
    pub(super) fn least_m(&self) -> f32 {
        self.heights.values().iter().copied().fold(f32::INFINITY, f32::min)
    }

    /// The solid below or above the heights, with the prints of the object; `wrong` turns a reason into an error.
    pub(super) fn build<E: From<KeyError>>(
        self,
        object: &ObjectContext,
        filling: Filling,
        wrong: impl Fn(String) -> E,
    ) -> Result<BuiltShape, E> {
        let (low, high) = (
            DVec2::new(self.far_left_m.x, self.far_left_m.y - self.size_m().y),
            DVec2::new(self.far_left_m.x + self.size_m().x, self.far_left_m.y),
        );
        let mut imprints = Vec::with_capacity(object.imprints.len());
        for (index, imprint) in object.imprints.iter().enumerate() {
            let path = object.path.key("imprint").index(index);
            let position = DVec2::from(imprint.keys().position());
            if position.cmplt(low).any() || position.cmpgt(high).any() {
                let reason = format!(
                    "is {position}, but must lie on the surface: x = {} to {} m and y = {} to {} m",
                    low.x, high.x, low.y, high.y
                );
                return Err(path.key("position").error(reason).into());
            }
            imprints.push(imprint.keys().build(&path)?);
        }
        let Self { heights, far_left_m, cell_m, tolerance_m, .. } = self;
        let terrain = Terrain { heights, far_left_m, cell_m, filling, imprints };
        let parts = vec![object.place(terrain.solid(tolerance_m).map_err(wrong)?)?];
        let undisturbed = if terrain.imprints.is_empty() {
            None
        } else {
            UndisturbedSurface::new(Arc::new(terrain), object.placing.to_scene())
        };
        Ok(BuiltShape { parts, body: None, undisturbed })
    }
}

/// A grid of rows from far (greatest y) to near, each from left to right, among which `no_data` marks missing heights.
fn grid_of_rows(rows: &[Vec<f64>], path: &KeyPath, no_data: Option<f32>) -> Result<HeightGrid, KeyError> {
    if rows.windows(2).any(|pair| pair[0].len() != pair[1].len()) {
        return Err(path.error("must be a list of lists of numbers, all of one length"));
    }
    let values = rows.iter().flatten().copied().map(narrow).collect();
    HeightGrid::new(rows.first().map_or(0, Vec::len), values, [None, no_data], Ok(None))
        .map_err(|reason| path.error(format!("cannot be used: {reason}")))
}

/// The grid of a file.
pub(super) fn read_grid(
    path: &KeyPath,
    file: &str,
    sources: &Sources,
    stated: &StatedByUser,
) -> Result<HeightGrid, SceneError> {
    HeightGrid::read(sources.files, file, stated).map_err(|error| sources.named(path, file, error))
}

/// A note on a map that states no unit; `key` is the path to the map.
pub(super) fn note_on_unit(map: &Georeference, key: &KeyPath) -> Option<String> {
    (!map.states_unit).then(|| {
        format!("{key} states no coordinate system: its coordinates count as metres (`map_unit` states their unit)")
    })
}

/// Fills missing heights; `key` is the path to the heights.
pub(super) fn filled(grid: HeightGrid, fill_m: Option<f64>, key: &KeyPath) -> Result<HeightGrid, KeyError> {
    grid.filled(fill_m.map(narrow)).map_err(|reason| {
        key.error(format!("cannot be used: {reason}; `fill` gives a height for them, and `crop` leaves them out"))
    })
}

/// The heights of a grid without missing heights.
pub(super) fn heights_of(grid: HeightGrid, key: &KeyPath) -> Result<Heights, KeyError> {
    Heights::new(grid.columns, grid.values).map_err(|reason| key.error(format!("cannot be used: {reason}")))
}
