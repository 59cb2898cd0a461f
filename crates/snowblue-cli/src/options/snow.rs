//! What the snow is made of.

use clap::Args;
use snowblue_figures::{Metadata, format_number};
use snowblue_transport::optics::{IceTable, Impurities, Substance, impurity, water};
use snowblue_transport::parameters::{
    DENSITY, FACETNESS, GRAIN_SIZE, MASS_FRACTION, SPHERICITY, SURFACE_AREA, TEMPERATURE, WATER_SATURATION,
};
use snowblue_transport::sample::{
    GrainSize, MEAN_SIZE_HALF_RANGE_UM, MEAN_SIZE_RANGE, SizeMeasure, SnowDescription, SnowSample, SnowType,
    TruncatedNormal,
};
use snowblue_transport::slab::Slab;

use super::parse::{self, GrainSizeArgument, ImpurityAxis, Wavelengths};
use super::{SlabOptions, has_no_effect, limits};
use crate::output::Failure;

/// The end of the help of options that may have several values.
const SEVERAL: &str = "; spectrum takes several, separated by commas";

/// What the snow is made of.
#[derive(Debug, Args)]
#[command(next_help_heading = "Snow")]
pub(crate) struct SnowOptions {
    /// Kind of snow of the International Classification: fresh, rounded, faceted, wind-packed, melt-forms, firn; sets
    /// specific surface area and density, of which options may replace one
    #[arg(long, value_name = "KIND", value_parser = parse::snow_type)]
    snow: Option<SnowType>,
    #[arg(
        long, value_name = "SIZE", value_parser = parse::grain_size, conflicts_with = "ssa",
        help = format!(
            "{}: a mean, for the range mean ± {MEAN_SIZE_HALF_RANGE_UM} [{}], or MIN:MAX, uniform in number \
             [{}; default: {}]",
            GRAIN_SIZE.describe(), limits::ends(&MEAN_SIZE_RANGE.inclusive()),
            limits::ends(&GRAIN_SIZE.range.inclusive()), GRAIN_SIZE.default
        )
    )]
    grain_size: Option<GrainSizeArgument>,
    #[arg(
        long, value_name = "AREA", value_delimiter = ',', value_parser = parse::number,
        help = format!("{}, instead of a grain size{SEVERAL}", limits::described(&SURFACE_AREA))
    )]
    ssa: Vec<f64>,
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
    #[arg(
        long, value_name = "FACETNESS", default_value = "0.3", value_parser = parse::facetness,
        help = format!("{}: a mean (± 0.1, SD 0.075) or MIN:MAX:MEAN:SD", limits::described(&FACETNESS))
    )]
    facetness: TruncatedNormal,
    #[arg(
        long, value_name = "SPHERICITY", default_value = "0.7:0.9:0.8:0.1", value_parser = parse::sphericity,
        help = format!("{}: one value or MIN:MAX:MEAN:SD", limits::described(&SPHERICITY))
    )]
    sphericity: TruncatedNormal,
    #[arg(
        long, value_name = "DENSITY", value_delimiter = ',', value_parser = parse::number,
        help = format!(
            "{} [{}; default: {}]{SEVERAL}", DENSITY.describe(), limits::ends(&DENSITY.range.inclusive()),
            DENSITY.default
        )
    )]
    density: Vec<f64>,
    #[arg(
        long, value_name = "FRACTION", default_value_t = WATER_SATURATION.default, value_parser = parse::number,
        help = format!(
            "{}; for {} nm", limits::described(&WATER_SATURATION), limits::wavelengths(water::WAVELENGTH_RANGE)
        )
    )]
    water_saturation: f64,
    #[arg(
        long, value_name = "NAME=NG_G", value_delimiter = ',', value_parser = parse::impurity_axis,
        help = format!(
            "{}, as black-carbon=10; several separated by commas or repeated: {}; for {} nm. spectrum also takes \
             several values of one, black-carbon=0:10:100",
            limits::described(&MASS_FRACTION), Substance::ALL.map(Substance::name).join(", "),
            limits::wavelengths(impurity::WAVELENGTH_RANGE)
        )
    )]
    impurity: Vec<ImpurityAxis>,
    #[arg(
        long, value_name = "T", default_value_t = TEMPERATURE.default, value_parser = parse::number,
        allow_negative_numbers = true,
        help = format!("{}; changes the density of ice only", limits::described(&TEMPERATURE))
    )]
    temperature: f64,
    /// Table of the absorption of ice: warren2008 (Warren & Brandt 2008) or picard2016 (Picard, Libois & Arnaud 2016);
    /// the two differ in the blue
    #[arg(long, value_name = "TABLE", default_value = "warren2008", value_parser = parse::ice)]
    ice: IceTable,
}

