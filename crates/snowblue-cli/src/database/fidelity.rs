//! `snowblue database fidelity`: what compression costs, and what look-ups between a table's values do.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use snowblue_color::Illuminant;
use snowblue_database::fidelity::off_grid::{Interpolation, OffGrid, off_grid};
use snowblue_database::fidelity::{self, PERCEPTIBLE_DELTA_E, Spread};
use snowblue_database::file::{self, AnyTable};
use snowblue_database::pca::Decomposition;
use snowblue_database::{CompressedTable, DatabaseError, Quantity, Space, Table};

use super::Filling;
use crate::failure::{Failure, Outcome};
use crate::options::OutputOptions;
use crate::parse;
use crate::plot::{self, Cost};
use crate::report::{Cell, Report, write_file};

/// Judge how well 1–N principal components keep every curve of a full table, in both spaces
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Each row tells the errors of all rebuilt curves: worst, 99th percentile, mean; which curves are worst; \
and the singular value of the row's last component.

With --off-grid, look-ups at random thicknesses (0.01–100 cm) and angles (0–80° and 80–89°) are compared with direct \
solutions by the same rays and seed as the table's, so that errors are those of interpolation alone: for the table's own \
snow (samples 'grid') and, in log space, for snow between its values ('between'). Relative errors are told apart where the \
value is above 1e-6 ('bright') and everywhere.

Examples:
  snowblue database fidelity full.nc
  snowblue database fidelity --illuminant E,D65,LED-B5 --components 6 -o fidelity.csv --plot fidelity.svg
  snowblue database fidelity walked.nc --truth solved.nc     what the noise of few rays does to components and colours
  snowblue database fidelity --off-grid 200                  look-ups in the embedded table, and the paper's
  snowblue database fidelity --off-grid 200 --seed 2 small.nc"
)]
pub(crate) struct Fidelity {
    /// Full table to judge, with --off-grid of either kind [default: the axes asked for, filled now]
    #[arg(conflicts_with_all = ["Filling", "AxesOptions", "streams"])]
    file: Option<PathBuf>,
    #[command(flatten)]
    filling: Filling,
    /// Compare rebuilt curves with those of another full table on the same axes
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    /// Most components to judge [1–31]
    #[arg(long, value_name = "N", default_value_t = 4)]
    components: usize,
    /// Compare look-ups with direct solutions at this many random places, chosen by --seed
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000), conflicts_with_all = ["truth", "components"])]
    off_grid: Option<u32>,
    /// Whose look-ups: the paper's, of a table in linear space, or ours, in log space [default: both]
    #[arg(long, value_name = "FORM", value_enum, requires = "off_grid")]
    interpolation: Option<Form>,
    /// CIE illuminants to see colours under, by commas
    #[arg(
        long, value_name = "NAMES", default_value = "D65", value_delimiter = ',', value_parser = parse::illuminant,
        help_heading = "Light"
    )]
    illuminant: Vec<Illuminant>,
    #[command(flatten)]
    output: OutputOptions,
    /// Draw worst ΔE and RMSE and the singular values against the number of components into an SVG file
    #[arg(long, value_name = "FILE", help_heading = "Output", conflicts_with = "off_grid")]
    plot: Option<PathBuf>,
}

/// One number of components of one quantity in one space, judged.
struct Judged {
    quantity: Quantity,
    space: Space,
    components: usize,
    illuminant: Illuminant,
    found: fidelity::Fidelity,
    singular_value: f64,
}

/// How a table is looked up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Form {
    Paper,
    Log,
}

const COLUMNS: [&str; 15] = [
    "quantity",
    "space",
    "components",
    "illuminant",
    "rmse_worst",
    "rmse_p99",
    "rmse_mean",
    "delta_e_worst",
    "delta_e_p99",
    "delta_e_mean",
    "share_above_2.3",
    "negative_values",
    "singular_value",
    "worst_rmse_curve",
    "worst_delta_e_curve",
];

