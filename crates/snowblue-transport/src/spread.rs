//! Spread of reflectance, transmittance and absorptance that follows from uncertain properties of the snow.
//!
//! Uncertain properties have log-normal distributions within their ranges, with the given value as mean and the given
//! standard deviation: specific surface area or grain size (which scales all grains), density, water saturation and
//! mass fractions. Both tables of ice are equally likely. All uncertain quantities are independent. The [`DRAWS`]
//! snows form a Latin hypercube (McKay, Beckman & Conover 1979, doi:10.2307/1268522): each quantity takes each of
//! [`DRAWS`] equally probable intervals once. The interval of a flux follows from the order statistics of the snows.
//! An end of this interval has a standard error of √(0.025 · 0.975/[`DRAWS`]) in probability: in 2 of 3 computations,
//! 1.7–3.3 % of the possible values lie beyond an end.

use snowblue_base::ParameterRange;

use crate::TransportError;
use crate::batch::{Batch, BatchError, SlabCase};
use crate::optics::ice;
use crate::ordinates::{OrdinatesOptions, solve_batch};
use crate::parameters::GRAIN_SIZE;
use crate::rng::Stream;
use crate::sample::{GrainSize, Property, SizeMeasure, SnowSample, TruncatedNormal};
use crate::slab::{Estimate, Fluxes};

/// Number of snows that are drawn.
pub const DRAWS: usize = 400;

/// Fraction of the possible values that lies below each end of an interval.
pub const ENDS: [f64; 2] = [0.025, 0.975];

/// Greatest standard deviation of a property, relative to its mean.
const MAX_RELATIVE: f64 = 3.0;

/// Uncertain properties of a snow.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Uncertainty {
    /// Standard deviations of properties, each in its unit. A standard deviation of the specific surface area needs
    /// snow that is given by its specific surface area.
    pub deviations: Vec<(Property, f64)>,
    /// Whether the table of ice is uncertain.
    pub ice: bool,
}

