//! `snowblue database fidelity`: errors of compression, and of interpolation between the values of a table.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use snowblue_color::Illuminant;
use snowblue_database::fidelity::off_grid::{OffGridErrors, OffGridOptions, evaluate_off_grid};
use snowblue_database::fidelity::{self, PERCEPTIBLE_DELTA_E, Spread};
use snowblue_database::file::{self, AnyTable};
use snowblue_database::pca::Decomposition;
use snowblue_database::{CompressedTable, DatabaseError, Quantity, Space, Table};
use snowblue_figures::plot::{self, CompressionError};
use snowblue_figures::{Cell, DataTable};

use super::filling::Filling;
use crate::options::{GivenOptions, Idle, parse};
use crate::output::{Failure, Outcome, OutputOptions, check_extension, write_file};

/// Compute the errors of 1–N principal components over all curves of a full table, in both spaces
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Each row has the errors over all reconstructed curves (worst, 99th percentile, mean), the worst \
curves, and the singular value of the last component.

With --off-grid, look-ups at random thicknesses (0.01–100 cm) and angles (0–80° and 80–89°) are compared with direct \
solutions. These use the rays and the seed of the table, so that the errors are those of interpolation: for samples of \
the table ('grid') and, in log space, for samples between them ('between'). Relative errors are given for values above \
1e-6 ('bright') and for all values.

Examples:
  snowblue database fidelity full.nc
  snowblue database fidelity --illuminant E,D65,LED-B5 --components 6 -o fidelity.csv --plot f.svg
  snowblue database fidelity mc.nc --truth exact.nc     effect of Monte Carlo noise
  snowblue database fidelity --off-grid 200             errors of look-ups, ours and the paper's
  snowblue database fidelity --off-grid 200 --seed 2 small.nc"
)]
pub(crate) struct Fidelity {
    /// Must be the first field.
    #[command(flatten)]
    given: GivenOptions,
    /// Full table, with --off-grid also a compressed one [default: computed on the given axes]
    #[arg(conflicts_with_all = ["Filling", "AxesOptions", "streams"])]
    file: Option<PathBuf>,
    #[command(flatten)]
    filling: Filling,
    /// Full table on the same axes to compare the reconstructed curves with [default: the table itself]
    #[arg(long, value_name = "FILE", help_heading = "Fidelity")]
    truth: Option<PathBuf>,
    /// Greatest number of components [1–31]
    #[arg(
        long, value_name = "N", default_value_t = 4, value_parser = parse::whole_number::<usize>(1..=31),
        help_heading = "Fidelity"
    )]
    components: usize,
    /// Compare look-ups with direct solutions at this many random points, chosen by --seed [1–100000]
    #[arg(
        long, value_name = "N", value_parser = parse::whole_number::<u32>(1..=100_000),
        conflicts_with_all = ["truth", "components"], help_heading = "Fidelity"
    )]
    off_grid: Option<u32>,
    /// Interpolation of the look-ups [default: both]
    #[arg(long, value_name = "FORM", value_enum, requires = "off_grid", help_heading = "Fidelity")]
    interpolation: Option<InterpolationArgument>,
    /// CIE illuminants of colour differences, separated by commas
    #[arg(
        long, value_name = "NAMES", default_value = "D65", value_delimiter = ',', value_parser = parse::illuminant,
        help_heading = "Light"
    )]
    illuminant: Vec<Illuminant>,
    #[command(flatten)]
    output: OutputOptions,
    /// Draw worst ΔE, worst RMSE and singular values against the number of components into this SVG file
    #[arg(long, value_name = "FILE", help_heading = "Output", conflicts_with = "off_grid")]
    plot: Option<PathBuf>,
}

/// Errors of a number of components of one quantity in one space.
struct Judgement {
    quantity: Quantity,
    space: Space,
    components: usize,
    illuminant: Illuminant,
    fidelity: fidelity::Fidelity,
    singular_value: f64,
}

/// Interpolation of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum InterpolationArgument {
    /// The paper's, in linear space
    Paper,
    /// Ours, in log space
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
    "fraction_above_2.3",
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
    "greatest_angle_deg",
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
    "worst_bright_point",
    "worst_relative_point",
    "worst_delta_e_point",
];

