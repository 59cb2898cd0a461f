//! Fills a table by Monte Carlo, with the standard error of every value.
//!
//! Transport in dry snow depends only on the product of density and thickness, also with impurities: one trace at one
//! density serves all densities.

use snowblue_transport::monte_carlo::{self, MonteCarloOptions};
use snowblue_transport::rng::Stream;
use snowblue_transport::slab::{Radiometry, Slab};

use super::job::{FillJob, FillStage};
use crate::table::{CurveValues, StandardErrors};
use crate::{Axes, DatabaseError};

/// Fills the grains of a job with `rays` for each sample, angle and index node.
pub(super) fn fill(job: &FillJob, rays: u64) -> Result<CurveValues, DatabaseError> {
    let FillJob { axes, samples, grains, .. } = job;
    let (densities, per_grain) = (axes.densities_kg_m3.len(), axes.samples_per_grain());
    let kinds = per_grain / densities;
    let curves = axes.curves_per_sample() * axes.wavelengths_nm.len();
    let total = (grains.len() * per_grain) as u64;
    let mut filled = Filled::new(grains.len() * per_grain * curves);
    job.report(FillStage::Solve, 0, total);
    for (g, grain) in grains.iter().enumerate() {
        for kind in 0..kinds {
            let number = |density: usize| density * kinds + kind;
            let at_density = |density: usize| &samples[grain * per_grain + number(density)];
            let is_wet = at_density(0).water_saturation > 0.0;
            // Densities that one trace serves: all of dry snow, one of wet snow.
            let groups: Vec<Vec<usize>> =
                if is_wet { (0..densities).map(|d| vec![d]).collect() } else { vec![(0..densities).collect()] };
            for group in groups {
                let sample = at_density(group[0]);
                let options = MonteCarloOptions {
                    rays,
                    seed: Stream::key(job.seed, (grain * per_grain + number(group[0])) as u64),
                    per_wavelength: false,
                };
                let scale = |density: &usize| at_density(*density).density_kg_m3 / sample.density_kg_m3;
                let thicknesses_cm =
                    group.iter().flat_map(|density| axes.thicknesses_cm.iter().map(move |h| h * scale(density)));
                let slab = Slab {
                    sample: *sample,
                    thicknesses_cm: thicknesses_cm.collect(),
                    incidences: axes.incidences(),
                    wavelengths_nm: axes.wavelengths_nm.clone(),
                };
                let solved = monte_carlo::solve(&slab, &options, &|_| ())?;
                for (density, traced) in group.iter().zip(solved.chunks_exact(curves)) {
                    filled.place(axes, traced, (g * per_grain + number(*density)) * curves);
                    let done = (g * per_grain + kind * densities + density + 1) as u64;
                    job.report(FillStage::Solve, done, total);
                }
            }
        }
    }
    let Filled { transmittance, reflectance, errors } = filled;
    Ok(CurveValues { transmittance, reflectance, errors: Some(errors) })
}

/// Values and standard errors, filled sample by sample.
struct Filled {
    transmittance: Vec<f64>,
    reflectance: Vec<f64>,
    errors: StandardErrors,
}

impl Filled {
    fn new(values: usize) -> Self {
        let zeros = || vec![0.0; values];
        let errors = StandardErrors { transmittance: zeros(), reflectance: zeros() };
        Self { transmittance: zeros(), reflectance: zeros(), errors }
    }

    /// Reorders the results of one sample from [thickness][light][wavelength] to [light][thickness][wavelength], and
    /// stores them from index `first` on.
    fn place(&mut self, axes: &Axes, traced: &[Radiometry], first: usize) {
        let (lights, wavelengths) = (axes.incidences().len(), axes.wavelengths_nm.len());
        let thicknesses = axes.thicknesses_cm.len();
        for (number, row) in traced.iter().enumerate() {
            let (t, rest) = (number / (lights * wavelengths), number % (lights * wavelengths));
            let index = first + ((rest / wavelengths) * thicknesses + t) * wavelengths + rest % wavelengths;
            self.transmittance[index] = row.transmittance.value;
            self.reflectance[index] = row.reflectance.value;
            self.errors.transmittance[index] = row.transmittance.standard_error;
            self.errors.reflectance[index] = row.reflectance.standard_error;
        }
    }
}
