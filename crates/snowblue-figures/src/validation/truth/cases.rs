//! The scenes of the comparison: blocks of three thicknesses and a ball, in front of a far and a near lamp.

use std::path::Path;

use snowblue_render::RenderError;
use snowblue_render::scene::file::Overrides;
use snowblue_render::scene::{IntegratorKind, Scene};

use super::image::SIDE;
use crate::scenes;

/// A scene, with the name and the caption of its picture.
pub(super) struct Case {
    pub(super) name: &'static str,
    pub(super) caption: String,
    /// Text of the scene file.
    scene: String,
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
    size_m: &'static str,
    samples: u32,
}

const THICKNESSES: [Thickness; 3] = [
    Thickness { label: "5 cm", size_m: "0.05", samples: 256 },
    Thickness { label: "10 cm", size_m: "0.1", samples: 512 },
    Thickness { label: "15 cm", size_m: "0.15", samples: 512 },
];

/// Distances of the lamp behind a block's middle: the coordinate in m, and its label.
const LAMPS: [(&str, &str); 2] = [("1.2", "120 cm"), ("0.45", "45 cm")];

/// Position of the lamp in the ball's scene.
const BALL_LAMP: &str = "[0.5, 0.85, 0.2]";

/// All scenes, with `sample_factor` times the samples.
pub(super) fn cases(sample_factor: u32) -> Vec<Case> {
    let mut cases = Vec::new();
    for view in &VIEWS {
        for (names, (lamp_m, lamp)) in view.names.into_iter().zip(LAMPS) {
            for (name, thickness) in names.into_iter().zip(&THICKNESSES) {
                let Thickness { label, size_m, samples } = thickness;
                let scene = view
                    .scene
                    .replace(scenes::BLOCK_SIZE, &format!("size = [0.6, {size_m}, 0.6]"))
                    .replace("position = [0.0, 1.2, 0.2]", &format!("position = [0.0, {lamp_m}, 0.2]"))
                    .replace("vertical_fov_deg = 20", "vertical_fov_deg = 17");
                let caption = format!("A block of {label}, the lamp {lamp} behind its middle, seen {}", view.label);
                let samples = samples * sample_factor;
                cases.push(Case { name, caption, scene, samples, is_front: view.is_front });
            }
        }
    }
    for (name, position, lamp) in [("ball_far", BALL_LAMP, "1 m"), ("ball_near", "[0.1, 0.17, 0.04]", "20 cm")] {
        let caption = format!("A ball 10 cm across, the lamp {lamp} from its middle");
        let scene = scenes::BALL.replace(BALL_LAMP, position);
        cases.push(Case { name, caption, scene, samples: 512 * sample_factor, is_front: false });
    }
    cases
}

impl Case {
    pub(super) fn load(&self) -> Result<Scene, RenderError> {
        let overrides = Overrides {
            integrator: Some(IntegratorKind::Reference),
            width: Some(SIDE),
            height: Some(SIDE),
            samples_per_pixel: Some(self.samples),
            ..Overrides::default()
        };
        let path = format!("{}.toml", self.name);
        Scene::from_text(&self.scene, Path::new(&path), snowblue_data::embedded(), &overrides)
    }
}
