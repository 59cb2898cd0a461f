//! Paths over surfaces: PCASnow, and the light field.

pub(super) mod open_sky;
pub(super) mod scene_lights;
pub(super) mod tracer;
mod vertex;
