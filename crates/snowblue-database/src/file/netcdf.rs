//! Files of NetCDF classic with 64-bit offsets and CF attributes, written whole or not at all.

use std::borrow::Cow;
use std::fs::File;
use std::io;
use std::path::Path;

use netcdf3::error::{InvalidDataSet, WriteError};
use netcdf3::{DataSet, FileWriter, Version};
use snowblue_base::atomic_file::write_atomically;

use super::format::CONVENTIONS;
use crate::DatabaseError;
use crate::axes::is_diffuse;
use crate::table::Attribute;

/// The content of a file.
#[derive(Debug, Clone, Default)]
pub struct NetCdf<'a> {
    /// Global attributes beside the conventions.
    pub attributes: Vec<Attribute>,
    /// Dimensions with their lengths.
    pub dimensions: Vec<(String, usize)>,
    /// Variables. A variable with the name of a dimension holds the coordinates of that dimension.
    pub variables: Vec<Variable<'a>>,
}

/// A variable of a file.
#[derive(Debug, Clone)]
pub struct Variable<'a> {
    /// Name.
    pub name: String,
    /// Unit by UDUNITS.
    pub unit: &'static str,
    /// Names of its dimensions, the last running fastest.
    pub dimensions: Vec<String>,
    /// Values.
    pub values: Values<'a>,
    /// Names of further variables that are its coordinates, beside the coordinates of its dimensions; empty if there
    /// are none.
    pub coordinates: String,
}

/// Values of a variable.
#[derive(Debug, Clone)]
pub enum Values<'a> {
    /// Numbers of 64 bits.
    Double(Cow<'a, [f64]>),
    /// Numbers of 32 bits.
    Single(&'a [f32]),
    /// UTF-8 letters of words of equal length, filled with zeros.
    Letters(Vec<u8>),
    /// Packed numbers with the step that they are multiples of.
    Packed {
        /// Their bytes.
        bytes: Vec<i8>,
        /// Name and value of the attribute of the step.
        step: (&'static str, f32),
    },
}

impl<'a> Variable<'a> {
    /// A variable without further coordinates.
    pub fn new(name: impl Into<String>, unit: &'static str, dimensions: Vec<String>, values: Values<'a>) -> Self {
        Self { name: name.into(), unit, dimensions, values, coordinates: String::new() }
    }

    /// The coordinates of a dimension.
    pub fn coordinates(name: &str, unit: &'static str, values: Vec<f64>) -> Self {
        Self::new(name, unit, vec![name.to_owned()], Values::Double(values.into()))
    }
}

impl NetCdf<'_> {
    /// Writes the file.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), DatabaseError> {
        let failed = |error: &dyn std::fmt::Display| DatabaseError::file(path, format!("cannot be written: {error}"));
        let described = self.describe().map_err(|error| failed(&format!("{error:?}")))?;
        let write = |file: &mut File| {
            let output = Box::new(file.try_clone()?);
            self.write_values(&described, output).map_err(|error| match error {
                WriteError::IOErrorKind(kind) => io::Error::from(kind),
                other => io::Error::other(format!("{other:?}")),
            })
        };
        write_atomically(path, write).map_err(|error| failed(&error))
    }

    fn describe(&self) -> Result<DataSet, InvalidDataSet> {
        let mut data = DataSet::new();
        data.add_global_attr_string(CONVENTIONS, "CF-1.8")?;
        for Attribute { name, value } in &self.attributes {
            data.add_global_attr_string(name, value)?;
        }
        for (name, length) in &self.dimensions {
            data.add_fixed_dim(name, *length)?;
        }
        for Variable { name, unit, dimensions, values, coordinates } in &self.variables {
            match values {
                Values::Double(_) => data.add_var_f64(name, dimensions)?,
                Values::Single(_) => data.add_var_f32(name, dimensions)?,
                Values::Letters(_) => {
                    data.add_var_u8(name, dimensions)?;
                    data.add_var_attr_string(name, "_Encoding", "utf-8")?;
                    continue;
                }
                Values::Packed { step: (attribute, step), .. } => {
                    data.add_var_i8(name, dimensions)?;
                    data.add_var_attr_f32(name, attribute, vec![*step])?;
                }
            }
            data.add_var_attr_string(name, "units", unit)?;
            data.add_var_attr_string(name, "long_name", name.replace('_', " "))?;
            if !coordinates.is_empty() {
                data.add_var_attr_string(name, "coordinates", coordinates)?;
            }
            let Values::Double(numbers) = values else { continue };
            if let Some(diffuse) = numbers.iter().find(|angle| name == "angle" && is_diffuse(**angle)) {
                data.add_var_attr_f64(name, "flag_values", vec![*diffuse])?;
                data.add_var_attr_string(name, "flag_meanings", "diffuse")?;
            }
        }
        Ok(data)
    }

    fn write_values(&self, described: &DataSet, output: Box<File>) -> Result<(), WriteError> {
        let mut writer = FileWriter::open_seek_write("", output)?;
        writer.set_def(described, Version::Offset64Bit, 0)?;
        for Variable { name, values, .. } in &self.variables {
            match values {
                Values::Double(numbers) => writer.write_var_f64(name, numbers)?,
                Values::Single(numbers) => writer.write_var_f32(name, numbers)?,
                Values::Letters(letters) => writer.write_var_u8(name, letters)?,
                Values::Packed { bytes, .. } => writer.write_var_i8(name, bytes)?,
            }
        }
        writer.close()
    }
}
