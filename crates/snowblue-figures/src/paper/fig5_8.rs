//! The paper's Figs. 5–8: effects of grain size, facetness, density and thickness on the transmitted colour.

use snowblue_color::{Colorimeter, Illuminant, Observer, Xyz};
use snowblue_transport::batch::{Batch, SlabCase};
use snowblue_transport::optics::Wavelengths;
use snowblue_transport::ordinates::{OrdinatesOptions, solve_batch};
use snowblue_transport::sample::{GrainSize, SnowSample, TruncatedNormal};
use snowblue_transport::slab::Incidence;

use super::swatches::{self, Exposed};
use crate::figure::{Figure, FigureError, Picture, metadata};
use crate::plot::{Chart, LABEL};
use crate::table::{Cell, DataTable};

const ANGLES_DEG: [f64; 6] = [0.0, 20.0, 40.0, 60.0, 80.0, 89.0];
const THICKNESS_CM: f64 = 12.0;

const OURS: &str = "The light behind snow of 550 µm, facetness .3, 275 kg/m³ and 12 cm under D65, with one quantity \
    changed in each row, at one exposure. Grain size has the greatest effect on luminance at every angle.";
const PAPER: &str = "Markedly lighter hues for large grains, darker ones for large facetness, density and thickness, \
    the strongest effect for grain size, and darker hues with the angle of incidence.";

/// A row of swatches.
struct Row {
    figure: u8,
    quantity: &'static str,
    value: &'static str,
    sample: SnowSample,
    thickness_cm: f64,
}

pub(crate) fn figure() -> Result<Figure, FigureError> {
    let rows = rows()?;
    let Wavelengths(wavelengths_nm) = Wavelengths::visible();
    let colorimeter = Colorimeter::new(Observer::Cie1931, Illuminant::D65, &wavelengths_nm)?;
    let case = |(sample, row): (usize, &Row)| {
        let thickness_cm = row.thickness_cm;
        ANGLES_DEG.map(|angle_deg| SlabCase {
            sample,
            thickness_cm,
            incidence: Incidence::Beam { angle_deg },
            ground_albedo: 0.0.into(),
        })
    };
    let batch = Batch {
        samples: rows.iter().map(|row| row.sample).collect(),
        cases: rows.iter().enumerate().flat_map(case).collect(),
        wavelengths_nm,
    };
    let fluxes = solve_batch(&batch, &OrdinatesOptions::default(), false, &|_| ()).map_err(|wrong| wrong.error)?;
    let transmitted: Vec<f64> = fluxes.iter().map(|fluxes| fluxes.transmittance.value).collect();
    let lights: Vec<Xyz> =
        transmitted.chunks_exact(batch.wavelengths_nm.len()).map(|values| colorimeter.xyz(values)).collect();
    let lights: Vec<&[Xyz]> = lights.chunks_exact(ANGLES_DEG.len()).collect();
    let exposed = Exposed::together(lights.concat().into_iter());
    let cells = |(row, lights): (&Row, &&[Xyz])| {
        let cells = |(light, angle_deg): (&Xyz, f64)| {
            let mut cells = vec![f64::from(row.figure).into(), Cell::word(row.quantity), Cell::word(row.value)];
            cells.extend([angle_deg, light.x, light.y, light.z].map(Cell::from));
            cells.push(Cell::Word(exposed.colour(*light).to_string()));
            cells
        };
        lights.iter().zip(ANGLES_DEG).map(cells).collect::<Vec<_>>()
    };
    let columns = ["figure", "quantity", "value", "angle_deg", "X", "Y", "Z", "shown_hex"];
    Ok(Figure {
        title: "Grain size, facetness, density, thickness and angle of incidence",
        ours: OURS.to_owned(),
        paper: PAPER,
        pictures: Picture::drawing(draw(&rows, &lights, &exposed)),
        numbers: DataTable::new(&columns, rows.iter().zip(&lights).flat_map(cells).collect()),
        table: Some(("Effect of each quantity on the luminance at 0°", pairs(&rows, &lights))),
        warning: None,
    })
}

fn rows() -> Result<Vec<Row>, FigureError> {
    let of_size = |mean_um: f64| -> Result<SnowSample, FigureError> {
        Ok(SnowSample { grain_size: GrainSize::around(mean_um)?, density_kg_m3: 275.0, ..SnowSample::default() })
    };
    let base = of_size(550.0)?;
    let faceted = |mean: f64| SnowSample { facetness: TruncatedNormal::facetness_around(mean), ..base };
    let row = |figure, quantity, value, sample, thickness_cm| Row { figure, quantity, value, sample, thickness_cm };
    Ok(vec![
        row(5, "grain size", "100 µm", of_size(100.0)?, THICKNESS_CM),
        row(5, "grain size", "500 µm", of_size(500.0)?, THICKNESS_CM),
        row(6, "facetness", "0.1", faceted(0.1), THICKNESS_CM),
        row(6, "facetness", "0.9", faceted(0.9), THICKNESS_CM),
        row(7, "density", "200 kg/m³", SnowSample { density_kg_m3: 200.0, ..base }, THICKNESS_CM),
        row(7, "density", "400 kg/m³", SnowSample { density_kg_m3: 400.0, ..base }, THICKNESS_CM),
        row(8, "thickness", "10 cm", base, 10.0),
        row(8, "thickness", "25 cm", base, 25.0),
    ])
}

/// Effect of each of the four quantities at 0°.
fn pairs(rows: &[Row], lights: &[&[Xyz]]) -> DataTable {
    let pair = |(rows, lights): (&[Row], &[&[Xyz]])| {
        let [low, high] = [lights[0][0].y, lights[1][0].y];
        let change = if high > low { "lighter" } else { "darker" };
        vec![
            Cell::Word(format!("Fig. {}", rows[0].figure)),
            Cell::Word(format!("{}, {} → {}", rows[0].quantity, rows[0].value, rows[1].value)),
            low.into(),
            high.into(),
            (high.max(low) / low.min(high)).into(),
            Cell::word(change),
        ]
    };
    let columns = ["figure", "from → to", "Y from", "Y to", "times", "it becomes"];
    DataTable::new(&columns, rows.chunks_exact(2).zip(lights.chunks_exact(2)).map(pair).collect()).rounded(3)
}

fn draw(rows: &[Row], lights: &[&[Xyz]], exposed: &Exposed) -> String {
    let title = "Light through snow: grain size, facetness, density, thickness and angle";
    let mut chart = Chart::new(900.0, 690.0, title);
    let base = format!("550 µm, facetness 0.3, 275 kg/m³, 12 cm, D65, but for what is named; {}", exposed.words());
    chart.text((24.0, 58.0), &base, LABEL);
    let row = |(row, lights): (&Row, &&[Xyz])| {
        let label = format!("Fig. {}: {} {}", row.figure, row.quantity, row.value);
        (label, lights.iter().map(|light| exposed.colour(*light)).collect())
    };
    let sheet: Vec<_> = rows.iter().zip(lights).map(row).collect();
    let columns = ANGLES_DEG.map(|angle_deg| format!("{angle_deg}°"));
    swatches::draw(&mut chart, (212.0, 98.0), (110.0, 68.0), &columns, &sheet);
    chart.finish(&metadata(&[("engine", "discrete ordinates"), ("ice", "warren2008"), ("observer", "CIE 1931")]))
}
