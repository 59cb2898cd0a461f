//! Slabs: the lines of a CSV file, or the combinations of the values of options.
//!
//! All lines are checked before the first line is computed, so that a mistake on the last line costs no time.

use std::path::{Path, PathBuf};

use snowblue_base::csv_text::{cells, is_comment, lines, separator_hint};
use snowblue_figures::{Cell, format_number};
use snowblue_transport::batch::{Batch, BatchError, SlabCase};
use snowblue_transport::optics::{Impurities, Wavelengths};
use snowblue_transport::sample::{GrainSize, Property, SizeMeasure, SnowKeys, SnowSample};
use snowblue_transport::slab::Incidence;
use snowblue_transport::{GroundAlbedo, Number};

use super::curves::{Labels, SLAB_COLUMNS, slab_cells};
use crate::input::SettingsFile;
use crate::options::parse::GivenGround;
use crate::options::property::{option_name, values};
use crate::options::{GivenOptions, PropertyAxis, SnowOptions, has_no_effect, parse, set_optical_radius};
use crate::output::Failure;

/// Slabs with the leading cells of their rows.
pub(super) struct Slabs {
    pub(super) labels: Labels,
    /// The kinds of snow.
    pub(super) samples: Vec<SnowSample>,
    cases: Vec<SlabCase>,
    /// The file, and the line of each case in the file, from 1; none for options.
    file: Option<(PathBuf, Vec<usize>)>,
    /// Whether each slab is a case. The others have a cell NaN, and no fluxes.
    is_known: Vec<bool>,
    /// Which columns of the file have empty cells, and what they stand for.
    pub(super) notes: Vec<String>,
}

/// Values of the options, for quantities that no column or axis sets.
pub(super) struct Defaults<'o> {
    pub(super) snow: &'o SnowOptions,
    pub(super) thicknesses_cm: &'o [f64],
    pub(super) incidences: &'o [Incidence],
    pub(super) ground_albedo: GivenGround,
}

/// A column of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Column {
    Name,
    Thickness,
    Angle,
    Ground,
    Snow,
    OpticalRadius,
    SizeMeasure,
    Ice,
    Property(Property),
}

/// One line of a file.
struct Line {
    snow: SnowKeys,
    thickness_cm: f64,
    incidence: Incidence,
    ground_albedo: GivenGround,
}

/// A line of a file that is read.
struct ReadLine {
    own: Line,
    cells: Vec<Cell>,
    sample: SnowSample,
    /// Which of its cells are not empty.
    is_given: Vec<bool>,
    /// Whether no cell is NaN.
    is_known: bool,
}

impl Slabs {
    /// Every combination of the values of the options.
    pub(super) fn of_options(defaults: &Defaults) -> Result<Self, Failure> {
        let axes: Vec<&PropertyAxis> = defaults.snow.axes().collect();
        let lengths = axes.iter().map(|axis| axis.values.len());
        let lengths = lengths.chain([defaults.thicknesses_cm.len(), defaults.incidences.len()]);
        check_count(lengths.clone().map(|length| length as f64).product(), "slabs")?;
        let lengths: Vec<usize> = lengths.collect();
        let mut combinations: Vec<(Vec<Cell>, SnowKeys)> = vec![(Vec::new(), defaults.snow.keys()?)];
        for PropertyAxis { property, values } in &axes {
            let with = |(cells, snow): &(Vec<Cell>, SnowKeys), value: &[f64]| {
                let mut snow = snow.clone();
                snow.set(*property, value).map_err(Failure::input)?;
                Ok(([&cells[..], &[cell(value)]].concat(), snow))
            };
            let all = combinations.iter().flat_map(|one| values.iter().map(move |value| with(one, value)));
            combinations = all.collect::<Result<_, Failure>>()?;
        }
        let (mut samples, mut cases, mut cells) = (Vec::new(), Vec::new(), Vec::new());
        for (of_snow, snow) in combinations {
            samples.push(snow.sample().map_err(|wrong| Failure::input(wrong.error))?);
            for thickness_cm in defaults.thicknesses_cm {
                for incidence in defaults.incidences {
                    cells.push([&of_snow[..], &slab_cells(*thickness_cm, incidence)].concat());
                    cases.push(SlabCase {
                        sample: samples.len() - 1,
                        thickness_cm: *thickness_cm,
                        incidence: *incidence,
                        ground_albedo: defaults.ground_albedo.albedo.clone(),
                    });
                }
            }
        }
        let columns = axes.iter().map(|axis| axis.property.key()).chain(SLAB_COLUMNS).collect();
        let is_known = vec![true; cells.len()];
        let labels = Labels { columns, cells, axes: Some(lengths) };
        Ok(Self { labels, samples, cases, file: None, is_known, notes: Vec::new() })
    }

