//! Spectra of slabs and stacks, and distributions over directions.

use numpy::ndarray::ArrayView1;
use numpy::{PyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use snowblue_transport::batch::{Batch, BatchError, SlabCase};
use snowblue_transport::illumination::{self, BandLight, DifferentiatedLight, Illumination, LightInLayers};
use snowblue_transport::monte_carlo::{self, Distribution, GoniometricOptions, MonteCarloOptions, PatchGrid};
use snowblue_transport::ordinates::{self, DifferentiatedFluxes, DifferentiatedStack};
use snowblue_transport::slab::{Estimate, Fluxes, Incidence};
use snowblue_transport::spread::{Uncertainty, solve_spread};
use snowblue_transport::stack::{DepthFluxes, Layer, Stack, StackDerivatives, StackRadiometry, check_kind};
use snowblue_transport::sunlight::{Band, LinearSpectrum, band_integrals, response_weights};
use snowblue_transport::{GroundAlbedo, IceTable, LayerVariable, Property, TransportError, Variable};
use std::ops::Range;

use crate::arguments::{Angle, Cases, GivenGround, GivenSnow, Ordinates};
use crate::snow::Snows;
use crate::work::{input, input_at, input_in_row, run};

/// Number of rays of the Monte Carlo engine, or none for discrete ordinates.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Engine {
    ordinates: Ordinates,
    rays: Option<u64>,
    per_wavelength: bool,
    standard_errors: bool,
}

/// Slabs. Each slab is given by the indices of its snow, thickness, angle and albedo of the ground in the lists of
/// these quantities.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct GivenCases<'py> {
    thickness_cm: Vec<f64>,
    angle_deg: Vec<Angle>,
    ground_albedo: Vec<GivenGround>,
    wavelength_nm: Vec<f64>,
    /// [case][snow, thickness, angle, ground]
    places: PyReadonlyArray2<'py, i64>,
    /// Parameters with respect to which the fluxes are differentiated.
    jacobian: Vec<String>,
}

/// A layer and its thickness.
#[derive(FromPyObject)]
pub(crate) struct GivenLayer(GivenKind, f64);

/// The content of a layer: the known properties of snow, or a `kind` with the names of further properties.
enum GivenKind {
    Snow(Box<GivenSnow>),
    Named { kind: String, ice: Option<String>, others: Vec<String> },
}

impl<'py> FromPyObject<'_, 'py> for GivenKind {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let known = given.cast::<PyDict>()?;
        let Some(kind) = known.get_item("kind")? else { return Ok(Self::Snow(Box::new(given.extract()?))) };
        let ice = known.get_item("ice")?.map(|table| table.extract()).transpose()?;
        let mut others: Vec<String> = known.keys().extract()?;
        others.retain(|name| !["kind", "ice"].contains(&&**name));
        Ok(Self::Named { kind: kind.extract()?, ice, others })
    }
}

/// Layers on a ground.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Ground {
    layers: Vec<GivenLayer>,
    ground_albedo: GivenGround,
    depth_cm: Vec<f64>,
}

/// Names of the quantities of a depth.
const DEPTH_NAMES: [&str; 5] = ["down", "up", "net", "fluence", "e_folding_depth"];

fn of_depth<T: Copy>(at: &DepthFluxes<T>) -> [T; 5] {
    [at.down, at.up, at.net, at.fluence, at.e_folding_depth_cm]
}

