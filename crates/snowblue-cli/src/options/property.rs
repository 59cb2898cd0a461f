//! Options of the properties of snow, one for each row of their table, and `--impurity`.

use clap::{Arg, ArgAction, ArgGroup, ArgMatches, Args, Command, FromArgMatches};
use snowblue_database::axis_properties;
use snowblue_transport::optics::OwnParticles;
use snowblue_transport::parameters::MASS_FRACTION;
use snowblue_transport::sample::{MEAN_SIZE_HALF_RANGE_UM, MEAN_SIZE_RANGE, Property, SnowKeys};
use snowblue_transport::{Parameter, Substance};

use super::{limits, parse};

/// Values of properties of snow: of one snow, or along the axes of a table.
#[derive(Debug)]
pub(crate) struct PropertyValues<const OF_TABLE: bool>(Vec<PropertyAxis>);

/// A property with its values, each a number, or the numbers of a distribution.
#[derive(Debug, Clone)]
pub(crate) struct PropertyAxis {
    pub(crate) property: Property,
    pub(crate) values: Vec<Vec<f64>>,
}

const IMPURITY: &str = "impurity";

/// The help on particles that are not built in.
const OWN_PARTICLES: &str = ". Other particles have a file, my-dust=500:dust.csv, with the columns wavelength_nm, \
    extinction_m2_kg, single_scattering_albedo and asymmetry, or wavelength_nm and absorption_m2_kg";

impl PropertyAxis {
    /// The option as on the command line, without the hyphens before it.
    pub(crate) fn option(&self) -> String {
        option_name(self.property).replace('_', "-")
    }
}

/// Name of the option of a property, as an id of clap.
pub(crate) fn option_name(property: Property) -> &'static str {
    if matches!(property, Property::Impurity(_)) { IMPURITY } else { property.name() }
}

/// The numbers of a property between colons: one number, or the numbers of a distribution.
pub(crate) fn values(property: Property, word: &str) -> Result<Vec<f64>, String> {
    let (numbers, mut keys) = (parse::numbers(word)?, SnowKeys::default());
    keys.set(property, &numbers).map_err(|error| error.to_string())?;
    keys.sample().map_err(|wrong| wrong.error.to_string())?;
    Ok(numbers)
}

/// `black-carbon=10` or `black-carbon=0:10:100`: an impurity and one or several mass fractions in ng/g. After them may
/// come the file of the particles of a substance that is not built in: `my-dust=500:dust.csv`.
fn impurity_axis(words: &str, of_table: bool) -> Result<PropertyAxis, String> {
    const FORMS: &str = "give NAME=NG_G (black-carbon=10, or several: black-carbon=0:10:100), or NAME=NG_G:FILE.csv";
    let (name, rest) = words.split_once('=').ok_or(FORMS)?;
    let (name, words) = (name.trim(), rest.split(':').collect::<Vec<_>>());
    let is_number = |word: &&&str| word.trim().parse::<f64>().is_ok();
    let (ng_g, file) = words.split_at(words.iter().take_while(is_number).count());
    // The name of a file may have a colon. Other words are wrong numbers.
    let file = Some(file.join(":")).filter(|file| parse::has_end(file, "csv"));
    if file.is_some() && ng_g.is_empty() {
        return Err(FORMS.to_owned());
    }
    let substance = match &file {
        Some(file) if of_table => return Err(format!("{file}: a table has built-in impurities only, without a file")),
        None => {
            name.parse::<Substance>().map_err(|error| format!("{error}; others have a file: NAME=NG_G:FILE.csv"))?
        }
        Some(file) => {
            let particles = parse::csv_file(file, OwnParticles::read)?;
            particles.declare(name).map_err(|error| format!("{file}: {error}"))?
        }
    };
    let property = Property::Impurity(substance);
    let values = if file.is_some() { ng_g } else { &words }.iter().map(|word| values(property, word));
    Ok(PropertyAxis { property, values: values.collect::<Result<_, _>>()? })
}

