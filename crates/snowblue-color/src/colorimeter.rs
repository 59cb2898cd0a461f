//! From spectra to tristimulus values, with weights computed once.
//!
//! X = Σ v E x̄ / Σ E ȳ, and likewise Y and Z, over the given wavelengths (CIE 015:2018, with k = 1 / Σ E ȳ): v is the
//! spectrum (a ratio to the bare light), E the power of the illuminant, and x̄ ȳ z̄ are the colour-matching functions.

use crate::error::ColorError;
use crate::illuminant::Illuminant;
use crate::observer::Observer;
use crate::xyz::Xyz;

/// Range of the sum over a measured spectrum, in nm, and its step unless the spectrum has finer steps.
const FIRST_NM: f64 = 400.0;
const LAST_NM: f64 = 700.0;
const GRID_STEP_NM: f64 = 10.0;
/// Widest step of a measured spectrum within that range, in nm.
const WIDEST_STEP_NM: f64 = 20.0;
/// Wavelengths closer than this are equal, in nm: far below any step, far above rounding.
const TOLERANCE_NM: f64 = 1e-6;

/// Converts spectra on fixed wavelengths to tristimulus values, for one observer and one illuminant.
///
/// The bare light has Y = 1 and keeps its own chromaticity:
/// ```
/// # use snowblue_color::{Colorimeter, Illuminant, Observer};
/// let lamp = Colorimeter::new(Observer::Cie1931, Illuminant::A, &[450.0, 550.0, 650.0])?;
/// let bare = lamp.xyz(&[1.0, 1.0, 1.0]);
/// assert!((bare.y - 1.0).abs() < 1e-15);
/// assert!(bare.x > bare.z);
/// # Ok::<(), snowblue_color::ColorError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Colorimeter {
    wavelengths_nm: Vec<f64>,
    weights: Vec<Xyz>,
}

impl Colorimeter {
    /// Computes the weights for spectra on these wavelengths, in nm.
    ///
    /// The sum approximates an integral only if the wavelengths are evenly spaced.
    ///
    /// # Errors
    /// If the wavelengths do not increase or lie outside a table, or if X, Y or Z of the bare light is 0.
    pub fn new(observer: Observer, illuminant: Illuminant, wavelengths_nm: &[f64]) -> Result<Colorimeter, ColorError> {
        for pair in wavelengths_nm.windows(2) {
            if pair[1] <= pair[0] {
                return Err(ColorError::NotIncreasing { wavelength_nm: pair[1], previous_nm: pair[0] });
            }
        }
        let mut weights = Vec::with_capacity(wavelengths_nm.len());
        for &wavelength_nm in wavelengths_nm {
            weights.push(observer.color_matching(wavelength_nm)? * illuminant.relative_power(wavelength_nm)?);
        }
        let Xyz { x, y, z } = sum(weights.iter().copied());
        if x <= 0.0 || y <= 0.0 || z <= 0.0 {
            return Err(ColorError::NoWhite { x, y, z, count: wavelengths_nm.len() });
        }
        for weight in &mut weights {
            *weight = *weight * y.recip();
        }
        Ok(Colorimeter { wavelengths_nm: wavelengths_nm.to_vec(), weights })
    }

