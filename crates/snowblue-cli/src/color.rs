//! `snowblue color`: the colour of the light that comes through.

use std::path::{Path, PathBuf};

use clap::Args;
use snowblue_color::{Colorimeter, Lab, LinearRgb, Observer, Srgb8};
use snowblue_render::FalseColor;
use snowblue_transport::ordinates;
use snowblue_transport::slab::Radiometry;

use crate::failure::{Failure, Outcome};
use crate::options::{LightOptions, OrdinatesWords, OutputOptions, SampleOptions, SlabOptions, incidence_name};
use crate::parse::{self, Wavelengths};
use crate::report::{Cell, Report};

/// The paper's three sample wavelengths, in nm.
const THREE_SAMPLES_NM: [f64; 3] = [455.0, 551.0, 608.0];

/// Widest step of a spectrum that is summed to a colour, in nm.
const MOST_STEP_NM: f64 = 20.0;

const COLUMNS: [&str; 13] = [
    "thickness_cm",
    "angle_deg",
    "illuminant",
    "X",
    "Y",
    "Z",
    "L",
    "a",
    "b",
    "r_linear",
    "g_linear",
    "b_linear",
    "hex",
];

/// Columns of false colours, which no eye sees: they have no illuminant, XYZ or CIELAB.
const FALSE_COLUMNS: [&str; 6] = ["thickness_cm", "angle_deg", "r_linear", "g_linear", "b_linear", "hex"];

/// XYZ, CIELAB, linear sRGB and hex of the light that comes through snow
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "The bare light has Y = 1 and is the white of CIELAB; there is no chromatic adaptation.
A false colour is the transmittance at three wavelengths, 1 being white, without illuminant, XYZ and CIELAB.

Examples:
  snowblue color --thickness 5,10,15,30 --illuminant D65
  snowblue color --thickness 0.5,1,2 --false-color 1030,860,550
  snowblue color --spectrum measured.csv --illuminant E    (columns wavelength_nm,value; 400–700 nm in equal
                                                           steps of 20 nm at the most)"
)]
pub(crate) struct Color {
    #[command(flatten)]
    sample: SampleOptions,
    #[command(flatten)]
    slab: SlabOptions,
    #[command(flatten)]
    ordinates: OrdinatesWords,
    #[command(flatten)]
    light: LightOptions,
    /// Wavelengths to sum over: 31 (400–700 nm) or 3 (455, 551, 608 nm)
    #[arg(long, value_name = "N", default_value = "31", value_parser = ["31", "3"], help_heading = "Light")]
    samples: String,
    /// Light of three wavelengths in nm as red, green and blue [300–2500; 1030,860,550 if none are given]
    #[arg(
        long, value_name = "R,G,B", num_args = 0..=1, default_missing_value = parse::FALSE_COLOR_NM,
        value_parser = parse::false_color, help_heading = "Light", conflicts_with_all = ["illuminant", "samples"]
    )]
    false_color: Option<FalseColor>,
    /// Colour of a spectrum in a CSV file (wavelength_nm,value) instead of snow
    #[arg(
        long, value_name = "FILE",
        conflicts_with_all = ["SampleOptions", "SlabOptions", "OrdinatesWords", "samples", "false_color"]
    )]
    spectrum: Option<PathBuf>,
    #[command(flatten)]
    output: OutputOptions,
}

impl Color {
    pub(crate) fn run(&self, quiet: bool) -> Outcome {
        let (columns, rows) = match (&self.spectrum, self.false_color) {
            (Some(path), _) => (COLUMNS.to_vec(), vec![self.of_file(path)?]),
            (None, Some(colour)) => (FALSE_COLUMNS.to_vec(), self.in_false_color(colour)?),
            (None, None) => (COLUMNS.to_vec(), self.of_snow()?),
        };
        let observer = match self.false_color {
            Some(FalseColor { red_nm, green_nm, blue_nm }) => {
                ("false colour", format!("{red_nm},{green_nm},{blue_nm} nm"))
            }
            None => ("observer", Observer::Cie1931.name().to_owned()),
        };
        let mut metadata = vec![("snowblue", env!("CARGO_PKG_VERSION").to_owned()), observer];
        if self.spectrum.is_none() {
            metadata.extend(self.sample.metadata()?);
            metadata.push(("seed", self.ordinates.seed.to_string()));
        }
        Report { columns, rows, metadata }.write(&self.output, quiet)
    }

