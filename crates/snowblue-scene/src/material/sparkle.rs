//! Sparkle: the facets of the grains at the surface that mirror a light into the camera.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_base::toml_table::Value;
use snowblue_base::{KeyError, KeyPath, Number, ParameterRange, ParseError, quantities, short_number};
use toml::de::DeValue;

use crate::values::Fraction;

quantities! {
    /// Diameter of the facets of grains. Smaller ones scatter light into all directions by diffraction.
    pub FacetSize = ParameterRange::new("diameter of facets", 5.0, 5000.0, "µm");
}

/// Sparkle: the facets of the grains at the surface that mirror a light into the camera.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SparkleDescription {
    /// Mean diameter of the facets, in µm; if absent, it follows from grain size and facetness.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub facet_size_um: Option<Number<FacetSize>>,
    /// Share of the surface of the grains that is flat facets, 0–1; the rest reflects smoothly.
    pub flat_fraction: Number<Fraction>,
}

impl Default for SparkleDescription {
    /// Facets all over the grains, with a size that follows from grain size and facetness.
    fn default() -> Self {
        Self { facet_size_um: None, flat_fraction: Number::of(1.0) }
    }
}

impl SparkleDescription {
    /// Reads a table, or `true` or `false`; none for `false`.
    pub(super) fn read(value: Value) -> Result<Option<Self>, ParseError> {
        match value.get() {
            DeValue::Boolean(is_on) => Ok(is_on.then(Self::default)),
            DeValue::Table(_) => value.read().map(Some),
            _ => Err(value.error("must be true, false or a table")),
        }
    }

    /// Checks that facets are no larger than their grains, whose mean size is at least `max_um`. Facets vary with the
    /// grains about their mean, so that no facet is then larger than its grain.
    pub(super) fn check(&self, path: &KeyPath, max_um: f64) -> Result<(), KeyError> {
        let Some(facet_size_um) = self.facet_size_um.map(Number::get) else { return Ok(()) };
        if facet_size_um <= max_um {
            return Ok(());
        }
        let (size, max) = (short_number(facet_size_um), short_number(max_um));
        let reason = format!("is {size} µm, but must be at most {max} µm, the mean size of the grains");
        Err(path.key("facet_size_um").error(reason))
    }
}
