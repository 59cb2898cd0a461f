//! Spectra out of CSV files, for colours: two columns, or what `snowblue spectrum` writes.

use std::path::Path;

use snowblue_color::sampling::{Interpolation, SampledSpectrum};

use crate::colored;
use crate::failure::Failure;
use crate::parse;
use crate::source::Source;

/// Widest step of a spectrum that is summed to a colour, in nm.
const MOST_STEP_NM: f64 = 20.0;
/// What a sum covers, in nm.
const SUM_NM: (f64, f64) = (400.0, 700.0);
/// Wavelengths as near as this are the same, in nm: far below any step, far above rounding.
const SAME_NM: f64 = 1e-6;

/// One spectrum, and what the file says of it.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Curve {
    /// Thickness in cm and angle in degrees, as words; empty where the file has none.
    pub(crate) place: [String; 2],
    pub(crate) wavelengths_nm: Vec<f64>,
    pub(crate) values: Vec<f64>,
    /// The line of the file on which it starts, from 1.
    line: usize,
}

/// Which fields of a row count.
struct Fields {
    count: usize,
    place: [Option<usize>; 2],
    wavelength: usize,
    value: usize,
}

/// Reads the curves of a file: `wavelength_nm,value` rows, with or without a header, or rows under a header that has
/// `wavelength_nm` and `quantity`. A curve ends where thickness or angle change or the wavelength does not ascend.
pub(crate) fn read(path: &Path, quantity: &str) -> Result<Vec<Curve>, Failure> {
    let text = Source::read(path)?;
    let text = text.trim_start_matches('\u{feff}');
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()).peekable();
    let mut fields = Fields { count: 2, place: [None, None], wavelength: 0, value: 1 };
    if let Some((number, line)) = lines.next_if(|(_, line)| line.trim_start().starts_with(|c: char| c.is_alphabetic()))
    {
        fields = Fields::of_header(line, quantity).map_err(|why| failure(path, number, &why))?;
    }
    let mut curves: Vec<Curve> = Vec::new();
    for (number, line) in lines {
        let (place, wavelength_nm, value) = fields.row(line).map_err(|why| failure(path, number, &why))?;
        let goes_on = |curve: &Curve| {
            curve.place == place && curve.wavelengths_nm.last().is_some_and(|last| *last < wavelength_nm)
        };
        if fields.count == 2 && !curves.is_empty() || curves.last().is_some_and(goes_on) {
            let last = curves.len() - 1;
            curves[last].wavelengths_nm.push(wavelength_nm);
            curves[last].values.push(value);
        } else {
            let line = number + 1;
            curves.push(Curve { place, wavelengths_nm: vec![wavelength_nm], values: vec![value], line });
        }
    }
    if curves.is_empty() {
        return Err(Failure::Input(format!("{}: holds no spectrum", path.display())));
    }
    let summed = |curve: Curve| {
        let line = curve.line - 1;
        curve.within_the_sum().map_err(|why| failure(path, line, &why))
    };
    curves.into_iter().map(summed).collect()
}

/// That something is wrong with line `number`, counted from 0.
fn failure(path: &Path, number: usize, why: &str) -> Failure {
    Failure::Input(format!("{}:{}: {why}", path.display(), number + 1))
}

impl Fields {
    /// Two columns mean what they mean whatever they are called.
    fn of_header(line: &str, quantity: &str) -> Result<Self, String> {
        let names: Vec<&str> = line.split(',').map(str::trim).collect();
        let find = |wanted: &str| names.iter().position(|name| *name == wanted);
        let found = (find("wavelength_nm"), find(quantity));
        let (wavelength, value) = match found {
            (Some(wavelength), Some(value)) => (wavelength, value),
            _ if names.len() == 2 => (0, 1),
            _ => return Err(format!("expected the columns wavelength_nm and {quantity}, but found '{line}'")),
        };
        Ok(Self { count: names.len(), place: [find("thickness_cm"), find("angle_deg")], wavelength, value })
    }

    fn row(&self, line: &str) -> Result<([String; 2], f64, f64), String> {
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        let wrong = || format!("expected a wavelength in nm and a value of 0 or more, but found '{line}'");
        if fields.len() != self.count {
            return Err(if self.count == 2 {
                wrong()
            } else {
                format!("expected {} fields, but found {}", self.count, fields.len())
            });
        }
        let number = |place: usize| parse::number(fields[place]).ok().filter(|number| number.is_finite());
        let (Some(wavelength_nm), Some(value)) = (number(self.wavelength), number(self.value)) else {
            return Err(wrong());
        };
        if value < 0.0 {
            return Err(wrong());
        }
        Ok((
            self.place.map(|place| place.map_or_else(String::new, |place| fields[place].to_owned())),
            wavelength_nm,
            value,
        ))
    }
}

impl Curve {
    /// The curve on the wavelengths that a sum over 400–700 nm takes: its own where they are in equal steps from end to end,
    /// else those of 31 samples, by straight lines.
    fn within_the_sum(self) -> Result<Self, String> {
        check_coverage(&self.wavelengths_nm)?;
        let (first_nm, last_nm) = SUM_NM;
        let inside = |nm: &f64| (first_nm - SAME_NM..=last_nm + SAME_NM).contains(nm);
        let (own_nm, values): (Vec<f64>, Vec<f64>) =
            self.wavelengths_nm.iter().copied().zip(self.values.iter().copied()).filter(|(nm, _)| inside(nm)).unzip();
        if in_equal_steps(&own_nm) {
            return Ok(Self { wavelengths_nm: own_nm, values, ..self });
        }
        let onto_nm = colored::wavelengths_nm("31");
        let spectrum = SampledSpectrum { wavelengths_nm: &self.wavelengths_nm, values: &self.values };
        let resampled = spectrum.resample(&onto_nm, Interpolation::Linear);
        Ok(Self { values: resampled.map_err(|error| error.to_string())?, wavelengths_nm: onto_nm, ..self })
    }
}

/// Whether wavelengths go from one end of the sum to the other in equal steps.
fn in_equal_steps(wavelengths_nm: &[f64]) -> bool {
    let (first_nm, last_nm) = SUM_NM;
    let [first, .., last] = *wavelengths_nm else { return false };
    let step_nm = (last - first) / (wavelengths_nm.len() - 1) as f64;
    let equal = wavelengths_nm.windows(2).all(|pair| (pair[1] - pair[0] - step_nm).abs() <= SAME_NM);
    equal && (first - first_nm).abs() <= SAME_NM && (last - last_nm).abs() <= SAME_NM
}

/// Checks that a sum over the wavelengths is a colour: ascending, close enough within 400–700 nm, and as wide.
fn check_coverage(wavelengths_nm: &[f64]) -> Result<(), String> {
    let (first_nm, last_nm) = SUM_NM;
    for pair in wavelengths_nm.windows(2) {
        if pair[1] <= pair[0] {
            return Err(format!("the wavelengths must ascend, but {} nm follows {} nm", pair[1], pair[0]));
        }
        if pair[1] - pair[0] > MOST_STEP_NM + SAME_NM && pair[1] > first_nm && pair[0] < last_nm {
            let (low, high) = (pair[0], pair[1]);
            return Err(format!(
                "{high} nm follows {low} nm, but steps within 400–700 nm must be at most {MOST_STEP_NM} nm"
            ));
        }
    }
    let (first, last) = (wavelengths_nm[0], wavelengths_nm[wavelengths_nm.len() - 1]);
    if first > first_nm || last < last_nm {
        return Err(format!("the wavelengths are {first}–{last} nm, but must cover 400–700 nm"));
    }
    Ok(())
}
