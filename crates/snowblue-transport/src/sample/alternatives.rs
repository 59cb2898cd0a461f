//! What the answer hangs on: the same snow under other plausible readings.
//!
//! A grain size is measured in several ways, facetness and sphericity are seldom known well, and two published tables of
//! ice disagree in the blue. Each alternative changes one of these and leaves the rest.

use super::grain_size::GrainSize;
use super::snow_sample::SnowSample;
use super::truncated_normal::{FACETNESS_RANGE, SPHERICITY_RANGE, TruncatedNormal};
use crate::grain::SizeMeasure;
use crate::optics::ice::IceTable;

/// How far facetness and sphericity are plausibly off.
const FACETNESS_DOUBT: f64 = 0.2;
const SPHERICITY_DOUBT: f64 = 0.1;

/// A sample and what is different about it.
#[derive(Debug, Clone, PartialEq)]
pub struct Alternative {
    /// In words: `as given`, `facetness + 0.2`, …
    pub name: &'static str,
    /// The snow.
    pub sample: SnowSample,
}

/// The sample as given, then with the other ice table, facetness ± 0.2, the other measures of size, sphericity ± 0.1.
///
/// At the ends of what is possible a law moves less than its name says, and keeps its width.
///
/// ```
/// use snowblue_transport::sample::{SnowSample, alternatives};
///
/// // What a grain size measures changes extinction by more than a third.
/// let extinctions: Vec<f64> =
///     alternatives(&SnowSample::default()).iter().map(|other| other.sample.extinction_per_m()).collect();
/// let ratio = extinctions.iter().copied().fold(0.0, f64::max) / extinctions.iter().copied().fold(f64::MAX, f64::min);
/// assert!(ratio > 1.35);
/// ```
#[must_use]
pub fn alternatives(given: &SnowSample) -> Vec<Alternative> {
    let other_ice = given.ice.other();
    let name = match other_ice {
        IceTable::WarrenBrandt2008 => "ice warren2008",
        IceTable::Picard2016 => "ice picard2016",
    };
    let mut found = vec![
        Alternative { name: "as given", sample: *given },
        Alternative { name, sample: SnowSample { ice: other_ice, ..*given } },
    ];
    for (name, shift) in [("facetness - 0.2", -FACETNESS_DOUBT), ("facetness + 0.2", FACETNESS_DOUBT)] {
        let facetness = shifted(&given.facetness, shift, FACETNESS_RANGE);
        found.push(Alternative { name, sample: SnowSample { facetness, ..*given } });
    }
    for (name, measure) in [
        ("size measure greatest-extension", SizeMeasure::GreatestExtension),
        ("size measure volume-diameter", SizeMeasure::VolumeDiameter),
        ("size measure optical-diameter", SizeMeasure::OpticalDiameter),
    ] {
        if measure != given.grain_size.measure {
            let grain_size = GrainSize { measure, ..given.grain_size };
            found.push(Alternative { name, sample: SnowSample { grain_size, ..*given } });
        }
    }
    for (name, shift) in [("sphericity - 0.1", -SPHERICITY_DOUBT), ("sphericity + 0.1", SPHERICITY_DOUBT)] {
        let sphericity = shifted(&given.sphericity, shift, SPHERICITY_RANGE);
        found.push(Alternative { name, sample: SnowSample { sphericity, ..*given } });
    }
    found
}

/// A distribution moved as a whole, or as far as its range allows: it keeps its width.
fn shifted(law: &TruncatedNormal, shift: f64, (low, high): (f64, f64)) -> TruncatedNormal {
    let shift = shift.clamp(low - law.min, high - law.max);
    TruncatedNormal { min: law.min + shift, max: law.max + shift, mean: law.mean + shift, ..*law }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_alternative_is_possible_and_differs() {
        let bare = SnowSample {
            facetness: TruncatedNormal::exactly(0.05),
            sphericity: TruncatedNormal::exactly(1.0),
            ..SnowSample::default()
        };
        for given in [SnowSample::default(), bare] {
            let found = alternatives(&given);
            assert_eq!(found.len(), 8);
            for (i, other) in found.iter().enumerate() {
                other.sample.check().unwrap();
                let cut = other.name == "sphericity + 0.1" && given == bare;
                assert_eq!(other.sample == given, i == 0 || cut, "{}", other.name);
            }
        }
    }
}