/// Reflectance, transmittance and absorptance of each case at each wavelength, the wavelength running fastest; with
/// `_se` for standard errors. Derivatives with respect to each parameter of `jacobian` have `_per_` and its name. An
/// error of one case has its row.
#[pyfunction]
#[pyo3(signature = (snows, cases, engine, progress))]
pub(crate) fn spectrum<'py>(
    py: Python<'py>,
    snows: &Snows,
    cases: GivenCases<'py>,
    engine: Engine,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let variables = variables(&cases.jacobian)?;
    let batch = Batch {
        samples: snows.samples.to_vec(),
        cases: cases.cases(snows.samples.len())?,
        wavelengths_nm: cases.wavelength_nm,
    };
    let (options, errors) = (engine.ordinates.options()?, engine.standard_errors);
    let monte_carlo = engine.monte_carlo();
    let with_errors = errors || monte_carlo.is_some();
    let by = variables.clone();
    let DifferentiatedFluxes { fluxes: rows, derivatives } = run(py, progress.as_ref(), move |control| {
        let count = batch.cases.len() as u64;
        let solved = match &monte_carlo {
            Some(options) => monte_carlo::solve_batch(&batch, options, &|at| control.set(at.traced, at.total))
                .map(|fluxes| DifferentiatedFluxes { fluxes, derivatives: Vec::new() }),
            None => ordinates::differentiate_batch(&batch, &by, &options, errors, &|done| {
                control.set(done as u64, count);
            }),
        };
        solved.map_err(|BatchError { case, error }| match case {
            Some(case) => input_in_row(error, case),
            None => input(error),
        })
    })?;
    let dict = PyDict::new(py);
    add(&dict, Fluxes::NAMES, rows.iter().map(|row| row.to_array()), with_errors)?;
    for (place, variable) in variables.iter().enumerate() {
        let rows = derivatives.iter().skip(place).step_by(variables.len());
        add_numbers(&dict, Fluxes::NAMES, &format!("_per_{variable}"), rows.map(|row| row.to_array()))?;
    }
    Ok(dict)
}

/// Intervals of reflectance, transmittance and absorptance of each case at each wavelength, the wavelength running
/// fastest: `_lower` and `_upper`. An error of one case has its row.
#[pyfunction]
#[pyo3(signature = (snows, cases, uncertainty, engine, progress))]
#[expect(clippy::too_many_arguments, reason = "one for each group of keywords")]
pub(crate) fn spread<'py>(
    py: Python<'py>,
    snows: &Snows,
    cases: GivenCases<'py>,
    uncertainty: (Vec<(String, f64)>, bool),
    engine: Engine,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let (options, (deviations, ice)) = (engine.ordinates.options()?, uncertainty);
    let deviation = |(key, deviation): (String, f64)| Ok((Property::of_key(&key).map_err(input)?, deviation));
    let deviations = deviations.into_iter().map(deviation).collect::<PyResult<_>>()?;
    let uncertainty = Uncertainty { deviations, ice };
    let batch = Batch {
        samples: snows.samples.to_vec(),
        cases: cases.cases(snows.samples.len())?,
        wavelengths_nm: cases.wavelength_nm,
    };
    let rows = run(py, progress.as_ref(), move |control| {
        let count = batch.cases.len() as u64;
        let solved = solve_spread(&batch, &uncertainty, &options, &|done| control.set(done as u64, count));
        solved.map_err(|BatchError { case, error }| input_at(error, case, None))
    })?;
    let dict = PyDict::new(py);
    for (end, place) in [("_lower", 0), ("_upper", 1)] {
        add_numbers(&dict, Fluxes::NAMES, end, rows.iter().map(|row| row.to_array().map(|interval| interval[place])))?;
    }
    Ok(dict)
}

/// Lights on packs of layers: the pack of each light, by its number.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct GivenLights {
    pack: Vec<usize>,
    angle_deg: Vec<Angle>,
    wavelength_nm: Vec<f64>,
    /// The numbers of layers and of depths of the results.
    layers: usize,
    depths: usize,
}

/// A solved pack, with the number of its layers.
struct SolvedPack {
    solved: DifferentiatedStack,
    layers: usize,
}

impl SolvedPack {
    /// The derivatives in a row with respect to one of some variables, of a layer if it belongs to layers; none beyond
    /// the layers of the pack.
    fn derivatives(
        &self,
        row: usize,
        (variables, place): (&[Variable], usize),
        layer: usize,
    ) -> Option<&StackDerivatives> {
        let width = |variable: &Variable| if variable.is_of_layer() { self.layers } else { 1 };
        let [first, all] = [&variables[..place], variables].map(|some| some.iter().map(width).sum::<usize>());
        (layer < width(&variables[place])).then(|| &self.solved.derivatives[row * all + first + layer])
    }
}

