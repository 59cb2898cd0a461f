//! Tables of curves.

use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;
use std::sync::Arc;

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use snowblue_color::Illuminant;
use snowblue_database::fidelity::{self, Criteria, Spread};
use snowblue_database::file::{self, AnyTable};
use snowblue_database::fill::{self, Engine, FillOptions};
use snowblue_database::lookup::PcaSnow;
use snowblue_database::pca::Decomposition;
use snowblue_database::table::Attribute;
use snowblue_database::{Axes, CompressedTable, Property, PropertyAxis, Quantity, Space, TableSample, axis_properties};
use snowblue_transport::ParameterRange;
use snowblue_transport::slab::Incidence;

use crate::arguments::{Angle, GivenSnow, Ordinates};
use crate::work::{failure, input, run};

/// Rays of the tally of a table.
const TALLY_RANGE: ParameterRange =
    ParameterRange { quantity: "number of tally rays", least: 1024.0, greatest: 1_048_576.0, unit: "" };

/// A table of curves, full or compressed.
#[pyclass(frozen, module = "snowblue._native")]
pub(crate) struct Table(Arc<AnyTable>);

/// Axes that differ from the axes of a preset.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct GivenAxes {
    preset: String,
    grain_size_um: Option<Vec<f64>>,
    facetness: Option<Vec<f64>>,
    density_kg_m3: Option<Vec<f64>>,
    thickness_cm: Option<Vec<f64>>,
    angle_deg: Option<Vec<Angle>>,
    wavelength_nm: Option<Vec<f64>>,
    properties: Vec<(String, Vec<f64>)>,
}

/// How a table is filled.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Filling {
    ordinates: Ordinates,
    tally_rays: u32,
    rays: Option<u64>,
    ice: String,
}

/// How a table is compressed: to a given number of components, or to the number of components that keeps the errors
/// within given limits.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Compression {
    space: String,
    components: Option<usize>,
    max_delta_e: Option<f64>,
    max_rmse: Option<f64>,
    illuminants: Vec<String>,
}

/// A snow by the quantities of a table.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct GivenSample {
    grain_size_um: f64,
    facetness: f64,
    density_kg_m3: f64,
    properties: BTreeMap<String, f64>,
}

#[pymethods]
impl Table {
    /// Reads a table from a file.
    #[staticmethod]
    fn open(path: PathBuf) -> PyResult<Self> {
        file::read(&path).map(Self::new).map_err(input)
    }

    /// Reads a table from the bytes of a file.
    #[staticmethod]
    fn from_bytes(bytes: Vec<u8>) -> PyResult<Self> {
        AnyTable::from_bytes("pickled table", &bytes).map(Self::new).map_err(input)
    }

    /// The table of the package.
    #[staticmethod]
    fn embedded() -> Self {
        Self::new(AnyTable::Compressed(snowblue_data::embedded().clone()))
    }

    /// Computes all curves on some axes.
    #[staticmethod]
    fn build(py: Python<'_>, axes: GivenAxes, filling: Filling, progress: Option<Bound<'_, PyAny>>) -> PyResult<Self> {
        let options = filling.options()?;
        let axes = axes.axes()?;
        axes.check(options.ice).map_err(input)?;
        let table = run(py, progress.as_ref(), move |control| {
            fill::fill(&axes, &options, &|at| control.set(at.done, at.total)).map_err(input)
        })?;
        Ok(Self::new(AnyTable::Full(table)))
    }

    /// The table in terms of a few principal components.
    fn compress(&self, py: Python<'_>, compression: Compression) -> PyResult<Self> {
        let table = Arc::clone(&self.0);
        let space = compression.space()?;
        for limit in [compression.max_delta_e, compression.max_rmse].into_iter().flatten() {
            if limit.is_nan() || limit <= 0.0 {
                return Err(input(format!("a greatest error is {limit}, but must be above 0")));
            }
        }
        let illuminants = compression.illuminants()?;
        let compressed = run(py, None, move |_| {
            let full = full(&table)?;
            let components = match compression.components {
                Some(components) => components,
                None => {
                    let criteria = Criteria {
                        max_delta_e: compression.max_delta_e.unwrap_or(f64::INFINITY),
                        max_rmse: compression.max_rmse.unwrap_or(f64::INFINITY),
                        illuminants,
                    };
                    fidelity::fewest_components(full, space, &criteria).map_err(input)?
                }
            };
            CompressedTable::new(full, space, components).map_err(input)
        })?;
        Ok(Self::new(AnyTable::Compressed(compressed)))
    }

