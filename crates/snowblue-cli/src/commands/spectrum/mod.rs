//! `snowblue spectrum`: reflectance, transmittance and absorptance of a slab, per wavelength.

mod broadband;
mod curves;
mod layers;
mod plus_minus;
mod sky;
mod slabs;

use std::path::{Path, PathBuf};

use clap::Args;
use snowblue_figures::{DataTable, Metadata, plot};
use snowblue_sky::daylight_wavelengths_nm;
use snowblue_transport::GroundAlbedo;
use snowblue_transport::batch::Batch;
use snowblue_transport::monte_carlo::{self, MonteCarloOptions};
use snowblue_transport::optics::{IceTable, Wavelengths};
use snowblue_transport::ordinates;
use snowblue_transport::parameters::GROUND_ALBEDO;
use snowblue_transport::slab::{Estimate, Fluxes, Incidence, Radiometry};
use snowblue_transport::spread::{Uncertainty, solve_spread};
use snowblue_transport::stack::{Layer, Stack};
use snowblue_transport::sunlight::BandWeights;

use crate::options::{Engine, GivenOptions, Idle, OrdinatesArguments, SlabOptions, SnowOptions, limits, parse};
use crate::output::{
    Failure, Outcome, OutputOptions, Progress, check_extension, check_not_input, print_notes, write_file,
};
use broadband::{ALL_BANDS, Bands};
use curves::{Curves, Labels};
use layers::{PROFILE_COLUMNS, Pack, StackOptions, profile_rows};
use sky::SkyOptions;
use slabs::{Defaults, Slabs};

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
        long, value_name = "FILE", help_heading = "Slab", conflicts_with_all = ["layers", "depths", "plot"],
        help = format!(
            "CSV file of slabs, one a line, below a line of names of columns. Cells are separated by commas, and \
             decimals have a point. Lines that begin with # are comments; below the names they are slabs if the first \
             column is name. Columns are {}. Where a cell is empty or there is no column, the option counts, and the \
             result has its value; a note says so of empty cells. A line with a number NaN has results NaN. All \
             lines are checked before any is computed. NetCDF has the dimensions slab and wavelength",
            slabs::names_of_columns()
        )
    )]
    batch: Option<PathBuf>,
    #[arg(
        long, value_name = "NM", help_heading = "Slab",
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
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    plot: Option<PathBuf>,
}

impl Spectrum {
    pub(crate) fn run(&self, quiet: bool) -> Outcome {
        self.check_output()?;
        self.check_effects()?;
        if self.stack.has_depths() {
            return self.output.write(&self.light_at_depths()?, quiet);
        }
        let (curves, snow) = match self.stack.pack()? {
            Some(pack) => self.solve_layers(pack, quiet)?,
            None => self.solve_slabs(quiet)?,
        };
        let mut metadata = self.metadata(snow, curves.labels.columns.contains(&GROUND_ALBEDO.key));
        metadata.extend(curves.metadata());
        if let Some(path) = &self.plot {
            let plot = plot::spectrum(&curves.rows, &metadata, self.stack.has_ground());
            write_file(path, plot.as_bytes())?;
        }
        match self.output.netcdf_path() {
            Some(path) => curves.netcdf(&metadata).write(path).map_err(Failure::work),
            None => self.output.write(&curves.table(metadata), quiet),
        }
    }

    /// Checks that the files can be written.
    fn check_output(&self) -> Outcome {
        self.output.check_spectrum()?;
        if let Some(path) = &self.plot {
            check_extension(path, "svg", "the plot")?;
        }
        if let Some(path) = self.output.netcdf_path().filter(|_| self.broadband.is_some() || self.stack.has_depths()) {
            let name = path.display();
            return Err(Failure::Input(format!("{name}: NetCDF needs spectra; write bands and depths as CSV or JSON")));
        }
        let ground = self.stack.ground_albedo();
        let ground = matches!(ground.albedo, GroundAlbedo::Spectrum(_)).then_some(Path::new(&ground.word));
        let mut inputs = self.batch.as_deref().into_iter().chain(self.stack.file()).chain(ground);
        match &self.output.output {
            Some(output) => inputs.try_for_each(|input| check_not_input(input, output)),
            None => Ok(()),
        }
    }

