//! Reads tables from NetCDF, whose header is checked before any data are read.
//!
//! The header (NetCDF Classic Format Specification, Unidata) lists dimensions, attributes and variables with their
//! lengths. A damaged length could request any amount of memory, so every length is compared with the bytes that exist.

use std::io::{Cursor, Read as _};
use std::path::Path;

use netcdf3::error::ReadError;
use netcdf3::{DataSet, FileReader};

use crate::axes::is_axis;
use crate::file::format::{
    self, ARITHMETIC, COMPONENT, CONVENTIONS, ERROR_SUFFIX, PACKED_SUFFIX, SHARD, SHARD_DIMENSIONS, SINGULAR_VALUE,
    SPACE, STEP,
};
use crate::pca::{Components, MAX_COMPONENTS};
use crate::shard::{Part, Shard};
use crate::table::{Attribute, CurveValues, StandardErrors};
use crate::{Axes, CompressedTable, DatabaseError, Quantity, Space, Table};

/// A table of any kind.
#[derive(Debug, Clone, PartialEq)]
pub enum AnyTable {
    /// Every value.
    Full(Table),
    /// A few coefficients per curve.
    Compressed(CompressedTable),
    /// Every value of some grains.
    Shard(Shard),
}

impl AnyTable {
    /// The kind of table, in words.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Full(_) => "a full table",
            Self::Compressed(_) => "a compressed table",
            Self::Shard(_) => "a shard of a table",
        }
    }

    /// Reads a table from the bytes of its file. `name` identifies them in messages.
    ///
    /// # Errors
    /// If the bytes are not a table of snow. Nothing is guessed or repaired.
    pub fn from_bytes(name: &str, bytes: &[u8]) -> Result<Self, DatabaseError> {
        let path = Path::new(name);
        read_table(path, open_bytes(path, bytes)?)
    }

    fn compressed(self, path: &Path) -> Result<CompressedTable, DatabaseError> {
        match self {
            Self::Compressed(table) => Ok(table),
            Self::Full(_) => Err(DatabaseError::file(
                path,
                format!(
                    "is a full table, not a compressed one, which is written by: \
                     snowblue merge {} --space log --components 3 -o FILE.nc",
                    path.display()
                ),
            )),
            Self::Shard(_) => Err(DatabaseError::file(path, format!("is {}, not a compressed one", self.kind()))),
        }
    }
}

impl CompressedTable {
    /// Reads a compressed table from a file.
    ///
    /// # Errors
    /// If the file cannot be read or is not a compressed table of snow.
    pub fn open(path: &Path) -> Result<Self, DatabaseError> {
        read(path)?.compressed(path)
    }

    /// Reads a compressed table from the bytes of its file. `name` identifies them in messages.
    ///
    /// # Errors
    /// If the bytes are not a compressed table of snow.
    pub fn from_bytes(name: &str, bytes: &[u8]) -> Result<Self, DatabaseError> {
        AnyTable::from_bytes(name, bytes)?.compressed(Path::new(name))
    }
}

/// Reads a table of any kind from a file.
///
/// # Errors
/// If the file cannot be read or is not a table of snow. Nothing is guessed or repaired.
pub fn read(path: &Path) -> Result<AnyTable, DatabaseError> {
    read_table(path, open(path)?)
}

/// Opens a NetCDF file. The errors of a missing, a damaged and a NetCDF-4 file differ.
fn open(path: &Path) -> Result<FileReader, DatabaseError> {
    let unreadable = |error: std::io::Error| DatabaseError::file(path, format!("cannot be read: {error}"));
    let (mut file, mut start) = (std::fs::File::open(path).map_err(unreadable)?, Vec::new());
    let length = file.metadata().map_err(unreadable)?.len();
    file.by_ref().take(MAX_HEADER_BYTES).read_to_end(&mut start).map_err(unreadable)?;
    check_header(path, &start, length)?;
    FileReader::open(path).map_err(|error| invalid_netcdf(path, &error))
}

/// Opens the bytes of a NetCDF file.
fn open_bytes(name: &Path, bytes: &[u8]) -> Result<FileReader, DatabaseError> {
    check_header(name, bytes, bytes.len() as u64)?;
    let bytes = Box::new(Cursor::new(bytes.to_vec()));
    FileReader::open_seek_read(&name.to_string_lossy(), bytes).map_err(|error| invalid_netcdf(name, &error))
}

