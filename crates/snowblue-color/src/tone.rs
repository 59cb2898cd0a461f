//! Tone curves: from exposed light, without an upper limit, to the range of a display; also as a shader in GLSL.
//!
//! All curves map black to black and keep middle grey, 18 % of white. They end with
//! [gamut mapping](LinearRgb::displayable), which keeps luminance, and hue nearly.
//!
//! **`filmic`** keeps luminance Y up to a knee t = 0.8, and compresses greater luminances, with a continuous slope:
//!
//! > Y′ = 1 − (1 − t)² / (Y + 1 − 2t).
//!
//! This is the shoulder of *Khronos PBR Neutral* (Khronos Group 2024, *PBR Neutral Tone Mapper*), whose knee is at
//! 0.76 of the brightest channel. Here it applies to luminance, as E. Reinhard, M. Stark, P. Shirley & J. Ferwerda
//! (2002, *Photographic tone reproduction for digital images*, ACM Transactions on Graphics 21(3), 267–276,
//! doi:10.1145/566654.566575) recommend: chromaticity does not change, so that blue stays blue, and the order of
//! luminances is kept. Curves for each channel, such as the curves of J. Hable (2010, *Filmic tonemapping operators*)
//! and K. Narkowicz (2015, *ACES filmic tone mapping curve*), turn bright blue towards cyan. They also compress the
//! tones of lit snow, which lie near white.
//!
//! **`agx`** is AgX by T. Sobotka (2022, <https://github.com/sobotka/AgX>), the default of Blender, in its first form
//! for sRGB. The primaries are moved inwards, each channel is encoded as its logarithm from 10 stops below to 6.5
//! above middle grey, a sigmoid gives the code value for a display of exponent 2.2, and the primaries are moved
//! outwards again. Bright colours lose saturation. Light is scaled by 0.79 before AgX, so that middle grey is kept:
//! AgX itself shows 18 % as 22 %.

use std::fmt;
use std::str::FromStr;

use crate::error::ColorError;
use crate::gamut::{CONE_SLOPES, HUE_WEIGHT, PRIMARY_LUMINANCES, STEPS};
use crate::matrix::{Matrix, Vector, inverse, product};
use crate::oklab::ROOTS_TO_LAB;
use crate::rgb::LinearRgb;

/// A tone curve. Parses from its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum ToneCurve {
    /// `filmic`: a straight line with a shoulder below white, on luminance.
    #[default]
    Filmic,
    /// `agx`: low contrast over 16.5 stops, with pale highlights.
    Agx,
    /// `none`: light is shown unchanged up to white.
    None,
}

/// Greatest luminance that [`ToneCurve::Filmic`] shows unchanged.
const KNEE: f64 = 0.8;

/// Number of bisections in the search for the logarithm of a level of light.
const BISECTIONS: usize = 100;

impl ToneCurve {
    /// All curves.
    pub const ALL: [Self; 3] = [Self::Filmic, Self::Agx, Self::None];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Filmic => "filmic",
            Self::Agx => "agx",
            Self::None => "none",
        }
    }

    /// The displayable colour of exposed light.
    ///
    /// Light that is brighter than white keeps its order:
    /// ```
    /// # use snowblue_color::{LinearRgb, ToneCurve};
    /// let [white, glint] = [1.0, 4.0].map(|level| LinearRgb { r: level, g: level, b: level });
    /// assert!((ToneCurve::Filmic.displayed(white).g - 0.9).abs() < 1e-12);
    /// assert!((ToneCurve::Filmic.displayed(glint).g - 0.9882).abs() < 1e-4);
    /// assert_eq!(ToneCurve::None.displayed(glint), white);
    /// ```
    #[must_use]
    pub fn displayed(self, light: LinearRgb) -> LinearRgb {
        let toned = match self {
            Self::Filmic => {
                let luminance = light.luminance();
                if luminance > KNEE { light * (shoulder(luminance) / luminance) } else { light }
            }
            Self::Agx => agx(light.into_gamut()),
            Self::None => light,
        };
        toned.displayable()
    }

    /// The level of grey light that is displayed as a level between 0 and 1.
    ///
    /// ```
    /// # use snowblue_color::ToneCurve;
    /// assert!((ToneCurve::Filmic.light_of(0.9) - 1.0).abs() < 1e-12);
    /// ```
    #[must_use]
    pub fn light_of(self, displayed: f64) -> f64 {
        if self == Self::None {
            return displayed;
        }
        let is_below = |level: f64| self.displayed(LinearRgb { r: level, g: level, b: level }).luminance() < displayed;
        let (mut low, mut high) = (-64.0_f64, 64.0_f64);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if is_below(middle.exp2()) { low = middle } else { high = middle }
        }
        high.exp2()
    }
}

