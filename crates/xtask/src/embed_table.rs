//! Computes the table that `snowblue-data` embeds.
//!
//! The `snowblue` command cannot compute it, because it does not build without the file.

use std::path::{Path, PathBuf};

use snowblue_database::fill::{self, FillOptions};
use snowblue_database::{Axes, CompressedTable, DatabaseError, Space};

/// Step of the coefficients. The relative error of a value that comes of it is 8·10⁻⁶ (root mean square) and at most
/// 6.1·10⁻⁵, far below that of leaving out all other components.
const COEFFICIENT_STEP: f32 = 1.0 / 16384.0;

/// Fills, compresses and writes the table, to its place in the repository unless a file is given.
pub(crate) fn run(file: Option<&str>) -> Result<(), DatabaseError> {
    let place = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../snowblue-data/data/snow.nc");
    let path = file.map_or_else(place, PathBuf::from);
    let table = fill::fill(&Axes::with_thin_and_thick_knots(), &FillOptions::default(), &|_| ())?;
    let compressed = CompressedTable::new(&table, Space::Log, Space::Log.default_components())?;
    compressed.write_packed(&path, COEFFICIENT_STEP)
}