fn check_header(path: &Path, start: &[u8], length: u64) -> Result<(), DatabaseError> {
    if start.starts_with(b"\x89HDF") {
        let remedy = "to_netcdf(path, format=\"NETCDF3_64BIT\") of xarray";
        let what = format!("is NetCDF-4 (HDF5), but only the classic format is supported: {remedy} writes it");
        return Err(DatabaseError::file(path, what));
    }
    check_start(start, length).map_err(|why| invalid(path, why))
}

fn read_table(path: &Path, mut reader: FileReader) -> Result<AnyTable, DatabaseError> {
    let axes = read_axes(path, &mut reader)?;
    let metadata = metadata(reader.data_set());
    if let Some(part) = reader.data_set().get_global_attr_as_string(SHARD) {
        let part: Part =
            part.parse().map_err(|_| DatabaseError::file(path, format!("has the invalid shard number '{part}'")))?;
        part.check(&axes).map_err(|error| DatabaseError::file(path, error.to_string()))?;
        let per_grain = axes.curves() / axes.grains() * axes.wavelengths_nm.len();
        let values = read_values(path, &mut reader, part.grains(&axes).len() * per_grain)?;
        let arithmetic = reader.data_set().get_global_attr_as_string(ARITHMETIC).unwrap_or_default();
        return Ok(AnyTable::Shard(Shard { axes, part, values, metadata, arithmetic }));
    }
    match reader.data_set().get_global_attr_as_string(SPACE).as_deref() {
        None => {
            let expected = axes.curves() * axes.wavelengths_nm.len();
            Ok(AnyTable::Full(Table::new(axes, read_values(path, &mut reader, expected)?, metadata)))
        }
        Some(space) => {
            let space =
                [Space::Linear, Space::Log].into_iter().find(|known| known.name() == space).ok_or_else(|| {
                    DatabaseError::file(path, format!("has the space '{space}', but must have linear or log"))
                })?;
            let transmittance = read_components(path, &mut reader, &axes, Quantity::Transmittance)?;
            let reflectance = read_components(path, &mut reader, &axes, Quantity::Reflectance)?;
            Ok(AnyTable::Compressed(CompressedTable { axes, space, transmittance, reflectance, metadata }))
        }
    }
}

/// Reads transmittance, reflectance and, if there are any, standard errors.
fn read_values(path: &Path, reader: &mut FileReader, expected: usize) -> Result<CurveValues, DatabaseError> {
    let name = |quantity: Quantity, suffix: &str| format!("{}{suffix}", quantity.name());
    let has_errors = reader.data_set().has_var(&name(Quantity::Transmittance, ERROR_SUFFIX));
    let mut values = |quantity, suffix| read_f64(path, reader, &name(quantity, suffix), expected);
    let (transmittance, reflectance) = (values(Quantity::Transmittance, "")?, values(Quantity::Reflectance, "")?);
    let errors = if has_errors {
        Some(StandardErrors {
            transmittance: values(Quantity::Transmittance, ERROR_SUFFIX)?,
            reflectance: values(Quantity::Reflectance, ERROR_SUFFIX)?,
        })
    } else {
        None
    };
    Ok(CurveValues { transmittance, reflectance, errors })
}

