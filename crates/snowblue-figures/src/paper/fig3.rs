//! The paper's Fig. 3: illuminants, the transmittance of snow, and its colours from 3 and from 31 wavelengths.

use snowblue_color::lab::MIDDLE_GREY;
use snowblue_color::{ColorDifference, Colorimeter, Illuminant, Lab, Observer, THREE_SAMPLES_NM, Xyz};
use snowblue_transport::optics::Wavelengths;
use snowblue_transport::ordinates::{self, OrdinatesOptions};
use snowblue_transport::sample::SnowSample;
use snowblue_transport::slab::{Incidence, Slab};

use super::swatches::{self, Exposed};
use crate::figure::{Figure, FigureError, Picture, metadata};
use crate::plot::{Area, Axis, Chart, HEADING, INK, LABEL, Stroke, ordered_colours};
use crate::table::{Cell, DataTable};

const ILLUMINANTS: [&str; 5] = ["E", "D55", "D65", "LED-B5", "FL3.15"];
/// Numbers of samples.
const SAMPLES: [&str; 2] = ["3", "31"];
const SNOW: &str = "15 cm of snow at 0°: 400 µm, facetness 0.3, 300 kg/m³";

const OURS: &str = "The light behind 15 cm of snow, summed over the paper's three wavelengths (455, 551, 608 nm) and \
    over 31. Most of the difference is the hue that three wavelengths give the illuminant: with the white of each's \
    own samples, the snow differs by 2.2 to 2.6 unexposed, where 2.3 is just noticeable.";
const PAPER: &str = "A noticeable difference between 3 and 31 samples, and a significant impact of the illuminant. Its \
    FL-15 is taken as the CIE's FL3.15.";

/// Wavelengths, in nm, and values.
type Curve = Vec<(f64, f64)>;

/// Light behind the snow under one illuminant, from 3 and from 31 samples.
struct IlluminantComparison {
    power: Curve,
    lights: [Xyz; 2],
    difference: ColorDifference,
    /// ΔE*ab, where the white of each colour is computed with the samples of that colour: unexposed, and exposed to
    /// middle grey.
    own_whites: [f64; 2],
}

pub(crate) fn figure() -> Result<Figure, FigureError> {
    let curves = [transmittances(THREE_SAMPLES_NM.to_vec())?, transmittances(Wavelengths::visible().0)?];
    let lamps = ILLUMINANTS.iter().map(|name| lamp(name, &curves)).collect::<Result<Vec<_>, _>>()?;
    let powers = ILLUMINANTS.iter().map(|name| format!("relative power of {name}"));
    let names = powers.chain(SAMPLES.map(|samples| format!("transmittance of {samples} samples")));
    let rows = names.zip(lamps.iter().map(|lamp| &lamp.power).chain(&curves)).flat_map(|(name, curve)| {
        curve.iter().map(move |(nm, value)| vec![Cell::word(&name), (*nm).into(), (*value).into()])
    });
    Ok(Figure {
        title: "Light and the number of its samples",
        ours: OURS.to_owned(),
        paper: PAPER,
        pictures: Picture::drawing(draw(&curves, &lamps)),
        numbers: DataTable::new(&["curve", "wavelength_nm", "value"], rows.collect()),
        table: Some(("The light of 3 and of 31 samples, and ΔE*ab between them", table(&lamps))),
        warning: None,
    })
}

fn transmittances(wavelengths_nm: Vec<f64>) -> Result<Curve, FigureError> {
    let slab = Slab {
        sample: SnowSample::default(),
        thicknesses_cm: vec![15.0],
        incidences: vec![Incidence::Beam { angle_deg: 0.0 }],
        wavelengths_nm,
    };
    let rows = ordinates::solve_without_errors(&slab, &OrdinatesOptions::default())?;
    Ok(rows.iter().map(|row| (row.wavelength_nm, row.fluxes.transmittance.value)).collect())
}

fn lamp(name: &str, curves: &[Curve; 2]) -> Result<IlluminantComparison, FigureError> {
    let illuminant: Illuminant = name.parse()?;
    let seen = |curve: &Curve| -> Result<(Xyz, Xyz), FigureError> {
        let (wavelengths_nm, values): (Vec<f64>, Vec<f64>) = curve.iter().copied().unzip();
        let colorimeter = Colorimeter::new(Observer::Cie1931, illuminant, &wavelengths_nm)?;
        Ok((colorimeter.xyz(&values), colorimeter.white()))
    };
    let ((few, white_of_few), (many, white)) = (seen(&curves[0])?, seen(&curves[1])?);
    let own = |few: Xyz, many: Xyz| Lab::from_xyz(few, white_of_few).delta_e_1976(Lab::from_xyz(many, white));
    // Powers have a mean of 1, weighted by luminous efficiency.
    let (mut power, mut bright, mut even) = (Vec::new(), 0.0, 0.0);
    for nm in (400..=700).step_by(5).map(f64::from) {
        let (eye, value) = (Observer::Cie1931.color_matching(nm)?.y, illuminant.relative_power(nm)?);
        (bright, even) = (bright + value * eye, even + eye);
        power.push((nm, value));
    }
    Ok(IlluminantComparison {
        power: power.into_iter().map(|(nm, value)| (nm, value * even / bright)).collect(),
        lights: [few, many],
        difference: ColorDifference::between(few, many, white),
        own_whites: [own(few, many), own(few.with_luminance(MIDDLE_GREY), many.with_luminance(MIDDLE_GREY))],
    })
}

