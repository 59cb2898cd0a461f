//! The hot paths of both engines, on one thread: `cargo bench -p snowblue-transport`.

#![allow(clippy::unwrap_used, reason = "a bench may panic")]

use divan::{Bencher, black_box, counter::ItemsCount};
use snowblue_transport::Scattering;
use snowblue_transport::batch::{Batch, SlabCase};
use snowblue_transport::grain::Grain;
use snowblue_transport::grain::Spheroid;
use snowblue_transport::monte_carlo::{self, MonteCarloOptions};
use snowblue_transport::ordinates::{
    HalfSpace, HomogeneousMedium, OrdinatesOptions, differentiate_batch, differentiate_stack,
};
use snowblue_transport::rng::Stream;
use snowblue_transport::sample::{GrainSize, SizeMeasure, SnowSample};
use snowblue_transport::slab::{Incidence, Slab};
use snowblue_transport::stack::{Layer, Stack};
use snowblue_transport::{Demand, GrainTallies, PhaseFunction, PhasePlan, Population, TallyPlan, Variable};

fn main() {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().unwrap();
    divan::main();
}

fn visible_nm() -> Vec<f64> {
    (40..=70).map(|ten| 10.0 * f64::from(ten)).collect()
}

/// One ray and one grain of sphericity 0.8, by the roughness of its surface.
#[divan::bench(args = [0.0, 0.075, 0.2])]
fn grain_hit(bencher: Bencher, roughness: f64) {
    let shape = Spheroid::of_unit_size(0.8, SizeMeasure::GreatestExtension);
    let grain = Grain { shape, roughness, relative_index: 1.31 };
    let mut stream = Stream::new(1, 0);
    bencher
        .counter(ItemsCount::new(1000_usize))
        .bench_local(|| (0..1000).map(|_| black_box(grain).scatter(&mut stream).cos_scattering).sum::<f64>());
}

/// Scattering events of Monte Carlo walks through 3 cm of the default snow under Lambertian light: 2κh = 99.5 per ray.
#[divan::bench(sample_count = 10)]
fn monte_carlo_hit(bencher: Bencher) {
    let slab = Slab {
        sample: SnowSample::default(),
        thicknesses_cm: vec![3.0],
        incidences: vec![Incidence::Diffuse],
        wavelengths_nm: vec![550.0],
    };
    let rays = 16_384_u64;
    let hits = rays as f64 * 2.0 * slab.optical_depth(3.0);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count of some millions")]
    let hits = hits as u64;
    let options = MonteCarloOptions { rays, ..MonteCarloOptions::default() };
    bencher.counter(ItemsCount::new(hits)).bench_local(|| monte_carlo::solve(&slab, &options, &|_| ()).unwrap());
}

/// Transmittance and reflectance at 31 wavelengths of one slab at one angle, from given moments of the grains.
#[divan::bench(args = [8, 16, 32, 64])]
fn spectrum_by_ordinates(bencher: Bencher, streams: usize) {
    let sample = SnowSample::default();
    let plan = TallyPlan { degree: streams, rays: 1 << 12, seed: 1 };
    let (population, wavelengths_nm) = (Population::of_sample(&sample), visible_nm());
    let tallies = GrainTallies::new(&population, &Demand::of_sample(&sample, &wavelengths_nm), &plan);
    let medium = |wavelength_nm: &f64| tallies.medium(&sample, *wavelength_nm).scattering;
    let optics: Vec<Scattering> = wavelengths_nm.iter().map(medium).collect();
    bencher.bench_local(|| {
        let flux = |scattering: &Scattering| {
            let medium = HomogeneousMedium::new(scattering, streams);
            medium.fluxes(black_box(250.0), &[medium.beam(0.5)])[0].transmittance
        };
        optics.iter().map(flux).sum::<f64>()
    });
}

/// Transmittance and reflectance at 31 wavelengths of one slab of dry snow, and their derivatives by some
/// variables, from kept tallies.
#[divan::bench(args = [0, 1, 4, 8])]
fn derivatives_by_ordinates(bencher: Bencher, variables: usize) {
    differentiate(bencher, SnowSample::default(), 1, variables);
}

/// The same for wet snow, which takes 64 streams.
#[divan::bench(args = [0, 4])]
fn derivatives_of_wet_snow(bencher: Bencher, variables: usize) {
    differentiate(bencher, SnowSample { water_saturation: 0.1, ..SnowSample::default() }, 1, variables);
}