    /// Writes the table as NetCDF.
    fn write(&self, path: PathBuf) -> PyResult<()> {
        match &*self.0 {
            AnyTable::Full(table) => table.write(&path),
            AnyTable::Compressed(table) => table.write(&path),
            AnyTable::Shard(shard) => shard.write(&path),
        }
        .map_err(failure)
    }

    /// What kind of table it is, in words.
    #[getter]
    fn kind(&self) -> &'static str {
        self.0.kind()
    }

    /// Number of curves.
    #[getter]
    fn curves(&self) -> usize {
        self.axes().curves()
    }

    /// Number of components; none for a full table.
    #[getter]
    fn components(&self) -> Option<usize> {
        match &*self.0 {
            AnyTable::Compressed(table) => Some(table.transmittance.count),
            AnyTable::Full(_) | AnyTable::Shard(_) => None,
        }
    }

    /// Space of the components; none for a full table.
    #[getter]
    fn space(&self) -> Option<&'static str> {
        match &*self.0 {
            AnyTable::Compressed(table) => Some(table.space.name()),
            AnyTable::Full(_) | AnyTable::Shard(_) => None,
        }
    }

    /// Name, unit and values of each axis.
    #[getter]
    fn axis_values(&self) -> Vec<(&'static str, &'static str, Vec<f64>)> {
        self.axes().named().into_iter().map(|axis| (axis.name, axis.unit, axis.values)).collect()
    }

    /// Provenance.
    #[getter]
    fn metadata(&self) -> HashMap<String, String> {
        let metadata = match &*self.0 {
            AnyTable::Full(table) => &table.metadata,
            AnyTable::Compressed(table) => &table.metadata,
            AnyTable::Shard(shard) => &shard.metadata,
        };
        metadata.iter().map(|Attribute { name, value }| (name.clone(), value.clone())).collect()
    }

    /// All values: of the axes in their order, the wavelength running fastest.
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for quantity in Quantity::ALL {
            let values = match &*self.0 {
                AnyTable::Full(table) => {
                    if let Some(errors) = &table.errors {
                        let errors = PyArray1::from_slice(py, errors.of(quantity));
                        dict.set_item(format!("{}_se", quantity.name()), errors)?;
                    }
                    table.values(quantity).to_vec()
                }
                AnyTable::Compressed(table) => rebuilt(table, quantity),
                AnyTable::Shard(_) => return Err(input("a shard has no complete axes; merge it first")),
            };
            dict.set_item(quantity.name(), PyArray1::from_vec(py, values))?;
        }
        Ok(dict)
    }

    /// Curves of each snow, for each thickness, then each angle, then each wavelength.
    fn look_up<'py>(
        &self,
        py: Python<'py>,
        samples: Vec<GivenSample>,
        thickness_cm: Vec<f32>,
        angle_deg: Vec<f32>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let AnyTable::Compressed(table) = &*self.0 else {
            return Err(input(format!("look-ups need a compressed table, but it is {}", self.0.kind())));
        };
        let snow: Vec<PcaSnow> = samples
            .par_iter()
            .map(|sample| PcaSnow::new(table, &sample.sample().map_err(input)?).map_err(input))
            .collect::<PyResult<_>>()?;
        looked_up(py, &table.axes, &snow, &thickness_cm, &angle_deg)
    }

    /// Curves of any snow in the same order: from the table if that holds the snow, else solved for.
    fn read_or_solve<'py>(
        &self,
        py: Python<'py>,
        snow: GivenSnow,
        thickness_cm: Vec<f32>,
        angle_deg: Vec<f32>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (table, sample) = (self.compressed()?, snow.sample().map_err(input)?);
        let axes = table.axes.clone();
        let (snow, _) = run(py, None, move |_| {
            PcaSnow::read_or_solve(Some(&table), &[sample], &table.axes.wavelengths_nm).map_err(input)
        })?;
        looked_up(py, &axes, &snow, &thickness_cm, &angle_deg)
    }

    /// The errors of one to `components` principal components: a row for each quantity and number.
    fn fidelity<'py>(
        &self,
        py: Python<'py>,
        space: String,
        components: usize,
        illuminant: String,
    ) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let table = Arc::clone(&self.0);
        let space = named_space(&space)?;
        let illuminant: Illuminant = illuminant.parse().map_err(input)?;
        let rows = run(py, None, move |control| {
            let full = full(&table)?;
            let mut rows = Vec::new();
            for quantity in Quantity::ALL {
                let decomposition = Decomposition::new(full, quantity, space).map_err(input)?;
                for count in 1..=components {
                    control.check();
                    let kept = decomposition.keep(full, quantity, count).map_err(input)?;
                    let found = fidelity::evaluate(full, quantity, &kept, space, Some(illuminant)).map_err(input)?;
                    rows.push((quantity, count, found, decomposition.singular_values()[count - 1]));
                }
            }
            Ok(rows)
        })?;
        let row = |(quantity, count, found, singular_value): &(Quantity, usize, fidelity::Fidelity, f64)| {
            let dict = PyDict::new(py);
            dict.set_item("quantity", quantity.name())?;
            dict.set_item("components", count)?;
            for (name, Spread { worst, percentile_99: p99, mean, .. }) in
                [("rmse", &found.rmse), ("delta_e", &found.delta_e)]
            {
                dict.set_item(format!("{name}_worst"), worst)?;
                dict.set_item(format!("{name}_p99"), p99)?;
                dict.set_item(format!("{name}_mean"), mean)?;
            }
            dict.set_item("fraction_above_2.3", found.perceptible_fraction)?;
            dict.set_item("negative_values", found.negative_values)?;
            dict.set_item("singular_value", singular_value)?;
            Ok(dict)
        };
        rows.iter().map(row).collect()
    }
}

