//! Carved snow: the union of added solids without the union of removed solids, as one closed mesh.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_base::toml_table::Table;
use snowblue_base::{KeyError, KeyPath, Number, ParameterRange, ParseError, quantities};
use snowblue_shapes::carved::{Carved, CarvedError, Solid};

use super::keys::{BuiltShape, ObjectContext, ShapeKeys, check_shapes};
use super::solid::{EdgeRadius, MAX_REACH_M, SolidDescription, SolidSize};
use crate::error::SceneError;
use crate::values::first_seed;

quantities! {
    /// Height or length of the unevenness of carved snow.
    pub Unevenness = ParameterRange::new("unevenness", 0.0, MAX_REACH_M, "m");
}

/// Carved snow: the union of the solids that it adds without the union of the solids that it removes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CarvedDescription {
    /// Length of the cells of the mesh, in m.
    pub cell: Number<SolidSize>,
    /// Distance from the edge at which joints of solids begin to be rounded, in m.
    #[serde(default)]
    pub rounding: Number<EdgeRadius>,
    /// Height of the unevenness, in m; at most a quarter of its length.
    #[serde(default)]
    pub relief: Number<Unevenness>,
    /// Length of the coarsest unevenness, in m; at least two cells.
    #[serde(default = "CarvedDescription::default_relief_length")]
    pub relief_length: Number<Unevenness>,
    /// Seed of the unevenness.
    #[serde(default = "first_seed")]
    pub seed: u32,
    /// The solids that are added, at least one.
    #[serde(skip_deserializing)]
    #[schemars(!skip_deserializing)]
    pub add: Vec<SolidDescription>,
    /// The solids that are removed.
    #[serde(skip_deserializing, skip_serializing_if = "Vec::is_empty")]
    #[schemars(!skip_deserializing, default)]
    pub remove: Vec<SolidDescription>,
}

impl CarvedDescription {
    /// Reads the keys of a table.
    pub(super) fn read(mut table: Table) -> Result<Self, ParseError> {
        let mut solids =
            |key| table.take_tables(key)?.into_iter().map(SolidDescription::read).collect::<Result<_, ParseError>>();
        let (add, remove) = (solids("add")?, solids("remove")?);
        Ok(Self { add, remove, ..table.read()? })
    }

    fn default_relief_length() -> Number<Unevenness> {
        Number::of(0.3)
    }

    fn carved(&self, path: &KeyPath) -> Result<Carved, KeyError> {
        let [cell_m, relief_m, relief_length_m] = [self.cell.get(), self.relief.get(), self.relief_length.get()];
        // Shorter unevenness would fall between the vertices, and higher unevenness would come apart.
        if relief_m > 0.0 && relief_length_m < 2.0 * cell_m {
            let reason = format!("is {relief_length_m} m, but must be at least {} m, two cells", 2.0 * cell_m);
            return Err(path.key("relief_length").error(reason));
        }
        if relief_m > 0.25 * relief_length_m {
            let most_m = 0.25 * relief_length_m;
            let reason = format!("is {relief_m} m, but must be at most {most_m} m, a quarter of its length");
            return Err(path.key("relief").error(reason));
        }
        let add = path.key("add");
        if self.add.is_empty() {
            return Err(add.error("is empty, but must have at least one solid"));
        }
        if let Some(index) = self.add.iter().position(|solid| !solid.is_bounded()) {
            let reason = "is \"half_space\", which has no end and can only be removed";
            return Err(add.index(index).key("type").error(reason));
        }
        let solids = |key: &str, solids: &[SolidDescription]| -> Result<Vec<Solid>, KeyError> {
            let path = path.key(key);
            solids.iter().enumerate().map(|(index, solid)| solid.keys().build(&path.index(index))).collect()
        };
        Ok(Carved {
            cell_m,
            rounding_m: self.rounding.get(),
            relief_m,
            relief_length_m,
            seed: self.seed,
            add: solids("add", &self.add)?,
            remove: solids("remove", &self.remove)?,
        })
    }
}

impl ShapeKeys for CarvedDescription {
    fn build(&self, object: &mut ObjectContext) -> Result<BuiltShape, SceneError> {
        let path = object.path;
        check_shapes(path)?;
        let mesh = self.carved(path)?.mesh().map_err(|error| match error {
            CarvedError::TooFine { least_m } => {
                let (cell_m, least_m) = (self.cell.get(), rounded_up(least_m));
                let reason = format!("is {cell_m} m, but must be at least {least_m} m for solids of this size");
                path.key("cell").error(reason)
            }
            CarvedError::Empty => path.error("is empty: its solids are removed, rounded away, or smaller than a cell"),
        })?;
        Ok(object.place(mesh)?.into())
    }
}

/// A length rounded up to two digits.
fn rounded_up(length_m: f64) -> f64 {
    let digits = 10f64.powf(1.0 - length_m.log10().floor());
    (length_m * digits).ceil() / digits
}
