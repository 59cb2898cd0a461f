//! The integration tests of `snowblue-transport` in one program.

#![allow(clippy::unwrap_used, reason = "tests may panic")]

mod batch;
mod bidirectional;
mod broadband;
mod derivatives;
mod engines_agree;
mod extremes;
mod goniometric;
mod ice;
mod inversion;
mod laws;
mod layer_derivatives;
mod layers;
mod published;
mod reflection_table;
mod refusals;
mod variables;
mod wet_and_dirty;
