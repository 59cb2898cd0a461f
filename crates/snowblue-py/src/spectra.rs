//! Spectra of slabs and stacks, and distributions over directions.

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use snowblue_transport::monte_carlo::{self, Distribution, GoniometricOptions, MonteCarloOptions, PatchGrid};
use snowblue_transport::ordinates;
use snowblue_transport::slab::{Estimate, Radiometry, Slab};
use snowblue_transport::stack::{DepthFluxes, Layer, Stack, StackRadiometry};

use crate::arguments::{Angle, Cases, Ordinates, Snow};
use crate::work::{Control, input, run};

/// Rays of the Monte Carlo engine, or none for discrete ordinates.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Engine {
    ordinates: Ordinates,
    rays: Option<u64>,
    per_wavelength: bool,
    standard_errors: bool,
}

/// A layer and its thickness.
#[derive(FromPyObject)]
pub(crate) struct GivenLayer(Snow, f64);

/// Layers on a ground.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Ground {
    layers: Vec<GivenLayer>,
    ground_albedo: f64,
    depth_cm: Vec<f64>,
}

/// A named quantity of a row.
type Quantity<R> = (&'static str, fn(&R) -> Estimate);

const FRACTIONS: [Quantity<Radiometry>; 3] = [
    ("reflectance", |row| row.reflectance),
    ("transmittance", |row| row.transmittance),
    ("absorptance", |row| row.absorptance),
];

const FLUXES: [Quantity<DepthFluxes>; 4] =
    [("down", |at| at.down), ("up", |at| at.up), ("net", |at| at.net), ("e_folding_depth", |at| at.e_folding_depth_cm)];

/// Reflectance, transmittance and absorptance of slabs of each snow, for each thickness, then each angle, then each
/// wavelength; with `_se` for standard errors.
#[pyfunction]
#[pyo3(signature = (snows, cases, engine, progress))]
pub(crate) fn spectrum<'py>(
    py: Python<'py>,
    snows: Vec<Snow>,
    cases: Cases,
    engine: Engine,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let slabs: Vec<Slab> = snows.iter().map(|snow| cases.slab(snow)).collect::<PyResult<_>>()?;
    let (options, errors) = (engine.ordinates.options()?, engine.standard_errors);
    let monte_carlo = engine.monte_carlo();
    let solve = if errors { ordinates::solve } else { ordinates::solve_without_errors };
    let rows = run(py, progress.as_ref(), move |control| {
        let mut rows = Vec::new();
        for (done, slab) in slabs.iter().enumerate() {
            let solved = if let Some(options) = &monte_carlo {
                control.check();
                monte_carlo::solve(slab, options, &of_several(control, done, slabs.len()))
            } else {
                control.set(done as u64, slabs.len() as u64);
                solve(slab, &options)
            };
            rows.extend(solved.map_err(input)?);
        }
        Ok(rows)
    })?;
    let dict = PyDict::new(py);
    add(&dict, &FRACTIONS, &rows, errors || engine.rays.is_some())?;
    Ok(dict)
}

/// Fluxes of a stack of layers, for each angle, then each wavelength; and at depths, the depth running fastest.
#[pyfunction]
#[pyo3(signature = (ground, cases, engine, progress))]
pub(crate) fn stack<'py>(
    py: Python<'py>,
    ground: Ground,
    cases: Cases,
    engine: Engine,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let layer =
        |GivenLayer(snow, thickness_cm): &GivenLayer| Ok(Layer { sample: snow.sample()?, thickness_cm: *thickness_cm });
    let stack = Stack {
        layers: ground.layers.iter().map(layer).collect::<PyResult<_>>()?,
        ground_albedo: ground.ground_albedo,
        depths_cm: ground.depth_cm,
        incidences: cases.incidences()?,
        wavelengths_nm: cases.wavelength_nm,
    };
    stack.check().map_err(input)?;
    let options = engine.ordinates.options()?;
    let monte_carlo = engine.monte_carlo();
    let with_errors = engine.standard_errors || monte_carlo.is_some();
    let (rows, profile) = run(py, progress.as_ref(), move |control| {
        if let Some(options) = monte_carlo {
            let rows = monte_carlo::solve_stack(&stack, &options, &of_several(control, 0, 1)).map_err(input)?;
            return Ok((rows, Vec::new()));
        }
        let answers: Vec<StackRadiometry> = ordinates::solve_stack(&stack, &options).map_err(input)?;
        let rows = answers.iter().map(|answer| answer.whole).collect();
        Ok((rows, answers.into_iter().flat_map(|answer| answer.profile).collect()))
    })?;
    let dict = PyDict::new(py);
    add(&dict, &FRACTIONS, &rows, with_errors)?;
    if !profile.is_empty() {
        add(&dict, &FLUXES, &profile, with_errors)?;
    }
    Ok(dict)
}

