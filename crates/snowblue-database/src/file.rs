//! Tables as files: NetCDF classic with 64-bit offsets, dimensions and coordinates by name, CF attributes.
//!
//! A full table holds `transmittance` and `reflectance` on all axes. A compressed one holds, for each of the two, the
//! `coefficients` on all axes but the wavelength, the `basis` and the `singular_values`, and the attribute `space`. A shard
//! holds values on `grain`, `sample` (of a grain), `angle`, `thickness` and `wavelength`, and the attribute `shard`.
//! A file is written beside its place and then renamed, so that none is ever half-written.

use std::io::Cursor;
use std::path::Path;

use netcdf3::error::{ReadError, WriteError};
use netcdf3::{DataSet, FileReader, FileWriter, Version};

use crate::axes::DIFFUSE_ANGLE_DEG;
use crate::fill;
use crate::pca::{Components, MOST_COMPONENTS};
use crate::shard::{Part, Shard};
use crate::{Axes, CompressedTable, DatabaseError, Property, Quantity, Space, Table};

const COMPONENT: &str = "component";
const SINGULAR: &str = "singular_value";
const SHARD: &str = "shard";
const GRAIN: &str = "grain";
const SAMPLE: &str = "sample";
const SHARD_DIMENSIONS: [&str; 5] = [GRAIN, SAMPLE, "angle", "thickness", "wavelength"];
/// What the names of standard errors end in.
const ERRORS: &str = "_standard_error";
const CONVENTIONS: &str = "CF-1.8";

/// A table of either kind.
#[derive(Debug, Clone, PartialEq)]
pub enum AnyTable {
    /// Every value.
    Full(Table),
    /// A few coefficients a curve.
    Compressed(CompressedTable),
    /// Every value of some grains.
    Shard(Shard),
}

impl AnyTable {
    /// What it is, in a few words.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Full(_) => "a full table",
            Self::Compressed(_) => "a compressed table",
            Self::Shard(_) => "a shard of a table",
        }
    }
}

/// A variable that is to be written.
enum Values<'a> {
    Double(&'a [f64]),
    Single(&'a [f32]),
}

impl Table {
    /// Writes the table to `path`.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), DatabaseError> {
        let named = self.axes.named();
        let dimensions: Vec<&str> = named.iter().map(|(name, ..)| *name).collect();
        let values = [&self.transmittance[..], &self.reflectance];
        write(path, &self.axes, &[], &self.metadata, &values_and_errors(&dimensions, values, self.errors.as_ref()))
    }
}

impl Shard {
    /// Writes the shard to `path`.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), DatabaseError> {
        let lengths = [(GRAIN, self.part.grains(&self.axes).len()), (SAMPLE, self.axes.samples_per_grain())];
        let values = [&self.values.transmittance[..], &self.values.reflectance];
        let variables = values_and_errors(&SHARD_DIMENSIONS, values, self.values.errors.as_ref());
        let metadata = [&self.metadata[..], &[(SHARD.to_owned(), self.part.to_string())]].concat();
        write(path, &self.axes, &lengths, &metadata, &variables)
    }
}

/// Transmittance and reflectance and, where they are known, their errors, as variables.
fn values_and_errors<'v>(
    dimensions: &[&'v str],
    values: [&'v [f64]; 2],
    errors: Option<&'v [Vec<f64>; 2]>,
) -> Vec<(String, Vec<&'v str>, Values<'v>)> {
    let variable = |name: String, values| (name, dimensions.to_vec(), Values::Double(values));
    let mut variables = Vec::new();
    for (quantity, values) in Quantity::ALL.into_iter().zip(values) {
        variables.push(variable(quantity.name().to_owned(), values));
    }
    for (quantity, errors) in Quantity::ALL.into_iter().zip(errors.into_iter().flatten()) {
        variables.push(variable(format!("{}{ERRORS}", quantity.name()), errors));
    }
    variables
}

impl CompressedTable {
    /// Writes the table to `path`.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), DatabaseError> {
        let named = self.axes.named();
        let mut curve_dimensions: Vec<&str> = named[..named.len() - 1].iter().map(|(name, ..)| *name).collect();
        curve_dimensions.push(COMPONENT);
        let mut variables = Vec::new();
        for quantity in Quantity::ALL {
            let components = self.components(quantity);
            for (part, dimensions, values) in [
                ("coefficients", curve_dimensions.clone(), Values::Single(&components.coefficients)),
                ("basis", vec!["wavelength", COMPONENT], Values::Single(&components.basis)),
                ("singular_values", vec![SINGULAR], Values::Double(&components.singular_values)),
            ] {
                variables.push((format!("{}_{part}", quantity.name()), dimensions, values));
            }
        }
        let lengths = [(COMPONENT, self.transmittance.count), (SINGULAR, self.transmittance.singular_values.len())];
        let space = ("space".to_owned(), self.space.name().to_owned());
        let metadata = [&self.metadata[..], &[space]].concat();
        write(path, &self.axes, &lengths, &metadata, &variables)
    }

    /// Reads a compressed table out of the bytes of its file. `name` stands in messages.
    ///
    /// # Errors
    /// If the bytes are not a compressed table of snow.
    pub fn from_bytes(name: &str, bytes: &'static [u8]) -> Result<Self, DatabaseError> {
        let path = Path::new(name);
        let reader = FileReader::open_seek_read(name, Box::new(Cursor::new(bytes))).map_err(|e| broken(path, &e))?;
        match read_tables(path, reader)? {
            AnyTable::Compressed(table) => Ok(table),
            other => Err(wrong(path, &format!("is {}, not a compressed one", other.kind()))),
        }
    }
}