/// Fluxes of packs of layers: for each light, then each wavelength; and at depths, the depth running fastest.
/// Derivatives with respect to each parameter of `jacobian` have `_per_` and its name; their layers run fastest, of
/// parameters that layers have. Where a pack has fewer layers or depths than the results, they are NaN. An error of one
/// of several packs has the row of its first light.
#[pyfunction]
#[pyo3(signature = (packs, lights, jacobian, engine, progress))]
#[expect(clippy::too_many_arguments, reason = "one for each group of keywords")]
pub(crate) fn stacks<'py>(
    py: Python<'py>,
    packs: Vec<Ground>,
    lights: GivenLights,
    jacobian: Vec<String>,
    engine: Engine,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let mut incidences: Vec<Vec<Incidence>> = vec![Vec::new(); packs.len()];
    let (mut places, mut rows) = (Vec::new(), vec![None; packs.len()]);
    for (row, (pack, angle)) in lights.pack.iter().zip(&lights.angle_deg).enumerate() {
        let own = incidences.get_mut(*pack).ok_or_else(|| input("a light has a pack beyond the packs"))?;
        places.push((*pack, own.len()));
        own.push(angle.incidence()?);
        rows[*pack] = rows[*pack].or((packs.len() > 1).then_some(row));
    }
    let wavelengths = lights.wavelength_nm.len();
    let given = packs.into_iter().zip(incidences).zip(&rows);
    let stack = |((pack, incidences), row): ((Ground, _), &Option<usize>)| {
        pack.stack(incidences, lights.wavelength_nm.clone(), *row)
    };
    let stacks: Vec<Stack> = given.map(stack).collect::<PyResult<_>>()?;
    let layers: Vec<usize> = stacks.iter().map(|stack| stack.layers.len()).collect();
    let options = engine.ordinates.options()?;
    let monte_carlo = engine.monte_carlo();
    let with_errors = engine.standard_errors || monte_carlo.is_some();
    let variables = variables(&jacobian)?;
    let by = variables.clone();
    let solved: Vec<DifferentiatedStack> = run(py, progress.as_ref(), move |control| {
        let walk = |options: &MonteCarloOptions, (stack, row): (&Stack, &Option<usize>)| {
            let solved = monte_carlo::solve_stack(stack, options, &|at| control.set(at.traced, at.total));
            let answer = |whole| StackRadiometry { whole, direct: f64::NAN, profile: Vec::new() };
            let fluxes = solved.map_err(|error| input_at(error, *row, None))?.into_iter().map(answer).collect();
            Ok(DifferentiatedStack { fluxes, derivatives: Vec::new() })
        };
        match &monte_carlo {
            // Random walks take one pack.
            Some(options) => stacks.iter().zip(&rows).map(|pack| walk(options, pack)).collect(),
            None => {
                let done = |done| control.set(done as u64, stacks.len() as u64);
                let solved = ordinates::differentiate_stacks(&stacks, &by, &options, with_errors, &done);
                solved.map_err(|BatchError { case, error }| input_at(error, case.and_then(|pack| rows[pack]), None))
            }
        }
    })?;
    let packs: Vec<SolvedPack> =
        solved.into_iter().zip(layers).map(|(solved, layers)| SolvedPack { solved, layers }).collect();
    let dict = PyDict::new(py);
    let (packs, variables) = (&packs[..], &variables[..]);
    let rows = places.iter().flat_map(|(pack, light)| {
        (0..wavelengths).map(move |wavelength| (&packs[*pack], light * wavelengths + wavelength))
    });
    let profile = |(pack, row): (&SolvedPack, usize)| pack.solved.fluxes[row].profile.clone();
    add(
        &dict,
        Fluxes::NAMES,
        rows.clone().map(|(pack, row)| pack.solved.fluxes[row].whole.fluxes.to_array()),
        with_errors,
    )?;
    let depths = lights.depths;
    if depths > 0 {
        let unknown = Estimate { value: f64::NAN, standard_error: f64::NAN };
        let at = |one: (&SolvedPack, usize)| {
            let profile = profile(one);
            (0..depths).map(move |depth| profile.get(depth).map_or([unknown; 5], of_depth))
        };
        add(&dict, DEPTH_NAMES, rows.clone().flat_map(at), with_errors)?;
    }
    add_derivatives(&dict, &rows.collect::<Vec<_>>(), variables, [lights.layers, depths])?;
    Ok(dict)
}

