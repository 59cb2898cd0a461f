//! Curves from NetCDF: `transmittance` and `reflectance` on named dimensions, in any order, each with its coordinate.
//!
//! Only the classic format is supported (also with 64-bit offsets), as `to_netcdf(path, format="NETCDF3_64BIT")` of
//! xarray writes it. Unknown dimensions are errors; axes without a dimension are given as fixed values.

use std::collections::BTreeMap;
use std::path::Path;

use netcdf3::{DataVector, FileReader};

use super::columns::{FixedValues, axes, axis_of, check_fraction, metadata};
use crate::file::{invalid_netcdf, open, open_bytes};
use crate::{DatabaseError, Quantity, Table};

/// Imports a table. `fixed` gives the values of what has no dimension.
///
/// # Errors
/// If the file cannot be read, a dimension is unknown, or a coordinate does not ascend.
pub fn import_netcdf(path: &Path, fixed: &FixedValues) -> Result<Table, DatabaseError> {
    import(path, open(path)?, fixed)
}

/// Imports a table from the bytes of a file. `name` identifies them in messages.
///
/// # Errors
/// As [`import_netcdf`].
pub fn import_netcdf_bytes(name: &str, bytes: &[u8], fixed: &FixedValues) -> Result<Table, DatabaseError> {
    let name = Path::new(name);
    import(name, open_bytes(name, bytes)?, fixed)
}

fn import(path: &Path, mut reader: FileReader, fixed: &FixedValues) -> Result<Table, DatabaseError> {
    let mut values: BTreeMap<&'static str, Vec<f64>> = BTreeMap::new();
    for name in dimensions(path, &reader)? {
        let axis = axis_of(&name)
            .ok_or_else(|| DatabaseError::file(path, format!("dimension '{name}' is not an axis of a table")))?;
        check_unit(path, &reader, &name, axis)?;
        let axis_values = read(path, &mut reader, &name)?;
        if values.insert(axis, axis_values).is_some() {
            return Err(DatabaseError::file(path, format!("has two dimensions for the axis '{axis}'")));
        }
    }
    let mut constants = BTreeMap::new();
    for (name, value) in fixed {
        match axis_of(name) {
            Some(axis) if values.contains_key(axis) => {
                return Err(DatabaseError::file(path, format!("has '{name}' itself, so it cannot be set")));
            }
            Some(axis) => drop(values.insert(axis, vec![*value])),
            None => drop(constants.insert(name.as_str(), check_fraction(path, "", name, *value)?)),
        }
    }
    let axes = axes(path, values)?;
    let named = axes.named();
    let order: Vec<Dimension> =
        named.iter().map(|axis| Dimension { name: axis.name, length: axis.values.len() }).collect();
    let mut filled = Vec::new();
    for quantity in Quantity::ALL {
        filled.push(match constants.remove(quantity.name()) {
            Some(value) => vec![value; axes.curves() * axes.wavelengths_nm.len()],
            None => variable(path, &mut reader, quantity.name(), &order)?,
        });
    }
    if let Some((name, _)) = constants.into_iter().next() {
        return Err(DatabaseError::file(path, format!("'{name}' is neither an axis nor a quantity")));
    }
    let reflectance = filled.pop().unwrap_or_default();
    let transmittance = filled.pop().unwrap_or_default();
    Ok(Table { axes, transmittance, reflectance, errors: None, metadata: metadata(path, fixed) })
}

/// A dimension in the table's order.
struct Dimension {
    name: &'static str,
    length: usize,
}

/// Checks that the unit of a coordinate, if it has one, is the axis's.
fn check_unit(path: &Path, reader: &FileReader, name: &str, axis: &str) -> Result<(), DatabaseError> {
    let known: &[&str] = match axis {
        "grain_size" => &["um", "µm", "micrometer", "micrometers", "micron", "microns"],
        "density" => &["kg m-3", "kg/m3", "kg m^-3", "kg/m^3", "kg m**-3", "kg/m³"],
        "angle" => &["degree", "degrees", "deg", "°"],
        "thickness" => &["cm", "centimeter", "centimeters"],
        "wavelength" => &["nm", "nanometer", "nanometers"],
        "temperature" => &["degree_Celsius", "degrees_Celsius", "celsius", "Celsius", "degC", "°C"],
        "facetness" | "water_saturation" | "transmittance" | "reflectance" => &["1"],
        _ => &["ng g-1", "ng/g", "ppb"],
    };
    match reader.data_set().get_var_attr_as_string(name, "units") {
        Some(unit) => {
            let unit: String = unit.chars().filter(|c| !c.is_control()).take(30).collect();
            if unit.is_empty() || known.contains(&unit.as_str()) {
                return Ok(());
            }
            Err(DatabaseError::file(path, format!("'{name}' has the unit '{unit}', but must be in {}", known[0])))
        }
        None => Ok(()),
    }
}

