//! Tables of spectra as NetCDF classic with named dimensions and units, which xarray opens.
//!
//! The wavelength is a dimension. The columns before it are dimensions too where the rows are all combinations of their
//! values, as those of thickness and angle; else, and for the lines of a file, they are coordinates on the dimension
//! `slab`. Names are those of the Python package: `thickness` with the unit cm for `thickness_cm`.

use std::collections::HashSet;
use std::fs::File;
use std::io;
use std::path::Path;

use netcdf3::error::{InvalidDataSet, WriteError};
use netcdf3::{DataSet, FileWriter, Version};
use snowblue_base::atomic_file::write_atomically;
use snowblue_database::axes::DIFFUSE_ANGLE_DEG;
use snowblue_figures::{Cell, DataTable};
use snowblue_transport::slab::Incidence;

use super::failure::{Failure, Outcome};

const SLAB: &str = "slab";
const WAVELENGTH: &str = "wavelength";

/// What the columns before the wavelength become.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Layout {
    /// Dimensions if the rows are all combinations of their values, else coordinates of slabs.
    Axes,
    /// Coordinates of slabs whatever the values.
    Slabs,
}

/// The content of a file.
struct Content {
    dimensions: Vec<(String, usize)>,
    variables: Vec<Variable>,
}

struct Variable {
    name: String,
    unit: &'static str,
    dimensions: Vec<String>,
    values: Values,
}

enum Values {
    Numbers(Vec<f64>),
    /// Words of equal length, filled with zeros.
    Letters(Vec<u8>),
}

/// Writes a table whose rows have a column of wavelengths, of which each slab has the same.
pub(super) fn write(path: &Path, results: &DataTable, layout: Layout) -> Outcome {
    let name = path.display();
    let content = Content::new(results, layout)
        .ok_or_else(|| Failure::Input(format!("{name}: NetCDF needs spectra; write these results as CSV or JSON")))?;
    let failed = |error: &dyn std::fmt::Debug| Failure::Work(format!("{name}: cannot be written: {error:?}"));
    let described = content.describe(results).map_err(|error| failed(&error))?;
    let write = |file: &mut File| {
        let output = Box::new(file.try_clone()?);
        content.write(&described, output).map_err(|error| match error {
            WriteError::IOErrorKind(kind) => io::Error::from(kind),
            other => io::Error::other(format!("{other:?}")),
        })
    };
    write_atomically(path, write).map_err(|error| Failure::Work(format!("{name}: cannot be written: {error}")))
}

impl Content {
    /// None if the rows are no spectra at the same wavelengths.
    fn new(results: &DataTable, layout: Layout) -> Option<Self> {
        let place = results.columns.iter().position(|column| *column == "wavelength_nm")?;
        let numbers = |column: usize| results.rows.iter().map(move |row| number(results.columns[column], &row[column]));
        let all_nm: Vec<f64> = numbers(place).collect::<Option<_>>()?;
        let leading = |row: &Vec<Cell>| row[..place].to_vec();
        let first = leading(results.rows.first()?);
        let count = results.rows.iter().take_while(|row| leading(row) == first).count();
        // Two slabs may be alike: the wavelengths then begin again.
        let count = (1..count).find(|i| all_nm[*i].to_bits() == all_nm[0].to_bits()).unwrap_or(count);
        let same = all_nm.chunks(count).all(|slab| slab == &all_nm[..count]);
        let constant = results.rows.chunks(count).all(|slab| slab.iter().all(|row| leading(row) == leading(&slab[0])));
        if !same || !constant {
            return None;
        }
        let slabs: Vec<&Vec<Cell>> = results.rows.iter().step_by(count).collect();
        let mut variables = Vec::new();
        let mut dimensions: Vec<(String, usize)> = Vec::new();
        let axes = || grid(&results.columns[..place], &slabs);
        if let Some(axes) = (layout == Layout::Axes).then(axes).flatten() {
            for (column, values) in axes {
                let (name, unit) = name_and_unit(column);
                dimensions.push((name.clone(), values.len()));
                variables.push(Variable {
                    dimensions: vec![name.clone()],
                    name,
                    unit,
                    values: Values::Numbers(values),
                });
            }
        } else {
            dimensions.push((SLAB.to_owned(), slabs.len()));
            for (number, column) in results.columns[..place].iter().enumerate() {
                let cells: Vec<&Cell> = slabs.iter().map(|row| &row[number]).collect();
                let variable = Variable::of_cells(column, &cells);
                if let (Values::Letters(letters), Some(length)) = (&variable.values, variable.dimensions.get(1)) {
                    dimensions.push((length.clone(), letters.len() / slabs.len()));
                }
                variables.push(variable);
            }
        }
        let mut on_all: Vec<String> = dimensions.iter().map(|(name, _)| name.clone()).collect();
        on_all.retain(|name| !name.ends_with("_length"));
        on_all.push(WAVELENGTH.to_owned());
        dimensions.push((WAVELENGTH.to_owned(), count));
        let wavelengths = Values::Numbers(all_nm[..count].to_vec());
        let own = vec![WAVELENGTH.to_owned()];
        variables.push(Variable { name: WAVELENGTH.to_owned(), unit: "nm", dimensions: own, values: wavelengths });
        for (column, name) in results.columns.iter().enumerate().skip(place + 1) {
            let values = Values::Numbers(numbers(column).collect::<Option<_>>()?);
            variables.push(Variable { name: (*name).to_owned(), unit: "1", dimensions: on_all.clone(), values });
        }
        Some(Self { dimensions, variables })
    }