    /// Computes the weights for a measured spectrum: on wavelengths of any steps up to 20 nm that cover 400–700 nm.
    /// Values outside have no weight.
    ///
    /// The sum runs over 400, 410, … 700 nm, on which the spectrum is interpolated linearly. A spectrum in equal
    /// steps of at most 10 nm that include 400 and 700 nm is summed as it is, so that no detail is lost; X, Y and Z
    /// are then scaled such that X, Y and Z of the bare light equal their values on 400, 410, … 700 nm. A constant
    /// spectrum therefore has the chromaticity of the light whatever its wavelengths are.
    ///
    /// ```
    /// # use snowblue_color::{Colorimeter, Illuminant, Observer};
    /// let white = |wavelengths_nm: &[f64]| {
    ///     Colorimeter::for_spectrum(Observer::Cie1931, Illuminant::D65, wavelengths_nm).map(|light| light.white())
    /// };
    /// let steps = |nm: u32| (0..=300 / nm).map(|i| f64::from(400 + i * nm)).collect::<Vec<_>>();
    /// let (tens, twenties) = (white(&steps(10))?, white(&steps(20))?);
    /// assert!((tens.x - twenties.x).abs() < 1e-15 && (tens.z - twenties.z).abs() < 1e-15);
    /// # Ok::<(), snowblue_color::ColorError>(())
    /// ```
    ///
    /// # Errors
    /// If the wavelengths do not increase, do not cover 400–700 nm or have a wider step there, or if the illuminant's
    /// table does not cover 400–700 nm.
    pub fn for_spectrum(
        observer: Observer,
        illuminant: Illuminant,
        wavelengths_nm: &[f64],
    ) -> Result<Colorimeter, ColorError> {
        check_coverage(wavelengths_nm)?;
        let grid = Self::new(observer, illuminant, &visible_grid_nm())?;
        let mut weights = vec![Xyz::default(); wavelengths_nm.len()];
        let is_inside = |nm: &&f64| (FIRST_NM - TOLERANCE_NM..=LAST_NM + TOLERANCE_NM).contains(*nm);
        let own_nm: Vec<f64> = wavelengths_nm.iter().filter(is_inside).copied().collect();
        if has_fine_equal_steps(&own_nm) {
            let own = Self::new(observer, illuminant, &own_nm)?;
            let (wanted, found) = (grid.white(), own.white());
            let first = wavelengths_nm.partition_point(|nm| *nm < own_nm[0]);
            for (weight, own) in weights[first..].iter_mut().zip(&own.weights) {
                let Xyz { x, y, z } = *own;
                *weight = Xyz { x: x * (wanted.x / found.x), y: y * (wanted.y / found.y), z: z * (wanted.z / found.z) };
            }
        } else {
            for (nm, weight) in grid.wavelengths_nm.iter().zip(&grid.weights) {
                let right = wavelengths_nm.partition_point(|own| own < nm).clamp(1, wavelengths_nm.len() - 1);
                let (low, high) = (wavelengths_nm[right - 1], wavelengths_nm[right]);
                // Rounding of the ends must not extrapolate.
                let part = ((nm - low) / (high - low)).clamp(0.0, 1.0);
                weights[right - 1] = weights[right - 1] + *weight * (1.0 - part);
                weights[right] = weights[right] + *weight * part;
            }
        }
        Ok(Self { wavelengths_nm: wavelengths_nm.to_vec(), weights })
    }

    /// The wavelengths of the spectra, in nm.
    pub fn wavelengths_nm(&self) -> &[f64] {
        &self.wavelengths_nm
    }

    /// Contribution of each wavelength to the tristimulus values, per unit of the spectrum.
    ///
    /// The luminance of a spectrum is its dot product with `y` of the weights.
    pub fn weights(&self) -> &[Xyz] {
        &self.weights
    }

    /// Relative tristimulus values of a spectrum. A spectrum of ones gives Y = 1.
    ///
    /// # Panics
    /// If there is not one value per wavelength.
    pub fn xyz(&self, values: &[f64]) -> Xyz {
        assert_eq!(values.len(), self.weights.len(), "a spectrum needs one value per wavelength of the colorimeter");
        sum(self.weights.iter().zip(values).map(|(&weight, &value)| weight * value))
    }

    /// Tristimulus values of the bare light, with Y = 1.
    pub fn white(&self) -> Xyz {
        sum(self.weights.iter().copied())
    }
}

/// The wavelengths 400, 410, … 700 nm.
fn visible_grid_nm() -> Vec<f64> {
    (40..=70).map(|ten| 10.0 * f64::from(ten)).collect()
}

/// Whether wavelengths run from 400 to 700 nm in equal steps of at most 10 nm.
fn has_fine_equal_steps(wavelengths_nm: &[f64]) -> bool {
    let [first, .., last] = *wavelengths_nm else { return false };
    let step_nm = (last - first) / (wavelengths_nm.len() - 1) as f64;
    let equal = wavelengths_nm.windows(2).all(|pair| (pair[1] - pair[0] - step_nm).abs() <= TOLERANCE_NM);
    let covers = (first - FIRST_NM).abs() <= TOLERANCE_NM && (last - LAST_NM).abs() <= TOLERANCE_NM;
    equal && covers && step_nm <= GRID_STEP_NM + TOLERANCE_NM
}

