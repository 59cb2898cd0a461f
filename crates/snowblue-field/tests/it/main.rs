//! The integration tests of `snowblue-field` in one program.

#![allow(clippy::unwrap_used, reason = "tests may panic")]

mod cell_sizes;
mod laws;

use snowblue_field::{Fluence, SnowBody, SurfaceValues};
use wide::f32x4;

/// The net flux outwards through the surface, for the light of a solution in one group of wavelengths.
fn surface_flux(body: &SnowBody, fluence: &Fluence, light: &Vec<f32x4>) -> SurfaceValues {
    body.smooth(&body.element_flux(fluence, std::slice::from_ref(light)))
}
