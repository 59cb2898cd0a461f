//! `snowblue spectrum`: reflectance, transmittance and absorptance of a slab, per wavelength.

mod batch;
mod broadband;
mod layers;
mod plus_minus;
mod sky;

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use snowblue_figures::{Cell, DataTable, Metadata, plot};
use snowblue_transport::batch::CaseFluxes;
use snowblue_transport::monte_carlo::{self, MonteCarloOptions};
use snowblue_transport::optics::WavelengthRange;
use snowblue_transport::ordinates;
use snowblue_transport::slab::{Estimate, Radiometry, Slab};
use snowblue_transport::spread::{FluxIntervals, Uncertainty, solve_spread};
use snowblue_transport::stack::{Stack, StackRadiometry};
use snowblue_transport::sunlight::{BandWeights, Broadband};

use crate::options::parse::{self, Wavelengths};
use crate::options::{GivenOptions, Idle, OrdinatesArguments, PropertyAxis, SlabOptions, SnowOptions, limits};
use crate::output::{Failure, Layout, Outcome, OutputOptions, Progress, check_extension, check_not_input, write_file};
use batch::{Defaults, Slabs};
use broadband::{ALL_BANDS, Bands};
use layers::{PROFILE_COLUMNS, Pack, StackOptions, profile_rows};
use sky::SkyOptions;

/// Name of the greatest standard error in the metadata.
const STANDARD_ERROR: &str = "transmittance standard error at most";

/// Compute reflectance, transmittance and absorptance of a slab of snow, per wavelength
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  snowblue spectrum --grain-size 400 --facetness 0.3 --density 300 --thickness 15
  snowblue spectrum --ssa 16 --thickness 1,5,15 --angle 0,60,diffuse -o snow.csv
  snowblue spectrum --engine montecarlo --rays 20000 --wavelengths 450,550,650 --thickness 3
  snowblue spectrum --snow firn --water-saturation 0.1 --impurity black-carbon=50,saharan-dust=500
  snowblue spectrum --ssa 10,20,40 --density 200,300 --impurity black-carbon=0:20:100 -o grid.nc
  snowblue spectrum --batch pits.csv --angle 60 -o pits.nc
  snowblue spectrum --layers pack.toml --ground-albedo 0.2 --depths 0,1,5,20 --wavelengths 450,650
  snowblue spectrum --layers pack.toml --sky 47.27,11.39,2026-02-01T12:00+01:00 --depths 0,5,20 --broadband par,solar
  snowblue spectrum --broadband --thickness 1,5,15,30 --angle 60     albedo and PAR under sunlight
  snowblue spectrum --broadband visible,par --ice picard2016 --engine montecarlo
  snowblue spectrum --ssa 20 --thickness inf --angle 60 --wavelengths 400:1400:50     the albedo of deep snow
  snowblue spectrum --ssa 20 --density 250 --thickness 30 --plus-minus ssa=2,density=30,ice"
)]
pub(crate) struct Spectrum {
    /// Must be the first field.
    #[command(flatten)]
    given: GivenOptions,
    #[command(flatten)]
    sample: SnowOptions,
    #[command(flatten)]
    slab: SlabOptions,
    #[command(flatten)]
    stack: StackOptions,
    #[command(flatten)]
    sky: SkyOptions,
    #[arg(
        long, value_name = "FILE", help_heading = "Slab", conflicts_with_all = ["layers", "depths", "broadband"],
        help = format!(
            "CSV file of slabs, one a line, below a line of names of columns. Cells are separated by commas, and \
             decimals have a point. Lines that begin with # are comments; below the names they are slabs if the first \
             column is name. Columns are {}. Where a cell is empty or there is no column, the option counts, and the \
             result has its value. All lines are checked before any is computed. NetCDF has the dimensions slab and \
             wavelength", batch::names_of_columns()
        )
    )]
    batch: Option<PathBuf>,
    #[arg(
        long, value_name = "NM", value_parser = parse::wavelengths, help_heading = "Slab",
        help = format!(
            "Wavelengths in nm: FIRST:LAST:STEP or a list [{}; default: 400:700:10, or every 10 nm of the bands]. They \
             share rays through single grains, so that a value changes with the list, within its standard error",
            limits::snow_wavelengths()
        )
    )]
    wavelengths: Option<Wavelengths>,
    /// Averages over bands of sunlight (ASTM G173-03) instead of wavelengths: all, or some of solar, visible,
    /// near-infrared and par, separated by commas
    #[arg(
        long, value_name = "BANDS", num_args = 0..=1, default_missing_value = ALL_BANDS,
        value_parser = broadband::bands, help_heading = "Slab"
    )]
    broadband: Option<Bands>,
    /// Method of solution
    #[arg(long, value_name = "ENGINE", value_enum, default_value = "ordinates", help_heading = "Engine")]
    engine: Engine,
    #[command(flatten)]
    ordinates: OrdinatesArguments,
    /// Rays of the Monte Carlo engine for each angle and index node, shared by wavelengths and thicknesses; for each
    /// wavelength with layers, with impurities and above a water saturation of 0.5
    #[arg(
        long, value_name = "N", default_value_t = monte_carlo::DEFAULT_RAYS, value_parser = parse::rays(),
        help_heading = "Engine"
    )]
    rays: u64,
    /// Monte Carlo as in the paper: separate rays for every wavelength and thickness
    #[arg(long, help_heading = "Engine")]
    per_wavelength: bool,
    /// Intervals that hold 95 % of the cases if these are the standard deviations of what the snow is made of:
    /// ssa=2,density=30,black-carbon=5,ice. Names are those of options (grain-size too); ice makes either table equally
    /// likely. All else are log-normal and independent. By 400 snows; columns reflectance_lower, reflectance_upper, …
    #[arg(
        long, value_name = "DEVIATIONS", value_parser = plus_minus::uncertainty, help_heading = "Slab",
        conflicts_with_all = ["layers", "depths", "broadband", "plot"]
    )]
    plus_minus: Option<Uncertainty>,
    #[command(flatten)]
    output: OutputOptions,
    /// Draw transmittance and reflectance against wavelength into this SVG file
    #[arg(long, value_name = "FILE", help_heading = "Output", conflicts_with = "batch")]
    plot: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Engine {
    /// Discrete ordinates
    Ordinates,
    /// Monte Carlo random walk from grain to grain
    Montecarlo,
}

