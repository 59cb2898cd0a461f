//! Writes tables as NetCDF.

use std::fs::File;
use std::io::{self, Write as _};
use std::path::Path;

use netcdf3::error::WriteError;
use netcdf3::{DataSet, FileWriter, Version};
use snowblue_base::atomic_file::write_atomically;

use super::format::{
    self, ARITHMETIC, COMPONENT, CONVENTIONS, ERROR_SUFFIX, GRAIN, PACKED_DIMENSIONS, PACKED_SUFFIX, SAMPLE, SHARD,
    SHARD_DIMENSIONS, SINGULAR_VALUE, SPACE, STEP,
};
use crate::axes::{DIFFUSE_ANGLE_DEG, NamedAxis};
use crate::shard::Shard;
use crate::table::{Attribute, StandardErrors};
use crate::{Axes, CompressedTable, DatabaseError, Quantity, Table};

/// The content of a file.
struct Content<'a> {
    axes: &'a Axes,
    /// Dimensions that are not axes.
    dimensions: Vec<Dimension>,
    attributes: Vec<Attribute>,
    variables: Vec<Variable<'a>>,
}

struct Dimension {
    name: &'static str,
    length: usize,
}

struct Variable<'a> {
    name: String,
    dimensions: Vec<&'static str>,
    values: Values<'a>,
}

enum Values<'a> {
    Double(&'a [f64]),
    Single(&'a [f32]),
    Packed { bytes: Vec<i8>, step: f32 },
}

impl Table {
    /// Writes the table to `path`.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), DatabaseError> {
        let dimensions: Vec<&'static str> = self.axes.named().iter().map(|axis| axis.name).collect();
        let content = Content {
            axes: &self.axes,
            dimensions: Vec::new(),
            attributes: self.metadata.clone(),
            variables: curve_variables(&dimensions, |quantity| self.values(quantity), self.errors.as_ref()),
        };
        content.write(path)
    }
}

impl Shard {
    /// Writes the shard to `path`.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), DatabaseError> {
        let shard = [Attribute::new(SHARD, self.part.to_string()), Attribute::new(ARITHMETIC, &self.arithmetic)];
        let content = Content {
            axes: &self.axes,
            dimensions: vec![
                Dimension { name: GRAIN, length: self.part.grains(&self.axes).len() },
                Dimension { name: SAMPLE, length: self.axes.samples_per_grain() },
            ],
            attributes: [&self.metadata[..], &shard].concat(),
            variables: curve_variables(
                &SHARD_DIMENSIONS,
                |quantity| self.values.of(quantity),
                self.values.errors.as_ref(),
            ),
        };
        content.write(path)
    }
}

impl CompressedTable {
    /// Writes the table to `path`.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), DatabaseError> {
        let mut dimensions: Vec<&'static str> = self.axes.named().iter().map(|axis| axis.name).collect();
        dimensions.pop();
        dimensions.push(COMPONENT);
        let coefficients = |quantity: Quantity| Variable {
            name: format!("{}_coefficients", quantity.name()),
            dimensions: dimensions.clone(),
            values: Values::Single(&self.components(quantity).coefficients),
        };
        self.content(Vec::new(), Quantity::ALL.map(coefficients)).write(path)
    }

    /// Writes the table to `path` with its coefficients as [`rounded`](Self::rounded) by `step`, and packed: of the
    /// embedded table, they take about a tenth of the bytes. It is read as any other table, but by this crate alone.
    ///
    /// # Errors
    /// If the file cannot be written, or a coefficient has more than 2²⁴ steps.
    ///
    /// # Panics
    /// As [`rounded`](Self::rounded).
    pub fn write_packed(&self, path: &Path, step: f32) -> Result<(), DatabaseError> {
        let rounded = self.clone().rounded(step);
        let (mut dimensions, mut variables) = (Vec::new(), Vec::new());
        for (quantity, dimension) in Quantity::ALL.into_iter().zip(PACKED_DIMENSIONS) {
            let components = rounded.components(quantity);
            let integers = components.coefficients.iter().map(|coefficient| steps(*coefficient, step));
            let integers = integers.collect::<Result<_, _>>().map_err(|coefficient| {
                let what = format!("the coefficient {coefficient} of {} has more than 2²⁴ steps", quantity.name());
                DatabaseError::file(path, format!("cannot be written: {what}"))
            })?;
            let bytes = format::pack(integers, &format::lengths(&self.axes), components.count);
            let bytes: Vec<i8> = bytes.into_iter().map(u8::cast_signed).collect();
            dimensions.push(Dimension { name: dimension, length: bytes.len() });
            variables.push(Variable {
                name: format!("{}{PACKED_SUFFIX}", quantity.name()),
                dimensions: vec![dimension],
                values: Values::Packed { bytes, step },
            });
        }
        self.content(dimensions, variables).write(path)
    }

    /// The content of a file with these coefficients, on axes and further dimensions.
    fn content<'t>(
        &'t self,
        mut dimensions: Vec<Dimension>,
        coefficients: impl IntoIterator<Item = Variable<'t>>,
    ) -> Content<'t> {
        dimensions.push(Dimension { name: COMPONENT, length: self.transmittance.count });
        dimensions.push(Dimension { name: SINGULAR_VALUE, length: self.transmittance.singular_values.len() });
        let mut variables = Vec::new();
        for (quantity, coefficients) in Quantity::ALL.into_iter().zip(coefficients) {
            let components = self.components(quantity);
            variables.push(coefficients);
            let mut add = |part: &str, dimensions, values| {
                variables.push(Variable { name: format!("{}_{part}", quantity.name()), dimensions, values });
            };
            add("basis", vec!["wavelength", COMPONENT], Values::Single(&components.basis));
            add("singular_values", vec![SINGULAR_VALUE], Values::Double(&components.singular_values));
        }
        Content {
            axes: &self.axes,
            dimensions,
            attributes: [&self.metadata[..], &[Attribute::new(SPACE, self.space.name())]].concat(),
            variables,
        }
    }
}

