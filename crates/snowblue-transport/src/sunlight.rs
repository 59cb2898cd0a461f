//! Broadband reflectance, transmittance and absorptance of snow in bands of sunlight.
//!
//! The spectrum is ASTM G173-03, hemispherical (global): sun and clear sky on a plane tilted by 37° towards the sun, at
//! an air mass of 1.5; 1000.37 W/m² over 280–4000 nm, of which 0.8 % lie beyond 2500 nm. A broadband value is the
//! weighted mean of a curve:
//!
//! ρ = ∫ ρ(λ) E(λ) g(λ) dλ / ∫ E(λ) g(λ) dλ,
//!
//! with g = 1 for energy and g = λ for photons. Photosynthetically active radiation (PAR) weights all photons of
//! 400–700 nm equally (McCree 1972, doi:10.1016/0002-1571(72)90045-3). Curve and spectrum are piecewise linear, and
//! their product is integrated exactly: the pieces are cubic at most, for which Simpson's rule has no error.
//!
//! **Simplified.** One spectrum serves every incidence. Under a low sun or clouds the spectrum differs, which changes
//! the albedo by a few hundredths.

use std::sync::LazyLock;

use snowblue_base::ParameterRange;
use snowblue_base::units::PHOTONS_UMOL_J_NM;

use crate::TransportError;
use crate::optics::{SpectralTable, WavelengthRange};
use crate::slab::{Estimate, Fluxes};

/// Name of the spectrum.
pub const SPECTRUM: &str = "ASTM G173-03 global on a plane tilted by 37°, air mass 1.5";

/// Greatest distance between the wavelengths of a curve, in nm. At 50 nm albedos are within 0.003 of the limit of dense
/// wavelengths, at 10 nm within 2·10⁻⁵. The infrared transmittance of thick snow needs dense wavelengths.
pub const MAX_STEP_NM: f64 = 50.0;

/// Distance of the wavelengths of [`wavelengths_nm`], in nm.
const STEP_NM: f64 = 10.0;

static G173: LazyLock<SpectralTable> =
    LazyLock::new(|| SpectralTable::new(include_str!("../data/astm_g173_global_tilt.csv")));

/// A band of the sun's spectrum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Band {
    /// 320–2500 nm, weighted by energy: the range of all tables and of the sky. 0.2 % of sunlight have shorter
    /// wavelengths.
    Solar,
    /// 400–700 nm, weighted by energy.
    Visible,
    /// 700–2500 nm, weighted by energy.
    NearInfrared,
    /// Photosynthetically active radiation: 400–700 nm, weighted by photons.
    Par,
}

/// The weight of each wavelength of a curve in a band.
#[derive(Debug, Clone, PartialEq)]
pub struct BandWeights {
    /// The band.
    pub band: Band,
    /// Weight of each wavelength. The sum of the weights is 1.
    weights: Vec<f64>,
}

impl Band {
    /// All bands, widest first.
    pub const ALL: [Self; 4] = [Self::Solar, Self::Visible, Self::NearInfrared, Self::Par];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Solar => "solar",
            Self::Visible => "visible",
            Self::NearInfrared => "near-infrared",
            Self::Par => "par",
        }
    }

    /// First and last wavelength of the band.
    #[must_use]
    pub const fn wavelength_range(self) -> WavelengthRange {
        match self {
            Self::Solar => WavelengthRange::new(320.0, 2500.0),
            Self::Visible | Self::Par => WavelengthRange::new(400.0, 700.0),
            Self::NearInfrared => WavelengthRange::new(700.0, 2500.0),
        }
    }

    /// Response of the band: g.
    #[must_use]
    pub fn response(self) -> LinearSpectrum {
        let WavelengthRange { first_nm, last_nm } = self.wavelength_range();
        let values = [first_nm, last_nm].map(|wavelength_nm| self.weight(wavelength_nm));
        LinearSpectrum { wavelengths_nm: vec![first_nm, last_nm], values: values.to_vec() }
    }

    /// g, up to a factor.
    fn weight(self, wavelength_nm: f64) -> f64 {
        match self {
            Self::Solar | Self::Visible | Self::NearInfrared => 1.0,
            Self::Par => wavelength_nm,
        }
    }
}

