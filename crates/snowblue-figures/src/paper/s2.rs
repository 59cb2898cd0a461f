//! The paper's Fig. S2: reflectance and transmittance of the snow in its Table S1.

use snowblue_transport::ordinates::{self, OrdinatesOptions};
use snowblue_transport::sample::{GrainSize, SizeMeasure, SnowSample, TruncatedNormal};
use snowblue_transport::slab::{Incidence, Radiometry, Slab};

use crate::figure::{Figure, FigureError, Picture, metadata};
use crate::plot::{Area, Axis, Chart, Stroke, ordered_colours};
use crate::table::{Cell, DataTable};

const THICKNESSES_CM: [f64; 4] = [5.0, 10.0, 18.0, 30.0];
/// The thickness of Table S1, whose reflectance the paper shows.
const TABLE_S1: usize = 2;

const OURS: &str = "The snow of Table S1: grains of 200–300 µm, facetness .15, 360 kg/m³, every 5 nm at 0°. All curves \
    are ours. More blue and green than red light is transmitted, and transmittance does not fall linearly.";
const PAPER: &str = "Modelled reflectance beside a measured one, and transmittance at thicknesses that its text does \
    not give; neither is available as numbers. The same trends.";

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
        wavelengths_nm: (400..=800).step_by(5).map(f64::from).collect(),
    };
    let rows = ordinates::solve_without_errors(&slab, &OrdinatesOptions::default())?;
    let curves: Vec<&[Radiometry]> = rows.chunks_exact(slab.wavelengths_nm.len()).collect();
    let cells = |row: &Radiometry| {
        [row.thickness_cm, row.wavelength_nm, row.fluxes.reflectance.value, row.fluxes.transmittance.value]
            .map(Cell::from)
            .to_vec()
    };
    // Every 5 nm from 400 nm on.
    let at = |curve: &&[Radiometry]| [10, 20, 30, 50, 70].map(|number: usize| curve[number].fluxes.transmittance.value);
    let brief = |curve: &&[Radiometry]| [&[curve[0].thickness_cm], &at(curve)[..]].concat();
    let brief = curves.iter().map(|curve| brief(curve).into_iter().map(Cell::from).collect()).collect();
    let columns = ["cm", "T 450", "T 500", "T 550", "T 650", "T 750"];
    Ok(Figure {
        title: "Reflectance and transmittance of the snow of Table S1",
        ours: OURS.to_owned(),
        paper: PAPER,
        pictures: Picture::drawing(draw(&curves)),
        numbers: DataTable::new(
            &["thickness_cm", "wavelength_nm", "reflectance", "transmittance"],
            rows.iter().map(cells).collect(),
        ),
        table: Some(("Transmittance of the snow of Table S1", DataTable::new(&columns, brief).rounded(4))),
        warning: None,
    })
}

fn draw(curves: &[&[Radiometry]]) -> String {
    let mut chart = Chart::new(900.0, 470.0, "Snow of Table S1: reflectance and transmittance");
    let nm = || Axis::linear(400.0, 800.0, 5.0);
    let (top, bottom) = (66.0, 380.0);
    let left = Area { left: 84.0, right: 380.0, top, bottom };
    let right = Area { left: 470.0, right: 766.0, top, bottom };
    let names = ["Wavelength (nm)", "Reflectance of 18 cm"];
    let reflectance = chart.panel(left, [nm(), Axis::linear(0.8, 1.0, 4.0)], names);
    let names = ["Wavelength (nm)", "Transmittance"];
    let transmittance = chart.panel(right, [nm(), Axis::logarithmic(1e-9, 0.1)], names);
    let colours = ordered_colours(curves.len());
    let mut entries = Vec::new();
    for (number, (curve, colour)) in curves.iter().zip(&colours).enumerate() {
        let stroke = Stroke::solid(colour, 2.0);
        let passed: Vec<_> = curve.iter().map(|row| (row.wavelength_nm, row.fluxes.transmittance.value)).collect();
        chart.curve(&transmittance.points(&passed), stroke);
        if number == TABLE_S1 {
            let back: Vec<_> = curve.iter().map(|row| (row.wavelength_nm, row.fluxes.reflectance.value)).collect();
            chart.curve(&reflectance.points(&back), stroke);
        }
        entries.push((format!("{} cm", THICKNESSES_CM[number]), stroke));
    }
    chart.legend((786.0, 80.0), "Thickness", &entries);
    chart.finish(&metadata(&[("engine", "discrete ordinates"), ("ice", "warren2008"), ("light", "0°")]))
}