/// BRDF and BTDF of a slab on patches of the hemispheres, for each wavelength, ring and sector. Without a number of
/// sectors there are as many as the light needs.
#[pyfunction]
#[pyo3(signature = (snow, slab, rays_and_seed, patches, progress))]
#[expect(clippy::too_many_arguments, reason = "one for each group of keywords")]
pub(crate) fn bsdf<'py>(
    py: Python<'py>,
    snow: Snow,
    slab: (f64, Angle, Vec<f64>),
    rays_and_seed: (u64, u64),
    patches: (usize, Option<usize>),
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let (thickness_cm, angle_deg, wavelength_nm) = slab;
    let slab = Cases { thickness_cm: vec![thickness_cm], angle_deg: vec![angle_deg], wavelength_nm }.slab(&snow)?;
    let ((rays, seed), (rings, sectors)) = (rays_and_seed, patches);
    let sectors = sectors.unwrap_or(PatchGrid::for_incidence(slab.incidences[0]).sectors);
    let options = GoniometricOptions { rays, seed, patches: PatchGrid { rings, sectors } };
    let distributions = run(py, progress.as_ref(), move |control| {
        monte_carlo::distribute(&slab, &options, &of_several(control, 0, 1)).map_err(input)
    })?;
    let dict = PyDict::new(py);
    for (name, patches) in [
        ("brdf", (|distribution| &distribution.reflection) as fn(&Distribution) -> &Vec<monte_carlo::Patch>),
        ("btdf", |distribution| &distribution.transmission),
    ] {
        let rows: Vec<Estimate> = distributions
            .iter()
            .flat_map(|distribution| patches(distribution).iter().map(|patch| patch.bsdf_per_sr))
            .collect();
        add(&dict, &[(name, |row| *row)], &rows, true)?;
    }
    let quantities: [Quantity<Distribution>; 3] = [
        ("reflectance", |distribution| distribution.reflectance),
        ("transmittance", |distribution| distribution.transmittance),
        ("direct", |distribution| distribution.direct),
    ];
    add(&dict, &quantities, &distributions, true)?;
    if let Some(distribution) = distributions.first() {
        let patch_values =
            |value: fn(&monte_carlo::Patch) -> f64| -> Vec<f64> { distribution.reflection.iter().map(value).collect() };
        for (name, values) in [
            ("theta", patch_values(|patch| patch.theta_deg)),
            ("phi", patch_values(|patch| patch.phi_deg)),
            ("solid_angle", patch_values(|patch| patch.solid_angle_sr)),
        ] {
            dict.set_item(name, PyArray1::from_vec(py, values))?;
        }
    }
    Ok(dict)
}

impl Engine {
    fn monte_carlo(&self) -> Option<MonteCarloOptions> {
        let Self { ordinates, rays, per_wavelength, .. } = self;
        rays.map(|rays| MonteCarloOptions { rays, seed: ordinates.seed(), per_wavelength: *per_wavelength })
    }
}

/// The progress of one part of several equal ones.
fn of_several(control: &Control, part: usize, parts: usize) -> impl Fn(monte_carlo::RayProgress) + Sync {
    move |at| control.set(at.traced + part as u64 * at.total, at.total * parts as u64)
}

/// Adds an array for each quantity, and one of its standard errors.
fn add<R>(dict: &Bound<'_, PyDict>, quantities: &[Quantity<R>], rows: &[R], with_errors: bool) -> PyResult<()> {
    for (name, quantity) in quantities {
        let array = |part: fn(Estimate) -> f64| -> Vec<f64> { rows.iter().map(|row| part(quantity(row))).collect() };
        dict.set_item(name, PyArray1::from_vec(dict.py(), array(|estimate| estimate.value)))?;
        if with_errors {
            let errors = PyArray1::from_vec(dict.py(), array(|estimate| estimate.standard_error));
            dict.set_item(format!("{name}_se"), errors)?;
        }
    }
    Ok(())
}