impl BandWeights {
    /// Weights of ascending wavelengths.
    ///
    /// # Errors
    /// [`TransportError::Descending`] if they do not ascend, [`TransportError::Uncovered`] if they do not reach the
    /// ends of the band or have a gap of more than [`MAX_STEP_NM`] in it.
    pub fn new(band: Band, wavelengths_nm: &[f64]) -> Result<Self, TransportError> {
        let range = band.wavelength_range();
        check_cover(band.name(), range, wavelengths_nm)?;
        let integrals = integrals(wavelengths_nm, range, |wavelength_nm| band.weight(wavelength_nm));
        let sum: f64 = integrals.iter().sum();
        Ok(Self { band, weights: integrals.into_iter().map(|integral| integral / sum).collect() })
    }

    /// Integrates the curve of one slab and one incidence, at the wavelengths of the weights, over the band. The
    /// results are fractions of the incident energy or, for PAR, photons.
    ///
    /// The standard errors assume fully correlated errors at all wavelengths, as where the wavelengths share their rays
    /// or their tally; for independent errors they are too large.
    ///
    /// # Panics
    /// If the curve does not have one value for each wavelength.
    #[must_use]
    pub fn broadband(&self, curve: &[Fluxes]) -> Fluxes {
        assert_eq!(curve.len(), self.weights.len(), "a band needs one value per wavelength");
        let nothing = [Estimate { value: 0.0, standard_error: 0.0 }; 3];
        let add = |mut sums: [Estimate; 3], (weight, fluxes): (&f64, &Fluxes)| {
            for (sum, at) in sums.iter_mut().zip(fluxes.to_array()) {
                sum.value += weight * at.value;
                sum.standard_error += weight * at.standard_error;
            }
            sums
        };
        self.weights.iter().zip(curve).fold(nothing, add).into()
    }
}

/// Spectral irradiance of the sun at a wavelength, in W m⁻² nm⁻¹.
///
/// The sun is brightest in the blue and the green:
/// ```
/// # use snowblue_transport::sunlight::spectral_irradiance;
/// assert!(spectral_irradiance(500.0)? > 2.0 * spectral_irradiance(1000.0)?);
/// # Ok::<(), snowblue_transport::TransportError>(())
/// ```
///
/// # Errors
/// [`TransportError::Range`] outside 300–2500 nm.
pub fn spectral_irradiance(wavelength_nm: f64) -> Result<f64, TransportError> {
    G173.wavelength_range().check("wavelength", wavelength_nm)?;
    Ok(spectral_irradiance_w_m2_nm(wavelength_nm))
}

/// Irradiance of the sun over a range of wavelengths, in W/m².
///
/// More than half of it is invisible:
/// ```
/// # use snowblue_transport::{optics::WavelengthRange, sunlight::irradiance_w_m2};
/// let irradiance = |first_nm, last_nm| irradiance_w_m2(WavelengthRange::new(first_nm, last_nm));
/// assert!(irradiance(400.0, 700.0) < 0.5 * irradiance(300.0, 2500.0));
/// ```
///
/// # Panics
/// If the wavelengths do not ascend within 300–2500 nm.
#[must_use]
pub fn irradiance_w_m2(range: WavelengthRange) -> f64 {
    integral(range, |_| 1.0)
}

/// Photon flux of the sun over a range of wavelengths, in µmol m⁻² s⁻¹.
///
/// # Panics
/// If the wavelengths do not ascend within 300–2500 nm.
#[must_use]
pub fn photon_flux_umol_m2_s(range: WavelengthRange) -> f64 {
    integral(range, |wavelength_nm| PHOTONS_UMOL_J_NM * wavelength_nm)
}

/// ∫ E g dλ over a range.
fn integral(range: WavelengthRange, weight: impl Fn(f64) -> f64) -> f64 {
    let WavelengthRange { first_nm, last_nm } = range;
    assert!(first_nm < last_nm, "wavelengths {first_nm} and {last_nm} nm do not ascend");
    integrals(&[first_nm, last_nm], range, weight).iter().sum()
}

