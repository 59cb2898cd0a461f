//! Errors of this crate.

use std::ops::RangeInclusive;

/// Why a colour cannot be computed from the input.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ColorError {
    /// No illuminant has this name.
    #[error("illuminant is `{name}`, but must be one of {known}")]
    UnknownIlluminant {
        /// The given name.
        name: String,
        /// All names, separated by commas.
        known: String,
    },
    /// No observer has this name.
    #[error("observer is `{name}`, but must be 1931 (or 2, for 2°) or 1964 (or 10, for 10°)")]
    UnknownObserver {
        /// The given name.
        name: String,
    },
    /// A wavelength lies outside a table.
    #[error("wavelength is {wavelength_nm} nm, but must lie in {first_nm}–{last_nm} nm for {table}")]
    OutsideTable {
        /// The wavelength in nm.
        wavelength_nm: f64,
        /// The first wavelength of the table in nm.
        first_nm: f64,
        /// The last wavelength of the table in nm.
        last_nm: f64,
        /// The illuminant, the observer or the spectrum.
        table: String,
    },
    /// The wavelengths do not increase.
    #[error("wavelengths must increase, but {wavelength_nm} nm follows {previous_nm} nm")]
    NotIncreasing {
        /// The wavelength in nm that is too small.
        wavelength_nm: f64,
        /// The previous wavelength in nm.
        previous_nm: f64,
    },
    /// A spectrum does not cover the visible range.
    #[error("the wavelengths are {first_nm}–{last_nm} nm, but must cover 400–700 nm")]
    NotCovered {
        /// The first wavelength in nm.
        first_nm: f64,
        /// The last wavelength in nm.
        last_nm: f64,
    },
    /// A step of a spectrum is too wide.
    #[error(
        "the step from {low_nm} to {high_nm} nm is {step_nm} nm, but must be at most 20 nm within 400–700 nm",
        step_nm = high_nm - low_nm
    )]
    WideStep {
        /// Where the step begins, in nm.
        low_nm: f64,
        /// Where it ends, in nm.
        high_nm: f64,
    },
    /// A spectrum has too few values or uneven steps for Sprague interpolation.
    #[error(
        "Sprague interpolation needs at least 6 values in even steps, but there are {count} values, and the first two \
         are {step_nm} nm apart"
    )]
    SpragueNeedsEvenSteps {
        /// Number of values.
        count: usize,
        /// The first step in nm.
        step_nm: f64,
    },
    /// The bare light has a zero tristimulus value, so there is no reference white.
    #[error(
        "the bare light has X = {x}, Y = {y}, Z = {z} (relative) on {count} wavelengths, but each must be above 0: \
         include blue, green and red wavelengths that the light contains"
    )]
    NoWhite {
        /// X of the bare light, in an arbitrary unit.
        x: f64,
        /// Y of the bare light, in the unit of X.
        y: f64,
        /// Z of the bare light, in the unit of X.
        z: f64,
        /// Number of wavelengths.
        count: usize,
    },
    /// No tone curve has this name.
    #[error("tone curve is `{name}`, but must be one of {known}")]
    UnknownToneCurve {
        /// The given name.
        name: String,
        /// All names, separated by commas.
        known: String,
    },
    /// A colour temperature has no light.
    #[error("colour temperature is {kelvin} K, but must lie in {}–{} K", range_k.start(), range_k.end())]
    Temperature {
        /// The temperature in K.
        kelvin: f64,
        /// Where it must lie, in K.
        range_k: RangeInclusive<f64>,
    },
    /// Not a hexadecimal colour as in HTML.
    #[error("colour is `{text}`, but must be `#` and six hexadecimal digits, such as #8fb8de")]
    InvalidHex {
        /// The given text.
        text: String,
    },
}
