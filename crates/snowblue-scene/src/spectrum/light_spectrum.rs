//! Spectra of lights, from CIE illuminants or a file.

use std::sync::LazyLock;

use snowblue_base::files::{FileSource, NamedFile};
use snowblue_base::narrow;
use snowblue_base::spectrum_csv;
use snowblue_base::units::LUMENS_PER_WATT;
use snowblue_color::{ColorError, Colorimeter, Illuminant, Observer, temperature};

use crate::error::SceneError;
use crate::spectrum::file::SpectrumFile;
use crate::spectrum::{SAMPLES, Spectrum, wavelengths_nm};

/// Least value of the brightest wavelength. Below this value, ratios of values lose digits.
const MIN_MAXIMUM: f64 = 1e-30;

/// The shape of a light's spectrum, normalized in two ways.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightSpectrum {
    /// Band density with a total power of 1 over 31 bands of 10 nm around 400, 410, …, 700 nm.
    pub unit: Spectrum,
    /// Band density with a luminance Y of 1.
    pub relative: Spectrum,
}

impl LightSpectrum {
    /// Greatest value in a file, in any unit.
    pub const MAX_VALUE: f64 = spectrum_csv::MAX_VALUE;
    /// Equal power at all wavelengths.
    pub const EQUAL_ENERGY: Self = Self { unit: Spectrum::ONE, relative: Spectrum::ONE };

    /// The spectrum of a standard illuminant.
    ///
    /// At equal power an incandescent bulb emits more red light than the noon sky:
    /// ```
    /// # use snowblue_scene::spectrum::light_spectrum::LightSpectrum;
    /// # use snowblue_color::Illuminant;
    /// let (bulb, noon) = (LightSpectrum::illuminant(Illuminant::A)?, LightSpectrum::illuminant(Illuminant::D65)?);
    /// assert!(bulb.unit.0[30] > 2.0 * noon.unit.0[30]);
    /// # Ok::<(), snowblue_color::ColorError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// When the illuminant's table does not cover 400–700 nm.
    pub fn illuminant(illuminant: Illuminant) -> Result<Self, ColorError> {
        Self::of_relative_power(|nm| illuminant.relative_power(nm))
    }

    /// The spectrum of a correlated [colour temperature](temperature) in K.
    ///
    /// # Errors
    ///
    /// When the temperature lies outside its range.
    pub fn of_temperature(kelvin: f64) -> Result<Self, ColorError> {
        Self::of_relative_power(|nm| temperature::relative_power(kelvin, nm))
    }

    fn of_relative_power(relative_power: impl Fn(f64) -> Result<f64, ColorError>) -> Result<Self, ColorError> {
        let mut power = [0.0; SAMPLES];
        for (sample, nm) in power.iter_mut().zip(wavelengths_nm()) {
            *sample = relative_power(nm)?;
        }
        Ok(Self::of_power(&power))
    }

    /// The spectrum of a band density; none if it is black.
    pub(crate) fn of_spectrum(spectrum: &Spectrum) -> Option<Self> {
        (spectrum.maximum() > 0.0).then(|| Self::of_power(&spectrum.0.map(f64::from)))
    }

    /// Reads a file of `wavelength_nm,value` rows with or without a header. The values may have any unit. Between the
    /// rows the spectrum is linear.
    ///
    /// # Errors
    ///
    /// When the file cannot be read, a row is not two numbers, a value does not lie in 0–10³⁰, the wavelengths do not
    /// increase or do not cover 400–700 nm, or all values there are below 10⁻³⁰. The message names the file and the
    /// line.
    pub fn read(files: &dyn FileSource, name: &str) -> Result<Self, SceneError> {
        let file = SpectrumFile::parse(&NamedFile::read(files, name)?, Self::MAX_VALUE)?;
        let power = file.resample()?;
        let greatest = power.iter().copied().fold(0.0, f64::max);
        if greatest < MIN_MAXIMUM {
            let reason = format!(
                "the greatest value every 10 nm of 400–700 nm is {greatest:?}, but must be at least {MIN_MAXIMUM:?}"
            );
            return Err(file.error(reason));
        }
        Ok(Self::of_power(&power))
    }

