//! Curves from NetCDF: `transmittance` and `reflectance` on named dimensions, in any order, each with its coordinate.
//!
//! Only the classic format is read (and its form with 64-bit offsets), as `to_netcdf(path, format="NETCDF3_64BIT")` of
//! xarray writes it. Dimensions that an axis does not know are refused; axes without a dimension are said beside the file.

use std::collections::BTreeMap;
use std::path::Path;

use netcdf3::{DataVector, FileReader};

use super::{Fixed, axes, axis_of, check_share, metadata, wrong};
use crate::file::{broken, open};
use crate::{DatabaseError, Quantity, Table};

/// Most values that a variable may have: what 8 GiB of memory hold.
const MOST_VALUES: usize = 1 << 30;

/// Reads a table; `fixed` says what has no dimension.
///
/// # Errors
/// If the file cannot be read, a dimension is not known, or a coordinate does not ascend.
pub fn import_netcdf(path: &Path, fixed: &Fixed) -> Result<Table, DatabaseError> {
    let mut reader = open(path)?;
    let mut values: BTreeMap<&'static str, Vec<f64>> = BTreeMap::new();
    for name in dimensions(path, &reader)? {
        let axis = axis_of(&name).ok_or_else(|| wrong(path, format!("dimension '{name}' is not an axis of snow")))?;
        check_unit(path, &reader, &name, axis)?;
        let axis_values = read(path, &mut reader, &name)?;
        if values.insert(axis, axis_values).is_some() {
            return Err(wrong(path, format!("has two dimensions for the axis '{axis}'")));
        }
    }
    let mut constants = BTreeMap::new();
    for (name, value) in fixed {
        match axis_of(name) {
            Some(axis) if values.contains_key(axis) => {
                return Err(wrong(path, format!("has '{name}' itself, so it cannot be set")));
            }
            Some(axis) => drop(values.insert(axis, vec![*value])),
            None => drop(constants.insert(name.as_str(), check_share(path, "", name, *value)?)),
        }
    }
    let axes = axes(path, values)?;
    let named = axes.named();
    let order: Vec<(&str, usize)> = named.iter().map(|(name, _, values)| (*name, values.len())).collect();
    let mut filled = Vec::new();
    for quantity in Quantity::ALL {
        filled.push(match constants.remove(quantity.name()) {
            Some(value) => vec![value; axes.curves() * axes.wavelengths_nm.len()],
            None => variable(path, &mut reader, quantity.name(), &order)?,
        });
    }
    if let Some((name, _)) = constants.into_iter().next() {
        return Err(wrong(path, format!("'{name}' is neither an axis nor a quantity")));
    }
    let reflectance = filled.pop().unwrap_or_default();
    let transmittance = filled.pop().unwrap_or_default();
    Ok(Table { axes, transmittance, reflectance, errors: None, metadata: metadata(path, fixed) })
}

/// Checks that a coordinate's unit, if it tells one, is the axis's.
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
            Err(wrong(path, format!("'{name}' has the unit '{unit}', but must be in {}", known[0])))
        }
        None => Ok(()),
    }
}

/// Checks that a variable's numbers are what they stand for: not packed, and none of them filled in.
fn check_plain(path: &Path, reader: &FileReader, name: &str) -> Result<(), DatabaseError> {
    let data = reader.data_set();
    for packed in ["scale_factor", "add_offset"] {
        if data.has_var_attr(name, packed) == Some(true) {
            return Err(wrong(path, format!("'{name}' is packed ({packed}); write it as plain numbers")));
        }
    }
    for filled in ["_FillValue", "missing_value"] {
        let double = data.get_var_attr_f64(name, filled).is_some_and(|values| values.iter().any(|v| !v.is_nan()));
        let single = data.get_var_attr_f32(name, filled).is_some_and(|values| values.iter().any(|v| !v.is_nan()));
        if double || single {
            return Err(wrong(path, format!("'{name}' has a number for missing values ({filled}); write it without")));
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
        return Err(wrong(path, "has neither 'transmittance' nor 'reflectance'".to_owned()));
    }
    Ok(names)
}

/// A quantity on all axes in the table's order; dimensions of length 1 may be absent.
fn variable(
    path: &Path,
    reader: &mut FileReader,
    name: &str,
    order: &[(&str, usize)],
) -> Result<Vec<f64>, DatabaseError> {
    let Some(found) = reader.data_set().get_var(name) else {
        return Err(wrong(path, format!("has no '{name}'; if it does not matter, give it: --set {name}=VALUE")));
    };
    let dimensions: Vec<Option<&str>> = found.dim_names().iter().map(|name| axis_of(name)).collect();
    // How far apart neighbours along each axis lie in the file.
    let mut strides = vec![0; order.len()];
    let mut stride = 1;
    for dimension in dimensions.iter().rev() {
        if let Some(place) = order.iter().position(|(axis, _)| Some(*axis) == *dimension) {
            strides[place] = stride;
            stride *= order[place].1;
        }
    }
    if let Some(place) = (0..order.len()).find(|place| order[*place].1 > 1 && strides[*place] == 0) {
        return Err(wrong(path, format!("'{name}' has no dimension '{}'", order[place].0)));
    }
    check_unit(path, reader, name, name)?;
    let values = read(path, reader, name)?;
    let all: usize = order.iter().map(|(_, length)| length).product();
    if values.len() != all {
        return Err(wrong(path, format!("has {} values of '{name}', but its axes ask for {all}", values.len())));
    }
    let mut filled = Vec::with_capacity(all);
    for number in 0..all {
        let (mut rest, mut place) = (number, 0);
        for ((_, length), stride) in order.iter().zip(&strides).rev() {
            place += rest % length * stride;
            rest /= length;
        }
        filled.push(check_share(path, "", name, values[place])?);
    }
    Ok(filled)
}

/// All values of a numeric variable.
fn read(path: &Path, reader: &mut FileReader, name: &str) -> Result<Vec<f64>, DatabaseError> {
    let length = reader.data_set().var_len(name);
    let length = length.ok_or_else(|| wrong(path, format!("dimension '{name}' has no coordinate")))?;
    if length > MOST_VALUES {
        return Err(wrong(path, format!("has {length} values of '{name}', more than fit into memory")));
    }
    check_plain(path, reader, name)?;
    Ok(match reader.read_var(name).map_err(|error| broken(path, &error))? {
        DataVector::F64(values) => values,
        // The number that was meant: .1, not .10000000149.
        DataVector::F32(values) => values.into_iter().map(|v| v.to_string().parse().unwrap_or(f64::from(v))).collect(),
        DataVector::I32(values) => values.into_iter().map(f64::from).collect(),
        DataVector::I16(values) => values.into_iter().map(f64::from).collect(),
        DataVector::I8(values) => values.into_iter().map(f64::from).collect(),
        DataVector::U8(_) => return Err(wrong(path, format!("'{name}' holds text, not numbers"))),
    })
}
