//! Spheres.

use glam::{DAffine3, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_base::Number;
use snowblue_geometry::ellipsoid::Ellipsoid;
use snowblue_geometry::shape::Shape;

use super::keys::{BuiltShape, ObjectContext, ShapeKeys};
use crate::error::SceneError;
use crate::values::ShapeSize;

/// A sphere about the origin.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereDescription {
    /// Its radius, in m.
    pub radius: Number<ShapeSize>,
}

impl ShapeKeys for SphereDescription {
    fn build(&self, object: &mut ObjectContext) -> Result<BuiltShape, SceneError> {
        let to_scene = object.placing.to_scene() * DAffine3::from_scale(DVec3::splat(self.radius.get()));
        let ellipsoid = Ellipsoid::new(to_scene);
        Ok(Shape::Ellipsoid(ellipsoid.ok_or_else(|| object.path.key("scale").error("flattens the sphere"))?).into())
    }
}