/// Checks that the wavelengths ascend and cover the band.
fn check_cover(band: &'static str, range: WavelengthRange, wavelengths_nm: &[f64]) -> Result<(), TransportError> {
    let WavelengthRange { first_nm: low_nm, last_nm: high_nm } = range;
    check_ascent(wavelengths_nm)?;
    let uncovered = |from_nm: f64, to_nm: f64| TransportError::Uncovered {
        band,
        first_nm: low_nm,
        last_nm: high_nm,
        step_nm: MAX_STEP_NM,
        from_nm,
        to_nm,
    };
    let (Some(first_nm), Some(last_nm)) = (wavelengths_nm.first(), wavelengths_nm.last()) else {
        return Err(uncovered(low_nm, high_nm));
    };
    if *first_nm > low_nm {
        return Err(uncovered(low_nm, first_nm.min(high_nm)));
    }
    if *last_nm < high_nm {
        return Err(uncovered(last_nm.max(low_nm), high_nm));
    }
    let within = |pair: &&[f64]| pair[1] > low_nm && pair[0] < high_nm;
    match wavelengths_nm.windows(2).filter(within).find(|pair| pair[1] - pair[0] > MAX_STEP_NM) {
        Some(gap) => Err(uncovered(gap[0], gap[1])),
        None => Ok(()),
    }
}

/// Wavelengths for bands within a range, in nm: the first one, one every 10 nm from there, and the last one.
#[must_use]
pub fn wavelengths_nm(range: WavelengthRange) -> Vec<f64> {
    let steps = std::iter::successors(Some(range.first_nm), |nm| Some(nm + STEP_NM));
    steps.take_while(|nm| *nm < range.last_nm).chain([range.last_nm]).collect()
}

/// The first and the last of some wavelengths.
fn ends(wavelengths_nm: &[f64]) -> Result<WavelengthRange, TransportError> {
    match (wavelengths_nm.first(), wavelengths_nm.last()) {
        (Some(first_nm), Some(last_nm)) => Ok(WavelengthRange::new(*first_nm, *last_nm)),
        _ => Err(TransportError::Missing { quantity: "wavelength" }),
    }
}

fn check_ascent(wavelengths_nm: &[f64]) -> Result<(), TransportError> {
    if wavelengths_nm.iter().any(|wavelength_nm| !wavelength_nm.is_finite()) {
        return Err(TransportError::Combination { quantity: "wavelength", rule: "must be finite" });
    }
    match wavelengths_nm.windows(2).find(|pair| pair[1] <= pair[0]) {
        Some(pair) => Err(TransportError::Descending { previous_nm: pair[0], next_nm: pair[1] }),
        None => Ok(()),
    }
}

/// The weight of each ascending wavelength in the integral over a band of a spectrum that is linear between
/// wavelengths: ∫ h dλ, or for PAR ∫ h λ/(h c N_A) dλ, in µmol J⁻¹ nm.
///
/// # Errors
/// As [`BandWeights::new`].
pub fn band_integrals(band: Band, wavelengths_nm: &[f64]) -> Result<Vec<f64>, TransportError> {
    let range = band.wavelength_range();
    check_cover(band.name(), range, wavelengths_nm)?;
    let weight = |wavelength_nm| match band {
        Band::Par => PHOTONS_UMOL_J_NM * wavelength_nm,
        Band::Solar | Band::Visible | Band::NearInfrared => 1.0,
    };
    Ok(hat_integrals(wavelengths_nm, range, std::iter::empty(), weight))
}

/// Greatest value of a [`LinearSpectrum`]: integrals of greater values lose digits.
const MAX_VALUE: f64 = 1e12;

/// A spectrum that is linear between ascending wavelengths, and 0 beyond them: the response of a sensor, or a light, in
/// any unit per nm.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearSpectrum {
    wavelengths_nm: Vec<f64>,
    values: Vec<f64>,
}

impl LinearSpectrum {
    /// A spectrum of a quantity that is not negative.
    ///
    /// # Errors
    /// If there are fewer than two wavelengths, the wavelengths do not ascend, or the numbers of wavelengths and
    /// values differ; if a value is negative or not a number, or all values are 0.
    pub fn new(quantity: &'static str, wavelengths_nm: &[f64], values: &[f64]) -> Result<Self, TransportError> {
        if wavelengths_nm.len() < 2 {
            return Err(TransportError::Missing { quantity: "second wavelength" });
        }
        if values.len() != wavelengths_nm.len() {
            let expected = "as many as there are wavelengths";
            return Err(TransportError::Count { quantity, count: values.len(), expected });
        }
        check_ascent(wavelengths_nm)?;
        let range = ParameterRange { quantity, least: 0.0, greatest: MAX_VALUE, unit: "" };
        values.iter().try_for_each(|value| range.check(*value))?;
        if values.iter().all(|value| *value <= 0.0) {
            return Err(TransportError::Combination { quantity, rule: "must be above 0 somewhere" });
        }
        Ok(Self { wavelengths_nm: wavelengths_nm.to_vec(), values: values.to_vec() })
    }

