//! The paper's Fig. S1: the reconstructed curves of its 225 samples at 15 cm and 0°, and their errors.

use std::ops::Range;

use snowblue_database::pca::{Components, Decomposition};
use snowblue_database::{Axes, Quantity, Space, Table as SnowTable};

use super::paper_table::paper_table;
use crate::error::FigureError;
use crate::figure::{Drawing, Figure, FigureTable};
use crate::plot::{Area, Axis, Chart, Entry, GREY, Panel, Stroke, Symbol, ordered_colour};
use crate::table::{Cell, DataTable};

const THICKNESS_CM: f64 = 15.0;
const ANGLE_DEG: f64 = 0.0;

/// One of the 225 samples.
struct Curve {
    /// Index of the grain size.
    size: usize,
    /// Grain size, facetness and density.
    sample: [f64; 3],
    full: Vec<f64>,
    /// Reconstructed from the paper's components, and from ours.
    reconstructed: [Vec<f64>; 2],
}

/// The paper's space, and that of the embedded table.
const SPACES: [Space; 2] = [Space::Linear, Space::Log];

pub(crate) fn figure() -> Result<Figure, FigureError> {
    let table = paper_table()?;
    let curves = curves(table)?;
    let wavelengths_nm = &table.axes.wavelengths_nm;
    let rows = curves.iter().flat_map(|curve| {
        wavelengths_nm.iter().enumerate().map(|(w, nm)| {
            let values = [*nm, curve.full[w], curve.reconstructed[0][w], curve.reconstructed[1][w]];
            curve.sample.into_iter().chain(values).map(Cell::from).collect()
        })
    });
    let columns = [
        "grain_size_um",
        "facetness",
        "density_kg_m3",
        "wavelength_nm",
        "transmittance",
        "reconstructed_linear_2",
        "reconstructed_log_6",
    ];
    let [linear, log] = [0, 1].map(|space| Errors::of(&curves, space));
    Ok(Figure {
        title: "Transmittance of 225 samples of snow, reconstructed from principal components",
        ours: format!(
            "Every sample of Table 1 at 15 cm and 0°, reconstructed from two components of the values, as in the \
             paper, from a decomposition of all {} curves. Right: relative errors. Two linear components have errors \
             of T up to {:.2e}, little compared with the transmittance of coarse snow, but more than all red light of \
             fine snow, where {} values are negative. Six components of the logarithms have errors of at most {:.2} % \
             and cannot be negative.",
            table.axes.curves(),
            linear.absolute,
            linear.negative,
            100.0 * log.relative,
        ),
        paper: "Shows the 225 curves reconstructed with l' = 2, one for each of nine grain sizes, five values of \
                facetness and five densities, at 15 cm and 0°."
            .to_owned(),
        drawing: Drawing::Svg(draw(&table.axes, &curves)),
        numbers: DataTable::new(&columns, rows.collect()),
        tables: vec![errors_table([&linear, &log])],
        warning: None,
    })
}

fn curves(table: &SnowTable) -> Result<Vec<Curve>, FigureError> {
    let axes = &table.axes;
    let index_of =
        |values: &[f64], value: f64| values.iter().position(|known| (known - value).abs() < 1e-9).unwrap_or_default();
    let within = index_of(&axes.angles_deg, ANGLE_DEG) * axes.thicknesses_cm.len()
        + index_of(&axes.thicknesses_cm, THICKNESS_CM);
    let keep = |space: Space| {
        let decomposition = Decomposition::new(table, Quantity::Transmittance, space)?;
        decomposition.keep(table, Quantity::Transmittance, space.default_components())
    };
    let kept: Vec<Components> = SPACES.into_iter().map(keep).collect::<Result<_, _>>()?;
    let full: Vec<&[f64]> = table.curves(Quantity::Transmittance).collect();
    let curve = |number: usize| {
        let row = number * axes.curves_per_sample() + within;
        let sample = axes.table_sample(number);
        let reconstructed = [0, 1].map(|space| {
            let mut values = vec![0.0; axes.wavelengths_nm.len()];
            kept[space].rebuild(row, SPACES[space], &mut values);
            values
        });
        Curve {
            size: index_of(&axes.grain_sizes_um, sample.grain_size_um),
            sample: [sample.grain_size_um, sample.facetness, sample.density_kg_m3],
            full: full[row].to_vec(),
            reconstructed,
        }
    };
    Ok((0..axes.samples()).map(curve).collect())
}

/// Greatest errors of the curves.
struct Errors {
    absolute: f64,
    rmse: f64,
    relative: f64,
    negative: usize,
}

impl Errors {
    fn of(curves: &[Curve], space: usize) -> Self {
        let pairs = |curve: &Curve| -> Vec<(f64, f64)> {
            curve.full.iter().copied().zip(curve.reconstructed[space].iter().copied()).collect()
        };
        let worst =
            |error: fn(&(f64, f64)) -> f64| curves.iter().flat_map(pairs).map(|pair| error(&pair)).fold(0.0, f64::max);
        let rmse = |curve: &Curve| {
            let squares: f64 = pairs(curve).iter().map(|(full, reconstructed)| (full - reconstructed).powi(2)).sum();
            (squares / curve.full.len() as f64).sqrt()
        };
        Self {
            absolute: worst(|(full, reconstructed)| (reconstructed - full).abs()),
            rmse: curves.iter().map(rmse).fold(0.0, f64::max),
            relative: worst(|(full, reconstructed)| (reconstructed / full - 1.0).abs()),
            negative: curves.iter().flat_map(|curve| &curve.reconstructed[space]).filter(|value| **value < 0.0).count(),
        }
    }
}