    /// The lines of a file.
    pub(super) fn read(path: &Path, defaults: &Defaults, given: &GivenOptions) -> Result<Self, Failure> {
        if let Some(axis) = defaults.snow.axes().next() {
            let option = axis.option();
            return Err(Failure::Input(format!("--{option} has several values, but --batch takes one, or a column")));
        }
        let text = SettingsFile::read(path)?;
        let mut lines = lines(&text).skip_while(|(_, line)| is_comment(line));
        let at = |line: usize, why: &str| Failure::Input(format!("{}:{line}: {why}", path.display()));
        let empty = || Failure::Input(format!("{}: has no line of names of columns", path.display()));
        let (number, header) = lines.next().ok_or_else(empty)?;
        let columns = columns(header, given).map_err(|why| at(number, &why))?;
        let first = Line {
            snow: defaults.snow.keys()?,
            thickness_cm: single("thickness", defaults.thicknesses_cm)?,
            incidence: single("angle", defaults.incidences)?,
            ground_albedo: defaults.ground_albedo.clone(),
        };
        // An error in the options does not belong to a line.
        let sample = first.snow.sample().map_err(|wrong| Failure::input(wrong.error))?;
        check_slab(&sample, first.case(0)).map_err(Failure::input)?;
        let others = [(Column::Thickness, 0), (Column::Angle, 1)];
        let others = others.iter().filter(|(column, _)| !columns.contains(column)).map(|(_, place)| *place);
        let others: Vec<usize> = others.collect();
        let names = columns.iter().map(|column| column.name()).chain(others.iter().map(|place| SLAB_COLUMNS[*place]));
        let labels = Labels { columns: names.collect(), cells: Vec::new(), axes: None };
        let (samples, cases, notes) = (Vec::new(), Vec::new(), Vec::new());
        let mut slabs = Self { labels, samples, cases, file: None, is_known: Vec::new(), notes };
        let (mut numbers, mut empty) = (Vec::new(), vec![0; columns.len()]);
        // A name may begin with the sign of a comment.
        let has_comments = columns.first() != Some(&Column::Name);
        for (number, line) in lines.filter(|(_, line)| !has_comments || !is_comment(line)) {
            let ReadLine { own, mut cells, sample, is_given, is_known } =
                first.read(&columns, line).map_err(|why| at(number, &why))?;
            empty.iter_mut().zip(is_given).for_each(|(empty, given)| *empty += usize::from(!given));
            let slab = slab_cells(own.thickness_cm, &own.incidence);
            cells.extend(others.iter().map(|place| slab[*place].clone()));
            slabs.labels.cells.push(cells);
            slabs.is_known.push(is_known);
            if is_known {
                let sample = slabs.place_of(sample);
                slabs.cases.push(own.case(sample));
                numbers.push(number);
            } else {
                check_slab(&sample, own.case(0)).map_err(|error| at(number, &error.to_string()))?;
            }
        }
        if slabs.is_known.is_empty() {
            return Err(Failure::Input(format!("{}: has no slab below the names of columns", path.display())));
        }
        slabs.file = Some((path.to_owned(), numbers));
        let count = slabs.is_known.len();
        let note = |(column, empty): (&Column, &usize)| {
            let taken = first.default_text(*column, &sample)?;
            let has_kinds = matches!(column, Column::Property(_)) && columns.contains(&Column::Snow);
            let or = if has_kinds { ", or the value of the kind of snow of the line," } else { "" };
            let (path, name) = (path.display(), column.name());
            Some(format!("{path}: {empty} of {count} lines have no {name}: {taken}{or} is taken"))
        };
        slabs.notes = columns.iter().zip(&empty).filter(|(_, empty)| **empty > 0).filter_map(note).collect();
        for (column, _) in columns.iter().zip(empty).filter(|(_, empty)| *empty == 0) {
            if let Some(option) = column.option().filter(|option| given.has(option) && column.is_in(&first.snow)) {
                let why = format!("each line of {} has {}", path.display(), column.name());
                return Err(has_no_effect(option, &why));
            }
        }
        Ok(slabs)
    }

