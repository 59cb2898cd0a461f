//! What light a lamp gives: the shape of its spectrum, from the CIE's tables or a file, and colours of images as spectra.

use std::path::Path;
use std::sync::LazyLock;

use snowblue_color::{ColorError, Colorimeter, Illuminant, LinearRgb, Observer};

use crate::error::RenderError;
use crate::ray::narrow;
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
    /// # use snowblue_render::light::LampSpectrum;
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
    pub fn read(path: &Path) -> Result<Self, RenderError> {
        let text =
            std::fs::read_to_string(path).map_err(|source| RenderError::ReadFile { path: path.into(), source })?;
        let refused = |line: usize, reason: String| RenderError::Spectrum { path: path.into(), line, reason };
        let mut rows: Vec<(f64, f64)> = Vec::new();
        let mut last_line = 1;
        for (index, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
            let is_header = index == 0 && line.starts_with(|first: char| first.is_ascii_alphabetic());
            if is_header || line.trim().is_empty() {
                continue;
            }
            last_line = index + 1;
            let row = parse_row(line).map_err(|reason| refused(last_line, reason))?;
            if let Some((before_nm, _)) = rows.last().filter(|(before_nm, _)| *before_nm >= row.0) {
                let reason = format!("wavelength is {} nm, but must lie above {before_nm} nm, the one before", row.0);
                return Err(refused(last_line, reason));
            }
            rows.push(row);
        }
        let range = rows.first().zip(rows.last()).map(|(first, last)| (first.0, last.0));
        let Some((low_nm, high_nm)) = range.filter(|(low_nm, high_nm)| *low_nm <= 400.0 && *high_nm >= 700.0) else {
            let found = range.map_or("none".into(), |(low_nm, high_nm)| format!("{low_nm}–{high_nm} nm"));
            return Err(refused(last_line, format!("wavelengths are {found}, but must cover 400–700 nm")));
        };
        let power = wavelengths_nm().map(|nm| between(&rows, nm.clamp(low_nm, high_nm)));
        if power.iter().all(|&sample| sample <= 0.0) {
            return Err(refused(last_line, "the spectrum is 0 at every 10 nm of 400–700 nm".into()));
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

fn parse_row(line: &str) -> Result<(f64, f64), String> {
    let fields: Vec<Option<f64>> = line.split(',').map(|field| field.trim().parse().ok()).collect();
    match fields[..] {
        [Some(nm), Some(value)] if f64::is_finite(nm) && f64::is_finite(value) && value >= 0.0 => Ok((nm, value)),
        _ => Err(format!("expected a wavelength in nm and a value of 0 or more, but found `{line}`")),
    }
}

/// The value at a wavelength within the rows, on the straight line between its neighbours.
fn between(rows: &[(f64, f64)], nm: f64) -> f64 {
    let above = rows.partition_point(|row| row.0 <= nm).clamp(1, rows.len() - 1);
    let ((low_nm, low), (high_nm, high)) = (rows[above - 1], rows[above]);
    low + (high - low) * (nm - low_nm) / (high_nm - low_nm)
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

/// Turns linear sRGB of an image into spectra, r R(λ) + g G(λ) + b B(λ) times the light of D65.
///
/// R, G and B are the smoothest spectra that add up to 1 and have, under D65, the colours of the primaries (Mallett &
/// Yuksel 2019, doi:10.2312/sr.20191216). So grey is daylight, every colour within the gamut is met, and none has negative
/// power. White is D65 as the sum over 400–700 nm sees it: within 1 % of sRGB's.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Upsampling {
    primaries: [Spectrum; 3],
}

impl Upsampling {
    /// The spectra of daylight, for eyes.
    ///
    /// # Panics
    ///
    /// Never: the embedded table has been checked by a test, and D65 covers 400–700 nm.
    pub(crate) fn daylight() -> Self {
        let daylight = LampSpectrum::illuminant(Illuminant::D65).expect("D65 covers 400–700 nm").relative;
        let mut primaries = [Spectrum::ZERO; 3];
        let rows = include_str!("../../data/rgb_basis.csv").lines().skip(1);
        for (nm, row) in rows.enumerate() {
            for (primary, field) in primaries.iter_mut().zip(row.split(',').skip(1)) {
                primary.0[nm] = field.parse().expect("the table holds numbers");
            }
        }
        Self { primaries: primaries.map(|primary| primary * daylight) }
    }

    /// The luminance of each primary alike at all wavelengths, for false colours.
    pub(crate) fn grey() -> Self {
        let of = |r, g, b| Spectrum::constant(narrow(LinearRgb { r, g, b }.luminance()));
        Self { primaries: [of(1.0, 0.0, 0.0), of(0.0, 1.0, 0.0), of(0.0, 0.0, 1.0)] }
    }

    /// The spectrum of a colour, of the luminance of the colour.
    #[inline]
    pub(crate) fn spectrum(&self, [r, g, b]: [f32; 3]) -> Spectrum {
        let [red, green, blue] = &self.primaries;
        Spectrum(std::array::from_fn(|k| r * red.0[k] + g * green.0[k] + b * blue.0[k]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowblue_color::Xyz;

    fn seen(spectrum: &Spectrum) -> Xyz {
        let eye = Colorimeter::new(Observer::Cie1931, Illuminant::E, &wavelengths_nm()).unwrap();
        eye.xyz(&spectrum.0.map(f64::from))
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
    fn colours_become_spectra_of_the_same_colour_and_grey_becomes_daylight() {
        let upsampling = Upsampling::daylight();
        let daylight = LampSpectrum::illuminant(Illuminant::D65).unwrap().relative;
        for (grey, sample) in upsampling.spectrum([0.5; 3]).0.iter().zip(daylight.0) {
            assert!((grey / sample - 0.5).abs() < 1e-6);
        }
        for (r, g, b) in [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.2, 0.3, 0.7)] {
            let spectrum = upsampling.spectrum([r, g, b].map(narrow));
            assert!(spectrum.0.iter().all(|&sample| sample >= 0.0));
            let back = LinearRgb::from_xyz(seen(&spectrum));
            // The white of D65 on 10 nm steps from 400 to 700 nm is off sRGB's by .8 % in blue, and less elsewhere.
            for (found, expected) in [(back.r, r), (back.g, g), (back.b, b)] {
                assert!((found - expected).abs() < 0.01 * expected.max(1e-3), "{r} {g} {b}: {back:?}");
            }
        }
    }

    #[test]
    fn files_are_joined_by_straight_lines() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lamp.csv");
        std::fs::write(&path, "wavelength_nm,value\n390,1\n550,3\n\n720,3\n").unwrap();
        let lamp = LampSpectrum::read(&path).unwrap();
        let ratio = |k: usize| lamp.unit.0[k] / lamp.unit.0[30];
        assert!((ratio(0) - 1.125 / 3.0).abs() < 1e-6 && (ratio(8) - (1.0 + 2.0 * 90.0 / 160.0) / 3.0).abs() < 1e-6);
        assert!((lamp.unit.mean() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn mistakes_in_files_are_named_with_their_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lamp.csv");
        for (content, expected) in [
            ("400,1\n700\n", "lamp.csv:2: expected a wavelength in nm and a value of 0 or more, but found `700`"),
            ("400,1\n700,-1\n", "lamp.csv:2: expected a wavelength"),
            ("nm,value\n500,1\n400,1\n", "lamp.csv:3: wavelength is 400 nm, but must lie above 500 nm"),
            ("400,1\n690,1\n", "lamp.csv:2: wavelengths are 400–690 nm, but must cover 400–700 nm"),
            ("", "lamp.csv:1: wavelengths are none, but must cover"),
            ("300,0\n800,0\n", "lamp.csv:2: the spectrum is 0"),
        ] {
            std::fs::write(&path, content).unwrap();
            let message = LampSpectrum::read(&path).unwrap_err().to_string();
            assert!(message.contains(expected) && !message.contains('\n'), "{message}");
        }
    }
}
