//! `snowblue swatch`: colours of snow over any two options of `snowblue color`, as a PNG.

use std::path::PathBuf;

use clap::{Args, Command, FromArgMatches as _};
use snowblue_color::LinearRgb;
use snowblue_color::exposure::{self, AutoExposure};
use snowblue_figures::{Cell, DataTable, Metadata};
use snowblue_render::Exposure;
use snowblue_render::film::image_file::write_raster_png;
use snowblue_render::raster::RasterImage;
use snowblue_transport::batch::{Batch, SlabCase};
use snowblue_transport::ordinates::solve_batch;
use snowblue_transport::sample::Property;
use snowblue_transport::slab::Fluxes;

use crate::options::{
    ColorOptions, GivenOptions, LightOptions, OrdinatesArguments, SlabOptions, SnowOptions, check_transmits, limits,
    parse,
};
use crate::output::color_row::{self, ColorRow};
use crate::output::{Failure, Outcome, check_extension, output_path, write_file};

/// Greatest width or height of all swatches together, in pixels.
const MAX_PIXELS: usize = 16_384;

/// Draw the colours of light through snow over one or two options, as a PNG
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = format!("Rows and columns: {}, with values as in the options of these names. Swatches are squares \
without gaps, at one exposure; 'auto' brings the greatest channel to 0.9 of white. Hues outside sRGB lose saturation.

Examples:
  snowblue swatch --rows grain-size=100,500 --columns angle=0,40,80 -o angles.png
  snowblue swatch --rows illuminant=D65,FL3.15 --columns thickness=2,5,10 -o lamps.png
  snowblue swatch --columns thickness=5,10,15,30 --exposure 3 --colors colours.csv -o thick.png", names())
)]
pub(crate) struct Swatch {
    /// Must be the first field.
    #[command(flatten)]
    given: GivenOptions,
    /// Option that varies from left to right
    #[arg(
        long, value_name = "NAME=LIST", value_parser = axis, required_unless_present = "rows", help_heading = "Sheet"
    )]
    columns: Option<Axis>,
    /// Option that varies from top to bottom
    #[arg(long, value_name = "NAME=LIST", value_parser = axis, help_heading = "Sheet")]
    rows: Option<Axis>,
    #[command(flatten)]
    subject: Subject,
    #[command(flatten)]
    ordinates: OrdinatesArguments,
    #[command(flatten)]
    color: ColorOptions,
    /// Colour of the reflected light instead of the transmitted light
    #[arg(long, help_heading = "Light")]
    reflected: bool,
    #[arg(
        long, value_name = "STOPS", default_value = "auto", value_parser = parse::exposure, help_heading = "Light",
        help = format!(
            "Exposure in stops [{}], where 0 shows the unattenuated light as white, or 'auto'", limits::stops()
        )
    )]
    exposure: Exposure,
    /// Width and height of a swatch in pixels [16–2048]
    #[arg(
        long, value_name = "N", default_value_t = 160, value_parser = parse::whole_number::<u16>(16..=2048),
        help_heading = "Sheet"
    )]
    size: u16,
    /// Picture to write (.png)
    #[arg(short, long, value_name = "FILE", value_parser = output_path(), help_heading = "Output")]
    output: PathBuf,
    /// Also write the colours (.csv): the values of the axes, the columns of 'snowblue color' and the displayed hex
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    colors: Option<PathBuf>,
}

/// The snow and the light of a swatch.
#[derive(Debug, Args)]
struct Subject {
    #[command(flatten)]
    sample: SnowOptions,
    #[command(flatten)]
    slab: SlabOptions,
    #[command(flatten)]
    light: LightOptions,
}

/// An option and its values.
#[derive(Debug, Clone)]
struct Axis {
    name: String,
    /// The column of the option in CSV, unless 'snowblue color' has such a column.
    column: Option<&'static str>,
    values: Vec<String>,
}

