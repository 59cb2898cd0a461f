//! The integration tests of `snowblue-web` in one program.

#![allow(clippy::unwrap_used, reason = "tests may panic")]

mod spectrum;
mod sunlight;
