//! Sun and sky.
//!
//! In a scene y points north and x east.

mod clear;
mod overcast;
mod sun;

pub(crate) use clear::BuiltSky;
pub use clear::ClearSkyDescription;
pub use overcast::OvercastSkyDescription;
pub use sun::SunDescription;

use schemars::{JsonSchema, Schema};
use serde::Serialize;
use snowblue_base::toml_table::Table;
use snowblue_base::{KeyPath, ParseError};
use snowblue_transport::SnowSample;

use crate::error::SceneError;
use crate::sources::Sources;

/// Sun and sky.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
#[schemars(transform = clear_by_default)]
pub enum SkyDescription {
    /// A clear sky with its sun.
    Clear(ClearSkyDescription),
    /// An overcast sky.
    Overcast(OvercastSkyDescription),
}

/// Makes the key `type` optional in the schema of a clear sky.
fn clear_by_default(schema: &mut Schema) {
    let clear = schema.get_mut("oneOf").and_then(|kinds| kinds.get_mut(0));
    if let Some(serde_json::Value::Array(required)) = clear.and_then(|clear| clear.get_mut("required")) {
        required.retain(|key| key != "type");
    }
}

impl SkyDescription {
    /// Reads a sky, which is clear unless its table says otherwise.
    pub(crate) fn read(mut table: Table) -> Result<Self, ParseError> {
        let is_overcast = table.has("type") && table.take_name("type", &[("clear", false), ("overcast", true)])?;
        if is_overcast {
            OvercastSkyDescription::read(table).map(Self::Overcast)
        } else {
            table.read().map(Self::Clear)
        }
    }

    /// Number of lights that the description adds to a scene: sun and sky, or the sky alone.
    pub(crate) fn light_count(&self) -> usize {
        match self {
            Self::Clear(_) => 2,
            Self::Overcast(_) => 1,
        }
    }

    /// Whether the camera may see the sun.
    pub(crate) fn has_visible_sun(&self) -> bool {
        match self {
            Self::Clear(clear) => clear.visible,
            Self::Overcast(_) => false,
        }
    }

    /// Builds the sky over snow, or over bare ground if there is no snow.
    pub(crate) fn build(&self, snow: Option<&SnowSample>, sources: &Sources) -> Result<BuiltSky, SceneError> {
        let path = KeyPath::root("sky");
        match self {
            Self::Clear(clear) => clear.build(&path, snow, sources),
            Self::Overcast(overcast) => Ok(BuiltSky { lights: vec![overcast.build(&path, sources)?], air: None }),
        }
    }
}