/// Solved slabs and the table to print.
struct Solution {
    rows: Vec<Radiometry>,
    results: DataTable,
}

impl Spectrum {
    pub(crate) fn run(&self, quiet: bool) -> Outcome {
        self.output.check_spectrum()?;
        if let Some(path) = &self.plot {
            check_extension(path, "svg", "the plot")?;
        }
        if let Some(path) = self.output.netcdf_path().filter(|_| self.broadband.is_some() || self.stack.has_depths()) {
            let name = path.display();
            return Err(Failure::Input(format!("{name}: NetCDF needs spectra; write bands and depths as CSV or JSON")));
        }
        let inputs = self.batch.as_deref().into_iter().chain(self.stack.file());
        for (input, output) in inputs.flat_map(|input| self.output.output.iter().map(move |output| (input, output))) {
            check_not_input(input, output)?;
        }
        self.check_effects()?;
        if self.broadband.is_some() && self.stack.has_depths() && !self.sky.is_used() {
            return Err(Failure::Input("--broadband with --depths needs the light of a --sky".to_owned()));
        }
        let axes: Vec<&PropertyAxis> = self.sample.axes().collect();
        if self.plot.is_some() && self.slab.thickness.iter().any(|thickness_cm| thickness_cm.is_infinite()) {
            return Err(Failure::Input("--plot draws transmittance, which a half-space lacks".to_owned()));
        }
        if self.batch.is_some() || !axes.is_empty() || self.plus_minus.is_some() {
            return self.run_batch(&axes, quiet);
        }
        let pack = self.stack.pack()?;
        let range = match pack.as_ref().and_then(Pack::wavelength_range) {
            Some(range) => range,
            None => self.sample.sample()?.wavelength_range(),
        };
        let wavelengths = self.wavelengths(range)?;
        let slab = self.sample.slab(&self.slab, &wavelengths)?;
        let weights = if self.sky.is_used() { Vec::new() } else { self.band_weights(range, &wavelengths)? };
        let mut snow = match &pack {
            Some(pack) => pack.metadata.clone(),
            None => self.sample.metadata()?,
        };
        snow.extend(self.stack.metadata());
        if self.sky.is_used() {
            if self.engine == Engine::Montecarlo {
                return Err(Failure::Input("--sky needs --engine ordinates".to_owned()));
            }
            let [stack] = <[Stack; 1]>::try_from(self.stack.stacks(&slab, pack.as_ref())?)
                .map_err(|_| Failure::Input("--sky takes one --thickness".to_owned()))?;
            let mut metadata = vec![("snowblue", env!("CARGO_PKG_VERSION").to_owned()), ("engine", self.engine_name())];
            metadata.extend(snow);
            metadata.push(("seed", self.ordinates.seed.to_string()));
            let results = self.sky.results(stack, self.broadband.as_ref(), &self.ordinates.options(), metadata)?;
            return self.output.write_spectrum(&results, Layout::Axes, quiet);
        }
        let Solution { rows, mut results } = if self.stack.is_used() {
            let stacks = self.stack.stacks(&slab, pack.as_ref())?;
            self.solve_stacks(&stacks, &snow, quiet)?
        } else {
            let rows = self.solve(&slab, quiet)?;
            Solution { results: self.results(&rows, &snow), rows }
        };
        if !weights.is_empty() {
            results = self.broadband_results(&rows, &weights, &snow);
        }
        if let Some(path) = &self.plot {
            write_file(path, plot::spectrum(&rows, &results.metadata, self.stack.has_ground()).as_bytes())?;
        }
        self.output.write_spectrum(&results, Layout::Axes, quiet)
    }

