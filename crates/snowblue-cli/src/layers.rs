//! Layers of snow on a ground: the options that ask for them, the file that describes them, and fluxes at depths.
//!
//! ```toml
//! ice = "warren2008"          # or "picard2016"; for all layers
//! [[layer]]                   # top first
//! thickness_cm = 3            # the only key that must be there
//! grain_size_um = 200         # a mean, or [MIN, MAX]; with size_measure = "greatest-extension" | "volume-diameter" | …
//! # ssa_m2_kg = 40            # instead of a grain size
//! facetness = 0.3             # a mean, or [MIN, MAX, MEAN, SD]
//! sphericity = 0.8            # one value, or [MIN, MAX, MEAN, SD]
//! density_kg_m3 = 120
//! # snow = "fresh"            # a kind of snow, for its size and density where they are not given
//! water_saturation = 0
//! impurities_ng_g = { black-carbon = 10, saharan-dust = 500 }
//! temperature_c = -5
//! ```
//!
//! Keys that are left out have the values of the command's defaults.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Deserialize;
use snowblue_transport::optics::Substance;
use snowblue_transport::sample::SnowType;
use snowblue_transport::sample::{GrainSize, SnowSample, TruncatedNormal};
use snowblue_transport::slab::Slab;
use snowblue_transport::stack::{Layer, Stack, StackRadiometry};
use toml::Spanned;

use crate::failure::Failure;
use crate::options::{IceWord, SizeMeasureWord, incidence_name};
use crate::parse;
use crate::report::Cell;
use crate::source::Source;

/// What lies under the top of the snow.
#[derive(Debug, Args)]
#[command(next_help_heading = "Layers")]
pub(crate) struct StackOptions {
    /// Layers of different snow, top first, from a TOML file instead of the options for one snow. Each `[[layer]]` has
    /// thickness_cm and, where it is not as usual: snow, grain_size_um, size_measure, ssa_m2_kg, facetness, sphericity,
    /// density_kg_m3, water_saturation, impurities_ng_g = { black-carbon = 10 }, temperature_c; the file may have ice
    #[arg(long, value_name = "FILE", conflicts_with_all = [
        "snow", "grain_size", "ssa", "size_measure", "facetness", "sphericity", "density", "water_saturation", "impurity",
        "temperature", "ice", "thickness",
    ])]
    layers: Option<PathBuf>,
    /// Albedo of the ground under the snow [0–1; default: 0, as in the free air]
    #[arg(long, value_name = "ALBEDO", value_parser = parse::number)]
    ground_albedo: Option<f64>,
    /// Depths in cm at which to print the fluxes down and up, by commas, instead of those of the whole
    #[arg(long, value_name = "CM", value_delimiter = ',', value_parser = parse::number)]
    depths: Vec<f64>,
}

/// Layers out of a file, and what their answer rests on, for metadata.
pub(crate) struct Pack {
    layers: Vec<Layer>,
    pub(crate) made_of: Provenance,
}

