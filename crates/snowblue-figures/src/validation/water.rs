//! Effect of water in the pores on the colour of the transmitted light, which the paper leaves to future work.

use snowblue_color::difference::MIDDLE_GREY;
use snowblue_color::{ColorDifference, Colorimeter, LinearRgb, Xyz};
use snowblue_transport::ordinates::{FluxSpectra, OrdinatesOptions, solve_each};
use snowblue_transport::sample::SnowSample;
use snowblue_transport::slab::{Incidence, Slab};

use crate::error::FigureError;
use crate::figure::{Drawing, Figure, FigureTable, ordinates_metadata};
use crate::plot::{Area, Axis, Chart, Entry, GREY, Panel, Stroke, Symbol, ordered_colour};
use crate::shading::{daylight, wavelengths_nm};
use crate::table::{Cell, DataTable};

const SATURATIONS: [f64; 11] = [0.0, 0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.2, 0.3, 0.5, 1.0];
/// Indices of the saturations in the table and the swatches.
const SHOWN: [usize; 8] = [1, 4, 5, 6, 7, 8, 9, 10];
const THICKNESSES_CM: [f64; 4] = [1.0, 5.0, 15.0, 30.0];
/// Just noticeable difference (Mahy et al. 1994).
const NOTICED: f64 = 2.3;
/// Lower end of the axis of ΔE.
const LEAST: f64 = 0.002;

/// The light behind snow of one wetness and thickness.
struct Light {
    saturation: f64,
    xyz: Xyz,
    from_dry: ColorDifference,
}

pub(crate) fn figure() -> Result<Figure, FigureError> {
    let wavelengths_nm = wavelengths_nm(400, 700, 10);
    let colorimeter = daylight(&wavelengths_nm)?;
    let lights = lights(wavelengths_nm, &colorimeter)?;
    let cells = |(thickness_cm, light): (f64, &Light)| {
        let ColorDifference { as_given, at_equal_luminance, at_middle_grey, .. } = light.from_dry;
        let mut row: Vec<Cell> =
            [thickness_cm, light.saturation, light.xyz.y, as_given, at_equal_luminance, at_middle_grey]
                .map(Cell::from)
                .to_vec();
        row.extend(
            [
                LinearRgb::from_xyz(light.xyz).display_hex(),
                LinearRgb::from_xyz(light.xyz.with_luminance(MIDDLE_GREY)).display_hex(),
            ]
            .map(Cell::Word),
        );
        row
    };
    let columns = [
        "thickness_cm",
        "water_saturation",
        "Y",
        "delta_e",
        "delta_e_at_equal_luminance",
        "delta_e_at_middle_grey",
        "hex",
        "hex_at_middle_grey",
    ];
    let rows = THICKNESSES_CM.iter().zip(&lights).flat_map(|(cm, lights)| lights.iter().map(|light| (*cm, light)));
    Ok(Figure {
        title: "Water in the pores and the colour behind snow",
        ours: "ΔE*ab (CIELAB, with D65 as white) of the light through wet snow against dry snow of equal dry density, \
               400 µm, facetness .3, 300 kg/m³, 0°. Left: unexposed. Right: both exposed to middle grey, which leaves \
               hue and chroma; the swatches have this exposure. Each grain is surrounded either by water or by air."
            .to_owned(),
        paper: "Leaves to future work whether water in the pores matters, and whether the table needs an axis for it."
            .to_owned(),
        drawing: Drawing::Svg(draw(&lights)),
        numbers: DataTable::new(&columns, rows.map(cells).collect()),
        tables: vec![
            table("whole", "ΔE*ab of wet against dry snow, unexposed", &lights, |difference| difference.as_given),
            table("hue", "The same, both exposed to middle grey: hue and chroma", &lights, |difference| {
                difference.at_middle_grey
            }),
            brightness(&lights),
        ],
        warning: None,
    })
}

/// The light, by thickness and saturation.
fn lights(wavelengths_nm: Vec<f64>, colorimeter: &Colorimeter) -> Result<Vec<Vec<Light>>, FigureError> {
    let sample = SnowSample::default();
    let samples = SATURATIONS.map(|water_saturation| SnowSample { water_saturation, ..sample });
    let slab = Slab {
        sample,
        thicknesses_cm: THICKNESSES_CM.to_vec(),
        incidences: vec![Incidence::Beam { angle_deg: 0.0 }],
        wavelengths_nm,
    };
    // [saturation][thickness][wavelength]
    let fluxes = solve_each(&samples, &slab, &OrdinatesOptions::default())?;
    let at_thickness = |index: usize| {
        let xyz = |of: &FluxSpectra| {
            let spectrum: Vec<f64> = of.spectrum(index, 0).iter().map(|fluxes| fluxes.transmittance).collect();
            colorimeter.xyz(&spectrum)
        };
        let dry = xyz(&fluxes[0]);
        let light = |(saturation, of): (&f64, &FluxSpectra)| {
            let xyz = xyz(of);
            Light { saturation: *saturation, xyz, from_dry: ColorDifference::between(xyz, dry, colorimeter.white()) }
        };
        SATURATIONS.iter().zip(&fluxes).map(light).collect()
    };
    Ok((0..THICKNESSES_CM.len()).map(at_thickness).collect())
}