    /// The lines of a file, or all combinations of options with several values.
    fn run_batch(&self, axes: &[&PropertyAxis], quiet: bool) -> Outcome {
        for option in ["plot", "broadband", "depths", "sky"] {
            if self.given.has(option) {
                return Err(Failure::Input(format!("--{option} needs a single snow")));
            }
        }
        // Of several values the first.
        let sample = self.sample.keys()?.sample().map_err(|wrong| Failure::input(wrong.error))?;
        let wavelengths = self.wavelengths(sample.wavelength_range())?;
        let defaults = Defaults {
            snow: &self.sample,
            thicknesses_cm: &self.slab.thickness,
            incidences: &self.slab.angle,
            ground_albedo: self.stack.ground_albedo(),
            wavelengths_nm: &wavelengths.0,
        };
        let slabs = match &self.batch {
            Some(path) if axes.is_empty() => Slabs::read(path, &defaults, &self.given)?,
            Some(_) => return Err(Failure::Input("an option has several values, but --batch takes one".to_owned())),
            None => Slabs::of_axes(axes, &defaults)?,
        };
        let intervals = self.intervals(&slabs, quiet)?;
        let solved = self.solve_batch(&slabs, quiet)?;
        let with_errors = self.engine == Engine::Montecarlo;
        let mut columns = slabs.columns.clone();
        columns.extend(["wavelength_nm", "reflectance", "transmittance", "absorptance"]);
        if with_errors {
            columns.extend(["reflectance_se", "transmittance_se", "absorptance_se"]);
        }
        let rows = slabs.leading.iter().zip(solved.chunks_exact(wavelengths.0.len())).flat_map(|(leading, fluxes)| {
            fluxes.iter().zip(&wavelengths.0).map(|(at, wavelength_nm)| {
                let leading = leading.iter().cloned().chain([Cell::from(*wavelength_nm)]).collect();
                cells(leading, [at.reflectance, at.transmittance, at.absorptance], with_errors)
            })
        });
        let mut rows: Vec<Vec<Cell>> = rows.collect();
        if !intervals.is_empty() {
            columns.extend(plus_minus::COLUMNS);
            rows.iter_mut().zip(&intervals).for_each(|(row, at)| row.extend(plus_minus::cells(at)));
        }
        let mut metadata = vec![("snowblue", env!("CARGO_PKG_VERSION").to_owned()), ("engine", self.engine_name())];
        if let Some(path) = &self.batch {
            metadata.push(("slabs", path.display().to_string()));
        }
        metadata.extend(self.sample.properties(&sample, &slabs.columns, &slabs.full_columns()));
        metadata.extend(self.stack.metadata());
        metadata.extend(self.plus_minus.iter().flat_map(plus_minus::metadata));
        metadata.push(("seed", self.ordinates.seed.to_string()));
        let results = DataTable { columns, rows, metadata };
        let layout = if self.batch.is_some() { Layout::Slabs } else { Layout::Axes };
        self.output.write_spectrum(&results, layout, quiet)
    }

