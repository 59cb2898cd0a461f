//! Light sources: what they emit, how a point of one is sampled, and the light that arrives at a surface.
//!
//! A point of an area light acts as a point light, and a direction of the sky as a distant one. So a surface asks for
//! one `LightSample` after the other:
//!
//! | light | sample | irradiance E of a surface |
//! |---|---|---|
//! | point, spot | the point | I cos θ / r² |
//! | directional | the direction | E⊥ cos θ |
//! | sphere, rectangle | a point, by solid angle | L cos θ cos θ_l / (r² p), θ_l at the light, p per m² |
//! | sky of any kind, sun | a direction | L cos θ / p, p per sr |
//!
//! Where several techniques sample a light, p is the sum of their densities (see [`Light`]). Area lights are visible
//! but occlude nothing.
//!
//! **A new kind of light** is a file here and a line in the list below. The file has the keys of a scene file with
//! their ranges (`LightKeys`), and what the light says of itself (`Emitter`): where it is, how it is sampled and with
//! which density, and what it emits. All else follows from these.

pub(crate) mod direction_table;
pub(crate) mod directional;
pub(crate) mod dome;
pub mod emitter;
pub(crate) mod image;
pub(crate) mod keys;
mod list;
pub(crate) mod point;
mod rectangle;
pub(crate) mod sample;
mod sphere;
pub(crate) mod spot;
pub(crate) mod sun;
mod techniques;
pub(crate) mod uniform_sky;

pub use image::Panorama;
pub use sample::{IncidentLight, LightDirection, LightOrigin, LightSample, SHADOW_EPSILON};
pub use techniques::Light;
pub use techniques::{LightHit, SamplingTechniques, irradiance_by_sky};

list::light_sources! {
    /// Shines from a point in all directions.
    "point" => Point(point::PointLightDescription),
    /// Shines from a point into a cone.
    "spot" => Spot(spot::SpotLightDescription),
    /// Parallel light.
    "directional" => Directional(directional::DirectionalLightDescription),
    /// A sphere that emits uniformly.
    "sphere" => Sphere(sphere::SphereLightDescription),
    /// A rectangle that emits from one side.
    "rectangle" => Rectangle(rectangle::RectangleLightDescription),
}

#[cfg(test)]
mod tests;
