//! The integration tests of `snowblue-cli` in one program.

#![allow(clippy::float_cmp, clippy::unwrap_used, reason = "tests may panic, and some results are exact")]

mod bake;
mod batch;
mod broadband;
mod bsdf_and_plots;
mod colours;
mod command;
mod export;
mod figures;
mod finished;
mod idle_options;
#[cfg(target_os = "linux")]
mod interrupt;
mod layers;
mod outdoors;
#[cfg(target_os = "linux")]
mod outputs;
mod parts;
mod program;
mod reference;
mod refusals;
mod render_check;
mod repair;
mod scene_keys;
mod scenes;
mod shell;
mod sky;
mod snow;
mod statistics;
mod swatch;
mod tables;
