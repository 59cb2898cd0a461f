//! `snowblue figures`: the results of the paper, recomputed, with a page that shows them.

use std::path::PathBuf;

use clap::Args;
use snowblue_figures::{FigureFile, RECIPES, page, recipes};

use crate::output::{Failure, Outcome, Progress, create_folder, print, print_message, write_file};

/// Recompute what the paper measures: its figures, tables and claims
#[derive(Debug, Args)]
#[command(
    after_help = "Each figure NAME is written as NAME.svg, or NAME_PICTURE.png for renderings, with its numbers in \
NAME.csv and its table in NAME_table.csv; index.html shows all of them. Tables are also printed. The renderings (fig9, \
fig10, fig11) take some minutes, all others together about one. fig11 needs models/dragon.ply, which \
scripts/fetch-models of the sources downloads.

Examples:
  snowblue figures -o figures
  snowblue figures -o figures --only s1,lprime"
)]
pub(crate) struct Figures {
    /// Folder to write to; created if it does not exist
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    #[arg(
        long, value_name = "NAMES", value_delimiter = ',', help = format!(
            "Only these figures, separated by commas: {}", RECIPES.map(|recipe| recipe.name).join(", ")
        )
    )]
    only: Vec<String>,
}

impl Figures {
    pub(crate) fn run(&self, quiet: bool) -> Outcome {
        let recipes = recipes(&self.only).map_err(Failure::input)?;
        create_folder(&self.output)?;
        let bar = Progress::new("figures", quiet);
        let mut made = Vec::new();
        for (number, &recipe) in recipes.iter().enumerate() {
            bar.set(number as u64, recipes.len() as u64);
            let figure = recipe.make().map_err(Failure::work)?;
            for FigureFile { name, bytes } in figure.files(recipe.name) {
                write_file(&self.output.join(name), &bytes)?;
            }
            if let Some(warning) = &figure.warning {
                print_message(&format!("{}: {warning}\n", recipe.name));
            }
            made.push((recipe, figure));
        }
        bar.finish();
        write_file(&self.output.join("index.html"), page(&made).as_bytes())?;
        for (title, table) in made.iter().filter_map(|(_, figure)| figure.table.as_ref()) {
            print(&format!("{title}\n{}\n", table.text())).map_err(Failure::work)?;
        }
        Ok(())
    }
}
