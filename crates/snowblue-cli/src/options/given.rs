//! Options that are given on the command line, as opposed to defaults.

use std::ffi::{OsStr, OsString};

use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches};

use crate::output::{Failure, Outcome};

/// The options that are given on the command line. The type defines no option. It must be the first field of its
/// command, because clap hands each value out once, and values that are handed out no longer count.
#[derive(Debug)]
pub(crate) struct GivenOptions(ArgMatches);

/// Options that have no effect in some case. A given option without effect is an error, because its value looks as if
/// it were in the result.
pub(crate) struct Idle<'a> {
    /// Whether this case applies.
    pub(crate) when: bool,
    /// The names of the options in Rust. An argument without a name on the command line has an id in capitals, as in
    /// the help.
    pub(crate) options: &'a [&'a str],
    /// The reason why the options have no effect, as in "--rays has no effect: WHY".
    pub(crate) why: &'a str,
}

impl GivenOptions {
    /// Whether an option is given, by its name in Rust. Debug builds panic if the command has no such option.
    pub(crate) fn has(&self, option: &str) -> bool {
        self.0.value_source(option) == Some(ValueSource::CommandLine)
    }

    /// The options of `command` that are given here, as words of a command line.
    pub(crate) fn words_of(&self, command: &Command) -> Vec<OsString> {
        let given = |argument: &Arg| {
            let (id, long) = (argument.get_id().as_str(), argument.get_long().unwrap_or_default().to_owned());
            let values = self.0.get_raw(id).filter(|_| self.has(id)).into_iter().flatten();
            let word = |value: &OsStr| {
                let mut word = OsString::from(format!("--{long}="));
                word.push(value);
                word
            };
            values.map(word).collect::<Vec<OsString>>()
        };
        command.get_arguments().flat_map(given).collect()
    }

    /// Refuses given options that have no effect.
    pub(crate) fn refuse_idle(&self, cases: &[Idle]) -> Outcome {
        for Idle { when, options, why } in cases {
            // All options are looked up even if all have an effect, so that every name is checked.
            let given: Vec<&&str> = options.iter().filter(|option| self.has(option)).collect();
            if let Some(option) = given.first().filter(|_| *when) {
                return Err(has_no_effect(option, why));
            }
        }
        Ok(())
    }
}

/// The error of a given option that has no effect.
pub(crate) fn has_no_effect(option: &str, why: &str) -> Failure {
    let is_positional = option.chars().all(|letter| letter.is_uppercase() || letter == '_');
    let name = if is_positional { option.to_owned() } else { format!("--{}", option.replace('_', "-")) };
    Failure::Input(format!("{name} has no effect: {why}"))
}

impl FromArgMatches for GivenOptions {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        Ok(Self(matches.clone()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for GivenOptions {
    fn augment_args(command: Command) -> Command {
        command
    }

    fn augment_args_for_update(command: Command) -> Command {
        command
    }
}
