//! How many wavelengths a colour takes: sums over n samples in equal steps against the sum over a curve's own.
//!
//! The samples are the first wavelength, the last, and n − 2 between them. Between a curve's own wavelengths its logarithm is
//! joined by straight lines, since deep in snow light falls by a factor from one to the next; the illuminant's power is
//! joined by straight lines as ever. With few samples even the bare light gets another hue, and a narrow line of a lamp
//! falls between them: both colours are therefore compared before the one white of the full sum.

use rayon::prelude::*;
use snowblue_color::{ColorDifference, Colorimeter, Illuminant, Observer, Xyz};

use super::PERCEPTIBLE_DELTA_E;
use crate::DatabaseError;

/// Fewest samples that are tried.
const FEWEST_SAMPLES: usize = 3;

/// What a number of samples costs: the greatest ΔE*ab of any curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampleCost {
    /// How many samples.
    pub samples: usize,
    /// ΔE*ab of the light as it comes through.
    pub as_it_is: f64,
    /// ΔE*ab with both lights brought to L* = 50, as by an exposure.
    pub at_middle_grey: f64,
}

/// Numbers of samples that keep every curve within what an eye sees.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SamplesNeeded {
    /// The fewest that do.
    pub fewest: usize,
    /// The fewest from which on all do: less may do by luck.
    pub all_from: usize,
}

/// The cost of 3, 4, … and of as many samples as the curves have, which is 0.
///
/// # Errors
/// If the curves' own wavelengths do not allow colours under `illuminant`.
///
/// # Panics
/// If a curve has not one value per wavelength.
pub fn sample_costs(
    curves: &[&[f64]],
    wavelengths_nm: &[f64],
    illuminant: Illuminant,
) -> Result<Vec<SampleCost>, DatabaseError> {
    let colorimeter = Colorimeter::new(Observer::Cie1931, illuminant, wavelengths_nm)?;
    let white = colorimeter.white();
    let sums: Vec<Option<FewSamples>> = (FEWEST_SAMPLES..=wavelengths_nm.len())
        .map(|samples| FewSamples::new(wavelengths_nm, illuminant, samples))
        .collect();
    let unknown = [f64::INFINITY; 2];
    let costs_of_curve = |curve: &&[f64]| -> Vec<[f64; 2]> {
        let whole = colorimeter.xyz(curve);
        let logarithms: Vec<f64> = curve.iter().map(|value| value.ln()).collect();
        let differ = |sum: &FewSamples| {
            let found = ColorDifference::between(sum.xyz(curve, &logarithms), whole, white);
            [found.as_given, found.at_middle_grey]
        };
        sums.iter().map(|sum| sum.as_ref().map_or(unknown, differ)).collect()
    };
    let none = || vec![[0.0; 2]; sums.len()];
    let greater = |mut a: Vec<[f64; 2]>, b: Vec<[f64; 2]>| {
        for (a, b) in a.as_flattened_mut().iter_mut().zip(b.as_flattened()) {
            *a = a.max(*b);
        }
        a
    };
    let worst = curves.par_iter().map(costs_of_curve).reduce(none, greater);
    let cost =
        |(samples, [as_it_is, at_middle_grey]): (usize, [f64; 2])| SampleCost { samples, as_it_is, at_middle_grey };
    Ok((FEWEST_SAMPLES..).zip(worst).map(cost).collect())
}

/// How many samples keep ΔE*ab, taken out of each cost by `delta_e`, within what an eye sees.
#[must_use]
pub fn samples_needed(costs: &[SampleCost], delta_e: fn(&SampleCost) -> f64) -> Option<SamplesNeeded> {
    let enough = |cost: &&SampleCost| delta_e(cost) <= PERCEPTIBLE_DELTA_E;
    let fewest = costs.iter().find(enough)?.samples;
    let all_from = costs.iter().rev().take_while(enough).last()?.samples;
    Some(SamplesNeeded { fewest, all_from })
}

/// A sum over few wavelengths.
struct FewSamples {
    /// For each sample the curve's wavelength above it, the share of the way to there, and its weight.
    samples: Vec<(usize, f64, Xyz)>,
}

