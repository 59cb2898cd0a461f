//! A figure: its pictures, the numbers behind them, its captions, and why it cannot be made.

use snowblue_color::ColorError;
use snowblue_database::DatabaseError;
use snowblue_render::{RenderError, SceneError};
use snowblue_transport::TransportError;

use crate::table::{DataTable, Metadata};

/// A figure that was computed and drawn.
#[derive(Debug, Clone)]
pub struct Figure {
    /// Its heading.
    pub title: &'static str,
    /// Description of our computation and its result.
    pub ours: String,
    /// Description of the paper's result.
    pub paper: &'static str,
    /// Drawings, or rendered pictures.
    pub pictures: Vec<Picture>,
    /// The numbers behind the pictures.
    pub numbers: DataTable,
    /// A short table to read, with its title.
    pub table: Option<(&'static str, DataTable)>,
    /// Why a part of the figure is missing, if it is.
    pub warning: Option<String>,
}

/// A drawing, or a rendered picture.
#[derive(Debug, Clone)]
pub struct Picture {
    /// Suffix of the figure's name in the name of the file: `.svg` or `_back_5.png`.
    pub suffix: String,
    /// The line below it.
    pub caption: String,
    /// Content of the file.
    pub bytes: Vec<u8>,
}

/// A file of a figure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FigureFile {
    /// Name without a folder.
    pub name: String,
    /// Content.
    pub bytes: Vec<u8>,
}

impl Figure {
    /// Files of the figure: NAME.svg or NAME_PICTURE.png, NAME.csv, and NAME_table.csv if it has a table.
    pub fn files(&self, name: &str) -> Vec<FigureFile> {
        let file = |suffix: &str, bytes: Vec<u8>| FigureFile { name: format!("{name}{suffix}"), bytes };
        let pictures = self.pictures.iter().map(|picture| file(&picture.suffix, picture.bytes.clone()));
        let table = self.table.iter().map(|(_, table)| file("_table.csv", table.csv().into_bytes()));
        pictures.chain([file(".csv", self.numbers.csv().into_bytes())]).chain(table).collect()
    }
}

impl Picture {
    /// A figure's only picture, from the text of an SVG file.
    pub(crate) fn drawing(svg: String) -> Vec<Self> {
        vec![Self { suffix: ".svg".to_owned(), caption: String::new(), bytes: svg.into_bytes() }]
    }
}

/// The program that made a figure, followed by `more`.
pub(crate) fn metadata(more: &[(&'static str, &str)]) -> Metadata {
    let made = [("snowblue", env!("CARGO_PKG_VERSION"))];
    made.iter().chain(more).map(|(name, value)| (*name, (*value).to_owned())).collect()
}

/// Why a figure cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// No figure has this name.
    #[error("figure '{name}' is not known; there are {known}")]
    UnknownFigure {
        /// The name that was asked for.
        name: String,
        /// All names, separated by commas.
        known: String,
    },
    /// A solution of the equation of transfer failed.
    #[error(transparent)]
    Transport(#[from] TransportError),
    /// A table or a look-up in it failed.
    #[error(transparent)]
    Database(#[from] DatabaseError),
    /// A colour could not be computed.
    #[error(transparent)]
    Color(#[from] ColorError),
    /// A scene could not be built.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A picture could not be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
}
