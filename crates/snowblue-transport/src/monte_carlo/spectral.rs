//! One trace for everything: all wavelengths and all thicknesses.
//!
//! - **Wavelengths.** A ray's way depends on the wavelength through the refractive index alone; absorption is the weight
//!   exp(−γ(λ)ℓ) of its path ℓ through ice. So rays are traced at a few nodes in n with common random numbers, and what
//!   they bring is interpolated before it is squared, so that the standard errors are those of what is printed.
//! - **Thicknesses.** The first passage of a walk in deep snow below a depth h *is* the transmission of a slab of
//!   thickness h; a ray that comes out on top having stayed above h *is* the reflection of that slab.
//! - **Densities.** The walk lives in optical depth.
//! - **Grains.** What a grain does knows nothing of where the ray is or whither it goes. The rays of a team therefore share
//!   one sequence of scatterings, each ray from where it enters, with flights, azimuths and sizes of its own. To each ray
//!   the sequence is fresh, so that every mean is exact; that the rays of a team are not independent is honoured by taking
//!   the team, not the ray, as the unit of the standard error.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use super::options::{MonteCarloOptions, cos_incidence};
use super::walk::{Absorption, Paths, Scatterers, turn};
use crate::medium::{Constituents, hit_size_m};
use crate::optics::{Ice, IndexNodes};
use crate::rng::Stream;
use crate::sample::SnowSample;
use crate::slab::{Estimate, Incidence, Radiometry, Slab};

/// Teams that the rays are split into at the least, so that their scatter is known to some 9 %.
const LEAST_TEAMS: u64 = 64;
/// Rays of a team at the most.
const MOST_RAYS_PER_TEAM: u64 = 256;
/// Rays of a team that are on their way at one time.
const MOST_TOGETHER: usize = 16;
/// Snow with more of its pores filled is traced at each wavelength; with less, grains in water turn a sixtieth of the light.
const MOST_WATER: f64 = 0.5;
/// Teams whose sums are kept at a time before they are added up in order.
const TEAMS_PER_BLOCK: u64 = 256;

/// What is the same for all rays of one incidence.
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

/// Snow as rays see it at one wavelength.
struct Node {
    scatterers: Scatterers,
    /// Optical depths, ascending.
    depths: Vec<f64>,
}

/// A ray on its way.
struct Walker {
    stream: Stream,
    depth: f64,
    cosine: f64,
    paths: Paths,
    /// How many of the depths it has passed.
    passed: usize,
}

/// What a team brought, for each [thickness][wavelength]: reflected and transmitted weight.
struct Catch {
    reflected: Vec<f64>,
    transmitted: Vec<f64>,
    /// A spectrum on its way into the two.
    left: Vec<f64>,
}

/// Sums over teams for each [thickness][wavelength], of reflected, transmitted and absorbed weight.
struct Sums {
    value: [Vec<f64>; 3],
    square: [Vec<f64>; 3],
    /// Of the weight times the team's rays.
    product: [Vec<f64>; 3],
    rays: f64,
    square_rays: f64,
    teams: f64,
}

/// Solves a slab for all its wavelengths and thicknesses at once, each incidence on its own.
pub(super) fn solve(slab: &Slab, options: &MonteCarloOptions, progress: &(dyn Fn(u64, u64) + Sync)) -> Vec<Radiometry> {
    let mut order: Vec<usize> = (0..slab.thicknesses_cm.len()).collect();
    order.sort_by(|a, b| slab.thicknesses_cm[*a].total_cmp(&slab.thicknesses_cm[*b]));
    let mut trace = Trace::new(slab, &order, options);
    let (done, all) = (AtomicU64::new(0), options.rays * slab.incidences.len() as u64);
    let told = |rays: u64| progress(done.fetch_add(rays, Ordering::Relaxed) + rays, all);
    let mut sums = Vec::new();
    for (number, incidence) in slab.incidences.iter().enumerate() {
        trace.incidence = *incidence;
        trace.seed = Stream::key(options.seed, number as u64);
        sums.push(trace.run(&told));
    }
    let wavelengths = slab.wavelengths_nm.len();
    let mut answer = Vec::new();
    for (i, &thickness_cm) in slab.thicknesses_cm.iter().enumerate() {
        let first = order.iter().position(|other| *other == i).unwrap_or(0) * wavelengths;
        for (&incidence, sums) in slab.incidences.iter().zip(&sums) {
            for (w, &wavelength_nm) in slab.wavelengths_nm.iter().enumerate() {
                let [reflectance, transmittance, absorptance] = [0, 1, 2].map(|q| sums.estimate(q, first + w));
                answer.push(Radiometry {
                    thickness_cm,
                    incidence,
                    wavelength_nm,
                    reflectance,
                    transmittance,
                    absorptance,
                });
            }
        }
    }
    answer
}

