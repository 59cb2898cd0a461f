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
use snowblue_transport::optics::Wavelengths;
use snowblue_transport::parameters::{ANGLE, MASS_FRACTION, THICKNESS};
use snowblue_transport::slab::Incidence;
use snowblue_transport::{Property, Substance};

use crate::{Axes, PropertyAxis, axis_properties};

#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "must be an angle in degrees or \"diffuse\"")]
enum Angle {
    Degrees(f64),
    Word(String),
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
    if let Some(Wavelengths(list)) = file.take_as("wavelength_nm")? {
        axes.wavelengths_nm = list;
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
            wrong(&format!(
                "is an unknown impurity; known are {}",
                Substance::all().map(Substance::name).collect::<Vec<_>>().join(", ")
            ))
        })?;
        if substances.contains(&substance) {
            return Err(wrong("is given twice, with a hyphen and with an underscore"));
        }
        substances.push(substance);
        axes.set_property(PropertyAxis { property: Property::Impurity(substance), values });
    }
    Ok(axes)
}
