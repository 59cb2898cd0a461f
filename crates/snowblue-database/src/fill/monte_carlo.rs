//! Fills a table by Monte Carlo, with the standard error of every value.
//!
//! Dry snow, clean or not, knows only the product of density and thickness: what is traced at one density serves all.

use std::time::Instant;

use snowblue_transport::monte_carlo::{self, MonteCarloOptions};
use snowblue_transport::rng::Stream;
use snowblue_transport::sample::SnowSample;
use snowblue_transport::slab::{Radiometry, Slab};

use super::{FillTimes, Values};
use crate::{Axes, DatabaseError};

/// Grains of a table's samples, `rays` for each sample's angle and index node.
pub(super) fn fill(
    (axes, samples): (&Axes, &[SnowSample]),
    (rays, seed): (u64, u64),
    grains: &[usize],
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Result<(Values, FillTimes), DatabaseError> {
    let start = Instant::now();
    let (densities, per_grain) = (axes.densities_kg_m3.len(), axes.samples_per_grain());
    let further = per_grain / densities;
    let curves = axes.curves_per_sample() * axes.wavelengths_nm.len();
    let zeros = || vec![0.0; grains.len() * per_grain * curves];
    let (mut values, mut errors) = ([zeros(), zeros()], [zeros(), zeros()]);
    let all = (grains.len() * per_grain) as u64;
    for (g, grain) in grains.iter().enumerate() {
        for kind in 0..further {
            let number = |density: usize| density * further + kind;
            let at_density = |density: usize| &samples[grain * per_grain + number(density)];
            let wet = at_density(0).water_saturation > 0.0;
            // Densities that one trace serves: all of dry snow, one of wet snow.
            let groups: Vec<Vec<usize>> =
                if wet { (0..densities).map(|d| vec![d]).collect() } else { vec![(0..densities).collect()] };
            for group in groups {
                let sample = at_density(group[0]);
                let options = MonteCarloOptions {
                    rays,
                    seed: Stream::key(seed, (grain * per_grain + number(group[0])) as u64),
                    per_wavelength: false,
                };
                let thicker = |density: &usize| at_density(*density).density_kg_m3 / sample.density_kg_m3;
                let thicknesses_cm =
                    group.iter().flat_map(|density| axes.thicknesses_cm.iter().map(move |h| h * thicker(density)));
                let slab = Slab {
                    sample: *sample,
                    thicknesses_cm: thicknesses_cm.collect(),
                    incidences: axes.incidences(),
                    wavelengths_nm: axes.wavelengths_nm.clone(),
                };
                let solved = monte_carlo::solve(&slab, &options, &|_| ())?;
                for (density, traced) in group.iter().zip(solved.chunks_exact(curves)) {
                    let first = (g * per_grain + number(*density)) * curves;
                    place(axes, traced, first, [&mut values, &mut errors]);
                    progress((g * per_grain + kind * densities + density + 1) as u64, all);
                }
            }
        }
    }
    let [transmittance, reflectance] = values;
    let times = FillTimes { solve: start.elapsed(), ..FillTimes::default() };
    Ok((Values { transmittance, reflectance, errors: Some(errors) }, times))
}

/// Puts the answers of one sample, [thickness][light][wavelength], to their places from `first`,
/// [light][thickness][wavelength].
fn place(axes: &Axes, traced: &[Radiometry], first: usize, [values, errors]: [&mut [Vec<f64>; 2]; 2]) {
    let (lights, wavelengths) = (axes.incidences().len(), axes.wavelengths_nm.len());
    let thicknesses = axes.thicknesses_cm.len();
    for (number, row) in traced.iter().enumerate() {
        let (t, rest) = (number / (lights * wavelengths), number % (lights * wavelengths));
        let place = first + ((rest / wavelengths) * thicknesses + t) * wavelengths + rest % wavelengths;
        for (quantity, estimate) in [row.transmittance, row.reflectance].into_iter().enumerate() {
            values[quantity][place] = estimate.value;
            errors[quantity][place] = estimate.standard_error;
        }
    }
}
