//! Dominant wavelength and excitation purity: a colour as a mixture of white and one wavelength (CIE
//! 015:2018). Bohren (1983, "Colors of snow, frozen waterfalls, and icebergs") describes the blue of snow by them.

use crate::error::ColorError;
use crate::observer::Observer;
use crate::xyz::Chromaticity;

/// Ends of the spectral locus, in nm: beyond, chromaticity hardly changes.
const FIRST_NM: u32 = 380;
const LAST_NM: u32 = 700;

/// A colour as a mixture of white and light of one wavelength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DominantWavelength {
    /// The wavelength that has to be mixed with white to give the colour, in nm.
    pub wavelength_nm: f64,
    /// Distance of the colour from white over that of the spectral locus, 0–1.
    pub excitation_purity: f64,
}

impl DominantWavelength {
    /// The mixture of a chromaticity with a white, for an observer; none for white itself and for purples, which are
    /// no mixture of white and one wavelength.
    ///
    /// A colour halfway from white to the chromaticity of 480 nm:
    /// ```
    /// # use snowblue_color::{Observer, dominant::DominantWavelength, xyz::Chromaticity};
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
