//! Integrators: the radiance along a camera ray.
//!
//! [`Integrator::prepare`] computes once what a method needs of a scene: curves of snow, random walks, the light field.
//! A tracer for each task is cheap.

mod snow_volumes;
mod surroundings;

mod snow_walk;

mod hybrid;
mod path;
mod pcasnow;
mod reference;
mod single_scattering;
mod snow_vertex;
mod sparkle;
mod tangent_half_space;

mod first_hit;
mod integrator;
mod path_sample;
mod prepared;

pub use integrator::{Integrator, Preparation, SceneStatistics};
pub(crate) use path_sample::{FilteredSample, PathSample};
