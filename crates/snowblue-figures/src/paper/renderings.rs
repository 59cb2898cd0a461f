//! The paper's pictures, rendered from the scenes in `scenes/` by PCASnow and by the light field: Figs. 1, 9, 10, 11.

use std::path::Path;

use snowblue_color::LinearRgb;
use snowblue_render::Exposure;
use snowblue_render::files::FilesIn;
use snowblue_render::film::image_file;
use snowblue_render::scene::IntegratorKind;
use snowblue_render::scene::film::ImageSize;
use snowblue_render::{SceneDescription, render};

use crate::error::FigureError;
use crate::figure::{Drawing, Figure, Rendering, SOFTWARE};
use crate::scenes;
use crate::table::{Cell, DataTable};

/// The dragon's mesh, relative to the working directory.
const DRAGON_MESH: &str = "models/dragon.ply";

/// How much stronger the lamp under snow is for PCASnow, which lacks most of its light.
const LAMP_FACTOR: f64 = 100.0;

/// A picture to render.
#[derive(Clone)]
struct Shot {
    name: String,
    caption: String,
    scene: SceneDescription,
    size: ImageSize,
}

/// Captions of a figure.
struct Captions<'c> {
    title: &'static str,
    ours: &'c str,
    paper: &'c str,
}

pub(crate) fn fig1() -> Result<Figure, FigureError> {
    let captions = Captions {
        title: "A garden lamp under snow",
        ours: "A scene of our own after the photograph: a lamp of 6600 K (LED-B5), 6 cm in radius, under a mound of \
               snow with grains of 500 µm, 200 kg/m³. Light is pale where the snow is thin and blue where it comes \
               from deep inside. For PCASnow the lamp is 100 times as strong: the light that spreads in a mound is \
               not on its straight line.",
        paper: "Shows two photographs: an igloo's wall in daylight, and a garden lamp covered by snow at dusk.",
    };
    let shot = Shot {
        name: "lamp".to_owned(),
        caption: "A lamp in a mound of snow, at dusk".to_owned(),
        scene: scenes::read(scenes::LAMP)?,
        size: ImageSize { width: 640, height: 480 },
    };
    let mut shots = both_ways(&[shot]);
    scenes::scale_lamp(&mut shots[0].scene, LAMP_FACTOR);
    rendered(&captions, &shots)
}

/// A thickness of a block of Fig. 9, and the exposure of its backlit pictures.
struct Thickness {
    /// In cm.
    name: &'static str,
    size_m: f64,
    exposure_stops: f64,
}

const THICKNESSES: [Thickness; 4] = [
    Thickness { name: "5", size_m: 0.05, exposure_stops: -0.7 },
    Thickness { name: "10", size_m: 0.1, exposure_stops: 0.3 },
    Thickness { name: "15", size_m: 0.15, exposure_stops: 0.8 },
    Thickness { name: "30", size_m: 0.3, exposure_stops: 1.6 },
];

/// A view of the blocks of Fig. 9.
struct View {
    scene: &'static str,
    name: &'static str,
    label: &'static str,
    backlit: bool,
}

const VIEWS: [View; 3] = [
    View { scene: scenes::BLOCK_FRONT, name: "front", label: "opaque, lit from the front", backlit: false },
    View { scene: scenes::BLOCK_BACK, name: "back", label: "lit from behind", backlit: true },
    View { scene: scenes::BLOCK_OBLIQUE, name: "oblique", label: "lit from behind, seen from the side", backlit: true },
];

/// The blocks of Fig. 9 in all views.
fn blocks() -> Result<Vec<Shot>, FigureError> {
    let mut shots = Vec::new();
    for view in &VIEWS {
        let mut row = Vec::new();
        for thickness in &THICKNESSES {
            let mut scene = scenes::read(view.scene)?;
            scenes::set_thickness(&mut scene, thickness.size_m);
            let mut caption = format!("{} cm, {}", thickness.name, view.label);
            if view.backlit {
                let stops = thickness.exposure_stops;
                scene.film.exposure = Exposure::Stops(stops);
                caption = format!("{caption}; {:+.1} stops", stops - THICKNESSES[0].exposure_stops);
            }
            let size = ImageSize { width: 270, height: 270 };
            row.push(Shot { name: format!("{}_{}", view.name, thickness.name), caption, scene, size });
        }
        shots.extend(if view.backlit { both_ways(&row) } else { row });
    }
    Ok(shots)
}

