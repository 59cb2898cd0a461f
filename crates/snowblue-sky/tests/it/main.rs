//! The integration tests of `snowblue-sky` in one program.

#![allow(clippy::unwrap_used, reason = "tests may panic")]

mod laws;
mod mitsuba;
mod published;
