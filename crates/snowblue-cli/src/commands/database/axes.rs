//! Axes of a table: a preset, changed by a file and by options.

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use snowblue_database::axes_file::{self, AxesFileError};
use snowblue_database::{Axes, Property, PropertyAxis};
use snowblue_transport::optics::IceTable;
use snowblue_transport::parameters::{
    ANGLE, DENSITY, FACETNESS, MASS_FRACTION, TEMPERATURE, THICKNESS, WATER_SATURATION,
};
use snowblue_transport::sample::{MEAN_SIZE_HALF_RANGE_UM, MEAN_SIZE_RANGE};
use snowblue_transport::slab::Incidence;

use crate::input::SettingsFile;
use crate::options::limits::{self, described};
use crate::options::parse::{self, ImpurityAxis, Wavelengths};
use crate::output::Failure;

/// Axes of a table
#[derive(Debug, Args)]
#[command(next_help_heading = "Axes")]
pub(super) struct AxesOptions {
    /// Axes that further options change
    #[arg(long, value_name = "PRESET", value_parser = preset(), default_value = "paper")]
    preset: Axes,
    /// TOML file of axes with the keys preset, grain_size_um, facetness, density_kg_m3, thickness_cm, angle_deg,
    /// wavelength_nm, water_saturation, temperature_c, impurities_ng_g
    #[arg(long, value_name = "FILE", conflicts_with = "preset")]
    axes: Option<PathBuf>,
    #[arg(
        long, value_name = "LIST", value_delimiter = ',', value_parser = parse::number,
        help = format!(
            "Mean grain sizes in µm, each for the range mean ± {MEAN_SIZE_HALF_RANGE_UM} [{}]",
            limits::ends(&MEAN_SIZE_RANGE.inclusive())
        )
    )]
    grain_size: Vec<f64>,
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = parse::number, help = described(&FACETNESS))]
    facetness: Vec<f64>,
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = parse::number, help = described(&DENSITY))]
    density: Vec<f64>,
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
        long, value_name = "NM", value_parser = parse::wavelengths,
        help = format!("Wavelengths in nm: FIRST:LAST:STEP or a list [{}]", limits::snow_wavelengths())
    )]
    wavelengths: Option<Wavelengths>,
    #[arg(
        long, value_name = "LIST", value_delimiter = ',', value_parser = parse::number,
        help = described(&WATER_SATURATION)
    )]
    water_saturation: Vec<f64>,
    #[arg(
        long, value_name = "LIST", value_delimiter = ',', value_parser = parse::number, allow_negative_numbers = true,
        help = described(&TEMPERATURE)
    )]
    temperature: Vec<f64>,
    #[arg(
        long, value_name = "NAME=LIST", value_parser = parse::impurity_axis,
        help = format!("{}, as black-carbon=0:10:100; repeatable", described(&MASS_FRACTION))
    )]
    impurity: Vec<ImpurityAxis>,
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
            Some(path) => read(path, ice)?,
        };
        let given = |values: &[f64]| (!values.is_empty()).then(|| values.to_vec());
        replace(&mut axes.grain_sizes_um, given(&self.grain_size));
        replace(&mut axes.facetness, given(&self.facetness));
        replace(&mut axes.densities_kg_m3, given(&self.density));
        replace(&mut axes.thicknesses_cm, given(&self.thickness));
        replace(&mut axes.wavelengths_nm, self.wavelengths.as_ref().map(|wavelengths| wavelengths.0.clone()));
        if !self.angle.is_empty() {
            axes.set_incidences(&self.angle);
        }
        set_property(&mut axes, Property::WaterSaturation, given(&self.water_saturation));
        set_property(&mut axes, Property::Temperature, given(&self.temperature));
        for ImpurityAxis { substance, ng_g } in &self.impurity {
            set_property(&mut axes, Property::Impurity(*substance), Some(ng_g.clone()));
        }
        axes.check(ice).map_err(Failure::input)?;
        Ok(axes)
    }
}

/// Reads a file of axes and checks them.
fn read(path: &Path, ice: IceTable) -> Result<Axes, Failure> {
    let text = SettingsFile::read(path)?;
    let source = SettingsFile { path, text: &text };
    axes_file::parse(&text, ice).map_err(|AxesFileError { span, reason }| match span {
        Some(span) => source.failure(&span, reason),
        None => Failure::Input(format!("{}: {reason}", path.display())),
    })
}

fn replace(axis: &mut Vec<f64>, values: Option<Vec<f64>>) {
    if let Some(values) = values {
        *axis = values;
    }
}

/// Sets the axis of a further property, if it is given.
fn set_property(axes: &mut Axes, property: Property, values: Option<Vec<f64>>) {
    if let Some(values) = values {
        axes.set_property(PropertyAxis { property, values });
    }
}