pub(crate) fn fig9() -> Result<Figure, FigureError> {
    let captions = Captions {
        title: "Blocks of snow, 5 to 30 cm thick",
        ours: "Grains of 400 µm, 300 kg/m³, facetness .3, a point light of D65 behind the block. Thicker blocks are \
               darker and bluer; each thickness has its own exposure, given below it, so that its colour can be seen. \
               Seen from the side, edges through which the light's path is short are white.",
        paper: "The same blocks: opaque under a lamp near the camera, backlit and seen straight on, backlit and seen \
                obliquely. Their exposure is not given.",
    };
    rendered(&captions, &blocks()?)
}

pub(crate) fn fig10() -> Result<Figure, FigureError> {
    let shot = |name: &str, caption: &str, scene: &str| -> Result<Shot, FigureError> {
        let size = ImageSize { width: 400, height: 300 };
        Ok(Shot { name: name.to_owned(), caption: caption.to_owned(), scene: scenes::read(scene)?, size })
    };
    let captions = Captions {
        title: "Inside an igloo",
        ours: "Separate blocks of one body, 15 cm thick in the middle and 6 cm at the seams, under a uniform sky \
               (D55); all light inside has come through the wall. Wind-packed snow: grains of 250 µm, 400 kg/m³. Light \
               bleeds through the seams.",
        paper: "Blocks about 15 cm thick in a directionally uniform light of D55; light bleeds through the seams. \
                Inset: opaque blocks, lit from within. It does not specify the snow.",
    };
    let mut shots = both_ways(&[shot("snow", "Lit by the sky, through the wall", scenes::IGLOO)?]);
    shots.push(shot("opaque", "Opaque blocks, a lamp inside", scenes::IGLOO_OPAQUE)?);
    rendered(&captions, &shots)
}

pub(crate) fn fig11() -> Result<Figure, FigureError> {
    let title = "The Stanford dragon, of snow";
    let paper = "Grains of 250, 100 and 500 µm, facetness .3, 300 kg/m³, a point of D65 behind; the body about 30 cm \
                 in diameter, the thickest part about 80 cm. Larger grains let more light through, of a more vivid \
                 blue.";
    if !Path::new(DRAGON_MESH).is_file() {
        let reason = format!(
            "{DRAGON_MESH} does not exist: run scripts/fetch-models in the sources of snowblue, and this command there"
        );
        let ours = format!("Not rendered. {reason}.");
        let figure = rendered(&Captions { title, ours: &ours, paper }, &[])?;
        return Ok(Figure { warning: Some(reason), ..figure });
    }
    let mut dragon = scenes::read(scenes::DRAGON)?;
    scenes::set_mesh(&mut dragon, DRAGON_MESH);
    let shots = [("grains_250", 250.0), ("grains_100", 100.0), ("grains_500", 500.0)].map(|(name, grain_size_um)| {
        let mut scene = dragon.clone();
        scenes::set_grain_size(&mut scene, grain_size_um);
        let size = ImageSize { width: 480, height: 360 };
        Shot { name: name.to_owned(), caption: format!("Grains of {grain_size_um} µm"), scene, size }
    });
    let ours = "Facetness .3, 300 kg/m³, a point of D65 behind, one exposure for all. At this scale the dragon is 80 \
                cm thick at most, where body and front legs add up, and 30 cm in the median of its silhouette. Larger \
                grains let more light through. Mesh: Stanford Computer Graphics Laboratory.";
    rendered(&Captions { title, ours, paper }, &both_ways(&shots))
}

