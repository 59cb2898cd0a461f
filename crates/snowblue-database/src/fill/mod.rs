//! Fills a table by either engine, as a whole or some of its grains at a time.
//!
//! Each engine solves only for the axes that change its result. By discrete ordinates, one grain tally serves a
//! facetness, and one eigenproblem a (size, facetness, wavelength) of dry and clean snow; densities, thicknesses and
//! angles follow by back substitution. By Monte Carlo, one trace serves all wavelengths and thicknesses, and all
//! densities of dry snow. The paper traced 10⁵ rays for each of its 767,250 values.

mod job;
mod monte_carlo;
mod options;
mod ordinates;

use snowblue_transport::sample::SnowSample;

pub use job::{FillProgress, FillStage};
pub use options::{Engine, FillOptions, ice_from_metadata};

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
