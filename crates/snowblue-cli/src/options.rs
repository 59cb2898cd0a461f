//! Options that mean the same on every command.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use serde::Deserialize;
use snowblue_color::{Colorimeter, Illuminant, Observer};
use snowblue_render::FalseColor;
use snowblue_transport::TransportError;
use snowblue_transport::optics::IceTable;
use snowblue_transport::optics::{Impurities, Substance};
use snowblue_transport::ordinates::{OrdinatesOptions, Streams};
use snowblue_transport::sample::SnowType;
use snowblue_transport::sample::{GrainSize, SizeMeasure, SnowSample, TruncatedNormal};
use snowblue_transport::slab::{Incidence, Slab};

use crate::failure::{Failure, Outcome};
use crate::parse::{self, SizeWords, Wavelengths};
use crate::report::{check_place, figures};

/// What the snow is made of.
#[derive(Debug, Args)]
#[command(next_help_heading = "Snow")]
pub(crate) struct SampleOptions {
    /// Kind of snow by the International Classification, for its specific surface area and density where they are not given:
    /// fresh, rounded, faceted, wind-packed, melt-forms, firn
    #[arg(long, value_name = "KIND", value_parser = parse::snow_type)]
    snow: Option<SnowType>,
    /// Grain size in µm: a mean, which stands for mean ± 50 [70–4950], or MIN:MAX, uniform in number [20–5000; default:
    /// 400]
    #[arg(long, value_name = "SIZE", value_parser = parse::size, conflicts_with = "ssa")]
    grain_size: Option<SizeWords>,
    /// Specific surface area in m²/kg, instead of a grain size [1.4–300]
    #[arg(long, value_name = "AREA", value_parser = parse::number)]
    ssa: Option<f64>,
    /// What the grain size measures
    #[arg(long, value_name = "MEASURE", value_enum, default_value = "greatest-extension", conflicts_with = "ssa")]
    size_measure: SizeMeasureWord,
    /// Facetness, the roughness of the grains: a mean (± 0.1, SD 0.075) or MIN:MAX:MEAN:SD [0–1]
    #[arg(long, value_name = "FACETNESS", default_value = "0.3", value_parser = parse::facetness)]
    facetness: TruncatedNormal,
    /// Riley sphericity of the grains: one value or MIN:MAX:MEAN:SD [0.5–1]
    #[arg(long, value_name = "SPHERICITY", default_value = "0.7:0.9:0.8:0.1", value_parser = parse::sphericity)]
    sphericity: TruncatedNormal,
    /// Density of the dry snow in kg/m³ [10–900; default: 300]
    #[arg(long, value_name = "DENSITY", value_parser = parse::number)]
    density: Option<f64>,
    /// Share of the pores that water fills [0–1]; 300–1400 nm
    #[arg(long, value_name = "SHARE", default_value = "0", value_parser = parse::number)]
    water_saturation: f64,
    /// Particles between the grains and their mass per dry snow in ng/g, as black-carbon=10; several by commas or
    /// repeated: black-carbon, brown-carbon, saharan-dust, colorado-dust, snow-algae; 305–1495 nm
    #[arg(long, value_name = "NAME=NG_G", value_delimiter = ',', value_parser = parse::impurity)]
    impurity: Vec<(Substance, f64)>,
    /// Temperature in °C, which changes the density of ice alone [-60–0]
    #[arg(long, value_name = "T", default_value = "-5", value_parser = parse::number, allow_negative_numbers = true)]
    temperature: f64,
    /// Whose absorption of ice to use; the two differ in the blue
    #[arg(long, value_name = "TABLE", value_enum, default_value = "warren2008")]
    ice: IceWord,
}

/// How thick the snow is, and how light falls on it.
#[derive(Debug, Args)]
#[command(next_help_heading = "Slab")]
pub(crate) struct SlabOptions {
    /// Thickness in cm, one or several separated by commas
    #[arg(long, value_name = "CM", default_value = "15", value_delimiter = ',', value_parser = parse::number)]
    pub(crate) thickness: Vec<f64>,
    /// Angle of incidence from the normal in degrees [0–89.99], or 'diffuse' (Lambertian); several by commas
    #[arg(long, value_name = "DEG", default_value = "0", value_delimiter = ',', value_parser = parse::incidence)]
    pub(crate) angle: Vec<Incidence>,
}

/// How the discrete ordinates work.
#[derive(Debug, Clone, Copy, Args)]
#[command(next_help_heading = "Engine")]
pub(crate) struct OrdinatesWords {
    /// Ordinates, counting both hemispheres: an even number, or 'auto': 16 up to 80° and diffuse, 48 beyond; in wet
    /// snow and among algae 64 and 128
    #[arg(long, value_name = "N", default_value = "auto", value_parser = parse::streams)]
    pub(crate) streams: Streams,
    /// Seed of all randomness
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
}

