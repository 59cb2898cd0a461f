//! The choice of l', the number of principal components: errors of each number, by the paper's two criteria.

use snowblue_color::Illuminant;
use snowblue_database::fidelity::{Fidelity, PERCEPTIBLE_DELTA_E, Spread, evaluate};
use snowblue_database::pca::Decomposition;
use snowblue_database::{DatabaseError, Quantity, Space, Table as SnowTable};

use super::paper_table::paper_table;
use crate::error::FigureError;
use crate::figure::{Drawing, Figure, FigureTable};
use crate::plot::{Area, Axis, Chart, Entry, GREY, INK, Stroke, Symbol};
use crate::table::{Cell, DataTable};

const MOST: usize = 8;
/// The paper's number of components.
const PAPER: usize = 2;
/// The paper's bound on its RMSE.
const PAPER_RMSE: f64 = 0.002;
const SPACES: [Space; 2] = [Space::Linear, Space::Log];
const COLOURS: [&str; 2] = ["#d1495b", "#1f6feb"];
const LIMIT: Stroke = Stroke { colour: INK, width: 1.2, dashes: "" };

pub(crate) fn figure() -> Result<Figure, FigureError> {
    let table = paper_table()?;
    let found = [judged(table, Space::Linear)?, judged(table, Space::Log)?];
    let rows = SPACES.iter().zip(&found).flat_map(|(space, found)| {
        found.iter().enumerate().map(|(i, fidelity)| {
            let mut row = vec![Cell::Word(space.name().to_owned()), (i as f64 + 1.0).into()];
            let Fidelity { rmse, delta_e, perceptible_fraction, negative_values } = fidelity;
            let spreads =
                [rmse, delta_e].into_iter().flat_map(|spread| [spread.worst, spread.percentile_99, spread.mean]);
            row.extend(spreads.chain([*perceptible_fraction, *negative_values as f64]).map(Cell::from));
            row
        })
    });
    let columns = [
        "space",
        "components",
        "rmse_worst",
        "rmse_p99",
        "rmse_mean",
        "delta_e_worst",
        "delta_e_p99",
        "delta_e_mean",
        "fraction_above_2.3",
        "negative_values",
    ];
    Ok(Figure {
        title: "The choice of l', the number of principal components",
        ours: words(&found, table.axes.curves()),
        paper:
            "Chose the least l' for which every curve's ΔE*ab is below 2.3, and found l' = 2; RMSE was below .002. Its \
                text gives neither the illuminant nor the white of these colours."
                .to_owned(),
        drawing: Drawing::Svg(draw(&found, table.axes.curves())),
        numbers: DataTable::new(&columns, rows.collect()),
        tables: vec![costs(&found, table.axes.curves())],
        warning: None,
    })
}

/// Errors of 1–8 components in a space.
fn judged(table: &SnowTable, space: Space) -> Result<Vec<Fidelity>, FigureError> {
    let decomposition = Decomposition::new(table, Quantity::Transmittance, space)?;
    let judged = |count| {
        let components = decomposition.keep(table, Quantity::Transmittance, count)?;
        evaluate(table, Quantity::Transmittance, &components, space, Some(Illuminant::D65))
    };
    Ok((1..=MOST).map(judged).collect::<Result<_, DatabaseError>>()?)
}

fn words(found: &[Vec<Fidelity>; 2], curves: usize) -> String {
    let fewest = |found: &[Fidelity]| {
        let kept =
            |fidelity: &Fidelity| fidelity.delta_e.worst < PERCEPTIBLE_DELTA_E && fidelity.rmse.worst < PAPER_RMSE;
        found.iter().position(kept).map_or_else(|| format!("more than {MOST}"), |index| (index + 1).to_string())
    };
    let two = &found[0][PAPER - 1];
    format!(
        "All {curves} curves under D65 (CIE 1931, with the illuminant as white). With l' = {PAPER} in linear space the \
         worst curve differs by ΔE*ab = {:.2} and RMSE = {:.4}, the mean by {:.2}; {:.2} % of the curves exceed 2.3 \
         and {} values are negative. Both criteria hold for every curve from l' = {} in linear space, and from l' = {} \
         for the logarithms, which are never negative.",
        two.delta_e.worst,
        two.rmse.worst,
        two.delta_e.mean,
        100.0 * two.perceptible_fraction,
        two.negative_values,
        fewest(&found[0]),
        fewest(&found[1]),
    )
}

