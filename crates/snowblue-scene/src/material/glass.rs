//! Panes of glass, so thin that light passes them straight on.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_base::{Number, ParameterRange, narrow, quantities};
use snowblue_transport::optics::pane_transmittance;

quantities! {
    /// Refractive index of a pane relative to air.
    pub PaneIndex = ParameterRange::new("refractive index", 1.0, 3.0, "");
}

/// A thin pane without absorption: every surface is a pane with two faces, also each surface of a box.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct GlassDescription {
    /// Refractive index relative to air.
    pub refractive_index: Number<PaneIndex>,
}

impl Default for GlassDescription {
    /// Window glass.
    fn default() -> Self {
        Self { refractive_index: Number::of(1.52) }
    }
}

impl GlassDescription {
    pub(super) fn build(self) -> Glass {
        Glass::new(self.refractive_index.get())
    }
}

/// A thin pane without absorption.
#[derive(Debug, Clone, Copy)]
pub struct Glass {
    refractive_index: f64,
}

impl Glass {
    /// A pane of a refractive index.
    pub(crate) fn new(refractive_index: f64) -> Self {
        Self { refractive_index }
    }

    /// The share of light that passes at a cosine of incidence. The rest is mirrored.
    pub(super) fn transmittance(self, cos_incidence: f32) -> f32 {
        narrow(pane_transmittance(cos_incidence.into(), self.refractive_index))
    }
}
