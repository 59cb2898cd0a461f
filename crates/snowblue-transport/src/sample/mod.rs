//! The composition of snow: a [`SnowSample`], the table of its properties, kinds of snow by name, a sample from known
//! properties, and the ageing of its surface.

mod grain_size;
mod property;
mod snow_keys;
mod snow_sample;
mod snow_type;
mod truncated_normal;

pub use crate::grain::SizeMeasure;
pub use grain_size::{GrainSize, MEAN_SIZE_HALF_RANGE_UM, MEAN_SIZE_RANGE, Metamorphism, aged_surface_area_m2_kg};
pub use property::{Property, parameters};
pub use snow_keys::{SnowKeyError, SnowKeys};
pub use snow_sample::SnowSample;
pub use snow_type::SnowType;
pub(crate) use truncated_normal::Quantiles;
pub use truncated_normal::TruncatedNormal;
