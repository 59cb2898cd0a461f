//! `snowblue swatch`: the colours of light through snow as a picture, over any two parameters.

mod axis;
mod given;
mod seen;

use std::path::PathBuf;

use clap::Args;
use snowblue_color::exposure;
use snowblue_render::FalseColor;
use snowblue_render::film::exposure::Exposure;
use snowblue_render::film::image_file::write_picture;
use snowblue_render::swatch::{SheetAxis, SwatchSheet, automatic_exposure};
use snowblue_transport::sample::SizeMeasure;
use snowblue_transport::slab::Incidence;

use crate::colored;
use crate::failure::{Failure, Outcome};
use crate::options::{
    EyeOptions, LightOptions, OrdinatesWords, SampleOptions, SlabOptions, law_in_words, measure_in_words,
    range_in_words,
};
use crate::parse::{self, SizeWords};
use crate::report::{Cell, Report, check_place, figures, write_file};
use axis::{Axis, Parameter, Setting, Subject, axis};
use given::Given;

/// Longest side of the swatches together, in pixels.
const MOST_PIXELS: u32 = 16_384;

/// Swatches of the light that comes through snow, over any two parameters, as a PNG
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Rows and columns: grain-size (µm), facetness, density (kg/m³), water-saturation, thickness
(cm), angle (deg), illuminant; values as the options of the same names take them. All swatches
share one exposure: 'auto' brings the greatest channel of the brightest one to 0.8 of a
screen's white, up to which the snow texture fits and its average is the colour; brighter
swatches are cut off at white where the texture is light. Hues that no screen can show lose saturation.

Examples:
  snowblue swatch --rows grain-size=100,500 --columns angle=0,40,80 -o angles.png
  snowblue swatch --rows illuminant=D65,FL3.15 --columns thickness=2,5,10 -o lamps.png
  snowblue swatch --columns thickness=5,10,15,30 --exposure 3 --colors colours.csv -o thick.png"
)]
pub(crate) struct Swatch {
    /// Options that are on the command line; it reads them first, while they are there.
    #[command(flatten)]
    given: Given,
    /// What varies from left to right
    #[arg(long, value_name = "NAME=LIST", value_parser = axis, required_unless_present = "rows", help_heading = "Sheet")]
    columns: Option<Axis>,
    /// What varies from top to bottom
    #[arg(long, value_name = "NAME=LIST", value_parser = axis, help_heading = "Sheet")]
    rows: Option<Axis>,
    #[command(flatten)]
    sample: SampleOptions,
    #[command(flatten)]
    slab: SlabOptions,
    #[command(flatten)]
    ordinates: OrdinatesWords,
    #[command(flatten)]
    light: LightOptions,
    #[command(flatten)]
    eye: EyeOptions,
    /// The light that snow sends back instead of that which comes through
    #[arg(long, help_heading = "Light")]
    reflected: bool,
    /// Brightness of the picture in stops above the bare light as white, or 'auto'
    #[arg(long, value_name = "STOPS", default_value = "auto", value_parser = parse::exposure, help_heading = "Light")]
    exposure: Exposure,
    /// Height of a swatch in pixels; it is as wide or, under long labels, wider
    #[arg(long, value_name = "N", default_value_t = 160, value_parser = clap::value_parser!(u32).range(16..=2048), help_heading = "Sheet")]
    size: u32,
    /// Flat colours, without the grey texture of snow
    #[arg(long, help_heading = "Sheet")]
    no_texture: bool,
    /// Where to write the picture (.png)
    #[arg(short, long, value_name = "FILE", help_heading = "Output")]
    output: PathBuf,
    /// Write the colours too, with the columns of 'color', those that vary, and the hex that is shown (.csv)
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    colors: Option<PathBuf>,
}