    /// Refuses more values than fit into memory.
    pub(super) fn check_size(&self, wavelengths: usize) -> Result<(), Failure> {
        check_count(self.cases.len() as f64 * wavelengths as f64, "spectral values")
    }

    /// The slabs at some wavelengths, checked.
    pub(super) fn batch(&self, wavelengths: Wavelengths) -> Result<Batch, Failure> {
        let batch = Batch { samples: self.samples.clone(), cases: self.cases.clone(), wavelengths_nm: wavelengths.0 };
        batch.check().map_err(|wrong| self.failure(&wrong))?;
        Ok(batch)
    }

    /// Whether all slabs have the snow of the options.
    pub(super) fn has_one_snow(&self) -> bool {
        self.file.is_none() && self.samples.len() == 1
    }

    /// The values of all slabs at each wavelength, by those of the cases; `unknown` where a cell is NaN.
    pub(super) fn with_gaps<T: Clone>(&self, of_cases: Vec<T>, unknown: &[T]) -> Vec<T> {
        if self.cases.len() == self.is_known.len() {
            return of_cases;
        }
        let mut cases = of_cases.chunks_exact(unknown.len());
        let of_slab = |is_known: &bool| match is_known {
            true => cases.next().unwrap_or_else(|| unreachable!("there are the values of each case")).to_vec(),
            false => unknown.to_vec(),
        };
        self.is_known.iter().flat_map(of_slab).collect()
    }

    /// The place of a sample among the samples of the batch. Neighbouring lines often have the same sample.
    fn place_of(&mut self, sample: SnowSample) -> usize {
        if self.samples.last() != Some(&sample) {
            self.samples.push(sample);
        }
        self.samples.len() - 1
    }

    /// The error of a case, with its line.
    pub(super) fn failure(&self, BatchError { case, error }: &BatchError) -> Failure {
        let line = case.and_then(|case| self.file.as_ref().map(|(path, lines)| (path, lines[case])));
        match line {
            Some((path, line)) => Failure::Input(format!("{}:{line}: {error}", path.display())),
            None => Failure::input(error),
        }
    }
}

/// Greatest number of slabs and of their spectral values, which take some hundred bytes each.
const MAX_VALUES: f64 = 1e8;

fn check_count(count: f64, of: &str) -> Result<(), Failure> {
    if count <= MAX_VALUES {
        return Ok(());
    }
    Err(Failure::Input(format!(
        "the options make {count} {of}, but at most {MAX_VALUES} are computed at once: take fewer values of options, \
         or wavelengths"
    )))
}

/// The number of a property, or the numbers of a distribution between colons.
fn cell(numbers: &[f64]) -> Cell {
    match numbers {
        [number] => (*number).into(),
        _ => Cell::word(numbers.iter().map(|number| format_number(*number)).collect::<Vec<_>>().join(":")),
    }
}

/// The only value of an option.
fn single<T: Copy>(option: &str, values: &[T]) -> Result<T, Failure> {
    match values {
        [value] => Ok(*value),
        _ => Err(Failure::Input(format!("--{option} has several values, but --batch takes one, or a column"))),
    }
}

/// Names of all columns.
pub(super) fn names_of_columns() -> String {
    Column::all().map(Column::name).collect::<Vec<_>>().join(", ")
}

/// The columns that a line names.
fn columns(header: &str, given: &GivenOptions) -> Result<Vec<Column>, String> {
    let mut columns = Vec::new();
    for name in cells(header) {
        let column = Column::all().find(|column| column.name() == name);
        let column = column.ok_or_else(|| {
            let hint = separator_hint(name, 1);
            let known = if hint.is_empty() { format!("; there are {}", names_of_columns()) } else { hint };
            format!("column '{name}' is not known{known}")
        })?;
        if columns.contains(&column) {
            return Err(format!("column {name} is given twice"));
        }
        let excluded = Column::all().filter(|other| column.excludes(*other)).filter_map(Column::option);
        if let Some(option) = excluded.into_iter().find(|option| given.has(option)) {
            return Err(format!("column {name} cannot be given with --{}", option.replace('_', "-")));
        }
        columns.push(column);
    }
    Ok(columns)
}