    /// Refuses options without effect.
    fn check_effects(&self) -> Outcome {
        let (is_walk, has_sky) = (self.engine == Engine::Montecarlo, self.sky.is_used());
        let several = self.sample.axes().next().map(|axis| format!("--{} has several values", axis.option()));
        self.given.refuse_idle(&[
            Idle {
                when: !is_walk,
                options: &["rays", "per_wavelength"],
                why: "--engine ordinates solves equations instead of sending rays through the snow",
            },
            Idle {
                when: is_walk,
                options: &["streams"],
                why: "--engine montecarlo sends rays through the snow and has no streams",
            },
            Idle {
                when: is_walk,
                options: &["sky", "depths", "plus_minus"],
                why: "only --engine ordinates computes it",
            },
            Idle {
                when: self.stack.file().is_some() || self.stack.has_ground(),
                options: &["per_wavelength"],
                why: "on layers and on a ground each wavelength has its own rays in any case",
            },
            Idle { when: has_sky, options: &["angle"], why: "--sky says where the sun stands" },
            Idle {
                when: !has_sky,
                options: &["turbidity", "precipitable_water", "overcast"],
                why: "there is no --sky",
            },
            Idle {
                when: self.stack.has_depths() && !has_sky,
                options: &["broadband"],
                why: "light at --depths has bands under a --sky only",
            },
            Idle { when: self.stack.has_depths(), options: &["plot"], why: "it draws no fluxes at --depths" },
            Idle { when: several.is_some(), options: &["plot", "depths"], why: several.as_deref().unwrap_or_default() },
        ])?;
        let has_half_space = self.slab.thickness.iter().any(|thickness_cm| thickness_cm.is_infinite());
        if is_walk && has_half_space {
            return Err(Failure::Input("thickness is inf cm, which only --engine ordinates takes".to_owned()));
        }
        self.check_plot(has_half_space)
    }

    /// Refuses to plot the transmittance of a half-space.
    fn check_plot(&self, has_half_space: bool) -> Outcome {
        if self.plot.is_some() && has_half_space {
            return Err(Failure::Input("--plot draws transmittance, which a half-space lacks".to_owned()));
        }
        Ok(())
    }

    /// The given wavelengths, or the wavelengths of the sky or of the bands.
    fn wavelengths(&self) -> Result<Wavelengths, Failure> {
        let snow = IceTable::default().wavelength_range();
        match (&self.wavelengths, &self.broadband) {
            (Some(wavelengths), _) => {
                let mut each = wavelengths.0.iter();
                each.try_for_each(|nm| snow.check("wavelength", *nm)).map_err(Failure::input)?;
                Ok(wavelengths.clone())
            }
            _ if self.sky.is_used() => Ok(Wavelengths(daylight_wavelengths_nm())),
            (None, Some(bands)) => Ok(bands.wavelengths()),
            (None, None) => Ok(Wavelengths::visible()),
        }
    }

    /// The weights of the bands; none without `--broadband`.
    fn bands(&self, wavelengths: &Wavelengths) -> Result<Vec<BandWeights>, Failure> {
        self.broadband.as_ref().map_or(Ok(Vec::new()), |bands| bands.weights(wavelengths))
    }

    /// Solves the layers of a file. Also returns the metadata of the snow.
    fn solve_layers(&self, pack: Pack, quiet: bool) -> Result<(Curves, Metadata), Failure> {
        let wavelengths = self.wavelengths()?;
        let bands = self.bands(&wavelengths)?;
        let stack = self.stack.stack(pack.layers, &self.slab.angle, &wavelengths)?;
        self.check_plot(stack.thickness_cm().is_infinite())?;
        let rows = if self.engine == Engine::Montecarlo {
            let bar = Progress::new("rays", quiet);
            let options = self.monte_carlo_options();
            let solved = monte_carlo::solve_stack(&stack, &options, &|at| bar.set(at.traced, at.total));
            bar.finish();
            solved.map_err(Failure::input)?
        } else {
            let solved = ordinates::solve_stack(&stack, &self.ordinates.options()).map_err(Failure::input)?;
            solved.iter().map(|answer| answer.whole).collect()
        };
        let labels = Labels::of_incidences(stack.thickness_cm(), &stack.incidences);
        let has_errors = self.engine == Engine::Montecarlo;
        Ok((Curves { labels, rows, bands, intervals: Vec::new(), has_errors }, pack.metadata))
    }

    /// Solves the lines of a file, or all combinations of the values of options. Also returns the metadata of the snow.
    fn solve_slabs(&self, quiet: bool) -> Result<(Curves, Metadata), Failure> {
        let defaults = Defaults {
            snow: &self.sample,
            thicknesses_cm: &self.slab.thickness,
            incidences: &self.slab.angle,
            ground_albedo: self.stack.ground_albedo(),
        };
        let slabs = match &self.batch {
            Some(path) => Slabs::read(path, &defaults, &self.given)?,
            None => Slabs::of_options(&defaults)?,
        };
        let wavelengths = self.wavelengths()?;
        slabs.check_size(wavelengths.0.len())?;
        let bands = self.bands(&wavelengths)?;
        let batch = slabs.batch(wavelengths)?;
        print_notes(quiet, &slabs.notes);
        let intervals = self.intervals(&slabs, &batch, quiet)?;
        let rows = batch.radiometry(&self.fluxes(&slabs, &batch, quiet)?);
        let unknown = |nm: &f64| Radiometry {
            thickness_cm: f64::NAN,
            incidence: Incidence::Diffuse,
            wavelength_nm: *nm,
            fluxes: Fluxes::from([Estimate { value: f64::NAN, standard_error: f64::NAN }; 3]),
        };
        let rows = slabs.with_gaps(rows, &batch.wavelengths_nm.iter().map(unknown).collect::<Vec<_>>());
        let snow = if slabs.has_one_snow() {
            self.sample.metadata_of(&slabs.samples[0])
        } else {
            let (columns, full_columns) = (&slabs.labels.columns, slabs.labels.full_columns());
            // Of several values of an option, the first value counts.
            let sample = self.sample.keys()?.sample().map_err(|wrong| Failure::input(wrong.error))?;
            self.sample.properties(&sample, columns, &full_columns)
        };
        let has_errors = self.engine == Engine::Montecarlo;
        Ok((Curves { labels: slabs.labels, rows, bands, intervals, has_errors }, snow))
    }

