//! `snowblue export openpbr`, `arnold`, `usd` and `principled`: subsurface parameters for renderers without a plug-in.

mod comparison;
mod material_x;
mod principled;
mod usd;
mod written;

use std::path::PathBuf;

use clap::Args;
use snowblue_color::Observer;
use snowblue_database::preset::{SnowReference, SubsurfaceModel};

use crate::options::{LightOptions, OrdinatesArguments, SampleCount, SnowOptions};
use crate::output::{Failure, Outcome, check_extension, output_path, print, write_file};
use written::{ColorSpace, SceneUnit, Written};

/// A file of subsurface parameters.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub(crate) struct PresetFile {
    #[command(flatten)]
    sample: SnowOptions,
    #[command(flatten)]
    light: LightOptions,
    /// Length of a unit of the scene, in which radii are written
    #[arg(long, value_name = "UNIT", default_value = "m", value_enum, help_heading = "Renderer")]
    scene_unit: SceneUnit,
    /// Colour space in which the renderer computes [default: acescg; of principled srgb-linear]
    #[arg(long, value_name = "SPACE", value_enum, help_heading = "Renderer")]
    color_space: Option<ColorSpace>,
    #[command(flatten)]
    ordinates: OrdinatesArguments,
    /// File to write: .mtlx of openpbr and arnold, .usda of usd, .py of principled [default: print]
    #[arg(short, long, value_name = "FILE", value_parser = output_path(), help_heading = "Output")]
    output: Option<PathBuf>,
}

/// A kind of preset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PresetFormat {
    OpenPbr,
    Arnold,
    Usd,
    Principled,
}

impl PresetFile {
    pub(super) fn write(&self, format: PresetFormat) -> Outcome {
        if let Some(path) = &self.output {
            check_extension(path, format.extension(), format.content())?;
        }
        let text = match format {
            PresetFormat::OpenPbr => material_x::open_pbr(&self.fit(format)?),
            PresetFormat::Arnold => material_x::standard_surface(&self.fit(format)?),
            PresetFormat::Usd => usd::material(&self.fit(format)?).map_err(Failure::input)?,
            PresetFormat::Principled => principled::script(&self.fit(format)?),
        };
        match &self.output {
            Some(path) => write_file(path, text.as_bytes()),
            None => print(&text).map_err(Failure::work),
        }
    }

    fn fit(&self, format: PresetFormat) -> Result<Written, Failure> {
        let colorimeter = self.light.colorimeter(Observer::Cie1931, &SampleCount::ThirtyOne.wavelengths_nm())?;
        let (model, usual_space) = match format {
            PresetFormat::Principled => (SubsurfaceModel::Cycles, ColorSpace::SrgbLinear),
            _ => (SubsurfaceModel::OpenPbr, ColorSpace::AcesCg),
        };
        let color_space = self.color_space.unwrap_or(usual_space);
        let reference = SnowReference::new(&self.sample.sample()?, &colorimeter, &self.ordinates.options())
            .map_err(Failure::input)?;
        let preset = reference.preset(color_space.rgb(), model).map_err(Failure::input)?;
        let mut notes = vec![format!("snowblue {}", env!("CARGO_PKG_VERSION"))];
        notes.extend(self.sample.metadata()?.into_iter().map(|(name, value)| format!("{name}: {value}")));
        notes.push(format!(
            "white: {}, CIE 1931; channels: linear {}; unit of length: {}",
            self.light.illuminant,
            color_space.rgb(),
            self.scene_unit.word()
        ));
        notes.extend(format.limits());
        notes.push(String::new());
        notes.extend(comparison::lines(&preset));
        Ok(Written { preset, color_space, unit: self.scene_unit, reference, notes })
    }
}

impl PresetFormat {
    fn extension(self) -> &'static str {
        match self {
            Self::OpenPbr | Self::Arnold => "mtlx",
            Self::Usd => "usda",
            Self::Principled => "py",
        }
    }

    fn content(self) -> &'static str {
        match self {
            Self::OpenPbr | Self::Arnold | Self::Usd => "the material",
            Self::Principled => "the script",
        }
    }

    /// Lines that say what the values depend on, and what the preset cannot do.
    fn limits(self) -> Vec<String> {
        let own: &[&str] = match self {
            Self::OpenPbr | Self::Usd => &[
                "A random walk as in OpenPBR 1.1, with van de Hulst's inversion of colours.",
                "Verified: this medium, by volpath of Mitsuba 3.9.1, through 1 and 5 cm of the default snow, within \
                 6 %. Not verified: any renderer's own OpenPBR.",
            ],
            Self::Arnold => &[
                "A random walk with van de Hulst's inversion of colours. Standard Surface leaves the inversion to the \
                 renderer.",
                "Not verified in Arnold, or in any other renderer of Standard Surface. The values below are those of \
                 OpenPBR's medium.",
            ],
            Self::Principled => &[
                "Cycles, method Random Walk of Blender 4.0 to 5.1, Random Walk (Legacy) of later versions.",
                "Verified in Blender 5.0.1: albedo, and what comes through 1 and 5 cm, of the default snow.",
                "Cycles ends a walk after 256 flights, which the values below contain: light that would go on is lost.",
                "What comes through leaves equally in all directions. Snow is brighter straight on, by a quarter.",
                "The base colour is not the colour of the snow, but the one that Cycles turns into its absorption.",
            ],
        };
        let common = [
            "Three channels, each with one decay: behind thick snow the spectrum narrows, and no channel follows it.",
            "One medium in a closed mesh: no layers, no facets that sparkle. The surface does not reflect; grains do.",
        ];
        own.iter().copied().chain(common).map(str::to_owned).collect()
    }
}
