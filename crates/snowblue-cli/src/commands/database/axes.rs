//! Axes of a table: a preset, changed by a file and by options.

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use snowblue_base::toml_table::ParseError;
use snowblue_database::{Axes, axes_file};
use snowblue_transport::optics::IceTable;
use snowblue_transport::optics::Wavelengths;
use snowblue_transport::parameters::{ANGLE, THICKNESS};
use snowblue_transport::slab::Incidence;

use crate::input::SettingsFile;
use crate::options::PropertyAxis;
use crate::options::limits::{self, described};
use crate::options::parse;
use crate::options::property::PropertyValues;
use crate::output::Failure;

/// Axes of a table
#[derive(Debug, Args)]
#[command(next_help_heading = "Axes")]
pub(super) struct AxesOptions {
    /// Axes that further options change
    #[arg(long, value_name = "PRESET", value_parser = preset(), default_value = "paper")]
    preset: Axes,
    #[arg(
        long, value_name = "FILE", conflicts_with = "preset",
        help = format!(
            "TOML file of axes with the keys preset, {}, impurities_ng_g, thickness_cm, angle_deg, wavelength_nm",
            PropertyValues::<true>::keys()
        )
    )]
    axes: Option<PathBuf>,
    #[command(flatten)]
    properties: PropertyValues<true>,
    #[arg(
        long, value_name = "LIST", value_delimiter = ',', value_parser = parse::number,
        help = format!("{}, two or more", described(&THICKNESS))
    )]
    thickness: Vec<f64>,
    #[arg(
        long, value_name = "LIST", value_delimiter = ',', value_parser = parse::incidence,
        help = format!("{}, or 'diffuse'", described(&ANGLE))
    )]
    angle: Vec<Incidence>,
    #[arg(
        long, value_name = "NM",
        help = format!("Wavelengths in nm: FIRST:LAST:STEP or a list [{}]", limits::snow_wavelengths())
    )]
    wavelengths: Option<Wavelengths>,
}

/// Parses the name of a preset.
fn preset() -> impl TypedValueParser<Value = Axes> {
    let names = Axes::PRESETS.map(|(name, meaning)| PossibleValue::new(name).help(meaning));
    PossibleValuesParser::new(names).map(|name| Axes::preset(&name).expect("every name of a preset has axes"))
}

impl AxesOptions {
    /// The axes, checked with a table of ice.
    pub(super) fn axes(&self, ice: IceTable) -> Result<Axes, Failure> {
        let mut axes = match &self.axes {
            None => self.preset.clone(),
            Some(path) => read(path)?,
        };
        for PropertyAxis { property, values } in self.properties.iter() {
            if let Some(range) = values.iter().find(|value| value.len() > 1) {
                let (option, count) = (property.name().replace('_', "-"), range.len());
                return Err(Failure::Input(format!("a value of --{option} has {count} numbers, but must be a mean")));
            }
            axes.set_property(snowblue_database::PropertyAxis { property: *property, values: values.concat() });
        }
        if !self.thickness.is_empty() {
            axes.thicknesses_cm.clone_from(&self.thickness);
        }
        if let Some(Wavelengths(wavelengths_nm)) = &self.wavelengths {
            axes.wavelengths_nm.clone_from(wavelengths_nm);
        }
        if !self.angle.is_empty() {
            axes.set_incidences(&self.angle);
        }
        axes.check(ice).map_err(|error| match &self.axes {
            Some(path) => Failure::Input(format!("{}: {error}", path.display())),
            None => Failure::input(error),
        })?;
        Ok(axes)
    }
}

/// Reads a file of axes.
fn read(path: &Path) -> Result<Axes, Failure> {
    let text = SettingsFile::read(path)?;
    let source = SettingsFile { path, text: &text };
    axes_file::parse(&text).map_err(|ParseError { span, reason }| source.failure(&span, reason))
}
