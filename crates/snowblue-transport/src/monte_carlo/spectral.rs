//! All wavelengths and all thicknesses of a slab from one set of rays.
//!
//! - **Wavelengths.** A ray's path depends on the wavelength through the refractive index alone; absorption is the
//!   weight exp(−γ(λ)ℓ) of its path ℓ through ice. Rays are therefore traced at a few nodes in n with common random
//!   numbers. Weights are interpolated before they are squared, so the standard errors apply to the interpolated
//!   results.
//! - **Thicknesses.** The first passage of a walk in deep snow below a depth h is the transmission of a slab of
//!   thickness h; a ray that leaves the top without passing h is reflected by that slab.
//! - **Densities.** Walks are in optical depth.
//! - **Grains.** Scattering by a grain does not depend on the position or direction of the ray. The rays of a batch
//!   therefore share one sequence of scattering events, each ray from its entry on, with its own flights, azimuths and
//!   sizes. Each ray has a random sequence, so every mean is unbiased; the rays of a batch are correlated, so the batch
//!   is the unit of the standard error.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use super::rays::{MonteCarloOptions, RayProgress, cos_incidence};
use super::walk::{Absorption, Paths, Scatterers, scattered_cosine};
use crate::medium::{Constituents, hit_size_m};
use crate::optics::IndexNodes;
use crate::rng::Stream;
use crate::sample::SnowSample;
use crate::slab::{Estimate, Incidence, Radiometry, Slab};

/// Least number of batches, which gives the standard error to some 9 %.
const MIN_BATCHES: u64 = 64;
/// Most rays of a batch.
const MAX_RAYS_PER_BATCH: u64 = 256;
/// Most rays of a batch that are traced at a time.
const MAX_TOGETHER: usize = 16;
/// Greatest water saturation at which index nodes are used; snow with more water is traced at each wavelength.
const MAX_WATER: f64 = 0.5;
/// Batches whose sums are held in memory at a time.
const BATCHES_PER_BLOCK: u64 = 256;

/// Data common to all rays of one incidence.
struct Trace {
    nodes: Vec<Node>,
    /// [wavelength][node]
    node_weights: Vec<Vec<f64>>,
    /// [wavelength]
    absorptions: Vec<Absorption>,
    incidence: Incidence,
    rays: u64,
    seed: u64,
}

/// Snow at one wavelength.
struct Node {
    scatterers: Scatterers,
    /// Optical depths, ascending.
    depths: Vec<f64>,
}

/// A ray inside the snow.
struct Ray {
    stream: Stream,
    depth: f64,
    cosine: f64,
    paths: Paths,
    /// Number of depths passed.
    passed: usize,
}

/// Weights of a batch, for each [thickness][wavelength].
struct BatchSums {
    reflected: Vec<f64>,
    transmitted: Vec<f64>,
    /// Buffer for the weights of a ray at each wavelength.
    weights: Vec<f64>,
}

/// Sums over batches for each [thickness][wavelength], of reflected, transmitted and absorbed weight.
struct Sums {
    value: [Vec<f64>; 3],
    square: [Vec<f64>; 3],
    /// Sums of the weight times the rays of the batch.
    product: [Vec<f64>; 3],
    rays: f64,
    square_rays: f64,
    batches: f64,
}

/// Solves a slab for all its wavelengths and thicknesses at once, each incidence separately.
pub(super) fn solve(
    slab: &Slab,
    options: &MonteCarloOptions,
    progress: &(dyn Fn(RayProgress) + Sync),
) -> Vec<Radiometry> {
    let mut order: Vec<usize> = (0..slab.thicknesses_cm.len()).collect();
    order.sort_by(|a, b| slab.thicknesses_cm[*a].total_cmp(&slab.thicknesses_cm[*b]));
    let mut trace = Trace::new(slab, &order, options);
    let (traced, total) = (AtomicU64::new(0), options.rays * slab.incidences.len() as u64);
    let report = |rays: u64| progress(RayProgress { traced: traced.fetch_add(rays, Ordering::Relaxed) + rays, total });
    let mut sums = Vec::new();
    for (number, incidence) in slab.incidences.iter().enumerate() {
        trace.incidence = *incidence;
        trace.seed = Stream::key(options.seed, number as u64);
        sums.push(trace.run(&report));
    }
    let wavelengths = slab.wavelengths_nm.len();
    let mut answer = Vec::new();
    for (i, &thickness_cm) in slab.thicknesses_cm.iter().enumerate() {
        let first = order.iter().position(|other| *other == i).unwrap_or(0) * wavelengths;
        for (&incidence, sums) in slab.incidences.iter().zip(&sums) {
            for (w, &wavelength_nm) in slab.wavelengths_nm.iter().enumerate() {
                let fluxes = [0, 1, 2].map(|quantity| sums.estimate(quantity, first + w)).into();
                answer.push(Radiometry { thickness_cm, incidence, wavelength_nm, fluxes });
            }
        }
    }
    answer
}

