//! A Lambertian surface: radiance L = ρ E / π, the same in every direction.

/// A surface that reflects alike in all directions, on both sides.
#[derive(Debug, Clone, Copy)]
pub struct Diffuse {
    /// Share of the light that is reflected, at every wavelength.
    pub reflectance: f32,
}
