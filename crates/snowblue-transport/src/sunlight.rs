//! Sunlight, and what snow does to bands of it: broadband reflectance, transmittance and absorptance.
//!
//! The spectrum is ASTM G173-03, hemispherical (global): sun and clear sky on a plane that faces the sun under a tilt of
//! 37°, at an air mass of 1.5; 1000.37 W/m² over 280–4000 nm, of which 0.8 % lie beyond 2500 nm. A broadband value is
//! the mean of a curve, weighted by it:
//!
//! ρ = ∫ ρ(λ) E(λ) g(λ) dλ / ∫ E(λ) g(λ) dλ,
//!
//! with g = 1 for energy and g = λ for quanta. Photosynthetically active radiation (PAR) is all quanta of 400–700 nm
//! alike (McCree 1972, doi:10.1016/0002-1571(72)90045-3). Curve and spectrum are straight lines between their
//! wavelengths, and their product is integrated exactly: pieces are cubic, for which Simpson's rule has no error. So a
//! constant curve gives its constant.
//!
//! **Simplified.** The spectrum is the same for every direction of the light. Under a low sun or clouds it is another,
//! and with it the albedo by a few hundredths.

use std::sync::LazyLock;

use crate::TransportError;
use crate::optics::SpectralTable;
use crate::slab::{Estimate, Incidence, Radiometry};

/// What the spectrum is called.
pub const SPECTRUM: &str = "ASTM G173-03 global on a plane tilted by 37°, air mass 1.5";

/// Greatest distance between the wavelengths of a curve, in nm. Albedos are then within .003 of those of close wavelengths;
/// at 10 nm, within 2·10⁻⁵. What little infrared thick
/// snow lets through needs close ones.
pub const MOST_STEP_NM: f64 = 50.0;

/// Quanta per energy and wavelength, 1/(h c N_A), in µmol J⁻¹ nm⁻¹ (exact constants of the SI).
const PHOTONS_UMOL_J_NM: f64 = 1e-3 / (6.626_070_15e-34 * 299_792_458.0 * 6.022_140_76e23);

static G173: LazyLock<SpectralTable> =
    LazyLock::new(|| SpectralTable::new(include_str!("../data/astm_g173_global_tilt.csv")));

/// A part of the sun's spectrum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Band {
    /// All of it that the model reaches: 300–2500 nm in dry and clean snow, weighted by energy.
    Solar,
    /// 400–700 nm, weighted by energy.
    Visible,
    /// 700–2500 nm, weighted by energy.
    NearInfrared,
    /// Photosynthetically active radiation: 400–700 nm, weighted by quanta.
    Par,
}

/// How much each wavelength of a curve counts in a band.
#[derive(Debug, Clone, PartialEq)]
pub struct BandWeights {
    band: Band,
    range_nm: (f64, f64),
    /// One a wavelength, with the sum 1.
    shares: Vec<f64>,
}

/// What a slab does to the sunlight of a band: shares of the incident energy or, for PAR, quanta.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Broadband {
    /// Thickness of the slab, in cm.
    pub thickness_cm: f64,
    /// Direction of the light.
    pub incidence: Incidence,
    /// The band.
    pub band: Band,
    /// First and last wavelength of the band, in nm.
    pub range_nm: (f64, f64),
    /// Share that leaves on top.
    pub reflectance: Estimate,
    /// Share that leaves below.
    pub transmittance: Estimate,
    /// Share that stays.
    pub absorptance: Estimate,
}

impl Band {
    /// All bands, the widest first.
    pub const ALL: [Self; 4] = [Self::Solar, Self::Visible, Self::NearInfrared, Self::Par];

