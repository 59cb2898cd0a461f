//! What snow is made of: a [`SnowSample`] and its parameters, kinds of snow by name, and other plausible readings of a
//! sample.

mod alternatives;
mod grain_size;
mod snow_sample;
mod snow_type;
mod truncated_normal;

pub use crate::grain::SizeMeasure;
pub use alternatives::{Alternative, alternatives};
pub use grain_size::{GrainSize, MEAN_SIZE_HALF_RANGE_UM};
pub use snow_sample::SnowSample;
pub use snow_type::SnowType;
pub(crate) use truncated_normal::Quantiles;
pub use truncated_normal::{MEAN_FACETNESS_DEVIATION, TruncatedNormal};
