//! `snowblue spectrum`: reflectance, transmittance and absorptance of a slab, per wavelength.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use snowblue_transport::monte_carlo::{self, MonteCarloOptions};
use snowblue_transport::ordinates;
use snowblue_transport::sample::alternatives;
use snowblue_transport::slab::{Estimate, Radiometry, Slab};
use snowblue_transport::stack::{Stack, StackRadiometry};
use snowblue_transport::sunlight::{BandWeights, Broadband};

use crate::broadband::{self, ALL_BANDS, Bands};
use crate::failure::{Failure, Outcome};
use crate::layers::{PROFILE_COLUMNS, Pack, Provenance, StackOptions, profile_rows};
use crate::options::{OrdinatesWords, OutputOptions, SampleOptions, SlabOptions, incidence_name};
use crate::parse::{self, Wavelengths};
use crate::plot;
use crate::progress::Progress;
use crate::report::{Cell, Report, tell};

/// What the metadata call the greatest standard error.
const STANDARD_ERROR: &str = "transmittance standard error at most";

/// Reflectance, transmittance and absorptance of a slab of snow, per wavelength
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  snowblue spectrum --grain-size 400 --facetness 0.3 --density 300 --thickness 15
  snowblue spectrum --ssa 16 --thickness 1,5,15 --angle 0,60,diffuse -o snow.csv
  snowblue spectrum --engine montecarlo --rays 20000 --wavelengths 450,550,650 --thickness 3
  snowblue spectrum --thickness 30 --wavelengths 450,650 --spread
  snowblue spectrum --snow melt-forms --water-saturation 0.1 --impurity black-carbon=50,saharan-dust=1000
  snowblue spectrum --layers pack.toml --ground-albedo 0.2 --depths 0,1,5,20 --wavelengths 450,650
  snowblue spectrum --broadband --thickness 1,5,15,30 --angle 60     albedo, PAR under the sun
  snowblue spectrum --broadband visible,par --ice picard2016 --engine montecarlo"
)]
pub(crate) struct Spectrum {
    #[command(flatten)]
    sample: SampleOptions,
    #[command(flatten)]
    slab: SlabOptions,
    #[command(flatten)]
    stack: StackOptions,
    /// Wavelengths in nm: FIRST:LAST:STEP or a list [300–2500; default: 400:700:10, or every 10 nm of the
    /// bands]
    #[arg(long, value_name = "NM", value_parser = parse::wavelengths, help_heading = "Slab")]
    wavelengths: Option<Wavelengths>,
    /// Values for bands of sunlight (ASTM G173-03) instead of wavelengths: all, or some of solar, visible, near-infrared
    /// and par by commas
    #[arg(
        long, value_name = "BANDS", num_args = 0..=1, default_missing_value = ALL_BANDS, value_parser = broadband::bands,
        help_heading = "Slab", conflicts_with_all = ["spread", "depths"]
    )]
    broadband: Option<Bands>,
    /// Discrete ordinates, or the Monte Carlo walk from grain to grain
    #[arg(long, value_name = "ENGINE", value_enum, default_value = "ordinates", help_heading = "Engine")]
    engine: Engine,
    #[command(flatten)]
    ordinates: OrdinatesWords,
    /// Rays of the Monte Carlo engine for each angle and index node, shared by wavelengths and thicknesses; in layers, among
    /// impurities and in snow more than half full of water for each wavelength
    #[arg(long, value_name = "N", default_value_t = monte_carlo::DEFAULT_RAYS, value_parser = parse::count, help_heading = "Engine")]
    rays: u64,
    /// Monte Carlo as the paper did it: every wavelength and thickness with rays of its own
    #[arg(long, help_heading = "Engine")]
    per_wavelength: bool,
    /// The same snow under other plausible readings too: ice table, facetness, size measure, sphericity
    #[arg(long, help_heading = "Slab", conflicts_with_all = ["StackOptions", "plot"])]
    spread: bool,
    #[command(flatten)]
    output: OutputOptions,
    /// Draw transmittance and reflectance against wavelength into an SVG file
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    plot: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Engine {
    Ordinates,
    Montecarlo,
}

