//! Many slabs of snow by Monte Carlo, each with its own snow, thickness, light and ground.

use super::options::{MonteCarloOptions, RayProgress};
use super::solve::solve;
use super::stack::solve_stack;
use crate::batch::{Batch, BatchError, CaseFluxes, SlabCase};
use crate::slab::{Incidence, Radiometry, Slab, THICKNESS_RANGE};
use crate::stack::{Layer, Stack};

/// Fluxes of each case at each wavelength, the wavelength running fastest.
///
/// Cases of one snow without a ground that are each of some thicknesses under each of some incidences share rays, as in
/// [`solve`]; all other cases have their own.
///
/// `progress` is called from any thread with the number of rays traced.
///
/// # Errors
/// As [`Batch::check`], and for an infinite thickness or a wrong number of rays.
///
/// # Panics
/// If a case has a sample that is none of the samples.
pub fn solve_batch(
    batch: &Batch,
    options: &MonteCarloOptions,
    progress: &(dyn Fn(RayProgress) + Sync),
) -> Result<Vec<CaseFluxes>, BatchError> {
    batch.check()?;
    for (number, case) in batch.cases.iter().enumerate() {
        let finite = THICKNESS_RANGE.check(case.thickness_cm);
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
            rows[*case] = fluxes.to_vec();
        }
    }
    let fluxes = |row: &Radiometry| CaseFluxes {
        reflectance: row.reflectance,
        transmittance: row.transmittance,
        absorptance: row.absorptance,
    };
    Ok(rows.iter().flatten().map(fluxes).collect())
}

/// The slab whose cases these are, in its order.
fn slab_of(batch: &Batch, cases: &[usize]) -> Option<Slab> {
    let own: Vec<SlabCase> = cases.iter().map(|case| SlabCase { sample: 0, ..batch.cases[*case] }).collect();
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
        ground_albedo: case.ground_albedo,
        depths_cm: Vec::new(),
        incidences: vec![case.incidence],
        wavelengths_nm: batch.wavelengths_nm.clone(),
    }
}
