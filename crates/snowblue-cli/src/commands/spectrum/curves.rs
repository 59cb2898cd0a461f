//! Fluxes of slabs at each wavelength: as rows of wavelengths or of bands, or as NetCDF, which xarray opens.
//!
//! In NetCDF the wavelength is a dimension. The leading columns are also dimensions if the slabs are all combinations
//! of their values, such as thicknesses and angles. Otherwise, and for the lines of a file, the leading columns are
//! coordinates on the dimension `slab`. Names are the names of the Python package: `thickness` with the unit cm for
//! `thickness_cm`.

use snowblue_database::axes::DIFFUSE_ANGLE_DEG;
use snowblue_database::file::netcdf::{NetCdf, Values, Variable};
use snowblue_database::table::Attribute;
use snowblue_figures::{Cell, DataTable, Metadata};
use snowblue_transport::parameters::name_and_unit;
use snowblue_transport::slab::{Estimate, Fluxes, Incidence, Radiometry};
use snowblue_transport::sunlight::BandWeights;

use super::{broadband, plus_minus};

const SLAB: &str = "slab";
const WAVELENGTH: &str = "wavelength";
const ERROR_COLUMNS: [&str; 3] = ["reflectance_se", "transmittance_se", "absorptance_se"];

/// The leading columns of the rows of each slab.
pub(super) struct Labels {
    /// Names of the columns.
    pub(super) columns: Vec<&'static str>,
    /// The cells of each slab.
    pub(super) cells: Vec<Vec<Cell>>,
    /// The number of values of each column, if the slabs are all combinations of them; the last column runs fastest.
    pub(super) axes: Option<Vec<usize>>,
}

/// Fluxes of slabs.
pub(super) struct Curves {
    pub(super) labels: Labels,
    /// The fluxes of each slab at each wavelength. The wavelength runs fastest.
    pub(super) rows: Vec<Radiometry>,
    /// The bands of the table; none for wavelengths.
    pub(super) bands: Vec<BandWeights>,
    /// Intervals of the rows; none without deviations.
    pub(super) intervals: Vec<Fluxes<[f64; 2]>>,
    /// Whether there are columns of standard errors.
    pub(super) has_errors: bool,
}

impl Labels {
    /// The labels of a slab with a single thickness, under each of some incidences.
    pub(super) fn of_incidences(thickness_cm: f64, incidences: &[Incidence]) -> Self {
        let cells = incidences.iter().map(|incidence| slab_cells(thickness_cm, incidence).to_vec()).collect();
        Self { columns: SLAB_COLUMNS.to_vec(), cells, axes: Some(vec![1, incidences.len()]) }
    }

    /// The columns that have a value for each slab.
    pub(super) fn full_columns(&self) -> Vec<&'static str> {
        let is_full = |place: &usize| {
            self.cells.iter().all(|cells| !matches!(&cells[*place], Cell::Word(word) if word.is_empty()))
        };
        (0..self.columns.len()).filter(is_full).map(|place| self.columns[place]).collect()
    }

    /// The variables of the columns in NetCDF, and the dimensions on which the slabs lie.
    fn variables(&self) -> (Vec<Variable<'static>>, Vec<(String, usize)>) {
        if let Some(variables) = self.axes.as_ref().and_then(|lengths| self.coordinates(lengths)) {
            let lengths = self.axes.iter().flatten().copied();
            let dimensions = variables.iter().map(|axis| axis.name.clone()).zip(lengths).collect();
            return (variables, dimensions);
        }
        let of_column = |(place, column): (usize, &&str)| self.of_slabs(place, column);
        (self.columns.iter().enumerate().map(of_column).collect(), vec![(SLAB.to_owned(), self.cells.len())])
    }

    /// The coordinates of all columns as dimensions, if they are numbers without repetition.
    fn coordinates(&self, lengths: &[usize]) -> Option<Vec<Variable<'static>>> {
        let axis = |(place, column): (usize, &&str)| {
            let stride: usize = lengths[place + 1..].iter().product();
            let value = |step: usize| number(column, &self.cells[step * stride][place]);
            let (name, unit) = name_and_unit_in_files(column);
            let values: Vec<f64> = (0..lengths[place]).map(value).collect::<Option<_>>()?;
            let is_repeated = |(place, value): (usize, &f64)| values[..place].contains(value);
            let has_repeated = values.iter().enumerate().any(is_repeated);
            (!has_repeated).then(|| Variable::coordinates(name, unit, values))
        };
        self.columns.iter().enumerate().map(axis).collect()
    }

    /// A column on the slabs: numbers, with NaN for an empty cell, or words.
    fn of_slabs(&self, place: usize, column: &str) -> Variable<'static> {
        let (name, unit) = name_and_unit_in_files(column);
        let cells = || self.cells.iter().map(|cells| &cells[place]);
        let numbers = cells().map(|cell| match cell {
            Cell::Word(word) if word.is_empty() => Some(f64::NAN),
            cell => number(column, cell),
        });
        if let Some(numbers) = numbers.collect::<Option<Vec<f64>>>().filter(|_| column != "name") {
            return Variable::new(name, unit, vec![SLAB.to_owned()], Values::Double(numbers.into()));
        }
        let words: Vec<Vec<u8>> = cells().map(|cell| cell.text().into_bytes()).collect();
        let length = words.iter().map(Vec::len).max().unwrap_or(0).max(1);
        let letters = words.into_iter().flat_map(|mut word| {
            word.resize(length, 0);
            word
        });
        let dimensions = vec![SLAB.to_owned(), format!("{name}_length")];
        Variable::new(name, unit, dimensions, Values::Letters(letters.collect()))
    }
}