/// Where the answer goes.
#[derive(Debug, Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct OutputOptions {
    /// Write to a file instead of the terminal
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Format [default: by the file's ending, else a table on a terminal and CSV into a pipe]
    #[arg(long, value_name = "FORMAT", value_enum)]
    pub(crate) format: Option<Format>,
}

/// The light that colours are seen under.
#[derive(Debug, Clone, Copy, Args)]
#[command(next_help_heading = "Light")]
pub(crate) struct LightOptions {
    /// CIE illuminant: E, A, C, D50, D55, D65, D75, FL1–FL12, FL3.1–FL3.15, HP1–HP5, LED-B1…
    #[arg(long, value_name = "NAME", default_value = "D65", value_parser = parse::illuminant)]
    pub(crate) illuminant: Illuminant,
}

/// How spectra become colours.
#[derive(Debug, Args)]
#[command(next_help_heading = "Light")]
pub(crate) struct EyeOptions {
    /// Eye that sees the colours: 1931 (2°), by which sRGB is defined, or 1964 (10°)
    #[arg(long, value_name = "YEAR", default_value = "1931", value_parser = parse::observer)]
    pub(crate) observer: Observer,
    /// Wavelengths to sum over: 31 (400–700 nm) or 3 (455, 551, 608 nm)
    #[arg(long, value_name = "N", default_value = "31", value_parser = ["31", "3"])]
    pub(crate) samples: String,
    /// Light of three wavelengths in nm as red, green and blue [300–2500; 1030,860,550 if none are given]
    #[arg(
        long, value_name = "R,G,B", num_args = 0..=1, default_missing_value = parse::FALSE_COLOR_NM,
        value_parser = parse::false_color, conflicts_with_all = ["illuminant", "observer", "samples"]
    )]
    pub(crate) false_color: Option<FalseColor>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    Table,
    Csv,
    Json,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum SizeMeasureWord {
    GreatestExtension,
    VolumeDiameter,
    OpticalDiameter,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum IceWord {
    /// Warren & Brandt 2008
    Warren2008,
    /// Picard, Libois & Arnaud 2016
    Picard2016,
}

impl SizeWords {
    /// The sizes that the words stand for.
    pub(crate) fn measured_by(self, measure: SizeMeasureWord) -> Result<GrainSize, TransportError> {
        let measure = match measure {
            SizeMeasureWord::GreatestExtension => SizeMeasure::GreatestExtension,
            SizeMeasureWord::VolumeDiameter => SizeMeasure::VolumeDiameter,
            SizeMeasureWord::OpticalDiameter => SizeMeasure::OpticalDiameter,
        };
        match self {
            Self::Mean(mean_um) => GrainSize::around(mean_um).map(|size| GrainSize { measure, ..size }),
            Self::Range(min_um, max_um) => Ok(GrainSize { min_um, max_um, measure }),
        }
    }
}

impl IceWord {
    pub(crate) fn table(self) -> IceTable {
        match self {
            Self::Warren2008 => IceTable::WarrenBrandt2008,
            Self::Picard2016 => IceTable::Picard2016,
        }
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Warren2008 => "warren2008",
            Self::Picard2016 => "picard2016",
        }
    }
}

impl SampleOptions {
    fn grain_size(&self) -> Result<GrainSize, Failure> {
        let area_m2_kg = self.ssa.or(self.snow.map(SnowType::surface_area_m2_kg));
        if self.snow.is_some() && self.grain_size.is_none() && self.size_measure != SizeMeasureWord::GreatestExtension {
            return Err(Failure::Input("--size-measure with --snow needs --grain-size".to_owned()));
        }
        let size = match (self.grain_size, area_m2_kg) {
            (Some(words), _) => return self.size(words),
            (None, Some(area_m2_kg)) => GrainSize::from_specific_surface_area(area_m2_kg, self.temperature),
            (None, None) => return self.size(SizeWords::Mean(400.0)),
        };
        size.map_err(Failure::input)
    }

    /// Grain sizes in the measure that the options say.
    pub(crate) fn size(&self, words: SizeWords) -> Result<GrainSize, Failure> {
        words.measured_by(self.size_measure).map_err(Failure::input)
    }

    fn impurities(&self) -> Result<Impurities, Failure> {
        let mut impurities = Impurities::none();
        for (number, (substance, ng_g)) in self.impurity.iter().enumerate() {
            if self.impurity[..number].iter().any(|(other, _)| other == substance) {
                return Err(Failure::Input(format!("impurity {substance} is given twice")));
            }
            impurities = impurities.with(*substance, *ng_g);
        }
        Ok(impurities)
    }

