//! The parameters of a preset as all formats write them.

use clap::ValueEnum;
use snowblue_color::RgbSpace;
use snowblue_database::preset::{ChannelPreset, RendererPreset, SnowReference};

/// Length of a unit of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum SceneUnit {
    M,
    Cm,
    Mm,
}

/// A linear colour space of renderers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum ColorSpace {
    #[value(name = "acescg")]
    AcesCg,
    SrgbLinear,
    Rec2020,
}

/// The written content: parameters with radii in units of the scene, and lines of notes.
pub(super) struct Written {
    pub(super) preset: RendererPreset,
    pub(super) color_space: ColorSpace,
    pub(super) unit: SceneUnit,
    /// The snow to which the parameters are fitted.
    pub(super) reference: SnowReference,
    pub(super) notes: Vec<String>,
}

impl SceneUnit {
    pub(super) fn metres(self) -> f64 {
        match self {
            Self::M => 1.0,
            Self::Cm => 0.01,
            Self::Mm => 0.001,
        }
    }

    pub(super) fn word(self) -> &'static str {
        match self {
            Self::M => "m",
            Self::Cm => "cm",
            Self::Mm => "mm",
        }
    }
}

impl ColorSpace {
    pub(super) fn rgb(self) -> RgbSpace {
        match self {
            Self::AcesCg => RgbSpace::AcesCg,
            Self::SrgbLinear => RgbSpace::Srgb,
            Self::Rec2020 => RgbSpace::Rec2020,
        }
    }
}

impl Written {
    pub(super) fn colors(&self) -> [f64; 3] {
        self.preset.channels.map(|channel| channel.color)
    }

    /// The greatest radius, in units of the scene.
    pub(super) fn scale(&self) -> f64 {
        self.radii().into_iter().fold(0.0, f64::max)
    }

    /// The radii divided by the greatest radius.
    pub(super) fn relative_radii(&self) -> [f64; 3] {
        self.radii().map(|radius| radius / self.scale())
    }

    fn radii(&self) -> [f64; 3] {
        self.preset.channels.map(|ChannelPreset { radius_m, .. }| radius_m / self.unit.metres())
    }
}

/// A number with seven significant digits, in a notation that all these formats read.
pub(super) fn number(value: f64) -> String {
    let rounded: f64 = format!("{value:.6e}").parse().unwrap_or(value);
    format!("{rounded:?}")
}

/// Three numbers with commas.
pub(super) fn three(values: [f64; 3]) -> String {
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
