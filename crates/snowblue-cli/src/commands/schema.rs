//! `snowblue schema`: JSON Schemas of the files that the program reads.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use snowblue_base::schema::json_schema;
use snowblue_render::SceneDescription;
use snowblue_transport::layer_file::LayerFileKeys;

use crate::output::{Failure, Outcome, print, write_file};

/// Write the JSON Schema of a kind of file, by which an editor completes keys, shows units and marks mistakes
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  snowblue schema scene -o scene.schema.json    then begin my.toml with '#:schema scene.schema.json'
  snowblue schema layers -o layers.schema.json

Editors read the line with an extension for TOML, such as Even Better TOML of Visual Studio Code, or taplo.")]
pub(crate) struct Schema {
    /// Kind of file
    #[arg(value_name = "KIND", value_enum)]
    kind: Kind,
    /// File to write [default: print it]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// A kind of file.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Kind {
    /// Scenes for 'render' and 'bake'
    Scene,
    /// Layers for 'spectrum --layers' and for snow in scenes
    Layers,
}

impl Schema {
    pub(crate) fn run(&self) -> Outcome {
        let schema = match self.kind {
            Kind::Scene => json_schema::<SceneDescription>(),
            Kind::Layers => json_schema::<LayerFileKeys>(),
        };
        let text = format!("{schema:#}\n");
        match &self.output {
            Some(path) => write_file(path, text.as_bytes()),
            None => print(&text).map_err(Failure::work),
        }
    }
}