impl SnowOptions {
    /// The snow. Only its grain size is checked.
    pub(crate) fn sample(&self) -> Result<SnowSample, Failure> {
        let several =
            |option: &str| Failure::Input(format!("--{option} has several values, which only spectrum takes"));
        for (option, count) in [("ssa", self.ssa.len()), ("density", self.density.len())] {
            if count > 1 {
                return Err(several(option));
            }
        }
        if self.impurity.iter().any(|axis| axis.ng_g.len() > 1) {
            return Err(several("impurity"));
        }
        self.description()?.sample().map_err(Failure::input)
    }

    /// What is known of the snow; of several values the first.
    pub(crate) fn description(&self) -> Result<SnowDescription, Failure> {
        let (ssa, density) = (self.ssa.first().copied(), self.density.first().copied());
        let measure = (self.size_measure != SizeMeasure::default()).then_some(self.size_measure);
        if self.snow.is_some() && self.grain_size.is_none() && measure.is_some() {
            return Err(Failure::Input("--size-measure with --snow needs --grain-size".to_owned()));
        }
        let size = self.grain_size.map(|_| "--grain-size").or(ssa.map(|_| "--ssa"));
        let size = size.or(self.optical_radius.map(|_| "--optical-radius"));
        if let (Some(_), Some(_), Some(size)) = (self.snow, density, size) {
            return Err(has_no_effect("snow", &format!("{size} and --density replace all that a kind of snow sets")));
        }
        let mut impurities = Impurities::none();
        for (number, ImpurityAxis { substance, ng_g }) in self.impurity.iter().enumerate() {
            if self.impurity[..number].iter().any(|other| other.substance == *substance) {
                return Err(Failure::Input(format!("impurity {substance} is given twice")));
            }
            impurities = impurities.with(*substance, ng_g[0]);
        }
        let optical_diameter = self.optical_radius.map(|radius_um| vec![2.0 * radius_um; 2]);
        Ok(SnowDescription {
            snow_type: self.snow,
            size_measure: measure.or(optical_diameter.as_ref().map(|_| SizeMeasure::OpticalDiameter)),
            grain_size_um: optical_diameter.or(self.grain_size.map(GrainSizeArgument::numbers_um)),
            surface_area_m2_kg: ssa,
            sphericity: Some(self.sphericity),
            facetness: Some(self.facetness),
            density_kg_m3: density,
            water_saturation: Some(self.water_saturation),
            impurities,
            temperature_c: Some(self.temperature),
            ice: Some(self.ice),
        })
    }

    /// The options with several values, whose combinations are meant.
    pub(crate) fn axes(&self) -> Vec<SnowAxis> {
        let mut axes = vec![
            SnowAxis { property: SnowProperty::SurfaceArea, values: self.ssa.clone() },
            SnowAxis { property: SnowProperty::Density, values: self.density.clone() },
        ];
        let axis = |ImpurityAxis { substance, ng_g }: &ImpurityAxis| SnowAxis {
            property: SnowProperty::Impurity(*substance),
            values: ng_g.clone(),
        };
        axes.extend(self.impurity.iter().map(axis));
        axes.retain(|axis| axis.values.len() > 1);
        axes
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
        self.grain_size.is_some() || !self.ssa.is_empty() || self.optical_radius.is_some() || self.snow.is_some()
    }

    /// Whether an option sets the density.
    pub(crate) fn sets_density(&self) -> bool {
        !self.density.is_empty() || self.snow.is_some()
    }

    /// Metadata: the snow, its identifier, its kind, ice constants, water and impurities.
    pub(crate) fn metadata(&self) -> Result<Metadata, Failure> {
        Ok(self.metadata_of(&self.sample()?))
    }

