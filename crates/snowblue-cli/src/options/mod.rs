//! Options that mean the same on every command, and the parsers of their values.

pub(crate) mod limits;
pub(crate) mod parse;

mod color;
mod compression;
mod development;
mod engine;
mod film_memory;
mod given;
mod light_field;
pub(crate) mod property;
mod scene;
mod slab;
mod snow;
mod weather;

pub(crate) use color::{ColorOptions, LightOptions, SampleCount};
pub(crate) use compression::Compression;
pub(crate) use development::DevelopmentOptions;
pub(crate) use engine::{Engine, OrdinatesArguments};
pub(crate) use film_memory::FilmMemory;
pub(crate) use given::{GivenOptions, Idle, has_no_effect};
pub(crate) use light_field::LightFieldOptions;
pub(crate) use property::PropertyAxis;
pub(crate) use scene::SceneOptions;
pub(crate) use slab::{SlabOptions, check_transmits};
pub(crate) use snow::{SnowOptions, set_optical_radius, snow_options};
pub(crate) use weather::WeatherOptions;
