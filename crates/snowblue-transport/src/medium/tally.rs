//! Moments of the scattering by a population of grains, for discrete ordinates.
//!
//! Rays are traced through random grains and the Legendre polynomials of their scattering angles averaged, without
//! bins. Absorption depends on the ice path only: with the size s, the absorption coefficient γ, x = γs and the path ℓ
//! per size, ⟨P_l(cos Θ)·(1 − e^{−xℓ})⟩ is tabulated at x → 0 and on a logarithmic grid of x, and averaged over the
//! sizes with weight s² afterwards. One tally thus serves all sizes, absorption coefficients and densities.
//!
//! The index of ice varies little, so tallies at a few Chebyshev nodes in n, with common random numbers, are
//! interpolated. The points where rays enter grains come from Owen-scrambled Sobol' sequences (Burley 2020, JCGT 9(4));
//! the scrambles are independent, and the scatter between them gives the covariance of the tally, by the jackknife
//! (Quenouille 1956, doi:10.1093/biomet/43.3-4.353).
//!
//! A tally takes most of the time of a spectrum and depends on the grains only, not on the thickness, density or
//! light. The process keeps its last tallies, so that a tally is computed once where only thickness, density or light
//! vary.

use std::collections::VecDeque;
use std::ops::RangeInclusive;
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use super::population::Population;
use super::scattering::Scattering;
use crate::dual::Real;
use crate::optics::{IndexNodes, lagrange};
use crate::quadrature::legendre_polynomials;
use crate::rng::Stream;
use crate::sample::GrainSize;

/// Number of independent scrambles of the sequence, whose scatter gives the standard error.
const BATCHES: usize = 16;
/// Most rays of a batch: the length of the Sobol' sequence.
pub(super) const MAX_RAYS_PER_BATCH: u32 = 1 << 16;
/// Rays per index node for a standard error of some 0.2 % in T of a 15 cm slab.
pub(crate) const DEFAULT_RAYS: u32 = 1 << 18;
/// First x = γs of the grid; below it, the absorbed fraction per x is linear in x.
const FIRST_ABSORPTION: f64 = 1e-4;
const NODES_PER_DECADE: f64 = 4.0;
/// Most tallies that are kept; one has some 0.3 MB with 16 streams and 3 MB with 128.
const MAX_KEPT: usize = 16;

/// Tallies with their requests, the last used first.
static LAST: Mutex<VecDeque<(TallyRequest, Arc<Tally>)>> = Mutex::new(VecDeque::new());

/// Deviations of a quantity with each batch.
pub(super) type Deviations = [f64; BATCHES];

/// Options of a tally.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TallyPlan {
    /// Highest degree l of the moments χ_0 … χ_l.
    pub degree: usize,
    /// Rays per index node, divided among 16 batches.
    pub rays: u32,
    /// Seed of all randomness.
    pub seed: u64,
}

/// Moments of a population of grains, for any size and absorption coefficient.
#[derive(Debug, Clone)]
struct Tally {
    index_nodes: IndexNodes,
    /// Grid of x = γs, after the limit x → 0.
    absorptions: Vec<f64>,
    /// [index node][batch]
    sums: Vec<Vec<Moments>>,
    /// The sums of all batches at each index node.
    totals: Vec<Moments>,
}

/// Sums of one batch, or of all, at one index: ⟨P_l⟩, and ⟨P_l (1 − e^{−xℓ})⟩/x for x → 0 and each x of the grid.
#[derive(Debug, Clone)]
struct Moments {
    scattered: Vec<f64>,
    absorbed: Vec<Vec<f64>>,
    weight: f64,
}

/// Sums of each batch at one index, for some sizes and absorption, over the weight of all batches.
struct BatchSums {
    /// Of all light that meets grains: [batch][degree].
    moments: Vec<f64>,
    /// Of the light that is absorbed.
    absorbed: Vec<f64>,
    /// Weight of each batch over the weight of all batches.
    shares: [f64; BATCHES],
}