/// Columns of thickness and incidence.
pub(super) const SLAB_COLUMNS: [&str; 2] = ["thickness_cm", "angle_deg"];

/// The cells of [`SLAB_COLUMNS`].
pub(super) fn slab_cells(thickness_cm: f64, incidence: &Incidence) -> [Cell; 2] {
    [thickness_cm.into(), Cell::word(incidence.to_string())]
}

impl Curves {
    /// The rows of each slab.
    fn of_slabs(&self) -> impl Iterator<Item = (&Vec<Cell>, &[Radiometry])> {
        self.labels.cells.iter().zip(self.rows.chunks_exact(self.wavelengths()))
    }

    /// The number of wavelengths.
    fn wavelengths(&self) -> usize {
        self.rows.len() / self.labels.cells.len()
    }

    /// The fluxes of a slab at each wavelength, or in each band.
    fn fluxes(&self, curve: &[Radiometry]) -> Vec<Fluxes> {
        let fluxes: Vec<Fluxes> = curve.iter().map(|row| row.fluxes).collect();
        if self.bands.is_empty() { fluxes } else { self.bands.iter().map(|band| band.broadband(&fluxes)).collect() }
    }

    /// Metadata of the fluxes: the greatest standard error, and the sunlight in the bands.
    pub(super) fn metadata(&self) -> Metadata {
        // Nothing passes through a half-space.
        let finite = self.of_slabs().filter(|(_, curve)| curve[0].thickness_cm.is_finite());
        let passed = finite.flat_map(|(_, curve)| self.fluxes(curve)).map(|fluxes| fluxes.transmittance);
        let mut metadata: Metadata = worst_error(&passed.collect::<Vec<_>>()).into_iter().collect();
        if !self.bands.is_empty() {
            metadata.extend(broadband::metadata(&self.bands));
        }
        metadata
    }

    /// A row for each slab and wavelength, or each slab and band.
    pub(super) fn table(&self, metadata: Metadata) -> DataTable {
        let errors = if self.has_errors { &ERROR_COLUMNS[..] } else { &[] };
        let last_leading = if self.bands.is_empty() { "wavelength_nm" } else { "band" };
        let mut columns = [&self.labels.columns[..], &[last_leading], &Fluxes::NAMES, errors].concat();
        let names: Vec<Cell> = if self.bands.is_empty() {
            self.rows[..self.wavelengths()].iter().map(|row| row.wavelength_nm.into()).collect()
        } else {
            self.bands.iter().map(|band| Cell::Word(broadband::name(band.band))).collect()
        };
        let mut rows: Vec<Vec<Cell>> = Vec::new();
        for (leading, curve) in self.of_slabs() {
            let fluxes = names.iter().cloned().zip(self.fluxes(curve));
            rows.extend(fluxes.map(|(name, fluxes)| self.row(leading, name, fluxes)));
        }
        if !self.intervals.is_empty() {
            columns.extend(plus_minus::COLUMNS);
            rows.iter_mut().zip(&self.intervals).for_each(|(row, at)| row.extend(plus_minus::cells(at)));
        }
        DataTable { columns, rows, metadata }
    }

