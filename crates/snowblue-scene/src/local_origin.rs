//! Scenes far from the origin of their coordinates, as in a national grid.
//!
//! Rays have single precision, which resolves half a metre at the coordinates of a national grid. A scene is therefore
//! built around a local origin near the point that the camera looks at, or near its first object. Positions of a
//! description have double precision, so that nothing is lost.

use glam::DVec3;
use snowblue_base::{KeyError, KeyPath, Number, Numbers};
use snowblue_geometry::transform::origin_near;

use crate::light::LightSource;
use crate::material::{LayersTop, MaterialDescription, SnowDescription};
use crate::scene::SceneDescription;
use crate::values::{Coordinate, MAX_REACH_M};

impl SceneDescription {
    /// The description around a local origin, near the point that its camera looks at, or else near its first object.
    pub(crate) fn around_local_origin(&self) -> Result<Self, KeyError> {
        let seen = self.camera.as_ref().map(|camera| camera.look_at.get());
        let centre = seen.or_else(|| self.objects.first().map(|object| object.common.position.get()));
        self.around(origin_near(centre.unwrap_or_default().into()))
    }

    /// The description around an origin in its own coordinates, in m.
    pub(crate) fn around(&self, origin: DVec3) -> Result<Self, KeyError> {
        let mut moved = self.clone();
        if origin == DVec3::ZERO {
            return Ok(moved);
        }
        moved.local_origin += origin;
        if let Some(camera) = &mut moved.camera {
            let path = KeyPath::root("camera");
            move_near(&path.key("position"), &mut camera.position, origin)?;
            move_near(&path.key("look_at"), &mut camera.look_at, origin)?;
        }
        for (index, light) in moved.lights.iter_mut().enumerate() {
            let positions: &mut [(&str, &mut Numbers<Coordinate, 3>)] = match &mut light.source {
                LightSource::Point(light) => &mut [("position", &mut light.position)],
                LightSource::Sphere(light) => &mut [("position", &mut light.position)],
                LightSource::Spot(light) => &mut [("position", &mut light.position), ("look_at", &mut light.look_at)],
                LightSource::Rectangle(light) => {
                    &mut [("position", &mut light.position), ("look_at", &mut light.look_at)]
                }
                LightSource::Directional(_) => &mut [],
            };
            for (key, position) in positions {
                move_near(&KeyPath::root("light").index(index).key(key), position, origin)?;
            }
        }
        // The origin of an object may be far away from its shape.
        for (index, object) in moved.objects.iter_mut().enumerate() {
            let path = KeyPath::root("object").index(index).key("position");
            let position = &mut object.common.position;
            *position = Numbers::new((DVec3::from(position.get()) - origin).to_array())
                .map_err(|error| path.error(format!("does not fit to a camera near {origin} m: {error}")))?;
        }
        for (name, material) in &mut moved.materials {
            if let MaterialDescription::Snow(snow) = material
                && let SnowDescription::Layers(layers) = &mut snow.snow
                && let LayersTop::Height(height) = &mut layers.layers_top
            {
                let path = KeyPath::root("material").key(name).key("layers_top");
                *height = Number::new(height.get() - origin.z).map_err(|error| path.error(error.to_string()))?;
            }
        }
        Ok(moved)
    }
}

/// Moves a position, which must lie near the local origin.
fn move_near(path: &KeyPath, position: &mut Numbers<Coordinate, 3>, origin: DVec3) -> Result<(), KeyError> {
    let moved = DVec3::from(position.get()) - origin;
    if moved.abs().max_element() > MAX_REACH_M {
        return Err(path.error(format!(
            "is {:.0} km from the point that the camera looks at, but must lie within {} km",
            moved.length() / 1e3,
            MAX_REACH_M / 1e3
        )));
    }
    *position = Numbers::of(moved.to_array());
    Ok(())
}
