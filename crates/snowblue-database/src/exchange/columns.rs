//! The columns of foreign tables: names of axes, values of a whole column, and their checks.

use std::collections::BTreeMap;
use std::path::Path;

use crate::axes::{DIFFUSE_ANGLE_DEG, NamedAxis};
use crate::table::Attribute;
use crate::{Axes, DatabaseError, Property};

/// Values that a file does not hold, by column name: an axis with one value, or a constant quantity.
pub type FixedValues = BTreeMap<String, f64>;

/// Noise by which transmittance and reflectance may leave 0–1.
const NOISE: f64 = 0.1;

/// The names of an axis.
pub(super) struct AxisName {
    pub(super) netcdf: &'static str,
    pub(super) csv: String,
}

/// The names of all axes.
pub(super) fn axis_names() -> Vec<AxisName> {
    let with_unit = |netcdf: &'static str, unit: &str| AxisName { netcdf, csv: format!("{netcdf}_{unit}") };
    let without_unit = |netcdf: &'static str| AxisName { netcdf, csv: netcdf.to_owned() };
    let mut names = vec![with_unit("grain_size", "um"), without_unit("facetness"), with_unit("density", "kg_m3")];
    names.extend(Property::all().map(|property| match property {
        Property::WaterSaturation => without_unit(property.name()),
        Property::Temperature => with_unit(property.name(), "c"),
        Property::Impurity(_) => with_unit(property.name(), "ng_g"),
    }));
    names.extend([with_unit("angle", "deg"), with_unit("thickness", "cm"), with_unit("wavelength", "nm")]);
    names
}

/// The NetCDF name of the axis with this name in either format.
pub(super) fn axis_of(name: &str) -> Option<&'static str> {
    axis_names().into_iter().find(|axis| axis.netcdf == name || axis.csv == name).map(|axis| axis.netcdf)
}

/// Axes from their values by NetCDF names.
pub(super) fn axes(path: &Path, mut values: BTreeMap<&'static str, Vec<f64>>) -> Result<Axes, DatabaseError> {
    let names = axis_names();
    let in_order = names.iter().filter_map(|axis| Some((axis.netcdf, values.remove(axis.netcdf)?)));
    let axes = Axes::from_named(in_order).map_err(|missing| {
        let name = names.iter().find(|axis| axis.netcdf == missing).map_or(missing, |axis| &axis.csv);
        DatabaseError::file(path, format!("has no '{name}'; if it has one value, give it: --set {name}=VALUE"))
    })?;
    axes.check_order().map_err(|error| DatabaseError::file(path, error.to_string()))?;
    check_magnitudes(path, &axes)?;
    Ok(axes)
}

/// Checks the magnitudes of imported axes, which catches wrong units.
fn check_magnitudes(path: &Path, axes: &Axes) -> Result<(), DatabaseError> {
    for NamedAxis { name, unit, values } in axes.named() {
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
            let what = format!("{name} is {value}{unit}, but must lie in {low}–{high}{unit}");
            return Err(DatabaseError::file(path, what));
        }
    }
    Ok(())
}

/// Checks that a value lies in 0–1 within noise. `place` is the position in the file, for the message.
pub(super) fn check_fraction(path: &Path, place: &str, quantity: &str, value: f64) -> Result<f64, DatabaseError> {
    if (-NOISE..=1.0 + NOISE).contains(&value) {
        Ok(value)
    } else {
        Err(DatabaseError::file(path, format!("{place}{quantity} is {value}, but must lie in 0–1")))
    }
}

/// The provenance of an imported table.
pub(super) fn metadata(path: &Path, fixed: &FixedValues) -> Vec<Attribute> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let settings: Vec<String> = fixed.iter().map(|(name, value)| format!("{name}={value}")).collect();
    let mut metadata = vec![
        Attribute::new("title", "Spectral transmittance and reflectance of snow"),
        Attribute::new("source", format!("imported from {name} by snowblue {}", env!("CARGO_PKG_VERSION"))),
    ];
    if !settings.is_empty() {
        metadata.push(Attribute::new("set_on_import", settings.join(" ")));
    }
    metadata
}