    fn describe(&self, results: &DataTable) -> Result<DataSet, InvalidDataSet> {
        let mut data = DataSet::new();
        data.add_global_attr_string("Conventions", "CF-1.8")?;
        for (name, value) in &results.metadata {
            data.add_global_attr_string(&name.replace(' ', "_"), value)?;
        }
        for (name, length) in &self.dimensions {
            data.add_fixed_dim(name, *length)?;
        }
        // Coordinates of a dimension have its name; those of the slabs are listed.
        let is_spectrum =
            |dimensions: &[String]| dimensions.len() > 1 && dimensions.ends_with(&[WAVELENGTH.to_owned()]);
        let is_of_slab = |variable: &&Variable| {
            variable.dimensions.first().is_some_and(|first| first == SLAB) && !is_spectrum(&variable.dimensions)
        };
        let coordinates: Vec<&str> = self.variables.iter().filter(is_of_slab).map(|one| one.name.as_str()).collect();
        for Variable { name, unit, dimensions, values } in &self.variables {
            let Values::Numbers(values) = values else {
                data.add_var_u8(name, dimensions)?;
                data.add_var_attr_string(name, "_Encoding", "utf-8")?;
                continue;
            };
            data.add_var_f64(name, dimensions)?;
            data.add_var_attr_string(name, "units", unit)?;
            data.add_var_attr_string(name, "long_name", name.replace('_', " "))?;
            if is_spectrum(dimensions) && !coordinates.is_empty() {
                data.add_var_attr_string(name, "coordinates", coordinates.join(" "))?;
            }
            if name == "angle" && values.iter().any(|angle| *angle < 0.0) {
                data.add_var_attr_f64(name, "flag_values", vec![DIFFUSE_ANGLE_DEG])?;
                data.add_var_attr_string(name, "flag_meanings", "diffuse")?;
            }
        }
        Ok(data)
    }

    fn write(&self, described: &DataSet, output: Box<File>) -> Result<(), WriteError> {
        let mut writer = FileWriter::open_seek_write("", output)?;
        writer.set_def(described, Version::Offset64Bit, 0)?;
        for Variable { name, values, .. } in &self.variables {
            match values {
                Values::Numbers(numbers) => writer.write_var_f64(name, numbers)?,
                Values::Letters(letters) => writer.write_var_u8(name, letters)?,
            }
        }
        writer.close()
    }
}

impl Variable {
    /// A column on the slabs: numbers, of which an empty cell is NaN, or words.
    fn of_cells(column: &str, cells: &[&Cell]) -> Self {
        let (name, unit) = name_and_unit(column);
        let numbers: Option<Vec<f64>> = cells
            .iter()
            .map(|cell| match cell {
                Cell::Word(word) if word.is_empty() => Some(f64::NAN),
                cell => number(column, cell),
            })
            .collect();
        if let Some(numbers) = numbers.filter(|_| column != "name") {
            return Self { name, unit, dimensions: vec![SLAB.to_owned()], values: Values::Numbers(numbers) };
        }
        let words: Vec<Vec<u8>> = cells.iter().map(|cell| cell.text().into_bytes()).collect();
        let length = words.iter().map(Vec::len).max().unwrap_or(0).max(1);
        let letters = words.into_iter().flat_map(|mut word| {
            word.resize(length, 0);
            word
        });
        let dimensions = vec![SLAB.to_owned(), format!("{name}_length")];
        Self { name, unit, dimensions, values: Values::Letters(letters.collect()) }
    }
}

/// A cell as a number; diffuse light is the angle −1.
fn number(column: &str, cell: &Cell) -> Option<f64> {
    match cell {
        Cell::Number(number) => Some(*number),
        Cell::Word(word) if column == "angle_deg" => match word.parse().ok()? {
            Incidence::Beam { angle_deg } => Some(angle_deg),
            Incidence::Diffuse => Some(DIFFUSE_ANGLE_DEG),
        },
        Cell::Word(_) => None,
    }
}

/// The values of each column if the slabs are all their combinations, the last running fastest.
fn grid<'c>(columns: &[&'c str], slabs: &[&Vec<Cell>]) -> Option<Vec<(&'c str, Vec<f64>)>> {
    let mut axes: Vec<(&str, Vec<f64>)> = Vec::new();
    for (place, column) in columns.iter().enumerate() {
        let (mut values, mut known) = (Vec::new(), HashSet::new());
        for slab in slabs {
            let value = number(column, &slab[place])?;
            if known.insert(value.to_bits()) {
                values.push(value);
            }
        }
        axes.push((column, values));
    }
    if axes.iter().map(|(_, values)| values.len()).product::<usize>() != slabs.len() {
        return None;
    }
    let in_order = slabs.iter().enumerate().all(|(row, slab)| {
        let mut rest = row;
        axes.iter().enumerate().rev().all(|(place, (column, values))| {
            let expected = values[rest % values.len()];
            rest /= values.len();
            number(column, &slab[place]).is_some_and(|value| value.to_bits() == expected.to_bits())
        })
    });
    in_order.then_some(axes)
}

/// The name and the unit of a column.
fn name_and_unit(column: &str) -> (String, &'static str) {
    const UNITS: [(&str, &str); 8] = [
        ("_kg_m3", "kg m-3"),
        ("_m2_kg", "m2 kg-1"),
        ("_ng_g", "ng g-1"),
        ("_cm", "cm"),
        ("_nm", "nm"),
        ("_um", "um"),
        ("_deg", "degree"),
        ("_c", "degC"),
    ];
    let found = UNITS.iter().find_map(|(end, unit)| Some((column.strip_suffix(end)?, *unit)));
    match found {
        Some(("ssa", unit)) => ("specific_surface_area".to_owned(), unit),
        Some((name, unit)) => (name.to_owned(), unit),
        None => (column.to_owned(), "1"),
    }
}
