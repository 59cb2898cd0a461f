//! Errors and exit codes: 2 for bad input, 1 for a failure of the work, 130 after an interrupt.

use std::fmt::Display;
use std::process::ExitCode;

use super::printable::printable;
use super::terminal::{print_message, unprinted};

/// Exit code after an interrupt, as a shell reports it: 128 plus the number of SIGINT.
pub(crate) const INTERRUPTED: u8 = 130;

/// Why a command ends before its work is done, as one line for the user.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The input is wrong: exit code 2.
    Input(String),
    /// The input is right, but the work failed: exit code 1.
    Work(String),
    /// The user or the system asked the command to end: exit code 130. Finished work has been saved.
    Interrupted(String),
    /// Help or version was printed: exit code 0.
    Printed,
}

/// The result of a command.
pub(crate) type Outcome = Result<(), Failure>;

/// Prints a failure to stderr, and returns the exit code.
pub(crate) fn exit_code(outcome: &Outcome) -> ExitCode {
    let (message, code) = match outcome {
        Ok(()) | Err(Failure::Printed) => return ExitCode::SUCCESS,
        Err(Failure::Work(message)) => (message, 1),
        Err(Failure::Input(message)) => (message, 2),
        Err(Failure::Interrupted(message)) => (message, INTERRUPTED),
    };
    print_message(&format!("snowblue: {}\n", printable(message)));
    ExitCode::from(code)
}

impl Failure {
    pub(crate) fn input(error: impl Display) -> Self {
        Self::Input(error.to_string())
    }

    pub(crate) fn work(error: impl Display) -> Self {
        Self::Work(error.to_string())
    }
}

/// Joins the lines of a message by clap: the error and its tips. The tip that an unknown option could be a value is
/// left out, because no argument takes such a value.
impl From<clap::Error> for Failure {
    fn from(error: clap::Error) -> Self {
        use clap::error::ErrorKind;
        let asked = matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion);
        if asked || error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
            return match error.print() {
                Ok(()) if asked => Self::Printed,
                Ok(()) => Self::Input(String::from("a command is missing")),
                Err(error) => Self::work(unprinted(&error)),
            };
        }
        let text = error.render().to_string();
        let mut lines =
            text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("tip: to pass '"));
        let mut message = lines.next().unwrap_or_default().trim_start_matches("error: ").to_owned();
        for line in lines.take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more")) {
            message.push_str(if line.starts_with("tip:") { "; " } else { " " });
            message.push_str(line.trim_start_matches("tip: "));
        }
        Self::Input(message)
    }
}
