//! Igloos.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_base::{Count, KeyError, KeyPath, Number, ParameterRange, quantities};
use snowblue_shapes::igloo::Igloo;

use super::keys::{BuiltShape, ObjectContext, ShapeKeys, check_shapes};
use crate::error::SceneError;
use crate::values::first_seed;

quantities! {
    /// Radius of an igloo inside.
    pub InnerRadius = ParameterRange::new("inner radius", 0.5, 10.0, "m");
    /// Thickness of the blocks.
    pub WallThickness = ParameterRange::new("wall", 0.02, 5.0, "m");
    /// Courses of blocks.
    pub Courses = ParameterRange::new("courses", 2.0, 20.0, "");
    /// Width of a block.
    pub BlockWidth = ParameterRange::new("width of a block", 0.1, 10.0, "m");
    /// Depth of the seams.
    pub SeamDepth = ParameterRange::new("depth of seams", 0.0, 2.0, "m");
    /// Width of the seams.
    pub SeamWidth = ParameterRange::new("width of seams", 0.005, 0.5, "m");
}

/// An igloo about the origin, one object for each block, all of one body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct IglooDescription {
    /// Radius inside, in m.
    pub inner_radius: Number<InnerRadius>,
    /// Thickness of the blocks in their middle, in m; at most half the radius.
    pub wall: Number<WallThickness>,
    /// Courses of blocks below the king block.
    pub courses: Count<Courses>,
    /// Width of a block, in m; at most the radius.
    pub block_width: Number<BlockWidth>,
    /// Depth of the seams on either face, in m; a quarter of the wall if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seam_depth: Option<Number<SeamDepth>>,
    /// Width of the seams, in m.
    pub seam_width: Number<SeamWidth>,
    /// Seed of the unevenness.
    pub seed: u32,
}

impl Default for IglooDescription {
    fn default() -> Self {
        Self {
            inner_radius: Number::of(1.5),
            wall: Number::of(0.15),
            courses: Count::of(6),
            block_width: Number::of(0.6),
            seam_depth: None,
            seam_width: Number::of(0.05),
            seed: first_seed(),
        }
    }
}

impl ShapeKeys for IglooDescription {
    fn build(&self, object: &mut ObjectContext) -> Result<BuiltShape, SceneError> {
        check_shapes(object.path)?;
        let blocks = self.igloo(object.path)?.blocks().into_iter();
        let parts = blocks.map(|block| object.place(block)).collect::<Result<_, _>>()?;
        // The blocks of an igloo are one solid, whether or not the object names a body.
        let body = object.is_snow.then(|| format!("igloo at {}", object.placing.position));
        Ok(BuiltShape { parts, body, undisturbed: None })
    }
}

impl IglooDescription {
    fn igloo(&self, path: &KeyPath) -> Result<Igloo, KeyError> {
        let (inner_radius_m, wall_m) = (self.inner_radius.get(), self.wall.get());
        let at_most = |key: &str, value: f64, most: f64, of_what: &str| {
            let reason = || format!("is {value} m, but must be at most {most} m, {of_what}");
            if value <= most { Ok(value) } else { Err(path.key(key).error(reason())) }
        };
        at_most("wall", wall_m, 0.5 * inner_radius_m, "half the inner radius")?;
        let seam_depth_m = self.seam_depth.map_or(0.25 * wall_m, Number::get);
        Ok(Igloo {
            inner_radius_m,
            wall_m,
            courses: self.courses.get(),
            block_width_m: at_most("block_width", self.block_width.get(), inner_radius_m, "the inner radius")?,
            // The relief must not break through a seam.
            seam_depth_m: at_most("seam_depth", seam_depth_m, 0.4 * wall_m, "0.4 times the wall")?,
            seam_width_m: self.seam_width.get(),
            seed: self.seed,
        })
    }
}
