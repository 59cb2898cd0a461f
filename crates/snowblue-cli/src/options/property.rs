//! Options of the properties of snow, one for each row of their table, and `--impurity`.

use std::collections::BTreeMap;

use clap::{Arg, ArgAction, ArgGroup, ArgMatches, Command};
use snowblue_transport::Substance;
use snowblue_transport::optics::impurity;
use snowblue_transport::parameters::MASS_FRACTION;
use snowblue_transport::sample::{Property, SnowKeys};

use super::{limits, parse};

/// Values of properties of snow, in the order of the table: each a number, or the numbers of a distribution.
#[derive(Debug, Clone)]
pub(crate) struct PropertyValues(Vec<PropertyAxis>);

/// A property with its values.
#[derive(Debug, Clone)]
pub(crate) struct PropertyAxis {
    pub(crate) property: Property,
    pub(crate) values: Vec<Vec<f64>>,
}

/// `black-carbon=10` or `black-carbon=0:10:100`: an impurity and one or several mass fractions in ng/g.
#[derive(Debug, Clone)]
struct ImpurityValues(Substance, Vec<Vec<f64>>);

const IMPURITY: &str = "impurity";

/// Name of the option of a property, as an id of clap.
pub(crate) fn option_name(property: Property) -> &'static str {
    if matches!(property, Property::Impurity(_)) { IMPURITY } else { property.name() }
}

/// Names of the options of properties, as ids of clap.
pub(crate) fn option_names(properties: impl Iterator<Item = Property>) -> Vec<&'static str> {
    let plain = properties.filter(|property| !matches!(property, Property::Impurity(_)));
    plain.map(Property::name).chain([IMPURITY]).collect()
}

/// Adds an option for each property that is no impurity, with the end of its help, and `--impurity`, as a group.
pub(crate) fn add_options(
    command: Command,
    group: &'static str,
    properties: impl Iterator<Item = Property> + Clone,
    help: impl Fn(Property) -> String,
    impurity_help: &str,
) -> Command {
    let option =
        |name: &'static str| Arg::new(name).long(name.replace('_', "-")).action(ArgAction::Append).value_delimiter(',');
    let group = ArgGroup::new(group).multiple(true).args(option_names(properties.clone()));
    let plain = properties.filter(|property| !matches!(property, Property::Impurity(_))).map(|property| {
        option(property.name())
            .value_name(property.name().to_uppercase())
            .allow_negative_numbers(true)
            .value_parser(move |word: &str| values(property, word))
            .help(format!("{}{}", property.parameter().describe(), help(property)))
    });
    let impurity = option(IMPURITY).value_name("NAME=NG_G").value_parser(impurity_values).help(format!(
        "{}, as black-carbon=10; several separated by commas or repeated: {}; for {} nm{impurity_help}",
        limits::described(&MASS_FRACTION),
        Substance::ALL.map(Substance::name).join(", "),
        limits::wavelengths(impurity::WAVELENGTH_RANGE),
    ));
    command.args(plain).arg(impurity).group(group)
}

/// The numbers of a property: one, or those of a distribution, between colons.
pub(crate) fn values(property: Property, word: &str) -> Result<Vec<f64>, String> {
    let (numbers, mut keys) = (parse::numbers(word)?, SnowKeys::default());
    keys.set(property, &numbers).map_err(|error| error.to_string())?;
    keys.sample().map_err(|wrong| wrong.error.to_string())?;
    Ok(numbers)
}

fn impurity_values(words: &str) -> Result<ImpurityValues, String> {
    let (name, ng_g) =
        words.split_once('=').ok_or("give NAME=NG_G (black-carbon=10, or several: black-carbon=0:10:100)")?;
    let substance = name.trim().parse::<Substance>().map_err(|error| error.to_string())?;
    let value = |word: &str| values(Property::Impurity(substance), word);
    Ok(ImpurityValues(substance, ng_g.split(':').map(value).collect::<Result<_, _>>()?))
}

impl PropertyValues {
    /// The values that are given on the command line.
    ///
    /// # Errors
    /// If an impurity is given twice.
    pub(crate) fn of(matches: &ArgMatches, properties: impl Iterator<Item = Property>) -> Result<Self, clap::Error> {
        let mut impurities = BTreeMap::new();
        for ImpurityValues(substance, values) in matches.get_many::<ImpurityValues>(IMPURITY).into_iter().flatten() {
            if impurities.insert(substance.name(), values).is_some() {
                let message = format!("impurity {substance} is given twice\n");
                return Err(clap::Error::raw(clap::error::ErrorKind::ArgumentConflict, message));
            }
        }
        let given = |property: Property| {
            let values = match property {
                Property::Impurity(substance) => impurities.get(substance.name()).copied()?.clone(),
                _ => matches.get_many::<Vec<f64>>(property.name())?.cloned().collect(),
            };
            Some(PropertyAxis { property, values })
        };
        Ok(Self(properties.filter_map(given).collect()))
    }

    /// The properties that have values.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &PropertyAxis> {
        self.0.iter()
    }

    /// Whether a property has values.
    pub(crate) fn has(&self, property: Property) -> bool {
        self.0.iter().any(|axis| axis.property == property)
    }
}