/// The part of a tally that a request asks for. The tally may have been made for a wider request: the sums of a
/// degree and of an absorption do not depend on the other degrees and absorptions of the tally.
#[derive(Debug, Clone)]
pub(super) struct TallyPart {
    tally: Arc<Tally>,
    degree: usize,
    /// Number of grid values of x in use. The interpolation near their end depends on it.
    absorptions: usize,
}

/// A request for a tally.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TallyRequest {
    population: Population,
    index_nodes: IndexNodes,
    absorptions: Vec<f64>,
    plan: TallyPlan,
}

impl TallyRequest {
    /// A tally of grains of `population` for every relative index in `indices` and every x = γs up to
    /// `most_absorption`.
    pub(crate) fn new(
        population: &Population,
        indices: RangeInclusive<f64>,
        most_absorption: f64,
        plan: &TallyPlan,
    ) -> Self {
        Self {
            population: population.clone(),
            index_nodes: IndexNodes::between(*indices.start(), *indices.end()),
            absorptions: absorption_grid(most_absorption),
            plan: *plan,
        }
    }

    /// Whether a tally of this request has all that `other` asks for.
    fn covers(&self, other: &Self) -> bool {
        let TallyPlan { degree, rays, seed } = other.plan;
        (&self.population, &self.index_nodes) == (&other.population, &other.index_nodes)
            && (self.plan.rays, self.plan.seed) == (rays, seed)
            && self.plan.degree >= degree
            && self.absorptions.len() >= other.absorptions.len()
    }

    /// The part that this request asks for, of a tally whose request covers it.
    fn part_of(&self, tally: Arc<Tally>) -> TallyPart {
        TallyPart { tally, degree: self.plan.degree, absorptions: self.absorptions.len() }
    }

    /// The part that this request asks for, of a kept or a new tally. The part does not depend on the tally from
    /// which it is taken.
    pub(super) fn part(self) -> TallyPart {
        if let Some(kept) = self.kept() {
            return self.part_of(kept);
        }
        // Nothing is locked while rays are traced: a thread that waits for rays may start another tally meanwhile.
        let tally = Arc::new(self.tally());
        let part = self.part_of(Arc::clone(&tally));
        let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
        last.push_front((self, tally));
        last.truncate(MAX_KEPT);
        part
    }

    fn kept(&self) -> Option<Arc<Tally>> {
        let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
        let place = last.iter().position(|(made, _)| made.covers(self))?;
        let found = last.remove(place)?;
        let tally = Arc::clone(&found.1);
        last.push_front(found);
        Some(tally)
    }

    /// Traces the rays.
    fn tally(&self) -> Tally {
        let Self { population, index_nodes, absorptions, plan } = self;
        let jobs: Vec<(f64, usize)> =
            index_nodes.nodes().iter().flat_map(|n| (0..BATCHES).map(move |batch| (*n, batch))).collect();
        let mut moments: Vec<Moments> =
            jobs.into_par_iter().map(|(n, batch)| run_batch(population, n, batch, absorptions, plan)).collect();
        let mut sums: Vec<Vec<Moments>> = Vec::with_capacity(index_nodes.nodes().len());
        for _ in index_nodes.nodes() {
            sums.push(moments.drain(..BATCHES).collect());
        }
        let totals = sums.iter().map(|batches| Moments::total(batches)).collect();
        Tally { index_nodes: index_nodes.clone(), absorptions: absorptions.clone(), sums, totals }
    }
}

impl TallyPart {
    /// The highest degree l of the moments.
    pub(crate) fn degree(&self) -> usize {
        self.degree
    }

    /// The part up to a lower degree and a smaller x = γs.
    ///
    /// # Panics
    /// If the degree or x exceeds the degree or the x of this part.
    pub(super) fn narrowed(&self, degree: usize, most_absorption: f64) -> Self {
        let absorptions = absorption_count(most_absorption);
        assert!(degree <= self.degree && absorptions <= self.absorptions, "the tally has no such part");
        Self { tally: Arc::clone(&self.tally), degree, absorptions }
    }

