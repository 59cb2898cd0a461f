//! The composition of snow: a [`SnowSample`], kinds of snow by name, a sample from what is known of a snow (as values
//! or as words), and the ageing of its surface.

mod grain_size;
mod snow_description;
mod snow_sample;
mod snow_type;
mod truncated_normal;

pub use crate::grain::SizeMeasure;
pub use grain_size::{GrainSize, MEAN_SIZE_HALF_RANGE_UM, MEAN_SIZE_RANGE, Metamorphism, aged_surface_area_m2_kg};
pub use snow_description::{SnowDescription, SnowKeyError, SnowKeys};
pub use snow_sample::SnowSample;
pub use snow_type::SnowType;
pub(crate) use truncated_normal::Quantiles;
pub use truncated_normal::TruncatedNormal;