fn costs(found: &[Vec<Fidelity>; 2], curves: usize) -> FigureTable {
    let row = |space: Space, count: usize, fidelity: &Fidelity| {
        let mut cells = vec![format!("{} {count}", space.name())];
        cells.extend(
            [fidelity.delta_e.worst, fidelity.delta_e.percentile_99, fidelity.delta_e.mean]
                .map(|value| format!("{value:.3}")),
        );
        cells.push(format!("{:.2}", 100.0 * fidelity.perceptible_fraction));
        cells.extend(
            [fidelity.rmse.worst, fidelity.rmse.percentile_99, fidelity.rmse.mean].map(|value| format!("{value:.1e}")),
        );
        cells.push(fidelity.negative_values.to_string());
        cells
    };
    let rows = SPACES.iter().zip(found).flat_map(|(space, found)| {
        found.iter().enumerate().map(|(i, fidelity)| row(*space, i + 1, fidelity)).collect::<Vec<_>>()
    });
    let columns =
        ["l'", "ΔE worst", "ΔE 99 %", "ΔE mean", "% above 2.3", "RMSE worst", "RMSE 99 %", "RMSE mean", "negative"];
    let title = format!("Errors of l' components, over {curves} curves of transmittance under D65");
    FigureTable::of_words("costs", &title, &columns, rows.collect())
}

type Measure = fn(&Fidelity) -> &Spread;

fn draw(found: &[Vec<Fidelity>; 2], curves: usize) -> String {
    let mut chart = Chart::new(1120.0, 460.0, "Errors of l' principal components");
    let measures: [(&str, f64, Measure); 2] = [
        ("ΔE*ab under D65", PERCEPTIBLE_DELTA_E, |fidelity| &fidelity.delta_e),
        ("RMSE of transmittance", PAPER_RMSE, |fidelity| &fidelity.rmse),
    ];
    let counts = || Axis::linear(1.0, MOST as f64, MOST as f64 - 1.0);
    let area = |index: usize| {
        let left = 92.0 + 305.0 * index as f64;
        Area { left, right: left + 215.0, top: 66.0, bottom: 370.0 }
    };
    for (index, (name, limit, measure)) in measures.into_iter().enumerate() {
        let values =
            || found.iter().flatten().map(measure).flat_map(|spread| [spread.worst, spread.percentile_99, spread.mean]);
        let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max));
        let decade = |value: f64| 10_f64.powf(value);
        let y = Axis::logarithmic(decade(low.log10().floor()), decade(high.log10().ceil()));
        let panel = chart.panel(area(index), [counts(), y], ["l', number of components", name]);
        chart.line(&panel, &[(1.0, limit), (MOST as f64, limit)], LIMIT);
        for (colour, found) in COLOURS.iter().zip(found) {
            let points = |of: fn(&Spread) -> f64| -> Vec<(f64, f64)> {
                found.iter().enumerate().map(|(i, fidelity)| (i as f64 + 1.0, of(measure(fidelity)))).collect()
            };
            chart.line(&panel, &points(|spread| spread.worst), Stroke::solid(colour, 2.2));
            chart.line(&panel, &points(|spread| spread.percentile_99), Stroke { colour, width: 1.6, dashes: "7 4" });
            chart.line(&panel, &points(|spread| spread.mean), Stroke { colour, width: 1.6, dashes: "2 3" });
            chart.dots(&panel, &points(|spread| spread.worst), colour);
        }
    }
    let fractions = chart.panel(
        area(2),
        [counts(), Axis::linear(0.0, 100.0, 5.0)],
        ["l', number of components", "Curves above ΔE*ab 2.3 (%)"],
    );
    for (colour, found) in COLOURS.iter().zip(found) {
        let point = |(i, fidelity): (usize, &Fidelity)| (i as f64 + 1.0, 100.0 * fidelity.perceptible_fraction);
        let points: Vec<(f64, f64)> = found.iter().enumerate().map(point).collect();
        chart.line(&fractions, &points, Stroke::solid(colour, 2.2));
        chart.dots(&fractions, &points, colour);
    }
    legend(&mut chart);
    let made = [
        ("snowblue", env!("CARGO_PKG_VERSION").to_owned()),
        ("engine", "discrete ordinates, automatic streams".to_owned()),
        ("curves", curves.to_string()),
        ("light", "D65, CIE 1931".to_owned()),
        ("numbers", "ours".to_owned()),
        ("limits", "the paper's".to_owned()),
    ];
    chart.finish(&made)
}

fn legend(chart: &mut Chart) {
    let x = 945.0;
    let spaces = [("linear", COLOURS[0]), ("log", COLOURS[1])];
    let spaces = spaces.map(|(name, colour)| Entry { name, symbol: Symbol::Line(Stroke::solid(colour, 2.4)) });
    let y = chart.legend((x, 80.0), "Space", &spaces);
    let line = |name, width, dashes| Entry { name, symbol: Symbol::Line(Stroke { colour: GREY, width, dashes }) };
    let statistics = [line("worst", 2.2, ""), line("99 %", 1.6, "7 4"), line("mean", 1.6, "2 3")];
    let y = chart.legend((x, y + 6.0), "Over curves", &statistics);
    chart.legend((x, y + 6.0), "", &[Entry { name: "the paper's limit", symbol: Symbol::Line(LIMIT) }]);
}
