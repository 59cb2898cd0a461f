//! Snow of layers, for the integrators that solve for the light inside.

use snowblue_transport::SnowSample;

use crate::scene::layering::Layering;

/// Snow of layers.
#[derive(Debug)]
pub struct LayeredSnow {
    /// The snow of each layer, top first.
    pub samples: Vec<SnowSample>,
    /// Where the layers lie.
    pub(crate) layering: Layering,
}
