//! Colour errors of simpler models of light through snow.

use snowblue_color::ColorDifference;
use snowblue_transport::ordinates::OrdinatesOptions;
use snowblue_transport::sample::SnowSample;
use snowblue_transport::simplification::{Simplification, Simplifier};
use snowblue_transport::slab::{Incidence, Slab};

use crate::error::FigureError;
use crate::figure::{Drawing, Figure, FigureTable, ordinates_metadata};
use crate::plot::{Area, Axis, Chart, Entry, Fill, GREY, Stroke, Symbol, ordered_colour};
use crate::shading::{daylight, wavelengths_nm};
use crate::table::{Cell, DataTable};

const THICKNESSES_CM: [f64; 3] = [5.0, 15.0, 30.0];
const ANGLES_DEG: [f64; 3] = [0.0, 60.0, 80.0];
/// Wavelengths whose transmittance is compared, in nm.
const COMPARED_NM: [f64; 3] = [450.0, 550.0, 650.0];
/// Index in `THICKNESSES_CM` of the table of transmittance.
const MIDDLE: usize = 1;
const NOTICED: f64 = 2.3;

/// Errors of a simplification behind one slab.
struct Cost {
    difference: ColorDifference,
    /// Relative error of the transmittance at each of the compared wavelengths.
    errors: Vec<f64>,
}

/// A simplification at one angle, with its errors for each thickness.
struct Case {
    simplification: Simplification,
    angle_deg: f64,
    costs: Vec<Cost>,
}

pub(crate) fn figure() -> Result<Figure, FigureError> {
    let cases = cases()?;
    let row = |case: &Case, index: usize| {
        let Cost { difference, errors } = &case.costs[index];
        let mut row = vec![
            Cell::Word(case.simplification.name().to_owned()),
            case.angle_deg.into(),
            THICKNESSES_CM[index].into(),
        ];
        row.extend([difference.as_given, difference.at_equal_luminance, difference.at_middle_grey].map(Cell::from));
        row.extend(errors.iter().map(|error| Cell::from(*error)));
        row
    };
    let columns = [
        "simplification",
        "angle_deg",
        "thickness_cm",
        "delta_e",
        "delta_e_at_equal_luminance",
        "delta_e_at_middle_grey",
        "relative_error_450",
        "relative_error_550",
        "relative_error_650",
    ];
    let rows = cases.iter().flat_map(|case| (0..THICKNESSES_CM.len()).map(move |index| row(case, index)));
    Ok(Figure {
        title: "Errors of simplifications",
        ours: "ΔE*ab (CIELAB, with D65 as white) of the light through 5, 15 and 30 cm of snow (400 µm, facetness .3, \
               300 kg/m³) by a simpler model against the complete one, unexposed and with both exposed to middle grey. \
               The other table of ice, Picard 2016 instead of Warren & Brandt 2008, is included for scale."
            .to_owned(),
        paper: "Names two simplifications of other renderers, a constant index of refraction and ice that does not \
                absorb, and says that they hinder prediction; it gives no numbers."
            .to_owned(),
        drawing: Drawing::Svg(draw(&cases)),
        numbers: DataTable::new(&columns, rows.collect()),
        tables: vec![colours(&cases), transmittances(&cases)],
        warning: None,
    })
}

fn cases() -> Result<Vec<Case>, FigureError> {
    let slab = Slab {
        sample: SnowSample::default(),
        thicknesses_cm: THICKNESSES_CM.to_vec(),
        incidences: ANGLES_DEG.map(|angle_deg| Incidence::Beam { angle_deg }).to_vec(),
        wavelengths_nm: wavelengths_nm(400, 700, 10),
    };
    let colorimeter = daylight(&slab.wavelengths_nm)?;
    let simplifier = Simplifier::new(&slab, &OrdinatesOptions::default())?;
    let exact = simplifier.transmittance(Simplification::Exact);
    let index_of =
        |nm: f64| slab.wavelengths_nm.iter().position(|known_nm| (known_nm - nm).abs() < 1e-9).unwrap_or_default();
    let mut cases = Vec::new();
    for simplification in Simplification::ALL {
        let simple = simplifier.transmittance(simplification);
        let angles = if is_two_stream(simplification) { ANGLES_DEG.len() } else { 1 };
        for (angle, angle_deg) in ANGLES_DEG.into_iter().enumerate().take(angles) {
            let cost = |thickness: usize| {
                let case = thickness * ANGLES_DEG.len() + angle;
                let (simple, exact) = (&simple[case], &exact[case]);
                let difference =
                    ColorDifference::between(colorimeter.xyz(simple), colorimeter.xyz(exact), colorimeter.white());
                let error = |nm: &f64| simple[index_of(*nm)] / exact[index_of(*nm)] - 1.0;
                Cost { difference, errors: COMPARED_NM.iter().map(error).collect() }
            };
            cases.push(Case { simplification, angle_deg, costs: (0..THICKNESSES_CM.len()).map(cost).collect() });
        }
    }
    Ok(cases)
}

