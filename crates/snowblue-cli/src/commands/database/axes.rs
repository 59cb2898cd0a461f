//! Axes of a table: a preset, changed by a file and by options.
//!
//! ```toml
//! preset = "paper"                    # or "default", "fine", "infrared"; the values of keys that are not given
//! grain_size_um = [100, 200, 400]     # means, each for the range mean ± 50 µm
//! facetness = [0.1, 0.3, 0.5]
//! density_kg_m3 = [300]
//! thickness_cm = [1, 5, 15, 50]
//! angle_deg = [0, 60, "diffuse"]
//! wavelength_nm = "400:700:10"        # or a list
//! water_saturation = [0, 0.1, 0.3]
//! temperature_c = [-5]
//! impurities_ng_g = { black-carbon = [0, 10, 100] }
//! ```

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde::Deserialize;
use snowblue_database::{Axes, Property, PropertyAxis};
use snowblue_transport::optics::IceTable;
use snowblue_transport::slab::Incidence;
use toml::Spanned;

use crate::input::SettingsFile;
use crate::options::parse::{self, ImpurityAxis, Wavelengths};
use crate::output::Failure;

/// Axes of a table
#[derive(Debug, Args)]
#[command(next_help_heading = "Axes")]
pub(super) struct AxesOptions {
    /// Axes that further options change
    #[arg(long, value_name = "PRESET", value_enum, default_value = "paper")]
    preset: Preset,
    /// TOML file of axes with the keys preset, grain_size_um, facetness, density_kg_m3, thickness_cm, angle_deg,
    /// wavelength_nm, water_saturation, temperature_c, impurities_ng_g
    #[arg(long, value_name = "FILE", conflicts_with = "preset")]
    axes: Option<PathBuf>,
    /// Mean grain sizes in µm, each for the range mean ± 50 [70–4950]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = parse::number)]
    grain_size: Vec<f64>,
    /// Mean facetness [0–1]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = parse::number)]
    facetness: Vec<f64>,
    /// Densities in kg/m³ [10–900]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = parse::number)]
    density: Vec<f64>,
    /// Thicknesses in cm, two or more [0–100000]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = parse::number)]
    thickness: Vec<f64>,
    /// Angles of incidence in degrees [0–89.99], or 'diffuse'
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = parse::incidence)]
    angle: Vec<Incidence>,
    /// Wavelengths in nm: FIRST:LAST:STEP or a list [300–2500]
    #[arg(long, value_name = "NM", value_parser = parse::wavelengths)]
    wavelengths: Option<Wavelengths>,
    /// Fractions of the pore volume filled with water [0–1]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = parse::number)]
    water_saturation: Vec<f64>,
    /// Temperatures in °C [-60–0]
    #[arg(
        long, value_name = "LIST", value_delimiter = ',', value_parser = parse::number, allow_negative_numbers = true
    )]
    temperature: Vec<f64>,
    /// Mass fractions of an impurity in ng/g, as black-carbon=0:10:100; repeatable
    #[arg(long, value_name = "NAME=LIST", value_parser = parse::impurity_axis)]
    impurity: Vec<ImpurityAxis>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Preset {
    /// Table 1 of the paper: 24,750 curves
    Paper,
    /// The embedded table: the paper's with more thicknesses and angles
    Default,
    /// The default every 5 nm
    Fine,
    /// 300–2500 nm every 20 nm, one density, also diffuse light
    Infrared,
}

impl Preset {
    fn axes(self) -> Axes {
        match self {
            Self::Paper => Axes::paper(),
            Self::Default => Axes::with_thin_and_thick_knots(),
            Self::Fine => Axes::fine(),
            Self::Infrared => Axes::infrared(),
        }
    }
}

/// A file of axes.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct AxesFile {
    preset: Option<Preset>,
    grain_size_um: Option<Vec<f64>>,
    facetness: Option<Vec<f64>>,
    density_kg_m3: Option<Vec<f64>>,
    thickness_cm: Option<Vec<f64>>,
    angle_deg: Option<Vec<Spanned<Angle>>>,
    wavelength_nm: Option<Spanned<WavelengthList>>,
    water_saturation: Option<Vec<f64>>,
    temperature_c: Option<Vec<f64>>,
    #[serde(default)]
    impurities_ng_g: BTreeMap<Spanned<String>, Vec<f64>>,
}

#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "must be an angle in degrees or \"diffuse\"")]
enum Angle {
    Degrees(f64),
    Word(String),
}

#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "must be a list of wavelengths or a range FIRST:LAST:STEP")]
enum WavelengthList {
    List(Vec<f64>),
    Range(String),
}

impl AxesOptions {
    /// The axes, checked with a table of ice.
    pub(super) fn axes(&self, ice: IceTable) -> Result<Axes, Failure> {
        let mut axes = match &self.axes {
            None => self.preset.axes(),
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
    let file: AxesFile = source.parse()?;
    let mut axes = file.preset.unwrap_or(Preset::Paper).axes();
    replace(&mut axes.grain_sizes_um, file.grain_size_um);
    replace(&mut axes.facetness, file.facetness);
    replace(&mut axes.densities_kg_m3, file.density_kg_m3);
    replace(&mut axes.thicknesses_cm, file.thickness_cm);
    let mut incidences = Vec::new();
    for word in file.angle_deg.iter().flatten() {
        incidences.push(match word.get_ref() {
            Angle::Degrees(angle_deg) => Incidence::Beam { angle_deg: *angle_deg },
            Angle::Word(name) => parse::incidence(name).map_err(|error| source.failure(&word.span(), error))?,
        });
    }
    if !incidences.is_empty() {
        axes.set_incidences(&incidences);
    }
    if let Some(words) = file.wavelength_nm {
        let span = words.span();
        axes.wavelengths_nm = match words.into_inner() {
            WavelengthList::List(list) => list,
            WavelengthList::Range(range) => parse::wavelengths(&range).map_err(|error| source.failure(&span, error))?.0,
        };
    }
    set_property(&mut axes, Property::WaterSaturation, file.water_saturation);
    set_property(&mut axes, Property::Temperature, file.temperature_c);
    for (name, values) in file.impurities_ng_g {
        let substance = name.get_ref().parse().map_err(|error| source.failure(&name.span(), error))?;
        set_property(&mut axes, Property::Impurity(substance), Some(values));
    }
    axes.check(ice).map_err(|error| Failure::Input(format!("{}: {error}", path.display())))?;
    Ok(axes)
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
