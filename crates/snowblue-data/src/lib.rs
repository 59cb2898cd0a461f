//! The computed, compressed table of snow that every face of the product carries.
//!
//! It has the axes of the paper's Table 1 with thin and thick knots in the thickness and two more angles, six principal
//! components in log space for transmittance and for reflectance, and the ice of Warren & Brandt 2008. The example `embed` of
//! `snowblue-database` computes it; the file's attributes say how. A test computes random rows anew and compares.

use std::sync::LazyLock;

use snowblue_database::CompressedTable;

static TABLE: LazyLock<CompressedTable> = LazyLock::new(|| {
    let bytes = include_bytes!("../data/snow.nc");
    CompressedTable::from_bytes("embedded table", bytes).unwrap_or_else(|error| unreachable!("{error}"))
});

/// The embedded table.
///
/// ```
/// use snowblue_database::{PcaSnow, TableSample};
///
/// let sample = TableSample::new(420.0, 0.35, 310.0);
/// let snow = PcaSnow::new(snowblue_data::embedded(), &sample)?;
/// let mut spectrum = [0.0; 31];
/// snow.transmittance(30.0, 0.0, &mut spectrum);
/// // Behind 30 cm of snow there is ten times as much blue as red.
/// assert!(spectrum[5] > 10.0 * spectrum[30]);
/// # Ok::<(), snowblue_database::DatabaseError>(())
/// ```
#[must_use]
pub fn embedded() -> &'static CompressedTable {
    &TABLE
}
