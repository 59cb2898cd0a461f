//! `spectrum --broadband`: bands of sunlight instead of wavelengths.

use snowblue_transport::slab::Radiometry;
use snowblue_transport::sunlight::{self, Band, BandWeights, Broadband};

use crate::failure::Failure;
use crate::parse::Wavelengths;

/// All bands, as a user would write them.
pub(crate) const ALL_BANDS: &str = "solar,visible,near-infrared,par";

/// Distance between the wavelengths that bands are computed on, in nm.
const STEP_NM: f64 = 10.0;

/// Some bands.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Bands(Vec<Band>);

/// Bands by their names, separated by commas.
pub(crate) fn bands(words: &str) -> Result<Bands, String> {
    let band = |word: &str| {
        let known = Band::ALL.into_iter().find(|band| band.name() == word.trim());
        known.ok_or_else(|| format!("'{word}' is no band; give some of {ALL_BANDS}"))
    };
    let words = if words == "all" { ALL_BANDS } else { words };
    words.split(',').map(band).collect::<Result<_, _>>().map(Bands)
}

impl Bands {
    /// Wavelengths from the first band's begin to the last one's end.
    pub(crate) fn wavelengths(&self, reach_nm: (f64, f64)) -> Wavelengths {
        let ranges = self.0.iter().map(|band| band.range_nm(reach_nm));
        let whole = |a: (f64, f64), b: (f64, f64)| (a.0.min(b.0), a.1.max(b.1));
        let (first_nm, last_nm) = ranges.fold((f64::INFINITY, f64::NEG_INFINITY), whole);
        let steps = std::iter::successors(Some(first_nm), |nm| Some(nm + STEP_NM));
        Wavelengths(steps.take_while(|nm| *nm < last_nm).chain([last_nm]).collect())
    }

    /// Weights of each band.
    pub(crate) fn weights(&self, reach_nm: (f64, f64), wavelengths: &Wavelengths) -> Result<Vec<BandWeights>, Failure> {
        let weights = self.0.iter().map(|band| BandWeights::new(*band, reach_nm, &wavelengths.0));
        weights.collect::<Result<_, _>>().map_err(Failure::input)
    }
}

/// The values of each slab and light in each band; the wavelength runs fastest in `rows`.
pub(crate) fn values(rows: &[Radiometry], weights: &[BandWeights]) -> Vec<Broadband> {
    let same = |a: &Radiometry, b: &Radiometry| a.wavelength_nm < b.wavelength_nm;
    rows.chunk_by(same).flat_map(|curve| weights.iter().map(|weights| weights.broadband(curve))).collect()
}

/// The name of a band with its ends, since they depend on what the tables of all that the snow holds reach: `solar-300-2500`.
pub(crate) fn name(row: &Broadband) -> String {
    let (low_nm, high_nm) = row.range_nm;
    format!("{}-{low_nm}-{high_nm}", row.band.name())
}

/// Which sun it is, and what shines on the snow in each band.
pub(crate) fn metadata(rows: &[Broadband]) -> Vec<(&'static str, String)> {
    let mut bands: Vec<&Broadband> = Vec::new();
    for row in rows {
        if !bands.iter().any(|known| known.band == row.band) {
            bands.push(row);
        }
    }
    let shines = |row: &&Broadband| match row.band {
        Band::Par => format!("{} {:.2} µmol m⁻² s⁻¹", name(row), sunlight::photon_flux_umol_m2_s(row.range_nm)),
        _ => format!("{} {:.2} W m⁻²", name(row), sunlight::irradiance_w_m2(row.range_nm)),
    };
    let sun: Vec<String> = bands.iter().map(shines).collect();
    vec![("sunlight", sunlight::SPECTRUM.to_owned()), ("full sun", sun.join(", "))]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_have_the_wavelengths_that_they_need() {
        let all = bands(ALL_BANDS).unwrap();
        assert_eq!(all.0, Band::ALL);
        let wavelengths = all.wavelengths((320.0, 2500.0));
        assert_eq!((wavelengths.0.len(), wavelengths.0[0].to_bits()), (219, 320_f64.to_bits()));
        let par = bands("par").unwrap();
        assert_eq!(par.wavelengths((300.0, 2500.0)).0.len(), 31);
        assert_eq!(par.weights((300.0, 2500.0), &par.wavelengths((300.0, 2500.0))).unwrap().len(), 1);
        assert!(bands("ultraviolet").unwrap_err().contains("'ultraviolet' is no band"));
    }
}
