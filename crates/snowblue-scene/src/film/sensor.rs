//! From spectra to the tristimulus values of the CIE 1931 observer.

use std::iter::Sum;
use std::ops::{Add, AddAssign, Mul};

use glam::Vec4;
use snowblue_base::narrow;
use snowblue_color::{ChromaticAdaptation, Colorimeter, Illuminant, LinearRgb, Observer, Xyz};

use crate::spectrum::light_spectrum::LightSpectrum;
use crate::spectrum::{SAMPLES, Spectrum, wavelengths_nm};

/// Luminance in cd/m² of a Y of 1, which is the luminance of 1 W m⁻² sr⁻¹ of equal-energy light over 400–700 nm:
/// 683 lm/W times 0.345, the mean of ȳ on the wavelength grid.
pub(crate) const UNIT_CD_M2: f64 = 235.5;

/// Number of wavelengths in a SIMD register.
const REGISTER_WIDTH: usize = 4;

/// Converts spectra to tristimulus values.
#[derive(Debug, Clone)]
pub struct Sensor {
    /// X, Y and Z of one unit at each wavelength.
    weights: [Xyz; SAMPLES],
    /// The weights of X, Y and Z in single precision. The last register is padded with 0.
    registers: [[Vec4; 3]; SAMPLES.div_ceil(REGISTER_WIDTH)],
    /// Light in which a grey surface is neutral. Its luminance is 1.
    white: Spectrum,
}

/// The light of one sample as a sensor measures it: X, Y, Z and the sum of the magnitudes of all wavelengths. The sum
/// is finite only if the value at each wavelength is finite. One register holds all four numbers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SensorSample(Vec4);

impl SensorSample {
    /// No light.
    pub const ZERO: Self = Self(Vec4::ZERO);

    /// A sample from X, Y, Z and the sum of magnitudes.
    #[inline]
    pub fn from_array(values: [f32; 4]) -> Self {
        Self(Vec4::from_array(values))
    }

    /// Tristimulus values X, Y and Z.
    #[inline]
    pub fn xyz(self) -> [f32; 3] {
        self.0.truncate().to_array()
    }

    /// Luminance Y.
    #[inline]
    pub fn luminance(self) -> f32 {
        self.0.y
    }

    /// Sum of the magnitudes of all wavelengths.
    #[inline]
    pub fn magnitude(self) -> f32 {
        self.0.w
    }
}

impl Add for SensorSample {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl AddAssign for SensorSample {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Mul<f32> for SensorSample {
    type Output = Self;

    #[inline]
    fn mul(self, factor: f32) -> Self {
        Self(self.0 * factor)
    }
}

impl Sum for SensorSample {
    fn sum<I: Iterator<Item = Self>>(samples: I) -> Self {
        samples.fold(Self::ZERO, Self::add)
    }
}

impl Sensor {
    /// The CIE 1931 observer on the grid of 400–700 nm.
    ///
    /// # Panics
    ///
    /// Never: the tables of the observer and of D65 cover the grid.
    pub fn cie_1931() -> Self {
        let colorimeter = Colorimeter::new(Observer::Cie1931, Illuminant::E, &wavelengths_nm())
            .expect("the observer's table covers 400–700 nm");
        let mut weights = [Xyz::default(); SAMPLES];
        weights.copy_from_slice(colorimeter.weights());
        let daylight = LightSpectrum::illuminant(Illuminant::D65).expect("the table of D65 covers 400–700 nm");
        Self::new(weights, daylight.relative)
    }

    /// The sensor adapted to a light that eyes or a camera see as white; none if the colour of this light is outside
    /// of sRGB.
    pub(crate) fn balanced(self, white: &Spectrum) -> Option<Self> {
        let adaptation = ChromaticAdaptation { from_white: self.white_xyz(white)?, to_white: self.xyz(&self.white) };
        let weights = self.weights.map(|weight| adaptation.apply(weight));
        Some(Self::new(weights, *white * narrow(self.xyz(white).y.recip())))
    }

    /// Tristimulus values of a light that may look white, at luminance 1; none if its colour is outside of sRGB, or it
    /// is black.
    pub(crate) fn white_xyz(&self, white: &Spectrum) -> Option<Xyz> {
        let xyz = self.xyz(white).with_luminance(1.0);
        let LinearRgb { r, g, b } = LinearRgb::from_xyz(xyz);
        // Within sRGB all responses of the cones are positive. The comparison also fails for NaN.
        [r, g, b].into_iter().all(|channel| channel > 0.0).then_some(xyz)
    }

    /// Tristimulus values of the light in which a grey surface is neutral.
    pub(crate) fn own_white_xyz(&self) -> Xyz {
        self.xyz(&self.white)
    }

    fn new(weights: [Xyz; SAMPLES], white: Spectrum) -> Self {
        let mut registers = [[Vec4::ZERO; 3]; SAMPLES.div_ceil(REGISTER_WIDTH)];
        for (index, weight) in weights.iter().enumerate() {
            let xyz = [weight.x, weight.y, weight.z];
            for (register, value) in registers[index / REGISTER_WIDTH].iter_mut().zip(xyz) {
                register[index % REGISTER_WIDTH] = narrow(value);
            }
        }
        Self { weights, registers, white }
    }

