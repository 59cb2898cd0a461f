//! The paper's pictures, rendered anew from the scenes that ship in `scenes/`: Figs. 1, 9, 10 and 11.

use std::path::{Path, PathBuf};

use snowblue_render::film::exposure::Exposure;
use snowblue_render::film::image_file;
use snowblue_render::scene::Scene;
use snowblue_render::scene::file::Overrides;
use snowblue_render::{Film, render};

use super::{Drawing, Figure, Rendered, numbers};
use crate::failure::Failure;
use crate::report::{Cell, tell};

const LAMP: &str = include_str!("../../../../scenes/fig1_lamp.toml");
const FRONT: &str = include_str!("../../../../scenes/fig9_front.toml");
pub(super) const BACK: &str = include_str!("../../../../scenes/fig9_back.toml");
pub(super) const OBLIQUE: &str = include_str!("../../../../scenes/fig9_oblique.toml");
const IGLOO: &str = include_str!("../../../../scenes/fig10_igloo.toml");
const OPAQUE: &str = include_str!("../../../../scenes/fig10_opaque.toml");
const DRAGON: &str = include_str!("../../../../scenes/fig11_dragon.toml");

/// Where the dragon lies, as the scene has it, seen from the folder of work.
const DRAGON_MESH: &str = "models/dragon.ply";
/// The lines of the scenes that are changed for a figure's other pictures.
pub(super) const BLOCK_SIZE: &str = "size = [0.6, 0.3, 0.6]";
const DRAGON_GRAINS: &str = "grain_size_um = 250";

/// A picture to be made: its name, what stands below it, the scene, and how wide it is in pixels, at what ratio.
struct Shot {
    name: &'static str,
    caption: String,
    scene: String,
    size: (u32, u32),
}

pub(super) fn fig1() -> Result<Figure, Failure> {
    let caption = "A lamp in a mound of snow, at dusk".to_owned();
    let shot = Shot { name: "lamp", caption, scene: LAMP.to_owned(), size: (640, 480) };
    pictured(
        "A garden lamp under snow",
        "A scene of our own after the photograph: a lamp of 6600 K (LED-B5), 6 cm in radius, under a mound of snow with grains of \
         500 µm, 200 kg/m³. Light is pale where the snow is thin and blue where it comes from far within.",
        "Shows two photographs: an igloo's wall in daylight, and a garden lamp covered by snow at dusk.",
        &[shot],
    )
}

pub(super) fn fig9() -> Result<Figure, Failure> {
    let views = [
        (FRONT, ["front_5", "front_10", "front_15", "front_30"], "opaque, lit from the front"),
        (BACK, ["back_5", "back_10", "back_15", "back_30"], "lit from behind"),
        (OBLIQUE, ["oblique_5", "oblique_10", "oblique_15", "oblique_30"], "lit from behind, seen from the side"),
    ];
    // A photographer opens the aperture by these many stops for thicker snow.
    let thicknesses = [("5 cm", "0.05", -0.7), ("10 cm", "0.1", 0.3), ("15 cm", "0.15", 0.8), ("30 cm", "0.3", 1.6)];
    let mut shots = Vec::new();
    for (scene, names, view) in views {
        for ((name, (thickness, size_m, stops)), lit) in names.into_iter().zip(thicknesses).zip([view; 4]) {
            let mut scene = scene.replace(BLOCK_SIZE, &format!("size = [0.6, {size_m}, 0.6]"));
            let mut caption = format!("{thickness}, {lit}");
            if lit != views[0].2 {
                scene = scene.replace("exposure = 1.5", &format!("exposure = {stops}"));
                caption = format!("{caption}; {:+.1} stops", stops - thicknesses[0].2);
            }
            shots.push(Shot { name, caption, scene, size: (270, 270) });
        }
    }
    pictured(
        "Blocks of snow, 5 to 30 cm thick",
        "Grains of 400 µm, 300 kg/m³, facetness .3, a point of D65 behind the block. Thicker blocks are darker and bluer; each \
         thickness has its own exposure, told below it, so that its colour can be seen. Seen from the side, edges that the lamp's light \
         cuts short are white.",
        "The same blocks: opaque under a lamp near the eye, backlit and seen straight on, backlit and seen obliquely. Their exposure is \
         not told.",
        &shots,
    )
}