    /// Metadata of the samples of a batch: what none of the columns says, or not of each sample; `full` columns do.
    pub(crate) fn properties(&self, sample: &SnowSample, columns: &[&str], full: &[&str]) -> Metadata {
        let has = |name: &&str| columns.contains(name);
        let SnowSample { grain_size, sphericity, facetness, density_kg_m3, water_saturation, impurities, .. } = sample;
        let GrainSize { min_um, max_um, measure } = grain_size;
        let mut metadata = Metadata::new();
        metadata.extend(self.kind_metadata().filter(|_| !has(&"snow")));
        if !["snow", GRAIN_SIZE.key, SURFACE_AREA.key, "optical_radius_um"].iter().any(has) {
            metadata.push((GRAIN_SIZE.key, describe_range(*min_um, *max_um)));
        }
        // Surface areas, optical radii and kinds of snow have a measure of their own.
        if !["snow", "size_measure", SURFACE_AREA.key, "optical_radius_um"].iter().any(has) {
            let measure = if has(&GRAIN_SIZE.key) { self.size_measure } else { *measure };
            metadata.push(("size_measure", describe_measure(measure).to_owned()));
        }
        if !["snow", DENSITY.key].iter().any(has) {
            metadata.push((DENSITY.key, format_number(*density_kg_m3)));
        }
        let others = [
            (FACETNESS.key, describe_distribution(facetness)),
            (SPHERICITY.key, describe_distribution(sphericity)),
            (WATER_SATURATION.key, format_number(*water_saturation)),
            (TEMPERATURE.key, format_number(sample.temperature_c)),
            ("ice", self.ice.name().to_owned()),
        ];
        metadata.extend(others.into_iter().filter(|(name, _)| !full.contains(name)));
        let describe = |substance: Substance| {
            let amount = match impurities.ng_g(substance) {
                _ if has(&SnowProperty::Impurity(substance).column()) => String::new(),
                ng_g if ng_g > 0.0 => format!("={} ng/g", format_number(ng_g)),
                _ => return None,
            };
            Some(format!("{substance}{amount} ({})", substance.source()))
        };
        let present: Vec<String> = Substance::ALL.into_iter().filter_map(describe).collect();
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
        if self.water_saturation > 0.0 {
            let source = "Daimon & Masumura 2007, Water Optical Properties Processor v3";
            metadata.push(("water", format!("saturation {} ({source})", format_number(self.water_saturation))));
        }
        let describe = |ImpurityAxis { substance, ng_g }: &ImpurityAxis| {
            let values: Vec<String> = ng_g.iter().map(|value| format_number(*value)).collect();
            format!("{substance}={} ng/g ({})", values.join(":"), substance.source())
        };
        let is_present = |axis: &&ImpurityAxis| axis.ng_g.iter().any(|value| *value > 0.0);
        let present: Vec<String> = self.impurity.iter().filter(is_present).map(describe).collect();
        if !present.is_empty() {
            metadata.push(("impurities", present.join(", ")));
        }
        metadata
    }
}

/// An option with several values.
#[derive(Debug, Clone)]
pub(crate) struct SnowAxis {
    pub(crate) property: SnowProperty,
    pub(crate) values: Vec<f64>,
}

/// A property of snow that may have several values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SnowProperty {
    SurfaceArea,
    Density,
    Impurity(Substance),
}

impl SnowProperty {
    /// The name of its column.
    pub(crate) fn column(self) -> &'static str {
        match self {
            Self::SurfaceArea => SURFACE_AREA.key,
            Self::Density => DENSITY.key,
            Self::Impurity(Substance::BlackCarbon) => "black_carbon_ng_g",
            Self::Impurity(Substance::BrownCarbon) => "brown_carbon_ng_g",
            Self::Impurity(Substance::SaharanDust) => "saharan_dust_ng_g",
            Self::Impurity(Substance::ColoradoDust) => "colorado_dust_ng_g",
            Self::Impurity(Substance::SnowAlgae) => "snow_algae_ng_g",
        }
    }

    /// Sets its value.
    pub(crate) fn set(self, snow: &mut SnowDescription, value: f64) {
        match self {
            Self::SurfaceArea => snow.surface_area_m2_kg = Some(value),
            Self::Density => snow.density_kg_m3 = Some(value),
            Self::Impurity(substance) => snow.impurities = snow.impurities.with(substance, value),
        }
    }
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