/// The end of the help of a property: its range, default and form.
fn help(property: Property, of_table: bool) -> String {
    let Parameter { range, default, .. } = property.parameter();
    let range = limits::ends(&range.inclusive());
    let range = match property {
        _ if of_table => format!(" [{range}]"),
        Property::SurfaceArea => format!(" [{range}], instead of a grain size"),
        _ => format!(" [{range}; default: {default}]"),
    };
    let means = limits::ends(&MEAN_SIZE_RANGE.inclusive());
    let of_mean = format!("for the range mean ± {MEAN_SIZE_HALF_RANGE_UM} [{means}]");
    let form = match property {
        Property::GrainSize if of_table => format!(": means, each {of_mean}"),
        Property::GrainSize => format!(": a mean, {of_mean}, or MIN:MAX, uniform in number{range}"),
        Property::Facetness if !of_table => format!("{range}: a mean (± 0.1, SD 0.075) or MIN:MAX:MEAN:SD"),
        Property::Sphericity => format!("{range}: one value or MIN:MAX:MEAN:SD; without it 0.7:0.9:0.8:0.1"),
        Property::Temperature => format!("{range}; changes the density of ice only"),
        _ => range,
    };
    if of_table { form } else { format!("{form}; spectrum takes several, separated by commas") }
}

impl<const OF_TABLE: bool> PropertyValues<OF_TABLE> {
    /// Name of the group of the options.
    pub(crate) const GROUP: &str = if OF_TABLE { "AxisProperties" } else { "SnowProperties" };

    /// Names of the options, as ids of clap.
    pub(crate) fn names() -> Vec<&'static str> {
        Self::plain().map(Property::name).chain([IMPURITY]).collect()
    }

    /// Keys of the properties that are no impurities.
    pub(crate) fn keys() -> String {
        Self::plain().map(Property::key).collect::<Vec<_>>().join(", ")
    }

    /// The properties that are no impurities.
    fn plain() -> impl Iterator<Item = Property> {
        let can_be_axis = |property: Property| !OF_TABLE || axis_properties().any(|other| other == property);
        Property::all().filter(move |one| !matches!(one, Property::Impurity(_)) && can_be_axis(*one))
    }

    /// The properties that have values, in the order of the table, and impurities as they are given.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &PropertyAxis> {
        self.0.iter()
    }

    /// Whether a property has values.
    pub(crate) fn has(&self, property: Property) -> bool {
        self.0.iter().any(|axis| axis.property == property)
    }
}

impl<const OF_TABLE: bool> Args for PropertyValues<OF_TABLE> {
    fn augment_args(command: Command) -> Command {
        let option = |name: &'static str| {
            Arg::new(name).long(name.replace('_', "-")).action(ArgAction::Append).value_delimiter(',')
        };
        let plain = Self::plain().map(|property| {
            option(property.name())
                .value_name(property.name().to_uppercase())
                .allow_negative_numbers(true)
                .conflicts_with_all((property == Property::GrainSize && !OF_TABLE).then_some("ssa"))
                .value_parser(move |word: &str| values(property, word))
                .help(format!("{}{}", property.parameter().describe(), help(property, OF_TABLE)))
        });
        let impurity = option(IMPURITY)
            .value_name("NAME=NG_G")
            .value_parser(|words: &str| impurity_axis(words, OF_TABLE))
            .help(format!(
                "{}, as black-carbon=10; several separated by commas or repeated: {}. {} also takes several \
             values of one, black-carbon=0:10:100{}",
                limits::described(&MASS_FRACTION),
                Substance::all().map(Substance::name).collect::<Vec<_>>().join(", "),
                if OF_TABLE { "An axis" } else { "spectrum" },
                if OF_TABLE { "" } else { OWN_PARTICLES }
            ));
        command.args(plain).arg(impurity).group(ArgGroup::new(Self::GROUP).multiple(true).args(Self::names()))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<const OF_TABLE: bool> FromArgMatches for PropertyValues<OF_TABLE> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let given = |property: Property| {
            let values = matches.get_many::<Vec<f64>>(property.name())?.cloned().collect();
            Some(PropertyAxis { property, values })
        };
        let mut all: Vec<PropertyAxis> = Self::plain().filter_map(given).collect();
        for axis in matches.get_many::<PropertyAxis>(IMPURITY).into_iter().flatten() {
            if all.iter().any(|other| other.property == axis.property) {
                let message = format!("impurity {} is given twice\n", axis.property.parameter().title);
                return Err(clap::Error::raw(clap::error::ErrorKind::ArgumentConflict, message));
            }
            all.push(axis.clone());
        }
        Ok(Self(all))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}
