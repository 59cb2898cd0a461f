//! The paper's Fig. 3: illuminants, the transmittance of snow, and its colours from 3 and from 31 wavelengths.

use snowblue_color::difference::MIDDLE_GREY;
use snowblue_color::{ColorDifference, Illuminant, Lab, Observer, THREE_SAMPLES_NM, Xyz};
use snowblue_render::scene::film::ImageSize;
use snowblue_transport::ordinates::{self, OrdinatesOptions};
use snowblue_transport::sample::SnowSample;
use snowblue_transport::slab::{Incidence, Slab};

use crate::error::FigureError;
use crate::figure::{Drawing, Figure, FigureTable, ordinates_metadata};
use crate::plot::{Area, Axis, Chart, Entry, INK, Stroke, Symbol, ordered_colour};
use crate::shading::{common_exposure, textured_png, under, wavelengths_nm};
use crate::table::{Cell, DataTable};

const ILLUMINANTS: [&str; 5] = ["E", "D55", "D65", "LED-B5", "FL3.15"];
/// Numbers of samples.
const SAMPLES: [&str; 2] = ["3", "31"];

const OURS: &str = "All numbers, and the texture, are ours. Top left: spectra of five CIE illuminants, normalised to \
    the luminance of illuminant E of power 1 on 400–700 nm. Top right: transmittance of 15 cm of snow at 0° (400 µm, \
    facetness .3, 300 kg/m³), with the paper's three wavelengths marked: 455, 551 and 608 nm. Bottom: the light behind \
    it, summed over 3 and over 31 wavelengths, at one exposure; ΔE*ab between them is exposed to middle grey, with the \
    white of the 31. Most of it is the hue that three wavelengths give the illuminant. With the white of each's own \
    samples, the snow differs by ΔE*ab 2.27 (E), 2.47, 2.43, 2.55 and 2.19 (FL3.15) unexposed, where 2.3 is just \
    noticeable, and by 4.8 to 5.6 at middle grey.";
const PAPER: &str = "The paper reports a noticeable difference between 3 and 31 samples, a significant impact of the \
    illuminant, and that under E the colours come from the transmittance alone. Its FL-15 is taken as the CIE's \
    FL3.15.";

/// Light behind the snow under one illuminant, from 3 and from 31 samples.
struct Lamp {
    illuminant: Illuminant,
    lights: [Xyz; 2],
    white: Xyz,
    difference: ColorDifference,
    /// ΔE*ab with the white of each's own samples: unexposed, and exposed to middle grey.
    before_own_whites: [f64; 2],
}

pub(crate) fn figure() -> Result<Figure, FigureError> {
    let curves = [transmittances(THREE_SAMPLES_NM.to_vec())?, transmittances(wavelengths_nm(400, 700, 10))?];
    let lamps = ILLUMINANTS.iter().map(|name| lamp(name, &curves)).collect::<Result<Vec<_>, _>>()?;
    let spectra = ILLUMINANTS.iter().map(|name| spectrum(name)).collect::<Result<Vec<_>, _>>()?;
    Ok(Figure {
        title: "Light and the number of its samples",
        ours: OURS.to_owned(),
        paper: PAPER.to_owned(),
        drawing: Drawing::Svg(draw(&spectra, &curves, &lamps)?),
        numbers: DataTable::new(&["curve", "wavelength_nm", "value"], curves_as_drawn(&spectra, &curves)),
        tables: vec![table(&lamps), swatches_table(&lamps)],
        warning: None,
    })
}

/// Wavelengths in nm and transmittances.
fn transmittances(wavelengths_nm: Vec<f64>) -> Result<Vec<(f64, f64)>, FigureError> {
    let slab = Slab {
        sample: SnowSample::default(),
        thicknesses_cm: vec![15.0],
        incidences: vec![Incidence::Beam { angle_deg: 0.0 }],
        wavelengths_nm,
    };
    let rows = ordinates::solve_without_errors(&slab, &OrdinatesOptions::default())?;
    Ok(rows.iter().map(|row| (row.wavelength_nm, row.transmittance.value)).collect())
}