impl FewSamples {
    /// Nothing if on these wavelengths the light has no white.
    fn new(wavelengths_nm: &[f64], illuminant: Illuminant, samples: usize) -> Option<Self> {
        let last = wavelengths_nm.len() - 1;
        let (first_nm, width_nm) = (wavelengths_nm[0], wavelengths_nm[last] - wavelengths_nm[0]);
        let at = |sample: usize| first_nm + width_nm * sample as f64 / (samples - 1) as f64;
        let sampled_nm: Vec<f64> = (0..samples).map(at).collect();
        let colorimeter = Colorimeter::new(Observer::Cie1931, illuminant, &sampled_nm).ok()?;
        let place = |(sample_nm, weight): (&f64, &Xyz)| {
            let right = wavelengths_nm.partition_point(|known_nm| known_nm <= sample_nm).clamp(1, last);
            let (left_nm, right_nm) = (wavelengths_nm[right - 1], wavelengths_nm[right]);
            (right, (sample_nm - left_nm) / (right_nm - left_nm), *weight)
        };
        Some(Self { samples: sampled_nm.iter().zip(colorimeter.weights()).map(place).collect() })
    }

    fn xyz(&self, curve: &[f64], logarithms: &[f64]) -> Xyz {
        let term = |(right, share, weight): &(usize, f64, Xyz)| {
            // On the curve's own wavelengths its values, which may be 0.
            let value = if *share <= 0.0 {
                curve[right - 1]
            } else if *share >= 1.0 {
                curve[*right]
            } else {
                ((1.0 - share) * logarithms[right - 1] + share * logarithms[*right]).exp()
            };
            *weight * value
        };
        self.samples.iter().map(term).fold(Xyz::default(), |sum, term| sum + term)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tens() -> Vec<f64> {
        (0..31).map(|i| 400.0 + 10.0 * f64::from(i)).collect()
    }

    /// An exponential is interpolated exactly, so that the sum is the one over its values at the samples.
    #[test]
    fn sums_are_over_the_samples() {
        let passed = |nm: f64| (4.0 - nm / 100.0).exp();
        let curve: Vec<f64> = tens().into_iter().map(passed).collect();
        let logarithms: Vec<f64> = curve.iter().map(|value| value.ln()).collect();
        let found = FewSamples::new(&tens(), Illuminant::D65, 5).unwrap().xyz(&curve, &logarithms);
        let five = [400.0, 475.0, 550.0, 625.0, 700.0];
        let expected = Colorimeter::new(Observer::Cie1931, Illuminant::D65, &five).unwrap().xyz(&five.map(passed));
        let errors = [found.x - expected.x, found.y - expected.y, found.z - expected.z];
        assert!(errors.iter().all(|error| error.abs() < 1e-14), "{errors:?}");
    }

    #[test]
    fn all_wavelengths_are_enough_and_three_are_not() {
        let flat = [0.5; 31];
        let costs = sample_costs(&[&flat], &tens(), Illuminant::D65).unwrap();
        assert_eq!((costs[0].samples, costs[28].samples, costs.len()), (3, 31, 29));
        assert!(costs[0].as_it_is > PERCEPTIBLE_DELTA_E && costs[28].at_middle_grey < 1e-9, "{costs:?}");
    }

    #[test]
    fn luck_is_told_from_enough() {
        let costs: Vec<SampleCost> = [(3, 9.0), (4, 1.0), (5, 3.0), (6, 2.0), (7, 0.0)]
            .map(|(samples, delta)| SampleCost { samples, as_it_is: delta, at_middle_grey: 2.0 * delta })
            .to_vec();
        let needed = |delta_e| samples_needed(&costs, delta_e).unwrap();
        assert_eq!(needed(|cost| cost.as_it_is), SamplesNeeded { fewest: 4, all_from: 6 });
        assert_eq!(needed(|cost| cost.at_middle_grey), SamplesNeeded { fewest: 4, all_from: 7 });
        assert_eq!(samples_needed(&costs[..1], |cost| cost.as_it_is), None);
    }
}