impl InterpolationArgument {
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
        if let Some(path) = &self.plot {
            check_extension(path, "svg", "the plot")?;
        }
        self.check_effects()?;
        if let Some(points) = self.off_grid {
            return self.off_grid(points, quiet);
        }
        let table = match &self.file {
            None => self.filling.table(quiet)?.table,
            Some(path) => full(path)?,
        };
        let truth = self.truth.as_deref().map(full).transpose()?;
        if truth.as_ref().is_some_and(|truth| truth.axes != table.axes) {
            return Err(Failure::Input("--truth: the table has other axes".to_owned()));
        }
        let truth = truth.as_ref().unwrap_or(&table);
        let judgements = self.judge(&table, truth).map_err(Failure::input)?;
        let rows = judgements.iter().map(|judgement| row(judgement, truth)).collect();
        let claim = "l' = 2 linear: every ΔE below 2.3 and RMSE below 0.002";
        let metadata = vec![
            ("snowblue", env!("CARGO_PKG_VERSION").to_owned()),
            ("curves", table.axes.curves().to_string()),
            ("the paper claims", claim.to_owned()),
        ];
        if let Some(path) = &self.plot {
            write_file(path, plot::fidelity(&self.plotted(&judgements), &metadata).as_bytes())?;
        }
        self.output.write(&DataTable { columns: COLUMNS.to_vec(), rows, metadata }, quiet)
    }

    /// Refuses options without effect. Those that fill a table conflict with one from a file.
    fn check_effects(&self) -> Outcome {
        self.given.refuse_idle(&self.filling.idle())?;
        self.given.refuse_idle(&[
            Idle {
                when: self.file.is_some() && self.off_grid.is_none(),
                options: &["seed"],
                why: "the table is from a file, and --off-grid draws no points",
            },
            Idle {
                when: self.file.is_none() && self.interpolation == Some(InterpolationArgument::Log),
                options: &[
                    "preset",
                    "axes",
                    "grain_size",
                    "facetness",
                    "density",
                    "thickness",
                    "angle",
                    "wavelengths",
                    "water_saturation",
                    "temperature",
                    "impurity",
                    "ice",
                    "engine",
                    "tally_rays",
                    "rays",
                    "streams",
                ],
                why: "--interpolation log without a file is that of the embedded table",
            },
        ])
    }

    /// The errors under the first illuminant.
    fn plotted(&self, judgements: &[Judgement]) -> Vec<CompressionError> {
        let first_singular_value = |judgement: &Judgement| {
            let same_curve =
                |other: &&Judgement| (other.quantity, other.space) == (judgement.quantity, judgement.space);
            judgements.iter().find(same_curve).map_or(f64::NAN, |first| first.singular_value)
        };
        let error = |judgement: &Judgement| CompressionError {
            space: judgement.space,
            quantity: judgement.quantity,
            components: judgement.components,
            worst_delta_e: judgement.fidelity.delta_e.worst,
            worst_rmse: judgement.fidelity.rmse.worst,
            relative_singular_value: judgement.singular_value / first_singular_value(judgement),
        };
        judgements
            .iter()
            .filter(|judgement| Some(&judgement.illuminant) == self.illuminant.first())
            .map(error)
            .collect()
    }

    fn off_grid(&self, points: u32, quiet: bool) -> Outcome {
        let [illuminant] = self.illuminant[..] else {
            return Err(Failure::Input("--off-grid needs exactly one illuminant".to_owned()));
        };
        let options = OffGridOptions { points: points as usize, seed: self.filling.ordinates.seed, illuminant };
        let mut rows = Vec::new();
        for table in self.looked_up(quiet)? {
            for found in evaluate_off_grid(&table, &options).map_err(Failure::input)? {
                rows.push(off_grid_row(&table, illuminant, &found));
            }
        }
        let metadata = vec![
            ("snowblue", env!("CARGO_PKG_VERSION").to_owned()),
            ("points in each row", points.to_string()),
            ("bright", "where the value is above 1e-6".to_owned()),
        ];
        self.output.write(&DataTable { columns: OFF_GRID_COLUMNS.to_vec(), rows, metadata }, quiet)
    }

    /// A table for each interpolation.
    fn looked_up(&self, quiet: bool) -> Result<Vec<CompressedTable>, Failure> {
        let wanted = |space: &Space| {
            self.interpolation.is_none_or(|interpolation| interpolation == InterpolationArgument::of(*space))
        };
        let spaces = [Space::Linear, Space::Log].into_iter().filter(wanted);
        let compress = |table: &Table, space: Space| {
            CompressedTable::new(
                table,
                space,
                space.default_components().min(table.axes.wavelengths_nm.len()).min(table.axes.curves()),
            )
        };
        let Some(path) = &self.file else {
            return spaces
                .map(|space| match space {
                    Space::Linear => compress(&self.filling.table(quiet)?.table, space).map_err(Failure::input),
                    Space::Log => Ok(snowblue_data::embedded().clone()),
                })
                .collect();
        };
        match file::read(path).map_err(Failure::input)? {
            AnyTable::Full(table) => spaces.map(|space| compress(&table, space).map_err(Failure::input)).collect(),
            AnyTable::Compressed(table) if wanted(&table.space) => Ok(vec![table]),
            other => Err(Failure::Input(format!(
                "{}: is {}, which this interpolation does not take",
                path.display(),
                other.kind()
            ))),
        }
    }

    fn judge(&self, table: &Table, truth: &Table) -> Result<Vec<Judgement>, DatabaseError> {
        let mut judgements = Vec::new();
        for quantity in Quantity::ALL {
            for space in [Space::Linear, Space::Log] {
                let decomposition = Decomposition::new(table, quantity, space)?;
                for components in 1..=self.components.min(decomposition.singular_values().len()) {
                    let kept = decomposition.keep(table, quantity, components)?;
                    for &illuminant in &self.illuminant {
                        let fidelity = fidelity::evaluate(truth, quantity, &kept, space, Some(illuminant))?;
                        let singular_value = decomposition.singular_values()[components - 1];
                        judgements.push(Judgement {
                            quantity,
                            space,
                            components,
                            illuminant,
                            fidelity,
                            singular_value,
                        });
                    }
                }
            }
        }
        Ok(judgements)
    }
}

