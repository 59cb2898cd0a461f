//! How many wavelengths a colour needs: sums over n samples in equal steps against the sum over all wavelengths of a
//! curve.
//!
//! The samples are the first wavelength, the last, and n − 2 between them. Curves are interpolated linearly in their
//! logarithm, since deep in snow light falls by a factor from one wavelength to the next; the illuminant's power is
//! interpolated linearly. Few samples change even the hue of the bare light, and miss narrow lines of a lamp, so both
//! colours are compared under the white of the full sum.

use rayon::prelude::*;
use snowblue_color::{ColorDifference, Colorimeter, Illuminant, Observer, Xyz};

use super::spread::PERCEPTIBLE_DELTA_E;
use crate::DatabaseError;

/// Smallest number of samples evaluated.
const MIN_SAMPLES: usize = 3;

/// The error of a number of samples: the largest ΔE*ab of any curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampleCost {
    /// Number of samples.
    pub samples: usize,
    /// ΔE*ab of the transmitted light.
    pub as_transmitted: f64,
    /// ΔE*ab with both colours scaled to L* = 50, as by an exposure.
    pub at_middle_grey: f64,
}

/// Numbers of samples that keep every curve's error imperceptible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SamplesNeeded {
    /// The smallest such number.
    pub fewest: usize,
    /// The smallest number from which on all are sufficient; smaller ones may be so by chance.
    pub all_from: usize,
}

/// The errors of 3, 4, … samples, up to the wavelengths of the curves, where the error is 0.
///
/// # Errors
/// If the wavelengths do not determine colours under `illuminant`.
///
/// # Panics
/// If a curve does not have one value per wavelength.
pub fn sample_costs(
    curves: &[&[f64]],
    wavelengths_nm: &[f64],
    illuminant: Illuminant,
) -> Result<Vec<SampleCost>, DatabaseError> {
    let colorimeter = Colorimeter::new(Observer::Cie1931, illuminant, wavelengths_nm)?;
    let white = colorimeter.white();
    let sums: Vec<Option<FewSamples>> = (MIN_SAMPLES..=wavelengths_nm.len())
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
    let cost = |(samples, [as_transmitted, at_middle_grey]): (usize, [f64; 2])| SampleCost {
        samples,
        as_transmitted,
        at_middle_grey,
    };
    Ok((MIN_SAMPLES..).zip(worst).map(cost).collect())
}

/// The numbers of samples whose ΔE*ab is imperceptible. `delta_e` selects the colour difference.
#[must_use]
pub fn samples_needed(costs: &[SampleCost], delta_e: fn(&SampleCost) -> f64) -> Option<SamplesNeeded> {
    let enough = |cost: &&SampleCost| delta_e(cost) <= PERCEPTIBLE_DELTA_E;
    let fewest = costs.iter().find(enough)?.samples;
    let all_from = costs.iter().rev().take_while(enough).last()?.samples;
    Some(SamplesNeeded { fewest, all_from })
}

/// A sum over few wavelengths.
struct FewSamples {
    samples: Vec<Sample>,
}

/// A sample between two wavelengths of a curve.
struct Sample {
    /// Index of the wavelength above.
    above: usize,
    /// Position between the wavelengths below and above, 0–1.
    fraction: f64,
    weight: Xyz,
}

impl FewSamples {
    /// `None` if the light has no luminance at these wavelengths.
    fn new(wavelengths_nm: &[f64], illuminant: Illuminant, samples: usize) -> Option<Self> {
        let last = wavelengths_nm.len() - 1;
        let (first_nm, width_nm) = (wavelengths_nm[0], wavelengths_nm[last] - wavelengths_nm[0]);
        let at = |sample: usize| first_nm + width_nm * sample as f64 / (samples - 1) as f64;
        let sampled_nm: Vec<f64> = (0..samples).map(at).collect();
        let colorimeter = Colorimeter::new(Observer::Cie1931, illuminant, &sampled_nm).ok()?;
        let place = |(sample_nm, weight): (&f64, &Xyz)| {
            let right = wavelengths_nm.partition_point(|known_nm| known_nm <= sample_nm).clamp(1, last);
            let (left_nm, right_nm) = (wavelengths_nm[right - 1], wavelengths_nm[right]);
            Sample { above: right, fraction: (sample_nm - left_nm) / (right_nm - left_nm), weight: *weight }
        };
        Some(Self { samples: sampled_nm.iter().zip(colorimeter.weights()).map(place).collect() })
    }

    fn xyz(&self, curve: &[f64], logarithms: &[f64]) -> Xyz {
        let term = |Sample { above, fraction, weight }: &Sample| {
            // At the curve's wavelengths values may be 0, which has no logarithm.
            let value = if *fraction <= 0.0 {
                curve[above - 1]
            } else if *fraction >= 1.0 {
                curve[*above]
            } else {
                ((1.0 - fraction) * logarithms[above - 1] + fraction * logarithms[*above]).exp()
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

    /// An exponential is interpolated exactly, so the sum is that of its values at the samples.
    #[test]
    fn sum_of_an_exponential_is_exact() {
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
    fn all_wavelengths_are_sufficient_and_three_are_not() {
        let flat = [0.5; 31];
        let costs = sample_costs(&[&flat], &tens(), Illuminant::D65).unwrap();
        assert_eq!((costs[0].samples, costs[28].samples, costs.len()), (3, 31, 29));
        assert!(costs[0].as_transmitted > PERCEPTIBLE_DELTA_E && costs[28].at_middle_grey < 1e-9, "{costs:?}");
    }

    #[test]
    fn sufficient_by_chance_differs_from_sufficient_from_then_on() {
        let costs: Vec<SampleCost> = [(3, 9.0), (4, 1.0), (5, 3.0), (6, 2.0), (7, 0.0)]
            .map(|(samples, delta)| SampleCost { samples, as_transmitted: delta, at_middle_grey: 2.0 * delta })
            .to_vec();
        let needed = |delta_e| samples_needed(&costs, delta_e).unwrap();
        assert_eq!(needed(|cost| cost.as_transmitted), SamplesNeeded { fewest: 4, all_from: 6 });
        assert_eq!(needed(|cost| cost.at_middle_grey), SamplesNeeded { fewest: 4, all_from: 7 });
        assert_eq!(samples_needed(&costs[..1], |cost| cost.as_transmitted), None);
    }
}