/// The compressed luminance for a luminance above the knee.
fn shoulder(luminance: f64) -> f64 {
    1.0 - (1.0 - KNEE) * (1.0 - KNEE) / (luminance + 1.0 - 2.0 * KNEE)
}

/// From linear sRGB to primaries that are moved inwards.
const INSET: Matrix = [
    [0.842_479_062_253_094, 0.078_433_599_999_999_2, 0.079_223_745_147_764_3],
    [0.042_328_242_261_012_3, 0.878_468_636_469_772, 0.079_166_127_460_543_4],
    [0.042_375_654_905_705_1, 0.078_433_6, 0.879_142_973_793_104],
];
const OUTSET: Matrix = inverse(INSET);

/// Middle grey, and the stops below and above it that are encoded.
const MIDDLE_GREY: f64 = 0.18;
const STOPS_BELOW: f64 = 10.0;
const STOPS_ABOVE: f64 = 6.5;
/// Code value of middle grey, slope of the sigmoid at middle grey, and powers of the sigmoid below and above.
const PIVOT: f64 = 0.5;
const SLOPE: f64 = 2.0;
const TOE_POWER: f64 = 3.0;
const SHOULDER_POWER: f64 = 3.25;
/// Exponent of the display.
const DISPLAY_EXPONENT: f64 = 2.2;
/// Scale of light at which 18 % is displayed as 18 %.
const AGX_SCALE: f64 = 0.789_247_9;

/// AgX of light within sRGB. The result may lie outside of sRGB for saturated colours.
fn agx(LinearRgb { r, g, b }: LinearRgb) -> LinearRgb {
    let inset = product(INSET, [r, g, b].map(|channel| channel * AGX_SCALE));
    let codes = product(OUTSET, inset.map(code_of));
    let [r, g, b] = codes.map(|code| code.abs().powf(DISPLAY_EXPONENT).copysign(code));
    LinearRgb { r, g, b }
}

/// The code value of a channel: a sigmoid of its logarithm through (0, 0), the pivot and (1, 1).
fn code_of(channel: f64) -> f64 {
    const RANGE: f64 = STOPS_BELOW + STOPS_ABOVE;
    const PIVOT_PLACE: f64 = STOPS_BELOW / RANGE;
    let place = (((channel / MIDDLE_GREY).log2() + STOPS_BELOW) / RANGE).clamp(0.0, 1.0);
    let (end, height, power) = if place < PIVOT_PLACE {
        (PIVOT_PLACE, PIVOT, TOE_POWER)
    } else {
        (1.0 - PIVOT_PLACE, 1.0 - PIVOT, SHOULDER_POWER)
    };
    // u / (1 + u^p)^(1/p), scaled so that its value at the end is the height.
    let scale = (height.powf(-power) - (SLOPE * end).powf(-power)).powf(-1.0 / power);
    let steep = SLOPE * (place - PIVOT_PLACE).abs();
    let away = steep / (1.0 + (steep / scale).powf(power)).powf(1.0 / power);
    PIVOT + away.copysign(place - PIVOT_PLACE)
}

/// Its name.
impl fmt::Display for ToneCurve {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

impl FromStr for ToneCurve {
    type Err = ColorError;

