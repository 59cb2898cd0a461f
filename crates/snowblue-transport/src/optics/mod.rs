//! Optical constants of ice, water and impurities, and Fresnel's laws.

mod fresnel;
pub mod ice;
pub mod impurity;
mod index_nodes;
mod spectral_table;
pub mod water;

pub(crate) use fresnel::polarised;
pub use fresnel::{Fresnel, fresnel};
pub use ice::{Ice, IceTable};
pub use impurity::{Impurities, Substance};
pub(crate) use index_nodes::{IndexNodes, lagrange};
pub(crate) use spectral_table::SpectralTable;
