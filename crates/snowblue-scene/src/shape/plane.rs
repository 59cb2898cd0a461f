//! Planes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_geometry::plane::Plane;
use snowblue_geometry::shape::Shape;

use super::keys::{BuiltShape, ObjectContext, ShapeKeys};
use crate::error::SceneError;

/// The endless plane z = 0, which faces z until it is turned.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaneDescription {}

impl ShapeKeys for PlaneDescription {
    fn build(&self, object: &mut ObjectContext) -> Result<BuiltShape, SceneError> {
        let placing = &object.placing;
        if placing.scale != glam::DVec3::ONE {
            return Err(object.path.key("scale").error("does not apply to a plane, which is infinite").into());
        }
        Ok(Shape::Plane(Plane::new(placing.position.as_vec3a(), placing.axes())).into())
    }
}
