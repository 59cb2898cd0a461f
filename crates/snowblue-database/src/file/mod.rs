//! Tables as files: NetCDF classic with 64-bit offsets, dimensions and coordinates by name, CF attributes.
//!
//! A full table holds `transmittance` and `reflectance` on all axes. A compressed one holds, for each of the two, the
//! `coefficients` on all axes but the wavelength, the `basis` and the `singular_values`, and the attribute `space`. A shard
//! holds values on `grain`, `sample` (of a grain), `angle`, `thickness` and `wavelength`, and the attribute `shard`.
//! A file is written beside its place and then renamed, so that none is ever half-written.

mod header;
mod whole;
mod writing;

use std::io::{Cursor, Read as _};
use std::path::Path;

use netcdf3::error::ReadError;
use netcdf3::{DataSet, FileReader};

use crate::axes::is_axis;
use crate::fill;
use crate::pca::{Components, MAX_COMPONENTS};
use crate::shard::{Part, Shard};
use crate::{Axes, CompressedTable, DatabaseError, Quantity, Space, Table};

pub use whole::{unfinished_path, write_whole};
pub(crate) use writing::replace;

const COMPONENT: &str = "component";
const SINGULAR: &str = "singular_value";
const SHARD: &str = "shard";
const ARITHMETIC: &str = "arithmetic";
const GRAIN: &str = "grain";
const SAMPLE: &str = "sample";
const SHARD_DIMENSIONS: [&str; 5] = [GRAIN, SAMPLE, "angle", "thickness", "wavelength"];
/// What the names of standard errors end in.
const ERRORS: &str = "_standard_error";

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

impl CompressedTable {
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
    read_tables(path, open(path)?)
}

/// Opens a NetCDF file; a missing file, a broken one and one of another format are told apart.
pub(crate) fn open(path: &Path) -> Result<FileReader, DatabaseError> {
    let unread = |error: std::io::Error| wrong(path, &format!("cannot be read: {error}"));
    let (mut file, mut start) = (std::fs::File::open(path).map_err(unread)?, Vec::new());
    let length = file.metadata().map_err(unread)?.len();
    file.by_ref().take(header::MOST_BYTES).read_to_end(&mut start).map_err(unread)?;
    if start.starts_with(b"\x89HDF") {
        let how = "to_netcdf(path, format=\"NETCDF3_64BIT\") of xarray";
        return Err(wrong(path, &format!("is NetCDF-4 (HDF5), but only the classic format is read: {how} writes it")));
    }
    header::check(&start, length).map_err(|why| not_whole(path, why))?;
    FileReader::open(path).map_err(|error| broken(path, &error))
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
        let arithmetic = reader.data_set().get_global_attr_as_string(ARITHMETIC).unwrap_or_default();
        return Ok(AnyTable::Shard(Shard { axes, part, values, metadata, arithmetic }));
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
    // Coordinates stand in the order of the axes.
    let names = reader.data_set().get_var_names();
    let mut values = Vec::new();
    for name in names.iter().filter(|name| is_axis(name)) {
        if let Some(size) = reader.data_set().dim_size(name) {
            values.push((name.as_str(), doubles(path, reader, name, size)?));
        }
    }
    let axes = Axes::from_named(values)
        .map_err(|name| wrong(path, &format!("is not a table of snow: it has no dimension '{name}'")))?;
    axes.check_order().map_err(|error| wrong(path, &error.to_string()))?;
    let named = axes.named();
    let is_shard = reader.data_set().has_global_attr(SHARD);
    let expected: Vec<&str> = named.iter().map(|(name, ..)| *name).collect();
    let expected = if is_shard { &SHARD_DIMENSIONS[..] } else { &expected[..] };
    for quantity in Quantity::ALL {
        for ending in ["", ERRORS, "_coefficients"] {
            let Some(variable) = reader.data_set().get_var(&format!("{}{ending}", quantity.name())) else { continue };
            let mut expected = expected.to_vec();
            if ending == "_coefficients" {
                expected.pop();
                expected.push(COMPONENT);
            }
            if variable.dim_names() != expected {
                return Err(wrong(path, "has its dimensions in another order; use 'database import'"));
            }
        }
    }
    Ok(axes)
}

fn read_components(
    path: &Path,
    reader: &mut FileReader,
    axes: &Axes,
    quantity: Quantity,
) -> Result<Components, DatabaseError> {
    let count = reader.data_set().dim_size(COMPONENT).unwrap_or(0);
    if count == 0 || count > MAX_COMPONENTS {
        return Err(wrong(path, &format!("has {count} components, but must have 1–{MAX_COMPONENTS}")));
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
        .filter(|name| name != "Conventions" && name != "space" && name != SHARD && name != ARITHMETIC)
        .filter_map(|name| data.get_global_attr_as_string(&name).map(|value| (name, value)))
        .collect()
}

fn wrong(path: &Path, what: &str) -> DatabaseError {
    DatabaseError::File { path: path.to_owned(), what: what.to_owned() }
}

pub(crate) fn broken(path: &Path, error: &ReadError) -> DatabaseError {
    // The debugging form of a header's error holds the file's bytes: nothing for a person.
    let reason = match error {
        ReadError::IOErrorKind(kind) => kind.to_string(),
        ReadError::ParseHeader(_) => "its header makes no sense".to_owned(),
        other => format!("{other:?}").chars().take(100).collect(),
    };
    not_whole(path, &reason)
}

fn not_whole(path: &Path, why: &str) -> DatabaseError {
    wrong(path, &format!("is not a whole NetCDF classic file: {why}"))
}
