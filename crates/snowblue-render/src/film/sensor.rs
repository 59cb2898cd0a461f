//! From spectra to colours: those that an eye sees, or false ones.
//!
//! A false colour takes the light of three wavelengths, of the infrared too, for red, green and blue. The wavelengths of
//! the picture are then those of the table, whichever they are, and all lights shine alike at each of them, so that what
//! reflects or transmits all wavelengths alike is grey.

use glam::Vec4;
use snowblue_color::{Colorimeter, Illuminant, LinearRgb, Observer, Xyz};

use crate::error::RenderError;
use crate::geometry::ray::narrow;
use crate::spectrum::lamp::LampSpectrum;
use crate::spectrum::{SAMPLES, Spectrum, wavelengths_nm};

/// Numbers that are multiplied at a time.
const LANES: usize = 4;

/// The wavelengths that a false colour shows as red, green and blue.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FalseColor {
    /// Shown as red, in nm.
    pub red_nm: f64,
    /// Shown as green, in nm.
    pub green_nm: f64,
    /// Shown as blue, in nm.
    pub blue_nm: f64,
}

/// Turns sums of spectra into tristimulus values.
#[derive(Debug)]
pub(crate) struct Sensor {
    weights: [Xyz; SAMPLES],
    /// The weights of X, Y and Z in single precision, as many at a time as a processor multiplies.
    lanes: [[Vec4; 3]; SAMPLES.div_ceil(LANES)],
    wavelengths_nm: [f64; SAMPLES],
    /// Light in which a grey surface is neutral, of luminance 1.
    white: Spectrum,
    is_eye: bool,
}

/// Tristimulus values X, Y and Z of light, and the sum of the magnitudes of all wavelengths.
pub(crate) type Colour = Vec4;

impl Sensor {
    /// The CIE 1931 observer on the grid of 400–700 nm.
    ///
    /// # Panics
    ///
    /// Never: the tables of the observer and of daylight cover the grid.
    pub(crate) fn eye() -> Self {
        let colorimeter = Colorimeter::new(Observer::Cie1931, Illuminant::E, &wavelengths_nm())
            .expect("the observer's table covers 400–700 nm");
        let mut weights = [Xyz::default(); SAMPLES];
        weights.copy_from_slice(colorimeter.weights());
        let daylight = LampSpectrum::illuminant(Illuminant::D65).expect("the table of D65 covers 400–700 nm");
        Self { is_eye: true, ..Self::new(weights, wavelengths_nm(), daylight.relative) }
    }

    /// Three wavelengths as the light of a screen's primaries, linear between the wavelengths of a table.
    ///
    /// # Errors
    ///
    /// When the table has not as many wavelengths as a [`Spectrum`], or does not reach those of the colour.
    pub(crate) fn false_color(colour: FalseColor, wavelengths_nm: &[f64]) -> Result<Self, RenderError> {
        if wavelengths_nm.len() != SAMPLES {
            let count = wavelengths_nm.len();
            let reason = format!("false colour needs a table of {SAMPLES} wavelengths, but this one has {count}");
            return Err(RenderError::Override(reason));
        }
        let mut weights = [LinearRgb::default(); SAMPLES];
        let FalseColor { red_nm, green_nm, blue_nm } = colour;
        for (nm, share) in hat(wavelengths_nm, red_nm)? {
            weights[nm].r += share;
        }
        for (nm, share) in hat(wavelengths_nm, green_nm)? {
            weights[nm].g += share;
        }
        for (nm, share) in hat(wavelengths_nm, blue_nm)? {
            weights[nm].b += share;
        }
        let mut nm = [0.0; SAMPLES];
        nm.copy_from_slice(wavelengths_nm);
        Ok(Self::new(weights.map(LinearRgb::xyz), nm, Spectrum::ONE))
    }

    fn new(weights: [Xyz; SAMPLES], wavelengths_nm: [f64; SAMPLES], white: Spectrum) -> Self {
        let mut lanes = [[Vec4::ZERO; 3]; SAMPLES.div_ceil(LANES)];
        for (place, weight) in weights.iter().enumerate() {
            for (lanes, value) in lanes[place / LANES].iter_mut().zip([weight.x, weight.y, weight.z]) {
                lanes[place % LANES] = narrow(value);
            }
        }
        Self { weights, lanes, wavelengths_nm, white, is_eye: false }
    }

    /// Tristimulus values of a radiance.
    pub(crate) fn xyz(&self, radiance: &Spectrum) -> Xyz {
        let terms = self.weights.iter().zip(&radiance.0).map(|(&weight, &value)| weight * f64::from(value));
        terms.fold(Xyz::default(), |sum, term| sum + term)
    }

    /// The same in single precision for the many samples of a picture, and the sum of the magnitudes of all wavelengths:
    /// it is finite only if each of them is.
    #[inline]
    pub(crate) fn sample(&self, radiance: &Spectrum) -> Colour {
        let (whole, rest) = radiance.0.as_chunks::<LANES>();
        let mut last = [0.0; LANES];
        last[..rest.len()].copy_from_slice(rest);
        let (mut sums, mut magnitudes) = ([Vec4::ZERO; 3], Vec4::ZERO);
        for (values, weights) in whole.iter().chain([&last]).zip(&self.lanes) {
            let values = Vec4::from_array(*values);
            magnitudes += values.abs();
            for (sum, weights) in sums.iter_mut().zip(weights) {
                *sum += *weights * values;
            }
        }
        let [x, y, z] = sums.map(Vec4::element_sum);
        Colour::new(x, y, z, magnitudes.element_sum())
    }

