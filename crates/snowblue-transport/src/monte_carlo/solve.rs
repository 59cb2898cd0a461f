//! Slabs by Monte Carlo: all wavelengths at once, or each separately.

use super::options::{MonteCarloOptions, RayProgress, check_rays, cos_incidence};
use super::rays::sum_over_rays;
use super::spectral;
use super::walk::{Absorption, Scatterers, walk};
use crate::TransportError;
use crate::medium::Constituents;
use crate::rng::Stream;
use crate::slab::{Estimate, Radiometry, Slab};

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
                    reflectance: sums.estimate(0, options.rays),
                    transmittance: sums.estimate(1, options.rays),
                    absorptance: sums.estimate(2, options.rays),
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
