//! Scenes far from the origin of their coordinates, as in a national grid.
//!
//! Rays have single precision, which resolves half a metre at the coordinates of a national grid. A scene is therefore
//! built around a local origin near the point that the camera looks at. Positions of a description have double
//! precision, so that nothing is lost.

use glam::DVec3;
use snowblue_base::{Number, Numbers};

use crate::light::LightSource;
use crate::material::{LayersTop, MaterialDescription, SnowDescription};
use crate::scene::SceneDescription;
use crate::values::Coordinate;

/// Coordinates of a local origin are multiples of this length in m, so that most scenes keep their coordinates.
const STEP_M: f64 = 1000.0;

impl SceneDescription {
    /// The description around its local origin, and this origin in the coordinates of `self`, in m. Without a camera in
    /// the description it is 0.
    pub(crate) fn around_local_origin(&self) -> (Self, DVec3) {
        let centre = self.camera.as_ref().map_or(DVec3::ZERO, |camera| camera.look_at.get().into());
        let origin = (centre / STEP_M).round() * STEP_M;
        let mut moved = self.clone();
        if origin != DVec3::ZERO {
            moved.move_by(-origin);
        }
        (moved, origin)
    }

    /// Moves everything in the description.
    fn move_by(&mut self, by: DVec3) {
        let move_point = |position: &mut Numbers<Coordinate, 3>| {
            *position = Numbers::nearest((DVec3::from(position.get()) + by).to_array());
        };
        if let Some(camera) = &mut self.camera {
            [&mut camera.position, &mut camera.look_at].into_iter().for_each(move_point);
        }
        self.objects.iter_mut().for_each(|object| move_point(&mut object.common.position));
        for light in &mut self.lights {
            match &mut light.source {
                LightSource::Point(light) => move_point(&mut light.position),
                LightSource::Sphere(light) => move_point(&mut light.position),
                LightSource::Spot(light) => [&mut light.position, &mut light.look_at].into_iter().for_each(move_point),
                LightSource::Rectangle(light) => {
                    [&mut light.position, &mut light.look_at].into_iter().for_each(move_point);
                }
                LightSource::Directional(_) => {}
            }
        }
        for material in self.materials.values_mut() {
            if let MaterialDescription::Snow(snow) = material
                && let SnowDescription::Layers(layers) = &mut snow.snow
                && let LayersTop::Height(height) = &mut layers.layers_top
            {
                let [moved] = Numbers::<Coordinate, 1>::nearest([height.get() + by.z]).get();
                *height = Number::of(moved);
            }
        }
    }
}
