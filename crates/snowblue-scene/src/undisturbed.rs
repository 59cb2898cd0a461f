//! Surfaces of snow before poles and boots were pressed into them. The layers of snow below a print keep their depths
//! below this surface.

use std::sync::Arc;

use glam::{DAffine3, DVec2};

use snowblue_base::narrow;
use snowblue_shapes::terrain::Terrain;

/// The surface of an object before anything was pressed into it.
#[derive(Debug)]
pub struct UndisturbedSurface {
    terrain: Arc<Terrain>,
    to_scene: DAffine3,
    to_object: DAffine3,
}

impl UndisturbedSurface {
    /// The surface of an object in its place; none if the object is tilted, so that its heights are not along z.
    pub(crate) fn new(terrain: Arc<Terrain>, to_scene: DAffine3) -> Option<Self> {
        let matrix = to_scene.matrix3;
        let tilt = matrix.z_axis.truncate().length().max(matrix.x_axis.z.abs()).max(matrix.y_axis.z.abs());
        // Rotations are given in single precision.
        let is_upright = tilt < 1e-6 * matrix.z_axis.z;
        is_upright.then(|| Self { terrain, to_scene, to_object: to_scene.inverse() })
    }

    /// Height of the surface above or below a point of the scene, in m; none beyond the edges of the surface. Where
    /// there is no snow, this is the height of the snow's underside.
    pub fn height_m(&self, x_m: f32, y_m: f32) -> Option<f32> {
        let in_object = self.to_object.transform_point3(DVec2::new(x_m.into(), y_m.into()).extend(0.0));
        let height_m = self.terrain.undisturbed_m(in_object.truncate())?;
        Some(narrow(self.to_scene.transform_point3(in_object.with_z(height_m)).z))
    }
}
