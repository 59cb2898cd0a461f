//! Boxes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_base::Numbers;
use snowblue_geometry::cuboid::Cuboid;
use snowblue_geometry::shape::Shape;

use super::keys::{BuiltShape, ObjectContext, ShapeKeys};
use crate::error::SceneError;
use crate::values::{ShapeSize, point};

/// A box about the origin.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxDescription {
    /// Its lengths along x, y and z, in m.
    pub size: Numbers<ShapeSize, 3>,
}

impl ShapeKeys for BoxDescription {
    fn build(&self, object: &mut ObjectContext) -> Result<BuiltShape, SceneError> {
        let placing = &object.placing;
        let size = (point(self.size).as_dvec3() * placing.scale).as_vec3a();
        Ok(Shape::Cuboid(Cuboid::new(placing.position.as_vec3a(), size, placing.axes())).into())
    }
}
