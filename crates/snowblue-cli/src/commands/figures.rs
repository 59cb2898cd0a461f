//! `snowblue figures`: figures and tables of the paper and of the validation, with a page that shows them.

use std::path::PathBuf;

use clap::Args;
use snowblue_figures::page::{self, Section};
use snowblue_figures::{FigureFile, FigureOptions, recipes};

use crate::options::{GivenOptions, Idle, parse};
use crate::output::{Failure, Outcome, Progress, create_folder, print, print_message, write_file};

/// Recompute the figures and tables of the paper and of the validation
#[derive(Debug, Args)]
#[command(
    after_help = "Each figure NAME is written as NAME.svg, or NAME_PICTURE.png for renderings, with its numbers in \
NAME.csv and its tables in NAME_TABLE.csv; index.html shows all of them. Tables are also printed. The renderings \
(fig1, fig9, fig10, fig11, truth) take some minutes, all others together about one. fig11 needs models/dragon.ply, \
which scripts/fetch-models of the sources downloads.

Examples:
  snowblue figures -o figures
  snowblue figures -o figures --only water,albedo"
)]
pub(crate) struct Figures {
    /// Must be the first field.
    #[command(flatten)]
    given: GivenOptions,
    /// Folder to write to; created if it does not exist
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Only these figures, separated by commas: table1, fig1, fig2, fig3, fig4, fig5-8, fig9, fig10, fig11, s1, lprime,
    /// s2, simplifications, water, albedo, microct, truth
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    only: Vec<String>,
    /// Factor on the samples of the references of truth, whose noise falls with its square root [1–1000]; 1 takes about
    /// 5 minutes on one core
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = parse::whole_number::<u32>(1..=1000))]
    truth_samples: u32,
}

impl Figures {
    pub(crate) fn run(&self, quiet: bool) -> Outcome {
        let recipes = recipes(&self.only).map_err(Failure::input)?;
        self.given.refuse_idle(&[Idle {
            when: !recipes.iter().any(|recipe| recipe.name == "truth"),
            options: &["truth_samples"],
            why: "--only leaves truth out",
        }])?;
        create_folder(&self.output)?;
        let options = FigureOptions { reference_samples: self.truth_samples };
        let bar = Progress::new("figures", quiet);
        let mut sections = Vec::new();
        for (number, &recipe) in recipes.iter().enumerate() {
            bar.set(number as u64, recipes.len() as u64);
            let figure = recipe.make(options).map_err(Failure::work)?;
            for FigureFile { name, bytes } in figure.files(recipe.name) {
                write_file(&self.output.join(name), &bytes)?;
            }
            if let Some(warning) = &figure.warning {
                print_message(&format!("{}: {warning}\n", recipe.name));
            }
            sections.push(Section { recipe, figure });
        }
        bar.finish();
        write_file(&self.output.join("index.html"), page::index(&sections).as_bytes())?;
        for table in sections.iter().flat_map(|section| &section.figure.tables) {
            print(&format!("{}\n{}\n", table.title, table.data.text())).map_err(Failure::work)?;
        }
        Ok(())
    }
}
