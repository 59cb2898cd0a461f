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

use serde::Deserialize;
use snowblue_base::KeyPath;
use snowblue_base::toml_table::{ParseError, Table};
use snowblue_transport::parameters::{ANGLE, MASS_FRACTION, THICKNESS};
use snowblue_transport::slab::Incidence;
use snowblue_transport::{Property, Substance};

use crate::{Axes, PropertyAxis, axis_properties};

/// Greatest number of steps of a range of wavelengths.
const MAX_STEPS: f64 = 100_000.0;

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

/// Reads the text of a file. The axes are not [checked](Axes::check).
///
/// ```
/// # use snowblue_database::axes_file::parse;
/// let axes = parse("density_kg_m3 = [300]\nwavelength_nm = \"400:700:100\"\n")?;
/// assert_eq!(axes.wavelengths_nm, [400.0, 500.0, 600.0, 700.0]);
/// # Ok::<(), snowblue_base::toml_table::ParseError>(())
/// ```
///
/// # Errors
/// If the text is not TOML, a key is unknown, or a value is not of its type.
pub fn parse(text: &str) -> Result<Axes, ParseError> {
    let mut file = Table::parse(text)?;
    let presets = Axes::PRESETS.map(|(name, _)| (name, name));
    let preset = if file.has("preset") { file.take_name("preset", &presets)? } else { "paper" };
    let mut axes = Axes::preset(preset).unwrap_or_else(|| unreachable!("{preset} is a preset"));
    if let Some(values) = file.take_as(THICKNESS.key)? {
        axes.thicknesses_cm = values;
    }
    if let Some(angles) = file.take(ANGLE.key) {
        let incidence = |angle: Angle| match angle {
            Angle::Degrees(angle_deg) => Ok(Incidence::Beam { angle_deg }),
            Angle::Word(word) => word.parse().map_err(|error| angles.error(format_args!("is wrong: {error}"))),
        };
        let incidences = angles.clone().read::<Vec<Angle>>()?.into_iter().map(incidence);
        axes.set_incidences(&incidences.collect::<Result<Vec<_>, _>>()?);
    }
    if let Some(words) = file.take("wavelength_nm") {
        axes.wavelengths_nm = match words.clone().read()? {
            WavelengthList::List(list) => list,
            WavelengthList::Range(range) => {
                wavelengths(&range).map_err(|error| words.error(format_args!("is wrong: {error}")))?
            }
        };
    }
    let given: BTreeMap<String, Vec<f64>> = file.take_as(MASS_FRACTION.key)?.unwrap_or_default();
    for property in axis_properties().filter(|property| !matches!(property, Property::Impurity(_))) {
        if let Some(values) = file.take_as(property.key())? {
            axes.set_property(PropertyAxis { property, values });
        }
    }
    file.finish()?;
    let mut substances: Vec<Substance> = Vec::new();
    for (name, values) in given {
        let wrong = |reason: &str| KeyPath::root(MASS_FRACTION.key).key(&name).error(reason).in_text(text);
        let substance = name.parse().map_err(|_| {
            wrong(&format!("is an unknown impurity; known are {}", Substance::ALL.map(Substance::name).join(", ")))
        })?;
        if substances.contains(&substance) {
            return Err(wrong("is given twice, with a hyphen and with an underscore"));
        }
        substances.push(substance);
        axes.set_property(PropertyAxis { property: Property::Impurity(substance), values });
    }
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
    if !(step > 0.0 && (0.0..MAX_STEPS).contains(&count)) {
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