/// The wavelengths, in nm, at which rays are traced, and the weights [wavelength][node] with which each wavelength that is
/// asked for is composed of them.
///
/// The index of ice varies little and smoothly. Particles scatter so differently from one wavelength to the next that rays
/// among them are traced at each wavelength; so are those in snow that is mostly water, since what ice in water turns goes
/// as (1 − n_ice/n_water)², of which the fourth decimal of n is up to 2.6 %.
pub(super) fn nodes(sample: &SnowSample, wavelengths_nm: &[f64], met: &[Constituents]) -> (Vec<f64>, Vec<Vec<f64>>) {
    if sample.water_saturation > MOST_WATER || met.iter().any(|met| !met.particles.is_empty()) {
        let count = wavelengths_nm.len();
        let one = |place: usize| (0..count).map(|node| if node == place { 1.0 } else { 0.0 }).collect();
        return (wavelengths_nm.to_vec(), (0..count).map(one).collect());
    }
    let ice = Ice::new(sample.ice);
    let nodes = IndexNodes::new(&ice, wavelengths_nm);
    let weights = wavelengths_nm.iter().map(|wavelength_nm| nodes.weights(ice.index(*wavelength_nm))).collect();
    (nodes.wavelengths_nm(&ice, ice.range_nm()), weights)
}

impl Trace {
    /// `order` lists the thicknesses from the thinnest to the thickest.
    fn new(slab: &Slab, order: &[usize], options: &MonteCarloOptions) -> Self {
        let constituents = |wavelength_nm: &f64| Constituents::new(&slab.sample, *wavelength_nm);
        let met: Vec<Constituents> = slab.wavelengths_nm.iter().map(constituents).collect();
        let (nodes_nm, node_weights) = nodes(&slab.sample, &slab.wavelengths_nm, &met);
        let node = |wavelength_nm: &f64| {
            let scatterers = Scatterers::new(&slab.sample, &constituents(wavelength_nm));
            let depths = order.iter().map(|i| scatterers.extinction_per_m * slab.thicknesses_cm[*i] * 0.01).collect();
            Node { scatterers, depths }
        };
        let absorption = |met: &Constituents| Absorption::new(met, &Scatterers::new(&slab.sample, met));
        Self {
            nodes: nodes_nm.iter().map(node).collect(),
            node_weights,
            absorptions: met.iter().map(absorption).collect(),
            incidence: slab.incidences[0],
            rays: options.rays,
            seed: options.seed,
        }
    }

    /// Sends all teams, on any number of threads, and adds up what they bring in their order.
    fn run(&self, told: &(dyn Fn(u64) + Sync)) -> Sums {
        let teams = self.rays.div_ceil((self.rays / LEAST_TEAMS).clamp(1, MOST_RAYS_PER_TEAM));
        let rays_of = |team: u64| self.rays * team / teams..self.rays * (team + 1) / teams;
        let mut sums = Sums::new(self.places());
        for first in (0..teams).step_by(usize::try_from(TEAMS_PER_BLOCK).unwrap_or(usize::MAX)) {
            let block = first..(first + TEAMS_PER_BLOCK).min(teams);
            let caught: Vec<Catch> = block
                .clone()
                .into_par_iter()
                .map(|team| {
                    let caught = self.send(rays_of(team));
                    told(rays_of(team).end - rays_of(team).start);
                    caught
                })
                .collect();
            for (team, caught) in block.zip(&caught) {
                sums.add((rays_of(team).end - rays_of(team).start) as f64, caught);
            }
        }
        sums
    }

