//! Figures beyond the paper: comparisons with measurements, with simpler models and with path-traced references.

pub(crate) mod albedo;
pub(crate) mod microct;
pub(crate) mod simplifications;
pub(crate) mod truth;
pub(crate) mod water;