/// Options that can vary, with their columns in CSV.
fn options() -> impl Iterator<Item = (String, Option<&'static str>)> {
    let properties = Property::all().filter(|property| !matches!(property, Property::Impurity(_)));
    let others = ["thickness", "angle", "illuminant"].map(|name| (name.to_owned(), None));
    properties.map(|property| (property.name().replace('_', "-"), Some(property.key()))).chain(others)
}

/// Names of the options that can vary.
fn names() -> String {
    options().map(|(name, _)| name).collect::<Vec<_>>().join(", ")
}

/// Parses `thickness=1,5,15`.
fn axis(words: &str) -> Result<Axis, String> {
    let (name, values) = words.split_once('=').ok_or("give NAME=VALUE,VALUE (thickness=1,5,15)")?;
    let found = options().find(|(known, _)| known == name.trim());
    let (name, column) = found.ok_or_else(|| format!("parameter '{name}' is not known; there are {}", names()))?;
    let values: Vec<String> = values.split(',').map(|value| value.trim().to_owned()).collect();
    let number = |value: &String| value.parse::<f64>().ok();
    let is_same = |one: &String, other: &String| one == other || number(one).is_some_and(|n| Some(n) == number(other));
    match values.iter().enumerate().find(|(place, value)| values[..*place].iter().any(|other| is_same(value, other))) {
        Some((_, value)) => Err(format!("{name} {value} is given twice")),
        None => Ok(Axis { name, column, values }),
    }
}

impl Swatch {
    pub(crate) fn run(&self) -> Outcome {
        check_extension(&self.output, "png", "the picture")?;
        if let Some(path) = &self.colors {
            check_extension(path, "csv", "the table of colours")?;
        }
        self.check_axes()?;
        let colours = self.colours()?;
        let factor = match self.exposure {
            Exposure::Stops(stops) => exposure::factor(stops),
            Exposure::Auto => AutoExposure::OF_COLORS.factor(colours.iter().map(|row| row.colour)),
        };
        let exposed: Vec<LinearRgb> = colours.iter().map(|row| row.colour * factor).collect();
        let across = self.columns.as_ref().map_or(1, |axis| axis.values.len());
        let rows: Vec<Vec<LinearRgb>> = exposed.chunks(across).map(<[LinearRgb]>::to_vec).collect();
        let picture = RasterImage::patches(&rows, self.size.into());
        let software = concat!("snowblue ", env!("CARGO_PKG_VERSION"));
        write_raster_png(&picture, &[("Software", software)], &self.output).map_err(Failure::work)?;
        let Some(path) = &self.colors else { return Ok(()) };
        let columns = self.axes().filter_map(|(_, axis)| axis.column).chain(color_row::COLUMNS).collect();
        let rows = colours.into_iter().map(|row| row.exposed(factor)).collect();
        write_file(path, DataTable { columns, rows, metadata: Metadata::new() }.csv().as_bytes())
    }

    /// The varying options, rows first.
    fn axes(&self) -> impl Iterator<Item = (&'static str, &Axis)> {
        let named = [("--rows", &self.rows), ("--columns", &self.columns)];
        named.into_iter().filter_map(|(option, axis)| Some((option, axis.as_ref()?)))
    }

    /// Checks options before long work.
    fn check_axes(&self) -> Outcome {
        if let (Some(rows), Some(columns)) = (&self.rows, &self.columns)
            && rows.name == columns.name
        {
            return Err(Failure::Input(format!("{} varies along --rows and --columns", rows.name)));
        }
        for (option, Axis { name, values, .. }) in self.axes() {
            if self.given.has(&name.replace('-', "_")) {
                return Err(Failure::Input(format!("{name} varies along {option}, but is also set by --{name}")));
            }
            let (count, size) = (values.len(), usize::from(self.size));
            if count * size > MAX_PIXELS {
                let pixels = count * size;
                return Err(Failure::Input(format!(
                    "{option}: {count} swatches of {size} pixels are {pixels} pixels, but must be at most {MAX_PIXELS}"
                )));
            }
        }
        let slab = &self.subject.slab;
        for (name, count) in [("thickness", slab.thickness.len()), ("angle", slab.angle.len())] {
            if count != 1 {
                return Err(Failure::Input(format!(
                    "--{name} has {count} values, but must have 1: give several as --columns {name}=VALUE,VALUE"
                )));
            }
        }
        Ok(())
    }

