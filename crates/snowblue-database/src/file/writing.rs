//! Tables into files.

use std::io;
use std::path::Path;

use netcdf3::error::WriteError;
use netcdf3::{DataSet, FileWriter, Version};

use super::whole::write_whole;
use super::{ARITHMETIC, COMPONENT, ERRORS, GRAIN, SAMPLE, SHARD, SHARD_DIMENSIONS, SINGULAR, wrong};
use crate::axes::DIFFUSE_ANGLE_DEG;
use crate::shard::Shard;
use crate::{Axes, CompressedTable, DatabaseError, Quantity, Table};

const CONVENTIONS: &str = "CF-1.8";

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
        let metadata = [
            &self.metadata[..],
            &[(SHARD.to_owned(), self.part.to_string()), (ARITHMETIC.to_owned(), self.arithmetic.clone())],
        ]
        .concat();
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
}

/// Writes axes, further dimensions, attributes and variables.
fn write(
    path: &Path,
    axes: &Axes,
    lengths: &[(&str, usize)],
    metadata: &[(String, String)],
    variables: &[(String, Vec<&str>, Values)],
) -> Result<(), DatabaseError> {
    let failed = |error: &dyn std::fmt::Display| wrong(path, &format!("cannot be written: {error}"));
    let data = describe(axes, lengths, metadata, variables).map_err(|error| failed(&format!("{error:?}")))?;
    let written = |beside: &Path| {
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
    };
    let written = |beside: &Path| written(beside).map_err(|error: WriteError| io::Error::other(reason(&error)));
    write_whole(path, written).map_err(|error| failed(&error))
}

/// Writes a file of bytes.
pub(crate) fn replace(path: &Path, bytes: &[u8]) -> Result<(), DatabaseError> {
    let failed = |error: io::Error| wrong(path, &format!("cannot be written: {error}"));
    write_whole(path, |beside| std::fs::write(beside, bytes)).map_err(failed)
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

fn reason(error: &WriteError) -> String {
    match error {
        WriteError::IOErrorKind(kind) => kind.to_string(),
        other => format!("{other:?}"),
    }
}
