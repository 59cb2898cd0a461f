//! The paper's pictures, rendered from the scenes in `scenes/` by PCASnow and by the light field: Figs. 9, 10, 11.

use std::path::Path;

use snowblue_base::{Count, Numbers};
use snowblue_color::LinearRgb;
use snowblue_render::files::FilesIn;
use snowblue_render::film::image_file;
use snowblue_render::scene::IntegratorKind;
use snowblue_render::scene::description::{
    MaterialDescription, NamedShape, ShapeDescription, SnowDescription, SnowMaterialDescription,
};
use snowblue_render::{Exposure, SceneDescription, SceneFile, render};

use crate::figure::{Figure, FigureError, Picture};
use crate::table::{Cell, DataTable};

/// The dragon's mesh, relative to the working directory.
const DRAGON_MESH: &str = "models/dragon.ply";

/// A picture to render.
#[derive(Clone)]
struct Shot {
    name: String,
    caption: String,
    scene: SceneDescription,
}

impl Shot {
    /// A scene file, rendered with a width and a height in pixels.
    fn new(name: &str, caption: &str, file: &str, [width, height]: [u32; 2]) -> Result<Self, FigureError> {
        let mut scene = SceneFile::parse(file, "scene.toml")?.description;
        (scene.film.width, scene.film.height) = (Count::of(width), Count::of(height));
        Ok(Self { name: name.to_owned(), caption: caption.to_owned(), scene })
    }
}

/// Thicknesses of the blocks of Fig. 9, in cm, with the exposures of backlit pictures.
const THICKNESSES: [(f64, f64); 4] = [(5.0, -0.7), (10.0, 0.3), (15.0, 0.8), (30.0, 1.6)];

/// The blocks of Fig. 9 in all views.
fn blocks() -> Result<Vec<Shot>, FigureError> {
    let views = [
        ("front", "opaque, lit from the front", include_str!("../../scenes/fig9_front.toml")),
        ("back", "lit from behind", include_str!("../../scenes/fig9_back.toml")),
        ("oblique", "lit from behind, seen from the side", include_str!("../../scenes/fig9_oblique.toml")),
    ];
    let mut shots = Vec::new();
    for (view, label, file) in views {
        let block = |(thickness_cm, stops): (f64, f64)| {
            let caption = format!("{thickness_cm} cm, {label}");
            let mut shot = Shot::new(&format!("{view}_{thickness_cm}"), &caption, file, [270, 270])?;
            if let ShapeDescription::Named(NamedShape::Box(block)) = &mut shot.scene.objects[0].shape {
                let [x, _, z] = block.size.get();
                block.size = Numbers::of([x, 0.01 * thickness_cm, z]);
            }
            if view != "front" {
                shot.scene.film.exposure = Exposure::Stops(stops);
                shot.caption += &format!("; {:+.1} stops", stops - THICKNESSES[0].1);
            }
            Ok(shot)
        };
        let row = THICKNESSES.into_iter().map(block).collect::<Result<Vec<_>, FigureError>>()?;
        shots.extend(if view == "front" { row } else { both_ways(&row) });
    }
    Ok(shots)
}

pub(crate) fn fig9() -> Result<Figure, FigureError> {
    let ours = "Grains of 400 µm, 300 kg/m³, facetness .3, a point light of D65 behind the block. Thicker blocks are \
                darker and bluer; each thickness has its own exposure, so that its colour can be seen.";
    let paper = "The same blocks: opaque under a lamp near the camera, backlit and seen straight on, backlit and seen \
                 obliquely.";
    rendered("Blocks of snow, 5 to 30 cm thick", ours, paper, &blocks()?)
}

pub(crate) fn fig10() -> Result<Figure, FigureError> {
    let ours = "Separate blocks of one body, 15 cm thick in the middle and 6 cm at the seams, of wind-packed snow \
                under a uniform sky (D55). All light inside has come through the wall.";
    let paper = "Blocks about 15 cm thick in a directionally uniform light of D55; light bleeds through the seams. \
                 Inset: opaque blocks, lit from within.";
    let igloo = include_str!("../../scenes/fig10_igloo.toml");
    let opaque = include_str!("../../scenes/fig10_opaque.toml");
    let mut shots = both_ways(&[Shot::new("snow", "Lit by the sky, through the wall", igloo, [400, 300])?]);
    shots.push(Shot::new("opaque", "Opaque blocks, a lamp inside", opaque, [400, 300])?);
    rendered("Inside an igloo", ours, paper, &shots)
}

