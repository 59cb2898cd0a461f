//! Cameras and lights of a glTF, as plain values in the scene's axes.

use glam::{DAffine3, DVec3, Vec3A};
use gltf::camera::Projection;
use gltf::khr_lights_punctual::Kind;
use snowblue_color::LinearRgb;

use super::{GltfFile, PlacedNode};
use crate::scene::camera::View;

/// A light of the glTF extension KHR_lights_punctual, in the scene's axes.
#[derive(Debug, Clone, PartialEq)]
pub struct PunctualLight {
    /// Its node's name.
    pub name: String,
    /// Its kind, with its strength.
    pub kind: LightKind,
    /// Where it is, in m; of no meaning for a directional light.
    pub position: Vec3A,
    /// Where it shines, a unit vector; of no meaning for a point light.
    pub direction: Vec3A,
    /// Its colour, which multiplies its strength channel by channel.
    pub colour: LinearRgb,
}

/// The kind of a light of a glTF.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LightKind {
    /// Shines alike in all directions.
    Point {
        /// Luminous intensity, in cd.
        intensity_cd: f64,
    },
    /// Shines in one direction from infinitely far.
    Directional {
        /// Illuminance of a surface across it, in lx.
        illuminance_lx: f64,
    },
    /// Shines in a cone; between the angles it fades.
    Spot {
        /// Luminous intensity within the inner cone, in cd.
        intensity_cd: f64,
        /// Half the opening of the inner cone, in degrees.
        inner_cone_deg: f64,
        /// Half the opening of the outer cone, in degrees.
        outer_cone_deg: f64,
    },
}

impl GltfFile {
    /// The view of the first perspective camera among placed nodes, if there is one.
    pub fn view(&self, nodes: &[PlacedNode]) -> Option<View> {
        nodes.iter().find_map(|placed| {
            let camera = placed.node.camera()?;
            let Projection::Perspective(lens) = camera.projection() else {
                return None;
            };
            let position = placed.to_root.translation;
            Some(View {
                position: position.as_vec3a(),
                look_at: (position + ahead(&placed.to_root)?).as_vec3a(),
                up: placed.to_root.transform_vector3(DVec3::Y).as_vec3a(),
                vertical_fov_deg: lens.yfov().to_degrees(),
            })
        })
    }

    /// The lights among placed nodes.
    pub fn lights(&self, nodes: &[PlacedNode]) -> Vec<PunctualLight> {
        let light = |placed: &PlacedNode| {
            let light = placed.node.light()?;
            let strength = f64::from(light.intensity());
            let [r, g, b] = light.color().map(f64::from);
            Some(PunctualLight {
                name: placed.name(),
                kind: match light.kind() {
                    Kind::Point => LightKind::Point { intensity_cd: strength },
                    Kind::Directional => LightKind::Directional { illuminance_lx: strength },
                    Kind::Spot { inner_cone_angle, outer_cone_angle } => LightKind::Spot {
                        intensity_cd: strength,
                        inner_cone_deg: f64::from(inner_cone_angle).to_degrees(),
                        outer_cone_deg: f64::from(outer_cone_angle).to_degrees(),
                    },
                },
                position: placed.to_root.translation.as_vec3a(),
                direction: ahead(&placed.to_root)?.as_vec3a().normalize(),
                colour: LinearRgb { r, g, b },
            })
        };
        nodes.iter().filter_map(light).collect()
    }
}

/// Where a camera or light looks: along the negative z axis of its node.
fn ahead(to_root: &DAffine3) -> Option<DVec3> {
    to_root.transform_vector3(DVec3::NEG_Z).try_normalize()
}
