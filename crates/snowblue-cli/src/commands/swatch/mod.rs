//! `snowblue swatch`: a sheet of colours over any two parameters.

mod axis;
mod colours;

use std::path::PathBuf;

use clap::Args;
use snowblue_color::exposure;
use snowblue_figures::swatch::{SheetAxis, SwatchSheet, automatic_exposure};
use snowblue_figures::{Cell, DataTable, Metadata, format_number};
use snowblue_render::Exposure;
use snowblue_render::film::image_file::write_raster_png;
use snowblue_transport::sample::SizeMeasure;
use snowblue_transport::slab::Incidence;

use crate::options::parse::{self, GrainSizeArgument};
use crate::options::{
    ColorOptions, GivenOptions, Idle, LightOptions, OrdinatesArguments, SampleCount, SlabOptions, SnowOptions,
    describe_distribution, describe_measure, describe_range, limits,
};
use crate::output::{Failure, Outcome, check_extension, color_row, output_path, write_file};
use axis::{Axis, Parameter, Setting, Subject, axis};
use colours::SheetColours;

/// Greatest width or height of all swatches together, in pixels.
const MOST_PIXELS: u32 = 16_384;

/// Draw swatches of the light through snow, over any two parameters, as a PNG
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Rows and columns: grain-size (µm), facetness, density (kg/m³), water-saturation, thickness (cm), \
angle (deg), illuminant, with values as in the options of these names. All swatches have one exposure; 'auto' brings \
the greatest channel to 0.8 of white, at which the average of the snow texture is the colour. Brighter swatches are \
clipped where the texture is light. Hues outside sRGB lose saturation.

Examples:
  snowblue swatch --rows grain-size=100,500 --columns angle=0,40,80 -o angles.png
  snowblue swatch --rows illuminant=D65,FL3.15 --columns thickness=2,5,10 -o lamps.png
  snowblue swatch --columns thickness=5,10,15,30 --exposure 3 --colors colours.csv -o thick.png"
)]
pub(crate) struct Swatch {
    /// Must be the first field.
    #[command(flatten)]
    given: GivenOptions,
    /// Parameter that varies from left to right
    #[arg(
        long, value_name = "NAME=LIST", value_parser = axis, required_unless_present = "rows", help_heading = "Sheet"
    )]
    columns: Option<Axis>,
    /// Parameter that varies from top to bottom
    #[arg(long, value_name = "NAME=LIST", value_parser = axis, help_heading = "Sheet")]
    rows: Option<Axis>,
    #[command(flatten)]
    sample: SnowOptions,
    #[command(flatten)]
    slab: SlabOptions,
    #[command(flatten)]
    ordinates: OrdinatesArguments,
    #[command(flatten)]
    light: LightOptions,
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
    /// Height of a swatch in pixels [16–2048]; long labels make it wider than high
    #[arg(
        long, value_name = "N", default_value_t = 160, value_parser = parse::whole_number::<u32>(16..=2048),
        help_heading = "Sheet"
    )]
    size: u32,
    /// Flat colours, without the grey texture of snow
    #[arg(long, help_heading = "Sheet")]
    no_texture: bool,
    /// Picture to write (.png)
    #[arg(short, long, value_name = "FILE", value_parser = output_path(), help_heading = "Output")]
    output: PathBuf,
    /// Also write the colours (.csv): the varying parameters, the columns of 'snowblue color' and the displayed hex
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    colors: Option<PathBuf>,
}

