//! The paper's Fig. S2: reflectance and transmittance of the snow in its Table S1.

use snowblue_transport::ordinates::{self, OrdinatesOptions};
use snowblue_transport::sample::{GrainSize, SizeMeasure, SnowSample, TruncatedNormal};
use snowblue_transport::slab::{Incidence, Radiometry, Slab};

use crate::error::FigureError;
use crate::figure::{Drawing, Figure, FigureTable, ordinates_metadata};
use crate::plot::{Area, Axis, Chart, Entry, Stroke, Symbol, ordered_colour};
use crate::shading::wavelengths_nm;
use crate::table::{Cell, DataTable};

const THICKNESSES_CM: [f64; 4] = [5.0, 10.0, 18.0, 30.0];
/// The thickness of Table S1, whose reflectance the paper shows.
const TABLE_S1: usize = 2;
const SHOWN_NM: [f64; 5] = [450.0, 500.0, 550.0, 650.0, 750.0];

pub(crate) fn figure() -> Result<Figure, FigureError> {
    let slab = Slab {
        sample: SnowSample {
            grain_size: GrainSize { min_um: 200.0, max_um: 300.0, measure: SizeMeasure::GreatestExtension },
            facetness: TruncatedNormal { min: 0.05, max: 0.25, mean: 0.15, standard_deviation: 0.075 },
            density_kg_m3: 360.0,
            ..SnowSample::default()
        },
        thicknesses_cm: THICKNESSES_CM.to_vec(),
        incidences: vec![Incidence::Beam { angle_deg: 0.0 }],
        wavelengths_nm: wavelengths_nm(400, 800, 5),
    };
    let rows = ordinates::solve(&slab, &OrdinatesOptions::default())?;
    let curves: Vec<&[Radiometry]> = rows.chunks_exact(slab.wavelengths_nm.len()).collect();
    let cells = |row: &Radiometry| {
        [row.thickness_cm, row.wavelength_nm, row.reflectance.value, row.transmittance.value].map(Cell::from).to_vec()
    };
    Ok(Figure {
        title: "Reflectance and transmittance of the snow of Table S1",
        ours: "Reflectance of 18 cm and transmittance of 5, 10, 18 and 30 cm of the snow in the paper's Table S1 \
               (grains 200–300 µm, facetness .15, 360 kg/m³), every 5 nm at 0°. All curves are ours. More blue and \
               green than red light is transmitted, and transmittance does not fall linearly with thickness: the \
               paper's trends hold."
            .to_owned(),
        paper: "Shows modelled reflectance beside a measured one (SISpec file 6, Salvatori et al. 2022), and \
                transmittance at thicknesses that its text does not give; neither is available as numbers. It reports \
                more blue and green than red light, and a nonlinear decrease with thickness."
            .to_owned(),
        drawing: Drawing::Svg(draw(&curves)),
        numbers: DataTable::new(
            &["thickness_cm", "wavelength_nm", "reflectance", "transmittance"],
            rows.iter().map(cells).collect(),
        ),
        tables: vec![table(&curves)],
        warning: None,
    })
}

fn table(curves: &[&[Radiometry]]) -> FigureTable {
    let at = |curve: &[Radiometry], nm: f64| {
        let row = curve.iter().find(|row| (row.wavelength_nm - nm).abs() < 1e-9);
        row.map_or(f64::NAN, |row| row.transmittance.value)
    };
    let row = |curve: &&[Radiometry]| {
        let mut cells = vec![curve[0].thickness_cm.to_string()];
        cells.extend(SHOWN_NM.iter().map(|nm| format!("{:.3e}", at(curve, *nm))));
        cells.push(format!("{:.2}", at(curve, 450.0) / at(curve, 650.0)));
        cells
    };
    let columns = ["cm", "T 450", "T 500", "T 550", "T 650", "T 750", "T 450 / T 650"];
    FigureTable::of_words(
        "transmittance",
        "Transmittance of the snow of Table S1",
        &columns,
        curves.iter().map(row).collect(),
    )
}

fn draw(curves: &[&[Radiometry]]) -> String {
    let mut chart = Chart::new(900.0, 470.0, "Snow of Table S1: reflectance and transmittance");
    let axis = || Axis::linear(400.0, 800.0, 5.0);
    let (top, bottom) = (66.0, 380.0);
    let left = Area { left: 84.0, right: 380.0, top, bottom };
    let right = Area { left: 470.0, right: 766.0, top, bottom };
    let reflectance =
        chart.panel(left, [axis(), Axis::linear(0.8, 1.0, 4.0)], ["Wavelength (nm)", "Reflectance of 18 cm"]);
    let transmittance =
        chart.panel(right, [axis(), Axis::logarithmic(1e-9, 0.1)], ["Wavelength (nm)", "Transmittance"]);
    let through = |curve: &[Radiometry], quantity: fn(&Radiometry) -> f64| -> Vec<(f64, f64)> {
        curve.iter().map(|row| (row.wavelength_nm, quantity(row))).collect()
    };
    let colours: Vec<String> = (0..curves.len()).map(|i| ordered_colour(i, curves.len())).collect();
    let back = through(curves[TABLE_S1], |row| row.reflectance.value);
    chart.line(&reflectance, &back, Stroke::solid(&colours[TABLE_S1], 2.0));
    for (curve, colour) in curves.iter().zip(&colours) {
        chart.line(&transmittance, &through(curve, |row| row.transmittance.value), Stroke::solid(colour, 2.0));
    }
    let names: Vec<String> = THICKNESSES_CM.iter().map(|cm| format!("{cm} cm")).collect();
    let entries: Vec<Entry> = names
        .iter()
        .zip(&colours)
        .map(|(name, colour)| Entry { name, symbol: Symbol::Line(Stroke::solid(colour, 2.2)) })
        .collect();
    chart.legend((786.0, 80.0), "Thickness", &entries);
    chart.finish(&ordinates_metadata(&[("ice", "warren2008"), ("light", "0°"), ("curves", "ours")]))
}