impl Swatch {
    pub(crate) fn run(&self) -> Outcome {
        self.check()?;
        let subjects = self.subjects()?;
        let colours = self.seen(&subjects)?;
        let factor = match self.exposure {
            Exposure::Stops(stops) => exposure::factor(stops),
            Exposure::Auto => automatic_exposure(colours.iter().flatten().map(|seen| &seen.light)),
        };
        let sheet = SwatchSheet {
            title: self.title(&subjects[0][0]),
            closing: self.closing(factor)?,
            columns: self.columns.as_ref().map_or_else(alone, Axis::sheet),
            rows: self.rows.as_ref().map_or_else(alone, Axis::sheet),
            colours: colours.iter().map(|row| row.iter().map(|seen| seen.light * factor).collect()).collect(),
            size_px: self.size,
            texture: (!self.no_texture).then_some(self.ordinates.seed),
        };
        let software = format!("snowblue {}", env!("CARGO_PKG_VERSION"));
        let title = sheet.title.replace('\u{a0}', " ");
        let notes = [("Software", &*software), ("Title", &*title), ("Description", &*sheet.closing)];
        write_picture(&sheet.draw(), &notes, &self.output).map_err(Failure::work)?;
        let Some(path) = &self.colors else { return Ok(()) };
        let rows = colours.into_iter().flatten().map(|seen| seen.row(factor)).collect();
        write_file(path, self.report(rows).csv().as_bytes())
    }

    /// Checks before the work what can be told from the words alone.
    fn check(&self) -> Outcome {
        for (path, ending) in [(Some(&self.output), "png"), (self.colors.as_ref(), "csv")] {
            let Some(path) = path else { continue };
            if path.extension().is_none_or(|found| !found.eq_ignore_ascii_case(ending)) {
                return Err(Failure::Input(format!("{}: the file must end in .{ending}", path.display())));
            }
            check_place(path)?;
        }
        self.check_axes()?;
        for (name, count) in [("thickness", self.slab.thickness.len()), ("angle", self.slab.angle.len())] {
            if count != 1 {
                let advice = format!("give them to --rows or --columns as {name}=VALUE,VALUE");
                return Err(Failure::Input(format!("--{name} has {count} values; {advice}")));
            }
        }
        Ok(())
    }

    fn check_axes(&self) -> Outcome {
        let axes: Vec<(&str, &Axis)> = self.axes().collect();
        if let [(_, rows), (_, columns)] = axes[..]
            && rows.parameter == columns.parameter
        {
            return Err(Failure::Input(format!("{} is given to --rows and to --columns", rows.parameter.name())));
        }
        for (option, axis) in &axes {
            if let Some(rival) = axis.parameter.rivals().iter().find(|rival| self.given.has(rival)) {
                let (name, rival) = (axis.parameter.name(), rival.replace('_', "-"));
                return Err(Failure::Input(format!("{name} is given to {option} and set by --{rival}")));
            }
            let pixels = self.size.saturating_mul(u32::try_from(axis.len()).unwrap_or(u32::MAX));
            if pixels > MOST_PIXELS {
                let size = self.size;
                return Err(Failure::Input(format!(
                    "{option}: {} swatches of {size} pixels are {pixels} pixels, but must be at most {MOST_PIXELS}",
                    axis.len()
                )));
            }
            if axis.parameter == Parameter::Illuminant && self.eye.false_color.is_some() {
                return Err(Failure::Input(format!("{option}: false colours have no illuminant")));
            }
        }
        Ok(())
    }

    /// What each swatch shows: for each row, each column.
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

    /// What varies, with the option that says so, rows first.
    fn axes(&self) -> impl Iterator<Item = (&'static str, &Axis)> {
        let named = [("--rows", &self.rows), ("--columns", &self.columns)];
        named.into_iter().filter_map(|(option, axis)| Some((option, axis.as_ref()?)))
    }

    fn varies(&self, parameter: Parameter) -> bool {
        self.axes().any(|(_, axis)| axis.parameter == parameter)
    }