const COLUMNS: [&str; 9] = ["cm", "1 %", "5 %", "7 %", "10 %", "20 %", "30 %", "50 %", "100 %"];

fn table(name: &'static str, title: &str, lights: &[Vec<Light>], quantity: fn(&ColorDifference) -> f64) -> FigureTable {
    let row = |(thickness_cm, lights): (&f64, &Vec<Light>)| {
        let cells = SHOWN.iter().map(|index| format!("{:.2}", quantity(&lights[*index].from_dry)));
        std::iter::once(thickness_cm.to_string()).chain(cells).collect()
    };
    FigureTable::of_words(name, title, &COLUMNS, THICKNESSES_CM.iter().zip(lights).map(row).collect())
}

fn brightness(lights: &[Vec<Light>]) -> FigureTable {
    let row = |(thickness_cm, lights): (&f64, &Vec<Light>)| {
        let cells = SHOWN.iter().map(|index| format!("{:.2}", lights[*index].xyz.y / lights[0].xyz.y));
        std::iter::once(thickness_cm.to_string()).chain(cells).collect()
    };
    let rows = THICKNESSES_CM.iter().zip(lights).map(row).collect();
    FigureTable::of_words("brightness", "Luminance over that behind dry snow", &COLUMNS, rows)
}

fn draw(lights: &[Vec<Light>]) -> String {
    let mut chart = Chart::new(900.0, 640.0, "Colour of the light through wet snow against dry snow");
    let (top, bottom) = (66.0, 340.0);
    let axes = || [Axis::logarithmic(0.01, 1.0), Axis::logarithmic(LEAST, 100.0)];
    let quantities: [fn(&ColorDifference) -> f64; 2] =
        [|difference| difference.as_given, |difference| difference.at_middle_grey];
    let names = ["ΔE*ab unexposed", "ΔE*ab at middle grey"];
    for (i, (quantity, name)) in quantities.into_iter().zip(names).enumerate() {
        let left = 84.0 + 370.0 * i as f64;
        let area = Area { left, right: left + 290.0, top, bottom };
        let panel = chart.panel(area, axes(), ["Fraction of the pores filled with water", name]);
        curves(&mut chart, &panel, lights, quantity);
    }
    let names: Vec<String> = THICKNESSES_CM.iter().map(|cm| format!("{cm} cm")).collect();
    let colours: Vec<String> = (0..names.len()).map(|i| ordered_colour(i, names.len())).collect();
    let mut entries: Vec<Entry> = names
        .iter()
        .zip(&colours)
        .map(|(name, colour)| Entry { name, symbol: Symbol::Line(Stroke::solid(colour, 2.2)) })
        .collect();
    entries.push(Entry { name: "just noticed", symbol: Symbol::Line(JUST_NOTICED) });
    chart.legend((770.0, 80.0), "Thickness", &entries);
    swatches(&mut chart, lights);
    chart.finish(&ordinates_metadata(&[("ice", "warren2008"), ("light", "D65, CIE 1931"), ("numbers", "ours")]))
}

const JUST_NOTICED: Stroke = Stroke { colour: GREY, width: 1.4, dashes: "5 4" };

fn curves(chart: &mut Chart, panel: &Panel, lights: &[Vec<Light>], quantity: fn(&ColorDifference) -> f64) {
    chart.line(panel, &[(0.01, NOTICED), (1.0, NOTICED)], JUST_NOTICED);
    for (i, lights) in lights.iter().enumerate() {
        let points: Vec<(f64, f64)> =
            lights[1..].iter().map(|light| (light.saturation, quantity(&light.from_dry))).collect();
        let colour = ordered_colour(i, THICKNESSES_CM.len());
        chart.line(panel, &points, Stroke::solid(&colour, 2.0));
        chart.dots(panel, &points, &colour);
    }
}

/// A row of swatches for each thickness, dry on the left.
fn swatches(chart: &mut Chart, lights: &[Vec<Light>]) {
    const SIZE: (f64, f64) = (68.0, 36.0);
    let (left, top) = (150.0, 448.0);
    chart.heading((84.0, 420.0), "Exposed to middle grey: dry, then by the fraction of the pores filled with water");
    for (row, (thickness_cm, lights)) in THICKNESSES_CM.iter().zip(lights).enumerate() {
        let y = top + SIZE.1 * row as f64;
        chart.text((left - 12.0, y + 23.0), &format!("{thickness_cm} cm"), "end");
        for (column, index) in std::iter::once(0).chain(SHOWN).enumerate() {
            let x = left + SIZE.0 * column as f64;
            chart.swatch(
                (x, y),
                SIZE,
                &LinearRgb::from_xyz(lights[index].xyz.with_luminance(MIDDLE_GREY)).display_hex(),
            );
            if row == 0 {
                let name = if index == 0 { "dry".to_owned() } else { format!("{:.0} %", 100.0 * SATURATIONS[index]) };
                chart.text((x + 0.5 * SIZE.0, y - 8.0), &name, "middle");
            }
        }
    }
}
