//! `spectrum --plus-minus`: intervals from the uncertainty of the properties of the snow.

use snowblue_base::unit_suffix;
use snowblue_figures::{Cell, Metadata, format_number};
use snowblue_transport::Property;
use snowblue_transport::slab::Fluxes;
use snowblue_transport::spread::{DRAWS, Uncertainty};

use crate::options::parse;

/// Columns of the intervals.
pub(super) const COLUMNS: [&str; 6] = [
    "reflectance_lower",
    "reflectance_upper",
    "transmittance_lower",
    "transmittance_upper",
    "absorptance_lower",
    "absorptance_upper",
];

/// `ssa=2,density=30,black-carbon=5,ice`: standard deviations by names of options.
pub(super) fn uncertainty(words: &str) -> Result<Uncertainty, String> {
    let mut uncertainty = Uncertainty::default();
    let mut given: Vec<&str> = Vec::new();
    for word in words.split(',').map(str::trim) {
        let (name, value) = word.split_once('=').map_or((word, None), |(name, value)| (name.trim(), Some(value)));
        if given.contains(&name) {
            return Err(format!("{name} is given twice"));
        }
        given.push(name);
        match (name, value) {
            ("ice", None) => uncertainty.ice = true,
            ("ice", Some(_)) => return Err("ice takes no value: either table is equally likely".to_owned()),
            _ => {
                let found = Uncertainty::properties().find(|property| property.name() == name.replace('-', "_"));
                let names = || Uncertainty::properties().map(|one| one.name().replace('_', "-")).collect::<Vec<_>>();
                let property =
                    found.ok_or_else(|| format!("'{name}' is not known; there are ice, {}", names().join(", ")))?;
                let deviation = value.ok_or_else(|| format!("give {name}=DEVIATION")).and_then(parse::number)?;
                uncertainty.deviations.push((property, deviation));
            }
        }
    }
    if given.contains(&"ssa") && given.contains(&"grain-size") {
        return Err("ssa and grain-size are two names of one size: give one".to_owned());
    }
    Ok(uncertainty)
}

/// The cells of [`COLUMNS`].
pub(super) fn cells(at: &Fluxes<[f64; 2]>) -> impl Iterator<Item = Cell> {
    at.to_array().into_iter().flatten().map(Cell::from)
}

/// Metadata that describe the intervals.
pub(super) fn metadata(uncertainty: &Uncertainty) -> Metadata {
    let part = |(property, deviation): &(Property, f64)| {
        let (name, unit) = (property.name().replace('_', "-"), unit_suffix(property.parameter().range.unit));
        format!("{name} ± {}{unit}", format_number(*deviation))
    };
    let mut parts: Vec<String> = uncertainty.deviations.iter().map(part).collect();
    if uncertainty.ice {
        parts.push("either table of ice".to_owned());
    }
    vec![("intervals", format!("95 % of cases in lower–upper, of {DRAWS} snows: {}", parts.join(", ")))]
}

#[cfg(test)]
mod tests {
    use snowblue_transport::Substance;

    use super::*;

    #[test]
    fn deviations_have_the_names_of_options() {
        let found = uncertainty("ssa=2, density=30,black-carbon=5,ice").unwrap();
        let soot = Property::Impurity(Substance::BLACK_CARBON);
        assert_eq!(found.deviations, [(Property::SurfaceArea, 2.0), (Property::Density, 30.0), (soot, 5.0)]);
        assert!(found.ice);
        for (words, message) in [
            ("soot=5", "'soot' is not known; there are ice, grain-size, ssa, density, water-saturation, black-carbon"),
            ("ssa", "give ssa=DEVIATION"),
            ("ssa=a", "'a' is not a number"),
            ("ice=1", "ice takes no value"),
            ("ssa=1,grain-size=2", "two names of one size"),
            ("ssa=1,ssa=2", "ssa is given twice"),
        ] {
            assert!(uncertainty(words).unwrap_err().contains(message), "{words}");
        }
    }
}