fn read_axes(path: &Path, reader: &mut FileReader) -> Result<Axes, DatabaseError> {
    // Coordinates are stored in the order of the axes.
    let names = reader.data_set().get_var_names();
    let mut values = Vec::new();
    for name in names.iter().filter(|name| is_axis(name)) {
        if let Some(size) = reader.data_set().dim_size(name) {
            values.push((name.as_str(), read_f64(path, reader, name, size)?));
        }
    }
    let axes = Axes::from_named(values)
        .map_err(|name| DatabaseError::file(path, format!("is not a table of snow: it has no dimension '{name}'")))?;
    axes.check_order().map_err(|error| DatabaseError::file(path, error.to_string()))?;
    let named = axes.named();
    let is_shard = reader.data_set().has_global_attr(SHARD);
    let expected: Vec<&str> = named.iter().map(|axis| axis.name).collect();
    let expected = if is_shard { &SHARD_DIMENSIONS[..] } else { &expected[..] };
    for quantity in Quantity::ALL {
        for suffix in ["", ERROR_SUFFIX, "_coefficients"] {
            let Some(variable) = reader.data_set().get_var(&format!("{}{suffix}", quantity.name())) else { continue };
            let mut expected = expected.to_vec();
            if suffix == "_coefficients" {
                expected.pop();
                expected.push(COMPONENT);
            }
            if variable.dim_names() != expected {
                let what = format!("has not the dimensions {} in this order", expected.join(", "));
                return Err(DatabaseError::file(path, what));
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
        return Err(DatabaseError::file(path, format!("has {count} components, but must have 1–{MAX_COMPONENTS}")));
    }
    let name = |part: &str| format!("{}_{part}", quantity.name());
    let singular_values = reader.data_set().dim_size(SINGULAR_VALUE).unwrap_or(0);
    let packed = format!("{}{PACKED_SUFFIX}", quantity.name());
    let coefficients = if reader.data_set().has_var(&packed) {
        read_packed(path, reader, &packed, axes, count)?
    } else {
        read_f32(path, reader, &name("coefficients"), axes.curves() * count)?
    };
    Ok(Components {
        count,
        coefficients,
        basis: read_f32(path, reader, &name("basis"), axes.wavelengths_nm.len() * count)?,
        singular_values: read_f64(path, reader, &name("singular_values"), singular_values)?,
    })
}

fn read_f64(path: &Path, reader: &mut FileReader, name: &str, expected: usize) -> Result<Vec<f64>, DatabaseError> {
    check_length(path, reader, name, expected)?;
    let values = reader.read_var_f64(name).map_err(|error| invalid_netcdf(path, &error))?;
    check_finite(path, name, values.iter().position(|value| !value.is_finite()))?;
    Ok(values)
}

fn read_f32(path: &Path, reader: &mut FileReader, name: &str, expected: usize) -> Result<Vec<f32>, DatabaseError> {
    check_length(path, reader, name, expected)?;
    let values = reader.read_var_f32(name).map_err(|error| invalid_netcdf(path, &error))?;
    check_finite(path, name, values.iter().position(|value| !value.is_finite()))?;
    Ok(values)
}

fn read_packed(
    path: &Path,
    reader: &mut FileReader,
    name: &str,
    axes: &Axes,
    count: usize,
) -> Result<Vec<f32>, DatabaseError> {
    let step = match reader.data_set().get_var_attr_f32(name, STEP) {
        Some(&[step]) if step > 0.0 => step,
        _ => return Err(DatabaseError::file(path, format!("'{name}' has no {STEP} above 0"))),
    };
    let bytes: Vec<u8> = match reader.read_var_i8(name) {
        Ok(bytes) => bytes.into_iter().map(i8::cast_unsigned).collect(),
        Err(error) => return Err(invalid_netcdf(path, &error)),
    };
    let integers = format::unpack(&bytes, &format::lengths(axes), count)
        .map_err(|why| DatabaseError::file(path, format!("the bytes of '{name}' are invalid: {why}")))?;
    let coefficients: Vec<f32> = integers.into_iter().map(|integer| step * integer as f32).collect();
    check_finite(path, name, coefficients.iter().position(|value| !value.is_finite()))?;
    Ok(coefficients)
}

/// Checks that a variable exists and has the length that follows from the axes, before memory of that size is
/// allocated.
fn check_length(path: &Path, reader: &FileReader, name: &str, expected: usize) -> Result<(), DatabaseError> {
    let what = match reader.data_set().var_len(name) {
        None => format!("is not a table of snow: it has no variable '{name}'"),
        Some(length) if length != expected => {
            format!("has {length} values of '{name}', but its axes have {expected}")
        }
        Some(_) => return Ok(()),
    };
    Err(DatabaseError::file(path, what))
}

fn check_finite(path: &Path, name: &str, first_invalid: Option<usize>) -> Result<(), DatabaseError> {
    match first_invalid {
        None => Ok(()),
        Some(index) => Err(DatabaseError::file(path, format!("value {index} of '{name}' is not a finite number"))),
    }
}

/// Global attributes except the attributes of the file format.
fn metadata(data: &DataSet) -> Vec<Attribute> {
    data.get_global_attr_names()
        .into_iter()
        .filter(|name| ![CONVENTIONS, SPACE, SHARD, ARITHMETIC].contains(&name.as_str()))
        .filter_map(|name| data.get_global_attr_as_string(&name).map(|value| Attribute { name, value }))
        .collect()
}

/// The error of a file that NetCDF cannot read.
fn invalid_netcdf(path: &Path, error: &ReadError) -> DatabaseError {
    // The Debug form of a header error holds the bytes of the file.
    let reason = match error {
        ReadError::IOErrorKind(kind) => kind.to_string(),
        ReadError::ParseHeader(_) => "its header is invalid".to_owned(),
        other => format!("{other:?}").chars().take(100).collect(),
    };
    invalid(path, &reason)
}

fn invalid(path: &Path, why: &str) -> DatabaseError {
    DatabaseError::file(path, format!("is not a complete NetCDF classic file: {why}"))
}

/// Most bytes of a header: enough for the axes, attributes and variables of any table.
const MAX_HEADER_BYTES: u64 = 1 << 24;

const DIMENSION: u32 = 0x0a;
const VARIABLE: u32 = 0x0b;
const ATTRIBUTE: u32 = 0x0c;

/// The unread part of a header.
struct Unread<'b>(&'b [u8]);

/// Checks the header at the start of a file of `length` bytes.
///
/// # Errors
/// A short description of the invalid part.
fn check_start(start: &[u8], length: u64) -> Result<(), &'static str> {
    let mut rest = Unread(start);
    let has_wide_offsets = match rest.take(4)? {
        b"CDF\x01" => false,
        b"CDF\x02" => true,
        _ => return Err("it does not start as one"),
    };
    rest.number()?;
    let mut dimensions = Vec::new();
    for _ in 0..rest.list(DIMENSION)? {
        rest.name()?;
        match rest.number()? {
            0 => return Err("it has an unlimited or empty dimension, which a table does not have"),
            size => dimensions.push(u64::from(size)),
        }
    }
    rest.attributes()?;
    for _ in 0..rest.list(VARIABLE)? {
        rest.name()?;
        let mut values = 1_u64;
        for _ in 0..rest.number()? {
            let size = usize::try_from(rest.number()?).ok().and_then(|dimension| dimensions.get(dimension));
            let size = size.ok_or("a variable has an unknown dimension")?;
            values = values.checked_mul(*size).ok_or("a variable is too large")?;
        }
        rest.attributes()?;
        let bytes = values.checked_mul(rest.size_of_type()?).ok_or("a variable is too large")?;
        rest.number()?;
        let high = if has_wide_offsets { u64::from(rest.number()?) << 32 } else { 0 };
        let begin = high | u64::from(rest.number()?);
        if begin.checked_add(bytes).is_none_or(|end| end > length) {
            return Err("it ends before its last value");
        }
    }
    Ok(())
}

