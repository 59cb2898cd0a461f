//! Sparkle: single facets of grains that mirror a light into the camera.
//!
//! The reflection function R₀ of snow has the mean of the first reflection from the outside of grains,
//!
//! ```text
//! L_ext = F p_ext(Θ)/(μ + μ₀),
//! ```
//!
//! with p_ext of [`ExternalReflection`](snowblue_transport::medium::ExternalReflection): light scattered once, that
//! meets grains by chance on its way in and out. Sparkle draws the facets that this is the mean of. The radiance of a
//! camera sample changes by L_ext (S − 1), where S is the light of the facets in the sample's footprint over its mean,
//! so that the mean over many pixels stays what it is.
//!
//! - [`facets`] says what S is: how many facets of which size there are, and what each reflects.
//! - [`facet_field`] says where they lie: places and orientations by a hash, fixed to the object, without end.
//! - [`footprint`] is the part of the surface that a sample sees.
//! - [`scene_sparkle`] brings them together with the objects and lights of a scene.
//!
//! Discrete facets on a grid of places and directions are those of Jakob, Hašan, Yan, Lawrence, Ramamoorthi & Marschner
//! (2014, *Discrete stochastic microfacet models*, doi:10.1145/2601097.2601186). Snow has so few that mirror the sun
//! that they can be listed; a hierarchy as theirs, or numbers drawn for a footprint as by Zirr & Kaplanyan (2016,
//! doi:10.1145/2856400.2856409) and Deliot & Belcour (2023, doi:10.1111/cgf.14866), is not needed.

mod facet_field;
mod facets;
mod footprint;
mod scene_sparkle;

pub(in crate::integrators) use scene_sparkle::{SceneSparkle, SparkleReader, SparklingPoint};