    /// The snow and the light of all swatches, row by row, each with its values of the axes that need a column.
    fn subjects(&self) -> Result<Vec<(Vec<Cell>, Subject)>, Failure> {
        let command = Subject::augment_args(Command::new("swatch").no_binary_name(true).allow_negative_numbers(true));
        let given = self.given.words_of(&command);
        let steps = |axis: &Option<Axis>| match axis {
            None => vec![None],
            Some(Axis { name, column, values }) => {
                values.iter().map(|value| Some((format!("--{name}={value}"), column.map(|_| value.clone())))).collect()
            }
        };
        // Clap's reason ends before an empty line.
        let reason = |error: clap::Error| {
            let words = error.to_string();
            let reason = words.split("\n\n").next().unwrap_or_default().replace('\n', " ");
            Failure::Input(reason.trim_start_matches("error: ").to_owned())
        };
        let mut subjects = Vec::new();
        for row in steps(&self.rows) {
            for column in steps(&self.columns) {
                let (words, cells): (Vec<_>, Vec<_>) = [row.clone(), column].into_iter().flatten().unzip();
                let words = given.iter().cloned().chain(words.into_iter().map(Into::into));
                let matches = command.clone().try_get_matches_from(words).map_err(reason)?;
                let subject = Subject::from_arg_matches(&matches).map_err(reason)?;
                subjects.push((cells.into_iter().flatten().map(Cell::Word).collect(), subject));
            }
        }
        Ok(subjects)
    }

    /// The colours of all swatches, row by row.
    fn colours(&self) -> Result<Vec<ColorRow>, Failure> {
        let subjects = self.subjects()?;
        let mut batch =
            Batch { samples: Vec::new(), cases: Vec::new(), wavelengths_nm: self.color.samples.wavelengths_nm() };
        for (_, Subject { sample, slab, .. }) in &subjects {
            let sample = sample.sample()?;
            let known = batch.samples.iter().position(|other| *other == sample);
            let sample = known.unwrap_or_else(|| {
                batch.samples.push(sample);
                batch.samples.len() - 1
            });
            let (thickness_cm, incidence) = (slab.thickness[0], slab.angle[0]);
            batch.cases.push(SlabCase { sample, thickness_cm, incidence, ground_albedo: 0.0.into() });
        }
        let thicknesses_cm: Vec<f64> = batch.cases.iter().map(|case| case.thickness_cm).collect();
        check_transmits(&thicknesses_cm, self.reflected)?;
        let fluxes = solve_batch(&batch, &self.ordinates.options(), false, &|_| ()).map_err(Failure::input)?;
        let value = |of: &Fluxes| if self.reflected { of.reflectance.value } else { of.transmittance.value };
        let values: Vec<f64> = fluxes.iter().map(value).collect();
        let spectra = values.chunks_exact(batch.wavelengths_nm.len());
        let colour = |((mut cells, subject), values): ((Vec<Cell>, Subject), &[f64])| {
            let Subject { slab, light, .. } = subject;
            cells.extend([slab.thickness[0].into(), Cell::word(slab.angle[0].to_string())]);
            let colorimeter = light.colorimeter(self.color.observer, &batch.wavelengths_nm)?;
            Ok(ColorRow::of_spectrum(cells, light.illuminant, &colorimeter, values))
        };
        subjects.into_iter().zip(spectra).map(colour).collect()
    }
}