    fn row(&self, leading: &[Cell], last_leading: Cell, fluxes: Fluxes) -> Vec<Cell> {
        let of_all = |part: fn(Estimate) -> f64| fluxes.map(part).to_array().map(Cell::from);
        let errors = if self.has_errors { &of_all(|estimate| estimate.standard_error)[..] } else { &[] };
        [leading, &[last_leading], &of_all(|estimate| estimate.value), errors].concat()
    }

    /// The fluxes at each wavelength as NetCDF.
    pub(super) fn netcdf(&self, metadata: &Metadata) -> NetCdf<'static> {
        let (mut variables, mut dimensions) = self.labels.variables();
        let coordinates: Vec<&str> = variables
            .iter()
            .filter(|variable| variable.dimensions.first().is_some_and(|first| first == SLAB))
            .map(|variable| &*variable.name)
            .collect();
        let coordinates = coordinates.join(" ");
        let mut on_all: Vec<String> = dimensions.iter().map(|(name, _)| name.clone()).collect();
        on_all.push(WAVELENGTH.to_owned());
        for variable in &variables {
            if let (Values::Letters(letters), [_, length]) = (&variable.values, &variable.dimensions[..]) {
                dimensions.push((length.clone(), letters.len() / self.labels.cells.len()));
            }
        }
        let first = &self.rows[..self.wavelengths()];
        dimensions.push((WAVELENGTH.to_owned(), first.len()));
        let wavelengths_nm = first.iter().map(|row| row.wavelength_nm).collect();
        variables.push(Variable::coordinates(WAVELENGTH, "nm", wavelengths_nm));
        variables.extend(self.quantities().into_iter().map(|(name, values)| {
            let variable = Variable::new(name, "1", on_all.clone(), Values::Double(values.into()));
            Variable { coordinates: coordinates.clone(), ..variable }
        }));
        let attribute = |(name, value): &(&str, String)| Attribute::new(name.replace(' ', "_"), value);
        NetCdf { attributes: metadata.iter().map(attribute).collect(), dimensions, variables }
    }

    /// The quantities of the rows, by the names of their columns.
    fn quantities(&self) -> Vec<(&'static str, Vec<f64>)> {
        let fluxes = |part: fn(Estimate) -> f64, place: usize| {
            self.rows.iter().map(|row| part(row.fluxes.to_array()[place])).collect()
        };
        let values = (0..3).map(|place| (Fluxes::NAMES[place], fluxes(|estimate| estimate.value, place)));
        let mut quantities: Vec<(&'static str, Vec<f64>)> = values.collect();
        if self.has_errors {
            let errors = (0..3).map(|place| (ERROR_COLUMNS[place], fluxes(|estimate| estimate.standard_error, place)));
            quantities.extend(errors);
        }
        if !self.intervals.is_empty() {
            let end = |at: &Fluxes<[f64; 2]>, place: usize| at.to_array().as_flattened()[place];
            let ends = |place: usize| self.intervals.iter().map(|at| end(at, place)).collect();
            quantities.extend(plus_minus::COLUMNS.into_iter().enumerate().map(|(place, name)| (name, ends(place))));
        }
        quantities
    }
}

/// The greatest relative standard error of transmittances, as metadata; none if standard errors are not known.
fn worst_error(passed: &[Estimate]) -> Option<(&'static str, String)> {
    let errors = passed.iter().map(|passed| (passed.standard_error / passed.value).abs());
    let worst = match errors.clone().reduce(f64::max)? {
        _ if passed.iter().any(|passed| passed.standard_error.is_nan()) => return None,
        _ if errors.clone().any(f64::is_nan) => "unknown: some transmittance is 0".to_owned(),
        worst => format!("{:.2} %", 100.0 * worst),
    };
    Some(("transmittance standard error at most", worst))
}

/// The name and the unit of a column in NetCDF.
fn name_and_unit_in_files(column: &str) -> (&str, &'static str) {
    match name_and_unit(column) {
        ("ssa", unit) => ("specific_surface_area", unit),
        other => other,
    }
}

/// A cell as a number. Diffuse light has an angle of its own.
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
