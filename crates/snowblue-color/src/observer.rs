//! Standard eyes: colour-matching functions, tabulated by the CIE.
//!
//! CIE 015:2018, *Colorimetry*, doi:10.25039/TR.015.2018.

use std::sync::LazyLock;

use crate::curve::{self, Curve};
use crate::error::ColorError;
use crate::xyz::Xyz;

static CIE_1931: LazyLock<[Curve; 3]> =
    LazyLock::new(|| curve::parse(include_str!("../data/cmf_1931_2deg_1nm.csv"), "wavelength_nm,x_bar,y_bar,z_bar"));

/// A standard eye.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum Observer {
    /// The CIE 1931 observer, for fields of view of 1–4°; sRGB and CIE 1931 chromaticities are defined by it.
    #[default]
    Cie1931,
}

impl Observer {
    /// Colour-matching functions x̄, ȳ, z̄: tristimulus values of one unit of power at one wavelength.
    ///
    /// The eye is most sensitive to yellowish green:
    /// ```
    /// # use snowblue_color::Observer;
    /// let sensitivity = |wavelength_nm| Observer::Cie1931.matching(wavelength_nm).map(|matching| matching.y);
    /// assert!(sensitivity(555.0)? > 20.0 * sensitivity(450.0)?);
    /// assert!(sensitivity(555.0)? > 200.0 * sensitivity(700.0)?);
    /// # Ok::<(), snowblue_color::ColorError>(())
    /// ```
    ///
    /// # Errors
    /// Outside the table, 360–830 nm.
    pub fn matching(self, wavelength_nm: f64) -> Result<Xyz, ColorError> {
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

    /// The name in full.
    pub fn name(self) -> &'static str {
        match self {
            Observer::Cie1931 => "CIE 1931 2°",
        }
    }

    fn curves(self) -> &'static [Curve; 3] {
        match self {
            Observer::Cie1931 => &CIE_1931,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows as printed in CIE 015:2018 and in Wyszecki & Stiles 2000, *Color Science*, table I(3.3.1).
    #[test]
    fn table_keeps_printed_values() {
        for curve in Observer::Cie1931.curves() {
            assert_eq!(curve.count(), 471);
            assert_eq!(curve.range_nm(), 360.0..=830.0);
        }
        let printed = [
            (360.0, Xyz { x: 0.0001299, y: 0.000003917, z: 0.0006061 }),
            (450.0, Xyz { x: 0.3362, y: 0.038, z: 1.77211 }),
            (600.0, Xyz { x: 1.0622, y: 0.631, z: 0.0008 }),
            (830.0, Xyz { x: 0.000001251141, y: 0.00000045181, z: 0.0 }),
        ];
        for (wavelength_nm, matching) in printed {
            assert_eq!(Observer::Cie1931.matching(wavelength_nm), Ok(matching));
        }
    }

    /// The three functions were scaled to the same area, so that the light of equal power is white.
    #[test]
    fn areas_are_equal() {
        let matching = (360..=830).map(|nm| Observer::Cie1931.matching(f64::from(nm)).unwrap());
        let area = matching.fold(Xyz::default(), |sum, matching| sum + matching);
        assert!((area.y - 106.857).abs() < 1e-3, "{area:?}");
        // The published functions are rounded: their areas differ by 3 parts in 10⁴.
        assert!((area.x / area.y - 1.0).abs() < 4e-4 && (area.z / area.y - 1.0).abs() < 4e-4, "{area:?}");
    }

    #[test]
    fn a_wavelength_outside_is_refused() {
        let message = Observer::Cie1931.matching(359.5).unwrap_err().to_string();
        assert_eq!(message, "wavelength is 359.5 nm, but must lie in 360–830 nm for the CIE 1931 2° observer");
    }
}