    /// The snow, not checked yet but for its grain size.
    pub(crate) fn sample(&self) -> Result<SnowSample, Failure> {
        Ok(SnowSample {
            grain_size: self.grain_size()?,
            sphericity: self.sphericity,
            facetness: self.facetness,
            density_kg_m3: self.density.or(self.snow.map(SnowType::density_kg_m3)).unwrap_or(300.0),
            water_saturation: self.water_saturation,
            impurities: self.impurities()?,
            temperature_c: self.temperature,
            ice: self.ice.table(),
        })
    }

    /// The slab of this snow that the other options ask for, checked.
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

    /// Whether the grain size is said in any way.
    pub(crate) fn tells_size(&self) -> bool {
        self.grain_size.is_some() || self.ssa.is_some() || self.snow.is_some()
    }

    /// Whether the density is said in any way.
    pub(crate) fn tells_density(&self) -> bool {
        self.density.is_some() || self.snow.is_some()
    }

    /// What the answer rests on, for metadata: the snow, its kind, ice constants, water and impurities.
    pub(crate) fn metadata(&self) -> Result<Vec<(&'static str, String)>, Failure> {
        Ok(self.metadata_of(&self.sample()?))
    }

    /// The same for snow that was found by these options.
    pub(crate) fn metadata_of(&self, sample: &SnowSample) -> Vec<(&'static str, String)> {
        let mut metadata = vec![("snow", in_words(sample))];
        if let Some(kind) = self.snow {
            metadata.push(("kind", format!("{kind} ({})", kind.source())));
        }
        metadata.push(("ice", self.ice.name().to_owned()));
        if self.water_saturation > 0.0 {
            let source = "Daimon & Masumura 2007, Water Optical Properties Processor v3";
            metadata.push(("water", format!("saturation {} ({source})", figures(self.water_saturation))));
        }
        let one = |(substance, ng_g): &(Substance, f64)| {
            format!("{substance}={} ng/g ({})", figures(*ng_g), substance.source())
        };
        let present: Vec<String> = self.impurity.iter().filter(|(_, ng_g)| *ng_g > 0.0).map(one).collect();
        if !present.is_empty() {
            metadata.push(("impurities", present.join(", ")));
        }
        metadata
    }
}

/// Grains, density and temperature of dry snow in a few words.
fn in_words(sample: &SnowSample) -> String {
    let GrainSize { min_um, max_um, measure } = sample.grain_size;
    format!(
        "{} {} µm, sphericity {}, facetness {}, {} kg/m³, {} °C",
        measure_in_words(measure),
        range_in_words(min_um, max_um),
        law_in_words(&sample.sphericity),
        law_in_words(&sample.facetness),
        figures(sample.density_kg_m3),
        figures(sample.temperature_c),
    )
}

/// What a grain size measures.
pub(crate) fn measure_in_words(measure: SizeMeasure) -> &'static str {
    match measure {
        SizeMeasure::GreatestExtension => "greatest extension",
        SizeMeasure::VolumeDiameter => "volume diameter",
        SizeMeasure::OpticalDiameter => "optical diameter",
    }
}

/// Both ends, or one value where they are the same.
pub(crate) fn range_in_words(low: f64, high: f64) -> String {
    if low < high { format!("{}–{}", figures(low), figures(high)) } else { figures(low) }
}

/// The range, the mean and the standard deviation, or the one value.
pub(crate) fn law_in_words(law: &TruncatedNormal) -> String {
    let range = range_in_words(law.min, law.max);
    if law.min >= law.max {
        return range;
    }
    format!("{range} about {} ± {}", figures(law.mean), figures(law.standard_deviation))
}

impl OutputOptions {
    /// Checks before long work that the output can stand at its place.
    pub(crate) fn check(&self) -> Outcome {
        self.output.as_deref().map_or(Ok(()), check_place)
    }
}

impl LightOptions {
    /// From spectra on some wavelengths to colours.
    pub(crate) fn colorimeter(&self, observer: Observer, wavelengths_nm: &[f64]) -> Result<Colorimeter, Failure> {
        Colorimeter::new(observer, self.illuminant, wavelengths_nm).map_err(Failure::input)
    }
}

impl OrdinatesWords {
    pub(crate) fn options(self) -> OrdinatesOptions {
        OrdinatesOptions { streams: self.streams, seed: self.seed, ..OrdinatesOptions::default() }
    }
}

/// `diffuse`, or the angle in degrees.
pub(crate) fn incidence_name(incidence: Incidence) -> String {
    match incidence {
        Incidence::Beam { angle_deg } => angle_deg.to_string(),
        Incidence::Diffuse => "diffuse".to_owned(),
    }
}