    /// The fluxes of each slab at each wavelength. The ordinates have standard errors only if there is one snow,
    /// because the errors take most of the time.
    fn fluxes(&self, slabs: &Slabs, batch: &Batch, quiet: bool) -> Result<Vec<Fluxes>, Failure> {
        let count = batch.cases.len() as u64;
        let solved = if self.engine == Engine::Montecarlo {
            let bar = Progress::new("rays", quiet);
            let options = self.monte_carlo_options();
            let solved = monte_carlo::solve_batch(batch, &options, &|at| bar.set(at.traced, at.total));
            bar.finish();
            solved
        } else {
            let bar = Progress::new("slabs", quiet);
            let (options, errors) = (self.ordinates.options(), slabs.has_one_snow());
            let solved = ordinates::solve_batch(batch, &options, errors, &|done| bar.set(done as u64, count));
            bar.finish();
            solved
        };
        solved.map_err(|wrong| slabs.failure(&wrong))
    }

    /// The intervals of each slab at each wavelength, if deviations are given.
    fn intervals(&self, slabs: &Slabs, batch: &Batch, quiet: bool) -> Result<Vec<Fluxes<[f64; 2]>>, Failure> {
        let Some(uncertainty) = &self.plus_minus else { return Ok(Vec::new()) };
        let (bar, count) = (Progress::new("slabs", quiet), batch.cases.len() as u64);
        let solved = solve_spread(batch, uncertainty, &self.ordinates.options(), &|done| bar.set(done as u64, count));
        bar.finish();
        let unknown = vec![Fluxes::from([[f64::NAN; 2]; 3]); batch.wavelengths_nm.len()];
        Ok(slabs.with_gaps(solved.map_err(|wrong| slabs.failure(&wrong))?, &unknown))
    }

    /// Fluxes at depths: of a unit of light, or under a sky.
    fn light_at_depths(&self) -> Result<DataTable, Failure> {
        let (packs, snow) = if let Some(pack) = self.stack.pack()? {
            (vec![pack.layers], pack.metadata)
        } else {
            let sample = self.sample.sample()?;
            let pack = |thickness_cm: &f64| vec![Layer::snow(sample, *thickness_cm)];
            let packs = self.slab.thickness.iter().map(pack).collect();
            (packs, self.sample.metadata_of(&sample))
        };
        let (wavelengths, metadata) = (self.wavelengths()?, self.metadata(snow, false));
        let stacks = packs.into_iter().map(|layers| self.stack.stack(layers, &self.slab.angle, &wavelengths));
        let stacks: Vec<Stack> = stacks.collect::<Result<_, Failure>>()?;
        let options = self.ordinates.options();
        if self.sky.is_used() {
            let [stack] =
                <[Stack; 1]>::try_from(stacks).map_err(|_| Failure::Input("--sky takes one --thickness".to_owned()))?;
            return self.sky.results(stack, self.broadband.as_ref(), &options, metadata);
        }
        let mut rows = Vec::new();
        for stack in &stacks {
            let solved = ordinates::solve_stack(stack, &options).map_err(Failure::input)?;
            rows.extend(solved.iter().flat_map(|answer| profile_rows(answer, stack)));
        }
        Ok(DataTable { columns: PROFILE_COLUMNS.to_vec(), rows, metadata })
    }

    fn monte_carlo_options(&self) -> MonteCarloOptions {
        MonteCarloOptions { rays: self.rays, seed: self.ordinates.seed, per_wavelength: self.per_wavelength }
    }

    /// Metadata about the computation of the results.
    fn metadata(&self, snow: Metadata, has_ground_column: bool) -> Metadata {
        let engine = match self.engine {
            Engine::Ordinates => format!("discrete ordinates, {} streams", self.ordinates.streams),
            Engine::Montecarlo => format!("Monte Carlo, {} rays", self.rays),
        };
        let mut metadata = vec![("snowblue", env!("CARGO_PKG_VERSION").to_owned()), ("engine", engine)];
        metadata.extend(self.batch.iter().map(|path| ("slabs", path.display().to_string())));
        metadata.extend(snow);
        metadata.extend(self.stack.metadata(has_ground_column));
        metadata.extend(self.plus_minus.iter().flat_map(plus_minus::metadata));
        metadata.push(("seed", self.ordinates.seed.to_string()));
        metadata
    }
}