/// Checks that the numbers of a variable are its values: not packed, and without fill values.
fn check_plain(path: &Path, reader: &FileReader, name: &str) -> Result<(), DatabaseError> {
    let data = reader.data_set();
    for packed in ["scale_factor", "add_offset"] {
        if data.has_var_attr(name, packed) == Some(true) {
            return Err(DatabaseError::file(path, format!("'{name}' is packed ({packed}); write it as plain numbers")));
        }
    }
    for filled in ["_FillValue", "missing_value"] {
        let double = data.get_var_attr_f64(name, filled).is_some_and(|values| values.iter().any(|v| !v.is_nan()));
        let single = data.get_var_attr_f32(name, filled).is_some_and(|values| values.iter().any(|v| !v.is_nan()));
        if double || single {
            return Err(DatabaseError::file(path, format!("'{name}' has a fill value ({filled}); write it without")));
        }
    }
    Ok(())
}

/// Names of all dimensions of both quantities.
fn dimensions(path: &Path, reader: &FileReader) -> Result<Vec<String>, DatabaseError> {
    let mut names = Vec::new();
    for quantity in Quantity::ALL {
        if let Some(variable) = reader.data_set().get_var(quantity.name()) {
            names.extend(variable.dim_names().into_iter().filter(|name| !names.contains(name)).collect::<Vec<_>>());
        }
    }
    if names.is_empty() {
        return Err(DatabaseError::file(path, "has neither 'transmittance' nor 'reflectance'"));
    }
    Ok(names)
}

/// Reads a quantity on all axes in the table's order. Dimensions of length 1 may be absent.
fn variable(path: &Path, reader: &mut FileReader, name: &str, order: &[Dimension]) -> Result<Vec<f64>, DatabaseError> {
    let Some(found) = reader.data_set().get_var(name) else {
        return Err(DatabaseError::file(
            path,
            format!("has no '{name}'; if it is not needed, give any value: --set {name}=VALUE"),
        ));
    };
    let dimensions: Vec<Option<&str>> = found.dim_names().iter().map(|name| axis_of(name)).collect();
    // Distance in the file between neighbours along each axis.
    let mut strides = vec![0; order.len()];
    let mut stride = 1;
    for dimension in dimensions.iter().rev() {
        if let Some(index) = order.iter().position(|axis| Some(axis.name) == *dimension) {
            strides[index] = stride;
            stride *= order[index].length;
        }
    }
    if let Some(index) = (0..order.len()).find(|index| order[*index].length > 1 && strides[*index] == 0) {
        return Err(DatabaseError::file(path, format!("'{name}' has no dimension '{}'", order[index].name)));
    }
    check_unit(path, reader, name, name)?;
    let values = read(path, reader, name)?;
    let all: usize = order.iter().map(|axis| axis.length).product();
    if values.len() != all {
        return Err(DatabaseError::file(
            path,
            format!("has {} values of '{name}', but its axes have {all}", values.len()),
        ));
    }
    let mut filled = Vec::with_capacity(all);
    for number in 0..all {
        let (mut rest, mut index) = (number, 0);
        for (Dimension { length, .. }, stride) in order.iter().zip(&strides).rev() {
            index += rest % length * stride;
            rest /= length;
        }
        filled.push(check_fraction(path, "", name, values[index])?);
    }
    Ok(filled)
}

/// All values of a numeric variable.
fn read(path: &Path, reader: &mut FileReader, name: &str) -> Result<Vec<f64>, DatabaseError> {
    if !reader.data_set().has_var(name) {
        return Err(DatabaseError::file(path, format!("dimension '{name}' has no coordinate")));
    }
    check_plain(path, reader, name)?;
    Ok(match reader.read_var(name).map_err(|error| invalid_netcdf(path, &error))? {
        DataVector::F64(values) => values,
        // The shortest decimal: 0.1, not 0.10000000149.
        DataVector::F32(values) => values.into_iter().map(|v| v.to_string().parse().unwrap_or(f64::from(v))).collect(),
        DataVector::I32(values) => values.into_iter().map(f64::from).collect(),
        DataVector::I16(values) => values.into_iter().map(f64::from).collect(),
        DataVector::I8(values) => values.into_iter().map(f64::from).collect(),
        DataVector::U8(_) => return Err(DatabaseError::file(path, format!("'{name}' holds text, not numbers"))),
    })
}
