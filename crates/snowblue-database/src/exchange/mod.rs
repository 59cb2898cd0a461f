//! Other models' and instruments' curves into tables, and tables out to other programs.
//!
//! - [`import_csv`]: one row a value, columns by name, rows in any order;
//! - [`import_netcdf`]: variables on named dimensions in any order;
//! - [`export_csv`] and [`export_raw`]: the former's rows, and plain `f32` numbers with a JSON file that says what they are.
//!
//! What comes in must be a whole grid: every combination of the axes' values once. An axis that is not in the file, since
//! all of it has one value, is said beside it. Values are taken as they are, but must be shares of the light:
//! 0–1, and as much beyond as noise makes them.

mod export_csv;
mod export_raw;
mod import_csv;
mod import_netcdf;

use std::collections::BTreeMap;
use std::path::Path;

use crate::axes::DIFFUSE_ANGLE_DEG;
use crate::{Axes, DatabaseError, Property};

pub use export_csv::export_csv;
pub use export_raw::export_raw;
pub use import_csv::import_csv;
pub use import_netcdf::import_netcdf;

/// Values for what a file does not hold, by the names of its columns: an axis that has one value, or a quantity.
pub type Fixed = BTreeMap<String, f64>;

/// Transmittance and reflectance may leave 0–1 by this much.
const NOISE: f64 = 0.1;

/// What axes are called: in NetCDF and in CSV.
fn axis_names() -> Vec<(&'static str, String)> {
    let with_unit = |name: &'static str, unit: &str| (name, format!("{name}_{unit}"));
    let mut names =
        vec![with_unit("grain_size", "um"), ("facetness", "facetness".to_owned()), with_unit("density", "kg_m3")];
    names.extend(Property::all().map(|property| match property {
        Property::WaterSaturation => (property.name(), property.name().to_owned()),
        Property::Temperature => with_unit(property.name(), "c"),
        Property::Impurity(_) => with_unit(property.name(), "ng_g"),
    }));
    names.extend([with_unit("angle", "deg"), with_unit("thickness", "cm"), with_unit("wavelength", "nm")]);
    names
}

/// The axis of a name in either form.
fn axis_of(name: &str) -> Option<&'static str> {
    axis_names().into_iter().find(|(short, long)| *short == name || long == name).map(|(short, _)| short)
}

/// Axes from their values by short names; further properties are there if they have values.
fn axes(path: &Path, mut values: BTreeMap<&'static str, Vec<f64>>) -> Result<Axes, DatabaseError> {
    let names = axis_names();
    let in_order = names.iter().filter_map(|(short, _)| Some((*short, values.remove(short)?)));
    let axes = Axes::from_named(in_order).map_err(|missing| {
        let long = names.iter().find(|(short, _)| *short == missing).map_or(missing, |(_, long)| long);
        wrong(path, format!("has no '{long}'; if it is one value, give it: --set {long}=VALUE"))
    })?;
    axes.check_order().map_err(|error| wrong(path, error.to_string()))?;
    check_magnitudes(path, &axes)?;
    Ok(axes)
}

/// Checks that imported axes can be those of snow in their units: what is far off is in another unit.
fn check_magnitudes(path: &Path, axes: &Axes) -> Result<(), DatabaseError> {
    for (name, unit, values) in axes.named() {
        let (low, high) = match name {
            "grain_size" => (1.0, 1e5),
            "facetness" | "water_saturation" => (0.0, 1.0),
            "density" => (1.0, 1000.0),
            "temperature" => (-100.0, 0.0),
            "angle" => (DIFFUSE_ANGLE_DEG, 90.0),
            "wavelength" => (100.0, 1e5),
            _ => (0.0, 1e9),
        };
        if let Some(value) = values.iter().find(|value| !(low..=high).contains(*value)) {
            let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
            return Err(wrong(path, format!("{name} is {value}{unit}, but must lie in {low}–{high}{unit}")));
        }
    }
    Ok(())
}

/// Checks that a value is a share of light, but for noise.
fn check_share(path: &Path, place: &str, quantity: &str, value: f64) -> Result<f64, DatabaseError> {
    if (-NOISE..=1.0 + NOISE).contains(&value) {
        Ok(value)
    } else {
        Err(wrong(path, format!("{place}{quantity} is {value}, but must be a share of the light, 0–1")))
    }
}

/// Where what is imported came from, for the table's metadata.
fn metadata(path: &Path, fixed: &Fixed) -> Vec<(String, String)> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let said: Vec<String> = fixed.iter().map(|(name, value)| format!("{name}={value}")).collect();
    let mut metadata = vec![
        ("title", "Spectral transmittance and reflectance of snow".to_owned()),
        ("source", format!("imported from {name} by snowblue {}", env!("CARGO_PKG_VERSION"))),
    ];
    if !said.is_empty() {
        metadata.push(("set_on_import", said.join(" ")));
    }
    metadata.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

fn wrong(path: &Path, what: String) -> DatabaseError {
    DatabaseError::File { path: path.to_owned(), what }
}
