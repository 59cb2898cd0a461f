//! Paths over surfaces: PCASnow, and the light field.

pub(super) mod carried;
pub(super) mod tracer;
mod vertex;