impl<'b> Unread<'b> {
    fn take(&mut self, count: usize) -> Result<&'b [u8], &'static str> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or("its header is truncated")?;
        self.0 = rest;
        Ok(taken)
    }

    fn number(&mut self) -> Result<u32, &'static str> {
        let bytes = self.take(4)?;
        Ok(bytes.iter().fold(0, |number, byte| number << 8 | u32::from(*byte)))
    }

    /// The length of a list of the given kind.
    fn list(&mut self, kind: u32) -> Result<u32, &'static str> {
        match (self.number()?, self.number()?) {
            (0, 0) => Ok(0),
            (found, count) if found == kind => Ok(count),
            _ => Err("its header is invalid"),
        }
    }

    /// Skips bytes, which are padded to a multiple of four.
    fn skip(&mut self, bytes: u64) -> Result<(), &'static str> {
        let padded = usize::try_from(bytes).ok().and_then(|bytes| bytes.checked_next_multiple_of(4));
        self.take(padded.ok_or("its header is invalid")?).map(|_| ())
    }

    fn name(&mut self) -> Result<(), &'static str> {
        let length = self.number()?;
        self.skip(u64::from(length))
    }

    fn attributes(&mut self) -> Result<(), &'static str> {
        for _ in 0..self.list(ATTRIBUTE)? {
            self.name()?;
            let size = self.size_of_type()?;
            let count = self.number()?;
            self.skip(size * u64::from(count))?;
        }
        Ok(())
    }

    /// Bytes of a value of the type that follows.
    fn size_of_type(&mut self) -> Result<u64, &'static str> {
        match self.number()? {
            1 | 2 => Ok(1),
            3 => Ok(2),
            4 | 5 => Ok(4),
            6 => Ok(8),
            _ => Err("its header is invalid"),
        }
    }
}