/// Adds the derivatives of rows of solved packs with respect to each variable, for the numbers of layers and depths of
/// the results.
fn add_derivatives(
    dict: &Bound<'_, PyDict>,
    rows: &[(&SolvedPack, usize)],
    variables: &[Variable],
    [layers, depths]: [usize; 2],
) -> PyResult<()> {
    for (place, variable) in variables.iter().enumerate() {
        let (per, most) = (format!("_per_{variable}"), if variable.is_of_layer() { layers } else { 1 });
        let of_layers = rows.iter().copied().flat_map(|(pack, row)| (0..most).map(move |layer| (pack, row, layer)));
        let whole = |(pack, row, layer): (&SolvedPack, usize, usize)| {
            let by = pack.derivatives(row, (variables, place), layer);
            by.map_or([f64::NAN; 3], |by| by.whole.to_array())
        };
        add_numbers(dict, Fluxes::NAMES, &per, of_layers.map(whole))?;
        if depths > 0 {
            let at = |(pack, row): (&'_ SolvedPack, usize)| {
                let at = |(depth, layer): (usize, usize)| {
                    let by = pack.derivatives(row, (variables, place), layer);
                    by.and_then(|by| by.profile.get(depth)).map_or([f64::NAN; 5], of_depth)
                };
                let places = (0..depths).flat_map(|depth| (0..most).map(move |layer| (depth, layer)));
                places.map(at).collect::<Vec<_>>()
            };
            add_numbers(dict, DEPTH_NAMES, &per, rows.iter().copied().flat_map(at))?;
        }
    }
    Ok(())
}

/// The places of each variable, whose layers follow each other.
fn places_by_name(of_layers: &[LayerVariable]) -> Vec<(&'static str, Range<usize>)> {
    let mut first = 0;
    let of_one = |group: &[LayerVariable]| {
        let places = first..first + group.len();
        first = places.end;
        (group[0].variable.name(), places)
    };
    of_layers.chunk_by(|one, next| one.variable == next.variable && next.layer > Some(0)).map(of_one).collect()
}

/// The sun's elevation, and spectral irradiances of a level surface by the sun and by the sky.
type GivenLight = (f64, Vec<f64>, Vec<f64>);

/// Names of the quantities of a level of light.
const LEVEL_NAMES: [&str; 5] = ["down", "up", "net", "actinic", "absorbed"];