impl Swatch {
    pub(crate) fn run(&self) -> Outcome {
        self.check()?;
        let subjects = self.subjects()?;
        let colours = SheetColours {
            rows: self.rows.as_ref(),
            columns: self.columns.as_ref(),
            color: &self.color,
            reflected: self.reflected,
            ordinates: self.ordinates.options(),
        };
        let colours = colours.of(&subjects)?;
        let factor = match self.exposure {
            Exposure::Stops(stops) => exposure::factor(stops),
            Exposure::Auto => automatic_exposure(colours.iter().flatten().map(|swatch| &swatch.colour)),
        };
        let sheet = SwatchSheet {
            title: self.title(&subjects[0][0]),
            footer: self.description(factor)?,
            columns: self.columns.as_ref().map_or_else(single_step, Axis::sheet),
            rows: self.rows.as_ref().map_or_else(single_step, Axis::sheet),
            colours: colours.iter().map(|row| row.iter().map(|swatch| swatch.colour * factor).collect()).collect(),
            size_px: self.size,
            texture: (!self.no_texture).then_some(self.ordinates.seed),
        };
        let software = format!("snowblue {}", env!("CARGO_PKG_VERSION"));
        let title = sheet.title.replace('\u{a0}', " ");
        let notes = [("Software", &*software), ("Title", &*title), ("Description", &*sheet.footer)];
        write_raster_png(&sheet.draw(), &notes, &self.output).map_err(Failure::work)?;
        let Some(path) = &self.colors else { return Ok(()) };
        let rows = colours.into_iter().flatten().map(|swatch| swatch.exposed(factor)).collect();
        write_file(path, self.results(rows).csv().as_bytes())
    }

    /// Checks options before long work.
    fn check(&self) -> Outcome {
        check_extension(&self.output, "png", "the picture")?;
        if let Some(path) = &self.colors {
            check_extension(path, "csv", "the table of colours")?;
        }
        self.check_axes()?;
        let sets_size = self.varies(Parameter::GrainSize) || self.given.has("grain_size") || self.given.has("ssa");
        let sets_density = self.varies(Parameter::Density) || self.given.has("density");
        self.given.refuse_idle(&[Idle {
            when: sets_size && sets_density,
            options: &["snow"],
            why: "grain size and density, which are all that a kind of snow sets, are given",
        }])?;
        for (name, count) in [("thickness", self.slab.thickness.len()), ("angle", self.slab.angle.len())] {
            if count != 1 {
                return Err(Failure::Input(format!(
                    "--{name} has {count} values, but must have 1: give several as --columns {name}=VALUE,VALUE"
                )));
            }
        }
        Ok(())
    }

    fn check_axes(&self) -> Outcome {
        let axes: Vec<(&str, &Axis)> = self.axes().collect();
        if let [(_, rows), (_, columns)] = axes[..]
            && rows.parameter == columns.parameter
        {
            return Err(Failure::Input(format!("{} varies along --rows and --columns", rows.parameter.name())));
        }
        for (option, axis) in &axes {
            if let Some(rival) = axis.parameter.rivals().iter().find(|rival| self.given.has(rival)) {
                let (name, rival) = (axis.parameter.name(), rival.replace('_', "-"));
                return Err(Failure::Input(format!("{name} varies along {option}, but is also set by --{rival}")));
            }
            let pixels = self.size.saturating_mul(u32::try_from(axis.len()).unwrap_or(u32::MAX));
            if pixels > MOST_PIXELS {
                let size = self.size;
                return Err(Failure::Input(format!(
                    "{option}: {} swatches of {size} pixels are {pixels} pixels, but must be at most {MOST_PIXELS}",
                    axis.len()
                )));
            }
        }
        Ok(())
    }

    /// The subjects of the swatches, by row and column.
    fn subjects(&self) -> Result<Vec<Vec<Subject>>, Failure> {
        let base = Subject {
            sample: self.sample.sample()?,
            thickness_cm: self.slab.thickness[0],
            incidence: self.slab.angle[0],
            illuminant: self.light.illuminant,
        };
        let along = |axis: &Option<Axis>, subject: Subject| -> Result<Vec<Subject>, Failure> {
            let Some(axis) = axis else { return Ok(vec![subject]) };
            (0..axis.len()).map(|step| axis.set(step, subject, &self.sample)).collect()
        };
        along(&self.rows, base)?.into_iter().map(|subject| along(&self.columns, subject)).collect()
    }

    /// The varying parameters with their options, rows first.
    fn axes(&self) -> impl Iterator<Item = (&'static str, &Axis)> {
        let named = [("--rows", &self.rows), ("--columns", &self.columns)];
        named.into_iter().filter_map(|(option, axis)| Some((option, axis.as_ref()?)))
    }

    fn varies(&self, parameter: Parameter) -> bool {
        self.axes().any(|(_, axis)| axis.parameter == parameter)
    }

