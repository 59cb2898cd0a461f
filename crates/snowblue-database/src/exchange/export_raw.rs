//! Exports a table as plain numbers, for engines without NetCDF: little-endian `f32`, described by a JSON file.

use std::path::Path;

use serde_json::{Value, json};

use crate::file::{AnyTable, write_bytes};
use crate::pca::{Components, single};
use crate::{Axes, CompressedTable, DatabaseError, Quantity, Space};

/// How to evaluate a spectrum, for the JSON file.
const RECIPE: &str = "Row-major arrays: the last dimension runs fastest. The coefficients of a curve times the basis, \
                      summed over the components, are its values in the space; in log space take the exponential. \
                      Between thicknesses and angles interpolate the coefficients, which is the same as interpolating \
                      the values in the space. Thickness 0: transmittance 1, reflectance 0.";

/// Writes a JSON file to `path` and the numbers beside it, in a file of the extension `f32`.
///
/// # Errors
/// If a file cannot be written, or the table is a shard.
pub fn export_raw(table: &AnyTable, path: &Path) -> Result<(), DatabaseError> {
    let mut numbers: Vec<f32> = Vec::new();
    let mut arrays = Vec::new();
    let (axes, metadata, space) = match table {
        AnyTable::Full(table) => {
            let dimensions = names(&table.axes);
            for quantity in Quantity::ALL {
                let values = table.values(quantity).iter().map(|value| single(*value));
                arrays.push(array(quantity.name(), &dimensions, &mut numbers, values));
            }
            (&table.axes, &table.metadata, None)
        }
        AnyTable::Compressed(table) => {
            for quantity in Quantity::ALL {
                arrays.extend(components(table, quantity, &mut numbers));
            }
            (&table.axes, &table.metadata, Some(table.space))
        }
        AnyTable::Shard(_) => {
            return Err(DatabaseError::file(path, "cannot be made from a shard; merge the shards first"));
        }
    };
    let beside = path.with_extension("f32");
    let document = json!({
        "format": "snowblue raw 1",
        "numbers": beside.file_name().unwrap_or_default().to_string_lossy(),
        "number_type": "float32",
        "byte_order": "little-endian",
        "space": space.map(Space::name),
        "axes": axes.named().iter().map(|axis| json!({ "name": axis.name, "unit": axis.unit, "values": axis.values }))
            .collect::<Vec<_>>(),
        "arrays": arrays,
        "recipe": space.map(|_| RECIPE),
        "metadata": metadata.iter().map(|entry| (entry.name.clone(), json!(entry.value)))
            .collect::<serde_json::Map<_, _>>(),
    });
    let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
    write_bytes(&beside, &bytes)?;
    write_bytes(path, format!("{document:#}\n").as_bytes())
}

fn components(table: &CompressedTable, quantity: Quantity, numbers: &mut Vec<f32>) -> [Value; 2] {
    let Components { coefficients, basis, .. } = table.components(quantity);
    let mut dimensions = names(&table.axes);
    dimensions.pop();
    dimensions.push("component");
    let name = |part: &str| format!("{}_{part}", quantity.name());
    [
        array(&name("coefficients"), &dimensions, numbers, coefficients.iter().copied()),
        array(&name("basis"), &["wavelength", "component"], numbers, basis.iter().copied()),
    ]
}

/// Appends an array to the numbers and describes its position.
fn array(name: &str, dimensions: &[&str], numbers: &mut Vec<f32>, values: impl Iterator<Item = f32>) -> Value {
    let first = numbers.len();
    numbers.extend(values);
    json!({ "name": name, "dimensions": dimensions, "first_number": first, "count": numbers.len() - first })
}

fn names(axes: &Axes) -> Vec<&'static str> {
    axes.named().into_iter().map(|axis| axis.name).collect()
}
