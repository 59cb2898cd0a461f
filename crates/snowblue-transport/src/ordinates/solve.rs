//! The ordinates' answer for a slab of snow, with the error that its grain tally leaves.

use rayon::prelude::*;

use super::jackknife::Jackknife;
use super::phase::Scattering;
use super::slab::{Fluxes, HomogeneousMedium, Light};
use super::streams::Streams;
use crate::TransportError;
use crate::ice::Ice;
use crate::population::Population;
use crate::slab::{Incidence, Radiometry, Slab};
use crate::tally::{Tally, TallyPlan};

/// How the engine works.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrdinatesOptions {
    /// Ordinates, counting both hemispheres.
    pub streams: Streams,
    /// Rays per index node of the grain tally.
    pub tally_rays: u32,
    /// Seed of the grain tally.
    pub seed: u64,
}

impl Default for OrdinatesOptions {
    fn default() -> Self {
        Self { streams: Streams::default(), tally_rays: crate::tally::DEFAULT_RAYS, seed: 1 }
    }
}

/// Reflectance, transmittance and absorptance for each thickness, then each incidence, then each wavelength.
///
/// The standard errors are those of the grain tally, by a jackknife over its batches.
///
/// # Errors
/// If the question or the number of streams is out of range.
pub fn solve(slab: &Slab, options: &OrdinatesOptions) -> Result<Vec<Radiometry>, TransportError> {
    slab.check()?;
    options.streams.check()?;
    let ice = Ice::new(slab.sample.ice);
    let size = slab.sample.grain_size;
    let tally = Tally::new(
        &Population::of_sample(&slab.sample),
        index_range(&ice, &slab.wavelengths_nm),
        &TallyPlan {
            degree: options.streams.most(&slab.incidences),
            most_absorption: most_absorption(&ice, &slab.wavelengths_nm, size.max_um),
            rays: options.tally_rays,
            seed: options.seed,
        },
    );
    // [wavelength][thickness × incidence]
    let spectra: Vec<Vec<Radiometry>> = slab
        .wavelengths_nm
        .par_iter()
        .map(|&wavelength_nm| {
            let fluxes = Jackknife::new(|without| {
                let scattering = match without {
                    None => tally.scattering(&size, &ice, wavelength_nm),
                    Some(batch) => tally.scattering_without(batch, &size, &ice, wavelength_nm),
                };
                slab_fluxes(slab, &scattering, options.streams)
            });
            let cases = slab.thicknesses_cm.iter().flat_map(|h| slab.incidences.iter().map(move |i| (*h, *i)));
            let radiometry = |(case, (thickness_cm, incidence)): (usize, (f64, Incidence))| Radiometry {
                thickness_cm,
                incidence,
                wavelength_nm,
                reflectance: fluxes.estimate(|fluxes| fluxes[case].reflectance),
                transmittance: fluxes.estimate(|fluxes| fluxes[case].transmittance),
                absorptance: fluxes.estimate(|fluxes| 1.0 - fluxes[case].reflectance - fluxes[case].transmittance),
            };
            cases.enumerate().map(radiometry).collect()
        })
        .collect();
    let cases = slab.thicknesses_cm.len() * slab.incidences.len();
    Ok((0..cases).flat_map(|case| spectra.iter().map(move |spectrum| spectrum[case])).collect())
}

/// The range of refractive indices over some wavelengths.
#[must_use]
pub fn index_range(ice: &Ice, wavelengths_nm: &[f64]) -> (f64, f64) {
    let indices = wavelengths_nm.iter().map(|wavelength_nm| ice.index(*wavelength_nm));
    indices.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), n| (low.min(n), high.max(n)))
}

/// The greatest x = γs over some wavelengths, for sizes up to `max_um`.
#[must_use]
pub fn most_absorption(ice: &Ice, wavelengths_nm: &[f64], max_um: f64) -> f64 {
    wavelengths_nm.iter().map(|wavelength_nm| ice.absorption_per_m(*wavelength_nm) * max_um * 1e-6).fold(0.0, f64::max)
}

/// Fluxes for each thickness, then each incidence.
fn slab_fluxes(slab: &Slab, scattering: &Scattering, streams: Streams) -> Vec<Fluxes> {
    let nothing = Fluxes { reflectance: 0.0, transmittance: 0.0, direct: 0.0 };
    let mut filled = vec![nothing; slab.thicknesses_cm.len() * slab.incidences.len()];
    for (streams, places) in streams.groups(&slab.incidences) {
        let medium = HomogeneousMedium::new(scattering, streams);
        let lights: Vec<Light> = places.iter().map(|place| medium.light(&slab.incidences[*place])).collect();
        for (row, thickness_cm) in filled.chunks_exact_mut(slab.incidences.len()).zip(&slab.thicknesses_cm) {
            for (place, fluxes) in places.iter().zip(medium.fluxes(slab.optical_depth(*thickness_cm), &lights)) {
                row[*place] = fluxes;
            }
        }
    }
    filled
}
