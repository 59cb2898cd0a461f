//! Cameras and punctual lights of a glTF, in the scene's axes.

use glam::{DAffine3, DVec3, Vec3A};
use gltf::camera::Projection;
use gltf::khr_lights_punctual::Kind;
use snowblue_color::LinearRgb;
use snowblue_geometry::mesh_files::gltf::PlacedNode;

use crate::camera::View;

/// A light of the glTF extension KHR_lights_punctual, in the scene's axes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PunctualLight {
    /// Name of its node.
    pub(super) name: String,
    /// Its kind and intensity.
    pub(super) kind: LightKind,
    /// Position in m; unused for a directional light.
    pub(super) position: Vec3A,
    /// Unit direction in which it emits; unused for a point light.
    pub(super) direction: Vec3A,
    /// Its colour, a factor on the intensity of each channel.
    pub(super) colour: LinearRgb,
}

/// Kind of a glTF light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum LightKind {
    /// Emits equally in all directions.
    Point {
        /// Luminous intensity, in cd.
        intensity_cd: f64,
    },
    /// Emits in one direction from infinitely far away.
    Directional {
        /// Illuminance of a surface perpendicular to the light, in lx.
        illuminance_lx: f64,
    },
    /// Emits in a cone, with a falloff between the two angles.
    Spot {
        /// Luminous intensity in the inner cone, in cd.
        intensity_cd: f64,
        /// Half angle of the inner cone, in degrees.
        inner_cone_deg: f64,
        /// Half angle of the outer cone, in degrees.
        outer_cone_deg: f64,
    },
}

impl PunctualLight {
    /// Luminous intensity in cd, or illuminance in lx.
    pub(super) fn strength(&self) -> f64 {
        match self.kind {
            LightKind::Point { intensity_cd } | LightKind::Spot { intensity_cd, .. } => intensity_cd,
            LightKind::Directional { illuminance_lx } => illuminance_lx,
        }
    }

    /// Whether it is not black.
    pub(super) fn shines(&self) -> bool {
        self.strength() * self.colour.luminance() != 0.0
    }
}

/// The view of the first perspective camera among nodes, if there is one.
pub(super) fn view(nodes: &[PlacedNode]) -> Option<View> {
    nodes.iter().find_map(|placed| {
        let camera = placed.node.camera()?;
        let Projection::Perspective(lens) = camera.projection() else {
            return None;
        };
        let position = placed.to_root.translation;
        Some(View {
            position: position.as_vec3a(),
            look_at: (position + forward(&placed.to_root)?).as_vec3a(),
            up: placed.to_root.transform_vector3(DVec3::Y).as_vec3a(),
            vertical_fov_deg: lens.yfov().to_degrees(),
        })
    })
}

/// Sentences on cameras and lights that are not read as they are.
pub(super) fn notes(nodes: &[PlacedNode]) -> Vec<String> {
    let mut cameras = nodes.iter().filter_map(|placed| placed.node.camera());
    let is_orthographic = |camera: gltf::Camera| matches!(camera.projection(), Projection::Orthographic(_));
    let has_range = |placed: &PlacedNode| placed.node.light().is_some_and(|light| light.range().is_some());
    let notes = [
        (cameras.any(is_orthographic), "an orthographic camera is not read"),
        (nodes.iter().any(has_range), "the range of lights is not read: their light reaches everywhere"),
    ];
    notes.into_iter().filter(|(is_so, _)| *is_so).map(|(_, note)| note.to_owned()).collect()
}

/// The lights of nodes.
pub(super) fn punctual_lights(nodes: &[PlacedNode]) -> Vec<PunctualLight> {
    let light = |placed: &PlacedNode| {
        let light = placed.node.light()?;
        let intensity = f64::from(light.intensity());
        let [r, g, b] = light.color().map(f64::from);
        Some(PunctualLight {
            name: placed.name(),
            kind: match light.kind() {
                Kind::Point => LightKind::Point { intensity_cd: intensity },
                Kind::Directional => LightKind::Directional { illuminance_lx: intensity },
                Kind::Spot { inner_cone_angle, outer_cone_angle } => LightKind::Spot {
                    intensity_cd: intensity,
                    inner_cone_deg: f64::from(inner_cone_angle).to_degrees(),
                    outer_cone_deg: f64::from(outer_cone_angle).to_degrees(),
                },
            },
            position: placed.to_root.translation.as_vec3a(),
            direction: forward(&placed.to_root)?.as_vec3a().normalize(),
            colour: LinearRgb { r, g, b },
        })
    };
    nodes.iter().filter_map(light).collect()
}

/// The direction of a camera or light: the negative z axis of its node.
fn forward(to_root: &DAffine3) -> Option<DVec3> {
    to_root.transform_vector3(DVec3::NEG_Z).try_normalize()
}

#[cfg(test)]
mod tests {
    use snowblue_base::files::FilesInMemory;
    use snowblue_geometry::mesh_files::gltf::{GltfFile, Y_UP_TO_Z_UP};

    use super::*;

    const LAMP: &str = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [
            {"type": "point", "intensity": 30, "color": [1, 0.5, 0.25]}]}},
        "nodes": [{"translation": [0, 1, 0], "children": [1]}, {"name": "lamp", "translation": [0, 2, 0],
        "extensions": {"KHR_lights_punctual": {"light": 0}}}]}"#;

    #[test]
    fn lights_are_transformed_like_meshes() {
        let file = GltfFile::read(&FilesInMemory::from([("lamp.gltf", LAMP)]), "lamp.gltf").unwrap();
        let lights = punctual_lights(&file.nodes(DAffine3::from_mat3(Y_UP_TO_Z_UP)).unwrap());
        let [lamp] = &lights[..] else { panic!("{lights:?}") };
        assert_eq!((lamp.name.as_str(), lamp.kind), ("lamp", LightKind::Point { intensity_cd: 30.0 }));
        assert!((lamp.position - Vec3A::new(0.0, 0.0, 3.0)).length() < 1e-6);
        assert!((lamp.colour.g - 0.5).abs() < 1e-6);
    }
}