/// The intervals that hold 95 % of the possible values, for each case at each wavelength, by discrete ordinates. The
/// wavelength varies fastest.
///
/// `progress` is called with the number of cases that are done.
///
/// # Errors
/// As [`solve_batch`], and for a standard deviation that is out of range or belongs to a property without a value.
///
/// # Panics
/// If a case refers to a sample that does not exist.
pub fn solve_spread(
    batch: &Batch,
    uncertainty: &Uncertainty,
    options: &OrdinatesOptions,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<Vec<Fluxes<[f64; 2]>>, BatchError> {
    batch.check()?;
    let cases_of = batch.cases_of_samples();
    let nothing = Fluxes::from([[f64::NAN; 2]; 3]);
    let wavelengths = batch.wavelengths_nm.len();
    let mut intervals = vec![nothing; batch.cases.len() * wavelengths];
    let mut done = 0;
    for (sample, cases) in batch.samples.iter().zip(&cases_of) {
        let Some(first) = cases.first() else { continue };
        let in_case = |error| BatchError { case: Some(*first), error };
        let samples = uncertainty.draw(sample, options.seed).map_err(in_case)?;
        let drawn = |case: &usize| {
            let case = &batch.cases[*case];
            (0..DRAWS).map(move |sample| SlabCase { sample, ..case.clone() })
        };
        let drawn = Batch {
            samples,
            cases: cases.iter().flat_map(drawn).collect(),
            wavelengths_nm: batch.wavelengths_nm.clone(),
        };
        let solved = solve_batch(&drawn, options, false, &|_| ());
        let solved =
            solved.map_err(|wrong| BatchError { case: wrong.case.map(|case| cases[case / DRAWS]), ..wrong })?;
        for (case, fluxes) in cases.iter().zip(solved.chunks_exact(DRAWS * wavelengths)) {
            for wavelength in 0..wavelengths {
                let at = || fluxes.iter().skip(wavelength).step_by(wavelengths);
                let quantities: [fn(&Fluxes) -> Estimate; 3] =
                    [|at| at.reflectance, |at| at.transmittance, |at| at.absorptance];
                intervals[case * wavelengths + wavelength] =
                    quantities.map(|quantity| interval(at().map(|at| quantity(at).value).collect())).into();
            }
        }
        done += cases.len();
        progress(done);
    }
    Ok(intervals)
}

/// The quantiles at the probabilities [`ENDS`], linear between order statistics. The i-th of n order statistics has
/// the probability (i + ½)/n.
fn interval(mut values: Vec<f64>) -> [f64; 2] {
    values.sort_by(f64::total_cmp);
    ENDS.map(|probability| {
        let place = (probability * values.len() as f64 - 0.5).clamp(0.0, values.len() as f64 - 1.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 ≤ place < length")]
        let below = place as usize;
        let above = (below + 1).min(values.len() - 1);
        values[below] + (place - below as f64) * (values[above] - values[below])
    })
}

impl Uncertainty {
    /// The properties that may have a standard deviation: positive numbers, and the size of the grains.
    pub fn properties() -> impl Iterator<Item = Property> {
        let others = [Property::Facetness, Property::Sphericity];
        Property::all().filter(move |one| !others.contains(one) && one.parameter().range.least >= 0.0)
    }

    /// [`DRAWS`] snows.
    ///
    /// # Errors
    /// If a standard deviation is out of range or belongs to a property without a value.
    fn draw(&self, given: &SnowSample, seed: u64) -> Result<Vec<SnowSample>, TransportError> {
        let mut samples = vec![*given; DRAWS];
        let mut quantity = 0;
        let mut permuted = || {
            quantity += 1;
            permuted(seed, quantity)
        };
        let mut deviations = self.deviations.clone();
        // The order determines the random numbers of each property.
        deviations.sort_by_key(|(property, _)| match property {
            Property::GrainSize | Property::SurfaceArea => 0,
            Property::Density => 1,
            _ => 2,
        });
        for (property, deviation) in deviations {
            let GrainSize { min_um, max_um, .. } = given.grain_size;
            let mean = mean(property, given)?;
            let range = property.parameter().range;
            let deviations = ParameterRange { least: 0.0, greatest: MAX_RELATIVE * mean, ..range };
            deviations.check(deviation).map_err(|error| TransportError::Deviation { error })?;
            if !matches!(property, Property::GrainSize | Property::SurfaceArea) {
                let values = log_normal(mean, deviation, &range, &permuted());
                samples.iter_mut().zip(values).for_each(|(sample, value)| property.set(sample, value));
                continue;
            }
            // The factor of the surface area divides all sizes; the factor of a grain size multiplies all sizes.
            let (least, greatest) = (GRAIN_SIZE.range.least / min_um, GRAIN_SIZE.range.greatest / max_um);
            let is_area = property == Property::SurfaceArea;
            let (least, greatest) = if is_area { (greatest.recip(), least.recip()) } else { (least, greatest) };
            let range = ParameterRange::new("factor of the size", least, greatest, "");
            for (sample, factor) in samples.iter_mut().zip(log_normal(1.0, deviation / mean, &range, &permuted())) {
                let factor = if is_area { factor.recip() } else { factor };
                sample.grain_size = GrainSize { min_um: min_um * factor, max_um: max_um * factor, ..given.grain_size };
            }
        }
        if self.ice {
            for (sample, uniform) in samples.iter_mut().zip(permuted()) {
                if uniform < 0.5 {
                    sample.ice = sample.ice.other();
                }
            }
        }
        Ok(samples)
    }
}

/// The value of a property that has a standard deviation.
fn mean(property: Property, sample: &SnowSample) -> Result<f64, TransportError> {
    let GrainSize { min_um, max_um, measure } = sample.grain_size;
    let needs = |rule| {
        let quantity = property.parameter().range.quantity;
        Err(TransportError::Combination { quantity, rule })
    };
    match property {
        Property::SurfaceArea if measure != SizeMeasure::OpticalDiameter || min_um < max_um => {
            needs("needs snow that is given by it to have a standard deviation")
        }
        Property::SurfaceArea => Ok(6e6 / (ice::density_kg_m3(sample.temperature_c) * max_um)),
        _ if property.get(sample) <= 0.0 => needs("needs a value above 0 to have a standard deviation"),
        _ => Ok(property.get(sample)),
    }
}

/// One uniform number in each of [`DRAWS`] intervals of (0, 1), in random order: a column of a Latin hypercube.
fn permuted(seed: u64, quantity: u64) -> Vec<f64> {
    // The inverted seed makes the stream independent of the streams of rays.
    let mut stream = Stream::new(!seed, quantity);
    let mut uniforms: Vec<f64> = (0..DRAWS).map(|cell| (cell as f64 + stream.uniform()) / DRAWS as f64).collect();
    for end in (1..DRAWS).rev() {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 ≤ place ≤ end")]
        let place = ((end + 1) as f64 * stream.uniform()) as usize;
        uniforms.swap(end, place.min(end));
    }
    uniforms
}

/// The quantiles of a log-normal distribution with this mean and standard deviation, truncated to a range.
fn log_normal(mean: f64, deviation: f64, range: &ParameterRange, uniforms: &[f64]) -> Vec<f64> {
    let variance = (deviation / mean).powi(2).ln_1p();
    let normal = TruncatedNormal {
        min: range.least.ln(),
        max: range.greatest.ln(),
        mean: mean.ln() - 0.5 * variance,
        standard_deviation: variance.sqrt(),
    };
    if variance <= 0.0 {
        return vec![mean; uniforms.len()];
    }
    let quantiles = normal.weighted(|_| 1.0);
    uniforms.iter().map(|uniform| quantiles.at(*uniform).exp()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Substance;
    use crate::slab::Incidence;

    fn soot(deviation: f64) -> Uncertainty {
        of(Property::Impurity(Substance::BLACK_CARBON), deviation)
    }

    fn of(property: Property, deviation: f64) -> Uncertainty {
        Uncertainty { deviations: vec![(property, deviation)], ice: false }
    }

    fn snow() -> SnowSample {
        let mut snow = SnowSample {
            grain_size: GrainSize::from_specific_surface_area(20.0, -5.0).unwrap(),
            ..SnowSample::default()
        };
        snow.impurities = snow.impurities.with(Substance::BLACK_CARBON, 10.0);
        snow
    }

    /// Moments of the draws: a Latin hypercube has the mean of a single quantity to much less than its deviation/√n.
    #[test]
    fn draws_have_the_given_mean_and_deviation() {
        let others = [(Property::SurfaceArea, 2.0), (Property::Density, 30.0)];
        let all = Uncertainty { deviations: [&soot(5.0).deviations[..], &others].concat(), ice: true };
        let drawn = all.draw(&snow(), 1).unwrap();
        let area = |sample: &SnowSample| 20.0 * snow().grain_size.max_um / sample.grain_size.max_um;
        let size_um = snow().grain_size.middle_um();
        let by_size = of(Property::GrainSize, 0.3 * size_um);
        let sizes = by_size.draw(&snow(), 1).unwrap().into_iter().map(|sample| sample.grain_size.middle_um()).collect();
        for (values, mean, deviation) in [
            (drawn.iter().map(area).collect::<Vec<_>>(), 20.0, 2.0),
            (sizes, size_um, 0.3 * size_um),
            (drawn.iter().map(|sample| sample.density_kg_m3).collect(), 300.0, 30.0),
            (drawn.iter().map(|sample| sample.impurities.ng_g(Substance::BLACK_CARBON)).collect(), 10.0, 5.0),
        ] {
            let found = values.iter().sum::<f64>() / DRAWS as f64;
            let variance = values.iter().map(|value| (value - found).powi(2)).sum::<f64>() / DRAWS as f64;
            assert!((found - mean).abs() < 0.01 * deviation, "{found}");
            // The last cell of the heavy tail of soot varies most.
            assert!((variance.sqrt() / deviation - 1.0).abs() < 0.03, "{}", variance.sqrt());
        }
        assert_eq!(drawn.iter().filter(|sample| sample.ice == snow().ice).count(), DRAWS / 2);
        assert!(drawn.iter().all(|sample| sample.check().is_ok()));
    }

    /// If one quantity is uncertain and the result is monotonic in it, the ends of the interval are the results at
    /// the ends of the interval of the quantity.
    #[test]
    fn the_interval_of_one_quantity_is_that_of_its_ends() {
        let case =
            |sample| SlabCase { sample, thickness_cm: 20.0, incidence: Incidence::Diffuse, ground_albedo: 0.0.into() };
        let options = OrdinatesOptions { tally_rays: 1 << 12, ..OrdinatesOptions::default() };
        let batch = Batch { samples: vec![snow()], cases: vec![case(0)], wavelengths_nm: vec![450.0, 700.0] };
        let spread = solve_spread(&batch, &soot(5.0), &options, &|_| ()).unwrap();
        // The log-normal distribution of mean 10 and deviation 5, 1.96 deviations of the logarithm from its median.
        let deviation = 1.25_f64.ln().sqrt();
        let median = 10.0 / 1.25_f64.sqrt();
        let ends = [-1.0, 1.0].map(|sign| median * (sign * 1.959_964 * deviation).exp());
        let with =
            |ng_g: f64| SnowSample { impurities: snow().impurities.with(Substance::BLACK_CARBON, ng_g), ..snow() };
        let at_ends = Batch { samples: ends.map(with).to_vec(), cases: vec![case(0), case(1)], ..batch };
        let solved = solve_batch(&at_ends, &options, false, &|_| ()).unwrap();
        for (wavelength, interval) in spread.iter().enumerate() {
            let (low, high) = (&solved[wavelength], &solved[2 + wavelength]);
            let width = low.transmittance.value - high.transmittance.value;
            // Within a cell of the hypercube: its probability of 1/400 is a tenth of the probability beyond an end.
            assert!((interval.transmittance[1] - low.transmittance.value).abs() < 0.02 * width, "{interval:?}");
            assert!((interval.transmittance[0] - high.transmittance.value).abs() < 0.02 * width, "{interval:?}");
            assert!(interval.absorptance[0] < interval.absorptance[1]);
        }
    }

    #[test]
    fn deviations_need_a_value() {
        let message =
            |uncertainty: Uncertainty, sample: &SnowSample| uncertainty.draw(sample, 1).unwrap_err().to_string();
        let clean = SnowSample::default();
        assert!(message(soot(5.0), &clean).contains("black-carbon needs a value above 0"));
        assert!(message(of(Property::SurfaceArea, 2.0), &clean).contains("needs snow that is given by it"));
        let message = message(of(Property::GrainSize, -1.0), &snow());
        assert!(message.starts_with("the standard deviation of grain size is -1 µm, but must lie in 0–"), "{message}");
    }
}
