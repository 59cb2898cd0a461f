//! The camera as data.

use glam::Vec3A;
use serde::{Deserialize, Serialize};
use snowblue_geometry::ray::narrow;

use super::value::{numbers, point};
use crate::camera::{Lens, View};

/// A camera: a pinhole, or a thin lens.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraDescription {
    /// Position, in m.
    #[serde(deserialize_with = "numbers")]
    pub position: [f64; 3],
    /// The point in the middle of the picture, in m.
    #[serde(deserialize_with = "numbers")]
    pub look_at: [f64; 3],
    /// The direction that points upwards in the picture, of any length.
    #[serde(default = "upwards", deserialize_with = "numbers")]
    pub up: [f64; 3],
    /// Angle between the upper and the lower edge of the picture, in degrees.
    #[serde(default = "CameraDescription::default_vertical_fov_deg")]
    pub vertical_fov_deg: f64,
    /// Diameter of the aperture of the lens, in m; 0 for a pinhole, which sees everything sharp.
    #[serde(default)]
    pub aperture: f64,
    /// Distance of the plane of focus along the viewing axis, in m; that of `look_at` if none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub focus: Option<f64>,
}

impl CameraDescription {
    /// An upright pinhole camera with a field of view of 40°.
    pub fn new(position: [f64; 3], look_at: [f64; 3]) -> Self {
        let vertical_fov_deg = Self::default_vertical_fov_deg();
        Self { position, look_at, up: upwards(), vertical_fov_deg, aperture: 0.0, focus: None }
    }

    /// The lens in single precision.
    pub(crate) fn lens(&self) -> Lens {
        Lens { aperture_m: narrow(self.aperture), focus_m: self.focus.map(narrow) }
    }

    /// The camera with another view and the same lens.
    pub(crate) fn with_view(self, view: &View) -> Self {
        Self { aperture: self.aperture, focus: self.focus, ..Self::from(view) }
    }

    fn default_vertical_fov_deg() -> f64 {
        40.0
    }

    /// The same in single precision.
    pub(crate) fn view(&self) -> View {
        View {
            position: point(self.position),
            look_at: point(self.look_at),
            up: point(self.up),
            vertical_fov_deg: narrow(self.vertical_fov_deg),
        }
    }
}

impl From<&View> for CameraDescription {
    fn from(view: &View) -> Self {
        let wide = |vector: Vec3A| vector.as_dvec3().to_array();
        Self {
            position: wide(view.position),
            look_at: wide(view.look_at),
            up: wide(view.up),
            vertical_fov_deg: view.vertical_fov_deg.into(),
            aperture: 0.0,
            focus: None,
        }
    }
}

/// The z axis.
pub(crate) fn upwards() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}
