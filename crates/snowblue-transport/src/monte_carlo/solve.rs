//! Slabs by Monte Carlo: all wavelengths at once, or each separately, and many slabs, each with its own snow,
//! thickness, light and ground.

use super::rays::{MonteCarloOptions, RayProgress, check_rays, cos_incidence, sum_over_rays};
use super::spectral;
use super::stack::solve_stack;
use super::walk::{Absorption, Scatterers, walk};
use crate::TransportError;
use crate::batch::{Batch, BatchError, SlabCase};
use crate::medium::Constituents;
use crate::parameters::THICKNESS;
use crate::rng::Stream;
use crate::slab::{Estimate, Fluxes, Incidence, Radiometry, Slab};
use crate::stack::{Layer, Stack};

/// Mean paths of all rays of a slab at one wavelength; they do not depend on absorption.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeanPaths {
    /// Path between grains, in m.
    pub pore_m: Estimate,
    /// Number of scattering events.
    pub hits: Estimate,
    /// Path through ice, in m; in grains in water it counts n_water² times, as for absorption.
    pub ice_m: Estimate,
}

/// Reflectance, transmittance and absorptance for each thickness, then each incidence, then each wavelength.
///
/// `progress` is called from any thread with the number of rays traced.
///
/// # Errors
/// If a parameter is out of range.
pub fn solve(
    slab: &Slab,
    options: &MonteCarloOptions,
    progress: &(dyn Fn(RayProgress) + Sync),
) -> Result<Vec<Radiometry>, TransportError> {
    slab.check_finite()?;
    check_rays(options.rays)?;
    if options.per_wavelength {
        Ok(solve_per_wavelength(slab, options, progress))
    } else {
        Ok(spectral::solve(slab, options, progress))
    }
}

/// Traces every wavelength, thickness and incidence separately, as in the paper.
fn solve_per_wavelength(
    slab: &Slab,
    options: &MonteCarloOptions,
    progress: &(dyn Fn(RayProgress) + Sync),
) -> Vec<Radiometry> {
    let mut answer = Vec::new();
    let cases = slab.thicknesses_cm.len() * slab.incidences.len() * slab.wavelengths_nm.len();
    for &thickness_cm in &slab.thicknesses_cm {
        for &incidence in &slab.incidences {
            for &wavelength_nm in &slab.wavelengths_nm {
                let constituents = Constituents::new(&slab.sample, wavelength_nm);
                let scatterers = Scatterers::new(&slab.sample, &constituents);
                let absorption = Absorption::new(&constituents, &scatterers);
                let depth = scatterers.extinction_per_m * thickness_cm * 0.01;
                let seed = Stream::key(options.seed, answer.len() as u64);
                let sums = sum_over_rays(options.rays, |ray| {
                    let mut stream = Stream::new(seed, ray);
                    let passage = walk(&scatterers, depth, cos_incidence(incidence, &mut stream), &mut stream);
                    let weight = absorption.transmittance(&passage.paths);
                    if passage.transmitted { [0.0, weight, 1.0 - weight] } else { [weight, 0.0, 1.0 - weight] }
                });
                answer.push(Radiometry {
                    thickness_cm,
                    incidence,
                    wavelength_nm,
                    fluxes: [0, 1, 2].map(|quantity| sums.estimate(quantity, options.rays)).into(),
                });
                let traced = answer.len() as u64 * options.rays;
                progress(RayProgress { traced, total: cases as u64 * options.rays });
            }
        }
    }
    answer
}

