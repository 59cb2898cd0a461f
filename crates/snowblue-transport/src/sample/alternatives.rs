//! Alternative readings of a sample, to show how much a result depends on uncertain parameters.
//!
//! Grain size is measured in several ways, facetness and sphericity are rarely known well, and two published tables of
//! ice disagree in the blue. Each alternative changes one of these and keeps the rest.

use snowblue_base::ParameterRange;

use super::grain_size::GrainSize;
use super::ranges::{FACETNESS_RANGE, SPHERICITY_RANGE};
use super::snow_sample::SnowSample;
use super::truncated_normal::TruncatedNormal;
use crate::grain::SizeMeasure;
use crate::optics::ice::IceTable;

/// Uncertainty of the facetness.
const FACETNESS_UNCERTAINTY: f64 = 0.2;
/// Uncertainty of the sphericity.
const SPHERICITY_UNCERTAINTY: f64 = 0.1;

/// A sample and how it differs from the given one.
#[derive(Debug, Clone, PartialEq)]
pub struct Alternative {
    /// The difference: `as given`, `facetness + 0.2`, …
    pub name: &'static str,
    /// The sample.
    pub sample: SnowSample,
}

/// The sample as given, then with the other ice table, facetness ± 0.2, the other size measures, and sphericity ± 0.1.
///
/// A distribution keeps its width. Near an end of the parameter's range it moves less than its name says.
///
/// ```
/// use snowblue_transport::sample::{SnowSample, alternatives};
///
/// // The size measure changes the extinction coefficient by more than a third.
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
    let mut samples = vec![
        Alternative { name: "as given", sample: *given },
        Alternative { name, sample: SnowSample { ice: other_ice, ..*given } },
    ];
    for (name, shift) in [("facetness - 0.2", -FACETNESS_UNCERTAINTY), ("facetness + 0.2", FACETNESS_UNCERTAINTY)] {
        let facetness = shifted(&given.facetness, shift, &FACETNESS_RANGE);
        samples.push(Alternative { name, sample: SnowSample { facetness, ..*given } });
    }
    for (name, measure) in [
        ("size measure greatest-extension", SizeMeasure::GreatestExtension),
        ("size measure volume-diameter", SizeMeasure::VolumeDiameter),
        ("size measure optical-diameter", SizeMeasure::OpticalDiameter),
    ] {
        if measure != given.grain_size.measure {
            let grain_size = GrainSize { measure, ..given.grain_size };
            samples.push(Alternative { name, sample: SnowSample { grain_size, ..*given } });
        }
    }
    for (name, shift) in [("sphericity - 0.1", -SPHERICITY_UNCERTAINTY), ("sphericity + 0.1", SPHERICITY_UNCERTAINTY)] {
        let sphericity = shifted(&given.sphericity, shift, &SPHERICITY_RANGE);
        samples.push(Alternative { name, sample: SnowSample { sphericity, ..*given } });
    }
    samples
}

/// The distribution moved by `shift`, or as far as `range` allows.
fn shifted(distribution: &TruncatedNormal, shift: f64, range: &ParameterRange) -> TruncatedNormal {
    let TruncatedNormal { min, max, mean, standard_deviation } = *distribution;
    let shift = shift.clamp(range.least - min, range.greatest - max);
    TruncatedNormal { min: min + shift, max: max + shift, mean: mean + shift, standard_deviation }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_alternative_is_valid_and_differs() {
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
