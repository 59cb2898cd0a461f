//! Haze, clouds and vapour above the snow.

use clap::Args;
use snowblue_sky::{
    CLOUD_OPTICAL_THICKNESS, CLOUD_OPTICAL_THICKNESS_RANGE, Clouds, PRECIPITABLE_WATER_CM, PRECIPITABLE_WATER_RANGE_CM,
    TURBIDITY_RANGE, Weather,
};

use super::parse;

/// The sky apart from its sun.
#[derive(Debug, Clone, Copy, Args)]
#[command(next_help_heading = "Sky")]
pub(crate) struct WeatherOptions {
    #[arg(
        long, value_name = "T", value_parser = parse::number, default_value = "3", conflicts_with = "overcast",
        help = format!(
            "Haze of a clear sky: 2 is very clear air, 3 clear, 6 moist and warm, 10 hazy [{}–{}]",
            TURBIDITY_RANGE.0, TURBIDITY_RANGE.1
        )
    )]
    pub(crate) turbidity: f64,
    #[arg(
        long, value_name = "CM", value_parser = parse::number, default_value_t = PRECIPITABLE_WATER_CM,
        help = format!(
            "Water vapour in the air, which absorbs in the infrared, in cm of water [{}–{}]",
            PRECIPITABLE_WATER_RANGE_CM.0, PRECIPITABLE_WATER_RANGE_CM.1
        )
    )]
    pub(crate) precipitable_water: f64,
    /// An overcast sky instead of a clear one
    #[arg(long)]
    pub(crate) overcast: bool,
    #[arg(
        long, value_name = "TAU", value_parser = parse::number, default_value_t = CLOUD_OPTICAL_THICKNESS,
        requires = "overcast",
        help = format!(
            "Optical thickness of the clouds, which absorb in the infrared; the illuminance stays [{}–{}]",
            CLOUD_OPTICAL_THICKNESS_RANGE.0, CLOUD_OPTICAL_THICKNESS_RANGE.1
        )
    )]
    pub(crate) cloud_thickness: f64,
}

impl WeatherOptions {
    /// The weather over ground that reflects a fraction of the light.
    pub(crate) fn weather(&self, ground_albedo: f64) -> Weather {
        let Self { turbidity, precipitable_water: precipitable_water_cm, .. } = *self;
        let clouds = if self.overcast {
            Clouds::Overcast { optical_thickness: self.cloud_thickness }
        } else {
            Clouds::None { turbidity }
        };
        Weather { clouds, ground_albedo, precipitable_water_cm }
    }
}
