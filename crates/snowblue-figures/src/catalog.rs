//! All figures by name, and the HTML page that shows them.

use crate::figure::{Figure, FigureError, Picture};
use crate::paper;
use crate::table::{Cell, DataTable};

/// A figure's name, and how it is made.
#[derive(Debug, Clone, Copy)]
pub struct Recipe {
    /// Name, also of its files.
    pub name: &'static str,
    /// The paper's name of it.
    pub in_paper: &'static str,
    make: fn() -> Result<Figure, FigureError>,
}

impl Recipe {
    /// Computes and draws the figure.
    ///
    /// # Errors
    /// If a solution, a table, a colour or a rendering fails.
    pub fn make(&self) -> Result<Figure, FigureError> {
        (self.make)()
    }
}

/// All figures, in the order of the page.
pub const RECIPES: [Recipe; 9] = [
    Recipe { name: "table1", in_paper: "Table 1", make: paper::table1::figure },
    Recipe { name: "fig3", in_paper: "Fig. 3", make: paper::fig3::figure },
    Recipe { name: "fig5-8", in_paper: "Figs. 5–8", make: paper::fig5_8::figure },
    Recipe { name: "fig9", in_paper: "Fig. 9", make: paper::renderings::fig9 },
    Recipe { name: "fig10", in_paper: "Fig. 10", make: paper::renderings::fig10 },
    Recipe { name: "fig11", in_paper: "Fig. 11", make: paper::renderings::fig11 },
    Recipe { name: "s1", in_paper: "Fig. S1", make: paper::s1::figure },
    Recipe { name: "lprime", in_paper: "Sidebar", make: paper::lprime::figure },
    Recipe { name: "s2", in_paper: "Fig. S2", make: paper::s2::figure },
];

/// The recipes of these names, or all if none is given, in the order of [`RECIPES`].
///
/// # Errors
/// If a name is not known.
pub fn recipes(names: &[String]) -> Result<Vec<&'static Recipe>, FigureError> {
    let known = RECIPES.map(|recipe| recipe.name);
    if let Some(name) = names.iter().find(|name| !known.contains(&name.as_str())) {
        return Err(FigureError::UnknownFigure { name: name.clone(), known: known.join(", ") });
    }
    let asked = |recipe: &&Recipe| names.is_empty() || names.iter().any(|name| name == recipe.name);
    Ok(RECIPES.iter().filter(asked).collect())
}

const STYLE: &str = "body { margin: 3rem auto; max-width: 66rem; padding: 0 1rem; font: 1rem/1.5 sans-serif }
figure { margin: 0; display: grid; grid-template-columns: repeat(auto-fit, minmax(14rem, 1fr)); gap: 1rem }
img { max-width: 100% }
table { border-collapse: collapse }
th, td { padding: .2rem .8rem .2rem 0; text-align: right; border-bottom: 1px solid }
";

/// The text of the HTML page of figures. The page links to the files of the figures, which lie in its folder.
pub fn page(sections: &[(&Recipe, Figure)]) -> String {
    let content: String = sections.iter().map(|(recipe, figure)| section(recipe, figure)).collect();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>The blue of light through snow, \
         figure by figure</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>The blue of light through snow, \
         figure by figure</h1>\n<p>Computed by snowblue {}, after Varsa and Baranoski, “Rendering the Bluish \
         Appearance of Snow”, <a href=\"https://doi.org/10.1109/MCG.2023.3307517\">doi:10.1109/MCG.2023.3307517</a>. \
         </p>\n{content}</body>\n</html>\n",
        env!("CARGO_PKG_VERSION")
    )
}

fn section(recipe: &Recipe, figure: &Figure) -> String {
    let name = recipe.name;
    let picture = |Picture { suffix, caption, .. }: &Picture| {
        let caption = escaped(caption);
        format!("<div><img src=\"{name}{suffix}\" alt=\"{caption}\"><p>{caption}</p></div>\n")
    };
    let pictures: String = figure.pictures.iter().map(picture).collect();
    let table = figure.table.iter().map(|(title, data)| format!("<h3>{}</h3>\n{}", escaped(title), table(data)));
    let link = |file: String| format!("<a href=\"{file}\">{file}</a> ");
    let links: String = figure.files(name).into_iter().map(|file| link(file.name)).collect();
    format!(
        "<section id=\"{name}\">\n<h2>{}: {}</h2>\n<figure>\n{pictures}</figure>\n<p><b>Ours</b> {}</p>\n<p><b>The \
         paper</b> {}</p>\n{}<p>{links}</p>\n</section>\n",
        recipe.in_paper,
        escaped(figure.title),
        escaped(&figure.ours),
        escaped(figure.paper),
        table.collect::<String>()
    )
}

fn table(data: &DataTable) -> String {
    let line = |cells: &mut dyn Iterator<Item = String>, tag: &str| -> String {
        let cells: String = cells.map(|cell| format!("<{tag}>{}</{tag}>", escaped(&cell))).collect();
        format!("<tr>{cells}</tr>\n")
    };
    let header = line(&mut data.columns.iter().map(|name| (*name).to_owned()), "th");
    let rows: String = data.rows.iter().map(|row| line(&mut row.iter().map(Cell::text), "td")).collect();
    format!("<table>\n{header}{rows}</table>\n")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