/// Reads a table of either kind.
///
/// # Errors
/// If the file cannot be read or is not a table of snow; nothing is guessed or repaired.
pub fn read(path: &Path) -> Result<AnyTable, DatabaseError> {
    // Opened first by itself, so that a missing file and a broken one are told apart.
    std::fs::File::open(path).map_err(|error| wrong(path, &format!("cannot be read: {error}")))?;
    read_tables(path, FileReader::open(path).map_err(|error| broken(path, &error))?)
}

fn read_tables(path: &Path, mut reader: FileReader) -> Result<AnyTable, DatabaseError> {
    let axes = read_axes(path, &mut reader)?;
    let metadata = metadata(reader.data_set());
    if let Some(part) = reader.data_set().get_global_attr_as_string(SHARD) {
        let part: Part =
            part.parse().map_err(|_| wrong(path, &format!("is a shard '{part}', which makes no sense")))?;
        part.check(&axes).map_err(|error| wrong(path, &error.to_string()))?;
        let per_grain = axes.curves() / axes.grains() * axes.wavelengths_nm.len();
        let values = read_values(path, &mut reader, part.grains(&axes).len() * per_grain)?;
        return Ok(AnyTable::Shard(Shard { axes, part, values, metadata }));
    }
    match reader.data_set().get_global_attr_as_string("space").as_deref() {
        None => {
            let expected = axes.curves() * axes.wavelengths_nm.len();
            let fill::Values { transmittance, reflectance, errors } = read_values(path, &mut reader, expected)?;
            Ok(AnyTable::Full(Table { axes, transmittance, reflectance, errors, metadata }))
        }
        Some(space) => {
            let space = [Space::Linear, Space::Log]
                .into_iter()
                .find(|known| known.name() == space)
                .ok_or_else(|| wrong(path, &format!("has the space '{space}', but must have linear or log")))?;
            let transmittance = read_components(path, &mut reader, &axes, Quantity::Transmittance)?;
            let reflectance = read_components(path, &mut reader, &axes, Quantity::Reflectance)?;
            Ok(AnyTable::Compressed(CompressedTable { axes, space, transmittance, reflectance, metadata }))
        }
    }
}

/// Transmittance, reflectance and, if they are there, their errors.
fn read_values(path: &Path, reader: &mut FileReader, expected: usize) -> Result<fill::Values, DatabaseError> {
    let with_errors = reader.data_set().has_var(&format!("{}{ERRORS}", Quantity::Transmittance.name()));
    let mut values =
        |quantity: Quantity, ending| doubles(path, reader, &format!("{}{ending}", quantity.name()), expected);
    let [transmittance, reflectance] = [values(Quantity::Transmittance, "")?, values(Quantity::Reflectance, "")?];
    let errors = if with_errors {
        Some([values(Quantity::Transmittance, ERRORS)?, values(Quantity::Reflectance, ERRORS)?])
    } else {
        None
    };
    Ok(fill::Values { transmittance, reflectance, errors })
}

