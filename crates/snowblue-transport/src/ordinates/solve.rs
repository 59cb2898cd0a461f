//! A slab of snow by discrete ordinates, with the standard errors of its grain tally.

use super::options::OrdinatesOptions;
use super::solve_batch::solve_batch;
use crate::TransportError;
use crate::batch::{Batch, CaseFluxes};
use crate::slab::{Radiometry, Slab};

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
    let batch = Batch::from(slab);
    let solved = solve_batch(&batch, options, errors, &|_| ()).map_err(|wrong| wrong.error)?;
    Ok(CaseFluxes::radiometry(&batch, &solved))
}
