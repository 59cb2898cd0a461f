//! Parameters that vary along the rows and columns of a sheet: `NAME=VALUE,VALUE`.

use snowblue_color::Illuminant;
use snowblue_figures::format_number;
use snowblue_figures::swatch::SheetAxis;
use snowblue_transport::sample::{SnowSample, TruncatedNormal};
use snowblue_transport::slab::Incidence;

use crate::options::parse::{self, GrainSizeArgument};
use crate::options::{SnowOptions, describe_distribution, describe_range};
use crate::output::Failure;

/// A parameter that can vary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Parameter {
    GrainSize,
    Facetness,
    Density,
    WaterSaturation,
    Thickness,
    Angle,
    Illuminant,
}

const PARAMETERS: [Parameter; 7] = [
    Parameter::GrainSize,
    Parameter::Facetness,
    Parameter::Density,
    Parameter::WaterSaturation,
    Parameter::Thickness,
    Parameter::Angle,
    Parameter::Illuminant,
];

/// One value of a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Setting {
    GrainSize(GrainSizeArgument),
    Facetness(TruncatedNormal),
    Density(f64),
    WaterSaturation(f64),
    Thickness(f64),
    Angle(Incidence),
    Illuminant(Illuminant),
}

/// A parameter and its values.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    pub(super) parameter: Parameter,
    steps: Vec<Setting>,
}

/// The snow and the light of a swatch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Subject {
    pub(super) sample: SnowSample,
    pub(super) thickness_cm: f64,
    pub(super) incidence: Incidence,
    pub(super) illuminant: Illuminant,
}

impl Parameter {
    /// Its name, equal to that of the option.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::GrainSize => "grain-size",
            Self::Facetness => "facetness",
            Self::Density => "density",
            Self::WaterSaturation => "water-saturation",
            Self::Thickness => "thickness",
            Self::Angle => "angle",
            Self::Illuminant => "illuminant",
        }
    }

    /// Its column in CSV, unless `color` has one.
    pub(super) fn column(self) -> Option<&'static str> {
        match self {
            Self::GrainSize => Some("grain_size_um"),
            Self::Facetness => Some("facetness"),
            Self::Density => Some("density_kg_m3"),
            Self::WaterSaturation => Some("water_saturation"),
            Self::Thickness | Self::Angle | Self::Illuminant => None,
        }
    }

    /// Options that set the same quantity.
    pub(super) fn rivals(self) -> &'static [&'static str] {
        match self {
            Self::GrainSize => &["grain_size", "ssa"],
            Self::Facetness => &["facetness"],
            Self::Density => &["density"],
            Self::WaterSaturation => &["water_saturation"],
            Self::Thickness => &["thickness"],
            Self::Angle => &["angle"],
            Self::Illuminant => &["illuminant"],
        }
    }

    fn setting(self, word: &str) -> Result<Setting, String> {
        Ok(match self {
            Self::GrainSize => Setting::GrainSize(parse::grain_size(word)?),
            Self::Facetness => Setting::Facetness(parse::facetness(word)?),
            Self::Density => Setting::Density(parse::number(word)?),
            Self::WaterSaturation => Setting::WaterSaturation(parse::number(word)?),
            Self::Thickness => Setting::Thickness(parse::number(word)?),
            Self::Angle => Setting::Angle(parse::incidence(word)?),
            Self::Illuminant => Setting::Illuminant(parse::illuminant(word)?),
        })
    }
}

impl Setting {
    /// The value as the option of its name takes it, with the digits of a table.
    fn word(self) -> String {
        match self {
            Self::GrainSize(GrainSizeArgument::Mean(size_um)) => format_number(size_um),
            Self::GrainSize(GrainSizeArgument::Range { min_um, max_um }) => {
                format!("{}:{}", format_number(min_um), format_number(max_um))
            }
            Self::Facetness(law) if law == TruncatedNormal::facetness_around(law.mean) => format_number(law.mean),
            Self::Facetness(TruncatedNormal { min, max, mean, standard_deviation }) => {
                [min, max, mean, standard_deviation].map(format_number).join(":")
            }
            Self::Density(value) | Self::WaterSaturation(value) | Self::Thickness(value) => format_number(value),
            Self::Angle(incidence) => incidence.to_string(),
            Self::Illuminant(illuminant) => illuminant.name().to_owned(),
        }
    }