    fn solve_batch(&self, slabs: &Slabs, quiet: bool) -> Result<Vec<CaseFluxes>, Failure> {
        let (batch, count) = (&slabs.batch, slabs.batch.cases.len() as u64);
        let solved = if self.engine == Engine::Montecarlo {
            let bar = Progress::new("rays", quiet);
            let solved =
                monte_carlo::solve_batch(batch, &self.monte_carlo_options(), &|at| bar.set(at.traced, at.total));
            bar.finish();
            solved
        } else {
            let bar = Progress::new("slabs", quiet);
            let options = self.ordinates.options();
            let solved = ordinates::solve_batch(batch, &options, false, &|done| bar.set(done as u64, count));
            bar.finish();
            solved
        };
        solved.map_err(|wrong| slabs.failure(self.batch.as_deref(), wrong.case, &wrong.error))
    }

    /// The interval of each slab at each wavelength, if deviations are given.
    fn intervals(&self, slabs: &Slabs, quiet: bool) -> Result<Vec<FluxIntervals>, Failure> {
        let Some(uncertainty) = &self.plus_minus else { return Ok(Vec::new()) };
        if self.engine == Engine::Montecarlo {
            return Err(Failure::Input("--plus-minus needs --engine ordinates".to_owned()));
        }
        let (batch, bar) = (&slabs.batch, Progress::new("slabs", quiet));
        let count = batch.cases.len() as u64;
        let solved = solve_spread(batch, uncertainty, &self.ordinates.options(), &|done| bar.set(done as u64, count));
        bar.finish();
        solved.map_err(|wrong| slabs.failure(self.batch.as_deref(), wrong.case, &wrong.error))
    }

    /// Refuses options without effect.
    fn check_effects(&self) -> Outcome {
        let why_rays = "--engine ordinates solves equations instead of sending rays through the snow";
        self.given.refuse_idle(&[
            Idle { when: self.engine == Engine::Ordinates, options: &["rays", "per_wavelength"], why: why_rays },
            Idle {
                when: self.engine == Engine::Montecarlo,
                options: &["streams"],
                why: "--engine montecarlo sends rays through the snow and has no streams",
            },
            Idle { when: self.sky.is_used(), options: &["angle"], why: "--sky says where the sun stands" },
            Idle {
                when: !self.sky.is_used(),
                options: &["turbidity", "precipitable_water", "overcast"],
                why: "there is no --sky",
            },
            Idle {
                when: self.stack.is_used(),
                options: &["per_wavelength"],
                why: "on layers and on a ground each wavelength has its own rays in any case",
            },
        ])
    }

    /// The given wavelengths, or those of the bands within the range of the tables.
    fn wavelengths(&self, range: WavelengthRange) -> Result<Wavelengths, Failure> {
        match (&self.wavelengths, &self.broadband) {
            (Some(wavelengths), _) => Ok(wavelengths.clone()),
            _ if self.sky.is_used() => Ok(self.sky.wavelengths(range)),
            (None, Some(bands)) => Ok(bands.wavelengths(range)),
            (None, None) => parse::wavelengths("400:700:10").map_err(Failure::Work),
        }
    }

    /// Weights of the bands; empty without `--broadband`.
    fn band_weights(&self, range: WavelengthRange, wavelengths: &Wavelengths) -> Result<Vec<BandWeights>, Failure> {
        match &self.broadband {
            Some(bands) => bands.weights(range, wavelengths),
            None => Ok(Vec::new()),
        }
    }

    /// Solves each stack. The results are fluxes of the whole stack, or at depths.
    fn solve_stacks(&self, stacks: &[Stack], snow: &Metadata, quiet: bool) -> Result<Solution, Failure> {
        if self.engine == Engine::Montecarlo {
            if self.stack.has_depths() {
                return Err(Failure::Input("--depths needs --engine ordinates".to_owned()));
            }
            let bar = Progress::new("rays", quiet);
            let options = self.monte_carlo_options();
            let solve = |stack| monte_carlo::solve_stack(stack, &options, &|at| bar.set(at.traced, at.total));
            let solved: Result<Vec<_>, _> = stacks.iter().map(solve).collect();
            bar.finish();
            let rows = solved.map_err(Failure::input)?.concat();
            return Ok(Solution { results: self.results(&rows, snow), rows });
        }
        let options = self.ordinates.options();
        let solved: Result<Vec<_>, _> = stacks.iter().map(|stack| ordinates::solve_stack(stack, &options)).collect();
        let answers: Vec<StackRadiometry> = solved.map_err(Failure::input)?.concat();
        let rows: Vec<Radiometry> = answers.iter().map(|answer| answer.whole).collect();
        let mut results = self.results(&rows, snow);
        if self.stack.has_depths() {
            results.columns = PROFILE_COLUMNS.to_vec();
            results.rows = answers.iter().flat_map(profile_rows).collect();
        }
        Ok(Solution { rows, results })
    }