/// Light in layers on a ground under each of some lights, or, `daily`, the sum over a day of all of them: for each
/// light the depths, then the wavelengths, and `layer_absorbed` with layers in place of depths; of each of `bands` the
/// same without wavelengths, as `par_down` and so on; and with the solar band `warming` and `layer_warming`.
/// Derivatives with respect to each parameter of `jacobian` have `_per_` and its name, for each light the layers that
/// change, if the parameter is one of layers, and then the others.
#[pyfunction]
#[pyo3(signature = (ground, wavelength_nm, lights, bands, daily, jacobian, ordinates))]
#[expect(clippy::too_many_arguments, reason = "one for each group of keywords")]
pub(crate) fn light_in_layers<'py>(
    py: Python<'py>,
    ground: Ground,
    wavelength_nm: Vec<f64>,
    lights: Vec<GivenLight>,
    bands: Vec<String>,
    daily: bool,
    jacobian: Vec<String>,
    ordinates: Ordinates,
) -> PyResult<Bound<'py, PyDict>> {
    let wavelengths_nm = wavelength_nm.clone();
    let stack = ground.stack(vec![Incidence::Diffuse], wavelength_nm, None)?;
    let options = ordinates.options()?;
    let light = |(elevation_deg, direct, diffuse)| Illumination::under_sun(elevation_deg, direct, diffuse);
    let lights: Vec<Illumination> = lights.into_iter().map(light).collect();
    if lights.iter().any(|light| [&light.direct, &light.diffuse].iter().any(|one| one.len() != wavelengths_nm.len())) {
        return Err(input("a light has not as many irradiances as there are wavelengths"));
    }
    let variables = variables(&jacobian)?;
    let of_layers = LayerVariable::of_layers(&variables, stack.layers.len());
    let solved_stack = stack.clone();
    let solved = run(py, None, move |_| {
        illumination::differentiate_light_in_layers(&solved_stack, &lights, &variables, &options).map_err(input)
    })?;
    let of_all = |of: &dyn Fn(&DifferentiatedLight) -> LightInLayers| -> Vec<LightInLayers> {
        let all: Vec<LightInLayers> = solved.iter().map(of).collect();
        if daily { vec![LightInLayers::sum_of_day(&all)] } else { all }
    };
    let bands: Vec<Band> = bands.iter().map(|name| band(name)).collect::<PyResult<_>>()?;
    let dict = PyDict::new(py);
    let values = of_all(&|one| one.light.clone());
    add_light(&dict, &values, "", &bands, &wavelengths_nm)?;
    if bands.contains(&Band::Solar) {
        let solar = |light: &LightInLayers| light.band(Band::Solar, &wavelengths_nm).map_err(input);
        let warming = |light: &LightInLayers| Ok(solar(light)?.warming_k_h(&stack));
        let warming: Vec<[Vec<f64>; 2]> = values.iter().map(warming).collect::<PyResult<_>>()?;
        for (place, name) in ["warming", "layer_warming"].into_iter().enumerate() {
            let values = warming.iter().flat_map(|of_light| of_light[place].iter().copied()).collect();
            dict.set_item(name, PyArray1::from_vec(py, values))?;
        }
    }
    for (name, places) in places_by_name(&of_layers) {
        let by: Vec<Vec<LightInLayers>> = places.map(|place| of_all(&|one| one.derivatives[place].clone())).collect();
        let lights = (0..values.len()).flat_map(|light| by.iter().map(move |of_all| of_all[light].clone()));
        add_light(&dict, &lights.collect::<Vec<_>>(), &format!("_per_{name}"), &bands, &wavelengths_nm)?;
    }
    Ok(dict)
}

/// Adds the levels of some lights, spectral and in bands, whose names end in `end`.
fn add_light(
    dict: &Bound<'_, PyDict>,
    lights: &[LightInLayers],
    end: &str,
    bands: &[Band],
    wavelengths_nm: &[f64],
) -> PyResult<()> {
    let levels = lights.iter().flat_map(|light| light.levels.iter().map(|level| level.values()));
    add_numbers(dict, LEVEL_NAMES, end, levels)?;
    let absorbed = lights.iter().flat_map(|light| light.absorbed.iter().map(|absorbed| [*absorbed]));
    add_numbers(dict, ["layer_absorbed"], end, absorbed)?;
    for band in bands {
        let name = band.name().replace('-', "_");
        let of_band = |light: &LightInLayers| light.band(*band, wavelengths_nm).map_err(input);
        let of_band: Vec<BandLight> = lights.iter().map(of_band).collect::<PyResult<_>>()?;
        let names = LEVEL_NAMES.map(|quantity| format!("{name}_{quantity}"));
        let levels = of_band.iter().flat_map(|light| light.levels.iter().map(|level| level.values()));
        add_numbers(dict, names.each_ref().map(String::as_str), end, levels)?;
        let absorbed = of_band.iter().flat_map(|light| light.absorbed.iter().map(|absorbed| [*absorbed]));
        add_numbers(dict, [&*format!("{name}_layer_absorbed")], end, absorbed)?;
    }
    Ok(())
}

/// The parameters of these names.
fn variables(names: &[String]) -> PyResult<Vec<Variable>> {
    names.iter().map(|name| name.parse().map_err(input)).collect()
}

fn band(name: &str) -> PyResult<Band> {
    Band::ALL.into_iter().find(|known| known.name() == name).ok_or_else(|| input(format!("'{name}' is no band")))
}

