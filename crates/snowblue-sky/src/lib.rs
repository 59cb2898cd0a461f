#![doc = include_str!("../README.md")]
//!
//! # Data flow
//!
//! ```text
//! Place, DateTime ─► SunPosition ─► elevation ─► ClearSky, OvercastSky ─┬─► radiance of a direction
//!                                                                       └─► Sky ─► Daylight on the ground
//! ```
//!
//! A [`ClearSky`] evaluates the model of Hosek & Wilkie; `data/SOURCES.md` lists its coefficients. An [`OvercastSky`]
//! hides the sun. [`Sky`] is either, and gives the direct and the diffuse [`Daylight`] on the ground as a spectral
//! irradiance, an illuminance, or a photon flux. [`sun_position`] computes the position of the sun, and
//! [`air_extinction_per_m`] the extinction by the air in front of distant objects.
//!
//! # Simplifications
//!
//! Radiances have the wavelengths of the model, 320–720 nm, sampled every 40 nm: no absorption line of the air is
//! resolved. Irradiances extend to 2500 nm with a model of the transmittance of the air and of clouds. The ground is
//! level and reflects all directions alike. A sun below the horizon gives no light. The sun is at its mean distance,
//! and the place is at sea level. The irradiance of the sun differs from its value at the mean distance by −3.3 %
//! (July) to 3.4 % (January).
//!
//! # Out of scope
//!
//! Twilight, the moon, single clouds, and the polarisation of the sky.

mod air;
mod error;

mod sun_position;
mod time;

mod rings;
mod tables;

mod cloud;
mod infrared;

mod clear_sky;
mod luminous;
mod overcast;

mod daylight;

pub use air::air_extinction_per_m;
pub use clear_sky::{ClearSky, ELEVATION_RANGE_DEG, SUN_RADIUS_RAD, limb_darkening_at_nodes};
pub use daylight::{Clouds, DAYLIGHT_RANGE_NM, Daylight, Sky, Weather, daylight_wavelengths_nm};
pub use error::SkyError;
pub use overcast::{
    CLOUD_OPTICAL_THICKNESS, CLOUD_OPTICAL_THICKNESS_RANGE, OVERCAST_IRRADIANCE_SR, OvercastSky,
    overcast_illuminance_lx, overcast_relative_radiance,
};
pub use sun_position::{Place, SunPosition, sun_position};
pub use tables::{
    Coefficients, PRECIPITABLE_WATER_CM, PRECIPITABLE_WATER_RANGE_CM, TURBIDITY_RANGE, WAVELENGTHS_NM, at_wavelength,
};
pub use time::{DateTime, times_of_day};