    /// A word for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Solar => "solar",
            Self::Visible => "visible",
            Self::NearInfrared => "near-infrared",
            Self::Par => "par",
        }
    }

    /// First and last wavelength, in nm, in snow whose tables reach from `reach_nm.0` to `reach_nm.1`
    /// ([`crate::sample::SnowSample::range_nm`]): the solar band is as wide as they are, the near-infrared ends with them.
    #[must_use]
    pub fn range_nm(self, reach_nm: (f64, f64)) -> (f64, f64) {
        match self {
            Self::Solar => reach_nm,
            Self::Visible | Self::Par => (400.0, 700.0),
            Self::NearInfrared => (700.0, reach_nm.1),
        }
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
    /// Weights of wavelengths that ascend, for snow whose tables reach from `reach_nm.0` to `reach_nm.1`.
    ///
    /// # Errors
    /// [`TransportError::Descending`] if they do not ascend, [`TransportError::Uncovered`] if they leave a part of the band
    /// out, or a gap of more than [`MOST_STEP_NM`] in it.
    pub fn new(band: Band, reach_nm: (f64, f64), wavelengths_nm: &[f64]) -> Result<Self, TransportError> {
        let range_nm = band.range_nm(reach_nm);
        check_cover(band, range_nm, wavelengths_nm)?;
        let integrals = integrals(wavelengths_nm, range_nm, |wavelength_nm| band.weight(wavelength_nm));
        let sum: f64 = integrals.iter().sum();
        Ok(Self { band, range_nm, shares: integrals.into_iter().map(|integral| integral / sum).collect() })
    }

    /// The band's values of one slab under light from one direction, whose wavelengths are those of the weights.
    ///
    /// The standard errors are those of errors that go together at all wavelengths, as they do where the wavelengths
    /// share their rays or their tally; if they do not, they are less.
    ///
    /// # Panics
    /// If there is not one value a wavelength.
    #[must_use]
    pub fn broadband(&self, curve: &[Radiometry]) -> Broadband {
        assert_eq!(curve.len(), self.shares.len(), "a band needs one value per wavelength");
        let mean = |quantity: fn(&Radiometry) -> Estimate| {
            let sum = |part: fn(Estimate) -> f64| {
                self.shares.iter().zip(curve).map(|(share, row)| share * part(quantity(row))).sum()
            };
            Estimate { value: sum(|estimate| estimate.value), standard_error: sum(|estimate| estimate.standard_error) }
        };
        Broadband {
            thickness_cm: curve[0].thickness_cm,
            incidence: curve[0].incidence,
            band: self.band,
            range_nm: self.range_nm,
            reflectance: mean(|row| row.reflectance),
            transmittance: mean(|row| row.transmittance),
            absorptance: mean(|row| row.absorptance),
        }
    }
}

impl Broadband {
    /// The quanta that pass under the full sun of the spectrum, in µmol m⁻² s⁻¹; for PAR only.
    #[must_use]
    pub fn transmitted_par_umol_m2_s(&self) -> Option<Estimate> {
        let sun = photon_flux_umol_m2_s(self.range_nm);
        let Estimate { value, standard_error } = self.transmittance;
        (self.band == Band::Par).then_some(Estimate { value: sun * value, standard_error: sun * standard_error })
    }
}

/// Irradiance of the sun between two wavelengths, in W/m².
///
/// Over half of it cannot be seen:
/// ```
/// # use snowblue_transport::sunlight::irradiance_w_m2;
/// assert!(irradiance_w_m2((400.0, 700.0)) < 0.5 * irradiance_w_m2((300.0, 2500.0)));
/// ```
///
/// # Panics
/// If the wavelengths do not ascend within 300–2500 nm.
#[must_use]
pub fn irradiance_w_m2(range_nm: (f64, f64)) -> f64 {
    of_the_sun(range_nm, |_| 1.0)
}

/// Quanta of the sun between two wavelengths, in µmol m⁻² s⁻¹.
///
/// # Panics
/// If the wavelengths do not ascend within 300–2500 nm.
#[must_use]
pub fn photon_flux_umol_m2_s(range_nm: (f64, f64)) -> f64 {
    of_the_sun(range_nm, |wavelength_nm| PHOTONS_UMOL_J_NM * wavelength_nm)
}

fn of_the_sun((low_nm, high_nm): (f64, f64), weight: impl Fn(f64) -> f64) -> f64 {
    assert!(low_nm < high_nm, "wavelengths {low_nm} and {high_nm} nm do not ascend");
    integrals(&[low_nm, high_nm], (low_nm, high_nm), weight).iter().sum()
}