pub(crate) fn fig11() -> Result<Figure, FigureError> {
    let title = "The Stanford dragon, of snow";
    let paper = "Grains of 250, 100 and 500 µm, facetness .3, 300 kg/m³, a point of D65 behind. Larger grains let more \
                 light through, of a more vivid blue.";
    if !Path::new(DRAGON_MESH).is_file() {
        let reason = format!(
            "{DRAGON_MESH} does not exist: run scripts/fetch-models in the sources of snowblue, and this command there"
        );
        let figure = rendered(title, &format!("Not rendered. {reason}."), paper, &[])?;
        return Ok(Figure { warning: Some(reason), ..figure });
    }
    let dragon = |grain_size_um: f64| {
        let (name, caption) = (format!("grains_{grain_size_um}"), format!("Grains of {grain_size_um} µm"));
        let mut shot = Shot::new(&name, &caption, include_str!("../../scenes/fig11_dragon.toml"), [480, 360])?;
        if let ShapeDescription::Mesh(mesh) = &mut shot.scene.objects[0].shape {
            DRAGON_MESH.clone_into(&mut mesh.mesh);
        }
        for material in shot.scene.materials.values_mut() {
            if let MaterialDescription::Snow(SnowMaterialDescription { snow: SnowDescription::Uniform(snow), .. }) =
                material
            {
                snow.grain_size_um = Some(vec![grain_size_um]);
            }
        }
        Ok(shot)
    };
    let shots = [250.0, 100.0, 500.0].into_iter().map(dragon).collect::<Result<Vec<_>, FigureError>>()?;
    let ours = "Facetness .3, 300 kg/m³, a point of D65 behind, one exposure for all. Larger grains let more light \
                through. Mesh: Stanford Computer Graphics Laboratory.";
    rendered(title, ours, paper, &both_ways(&shots))
}

/// Shots of snow in two rows: by PCASnow, as in the paper, and by random walks that end in the light field.
fn both_ways(shots: &[Shot]) -> Vec<Shot> {
    let way = |kind: IntegratorKind, suffix: &str, label: &str| {
        let with_kind = |shot: &Shot| {
            let mut scene = shot.scene.clone();
            scene.integrator.kind = kind;
            Shot { name: format!("{}{suffix}", shot.name), caption: format!("{}, {label}", shot.caption), scene }
        };
        shots.iter().map(with_kind).collect::<Vec<_>>()
    };
    [way(IntegratorKind::PcaSnow, "", "PCASnow"), way(IntegratorKind::Hybrid, "_ours", "ours")].concat()
}

/// A figure of rendered pictures, with the settings of each.
fn rendered(title: &'static str, ours: &str, paper: &'static str, shots: &[Shot]) -> Result<Figure, FigureError> {
    let (mut pictures, mut rows) = (Vec::new(), Vec::new());
    for Shot { name, caption, scene } in shots {
        let scene = scene.build(&FilesIn::new(""))?;
        let rendering = render(&scene)?;
        // Unchanged light, without a tone curve. Snow counts like all other objects.
        let metered = rendering.film.metered_pixels().map(LinearRgb::from_xyz);
        let stops = scene.film().exposure.display_factor(metered).log2();
        let settings = scene.integrator();
        let numbers = [settings.samples_per_pixel.get().into(), settings.max_bounces.get().into(), stops];
        let numbers = numbers.into_iter().chain([rendering.statistics.odd_depth_lines as f64]).map(Cell::from);
        rows.push([Cell::word(name), Cell::word(settings.kind.name())].into_iter().chain(numbers).collect());
        let picture = image_file::to_raster(&rendering.film, Exposure::Stops(stops));
        let software = concat!("snowblue ", env!("CARGO_PKG_VERSION"));
        let bytes = image_file::png_bytes(&picture, &[("Software", software)])?;
        pictures.push(Picture { suffix: format!("_{name}.png"), caption: caption.clone(), bytes });
    }
    let columns = ["picture", "integrator", "samples_per_pixel", "max_bounces", "exposure_stops", "odd_depth_lines"];
    let (ours, numbers) = (ours.to_owned(), DataTable::new(&columns, rows));
    Ok(Figure { title, ours, paper, pictures, numbers, table: None, warning: None })
}

#[cfg(test)]
mod tests {
    use snowblue_render::scene::LightFieldSettings;

    use super::*;

    /// Twelve blocks. The blocks lit from behind are rendered in two ways.
    #[test]
    fn blocks_of_fig_9_are_rendered() {
        let mut shots = blocks().unwrap();
        for shot in &mut shots {
            (shot.scene.film.width, shot.scene.film.height) = (Count::of(9), Count::of(9));
            shot.scene.integrator.samples_per_pixel = Count::of(1);
            let nodes = Some(Count::of(1000));
            let coarse = LightFieldSettings { nodes, grain_rays: 1024, ..LightFieldSettings::default() };
            shot.scene.light_field = coarse;
        }
        let figure = rendered("Blocks", "", "", &shots).unwrap();
        let files = figure.files("fig9");
        let numbers = figure.numbers.csv();
        assert_eq!(numbers.lines().count(), 1 + 20);
        assert!(numbers.lines().skip(1).all(|line| line.ends_with(",0")), "no ray found snow open: {numbers}");
        let views = [("front", ""), ("back", ""), ("back", "_ours"), ("oblique", ""), ("oblique", "_ours")];
        for (view, way) in views {
            for thickness in [5, 10, 15, 30] {
                let name = format!("fig9_{view}_{thickness}{way}.png");
                let png = files.iter().find(|file| file.name == name).map(|file| &file.bytes[..4]);
                assert_eq!(png, Some(&b"\x89PNG"[..]), "{name}");
            }
        }
    }
}