/// A coefficient in steps, of which it is a multiple; itself, if there are too many.
fn steps(coefficient: f32, step: f32) -> Result<i32, f32> {
    let steps = coefficient / step;
    #[expect(clippy::cast_possible_truncation, reason = "a whole number within the range")]
    if steps.abs() <= format::GREATEST as f32 { Ok(steps as i32) } else { Err(coefficient) }
}

/// Transmittance, reflectance and their standard errors, if they are known, as variables.
fn curve_variables<'v>(
    dimensions: &[&'static str],
    values: impl Fn(Quantity) -> &'v [f64],
    errors: Option<&'v StandardErrors>,
) -> Vec<Variable<'v>> {
    let variable = |name, values| Variable { name, dimensions: dimensions.to_vec(), values: Values::Double(values) };
    let mut variables = Vec::new();
    for quantity in Quantity::ALL {
        variables.push(variable(quantity.name().to_owned(), values(quantity)));
    }
    if let Some(errors) = errors {
        for quantity in Quantity::ALL {
            variables.push(variable(format!("{}{ERROR_SUFFIX}", quantity.name()), errors.of(quantity)));
        }
    }
    variables
}

impl Content<'_> {
    fn write(&self, path: &Path) -> Result<(), DatabaseError> {
        let failed = |error: &dyn std::fmt::Display| DatabaseError::file(path, format!("cannot be written: {error}"));
        let data = self.describe().map_err(|error| failed(&format!("{error:?}")))?;
        let write = |file: &mut File| {
            let output = Box::new(file.try_clone()?);
            self.write_values(&data, output).map_err(|error| io::Error::other(reason(&error)))
        };
        write_atomically(path, write).map_err(|error| failed(&error))
    }

    fn describe(&self) -> Result<DataSet, netcdf3::error::InvalidDataSet> {
        let mut data = DataSet::new();
        data.add_global_attr_string(CONVENTIONS, "CF-1.8")?;
        for Attribute { name, value } in &self.attributes {
            data.add_global_attr_string(name, value)?;
        }
        for NamedAxis { name, unit, values } in self.axes.named() {
            data.add_fixed_dim(name, values.len())?;
            data.add_var_f64(name, &[name])?;
            data.add_var_attr_string(name, "units", unit)?;
            data.add_var_attr_string(name, "long_name", name.replace('_', " "))?;
            if name == "angle" && self.axes.diffuse {
                data.add_var_attr_f64(name, "flag_values", vec![DIFFUSE_ANGLE_DEG])?;
                data.add_var_attr_string(name, "flag_meanings", "diffuse")?;
            }
        }
        for Dimension { name, length } in &self.dimensions {
            data.add_fixed_dim(*name, *length)?;
        }
        for Variable { name, dimensions, values } in &self.variables {
            match values {
                Values::Double(_) => data.add_var_f64(name, dimensions)?,
                Values::Single(_) => data.add_var_f32(name, dimensions)?,
                Values::Packed { step, .. } => {
                    data.add_var_i8(name, dimensions)?;
                    data.add_var_attr_f32(name, STEP, vec![*step])?;
                }
            }
            data.add_var_attr_string(name, "units", "1")?;
            data.add_var_attr_string(name, "long_name", name.replace('_', " "))?;
        }
        Ok(data)
    }

    fn write_values(&self, data: &DataSet, output: Box<File>) -> Result<(), WriteError> {
        let mut writer = FileWriter::open_seek_write("", output)?;
        writer.set_def(data, Version::Offset64Bit, 0)?;
        for NamedAxis { name, values, .. } in self.axes.named() {
            writer.write_var_f64(name, &values)?;
        }
        for Variable { name, values, .. } in &self.variables {
            match values {
                Values::Double(values) => writer.write_var_f64(name, values)?,
                Values::Single(values) => writer.write_var_f32(name, values)?,
                Values::Packed { bytes, .. } => writer.write_var_i8(name, bytes)?,
            }
        }
        writer.close()
    }
}

/// Writes bytes to a file.
pub(crate) fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), DatabaseError> {
    let failed = |error: io::Error| DatabaseError::file(path, format!("cannot be written: {error}"));
    write_atomically(path, |file| file.write_all(bytes)).map_err(failed)
}

fn reason(error: &WriteError) -> String {
    match error {
        WriteError::IOErrorKind(kind) => kind.to_string(),
        other => format!("{other:?}"),
    }
}