pub(super) fn fig10() -> Result<Figure, Failure> {
    let shot = |name, caption: &str, scene: &str| Shot {
        name,
        caption: caption.to_owned(),
        scene: scene.to_owned(),
        size: (400, 300),
    };
    pictured(
        "Inside an igloo",
        "Separate blocks, 15 cm thick in their middle and 6 cm at the seams, of one body, under a sky alike everywhere (D55); all \
         light inside has come through the wall. Wind-packed snow: grains of 250 µm, 400 kg/m³. Light bleeds through the seams.",
        "Blocks about 15 cm thick in a directionally uniform light of D55; light bleeds through the seams. Inset: opaque blocks, lit \
         from within. It does not tell what snow.",
        &[
            shot("snow", "Lit by the sky, through the wall", IGLOO),
            shot("opaque", "Opaque blocks, a lamp inside", OPAQUE),
        ],
    )
}

pub(super) fn fig11() -> Result<Figure, Failure> {
    let paper = "Grains of 250, 100 and 500 µm, facetness .3, 300 kg/m³, a point of D65 behind; the body about 30 cm in diameter, the \
                 thickest part about 80 cm. Larger grains let more light through, of a more vivid blue.";
    let title = "The Stanford dragon, of snow";
    if !Path::new(DRAGON_MESH).is_file() {
        let reason = format!(
            "{DRAGON_MESH} is not here: run scripts/fetch-models in the sources of snowblue, and this command in the same folder"
        );
        tell(&format!("fig11: {reason}\n"));
        return pictured(title, &format!("Not rendered. {reason}."), paper, &[]);
    }
    let shots = [("grains_250", 250), ("grains_100", 100), ("grains_500", 500)].map(|(name, grains_um)| Shot {
        name,
        caption: format!("Grains of {grains_um} µm"),
        // The mesh is beside the folder of scenes; here it is seen from the folder of work.
        scene: DRAGON.replace("../models/", "models/").replace(DRAGON_GRAINS, &format!("grain_size_um = {grains_um}")),
        size: (480, 360),
    });
    pictured(
        title,
        "Facetness .3, 300 kg/m³, a point of D65 behind, one exposure for all. At this scale the dragon is 80 cm thick at most, where \
         body and front legs add up, and 30 cm in the median of its silhouette. Larger grains let more light through. Mesh: \
         Stanford Computer Graphics Laboratory.",
        paper,
        &shots,
    )
}

/// A figure of pictures, with how each was made.
fn pictured(title: &'static str, ours: &str, paper: &str, shots: &[Shot]) -> Result<Figure, Failure> {
    let (mut pictures, mut rows) = (Vec::new(), Vec::new());
    for shot in shots {
        let (width, height) = shot.size;
        let overrides = Overrides { width: Some(width), height: Some(height), ..Overrides::default() };
        let place = PathBuf::from(format!("{}.toml", shot.name));
        let scene =
            Scene::from_text(&shot.scene, &place, snowblue_data::embedded(), &overrides).map_err(Failure::work)?;
        let rendering = render::render(&scene, &|_| {});
        let stops = display_stops(&rendering.film, scene.film.exposure);
        let samples = scene.integrator.samples_per_pixel;
        let counts = [width, height, samples, scene.integrator.max_bounces];
        let mut row = vec![Cell::Word(shot.name.to_owned())];
        row.extend(counts.map(|count| Cell::Number(count.into())));
        row.push(Cell::Number(stops));
        row.push(Cell::Number(rendering.statistics.odd_depth_lines as f64));
        rows.push(row);
        let picture = image_file::picture(&rendering.film, scene.film.exposure);
        let notes = [("Software", concat!("snowblue ", env!("CARGO_PKG_VERSION")))];
        let png = image_file::png_bytes(&picture, &notes).map_err(Failure::work)?;
        pictures.push(Rendered { name: shot.name, caption: shot.caption.clone(), png });
    }
    let columns = [
        "picture",
        "width",
        "height",
        "samples_per_pixel",
        "max_bounces",
        "exposure_stops",
        "lines_that_found_snow_open",
    ];
    Ok(Figure {
        title,
        ours: ours.to_owned(),
        paper: paper.to_owned(),
        drawing: Drawing::Pictures(pictures),
        numbers: numbers(&columns, rows),
        tables: Vec::new(),
    })
}

/// The exposure of a picture, also where it was found from the picture itself.
fn display_stops(film: &Film, exposure: Exposure) -> f64 {
    film.display_factor(exposure).log2()
}
