//! A figure: its drawing, the numbers behind it and its captions.

use snowblue_transport::ordinates::OrdinatesOptions;

use crate::table::{Cell, DataTable, Metadata};

/// A figure that was computed and drawn.
#[derive(Debug, Clone)]
pub struct Figure {
    /// Its heading.
    pub title: &'static str,
    /// What we computed and what we find.
    pub ours: String,
    /// What the paper shows or says.
    pub paper: String,
    /// The drawing or the rendered pictures.
    pub drawing: Drawing,
    /// The numbers behind the drawing.
    pub numbers: DataTable,
    /// Short tables to read.
    pub tables: Vec<FigureTable>,
    /// Why a part of the figure is missing, if it is.
    pub warning: Option<String>,
}

/// What a figure shows.
#[derive(Debug, Clone)]
pub enum Drawing {
    /// One drawing, as the text of an SVG file.
    Svg(String),
    /// Rendered pictures, side by side.
    Renderings(Vec<Rendering>),
}

/// A rendered picture.
#[derive(Debug, Clone)]
pub struct Rendering {
    /// Suffix of its file name.
    pub name: String,
    /// The line below it.
    pub caption: String,
    /// The bytes of a PNG file.
    pub png: Vec<u8>,
}

/// A short table to read, with its title.
#[derive(Debug, Clone)]
pub struct FigureTable {
    /// Suffix of its file name.
    pub name: &'static str,
    /// Its heading.
    pub title: String,
    /// Its rows.
    pub data: DataTable,
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
    /// Files of the figure: NAME.svg or NAME_PICTURE.png, NAME.csv, and NAME_TABLE.csv for each table.
    pub fn files(&self, name: &str) -> Vec<FigureFile> {
        let file = |suffix: &str, bytes: Vec<u8>| FigureFile { name: format!("{name}{suffix}"), bytes };
        let mut files = match &self.drawing {
            Drawing::Svg(svg) => vec![file(".svg", svg.clone().into_bytes())],
            Drawing::Renderings(renderings) => renderings
                .iter()
                .map(|rendering| file(&format!("_{}.png", rendering.name), rendering.png.clone()))
                .collect(),
        };
        files.push(file(".csv", self.numbers.csv().into_bytes()));
        files.extend(
            self.tables.iter().map(|table| file(&format!("_{}.csv", table.name), table.data.csv().into_bytes())),
        );
        files
    }
}

impl FigureTable {
    /// A table whose numbers are already rounded words.
    pub(crate) fn of_words(name: &'static str, title: &str, columns: &[&'static str], rows: Vec<Vec<String>>) -> Self {
        let rows = rows.into_iter().map(|row| row.into_iter().map(Cell::Word).collect()).collect();
        Self { name, title: title.to_owned(), data: DataTable::new(columns, rows) }
    }
}

/// Name and version of the program that made a figure.
pub(crate) const SOFTWARE: &str = concat!("snowblue ", env!("CARGO_PKG_VERSION"));

/// Metadata of a figure by discrete ordinates, followed by `more`.
pub(crate) fn ordinates_metadata(more: &[(&'static str, &str)]) -> Metadata {
    let options = OrdinatesOptions::default();
    let mut metadata = vec![
        ("snowblue", env!("CARGO_PKG_VERSION").to_owned()),
        ("engine", format!("discrete ordinates, {} streams", options.streams)),
        ("seed", options.seed.to_string()),
    ];
    metadata.extend(more.iter().map(|(name, value)| (*name, (*value).to_owned())));
    metadata
}
