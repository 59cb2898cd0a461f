//! `snowblue database fidelity`: what compression costs.

use std::path::{Path, PathBuf};

use clap::Args;
use snowblue_color::Illuminant;
use snowblue_database::fidelity::{self, PERCEPTIBLE_DELTA_E};
use snowblue_database::file::{self, AnyTable};
use snowblue_database::pca::Decomposition;
use snowblue_database::{DatabaseError, Quantity, Space, Table};

use super::Filling;
use crate::failure::{Failure, Outcome};
use crate::options::OutputOptions;
use crate::parse;
use crate::report::{Cell, Report};

/// Judge how well 1–N principal components keep every curve of a full table, in both spaces
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Each row tells the errors of all rebuilt curves: worst, 99th percentile, mean; which curves are worst; \
and the singular value of the row's last component.

Examples:
  snowblue database fidelity full.nc
  snowblue database fidelity --illuminant E,D65,LED-B5 --components 6 --format csv -o fidelity.csv
  snowblue database fidelity walked.nc --truth solved.nc     what the noise of few rays does to components and colours"
)]
pub(crate) struct Fidelity {
    /// Full table to judge [default: the axes asked for, filled now]
    #[arg(conflicts_with_all = ["Filling", "AxesOptions", "OrdinatesWords"])]
    file: Option<PathBuf>,
    #[command(flatten)]
    filling: Filling,
    /// Compare rebuilt curves with those of another full table on the same axes
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    /// Most components to judge [1–31]
    #[arg(long, value_name = "N", default_value_t = 4)]
    components: usize,
    /// CIE illuminants to see colours under, by commas
    #[arg(
        long, value_name = "NAMES", default_value = "D65", value_delimiter = ',', value_parser = parse::illuminant,
        help_heading = "Light"
    )]
    illuminant: Vec<Illuminant>,
    #[command(flatten)]
    output: OutputOptions,
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

impl Fidelity {
    pub(super) fn run(&self, quiet: bool) -> Outcome {
        let table = match &self.file {
            None => self.filling.table(quiet)?.0,
            Some(path) => full(path)?,
        };
        let truth = self.truth.as_deref().map(full).transpose()?;
        if truth.as_ref().is_some_and(|truth| truth.axes != table.axes) {
            return Err(Failure::Input("the table of --truth has other axes".to_owned()));
        }
        let rows = self.judge(&table, truth.as_ref().unwrap_or(&table)).map_err(Failure::input)?;
        let claim = "l' = 2 linear: every ΔE below 2.3 and RMSE below 0.002";
        let metadata = vec![
            ("snowblue", env!("CARGO_PKG_VERSION").to_owned()),
            ("curves", table.axes.curves().to_string()),
            ("the paper claims", claim.to_owned()),
        ];
        Report { columns: COLUMNS.to_vec(), rows, metadata }.write(&self.output, quiet)
    }

    fn judge(&self, table: &Table, truth: &Table) -> Result<Vec<Vec<Cell>>, DatabaseError> {
        let mut rows = Vec::new();
        for quantity in Quantity::ALL {
            for space in [Space::Linear, Space::Log] {
                let decomposition = Decomposition::new(table, quantity, space)?;
                for components in 1..=self.components.min(decomposition.singular_values().len()) {
                    let kept = decomposition.keep(table, quantity, components)?;
                    for illuminant in &self.illuminant {
                        let found = fidelity::judge(truth, quantity, (&kept, space), *illuminant)?;
                        let value = decomposition.singular_values()[components - 1];
                        rows.push(row((quantity, space, components, *illuminant), &found, (truth, value)));
                    }
                }
            }
        }
        Ok(rows)
    }
}

fn row(
    (quantity, space, components, illuminant): (Quantity, Space, usize, Illuminant),
    found: &fidelity::Fidelity,
    (table, singular_value): (&Table, f64),
) -> Vec<Cell> {
    debug_assert!(PERCEPTIBLE_DELTA_E.to_bits() == 2.3_f64.to_bits(), "the column says 2.3");
    let word = |word: &str| Cell::Word(word.to_owned());
    let (rmse, delta_e) = (&found.rmse, &found.delta_e);
    let mut row = vec![word(quantity.name()), word(space.name()), (components as f64).into(), word(illuminant.name())];
    let numbers = [
        rmse.worst,
        rmse.percentile_99,
        rmse.mean,
        delta_e.worst,
        delta_e.percentile_99,
        delta_e.mean,
        found.perceptible_share,
        found.negative_values as f64,
        singular_value,
    ];
    row.extend(numbers.map(Cell::from));
    // Commas would part the words in CSV.
    row.extend([rmse, delta_e].map(|spread| Cell::Word(table.axes.describe(spread.worst_curve).replace(',', ";"))));
    row
}

fn full(path: impl AsRef<Path>) -> Result<Table, Failure> {
    let path = path.as_ref();
    match file::read(path).map_err(Failure::input)? {
        AnyTable::Full(table) => Ok(table),
        other => Err(Failure::Input(format!("{}: is {}, but a full one is needed", path.display(), other.kind()))),
    }
}
