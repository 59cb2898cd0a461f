//! `snowblue man`: manual pages.

use std::path::PathBuf;

use clap::{Args, Command};
use clap_mangen::Man as Page;

use crate::output::{Failure, Outcome, create_folder, print, write_file};

/// Write the manual pages
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  snowblue man | man -l -                                 the page of the program
  snowblue man -o ~/.local/share/man/man1                 a page for each command, such as snowblue-render(1)")]
pub(crate) struct Man {
    /// Folder to write a page for the program and for each command to; created if it does not exist [default: print the
    /// page of the program]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

impl Man {
    /// Writes the pages of the program `snowblue`.
    pub(crate) fn run(&self, program: Command) -> Outcome {
        let mut program = program.disable_help_subcommand(true);
        program.build();
        let Some(folder) = &self.output else {
            return print(&String::from_utf8(page(program)?).map_err(Failure::work)?).map_err(Failure::work);
        };
        create_folder(folder)?;
        let mut commands = vec![program];
        while let Some(command) = commands.pop() {
            commands.extend(command.get_subcommands().cloned());
            write_file(&folder.join(Page::new(command.clone()).get_filename()), &page(command)?)?;
        }
        Ok(())
    }
}

fn page(command: Command) -> Result<Vec<u8>, Failure> {
    let mut text = Vec::new();
    let source = concat!("snowblue ", env!("CARGO_PKG_VERSION"));
    Page::new(command).source(source).render(&mut text).map_err(Failure::work)?;
    Ok(text)
}
