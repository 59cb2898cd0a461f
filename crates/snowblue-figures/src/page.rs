//! The HTML page of all figures: the paper's first, then ours, each with our caption and what the paper says.

use crate::catalog::Recipe;
use crate::figure::{Drawing, Figure, FigureTable, Rendering};
use crate::table::Cell;

const STYLE: &str = include_str!("page.css");
const PAPER: &str = "Petri M. Varsa and Gladimir V. G. Baranoski, “Rendering the Bluish Appearance of Snow: When Light \
                     Transmission Matters”, IEEE Computer Graphics and Applications 44 (1), 2024";
/// Columns with longer cells than this wrap.
const LONGEST_CELL: usize = 24;
const DOI: &str = "10.1109/MCG.2023.3307517";

/// A figure and its recipe.
#[derive(Debug)]
pub struct Section {
    /// How it is made, with its name.
    pub recipe: &'static Recipe,
    /// The figure.
    pub figure: Figure,
}

/// The text of the HTML page. It links to the files of the figures, in the same folder.
pub fn index(sections: &[Section]) -> String {
    let content: String = sections.iter().map(section_html).collect();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n <meta name=\"viewport\" \
         content=\"width=device-width, initial-scale=1\">\n<title>Figures of snowblue</title>\n \
         <style>\n{STYLE}</style>\n</head>\n<body>\n<header>\n<h1>The blue of light through snow, figure by \
         figure</h1>\n <p>Everything here is computed by snowblue {version}, from its engines and its tables of \
         constants alone. Beside it stands what the paper shows or says: {PAPER}, <a \
         href=\"https://doi.org/{DOI}\">doi:{DOI}</a>.</p>\n</header>\n <nav \
         aria-label=\"Contents\">\n{contents}</nav>\n<main>\n{content}</main>\n</body>\n</html>\n",
        version = env!("CARGO_PKG_VERSION"),
        contents = contents(sections, true) + &contents(sections, false),
    )
}

/// Links to the figures of the paper, or to those beyond it.
fn contents(sections: &[Section], is_in_paper: bool) -> String {
    let link = |Section { recipe, figure }: &Section| {
        format!("<li>{}<a href=\"#{}\">{}</a></li>\n", label(recipe), recipe.name, escaped(figure.title))
    };
    let links: String =
        sections.iter().filter(|section| section.recipe.in_paper.is_some() == is_in_paper).map(link).collect();
    let (title, kind) = if is_in_paper { ("The paper, recomputed", "paper") } else { ("Beyond the paper", "beyond") };
    if links.is_empty() {
        return String::new();
    }
    format!("<div>\n<h2>{title}</h2>\n<ul class=\"{kind}\">\n{links}</ul>\n</div>\n")
}

/// The paper's name of a figure.
fn label(recipe: &Recipe) -> String {
    recipe.in_paper.map_or_else(String::new, |name| format!("<span class=\"of\">{name}</span>"))
}

fn section_html(Section { recipe, figure }: &Section) -> String {
    let name = recipe.name;
    let tables: String = figure.tables.iter().map(table).collect();
    let files = figure.tables.iter().map(|table| format!("{name}_{}.csv", table.name));
    let DrawingHtml { html: drawing, files: drawn } = drawing(name, figure);
    let links: Vec<String> = drawn
        .into_iter()
        .chain([format!("{name}.csv")])
        .chain(files)
        .map(|file| format!("<a href=\"{file}\">{file}</a>"))
        .collect();
    format!(
        "<section id=\"{name}\">\n<h2>{of}{title}</h2>\n<figure>\n{drawing}<figcaption>\n\
         <dl>\n<dt>Ours</dt><dd>{ours}</dd>\n<dt>The paper</dt><dd>{paper}</dd>\n</dl>\n</figcaption>\n</figure>\n\
         {tables}<p class=\"files\">{links}</p>\n</section>\n",
        of = label(recipe),
        title = escaped(figure.title),
        ours = escaped(&figure.ours),
        paper = escaped(&figure.paper),
        links = links.join(" · ")
    )
}

/// HTML of a drawing, and the names of its files.
struct DrawingHtml {
    html: String,
    files: Vec<String>,
}

fn drawing(name: &str, figure: &Figure) -> DrawingHtml {
    match &figure.drawing {
        Drawing::Svg(_) => {
            let title = escaped(figure.title);
            DrawingHtml {
                html: format!("<img src=\"{name}.svg\" alt=\"{title}\">\n"),
                files: vec![format!("{name}.svg")],
            }
        }
        Drawing::Renderings(pictures) => {
            let file = |picture: &Rendering| format!("{name}_{}.png", picture.name);
            let shown = |picture: &Rendering| {
                let (file, caption) = (file(picture), escaped(&picture.caption));
                format!("<div><img src=\"{file}\" alt=\"{caption}\"><p>{caption}</p></div>\n")
            };
            let shown: String = pictures.iter().map(shown).collect();
            DrawingHtml {
                html: format!("<div class=\"pictures\">\n{shown}</div>\n"),
                files: pictures.iter().map(file).collect(),
            }
        }
    }
}

fn table(table: &FigureTable) -> String {
    let columns = table.data.columns.iter().map(|name| (*name).to_owned()).collect();
    let rows: Vec<Vec<String>> = table.data.rows.iter().map(|row| row.iter().map(Cell::text).collect()).collect();
    let wordy = |column: usize| rows.iter().any(|row| row[column].chars().count() > LONGEST_CELL);
    let line = |cells: &Vec<String>, tag: &str| -> String {
        let cell = |(column, cell): (usize, &String)| {
            let class = if wordy(column) { " class=\"words\"" } else { "" };
            format!("<{tag}{class}>{}</{tag}>", escaped(cell))
        };
        format!("<tr>{}</tr>\n", cells.iter().enumerate().map(cell).collect::<String>())
    };
    format!(
        "<h3>{}</h3>\n<div class=\"wide\">\n<table>\n<thead>\n{}</thead>\n<tbody>\n{}</tbody>\n</table>\n</div>\n",
        escaped(&table.title),
        line(&columns, "th"),
        rows.iter().map(|row| line(row, "td")).collect::<String>()
    )
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
