//! The scenes of the comparison: blocks of three thicknesses and a ball, in front of a far and a near lamp.

use snowblue_render::files::FilesInMemory;
use snowblue_render::scene::material::pca_snow::PathMode;
use snowblue_render::scene::{IntegratorKind, Scene};
use snowblue_render::{RenderError, SceneDescription};

use super::image::SIDE;
use crate::scenes;

/// A scene, with the name and the caption of its picture.
pub(super) struct Case {
    pub(super) name: &'static str,
    pub(super) caption: String,
    scene: SceneDescription,
    /// Samples per pixel of each reference rendering.
    pub(super) samples: u32,
    /// Whether it is a block seen straight on.
    pub(super) is_front: bool,
}

/// A view of the blocks, with the names of its pictures: far and near lamp, by thickness.
struct View {
    scene: &'static str,
    label: &'static str,
    is_front: bool,
    names: [[&'static str; 3]; 2],
}

const VIEWS: [View; 2] = [
    View {
        scene: scenes::BLOCK_BACK,
        label: "straight on",
        is_front: true,
        names: [["front_far_5", "front_far_10", "front_far_15"], ["front_near_5", "front_near_10", "front_near_15"]],
    },
    View {
        scene: scenes::BLOCK_OBLIQUE,
        label: "obliquely",
        is_front: false,
        names: [
            ["oblique_far_5", "oblique_far_10", "oblique_far_15"],
            ["oblique_near_5", "oblique_near_10", "oblique_near_15"],
        ],
    },
];

/// A thickness of the blocks. Thicker blocks transmit less light, and need more samples.
struct Thickness {
    label: &'static str,
    size_m: f64,
    samples: u32,
}

const THICKNESSES: [Thickness; 3] = [
    Thickness { label: "5 cm", size_m: 0.05, samples: 256 },
    Thickness { label: "10 cm", size_m: 0.1, samples: 512 },
    Thickness { label: "15 cm", size_m: 0.15, samples: 512 },
];

/// A position of the lamp, and its distance from the middle of the snow.
struct Lamp {
    position: [f64; 3],
    label: &'static str,
}

/// Behind a block.
const BLOCK_LAMPS: [Lamp; 2] =
    [Lamp { position: [0.0, 1.2, 0.2], label: "120 cm" }, Lamp { position: [0.0, 0.45, 0.2], label: "45 cm" }];

/// All scenes, with `sample_factor` times the samples.
pub(super) fn cases(sample_factor: u32) -> Result<Vec<Case>, RenderError> {
    let mut cases = Vec::new();
    for view in &VIEWS {
        let is_front = view.is_front;
        for (names, lamp) in view.names.into_iter().zip(&BLOCK_LAMPS) {
            for (name, thickness) in names.into_iter().zip(&THICKNESSES) {
                let Thickness { label, size_m, samples } = thickness;
                let mut scene = scenes::read(view.scene)?;
                scenes::set_thickness(&mut scene, *size_m);
                scenes::set_lamp_position(&mut scene, lamp.position);
                if let Some(camera) = &mut scene.camera {
                    camera.vertical_fov_deg = 17.0;
                }
                let (lamp, view) = (lamp.label, view.label);
                let caption = format!("A block of {label}, the lamp {lamp} behind its middle, seen {view}");
                let samples = samples * sample_factor;
                cases.push(Case { name, caption, scene, samples, is_front });
            }
        }
    }
    for (name, position, lamp) in [("ball_far", [0.5, 0.85, 0.2], "1 m"), ("ball_near", [0.1, 0.17, 0.04], "20 cm")] {
        let caption = format!("A ball 10 cm across, the lamp {lamp} from its middle");
        let mut scene = scenes::read(scenes::BALL)?;
        scenes::set_lamp_position(&mut scene, position);
        cases.push(Case { name, caption, scene, samples: 512 * sample_factor, is_front: false });
    }
    Ok(cases)
}

impl Case {
    /// The scene for path tracing.
    pub(super) fn reference(&self) -> Result<Scene, RenderError> {
        self.build(self.scene.clone(), IntegratorKind::Reference)
    }

    /// The scene for PCASnow with a path mode.
    pub(super) fn pcasnow(&self, mode: PathMode) -> Result<Scene, RenderError> {
        let mut scene = self.scene.clone();
        scene.set_path_mode(mode);
        self.build(scene, IntegratorKind::PcaSnow)
    }

    fn build(&self, mut scene: SceneDescription, kind: IntegratorKind) -> Result<Scene, RenderError> {
        scene.integrator.kind = kind;
        scene.integrator.samples_per_pixel = self.samples;
        (scene.film.width, scene.film.height) = (SIDE, SIDE);
        scene.build(snowblue_data::embedded(), &FilesInMemory::default())
    }
}
