#![doc = include_str!("../README.md")]

mod body;
mod element;
mod field;
mod grid;
mod lattice;
mod plan;
mod scan;
pub mod shapes;
mod solver;
mod surface_flux;
mod system;

pub use body::{AxisCrossing, Body};
pub use field::{DiffusionAt, Fluence, GridOptions, SnowBody};
pub use plan::{FieldError, choose_step_m};
pub use scan::SurfaceElement;
pub use system::Diffusion;
