//! The scenes of the comparison: blocks of three thicknesses and a ball, in front of a far and a near lamp; and further
//! scenes, lit from all sides.

use snowblue_render::files::FilesInMemory;
use snowblue_render::scene::description::{
    LightSource, MaterialDescription, ShapeDescription, SnowDescription, SnowMaterialDescription,
    SphereLightDescription,
};
use snowblue_render::{Integrator, RenderError, SceneDescription};

use super::image::SIDE;
use super::method::Method;
use crate::error::FigureError;
use crate::scenes;

/// Melting snow with soot: the fraction of the pores that is full of water, and black carbon.
const WATER_SATURATION: f64 = 0.1;
const SOOT_NG_G: f64 = 100.0;

/// A scene, with the name and the caption of its picture.
pub(super) struct Case {
    pub(super) name: &'static str,
    pub(super) caption: String,
    scene: SceneDescription,
    /// Samples per pixel of each reference rendering.
    pub(super) samples: u32,
    pub(super) group: Group,
    /// Whether it is a block seen straight on.
    pub(super) is_front: bool,
}

/// Scenes that are judged together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Group {
    Blocks,
    Balls,
    Further,
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
pub(super) fn cases(sample_factor: u32) -> Result<Vec<Case>, FigureError> {
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
                cases.push(Case { name, caption, scene, samples, group: Group::Blocks, is_front });
            }
        }
    }
    for (name, position, lamp) in [("ball_far", [0.5, 0.85, 0.2], "1 m"), ("ball_near", [0.1, 0.17, 0.04], "20 cm")] {
        let caption = format!("A ball 10 cm across, the lamp {lamp} from its middle");
        let mut scene = scenes::read(scenes::BALL)?;
        scenes::set_lamp_position(&mut scene, position);
        let samples = 512 * sample_factor;
        cases.push(Case { name, caption, scene, samples, group: Group::Balls, is_front: false });
    }
    cases.extend(further_cases(sample_factor)?);
    Ok(cases)
}

/// A block of 10 cm of wet and sooty snow with the lamp behind it.
fn wet_and_sooty() -> Result<SceneDescription, FigureError> {
    let mut scene = scenes::read(scenes::BLOCK_BACK)?;
    scenes::set_thickness(&mut scene, 0.1);
    for material in scene.materials.values_mut() {
        let MaterialDescription::Snow(SnowMaterialDescription { snow: SnowDescription::Uniform(snow), .. }) = material
        else {
            continue;
        };
        snow.water_saturation = Some(WATER_SATURATION);
        snow.impurities_ng_g.insert("black-carbon".to_owned(), SOOT_NG_G);
    }
    Ok(scene)
}

/// A part of the wall of a small igloo from outside, a lamp inside.
fn igloo_piece() -> Result<SceneDescription, RenderError> {
    let mut scene = scenes::read(scenes::IGLOO)?;
    if let ShapeDescription::Igloo(igloo) = &mut scene.objects[0].shape {
        (igloo.inner_radius, igloo.wall, igloo.block_width) = (0.6, 0.08, 0.3);
        (igloo.seam_depth, igloo.seam_width) = (Some(0.025), 0.05);
    }
    scene.objects.truncate(1);
    (scene.environment, scene.lights) = (None, scenes::read(scenes::BLOCK_BACK)?.lights);
    scenes::set_lamp_position(&mut scene, [0.0, 0.0, 0.2]);
    if let Some(camera) = &mut scene.camera {
        (camera.position, camera.look_at, camera.vertical_fov_deg) = ([0.0, -3.0, 0.5], [0.0, -0.65, 0.25], 10.0);
    }
    scene.integrator.max_bounces = 0;
    Ok(scene)
}

/// Scenes with light from the side and the front, small bodies, surfaces that see each other, and a lamp inside.
fn further_cases(sample_factor: u32) -> Result<Vec<Case>, FigureError> {
    let case = |name, caption: &str, scene, samples: u32| {
        let (caption, samples) = (caption.to_owned(), samples * sample_factor);
        Case { name, caption, scene, samples, group: Group::Further, is_front: false }
    };
    let block = |position| {
        let mut scene = scenes::read(scenes::BLOCK_OBLIQUE)?;
        scenes::set_thickness(&mut scene, 0.1);
        scenes::set_lamp_position(&mut scene, position);
        Ok::<_, RenderError>(scene)
    };
    let ball = |radius_m: f64, position: [f64; 3]| {
        let mut scene = scenes::read(scenes::BALL)?;
        let scale = radius_m / 0.05;
        if let Some(camera) = &mut scene.camera {
            camera.position = camera.position.map(|coordinate| coordinate * scale);
        }
        if let ShapeDescription::Sphere(sphere) = &mut scene.objects[0].shape {
            sphere.radius = radius_m;
        }
        scenes::set_lamp_position(&mut scene, position.map(|coordinate| coordinate * scale));
        Ok::<_, RenderError>(scene)
    };
    // Random walks find no lamp that is a point inside snow.
    let mut lamp_inside = ball(0.05, [0.0; 3])?;
    lamp_inside.lights[0].source = LightSource::Sphere(SphereLightDescription {
        position: [0.0, 0.02, 0.0],
        radius: 0.008,
        radiance_w_m2_sr: 1000.0,
        visible: true,
    });
    let wet = "A block of 10 cm, a tenth of its pores full of water, 100 ng/g of soot";
    let far = [0.5, 0.85, 0.2];
    Ok(vec![
        case("lit_front_10", "A block of 10 cm, lit from the front", block([0.4, -1.2, 0.5])?, 64),
        case("lit_side_10", "A block of 10 cm, lit from the left", block([-1.0, 0.15, 0.4])?, 512),
        case("ball_lit", "A ball 10 cm across, lit from the front", ball(0.05, [0.6, -0.7, 0.3])?, 256),
        case("ball_2cm", "A ball of 2 cm radius, the lamp behind", ball(0.02, far)?, 512),
        case("ball_1cm", "A ball of 1 cm radius, the lamp behind", ball(0.01, far)?, 512),
        case("ball_half_cm", "A ball of .5 cm radius, the lamp behind", ball(0.005, far)?, 512),
        case("lamp_inside", "A ball 10 cm across, a lamp of 8 mm radius 2 cm from its middle", lamp_inside, 512),
        case("corner", "A corner of two blocks on a floor, lit from the front", scenes::read(scenes::CORNER)?, 256),
        case("floor_sky", "A block on a floor under a white sky", scenes::read(scenes::FLOOR)?, 256),
        case("wet_sooty_10", wet, wet_and_sooty()?, 256),
        case("igloo_piece", "The wall of an igloo, 8 cm thick, a lamp inside", igloo_piece()?, 16),
    ])
}

impl Case {
    /// The integrator of the scene for a way of rendering.
    pub(super) fn integrator(&self, method: Method) -> Result<Integrator, RenderError> {
        let mut scene = self.scene.clone();
        if let Method::PcaSnow(mode) = method {
            scene.integrator.pcasnow.path = mode;
        }
        scene.integrator.kind = method.integrator();
        scene.integrator.samples_per_pixel = self.samples;
        (scene.film.width, scene.film.height) = (SIDE, SIDE);
        Integrator::prepare(&scene.build(&FilesInMemory::default())?)
    }
}