fn table(lamps: &[IlluminantComparison]) -> DataTable {
    let row = |(name, lamp): (&&str, &IlluminantComparison)| {
        let IlluminantComparison { lights: [few, many], difference, own_whites, .. } = lamp;
        let lights = [few, many].into_iter().flat_map(|light| [light.x, light.y, light.z]);
        let numbers = lights.chain([difference.as_given, difference.at_middle_grey]).chain(*own_whites);
        [Cell::word(*name)].into_iter().chain(numbers.map(Cell::from)).collect()
    };
    let columns = [
        "light",
        "X 3",
        "Y 3",
        "Z 3",
        "X 31",
        "Y 31",
        "Z 31",
        "ΔE*ab",
        "at middle grey",
        "own whites",
        "own whites at middle grey",
    ];
    DataTable::new(&columns, ILLUMINANTS.iter().zip(lamps).map(row).collect()).rounded(4)
}

fn draw(curves: &[Curve; 2], lamps: &[IlluminantComparison]) -> String {
    const FEW: &str = "#c2410c";
    let mut chart = Chart::new(900.0, 690.0, "Light through snow, by 3 and by 31 samples");
    chart.text((24.0, 58.0), SNOW, LABEL);
    let (top, bottom) = (84.0, 330.0);
    let nm = || Axis::linear(400.0, 700.0, 3.0);
    let highest = |curve: &Curve| curve.iter().map(|(_, value)| *value).fold(0.0, f64::max);
    let most = lamps.iter().map(|lamp| highest(&lamp.power)).fold(0.0, f64::max);
    let area = Area { left: 88.0, right: 328.0, top, bottom };
    let power = Axis::linear_to_marks(0.0, most, 5.0);
    let panel = chart.panel(area, [nm(), power], ["Wavelength (nm)", "Relative power"]);
    let colours = ordered_colours(lamps.len());
    for (lamp, colour) in lamps.iter().zip(&colours) {
        chart.curve(&panel.points(&lamp.power), Stroke::solid(colour, 1.8));
    }
    let entries: Vec<_> = ILLUMINANTS
        .iter()
        .zip(&colours)
        .map(|(name, colour)| ((*name).to_owned(), Stroke::solid(colour, 2.2)))
        .collect();
    chart.legend((344.0, 96.0), "", &entries);
    let area = Area { left: 514.0, right: 754.0, top, bottom };
    let passed = Axis::linear_to_marks(0.0, highest(&curves[1]), 4.0);
    let panel = chart.panel(area, [nm(), passed], ["Wavelength (nm)", "Transmittance"]);
    let strokes = [Stroke::solid(FEW, 1.4), Stroke::solid(INK, 2.0)];
    for ((curve, stroke), radius) in curves.iter().zip(strokes).zip([4.5, 2.2]) {
        chart.curve(&panel.points(curve), stroke);
        chart.dots(&panel.points(curve), radius, stroke.colour);
    }
    let entries: Vec<_> = SAMPLES.map(|name| format!("{name} samples")).into_iter().zip(strokes).collect();
    chart.legend((770.0, 96.0), "", &entries);
    let exposed = Exposed::together(lamps.iter().flat_map(|lamp| lamp.lights));
    let columns: Vec<String> = ILLUMINANTS
        .iter()
        .zip(lamps)
        .map(|(name, lamp)| format!("{name}, ΔE*ab {:.1}", lamp.difference.at_middle_grey))
        .collect();
    let row = |which: usize| {
        let colours = lamps.iter().map(|lamp| exposed.colour(lamp.lights[which])).collect();
        (format!("n = {}", SAMPLES[which]), colours)
    };
    let heading = format!("The light behind the snow, {}; ΔE*ab at middle grey", exposed.words());
    chart.text((24.0, 404.0), &heading, HEADING);
    swatches::draw(&mut chart, (88.0, 440.0), (150.0, 98.0), &columns, &[row(0), row(1)]);
    let made = [("engine", "discrete ordinates"), ("ice", "warren2008"), ("observer", "CIE 1931")];
    chart.finish(&metadata(&made))
}