    /// Sends one team of rays through the snow at every index node.
    fn send(&self, rays: Range<u64>) -> Catch {
        let zeros = || vec![0.0; self.places()];
        let left = vec![0.0; self.absorptions.len()];
        let mut caught = Catch { reflected: zeros(), transmitted: zeros(), left };
        let together = usize::try_from((rays.end - rays.start) / 8).unwrap_or(usize::MAX).clamp(1, MOST_TOGETHER);
        for (number, Node { scatterers, .. }) in self.nodes.iter().enumerate() {
            let mut waiting = rays.clone();
            let mut walkers: Vec<Walker> = waiting.by_ref().take(together).map(|ray| self.enter(ray)).collect();
            let key = Stream::key(!self.seed, rays.start);
            for hit in 0_u64.. {
                // Those who leave make room for those who wait, before the next grain is met.
                walkers.retain_mut(|walker| {
                    loop {
                        if self.fly(walker, number, &mut caught) {
                            return true;
                        }
                        let Some(ray) = waiting.next() else { return false };
                        *walker = self.enter(ray);
                    }
                });
                if walkers.is_empty() {
                    break;
                }
                let met = scatterers.meet(&mut Stream::new(key, hit));
                for walker in &mut walkers {
                    met.lengthen(hit_size_m(&scatterers.size, &mut walker.stream), &mut walker.paths);
                    walker.cosine = turn(walker.cosine, met.cos_scattering, &mut walker.stream);
                }
            }
        }
        caught
    }

    fn enter(&self, ray: u64) -> Walker {
        let mut stream = Stream::new(self.seed, ray);
        let cosine = cos_incidence(self.incidence, &mut stream);
        Walker { stream, depth: 0.0, cosine, paths: Paths::default(), passed: 0 }
    }

    /// Number of thicknesses times that of wavelengths.
    fn places(&self) -> usize {
        self.nodes[0].depths.len() * self.absorptions.len()
    }

    /// Flies to the next grain; counts the depths that are passed for the first time. False if the ray left.
    fn fly(&self, walker: &mut Walker, node: usize, caught: &mut Catch) -> bool {
        let (wavelengths, depths) = (self.absorptions.len(), &self.nodes[node].depths);
        let (start, flight, cosine, paths) = (walker.depth, -walker.stream.uniform().ln(), walker.cosine, walker.paths);
        let until = |face: f64| Paths { free: paths.free + (face - start) / cosine, ..paths };
        walker.depth += flight * cosine;
        if walker.depth <= 0.0 {
            self.weigh(node, &until(0.0), &mut caught.left);
            let thicker = caught.reflected[walker.passed * wavelengths..].chunks_exact_mut(wavelengths);
            thicker.for_each(|slab| add(slab, &caught.left));
            return false;
        }
        while depths[walker.passed] <= walker.depth {
            self.weigh(node, &until(depths[walker.passed]), &mut caught.left);
            add(&mut caught.transmitted[walker.passed * wavelengths..][..wavelengths], &caught.left);
            walker.passed += 1;
            if walker.passed == depths.len() {
                return false;
            }
        }
        walker.paths.free += flight;
        true
    }

    /// What is left of each wavelength after some paths, times its weight of a node.
    fn weigh(&self, node: usize, paths: &Paths, left: &mut [f64]) {
        for (value, (absorption, weights)) in left.iter_mut().zip(self.absorptions.iter().zip(&self.node_weights)) {
            // Most nodes count for one wavelength alone among particles.
            *value = if weights[node] == 0.0 { 0.0 } else { weights[node] * absorption.left(paths) };
        }
    }
}

impl Sums {
    fn new(places: usize) -> Self {
        let zeros = || [vec![0.0; places], vec![0.0; places], vec![0.0; places]];
        Self { value: zeros(), square: zeros(), product: zeros(), rays: 0.0, square_rays: 0.0, teams: 0.0 }
    }

    fn add(&mut self, rays: f64, caught: &Catch) {
        self.rays += rays;
        self.square_rays += rays * rays;
        self.teams += 1.0;
        for (i, (r, t)) in caught.reflected.iter().zip(&caught.transmitted).enumerate() {
            for (quantity, value) in [*r, *t, rays - r - t].into_iter().enumerate() {
                self.value[quantity][i] += value;
                self.square[quantity][i] += value * value;
                self.product[quantity][i] += value * rays;
            }
        }
    }

    /// The ratio of two sums, weight over rays, and its standard error from the scatter of Σ weight − mean · rays over the
    /// teams (Cochran 1977, *Sampling Techniques*, eq. 6.13).
    fn estimate(&self, quantity: usize, place: usize) -> Estimate {
        let mean = self.value[quantity][place] / self.rays;
        let scatter =
            self.square[quantity][place] - 2.0 * mean * self.product[quantity][place] + mean * mean * self.square_rays;
        let correction = self.teams / (self.teams - 1.0).max(1.0);
        Estimate { value: mean, standard_error: (scatter.max(0.0) * correction).sqrt() / self.rays }
    }
}

fn add(sums: &mut [f64], terms: &[f64]) {
    for (sum, term) in sums.iter_mut().zip(terms) {
        *sum += term;
    }
}