impl Table {
    fn new(table: AnyTable) -> Self {
        Self(Arc::new(table))
    }

    fn axes(&self) -> &Axes {
        match &*self.0 {
            AnyTable::Full(table) => &table.axes,
            AnyTable::Compressed(table) => &table.axes,
            AnyTable::Shard(shard) => &shard.axes,
        }
    }

    /// The table for the snow of a scene.
    pub(crate) fn compressed(&self) -> PyResult<Arc<CompressedTable>> {
        match &*self.0 {
            AnyTable::Compressed(table) => Ok(Arc::new(table.clone())),
            other => Err(input(format!("rendering needs a compressed table, but it is {}", other.kind()))),
        }
    }
}

/// Curves of each snow within the axes of a table.
fn looked_up<'py>(
    py: Python<'py>,
    axes: &Axes,
    snow: &[PcaSnow],
    thickness_cm: &[f32],
    angle_deg: &[f32],
) -> PyResult<Bound<'py, PyDict>> {
    let greatest = |values: &[f64]| values.last().copied().unwrap_or_default();
    let thicknesses =
        ParameterRange { quantity: "thickness", least: 0.0, greatest: greatest(&axes.thicknesses_cm), unit: "cm" };
    let mut values: [Vec<f32>; 2] = Default::default();
    let mut spectrum = vec![0.0; axes.wavelengths_nm.len()];
    for snow in snow {
        let angles =
            ParameterRange { quantity: "angle", least: 0.0, greatest: snow.last_angle_deg().into(), unit: "°" };
        for thickness_cm in thickness_cm {
            thicknesses.check((*thickness_cm).into()).map_err(input)?;
            for angle_deg in angle_deg {
                angles.check((*angle_deg).into()).map_err(input)?;
                snow.transmittance(*thickness_cm, *angle_deg, &mut spectrum);
                values[0].extend_from_slice(&spectrum);
                snow.reflectance(*thickness_cm, *angle_deg, &mut spectrum);
                values[1].extend_from_slice(&spectrum);
            }
        }
    }
    let dict = PyDict::new(py);
    for (quantity, values) in Quantity::ALL.into_iter().zip(values) {
        dict.set_item(quantity.name(), PyArray1::from_vec(py, values))?;
    }
    Ok(dict)
}

