//! Snow by the keys of a file of layers.

use std::fmt::Display;

use serde::Deserialize;
use snowblue_transport::sample::{SnowKeys, SnowSample};

/// A layer of snow.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Layer {
    pub(crate) thickness_cm: f64,
    #[serde(flatten)]
    snow: SnowKeys,
}

impl Layer {
    /// The snow. Only its grain size is checked.
    pub(crate) fn sample(&self) -> Result<SnowSample, String> {
        self.snow.description().and_then(|snow| snow.sample()).map_err(text)
    }
}

/// The words of an error.
pub(crate) fn text(error: impl Display) -> String {
    error.to_string()
}
