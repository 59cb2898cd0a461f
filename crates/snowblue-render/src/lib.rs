#![doc = include_str!("../README.md")]
//!
//! # Data flow
//!
//! ```text
//! Scene ─► Integrator ─► render ─► Film ─► image_file (PNG, OpenEXR)
//!              │           └─ FilmAccumulator: exact sums, which files keep
//!              └─ what its method needs of the scene, prepared once
//! ```
//!
//! A [`Scene`] describes the composition of snow, and not its rendering. [`Integrator::prepare`] computes the data
//! that a method needs: curves of slabs, random walks, the light field. [`render()`] prepares the integrator and
//! renders the picture. [`scene::integrator`] names the methods. An integrator that was prepared always renders.
//!
//! A picture has the same bits on any number of threads.
//!
//! **Simplifications.** In PCASnow light enters the snow at one point and leaves it at another point on a straight
//! line, with the curves of a slab, and leaves equally in all directions.
//!
//! **Out of scope.** Building tables (`snowblue-database`); options and progress bars (the command).

pub mod error;

pub mod raster;

pub mod film;

pub mod integrators;

pub mod render;

pub use error::RenderError;
pub use film::Film;
pub use film::accumulator::FilmAccumulator;
pub use film::aov::Aovs;
pub use film::window::SampleBlock;
pub use integrators::{Integrator, Preparation, SceneStatistics};
pub use render::{Rendering, render};
pub use snowblue_base::files;
pub use snowblue_light_field::{FieldStatistics, bake};
pub use snowblue_scene as scene;
pub use snowblue_scene::film::{Development, Exposure};
pub use snowblue_scene::progress::{Phase, Progress};
pub use snowblue_scene::{Scene, SceneDescription, SceneError, SceneFile};
