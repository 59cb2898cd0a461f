//! Illuminant, observer and wavelengths of colours.

use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};
use snowblue_color::{Colorimeter, Illuminant, Observer, THREE_SAMPLES_NM};
use snowblue_transport::optics::Wavelengths;

use super::parse;
use crate::output::Failure;

/// The illuminant of colours.
#[derive(Debug, Clone, Copy, Args)]
#[command(next_help_heading = "Light")]
pub(crate) struct LightOptions {
    /// CIE illuminant: E, A, C, D50, D55, D65, D75, FL1–FL12, FL3.1–FL3.15, HP1–HP5, LED-B1…
    #[arg(long, value_name = "NAME", default_value = "D65", value_parser = parse::illuminant)]
    pub(crate) illuminant: Illuminant,
}

impl LightOptions {
    /// The colorimeter of spectra on these wavelengths.
    pub(crate) fn colorimeter(&self, observer: Observer, wavelengths_nm: &[f64]) -> Result<Colorimeter, Failure> {
        Colorimeter::new(observer, self.illuminant, wavelengths_nm).map_err(Failure::input)
    }
}

/// How spectra become colours.
#[derive(Debug, Args)]
#[command(next_help_heading = "Light")]
pub(crate) struct ColorOptions {
    /// CIE standard observer: 1931 (2°), which sRGB is defined by, or 1964 (10°)
    #[arg(long, value_name = "YEAR", default_value = "1931", value_parser = parse::observer)]
    pub(crate) observer: Observer,
    /// Number of wavelengths to sum over: 31 (400–700 nm every 10 nm) or 3 (455, 551, 608 nm)
    #[arg(long, value_name = "N", default_value = "31", value_enum)]
    pub(crate) samples: SampleCount,
}

/// Number of wavelengths that a colour is summed over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SampleCount {
    Three,
    ThirtyOne,
}

impl ValueEnum for SampleCount {
    fn value_variants<'a>() -> &'a [Self] {
        &[Self::ThirtyOne, Self::Three]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(match self {
            Self::Three => "3",
            Self::ThirtyOne => "31",
        }))
    }
}

impl SampleCount {
    /// The wavelengths, in nm.
    pub(crate) fn wavelengths_nm(self) -> Vec<f64> {
        match self {
            Self::Three => THREE_SAMPLES_NM.to_vec(),
            Self::ThirtyOne => Wavelengths::visible().0,
        }
    }
}
