//! `snowblue figures`: figures and tables of the validation, each as an SVG and a CSV, with a page that shows them.

mod albedo;
mod curves;
mod fig2;
mod fig3;
mod fig4;
mod fig5_8;
mod lprime;
mod microct;
mod page;
mod s1;
mod s2;
mod scenes;
mod simplifications;
mod table1;
mod truth;
mod truth_picture;
mod water;

use std::path::PathBuf;

use clap::Args;
use snowblue_color::{Colorimeter, Illuminant, LinearRgb, Observer, Xyz};
use snowblue_render::film::image_file;
use snowblue_render::swatch;
use snowblue_transport::ordinates::OrdinatesOptions;

use crate::failure::{Failure, Outcome};
use crate::progress::Progress;
use crate::report::{Cell, Report, check_place, print, write_file};

/// Every figure and table of the paper and of the validation, recomputed, into a folder
#[derive(Debug, Args)]
#[command(
    after_help = "Each figure NAME becomes NAME.svg, or NAME_PICTURE.png where scenes are rendered, and NAME.csv, each of its tables
NAME_TABLE.csv; index.html shows what was made. Tables are printed as well. Renderings (fig1, fig9, fig10, fig11, truth) take
some minutes, all others about one. fig11 needs models/dragon.ply, which scripts/fetch-models of the sources puts there.

Examples:
  snowblue figures -o figures
  snowblue figures -o figures --only water,albedo"
)]
pub(crate) struct Figures {
    /// Folder to write into, which is made if it is not there, in one that is
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Some figures only: table1, fig1, fig2, fig3, fig4, fig5-8, fig9, fig10, fig11, s1, lprime, s2, simplifications, water, albedo, microct, truth
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    only: Vec<String>,
    /// Times as many samples for the references of truth, whose noise falls with the root of it; 1 takes some 5 minutes of a core
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    truth_samples: u32,
}

/// A figure that was computed and drawn.
struct Figure {
    title: &'static str,
    /// What we computed and what we find.
    ours: String,
    /// What the paper shows or says of it.
    paper: String,
    drawing: Drawing,
    /// The numbers behind the drawing.
    numbers: Report,
    tables: Vec<Table>,
}

/// What there is to see of a figure.
enum Drawing {
    /// One drawing, as an SVG file.
    Svg(String),
    /// Rendered pictures, side by side.
    Pictures(Vec<Rendered>),
}

/// A rendered picture.
struct Rendered {
    /// Its file is that of the figure with this after a line.
    name: &'static str,
    caption: String,
    png: Vec<u8>,
}

/// A few numbers to read.
struct Table {
    name: &'static str,
    title: String,
    report: Report,
}

/// A figure's name and how it is made.
struct Recipe {
    name: &'static str,
    /// What of the paper it redraws, as the paper calls it; nothing for questions of our own.
    of: Option<&'static str>,
    make: fn(&Figures) -> Result<Figure, Failure>,
}

/// In the order of the page: the paper's, then ours.
const RECIPES: [Recipe; 17] = [
    Recipe { name: "table1", of: Some("Table 1"), make: |_| table1::figure() },
    Recipe { name: "fig1", of: Some("Fig. 1"), make: |_| scenes::fig1() },
    Recipe { name: "fig2", of: Some("Fig. 2"), make: |_| fig2::figure() },
    Recipe { name: "fig3", of: Some("Fig. 3"), make: |_| fig3::figure() },
    Recipe { name: "fig4", of: Some("Fig. 4"), make: |_| fig4::figure() },
    Recipe { name: "fig5-8", of: Some("Figs. 5–8"), make: |_| fig5_8::figure() },
    Recipe { name: "fig9", of: Some("Fig. 9"), make: |_| scenes::fig9() },
    Recipe { name: "fig10", of: Some("Fig. 10"), make: |_| scenes::fig10() },
    Recipe { name: "fig11", of: Some("Fig. 11"), make: |_| scenes::fig11() },
    Recipe { name: "s1", of: Some("Fig. S1"), make: |_| s1::figure() },
    Recipe { name: "lprime", of: Some("Sidebar"), make: |_| lprime::figure() },
    Recipe { name: "s2", of: Some("Fig. S2"), make: |_| s2::figure() },
    Recipe { name: "simplifications", of: None, make: |_| simplifications::figure() },
    Recipe { name: "water", of: None, make: |_| water::figure() },
    Recipe { name: "albedo", of: None, make: |_| albedo::figure() },
    Recipe { name: "microct", of: None, make: |_| microct::figure() },
    Recipe { name: "truth", of: None, make: |asked| truth::figure(asked.truth_samples) },
];

