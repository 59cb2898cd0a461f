//! `snowblue color`: the colour of the light that snow transmits or reflects.

use std::path::{Path, PathBuf};

use clap::Args;
use snowblue_base::spectrum_csv::{self, SpectrumRows};
use snowblue_color::Colorimeter;
use snowblue_color::exposure::{self, AutoExposure};
use snowblue_figures::{Cell, DataTable, Metadata};
use snowblue_render::Exposure;
use snowblue_transport::optics::Wavelengths;
use snowblue_transport::ordinates;
use snowblue_transport::slab::Radiometry;

use crate::input::SettingsFile;
use crate::options::parse;
use crate::options::{
    ColorOptions, LightOptions, OrdinatesArguments, SlabOptions, SnowOptions, check_transmits, limits,
};
use crate::output::color_row::{self, ColorRow};
use crate::output::{Failure, Outcome, OutputOptions, check_not_input};

/// Compute XYZ, CIELAB, linear sRGB and hex of the light that snow transmits or reflects
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "The unattenuated light has Y = 1 and is the white of CIELAB; there is no chromatic adaptation. The \
exposure changes only hex: 'auto' brings the brightest channel of all rows to 0.9.

Examples:
  snowblue color --thickness 5,10,15,30 --illuminant D65
  snowblue color --thickness 5,10,15,30 --exposure auto
  snowblue color --reflected --impurity black-carbon=200
  snowblue color --spectrum measured.csv --illuminant E

A file of spectra has the columns wavelength_nm,value, or is a CSV of 'snowblue spectrum'. Cells are separated by \
commas, decimals have a point, and lines that begin with # are comments. It must cover 400–700 nm in steps of at most \
20 nm; values outside are ignored. Values in equal steps of at most 10 nm that include 400 and 700 nm are summed as \
they are; others are first interpolated linearly to 400, 410, … 700 nm. A constant spectrum has the chromaticity of \
the light, whatever its wavelengths are."
)]
pub(crate) struct Color {
    #[command(flatten)]
    sample: SnowOptions,
    #[command(flatten)]
    slab: SlabOptions,
    #[command(flatten)]
    ordinates: OrdinatesArguments,
    /// Colour of the reflected light instead of the transmitted light
    #[arg(long, help_heading = "Light")]
    reflected: bool,
    #[command(flatten)]
    light: LightOptions,
    #[command(flatten)]
    color: ColorOptions,
    #[arg(
        long, value_name = "STOPS", default_value = "0", value_parser = parse::exposure, allow_negative_numbers = true,
        help_heading = "Light", help = format!("Exposure of hex in stops [{}], or 'auto'", limits::stops())
    )]
    exposure: Exposure,
    /// Colours of the spectra in a CSV file instead of snow
    #[arg(
        long, value_name = "FILE",
        conflicts_with_all = ["SnowOptions", "SnowProperties", "SlabOptions", "OrdinatesArguments", "samples"]
    )]
    spectrum: Option<PathBuf>,
    #[command(flatten)]
    output: OutputOptions,
}

/// A spectrum, with the cells of its slab: thickness and angle.
struct Curve {
    slab: Vec<Cell>,
    values: Vec<f64>,
}

impl Color {
    pub(crate) fn run(&self, quiet: bool) -> Outcome {
        self.output.check()?;
        if let (Some(input), Some(output)) = (&self.spectrum, &self.output.output) {
            check_not_input(input, output)?;
        }
        let rows = match &self.spectrum {
            Some(path) => self.colours_of_file(path)?,
            None => self.colours_of_snow()?,
        };
        let light = if self.reflected { "reflected" } else { "transmitted" };
        let exposure = match self.exposure {
            Exposure::Auto => "auto".to_owned(),
            Exposure::Stops(stops) => format!("{stops} stops"),
        };
        let mut metadata: Metadata = vec![
            ("snowblue", env!("CARGO_PKG_VERSION").to_owned()),
            ("light", light.to_owned()),
            ("observer", self.color.observer.name().to_owned()),
            ("exposure of hex", exposure),
        ];
        if self.spectrum.is_none() {
            metadata.extend(self.sample.metadata()?);
            metadata.push(("seed", self.ordinates.seed.to_string()));
        }
        self.output
            .write(&DataTable { columns: color_row::COLUMNS.to_vec(), rows: self.exposed(rows), metadata }, quiet)
    }

    /// Complete rows, with hex at one exposure.
    fn exposed(&self, rows: Vec<ColorRow>) -> Vec<Vec<Cell>> {
        let factor = match self.exposure {
            Exposure::Stops(stops) => exposure::factor(stops),
            Exposure::Auto => AutoExposure::OF_COLORS.factor(rows.iter().map(|row| row.colour)),
        };
        rows.into_iter().map(|row| row.exposed(factor)).collect()
    }

    fn colours_of_snow(&self) -> Result<Vec<ColorRow>, Failure> {
        let wavelengths = Wavelengths(self.color.samples.wavelengths_nm());
        let colorimeter = self.light.colorimeter(self.color.observer, &wavelengths.0)?;
        let row = |curve: Curve| self.row(curve, &colorimeter);
        Ok(self.curves(&wavelengths)?.into_iter().map(row).collect())
    }

    /// The spectrum of each slab.
    fn curves(&self, wavelengths: &Wavelengths) -> Result<Vec<Curve>, Failure> {
        check_transmits(&self.slab.thickness, self.reflected)?;
        let slab = self.sample.slab(&self.slab, wavelengths)?;
        let solved = ordinates::solve(&slab, &self.ordinates.options()).map_err(Failure::input)?;
        let curve = |rows: &[Radiometry]| {
            let value = |row: &Radiometry| {
                if self.reflected { row.fluxes.reflectance.value } else { row.fluxes.transmittance.value }
            };
            let slab = vec![rows[0].thickness_cm.into(), Cell::word(rows[0].incidence.to_string())];
            Curve { slab, values: rows.iter().map(value).collect() }
        };
        Ok(solved.chunks_exact(wavelengths.0.len()).map(curve).collect())
    }

    fn colours_of_file(&self, path: &Path) -> Result<Vec<ColorRow>, Failure> {
        let quantity = if self.reflected { "reflectance" } else { "transmittance" };
        let row = |curve: SpectrumRows| {
            let colorimeter =
                Colorimeter::for_spectrum(self.color.observer, self.light.illuminant, &curve.wavelengths_nm);
            let colorimeter =
                colorimeter.map_err(|error| Failure::Input(format!("{}:{}: {error}", path.display(), curve.line)))?;
            let slab = curve.slab.map(Cell::Word).to_vec();
            Ok(self.row(Curve { slab, values: curve.values }, &colorimeter))
        };
        let spectra = spectrum_csv::read(&SettingsFile::read(path)?, quantity)
            .map_err(|error| Failure::Input(error.in_file(&path.display().to_string())))?;
        spectra.into_iter().map(row).collect()
    }

    fn row(&self, curve: Curve, colorimeter: &Colorimeter) -> ColorRow {
        ColorRow::of_spectrum(curve.slab, self.light.illuminant, colorimeter, &curve.values)
    }
}