fn read_axes(path: &Path, reader: &mut FileReader) -> Result<Axes, DatabaseError> {
    let mut axis = |name: &str| {
        let size = reader.data_set().dim_size(name);
        let size = size.ok_or_else(|| wrong(path, &format!("is not a table of snow: it has no dimension '{name}'")))?;
        doubles(path, reader, name, size)
    };
    let mut axes = Axes {
        grain_sizes_um: axis("grain_size")?,
        facetness: axis("facetness")?,
        densities_kg_m3: axis("density")?,
        further: Vec::new(),
        diffuse: false,
        angles_deg: axis("angle")?,
        thicknesses_cm: axis("thickness")?,
        wavelengths_nm: axis("wavelength")?,
    };
    axes.diffuse = axes.angles_deg.first().is_some_and(|angle_deg| angle_deg.to_bits() == DIFFUSE_ANGLE_DEG.to_bits());
    if axes.diffuse {
        axes.angles_deg.remove(0);
    }
    // Coordinates stand in the order of the axes.
    for name in reader.data_set().get_var_names() {
        if let Some(property) = Property::all().find(|property| property.name() == name) {
            let size = reader.data_set().dim_size(&name).unwrap_or(0);
            axes.further.push((property, doubles(path, reader, &name, size)?));
        }
    }
    axes.check_order().map_err(|error| wrong(path, &error.to_string()))?;
    let named = axes.named();
    let is_shard = reader.data_set().has_global_attr(SHARD);
    let expected: Vec<&str> = named.iter().map(|(name, ..)| *name).collect();
    let expected = if is_shard { &SHARD_DIMENSIONS[..] } else { &expected[..] };
    let before_wavelength = expected.len() - 1;
    let order = order_of_dimensions(reader);
    if !order.iter().map(String::as_str).take(before_wavelength).eq(expected[..before_wavelength].iter().copied()) {
        return Err(wrong(path, "has its dimensions in another order; use 'database import'"));
    }
    Ok(axes)
}

/// Names of the dimensions of the variable that holds transmittance, slowest first.
fn order_of_dimensions(reader: &FileReader) -> Vec<String> {
    let data = reader.data_set();
    let variable = ["transmittance", "transmittance_coefficients"].into_iter().find_map(|name| data.get_var(name));
    variable.map_or(Vec::new(), netcdf3::Variable::dim_names)
}

fn read_components(
    path: &Path,
    reader: &mut FileReader,
    axes: &Axes,
    quantity: Quantity,
) -> Result<Components, DatabaseError> {
    let count = reader.data_set().dim_size(COMPONENT).unwrap_or(0);
    if count == 0 || count > MOST_COMPONENTS {
        return Err(wrong(path, &format!("has {count} components, but must have 1–{MOST_COMPONENTS}")));
    }
    let name = |part: &str| format!("{}_{part}", quantity.name());
    let singular = reader.data_set().dim_size(SINGULAR).unwrap_or(0);
    Ok(Components {
        count,
        coefficients: singles(path, reader, &name("coefficients"), axes.curves() * count)?,
        basis: singles(path, reader, &name("basis"), axes.wavelengths_nm.len() * count)?,
        singular_values: doubles(path, reader, &name("singular_values"), singular)?,
    })
}

fn doubles(path: &Path, reader: &mut FileReader, name: &str, expected: usize) -> Result<Vec<f64>, DatabaseError> {
    check_length(path, reader, name, expected)?;
    let values = reader.read_var_f64(name).map_err(|error| broken(path, &error))?;
    check_values(path, name, values, |value| value.is_finite())
}

fn singles(path: &Path, reader: &mut FileReader, name: &str, expected: usize) -> Result<Vec<f32>, DatabaseError> {
    check_length(path, reader, name, expected)?;
    let values = reader.read_var_f32(name).map_err(|error| broken(path, &error))?;
    check_values(path, name, values, |value| value.is_finite())
}

/// Checks that a variable is there and has the length that the axes ask for, before anything of that size is read.
fn check_length(path: &Path, reader: &FileReader, name: &str, expected: usize) -> Result<(), DatabaseError> {
    match reader.data_set().var_len(name) {
        None => Err(wrong(path, &format!("is not a table of snow: it has no variable '{name}'"))),
        Some(length) if length != expected => {
            Err(wrong(path, &format!("has {length} values of '{name}', but its axes ask for {expected}")))
        }
        Some(_) => Ok(()),
    }
}

