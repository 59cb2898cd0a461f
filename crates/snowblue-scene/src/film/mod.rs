//! Size and exposure of an image, and the sensor that sees its light.

pub mod sensor;
pub mod white_balance;

use std::fmt;
use std::num::ParseFloatError;
use std::str::FromStr;

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use snowblue_base::{Count, Number, ParameterRange, quantities};
use snowblue_color::exposure::{AutoExposure, MAX_STOPS, factor, level_of_white, quantile};
use snowblue_color::{LinearRgb, ToneCurve};

use crate::film::sensor::UNIT_CD_M2;
use crate::film::white_balance::{PictureWhite, WhiteBalance};
use crate::values::{AnyOf, Notations, text};

quantities! {
    /// Pixels along a side of a picture.
    pub SidePixels = ParameterRange::new("pixels", 1.0, 16_384.0, "");
    /// Exposure in stops.
    pub Stops = ParameterRange::new("exposure", -MAX_STOPS, MAX_STOPS, "stops");
}

/// Size of an image in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImageSize {
    /// Pixels from left to right.
    pub width: u32,
    /// Pixels from top to bottom.
    pub height: u32,
}

impl ImageSize {
    /// Number of pixels.
    pub fn pixel_count(self) -> usize {
        self.width as usize * self.height as usize
    }
}

/// Size and exposure of an image.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FilmSettings {
    /// Number of columns of pixels.
    pub width: Count<SidePixels>,
    /// Number of rows of pixels.
    pub height: Count<SidePixels>,
    /// Exposure of a PNG.
    pub exposure: Exposure,
    /// Tone curve of a PNG.
    #[serde(with = "text")]
    #[schemars(with = "String")]
    pub tone: ToneCurve,
    /// The light that looks white.
    pub white: WhiteBalance,
}

impl Default for FilmSettings {
    fn default() -> Self {
        let Development { exposure, tone } = Development::default();
        Self { width: Count::of(1080), height: Count::of(1080), exposure, tone, white: WhiteBalance::default() }
    }
}

impl FilmSettings {
    /// Size of the image in pixels.
    pub fn size(&self) -> ImageSize {
        ImageSize { width: self.width.get(), height: self.height.get() }
    }

    /// Width over height.
    pub(crate) fn aspect(&self) -> f32 {
        let [width, height] = [self.width, self.height].map(|side| side.get() as f32);
        width / height
    }

    /// Exposure and tone curve of a PNG.
    pub fn development(&self) -> Development {
        Development { exposure: self.exposure, tone: self.tone }
    }
}

/// Exposure and tone curve that turn radiance into a picture for a display, such as a PNG. EXR files store radiance
/// without either.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Development {
    /// The factor by which radiance is multiplied.
    pub exposure: Exposure,
    /// The curve from exposed radiance to the range of the display.
    pub tone: ToneCurve,
}

/// What an EXR file keeps for a PNG that is made of it later.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PictureSettings {
    /// Exposure and tone curve. They may differ between parts of an image.
    pub development: Development,
    /// The light that looks white, and the light of the sky.
    pub white: PictureWhite,
}

impl From<Exposure> for Development {
    /// The exposure without a tone curve: levels are proportional to radiance up to white.
    fn from(exposure: Exposure) -> Self {
        Self { exposure, tone: ToneCurve::None }
    }
}

/// The fraction of all pixels that automatic exposure fits into the display's range. The rest are highlights.
const HIGHLIGHT_FRACTION: f64 = 0.99;
/// The fraction of the snow pixels that is displayed below the level of snow, which is the level of lit snow if any
/// snow is lit.
const SNOW_FRACTION: f64 = 0.9;

/// Displayed levels. A level of 1 is the display's white.
struct Levels {
    /// Level of snow in the sun.
    snow: f64,
    /// Level of the brightest pixels except highlights, in a picture without snow.
    highlights: f64,
}

impl Levels {
    /// The levels for a tone curve. With AgX, white surfaces are darker, so that they keep their contrast.
    fn of(tone: ToneCurve) -> Self {
        match tone {
            ToneCurve::Filmic | ToneCurve::None => Self { snow: 0.8, highlights: 0.9 },
            ToneCurve::Agx => Self { snow: 0.6, highlights: 0.75 },
        }
    }
}

