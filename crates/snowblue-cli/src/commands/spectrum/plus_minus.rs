//! `spectrum --plus-minus`: intervals from what is not known exactly of the snow.

use snowblue_figures::{Cell, Metadata, format_number};
use snowblue_transport::optics::Substance;
use snowblue_transport::spread::{DRAWS, FluxIntervals, SizeDeviation, Uncertainty};

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
        let number = || value.ok_or_else(|| format!("give {name}=DEVIATION")).and_then(parse::number);
        match name {
            "ice" if value.is_none() => uncertainty.ice = true,
            "ice" => return Err("ice takes no value: either table is equally likely".to_owned()),
            "ssa" => uncertainty.size = Some(SizeDeviation::SurfaceArea(number()?)),
            "grain-size" => uncertainty.size = Some(SizeDeviation::GrainSize(number()?)),
            "density" => uncertainty.density_kg_m3 = number()?,
            _ => {
                let substances = Substance::ALL.map(Substance::name).join(", ");
                let unknown =
                    |_| format!("'{name}' is not known; there are ssa, grain-size, density, ice, {substances}");
                uncertainty.mass_fractions_ng_g.push((name.parse().map_err(unknown)?, number()?));
            }
        }
    }
    if given.contains(&"ssa") && given.contains(&"grain-size") {
        return Err("ssa and grain-size are two names of one size: give one".to_owned());
    }
    Ok(uncertainty)
}

/// The cells of [`COLUMNS`].
pub(super) fn cells(at: &FluxIntervals) -> impl Iterator<Item = Cell> {
    [at.reflectance, at.transmittance, at.absorptance].into_iter().flatten().map(Cell::from)
}

/// What the intervals are.
pub(super) fn metadata(uncertainty: &Uncertainty) -> Metadata {
    let Uncertainty { size, density_kg_m3, mass_fractions_ng_g, ice } = uncertainty;
    let mut parts = Vec::new();
    match size {
        Some(SizeDeviation::SurfaceArea(area)) => parts.push(format!("ssa ± {} m²/kg", format_number(*area))),
        Some(SizeDeviation::GrainSize(size)) => parts.push(format!("grain size ± {} µm", format_number(*size))),
        None => {}
    }
    if *density_kg_m3 > 0.0 {
        parts.push(format!("density ± {} kg/m³", format_number(*density_kg_m3)));
    }
    let fraction = |(substance, ng_g): &(Substance, f64)| format!("{substance} ± {} ng/g", format_number(*ng_g));
    parts.extend(mass_fractions_ng_g.iter().map(fraction));
    if *ice {
        parts.push("either table of ice".to_owned());
    }
    vec![("95 % of cases", format!("lower–upper of {DRAWS} snows: {}", parts.join(", ")))]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviations_have_the_names_of_options() {
        let found = uncertainty("ssa=2, density=30,black-carbon=5,ice").unwrap();
        assert_eq!(found.size, Some(SizeDeviation::SurfaceArea(2.0)));
        assert_eq!((found.density_kg_m3.to_bits(), found.ice), (30_f64.to_bits(), true));
        assert_eq!(found.mass_fractions_ng_g, [(Substance::BlackCarbon, 5.0)]);
        for (words, message) in [
            ("soot=5", "'soot' is not known; there are ssa, grain-size, density, ice, black-carbon"),
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