/// Checks a slab at one wavelength. Impurities, and a spectrum as ground, were checked when they were read, and need
/// not cover this wavelength.
fn check_slab(sample: &SnowSample, mut case: SlabCase) -> Result<(), BatchError> {
    if let GroundAlbedo::Spectrum(_) = case.ground_albedo {
        case.ground_albedo = 0.0.into();
    }
    let clean = SnowSample { impurities: Impurities::none(), ..*sample };
    let wavelengths_nm = vec![sample.ice.wavelength_range().first_nm];
    Batch { samples: vec![clean], cases: vec![case], wavelengths_nm }.check()
}

impl Line {
    /// The slab of a line. A cell that is empty or NaN has the value of `self`; a slab with a cell NaN is not computed.
    fn read(&self, columns: &[Column], line: &str) -> Result<ReadLine, String> {
        let words: Vec<&str> = cells(line).collect();
        if words.len() != columns.len() {
            let hint = separator_hint(line, columns.len());
            return Err(format!("has {} cells, but there are {} columns{hint}", words.len(), columns.len()));
        }
        let mut own = Self { snow: self.snow.clone(), ground_albedo: self.ground_albedo.clone(), ..*self };
        let is_nan = |(column, word): &(&Column, &&str)| column.is_number() && word.parse().is_ok_and(f64::is_nan);
        let given = || columns.iter().zip(&words).filter(|cell| !cell.1.is_empty() && !is_nan(cell));
        for (column, word) in given() {
            if let Some((other, _)) = given().find(|(other, _)| column.excludes(**other)) {
                return Err(format!("{} cannot be given with {}", column.name(), other.name()));
            }
            own.set(*column, word).map_err(|why| format!("{}: {why}{}", column.name(), separator_hint(word, 1)))?;
        }
        let sample = own.snow.sample().map_err(|wrong| wrong.error.to_string())?;
        let cell = |(column, word): (&Column, &&str)| match word.parse::<f64>() {
            Err(_) if word.is_empty() => self.default_cell(*column, &sample),
            Ok(number) if *column != Column::Name => Cell::from(number),
            _ => Cell::word(*word),
        };
        let cells = columns.iter().zip(&words).map(cell).collect();
        let is_known = !columns.iter().zip(&words).any(|cell| is_nan(&cell));
        Ok(ReadLine { own, cells, sample, is_given: words.iter().map(|word| !word.is_empty()).collect(), is_known })
    }

    /// The meaning of an empty cell of a line, if `self` is the slab of the options. It is empty if no option sets
    /// the value, and for distributions, which the metadata describe.
    fn default_cell(&self, column: Column, sample: &SnowSample) -> Cell {
        let snow = &self.snow;
        let number = |value: Option<f64>| value.map_or(Cell::word(""), Cell::from);
        match column {
            Column::Thickness => self.thickness_cm.into(),
            Column::Angle => Cell::word(self.incidence.to_string()),
            Column::Ground => match self.ground_albedo.albedo {
                GroundAlbedo::Grey(albedo) => albedo.into(),
                GroundAlbedo::Spectrum(_) => Cell::word(&self.ground_albedo.word),
            },
            Column::Property(Property::SurfaceArea) => number(snow.ssa_m2_kg.map(Number::get)),
            Column::Property(Property::GrainSize) => snow.grain_size_um.as_deref().map_or(Cell::word(""), cell),
            Column::OpticalRadius => number(snow.grain_size_um.as_ref().map(|diameters_um| 0.5 * diameters_um[0])),
            Column::Snow => Cell::word(snow.snow.map_or(String::new(), |kind| kind.to_string())),
            Column::SizeMeasure => Cell::word(snow.size_measure.map_or("", SizeMeasure::name)),
            Column::Ice => Cell::word(sample.ice.name()),
            Column::Name | Column::Property(Property::Facetness | Property::Sphericity) => Cell::word(""),
            Column::Property(property) => property.get(sample).into(),
        }
    }