    /// Whether it sees as an eye does.
    pub(crate) fn is_eye(&self) -> bool {
        self.is_eye
    }

    /// For shares of a power at each wavelength: X, Y, Z and the power itself of one unit there.
    pub(crate) fn weights_of(&self, power: &Spectrum) -> [[f32; 4]; SAMPLES] {
        let mut places = self.weights.iter().zip(&power.0);
        [(); SAMPLES].map(|()| {
            places.next().map_or([0.0; 4], |(weight, &power)| {
                let [x, y, z] = [weight.x, weight.y, weight.z].map(|weight| narrow(weight) * power);
                [x, y, z, power]
            })
        })
    }

    /// The colour of a surface of this reflectance in the light that is white to this eye.
    pub(crate) fn surface_colour(&self, reflectance: &Spectrum) -> LinearRgb {
        LinearRgb::from_xyz(self.xyz(&(*reflectance * self.white)))
    }

    /// The wavelengths that it looks at, in nm.
    pub(crate) fn wavelengths_nm(&self) -> &[f64; SAMPLES] {
        &self.wavelengths_nm
    }

    /// Luminance of one unit at each wavelength.
    pub(crate) fn luminance(&self) -> Spectrum {
        Spectrum(self.weights.map(|weight| narrow(weight.y)))
    }
}

/// The wavelengths on both sides of a wavelength, by their place, with their shares.
fn hat(wavelengths_nm: &[f64], at_nm: f64) -> Result<[(usize, f64); 2], RenderError> {
    let last = SAMPLES - 1;
    let (low_nm, high_nm) = (wavelengths_nm[0], wavelengths_nm[last]);
    if !(low_nm..=high_nm).contains(&at_nm) {
        let reason = format!("false colour at {at_nm} nm, but the table holds {low_nm}–{high_nm} nm");
        return Err(RenderError::Override(reason));
    }
    let above = wavelengths_nm.partition_point(|nm| *nm <= at_nm).min(last);
    let share = (at_nm - wavelengths_nm[above - 1]) / (wavelengths_nm[above] - wavelengths_nm[above - 1]);
    Ok([(above - 1, 1.0 - share), (above, share)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_energy_of_one_watt_has_luminance_one_and_daylight_is_neutral() {
        let sensor = Sensor::eye();
        assert!((sensor.xyz(&Spectrum::ONE).y - 1.0).abs() < 1e-12);
        assert!((sensor.luminance().dot(&Spectrum::ONE) - 1.0).abs() < 1e-6);
        let daylight = LampSpectrum::illuminant(Illuminant::D65).unwrap();
        let LinearRgb { r, g, b } = LinearRgb::from_xyz(sensor.xyz(&daylight.relative));
        // What 10 nm steps and the ends at 400 and 700 nm leave out of D65.
        for channel in [r, g, b] {
            assert!((channel - 1.0).abs() < 0.01, "{r} {g} {b}");
        }
    }

    #[test]
    fn single_precision_sees_the_same_and_surfaces_are_grey() {
        let sensor = Sensor::eye();
        let ramp = Spectrum(std::array::from_fn(|k| 1e-9 * (1.0 + k as f32).powi(3)));
        let (exact, [x, y, z, magnitude]) = (sensor.xyz(&ramp), sensor.sample(&ramp).to_array());
        // Eight products a lane, each rounded by 2⁻²⁴ of itself at most, and their sums.
        for (single, exact) in [x, y, z].into_iter().zip([exact.x, exact.y, exact.z]) {
            assert!((f64::from(single) / exact - 1.0).abs() < 10.0 / f64::from(1 << 24), "{single} {exact}");
        }
        assert!((f64::from(magnitude) / (31.0 * ramp.mean()) - 1.0).abs() < 1e-6);
        assert!(!sensor.sample(&Spectrum::constant(f32::NAN)).w.is_finite());
        let LinearRgb { r, g, b } = sensor.surface_colour(&Spectrum::constant(0.5));
        // What 10 nm steps and the ends at 400 and 700 nm leave out of D65.
        for channel in [r, g, b] {
            assert!((channel - 0.5).abs() < 0.005, "{r} {g} {b}");
        }
    }

    #[test]
    fn false_colours_take_three_wavelengths_and_keep_white() {
        let table: Vec<f64> = (0..31).map(|k| 400.0 + 40.0 * f64::from(k)).collect();
        let colour = FalseColor { red_nm: 1600.0, green_nm: 850.0, blue_nm: 400.0 };
        let sensor = Sensor::false_color(colour, &table).unwrap();
        let seen = |spectrum: &Spectrum| LinearRgb::from_xyz(sensor.xyz(spectrum));
        let ramp = Spectrum(std::array::from_fn(|k| k as f32));
        for (spectrum, expected) in [(Spectrum::ONE, [1.0, 1.0, 1.0]), (ramp, [30.0, 11.25, 0.0])] {
            let LinearRgb { r, g, b } = seen(&spectrum);
            for (channel, expected) in [r, g, b].into_iter().zip(expected) {
                assert!((channel - expected).abs() < 1e-9, "{r} {g} {b}");
            }
        }
    }

    #[test]
    fn false_colours_lie_within_the_table() {
        let colour = FalseColor { red_nm: 1030.0, green_nm: 860.0, blue_nm: 550.0 };
        let message = Sensor::false_color(colour, &wavelengths_nm()).unwrap_err().to_string();
        assert_eq!(message, "false colour at 1030 nm, but the table holds 400–700 nm");
        assert!(Sensor::false_color(colour, &[400.0, 1100.0]).unwrap_err().to_string().contains("31 wavelengths"));
    }
}
