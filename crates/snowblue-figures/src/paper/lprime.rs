//! The choice of l', the number of principal components: errors of each number, by the paper's two criteria.

use snowblue_color::Illuminant;
use snowblue_database::fidelity::{Fidelity, PERCEPTIBLE_DELTA_E, Spread, evaluate};
use snowblue_database::pca::Decomposition;
use snowblue_database::{DatabaseError, Quantity, Space, Table};

use super::paper_table::paper_table;
use crate::figure::{Figure, FigureError, Picture, metadata};
use crate::plot::{Area, Axis, Chart, GREY, INK, Stroke};
use crate::table::{Cell, DataTable};

const MOST: usize = 8;
/// The paper's bound on its RMSE.
const PAPER_RMSE: f64 = 0.002;
const SPACES: [Space; 2] = [Space::Linear, Space::Log];
const COLOURS: [&str; 2] = ["#d1495b", "#1f6feb"];
const LIMIT: Stroke = Stroke { colour: INK, width: 1.2, dashes: "" };

const PAPER: &str = "Chose the least l' for which every curve's ΔE*ab is below 2.3, and found l' = 2, with RMSE below \
    .002. Its text gives neither the illuminant nor the white of these colours.";

/// Errors of 1–8 components in both spaces.
type Judged = [Vec<Fidelity>; 2];

pub(crate) fn figure() -> Result<Figure, FigureError> {
    let table = paper_table()?;
    let found = [judged(table, Space::Linear)?, judged(table, Space::Log)?];
    let row = |space: Space, (number, fidelity): (usize, &Fidelity)| {
        let Fidelity { rmse, delta_e, perceptible_fraction, negative_values } = fidelity;
        let spreads = [delta_e, rmse].into_iter().flat_map(|spread| [spread.worst, spread.percentile_99, spread.mean]);
        let numbers = [number as f64 + 1.0].into_iter().chain(spreads);
        let numbers = numbers.chain([*perceptible_fraction, *negative_values as f64]).map(Cell::from);
        [Cell::word(space.name())].into_iter().chain(numbers).collect()
    };
    let rows = SPACES.iter().zip(&found).flat_map(|(space, of)| of.iter().enumerate().map(|one| row(*space, one)));
    let columns = [
        "space",
        "components",
        "delta_e_worst",
        "delta_e_p99",
        "delta_e_mean",
        "rmse_worst",
        "rmse_p99",
        "rmse_mean",
        "fraction_above_2.3",
        "negative_values",
    ];
    let numbers = DataTable::new(&columns, rows.collect());
    Ok(Figure {
        title: "The choice of l', the number of principal components",
        ours: words(&found, table.axes.curves()),
        paper: PAPER,
        pictures: Picture::drawing(draw(&found, table.axes.curves())),
        table: Some(("Errors of l' components of transmittance under D65", numbers.rounded(3))),
        numbers,
        warning: None,
    })
}

fn judged(table: &Table, space: Space) -> Result<Vec<Fidelity>, FigureError> {
    let decomposition = Decomposition::new(table, Quantity::Transmittance, space)?;
    let judged = |count| {
        let components = decomposition.keep(table, Quantity::Transmittance, count)?;
        evaluate(table, Quantity::Transmittance, &components, space, Some(Illuminant::D65))
    };
    Ok((1..=MOST).map(judged).collect::<Result<_, DatabaseError>>()?)
}

fn words(found: &Judged, curves: usize) -> String {
    let fewest = |found: &[Fidelity]| {
        let is_enough =
            |fidelity: &Fidelity| fidelity.delta_e.worst < PERCEPTIBLE_DELTA_E && fidelity.rmse.worst < PAPER_RMSE;
        found.iter().position(is_enough).map_or_else(|| format!("more than {MOST}"), |index| (index + 1).to_string())
    };
    let two = &found[0][1];
    format!(
        "All {curves} curves under D65. With l' = 2 in linear space the worst curve differs by ΔE*ab = {:.2} and RMSE \
         = {:.4}. Both criteria hold for every curve from l' = {} in linear space, and from l' = {} for logarithms.",
        two.delta_e.worst,
        two.rmse.worst,
        fewest(&found[0]),
        fewest(&found[1]),
    )
}

type Measure = fn(&Fidelity) -> &Spread;

fn draw(found: &Judged, curves: usize) -> String {
    let mut chart = Chart::new(900.0, 460.0, "Errors of l' principal components");
    let measures: [(&str, f64, Measure); 2] = [
        ("ΔE*ab under D65", PERCEPTIBLE_DELTA_E, |fidelity| &fidelity.delta_e),
        ("RMSE of transmittance", PAPER_RMSE, |fidelity| &fidelity.rmse),
    ];
    for ((name, limit, measure), left) in measures.into_iter().zip([92.0, 440.0]) {
        let spreads = || found.iter().flatten().map(measure);
        let low = spreads().map(|spread| spread.mean).fold(f64::INFINITY, f64::min).log10().floor();
        let high = spreads().map(|spread| spread.worst).fold(0.0, f64::max).log10().ceil();
        let axes = [Axis::linear(1.0, MOST as f64, 7.0), Axis::logarithmic(10_f64.powf(low), 10_f64.powf(high))];
        let area = Area { left, right: left + 250.0, top: 66.0, bottom: 370.0 };
        let panel = chart.panel(area, axes, ["l', number of components", name]);
        chart.curve(&panel.points(&[(1.0, limit), (MOST as f64, limit)]), LIMIT);
        for (colour, found) in COLOURS.iter().zip(found) {
            let points = |of: fn(&Spread) -> f64| {
                let value = |(number, fidelity): (usize, &Fidelity)| (number as f64 + 1.0, of(measure(fidelity)));
                panel.points(&found.iter().enumerate().map(value).collect::<Vec<_>>())
            };
            chart.curve(&points(|spread| spread.worst), Stroke::solid(colour, 2.2));
            chart.dots(&points(|spread| spread.worst), 3.4, colour);
            chart.curve(&points(|spread| spread.mean), Stroke { colour, width: 1.6, dashes: "2 3" });
        }
    }
    let entry = |name: &str, stroke| (name.to_owned(), stroke);
    let spaces = [("linear", COLOURS[0]), ("log", COLOURS[1])];
    let y = chart.legend((716.0, 80.0), "Space", &spaces.map(|(name, of)| entry(name, Stroke::solid(of, 2.4))));
    let mean = Stroke { colour: GREY, width: 1.6, dashes: "2 3" };
    let entries = [entry("worst", Stroke::solid(GREY, 2.2)), entry("mean", mean), entry("the paper's limit", LIMIT)];
    chart.legend((716.0, y), "Over curves", &entries);
    let curves = curves.to_string();
    chart.finish(&metadata(&[("engine", "discrete ordinates"), ("curves", &curves), ("light", "D65, CIE 1931")]))
}