fn check_cover(band: Band, (low_nm, high_nm): (f64, f64), wavelengths_nm: &[f64]) -> Result<(), TransportError> {
    if let Some(pair) = wavelengths_nm.windows(2).find(|pair| pair[1] <= pair[0]) {
        return Err(TransportError::Descending { previous_nm: pair[0], next_nm: pair[1] });
    }
    let uncovered = |from_nm: f64, to_nm: f64| TransportError::Uncovered {
        band: band.name(),
        low_nm,
        high_nm,
        step_nm: MOST_STEP_NM,
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
    match wavelengths_nm.windows(2).filter(within).find(|pair| pair[1] - pair[0] > MOST_STEP_NM) {
        Some(gap) => Err(uncovered(gap[0], gap[1])),
        None => Ok(()),
    }
}

/// ∫ E g h dλ over a range, with the hat h of each wavelength: 1 there, 0 at its neighbours, straight in between.
fn integrals(wavelengths_nm: &[f64], (low_nm, high_nm): (f64, f64), weight: impl Fn(f64) -> f64) -> Vec<f64> {
    let inside = |nm: &f64| low_nm < *nm && *nm < high_nm;
    let mut cuts: Vec<f64> = G173.wavelengths_nm().chain(wavelengths_nm.iter().copied()).filter(inside).collect();
    cuts.extend([low_nm, high_nm]);
    cuts.sort_by(f64::total_cmp);
    let mut integrals = vec![0.0; wavelengths_nm.len()];
    for pair in cuts.windows(2) {
        let (from_nm, to_nm) = (pair[0], pair[1]);
        let middle_nm = 0.5 * (from_nm + to_nm);
        let right = wavelengths_nm.partition_point(|nm| *nm <= middle_nm).min(wavelengths_nm.len() - 1);
        let (left_nm, right_nm) = (wavelengths_nm[right - 1], wavelengths_nm[right]);
        for (at_nm, simpson) in [(from_nm, 1.0), (middle_nm, 4.0), (to_nm, 1.0)] {
            let part = simpson / 6.0 * (to_nm - from_nm) * spectral_irradiance_w_m2_nm(at_nm) * weight(at_nm);
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

    const WARREN: (f64, f64) = (300.0, 2500.0);

    fn curve(wavelengths_nm: &[f64], value: impl Fn(f64) -> f64) -> Vec<Radiometry> {
        let radiometry = |wavelength_nm: &f64| {
            let estimate = |value: f64| Estimate { value, standard_error: 0.1 * value };
            let value = value(*wavelength_nm);
            Radiometry {
                thickness_cm: 1.0,
                incidence: Incidence::Diffuse,
                wavelength_nm: *wavelength_nm,
                reflectance: estimate(1.0 - value),
                transmittance: estimate(value),
                absorptance: estimate(0.0),
            }
        };
        wavelengths_nm.iter().map(radiometry).collect()
    }

    fn steps(first: u32, last: u32, step: usize) -> Vec<f64> {
        (first..=last).step_by(step).map(f64::from).collect()
    }

    /// ASTM G173-03 in print. All its rows sum to 1000.37 W/m², with 0.0015 below 300 and 7.79 beyond 2500 nm.
    #[test]
    fn g173_in_print() {
        assert_eq!(G173.ordered_rows(), Some(1662));
        for (nm, printed) in [(300.0, 1.0205e-3), (550.0, 1.5399), (1400.0, 3.2466e-9), (2500.0, 7.0642e-3)] {
            assert!((spectral_irradiance_w_m2_nm(nm) - printed).abs() < 1e-15);
        }
        assert!((irradiance_w_m2((300.0, 2500.0)) + 0.0015 + 7.79 - 1000.37).abs() < 0.01);
    }

    /// Sun and sky have 4.57 µmol/J in 400–700 nm (Thimijan & Heins 1983, HortScience 18, 818, Table 3).
    #[test]
    fn quanta_of_the_sun() {
        let visible = (400.0, 700.0);
        let quanta = photon_flux_umol_m2_s(visible);
        assert!((quanta - 1977.9).abs() < 0.1, "{quanta}");
        assert!((quanta / irradiance_w_m2(visible) / 4.57 - 1.0).abs() < 0.01);
    }

    #[test]
    fn a_constant_curve_gives_its_constant() {
        for wavelengths_nm in [steps(300, 2500, 10), steps(298, 2503, 7), steps(250, 2520, 45)] {
            for band in Band::ALL {
                let weights = BandWeights::new(band, WARREN, &wavelengths_nm).unwrap();
                let Broadband { transmittance, reflectance, .. } = weights.broadband(&curve(&wavelengths_nm, |_| 0.3));
                assert!((transmittance.value - 0.3).abs() < 1e-14 && (reflectance.value - 0.7).abs() < 1e-14);
                assert!((transmittance.standard_error - 0.03).abs() < 1e-15, "errors go together");
            }
        }
    }

    /// A straight line is integrated exactly, on any wavelengths; for PAR that is ∫ E λ² dλ / ∫ E λ dλ.
    #[test]
    fn straight_lines_keep_their_mean_on_any_wavelengths() {
        let line = |nm: f64| nm / 4000.0;
        for band in Band::ALL {
            let mean = |wavelengths_nm: &[f64]| {
                BandWeights::new(band, WARREN, wavelengths_nm)
                    .unwrap()
                    .broadband(&curve(wavelengths_nm, line))
                    .transmittance
            };
            let (low_nm, high_nm) = band.range_nm(WARREN);
            let moment =
                |power: i32| integrals(&[low_nm, high_nm], (low_nm, high_nm), |nm| nm.powi(power)).iter().sum::<f64>();
            let quanta = i32::from(band == Band::Par);
            let expected = line(1.0) * moment(quanta + 1) / moment(quanta);
            for wavelengths_nm in [steps(300, 2500, 50), steps(300, 2510, 13), steps(290, 2530, 35)] {
                assert!((mean(&wavelengths_nm).value / expected - 1.0).abs() < 1e-13, "{band:?}");
            }
        }
    }

    #[test]
    fn par_has_a_flux() {
        let wavelengths_nm = steps(400, 700, 10);
        let of =
            |band| BandWeights::new(band, WARREN, &wavelengths_nm).unwrap().broadband(&curve(&wavelengths_nm, |_| 0.5));
        let flux = of(Band::Par).transmitted_par_umol_m2_s().unwrap();
        assert!((flux.value - 988.93).abs() < 0.1 && (flux.standard_error - 98.893).abs() < 0.01, "{flux:?}");
        assert_eq!(of(Band::Visible).transmitted_par_umol_m2_s(), None);
    }

    #[test]
    fn what_is_not_covered_is_told() {
        let message =
            |band, wavelengths_nm: &[f64]| BandWeights::new(band, WARREN, wavelengths_nm).unwrap_err().to_string();
        assert_eq!(
            message(Band::Solar, &steps(400, 700, 10)),
            "the solar band needs wavelengths from 300 to 2500 nm, no more than 50 nm apart, but there is none from 300 to \
             400 nm"
        );
        assert!(message(Band::NearInfrared, &steps(400, 700, 10)).ends_with("none from 700 to 2500 nm"));
        assert!(message(Band::NearInfrared, &steps(400, 600, 10)).ends_with("none from 700 to 2500 nm"));
        assert!(message(Band::Par, &[]).ends_with("none from 400 to 700 nm"));
        assert!(message(Band::Visible, &[400.0, 450.0, 510.0, 700.0]).ends_with("none from 450 to 510 nm"));
        assert!(message(Band::Visible, &[400.0, 450.0, 450.0, 700.0]).contains("450 nm follows 450 nm"));
        // Outside the band there may be gaps.
        let mut beyond = steps(400, 700, 20);
        beyond.push(1000.0);
        assert!(BandWeights::new(Band::Par, WARREN, &beyond).is_ok());
        assert_eq!(Band::NearInfrared.range_nm((320.0, 1400.0)), (700.0, 1400.0));
    }
}
