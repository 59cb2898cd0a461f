//! What the snow is made of.

use clap::Args;
use snowblue_figures::{Metadata, format_number};
use snowblue_transport::optics::{IceTable, Substance, Wavelengths};
use snowblue_transport::parameters::{DENSITY, GRAIN_SIZE, SURFACE_AREA};
use snowblue_transport::sample::{GrainSize, Property, SizeMeasure, SnowKeys, SnowSample, SnowType, TruncatedNormal};
use snowblue_transport::slab::Slab;

use super::parse;
use super::property::{PropertyAxis, PropertyValues};
use super::{SlabOptions, has_no_effect, limits};
use crate::output::Failure;

/// What the snow is made of.
#[derive(Debug, Args)]
#[command(next_help_heading = "Snow")]
pub(crate) struct SnowOptions {
    /// Kind of snow of the International Classification: fresh, rounded, faceted, wind-packed, melt-forms, firn; sets
    /// specific surface area and density, of which options may replace one
    #[arg(long, value_name = "KIND", value_parser = parse::snow_type)]
    snow: Option<SnowType>,
    #[command(flatten)]
    properties: PropertyValues<false>,
    #[arg(
        long, value_name = "UM", value_parser = parse::number,
        conflicts_with_all = ["grain_size", "ssa", "size_measure"],
        help = format!(
            "Optical radius in µm, that of spheres with the grains' surface per volume, instead of a grain size [{}]",
            limits::ends(&(0.5 * GRAIN_SIZE.range.least..=0.5 * GRAIN_SIZE.range.greatest))
        )
    )]
    optical_radius: Option<f64>,
    /// Diameter that the grain size means: greatest-extension (the longest distance across a grain), volume-diameter
    /// (of the sphere of equal volume) or optical-diameter (of equal volume per surface area)
    #[arg(
        long, value_name = "MEASURE", default_value = "greatest-extension", value_parser = parse::size_measure,
        conflicts_with = "ssa"
    )]
    size_measure: SizeMeasure,
    /// Table of the absorption of ice: warren2008 (Warren & Brandt 2008) or picard2016 (Picard, Libois & Arnaud 2016);
    /// the two differ in the blue
    #[arg(long, value_name = "TABLE", default_value = "warren2008", value_parser = parse::ice)]
    ice: IceTable,
}

/// Names of all options of the snow, as ids of clap.
pub(crate) fn snow_options() -> Vec<&'static str> {
    [PropertyValues::<false>::names(), vec!["snow", "optical_radius", "size_measure", "ice"]].concat()
}

impl SnowOptions {
    /// The snow.
    pub(crate) fn sample(&self) -> Result<SnowSample, Failure> {
        if let Some(axis) = self.axes().next() {
            return Err(Failure::Input(format!("--{} has several values, which only spectrum takes", axis.option())));
        }
        self.keys()?.sample().map_err(|wrong| Failure::input(wrong.error))
    }

    /// The given properties of the snow. Of several values of an option, the first value counts.
    pub(crate) fn keys(&self) -> Result<SnowKeys, Failure> {
        let properties = &self.properties;
        let measure = (self.size_measure != SizeMeasure::default()).then_some(self.size_measure);
        let has_size = properties.has(Property::GrainSize);
        if self.snow.is_some() && !has_size && measure.is_some() {
            return Err(Failure::Input("--size-measure with --snow needs --grain-size".to_owned()));
        }
        let sizes = [
            ("--grain-size", has_size),
            ("--ssa", properties.has(Property::SurfaceArea)),
            ("--optical-radius", self.optical_radius.is_some()),
        ];
        if let (Some(_), true, Some((size, _))) =
            (self.snow, properties.has(Property::Density), sizes.iter().find(|(_, has)| *has))
        {
            return Err(has_no_effect("snow", &format!("{size} and --density replace all that a kind of snow sets")));
        }
        let mut keys = SnowKeys { snow: self.snow, size_measure: measure, ice: Some(self.ice), ..SnowKeys::default() };
        for PropertyAxis { property, values } in properties.iter() {
            keys.set(*property, &values[0]).map_err(Failure::input)?;
        }
        if let Some(radius_um) = self.optical_radius {
            set_optical_radius(&mut keys, radius_um);
        }
        Ok(keys)
    }

    /// The options with several values. Every combination of these values is a snow.
    pub(crate) fn axes(&self) -> impl Iterator<Item = &PropertyAxis> {
        self.properties.iter().filter(|axis| axis.values.len() > 1)
    }

    /// A slab of this snow, checked.
    pub(crate) fn slab(&self, slab: &SlabOptions, wavelengths: &Wavelengths) -> Result<Slab, Failure> {
        let slab = Slab {
            sample: self.sample()?,
            thicknesses_cm: slab.thickness.clone(),
            incidences: slab.angle.clone(),
            wavelengths_nm: wavelengths.0.clone(),
        };
        slab.check().map_err(Failure::input)?;
        Ok(slab)
    }

    /// Whether an option sets the grain size.
    pub(crate) fn sets_grain_size(&self) -> bool {
        let has_size = [Property::GrainSize, Property::SurfaceArea].iter().any(|size| self.properties.has(*size));
        has_size || self.optical_radius.is_some() || self.snow.is_some()
    }

    /// Whether an option sets the density.
    pub(crate) fn sets_density(&self) -> bool {
        self.properties.has(Property::Density) || self.snow.is_some()
    }