    fn monte_carlo_options(&self) -> MonteCarloOptions {
        MonteCarloOptions { rays: self.rays, seed: self.ordinates.seed, per_wavelength: self.per_wavelength }
    }

    fn solve(&self, slab: &Slab, quiet: bool) -> Result<Vec<Radiometry>, Failure> {
        match self.engine {
            Engine::Ordinates => ordinates::solve(slab, &self.ordinates.options()).map_err(Failure::input),
            Engine::Montecarlo => {
                let bar = Progress::new("rays", quiet);
                let solved = monte_carlo::solve(slab, &self.monte_carlo_options(), &|at| bar.set(at.traced, at.total));
                bar.finish();
                solved.map_err(Failure::input)
            }
        }
    }

    /// A row for each thickness, angle and wavelength. Monte Carlo has columns of standard errors.
    fn results(&self, rows: &[Radiometry], snow: &Metadata) -> DataTable {
        let with_errors = self.engine == Engine::Montecarlo;
        let mut columns =
            vec!["thickness_cm", "angle_deg", "wavelength_nm", "reflectance", "transmittance", "absorptance"];
        if with_errors {
            columns.extend(["reflectance_se", "transmittance_se", "absorptance_se"]);
        }
        let row = |row: &Radiometry| {
            let leading =
                vec![row.thickness_cm.into(), Cell::word(row.incidence.to_string()), row.wavelength_nm.into()];
            cells(leading, [row.reflectance, row.transmittance, row.absorptance], with_errors)
        };
        // Nothing passes through a half-space.
        let passed = rows.iter().filter(|row| row.thickness_cm.is_finite()).map(|row| row.transmittance);
        let metadata = self.metadata(passed, snow);
        DataTable { columns, rows: rows.iter().map(row).collect(), metadata }
    }

    /// A row for each thickness, angle and band.
    fn broadband_results(&self, rows: &[Radiometry], weights: &[BandWeights], snow: &Metadata) -> DataTable {
        let with_errors = self.engine == Engine::Montecarlo;
        let bands = broadband::values(rows, weights);
        let mut columns = self.results(&[], snow).columns;
        columns[2] = "band";
        let row = |row: &Broadband| {
            let leading = vec![
                row.thickness_cm.into(),
                Cell::word(row.incidence.to_string()),
                Cell::Word(broadband::name(row.band, row.range)),
            ];
            cells(leading, [row.reflectance, row.transmittance, row.absorptance], with_errors)
        };
        let passed = bands.iter().filter(|row| row.thickness_cm.is_finite()).map(|row| row.transmittance);
        let mut metadata = self.metadata(passed, snow);
        metadata.extend(broadband::metadata(&bands));
        DataTable { columns, rows: bands.iter().map(row).collect(), metadata }
    }

    fn engine_name(&self) -> String {
        match self.engine {
            Engine::Ordinates => format!("discrete ordinates, {} streams", self.ordinates.streams),
            Engine::Montecarlo => format!("Monte Carlo, {} rays", self.rays),
        }
    }

    fn metadata(&self, transmittances: impl Iterator<Item = Estimate>, snow: &Metadata) -> Metadata {
        let relative: Vec<f64> = transmittances.map(|t| (t.standard_error / t.value).abs()).collect();
        let worst = if relative.iter().any(|error| error.is_nan()) {
            Some("unknown: some transmittance is 0".to_owned())
        } else {
            relative.into_iter().reduce(f64::max).map(|worst| format!("{:.2} %", 100.0 * worst))
        };
        let mut metadata = vec![("snowblue", env!("CARGO_PKG_VERSION").to_owned()), ("engine", self.engine_name())];
        metadata.extend_from_slice(snow);
        metadata.push(("seed", self.ordinates.seed.to_string()));
        metadata.extend(worst.map(|worst| (STANDARD_ERROR, worst)));
        metadata
    }
}

/// Cells of a row: leading cells, three quantities and optionally their standard errors.
fn cells(mut cells: Vec<Cell>, quantities: [Estimate; 3], with_errors: bool) -> Vec<Cell> {
    cells.extend(quantities.map(|estimate| Cell::from(estimate.value)));
    if with_errors {
        cells.extend(quantities.map(|estimate| Cell::from(estimate.standard_error)));
    }
    cells
}
