//! The scene files that figures render, and the changes that figures make to them.

use snowblue_render::scene::description::{
    LightSource, MaterialDescription, SceneDescription, ShapeDescription, SnowDescription, SnowMaterialDescription,
};
use snowblue_render::{RenderError, SceneFile};

pub(crate) const LAMP: &str = include_str!("../scenes/fig1_lamp.toml");
pub(crate) const BLOCK_FRONT: &str = include_str!("../scenes/fig9_front.toml");
pub(crate) const BLOCK_BACK: &str = include_str!("../scenes/fig9_back.toml");
pub(crate) const BLOCK_OBLIQUE: &str = include_str!("../scenes/fig9_oblique.toml");
pub(crate) const IGLOO: &str = include_str!("../scenes/fig10_igloo.toml");
pub(crate) const IGLOO_OPAQUE: &str = include_str!("../scenes/fig10_opaque.toml");
pub(crate) const DRAGON: &str = include_str!("../scenes/fig11_dragon.toml");
pub(crate) const BALL: &str = include_str!("../scenes/truth_ball.toml");
pub(crate) const CORNER: &str = include_str!("../scenes/truth_corner.toml");
pub(crate) const FLOOR: &str = include_str!("../scenes/truth_floor.toml");

/// Reads one of these scenes.
pub(crate) fn read(text: &str) -> Result<SceneDescription, RenderError> {
    Ok(SceneFile::parse(text, "scene.toml")?.description)
}

/// Sets the thickness of the block, the first object of a scene, in m.
pub(crate) fn set_thickness(scene: &mut SceneDescription, thickness_m: f64) {
    if let ShapeDescription::Box(block) = &mut scene.objects[0].shape {
        block.size[1] = thickness_m;
    }
}

/// Moves the first light of a scene, a point, to a position in m.
pub(crate) fn set_lamp_position(scene: &mut SceneDescription, position: [f64; 3]) {
    if let LightSource::Point(lamp) = &mut scene.lights[0].source {
        lamp.position = position;
    }
}

/// Multiplies the radiance of the first light of a scene, a sphere.
pub(crate) fn scale_lamp(scene: &mut SceneDescription, factor: f64) {
    if let LightSource::Sphere(lamp) = &mut scene.lights[0].source {
        lamp.radiance_w_m2_sr *= factor;
    }
}

/// Sets the grain size of all snow, in µm.
pub(crate) fn set_grain_size(scene: &mut SceneDescription, grain_size_um: f64) {
    for material in scene.materials.values_mut() {
        if let MaterialDescription::Snow(SnowMaterialDescription { snow: SnowDescription::Uniform(snow), .. }) =
            material
        {
            snow.grain_size_um = Some(vec![grain_size_um]);
        }
    }
}

/// Sets the mesh file of the first object.
pub(crate) fn set_mesh(scene: &mut SceneDescription, file: &str) {
    if let ShapeDescription::Mesh(mesh) = &mut scene.objects[0].shape {
        file.clone_into(&mut mesh.mesh);
    }
}
