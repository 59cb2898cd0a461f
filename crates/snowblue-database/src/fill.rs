//! Fills a table by discrete ordinates.
//!
//! One grain tally serves a facetness, one eigenproblem a (size, facetness, wavelength); densities, thicknesses and
//! angles follow by back-substitution. The paper traced 10⁵ rays for each of the 767,250 values.

use std::time::{Duration, Instant};

use rayon::prelude::*;
use snowblue_transport::ice::IceTable;
use snowblue_transport::ordinates::{HomogeneousMedium, Light, Streams};
use snowblue_transport::sample::{GrainSize, SnowSample, TruncatedNormal};
use snowblue_transport::slab::Incidence;
use snowblue_transport::{Demand, GrainTallies, Population, TallyPlan};

use crate::{Axes, DatabaseError, Table};

/// How a table is filled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FillOptions {
    /// Ordinates, counting both hemispheres; `Auto` solves steep and grazing angles apart.
    pub streams: Streams,
    /// Rays per facetness and index node of the grain tally; 2²⁰ leave 0.1 % in T of 15 cm.
    pub tally_rays: u32,
    /// Seed of the grain tally.
    pub seed: u64,
    /// Whose absorption of ice is used.
    pub ice: IceTable,
}

impl Default for FillOptions {
    fn default() -> Self {
        Self { streams: Streams::default(), tally_rays: 1 << 20, seed: 1, ice: IceTable::default() }
    }
}

/// How long the parts took.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FillTimes {
    /// Sending rays at grains.
    pub tally: Duration,
    /// Solving the equation of transfer.
    pub solve: Duration,
}

/// Fills a table on `axes` with transmittance and reflectance. `progress` is told how many of how many steps are done.
///
/// # Errors
/// If an axis or the number of streams is out of range.
pub fn by_ordinates(
    axes: &Axes,
    options: &FillOptions,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<(Table, FillTimes), DatabaseError> {
    axes.check()?;
    options.streams.check()?;
    let samples = samples(axes, options.ice)?;
    for sample in &samples {
        axes.wavelengths_nm.iter().try_for_each(|wavelength_nm| sample.check_wavelength(*wavelength_nm))?;
    }
    let largest_um = samples.iter().map(|sample| sample.grain_size.max_um).fold(0.0, f64::max);
    let plan =
        TallyPlan { degree: options.streams.most(&incidences(axes)), rays: options.tally_rays, seed: options.seed };
    let start = Instant::now();
    let steps = axes.facetness.len() + 1;
    let tally = |(done, sample): (usize, &SnowSample)| {
        progress(done, steps);
        let demand = Demand { largest_um, ..Demand::of_sample(sample, &axes.wavelengths_nm) };
        GrainTallies::new(&Population::of_sample(sample), &demand, &plan)
    };
    let tallies: Vec<GrainTallies> = samples[..axes.facetness.len()].iter().enumerate().map(tally).collect();
    let tally_time = start.elapsed();
    progress(steps - 1, steps);
    let start = Instant::now();
    let blocks: Vec<[Vec<f64>; 2]> = samples
        .par_iter()
        .enumerate()
        .map(|(i, sample)| fill_grain(axes, sample, &tallies[i % tallies.len()], options))
        .collect();
    progress(steps, steps);
    let (transmittance, reflectance) = blocks.into_iter().map(|[t, r]| (t, r)).unzip::<_, _, Vec<_>, Vec<_>>();
    let table = Table {
        axes: axes.clone(),
        transmittance: transmittance.concat(),
        reflectance: reflectance.concat(),
        metadata: metadata(options),
    };
    Ok((table, FillTimes { tally: tally_time, solve: start.elapsed() }))
}

/// The snow of each grain size and, running faster, facetness, at the first density.
fn samples(axes: &Axes, ice: IceTable) -> Result<Vec<SnowSample>, DatabaseError> {
    let mut samples = Vec::new();
    for size_um in &axes.grain_sizes_um {
        for facetness in &axes.facetness {
            let sample = SnowSample {
                grain_size: GrainSize::around(*size_um)?,
                facetness: TruncatedNormal::facetness_around(*facetness),
                ice,
                ..SnowSample::default()
            };
            for density_kg_m3 in &axes.densities_kg_m3 {
                SnowSample { density_kg_m3: *density_kg_m3, ..sample }.check()?;
            }
            samples.push(sample);
        }
    }
    Ok(samples)
}

fn incidences(axes: &Axes) -> Vec<Incidence> {
    axes.angles_deg.iter().map(|angle_deg| Incidence::Beam { angle_deg: *angle_deg }).collect()
}

/// Transmittance and reflectance of one kind of grain: [density][angle][thickness][wavelength].
fn fill_grain(axes: &Axes, sample: &SnowSample, tallies: &GrainTallies, options: &FillOptions) -> [Vec<f64>; 2] {
    let (angles, thicknesses, wavelengths) =
        (axes.angles_deg.len(), axes.thicknesses_cm.len(), axes.wavelengths_nm.len());
    let block = axes.densities_kg_m3.len() * angles * thicknesses * wavelengths;
    let mut filled = [vec![0.0; block], vec![0.0; block]];
    let incidences = incidences(axes);
    let groups = options.streams.groups(&incidences);
    let extinction_per_m =
        |density_kg_m3: &f64| SnowSample { density_kg_m3: *density_kg_m3, ..*sample }.extinction_per_m();
    let extinctions_per_m: Vec<f64> = axes.densities_kg_m3.iter().map(extinction_per_m).collect();
    for (w, wavelength_nm) in axes.wavelengths_nm.iter().enumerate() {
        let scattering = tallies.medium(sample, *wavelength_nm, None).scattering;
        for (streams, of_group) in &groups {
            let medium = HomogeneousMedium::new(&scattering, *streams);
            let lights: Vec<Light> = of_group.iter().map(|a| medium.light(&incidences[*a])).collect();
            for (d, extinction_per_m) in extinctions_per_m.iter().enumerate() {
                for (t, thickness_cm) in axes.thicknesses_cm.iter().enumerate() {
                    let under_each = medium.fluxes(extinction_per_m * thickness_cm * 0.01, &lights);
                    for (a, fluxes) in of_group.iter().zip(under_each) {
                        let place = ((d * angles + a) * thicknesses + t) * wavelengths + w;
                        filled[0][place] = fluxes.transmittance;
                        filled[1][place] = fluxes.reflectance;
                    }
                }
            }
        }
    }
    filled
}

fn metadata(options: &FillOptions) -> Vec<(String, String)> {
    let ice = match options.ice {
        IceTable::WarrenBrandt2008 => "Warren & Brandt 2008",
        IceTable::Picard2016 => "Picard, Libois & Arnaud 2016; Warren & Brandt 2008 above 600 nm",
    };
    [
        ("title", "Spectral transmittance and reflectance of snow".to_owned()),
        ("source", format!("snowblue {}", env!("CARGO_PKG_VERSION"))),
        ("engine", "discrete ordinates".to_owned()),
        ("streams", options.streams.to_string()),
        ("tally_rays", options.tally_rays.to_string()),
        ("seed", options.seed.to_string()),
        ("ice_constants", ice.to_owned()),
        ("grain_size_measure", "greatest extension, mean of a uniform range of +-50 um".to_owned()),
    ]
    .map(|(name, value)| (name.to_owned(), value))
    .to_vec()
}
