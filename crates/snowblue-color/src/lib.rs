//! From spectra to colour: what a standard eye sees of the light that snow lets through.
//!
//! ```text
//! observer, illuminant ─► colorimeter ─► Xyz ─┬─► LinearRgb ─► exposure ─► gamut ─► Srgb8 (#rrggbb)
//!         sampling ─► spectrum ──┘            ├─► RgbSpace (sRGB, Rec. 2020, ACEScg), Oklab
//!                                             └─► Lab ─► ΔE*ab, CIEDE2000
//! ```
//!
//! A [`Colorimeter`] is made once from an [`Observer`], an [`Illuminant`] and a list of wavelengths. It turns any
//! spectrum on these wavelengths, a ratio to the bare light (a transmittance, a reflectance), into [`Xyz`]:
//!
//! ```
//! use snowblue_color::{Colorimeter, Illuminant, LinearRgb, Observer};
//!
//! let wavelengths_nm: Vec<f64> = (0..31).map(|step| 400.0 + 10.0 * f64::from(step)).collect();
//! let colorimeter = Colorimeter::new(Observer::Cie1931, Illuminant::D65, &wavelengths_nm)?;
//!
//! // Ice absorbs red light more than blue, so that daylight turns blue behind deep snow.
//! let deep_snow: Vec<f64> = wavelengths_nm.iter().map(|wavelength_nm| (4.0 - wavelength_nm / 100.0).exp()).collect();
//! let colour = LinearRgb::from_xyz(colorimeter.xyz(&deep_snow));
//! assert!(colour.b > colour.g && colour.g > colour.r);
//! # Ok::<(), snowblue_color::ColorError>(())
//! ```
//!
//! What a screen cannot show, the blue of deep snow before all, becomes what it can by
//! [`LinearRgb::displayable`](LinearRgb::displayable): the same luminance, nearly the same hue to the eye.
//!
//! **Simplified.** Tables are joined by straight lines. A sum over the given wavelengths stands for the integral, as in
//! CIE 015:2018, so the wavelengths should be evenly spaced; [`sampling`] gives the grids of 1, 5 and 10 nm and says what
//! they cost. Chromatic adaptation happens where it is asked for ([`Xyz::adapted`]): else the bare light has Y = 1, and
//! its own hue in every result. RGB spaces and Oklab are defined for the 2° observer.
//!
//! **Out of scope.** Fluorescence, colour appearance (surround, adapting luminance, bleached and dark-adapted eyes), tone
//! curves, display profiles, high-dynamic-range encodings.

pub mod error;

mod curve;
mod matrix;

pub mod xyz;

pub mod illuminant;
pub mod observer;
pub mod sampling;

pub mod colorimeter;

pub mod lab;

pub mod ciede2000;
pub mod difference;

pub mod adaptation;
pub mod oklab;
pub mod rgb;
pub mod srgb;

pub mod exposure;
pub mod gamut;

pub use colorimeter::Colorimeter;
pub use difference::Difference;
pub use error::ColorError;
pub use illuminant::Illuminant;
pub use lab::Lab;
pub use observer::Observer;
pub use oklab::Oklab;
pub use rgb::{LinearRgb, Rgb, RgbSpace};
pub use sampling::Step;
pub use srgb::Srgb8;
pub use xyz::{Chromaticity, Xyy, Xyz};