/// Greatest ratio of the exposure factor of a picture with snow to the factor that fits its highlights. The limit
/// keeps a sky or a lit rim visible when the snow lies in the shade.
const MAX_OVER_HIGHLIGHTS: f64 = 2.0;

/// The factor between radiance and linear RGB in a PNG. EXR files store radiance without exposure.
#[derive(Debug, Clone, Copy, PartialEq, Default, JsonSchema)]
#[schemars(with = "AnyOf<String, Number<Stops>>")]
pub enum Exposure {
    /// The 90th percentile of the pixels that show snow gets the light that is displayed as white, at 0.8 (0.6 with
    /// AgX), or less light where its luminance is less than that of snow in the sun ([`level_of_white`]). At most, the
    /// 99th percentile of all pixels gets twice the light that is displayed as 0.9 (0.75); without snow it is displayed
    /// as 0.9. Pixels that show a lamp or the sun do not count.
    #[default]
    Auto,
    /// The factor is 2^stops. At 0 stops, a luminance of 1 (that of 1 W m⁻² sr⁻¹ of equal-energy light over
    /// 400–700 nm) is white.
    Stops(f64),
}

impl Exposure {
    /// The factor by which the radiance of pixels is multiplied for display without a tone curve. All pixels count
    /// alike.
    pub fn display_factor(self, pixels: impl Iterator<Item = LinearRgb>) -> f64 {
        Development::from(self).display_factor(pixels, std::iter::empty())
    }
}

impl Development {
    /// The factor by which radiance is multiplied before the tone curve. `pixels` are all counted pixels, and `snow`
    /// are the counted pixels that show snow.
    pub fn display_factor(
        self,
        pixels: impl Iterator<Item = LinearRgb>,
        snow: impl Iterator<Item = LinearRgb> + Clone,
    ) -> f64 {
        match self.exposure {
            Exposure::Stops(stops) => factor(stops),
            Exposure::Auto => {
                let levels = Levels::of(self.tone);
                let metering =
                    AutoExposure { fraction: HIGHLIGHT_FRACTION, level: self.tone.light_of(levels.highlights) };
                let of_highlights = metering.factor_of_any(pixels);
                let of_snow = quantile(snow.clone().map(LinearRgb::luminance), SNOW_FRACTION).and_then(|luminance| {
                    let level = self.tone.light_of(levels.snow) * level_of_white(luminance.max(0.0) * UNIT_CD_M2);
                    AutoExposure { fraction: SNOW_FRACTION, level }.factor_of_any(snow)
                });
                match (of_snow, of_highlights) {
                    (Some(of_snow), Some(of_highlights)) => of_snow.min(MAX_OVER_HIGHLIGHTS * of_highlights),
                    (of_snow, of_highlights) => of_snow.or(of_highlights).unwrap_or(1.0),
                }
            }
        }
    }
}

/// Stops, or `auto`.
impl fmt::Display for Exposure {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Auto => formatter.write_str("auto"),
            Self::Stops(stops) => write!(formatter, "{stops}"),
        }
    }
}

/// Parses the output of [`Display`](fmt::Display) to the same bits.
impl FromStr for Exposure {
    type Err = ParseFloatError;

    fn from_str(text: &str) -> Result<Self, ParseFloatError> {
        if text == "auto" { Ok(Self::Auto) } else { text.parse().map(Self::Stops) }
    }
}

impl Serialize for Exposure {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Auto => serializer.serialize_str("auto"),
            Self::Stops(stops) => serializer.serialize_f64(*stops),
        }
    }
}

impl<'de> Deserialize<'de> for Exposure {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Notations::<Stops, 0, _> {
            expected: "\"auto\" or a number of stops",
            number: Some(|stops| Self::Stops(stops.get())),
            word: Some(|word| match word {
                "auto" => Ok(Self::Auto),
                other => Err(format!("is \"{other}\", but must be \"auto\" or a number of stops")),
            }),
            list: None,
        })
    }
}
