//! Drifts: ground under snow, with mounds.

use glam::DVec2;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize};
use snowblue_base::{Number, Numbers, ParameterRange, narrow, quantities};
use snowblue_shapes::drift::{Mound, drift, drift_heights};
use snowblue_shapes::terrain::Filling;

use super::grid::PlacedGrid;
use super::keys::{BuiltShape, ObjectContext, ShapeKeys, check_shapes};
use crate::error::SceneError;
use crate::values::{ShapeSize, SmallLength, first_seed, point};

quantities! {
    /// A number of a mound.
    pub MoundNumber = ParameterRange::new("number of a mound", -1e9, 1e9, "m");
}

/// Ground under snow, with mounds: snow of a depth below z = 0, with mounds above it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DriftDescription {
    /// Lengths along x and y, and the depth below z = 0, in m.
    pub size: Numbers<ShapeSize, 3>,
    /// The mounds, each as x, y, height and radius in m.
    #[serde(default)]
    pub mounds: Vec<MoundDescription>,
    /// Height of the unevenness, in m.
    #[serde(default)]
    pub relief: Number<SmallLength>,
    /// Seed of the unevenness.
    #[serde(default = "first_seed")]
    pub seed: u32,
}

/// A mound, written as a list of four numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Numbers<MoundNumber, 4>", into = "Numbers<MoundNumber, 4>")]
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

impl TryFrom<Numbers<MoundNumber, 4>> for MoundDescription {
    type Error = &'static str;

    fn try_from(numbers: Numbers<MoundNumber, 4>) -> Result<Self, &'static str> {
        let [x, y, height, radius] = numbers.get();
        if height <= 0.0 || radius <= 0.0 {
            return Err("must be x, y, height and radius in m, the last two above 0");
        }
        Ok(Self { x, y, height, radius })
    }
}

impl From<MoundDescription> for Numbers<MoundNumber, 4> {
    fn from(mound: MoundDescription) -> Self {
        Self::of([mound.x, mound.y, mound.height, mound.radius])
    }
}

impl JsonSchema for MoundDescription {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Mound".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        Numbers::<MoundNumber, 4>::json_schema(generator)
    }
}

impl ShapeKeys for DriftDescription {
    fn build(&self, object: &mut ObjectContext) -> Result<BuiltShape, SceneError> {
        let path = object.path;
        check_shapes(path)?;
        let single = |number: f64| f64::from(narrow(number));
        let mounds = self.mounds.iter().map(|mound| Mound {
            centre_m: DVec2::new(single(mound.x), single(mound.y)),
            height_m: single(mound.height),
            radius_m: single(mound.radius),
        });
        let mounds: Vec<_> = mounds.collect();
        let (size_m, relief_m) = (point(self.size).as_dvec3(), self.relief.get());
        let too_small = |reason: String| path.key("size").error(format!("is too small: {reason}"));
        if object.imprints.is_empty() {
            let solid = drift(size_m, &mounds, relief_m, self.seed);
            return Ok(object.place(solid.map_err(too_small)?)?.into());
        }
        let heights = drift_heights(size_m, &mounds, relief_m, self.seed).map_err(too_small)?;
        let cells = DVec2::new((heights.columns() - 1) as f64, (heights.rows() - 1) as f64);
        let placed = PlacedGrid {
            far_left_m: 0.5 * size_m.truncate() * DVec2::new(-1.0, 1.0),
            cell_m: size_m.truncate() / cells,
            heights,
            tolerance_m: 0.0,
            origin_on_map_m: None,
        };
        placed.build(object, Filling::Below(-size_m.z), |reason| match reason.strip_prefix("bottom ") {
            Some(_) => too_small(reason).into(),
            None => path.error(reason).into(),
        })
    }

    fn takes_imprints(&self) -> bool {
        true
    }
}
