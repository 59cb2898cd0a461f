#![doc = include_str!("../README.md")]

use std::sync::LazyLock;

use snowblue_database::CompressedTable;

static TABLE: LazyLock<CompressedTable> = LazyLock::new(|| {
    let bytes = include_bytes!("../data/snow.nc");
    CompressedTable::from_bytes("embedded table", bytes).unwrap_or_else(|error| unreachable!("{error}"))
});

/// The embedded table, read on first use.
///
/// Its axes are [`Axes::with_thin_and_thick_knots`](snowblue_database::Axes::with_thin_and_thick_knots).
#[must_use]
pub fn embedded() -> &'static CompressedTable {
    &TABLE
}
