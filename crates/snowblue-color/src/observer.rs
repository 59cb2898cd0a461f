//! Standard observers: colour-matching functions, tabulated by the CIE, and dominant wavelengths along their spectral
//! locus.
//!
//! CIE 015:2018, *Colorimetry*, doi:10.25039/TR.015.2018. Dominant wavelength and excitation purity give a colour as a
//! mixture of white and one wavelength; Bohren (1983, "Colors of snow, frozen waterfalls, and icebergs") describes the
//! blue of snow by them.

use std::fmt;
use std::str::FromStr;
use std::sync::LazyLock;

use crate::curve::{self, Curve};
use crate::error::ColorError;
use crate::xyz::{Chromaticity, Xyz};

const HEADER: &str = "wavelength_nm,x_bar,y_bar,z_bar";
static CIE_1931: LazyLock<[Curve; 3]> =
    LazyLock::new(|| curve::parse(include_str!("../data/cmf_1931_2deg_1nm.csv"), HEADER));
static CIE_1964: LazyLock<[Curve; 3]> =
    LazyLock::new(|| curve::parse(include_str!("../data/cmf_1964_10deg_1nm.csv"), HEADER));

/// A CIE standard observer. Formats as its year, and parses from its year or its field of view in degrees:
///
/// ```
/// # use snowblue_color::Observer;
/// assert_eq!("10".parse::<Observer>()?.to_string(), "1964");
/// # Ok::<(), snowblue_color::ColorError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum Observer {
    /// The CIE 1931 2° observer, for fields of view of 1–4°. It defines sRGB and CIE 1931 chromaticities.
    #[default]
    Cie1931,
    /// The CIE 1964 10° observer, for fields of view above 4°, such as a wall of snow. RGB spaces are not defined for
    /// it.
    Cie1964,
}

impl Observer {
    /// All observers.
    pub const ALL: [Observer; 2] = [Observer::Cie1931, Observer::Cie1964];

    /// Colour-matching functions x̄, ȳ, z̄: tristimulus values of one unit of power at one wavelength.
    ///
    /// Vision is most sensitive to yellowish green:
    /// ```
    /// # use snowblue_color::Observer;
    /// let sensitivity = |wavelength_nm| Observer::Cie1931.color_matching(wavelength_nm).map(|matching| matching.y);
    /// assert!(sensitivity(555.0)? > 20.0 * sensitivity(450.0)?);
    /// assert!(sensitivity(555.0)? > 200.0 * sensitivity(700.0)?);
    /// # Ok::<(), snowblue_color::ColorError>(())
    /// ```
    ///
    /// # Errors
    /// If the wavelength lies outside 360–830 nm.
    pub fn color_matching(self, wavelength_nm: f64) -> Result<Xyz, ColorError> {
        let [x_bar, y_bar, z_bar] = self.curves();
        match (x_bar.at(wavelength_nm), y_bar.at(wavelength_nm), z_bar.at(wavelength_nm)) {
            (Some(x), Some(y), Some(z)) => Ok(Xyz { x, y, z }),
            _ => Err(ColorError::OutsideTable {
                wavelength_nm,
                first_nm: *x_bar.range_nm().start(),
                last_nm: *x_bar.range_nm().end(),
                table: format!("the {} observer", self.name()),
            }),
        }
    }

    /// The full name, such as `CIE 1931 2°`.
    pub fn name(self) -> &'static str {
        match self {
            Observer::Cie1931 => "CIE 1931 2°",
            Observer::Cie1964 => "CIE 1964 10°",
        }
    }

    fn curves(self) -> &'static [Curve; 3] {
        match self {
            Observer::Cie1931 => &CIE_1931,
            Observer::Cie1964 => &CIE_1964,
        }
    }
}

impl FromStr for Observer {
    type Err = ColorError;

    fn from_str(name: &str) -> Result<Observer, ColorError> {
        match name {
            "1931" | "2" => Ok(Observer::Cie1931),
            "1964" | "10" => Ok(Observer::Cie1964),
            _ => Err(ColorError::UnknownObserver { name: name.to_owned() }),
        }
    }
}

impl fmt::Display for Observer {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Observer::Cie1931 => "1931",
            Observer::Cie1964 => "1964",
        })
    }
}

/// Ends of the spectral locus, in nm. Beyond them chromaticity hardly changes.
const FIRST_NM: u32 = 380;
const LAST_NM: u32 = 700;

/// A colour as a mixture of white and light of one wavelength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DominantWavelength {
    /// The wavelength that has to be mixed with white to give the colour, in nm.
    pub wavelength_nm: f64,
    /// Ratio of the distance of the colour from white to the distance of the spectral locus from white, 0–1.
    pub excitation_purity: f64,
}

