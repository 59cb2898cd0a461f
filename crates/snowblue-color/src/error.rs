//! What can be wrong with the input of this room.

/// Why a colour cannot be computed from what was given.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ColorError {
    /// No illuminant has this name.
    #[error("illuminant is `{name}`, but must be one of {known}")]
    UnknownIlluminant {
        /// The name as it was written.
        name: String,
        /// All names, separated by commas.
        known: String,
    },
    /// No observer has this name.
    #[error("observer is `{name}`, but must be 1931 (or 2, for 2°) or 1964 (or 10, for 10°)")]
    UnknownObserver {
        /// The name as it was written.
        name: String,
    },
    /// A wavelength lies where a table has no values.
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
    /// A list of wavelengths stands still or goes back.
    #[error("wavelengths must increase, but {wavelength_nm} nm follows {previous_nm} nm")]
    NotIncreasing {
        /// The wavelength in nm that is too small.
        wavelength_nm: f64,
        /// The one before it in nm.
        previous_nm: f64,
    },
    /// A spectrum has too few values or uneven steps for Sprague's curves.
    #[error(
        "Sprague's interpolation needs 6 values or more in even steps, but there are {count} values, of which the first \
         two lie {step_nm} nm apart"
    )]
    NoSprague {
        /// How many values there are.
        count: usize,
        /// The first step in nm.
        step_nm: f64,
    },
    /// The light excites fewer than three kinds of the observer's receptors, so there is no white to compare with.
    #[error(
        "the bare light has X = {x}, Y = {y}, Z = {z} (relative) on {count} wavelengths, but each must be above 0: \
         include blue, green and red wavelengths that the light contains"
    )]
    NoWhite {
        /// X of the bare light, in an arbitrary unit.
        x: f64,
        /// Y of the bare light, in the same unit.
        y: f64,
        /// Z of the bare light, in the same unit.
        z: f64,
        /// How many wavelengths were given.
        count: usize,
    },
    /// Not an 8-bit colour as it is written in HTML.
    #[error("colour is `{text}`, but must be `#` and six hexadecimal digits, such as #8fb8de")]
    NotHex {
        /// The text as it was written.
        text: String,
    },
}