    /// Luminance Y of a band density. For equal energy, a band density of 1 has the luminance 1.
    pub(crate) fn luminance(spectrum: &Spectrum) -> f32 {
        narrow(luminance_of(&spectrum.0.map(f64::from)))
    }

    fn of_power(power: &[f64; SAMPLES]) -> Self {
        let mean = power.iter().sum::<f64>() / power.len() as f64;
        let luminance = luminance_of(power);
        Self {
            unit: Spectrum(power.map(|sample| narrow(sample / mean))),
            relative: Spectrum(power.map(|sample| narrow(sample / luminance))),
        }
    }
}

/// Photometric equivalent of a radiant quantity of luminance Y = 1, in lm/W: 683 lm/W times the mean of ȳ over the
/// grid, as for equal-energy light of 1 W over 400–700 nm.
///
/// # Panics
///
/// Never: the observer's table covers the grid.
pub(crate) fn lumens_per_watt_of_luminance_one() -> f64 {
    let luminosity = |nm| Observer::Cie1931.color_matching(nm).expect("the observer's table covers 400–700 nm").y;
    LUMENS_PER_WATT * wavelengths_nm().map(luminosity).iter().sum::<f64>() / SAMPLES as f64
}

/// Luminance Y of a band density. For equal energy, a band density of 1 has the luminance 1.
fn luminance_of(power: &[f64; SAMPLES]) -> f64 {
    /// The observer's ȳ on the grid, with sum 1.
    static OBSERVER: LazyLock<Colorimeter> = LazyLock::new(|| {
        Colorimeter::new(Observer::Cie1931, Illuminant::E, &wavelengths_nm())
            .expect("the observer's table covers 400–700 nm")
    });
    OBSERVER.xyz(power).y
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowblue_base::files::FilesInMemory;
    use snowblue_color::Xyz;

    fn xyz(spectrum: &Spectrum) -> Xyz {
        let observer = Colorimeter::new(Observer::Cie1931, Illuminant::E, &wavelengths_nm()).unwrap();
        observer.xyz(&spectrum.0.map(f64::from))
    }

    fn read(content: &str) -> Result<LightSpectrum, SceneError> {
        let files = FilesInMemory::from([("light.csv", content)]);
        LightSpectrum::read(&files, "light.csv")
    }

    #[test]
    fn total_power_and_luminance_are_one() {
        let light = LightSpectrum::illuminant(Illuminant::D65).unwrap();
        assert!((light.unit.mean() - 1.0).abs() < 1e-6);
        assert!((xyz(&light.relative).y - 1.0).abs() < 1e-6);
        // D65 is bluish: it has more power at 460 nm than at 620 nm.
        assert!(light.unit.0[6] > light.unit.0[22]);
    }

    #[test]
    fn spectra_are_linear_between_the_rows_of_a_file() {
        let light = read("wavelength_nm,value\n390,1\n550,3\n\n720,3\n").unwrap();
        let ratio = |k: usize| light.unit.0[k] / light.unit.0[30];
        assert!((ratio(0) - 1.125 / 3.0).abs() < 1e-6 && (ratio(8) - (1.0 + 2.0 * 90.0 / 160.0) / 3.0).abs() < 1e-6);
        assert!((light.unit.mean() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn errors_in_files_name_the_line() {
        for (content, expected) in [
            ("400,1\n700\n", ["light.csv:2:", "`700`"]),
            ("400,1\n700,-1\n", ["light.csv:2:", "value of 0 or more"]),
            ("nm,value\n500,1\n400,1\n", ["light.csv:3:", "400 nm, but must lie above 500 nm"]),
            ("400,1\n690,1\n", ["light.csv:2:", "400–690 nm, but must cover 400–700 nm"]),
            ("", ["light.csv:1:", "must cover 400–700 nm"]),
            ("300,0\n800,0\n", ["light.csv:2:", "nm is 0.0, but must be at least 1e-30"]),
            ("300,1e-310\n800,1e-310\n", ["light.csv:2:", "nm is 1e-310, but must be at least 1e-30"]),
            ("300,1\n800,1e308\n", ["light.csv:2:", "value is 1e308, but must lie in 0–1e30"]),
        ] {
            let message = read(content).unwrap_err().to_string();
            assert!(expected.iter().all(|part| message.contains(part)) && !message.contains('\n'), "{message}");
        }
    }
}