/// The wavelengths at which rays are traced.
pub(super) struct TraceNodes {
    /// Wavelengths, in nm.
    pub(super) wavelengths_nm: Vec<f64>,
    /// [wavelength][node]: weights of the nodes for each wavelength of the slab.
    pub(super) weights: Vec<Vec<f64>>,
}

/// Chooses the wavelengths at which rays are traced for `wavelengths_nm`.
///
/// The index of ice varies little and smoothly, so a few nodes serve. Scattering by particles varies too much between
/// wavelengths, so snow with particles is traced at each wavelength. So is snow with much water: scattering by ice in
/// water goes as (1 − n_ice/n_water)², which the fourth decimal of n changes by up to 2.6 %.
pub(super) fn trace_nodes(sample: &SnowSample, wavelengths_nm: &[f64], constituents: &[Constituents]) -> TraceNodes {
    if sample.water_saturation > MAX_WATER || constituents.iter().any(|constituents| !constituents.particles.is_empty())
    {
        let count = wavelengths_nm.len();
        let unit_weights = |place: usize| (0..count).map(|node| if node == place { 1.0 } else { 0.0 }).collect();
        return TraceNodes { wavelengths_nm: wavelengths_nm.to_vec(), weights: (0..count).map(unit_weights).collect() };
    }
    let ice = sample.ice;
    let nodes = IndexNodes::new(ice, wavelengths_nm);
    let weights = wavelengths_nm.iter().map(|wavelength_nm| nodes.weights(ice.index(*wavelength_nm))).collect();
    TraceNodes { wavelengths_nm: nodes.wavelengths_nm(ice, ice.wavelength_range()), weights }
}

impl Trace {
    /// `order` lists the thicknesses from the thinnest to the thickest.
    fn new(slab: &Slab, order: &[usize], options: &MonteCarloOptions) -> Self {
        let constituents_at = |wavelength_nm: &f64| Constituents::new(&slab.sample, *wavelength_nm);
        let constituents: Vec<Constituents> = slab.wavelengths_nm.iter().map(constituents_at).collect();
        let nodes = trace_nodes(&slab.sample, &slab.wavelengths_nm, &constituents);
        let node = |wavelength_nm: &f64| {
            let scatterers = Scatterers::new(&slab.sample, &constituents_at(wavelength_nm));
            let depths = order.iter().map(|i| scatterers.extinction_per_m * slab.thicknesses_cm[*i] * 0.01).collect();
            Node { scatterers, depths }
        };
        let absorption =
            |constituents: &Constituents| Absorption::new(constituents, &Scatterers::new(&slab.sample, constituents));
        Self {
            nodes: nodes.wavelengths_nm.iter().map(node).collect(),
            node_weights: nodes.weights,
            absorptions: constituents.iter().map(absorption).collect(),
            incidence: slab.incidences[0],
            rays: options.rays,
            seed: options.seed,
        }
    }

    /// Traces all batches, on any number of threads, and sums their weights in order.
    fn run(&self, report: &(dyn Fn(u64) + Sync)) -> Sums {
        let batches = self.rays.div_ceil((self.rays / MIN_BATCHES).clamp(1, MAX_RAYS_PER_BATCH));
        let rays_of = |batch: u64| self.rays * batch / batches..self.rays * (batch + 1) / batches;
        let mut sums = Sums::new(self.places());
        for first in (0..batches).step_by(usize::try_from(BATCHES_PER_BLOCK).unwrap_or(usize::MAX)) {
            let block = first..(first + BATCHES_PER_BLOCK).min(batches);
            let results: Vec<BatchSums> = block
                .clone()
                .into_par_iter()
                .map(|batch| {
                    let result = self.trace_batch(rays_of(batch));
                    report(rays_of(batch).end - rays_of(batch).start);
                    result
                })
                .collect();
            for (batch, result) in block.zip(&results) {
                sums.add((rays_of(batch).end - rays_of(batch).start) as f64, result);
            }
        }
        sums
    }

