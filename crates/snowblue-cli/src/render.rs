//! `snowblue render`: a scene as a picture.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use snowblue_database::CompressedTable;
use snowblue_database::file::{self, AnyTable};
use snowblue_render::FalseColor;
use snowblue_render::image_file::{write_exr, write_png};
use snowblue_render::material::pca_snow::PathMode;
use snowblue_render::render;
use snowblue_render::scene::{Exposure, Scene};
use snowblue_render::scene_file::Overrides;

use crate::failure::{Failure, Outcome};
use crate::inspect;
use crate::options::{Format, OutputOptions};
use crate::parse;
use crate::progress::Progress;
use crate::report::{check_place, tell};

/// Render a scene (TOML) as PNG or EXR
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  snowblue render scenes/block_30cm.toml -o block.png
  snowblue render scenes/block_30cm.toml --path view -o view.png     the paper's way through the snow
  snowblue render scenes/block_30cm.toml --width 270 --height 270 --spp 16 -o draft.exr
  snowblue render scenes/block_30cm.toml --check              sizes, and whether the snow is watertight
  snowblue render scenes/block_30cm.toml --database infrared.nc --false-color 1030,850,550 -o nir.png"
)]
pub(crate) struct Render {
    /// Scene file
    scene: PathBuf,
    /// Where to write the picture: .png (8-bit sRGB) or .exr (linear RGB, 32-bit)
    #[arg(short, long, value_name = "FILE", required_unless_present = "check")]
    output: Option<PathBuf>,
    /// Look at the objects only: their size in metres, open edges, lines that find them open; exit code 1 if snow is not
    /// watertight. With -o, into a .csv, .json or .txt file
    #[arg(long)]
    check: bool,
    /// Format of --check [default: by the file's ending, else a table on a terminal and CSV into a pipe]
    #[arg(long, value_name = "FORMAT", value_enum, requires = "check")]
    format: Option<Format>,
    /// Compressed table to look snow up in [default: the embedded one]
    #[arg(long, value_name = "FILE")]
    database: Option<PathBuf>,
    /// Way through all snow of the scene, instead of the scene's
    #[arg(long, value_name = "MODE", value_enum)]
    path: Option<PathWord>,
    /// Width in pixels, instead of the scene's
    #[arg(long, value_name = "N")]
    width: Option<u32>,
    /// Height in pixels, instead of the scene's
    #[arg(long, value_name = "N")]
    height: Option<u32>,
    /// Paths per pixel, instead of the scene's
    #[arg(long, value_name = "N")]
    spp: Option<u32>,
    /// Surfaces after the first that a path may visit, instead of the scene's; 0 is direct light only
    #[arg(long, value_name = "N")]
    max_bounces: Option<u32>,
    /// Seed of all randomness, instead of the scene's
    #[arg(long, value_name = "N")]
    seed: Option<u32>,
    /// Brightness of a PNG in stops, or 'auto', instead of the scene's
    #[arg(long, value_name = "STOPS", value_parser = parse::exposure, allow_negative_numbers = true)]
    exposure: Option<Exposure>,
    /// Three wavelengths of the table in nm as red, green and blue [1030,860,550 if none are given], under lights that shine
    /// alike at all wavelengths; the table must hold 31 of them, of any range
    #[arg(
        long, value_name = "R,G,B", num_args = 0..=1, default_missing_value = parse::FALSE_COLOR_NM,
        value_parser = parse::false_color
    )]
    false_color: Option<FalseColor>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum PathWord {
    /// Of the next two the one that lets the brighter light through
    Easiest,
    /// Straight in from the surface
    Normal,
    /// Towards the light
    Light,
    /// On along the viewing ray, as in the paper
    View,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Picture {
    Png,
    Exr,
}

impl Render {
    pub(crate) fn run(&self, quiet: bool) -> Outcome {
        let output = match &self.output {
            Some(output) if !self.check => output,
            _ => {
                let output = OutputOptions { output: self.output.clone(), format: self.format };
                return inspect::check(&self.load()?, &output, quiet);
            }
        };
        // Checked before the work, not after it.
        let picture = picture(output)?;
        check_place(output)?;
        let scene = self.load()?;
        let bar = Progress::new("rows", quiet);
        let rendering = render::render(&scene, &|at| bar.at(at.rows_done.into(), at.rows.into()));
        bar.end();
        let settings = &scene.integrator;
        let seed = settings.seed.to_string();
        let samples = settings.samples_per_pixel.to_string();
        let software = format!("snowblue {}", env!("CARGO_PKG_VERSION"));
        let scene_name = self.scene.display().to_string();
        let colours = match self.false_color {
            None => "as seen".to_owned(),
            Some(FalseColor { red_nm, green_nm, blue_nm }) => format!("false: {red_nm}, {green_nm}, {blue_nm} nm"),
        };
        let notes = [
            ("Software", &*software),
            ("Scene", &*scene_name),
            ("Samples per pixel", &*samples),
            ("Seed", &*seed),
            ("Colours", &*colours),
        ];
        let film = &rendering.film;
        match picture {
            Picture::Png => write_png(film, scene.film.exposure, &notes, output),
            Picture::Exr => write_exr(film, &notes, output),
        }
        .map_err(Failure::work)?;
        let odd = rendering.statistics.odd_depth_lines;
        if odd > 0 && !quiet {
            let lines = rendering.statistics.depth_lines;
            tell(&format!(
                "{odd} of {lines} lines through snow crossed it an odd number of times: a mesh is open (see --check)\n"
            ));
        }
        Ok(())
    }

    fn load(&self) -> Result<Scene, Failure> {
        let overrides = Overrides {
            path: self.path.map(PathWord::mode),
            width: self.width,
            height: self.height,
            exposure: self.exposure,
            samples_per_pixel: self.spp,
            max_bounces: self.max_bounces,
            seed: self.seed,
            false_color: self.false_color,
        };
        let read;
        let table: &CompressedTable = match &self.database {
            None => snowblue_data::embedded(),
            Some(path) => match file::read(path).map_err(Failure::input)? {
                AnyTable::Compressed(table) => {
                    read = table;
                    &read
                }
                other => {
                    let what = "rendering needs a compressed one (database build --space log)";
                    return Err(Failure::Input(format!("{}: is {}; {what}", path.display(), other.kind())));
                }
            },
        };
        Scene::load(&self.scene, table, &overrides).map_err(Failure::input)
    }
}

impl PathWord {
    fn mode(self) -> PathMode {
        match self {
            Self::Easiest => PathMode::Easiest,
            Self::Normal => PathMode::Normal,
            Self::Light => PathMode::Light,
            Self::View => PathMode::View,
        }
    }
}

/// The kind of picture that a file's ending asks for.
fn picture(path: &Path) -> Result<Picture, Failure> {
    match path.extension().and_then(|ending| ending.to_str()).map(str::to_lowercase).as_deref() {
        Some("png") => Ok(Picture::Png),
        Some("exr") => Ok(Picture::Exr),
        _ => Err(Failure::Input(format!("{}: the picture must end in .png or .exr", path.display()))),
    }
}
