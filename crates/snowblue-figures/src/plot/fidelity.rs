//! Errors of a compressed table against the number of components, for both spaces and both quantities.

use snowblue_database::{Quantity, Space};

use super::axis::Axis;
use super::canvas::{GREY, Stroke};
use super::chart::{Area, Chart, Entry, Symbol};

/// Errors of one number of components of one quantity in one space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompressionError {
    /// The space of the components.
    pub space: Space,
    /// The quantity.
    pub quantity: Quantity,
    /// Number of components.
    pub components: usize,
    /// Greatest ΔE*ab of any curve.
    pub worst_delta_e: f64,
    /// Greatest root mean square error of any curve.
    pub worst_rmse: f64,
    /// Singular value of the last component over that of the first.
    pub relative_singular_value: f64,
}

/// A panel's quantity, its name, and the paper's limit.
struct Measure {
    name: &'static str,
    paper_limit: Option<f64>,
    of: fn(&CompressionError) -> f64,
}

const MEASURES: [Measure; 3] = [
    Measure { name: "Greatest ΔE*ab", paper_limit: Some(2.3), of: |error| error.worst_delta_e },
    Measure { name: "Greatest RMSE", paper_limit: Some(0.002), of: |error| error.worst_rmse },
    Measure { name: "Singular value over the first", paper_limit: None, of: |error| error.relative_singular_value },
];

const LIMIT: Stroke = Stroke { colour: GREY, width: 1.2, dashes: "6 4" };

/// Draws greatest ΔE, greatest RMSE and singular values, a panel each.
pub fn fidelity(errors: &[CompressionError], metadata: &[(&'static str, String)]) -> String {
    let mut chart = Chart::new(1080.0, 430.0, "What compression costs, by the number of components");
    let most = errors.iter().map(|error| error.components).max().unwrap_or(1);
    let last = (most as f64).max(2.0);
    for (number, measure) in MEASURES.iter().enumerate() {
        let left = 84.0 + 300.0 * number as f64;
        let area = Area { left, right: left + 215.0, top: 64.0, bottom: 330.0 };
        let values = || errors.iter().map(measure.of).chain(measure.paper_limit).filter(|value| *value > 0.0);
        let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max));
        let y = if low < high { Axis::logarithmic(low * 0.5, high * 2.0) } else { Axis::logarithmic(0.1, 1.0) };
        let x = Axis::linear(1.0, last, most as f64 - 1.0);
        let panel = chart.panel(area, [x, y], ["Components", measure.name]);
        for space in [Space::Linear, Space::Log] {
            for quantity in [Quantity::Transmittance, Quantity::Reflectance] {
                let drawn = errors.iter().filter(|error| error.space == space && error.quantity == quantity);
                let points: Vec<(f64, f64)> =
                    drawn.map(|error| (error.components as f64, (measure.of)(error))).collect();
                chart.line(&panel, &points, stroke(space, quantity));
                chart.dots(&panel, &points, colour(space));
            }
        }
        if let Some(limit) = measure.paper_limit {
            chart.line(&panel, &[(1.0, limit), (last, limit)], LIMIT);
        }
    }
    let line = |space, quantity| Symbol::Line(stroke(space, quantity));
    let entries = [
        Entry { name: "T, linear", symbol: line(Space::Linear, Quantity::Transmittance) },
        Entry { name: "R, linear", symbol: line(Space::Linear, Quantity::Reflectance) },
        Entry { name: "T, log", symbol: line(Space::Log, Quantity::Transmittance) },
        Entry { name: "R, log", symbol: line(Space::Log, Quantity::Reflectance) },
        Entry { name: "the paper's", symbol: Symbol::Line(LIMIT) },
    ];
    chart.legend((966.0, 76.0), "", &entries);
    chart.finish(metadata)
}

fn colour(space: Space) -> &'static str {
    match space {
        Space::Linear => "#d1495b",
        Space::Log => "#1f6feb",
    }
}

fn stroke(space: Space, quantity: Quantity) -> Stroke<'static> {
    let solid = Stroke::solid(colour(space), 2.0);
    match quantity {
        Quantity::Transmittance => solid,
        Quantity::Reflectance => Stroke { dashes: "2 3", ..solid },
    }
}