/// Shots of snow in two rows: by PCASnow, as in the paper, and by random walks that end in the light field.
fn both_ways(shots: &[Shot]) -> Vec<Shot> {
    let way = |kind: IntegratorKind, suffix: &str, label: &str| {
        let with_kind = |shot: &Shot| {
            let mut shot = shot.clone();
            shot.scene.integrator.kind = kind;
            Shot { name: format!("{}{suffix}", shot.name), caption: format!("{}, {label}", shot.caption), ..shot }
        };
        shots.iter().map(with_kind).collect::<Vec<_>>()
    };
    [way(IntegratorKind::PcaSnow, "", "PCASnow"), way(IntegratorKind::Hybrid, "_ours", "ours")].concat()
}

/// A figure of rendered pictures, with the settings of each.
fn rendered(captions: &Captions, shots: &[Shot]) -> Result<Figure, FigureError> {
    let (mut renderings, mut rows) = (Vec::new(), Vec::new());
    for shot in shots {
        let ImageSize { width, height } = shot.size;
        let mut scene = shot.scene.clone();
        (scene.film.width, scene.film.height) = (width, height);
        let scene = scene.build(&FilesIn::new(""))?;
        let rendering = render(&scene)?;
        // Light as it is, without a tone curve. Snow counts like all else.
        let metered = rendering.film.metered_pixels().map(LinearRgb::from_xyz);
        let stops = scene.film().exposure.display_factor(metered).log2();
        let counts = [width, height, scene.integrator().samples_per_pixel, scene.integrator().max_bounces];
        let mut row = vec![Cell::word(&shot.name), Cell::word(scene.integrator().kind.name())];
        row.extend(counts.map(|count| Cell::Number(count.into())));
        row.push(Cell::Number(stops));
        row.push(Cell::Number(rendering.statistics.odd_depth_lines as f64));
        rows.push(row);
        let picture = image_file::to_raster(&rendering.film, Exposure::Stops(stops));
        let png = image_file::png_bytes(&picture, &[("Software", SOFTWARE)])?;
        renderings.push(Rendering { name: shot.name.clone(), caption: shot.caption.clone(), png });
    }
    let columns = [
        "picture",
        "integrator",
        "width",
        "height",
        "samples_per_pixel",
        "max_bounces",
        "exposure_stops",
        "odd_depth_lines",
    ];
    Ok(Figure {
        title: captions.title,
        ours: captions.ours.to_owned(),
        paper: captions.paper.to_owned(),
        drawing: Drawing::Renderings(renderings),
        numbers: DataTable::new(&columns, rows),
        tables: Vec::new(),
        warning: None,
    })
}

#[cfg(test)]
mod tests {
    use snowblue_render::scene::LightFieldSettings;

    use super::*;
    use crate::catalog::RECIPES;
    use crate::page::{self, Section};

    /// Twelve blocks, of which those lit from behind are rendered in two ways.
    #[test]
    fn blocks_of_fig_9_are_rendered_and_shown() {
        let mut shots = blocks().unwrap();
        for shot in &mut shots {
            shot.size = ImageSize { width: 9, height: 9 };
            shot.scene.integrator.samples_per_pixel = 1;
            let coarse = LightFieldSettings { nodes: Some(1000), grain_rays: 1024, ..LightFieldSettings::default() };
            shot.scene.light_field = coarse;
        }
        let figure = rendered(&Captions { title: "Blocks", ours: "", paper: "" }, &shots).unwrap();
        let files = figure.files("fig9");
        let numbers = figure.numbers.csv();
        assert_eq!(numbers.lines().count(), 1 + 20);
        assert!(numbers.lines().skip(1).all(|line| line.ends_with(",0")), "no ray found snow open: {numbers}");
        let recipe = RECIPES.iter().find(|recipe| recipe.name == "fig9").unwrap();
        let page = page::index(&[Section { recipe, figure }]);
        let views = [("front", ""), ("back", ""), ("back", "_ours"), ("oblique", ""), ("oblique", "_ours")];
        for (view, way) in views {
            for thickness in [5, 10, 15, 30] {
                let name = format!("fig9_{view}_{thickness}{way}.png");
                let png = files.iter().find(|file| file.name == name).map(|file| &file.bytes[..4]);
                assert!(page.contains(&format!("src=\"{name}\"")) && png == Some(&b"\x89PNG"[..]), "{name}");
            }
        }
    }
}
