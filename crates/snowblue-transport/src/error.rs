//! What can be wrong with a question, said once at the door.

/// Why a question about light in snow cannot be answered.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TransportError {
    /// A quantity lies outside the range in which the model holds.
    #[error("{quantity} is {value}{unit}, but must lie in {low}–{high}{unit}")]
    OutOfRange {
        /// The quantity's name.
        quantity: &'static str,
        /// What was given.
        value: f64,
        /// Least value allowed.
        low: f64,
        /// Greatest value allowed.
        high: f64,
        /// Unit with a leading space, or nothing.
        unit: &'static str,
    },
    /// The ends of a range are in the wrong order.
    #[error("{quantity} has the range {low}:{high}{unit}, whose ends are in the wrong order")]
    Reversed {
        /// The quantity's name.
        quantity: &'static str,
        /// The end that was given first.
        low: f64,
        /// The end that was given second.
        high: f64,
        /// Unit with a leading space, or nothing.
        unit: &'static str,
    },
    /// A mean grain size whose range of ± 50 µm would leave the model's range.
    #[error(
        "mean grain size is {mean_um} µm, but its range of ± 50 µm would start below 20 µm; give the range as MIN:MAX"
    )]
    MeanTooSmall {
        /// The mean that was given.
        mean_um: f64,
    },
    /// The number of ordinates cannot be halved between the hemispheres.
    #[error("streams are {streams}, but must be an even number in 2–{most}, counting both hemispheres")]
    Streams {
        /// What was given.
        streams: usize,
        /// Greatest number allowed.
        most: usize,
    },
    /// A phase function whose peak the ordinates cannot resolve.
    #[error("{streams} streams cannot resolve this phase function; use more, or a broader one")]
    Unresolved {
        /// What was given.
        streams: usize,
    },
    /// A name that stands for nothing.
    #[error("{quantity} '{name}' is not known; there are {known}")]
    Unknown {
        /// What the name was to be of.
        quantity: &'static str,
        /// What was given.
        name: String,
        /// The names that there are.
        known: String,
    },
    /// Wavelengths that do not cover a band.
    #[error(
        "the {band} band needs wavelengths from {low_nm} to {high_nm} nm, no more than {step_nm} nm apart, \
         but there is none from {from_nm} to {to_nm} nm"
    )]
    Uncovered {
        /// The band's name.
        band: &'static str,
        /// Where the band begins, in nm.
        low_nm: f64,
        /// Where the band ends, in nm.
        high_nm: f64,
        /// Greatest distance between wavelengths, in nm.
        step_nm: f64,
        /// Where the gap begins, in nm.
        from_nm: f64,
        /// Where the gap ends, in nm.
        to_nm: f64,
    },
    /// Wavelengths that are no curve.
    #[error("the wavelengths of a band must ascend, but {next_nm} nm follows {previous_nm} nm")]
    Descending {
        /// A wavelength, in nm.
        previous_nm: f64,
        /// The one that follows it, in nm.
        next_nm: f64,
    },
    /// A question with no thickness, angle or wavelength.
    #[error("no {quantity} is given")]
    Nothing {
        /// What is missing.
        quantity: &'static str,
    },
}

impl TransportError {
    /// Checks that `value` lies in `range`, ends included; not-a-number does not.
    ///
    /// # Errors
    /// [`TransportError::OutOfRange`] otherwise.
    pub(crate) fn check(
        quantity: &'static str,
        value: f64,
        (low, high): (f64, f64),
        unit: &'static str,
    ) -> Result<(), Self> {
        if (low..=high).contains(&value) { Ok(()) } else { Err(Self::OutOfRange { quantity, value, low, high, unit }) }
    }

    /// Checks that both ends of a range lie in `range` and are in order.
    ///
    /// # Errors
    /// [`TransportError::OutOfRange`] or [`TransportError::Reversed`] otherwise.
    pub(crate) fn check_range(
        quantity: &'static str,
        (low, high): (f64, f64),
        range: (f64, f64),
        unit: &'static str,
    ) -> Result<(), Self> {
        Self::check(quantity, low, range, unit)?;
        Self::check(quantity, high, range, unit)?;
        if low <= high { Ok(()) } else { Err(Self::Reversed { quantity, low, high, unit }) }
    }
}
