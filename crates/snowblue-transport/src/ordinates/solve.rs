//! A slab of snow by discrete ordinates, with the standard errors of its grain tally.

use rayon::prelude::*;

use super::jackknife::Jackknife;
use super::streams::{Peak, Streams};
use crate::TransportError;
use crate::medium::{Demand, GrainTallies, Population, TallyPlan};
use crate::slab::{Incidence, Radiometry, Slab};

/// Options of the discrete-ordinates engine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrdinatesOptions {
    /// Ordinates, counting both hemispheres.
    pub streams: Streams,
    /// Rays per index node of the grain tally.
    pub tally_rays: u32,
    /// Seed of the grain tally.
    pub seed: u64,
}

impl OrdinatesOptions {
    /// The tally options for snow with a forward peak under some lights.
    pub(crate) fn plan(&self, incidences: &[Incidence], peak: Peak) -> TallyPlan {
        TallyPlan { degree: self.streams.most(incidences, peak), rays: self.tally_rays, seed: self.seed }
    }
}

impl Default for OrdinatesOptions {
    fn default() -> Self {
        Self { streams: Streams::default(), tally_rays: crate::medium::DEFAULT_RAYS, seed: 1 }
    }
}

/// Reflectance, transmittance and absorptance for each thickness, then each incidence, then each wavelength.
///
/// The standard errors are those of the grain tally, by a jackknife over its batches.
///
/// # Errors
/// If a parameter or the number of streams is out of range.
pub fn solve(slab: &Slab, options: &OrdinatesOptions) -> Result<Vec<Radiometry>, TransportError> {
    solve_with(slab, options, true)
}

/// As [`solve`], without standard errors, which are NaN: they take most of the time once the grains are tallied.
///
/// # Errors
/// If a parameter or the number of streams is out of range.
pub fn solve_without_errors(slab: &Slab, options: &OrdinatesOptions) -> Result<Vec<Radiometry>, TransportError> {
    solve_with(slab, options, false)
}

fn solve_with(slab: &Slab, options: &OrdinatesOptions, errors: bool) -> Result<Vec<Radiometry>, TransportError> {
    slab.check()?;
    options.streams.check()?;
    let plan = options.plan(&slab.incidences, Peak::of(&slab.sample));
    let demand = Demand::of_sample(&slab.sample, &slab.wavelengths_nm);
    let tallies = GrainTallies::new(&Population::of_sample(&slab.sample), &demand, &plan);
    // [wavelength][thickness × incidence]
    let spectra: Vec<Vec<Radiometry>> = slab
        .wavelengths_nm
        .par_iter()
        .map(|&wavelength_nm| {
            let result = |without| {
                let medium = tallies.medium(&slab.sample, wavelength_nm, without);
                medium.fluxes(&slab.thicknesses_cm, &slab.incidences, options.streams, Peak::of(&slab.sample))
            };
            let fluxes = if errors { Jackknife::new(result) } else { Jackknife::without_errors(result) };
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