    /// Traces one batch of rays at every index node.
    fn trace_batch(&self, rays: Range<u64>) -> BatchSums {
        let zeros = || vec![0.0; self.places()];
        let weights = vec![0.0; self.absorptions.len()];
        let mut sums = BatchSums { reflected: zeros(), transmitted: zeros(), weights };
        let together = usize::try_from((rays.end - rays.start) / 8).unwrap_or(usize::MAX).clamp(1, MAX_TOGETHER);
        for (number, Node { scatterers, .. }) in self.nodes.iter().enumerate() {
            let mut waiting = rays.clone();
            let mut tracing: Vec<Ray> = waiting.by_ref().take(together).map(|number| self.enter(number)).collect();
            let key = Stream::key(!self.seed, rays.start);
            for hit in 0_u64.. {
                // Waiting rays replace those that leave, before the next grain is drawn.
                tracing.retain_mut(|ray| {
                    loop {
                        if self.fly(ray, number, &mut sums) {
                            return true;
                        }
                        let Some(next) = waiting.next() else { return false };
                        *ray = self.enter(next);
                    }
                });
                if tracing.is_empty() {
                    break;
                }
                let collision = scatterers.collide(&mut Stream::new(key, hit));
                for ray in &mut tracing {
                    collision.add_ice_path(hit_size_m(&scatterers.size, &mut ray.stream), &mut ray.paths);
                    ray.cosine = scattered_cosine(ray.cosine, collision.cos_scattering, &mut ray.stream);
                }
            }
        }
        sums
    }

    fn enter(&self, number: u64) -> Ray {
        let mut stream = Stream::new(self.seed, number);
        let cosine = cos_incidence(self.incidence, &mut stream);
        Ray { stream, depth: 0.0, cosine, paths: Paths::default(), passed: 0 }
    }

    /// Number of thicknesses times number of wavelengths.
    fn places(&self) -> usize {
        self.nodes[0].depths.len() * self.absorptions.len()
    }

    /// Moves a ray to its next scattering event and counts the depths passed for the first time; false if the ray
    /// leaves.
    fn fly(&self, ray: &mut Ray, node: usize, sums: &mut BatchSums) -> bool {
        let (wavelengths, depths) = (self.absorptions.len(), &self.nodes[node].depths);
        let (start, flight, cosine, paths) = (ray.depth, -ray.stream.uniform().ln(), ray.cosine, ray.paths);
        let until = |face: f64| Paths { free: paths.free + (face - start) / cosine, ..paths };
        ray.depth += flight * cosine;
        if ray.depth <= 0.0 {
            self.weigh(node, &until(0.0), &mut sums.weights);
            let thicker = sums.reflected[ray.passed * wavelengths..].chunks_exact_mut(wavelengths);
            thicker.for_each(|slab| add(slab, &sums.weights));
            return false;
        }
        while depths[ray.passed] <= ray.depth {
            self.weigh(node, &until(depths[ray.passed]), &mut sums.weights);
            add(&mut sums.transmitted[ray.passed * wavelengths..][..wavelengths], &sums.weights);
            ray.passed += 1;
            if ray.passed == depths.len() {
                return false;
            }
        }
        ray.paths.free += flight;
        true
    }

    /// The transmittance along some paths at each wavelength, times the weight of a node.
    fn weigh(&self, node: usize, paths: &Paths, values: &mut [f64]) {
        for (value, (absorption, weights)) in values.iter_mut().zip(self.absorptions.iter().zip(&self.node_weights)) {
            // Among particles each node has weight at one wavelength only.
            *value = if weights[node] == 0.0 { 0.0 } else { weights[node] * absorption.transmittance(paths) };
        }
    }
}

impl Sums {
    fn new(places: usize) -> Self {
        let zeros = || [vec![0.0; places], vec![0.0; places], vec![0.0; places]];
        Self { value: zeros(), square: zeros(), product: zeros(), rays: 0.0, square_rays: 0.0, batches: 0.0 }
    }

    fn add(&mut self, rays: f64, batch: &BatchSums) {
        self.rays += rays;
        self.square_rays += rays * rays;
        self.batches += 1.0;
        for (i, (r, t)) in batch.reflected.iter().zip(&batch.transmitted).enumerate() {
            for (quantity, value) in [*r, *t, rays - r - t].into_iter().enumerate() {
                self.value[quantity][i] += value;
                self.square[quantity][i] += value * value;
                self.product[quantity][i] += value * rays;
            }
        }
    }

    /// The ratio of two sums, weight over rays, and its standard error from the scatter of Σ weight − mean · rays over
    /// the batches (Cochran 1977, *Sampling Techniques*, eq. 6.13).
    fn estimate(&self, quantity: usize, place: usize) -> Estimate {
        let mean = self.value[quantity][place] / self.rays;
        let scatter =
            self.square[quantity][place] - 2.0 * mean * self.product[quantity][place] + mean * mean * self.square_rays;
        let correction = self.batches / (self.batches - 1.0).max(1.0);
        Estimate { value: mean, standard_error: (scatter.max(0.0) * correction).sqrt() / self.rays }
    }
}

fn add(sums: &mut [f64], terms: &[f64]) {
    for (sum, term) in sums.iter_mut().zip(terms) {
        *sum += term;
    }
}
