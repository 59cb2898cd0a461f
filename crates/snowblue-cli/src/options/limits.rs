//! Limits in help texts. They come from the crates that check the values.

use std::fmt::Display;
use std::ops::RangeInclusive;

use snowblue_base::Quantity;
use snowblue_color::exposure::MAX_STOPS;
use snowblue_color::temperature::RANGE_K;
use snowblue_transport::Parameter;
use snowblue_transport::optics::{IceTable, WavelengthRange};

/// The description of a parameter, with its unit and its limits.
pub(crate) fn described(parameter: &Parameter) -> String {
    format!("{} [{}]", parameter.describe(), ends(&parameter.range.inclusive()))
}

/// The ends of a range.
pub(crate) fn ends<T: Display>(range: &RangeInclusive<T>) -> String {
    format!("{}–{}", range.start(), range.end())
}

/// The ends of the range of a quantity.
pub(crate) fn of<Q: Quantity>() -> String {
    ends(&Q::RANGE.inclusive())
}

/// The wavelengths of the model, in nm.
pub(crate) fn snow_wavelengths() -> String {
    let WavelengthRange { first_nm, last_nm } = IceTable::default().wavelength_range();
    ends(&(first_nm..=last_nm))
}

/// Colour temperatures.
pub(crate) fn temperatures() -> String {
    format!("{}K–{}K", RANGE_K.start(), RANGE_K.end())
}

/// Stops of an exposure.
pub(crate) fn stops() -> String {
    ends(&(-MAX_STOPS..=MAX_STOPS))
}
