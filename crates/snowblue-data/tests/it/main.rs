//! The integration tests of `snowblue-data` in one program.

#![allow(clippy::unwrap_used, reason = "tests may panic")]

mod energy;
mod engine;
