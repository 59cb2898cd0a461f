//! Layers of snow on a ground: options, the file of layers, and fluxes at depths.
//!
//! ```toml
//! ice = "warren2008"          # or "picard2016"; for all layers
//! [[layer]]                   # top first
//! thickness_cm = 3            # the only required key
//! grain_size_um = 200         # a mean, or [MIN, MAX]
//! size_measure = "greatest-extension"   # or "volume-diameter", "optical-diameter"
//! # ssa_m2_kg = 40            # instead of a grain size
//! facetness = 0.3             # a mean, or [MIN, MAX, MEAN, SD]
//! sphericity = 0.8            # one value, or [MIN, MAX, MEAN, SD]
//! density_kg_m3 = 120
//! # snow = "fresh"            # a kind of snow, for grain size and density where they are not given
//! water_saturation = 0
//! impurities_ng_g = { black-carbon = 10, saharan-dust = 500 }
//! temperature_c = -5
//! ```
//!
//! Missing keys have the defaults of the options.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Deserialize;
use snowblue_figures::{Cell, Metadata};
use snowblue_transport::TransportError;
use snowblue_transport::optics::{IceTable, Substance};
use snowblue_transport::range::WavelengthRange;
use snowblue_transport::sample::{SnowDescription, TruncatedNormal};
use snowblue_transport::slab::Slab;
use snowblue_transport::stack::{Layer, Stack, StackRadiometry};
use toml::Spanned;

use crate::input::SettingsFile;
use crate::options::parse;
use crate::output::Failure;

/// Layers, ground and depths.
#[derive(Debug, Args)]
#[command(next_help_heading = "Layers")]
pub(super) struct StackOptions {
    /// TOML file of layers, top first, instead of the options of one snow. Each `[[layer]]` has thickness_cm (cm) and
    /// optionally snow, grain_size_um, size_measure, ssa_m2_kg, facetness, sphericity, density_kg_m3, water_saturation,
    /// impurities_ng_g = { black-carbon = 10 }, temperature_c; the file may set ice
    #[arg(long, value_name = "FILE", conflicts_with_all = [
        "snow", "grain_size", "ssa", "size_measure", "facetness", "sphericity", "density", "water_saturation",
        "impurity", "temperature", "ice", "thickness",
    ])]
    layers: Option<PathBuf>,
    /// Albedo of the ground under the snow [0–1; default: 0, no ground]
    #[arg(long, value_name = "ALBEDO", value_parser = parse::number)]
    ground_albedo: Option<f64>,
    /// Print downward and upward fluxes at these depths in cm, separated by commas, instead of those of the whole slab
    #[arg(long, value_name = "CM", value_delimiter = ',', value_parser = parse::number)]
    depths: Vec<f64>,
}

/// Layers from a file, with their metadata.
pub(super) struct Pack {
    layers: Vec<Layer>,
    pub(super) metadata: Metadata,
}

/// Columns of fluxes at depths.
pub(super) const PROFILE_COLUMNS: [&str; 8] =
    ["thickness_cm", "depth_cm", "angle_deg", "wavelength_nm", "down", "up", "net", "e_folding_depth_cm"];

impl StackOptions {
    /// Whether any of these options is given.
    pub(super) fn is_used(&self) -> bool {
        self.layers.is_some() || self.ground_albedo.is_some() || self.has_depths()
    }

    /// Whether fluxes at depths are to be printed.
    pub(super) fn has_depths(&self) -> bool {
        !self.depths.is_empty()
    }

    /// The layers of the file, if there is one.
    pub(super) fn pack(&self) -> Result<Option<Pack>, Failure> {
        let Some(path) = &self.layers else { return Ok(None) };
        let Layers { layers, ice } = read(path)?;
        let mut metadata = vec![("ice", ice.name().to_owned()), ("layers", path.display().to_string())];
        let is_present = |one: &Substance| layers.iter().any(|l| l.sample.impurities.present().any(|(s, _)| s == *one));
        let sources: Vec<&str> = Substance::ALL.iter().filter(|one| is_present(one)).map(|one| one.source()).collect();
        if !sources.is_empty() {
            metadata.push(("impurities", sources.join(", ")));
        }
        Ok(Some(Pack { layers, metadata }))
    }

    /// One stack of the layers of a pack, or a stack of one layer for each thickness of `slab`.
    pub(super) fn stacks(&self, slab: &Slab, pack: Option<&Pack>) -> Result<Vec<Stack>, Failure> {
        let stack = |layers: Vec<Layer>| Stack {
            layers,
            ground_albedo: self.ground_albedo.unwrap_or(0.0),
            depths_cm: self.depths.clone(),
            incidences: slab.incidences.clone(),
            wavelengths_nm: slab.wavelengths_nm.clone(),
        };
        let one = |thickness_cm: &f64| stack(vec![Layer { sample: slab.sample, thickness_cm: *thickness_cm }]);
        let stacks: Vec<Stack> = match pack {
            Some(pack) => vec![stack(pack.layers.clone())],
            None => slab.thicknesses_cm.iter().map(one).collect(),
        };
        stacks.iter().try_for_each(Stack::check).map_err(Failure::input)?;
        Ok(stacks)
    }
}

impl Pack {
    /// The range of wavelengths that the tables of all layers cover, in nm.
    pub(super) fn wavelength_range(&self) -> Option<WavelengthRange> {
        self.layers.iter().map(|layer| layer.sample.wavelength_range()).reduce(WavelengthRange::intersection)
    }
}