    /// Metadata: the snow, its identifier, its kind, ice constants, water and impurities.
    pub(crate) fn metadata(&self) -> Result<Metadata, Failure> {
        Ok(self.metadata_of(&self.sample()?))
    }

    /// Metadata of the samples of a batch: the properties without a column, or without a value for each sample in
    /// their column. Columns in `full` have a value for each sample.
    pub(crate) fn properties(&self, sample: &SnowSample, columns: &[&str], full: &[&str]) -> Metadata {
        let (has, is_full) = (|name: &&str| columns.contains(name), |name: &&str| full.contains(name));
        let GrainSize { min_um, max_um, measure } = sample.grain_size;
        let mut metadata = Metadata::new();
        metadata.extend(self.kind_metadata().filter(|_| !has(&"snow")));
        // Empty cells take the size and the density of the options.
        if !["snow", GRAIN_SIZE.key, SURFACE_AREA.key, "optical_radius_um"].iter().any(is_full) {
            metadata.push((GRAIN_SIZE.key, describe_range(min_um, max_um)));
        }
        // Surface areas, optical radii and kinds of snow have a measure of their own.
        if !["snow", "size_measure", SURFACE_AREA.key, "optical_radius_um"].iter().any(is_full) {
            let measure = if has(&GRAIN_SIZE.key) { self.size_measure } else { measure };
            metadata.push(("size_measure", describe_measure(measure).to_owned()));
        }
        if !["snow", DENSITY.key].iter().any(is_full) {
            metadata.push((DENSITY.key, format_number(sample.density_kg_m3)));
        }
        let others = Property::all().filter_map(|property| {
            let value = match property {
                Property::GrainSize | Property::SurfaceArea | Property::Density | Property::Impurity(_) => return None,
                Property::Facetness => describe_distribution(&sample.facetness),
                Property::Sphericity => describe_distribution(&sample.sphericity),
                _ => format_number(property.get(sample)),
            };
            Some((property.key(), value))
        });
        let others = others.chain([("ice", self.ice.name().to_owned())]);
        metadata.extend(others.filter(|(name, _)| !full.contains(name)));
        let describe = |substance: Substance| {
            let amount = match sample.impurities.ng_g(substance) {
                _ if has(&substance.key()) => String::new(),
                ng_g if ng_g > 0.0 => format!("={} ng/g", format_number(ng_g)),
                _ => return None,
            };
            Some(format!("{substance}{amount} ({})", substance.source()))
        };
        let present: Vec<String> = Substance::known().filter_map(describe).collect();
        if !present.is_empty() {
            metadata.push(("impurities", present.join(", ")));
        }
        metadata
    }

    /// The kind of snow, if one is given.
    fn kind_metadata(&self) -> Option<(&'static str, String)> {
        self.snow.map(|kind| ("kind", format!("{kind} ({})", kind.source())))
    }

    /// Metadata of a sample that differs from the options in grain size or density.
    pub(crate) fn metadata_of(&self, sample: &SnowSample) -> Metadata {
        let mut metadata = vec![("snow", describe_sample(sample)), ("snow_id", sample.id())];
        metadata.extend(self.kind_metadata());
        metadata.push(("ice", self.ice.name().to_owned()));
        if sample.water_saturation > 0.0 {
            let source = "Daimon & Masumura 2007, Water Optical Properties Processor v3; from 1225 nm Rowe et al. 2020";
            metadata.push(("water", format!("saturation {} ({source})", format_number(sample.water_saturation))));
        }
        let describe = |(substance, ng_g): (Substance, f64)| {
            format!("{substance}={} ng/g ({})", format_number(ng_g), substance.source())
        };
        let present: Vec<String> = sample.impurities.present().map(describe).collect();
        if !present.is_empty() {
            metadata.push(("impurities", present.join(", ")));
        }
        metadata
    }
}

/// Sets grains of one optical radius, in µm.
pub(crate) fn set_optical_radius(keys: &mut SnowKeys, radius_um: f64) {
    keys.grain_size_um = Some(vec![2.0 * radius_um; 2]);
    keys.size_measure = Some(SizeMeasure::OpticalDiameter);
}

/// Grains, density and temperature in one line.
fn describe_sample(sample: &SnowSample) -> String {
    let GrainSize { min_um, max_um, measure } = sample.grain_size;
    format!(
        "{} {} µm, sphericity {}, facetness {}, {} kg/m³, {} °C",
        describe_measure(measure),
        describe_range(min_um, max_um),
        describe_distribution(&sample.sphericity),
        describe_distribution(&sample.facetness),
        format_number(sample.density_kg_m3),
        format_number(sample.temperature_c),
    )
}

/// The name of a measure of grain size.
fn describe_measure(measure: SizeMeasure) -> &'static str {
    match measure {
        SizeMeasure::GreatestExtension => "greatest extension",
        SizeMeasure::VolumeDiameter => "volume diameter",
        SizeMeasure::OpticalDiameter => "optical diameter",
    }
}

/// Both ends of a range, or one value if they are equal.
fn describe_range(low: f64, high: f64) -> String {
    if low < high { format!("{}–{}", format_number(low), format_number(high)) } else { format_number(low) }
}

/// Range, mean and standard deviation, or the single value.
fn describe_distribution(distribution: &TruncatedNormal) -> String {
    let range = describe_range(distribution.min, distribution.max);
    if distribution.min >= distribution.max {
        return range;
    }
    let (mean, deviation) = (format_number(distribution.mean), format_number(distribution.standard_deviation));
    format!("{range} about {mean} ± {deviation}")
}