    fn at(&self, wavelength_nm: f64) -> f64 {
        let above = self.wavelengths_nm.partition_point(|nm| *nm < wavelength_nm).max(1);
        let Some(above_nm) = self.wavelengths_nm.get(above).filter(|_| wavelength_nm >= self.wavelengths_nm[0]) else {
            return 0.0;
        };
        let below_nm = self.wavelengths_nm[above - 1];
        let part = (wavelength_nm - below_nm) / (above_nm - below_nm);
        self.values[above - 1] + part * (self.values[above] - self.values[above - 1])
    }

    /// The wavelengths between which the spectrum is not 0.
    fn support(&self) -> WavelengthRange {
        let last = self.values.len() - 1;
        let first_above = self.values.iter().position(|value| *value > 0.0).unwrap_or(0);
        let last_above = self.values.iter().rposition(|value| *value > 0.0).unwrap_or(last);
        let ends = [first_above.saturating_sub(1), (last_above + 1).min(last)].map(|place| self.wavelengths_nm[place]);
        WavelengthRange::new(ends[0], ends[1])
    }
}

/// The weight of each ascending wavelength of a curve in the mean that a sensor with this response r sees: ∫ ρ E r dλ
/// / ∫ E r dλ. The sum of the weights is 1. E is `light`, or the standard sun. `band` names the band in errors.
///
/// # Errors
/// If the wavelengths do not ascend, do not reach the ends of the response, or have a gap of more than
/// [`MAX_STEP_NM`] in it; if the wavelengths of the light do not reach the ends of the response, or there is no light
/// in the band.
pub fn response_weights(
    band: &'static str,
    response: &LinearSpectrum,
    light: Option<&LinearSpectrum>,
    wavelengths_nm: &[f64],
) -> Result<Vec<f64>, TransportError> {
    let range = response.support();
    check_cover(band, range, wavelengths_nm)?;
    let (covered, light_wavelengths_nm) = match light {
        Some(light) => (ends(&light.wavelengths_nm)?, light.wavelengths_nm.clone()),
        None => (G173.wavelength_range(), G173.wavelengths_nm().collect()),
    };
    [range.first_nm, range.last_nm].iter().try_for_each(|nm| covered.check("wavelength of a response", *nm))?;
    let density =
        |nm: f64| response.at(nm) * light.map_or_else(|| spectral_irradiance_w_m2_nm(nm), |light| light.at(nm));
    let kinks = light_wavelengths_nm.into_iter().chain(response.wavelengths_nm.iter().copied());
    let integrals = hat_integrals(wavelengths_nm, range, kinks, density);
    let sum: f64 = integrals.iter().sum();
    if sum <= 0.0 {
        return Err(TransportError::Combination {
            quantity: "light",
            rule: "must be above 0 in the band of the sensor",
        });
    }
    Ok(integrals.into_iter().map(|integral| integral / sum).collect())
}

/// ∫ E g h dλ over a range, with the hat function h of each wavelength.
fn integrals(wavelengths_nm: &[f64], range: WavelengthRange, weight: impl Fn(f64) -> f64) -> Vec<f64> {
    let density = |wavelength_nm| spectral_irradiance_w_m2_nm(wavelength_nm) * weight(wavelength_nm);
    hat_integrals(wavelengths_nm, range, G173.wavelengths_nm(), density)
}

