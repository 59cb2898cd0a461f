#![doc = include_str!("../README.md")]
//!
//! # Data flow
//!
//! ```text
//! observer, illuminant ─► colorimeter ─► Xyz ─┬─► LinearRgb ─► exposure ─► tone ─► gamut ─► Srgb8 (#rrggbb)
//!         sampling ─► spectrum ──┘            ├─► RgbSpace (sRGB, Rec. 2020, ACEScg), Oklab
//!                                             └─► Lab ─► ΔE*ab, CIEDE2000
//! ```
//!
//! A [`Colorimeter`] is built once from an [`Observer`], an [`Illuminant`] and a list of wavelengths. It converts any
//! spectrum on these wavelengths, given as a ratio to the bare light (a transmittance or a reflectance), to [`Xyz`].
//! [`LinearRgb::displayable`] maps colours outside the sRGB gamut, such as the blue of deep snow, to displayable
//! ones: it keeps the luminance, and nearly keeps the perceived hue. A [`ToneCurve`] maps light that is brighter than
//! white to displayable colours.
//!
//! # Simplifications
//!
//! Tables are interpolated linearly. A sum over the given wavelengths approximates the integral, as in CIE 015:2018, so
//! the wavelengths should be evenly spaced; [`sampling`] provides grids of 1, 5 and 10 nm and documents their error.
//! Chromatic adaptation happens only on request ([`ChromaticAdaptation`]): the bare light has Y = 1 and keeps its own
//! chromaticity. RGB spaces and Oklab are defined for the 2° observer.
//!
//! # Out of scope
//!
//! Fluorescence, colour appearance (surround, adapting luminance, scotopic vision), display profiles and
//! high-dynamic-range encodings.

pub mod error;

mod curve;
mod matrix;

pub mod xyz;

pub mod illuminant;
pub mod observer;
pub mod sampling;
pub mod temperature;

pub mod colorimeter;

pub mod lab;

pub mod transfer;

pub mod rgb;

pub mod oklab;

pub mod gamut;

pub mod exposure;
pub mod tone;

pub use colorimeter::Colorimeter;
pub use error::ColorError;
pub use illuminant::Illuminant;
pub use lab::{ColorDifference, Lab};
pub use observer::{DominantWavelength, Observer};
pub use oklab::Oklab;
pub use rgb::{LinearRgb, Primaries, Rgb, RgbSpace, Srgb8};
pub use sampling::{THREE_SAMPLES_NM, WavelengthStep};
pub use tone::ToneCurve;
pub use xyz::{ChromaticAdaptation, Chromaticity, Xyy, Xyz};
