//! `snowblue completions`: completions for a shell.

use clap::Args;
use clap_complete::Shell;

use crate::output::{Failure, Outcome, print};

/// Print completions for a shell
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  snowblue completions bash > ~/.local/share/bash-completion/completions/snowblue
  snowblue completions zsh > ~/.zfunc/_snowblue          a folder of $fpath
  snowblue completions fish > ~/.config/fish/completions/snowblue.fish")]
pub(crate) struct Completions {
    /// Shell that completes
    #[arg(value_name = "SHELL", value_enum)]
    shell: Shell,
}

impl Completions {
    /// Prints the completions of the program `snowblue`.
    pub(crate) fn run(&self, mut program: clap::Command) -> Outcome {
        let name = program.get_name().to_owned();
        let mut text = Vec::new();
        clap_complete::generate(self.shell, &mut program, name, &mut text);
        print(&String::from_utf8(text).map_err(Failure::work)?).map_err(Failure::work)
    }
}
