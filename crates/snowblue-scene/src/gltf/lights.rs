//! Cameras and punctual lights of a glTF, in the scene's axes.

use glam::{DAffine3, DVec3};
use gltf::camera::Projection;
use gltf::khr_lights_punctual::Kind;
use snowblue_base::files::first_names;
use snowblue_base::narrow;
use snowblue_geometry::mesh_files::gltf::PlacedNode;

use crate::camera::View;
use crate::light::Light;
use crate::light::directional::DirectionalLight;
use crate::light::point::PointLight;
use crate::light::sample::SpotCone;
use crate::light::spot::SpotLight;
use crate::spectrum::light_spectrum::lumens_per_watt_of_luminance_one;
use crate::spectrum::upsampling::Upsampling;

/// Greatest strength of a light, in cd or lx.
const MAX_STRENGTH: f32 = 1e15;

/// The view of the first perspective camera among nodes, if there is one. Other cameras get a sentence in `notes`.
pub(super) fn view(nodes: &[PlacedNode], notes: &mut Vec<String>) -> Option<View> {
    let view_of = |placed: &PlacedNode| {
        let camera = placed.node.camera()?;
        let Projection::Perspective(lens) = camera.projection() else { return None };
        let position = placed.to_root.translation;
        Some(View {
            position: position.as_vec3a(),
            look_at: (position + forward(&placed.to_root)?).as_vec3a(),
            up: placed.to_root.transform_vector3(DVec3::Y).as_vec3a(),
            vertical_fov_deg: lens.yfov().to_degrees(),
        })
    };
    let mut cameras: Vec<&PlacedNode> = nodes.iter().filter(|placed| placed.node.camera().is_some()).collect();
    let first = cameras.iter().position(|placed| view_of(placed).is_some());
    let view = first.and_then(|first| view_of(cameras.remove(first)));
    if !cameras.is_empty() {
        let names: Vec<String> = cameras.iter().map(|placed| format!("\"{}\"", placed.name())).collect();
        notes.push(format!("cameras of the glTF that are not read: {}", first_names(&names, names.len())));
    }
    view
}

/// The lights of nodes. Adds sentences on what is not read as it is in the file to `notes`.
///
/// A light's strength is in candela or lux. Its spectrum is daylight (D65) times its colour, scaled so that ȳ gives the
/// same number of lumens at 683 lm/W (Khronos Group 2020, KHR_lights_punctual).
pub(super) fn lights(nodes: &[PlacedNode], notes: &mut Vec<String>) -> Result<Vec<Light>, String> {
    let mut lights = Vec::new();
    for placed in nodes {
        let Some(light) = placed.node.light() else { continue };
        let (name, strength, [r, g, b]) = (placed.name(), light.intensity(), light.color());
        if ![r, g, b, strength].iter().all(|value| (0.0..=MAX_STRENGTH).contains(value)) {
            return Err(format!("light \"{name}\" is {strength} times {r}, {g}, {b}, but must be positive and finite"));
        }
        if strength * (r + g + b) <= 0.0 {
            notes.push(format!("light \"{name}\" is black and left out"));
            continue;
        }
        if light.range().is_some() {
            notes.push(format!("light \"{name}\" has a range, which is not read: its light reaches everywhere"));
        }
        let scale = narrow(f64::from(strength) / lumens_per_watt_of_luminance_one());
        let emission = Upsampling::daylight().spectrum([r, g, b]) * scale;
        let position = placed.to_root.translation.as_vec3a();
        let direction =
            forward(&placed.to_root).ok_or_else(|| format!("light \"{name}\" has a scale of 0"))?.as_vec3a();
        lights.push(match light.kind() {
            Kind::Point => Light::new(PointLight { position, emission }),
            Kind::Directional => Light::new(DirectionalLight { to_light: -direction, emission }),
            Kind::Spot { inner_cone_angle, outer_cone_angle } => {
                let [inner_deg, outer_deg] = [inner_cone_angle, outer_cone_angle].map(f32::to_degrees);
                // Blender writes equal cones for a hard edge.
                if inner_deg > outer_deg {
                    return Err(format!(
                        "spot \"{name}\" has an inner cone of {inner_deg}°, but must be within its outer cone of \
                         {outer_deg}°"
                    ));
                }
                Light::new(SpotLight { position, cone: SpotCone::new(direction, inner_deg, outer_deg), emission })
            }
        });
    }
    Ok(lights)
}

/// The direction of a camera or light: the negative z axis of its node.
fn forward(to_root: &DAffine3) -> Option<DVec3> {
    to_root.transform_vector3(DVec3::NEG_Z).try_normalize()
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;
    use snowblue_base::files::FilesInMemory;
    use snowblue_geometry::mesh_files::gltf::{GltfFile, Y_UP_TO_Z_UP};

    use super::*;
    use crate::light::sample::{LightOrigin, LightSample};

    const LAMP: &str = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [
            {"type": "point", "intensity": 30, "color": [1, 0.5, 0.25]}]}},
        "nodes": [{"translation": [0, 1, 0], "children": [1]}, {"name": "lamp", "translation": [0, 2, 0],
        "extensions": {"KHR_lights_punctual": {"light": 0}}}]}"#;

    #[test]
    fn lights_are_transformed_like_meshes() {
        let file = GltfFile::read(&FilesInMemory::from([("lamp.gltf", LAMP)]), "lamp.gltf").unwrap();
        let lights = lights(&file.nodes(DAffine3::from_mat3(Y_UP_TO_Z_UP)).unwrap(), &mut Vec::new()).unwrap();
        let [lamp] = &lights[..] else { panic!("one light") };
        let Some(LightSample { origin: LightOrigin::Point(position), .. }) = lamp.delta_sample() else {
            panic!("a point light");
        };
        assert!((position - Vec3A::new(0.0, 0.0, 3.0)).length() < 1e-6);
    }
}
