//! Sun and sky as data.

use serde::{Deserialize, Serialize};
use snowblue_sky::TURBIDITY_RANGE;

use super::light::LampDescription;
use super::range::{Checked, DIRECTION, FRACTION, ROTATION, Range, unit_vector};
use super::value::{point, some_numbers, visible};
use crate::light::keys::SKY_SCALE;
use snowblue_base::KeyPath;

const TURBIDITY: Range = Range::new(TURBIDITY_RANGE.0, TURBIDITY_RANGE.1, "");
/// The elevation of the sun, or a latitude.
const ELEVATION: Range = Range::new(-90.0, 90.0, "deg");

/// Sun and sky.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum SkyDescription {
    /// A clear sky with its sun.
    Clear(ClearSkyDescription),
    /// An overcast sky.
    Overcast(OvercastSkyDescription),
}

impl SkyDescription {
    /// Number of lights of a scene that it is: sun and sky, or the sky alone.
    pub(crate) fn light_count(&self) -> usize {
        match self {
            Self::Clear(_) => 2,
            Self::Overcast(_) => 1,
        }
    }

    /// Whether the camera may see its sun.
    pub(super) fn has_visible_sun(&self) -> bool {
        match self {
            Self::Clear(clear) => clear.visible,
            Self::Overcast(_) => false,
        }
    }

    /// Checks the ranges of all values.
    pub(super) fn check(&self, path: &KeyPath) -> Checked {
        match self {
            Self::Clear(clear) => clear.check(path),
            Self::Overcast(overcast) => overcast.strength.check(path),
        }
    }
}

/// A clear sky with its sun, by the model of [`snowblue_sky`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClearSkyDescription {
    /// Where the sun is.
    pub sun: SunDescription,
    /// How much haze the air holds: 2 is very clear, 3 clear, 6 hazy.
    #[serde(default = "ClearSkyDescription::default_turbidity")]
    pub turbidity: f64,
    /// Reflectance of the ground below the sky, which brightens it; that of the scene's snow if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ground_albedo: Option<f64>,
    /// Multiplies sun and sky.
    #[serde(default = "one")]
    pub scale: f64,
    /// Whether the air lies over what is far away.
    #[serde(default)]
    pub aerial_perspective: bool,
    /// Whether they are visible to the camera.
    #[serde(default = "visible")]
    pub visible: bool,
}

impl ClearSkyDescription {
    /// A clear sky of turbidity 3.
    pub fn new(sun: SunDescription) -> Self {
        Self {
            sun,
            turbidity: Self::default_turbidity(),
            ground_albedo: None,
            scale: 1.0,
            aerial_perspective: false,
            visible: true,
        }
    }

    fn default_turbidity() -> f64 {
        3.0
    }

    fn check(&self, path: &KeyPath) -> Checked {
        self.sun.check(&path.key("sun"))?;
        TURBIDITY.check(&path.key("turbidity"), self.turbidity)?;
        if let Some(albedo) = self.ground_albedo {
            FRACTION.check(&path.key("ground_albedo"), albedo)?;
        }
        SKY_SCALE.check(&path.key("scale"), self.scale)
    }
}

/// An overcast sky.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OvercastSkyDescription {
    /// The shape of its spectrum.
    #[serde(flatten)]
    pub lamp: LampDescription,
    /// Its strength.
    #[serde(flatten)]
    pub strength: OvercastStrength,
    /// Whether it is visible to the camera.
    pub visible: bool,
}

/// The strength of an overcast sky.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum OvercastStrength {
    /// By the irradiance of level ground.
    Irradiance {
        /// Irradiance of level ground over 400–700 nm, in W/m².
        irradiance_w_m2: f64,
    },
    /// By the elevation of the sun behind the clouds.
    Sun {
        /// Where the sun is.
        sun: SunDescription,
    },
}

impl OvercastStrength {
    fn check(&self, path: &KeyPath) -> Checked {
        match self {
            Self::Irradiance { irradiance_w_m2 } => {
                Range::power("W/m²").check(&path.key("irradiance_w_m2"), *irradiance_w_m2)
            }
            Self::Sun { sun } => sun.check(&path.key("sun")),
        }
    }
}

