//! Many slabs of snow, each with its own snow, thickness, light and ground, and their fluxes.

use crate::TransportError;
use crate::ground::GroundAlbedo;
use crate::sample::SnowSample;
use crate::slab::{Fluxes, Incidence, Radiometry, Slab, check_incidences, check_thickness, check_wavelengths};

/// Slabs of snow at common wavelengths.
#[derive(Debug, Clone, PartialEq)]
pub struct Batch {
    /// The kinds of snow.
    pub samples: Vec<SnowSample>,
    /// The slabs.
    pub cases: Vec<SlabCase>,
    /// Wavelengths, in nm.
    pub wavelengths_nm: Vec<f64>,
}

/// A slab of one of several samples, under one light, on a Lambertian ground.
#[derive(Debug, Clone, PartialEq)]
pub struct SlabCase {
    /// Index of the sample of the slab.
    pub sample: usize,
    /// Thickness, in cm; infinity for a half-space.
    pub thickness_cm: f64,
    /// Incident light.
    pub incidence: Incidence,
    /// Albedo of the ground.
    pub ground_albedo: GroundAlbedo,
}

/// An error in a batch.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{error}")]
pub struct BatchError {
    /// The first wrong case; none if all cases are wrong.
    pub case: Option<usize>,
    /// The error.
    #[source]
    pub error: TransportError,
}

impl Batch {
    /// Checks every case, in order.
    ///
    /// # Errors
    /// Reports the first case that is wrong.
    ///
    /// # Panics
    /// If a case refers to a sample that does not exist.
    pub fn check(&self) -> Result<(), BatchError> {
        let mut checked = vec![false; self.samples.len()];
        for (number, case) in self.cases.iter().enumerate() {
            let is_known = std::mem::replace(&mut checked[case.sample], true);
            self.check_case(case, is_known).map_err(|error| BatchError { case: Some(number), error })?;
        }
        Ok(())
    }

    /// The fluxes of each case at each wavelength, with case and wavelength. The wavelength varies fastest.
    #[must_use]
    pub fn radiometry(&self, fluxes: &[Fluxes]) -> Vec<Radiometry> {
        let places = self.cases.iter().flat_map(|case| self.wavelengths_nm.iter().map(move |nm| (case, *nm)));
        let radiometry = |((case, wavelength_nm), fluxes): ((&SlabCase, f64), &Fluxes)| Radiometry {
            thickness_cm: case.thickness_cm,
            incidence: case.incidence,
            wavelength_nm,
            fluxes: *fluxes,
        };
        places.zip(fluxes).map(radiometry).collect()
    }

    /// The cases of each sample.
    pub(crate) fn cases_of_samples(&self) -> Vec<Vec<usize>> {
        let mut cases_of = vec![Vec::new(); self.samples.len()];
        for (number, case) in self.cases.iter().enumerate() {
            cases_of[case.sample].push(number);
        }
        cases_of
    }

    fn check_case(&self, case: &SlabCase, is_sample_known: bool) -> Result<(), TransportError> {
        let sample = &self.samples[case.sample];
        if !is_sample_known {
            sample.check()?;
        }
        check_thickness(case.thickness_cm)?;
        check_incidences(&[case.incidence])?;
        case.ground_albedo.check()?;
        case.ground_albedo.check_wavelengths(&self.wavelengths_nm)?;
        if is_sample_known { Ok(()) } else { check_wavelengths(&self.wavelengths_nm, sample) }
    }
}

/// Each thickness under each incidence, on no ground.
impl From<&Slab> for Batch {
    fn from(slab: &Slab) -> Self {
        let case = |thickness_cm: &f64, incidence: &Incidence| SlabCase {
            sample: 0,
            thickness_cm: *thickness_cm,
            incidence: *incidence,
            ground_albedo: 0.0.into(),
        };
        let cases = slab.thicknesses_cm.iter().flat_map(|h| slab.incidences.iter().map(move |i| case(h, i)));
        Self { samples: vec![slab.sample], cases: cases.collect(), wavelengths_nm: slab.wavelengths_nm.clone() }
    }
}

impl From<TransportError> for BatchError {
    fn from(error: TransportError) -> Self {
        Self { case: None, error }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_wrong_case_is_named() {
        let dense = SnowSample { density_kg_m3: 1200.0, ..SnowSample::default() };
        let case = |sample, thickness_cm| SlabCase {
            sample,
            thickness_cm,
            incidence: Incidence::Beam { angle_deg: 60.0 },
            ground_albedo: 0.0.into(),
        };
        let wrong = |cases: Vec<SlabCase>| {
            let batch = Batch { samples: vec![SnowSample::default(), dense], cases, wavelengths_nm: vec![500.0] };
            batch.check().unwrap_err()
        };
        let BatchError { case: number, error } = wrong(vec![case(0, 1.0), case(0, f64::INFINITY), case(1, -1.0)]);
        assert_eq!((number, &*error.to_string()), (Some(2), "density is 1200 kg/m³, but must lie in 10–900 kg/m³"));
        let BatchError { case: number, error } = wrong(vec![case(0, 1.0), case(0, f64::NEG_INFINITY)]);
        assert!(number == Some(1) && error.to_string().starts_with("thickness is -inf cm"), "{error}");
        assert_eq!(wrong(vec![case(0, 1.0), case(0, f64::NAN), case(1, 1.0)]).case, Some(1));
    }
}
