//! `snowblue export openpbr`, `arnold`, `usd` and `principled`: subsurface parameters for renderers without a plug-in.

mod comparison;
mod material_x;
mod principled;
mod usd;

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use snowblue_color::{Observer, RgbSpace};
use snowblue_database::preset::{ChannelPreset, RendererPreset, SnowReference, SubsurfaceModel};

use crate::options::{LightOptions, OrdinatesArguments, SampleCount, SnowOptions};
use crate::output::{Failure, Outcome, check_extension, output_path, print, write_file};

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

/// Length of a unit of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SceneUnit {
    M,
    Cm,
    Mm,
}

/// A linear colour space of renderers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ColorSpace {
    #[value(name = "acescg")]
    AcesCg,
    SrgbLinear,
    Rec2020,
}

/// What is written: parameters with radii in units of the scene, and lines of notes.
struct Written {
    preset: RendererPreset,
    color_space: ColorSpace,
    unit: SceneUnit,
    /// The albedo of deep snow in linear sRGB, for surfaces without subsurface scattering.
    srgb_albedo: [f64; 3],
    notes: Vec<String>,
}

impl PresetFile {
    pub(super) fn write(&self, format: PresetFormat) -> Outcome {
        if let Some(path) = &self.output {
            check_extension(path, format.extension(), format.content())?;
        }
        let text = match format {
            PresetFormat::OpenPbr => material_x::open_pbr(&self.fit(format)?),
            PresetFormat::Arnold => material_x::standard_surface(&self.fit(format)?),
            PresetFormat::Usd => usd::material(&self.fit(format)?),
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
        let srgb_albedo = reference.albedo(RgbSpace::Srgb);
        Ok(Written { preset, color_space, unit: self.scene_unit, srgb_albedo, notes })
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

    /// What the values depend on, and what the preset cannot do, in lines.
    fn limits(self) -> Vec<String> {
        let own: &[&str] = match self {
            Self::OpenPbr | Self::Usd => {
                &["A random walk as in OpenPBR 1.1, with van de Hulst's inversion of colours."]
            }
            Self::Arnold => &[
                "A random walk with van de Hulst's inversion of colours. Standard Surface leaves the inversion to the \
                 renderer.",
            ],
            Self::Principled => &[
                "Cycles, method Random Walk of Blender 4.0 to 5.0, Random Walk (Legacy) of later versions.",
                "Cycles gives a walk up after 256 flights, which the values below contain: snow is too dark, and thick \
                 snow black.",
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

impl SceneUnit {
    fn metres(self) -> f64 {
        match self {
            Self::M => 1.0,
            Self::Cm => 0.01,
            Self::Mm => 0.001,
        }
    }

    fn word(self) -> &'static str {
        match self {
            Self::M => "m",
            Self::Cm => "cm",
            Self::Mm => "mm",
        }
    }
}

impl ColorSpace {
    fn rgb(self) -> RgbSpace {
        match self {
            Self::AcesCg => RgbSpace::AcesCg,
            Self::SrgbLinear => RgbSpace::Srgb,
            Self::Rec2020 => RgbSpace::Rec2020,
        }
    }
}

impl Written {
    fn colors(&self) -> [f64; 3] {
        self.preset.channels.map(|channel| channel.color)
    }

    /// The greatest radius, in units of the scene.
    fn scale(&self) -> f64 {
        self.radii().into_iter().fold(0.0, f64::max)
    }

    /// The radii over the greatest.
    fn relative_radii(&self) -> [f64; 3] {
        self.radii().map(|radius| radius / self.scale())
    }

    fn radii(&self) -> [f64; 3] {
        self.preset.channels.map(|ChannelPreset { radius_m, .. }| radius_m / self.unit.metres())
    }
}

/// A number with seven significant digits, as all these formats read it.
fn number(value: f64) -> String {
    let rounded: f64 = format!("{value:.6e}").parse().unwrap_or(value);
    format!("{rounded:?}")
}

/// Three numbers with commas.
fn three(values: [f64; 3]) -> String {
    values.map(number).join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_seven_digits_and_a_point() {
        assert_eq!([1.0, 0.0, 0.123_456_789, 2.0 / 3.0e6].map(number), ["1.0", "0.0", "0.1234568", "6.666667e-7"]);
    }
}