/// Mean paths through the first thickness of a slab under its first incidence at its first wavelength.
///
/// # Errors
/// If a parameter is out of range.
pub fn mean_paths(slab: &Slab, options: &MonteCarloOptions) -> Result<MeanPaths, TransportError> {
    slab.check_finite()?;
    check_rays(options.rays)?;
    let constituents = Constituents::new(&slab.sample, slab.wavelengths_nm[0]);
    let scatterers = Scatterers::new(&slab.sample, &constituents);
    let depth = scatterers.extinction_per_m * slab.thicknesses_cm[0] * 0.01;
    // The path in grains in water counts by the ratio of the effective absorption coefficients.
    let in_water = constituents.in_water.absorption_per_m / constituents.in_air.absorption_per_m;
    let sums = sum_over_rays(options.rays, |ray| {
        let mut stream = Stream::new(options.seed, ray);
        let passage = walk(&scatterers, depth, cos_incidence(slab.incidences[0], &mut stream), &mut stream);
        let [ice_in_air_m, ice_in_water_m] = passage.paths.ice_m;
        let pore_m = passage.paths.free / scatterers.extinction_per_m;
        [pore_m, f64::from(passage.hits), ice_in_air_m + in_water * ice_in_water_m]
    });
    let [pore_m, hits, ice_m] = [0, 1, 2].map(|i| sums.estimate(i, options.rays));
    Ok(MeanPaths { pore_m, hits, ice_m })
}

/// Fluxes of each case at each wavelength, the wavelength running fastest.
///
/// Cases of one snow without a ground share rays, as in [`solve`], if they are all combinations of some thicknesses
/// and some incidences. All other cases have their own rays.
///
/// `progress` is called from any thread with the number of rays traced.
///
/// # Errors
/// As [`Batch::check`], and for an infinite thickness or a wrong number of rays.
///
/// # Panics
/// If a case refers to a sample that does not exist.
pub fn solve_batch(
    batch: &Batch,
    options: &MonteCarloOptions,
    progress: &(dyn Fn(RayProgress) + Sync),
) -> Result<Vec<Fluxes>, BatchError> {
    batch.check()?;
    for (number, case) in batch.cases.iter().enumerate() {
        let finite = THICKNESS.range.check(case.thickness_cm);
        finite.map_err(|error| BatchError { case: Some(number), error: error.into() })?;
    }
    let mut parts: Vec<(Vec<usize>, Option<Slab>)> = Vec::new();
    for cases in batch.cases_of_samples() {
        match slab_of(batch, &cases) {
            Some(slab) => parts.push((cases, Some(slab))),
            None => parts.extend(cases.into_iter().map(|case| (vec![case], slab_of(batch, &[case])))),
        }
    }
    let mut rows = vec![Vec::new(); batch.cases.len()];
    for (part, (cases, slab)) in parts.iter().enumerate() {
        let (part, parts) = (part as u64, parts.len() as u64);
        let of_several =
            |at: RayProgress| progress(RayProgress { traced: at.traced + part * at.total, total: at.total * parts });
        let solved = match slab {
            Some(slab) => solve(slab, options, &of_several),
            None => solve_stack(&stack_of(batch, &batch.cases[cases[0]]), options, &of_several),
        };
        let solved = solved.map_err(|error| BatchError { case: Some(cases[0]), error })?;
        for (case, fluxes) in cases.iter().zip(solved.chunks_exact(batch.wavelengths_nm.len())) {
            rows[*case] = fluxes.iter().map(|row| row.fluxes).collect();
        }
    }
    Ok(rows.concat())
}

/// The slab whose cases these are, in the order of the slab.
fn slab_of(batch: &Batch, cases: &[usize]) -> Option<Slab> {
    let own: Vec<SlabCase> = cases.iter().map(|case| SlabCase { sample: 0, ..batch.cases[*case].clone() }).collect();
    let first = own.first()?;
    let incidences: Vec<Incidence> = own
        .iter()
        .take_while(|case| case.thickness_cm.to_bits() == first.thickness_cm.to_bits())
        .map(|case| case.incidence)
        .collect();
    let slab = Slab {
        sample: batch.samples[batch.cases[cases[0]].sample],
        thicknesses_cm: own.iter().step_by(incidences.len()).map(|case| case.thickness_cm).collect(),
        incidences,
        wavelengths_nm: batch.wavelengths_nm.clone(),
    };
    (Batch::from(&slab).cases == own).then_some(slab)
}

/// The case as a layer on its ground.
fn stack_of(batch: &Batch, case: &SlabCase) -> Stack {
    Stack {
        layers: vec![Layer::snow(batch.samples[case.sample], case.thickness_cm)],
        ground_albedo: case.ground_albedo.clone(),
        depths_cm: Vec::new(),
        incidences: vec![case.incidence],
        wavelengths_nm: batch.wavelengths_nm.clone(),
    }
}
