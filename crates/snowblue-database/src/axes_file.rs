//! Axes of a table from a TOML file.
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
use std::fmt::Display;
use std::ops::Range;

use serde::Deserialize;
use snowblue_base::toml_value::Mistake;
use snowblue_transport::Substance;
use snowblue_transport::optics::IceTable;
use snowblue_transport::slab::Incidence;
use toml::Spanned;

use crate::{Axes, Property, PropertyAxis};

/// Greatest number of steps of a range of wavelengths.
const MOST_STEPS: f64 = 100_000.0;

/// What is wrong with a file of axes.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{reason}")]
pub struct AxesFileError {
    /// The bytes of the text that it is about; none if it is about the whole file.
    pub span: Option<Range<usize>>,
    /// The quantity, its value and its range.
    pub reason: String,
}

impl AxesFileError {
    fn at(span: Range<usize>, reason: impl Display) -> Self {
        Self { span: Some(span), reason: reason.to_string() }
    }
}

/// The tables of a file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Tables {
    preset: Option<Spanned<String>>,
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

/// Reads the text of a file, and checks the axes with a table of ice.
///
/// ```
/// # use snowblue_database::axes_file::parse;
/// let axes = parse("density_kg_m3 = [300]\nwavelength_nm = \"400:700:100\"\n", Default::default())?;
/// assert_eq!(axes.wavelengths_nm, [400.0, 500.0, 600.0, 700.0]);
/// # Ok::<(), snowblue_database::axes_file::AxesFileError>(())
/// ```
///
/// # Errors
/// If the text is not TOML, a key is unknown, or [`Axes::check`] refuses the axes.
pub fn parse(text: &str, ice: IceTable) -> Result<Axes, AxesFileError> {
    let tables: Tables = toml::from_str(text)
        .map_err(|error| Mistake::of_parser(text, &error))
        .map_err(|Mistake { span, reason }| AxesFileError::at(span, reason))?;
    let mut axes = match &tables.preset {
        None => Axes::paper(),
        Some(name) => Axes::preset(name.get_ref()).ok_or_else(|| {
            let presets = Axes::PRESETS.map(|(name, _)| name).join(", ");
            AxesFileError::at(name.span(), format!("preset is \"{}\", but must be one of {presets}", name.get_ref()))
        })?,
    };
    let replace = |axis: &mut Vec<f64>, values: Option<Vec<f64>>| {
        if let Some(values) = values {
            *axis = values;
        }
    };
    replace(&mut axes.grain_sizes_um, tables.grain_size_um);
    replace(&mut axes.facetness, tables.facetness);
    replace(&mut axes.densities_kg_m3, tables.density_kg_m3);
    replace(&mut axes.thicknesses_cm, tables.thickness_cm);
    let mut incidences = Vec::new();
    for word in tables.angle_deg.iter().flatten() {
        incidences.push(match word.get_ref() {
            Angle::Degrees(angle_deg) => Incidence::Beam { angle_deg: *angle_deg },
            Angle::Word(name) => name.parse().map_err(|error| AxesFileError::at(word.span(), error))?,
        });
    }
    if !incidences.is_empty() {
        axes.set_incidences(&incidences);
    }
    if let Some(words) = tables.wavelength_nm {
        let span = words.span();
        axes.wavelengths_nm = match words.into_inner() {
            WavelengthList::List(list) => list,
            WavelengthList::Range(range) => wavelengths(&range).map_err(|error| AxesFileError::at(span, error))?,
        };
    }
    let mut set = |property: Property, values: Option<Vec<f64>>| {
        if let Some(values) = values {
            axes.set_property(PropertyAxis { property, values });
        }
    };
    set(Property::WaterSaturation, tables.water_saturation);
    set(Property::Temperature, tables.temperature_c);
    let mut substances: Vec<Substance> = Vec::new();
    for (name, values) in tables.impurities_ng_g {
        let substance = name.get_ref().parse().map_err(|error| AxesFileError::at(name.span(), error))?;
        if substances.contains(&substance) {
            let reason = format!("{substance} is given twice, with a hyphen and with an underscore");
            return Err(AxesFileError::at(name.span(), reason));
        }
        substances.push(substance);
        set(Property::Impurity(substance), Some(values));
    }
    axes.check(ice).map_err(|error| AxesFileError { span: None, reason: error.to_string() })?;
    Ok(axes)
}

/// Wavelengths in nm from a range FIRST:LAST:STEP, which includes both ends, or a list with commas.
///
/// # Errors
/// If a word is not a number, or the range does not ascend or has more than 100,000 steps.
pub fn wavelengths(words: &str) -> Result<Vec<f64>, String> {
    let number = |word: &str| word.trim().parse().map_err(|_| format!("'{word}' is not a number"));
    if !words.contains(':') {
        let list = words.split(',').map(number).collect::<Result<_, String>>();
        return list.map_err(|error| format!("{error}; give FIRST:LAST:STEP (400:700:10) or a list (450,550), in nm"));
    }
    let [first, last, step] = words.split(':').map(number).collect::<Result<Vec<f64>, _>>()?[..] else {
        return Err("give FIRST:LAST:STEP (400:700:10) or a list (450,550,650), in nm".to_owned());
    };
    let count = (last - first) / step;
    if !(step > 0.0 && (0.0..MOST_STEPS).contains(&count)) {
        return Err(format!(
            "the range is {words} nm, but must ascend, with a step above 0 nm and at most 100000 steps"
        ));
    }
    let mut wavelengths = Vec::new();
    for i in 0_u32.. {
        let wavelength_nm = first + f64::from(i) * step;
        // Rounding must not drop the last wavelength.
        if wavelength_nm > last + 1e-9 * step {
            break;
        }
        wavelengths.push(wavelength_nm.min(last));
    }
    Ok(wavelengths)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_of_wavelengths_include_both_ends() {
        let visible = wavelengths("400:700:10").unwrap();
        assert_eq!(
            (visible.len(), visible[0].to_bits(), visible[30].to_bits()),
            (31, 400_f64.to_bits(), 700_f64.to_bits())
        );
        assert_eq!(wavelengths("0.1:0.7:0.1").unwrap().len(), 7);
        assert_eq!(wavelengths("450,550").unwrap().len(), 2);
        for bad in ["400:700:0", "700:400:10", "400:700", "blue", "1:1e12:1", "1:2:nan"] {
            assert!(wavelengths(bad).is_err(), "{bad}");
        }
    }
}