/// Checks that wavelengths increase, cover 400–700 nm and have small enough steps there.
fn check_coverage(wavelengths_nm: &[f64]) -> Result<(), ColorError> {
    for pair in wavelengths_nm.windows(2) {
        let (low_nm, high_nm) = (pair[0], pair[1]);
        if high_nm <= low_nm || high_nm.is_nan() {
            return Err(ColorError::NotIncreasing { wavelength_nm: high_nm, previous_nm: low_nm });
        }
        if high_nm - low_nm > WIDEST_STEP_NM + TOLERANCE_NM && high_nm > FIRST_NM && low_nm < LAST_NM {
            return Err(ColorError::WideStep { low_nm, high_nm });
        }
    }
    match *wavelengths_nm {
        [first_nm, .., last_nm] if first_nm <= FIRST_NM + TOLERANCE_NM && last_nm >= LAST_NM - TOLERANCE_NM => Ok(()),
        [first_nm, .., last_nm] => Err(ColorError::NotCovered { first_nm, last_nm }),
        [only_nm] => Err(ColorError::NotCovered { first_nm: only_nm, last_nm: only_nm }),
        [] => Err(ColorError::NoWhite { x: 0.0, y: 0.0, z: 0.0, count: 0 }),
    }
}

fn sum(terms: impl Iterator<Item = Xyz>) -> Xyz {
    terms.fold(Xyz::default(), |sum, term| sum + term)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn colorimeter(illuminant: Illuminant, wavelengths_nm: &[f64]) -> Result<Colorimeter, ColorError> {
        Colorimeter::new(Observer::Cie1931, illuminant, wavelengths_nm)
    }

    #[test]
    fn sums_follow_the_equation() {
        let wavelengths_nm = [450.0, 552.5, 650.0];
        let values = [0.3, 0.2, 0.1];
        let (mut numerator, mut denominator) = (0.0, 0.0);
        for (wavelength_nm, value) in wavelengths_nm.into_iter().zip(values) {
            let power = Illuminant::D65.relative_power(wavelength_nm).unwrap();
            let matching = Observer::Cie1931.color_matching(wavelength_nm).unwrap();
            numerator += value * power * matching.z;
            denominator += power * matching.y;
        }
        let d65 = colorimeter(Illuminant::D65, &wavelengths_nm).unwrap();
        assert!((d65.xyz(&values).z - numerator / denominator).abs() < 1e-15);
        let luminance: f64 = d65.weights().iter().zip(values).map(|(weight, value)| weight.y * value).sum();
        assert!((d65.xyz(&values).y - luminance).abs() < 1e-15);
    }

    /// z̄ is 0 above 650 nm, so Z of white is 0 on red wavelengths alone and CIELAB is undefined.
    #[test]
    fn a_bare_light_without_white_is_rejected() {
        let message = colorimeter(Illuminant::E, &[660.0, 700.0]).unwrap_err().to_string();
        assert!(message.contains("Z = 0 (relative) on 2 wavelengths, but each must be above 0"), "{message}");
        assert!(matches!(colorimeter(Illuminant::E, &[]), Err(ColorError::NoWhite { count: 0, .. })));
        let dark: Illuminant = "LED-B2".parse().unwrap();
        assert!(matches!(colorimeter(dark, &[380.0, 385.0]), Err(ColorError::NoWhite { .. })));
    }

    #[test]
    fn decreasing_or_untabulated_wavelengths_are_rejected() {
        let message = colorimeter(Illuminant::E, &[450.0, 450.0]).unwrap_err().to_string();
        assert_eq!(message, "wavelengths must increase, but 450 nm follows 450 nm");
        assert!(matches!(colorimeter(Illuminant::E, &[450.0, f64::NAN]), Err(ColorError::OutsideTable { .. })));
        assert!(matches!(colorimeter(Illuminant::D65, &[450.0, 800.0]), Err(ColorError::OutsideTable { .. })));
    }

    /// Equal and uneven steps, with and without both ends, within and beyond the range.
    #[test]
    fn a_constant_spectrum_has_the_colour_of_the_light_at_any_step() {
        let steps =
            |first: u32, last: u32, step: usize| -> Vec<f64> { (first..=last).step_by(step).map(f64::from).collect() };
        for light in [Illuminant::D65, Illuminant::A, Illuminant::E] {
            let bare = colorimeter(light, &visible_grid_nm()).unwrap().white();
            for own_nm in [
                steps(400, 700, 1),
                steps(380, 780, 5),
                steps(400, 700, 10),
                steps(400, 700, 12),
                steps(400, 700, 20),
                steps(390, 710, 16),
                [steps(400, 500, 3), steps(507, 720, 20)].concat(),
            ] {
                let colorimeter = Colorimeter::for_spectrum(Observer::Cie1931, light, &own_nm).unwrap();
                let half = colorimeter.xyz(&vec![0.5; own_nm.len()]);
                for (half, bare) in [(half.x, bare.x), (half.y, bare.y), (half.z, bare.z)] {
                    // Rounding of up to 301 terms.
                    assert!((half / (0.5 * bare) - 1.0).abs() < 1e-13, "{half} {bare} {own_nm:?}");
                }
            }
        }
    }

    /// Spectra in 10 nm steps are summed as they are. Spectra in other steps are interpolated linearly.
    #[test]
    fn a_spectrum_is_interpolated_linearly_unless_its_steps_are_fine() {
        let curve = |nm: f64| 1.0 + 0.001 * nm;
        let at = |own_nm: &[f64]| {
            let colorimeter = Colorimeter::for_spectrum(Observer::Cie1931, Illuminant::D65, own_nm).unwrap();
            colorimeter.xyz(&own_nm.iter().map(|nm| curve(*nm)).collect::<Vec<_>>())
        };
        let tens = at(&visible_grid_nm());
        let plain = colorimeter(Illuminant::D65, &visible_grid_nm()).unwrap();
        assert_eq!(tens, plain.xyz(&visible_grid_nm().iter().map(|nm| curve(*nm)).collect::<Vec<_>>()));
        let uneven = at(&[
            390.0, 401.0, 420.0, 437.5, 455.0, 470.0, 490.0, 510.0, 530.0, 550.0, 565.0, 585.0, 600.0, 620.0, 640.0,
            650.0, 670.0, 690.0, 705.0,
        ]);
        assert!((uneven.z / tens.z - 1.0).abs() < 1e-13 && (uneven.x / tens.x - 1.0).abs() < 1e-13);
    }

    /// Values between multiples of 10 nm count in spectra of fine equal steps, also in a spectrum that is wider than
    /// the range.
    #[test]
    fn fine_equal_steps_keep_detail() {
        let luminance = |own_nm: &[f64]| {
            let colorimeter = Colorimeter::for_spectrum(Observer::Cie1931, Illuminant::E, own_nm).unwrap();
            assert_eq!(colorimeter.wavelengths_nm(), own_nm);
            let is_between = |nm: &f64| if nm % 10.0 == 0.0 { 0.0 } else { 1.0 };
            colorimeter.xyz(&own_nm.iter().map(is_between).collect::<Vec<_>>()).y
        };
        let fives = |first: u32, last: u32| (first..=last).step_by(5).map(f64::from).collect::<Vec<_>>();
        for own_nm in [fives(400, 700), fives(395, 705), fives(380, 780)] {
            assert!((luminance(&own_nm) - 0.5).abs() < 1e-3, "{own_nm:?}");
        }
        // In uneven steps only values at multiples of 10 nm count.
        let uneven = [fives(400, 500), vec![506.0], fives(510, 700)].concat();
        assert!(luminance(&uneven).abs() < 1e-15);
    }

    /// Steps beyond 400–700 nm may be wide.
    #[test]
    fn steps_beyond_the_range_may_be_wide() {
        let own_nm = [vec![370.0], visible_grid_nm(), vec![740.0]].concat();
        assert!(Colorimeter::for_spectrum(Observer::Cie1931, Illuminant::E, &own_nm).is_ok());
    }

    #[test]
    fn spectra_with_gaps_are_rejected() {
        let message = |own_nm: &[f64]| {
            Colorimeter::for_spectrum(Observer::Cie1931, Illuminant::D65, own_nm).unwrap_err().to_string()
        };
        let part: Vec<f64> = (41..=70).map(|ten| 10.0 * f64::from(ten)).collect();
        assert_eq!(message(&part), "the wavelengths are 410–700 nm, but must cover 400–700 nm");
        assert_eq!(message(&[550.0]), "the wavelengths are 550–550 nm, but must cover 400–700 nm");
        assert!(message(&[400.0, 430.0, 700.0]).starts_with("the step from 400 to 430 nm is 30 nm"));
        assert!(message(&[400.0, 390.0]).contains("must increase"));
        assert!(message(&[400.0, f64::NAN]).contains("must increase") && message(&[]).contains("0 wavelengths"));
    }

    #[test]
    #[should_panic(expected = "one value per wavelength")]
    fn a_spectrum_of_another_length_panics() {
        colorimeter(Illuminant::E, &[450.0, 550.0]).unwrap().xyz(&[1.0]);
    }
}
