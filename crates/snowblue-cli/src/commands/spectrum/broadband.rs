//! `spectrum --broadband`: averages over bands of sunlight.

use snowblue_figures::Metadata;
use snowblue_transport::optics::{WavelengthRange, Wavelengths};
use snowblue_transport::sunlight::{self, Band, BandWeights};

use crate::output::Failure;

/// All bands, as the option takes them.
pub(super) const ALL_BANDS: &str = "solar,visible,near-infrared,par";

/// Bands of sunlight.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Bands(Vec<Band>);

/// Names of bands, separated by commas.
pub(super) fn bands(words: &str) -> Result<Bands, String> {
    let band = |word: &str| {
        let known = Band::ALL.into_iter().find(|band| band.name() == word.trim());
        known.ok_or_else(|| format!("band '{word}' is not known; there are {}", ALL_BANDS.replace(',', ", ")))
    };
    let words = if words == "all" { ALL_BANDS } else { words };
    words.split(',').map(band).collect::<Result<_, _>>().map(Bands)
}

impl Bands {
    /// The bands.
    pub(super) fn list(&self) -> &[Band] {
        &self.0
    }

    /// Wavelengths from the lowest to the highest end of all bands.
    pub(super) fn wavelengths(&self) -> Wavelengths {
        let ranges = self.0.iter().map(|band| band.wavelength_range());
        Wavelengths(ranges.reduce(WavelengthRange::hull).map_or_else(Vec::new, sunlight::wavelengths_nm))
    }

    /// Weights of each band.
    pub(super) fn weights(&self, wavelengths: &Wavelengths) -> Result<Vec<BandWeights>, Failure> {
        let weights = self.0.iter().map(|band| BandWeights::new(*band, &wavelengths.0));
        weights.collect::<Result<_, _>>().map_err(Failure::input)
    }
}

/// Name and ends of a band, as `solar-320-2500`.
pub(super) fn name(band: Band) -> String {
    let WavelengthRange { first_nm, last_nm } = band.wavelength_range();
    format!("{}-{first_nm}-{last_nm}", band.name())
}

/// The solar spectrum, and the irradiance of each band.
pub(super) fn metadata(bands: &[BandWeights]) -> Metadata {
    let irradiance = |BandWeights { band, .. }: &BandWeights| {
        let (name, range) = (name(*band), band.wavelength_range());
        match band {
            Band::Par => format!("{name} {:.2} µmol m⁻² s⁻¹", sunlight::photon_flux_umol_m2_s(range)),
            _ => format!("{name} {:.2} W m⁻²", sunlight::irradiance_w_m2(range)),
        }
    };
    let sun: Vec<String> = bands.iter().map(irradiance).collect();
    vec![("sunlight", sunlight::SPECTRUM.to_owned()), ("full sun", sun.join(", "))]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_cover_their_wavelengths() {
        let all = bands(ALL_BANDS).unwrap();
        assert_eq!(all.0, Band::ALL);
        let wavelengths = all.wavelengths();
        assert_eq!((wavelengths.0.len(), wavelengths.0[0].to_bits()), (219, 320_f64.to_bits()));
        let par = bands("par").unwrap();
        assert_eq!(par.wavelengths().0.len(), 31);
        assert_eq!(par.weights(&par.wavelengths()).unwrap().len(), 1);
        assert!(bands("ultraviolet").unwrap_err().contains("'ultraviolet'"));
    }
}