    /// What is shown, and all that does not vary.
    fn title(&self, base: &Subject) -> String {
        let sample = &base.sample;
        let size = sample.grain_size;
        let tenth = |um: f64| (10.0 * um).round() / 10.0;
        let sizes = Setting::GrainSize(SizeWords::Range(tenth(size.min_um), tenth(size.max_um))).label();
        let sizes = match size.measure {
            SizeMeasure::GreatestExtension => sizes,
            other => format!("{} {sizes}", measure_in_words(other)),
        };
        let angle = match base.incidence {
            Incidence::Diffuse => "diffuse light".to_owned(),
            beam @ Incidence::Beam { .. } => Setting::Angle(beam).label(),
        };
        let fixed = [
            (Parameter::GrainSize, sizes),
            (Parameter::Facetness, format!("facetness {}", Setting::Facetness(sample.facetness).label())),
            (Parameter::Density, Setting::Density(sample.density_kg_m3).label()),
            (Parameter::WaterSaturation, format!("{} % of the pores wet", figures(100.0 * sample.water_saturation))),
            (Parameter::Thickness, Setting::Thickness(base.thickness_cm).label()),
            (Parameter::Angle, angle),
            (Parameter::Illuminant, base.illuminant.name().to_owned()),
        ];
        let said = |parameter: &Parameter| {
            let idle = match parameter {
                Parameter::WaterSaturation => sample.water_saturation <= 0.0,
                Parameter::Illuminant => self.eye.false_color.is_some(),
                _ => false,
            };
            !idle && !self.varies(*parameter)
        };
        let fixed: Vec<String> = fixed.into_iter().filter(|(of, _)| said(of)).map(|(_, words)| words).collect();
        let light = if self.reflected { "Light that snow sends back" } else { "Light through snow" };
        // A value and its unit stay on one line.
        format!("{light}: {}", fixed.join(",\n").replace(' ', "\u{a0}").replace('\n', " "))
    }

    /// What made the sheet.
    fn closing(&self, factor: f64) -> Result<String, Failure> {
        let colours = match self.eye.false_color {
            Some(FalseColor { red_nm, green_nm, blue_nm }) => {
                format!("false colours {red_nm}, {green_nm}, {blue_nm} nm")
            }
            None if self.eye.samples == "3" => format!("3 samples (455, 551, 608 nm), {}", self.eye.observer.name()),
            None => format!("31 samples (400–700 nm), {}", self.eye.observer.name()),
        };
        let exposure = format!("exposure {:+.2} stops", factor.log2()).replace('-', "−");
        let mut made = vec![format!("snowblue {}", env!("CARGO_PKG_VERSION")), colours, exposure];
        made.push(self.grains()?);
        let rest = self.sample.metadata()?.into_iter().filter(|(name, _)| *name != "snow");
        made.extend(rest.map(|(name, value)| format!("{name} {value}")));
        made.push(format!("discrete ordinates, {} streams, seed {}", self.ordinates.streams, self.ordinates.seed));
        Ok(made.join(" · "))
    }

    /// What the title leaves out of the snow: all of it that does not vary.
    fn grains(&self) -> Result<String, Failure> {
        let sample = self.sample.sample()?;
        let size = sample.grain_size;
        let measure = measure_in_words(size.measure);
        let mut words = vec![if self.varies(Parameter::GrainSize) {
            format!("grain size: {measure}")
        } else {
            format!("{measure} {} µm", range_in_words(size.min_um, size.max_um))
        }];
        words.push(format!("sphericity {}", law_in_words(&sample.sphericity)));
        if !self.varies(Parameter::Facetness) {
            words.push(format!("facetness {}", law_in_words(&sample.facetness)));
        }
        if !self.varies(Parameter::Density) {
            words.push(Setting::Density(sample.density_kg_m3).label());
        }
        words.push(format!("{} °C", figures(sample.temperature_c)));
        Ok(words.join(", "))
    }

    /// The colours as a table: those of the varying parameters that `color` has no column for, then its own.
    fn report(&self, rows: Vec<Vec<Cell>>) -> Report {
        let mut columns: Vec<&str> = self.axes().filter_map(|(_, axis)| axis.parameter.column()).collect();
        columns.extend(if self.eye.false_color.is_some() { &colored::FALSE_COLUMNS[..] } else { &colored::COLUMNS });
        Report { columns, rows, metadata: Vec::new() }
    }
}

/// Of one row or column nothing varies.
fn alone() -> SheetAxis {
    SheetAxis { name: String::new(), labels: vec![String::new()] }
}