    fn of_snow(&self) -> Result<Vec<Vec<Cell>>, Failure> {
        let wavelengths = match self.samples.as_str() {
            "3" => Wavelengths(THREE_SAMPLES_NM.to_vec()),
            _ => parse::wavelengths("400:700:10").map_err(Failure::Work)?,
        };
        let slab = self.sample.slab(&self.slab, &wavelengths)?;
        let colorimeter = self.colorimeter(&slab.wavelengths_nm)?;
        let solved = ordinates::solve(&slab, &self.ordinates.options()).map_err(Failure::input)?;
        let row = |curve: &[Radiometry]| {
            let values: Vec<f64> = curve.iter().map(|row| row.transmittance.value).collect();
            let place = [curve[0].thickness_cm.into(), Cell::Word(incidence_name(curve[0].incidence))];
            self.row(place, &colorimeter, &values)
        };
        Ok(solved.chunks_exact(slab.wavelengths_nm.len()).map(row).collect())
    }

    fn in_false_color(&self, colour: FalseColor) -> Result<Vec<Vec<Cell>>, Failure> {
        let wavelengths = Wavelengths(vec![colour.red_nm, colour.green_nm, colour.blue_nm]);
        let slab = self.sample.slab(&self.slab, &wavelengths)?;
        let solved = ordinates::solve(&slab, &self.ordinates.options()).map_err(Failure::input)?;
        let row = |three: &[Radiometry]| {
            let [r, g, b] = [0, 1, 2].map(|channel| three[channel].transmittance.value);
            let hex = Srgb8::encode(LinearRgb { r, g, b }).to_string();
            let mut row = vec![three[0].thickness_cm.into(), Cell::Word(incidence_name(three[0].incidence))];
            row.extend([r, g, b].map(Cell::from));
            row.push(Cell::Word(hex));
            row
        };
        Ok(solved.chunks_exact(3).map(row).collect())
    }

    fn of_file(&self, path: &Path) -> Result<Vec<Cell>, Failure> {
        let (wavelengths_nm, values) = read_spectrum(path)?;
        let colorimeter = self.colorimeter(&wavelengths_nm)?;
        Ok(self.row([Cell::Word(String::new()), Cell::Word(String::new())], &colorimeter, &values))
    }

    fn colorimeter(&self, wavelengths_nm: &[f64]) -> Result<Colorimeter, Failure> {
        Colorimeter::new(Observer::Cie1931, self.light.illuminant, wavelengths_nm).map_err(Failure::input)
    }

    fn row(&self, place: [Cell; 2], colorimeter: &Colorimeter, values: &[f64]) -> Vec<Cell> {
        let xyz = colorimeter.xyz(values);
        let lab = Lab::from_xyz(xyz, colorimeter.white());
        let rgb = LinearRgb::from_xyz(xyz);
        let hex = Srgb8::encode(rgb.displayable()).to_string();
        let mut row = place.to_vec();
        row.push(Cell::Word(self.light.illuminant.name().to_owned()));
        row.extend([xyz.x, xyz.y, xyz.z, lab.l, lab.a, lab.b, rgb.r, rgb.g, rgb.b].map(Cell::from));
        row.push(Cell::Word(hex));
        row
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

/// Reads `wavelength_nm,value` rows; a first line that starts with a letter is a header.
fn read_spectrum(path: &Path) -> Result<(Vec<f64>, Vec<f64>), Failure> {
    let name = path.display();
    let text =
        std::fs::read_to_string(path).map_err(|error| Failure::Input(format!("{name}: cannot be read: {error}")))?;
    let (mut wavelengths_nm, mut values) = (Vec::new(), Vec::new());
    let text = text.trim_start_matches('\u{feff}');
    for (number, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let fields: Result<Vec<f64>, String> = line.split(',').map(parse::number).collect();
        match fields.as_deref() {
            Ok([wavelength_nm, value]) if wavelength_nm.is_finite() && value.is_finite() && *value >= 0.0 => {
                wavelengths_nm.push(*wavelength_nm);
                values.push(*value);
            }
            Err(_) if number == 0 && line.starts_with(|first: char| first.is_ascii_alphabetic()) => {}
            _ => {
                let place = format!("{name}:{}", number + 1);
                return Err(Failure::Input(format!(
                    "{place}: expected a wavelength in nm and a value of 0 or more, but found '{line}'"
                )));
            }
        }
    }
    check_spacing(&wavelengths_nm).map_err(|why| Failure::Input(format!("{name}: {why}")))?;
    Ok((wavelengths_nm, values))
}
