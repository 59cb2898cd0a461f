//! The page that shows figures with their captions and tables.

use super::{Figure, Table};

const STYLE: &str = "body{font:16px/1.5 system-ui,sans-serif;color:#1f2933;max-width:60rem;margin:2rem auto;padding:0 1rem}\
img{max-width:100%;height:auto}table{border-collapse:collapse;margin:.5rem 0 1.5rem;font-variant-numeric:tabular-nums}\
th,td{padding:.15rem .7rem;text-align:right;border-bottom:1px solid #e1e6eb}th:first-child,td:first-child{text-align:left}";

/// One page of HTML.
pub(super) fn index(figures: &[(&str, Figure)]) -> String {
    let sections: String = figures.iter().map(|(name, figure)| section(name, figure)).collect();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>Figures of snowblue {version}</title>\n\
         <style>{STYLE}</style>\n<h1>Figures of snowblue {version}</h1>\n{sections}</html>\n",
        version = env!("CARGO_PKG_VERSION")
    )
}

fn section(name: &str, figure: &Figure) -> String {
    let tables: String = figure.tables.iter().map(table).collect();
    let files = figure.tables.iter().map(|table| format!("{name}_{}.csv", table.name));
    let links: Vec<String> = std::iter::once(format!("{name}.csv"))
        .chain(files)
        .map(|file| format!("<a href=\"{file}\">{file}</a>"))
        .collect();
    format!(
        "<h2 id=\"{name}\">{title}</h2>\n<img src=\"{name}.svg\" alt=\"{title}\">\n<p>{caption}</p>\n{tables}<p>{links}</p>\n",
        title = escaped(figure.title),
        caption = escaped(&figure.caption),
        links = links.join(" · ")
    )
}

fn table(table: &Table) -> String {
    let line = |cells: Vec<String>, tag: &str| -> String {
        let cells: String = cells.iter().map(|cell| format!("<{tag}>{}</{tag}>", escaped(cell))).collect();
        format!("<tr>{cells}</tr>\n")
    };
    let head = line(table.report.columns.iter().map(|name| (*name).to_owned()).collect(), "th");
    let rows: String =
        table.report.rows.iter().map(|row| line(row.iter().map(crate::report::Cell::text).collect(), "td")).collect();
    format!("<h3>{}</h3>\n<table>\n{head}{rows}</table>\n", escaped(&table.title))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
