//! Options that are given on the command line, as opposed to defaults.

use clap::parser::ValueSource;
use clap::{ArgMatches, Args, Command, FromArgMatches};

use crate::output::{Failure, Outcome};

/// Names of the options on the command line. It defines no option. It must be the first field of its command: clap
/// hands each value out once, and values that are handed out no longer count.
#[derive(Debug)]
pub(crate) struct GivenOptions(Vec<String>);

/// Options that have no effect in some case. An option that is given and has none is an error: its value looks as if it
/// were in the result.
pub(crate) struct Idle<'a> {
    /// Whether this is the case.
    pub(crate) when: bool,
    /// Their names in Rust.
    pub(crate) options: &'a [&'a str],
    /// Why they have no effect, as in "--rays has no effect: WHY".
    pub(crate) why: &'a str,
}

impl GivenOptions {
    pub(crate) fn has(&self, option: &str) -> bool {
        self.0.iter().any(|given| given == option)
    }

    /// Refuses given options that have no effect.
    pub(crate) fn refuse_idle(&self, cases: &[Idle]) -> Outcome {
        let mut idle =
            cases.iter().filter(|case| case.when).flat_map(|case| case.options.iter().map(|one| (one, case.why)));
        match idle.find(|(option, _)| self.has(option)) {
            Some((option, why)) => Err(Failure::Input(format!("--{} has no effect: {why}", option.replace('_', "-")))),
            None => Ok(()),
        }
    }
}

impl FromArgMatches for GivenOptions {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let given = matches.ids().filter(|id| matches.value_source(id.as_str()) == Some(ValueSource::CommandLine));
        Ok(Self(given.map(|id| id.as_str().to_owned()).collect()))
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