/// The weight of each wavelength of a curve in the mean over a band under the standard sun, or another light.
#[pyfunction]
#[pyo3(signature = (band_name, response, light, wavelengths_nm))]
pub(crate) fn band_weights<'py>(
    py: Python<'py>,
    band_name: Option<String>,
    response: Option<(Vec<f64>, Vec<f64>)>,
    light: Option<(Vec<f64>, Vec<f64>)>,
    wavelengths_nm: Vec<f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let spectrum = |quantity: &'static str, given: &Option<(Vec<f64>, Vec<f64>)>| {
        let spectrum = given.as_ref().map(|(nm, values)| LinearSpectrum::new(quantity, nm, values));
        spectrum.transpose().map_err(input)
    };
    let light = spectrum("light", &light)?;
    let (label, response) = match (band_name, spectrum("response", &response)?) {
        (_, Some(response)) => ("sensor", response),
        (Some(name), None) => {
            let band = band(&name)?;
            (band.name(), band.response())
        }
        (None, None) => return Err(input("neither a band nor a response is given")),
    };
    let weights = response_weights(label, &response, light.as_ref(), &wavelengths_nm).map_err(input)?;
    Ok(PyArray1::from_vec(py, weights))
}

/// Names of the bands that these wavelengths cover.
#[pyfunction]
pub(crate) fn covered_bands(wavelengths_nm: Vec<f64>) -> Vec<&'static str> {
    let is_covered = |band: &Band| band_integrals(*band, &wavelengths_nm).is_ok();
    Band::ALL.into_iter().filter(is_covered).map(Band::name).collect()
}

/// BRDF and BTDF of a slab on patches of the hemispheres, for each wavelength, ring and sector. Without a number of
/// sectors there are as many as the light needs.
#[pyfunction]
#[pyo3(signature = (snow, slab, rays_and_seed, patches, progress))]
#[expect(clippy::too_many_arguments, reason = "one for each group of keywords")]
pub(crate) fn bsdf<'py>(
    py: Python<'py>,
    snow: GivenSnow,
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
        monte_carlo::distribute(&slab, &options, &|at| control.set(at.traced, at.total)).map_err(input)
    })?;
    let dict = PyDict::new(py);
    let patches = |of: fn(&Distribution) -> &Vec<monte_carlo::Patch>| {
        distributions.iter().flat_map(of).map(|patch| [patch.bsdf_per_sr])
    };
    add(&dict, ["brdf"], patches(|distribution| &distribution.reflection), true)?;
    add(&dict, ["btdf"], patches(|distribution| &distribution.transmission), true)?;
    let whole = |all: &Distribution| [all.reflectance, all.transmittance, all.direct];
    add(&dict, ["reflectance", "transmittance", "direct"], distributions.iter().map(whole), true)?;
    if let Some(distribution) = distributions.first() {
        let place = |patch: &monte_carlo::Patch| [patch.theta_deg, patch.phi_deg, patch.solid_angle_sr];
        add_numbers(&dict, ["theta", "phi", "solid_angle"], "", distribution.reflection.iter().map(place))?;
    }
    Ok(dict)
}

/// Bidirectional reflectance factors of a stack of layers: for each angle, then each wavelength, zenith and azimuth of
/// the view.
#[pyfunction]
#[pyo3(signature = (ground, cases, views, ordinates))]
pub(crate) fn brf<'py>(
    py: Python<'py>,
    ground: Ground,
    cases: Cases,
    views: (Vec<f64>, Vec<f64>),
    ordinates: Ordinates,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let stack = ground.stack(cases.incidences()?, cases.wavelength_nm, None)?;
    let (options, (zeniths_deg, azimuths_deg)) = (ordinates.options()?, views);
    let views = ordinates::Views { zeniths_deg, azimuths_deg };
    let light = run(py, None, move |_| ordinates::bidirectional(&stack, &views, &options).map_err(input))?;
    let factors = light.iter().flat_map(|one| &one.reflection).map(|per_sr| std::f64::consts::PI * per_sr);
    Ok(PyArray1::from_vec(py, factors.collect()))
}