impl DominantWavelength {
    /// The mixture of a chromaticity with a white, for an observer; none for white itself and for purples, which are
    /// no mixture of white and one wavelength.
    ///
    /// A colour halfway from white to the chromaticity of 480 nm:
    /// ```
    /// # use snowblue_color::{Chromaticity, DominantWavelength, Observer};
    /// let white = Chromaticity { x: 1.0 / 3.0, y: 1.0 / 3.0 };
    /// let pure = Observer::Cie1931.color_matching(480.0)?.chromaticity();
    /// let half = Chromaticity { x: 0.5 * (white.x + pure.x), y: 0.5 * (white.y + pure.y) };
    /// let found = DominantWavelength::of(half, white, Observer::Cie1931)?.unwrap();
    /// assert!((found.wavelength_nm - 480.0).abs() < 0.1 && (found.excitation_purity - 0.5).abs() < 1e-3);
    /// # Ok::<(), snowblue_color::ColorError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Never for the observers of this crate, whose tables cover 380–700 nm.
    pub fn of(color: Chromaticity, white: Chromaticity, observer: Observer) -> Result<Option<Self>, ColorError> {
        let along = [color.x - white.x, color.y - white.y];
        let length = along[0].hypot(along[1]);
        if length < 1e-9 {
            return Ok(None);
        }
        // Coordinates along the line from white through the colour, and across it.
        let place = |wavelength_nm: u32| -> Result<[f64; 2], ColorError> {
            let locus = observer.color_matching(f64::from(wavelength_nm))?.chromaticity();
            let [x, y] = [locus.x - white.x, locus.y - white.y];
            Ok([(x * along[0] + y * along[1]) / length, (x * along[1] - y * along[0]) / length])
        };
        let mut before = place(FIRST_NM)?;
        for wavelength_nm in FIRST_NM + 1..=LAST_NM {
            let after = place(wavelength_nm)?;
            if (before[1] < 0.0) != (after[1] < 0.0) {
                let share = before[1] / (before[1] - after[1]);
                let distance = before[0] + share * (after[0] - before[0]);
                if distance > 0.0 {
                    return Ok(Some(Self {
                        wavelength_nm: f64::from(wavelength_nm - 1) + share,
                        excitation_purity: length / distance,
                    }));
                }
            }
            before = after;
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows as printed in CIE 015:2018 and in Wyszecki & Stiles 2000, *Color Science*, table I(3.3.1).
    #[test]
    fn tables_contain_published_values() {
        for curve in Observer::ALL.into_iter().flat_map(Observer::curves) {
            assert_eq!(curve.count(), 471);
            assert_eq!(curve.range_nm(), 360.0..=830.0);
        }
        let wide = Xyz { x: 0.370_702, y: 0.089_456, z: 1.994_8 };
        assert_eq!(Observer::Cie1964.color_matching(450.0), Ok(wide));
        let printed = [
            (360.0, Xyz { x: 0.0001299, y: 0.000003917, z: 0.0006061 }),
            (450.0, Xyz { x: 0.3362, y: 0.038, z: 1.77211 }),
            (600.0, Xyz { x: 1.0622, y: 0.631, z: 0.0008 }),
            (830.0, Xyz { x: 0.000001251141, y: 0.00000045181, z: 0.0 }),
        ];
        for (wavelength_nm, matching) in printed {
            assert_eq!(Observer::Cie1931.color_matching(wavelength_nm), Ok(matching));
        }
    }

    /// The three functions are scaled to equal areas, so that equal power is white.
    #[test]
    fn areas_are_equal() {
        for (observer, luminous) in [(Observer::Cie1931, 106.857), (Observer::Cie1964, 116.662)] {
            let matching = (360..=830).map(|nm| observer.color_matching(f64::from(nm)).unwrap());
            let area = matching.fold(Xyz::default(), |sum, matching| sum + matching);
            assert!((area.y - luminous).abs() < 1e-3, "{area:?}");
            // The published functions are rounded: their areas differ by 3e-4.
            assert!((area.x / area.y - 1.0).abs() < 4e-4 && (area.z / area.y - 1.0).abs() < 4e-4, "{area:?}");
        }
    }

    #[test]
    fn names_are_years_or_degrees() {
        for (names, observer) in [(["1931", "2"], Observer::Cie1931), (["1964", "10"], Observer::Cie1964)] {
            assert!(names.iter().all(|name| name.parse() == Ok(observer)));
            assert_eq!(observer.to_string(), names[0]);
        }
        let message = "1978".parse::<Observer>().unwrap_err().to_string();
        assert_eq!(message, "observer is `1978`, but must be 1931 (or 2, for 2°) or 1964 (or 10, for 10°)");
    }

    #[test]
    fn a_wavelength_outside_the_table_is_rejected() {
        let message = Observer::Cie1931.color_matching(359.5).unwrap_err().to_string();
        assert_eq!(message, "wavelength is 359.5 nm, but must lie in 360–830 nm for the CIE 1931 2° observer");
    }

    #[test]
    fn colours_of_the_locus_are_pure_and_purples_have_none() {
        let white = Chromaticity { x: 0.3127, y: 0.3290 };
        for wavelength_nm in [440.0, 470.5, 520.0, 577.0, 610.0] {
            let pure = Observer::Cie1931.color_matching(wavelength_nm).unwrap().chromaticity();
            let found = DominantWavelength::of(pure, white, Observer::Cie1931).unwrap().unwrap();
            // The locus is straight between whole nanometres.
            assert!((found.wavelength_nm - wavelength_nm).abs() < 0.2, "{found:?}");
            assert!((found.excitation_purity - 1.0).abs() < 2e-3, "{found:?}");
        }
        let purple = Chromaticity { x: 0.32, y: 0.15 };
        assert_eq!(DominantWavelength::of(purple, white, Observer::Cie1931).unwrap(), None);
        assert_eq!(DominantWavelength::of(white, white, Observer::Cie1931).unwrap(), None);
    }
}