const OFF_GRID_COLUMNS: [&str; 19] = [
    "quantity",
    "interpolation",
    "components",
    "samples",
    "least_angle_deg",
    "most_angle_deg",
    "illuminant",
    "bright_worst",
    "bright_p99",
    "bright_mean",
    "relative_worst",
    "relative_p99",
    "relative_mean",
    "delta_e_worst",
    "delta_e_p99",
    "delta_e_mean",
    "worst_bright_place",
    "worst_relative_place",
    "worst_delta_e_place",
];

impl Form {
    fn of(space: Space) -> Self {
        match space {
            Space::Linear => Self::Paper,
            Space::Log => Self::Log,
        }
    }
}

impl Fidelity {
    pub(super) fn run(&self, quiet: bool) -> Outcome {
        self.output.check()?;
        self.plot.as_deref().map_or(Ok(()), plot::check_place)?;
        if let Some(places) = self.off_grid {
            return self.off_grid(places, quiet);
        }
        if self.file.is_some() && self.filling.ordinates.seed != 1 {
            return Err(Failure::Input("--seed is of no use to a table that is filled already".to_owned()));
        }
        let table = match &self.file {
            None => self.filling.table(quiet)?.0,
            Some(path) => full(path)?,
        };
        let truth = self.truth.as_deref().map(full).transpose()?;
        if truth.as_ref().is_some_and(|truth| truth.axes != table.axes) {
            return Err(Failure::Input("the table of --truth has other axes".to_owned()));
        }
        let truth = truth.as_ref().unwrap_or(&table);
        let judged = self.judge(&table, truth).map_err(Failure::input)?;
        let rows = judged.iter().map(|judged| row(judged, truth)).collect();
        let claim = "l' = 2 linear: every ΔE below 2.3 and RMSE below 0.002";
        let metadata = vec![
            ("snowblue", env!("CARGO_PKG_VERSION").to_owned()),
            ("curves", table.axes.curves().to_string()),
            ("the paper claims", claim.to_owned()),
        ];
        if let Some(path) = &self.plot {
            write_file(path, plot::fidelity(&self.costs(&judged), &metadata).as_bytes())?;
        }
        Report { columns: COLUMNS.to_vec(), rows, metadata }.write(&self.output, quiet)
    }

    /// What is drawn: under the first illuminant.
    fn costs(&self, judged: &[Judged]) -> Vec<Cost> {
        let first = |one: &&Judged| Some(&one.illuminant) == self.illuminant.first();
        let largest = |one: &Judged| {
            let alike = |other: &&Judged| (other.quantity, other.space) == (one.quantity, one.space);
            judged.iter().find(alike).map_or(f64::NAN, |first| first.singular_value)
        };
        let cost = |one: &Judged| Cost {
            space: usize::from(one.space == Space::Log),
            quantity: usize::from(one.quantity == Quantity::Reflectance),
            components: one.components,
            measures: [one.found.delta_e.worst, one.found.rmse.worst, one.singular_value / largest(one)],
        };
        judged.iter().filter(first).map(cost).collect()
    }

    fn off_grid(&self, places: u32, quiet: bool) -> Outcome {
        let [illuminant] = self.illuminant[..] else {
            return Err(Failure::Input("--off-grid takes one illuminant".to_owned()));
        };
        let asked = OffGrid { places: places as usize, seed: self.filling.ordinates.seed, illuminant };
        let mut rows = Vec::new();
        for table in self.looked_up(quiet)? {
            for found in off_grid(&table, &asked).map_err(Failure::input)? {
                rows.push(off_grid_row(&table, illuminant, &found));
            }
        }
        let metadata = vec![
            ("snowblue", env!("CARGO_PKG_VERSION").to_owned()),
            ("places in each row", places.to_string()),
            ("bright", "where the value is above 1e-6".to_owned()),
        ];
        Report { columns: OFF_GRID_COLUMNS.to_vec(), rows, metadata }.write(&self.output, quiet)
    }

