//! The ordinates' answer for a slab of snow, with the error that its grain tally leaves.

use super::phase::Scattering;
use super::quadrature::MOST_NODES;
use super::slab::{Fluxes, HomogeneousMedium, Light};
use crate::TransportError;
use crate::ice::Ice;
use crate::population::Population;
use crate::slab::{Estimate, Incidence, Radiometry, Slab};
use crate::tally::{BATCHES, Tally, TallyPlan};

/// Streams that keep T within 10⁻⁵ up to 89°.
pub const DEFAULT_STREAMS: usize = 32;
/// Most streams that are allowed.
pub const MOST_STREAMS: usize = 2 * MOST_NODES;

/// How the engine works.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrdinatesOptions {
    /// Ordinates, counting both hemispheres.
    pub streams: usize,
    /// Rays per index node of the grain tally.
    pub tally_rays: u32,
    /// Seed of the grain tally.
    pub seed: u64,
}

impl Default for OrdinatesOptions {
    fn default() -> Self {
        Self { streams: DEFAULT_STREAMS, tally_rays: crate::tally::DEFAULT_RAYS, seed: 1 }
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
    check_streams(options.streams)?;
    let ice = Ice::new(slab.sample.ice);
    let size = slab.sample.grain_size;
    let tally = Tally::new(
        &Population::of_sample(&slab.sample),
        index_range(&ice, &slab.wavelengths_nm),
        &TallyPlan {
            degree: options.streams,
            most_absorption: most_absorption(&ice, &slab.wavelengths_nm, size.max_um),
            rays: options.tally_rays,
            seed: options.seed,
        },
    );
    // [wavelength][thickness × incidence]
    let spectra: Vec<Vec<Radiometry>> = slab
        .wavelengths_nm
        .iter()
        .map(|&wavelength_nm| {
            let whole = slab_fluxes(slab, &tally.scattering(&size, &ice, wavelength_nm), options.streams);
            let parts: Vec<Vec<Fluxes>> = (0..BATCHES)
                .map(|batch| tally.scattering_without(batch, &size, &ice, wavelength_nm))
                .map(|scattering| slab_fluxes(slab, &scattering, options.streams))
                .collect();
            let cases = slab.thicknesses_cm.iter().flat_map(|h| slab.incidences.iter().map(move |i| (*h, *i)));
            let radiometry = |(case, (thickness_cm, incidence)): (usize, (f64, Incidence))| {
                let estimate = |quantity: &dyn Fn(&Fluxes) -> f64| {
                    jackknife(quantity(&whole[case]), parts.iter().map(|part| quantity(&part[case])))
                };
                Radiometry {
                    thickness_cm,
                    incidence,
                    wavelength_nm,
                    reflectance: estimate(&|fluxes| fluxes.reflectance),
                    transmittance: estimate(&|fluxes| fluxes.transmittance),
                    absorptance: estimate(&|fluxes| 1.0 - fluxes.reflectance - fluxes.transmittance),
                }
            };
            cases.enumerate().map(radiometry).collect()
        })
        .collect();
    let cases = slab.thicknesses_cm.len() * slab.incidences.len();
    Ok((0..cases).flat_map(|case| spectra.iter().map(move |spectrum| spectrum[case])).collect())
}

/// Checks a number of streams.
///
/// # Errors
/// [`TransportError::Streams`] if it is odd, zero or too large.
pub fn check_streams(streams: usize) -> Result<(), TransportError> {
    if (2..=MOST_STREAMS).contains(&streams) && streams.is_multiple_of(2) {
        Ok(())
    } else {
        Err(TransportError::Streams { streams, most: MOST_STREAMS })
    }
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
fn slab_fluxes(slab: &Slab, scattering: &Scattering, streams: usize) -> Vec<Fluxes> {
    let medium = HomogeneousMedium::new(scattering, streams);
    let light = |incidence: &Incidence| match incidence {
        Incidence::Beam { angle_deg } => medium.beam(angle_deg.to_radians().cos()),
        Incidence::Diffuse => Light::Lambertian,
    };
    let lights: Vec<Light> = slab.incidences.iter().map(light).collect();
    slab.thicknesses_cm.iter().flat_map(|h| medium.fluxes(slab.optical_depth(*h), &lights)).collect()
}

/// The value from all batches with the standard error from leaving out each: √((B − 1)/B Σ (v_b − v̄)²).
fn jackknife(value: f64, parts: impl Iterator<Item = f64>) -> Estimate {
    let parts: Vec<f64> = parts.collect();
    let count = parts.len() as f64;
    let mean = parts.iter().sum::<f64>() / count;
    let squares: f64 = parts.iter().map(|part| (part - mean).powi(2)).sum();
    Estimate { value, standard_error: ((count - 1.0) / count * squares).sqrt() }
}