/// ∫ f h dλ over a range, with the hat function h of each wavelength: 1 there, 0 at its neighbours, linear in between.
/// Between `kinks` f is quadratic at most.
fn hat_integrals(
    wavelengths_nm: &[f64],
    range: WavelengthRange,
    kinks: impl Iterator<Item = f64>,
    density: impl Fn(f64) -> f64,
) -> Vec<f64> {
    let inside = |nm: &f64| range.first_nm < *nm && *nm < range.last_nm;
    let mut cuts: Vec<f64> = kinks.chain(wavelengths_nm.iter().copied()).filter(inside).collect();
    cuts.extend([range.first_nm, range.last_nm]);
    cuts.sort_by(f64::total_cmp);
    let mut integrals = vec![0.0; wavelengths_nm.len()];
    for pair in cuts.windows(2) {
        let (from_nm, to_nm) = (pair[0], pair[1]);
        let middle_nm = 0.5 * (from_nm + to_nm);
        let right = wavelengths_nm.partition_point(|nm| *nm <= middle_nm).min(wavelengths_nm.len() - 1);
        let (left_nm, right_nm) = (wavelengths_nm[right - 1], wavelengths_nm[right]);
        for (at_nm, simpson) in [(from_nm, 1.0), (middle_nm, 4.0), (to_nm, 1.0)] {
            let part = simpson / 6.0 * (to_nm - from_nm) * density(at_nm);
            let hat = (at_nm - left_nm) / (right_nm - left_nm);
            integrals[right - 1] += (1.0 - hat) * part;
            integrals[right] += hat * part;
        }
    }
    integrals
}

