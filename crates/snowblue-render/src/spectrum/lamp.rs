//! What light a lamp gives: the shape of its spectrum, from the CIE's tables or a file.

use std::sync::LazyLock;

use snowblue_color::{ColorError, Colorimeter, Illuminant, Observer};

use crate::error::RenderError;
use crate::files::{SceneFile, SceneFiles};
use crate::geometry::ray::narrow;
use crate::spectrum::file::SpectrumFile;
use crate::spectrum::{SAMPLES, Spectrum, wavelengths_nm};

/// The shape of a lamp's spectrum, in two measures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LampSpectrum {
    /// As a band density with a total of 1 over 400–700 nm: times a power it is this power's spectrum.
    pub unit: Spectrum,
    /// The same with luminance Y = 1 on the grid.
    pub relative: Spectrum,
}

impl LampSpectrum {
    /// Alike at all wavelengths of a picture: the light of false colours.
    pub const EQUAL_ENERGY: Self = Self { unit: Spectrum::ONE, relative: Spectrum::ONE };

    /// The spectrum of a standard illuminant.
    ///
    /// Of one watt, a bulb gives more in the red than the sky of noon:
    /// ```
    /// # use snowblue_render::spectrum::lamp::LampSpectrum;
    /// # use snowblue_color::Illuminant;
    /// let (bulb, noon) = (LampSpectrum::illuminant(Illuminant::A)?, LampSpectrum::illuminant(Illuminant::D65)?);
    /// assert!(bulb.unit.0[30] > 2.0 * noon.unit.0[30]);
    /// # Ok::<(), snowblue_color::ColorError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// When the illuminant's table does not cover 400–700 nm.
    pub fn illuminant(illuminant: Illuminant) -> Result<Self, ColorError> {
        let mut power = [0.0; SAMPLES];
        for (sample, nm) in power.iter_mut().zip(wavelengths_nm()) {
            *sample = illuminant.relative_power(nm)?;
        }
        Ok(Self::of_power(&power))
    }

    /// A spectrum from a file of `wavelength_nm,value` rows in any unit, under a header or not, which straight lines join.
    ///
    /// # Errors
    ///
    /// When the file cannot be read, a row is not two numbers, a value is negative, wavelengths do not increase or do
    /// not cover 400–700 nm, or all light lies elsewhere. The message names the file and the line.
    pub fn read(files: &dyn SceneFiles, name: &str) -> Result<Self, RenderError> {
        let file = SpectrumFile::parse(&SceneFile::read(files, name)?, f64::INFINITY)?;
        let power = file.sampled(&wavelengths_nm())?;
        if power.iter().all(|&sample| sample <= 0.0) {
            return Err(file.refused("the spectrum is 0 at every 10 nm of 400–700 nm".into()));
        }
        Ok(Self::of_power(&power))
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

/// What a radiant quantity of luminance Y = 1 is in light for eyes, in lm for W: 683 lm/W times the mean of ȳ over the grid,
/// as for equal-energy light of 1 W over 400–700 nm.
///
/// # Panics
///
/// Never: the observer's table covers the grid.
pub(crate) fn lumens_of_luminance_one() -> f64 {
    /// Luminous efficacy of light of 540 THz (BIPM 2019, "The International System of Units", section 2.3.1).
    const LUMENS_PER_WATT: f64 = 683.0;
    let eye = |nm| Observer::Cie1931.color_matching(nm).expect("the observer's table covers 400–700 nm").y;
    LUMENS_PER_WATT * wavelengths_nm().map(eye).iter().sum::<f64>() / SAMPLES as f64
}

/// Luminance Y of a band density, 1 for equal energy of 1.
fn luminance_of(power: &[f64; SAMPLES]) -> f64 {
    /// The observer's ȳ on the grid, with sum 1.
    static EYE: LazyLock<Colorimeter> = LazyLock::new(|| {
        Colorimeter::new(Observer::Cie1931, Illuminant::E, &wavelengths_nm())
            .expect("the observer's table covers 400–700 nm")
    });
    EYE.xyz(power).y
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use snowblue_color::Xyz;

    fn seen(spectrum: &Spectrum) -> Xyz {
        let eye = Colorimeter::new(Observer::Cie1931, Illuminant::E, &wavelengths_nm()).unwrap();
        eye.xyz(&spectrum.0.map(f64::from))
    }

    fn read(content: &str) -> Result<LampSpectrum, RenderError> {
        let files = BTreeMap::from([("lamp.csv".to_owned(), content.as_bytes().to_vec())]);
        LampSpectrum::read(&files, "lamp.csv")
    }

    #[test]
    fn the_total_and_the_luminance_are_one() {
        let lamp = LampSpectrum::illuminant(Illuminant::D65).unwrap();
        assert!((lamp.unit.mean() - 1.0).abs() < 1e-6);
        assert!((seen(&lamp.relative).y - 1.0).abs() < 1e-6);
        // D65 is bluish: 460 nm has more than 620 nm.
        assert!(lamp.unit.0[6] > lamp.unit.0[22]);
    }

    #[test]
    fn files_are_joined_by_straight_lines() {
        let lamp = read("wavelength_nm,value\n390,1\n550,3\n\n720,3\n").unwrap();
        let ratio = |k: usize| lamp.unit.0[k] / lamp.unit.0[30];
        assert!((ratio(0) - 1.125 / 3.0).abs() < 1e-6 && (ratio(8) - (1.0 + 2.0 * 90.0 / 160.0) / 3.0).abs() < 1e-6);
        assert!((lamp.unit.mean() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn mistakes_in_files_are_named_with_their_line() {
        for (content, expected) in [
            ("400,1\n700\n", "lamp.csv:2: expected a wavelength in nm and a value of 0 or more, but found `700`"),
            ("400,1\n700,-1\n", "lamp.csv:2: expected a wavelength"),
            ("nm,value\n500,1\n400,1\n", "lamp.csv:3: wavelength is 400 nm, but must lie above 500 nm"),
            ("400,1\n690,1\n", "lamp.csv:2: wavelengths are 400–690 nm, but must cover 400–700 nm"),
            ("", "lamp.csv:1: wavelengths are none, but must cover"),
            ("300,0\n800,0\n", "lamp.csv:2: the spectrum is 0"),
        ] {
            let message = read(content).unwrap_err().to_string();
            assert!(message.contains(expected) && !message.contains('\n'), "{message}");
        }
    }
}
