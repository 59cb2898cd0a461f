#![doc = include_str!("../README.md")]

mod body;
mod cut_cells;
mod element;
mod field;
mod fixed_point;
mod grid;
mod lattice;
mod octree;
mod optics;
mod plan;
mod scan;
pub mod shapes;
mod sizes;
mod solver;
mod source;
mod spectral_nodes;
mod surface_flux;
mod system;
mod vectors;

pub use body::{AxisCrossing, Body};
pub use field::{CellBox, Fluence, SnowBody, SnowOfCells, SolveOptions, SurfacePatches, SurfaceValues};
pub use fixed_point::{FixedPointOptions, Missing, solve_fixed_point};
pub use grid::{GridOptions, SurfacePlace};
pub use optics::SnowOptics;
pub use plan::{FieldError, ScaledSizes, Survey, fit_sizes};
pub use scan::SurfaceElement;
pub use sizes::{CellSizes, SizeLimits, SizesByDistance};
pub use source::VolumeSource;
pub use spectral_nodes::{GROUP, Groups, KnownFactor, LayerSpectrum, MAX_GROUPS, SpectralNodes};
pub use system::Diffusion;