fn row(judgement: &Judgement, table: &Table) -> Vec<Cell> {
    let Judgement { quantity, space, components, illuminant, fidelity, singular_value } = judgement;
    debug_assert!(PERCEPTIBLE_DELTA_E.to_bits() == 2.3_f64.to_bits(), "the column's name has 2.3");
    let (rmse, delta_e) = (&fidelity.rmse, &fidelity.delta_e);
    let mut row = vec![
        Cell::word(quantity.name()),
        Cell::word(space.name()),
        (*components as f64).into(),
        Cell::word(illuminant.name()),
    ];
    let numbers = [
        rmse.worst,
        rmse.percentile_99,
        rmse.mean,
        delta_e.worst,
        delta_e.percentile_99,
        delta_e.mean,
        fidelity.perceptible_fraction,
        fidelity.negative_values as f64,
        *singular_value,
    ];
    row.extend(numbers.map(Cell::from));
    // A comma would separate columns in CSV.
    row.extend([rmse, delta_e].map(|spread| Cell::Word(table.axes.describe(spread.worst_curve).replace(',', ";"))));
    row
}

fn off_grid_row(table: &CompressedTable, illuminant: Illuminant, found: &OffGridErrors) -> Vec<Cell> {
    let word = |word: &str| Cell::Word(word.replace(',', ";"));
    let interpolation = match InterpolationArgument::of(table.space) {
        InterpolationArgument::Paper => "paper",
        InterpolationArgument::Log => "log",
    };
    let mut row = vec![
        word(found.quantity.name()),
        word(interpolation),
        (table.components(found.quantity).count as f64).into(),
        word(if found.between_samples { "between" } else { "grid" }),
        found.angles_deg.low.into(),
        found.angles_deg.high.into(),
        word(illuminant.name()),
    ];
    let numbers = |spread: &Spread| [spread.worst, spread.percentile_99, spread.mean].map(Cell::from);
    row.extend([&found.bright, &found.relative, &found.delta_e].into_iter().flat_map(numbers));
    row.extend([&found.worst.bright, &found.worst.relative, &found.worst.delta_e].map(|point| word(point)));
    row
}

fn full(path: impl AsRef<Path>) -> Result<Table, Failure> {
    let path = path.as_ref();
    match file::read(path).map_err(Failure::input)? {
        AnyTable::Full(table) => Ok(table),
        other => Err(Failure::Input(format!("{}: is {}, but must be a full table", path.display(), other.kind()))),
    }
}
