//! Integrators: the radiance along a camera ray.
//!
//! [`Integrator::prepare`] computes once the data that a method needs of a scene: curves of snow, random walks, the
//! light field. A tracer for each task is then cheap to make.

mod snow_volumes;
mod surroundings;

mod snow_walk;

mod diffusion;
mod hybrid;
mod pcasnow;
mod reference;

mod camera_terms;
mod snow_shader;
mod sparkle;
mod surface;

mod light_tables;
mod path;
mod sample;

mod first_hit;
mod integrator;
mod method;

pub use integrator::{Integrator, Preparation, SceneStatistics};
pub(crate) use sample::{FilteredSample, PathSample};
