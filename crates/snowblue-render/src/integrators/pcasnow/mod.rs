//! PCASnow (Varsa & Baranoski 2024, Algorithm 1): light through snow along one straight line, by the curves of a slab.

pub(super) mod snow_curves;
pub(super) mod snow_vertex;
pub(super) mod table_hash;
mod transmission;