fn lamp(name: &str, curves: &[Vec<(f64, f64)>; 2]) -> Result<Lamp, FigureError> {
    let illuminant: Illuminant = name.parse()?;
    let seen = |curve: &[(f64, f64)]| -> Result<(Xyz, Xyz), FigureError> {
        let (wavelengths_nm, values): (Vec<f64>, Vec<f64>) = curve.iter().copied().unzip();
        let colorimeter = under(illuminant, &wavelengths_nm)?;
        Ok((colorimeter.xyz(&values), colorimeter.white()))
    };
    let ((few, white_of_few), (many, white)) = (seen(&curves[0])?, seen(&curves[1])?);
    let own = |few: Xyz, many: Xyz| Lab::from_xyz(few, white_of_few).delta_e_1976(Lab::from_xyz(many, white));
    Ok(Lamp {
        illuminant,
        lights: [few, many],
        white,
        difference: ColorDifference::between(few, many, white),
        before_own_whites: [own(few, many), own(few.with_luminance(MIDDLE_GREY), many.with_luminance(MIDDLE_GREY))],
    })
}

/// Power every 5 nm, normalised to a mean of 1 weighted by luminous efficiency.
fn spectrum(name: &str) -> Result<Vec<(f64, f64)>, FigureError> {
    let illuminant: Illuminant = name.parse()?;
    let wavelengths_nm = wavelengths_nm(400, 700, 5);
    let mut powers = Vec::new();
    let (mut bright, mut even) = (0.0, 0.0);
    for &nm in &wavelengths_nm {
        let power = illuminant.relative_power(nm)?;
        let eye = Observer::Cie1931.color_matching(nm)?.y;
        (bright, even) = (bright + power * eye, even + eye);
        powers.push(power);
    }
    Ok(wavelengths_nm.into_iter().zip(powers.into_iter().map(|power| power * even / bright)).collect())
}

impl Lamp {
    fn cells(&self, which: usize) -> Vec<Cell> {
        let Xyz { x, y, z } = self.lights[which];
        let rgb = snowblue_color::LinearRgb::from_xyz(self.lights[which]);
        let mut cells = [self.illuminant.name(), SAMPLES[which]].map(|word| Cell::Word(word.to_owned())).to_vec();
        cells.extend([x, y, z, rgb.r, rgb.g, rgb.b].map(Cell::from));
        cells
    }
}

fn table(lamps: &[Lamp]) -> FigureTable {
    let row = |lamp: &Lamp| {
        let mut cells = vec![lamp.illuminant.name().to_owned()];
        for light in lamp.lights {
            let lab = Lab::from_xyz(light, lamp.white);
            cells.extend([
                format!("{:.4}", light.y),
                format!("{:.1}", lab.l),
                format!("{:.1}", lab.chroma()),
                format!("{:.0}", lab.hue_deg()),
            ]);
        }
        cells.extend(
            [lamp.difference.as_given, lamp.difference.at_middle_grey, lamp.difference.at_middle_grey_2000]
                .into_iter()
                .chain(lamp.before_own_whites)
                .map(|value| format!("{value:.2}")),
        );
        cells
    };
    let columns = [
        "light",
        "Y 3",
        "L* 3",
        "C* 3",
        "h° 3",
        "Y 31",
        "L* 31",
        "C* 31",
        "h° 31",
        "ΔE*ab",
        "ΔE*ab, middle grey",
        "ΔE2000, middle grey",
        "ΔE*ab, own whites",
        "ΔE*ab, own whites, middle grey",
    ];
    let title = "3 and 31 samples: CIELAB with the white of 31, and differences with it and with the whites of each's \
                 own samples";
    FigureTable::of_words("samples", title, &columns, lamps.iter().map(row).collect())
}

fn swatches_table(lamps: &[Lamp]) -> FigureTable {
    let columns = ["illuminant", "samples", "X", "Y", "Z", "r_linear", "g_linear", "b_linear"];
    let rows = lamps.iter().flat_map(|lamp| [0, 1].map(|which| lamp.cells(which))).collect();
    FigureTable {
        name: "swatches",
        title: "The light of the swatches".to_owned(),
        data: DataTable::new(&columns, rows),
    }
}

/// Powers of the illuminants every 5 nm, then the transmittances at 3 and at 31 wavelengths.
fn curves_as_drawn(spectra: &[Vec<(f64, f64)>], curves: &[Vec<(f64, f64)>; 2]) -> Vec<Vec<Cell>> {
    let names = ILLUMINANTS.map(|name| format!("relative power of {name}")).into_iter();
    let names = names.chain(SAMPLES.map(|samples| format!("transmittance of {samples} samples")));
    let rows = |(name, curve): (String, &Vec<(f64, f64)>)| -> Vec<Vec<Cell>> {
        curve.iter().map(|&(nm, value)| vec![Cell::Word(name.clone()), nm.into(), value.into()]).collect()
    };
    names.zip(spectra.iter().chain(curves)).flat_map(rows).collect()
}

