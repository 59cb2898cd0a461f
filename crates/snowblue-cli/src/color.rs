//! `snowblue color`: the colour of the light that comes through snow, or that snow sends back.

use std::path::{Path, PathBuf};

use clap::Args;
use snowblue_color::{Colorimeter, exposure, exposure::AutoExposure};
use snowblue_render::FalseColor;
use snowblue_render::film::exposure::Exposure;
use snowblue_transport::ordinates;
use snowblue_transport::slab::Radiometry;

use crate::colored::{COLUMNS, Colored, FALSE_COLUMNS, wavelengths_nm};
use crate::failure::{Failure, Outcome};
use crate::options::{
    EyeOptions, LightOptions, OrdinatesWords, OutputOptions, SampleOptions, SlabOptions, incidence_name,
};
use crate::parse::{self, Wavelengths};
use crate::report::{Cell, Report};
use crate::spectrum_file;

/// XYZ, CIELAB, linear sRGB and hex of the light that comes through snow, or that it sends back
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "The bare light has Y = 1 and is the white of CIELAB; there is no chromatic adaptation.
A false colour is the transmittance at three wavelengths, 1 being white, without illuminant,
XYZ and CIELAB.
The exposure changes hex alone: automatic, it brings the brightest channel of all rows to 0.9.

Examples:
  snowblue color --thickness 5,10,15,30 --illuminant D65
  snowblue color --thickness 5,10,15,30 --exposure auto
  snowblue color --reflected --impurity black-carbon=200
  snowblue color --thickness 0.5,1,2 --false-color 1030,860,550
  snowblue color --spectrum measured.csv --illuminant E

A file of spectra has the columns wavelength_nm,value, or is a CSV of `snowblue spectrum`.
It must cover 400–700 nm in steps of 20 nm at the most; what lies beyond does not count.
Values in equal steps that include 400 and 700 nm are summed as they are; any others are
first brought onto 400, 410, … 700 nm on straight lines."
)]
pub(crate) struct Color {
    #[command(flatten)]
    sample: SampleOptions,
    #[command(flatten)]
    slab: SlabOptions,
    #[command(flatten)]
    ordinates: OrdinatesWords,
    /// The light that the snow sends back instead of what comes through
    #[arg(long, help_heading = "Light")]
    reflected: bool,
    #[command(flatten)]
    light: LightOptions,
    #[command(flatten)]
    eye: EyeOptions,
    /// Exposure of hex in stops, or 'auto'
    #[arg(
        long, value_name = "STOPS", default_value = "0", value_parser = parse::exposure, allow_negative_numbers = true,
        help_heading = "Light"
    )]
    exposure: Exposure,
    /// Colours of the spectra in a CSV file (wavelength_nm,value or that of `snowblue spectrum`) instead of snow
    #[arg(
        long, value_name = "FILE",
        conflicts_with_all = ["SampleOptions", "SlabOptions", "OrdinatesWords", "samples", "false_color"]
    )]
    spectrum: Option<PathBuf>,
    #[command(flatten)]
    output: OutputOptions,
}

/// Where automatic exposure brings the brightest channel of all rows.
const AUTO_LEVEL: f64 = 0.9;

/// Thickness and angle of a slab, and its spectrum.
type Curve = ([Cell; 2], Vec<f64>);

impl Color {
    pub(crate) fn run(&self, quiet: bool) -> Outcome {
        self.output.check()?;
        let (columns, rows) = match (&self.spectrum, self.eye.false_color) {
            (Some(path), _) => (COLUMNS.to_vec(), self.of_file(path)?),
            (None, Some(colour)) => (FALSE_COLUMNS.to_vec(), self.in_false_color(colour)?),
            (None, None) => (COLUMNS.to_vec(), self.of_snow()?),
        };
        let observer = match self.eye.false_color {
            Some(FalseColor { red_nm, green_nm, blue_nm }) => {
                ("false colour", format!("{red_nm},{green_nm},{blue_nm} nm"))
            }
            None => ("observer", self.eye.observer.name().to_owned()),
        };
        let light = if self.reflected { "reflected" } else { "transmitted" };
        let exposure = match self.exposure {
            Exposure::Auto => "auto".to_owned(),
            Exposure::Stops(stops) => format!("{stops} stops"),
        };
        let mut metadata =
            vec![("snowblue", env!("CARGO_PKG_VERSION").to_owned()), ("light", light.to_owned()), observer];
        metadata.push(("exposure of hex", exposure));
        if self.spectrum.is_none() {
            metadata.extend(self.sample.metadata()?);
            metadata.push(("seed", self.ordinates.seed.to_string()));
        }
        Report { columns, rows: self.exposed(rows), metadata }.write(&self.output, quiet)
    }

    /// The rows with their hex, all at one exposure.
    fn exposed(&self, rows: Vec<Colored>) -> Vec<Vec<Cell>> {
        let factor = match self.exposure {
            Exposure::Stops(stops) => exposure::factor(stops),
            Exposure::Auto => {
                AutoExposure { fraction: 1.0, level: AUTO_LEVEL }.factor(rows.iter().map(|row| row.light))
            }
        };
        rows.into_iter().map(|row| row.row(factor)).collect()
    }

    fn of_snow(&self) -> Result<Vec<Colored>, Failure> {
        let wavelengths = Wavelengths(wavelengths_nm(&self.eye.samples));
        let colorimeter = self.light.colorimeter(self.eye.observer, &wavelengths.0)?;
        let row = |(place, values): Curve| self.row(place, &colorimeter, &values);
        Ok(self.curves(&wavelengths)?.into_iter().map(row).collect())
    }

    fn in_false_color(&self, colour: FalseColor) -> Result<Vec<Colored>, Failure> {
        let wavelengths = Wavelengths(vec![colour.red_nm, colour.green_nm, colour.blue_nm]);
        let row = |(place, values): Curve| Colored::in_false_color(place.to_vec(), [values[0], values[1], values[2]]);
        Ok(self.curves(&wavelengths)?.into_iter().map(row).collect())
    }

    /// The curves of the slabs that are asked for.
    fn curves(&self, wavelengths: &Wavelengths) -> Result<Vec<Curve>, Failure> {
        let slab = self.sample.slab(&self.slab, wavelengths)?;
        let solved = ordinates::solve(&slab, &self.ordinates.options()).map_err(Failure::input)?;
        let curve = |rows: &[Radiometry]| {
            let value = |row: &Radiometry| if self.reflected { row.reflectance.value } else { row.transmittance.value };
            let place = [rows[0].thickness_cm.into(), Cell::Word(incidence_name(rows[0].incidence))];
            (place, rows.iter().map(value).collect())
        };
        Ok(solved.chunks_exact(wavelengths.0.len()).map(curve).collect())
    }

    fn of_file(&self, path: &Path) -> Result<Vec<Colored>, Failure> {
        let quantity = if self.reflected { "reflectance" } else { "transmittance" };
        let row = |curve: spectrum_file::Curve| {
            let colorimeter = self.light.colorimeter(self.eye.observer, &curve.wavelengths_nm)?;
            Ok(self.row(curve.place.map(Cell::Word), &colorimeter, &curve.values))
        };
        spectrum_file::read(path, quantity)?.into_iter().map(row).collect()
    }

    fn row(&self, place: [Cell; 2], colorimeter: &Colorimeter, values: &[f64]) -> Colored {
        Colored::seen(place.to_vec(), self.light.illuminant, colorimeter, values)
    }
}
