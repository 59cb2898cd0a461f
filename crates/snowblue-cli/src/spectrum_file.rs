//! Spectra out of CSV files, for colours: two columns, or what `snowblue spectrum` writes.

use std::path::Path;

use crate::failure::Failure;
use crate::parse;
use crate::source::Source;

/// Widest step of a spectrum that is summed to a colour, in nm.
const MOST_STEP_NM: f64 = 20.0;

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
    for curve in &curves {
        check_spacing(&curve.wavelengths_nm).map_err(|why| failure(path, curve.line - 1, &why))?;
    }
    Ok(curves)
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

/// Checks that sums over the wavelengths are a colour: equal steps, close and wide enough.
fn check_spacing(wavelengths_nm: &[f64]) -> Result<(), String> {
    let [first, second, .., last] = *wavelengths_nm else {
        return Err("a colour needs values from 400 to 700 nm in equal steps of 20 nm at the most".to_owned());
    };
    let step = second - first;
    if let Some(pair) = wavelengths_nm.windows(2).find(|pair| (pair[1] - pair[0] - step).abs() > 1e-6) {
        return Err(format!("the wavelengths must ascend in equal steps, but {} nm follows {} nm", pair[1], pair[0]));
    }
    if !(step > 0.0 && step <= MOST_STEP_NM) {
        return Err(format!("the wavelengths are {step} nm apart, but must be in 0–{MOST_STEP_NM} nm"));
    }
    if first > 400.0 || last < 700.0 {
        return Err(format!("the wavelengths are {first}–{last} nm, but must cover 400–700 nm"));
    }
    Ok(())
}