    #[cfg(test)]
    fn is_of_the_tally_of(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.tally, &other.tally)
    }

    /// Single scattering by grains of the given sizes, relative index n and absorption coefficient in 1/m.
    pub(super) fn scattering<T: Real>(&self, size: &GrainSize, n: f64, absorption_per_m: T) -> Scattering<T> {
        let columns = self.absorption_columns(size, absorption_per_m);
        let (mut moments, mut absorbed) = (vec![0.0; self.degree + 1], vec![T::from(0.0); self.degree + 1]);
        for (index_weight, total) in self.tally.index_nodes.weights(n).into_iter().zip(&self.tally.totals) {
            let factor = index_weight / total.weight;
            add_scaled(&mut moments, factor, &total.scattered);
            for (strength, column) in &columns {
                add_scaled(&mut absorbed, *strength * factor, &total.absorbed[*column]);
            }
        }
        let one_minus_albedo = absorbed[0];
        let kept = |(moment, lost): (&f64, &T)| (T::from(*moment) - *lost) / (T::from(1.0) - one_minus_albedo);
        Scattering { one_minus_albedo, moments: moments.iter().zip(&absorbed).map(kept).collect() }
    }

    /// Single scattering, and the deviations of the co-albedo and of the moments χ_1, χ_2, … with each batch by the
    /// infinitesimal jackknife (Efron 1982, *The Jackknife, the Bootstrap and Other Resampling Plans*, ch. 6):
    /// derivatives by the weight of the batch, scaled so that their products sum to the covariance.
    pub(super) fn deviations(&self, size: &GrainSize, n: f64, absorption_per_m: f64) -> (Scattering, Vec<Deviations>) {
        let width = self.degree + 1;
        let sums = self.sums(size, n, absorption_per_m);
        let [all_moments, all_absorbed] = [total(&sums.moments, width), total(&sums.absorbed, width)];
        let scattering = self.scattering(size, n, absorption_per_m);
        let scale = (BATCHES as f64 / (BATCHES as f64 - 1.0)).sqrt();
        let per_kept = scale / (1.0 - scattering.one_minus_albedo);
        let mut deviations = vec![[0.0; BATCHES]; width];
        let batches = sums.moments.chunks_exact(width).zip(sums.absorbed.chunks_exact(width)).zip(sums.shares);
        for (place, ((moments, absorbed), share)) in batches.enumerate() {
            let coalbedo = absorbed[0] - share * all_absorbed[0];
            for (l, deviation) in deviations.iter_mut().enumerate() {
                let lost = absorbed[l] - share * all_absorbed[l] - scattering.moments[l] * coalbedo;
                deviation[place] = per_kept * (moments[l] - share * all_moments[l] - lost);
            }
            deviations[0][place] = scale * coalbedo;
        }
        (scattering, deviations)
    }

    /// The sums of each batch.
    fn sums(&self, size: &GrainSize, n: f64, absorption_per_m: f64) -> BatchSums {
        let width = self.degree + 1;
        let columns = self.absorption_columns(size, absorption_per_m);
        let (mut moments, mut absorbed) = (vec![0.0; BATCHES * width], vec![0.0; BATCHES * width]);
        let mut shares = [0.0; BATCHES];
        let nodes = self.tally.sums.iter().zip(&self.tally.totals);
        for (index_weight, (batches, Moments { weight, .. })) in
            self.tally.index_nodes.weights(n).into_iter().zip(nodes)
        {
            let sums = moments.chunks_exact_mut(width).zip(absorbed.chunks_exact_mut(width));
            for ((batch, (moments, absorbed)), share) in batches.iter().zip(sums).zip(&mut shares) {
                add_scaled(moments, index_weight / weight, &batch.scattered);
                for (strength, column) in &columns {
                    add_scaled(absorbed, *strength * (index_weight / weight), &batch.absorbed[*column]);
                }
                // The rays are common, so the share is equal at all indices.
                *share = batch.weight / weight;
            }
        }
        BatchSums { moments, absorbed, shares }
    }

    /// The weights of columns of absorbed moments, averaged over the sizes: x times the interpolation weights at x.
    fn absorption_columns<T: Real>(&self, size: &GrainSize, absorption_per_m: T) -> Vec<(T, usize)> {
        let grid = &self.tally.absorptions[..self.absorptions];
        let mut columns = vec![T::from(0.0); grid.len() + 1];
        for (size_um, weight) in size.by_area_um() {
            let x = absorption_per_m * size_um * 1e-6;
            let strength = x * weight;
            for (column, weight) in columns.iter_mut().zip(interpolation_weights(grid, x)) {
                *column += strength * weight;
            }
        }
        columns.into_iter().zip(0..).filter(|(strength, _)| !strength.is_zero()).collect()
    }
}

