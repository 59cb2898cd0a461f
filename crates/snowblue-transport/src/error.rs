//! Errors of the engines and of their input.

use snowblue_base::RangeError;

/// Why an input is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TransportError {
    /// A quantity lies outside the range in which the model holds, or the ends of an interval are in the wrong order.
    #[error(transparent)]
    Range(#[from] RangeError),
    /// A property of snow for a layer of clear ice.
    #[error("{key} is a property of snow: a layer of clear ice has only thickness_cm")]
    IceProperty {
        /// Key of the property.
        key: String,
    },
    /// An unknown kind of layer.
    #[error("kind of layer '{name}' is not known; it must be ice, or be left out for snow")]
    LayerKind {
        /// The kind given.
        name: String,
    },
    /// The density of clear ice for snow.
    #[error("{error}: snow has separate grains; a layer of clear ice has kind = \"ice\"")]
    ClearIce {
        /// The density and its range.
        error: RangeError,
    },
    /// A mean grain size whose range leaves the model's range.
    #[error(
        "mean grain size is {mean_um} µm, but its range of ± {half_range_um} µm must lie in {}–{} µm: give a mean of \
         {least_um}–{greatest_um} µm, or the ends of the range", least_um - half_range_um, greatest_um + half_range_um
    )]
    MeanSize {
        /// Mean given, in µm.
        mean_um: f64,
        /// Half-width of the range that a mean represents, in µm.
        half_range_um: f64,
        /// Least mean, in µm.
        least_um: f64,
        /// Greatest mean, in µm.
        greatest_um: f64,
    },
    /// A number of streams that is odd, zero or too large.
    #[error("streams are {streams}, but must be an even number in 2–{most}, counting both hemispheres")]
    Streams {
        /// Number given.
        streams: usize,
        /// Greatest number allowed.
        most: usize,
    },
    /// A phase function with a peak that the streams do not resolve.
    #[error("{streams} streams cannot resolve this phase function; use more, or a broader one")]
    Unresolved {
        /// Number of streams given.
        streams: usize,
    },
    /// A name that is not known.
    #[error("{quantity} '{name}' is not known; there are {known}")]
    Unknown {
        /// Kind of name.
        quantity: &'static str,
        /// Name given.
        name: String,
        /// Known names.
        known: String,
    },
    /// A word that is not an angle of incidence.
    #[error("'{word}' is neither an angle in degrees nor 'diffuse'")]
    NoAngle {
        /// Word given.
        word: String,
    },
    /// A table of a substance that is wrong.
    #[error("substance {name}: {reason}")]
    Substance {
        /// Name of the substance.
        name: String,
        /// Description of the error.
        reason: String,
    },
    /// A quantity with too few or too many numbers.
    #[error("{quantity} has {count} numbers, but must be {expected}")]
    Count {
        /// Name of the quantity.
        quantity: &'static str,
        /// How many numbers are given.
        count: usize,
        /// The numbers that are expected.
        expected: &'static str,
    },
    /// The prior of a parameter that is to be retrieved is out of range.
    #[error("the prior of {parameter}: {error}")]
    Prior {
        /// Name of the parameter.
        parameter: String,
        /// The range error.
        error: RangeError,
    },
    /// A standard deviation is out of range.
    #[error("the standard deviation of {error}")]
    Deviation {
        /// The range error.
        error: RangeError,
    },
    /// A quantity that has no meaning beside or without another.
    #[error("{quantity} {rule}")]
    Combination {
        /// Name of the quantity.
        quantity: &'static str,
        /// The rule that the combination violates.
        rule: &'static str,
    },
    /// Wavelengths that do not cover a band.
    #[error(
        "the {band} band needs wavelengths from {first_nm} to {last_nm} nm, no more than {step_nm} nm apart, \
         but there is none from {from_nm} to {to_nm} nm"
    )]
    Uncovered {
        /// Name of the band.
        band: &'static str,
        /// First wavelength of the band, in nm.
        first_nm: f64,
        /// Last wavelength of the band, in nm.
        last_nm: f64,
        /// Greatest distance between wavelengths, in nm.
        step_nm: f64,
        /// Start of the gap, in nm.
        from_nm: f64,
        /// End of the gap, in nm.
        to_nm: f64,
    },
    /// Wavelengths that do not ascend.
    #[error("the wavelengths of a band must ascend, but {next_nm} nm follows {previous_nm} nm")]
    Descending {
        /// A wavelength, in nm.
        previous_nm: f64,
        /// The next wavelength, in nm.
        next_nm: f64,
    },
    /// An input without thickness, angle or wavelength.
    #[error("no {quantity} is given")]
    Missing {
        /// Name of the missing quantity.
        quantity: &'static str,
    },
}

impl TransportError {
    /// The message without the name of the quantity, as the rest of a sentence that begins with a key.
    #[must_use]
    pub fn after_key(&self) -> String {
        let message = self.to_string();
        let quantity = match self {
            Self::Range(error) => return error.after_key(),
            Self::ClearIce {
                error: RangeError::OutOfRange { quantity, .. } | RangeError::Reversed { quantity, .. },
            }
            | Self::Count { quantity, .. }
            | Self::Combination { quantity, .. } => quantity,
            Self::MeanSize { .. } => "mean grain size",
            _ => "",
        };
        message.strip_prefix(quantity).unwrap_or(&message).trim_start().to_owned()
    }
}

/// An error in the input of an inversion.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{error}{}", depth_cm.map(|depth_cm| format!(", at a depth of {depth_cm} cm")).unwrap_or_default())]
pub struct InversionError {
    /// The wrong observation; none if all observations are wrong.
    pub observation: Option<usize>,
    /// Index of the wavelength or the band at which the observation is wrong, if there is one.
    pub wavelength: Option<usize>,
    /// The depth at which the observation is wrong, in cm, if there is one.
    pub depth_cm: Option<f64>,
    /// The error.
    #[source]
    pub error: Box<TransportError>,
}

impl InversionError {
    pub(crate) fn at_wavelength(place: usize, error: impl Into<TransportError>) -> Self {
        Self { wavelength: Some(place), ..Self::from(error.into()) }
    }
}

impl From<TransportError> for InversionError {
    fn from(error: TransportError) -> Self {
        Self { observation: None, wavelength: None, depth_cm: None, error: Box::new(error) }
    }
}

impl From<RangeError> for InversionError {
    fn from(error: RangeError) -> Self {
        TransportError::from(error).into()
    }
}

/// Finds a value of an enumeration by its name.
pub(crate) fn find_by_name<T: Copy>(
    quantity: &'static str,
    name: &str,
    all: &[T],
    name_of: fn(T) -> &'static str,
) -> Result<T, TransportError> {
    all.iter().copied().find(|value| name_of(*value) == name).ok_or_else(|| TransportError::Unknown {
        quantity,
        name: name.to_owned(),
        known: all.iter().map(|value| name_of(*value)).collect::<Vec<_>>().join(", "),
    })
}