fn check_values<T>(path: &Path, name: &str, values: Vec<T>, good: fn(&T) -> bool) -> Result<Vec<T>, DatabaseError> {
    match values.iter().position(|value| !good(value)) {
        None => Ok(values),
        Some(place) => Err(wrong(path, &format!("value {place} of '{name}' is not a finite number"))),
    }
}

/// Global attributes but for those that the format itself brings.
fn metadata(data: &DataSet) -> Vec<(String, String)> {
    data.get_global_attr_names()
        .into_iter()
        .filter(|name| name != "Conventions" && name != "space" && name != SHARD)
        .filter_map(|name| data.get_global_attr_as_string(&name).map(|value| (name, value)))
        .collect()
}

/// Writes axes, further dimensions, attributes and variables beside `path`, then renames.
fn write(
    path: &Path,
    axes: &Axes,
    lengths: &[(&str, usize)],
    metadata: &[(String, String)],
    variables: &[(String, Vec<&str>, Values)],
) -> Result<(), DatabaseError> {
    let failed = |error: &dyn std::fmt::Display| wrong(path, &format!("cannot be written: {error}"));
    let data = describe(axes, lengths, metadata, variables).map_err(|error| failed(&format!("{error:?}")))?;
    let mut beside = path.as_os_str().to_owned();
    beside.push(format!(".{}.part", std::process::id()));
    let beside = Path::new(&beside);
    let written = (|| {
        let mut writer = FileWriter::open(beside)?;
        writer.set_def(&data, Version::Offset64Bit, 0)?;
        for (name, _, values) in axes.named() {
            writer.write_var_f64(name, &values)?;
        }
        for (name, _, values) in variables {
            match values {
                Values::Double(values) => writer.write_var_f64(name, values)?,
                Values::Single(values) => writer.write_var_f32(name, values)?,
            }
        }
        writer.close()
    })();
    let renamed = written
        .map_err(|error: WriteError| failed(&reason(&error)))
        .and_then(|()| std::fs::rename(beside, path).map_err(|error| failed(&error)));
    if renamed.is_err() {
        // What is left of a failed write is of no use; a second failure would only hide the first.
        drop(std::fs::remove_file(beside));
    }
    renamed
}

fn describe(
    axes: &Axes,
    lengths: &[(&str, usize)],
    metadata: &[(String, String)],
    variables: &[(String, Vec<&str>, Values)],
) -> Result<DataSet, netcdf3::error::InvalidDataSet> {
    let mut data = DataSet::new();
    data.add_global_attr_string("Conventions", CONVENTIONS)?;
    for (name, value) in metadata {
        data.add_global_attr_string(name, value)?;
    }
    for (name, units, values) in axes.named() {
        data.add_fixed_dim(name, values.len())?;
        data.add_var_f64(name, &[name])?;
        data.add_var_attr_string(name, "units", units)?;
        data.add_var_attr_string(name, "long_name", name.replace('_', " "))?;
        if name == "angle" && axes.diffuse {
            data.add_var_attr_f64(name, "flag_values", vec![DIFFUSE_ANGLE_DEG])?;
            data.add_var_attr_string(name, "flag_meanings", "diffuse")?;
        }
    }
    for (name, length) in lengths {
        data.add_fixed_dim(*name, *length)?;
    }
    for (name, dimensions, values) in variables {
        match values {
            Values::Double(_) => data.add_var_f64(name, dimensions)?,
            Values::Single(_) => data.add_var_f32(name, dimensions)?,
        }
        data.add_var_attr_string(name, "units", "1")?;
        data.add_var_attr_string(name, "long_name", name.replace('_', " "))?;
    }
    Ok(data)
}

fn wrong(path: &Path, what: &str) -> DatabaseError {
    DatabaseError::File { path: path.to_owned(), what: what.to_owned() }
}

fn broken(path: &Path, error: &ReadError) -> DatabaseError {
    // The debugging form of a header's error holds the file's bytes: nothing for a person.
    let reason = match error {
        ReadError::IOErrorKind(kind) => kind.to_string(),
        ReadError::ParseHeader(_) => "its header makes no sense".to_owned(),
        other => format!("{other:?}").chars().take(100).collect(),
    };
    wrong(path, &format!("is not a whole NetCDF classic file: {reason}"))
}

fn reason(error: &WriteError) -> String {
    match error {
        WriteError::IOErrorKind(kind) => kind.to_string(),
        other => format!("{other:?}"),
    }
}