fn full(table: &AnyTable) -> PyResult<&snowblue_database::Table> {
    match table {
        AnyTable::Full(table) => Ok(table),
        other => Err(input(format!("this needs a full table, but it is {}", other.kind()))),
    }
}

fn rebuilt(table: &CompressedTable, quantity: Quantity) -> Vec<f64> {
    let wavelengths = table.axes.wavelengths_nm.len();
    let mut values = vec![0.0; table.axes.curves() * wavelengths];
    for (curve, values) in values.chunks_exact_mut(wavelengths).enumerate() {
        table.components(quantity).rebuild(curve, table.space, values);
    }
    values
}

fn named_space(name: &str) -> PyResult<Space> {
    let named = [Space::Linear, Space::Log].into_iter().find(|space| space.name() == name);
    named.ok_or_else(|| input(format!("space '{name}' is not known; there are linear, log")))
}

fn named_property(name: &str) -> PyResult<Property> {
    let known = || axis_properties().map(Property::name).collect::<Vec<_>>().join(", ");
    let named = axis_properties().find(|property| property.name() == name);
    named.ok_or_else(|| input(format!("property '{name}' is not known; there are {}", known())))
}

impl GivenAxes {
    fn axes(self) -> PyResult<Axes> {
        let mut axes = match &*self.preset {
            "paper" => Axes::paper(),
            "default" => Axes::with_thin_and_thick_knots(),
            "fine" => Axes::fine(),
            "infrared" => Axes::infrared(),
            other => {
                return Err(input(format!("preset '{other}' is not known; there are paper, default, fine, infrared")));
            }
        };
        for (axis, values) in [
            (&mut axes.grain_sizes_um, self.grain_size_um),
            (&mut axes.facetness, self.facetness),
            (&mut axes.densities_kg_m3, self.density_kg_m3),
            (&mut axes.thicknesses_cm, self.thickness_cm),
            (&mut axes.wavelengths_nm, self.wavelength_nm),
        ] {
            if let Some(values) = values {
                *axis = values;
            }
        }
        if let Some(angles) = self.angle_deg {
            let incidences: Vec<Incidence> = angles.iter().map(Angle::incidence).collect::<PyResult<_>>()?;
            axes.set_incidences(&incidences);
        }
        for (name, values) in self.properties {
            axes.set_property(PropertyAxis { property: named_property(&name)?, values });
        }
        Ok(axes)
    }
}

impl Filling {
    fn options(&self) -> PyResult<FillOptions> {
        TALLY_RANGE.check(self.tally_rays.into()).map_err(input)?;
        let ordinates = self.ordinates.options()?;
        let engine = match self.rays {
            Some(rays) => Engine::MonteCarlo { rays },
            None => Engine::Ordinates { streams: ordinates.streams, tally_rays: self.tally_rays },
        };
        Ok(FillOptions { engine, seed: ordinates.seed, ice: self.ice.parse().map_err(input)? })
    }
}

impl Compression {
    fn space(&self) -> PyResult<Space> {
        named_space(&self.space)
    }

    fn illuminants(&self) -> PyResult<Vec<Illuminant>> {
        self.illuminants.iter().map(|name| name.parse().map_err(input)).collect()
    }
}

impl GivenSample {
    fn sample(&self) -> PyResult<TableSample> {
        let mut sample = TableSample::new(self.grain_size_um, self.facetness, self.density_kg_m3);
        for (name, value) in &self.properties {
            sample = sample.with(named_property(name)?, *value);
        }
        Ok(sample)
    }
}