impl GivenCases<'_> {
    fn cases(&self, snows: usize) -> PyResult<Vec<SlabCase>> {
        let incidences: Vec<Incidence> = self.angle_deg.iter().map(Angle::incidence).collect::<PyResult<_>>()?;
        let ground = |(row, given): (usize, &GivenGround)| given.albedo().map_err(|error| input_in_row(error, row));
        let grounds: Vec<GroundAlbedo> = self.ground_albedo.iter().enumerate().map(ground).collect::<PyResult<_>>()?;
        let case = |row: ArrayView1<i64>| {
            let place = |column: usize| usize::try_from(*row.get(column)?).ok();
            Some(SlabCase {
                sample: place(0).filter(|snow| *snow < snows)?,
                thickness_cm: *self.thickness_cm.get(place(1)?)?,
                incidence: *incidences.get(place(2)?)?,
                ground_albedo: grounds.get(place(3)?)?.clone(),
            })
        };
        let cases: Option<_> = self.places.as_array().rows().into_iter().map(case).collect();
        cases.ok_or_else(|| input("a case has a place beyond the values"))
    }
}

impl Ground {
    /// The layers under some incidences, checked. An error has the row.
    fn stack(self, incidences: Vec<Incidence>, wavelengths_nm: Vec<f64>, row: Option<usize>) -> PyResult<Stack> {
        let in_row = |error| input_at(error, row, None);
        let layer = |(place, given): (usize, &GivenLayer)| {
            let layer = given.layer().and_then(|layer| layer.check(place + 1 == self.layers.len()).map(|()| layer));
            layer.map_err(|error| match row {
                Some(_) => input_at(format!("{error}, in layer {place}"), row, None),
                None => input(error),
            })
        };
        let stack = Stack {
            layers: self.layers.iter().enumerate().map(layer).collect::<PyResult<_>>()?,
            ground_albedo: self.ground_albedo.albedo().map_err(in_row)?,
            depths_cm: self.depth_cm,
            incidences,
            wavelengths_nm,
        };
        stack.check().map_err(in_row)?;
        Ok(stack)
    }
}

impl GivenLayer {
    pub(crate) fn layer(&self) -> Result<Layer, TransportError> {
        let Self(kind, thickness_cm) = self;
        Ok(match kind {
            GivenKind::Snow(snow) => Layer::snow(snow.sample()?, *thickness_cm),
            GivenKind::Named { kind, ice, others } => {
                check_kind(kind, others.first().map(String::as_str))?;
                let table: Option<IceTable> = ice.as_deref().map(str::parse).transpose()?;
                Layer::ice(table.unwrap_or_default(), *thickness_cm)
            }
        })
    }
}

impl Engine {
    fn monte_carlo(&self) -> Option<MonteCarloOptions> {
        let Self { ordinates, rays, per_wavelength, .. } = self;
        rays.map(|rays| MonteCarloOptions { rays, seed: ordinates.seed(), per_wavelength: *per_wavelength })
    }
}

/// Adds an array for each quantity of the rows, by its name and `end`.
fn add_numbers<const N: usize>(
    dict: &Bound<'_, PyDict>,
    names: [&str; N],
    end: &str,
    rows: impl Iterator<Item = [f64; N]> + Clone,
) -> PyResult<()> {
    for (place, name) in names.into_iter().enumerate() {
        let values = rows.clone().map(|row| row[place]).collect();
        dict.set_item(format!("{name}{end}"), PyArray1::from_vec(dict.py(), values))?;
    }
    Ok(())
}

/// Adds an array for each quantity of the rows, and an array of its standard errors.
fn add<const N: usize>(
    dict: &Bound<'_, PyDict>,
    names: [&str; N],
    rows: impl Iterator<Item = [Estimate; N]> + Clone,
    with_errors: bool,
) -> PyResult<()> {
    add_numbers(dict, names, "", rows.clone().map(|row| row.map(|estimate| estimate.value)))?;
    if with_errors {
        add_numbers(dict, names, "_se", rows.map(|row| row.map(|estimate| estimate.standard_error)))?;
    }
    Ok(())
}
