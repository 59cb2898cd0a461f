//! How much of a table is kept in its file.

use std::path::Path;

use clap::{Args, ValueEnum};
use snowblue_color::Illuminant;
use snowblue_database::fidelity::{self, Criteria};
use snowblue_database::{CompressedTable, Space, Table};

use crate::failure::{Failure, Outcome};
use crate::parse;

/// What to keep
#[derive(Debug, Args)]
#[command(next_help_heading = "Compression")]
pub(crate) struct Compression {
    /// Compress in this space; without it the full table is written
    #[arg(long, value_name = "SPACE", value_enum)]
    space: Option<SpaceWord>,
    /// Principal components to keep [1–31]
    #[arg(long, value_name = "N", requires = "space", conflicts_with_all = ["max_delta_e", "max_rmse"])]
    components: Option<usize>,
    /// Keep as few components as leave every curve below this colour difference, CIELAB 1976 (the paper: 2.3)
    #[arg(long, value_name = "DE", requires = "space", value_parser = parse::number)]
    max_delta_e: Option<f64>,
    /// Keep as few components as leave every curve below this root mean square error (the paper: 0.002)
    #[arg(long, value_name = "RMSE", requires = "space", value_parser = parse::number)]
    max_rmse: Option<f64>,
    /// Illuminants under which colours must not differ, by commas
    #[arg(
        long, value_name = "NAMES", default_value = "D65", value_delimiter = ',', value_parser = parse::illuminant,
        requires = "max_delta_e"
    )]
    illuminant: Vec<Illuminant>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SpaceWord {
    Linear,
    Log,
}

impl Compression {
    /// Whether anything but the full table is asked for.
    pub(crate) fn is_asked(&self) -> bool {
        self.space.is_some()
    }

    /// Checks, before long work, that the options go together.
    pub(crate) fn check(&self) -> Outcome {
        let said = self.components.is_some() || self.max_delta_e.is_some() || self.max_rmse.is_some();
        if self.space.is_some() && !said {
            return Err(Failure::Input("--space needs --components, --max-delta-e or --max-rmse".to_owned()));
        }
        Ok(())
    }

    /// Writes a table, compressed as asked for, and says how in a few words.
    pub(crate) fn write(&self, table: &Table, path: &Path) -> Result<String, Failure> {
        let Some(space) = self.space.map(SpaceWord::space) else {
            table.write(path).map_err(Failure::work)?;
            return Ok(String::new());
        };
        let components = match self.components {
            Some(components) => components,
            None => {
                let criteria = Criteria {
                    most_delta_e: self.max_delta_e.unwrap_or(f64::INFINITY),
                    most_rmse: self.max_rmse.unwrap_or(f64::INFINITY),
                    illuminants: self.illuminant.clone(),
                };
                fidelity::fewest(table, space, &criteria).map_err(Failure::input)?
            }
        };
        let compressed = CompressedTable::new(table, space, components).map_err(Failure::input)?;
        compressed.write(path).map_err(Failure::work)?;
        Ok(format!(", {components} components in {} space", space.name()))
    }
}

impl SpaceWord {
    fn space(self) -> Space {
        match self {
            Self::Linear => Space::Linear,
            Self::Log => Space::Log,
        }
    }
}