/// The same for 100 thicknesses of a snow.
#[divan::bench(args = [0, 4])]
fn derivatives_of_many_slabs(bencher: Bencher, variables: usize) {
    differentiate(bencher, SnowSample::default(), 100, variables);
}

/// The same for five layers on a ground, each with its own derivatives, without and with four depths.
#[divan::bench(args = [(0, 0), (0, 4), (4, 0), (4, 4)])]
fn derivatives_of_layers(bencher: Bencher, (variables, depths): (usize, u32)) {
    let layer = |place: u32| {
        let grain_size = GrainSize::from_specific_surface_area(40.0 / f64::from(place), -5.0).unwrap();
        Layer::snow(SnowSample { grain_size, ..SnowSample::default() }, 2.0 * f64::from(place))
    };
    let stack = Stack {
        layers: (1..=5).map(layer).collect(),
        ground_albedo: 0.2.into(),
        depths_cm: (1..=depths).map(|place| 7.0 * f64::from(place)).collect(),
        incidences: vec![Incidence::Beam { angle_deg: 60.0 }],
        wavelengths_nm: visible_nm(),
    };
    let options = OrdinatesOptions { tally_rays: 1 << 12, ..OrdinatesOptions::default() };
    let variables = &Variable::all()[..variables];
    bencher.bench_local(|| differentiate_stack(black_box(&stack), variables, &options, false).unwrap());
}

fn differentiate(bencher: Bencher, sample: SnowSample, slabs: u32, variables: usize) {
    let incidence = Incidence::Beam { angle_deg: 60.0 };
    let case =
        |place: u32| SlabCase { sample: 0, thickness_cm: 5.0 + f64::from(place), incidence, ground_albedo: 0.0.into() };
    let batch = Batch { samples: vec![sample], cases: (0..slabs).map(case).collect(), wavelengths_nm: visible_nm() };
    let options = OrdinatesOptions { tally_rays: 1 << 12, ..OrdinatesOptions::default() };
    let variables = &Variable::all()[..variables];
    bencher.bench_local(|| differentiate_batch(black_box(&batch), variables, &options, false, &|_| ()).unwrap());
}

/// Rays of the grain tally at one index node, 33 moments.
#[divan::bench(sample_count = 10)]
fn tally_ray(bencher: Bencher) {
    let sample = SnowSample::default();
    let population = Population::of_sample(&sample);
    let demand = Demand::of_sample(&sample, &[550.0]);
    let plan = TallyPlan { degree: 32, rays: 1 << 16, seed: 1 };
    bencher.counter(ItemsCount::new(1_usize << 16)).bench_local(|| GrainTallies::new(&population, &demand, &plan));
}

/// The phase function of dry snow by the default plan.
#[divan::bench(sample_count = 10)]
fn phase_function_of_sample(bencher: Bencher) {
    let sample = SnowSample::default();
    bencher.bench_local(|| PhaseFunction::of_sample(&sample, 550.0, &PhasePlan::default()).unwrap());
}

/// The half-space of a phase function.
#[divan::bench(sample_count = 10)]
fn half_space(bencher: Bencher) {
    let phase = PhaseFunction::henyey_greenstein(0.7);
    bencher.bench_local(|| HalfSpace::new(black_box(&phase)));
}

/// Escape functions at random cosines.
#[divan::bench]
fn half_space_escape(bencher: Bencher) {
    let half_space = HalfSpace::new(&PhaseFunction::henyey_greenstein(0.7));
    let mut stream = Stream::new(1, 0);
    bencher
        .counter(ItemsCount::new(1000_usize))
        .bench_local(|| (0..1000).map(|_| half_space.escape(stream.uniform())).sum::<f64>());
}

/// Reflection functions at random angles.
#[divan::bench]
fn half_space_reflection(bencher: Bencher) {
    let half_space = HalfSpace::new(&PhaseFunction::henyey_greenstein(0.7));
    let mut stream = Stream::new(1, 0);
    let mut reflection = || half_space.reflection(stream.uniform(), stream.uniform(), 2.0 * stream.uniform() - 1.0);
    bencher.counter(ItemsCount::new(1000_usize)).bench_local(|| (0..1000).map(|_| reflection()).sum::<f64>());
}
