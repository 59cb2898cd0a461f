//! The integration tests of `snowblue-field` in one program.

#![allow(clippy::unwrap_used, reason = "tests may panic")]

mod cell_sizes;
mod laws;