impl Figures {
    pub(crate) fn run(&self, quiet: bool) -> Outcome {
        let recipes = self.recipes()?;
        if !self.output.is_dir() {
            check_place(&self.output)?;
            let failed = |error| Failure::Input(format!("{}: cannot be a folder: {error}", self.output.display()));
            std::fs::create_dir(&self.output).map_err(failed)?;
        }
        let bar = Progress::new("figures", quiet);
        let mut figures = Vec::new();
        for (number, recipe) in recipes.iter().enumerate() {
            bar.at(number as u64, recipes.len() as u64);
            let figure = (recipe.make)(self)?;
            self.write(recipe.name, &figure)?;
            figures.push((*recipe, figure));
        }
        bar.end();
        write_file(&self.output.join("index.html"), page::index(&figures).as_bytes())?;
        for Table { title, report, .. } in figures.iter().flat_map(|(_, figure)| &figure.tables) {
            print(&format!("{title}\n{}\n", report.table()))?;
        }
        Ok(())
    }

    /// The figures that are asked for, in their own order.
    fn recipes(&self) -> Result<Vec<&'static Recipe>, Failure> {
        let names = RECIPES.map(|recipe| recipe.name);
        if let Some(name) = self.only.iter().find(|name| !names.contains(&name.as_str())) {
            return Err(Failure::Input(format!("figure '{name}' is not known; there are {}", names.join(", "))));
        }
        let asked = |recipe: &&Recipe| self.only.is_empty() || self.only.iter().any(|name| name == recipe.name);
        Ok(RECIPES.iter().filter(asked).collect())
    }

    fn write(&self, name: &str, figure: &Figure) -> Outcome {
        let place = |ending: &str| self.output.join(format!("{name}{ending}"));
        match &figure.drawing {
            Drawing::Svg(svg) => write_file(&place(".svg"), svg.as_bytes())?,
            Drawing::Pictures(pictures) => {
                for picture in pictures {
                    write_file(&place(&format!("_{}.png", picture.name)), &picture.png)?;
                }
            }
        }
        write_file(&place(".csv"), figure.numbers.csv().as_bytes())?;
        for table in &figure.tables {
            write_file(&place(&format!("_{}.csv", table.name)), table.report.csv().as_bytes())?;
        }
        Ok(())
    }
}

impl Table {
    /// A table whose numbers are already words of fit length.
    fn new(name: &'static str, title: &str, columns: &[&'static str], rows: Vec<Vec<String>>) -> Self {
        let rows = rows.into_iter().map(|row| row.into_iter().map(Cell::Word).collect()).collect();
        let report = Report { columns: columns.to_vec(), rows, metadata: Vec::new() };
        Self { name, title: title.to_owned(), report }
    }
}

/// Rows of numbers under their names.
fn numbers(columns: &[&'static str], rows: Vec<Vec<Cell>>) -> Report {
    Report { columns: columns.to_vec(), rows, metadata: Vec::new() }
}

/// What made a figure by ordinates.
fn provenance(more: &[(&'static str, &str)]) -> Vec<(&'static str, String)> {
    let options = OrdinatesOptions::default();
    let mut made = vec![
        ("snowblue", env!("CARGO_PKG_VERSION").to_owned()),
        ("engine", format!("discrete ordinates, {} streams", options.streams)),
        ("seed", options.seed.to_string()),
    ];
    made.extend(more.iter().map(|(name, value)| (*name, (*value).to_owned())));
    made
}

/// Evenly spaced wavelengths, in nm.
fn wavelengths_nm(first: u32, last: u32, step: usize) -> Vec<f64> {
    (first..=last).step_by(step).map(f64::from).collect()
}

/// The CIE 1931 observer under D65.
fn daylight(wavelengths_nm: &[f64]) -> Result<Colorimeter, Failure> {
    under(Illuminant::D65, wavelengths_nm)
}

/// The CIE 1931 observer under an illuminant.
fn under(illuminant: Illuminant, wavelengths_nm: &[f64]) -> Result<Colorimeter, Failure> {
    Colorimeter::new(Observer::Cie1931, illuminant, wavelengths_nm).map_err(Failure::work)
}

/// A light times a factor, under the grey texture of snow, as the bytes of a PNG file of a drawing's swatch.
fn textured(light: Xyz, factor: f64, (width, height): (u32, u32)) -> Result<Vec<u8>, Failure> {
    let picture = swatch::swatch(LinearRgb::from_xyz(light * factor), (width, height), Some(1));
    image_file::png_bytes(&picture, &[]).map_err(Failure::work)
}

/// The exposure that lights share: the brightest comes near white.
fn common_exposure(lights: impl Iterator<Item = Xyz>) -> f64 {
    let shown: Vec<LinearRgb> = lights.map(LinearRgb::from_xyz).collect();
    swatch::automatic_exposure(&shown)
}
