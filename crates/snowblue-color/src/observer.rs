//! Standard observers: colour-matching functions, tabulated by the CIE.
//!
//! CIE 015:2018, *Colorimetry*, doi:10.25039/TR.015.2018.

use std::fmt;
use std::str::FromStr;
use std::sync::LazyLock;

use crate::curve::{self, Curve};
use crate::error::ColorError;
use crate::xyz::Xyz;

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
}