    /// The value with its unit.
    pub(super) fn label(self) -> String {
        match self {
            Self::GrainSize(GrainSizeArgument::Range { min_um, max_um }) => {
                format!("{} µm", describe_range(min_um, max_um))
            }
            Self::GrainSize(GrainSizeArgument::Mean(_)) => format!("{} µm", self.word()),
            Self::Facetness(law) if law != TruncatedNormal::facetness_around(law.mean) => describe_distribution(&law),
            Self::Density(_) => format!("{} kg/m³", self.word()),
            Self::Thickness(_) => format!("{} cm", self.word()),
            Self::Angle(Incidence::Beam { .. }) => format!("{}°", self.word()),
            Self::Facetness(_) | Self::WaterSaturation(_) | Self::Angle(_) | Self::Illuminant(_) => self.word(),
        }
    }
}

/// Parses `thickness=1,5,15`.
pub(super) fn axis(words: &str) -> Result<Axis, String> {
    let (name, values) = words.split_once('=').ok_or("give NAME=VALUE,VALUE (thickness=1,5,15)")?;
    let known = PARAMETERS.into_iter().find(|parameter| parameter.name() == name.trim());
    let parameter = known.ok_or_else(|| {
        let names = PARAMETERS.map(Parameter::name).join(", ");
        format!("parameter '{name}' is not known; there are {names}")
    })?;
    let steps = values.split(',').map(|word| parameter.setting(word.trim())).collect::<Result<Vec<_>, String>>()?;
    if let Some((_, step)) = steps.iter().enumerate().find(|(number, step)| steps[..*number].contains(step)) {
        return Err(format!("{} is given twice", step.label()));
    }
    Ok(Axis { parameter, steps })
}

impl Axis {
    pub(super) fn len(&self) -> usize {
        self.steps.len()
    }

    /// The value of a step, for a table.
    pub(super) fn word(&self, step: usize) -> String {
        self.steps[step].word()
    }

    /// The subject with the value of a step.
    pub(super) fn set(&self, step: usize, subject: Subject, options: &SnowOptions) -> Result<Subject, Failure> {
        let Subject { sample, .. } = subject;
        Ok(match self.steps[step] {
            Setting::GrainSize(size) => {
                Subject { sample: SnowSample { grain_size: options.grain_size(size)?, ..sample }, ..subject }
            }
            Setting::Facetness(facetness) => Subject { sample: SnowSample { facetness, ..sample }, ..subject },
            Setting::Density(density_kg_m3) => Subject { sample: SnowSample { density_kg_m3, ..sample }, ..subject },
            Setting::WaterSaturation(water_saturation) => {
                Subject { sample: SnowSample { water_saturation, ..sample }, ..subject }
            }
            Setting::Thickness(thickness_cm) => Subject { thickness_cm, ..subject },
            Setting::Angle(incidence) => Subject { incidence, ..subject },
            Setting::Illuminant(illuminant) => Subject { illuminant, ..subject },
        })
    }

    /// Name and labels for the sheet.
    pub(super) fn sheet(&self) -> SheetAxis {
        let name = match self.parameter {
            Parameter::Angle => "angle of incidence".to_owned(),
            Parameter::WaterSaturation => "water in the pores (fraction)".to_owned(),
            other => other.name().replace('-', " "),
        };
        SheetAxis { name, labels: self.steps.iter().map(|step| step.label()).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_parsed_with_their_units() {
        let labels = |words: &str| axis(words).unwrap().sheet().labels;
        assert_eq!(labels("grain-size=100,350:450"), ["100 µm", "350–450 µm"]);
        assert_eq!(labels("angle=0,89.5,diffuse"), ["0°", "89.5°", "diffuse"]);
        assert_eq!(labels("density=200"), ["200 kg/m³"]);
        assert_eq!(labels("thickness=1e1, 2.50"), ["10 cm", "2.5 cm"]);
        assert_eq!(labels("illuminant=d65,fl3.15"), ["D65", "FL3.15"]);
        assert_eq!(labels("facetness=0.3,0.1:0.5:0.3:0.2"), ["0.3", "0.1–0.5 about 0.3 ± 0.2"],);
        for (words, reason) in [
            ("thickness", "NAME=VALUE"),
            ("depth=1", "'depth'"),
            ("thickness=1,,2", "'' is not a number"),
            ("thickness=1,5,1.0", "1 cm is given twice"),
            ("facetness=1.5", "facetness is 1.5, but must lie in 0–1"),
            ("illuminant=D66", "D66"),
        ] {
            assert!(axis(words).unwrap_err().contains(reason), "{words}");
        }
    }
}