/// The keys of an overcast sky without those of its spectrum.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct OvercastKeys {
    irradiance_w_m2: Option<f64>,
    sun: Option<SunDescription>,
    #[serde(default = "visible")]
    pub(crate) visible: bool,
}

impl OvercastKeys {
    /// The strength that they describe; none if there are both or neither.
    pub(crate) fn strength(&self) -> Option<OvercastStrength> {
        match (self.irradiance_w_m2, self.sun.clone()) {
            (Some(irradiance_w_m2), None) => Some(OvercastStrength::Irradiance { irradiance_w_m2 }),
            (None, Some(sun)) => Some(OvercastStrength::Sun { sun }),
            _ => None,
        }
    }
}

/// Where the sun is. In a scene y points north and x east.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "SunKeys", untagged)]
pub enum SunDescription {
    /// In a direction.
    Direction {
        /// Direction from the scene towards the sun, of any length.
        towards: [f64; 3],
    },
    /// By its angles.
    Angles {
        /// Angle above the horizon, in degrees.
        elevation_deg: f64,
        /// Angle from north by way of east, in degrees.
        azimuth_deg: f64,
    },
    /// As seen from a place at a time.
    Place {
        /// Latitude, north positive, in degrees.
        latitude_deg: f64,
        /// Longitude, east positive, in degrees.
        longitude_deg: f64,
        /// The day, as `2026-02-01`.
        date: String,
        /// The time of day, as `14:30` or `14:30:15`.
        time: String,
        /// Hours by which that time is ahead of universal time.
        utc_offset_h: f64,
    },
}

impl SunDescription {
    fn check(&self, path: &KeyPath) -> Checked {
        match self {
            Self::Direction { towards } => {
                let path = path.key("towards");
                DIRECTION.check_all(&path, towards)?;
                unit_vector(&path, point(*towards), "is [0, 0, 0], but must not be zero").map(drop)
            }
            Self::Angles { elevation_deg, azimuth_deg } => {
                ELEVATION.check(&path.key("elevation_deg"), *elevation_deg)?;
                ROTATION.check(&path.key("azimuth_deg"), *azimuth_deg)
            }
            Self::Place { latitude_deg, longitude_deg, utc_offset_h, .. } => {
                ELEVATION.check(&path.key("latitude_deg"), *latitude_deg)?;
                Range::new(-180.0, 180.0, "deg").check(&path.key("longitude_deg"), *longitude_deg)?;
                Range::new(-14.0, 14.0, "h").check(&path.key("utc_offset_h"), *utc_offset_h)
            }
        }
    }
}

/// The keys of the sun.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SunKeys {
    #[serde(default, deserialize_with = "some_numbers")]
    towards: Option<[f64; 3]>,
    elevation_deg: Option<f64>,
    azimuth_deg: Option<f64>,
    latitude_deg: Option<f64>,
    longitude_deg: Option<f64>,
    date: Option<String>,
    time: Option<String>,
    utc_offset_h: Option<f64>,
}

impl TryFrom<SunKeys> for SunDescription {
    type Error = &'static str;

    fn try_from(keys: SunKeys) -> Result<Self, &'static str> {
        let SunKeys { towards, elevation_deg, azimuth_deg, latitude_deg, longitude_deg, date, time, utc_offset_h } =
            keys;
        let is_placed = latitude_deg.is_some() || longitude_deg.is_some() || date.is_some() || time.is_some();
        match (towards, (elevation_deg, azimuth_deg), (latitude_deg, longitude_deg, date, time)) {
            (Some(towards), (None, None), _) if !is_placed && utc_offset_h.is_none() => Ok(Self::Direction { towards }),
            (None, (Some(elevation_deg), azimuth_deg), _) if !is_placed && utc_offset_h.is_none() => {
                Ok(Self::Angles { elevation_deg, azimuth_deg: azimuth_deg.unwrap_or(180.0) })
            }
            (None, (None, None), (Some(latitude_deg), Some(longitude_deg), Some(date), Some(time))) => {
                let utc_offset_h = utc_offset_h.unwrap_or(0.0);
                Ok(Self::Place { latitude_deg, longitude_deg, date, time, utc_offset_h })
            }
            _ => Err("needs either `towards`, or `elevation_deg` and `azimuth_deg`, or `latitude_deg`, \
                      `longitude_deg`, `date` and `time`"),
        }
    }
}

fn one() -> f64 {
    1.0
}