/// A row for each depth of a solved stack.
pub(super) fn profile_rows(answer: &StackRadiometry) -> impl Iterator<Item = Vec<Cell>> {
    answer.profile.iter().map(|at| {
        let whole = &answer.whole;
        let mut row: Vec<Cell> = vec![whole.thickness_cm.into(), at.depth_cm.into()];
        row.extend([Cell::word(whole.incidence.to_string()), whole.wavelength_nm.into()]);
        row.extend([at.down, at.up, at.net, at.e_folding_depth_cm].map(|estimate| Cell::from(estimate.value)));
        row
    })
}

/// The file of layers.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LayerFile {
    ice: Option<Spanned<String>>,
    #[serde(default)]
    layer: Vec<Spanned<LayerTable>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LayerTable {
    thickness_cm: Spanned<f64>,
    grain_size_um: Option<Spanned<Numbers>>,
    size_measure: Option<Spanned<String>>,
    ssa_m2_kg: Option<Spanned<f64>>,
    facetness: Option<Spanned<Numbers>>,
    sphericity: Option<Spanned<Numbers>>,
    density_kg_m3: Option<Spanned<f64>>,
    snow: Option<Spanned<String>>,
    water_saturation: Option<Spanned<f64>>,
    #[serde(default)]
    impurities_ng_g: BTreeMap<Spanned<String>, Spanned<f64>>,
    temperature_c: Option<Spanned<f64>>,
}

#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "must be a number or a list of numbers")]
enum Numbers {
    One(f64),
    Several(Vec<f64>),
}

/// Layers of a file, and the table of ice that all of them use.
struct Layers {
    layers: Vec<Layer>,
    ice: IceTable,
}

impl Numbers {
    fn as_slice(&self) -> &[f64] {
        match self {
            Self::One(number) => std::slice::from_ref(number),
            Self::Several(numbers) => numbers,
        }
    }
}

/// Reads and checks the layers of a file.
fn read(path: &Path) -> Result<Layers, Failure> {
    let name = path.display();
    let text = SettingsFile::read(path)?;
    let source = SettingsFile { path, text: &text };
    let file: LayerFile = source.parse()?;
    if file.layer.is_empty() {
        return Err(Failure::Input(format!("{name}: holds no [[layer]]")));
    }
    let ice = file.ice.as_ref().map(|ice| parsed(source, ice, |name| name.parse())).transpose()?.unwrap_or_default();
    let layers: Result<_, _> = file.layer.iter().map(|table| read_layer(source, table.get_ref(), ice)).collect();
    Ok(Layers { layers: layers?, ice })
}

/// Builds a layer key by key, and checks it after each key to report the line of an error.
fn read_layer(source: SettingsFile, table: &LayerTable, ice: IceTable) -> Result<Layer, Failure> {
    let mut snow = SnowDescription { ice: Some(ice), ..SnowDescription::default() };
    let check = |snow: &SnowDescription, span: Range<usize>| {
        let layer = snow.sample().map(|sample| Layer { sample, thickness_cm: *table.thickness_cm.get_ref() });
        layer.and_then(|layer| layer.check().map(|()| layer)).map_err(|error| source.failure(&span, error))
    };
    let mut layer = check(&snow, table.thickness_cm.span())?;
    if let Some(kind) = &table.snow {
        snow.snow_type = Some(parsed(source, kind, |name| name.parse())?);
        layer = check(&snow, kind.span())?;
    }
    if let Some(water_saturation) = &table.water_saturation {
        snow.water_saturation = Some(*water_saturation.get_ref());
        layer = check(&snow, water_saturation.span())?;
    }
    for (name, mass_fraction_ng_g) in &table.impurities_ng_g {
        let substance = parsed(source, name, |name| name.parse())?;
        snow.impurities = snow.impurities.with(substance, *mass_fraction_ng_g.get_ref());
        layer = check(&snow, mass_fraction_ng_g.span())?;
    }
    if let Some(density_kg_m3) = &table.density_kg_m3 {
        snow.density_kg_m3 = Some(*density_kg_m3.get_ref());
        layer = check(&snow, density_kg_m3.span())?;
    }
    if let Some(temperature_c) = &table.temperature_c {
        snow.temperature_c = Some(*temperature_c.get_ref());
        layer = check(&snow, temperature_c.span())?;
    }
    if let Some(facetness) = &table.facetness {
        snow.facetness = Some(parsed(source, facetness, |numbers| TruncatedNormal::facetness(numbers.as_slice()))?);
        layer = check(&snow, facetness.span())?;
    }
    if let Some(sphericity) = &table.sphericity {
        snow.sphericity = Some(parsed(source, sphericity, |numbers| TruncatedNormal::sphericity(numbers.as_slice()))?);
        layer = check(&snow, sphericity.span())?;
    }
    if let Some(grain_size_um) = &table.grain_size_um {
        snow.grain_size_um = Some(grain_size_um.get_ref().as_slice().to_vec());
        layer = check(&snow, grain_size_um.span())?;
    }
    if let Some(measure) = &table.size_measure {
        snow.size_measure = Some(parsed(source, measure, |name| name.parse())?);
        layer = check(&snow, measure.span())?;
    }
    if let Some(area_m2_kg) = &table.ssa_m2_kg {
        snow.surface_area_m2_kg = Some(*area_m2_kg.get_ref());
        layer = check(&snow, area_m2_kg.span())?;
    }
    Ok(layer)
}

/// The value of a key, or an error on its line.
fn parsed<K, V>(
    source: SettingsFile,
    key: &Spanned<K>,
    parse: impl Fn(&K) -> Result<V, TransportError>,
) -> Result<V, Failure> {
    parse(key.get_ref()).map_err(|error| source.failure(&key.span(), error))
}