    /// The quantity, and all parameters that do not vary.
    fn title(&self, base: &Subject) -> String {
        let sample = &base.sample;
        let size = sample.grain_size;
        let tenth = |um: f64| (10.0 * um).round() / 10.0;
        let sizes = GrainSizeArgument::Range { min_um: tenth(size.min_um), max_um: tenth(size.max_um) };
        let sizes = Setting::GrainSize(sizes).label();
        let sizes = match size.measure {
            SizeMeasure::GreatestExtension => sizes,
            other => format!("{} {sizes}", describe_measure(other)),
        };
        let angle = match base.incidence {
            Incidence::Diffuse => "diffuse light".to_owned(),
            beam @ Incidence::Beam { .. } => Setting::Angle(beam).label(),
        };
        let fixed = [
            (Parameter::GrainSize, sizes),
            (Parameter::Facetness, format!("facetness {}", Setting::Facetness(sample.facetness).label())),
            (Parameter::Density, Setting::Density(sample.density_kg_m3).label()),
            (
                Parameter::WaterSaturation,
                format!("{} % of the pores wet", format_number(100.0 * sample.water_saturation)),
            ),
            (Parameter::Thickness, Setting::Thickness(base.thickness_cm).label()),
            (Parameter::Angle, angle),
            (Parameter::Illuminant, base.illuminant.name().to_owned()),
        ];
        let is_shown = |parameter: &Parameter| {
            let irrelevant = match parameter {
                Parameter::WaterSaturation => sample.water_saturation <= 0.0,
                _ => false,
            };
            !irrelevant && !self.varies(*parameter)
        };
        let fixed: Vec<String> =
            fixed.into_iter().filter(|(parameter, _)| is_shown(parameter)).map(|(_, words)| words).collect();
        let light = if self.reflected { "Light reflected by snow" } else { "Light through snow" };
        // No line break between a value and its unit.
        format!("{light}: {}", fixed.join(",\n").replace(' ', "\u{a0}").replace('\n', " "))
    }

    /// The line below the swatches: what made them.
    fn description(&self, factor: f64) -> Result<String, Failure> {
        let samples = match self.color.samples {
            SampleCount::Three => "3 samples (455, 551, 608 nm)",
            SampleCount::ThirtyOne => "31 samples (400–700 nm)",
        };
        let colours = format!("{samples}, {}", self.color.observer.name());
        let exposure = format!("exposure {:+.2} stops", factor.log2()).replace('-', "−");
        let mut made = vec![format!("snowblue {}", env!("CARGO_PKG_VERSION")), colours, exposure];
        made.push(self.grains()?);
        let rest = self.sample.metadata()?.into_iter().filter(|(name, _)| !["snow", "snow_id"].contains(name));
        made.extend(rest.map(|(name, value)| format!("{name} {value}")));
        made.push(format!("discrete ordinates, {} streams, seed {}", self.ordinates.streams, self.ordinates.seed));
        Ok(made.join(" · "))
    }

    /// Properties of the snow that do not vary and are not in the title.
    fn grains(&self) -> Result<String, Failure> {
        let sample = self.sample.sample()?;
        let size = sample.grain_size;
        let measure = describe_measure(size.measure);
        let mut words = vec![if self.varies(Parameter::GrainSize) {
            format!("grain size: {measure}")
        } else {
            format!("{measure} {} µm", describe_range(size.min_um, size.max_um))
        }];
        words.push(format!("sphericity {}", describe_distribution(&sample.sphericity)));
        if !self.varies(Parameter::Facetness) {
            words.push(format!("facetness {}", describe_distribution(&sample.facetness)));
        }
        if !self.varies(Parameter::Density) {
            words.push(Setting::Density(sample.density_kg_m3).label());
        }
        words.push(format!("{} °C", format_number(sample.temperature_c)));
        Ok(words.join(", "))
    }

    /// The colours as a table: varying parameters without a column in `color`, then its columns.
    fn results(&self, rows: Vec<Vec<Cell>>) -> DataTable {
        let mut columns: Vec<&str> = self.axes().filter_map(|(_, axis)| axis.parameter.column()).collect();
        columns.extend(color_row::COLUMNS);
        DataTable { columns, rows, metadata: Metadata::new() }
    }
}

/// The axis of a single row or column.
fn single_step() -> SheetAxis {
    SheetAxis { name: String::new(), labels: vec![String::new()] }
}