impl Moments {
    /// The sums of some batches.
    fn total(batches: &[Self]) -> Self {
        let mut total = batches[0].clone();
        for batch in &batches[1..] {
            total.weight += batch.weight;
            add_scaled(&mut total.scattered, 1.0, &batch.scattered);
            let columns = total.absorbed.iter_mut().zip(&batch.absorbed);
            columns.for_each(|(sums, terms)| add_scaled(sums, 1.0, terms));
        }
        total
    }
}

/// The sum of rows of some width.
fn total(rows: &[f64], width: usize) -> Vec<f64> {
    let mut total = vec![0.0; width];
    rows.chunks_exact(width).for_each(|row| add_scaled(&mut total, 1.0, row));
    total
}

fn run_batch(population: &Population, n: f64, batch: usize, absorptions: &[f64], plan: &TallyPlan) -> Moments {
    let batches = u32::try_from(BATCHES).unwrap_or(u32::MAX);
    let rays = plan.rays.div_ceil(batches).clamp(1, MAX_RAYS_PER_BATCH);
    let zeros = || vec![0.0; plan.degree + 1];
    let mut sums = Moments { scattered: zeros(), absorbed: vec![zeros(); absorptions.len() + 1], weight: 0.0 };
    let mut polynomials = zeros();
    let scramble = scramble(plan.seed, batch);
    for ray in 0..rays {
        let mut stream = Stream::on_sequence(plan.seed, ((batch as u64) << 32) | u64::from(ray), ray, scramble);
        let (scattered, weight) = population.scatter(n, &mut stream);
        legendre_polynomials(scattered.cos_scattering, &mut polynomials);
        sums.weight += weight;
        add_scaled(&mut sums.scattered, weight, &polynomials);
        if scattered.ice_path > 0.0 {
            add_scaled(&mut sums.absorbed[0], weight * scattered.ice_path, &polynomials);
            for (x, column) in absorptions.iter().zip(&mut sums.absorbed[1..]) {
                add_scaled(column, -weight * (-x * scattered.ice_path).exp_m1() / x, &polynomials);
            }
        }
    }
    sums
}

fn add_scaled<T: Real>(sums: &mut [T], factor: T, terms: &[f64]) {
    for (sum, term) in sums.iter_mut().zip(terms) {
        *sum += factor * *term;
    }
}

/// The scramble of a batch for a seed.
pub(super) fn scramble(seed: u64, batch: usize) -> u32 {
    let mut stream = Stream::new(seed, u64::MAX - batch as u64);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a uniform number times 2³² fits")]
    let scramble = (stream.uniform() * 4_294_967_296.0) as u32;
    scramble
}

/// A value of the grid of x.
fn grid_absorption(i: usize) -> f64 {
    FIRST_ABSORPTION * 10_f64.powf(i as f64 / NODES_PER_DECADE)
}

/// The number of grid values, two or more, of which the last is not below `most`.
fn absorption_count(most: f64) -> usize {
    let mut count = 2;
    while grid_absorption(count - 1) < most {
        count += 1;
    }
    count
}