/// E, linear between the rows of the table.
fn spectral_irradiance_w_m2_nm(wavelength_nm: f64) -> f64 {
    G173.at(wavelength_nm).linear(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(wavelengths_nm: &[f64], value: impl Fn(f64) -> f64) -> Vec<Fluxes> {
        let fluxes = |wavelength_nm: &f64| {
            let value = value(*wavelength_nm);
            Fluxes::from([1.0 - value, value, 0.0]).map(|value| Estimate { value, standard_error: 0.1 * value })
        };
        wavelengths_nm.iter().map(fluxes).collect()
    }

    fn steps(first: u32, last: u32, step: usize) -> Vec<f64> {
        (first..=last).step_by(step).map(f64::from).collect()
    }

    /// A response of 1 over the visible band has the weights of this band; a response of λ has the weights of PAR.
    /// Each light has its own weights.
    #[test]
    fn the_weights_of_a_response_are_those_of_bands() {
        let wavelengths_nm = steps(380, 720, 20);
        let visible: Vec<f64> = (400..=700).map(f64::from).collect();
        let ones = vec![1.0; visible.len()];
        let weights = |values: &[f64], light: Option<&LinearSpectrum>| {
            let response = LinearSpectrum::new("response", &visible, values).unwrap();
            response_weights("sensor", &response, light, &wavelengths_nm).unwrap()
        };
        for (band, response) in [(Band::Visible, &ones), (Band::Par, &visible)] {
            let expected = BandWeights::new(band, &wavelengths_nm).unwrap();
            for (found, expected) in weights(response, None).iter().zip(&expected.weights) {
                assert!((found - expected).abs() < 1e-14, "{band:?}");
            }
        }
        let flat = LinearSpectrum::new("light", &[300.0, 800.0], &[2.0, 2.0]).unwrap();
        let by_flat = weights(&ones, Some(&flat));
        // 300 nm of hats of 20 nm, of which the ends have half of one side.
        assert!((by_flat[2] - 20.0 / 300.0).abs() < 1e-14 && (by_flat[1] - 10.0 / 300.0).abs() < 1e-14);
        assert!(by_flat[0].abs() < 1e-15 && (by_flat.iter().sum::<f64>() - 1.0).abs() < 1e-14);
        let message = |wavelengths_nm: &[f64], values: &[f64]| {
            let response = LinearSpectrum::new("response", wavelengths_nm, values);
            response
                .and_then(|response| response_weights("sensor", &response, None, &steps(400, 700, 10)))
                .unwrap_err()
                .to_string()
        };
        assert_eq!(message(&[500.0, 600.0], &[1.0, -1.0]), "response is -1, but must lie in 0–1000000000000");
        assert_eq!(message(&[500.0, 600.0], &[0.0, 0.0]), "response must be above 0 somewhere");
        assert!(
            message(&[600.0, 500.0], &[1.0, 1.0]).contains("600 nm") && message(&[500.0], &[1.0]).contains("second")
        );
        assert!(message(&[650.0, 750.0], &[1.0, 1.0]).contains("sensor"), "{}", message(&[650.0, 750.0], &[1.0, 1.0]));
    }

    /// ASTM G173-03 in print. All its rows sum to 1000.37 W/m², with 0.0015 below 300 and 7.79 beyond 2500 nm.
    #[test]
    fn g173_in_print() {
        assert_eq!(G173.ordered_rows(), Some(1662));
        for (nm, printed) in [(300.0, 1.0205e-3), (550.0, 1.5399), (1400.0, 3.2466e-9), (2500.0, 7.0642e-3)] {
            assert!((spectral_irradiance_w_m2_nm(nm) - printed).abs() < 1e-15);
        }
        let all = WavelengthRange::new(300.0, 2500.0);
        assert!((irradiance_w_m2(all) + 0.0015 + 7.79 - 1000.37).abs() < 0.01);
    }

    #[test]
    fn wavelengths_outside_the_spectrum_are_refused() {
        assert!((spectral_irradiance(550.0).unwrap() - 1.5399).abs() < 1e-15);
        let message = spectral_irradiance(2600.0).unwrap_err().to_string();
        assert_eq!(message, "wavelength is 2600 nm, but must lie in 300–2500 nm");
    }

    /// Sunlight has 4.57 µmol/J in 400–700 nm (Thimijan & Heins 1983, HortScience 18, 818, Table 3).
    #[test]
    fn photon_flux_of_the_sun() {
        let visible = WavelengthRange::new(400.0, 700.0);
        let photons = photon_flux_umol_m2_s(visible);
        assert!((photons - 1977.9).abs() < 0.1, "{photons}");
        assert!((photons / irradiance_w_m2(visible) / 4.57 - 1.0).abs() < 0.01);
    }

    #[test]
    fn a_constant_curve_has_its_constant_as_mean() {
        for wavelengths_nm in [steps(300, 2500, 10), steps(298, 2503, 7), steps(250, 2520, 45)] {
            for band in Band::ALL {
                let weights = BandWeights::new(band, &wavelengths_nm).unwrap();
                let Fluxes { transmittance, reflectance, .. } = weights.broadband(&curve(&wavelengths_nm, |_| 0.3));
                assert!((transmittance.value - 0.3).abs() < 1e-14 && (reflectance.value - 0.7).abs() < 1e-14);
                assert!((transmittance.standard_error - 0.03).abs() < 1e-15, "errors are fully correlated");
            }
        }
    }

    /// A linear curve is integrated exactly on any wavelengths; for PAR the mean is ∫ E λ² dλ / ∫ E λ dλ.
    #[test]
    fn linear_curves_are_integrated_exactly() {
        let line = |nm: f64| nm / 4000.0;
        for band in Band::ALL {
            let mean = |wavelengths_nm: &[f64]| {
                BandWeights::new(band, wavelengths_nm).unwrap().broadband(&curve(wavelengths_nm, line)).transmittance
            };
            let range = band.wavelength_range();
            let moment = |power: i32| integral(range, |nm| nm.powi(power));
            let photons = i32::from(band == Band::Par);
            let expected = line(1.0) * moment(photons + 1) / moment(photons);
            for wavelengths_nm in [steps(300, 2500, 50), steps(300, 2510, 13), steps(290, 2530, 35)] {
                assert!((mean(&wavelengths_nm).value / expected - 1.0).abs() < 1e-13, "{band:?}");
            }
        }
    }

    #[test]
    fn uncovered_bands_are_refused() {
        let message = |band, wavelengths_nm: &[f64]| BandWeights::new(band, wavelengths_nm).unwrap_err().to_string();
        assert_eq!(
            message(Band::Solar, &steps(400, 700, 10)),
            "the solar band needs wavelengths from 320 to 2500 nm, no more than 50 nm apart, \
             but there is none from 320 to 400 nm"
        );
        assert!(message(Band::NearInfrared, &steps(400, 700, 10)).ends_with("none from 700 to 2500 nm"));
        assert!(message(Band::NearInfrared, &steps(400, 600, 10)).ends_with("none from 700 to 2500 nm"));
        assert!(message(Band::Par, &[]).ends_with("none from 400 to 700 nm"));
        assert!(message(Band::Visible, &[400.0, 450.0, 510.0, 700.0]).ends_with("none from 450 to 510 nm"));
        assert!(message(Band::Visible, &[400.0, 450.0, 450.0, 700.0]).contains("450 nm follows 450 nm"));
        // Gaps outside the band do not matter.
        let mut beyond = steps(400, 700, 20);
        beyond.push(1000.0);
        assert!(BandWeights::new(Band::Par, &beyond).is_ok());
        assert!(message(Band::NearInfrared, &steps(700, 1500, 10)).ends_with("none from 1500 to 2500 nm"));
    }
}