    /// The tables to look up in, one for each form that is asked for.
    fn looked_up(&self, quiet: bool) -> Result<Vec<CompressedTable>, Failure> {
        let wanted = |space: &Space| self.interpolation.is_none_or(|form| form == Form::of(*space));
        let spaces = [Space::Linear, Space::Log].into_iter().filter(wanted);
        let compress = |table: &Table, space: Space| {
            CompressedTable::new(
                table,
                space,
                space.usual_components().min(table.axes.wavelengths_nm.len()).min(table.axes.curves()),
            )
        };
        let Some(path) = &self.file else {
            return spaces
                .map(|space| match space {
                    Space::Linear => compress(&self.filling.table(quiet)?.0, space).map_err(Failure::input),
                    Space::Log => Ok(snowblue_data::embedded().clone()),
                })
                .collect();
        };
        match file::read(path).map_err(Failure::input)? {
            AnyTable::Full(table) => spaces.map(|space| compress(&table, space).map_err(Failure::input)).collect(),
            AnyTable::Compressed(table) if wanted(&table.space) => Ok(vec![table]),
            other => Err(Failure::Input(format!(
                "{}: is {}, which this look-up does not take",
                path.display(),
                other.kind()
            ))),
        }
    }

    fn judge(&self, table: &Table, truth: &Table) -> Result<Vec<Judged>, DatabaseError> {
        let mut judged = Vec::new();
        for quantity in Quantity::ALL {
            for space in [Space::Linear, Space::Log] {
                let decomposition = Decomposition::new(table, quantity, space)?;
                for components in 1..=self.components.min(decomposition.singular_values().len()) {
                    let kept = decomposition.keep(table, quantity, components)?;
                    for illuminant in &self.illuminant {
                        let found = fidelity::judge(truth, quantity, (&kept, space), Some(*illuminant))?;
                        let singular_value = decomposition.singular_values()[components - 1];
                        let illuminant = *illuminant;
                        judged.push(Judged { quantity, space, components, illuminant, found, singular_value });
                    }
                }
            }
        }
        Ok(judged)
    }
}

fn row(judged: &Judged, table: &Table) -> Vec<Cell> {
    let Judged { quantity, space, components, illuminant, found, singular_value } = judged;
    debug_assert!(PERCEPTIBLE_DELTA_E.to_bits() == 2.3_f64.to_bits(), "the column says 2.3");
    let word = |word: &str| Cell::Word(word.to_owned());
    let (rmse, delta_e) = (&found.rmse, &found.delta_e);
    let mut row = vec![word(quantity.name()), word(space.name()), (*components as f64).into(), word(illuminant.name())];
    let numbers = [
        rmse.worst,
        rmse.percentile_99,
        rmse.mean,
        delta_e.worst,
        delta_e.percentile_99,
        delta_e.mean,
        found.perceptible_share,
        found.negative_values as f64,
        *singular_value,
    ];
    row.extend(numbers.map(Cell::from));
    // Commas would part the words in CSV.
    row.extend([rmse, delta_e].map(|spread| Cell::Word(table.axes.describe(spread.worst_curve).replace(',', ";"))));
    row
}

fn off_grid_row(table: &CompressedTable, illuminant: Illuminant, found: &Interpolation) -> Vec<Cell> {
    let word = |word: &str| Cell::Word(word.replace(',', ";"));
    let form = match Form::of(table.space) {
        Form::Paper => "paper",
        Form::Log => "log",
    };
    let (low_deg, high_deg) = found.angles_deg;
    let mut row = vec![
        word(found.quantity.name()),
        word(form),
        (table.components(found.quantity).count as f64).into(),
        word(if found.between_samples { "between" } else { "grid" }),
        low_deg.into(),
        high_deg.into(),
        word(illuminant.name()),
    ];
    let numbers = |spread: &Spread| [spread.worst, spread.percentile_99, spread.mean].map(Cell::from);
    row.extend([&found.bright, &found.relative, &found.delta_e].into_iter().flat_map(numbers));
    row.extend(found.worst.iter().map(|place| word(place)));
    row
}

fn full(path: impl AsRef<Path>) -> Result<Table, Failure> {
    let path = path.as_ref();
    match file::read(path).map_err(Failure::input)? {
        AnyTable::Full(table) => Ok(table),
        other => Err(Failure::Input(format!("{}: is {}, but a full one is needed", path.display(), other.kind()))),
    }
}
