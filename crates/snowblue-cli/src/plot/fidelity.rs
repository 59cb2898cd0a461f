//! What compression costs, against the number of components: both spaces, both quantities.

use super::{Area, Axis, Chart, Entry, GREY, Look, Metadata, Stroke};

/// One number of components of one quantity in one space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cost {
    /// 0 for linear, 1 for log.
    pub(crate) space: usize,
    /// 0 for transmittance, 1 for reflectance.
    pub(crate) quantity: usize,
    pub(crate) components: usize,
    /// Greatest ΔE, greatest RMSE, and the singular value over the first.
    pub(crate) measures: [f64; 3],
}

const COLOURS: [&str; 2] = ["#d1495b", "#1f6feb"];
const NAMES: [&str; 3] = ["Greatest ΔE*ab", "Greatest RMSE", "Singular value over the first"];
/// What the paper allows of the first two measures.
const ALLOWED: [Option<f64>; 3] = [Some(2.3), Some(0.002), None];

/// Draws three panels.
pub(crate) fn fidelity(costs: &[Cost], metadata: &Metadata) -> String {
    let mut chart = Chart::new((1080.0, 430.0), "What compression costs, by the number of components");
    let most = costs.iter().map(|cost| cost.components).max().unwrap_or(1);
    for (number, name) in NAMES.iter().enumerate() {
        let left = 84.0 + 300.0 * number as f64;
        let area = Area { left, right: left + 215.0, top: 64.0, bottom: 330.0 };
        let values = || costs.iter().map(|cost| cost.measures[number]).chain(ALLOWED[number]).filter(|v| *v > 0.0);
        let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max));
        let ends = if low < high { (low * 0.5, high * 2.0) } else { (0.1, 1.0) };
        let x = Axis::linear(1.0, (most as f64).max(2.0), most as f64 - 1.0);
        let panel = chart.panel(area, [x, Axis::logarithmic(ends.0, ends.1)], ["Components", name]);
        for space in [0, 1] {
            for quantity in [0, 1] {
                let of = |cost: &&Cost| (cost.space, cost.quantity) == (space, quantity);
                let points: Vec<(f64, f64)> =
                    costs.iter().filter(of).map(|cost| (cost.components as f64, cost.measures[number])).collect();
                chart.line(&panel, &points, stroke(space, quantity));
                chart.dots(&panel, &points, COLOURS[space]);
            }
        }
        if let Some(allowed) = ALLOWED[number] {
            let stroke = Stroke { dashes: "6 4", ..Stroke::full(GREY, 1.2) };
            chart.line(&panel, &[(1.0, allowed), ((most as f64).max(2.0), allowed)], stroke);
        }
    }
    let line = |space, quantity| Look::Line(stroke(space, quantity));
    let entries = [
        Entry { name: "T, linear", look: line(0, 0) },
        Entry { name: "R, linear", look: line(0, 1) },
        Entry { name: "T, log", look: line(1, 0) },
        Entry { name: "R, log", look: line(1, 1) },
        Entry { name: "the paper's", look: Look::Line(Stroke { dashes: "6 4", ..Stroke::full(GREY, 1.2) }) },
    ];
    chart.legend((926.0 + 40.0, 76.0), "", &entries);
    chart.finish(metadata)
}

fn stroke(space: usize, quantity: usize) -> Stroke<'static> {
    let full = Stroke::full(COLOURS[space], 2.0);
    if quantity == 0 { full } else { Stroke { dashes: "2 3", ..full } }
}