fn absorption_grid(most: f64) -> Vec<f64> {
    (0..absorption_count(most)).map(grid_absorption).collect()
}

/// Interpolation weights at `x` of the limit x → 0 and of each grid value: linear in x below the grid, cubic in ln x on
/// it.
fn interpolation_weights<T: Real>(grid: &[f64], x: T) -> Vec<T> {
    let mut weights = vec![T::from(0.0); grid.len() + 1];
    if x.value() <= grid[0] {
        weights[1] = x / grid[0];
        weights[0] = T::from(1.0) - weights[1];
        return weights;
    }
    let above = grid.partition_point(|node| *node < x.value()).min(grid.len() - 1);
    let last = grid.len().min((above + 2).max(4));
    let first = last.saturating_sub(4);
    let logarithms: Vec<f64> = grid[first..last].iter().map(|node| node.ln()).collect();
    for (i, weight) in lagrange(&logarithms, x.ln()).into_iter().enumerate() {
        weights[1 + first + i] = weight;
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::super::population::Population;
    use super::*;
    use crate::sample::SnowSample;

    #[test]
    fn interpolation_on_the_absorption_grid_reproduces_an_exponential() {
        let grid = absorption_grid(10.0);
        let ratio = |x: f64| if x > 0.0 { -(-x).exp_m1() / x } else { 1.0 };
        for i in 0..600 {
            let x = 1e-6 * 10_f64.powf(f64::from(i) / 100.0);
            let weights = interpolation_weights(&grid, x);
            let value: f64 = weights.iter().zip(std::iter::once(&0.0).chain(&grid)).map(|(w, x)| w * ratio(*x)).sum();
            // Cubic interpolation with 4 nodes per decade of a function that falls over two decades.
            assert!((value / ratio(x) - 1.0).abs() < 2e-3, "{x} {value} {}", ratio(x));
        }
    }

    fn request(degree: usize, most_absorption: f64, seed: u64) -> TallyRequest {
        let plan = TallyPlan { degree, rays: 64, seed };
        TallyRequest::new(&Population::of_sample(&SnowSample::default()), 1.30..=1.31, most_absorption, &plan)
    }

    #[test]
    fn requests_within_a_tally_share_it_and_others_do_not() {
        // Other tests of this process may use the cache in between, but not sixteen others at once.
        let first = request(4, 0.1, 7).part();
        let shares = |other: TallyRequest| first.is_of_the_tally_of(&other.part());
        assert!(shares(request(4, 0.1, 7)) && shares(request(3, 0.1, 7)) && shares(request(4, 0.001, 7)));
        assert!(!shares(request(4, 0.1, 8)) && !shares(request(5, 0.1, 7)) && !shares(request(4, 10.0, 7)));
    }

    /// The parts agree to the last bit on any number of threads, so that the spectrum of a snow does not depend on
    /// other snows.
    #[test]
    fn a_part_of_a_wider_tally_is_the_tally_of_a_narrower_request() {
        let sample = SnowSample::default();
        let tally_on = |threads: usize, request: &TallyRequest| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            Arc::new(pool.install(|| request.tally()))
        };
        let narrow = request(4, 0.1, 9);
        let own = narrow.part_of(tally_on(1, &narrow));
        let wide = request(12, 30.0, 9);
        let shared = narrow.part_of(tally_on(3, &wide));
        let narrowed = wide.part_of(tally_on(2, &wide)).narrowed(4, 0.1);
        // From weak absorption to the end of the narrower grid, x = 0.1, where the interpolation has no later values.
        for absorption_per_m in [0.01, 3.0, 100.0, 220.0] {
            let of = |part: &TallyPart| {
                let whole = part.scattering(&sample.grain_size, 1.304, absorption_per_m);
                (whole, part.deviations(&sample.grain_size, 1.304, absorption_per_m))
            };
            assert_eq!(of(&own), of(&shared));
            assert_eq!(of(&own), of(&narrowed));
        }
    }
}
