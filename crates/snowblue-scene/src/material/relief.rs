//! The relief of the surface of snow: random heights of known statistics.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_base::toml_table::Value;
use snowblue_base::{KeyError, KeyPath, Number, ParameterRange, ParseError, quantities, short_number};
use snowblue_shapes::roughness::{Roughness, RoughnessStatistics};
use toml::de::DeValue;

use crate::values::first_seed;

quantities! {
    /// Root mean square of heights.
    pub ReliefHeight = ParameterRange::new("height", 0.01, 30.0, "mm");
    /// The distance at which the autocorrelation of heights is 1/e.
    pub CorrelationLength = ParameterRange::new("correlation length", 2.0, 1000.0, "mm");
    /// How much finer structure is lower than coarser structure.
    pub HurstExponent = ParameterRange::new("Hurst exponent", 0.1, 1.0, "");
}

/// Greatest root mean square of the slope.
const MAX_SLOPE: f64 = 1.0;

/// The relief of a surface: random heights of known statistics.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReliefDescription {
    /// Root mean square of the heights, in mm.
    pub height_mm: Number<ReliefHeight>,
    /// The distance at which the autocorrelation of heights is 1/e, in mm.
    pub correlation_mm: Number<CorrelationLength>,
    /// Hurst exponent, 0–1: how much finer structure is lower than coarser structure.
    #[serde(default = "ReliefDescription::default_hurst")]
    pub hurst: Number<HurstExponent>,
    /// Another number gives other heights of the same statistics.
    #[serde(default = "first_seed")]
    pub seed: u32,
}

/// Kinds of snow with a relief of their own: new snow that fell without wind, snow that the wind has packed and
/// smoothed, and snow that the sun has melted into small hollows. Height and correlation length in mm, Hurst exponent.
const KINDS: [(&str, [f64; 3]); 3] =
    [("fresh", [1.0, 25.0, 0.6]), ("wind-packed", [1.2, 50.0, 0.7]), ("melt-forms", [3.0, 60.0, 0.8])];

impl ReliefDescription {
    fn default_hurst() -> Number<HurstExponent> {
        Number::of(0.5)
    }

    /// The relief of a kind of snow: `fresh`, `wind-packed` or `melt-forms`.
    pub fn of_kind(name: &str) -> Option<Self> {
        let (_, [height_mm, correlation_mm, hurst]) = KINDS.into_iter().find(|(kind, _)| *kind == name)?;
        Some(Self {
            height_mm: Number::of(height_mm),
            correlation_mm: Number::of(correlation_mm),
            hurst: Number::of(hurst),
            seed: first_seed(),
        })
    }

    /// Reads the name of a kind, or a table.
    pub(super) fn read(value: Value) -> Result<Self, ParseError> {
        match value.get() {
            DeValue::String(kind) => Self::of_kind(kind).ok_or_else(|| {
                let names = KINDS.map(|(name, _)| name).join(", ");
                value.error(format!("is \"{kind}\", but must be one of {names}"))
            }),
            DeValue::Table(_) => value.read(),
            _ => Err(value.error("must be a kind of snow or a table")),
        }
    }

    /// Checks that the surface is not too steep for displaced triangles, and that this build makes reliefs.
    pub(super) fn check(&self, path: &KeyPath) -> Result<(), KeyError> {
        if !cfg!(feature = "shapes") {
            return Err(path.error("is what this build does not make"));
        }
        let slope = self.roughness().slope();
        if slope <= MAX_SLOPE {
            return Ok(());
        }
        let height_mm = self.height_mm.get();
        let [correlation, hurst] = [self.correlation_mm.get(), self.hurst.get()].map(short_number);
        let most = short_number((height_mm * MAX_SLOPE / slope * 100.0).floor() / 100.0);
        Err(path.key("height_mm").error(format!(
            "is {height_mm} mm, but must be at most {most} mm for a correlation_mm of {correlation} and a hurst of \
             {hurst}: its slope is then {MAX_SLOPE} on average (root mean square)"
        )))
    }

    /// The random heights.
    pub(crate) fn roughness(&self) -> Roughness {
        let statistics = RoughnessStatistics {
            height_m: 1e-3 * self.height_mm.get(),
            correlation_m: 1e-3 * self.correlation_mm.get(),
            hurst: self.hurst.get(),
        };
        Roughness::new(&statistics, self.seed)
    }
}
