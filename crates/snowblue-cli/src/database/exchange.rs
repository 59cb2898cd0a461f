//! `snowblue database import` and `export`: tables from and to other programs.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use snowblue_database::exchange::{self, Fixed};
use snowblue_database::file::{self, AnyTable};

use super::Compression;
use crate::failure::{Failure, Outcome};
use crate::parse;
use crate::report::{check_place, check_table_place, tell};

/// Make a table of curves from another model or an instrument
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "A CSV file has a row for each value, with the columns grain_size_um, facetness, density_kg_m3, \
angle_deg (degrees or 'diffuse'), thickness_cm, wavelength_nm, and if they differ water_saturation, temperature_c, \
black_carbon_ng_g …; and transmittance, reflectance. A NetCDF file (classic) has the variables transmittance and \
reflectance on dimensions of these names, without the units, in any order. The values must be a whole grid.

Examples:
  snowblue database import curves.csv -o table.nc
  snowblue database import tartes.nc --set facetness=0.3 --set density=300 --space log --components 3 -o snow.nc
  snowblue spectrum --thickness 1,5,15 --angle 0,60 -o s.csv && \\
  snowblue database import s.csv --set grain_size=400 --set facetness=0.3 --set density=300 -o table.nc"
)]
pub(crate) struct Import {
    /// File to read: CSV, or NetCDF if it ends in .nc
    file: PathBuf,
    /// A value for what the file does not hold, an axis of one value or a quantity; repeatable
    #[arg(long, value_name = "NAME=VALUE", value_parser = setting)]
    set: Vec<(String, f64)>,
    #[command(flatten)]
    compression: Compression,
    /// Where to write the table (NetCDF)
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

/// Write a table for programs that read no NetCDF
#[derive(Debug, Args)]
#[command(
    after_help = "Formats: 'raw' writes FILE.json, which says what is where, and FILE.f32 beside it: numbers in \
single precision, little-endian. 'csv' writes a row for each value, as 'import' reads it.

Examples:
  snowblue database export -o snow.json              the embedded table for a real-time engine
  snowblue database export full.nc -o full.csv"
)]
pub(crate) struct Export {
    /// Table to read [default: the embedded one]
    file: Option<PathBuf>,
    /// Format [default: by the file's ending: .json is raw, .csv is CSV]
    #[arg(long, value_name = "FORMAT", value_enum)]
    format: Option<Format>,
    /// Where to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    Raw,
    Csv,
}

fn setting(words: &str) -> Result<(String, f64), String> {
    let (name, value) = words.split_once('=').ok_or("give NAME=VALUE (facetness=0.3)")?;
    let is_angle = ["angle", "angle_deg"].contains(&name.trim());
    let value =
        if value == "diffuse" && is_angle { snowblue_database::axes::DIFFUSE_ANGLE_DEG } else { parse::number(value)? };
    Ok((name.trim().to_owned(), value))
}

/// Whether two names stand for one file.
fn same_file(one: &Path, other: &Path) -> bool {
    one.canonicalize().is_ok_and(|one| other.canonicalize().is_ok_and(|other| one == other))
}

impl Import {
    pub(super) fn run(&self, quiet: bool) -> Outcome {
        check_table_place(&self.output)?;
        if same_file(&self.file, &self.output) {
            return Err(Failure::Input(format!("{}: would be overwritten by its own table", self.file.display())));
        }
        self.compression.check()?;
        let fixed: Fixed = self.set.iter().cloned().collect();
        if fixed.len() < self.set.len() {
            return Err(Failure::Input("--set names something twice".to_owned()));
        }
        let is_netcdf = self.file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("nc"));
        let import = if is_netcdf { exchange::import_netcdf } else { exchange::import_csv };
        let table = import(&self.file, &fixed).map_err(Failure::input)?;
        let kept = self.compression.write(&table, &self.output)?;
        if !quiet {
            tell(&format!("{}: {} curves{kept}\n", self.output.display(), table.axes.curves()));
        }
        Ok(())
    }
}

impl Export {
    pub(super) fn run(&self) -> Outcome {
        let ending = self.output.extension().and_then(|ending| ending.to_str()).map(str::to_lowercase);
        let format = match (self.format, ending.as_deref()) {
            (Some(format), _) => format,
            (None, Some("json")) => Format::Raw,
            (None, Some("csv")) => Format::Csv,
            _ => {
                let name = self.output.display();
                return Err(Failure::Input(format!("{name}: the file must end in .json or .csv, or give --format")));
            }
        };
        check_place(&self.output)?;
        let table = match &self.file {
            Some(path) => file::read(path).map_err(Failure::input)?,
            None => AnyTable::Compressed(snowblue_data::embedded().clone()),
        };
        let export = match format {
            Format::Raw => exchange::export_raw,
            Format::Csv => exchange::export_csv,
        };
        if let AnyTable::Shard(_) = table {
            return Err(Failure::Input("a shard cannot be exported; merge it first".to_owned()));
        }
        export(&table, &self.output).map_err(Failure::work)
    }
}
