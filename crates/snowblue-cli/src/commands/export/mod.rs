//! `snowblue export`: one snow for other renderers: its colours as functions and tables, and its subsurface
//! parameters.

mod compact_options;
mod presets;
mod tables;

use std::path::PathBuf;

use clap::{Args, Subcommand};
use snowblue_database::compact::{ADDED_ERROR_RANGE, ShaderLanguage};

use crate::options::{limits, parse};
use crate::output::{Failure, Outcome, check_path, output_path, print, write_file};
use compact_options::CompactOptions;
use presets::{PresetFile, PresetFormat};
use tables::TableFile;

/// The shader of a surface of snow, without the functions that it calls.
const OSL_SURFACE: &str = include_str!("surface.osl");

/// Write one snow for other renderers: colours as WGSL, GLSL, OSL or a table; subsurface parameters as MaterialX, USD
/// or a script for Blender
#[derive(Debug, Subcommand)]
#[command(after_help = "\
Functions and tables are those of PCASnow: the transmittance and the reflectance of a slab by its thickness in m and \
the cosine of the angle of incidence, under an illuminant whose light has luminance 1. Functions return linear sRGB, \
tables hold log2 of X, Y and Z. Deep blue lies outside sRGB and has a negative red.

openpbr, arnold, usd and principled write the parameters of a random walk below the surface: colour, radius and \
anisotropy, fitted to the snow. Each file says what deep snow, slabs and the light around a narrow beam look like, in \
snow and by the preset.

Examples:
  snowblue export wgsl -o snow.wgsl
  snowblue export glsl --grain-size 800 --impurity black-carbon=100 -o snow.glsl
  snowblue export osl -o snow.osl             a material for Blender's Cycles
  snowblue export lut -o snow.exr
  snowblue export openpbr --snow fresh --scene-unit cm -o snow.mtlx
  snowblue export principled -o snow.py       a material for Blender's Cycles, without a plug-in")]
pub(crate) enum Export {
    /// Write two functions in the WebGPU Shading Language
    Wgsl(Functions),
    /// Write two functions in the OpenGL Shading Language: 3.30, ES 3.00, WebGL 2, Godot
    Glsl(Functions),
    /// Write a surface in the Open Shading Language, which traces its thickness, for Blender's Cycles
    Osl(Functions),
    /// Write a look-up table: logarithms to base 2 of X, Y and Z by thickness and angle
    Lut(TableFile),
    /// Write an OpenPBR 1.1 surface as MaterialX
    Openpbr(PresetFile),
    /// Write a Standard Surface, of Arnold and others, as MaterialX
    Arnold(PresetFile),
    /// Write a material of USD: UsdPreviewSurface, and OpenPBR for renderers that know it
    Usd(PresetFile),
    /// Write a Python script that makes a material with Blender's Principled BSDF
    Principled(PresetFile),
}

/// Functions of a shading language.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub(crate) struct Functions {
    #[command(flatten)]
    compact: CompactOptions,
    #[arg(
        long, value_name = "FRACTION", default_value = "0.005", value_parser = parse::parameter(ADDED_ERROR_RANGE),
        help_heading = "Output", help = format!(
            "Greatest relative error of X, Y and Z that shortening the functions adds [{}]",
            limits::ends(&ADDED_ERROR_RANGE.inclusive())
        )
    )]
    added_error: f64,
    /// File to write [default: print]
    #[arg(short, long, value_name = "FILE", value_parser = output_path(), help_heading = "Output")]
    output: Option<PathBuf>,
}

impl Export {
    pub(crate) fn run(&self) -> Outcome {
        match self {
            Self::Wgsl(functions) => functions.write(ShaderLanguage::Wgsl, ""),
            Self::Glsl(functions) => functions.write(ShaderLanguage::Glsl, ""),
            Self::Osl(functions) => functions.write(ShaderLanguage::Osl, OSL_SURFACE),
            Self::Lut(file) => file.write(),
            Self::Openpbr(file) => file.write(PresetFormat::OpenPbr),
            Self::Arnold(file) => file.write(PresetFormat::Arnold),
            Self::Usd(file) => file.write(PresetFormat::Usd),
            Self::Principled(file) => file.write(PresetFormat::Principled),
        }
    }
}

impl Functions {
    fn write(&self, language: ShaderLanguage, rest: &str) -> Outcome {
        self.output.as_deref().map_or(Ok(()), check_path)?;
        let snow = self.compact.fit()?.shortened(self.added_error).map_err(Failure::input)?;
        let comments: String = self.compact.notes(&snow)?.iter().map(|line| format!("// {line}\n")).collect();
        let text = format!("{comments}\n{}{rest}", snow.functions(language));
        match &self.output {
            Some(path) => write_file(path, text.as_bytes()),
            None => print(&text).map_err(Failure::work),
        }
    }
}
