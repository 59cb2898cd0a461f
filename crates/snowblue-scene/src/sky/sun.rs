//! Where the sun is.

use glam::{DVec3, Vec3A};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_base::{KeyError, KeyPath, Number, Numbers, ParameterRange, quantities};
use snowblue_sky::{DateTime, Place, SkyError, SunPosition, sun_position};

use crate::values::{Direction, Rotation};

quantities! {
    /// An angle above the horizon.
    pub Elevation = ParameterRange::new("elevation", -90.0, 90.0, "°");
    /// Latitude, north positive.
    pub Latitude = ParameterRange::new("latitude", -90.0, 90.0, "°");
    /// Longitude, east positive.
    pub Longitude = ParameterRange::new("longitude", -180.0, 180.0, "°");
    /// Hours by which a clock is ahead of universal time.
    pub UtcOffset = ParameterRange::new("offset from universal time", -14.0, 14.0, "h");
}

/// Where the sun is: a direction, or two angles, or a place and a time.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SunDescription {
    /// Direction from the scene towards the sun, of any length.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub towards: Option<Numbers<Direction, 3>>,
    /// Angle above the horizon, in degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub elevation_deg: Option<Number<Elevation>>,
    /// Angle from north by way of east, in degrees; 180 (south) if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub azimuth_deg: Option<Number<Rotation>>,
    /// Latitude, north positive, in degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub latitude_deg: Option<Number<Latitude>>,
    /// Longitude, east positive, in degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub longitude_deg: Option<Number<Longitude>>,
    /// The day, as `2026-02-01`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub date: Option<String>,
    /// The time of day, as `14:30` or `14:30:15`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<String>,
    /// Hours by which that time is ahead of universal time; 0 if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub utc_offset_h: Option<Number<UtcOffset>>,
}

impl SunDescription {
    /// A sun at two angles.
    pub fn at(elevation_deg: Number<Elevation>, azimuth_deg: Number<Rotation>) -> Self {
        Self { elevation_deg: Some(elevation_deg), azimuth_deg: Some(azimuth_deg), ..Self::default() }
    }

    /// The position of the sun, and the unit direction towards it. y points north and x east.
    pub(super) fn position(&self, path: &KeyPath) -> Result<(SunPosition, Vec3A), KeyError> {
        let Self { towards, elevation_deg, azimuth_deg, latitude_deg, longitude_deg, date, time, utc_offset_h } = self;
        let angles = (elevation_deg.map(Number::get), azimuth_deg.map(Number::get));
        let place = (latitude_deg.map(Number::get), longitude_deg.map(Number::get), date, time);
        let position = match (towards.map(Numbers::get), angles, place, utc_offset_h) {
            (Some([x, y, z]), (None, None), (None, None, None, None), None) => {
                if x.hypot(y).hypot(z) <= 0.0 {
                    return Err(path.key("towards").error("is [0, 0, 0], but must not be zero"));
                }
                let elevation_deg = z.atan2(x.hypot(y)).to_degrees();
                SunPosition { elevation_deg, azimuth_deg: x.atan2(y).to_degrees().rem_euclid(360.0) }
            }
            (None, (Some(elevation_deg), azimuth_deg), (None, None, None, None), None) => {
                SunPosition { elevation_deg, azimuth_deg: azimuth_deg.unwrap_or(180.0) }
            }
            (None, (None, None), (Some(latitude_deg), Some(longitude_deg), Some(date), Some(time)), offset) => {
                let clock: Result<DateTime, _> = format!("{date}T{time}Z").parse();
                let clock = clock.map_err(|_| {
                    let reason = format!("is \"{time}\" on \"{date}\", but must be like \"14:30\" on \"2026-02-01\"");
                    path.key("time").error(reason)
                })?;
                let clock = DateTime { utc_offset_h: offset.map_or(0.0, Number::get), ..clock };
                sun_position(Place { latitude_deg, longitude_deg }, clock)
                    .map_err(|error| path.error(error.to_string()))?
            }
            _ => {
                return Err(path.error(
                    "needs either `towards`, or `elevation_deg` and `azimuth_deg`, or `latitude_deg`, \
                     `longitude_deg`, `date` and `time`",
                ));
            }
        };
        let [elevation, azimuth] = [position.elevation_deg, position.azimuth_deg].map(f64::to_radians);
        let direction = DVec3::new(elevation.cos() * azimuth.sin(), elevation.cos() * azimuth.cos(), elevation.sin());
        Ok((position, direction.as_vec3a()))
    }
}

/// An error about the sun at its path. The path already names the sun: `sky.sun elevation is -3°`.
pub(super) fn sun_error(path: &KeyPath, error: &SkyError) -> KeyError {
    path.error(error.to_string().trim_start_matches("sun "))
}
