//! Why a command stops, and with which exit code: 2 for bad input, 1 for a failure at work, 130 where
//! it was told to.

use std::fmt::Display;
use std::process::ExitCode;

use crate::report::tell;

/// The exit code after an interrupt, as of a shell: 128 and the number of the signal that Ctrl-C sends.
pub(crate) const INTERRUPTED: u8 = 130;

/// One clear line for the user, and an exit code.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The input is at fault.
    Input(String),
    /// The input was good, but the work failed.
    Work(String),
    /// The user, or a cluster at the end of its time, wants the work to end; what there is has been kept.
    Interrupted(String),
    /// What was asked has been said (help, version), and all is well.
    Told,
}

/// What commands return.
pub(crate) type Outcome = Result<(), Failure>;

/// The exit code of the command; a failure is told first.
pub(crate) fn exit_code(outcome: &Outcome) -> ExitCode {
    outcome.as_ref().map_or_else(Failure::report, |()| ExitCode::SUCCESS)
}

impl Failure {
    pub(crate) fn input(error: impl Display) -> Self {
        Self::Input(error.to_string())
    }

    pub(crate) fn work(error: impl Display) -> Self {
        Self::Work(error.to_string())
    }

    /// Tells the user, and returns the exit code.
    fn report(&self) -> ExitCode {
        match self {
            Self::Told => ExitCode::SUCCESS,
            Self::Work(message) => {
                tell(&format!("snowblue: {message}\n"));
                ExitCode::from(1)
            }
            Self::Input(message) => {
                tell(&format!("snowblue: {message}\n"));
                ExitCode::from(2)
            }
            Self::Interrupted(message) => {
                tell(&format!("snowblue: {message}\n"));
                ExitCode::from(INTERRUPTED)
            }
        }
    }
}

/// clap's message in one line: what is wrong, and its advice.
impl From<clap::Error> for Failure {
    fn from(error: clap::Error) -> Self {
        use clap::error::ErrorKind;
        let asked = matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion);
        if asked || error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
            return match error.print() {
                Ok(()) if asked => Self::Told,
                Ok(()) => Self::Input(String::from("no command is given")),
                Err(error) => Self::work(error),
            };
        }
        let text = error.render().to_string();
        let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
        let mut message = lines.next().unwrap_or_default().trim_start_matches("error: ").to_owned();
        for line in lines.take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more")) {
            message.push_str(if line.starts_with("tip:") { "; " } else { " " });
            message.push_str(line.trim_start_matches("tip: "));
        }
        Self::Input(message)
    }
}
