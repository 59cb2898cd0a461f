//! The paper's table, computed once for all figures that ask for it.

use std::sync::OnceLock;

use snowblue_database::fill::{FillOptions, fill};
use snowblue_database::{Axes, Table};

use crate::failure::Failure;

static TABLE: OnceLock<Table> = OnceLock::new();

/// Rays per facetness and index node of the grain tally. They leave .2 % in T of 15 cm, the same for all curves of a
/// facetness: four times as many move the greatest ΔE and RMSE of up to three components by 3 % at most.
const TALLY_RAYS: u32 = 1 << 18;

/// All curves of the paper's Table 1, by our engine.
pub(super) fn paper_table() -> Result<&'static Table, Failure> {
    if let Some(table) = TABLE.get() {
        return Ok(table);
    }
    let (table, _) = fill(&Axes::paper(), &FillOptions::by_ordinates(TALLY_RAYS), &|_, _| ()).map_err(Failure::work)?;
    Ok(TABLE.get_or_init(|| table))
}