/// Only the errors of these depend much on the angle.
fn is_two_stream(simplification: Simplification) -> bool {
    matches!(simplification, Simplification::TwoOrdinates | Simplification::DeltaEddington)
}

fn name(case: &Case) -> String {
    if is_two_stream(case.simplification) {
        format!("{} {}°", case.simplification.name(), case.angle_deg)
    } else {
        case.simplification.name().to_owned()
    }
}

fn colours(cases: &[Case]) -> FigureTable {
    let row = |case: &Case| {
        let mut cells = vec![name(case)];
        cells.extend(case.costs.iter().map(|cost| format!("{:.2}", cost.difference.as_given)));
        cells.extend(case.costs.iter().map(|cost| format!("{:.2}", cost.difference.at_middle_grey)));
        cells
    };
    let columns = ["ΔE*ab", "5 cm", "15 cm", "30 cm", "5 cm grey", "15 cm grey", "30 cm grey"];
    let title = "ΔE*ab of a simpler model, unexposed and exposed to middle grey";
    FigureTable::of_words("colour", title, &columns, cases.iter().map(row).collect())
}

fn transmittances(cases: &[Case]) -> FigureTable {
    let row = |case: &Case| {
        let cells = case.costs[MIDDLE].errors.iter().map(|error| format!("{:+.2}", 100.0 * error));
        std::iter::once(name(case)).chain(cells).collect()
    };
    let columns = ["error of T in %", "450 nm", "550 nm", "650 nm"];
    let title = "Relative error of the transmittance of 15 cm, in %";
    FigureTable::of_words("transmittance", title, &columns, cases.iter().map(row).collect())
}

fn draw(cases: &[Case]) -> String {
    const LEAST: f64 = 0.01;
    let height = 34.0 * cases.len() as f64;
    let mut chart = Chart::new(980.0, height + 150.0, "Errors of simplifications in the colour of transmitted light");
    let count = cases.len() as f64;
    let titles = ["ΔE*ab unexposed", "ΔE*ab at middle grey"];
    let quantities: [fn(&ColorDifference) -> f64; 2] =
        [|difference| difference.as_given, |difference| difference.at_middle_grey];
    for (i, (title, quantity)) in titles.into_iter().zip(quantities).enumerate() {
        let left = 200.0 + 340.0 * i as f64;
        let area = Area { left, right: left + 310.0, top: 66.0, bottom: 66.0 + height };
        let rows = Axis { marks: Vec::new(), ..Axis::linear(0.0, count, 1.0) };
        let panel = chart.panel(area, [Axis::logarithmic(LEAST, 50.0), rows], [title, ""]);
        chart.line(&panel, &[(NOTICED, 0.0), (NOTICED, count)], JUST_NOTICED);
        for (number, case) in cases.iter().enumerate() {
            let foot = count - number as f64 - 1.0;
            for (index, cost) in case.costs.iter().enumerate() {
                let upper = foot + 0.86 - 0.25 * index as f64;
                let value = quantity(&cost.difference);
                chart.bar(&panel, value, upper - 0.22..upper, &ordered_colour(index, THICKNESSES_CM.len()));
                chart.value_text(&panel, (value.max(LEAST), upper - 0.2), &short(value));
            }
            if i == 0 {
                chart.text((left - 10.0, panel.height_of(foot + 0.5) + 4.0), &name(case), "end");
            }
        }
    }
    let names: Vec<String> = THICKNESSES_CM.iter().map(|cm| format!("{cm} cm")).collect();
    let colours: Vec<String> = (0..names.len()).map(|i| ordered_colour(i, names.len())).collect();
    let mut entries: Vec<Entry> = names
        .iter()
        .zip(&colours)
        .map(|(name, colour)| Entry { name, symbol: Symbol::Band(Fill { colour, opacity: 1.0 }) })
        .collect();
    entries.push(Entry { name: "noticed", symbol: Symbol::Line(JUST_NOTICED) });
    chart.legend((880.0, 80.0), "Thickness", &entries);
    chart.finish(&ordinates_metadata(&[("ice", "warren2008"), ("light", "D65, CIE 1931"), ("numbers", "ours")]))
}

const JUST_NOTICED: Stroke = Stroke { colour: GREY, width: 1.4, dashes: "5 4" };

/// A number with two digits.
fn short(value: f64) -> String {
    if value < 0.005 {
        return "< 0.01".to_owned();
    }
    if value >= 10.0 {
        format!("{value:.0}")
    } else if value >= 1.0 {
        format!("{value:.1}")
    } else {
        format!("{value:.2}")
    }
}
