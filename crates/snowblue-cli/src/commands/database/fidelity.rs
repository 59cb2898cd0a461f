//! `snowblue database fidelity`: errors of compression.

use std::path::{Path, PathBuf};

use clap::Args;
use snowblue_color::Illuminant;
use snowblue_database::fidelity::{self, PERCEPTIBLE_DELTA_E};
use snowblue_database::file::{self, AnyTable};
use snowblue_database::pca::Decomposition;
use snowblue_database::{DatabaseError, Quantity, Space, Table};
use snowblue_figures::{Cell, DataTable};

use super::filling::Filling;
use crate::options::{GivenOptions, Idle, parse};
use crate::output::{Failure, Outcome, OutputOptions};

/// Compute the errors of 1–N principal components over all curves of a full table, in both spaces
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Each row has the errors over all reconstructed curves (worst, 99th percentile, mean), the worst \
curves, and the singular value of the last component.

Examples:
  snowblue database fidelity full.nc
  snowblue database fidelity --illuminant E,D65,LED-B5 --components 6 -o fidelity.csv
  snowblue database fidelity mc.nc --truth exact.nc     effect of Monte Carlo noise"
)]
pub(crate) struct Fidelity {
    /// Must be the first field.
    #[command(flatten)]
    given: GivenOptions,
    /// Full table [default: computed on the given axes]
    #[arg(conflicts_with_all = ["Filling", "AxesOptions", "AxisProperties", "streams"])]
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
    /// CIE illuminants of colour differences, separated by commas
    #[arg(
        long, value_name = "NAMES", default_value = "D65", value_delimiter = ',', value_parser = parse::illuminant,
        help_heading = "Light"
    )]
    illuminant: Vec<Illuminant>,
    #[command(flatten)]
    output: OutputOptions,
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

impl Fidelity {
    pub(super) fn run(&self, quiet: bool) -> Outcome {
        self.output.check()?;
        self.given.refuse_idle(&self.filling.idle())?;
        self.given.refuse_idle(&[Idle {
            when: self.file.is_some(),
            options: &["seed"],
            why: "the table is from a file",
        }])?;
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
        self.output.write(&DataTable { columns: COLUMNS.to_vec(), rows, metadata }, quiet)
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

fn full(path: impl AsRef<Path>) -> Result<Table, Failure> {
    let path = path.as_ref();
    match file::read(path).map_err(Failure::input)? {
        AnyTable::Full(table) => Ok(table),
        other => Err(Failure::Input(format!("{}: is {}, but must be a full table", path.display(), other.kind()))),
    }
}
