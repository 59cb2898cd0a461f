//! What the snow is made of.

use clap::Args;
use snowblue_figures::{Metadata, format_number};
use snowblue_transport::optics::{IceTable, Impurities, Substance, impurity, water};
use snowblue_transport::sample::{
    DENSITY, FACETNESS, GRAIN_SIZE, GrainSize, MASS_FRACTION, MEAN_SIZE_HALF_RANGE_UM, MEAN_SIZE_RANGE, SPHERICITY,
    SURFACE_AREA, SizeMeasure, SnowDescription, SnowSample, SnowType, TEMPERATURE, TruncatedNormal, WATER_SATURATION,
};
use snowblue_transport::slab::Slab;

use super::parse::{self, GrainSizeArgument, ImpurityAmount, Wavelengths};
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
        long, value_name = "AREA", value_parser = parse::number,
        help = format!("{}, instead of a grain size", limits::described(&SURFACE_AREA))
    )]
    ssa: Option<f64>,
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
        long, value_name = "DENSITY", value_parser = parse::number,
        help = format!(
            "{} [{}; default: {}]", DENSITY.describe(), limits::ends(&DENSITY.range.inclusive()), DENSITY.default
        )
    )]
    density: Option<f64>,
    #[arg(
        long, value_name = "FRACTION", default_value_t = WATER_SATURATION.default, value_parser = parse::number,
        help = format!(
            "{}; for {} nm", limits::described(&WATER_SATURATION), limits::wavelengths(water::WAVELENGTH_RANGE)
        )
    )]
    water_saturation: f64,
    #[arg(
        long, value_name = "NAME=NG_G", value_delimiter = ',', value_parser = parse::impurity,
        help = format!(
            "{}, as black-carbon=10; several separated by commas or repeated: {}; for {} nm",
            limits::described(&MASS_FRACTION), Substance::ALL.map(Substance::name).join(", "),
            limits::wavelengths(impurity::WAVELENGTH_RANGE)
        )
    )]
    impurity: Vec<ImpurityAmount>,
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
    /// Grain sizes in the measure of the options.
    pub(crate) fn grain_size(&self, size: GrainSizeArgument) -> Result<GrainSize, Failure> {
        GrainSize::from_numbers(&size.numbers_um(), self.size_measure).map_err(Failure::input)
    }

    fn impurities(&self) -> Result<Impurities, Failure> {
        let mut impurities = Impurities::none();
        for (number, ImpurityAmount { substance, ng_g }) in self.impurity.iter().enumerate() {
            if self.impurity[..number].iter().any(|other| other.substance == *substance) {
                return Err(Failure::Input(format!("impurity {substance} is given twice")));
            }
            impurities = impurities.with(*substance, *ng_g);
        }
        Ok(impurities)
    }

    /// The snow. Only its grain size is checked.
    pub(crate) fn sample(&self) -> Result<SnowSample, Failure> {
        let measure = (self.size_measure != SizeMeasure::default()).then_some(self.size_measure);
        if self.snow.is_some() && self.grain_size.is_none() && measure.is_some() {
            return Err(Failure::Input("--size-measure with --snow needs --grain-size".to_owned()));
        }
        let size = self.grain_size.map(|_| "--grain-size").or(self.ssa.map(|_| "--ssa"));
        if let (Some(_), Some(_), Some(size)) = (self.snow, self.density, size) {
            return Err(has_no_effect("snow", &format!("{size} and --density replace all that a kind of snow sets")));
        }
        let described = SnowDescription {
            snow_type: self.snow,
            grain_size_um: self.grain_size.map(GrainSizeArgument::numbers_um),
            size_measure: measure,
            surface_area_m2_kg: self.ssa,
            sphericity: Some(self.sphericity),
            facetness: Some(self.facetness),
            density_kg_m3: self.density,
            water_saturation: Some(self.water_saturation),
            impurities: self.impurities()?,
            temperature_c: Some(self.temperature),
            ice: Some(self.ice),
        };
        described.sample().map_err(Failure::input)
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
        self.grain_size.is_some() || self.ssa.is_some() || self.snow.is_some()
    }

    /// Whether an option sets the density.
    pub(crate) fn sets_density(&self) -> bool {
        self.density.is_some() || self.snow.is_some()
    }

    /// Metadata: the snow, its kind, ice constants, water and impurities.
    pub(crate) fn metadata(&self) -> Result<Metadata, Failure> {
        Ok(self.metadata_of(&self.sample()?))
    }

    /// Metadata of a sample that differs from the options in grain size or density.
    pub(crate) fn metadata_of(&self, sample: &SnowSample) -> Metadata {
        let mut metadata = vec![("snow", describe_sample(sample))];
        if let Some(kind) = self.snow {
            metadata.push(("kind", format!("{kind} ({})", kind.source())));
        }
        metadata.push(("ice", self.ice.name().to_owned()));
        if self.water_saturation > 0.0 {
            let source = "Daimon & Masumura 2007, Water Optical Properties Processor v3";
            metadata.push(("water", format!("saturation {} ({source})", format_number(self.water_saturation))));
        }
        let describe = |ImpurityAmount { substance, ng_g }: &ImpurityAmount| {
            format!("{substance}={} ng/g ({})", format_number(*ng_g), substance.source())
        };
        let present: Vec<String> = self.impurity.iter().filter(|amount| amount.ng_g > 0.0).map(describe).collect();
        if !present.is_empty() {
            metadata.push(("impurities", present.join(", ")));
        }
        metadata
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
pub(crate) fn describe_measure(measure: SizeMeasure) -> &'static str {
    match measure {
        SizeMeasure::GreatestExtension => "greatest extension",
        SizeMeasure::VolumeDiameter => "volume diameter",
        SizeMeasure::OpticalDiameter => "optical diameter",
    }
}

/// Both ends of a range, or one value if they are equal.
pub(crate) fn describe_range(low: f64, high: f64) -> String {
    if low < high { format!("{}–{}", format_number(low), format_number(high)) } else { format_number(low) }
}

/// Range, mean and standard deviation, or the single value.
pub(crate) fn describe_distribution(distribution: &TruncatedNormal) -> String {
    let range = describe_range(distribution.min, distribution.max);
    if distribution.min >= distribution.max {
        return range;
    }
    let (mean, deviation) = (format_number(distribution.mean), format_number(distribution.standard_deviation));
    format!("{range} about {mean} ± {deviation}")
}