/// Names and words for metadata.
pub(crate) type Provenance = Vec<(&'static str, String)>;

/// Columns of fluxes at depths.
pub(crate) const PROFILE_COLUMNS: [&str; 8] =
    ["thickness_cm", "depth_cm", "angle_deg", "wavelength_nm", "down", "up", "net", "e_folding_depth_cm"];

impl StackOptions {
    /// Whether anything but free slabs is asked for.
    pub(crate) fn asked(&self) -> bool {
        self.layers.is_some() || self.ground_albedo.is_some() || self.with_depths()
    }

    /// Whether fluxes at depths are asked for.
    pub(crate) fn with_depths(&self) -> bool {
        !self.depths.is_empty()
    }

    /// The layers of the file, if there is one.
    pub(crate) fn pack(&self) -> Result<Option<Pack>, Failure> {
        let Some(path) = &self.layers else { return Ok(None) };
        let (layers, ice) = read(path)?;
        let mut made_of = vec![("ice", ice.name().to_owned()), ("layers", path.display().to_string())];
        let held = |one: &Substance| layers.iter().any(|l| l.sample.impurities.present().any(|(s, _)| s == *one));
        let held: Vec<&str> = Substance::ALL.iter().filter(|one| held(one)).map(|one| one.source()).collect();
        if !held.is_empty() {
            made_of.push(("impurities", held.join(", ")));
        }
        Ok(Some(Pack { layers, made_of }))
    }

    /// The layers of a pack, or one of each thickness of `slab`.
    pub(crate) fn stacks(&self, slab: &Slab, pack: Option<&Pack>) -> Result<Vec<Stack>, Failure> {
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
    /// The wavelengths, in nm, that the tables of all layers reach.
    pub(crate) fn reach_nm(&self) -> Option<(f64, f64)> {
        let reaches = self.layers.iter().map(|layer| layer.sample.range_nm());
        reaches.reduce(|a, b| (a.0.max(b.0), a.1.min(b.1)))
    }
}

/// Rows of fluxes at the depths of an answer.
pub(crate) fn profile_rows(answer: &StackRadiometry) -> impl Iterator<Item = Vec<Cell>> {
    answer.profile.iter().map(|at| {
        let whole = &answer.whole;
        let mut row: Vec<Cell> = vec![whole.thickness_cm.into(), at.depth_cm.into()];
        row.extend([Cell::Word(incidence_name(whole.incidence)), whole.wavelength_nm.into()]);
        row.extend([at.down, at.up, at.net, at.e_folding_depth_cm].map(|estimate| Cell::from(estimate.value)));
        row
    })
}

/// A file of layers as it is written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LayerFile {
    ice: Option<IceWord>,
    #[serde(default)]
    layer: Vec<Spanned<LayerWords>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LayerWords {
    thickness_cm: Spanned<f64>,
    grain_size_um: Option<Spanned<Numbers>>,
    size_measure: Option<Spanned<SizeMeasureWord>>,
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

impl Numbers {
    fn as_slice(&self) -> &[f64] {
        match self {
            Self::One(number) => std::slice::from_ref(number),
            Self::Several(numbers) => numbers,
        }
    }
}

/// Reads layers, each checked, and whose ice constants they have.
fn read(path: &Path) -> Result<(Vec<Layer>, IceWord), Failure> {
    let name = path.display();
    let text = Source::read(path)?;
    let source = Source { path, text: &text };
    let file: LayerFile = source.parse()?;
    if file.layer.is_empty() {
        return Err(Failure::Input(format!("{name}: holds no [[layer]]")));
    }
    let ice = file.ice.unwrap_or(IceWord::Warren2008);
    let layers: Result<_, _> = file.layer.iter().map(|words| read_layer(source, words.get_ref(), ice)).collect();
    Ok((layers?, ice))
}

/// Builds a layer key by key and checks it after each, so that the one at fault is known.
fn read_layer(source: Source, words: &LayerWords, ice: IceWord) -> Result<Layer, Failure> {
    let sample = SnowSample { ice: ice.table(), ..SnowSample::default() };
    let mut layer = Layer { sample, thickness_cm: *words.thickness_cm.get_ref() };
    let checked = |layer: &Layer, place: &Range<usize>| layer.check().map_err(|error| source.failure(place, error));
    checked(&layer, &words.thickness_cm.span())?;
    if let Some(name) = &words.snow {
        let of_kind = kind_of(source, name)?.sample().map_err(|error| source.failure(&name.span(), error))?;
        layer.sample = SnowSample { ice: sample.ice, ..of_kind };
    }
    if let Some(water_saturation) = &words.water_saturation {
        layer.sample.water_saturation = *water_saturation.get_ref();
        checked(&layer, &water_saturation.span())?;
    }
    for (name, mass_fraction_ng_g) in &words.impurities_ng_g {
        let substance = name.get_ref().parse().map_err(|error| source.failure(&name.span(), error))?;
        layer.sample.impurities = layer.sample.impurities.with(substance, *mass_fraction_ng_g.get_ref());
        checked(&layer, &mass_fraction_ng_g.span())?;
    }
    if let Some(density_kg_m3) = &words.density_kg_m3 {
        layer.sample.density_kg_m3 = *density_kg_m3.get_ref();
        checked(&layer, &density_kg_m3.span())?;
    }
    if let Some(temperature_c) = &words.temperature_c {
        layer.sample.temperature_c = *temperature_c.get_ref();
        checked(&layer, &temperature_c.span())?;
    }
    if let Some(facetness) = &words.facetness {
        layer.sample.facetness = read_law(source, facetness, parse::facetness_of)?;
        checked(&layer, &facetness.span())?;
    }
    if let Some(sphericity) = &words.sphericity {
        layer.sample.sphericity = read_law(source, sphericity, parse::sphericity_of)?;
        checked(&layer, &sphericity.span())?;
    }
    if let Some((size, place)) = read_size(source, words, layer.sample.temperature_c)? {
        layer.sample.grain_size = size;
        checked(&layer, &place)?;
    }
    Ok(layer)
}

fn kind_of(source: Source, name: &Spanned<String>) -> Result<SnowType, Failure> {
    parse::snow_type(name.get_ref()).map_err(|error| source.failure(&name.span(), error))
}

fn read_law(
    source: Source,
    numbers: &Spanned<Numbers>,
    law: fn(&[f64]) -> Result<TruncatedNormal, String>,
) -> Result<TruncatedNormal, Failure> {
    law(numbers.get_ref().as_slice()).map_err(|error| source.failure(&numbers.span(), error))
}

/// The grain size that a layer's keys stand for, with its place.
fn read_size(
    source: Source,
    words: &LayerWords,
    temperature_c: f64,
) -> Result<Option<(GrainSize, Range<usize>)>, Failure> {
    let measure = words.size_measure.as_ref();
    if let Some(area_m2_kg) = &words.ssa_m2_kg {
        let place = area_m2_kg.span();
        if words.grain_size_um.is_some() || measure.is_some() {
            return Err(source.failure(&place, "ssa_m2_kg stands instead of grain_size_um and size_measure"));
        }
        let size = GrainSize::from_specific_surface_area(*area_m2_kg.get_ref(), temperature_c);
        return size.map(|size| Some((size, place.clone()))).map_err(|error| source.failure(&place, error));
    }
    let Some(numbers) = &words.grain_size_um else {
        // A kind of snow stands for a surface area, whose diameter hangs on the density of ice.
        if let (Some(name), None) = (&words.snow, measure) {
            let area_m2_kg = kind_of(source, name)?.surface_area_m2_kg();
            let size = GrainSize::from_specific_surface_area(area_m2_kg, temperature_c);
            return size.map(|size| Some((size, name.span()))).map_err(|error| source.failure(&name.span(), error));
        }
        return match measure {
            None => Ok(None),
            Some(measure) => Err(source.failure(&measure.span(), "size_measure needs grain_size_um")),
        };
    };
    let place = numbers.span();
    let size = parse::size_of(numbers.get_ref().as_slice()).map_err(|error| source.failure(&place, error))?;
    let measure = measure.map_or(SizeMeasureWord::GreatestExtension, |measure| *measure.get_ref());
    size.measured_by(measure).map(|size| Some((size, place.clone()))).map_err(|error| source.failure(&place, error))
}
