//! Writes tables as NetCDF.

use std::io::{self, Write as _};
use std::path::Path;

use snowblue_base::atomic_file::write_atomically;

use super::format::{
    self, ARITHMETIC, COMPONENT, ERROR_SUFFIX, GRAIN, PACKED_DIMENSIONS, PACKED_SUFFIX, SAMPLE, SHARD,
    SHARD_DIMENSIONS, SINGULAR_VALUE, SPACE, STEP,
};
use super::netcdf::{NetCdf, Values, Variable};
use crate::axes::NamedAxis;
use crate::shard::Shard;
use crate::table::{Attribute, StandardErrors};
use crate::{Axes, CompressedTable, DatabaseError, Quantity, Table};

impl Table {
    /// Writes the table to `path`.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), DatabaseError> {
        let variables =
            curve_variables(&dimensions(&self.axes), |quantity| self.values(quantity), self.errors.as_ref());
        content(&self.axes, self.metadata.clone(), &[], variables).write(path)
    }
}

impl Shard {
    /// Writes the shard to `path`.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), DatabaseError> {
        let shard = [Attribute::new(SHARD, self.part.to_string()), Attribute::new(ARITHMETIC, &self.arithmetic)];
        let lengths = [(GRAIN, self.part.grains(&self.axes).len()), (SAMPLE, self.axes.samples_per_grain())];
        let dimensions = SHARD_DIMENSIONS.map(str::to_owned);
        let variables = curve_variables(&dimensions, |quantity| self.values.of(quantity), self.values.errors.as_ref());
        content(&self.axes, [&self.metadata[..], &shard].concat(), &lengths, variables).write(path)
    }
}

impl CompressedTable {
    /// Writes the table to `path`.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), DatabaseError> {
        let mut dimensions = dimensions(&self.axes);
        dimensions.pop();
        dimensions.push(COMPONENT.to_owned());
        let coefficients = |quantity: Quantity| {
            let values = Values::Single(&self.components(quantity).coefficients);
            Variable::new(format!("{}_coefficients", quantity.name()), "1", dimensions.clone(), values)
        };
        self.content(Vec::new(), Quantity::ALL.map(coefficients)).write(path)
    }

    /// Writes the table to `path` with its coefficients [`rounded`](Self::rounded) by `step` and packed. The packed
    /// coefficients of the embedded table take about a tenth of the bytes. Packed tables are read like any other
    /// table, but only by this crate.
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
            dimensions.push((dimension, bytes.len()));
            let name = format!("{}{PACKED_SUFFIX}", quantity.name());
            let values = Values::Packed { bytes, step: (STEP, step) };
            variables.push(Variable::new(name, "1", vec![dimension.to_owned()], values));
        }
        self.content(dimensions, variables).write(path)
    }

    /// The content of a file with these coefficients, on axes and further dimensions.
    fn content<'t>(
        &'t self,
        mut lengths: Vec<(&str, usize)>,
        coefficients: impl IntoIterator<Item = Variable<'t>>,
    ) -> NetCdf<'t> {
        lengths.push((COMPONENT, self.transmittance.count));
        lengths.push((SINGULAR_VALUE, self.transmittance.singular_values.len()));
        let mut variables = Vec::new();
        for (quantity, coefficients) in Quantity::ALL.into_iter().zip(coefficients) {
            let components = self.components(quantity);
            variables.push(coefficients);
            let mut add = |part: &str, dimensions: &[&str], values| {
                let dimensions = dimensions.iter().map(|name| (*name).to_owned()).collect();
                variables.push(Variable::new(format!("{}_{part}", quantity.name()), "1", dimensions, values));
            };
            add("basis", &["wavelength", COMPONENT], Values::Single(&components.basis));
            let singular_values = Values::Double((&components.singular_values).into());
            add("singular_values", &[SINGULAR_VALUE], singular_values);
        }
        let attributes = [&self.metadata[..], &[Attribute::new(SPACE, self.space.name())]].concat();
        content(&self.axes, attributes, &lengths, variables)
    }
}

/// Names of the dimensions of the axes.
fn dimensions(axes: &Axes) -> Vec<String> {
    axes.named().iter().map(|axis| axis.name.to_owned()).collect()
}

/// The content of a file with the coordinates of the axes, and variables on them and on further dimensions.
fn content<'a>(
    axes: &Axes,
    attributes: Vec<Attribute>,
    lengths: &[(&str, usize)],
    variables: Vec<Variable<'a>>,
) -> NetCdf<'a> {
    let mut content = NetCdf { attributes, ..NetCdf::default() };
    for NamedAxis { name, unit, values } in axes.named() {
        content.dimensions.push((name.to_owned(), values.len()));
        content.variables.push(Variable::coordinates(name, unit, values));
    }
    content.dimensions.extend(lengths.iter().map(|(name, length)| ((*name).to_owned(), *length)));
    content.variables.extend(variables);
    content
}

/// A coefficient in steps, of which it is a multiple; an error with the coefficient if there are too many steps.
fn steps(coefficient: f32, step: f32) -> Result<i32, f32> {
    let steps = coefficient / step;
    #[expect(clippy::cast_possible_truncation, reason = "a whole number within the range")]
    if steps.abs() <= format::GREATEST as f32 { Ok(steps as i32) } else { Err(coefficient) }
}

/// Transmittance, reflectance and their standard errors, if they are known, as variables.
fn curve_variables<'v>(
    dimensions: &[String],
    values: impl Fn(Quantity) -> &'v [f64],
    errors: Option<&'v StandardErrors>,
) -> Vec<Variable<'v>> {
    let variable =
        |name, values: &'v [f64]| Variable::new(name, "1", dimensions.to_vec(), Values::Double(values.into()));
    let of_values = Quantity::ALL.map(|quantity| variable(quantity.name().to_owned(), values(quantity)));
    let of_error = |quantity: Quantity, errors: &'v StandardErrors| {
        variable(format!("{}{ERROR_SUFFIX}", quantity.name()), errors.of(quantity))
    };
    let of_errors = errors.into_iter().flat_map(|errors| Quantity::ALL.map(|quantity| of_error(quantity, errors)));
    of_values.into_iter().chain(of_errors).collect()
}

/// Writes bytes to a file.
pub(crate) fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), DatabaseError> {
    let failed = |error: io::Error| DatabaseError::file(path, format!("cannot be written: {error}"));
    write_atomically(path, |file| file.write_all(bytes)).map_err(failed)
}
