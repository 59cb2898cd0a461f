//! From spectra to colour: what a standard eye sees of the light that snow lets through.
//!
//! ```text
//! observer, illuminant ─► colorimeter ─► Xyz ─┬─► LinearRgb ─► Srgb8 (#rrggbb)
//!                          spectrum ──┘       └─► Lab ─► ΔE*ab
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
//! **Simplified.** Tables are joined by straight lines. A sum over the given wavelengths stands for the integral, as in
//! CIE 015:2018, so the wavelengths should be evenly spaced. There is no chromatic adaptation: the bare light has Y = 1,
//! and its own hue in every result.
//!
//! **Out of scope.** Fluorescence, colour appearance, display profiles, RGB spaces other than sRGB, colour-difference
//! formulas later than 1976.

pub mod error;

mod curve;

pub mod xyz;

pub mod illuminant;
pub mod observer;

pub mod colorimeter;

pub mod lab;

pub mod difference;

pub mod rgb;
pub mod srgb;

pub use colorimeter::Colorimeter;
pub use difference::Difference;
pub use error::ColorError;
pub use illuminant::Illuminant;
pub use lab::Lab;
pub use observer::Observer;
pub use rgb::LinearRgb;
pub use srgb::Srgb8;
pub use xyz::{Chromaticity, Xyz};
