//! The embedded table.
/// The embedded table.
pub fn embedded() -> snowblue_database::lookup::CompressedTable { todo!() }
