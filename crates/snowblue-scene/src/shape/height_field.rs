//! Solids under a surface of heights.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_base::toml_table::Table;
use snowblue_base::{Number, ParseError, narrow};
use snowblue_shapes::terrain::Filling;

use super::grid::{GridSettings, GridSource, PlacedGrid, filled, heights_of};
use super::keys::{BuiltShape, ObjectContext, ShapeKeys, check_shapes};
use crate::error::SceneError;
use crate::values::{Coordinate, point};

/// Default distance of the bottom below the least height, as a fraction of the longer side.
const BOTTOM_OF_SIDE: f64 = 0.01;

/// A solid under a surface of heights.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HeightFieldDescription {
    /// Rows of heights from far (greatest y) to near, each from left to right, all of one length; multiplied by the
    /// third number of `size`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heights: Option<Vec<Vec<f64>>>,
    /// A grey PNG, white being 1, an OpenEXR image of one channel, an ESRI ASCII grid or a GeoTIFF, instead of rows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Where they lie.
    #[serde(flatten, skip_deserializing)]
    #[schemars(!skip_deserializing)]
    pub grid: GridSettings,
    /// Where the solid ends below, in m; by default a hundredth of the longer side below the least height.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bottom: Option<Number<Coordinate>>,
}

impl HeightFieldDescription {
    /// Reads the keys of a table.
    pub(super) fn read(mut table: Table) -> Result<Self, ParseError> {
        let grid = table.split(&GridSettings::KEYS).read()?;
        Ok(Self { grid, ..table.read()? })
    }
}

impl ShapeKeys for HeightFieldDescription {
    fn build(&self, object: &mut ObjectContext) -> Result<BuiltShape, SceneError> {
        let (path, settings) = (object.path, &self.grid);
        let given = [
            ("heights", self.heights.as_ref().map(GridSource::Rows)),
            ("file", self.file.as_ref().map(GridSource::File)),
        ];
        let (grid, key) = settings.read(given, object)?;
        // The reason begins with the name of the key.
        let wrong = |reason: String| match reason.strip_prefix("bottom ") {
            Some(reason) => SceneError::from(path.key("bottom").error(reason)),
            None => path.error(reason).into(),
        };
        let bottom_m = self.bottom.map(|bottom| narrow(bottom.get()));
        let others = GridSettings { size: None, ..settings.clone() };
        if let (Some(size), [], None, Some(bottom_m)) = (settings.size, object.imprints, others.first_key(), bottom_m) {
            let heights = heights_of(filled(grid, None, &key)?, &key)?;
            return Ok(object.place(heights.solid(point(size).into(), bottom_m).map_err(wrong)?)?.into());
        }
        check_shapes(path)?;
        let placed = PlacedGrid::new(path, &key, grid, settings, object.notes)?;
        let usual_m = f64::from(placed.least_m()) - BOTTOM_OF_SIDE * placed.size_m().max_element();
        placed.build(object, Filling::Below(bottom_m.map_or(usual_m, f64::from)), wrong)
    }

    fn takes_imprints(&self) -> bool {
        true
    }
}
