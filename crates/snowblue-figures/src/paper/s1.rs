//! The paper's Fig. S1: the reconstructed curves of its 225 samples at 15 cm and 0°, and their errors.

use snowblue_database::pca::{Components, Decomposition};
use snowblue_database::{DatabaseError, Quantity, Space, Table};

use super::paper_table::paper_table;
use crate::figure::{Figure, FigureError, Picture, metadata};
use crate::plot::{Area, Axis, Chart, GREY, HEADING, Stroke, ordered_colours};
use crate::table::{Cell, DataTable};

/// The paper's space, and the space of the embedded table.
const SPACES: [Space; 2] = [Space::Linear, Space::Log];

const PAPER: &str = "Shows the 225 curves reconstructed with l' = 2, one for each of nine grain sizes, five values of \
    facetness and five densities, at 15 cm and 0°.";

/// One of the 225 samples.
struct Curve {
    /// Grain size, facetness and density.
    sample: [f64; 3],
    full: Vec<f64>,
    /// Reconstructed from the paper's components, and from ours.
    reconstructed: [Vec<f64>; 2],
}

pub(crate) fn figure() -> Result<Figure, FigureError> {
    let table = paper_table()?;
    let curves = curves(table)?;
    let cells = |curve: &Curve| {
        let cells = |(w, nm): (usize, &f64)| {
            let values = [*nm, curve.full[w], curve.reconstructed[0][w], curve.reconstructed[1][w]];
            curve.sample.into_iter().chain(values).map(Cell::from).collect()
        };
        table.axes.wavelengths_nm.iter().enumerate().map(cells).collect::<Vec<_>>()
    };
    let columns = [
        "grain_size_um",
        "facetness",
        "density_kg_m3",
        "wavelength_nm",
        "transmittance",
        "reconstructed_linear_2",
        "reconstructed_log_6",
    ];
    Ok(Figure {
        title: "Transmittance of 225 samples of snow, reconstructed from principal components",
        ours: format!(
            "Every sample of Table 1 at 15 cm and 0°, from a decomposition of all {} curves. Two components of the \
             values give negative transmittances of fine snow; six components of the logarithms cannot.",
            table.axes.curves()
        ),
        paper: PAPER,
        pictures: Picture::drawing(draw(table, &curves)),
        numbers: DataTable::new(&columns, curves.iter().flat_map(cells).collect()),
        table: Some(("Greatest errors of the 225 reconstructed curves", errors(&curves))),
        warning: None,
    })
}

fn curves(table: &Table) -> Result<Vec<Curve>, FigureError> {
    let axes = &table.axes;
    let keep = |space: Space| {
        let decomposition = Decomposition::new(table, Quantity::Transmittance, space)?;
        decomposition.keep(table, Quantity::Transmittance, space.default_components())
    };
    let kept = SPACES.into_iter().map(keep).collect::<Result<Vec<Components>, DatabaseError>>()?;
    let full: Vec<&[f64]> = table.curves(Quantity::Transmittance).collect();
    // The first angle is 0°.
    let thickness = axes.thicknesses_cm.iter().position(|cm| (cm - 15.0).abs() < 1e-9).unwrap_or_default();
    let curve = |number: usize| {
        let row = number * axes.curves_per_sample() + thickness;
        let sample = axes.table_sample(number);
        let reconstructed = [0, 1].map(|space| {
            let mut values = vec![0.0; axes.wavelengths_nm.len()];
            kept[space].rebuild(row, SPACES[space], &mut values);
            values
        });
        let sample = [sample.grain_size_um, sample.facetness, sample.density_kg_m3];
        Curve { sample, full: full[row].to_vec(), reconstructed }
    };
    Ok((0..axes.samples()).map(curve).collect())
}

fn errors(curves: &[Curve]) -> DataTable {
    let row = |space: usize| {
        let pairs = || curves.iter().flat_map(|curve| curve.full.iter().zip(&curve.reconstructed[space]));
        let worst = pairs().map(|(full, found)| (found - full).abs()).fold(0.0, f64::max);
        let relative = pairs().map(|(full, found)| (found / full - 1.0).abs()).fold(0.0, f64::max);
        let negative = pairs().filter(|(_, found)| **found < 0.0).count();
        let name = ["l' = 2, linear", "l' = 6, log"][space];
        vec![Cell::word(name), worst.into(), (100.0 * relative).into(), (negative as f64).into()]
    };
    let columns = ["components", "error of T", "error in %", "negative values"];
    DataTable::new(&columns, vec![row(0), row(1)]).rounded(3)
}

fn draw(table: &Table, curves: &[Curve]) -> String {
    let (nm, sizes_um) = (&table.axes.wavelengths_nm, &table.axes.grain_sizes_um);
    let mut chart = Chart::new(1080.0, 580.0, "Transmittance of 225 kinds of snow: 15 cm, 0°");
    let colours = ordered_colours(sizes_um.len());
    // Errors relative to the full curves, in %, up to the first negative value.
    let error = |curve: &Curve, space: usize, w: usize| {
        let ratio = curve.reconstructed[space][w] / curve.full[w];
        (ratio >= 0.0).then_some(100.0 * (ratio - 1.0))
    };
    type Value<'v> = &'v dyn Fn(&Curve, usize) -> Option<f64>;
    let panels: [(f64, f64, f64, f64, &str, &str, Value); 3] = [
        (84.0, 510.0, 84.0, 490.0, "Reconstructed with l' = 2, linear", "Transmittance (%)", &|curve, w| {
            Some(100.0 * curve.reconstructed[0][w])
        }),
        (610.0, 940.0, 84.0, 250.0, "l' = 2, linear: error", "% of T", &|curve, w| error(curve, 0, w)),
        (610.0, 940.0, 324.0, 490.0, "l' = 6, log: error", "% of T", &|curve, w| error(curve, 1, w)),
    ];
    for (left, right, top, bottom, heading, name, value) in panels {
        let line = |curve: &Curve| -> Vec<(f64, f64)> {
            nm.iter().enumerate().map_while(|(w, nm)| Some((*nm, value(curve, w)?))).collect()
        };
        let lines: Vec<Vec<(f64, f64)>> = curves.iter().map(line).collect();
        let values = || lines.iter().flatten().map(|(_, value)| *value);
        let (low, high) = (values().fold(0.0, f64::min), values().fold(0.0, f64::max));
        let axes = [Axis::linear(400.0, 700.0, 6.0), Axis::linear_to_marks(low, high, (bottom - top) / 42.0)];
        let panel = chart.panel(Area { left, right, top, bottom }, axes, ["Wavelength (nm)", name]);
        chart.text((left, top - 12.0), heading, HEADING);
        // Samples are ordered by grain size.
        for (lines, colour) in lines.chunks(curves.len() / sizes_um.len()).zip(&colours) {
            let alike: Vec<_> = lines.iter().map(|line| panel.points(line)).collect();
            chart.curves(&alike, Stroke::solid(colour, 0.8));
        }
        let zero = Stroke { colour: GREY, width: 1.2, dashes: "5 4" };
        chart.curve(&panel.points(&[(400.0, 0.0), (700.0, 0.0)]), zero);
    }
    let entries: Vec<_> =
        sizes_um.iter().zip(&colours).rev().map(|(um, of)| (format!("{um} µm"), Stroke::solid(of, 2.4))).collect();
    chart.legend((968.0, 96.0), "Grain size", &entries);
    chart.finish(&metadata(&[("engine", "discrete ordinates"), ("ice", "warren2008")]))
}