    /// The meaning of an empty cell in words; none of a name.
    fn default_text(&self, column: Column, sample: &SnowSample) -> Option<String> {
        let text = self.default_cell(column, sample).text();
        Some(match column {
            Column::Name => return None,
            _ if !text.is_empty() => text,
            Column::Property(Property::Facetness | Property::Sphericity) => {
                "the distribution of the options".to_owned()
            }
            Column::SizeMeasure => SizeMeasure::default().name().to_owned(),
            _ => {
                let GrainSize { min_um, max_um, .. } = sample.grain_size;
                let [min_um, max_um] = [min_um, max_um].map(format_number);
                format!("a grain size of {min_um}–{max_um} µm, unless another column has one,")
            }
        })
    }

    /// The slab with a sample of a batch.
    fn case(&self, sample: usize) -> SlabCase {
        let Self { thickness_cm, incidence, ground_albedo, .. } = self;
        let ground_albedo = ground_albedo.albedo.clone();
        SlabCase { sample, thickness_cm: *thickness_cm, incidence: *incidence, ground_albedo }
    }

    fn set(&mut self, column: Column, word: &str) -> Result<(), String> {
        let snow = &mut self.snow;
        match column {
            Column::Name => {}
            Column::Thickness => self.thickness_cm = parse::number(word)?,
            Column::Angle => self.incidence = parse::incidence(word)?,
            Column::Ground => self.ground_albedo = parse::ground_albedo(word)?,
            Column::Snow => snow.snow = Some(parse::snow_type(word)?),
            Column::OpticalRadius => set_optical_radius(snow, parse::number(word)?),
            Column::SizeMeasure => snow.size_measure = Some(parse::size_measure(word)?),
            Column::Ice => snow.ice = Some(parse::ice(word)?),
            Column::Property(property) => {
                snow.set(property, &values(property, word)?).map_err(|error| error.to_string())?;
            }
        }
        Ok(())
    }
}

impl Column {
    fn all() -> impl Iterator<Item = Self> {
        [Self::Name, Self::Thickness, Self::Angle, Self::Ground, Self::Snow]
            .into_iter()
            .chain(Property::all().map(Self::Property))
            .chain([Self::OpticalRadius, Self::SizeMeasure, Self::Ice])
    }

    fn name(self) -> &'static str {
        match self {
            Self::Name => "name",
            Self::Thickness => SLAB_COLUMNS[0],
            Self::Angle => SLAB_COLUMNS[1],
            Self::Ground => "ground_albedo",
            Self::Snow => "snow",
            Self::OpticalRadius => "optical_radius_um",
            Self::SizeMeasure => "size_measure",
            Self::Ice => "ice",
            Self::Property(property) => property.key(),
        }
    }

    /// Whether its cells are numbers.
    fn is_number(self) -> bool {
        !matches!(self, Self::Name | Self::Snow | Self::SizeMeasure | Self::Ice)
    }

    /// Whether a slab cannot have both quantities, in two columns or in a column and an option. Grains have only one
    /// size, and specific surface area and optical radius have a measure of their own.
    fn excludes(self, other: Self) -> bool {
        let has_measure = |one| matches!(one, Self::OpticalRadius | Self::Property(Property::SurfaceArea));
        let is_size = |one| one == Self::Property(Property::GrainSize) || has_measure(one);
        let are_measures = |one, other| one == Self::SizeMeasure && has_measure(other);
        self != other && is_size(self) && is_size(other) || are_measures(self, other) || are_measures(other, self)
    }

    /// Whether the options set this column, if one option sets several columns.
    fn is_in(self, snow: &SnowKeys) -> bool {
        match self {
            Self::Property(Property::Impurity(substance)) => snow.impurities_ng_g.ng_g(substance) > 0.0,
            _ => true,
        }
    }

    /// The option that sets this quantity of all slabs, by its name in Rust.
    fn option(self) -> Option<&'static str> {
        Some(match self {
            Self::Name => return None,
            Self::Thickness => "thickness",
            Self::Angle => "angle",
            Self::OpticalRadius => "optical_radius",
            Self::Property(property) => option_name(property),
            Self::Ground | Self::Snow | Self::SizeMeasure | Self::Ice => self.name(),
        })
    }
}