fn draw(spectra: &[Vec<(f64, f64)>], curves: &[Vec<(f64, f64)>; 2], lamps: &[Lamp]) -> Result<String, FigureError> {
    let mut chart = Chart::new(900.0, 726.0, "Light through snow, by 3 and by 31 samples");
    chart.text((24.0, 56.0), "400 µm, facetness 0.3, 300 kg/m³, 15 cm, 0°", "start");
    let (top, bottom) = (84.0, 330.0);
    let axis = || Axis::linear(400.0, 700.0, 6.0);
    let left = Area { left: 84.0, right: 400.0, top, bottom };
    let powers = spectra.iter().flatten().map(|(_, power)| *power).fold(0.0, f64::max);
    let power =
        chart.panel(left, [axis(), Axis::linear_to_marks(0.0, powers, 5.0)], ["Wavelength (nm)", "Relative power"]);
    let colours: Vec<String> = (0..spectra.len()).map(|i| ordered_colour(i, spectra.len())).collect();
    for (spectrum, colour) in spectra.iter().zip(&colours) {
        chart.line(&power, spectrum, Stroke::solid(colour, 1.8));
    }
    let entries: Vec<Entry> = ILLUMINANTS
        .iter()
        .zip(&colours)
        .map(|(name, colour)| Entry { name, symbol: Symbol::Line(Stroke::solid(colour, 2.2)) })
        .collect();
    chart.legend((306.0, 106.0), "", &entries);
    let right = Area { left: 520.0, right: 836.0, top, bottom };
    let highest = curves[1].iter().map(|(_, passed)| *passed).fold(0.0, f64::max);
    let passed =
        chart.panel(right, [axis(), Axis::linear_to_marks(0.0, highest, 4.0)], ["Wavelength (nm)", "Transmittance"]);
    chart.line(&passed, &curves[1], Stroke::solid(INK, 2.0));
    chart.sized_dots(&passed, &curves[1], INK, 2.4);
    chart.sized_dots(&passed, &curves[0], "#c2410c", 5.0);
    let entries = [
        Entry { name: "31 samples", symbol: Symbol::Dot(INK) },
        Entry { name: "3 samples", symbol: Symbol::Dot("#c2410c") },
    ];
    chart.legend((700.0, 106.0), "", &entries);
    swatches(&mut chart, lamps)?;
    Ok(chart.finish(&ordinates_metadata(&[("ice", "warren2008"), ("observer", "CIE 1931"), ("numbers", "ours")])))
}

/// A row for each number of samples, a column for each illuminant.
fn swatches(chart: &mut Chart, lamps: &[Lamp]) -> Result<(), FigureError> {
    const SIZE: (f64, f64) = (146.0, 98.0);
    const PIXELS: ImageSize = ImageSize { width: 146, height: 98 };
    let (left, top) = (100.0, 440.0);
    let factor = common_exposure(lamps.iter().flat_map(|lamp| lamp.lights));
    for (which, name) in SAMPLES.iter().enumerate() {
        let y = top + (SIZE.1 + 5.0) * which as f64;
        chart.text((left - 12.0, y + 0.5 * SIZE.1 + 4.0), &format!("n = {name}"), "end");
        for (column, lamp) in lamps.iter().enumerate() {
            let x = left + (SIZE.0 + 5.0) * column as f64;
            chart.image((x, y), SIZE, &textured_png(lamp.lights[which], factor, PIXELS)?);
            let middle = x + 0.5 * SIZE.0;
            if which == 0 {
                chart.text((middle, y - 10.0), lamp.illuminant.name(), "middle");
            } else {
                let difference = format!("ΔE*ab {:.1}", lamp.difference.at_middle_grey);
                chart.text((middle, y + SIZE.1 + 20.0), &difference, "middle");
            }
        }
    }
    let stops = format!("exposure +{:.2} stops", factor.log2());
    chart.heading((left, top - 34.0), &format!("The light behind it, {stops} for all"));
    Ok(())
}
