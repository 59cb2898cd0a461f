//! Paths over surfaces: PCASnow, and the light field.

pub(super) mod carried;
pub(super) mod open_sky;
pub(super) mod tracer;
mod vertex;