impl Spectrum {
    pub(crate) fn run(&self, quiet: bool) -> Outcome {
        self.output.check()?;
        self.plot.as_deref().map_or(Ok(()), plot::check_place)?;
        let pack = self.stack.pack()?;
        let reach_nm = match pack.as_ref().and_then(Pack::reach_nm) {
            Some(reach_nm) => reach_nm,
            None => self.sample.sample()?.range_nm(),
        };
        let wavelengths = self.wavelengths(reach_nm)?;
        let slab = self.sample.slab(&self.slab, &wavelengths)?;
        if self.spread {
            return self.spread(&slab, quiet)?.write(&self.output, quiet);
        }
        let weights = self.band_weights(reach_nm, &wavelengths)?;
        let snow = match &pack {
            Some(pack) => pack.made_of.clone(),
            None => self.sample.metadata()?,
        };
        let (rows, mut report) = if self.stack.asked() {
            let stacks = self.stack.stacks(&slab, pack.as_ref())?;
            self.solve_stacks(&stacks, &snow, quiet)?
        } else {
            let rows = self.solve(&slab, quiet)?;
            let report = self.report(&rows, &snow);
            (rows, report)
        };
        if !weights.is_empty() {
            report = self.broadband_report(&rows, &weights, &snow);
        }
        if let Some(path) = &self.plot {
            plot::spectrum(path, &rows, &report.metadata)?;
        }
        report.write(&self.output, quiet)
    }

    /// The wavelengths that are asked for, or those of bands where the tables of all the snow reach.
    fn wavelengths(&self, reach_nm: (f64, f64)) -> Result<Wavelengths, Failure> {
        match (&self.wavelengths, &self.broadband) {
            (Some(wavelengths), _) => Ok(wavelengths.clone()),
            (None, Some(bands)) => Ok(bands.wavelengths(reach_nm)),
            (None, None) => parse::wavelengths("400:700:10").map_err(Failure::Work),
        }
    }

    /// Weights of the bands that are asked for; none without `--broadband`.
    fn band_weights(&self, reach_nm: (f64, f64), wavelengths: &Wavelengths) -> Result<Vec<BandWeights>, Failure> {
        match &self.broadband {
            Some(bands) => bands.weights(reach_nm, wavelengths),
            None => Ok(Vec::new()),
        }
    }

    /// The rows of every alternative, each under its name.
    fn spread(&self, slab: &Slab, quiet: bool) -> Result<Report, Failure> {
        let mut spread: Option<Report> = None;
        for alternative in alternatives(&slab.sample) {
            let other = Slab { sample: alternative.sample, ..slab.clone() };
            // An alternative may lie beyond its table: Picard 2016 starts at 320 nm.
            if let Err(error) = other.check() {
                tell(&format!("snowblue: {} is left out: {error}\n", alternative.name));
                continue;
            }
            let mut report = self.report(&self.solve(&other, quiet)?, &self.sample.metadata()?);
            report.metadata.retain(|(name, _)| !["ice", STANDARD_ERROR].contains(name));
            report.columns.insert(0, "alternative");
            report.rows.iter_mut().for_each(|row| row.insert(0, Cell::Word(alternative.name.to_owned())));
            match &mut spread {
                None => spread = Some(report),
                Some(spread) => spread.rows.append(&mut report.rows),
            }
        }
        spread.ok_or_else(|| Failure::Work("no alternative could be solved".to_owned()))
    }

    /// The whole of each stack, and the report: of the whole, or of the fluxes at depths.
    fn solve_stacks(
        &self,
        stacks: &[Stack],
        snow: &Provenance,
        quiet: bool,
    ) -> Result<(Vec<Radiometry>, Report), Failure> {
        if self.engine == Engine::Montecarlo {
            if self.stack.with_depths() {
                return Err(Failure::Input("--depths needs --engine ordinates".to_owned()));
            }
            let bar = Progress::new("rays", quiet);
            let options = self.monte_carlo_options();
            let walk = |stack| monte_carlo::solve_stack(stack, &options, &|done, all| bar.at(done, all));
            let walked: Result<Vec<_>, _> = stacks.iter().map(walk).collect();
            bar.end();
            let rows = walked.map_err(Failure::input)?.concat();
            let report = self.report(&rows, snow);
            return Ok((rows, report));
        }
        let options = self.ordinates.options();
        let solved: Result<Vec<_>, _> = stacks.iter().map(|stack| ordinates::solve_stack(stack, &options)).collect();
        let answers: Vec<StackRadiometry> = solved.map_err(Failure::input)?.concat();
        let rows: Vec<Radiometry> = answers.iter().map(|answer| answer.whole).collect();
        let mut report = self.report(&rows, snow);
        if self.stack.with_depths() {
            report.columns = PROFILE_COLUMNS.to_vec();
            report.rows = answers.iter().flat_map(profile_rows).collect();
        }
        Ok((rows, report))
    }