fn errors_table(errors: [&Errors; 2]) -> FigureTable {
    let names = ["l' = 2 linear", "l' = 6 log"];
    let row = |(name, errors): (&str, &Errors)| {
        vec![
            name.to_owned(),
            format!("{:.2e}", errors.absolute),
            format!("{:.2e}", errors.rmse),
            format!("{:.*}", if errors.relative > 1.0 { 0 } else { 3 }, 100.0 * errors.relative),
            errors.negative.to_string(),
        ]
    };
    let columns = ["components", "worst error of T", "worst RMSE", "worst error in %", "negative values"];
    let title = "Errors of the 225 reconstructed curves at 15 cm and 0°";
    FigureTable::of_words("errors", title, &columns, names.into_iter().zip(errors).map(row).collect())
}

fn draw(axes: &Axes, curves: &[Curve]) -> String {
    let mut chart = Chart::new(1080.0, 580.0, "Transmittance of 225 kinds of snow: 15 cm, 0°");
    let colours: Vec<String> =
        (0..axes.grain_sizes_um.len()).map(|i| ordered_colour(i, axes.grain_sizes_um.len())).collect();
    let mut drawer = Drawer { chart: &mut chart, curves, nm: &axes.wavelengths_nm, colours: &colours };
    drawer.reconstructed();
    drawer.errors(0, 84.0..262.0, "l' = 2, linear: error, up to the first negative value");
    drawer.errors(1, 312.0..490.0, "l' = 6, log: error");
    let names: Vec<String> = axes.grain_sizes_um.iter().map(|um| format!("{um} µm")).collect();
    let entries: Vec<Entry> = names
        .iter()
        .zip(&colours)
        .rev()
        .map(|(name, colour)| Entry { name, symbol: Symbol::Line(Stroke::solid(colour, 2.4)) })
        .collect();
    chart.legend((968.0, 96.0), "Grain size", &entries);
    let made = [
        ("snowblue", env!("CARGO_PKG_VERSION").to_owned()),
        ("engine", "discrete ordinates, automatic streams".to_owned()),
        ("components of", format!("{} curves", axes.curves())),
        ("ice", "warren2008".to_owned()),
        ("curves", "ours".to_owned()),
    ];
    chart.finish(&made)
}

/// Data of all panels.
struct Drawer<'d> {
    chart: &'d mut Chart,
    curves: &'d [Curve],
    nm: &'d [f64],
    /// For each grain size.
    colours: &'d [String],
}

impl Drawer<'_> {
    fn reconstructed(&mut self) {
        let values = || self.curves.iter().flat_map(|curve| &curve.reconstructed[0]).map(|value| 100.0 * value);
        let (low, high) = (values().fold(0.0, f64::min), values().fold(0.0, f64::max));
        let area = Area { left: 84.0, right: 510.0, top: 84.0, bottom: 490.0 };
        let panel = self.chart.panel(
            area,
            [Axis::linear(400.0, 700.0, 6.0), Axis::linear_to_marks(low, high, 10.0)],
            ["Wavelength (nm)", "Transmittance (%)"],
        );
        self.chart.heading((84.0, 70.0), "Reconstructed with l' = 2, linear");
        self.lines(&panel, &|curve, w| Some(100.0 * curve.reconstructed[0][w]));
        self.zero_line(&panel);
    }

    /// Errors in one space, in % of the full curves, where the reconstructed values are not negative.
    fn errors(&mut self, space: usize, y: Range<f64>, heading: &str) {
        let error = |curve: &Curve, w: usize| {
            let ratio = curve.reconstructed[space][w] / curve.full[w];
            (ratio >= 0.0).then_some(100.0 * (ratio - 1.0))
        };
        let shown = || self.curves.iter().flat_map(|curve| (0..self.nm.len()).filter_map(move |w| error(curve, w)));
        let (low, high) = (shown().fold(0.0, f64::min), shown().fold(0.0, f64::max));
        let area = Area { left: 610.0, right: 940.0, top: y.start, bottom: y.end };
        let nm = Axis::linear(400.0, 700.0, 6.0);
        let (nm, name) = if space == 0 { (Axis { marks: Vec::new(), ..nm }, "") } else { (nm, "Wavelength (nm)") };
        let panel = self.chart.panel(area, [nm, Axis::linear_to_marks(low, high, 4.0)], [name, "% of T"]);
        self.chart.heading((610.0, y.start - 14.0), heading);
        self.lines(&panel, &error);
        self.zero_line(&panel);
    }

    /// A line for each curve in the colour of its grain size, up to its first point without a value.
    fn lines(&mut self, panel: &Panel, value: &dyn Fn(&Curve, usize) -> Option<f64>) {
        for (size, colour) in self.colours.iter().enumerate() {
            let through = |curve: &Curve| -> Vec<(f64, f64)> {
                self.nm.iter().enumerate().map_while(|(w, nm)| Some((*nm, value(curve, w)?))).collect()
            };
            let alike: Vec<_> = self.curves.iter().filter(|curve| curve.size == size).map(through).collect();
            self.chart.lines(panel, &alike, Stroke::solid(colour, 0.8));
        }
    }

    /// The line of zero.
    fn zero_line(&mut self, panel: &Panel) {
        self.chart.line(panel, &[(400.0, 0.0), (700.0, 0.0)], Stroke { colour: GREY, width: 1.2, dashes: "5 4" });
    }
}
