//! `snowblue database import` and `export`: exchange of tables with other programs.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use snowblue_database::exchange::{self, FixedValues};
use snowblue_database::file::{self, AnyTable};

use crate::options::{Compression, parse};
use crate::output::{
    Failure, Outcome, check_not_input, check_path, check_table_path, ending, output_path, print_message,
};

/// Make a table from the curves of another model or an instrument
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "A CSV file has a row for each value, with the columns grain_size_um, facetness, density_kg_m3, \
angle_deg (degrees or 'diffuse'), thickness_cm, wavelength_nm, transmittance, reflectance, and optionally \
water_saturation, temperature_c, black_carbon_ng_g … A NetCDF file (classic format) has the variables transmittance \
and reflectance on dimensions of these names without units, in any order. The values must form a complete grid.

Examples:
  snowblue database import curves.csv -o table.nc
  snowblue database import tartes.nc --set facetness=0.3 --set density=300 -o snow.nc
  snowblue spectrum --thickness 1,5,15 --angle 0,60 -o s.csv
  snowblue database import s.csv --set grain_size=400 --set facetness=0.3 --set density=300 -o t.nc"
)]
pub(crate) struct Import {
    /// File to read: CSV, or NetCDF if it ends in .nc
    file: PathBuf,
    /// Value of an axis or a quantity that the file does not hold, as density=300; repeatable
    #[arg(long, value_name = "NAME=VALUE", value_parser = fixed_value)]
    set: Vec<FixedValue>,
    #[command(flatten)]
    compression: Compression,
    /// Table to write (.nc, NetCDF)
    #[arg(short, long, value_name = "FILE", value_parser = output_path(), help_heading = "Output")]
    output: PathBuf,
}

/// Write a table for programs that do not read NetCDF
#[derive(Debug, Args)]
#[command(
    after_help = "'raw' writes FILE.json, which describes the layout, and FILE.f32 with little-endian single-precision \
numbers. 'csv' writes a row for each value, as 'import' reads it.

Examples:
  snowblue database export -o snow.json              the embedded table, for a real-time engine
  snowblue database export full.nc -o full.csv"
)]
pub(crate) struct Export {
    /// Table to export [default: the embedded one]
    file: Option<PathBuf>,
    /// Format [default: by the file's ending: .json is raw, .csv is CSV]
    #[arg(long, value_name = "FORMAT", value_enum)]
    format: Option<ExportFormat>,
    /// File to write (.json or .csv)
    #[arg(short, long, value_name = "FILE", value_parser = output_path())]
    output: PathBuf,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ExportFormat {
    /// JSON header and raw numbers
    Raw,
    /// A row for each value
    Csv,
}

/// `density=300`: a value of an axis or a quantity.
#[derive(Debug, Clone)]
struct FixedValue {
    name: String,
    value: f64,
}

fn fixed_value(words: &str) -> Result<FixedValue, String> {
    let (name, value) = words.split_once('=').ok_or("give NAME=VALUE (facetness=0.3)")?;
    let is_angle = ["angle", "angle_deg"].contains(&name.trim());
    let value =
        if value == "diffuse" && is_angle { snowblue_database::axes::DIFFUSE_ANGLE_DEG } else { parse::number(value)? };
    Ok(FixedValue { name: name.trim().to_owned(), value })
}

impl Import {
    pub(super) fn run(&self, quiet: bool) -> Outcome {
        check_table_path(&self.output)?;
        check_not_input(&self.file, &self.output)?;
        self.compression.check()?;
        let fixed: FixedValues = self.set.iter().map(|fixed| (fixed.name.clone(), fixed.value)).collect();
        if fixed.len() < self.set.len() {
            return Err(Failure::Input("--set is given twice for one name".to_owned()));
        }
        let table = exchange::import(&self.file, &fixed).map_err(Failure::input)?;
        let compression = self.compression.write(&table, &self.output)?;
        if !quiet {
            print_message(&format!("{}: {} curves{compression}\n", self.output.display(), table.axes.curves()));
        }
        Ok(())
    }
}

impl Export {
    pub(super) fn run(&self) -> Outcome {
        let format = match (self.format, &*ending(&self.output, "csv")) {
            (Some(format), _) => format,
            (None, "json") => ExportFormat::Raw,
            (None, "csv") => ExportFormat::Csv,
            _ => {
                let name = self.output.display();
                return Err(Failure::Input(format!("{name}: the file must end in .json or .csv, or give --format")));
            }
        };
        check_path(&self.output)?;
        let table = match &self.file {
            Some(path) => file::read(path).map_err(Failure::input)?,
            None => AnyTable::Compressed(snowblue_data::embedded().clone()),
        };
        let export = match format {
            ExportFormat::Raw => exchange::export_raw,
            ExportFormat::Csv => exchange::export_csv,
        };
        if let AnyTable::Shard(_) = table {
            return Err(Failure::Input("a shard cannot be exported; merge it first".to_owned()));
        }
        export(&table, &self.output).map_err(Failure::work)
    }
}
