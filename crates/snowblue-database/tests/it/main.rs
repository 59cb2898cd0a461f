//! The integration tests of `snowblue-database` in one program.

#![allow(
    clippy::cast_possible_truncation,
    clippy::unwrap_used,
    reason = "tests may panic, and numbers of tests are small"
)]

mod axes_and_shards;
mod exchange;
mod look_up;
mod matching;
mod paper;
mod paper_colours;
mod roundtrip;