    /// Tristimulus values of a radiance.
    pub fn xyz(&self, radiance: &Spectrum) -> Xyz {
        let terms = self.weights.iter().zip(&radiance.0).map(|(&weight, &value)| weight * f64::from(value));
        terms.fold(Xyz::default(), |sum, term| sum + term)
    }

    /// Tristimulus values of a radiance in single precision, with the sum of magnitudes, for the samples of an image.
    #[inline]
    pub fn sample(&self, radiance: &Spectrum) -> SensorSample {
        let (whole, rest) = radiance.0.as_chunks::<REGISTER_WIDTH>();
        let mut last = [0.0; REGISTER_WIDTH];
        last[..rest.len()].copy_from_slice(rest);
        let (mut sums, mut magnitudes) = ([Vec4::ZERO; 3], Vec4::ZERO);
        for (values, weights) in whole.iter().chain([&last]).zip(&self.registers) {
            let values = Vec4::from_array(*values);
            magnitudes += values.abs();
            for (sum, weights) in sums.iter_mut().zip(weights) {
                *sum += *weights * values;
            }
        }
        let [x, y, z] = sums.map(Vec4::element_sum);
        SensorSample::from_array([x, y, z, magnitudes.element_sum()])
    }

    /// X, Y, Z and magnitude of a power at each wavelength.
    pub fn weights_of(&self, power: &Spectrum) -> [[f32; 4]; SAMPLES] {
        let mut terms = self.weights.iter().zip(&power.0);
        [(); SAMPLES].map(|()| {
            terms.next().map_or([0.0; 4], |(weight, &power)| {
                let [x, y, z] = [weight.x, weight.y, weight.z].map(|weight| narrow(weight) * power);
                [x, y, z, power]
            })
        })
    }

    /// The albedo of a surface as a colour: a grey surface is neutral.
    pub fn albedo_rgb(&self, reflectance: &Spectrum) -> LinearRgb {
        LinearRgb::from_xyz(self.xyz(&(*reflectance * self.white)))
    }

    /// Luminance of one unit at each wavelength.
    pub fn luminance(&self) -> Spectrum {
        Spectrum(self.weights.map(|weight| narrow(weight.y)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_energy_light_of_one_watt_has_luminance_one() {
        let sensor = Sensor::cie_1931();
        assert!((sensor.xyz(&Spectrum::ONE).y - 1.0).abs() < 1e-12);
        assert!((sensor.luminance().dot(&Spectrum::ONE) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn the_unit_of_luminance_is_that_of_the_observer() {
        let observed = wavelengths_nm().map(|nm| Observer::Cie1931.color_matching(nm).unwrap().y);
        let unit_cd_m2 = 683.0 * observed.iter().sum::<f64>() / observed.len() as f64;
        assert!((unit_cd_m2 / UNIT_CD_M2 - 1.0).abs() < 1e-3, "{unit_cd_m2}");
    }

    #[test]
    fn daylight_is_neutral() {
        let daylight = LightSpectrum::illuminant(Illuminant::D65).unwrap();
        let LinearRgb { r, g, b } = LinearRgb::from_xyz(Sensor::cie_1931().xyz(&daylight.relative));
        // Tolerance: steps of 10 nm, and no light below 400 nm and above 700 nm.
        for channel in [r, g, b] {
            assert!((channel - 1.0).abs() < 0.01, "{r} {g} {b}");
        }
    }

    #[test]
    fn single_and_double_precision_agree() {
        let sensor = Sensor::cie_1931();
        let ramp = Spectrum(std::array::from_fn(|k| 1e-9 * (1.0 + k as f32).powi(3)));
        let (exact, sample) = (sensor.xyz(&ramp), sensor.sample(&ramp));
        let ([x, y, z], magnitude) = (sample.xyz(), sample.magnitude());
        // Eight products per lane, each with a relative error of at most 2⁻²⁴, and their sums.
        for (single, exact) in [x, y, z].into_iter().zip([exact.x, exact.y, exact.z]) {
            assert!((f64::from(single) / exact - 1.0).abs() < 10.0 / f64::from(1 << 24), "{single} {exact}");
        }
        assert!((f64::from(magnitude) / (31.0 * ramp.mean()) - 1.0).abs() < 1e-6);
        assert!(!sensor.sample(&Spectrum::constant(f32::NAN)).magnitude().is_finite());
    }

    #[test]
    fn grey_surfaces_are_neutral() {
        let LinearRgb { r, g, b } = Sensor::cie_1931().albedo_rgb(&Spectrum::constant(0.5));
        // Tolerance as above.
        for channel in [r, g, b] {
            assert!((channel - 0.5).abs() < 0.005, "{r} {g} {b}");
        }
    }

    /// The light may have any strength.
    #[test]
    fn a_grey_surface_is_neutral_in_the_light_that_looks_white() {
        let bulb = LightSpectrum::illuminant(Illuminant::A).unwrap();
        for strength in [1e-3, 1.0, 70.0] {
            let sensor = Sensor::cie_1931().balanced(&(bulb.relative * strength)).unwrap();
            let LinearRgb { r, g, b } = sensor.albedo_rgb(&Spectrum::constant(0.5));
            // D65 at 31 wavelengths is neutral within 0.4 %.
            assert!([r, g, b].iter().all(|channel| (channel / 0.5 - 1.0).abs() < 0.004), "{strength}: {r} {g} {b}");
        }
    }
}
