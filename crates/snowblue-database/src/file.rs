//! Tables as files: NetCDF classic with 64-bit offsets, dimensions and coordinates by name, CF attributes.
//!
//! A full table holds `transmittance` and `reflectance` on all axes. A compressed one holds, for each of the two, the
//! `coefficients` on all axes but the wavelength, the `basis` and the `singular_values`, and the attribute `space`.
//! A file is written beside its place and then renamed, so that none is ever half-written.

use std::io::Cursor;
use std::path::Path;

use netcdf3::error::{ReadError, WriteError};
use netcdf3::{DataSet, FileReader, FileWriter, Version};

use crate::pca::{Components, MOST_COMPONENTS};
use crate::{Axes, CompressedTable, DatabaseError, Quantity, Space, Table};

const COMPONENT: &str = "component";
const SINGULAR: &str = "singular_value";
const CONVENTIONS: &str = "CF-1.8";

/// A table of either kind.
#[derive(Debug, Clone, PartialEq)]
pub enum AnyTable {
    /// Every value.
    Full(Table),
    /// A few coefficients a curve.
    Compressed(CompressedTable),
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
        let dimensions: Vec<&str> = self.axes.named().iter().map(|(name, ..)| *name).collect();
        let variables: Vec<_> = Quantity::ALL
            .map(|quantity| (quantity.name().to_owned(), dimensions.clone(), Values::Double(self.values(quantity))))
            .into();
        write(path, &self.axes, &[], &self.metadata, &variables)
    }
}

impl CompressedTable {
    /// Writes the table to `path`.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), DatabaseError> {
        let named = self.axes.named();
        let mut curve_dimensions: Vec<&str> = named[..5].iter().map(|(name, ..)| *name).collect();
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
            AnyTable::Full(_) => Err(wrong(path, "is a full table, not a compressed one")),
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
    match reader.data_set().get_global_attr_as_string("space").as_deref() {
        None => {
            let expected = axes.curves() * axes.wavelengths_nm.len();
            let transmittance = doubles(path, &mut reader, "transmittance", expected)?;
            let reflectance = doubles(path, &mut reader, "reflectance", expected)?;
            Ok(AnyTable::Full(Table { axes, transmittance, reflectance, metadata }))
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

fn read_axes(path: &Path, reader: &mut FileReader) -> Result<Axes, DatabaseError> {
    let mut axis = |name: &str| {
        let size = reader.data_set().dim_size(name);
        let size = size.ok_or_else(|| wrong(path, &format!("is not a table of snow: it has no dimension '{name}'")))?;
        doubles(path, reader, name, size)
    };
    let axes = Axes {
        grain_sizes_um: axis("grain_size")?,
        facetness: axis("facetness")?,
        densities_kg_m3: axis("density")?,
        angles_deg: axis("angle")?,
        thicknesses_cm: axis("thickness")?,
        wavelengths_nm: axis("wavelength")?,
    };
    axes.check().map_err(|error| wrong(path, &error.to_string()))?;
    Ok(axes)
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
        .filter(|name| name != "Conventions" && name != "space")
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
            writer.write_var_f64(name, values)?;
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
