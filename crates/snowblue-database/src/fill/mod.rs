//! Fills a table by either engine, as a whole or some of its grains at a time.
//!
//! Each engine solves only for the axes that change its result. By discrete ordinates, one grain tally serves a
//! facetness, and one eigenproblem a (size, facetness, wavelength) of dry and clean snow; densities, thicknesses and
//! angles follow by back substitution. By Monte Carlo, one trace serves all wavelengths and thicknesses, and all
//! densities of dry snow. The paper traced 10⁵ rays for each of its 767,250 values.

mod job;
mod monte_carlo;
mod ordinates;

use snowblue_transport::ordinates::{OrdinatesOptions, solve_each};
use snowblue_transport::sample::SnowSample;
use snowblue_transport::slab::Slab;

pub use job::{Engine, FillOptions, FillProgress, FillStage, ice_from_metadata};

use crate::table::CurveValues;
use crate::{Axes, DatabaseError, Table};
use job::FillJob;

/// Fills a table on `axes` with transmittance and reflectance. `progress` is called after each step.
///
/// ```
/// use snowblue_database::fill::{FillOptions, fill};
/// use snowblue_database::{Axes, Quantity};
///
/// let axes = Axes {
///     grain_sizes_um: vec![400.0],
///     facetness: vec![0.3],
///     densities_kg_m3: vec![300.0],
///     angles_deg: vec![0.0],
///     thicknesses_cm: vec![1.0, 15.0],
///     wavelengths_nm: vec![450.0, 700.0],
///     ..Axes::paper()
/// };
/// let table = fill(&axes, &FillOptions::by_ordinates(1 << 10), &|_| ())?;
/// let curves: Vec<&[f64]> = table.curves(Quantity::Transmittance).collect();
/// // 15 cm of snow transmit little light, and more of the blue than of the red.
/// assert!(curves[1][0] < curves[0][0] && curves[1][0] > 2.0 * curves[1][1]);
/// # Ok::<(), snowblue_database::DatabaseError>(())
/// ```
///
/// # Errors
/// If an axis or an option is out of range.
pub fn fill(
    axes: &Axes,
    options: &FillOptions,
    progress: &(dyn Fn(FillProgress) + Sync),
) -> Result<Table, DatabaseError> {
    let grains: Vec<usize> = (0..axes.grains()).collect();
    let values = fill_grains(axes, options, &grains, progress)?;
    Ok(Table::new(axes.clone(), values, options.metadata()))
}

/// The curves of any samples by discrete ordinates, as a table whose samples are numbered from 1 on in place of grain
/// sizes. Angles and thicknesses are those of [`Axes::with_thin_and_thick_knots`]. The samples may have any grains, but
/// one table of ice.
///
/// # Errors
/// If a sample is out of range, or its tables do not cover a wavelength.
pub(crate) fn fill_samples(
    samples: &[SnowSample],
    wavelengths_nm: &[f64],
    tally_rays: u32,
) -> Result<Table, DatabaseError> {
    let axes = Axes {
        grain_sizes_um: (1..=samples.len()).map(|number| number as f64).collect(),
        facetness: vec![0.0],
        densities_kg_m3: vec![0.0],
        wavelengths_nm: wavelengths_nm.to_vec(),
        ..Axes::with_thin_and_thick_knots()
    };
    let slab = Slab {
        sample: SnowSample::default(),
        thicknesses_cm: axes.thicknesses_cm.clone(),
        incidences: axes.incidences(),
        wavelengths_nm: wavelengths_nm.to_vec(),
    };
    let mut values = CurveValues { transmittance: Vec::new(), reflectance: Vec::new(), errors: None };
    for spectra in solve_each(samples, &slab, &OrdinatesOptions { tally_rays, ..OrdinatesOptions::default() })? {
        for incidence in 0..slab.incidences.len() {
            for thickness in 0..slab.thicknesses_cm.len() {
                let fluxes = spectra.spectrum(thickness, incidence);
                values.transmittance.extend(fluxes.iter().map(|flux| flux.transmittance));
                values.reflectance.extend(fluxes.iter().map(|flux| flux.reflectance));
            }
        }
    }
    Ok(Table::new(axes, values, Vec::new()))
}

/// Fills the given grains, each an index into grain size × facetness. The values are bit for bit those of [`fill`], in
/// the order `[grain][sample][light][thickness][wavelength]`.
///
/// # Errors
/// If an axis or an option is out of range.
pub fn fill_grains(
    axes: &Axes,
    options: &FillOptions,
    grains: &[usize],
    progress: &(dyn Fn(FillProgress) + Sync),
) -> Result<CurveValues, DatabaseError> {
    axes.check(options.ice)?;
    let samples: Vec<SnowSample> =
        (0..axes.samples()).map(|number| axes.sample(number, options.ice)).collect::<Result<_, _>>()?;
    let job = FillJob { axes, samples: &samples, grains, seed: options.seed, progress };
    match options.engine {
        Engine::Ordinates { streams, tally_rays } => {
            streams.check()?;
            Ok(ordinates::fill(&job, streams, tally_rays))
        }
        Engine::MonteCarlo { rays } => monte_carlo::fill(&job, rays),
    }
}