    fn from_str(name: &str) -> Result<Self, ColorError> {
        Self::ALL.into_iter().find(|curve| curve.name() == name).ok_or_else(|| ColorError::UnknownToneCurve {
            name: name.to_owned(),
            known: Self::ALL.map(Self::name).join(", "),
        })
    }
}

/// GLSL ES 3.0 of two functions, up to single precision. `vec3 display(vec3 colour)` gives the code values of linear
/// sRGB for a display, as [`Srgb8::encode`](crate::Srgb8::encode) of the
/// [`displayable`](crate::LinearRgb::displayable) colour. `vec3 filmic(vec3 light)` is the curve
/// [`Filmic`](crate::ToneCurve::Filmic), to be applied before `display`.
#[must_use]
pub fn display_glsl() -> String {
    let [red, green, blue] = CONE_SLOPES.map(numbers);
    let [_, to_a, to_b] = ROOTS_TO_LAB.map(numbers);
    format!(
        "const vec3 PRIMARY_LUMINANCES = vec3({});\n\
         const mat3 CONE_SLOPES = mat3({red}, {green}, {blue});\n\
         const vec3 ROOTS_TO_A = vec3({to_a});\n\
         const vec3 ROOTS_TO_B = vec3({to_b});\n\
         const float HUE_WEIGHT = {HUE_WEIGHT:?};\n\
         const int STEPS = {STEPS};\n\
         const float KNEE = {KNEE:?};\n\
         {}",
        numbers(PRIMARY_LUMINANCES),
        include_str!("display.glsl"),
    )
}

/// Numbers with slightly more digits than single precision.
fn numbers([a, b, c]: Vector) -> String {
    format!("{a:.9}, {b:.9}, {c:.9}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oklab::Oklab;

    fn grey(level: f64) -> LinearRgb {
        LinearRgb { r: level, g: level, b: level }
    }

    /// Hue in Oklab, in degrees.
    fn hue_deg(colour: LinearRgb) -> f64 {
        Oklab::from_xyz(colour.xyz()).hue_deg()
    }

    /// Linear light of blue snow, from pale light to light through a metre of snow, whose red lies outside of sRGB.
    const BLUES: [LinearRgb; 4] = [
        LinearRgb { r: 0.55, g: 0.75, b: 1.0 },
        LinearRgb { r: 0.25, g: 0.5, b: 1.0 },
        LinearRgb { r: 0.05, g: 0.3, b: 1.0 },
        LinearRgb { r: -0.1, g: 0.25, b: 1.0 },
    ];

    #[test]
    fn black_stays_black_and_middle_grey_is_kept() {
        for curve in ToneCurve::ALL {
            for dark in [grey(0.0), LinearRgb { r: -1.0, g: 0.0, b: 0.1 }] {
                let LinearRgb { r, g, b } = curve.displayed(dark);
                assert!([r, g, b].iter().all(|channel| channel.abs() < 1e-12), "{curve}: {r} {g} {b}");
            }
            let LinearRgb { r, g, b } = curve.displayed(grey(MIDDLE_GREY));
            // The rows of the published inset matrix sum to 1 within 1.4e-4.
            assert!([r, g, b].iter().all(|channel| (channel - MIDDLE_GREY).abs() < 1e-4), "{curve}: {r} {g} {b}");
        }
    }

    #[test]
    fn luminance_grows_with_light_and_ends_at_white() {
        for curve in ToneCurve::ALL {
            for colour in BLUES.into_iter().chain([grey(1.0), LinearRgb { r: 1.0, g: 0.4, b: 0.1 }]) {
                let displayed = (-140..80).map(|step| curve.displayed(colour * (0.1 * f64::from(step)).exp2()));
                let levels: Vec<f64> = displayed.map(LinearRgb::luminance).collect();
                for pair in levels.windows(2) {
                    // AgX clips each channel separately, 6.5 stops above middle grey. Luminance may decrease there by
                    // 1e-8.
                    assert!(pair[1] >= pair[0] - 1e-7, "{curve}: {pair:?}");
                }
                let last = levels[levels.len() - 1];
                assert!((0.98..1.0 + 1e-12).contains(&last), "{curve}: {last}");
            }
        }
    }

    /// The mapping into the gamut shifts hue by up to 7.4°, near white. Clipping each channel turns blue to
    /// cyan.
    #[test]
    fn blue_keeps_its_hue() {
        for (curve, most_deg) in [(ToneCurve::None, 8.0), (ToneCurve::Filmic, 8.0), (ToneCurve::Agx, 12.0)] {
            let mut greatest_deg = 0.0_f64;
            for blue in BLUES {
                for stops in [-3.0, -1.0, 0.0, 0.5, 1.0, 1.5] {
                    let exposed = blue * f64::exp2(stops);
                    let shown = curve.displayed(exposed);
                    if Oklab::from_xyz(shown.xyz()).chroma() > 0.02 {
                        greatest_deg = greatest_deg.max((hue_deg(shown) - hue_deg(exposed)).abs());
                    }
                }
            }
            assert!(greatest_deg < most_deg, "{curve}: {greatest_deg}°");
        }
        let LinearRgb { r, g, b } = BLUES[1] * f64::exp2(1.0);
        let clipped = LinearRgb { r: r.min(1.0), g: g.min(1.0), b: b.min(1.0) };
        let shift_deg = hue_deg(clipped) - hue_deg(BLUES[1]);
        assert!(shift_deg < -40.0, "{shift_deg}°");
    }

    /// Below the knee a displayable colour does not change. Above the knee its chromaticity does not change.
    #[test]
    fn filmic_changes_luminance_alone() {
        let pale = BLUES[0];
        assert_eq!(ToneCurve::Filmic.displayed(pale), pale);
        let bright = pale * (0.95 / pale.luminance());
        let toned = bright * (shoulder(0.95) / 0.95);
        assert_eq!(ToneCurve::Filmic.displayed(bright), toned.displayable());
        // The slope is continuous at the knee.
        let slope = (shoulder(KNEE + 1e-6) - shoulder(KNEE)) / 1e-6;
        assert!((shoulder(KNEE) - KNEE).abs() < 1e-12 && (slope - 1.0).abs() < 1e-4, "{slope}");
    }

    /// Values of the polynomial that B. Wrensch (2023, *Minimal AgX implementation*) fitted to AgX, with a mean
    /// square error of 3.7e-6. The tolerance is three times the root of this error.
    #[test]
    fn agx_is_near_its_published_fit() {
        for step in 1..20 {
            let x = 0.05 * f64::from(step);
            let fit = ((((((15.5 * x - 40.14) * x + 31.96) * x) - 6.868) * x + 0.4298) * x + 0.1191) * x - 0.00232;
            let light = MIDDLE_GREY * (x * (STOPS_BELOW + STOPS_ABOVE) - STOPS_BELOW).exp2();
            let code = code_of(light);
            assert!((code - fit).abs() < 6e-3, "{x}: {code} {fit}");
        }
        assert!(code_of(0.0).abs() < 1e-12 && (code_of(100.0) - 1.0).abs() < 1e-12);
        assert!((code_of(MIDDLE_GREY) - PIVOT).abs() < 1e-12);
    }

    #[test]
    fn the_light_of_a_level_is_displayed_as_it() {
        for curve in ToneCurve::ALL {
            for level in [1e-3, 0.18, 0.8, 0.9, 0.99] {
                let displayed = curve.displayed(grey(curve.light_of(level))).luminance();
                assert!((displayed - level).abs() < 1e-9, "{curve}: {displayed} {level}");
            }
        }
    }

    #[test]
    fn names_parse() {
        for curve in ToneCurve::ALL {
            assert_eq!(curve.to_string().parse(), Ok(curve));
        }
        let message = "hable".parse::<ToneCurve>().unwrap_err().to_string();
        assert_eq!(message, "tone curve is `hable`, but must be one of filmic, agx, none");
    }

    #[test]
    fn the_constants_of_the_shader_are_those_of_the_crate() {
        let shader = display_glsl();
        for line in [
            "const vec3 PRIMARY_LUMINANCES = vec3(0.212639006, 0.715168679, 0.072192315);",
            "const vec3 ROOTS_TO_A = vec3(1.977998495, -2.428592205, 0.450593710);",
            "const float HUE_WEIGHT = 4.0;",
            "const int STEPS = 2;",
            "const float KNEE = 0.8;",
        ] {
            assert!(shader.contains(line), "{shader}");
        }
    }
}