    fn monte_carlo_options(&self) -> MonteCarloOptions {
        MonteCarloOptions { rays: self.rays, seed: self.ordinates.seed, per_wavelength: self.per_wavelength }
    }

    fn solve(&self, slab: &Slab, quiet: bool) -> Result<Vec<Radiometry>, Failure> {
        match self.engine {
            Engine::Ordinates => ordinates::solve(slab, &self.ordinates.options()).map_err(Failure::input),
            Engine::Montecarlo => {
                let bar = Progress::new("rays", quiet);
                let solved = monte_carlo::solve(slab, &self.monte_carlo_options(), &|done, all| bar.at(done, all));
                bar.end();
                solved.map_err(Failure::input)
            }
        }
    }

    /// The standard errors stand in columns of their own where every number has one that matters: Monte Carlo.
    fn report(&self, rows: &[Radiometry], snow: &Provenance) -> Report {
        let with_errors = self.engine == Engine::Montecarlo;
        let mut columns =
            vec!["thickness_cm", "angle_deg", "wavelength_nm", "reflectance", "transmittance", "absorptance"];
        if with_errors {
            columns.extend(["reflectance_se", "transmittance_se", "absorptance_se"]);
        }
        let row = |row: &Radiometry| {
            let place = [row.thickness_cm.into(), Cell::Word(incidence_name(row.incidence)), row.wavelength_nm.into()];
            cells(place, [row.reflectance, row.transmittance, row.absorptance], with_errors)
        };
        let metadata = self.metadata(rows.iter().map(|row| row.transmittance), snow);
        Report { columns, rows: rows.iter().map(row).collect(), metadata }
    }

    /// A row for each thickness, angle and band.
    fn broadband_report(&self, rows: &[Radiometry], weights: &[BandWeights], snow: &Provenance) -> Report {
        let with_errors = self.engine == Engine::Montecarlo;
        let bands = broadband::values(rows, weights);
        let mut columns = self.report(&[], snow).columns;
        columns[2] = "band";
        let row = |row: &Broadband| {
            let place =
                [row.thickness_cm.into(), Cell::Word(incidence_name(row.incidence)), Cell::Word(broadband::name(row))];
            cells(place, [row.reflectance, row.transmittance, row.absorptance], with_errors)
        };
        let mut metadata = self.metadata(bands.iter().map(|row| row.transmittance), snow);
        metadata.extend(broadband::metadata(&bands));
        Report { columns, rows: bands.iter().map(row).collect(), metadata }
    }

    fn metadata(
        &self,
        transmittances: impl Iterator<Item = Estimate>,
        snow: &Provenance,
    ) -> Vec<(&'static str, String)> {
        let engine = match self.engine {
            Engine::Ordinates => format!("discrete ordinates, {} streams", self.ordinates.streams),
            Engine::Montecarlo => format!("Monte Carlo, {} rays", self.rays),
        };
        let relative: Vec<f64> = transmittances.map(|t| (t.standard_error / t.value).abs()).collect();
        let worst = if relative.iter().any(|error| error.is_nan()) {
            "unknown: some transmittance is 0".to_owned()
        } else {
            format!("{:.2} %", 100.0 * relative.into_iter().fold(0.0, f64::max))
        };
        let mut metadata = vec![("snowblue", env!("CARGO_PKG_VERSION").to_owned()), ("engine", engine)];
        metadata.extend_from_slice(snow);
        metadata.extend([("seed", self.ordinates.seed.to_string()), (STANDARD_ERROR, worst)]);
        metadata
    }
}

/// Cells of a row: its place, three quantities and, where they are asked for, their errors.
fn cells(place: [Cell; 3], quantities: [Estimate; 3], with_errors: bool) -> Vec<Cell> {
    let mut cells = place.to_vec();
    cells.extend(quantities.map(|estimate| Cell::from(estimate.value)));
    if with_errors {
        cells.extend(quantities.map(|estimate| Cell::from(estimate.standard_error)));
    }
    cells
}
