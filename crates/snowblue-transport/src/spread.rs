//! The spread of reflectance, transmittance and absorptance that follows from what is not known exactly of the snow.
//!
//! Specific surface area or grain size (which scales all grains), density and mass fractions are log-normal, with the
//! given value as mean and the given standard deviation, within the ranges of the parameters; either table of ice is
//! equally likely. All are independent. [`DRAWS`] snows are a Latin hypercube (McKay, Beckman & Conover 1979,
//! doi:10.2307/1268522): each quantity takes each of as many equally probable intervals once. Their order statistics
//! are the interval. An end has a standard error of √(0.025 · 0.975/[`DRAWS`]) in probability: 1.7–3.3 % of the cases
//! lie beyond, in 2 of 3.

use snowblue_base::ParameterRange;

use crate::TransportError;
use crate::batch::{Batch, BatchError, CaseFluxes, SlabCase};
use crate::optics::{Substance, ice};
use crate::ordinates::{OrdinatesOptions, solve_batch};
use crate::parameters::{DENSITY, GRAIN_SIZE, MASS_FRACTION};
use crate::rng::Stream;
use crate::sample::{GrainSize, SizeMeasure, SnowSample, TruncatedNormal};

/// Number of snows that are drawn.
pub const DRAWS: usize = 400;

/// The part of the cases that lie below each end of an interval.
pub const ENDS: [f64; 2] = [0.025, 0.975];

/// Standard deviation of a size, relative to the greatest that is sensible.
const MOST_RELATIVE: f64 = 3.0;

/// What is not known exactly of a snow.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Uncertainty {
    /// Standard deviation of the grains' size.
    pub size: Option<SizeDeviation>,
    /// Standard deviation of the density, in kg/m³.
    pub density_kg_m3: f64,
    /// Standard deviations of mass fractions, in ng/g.
    pub mass_fractions_ng_g: Vec<(Substance, f64)>,
    /// Whether the table of ice may be the other one.
    pub ice: bool,
}

/// Standard deviation of the grains' size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SizeDeviation {
    /// Of the specific surface area, in m²/kg, of snow that is given by it.
    SurfaceArea(f64),
    /// Of the grain size, in µm.
    GrainSize(f64),
}

/// Intervals that hold 95 % of the cases.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FluxIntervals {
    /// Of the fraction that leaves the top.
    pub reflectance: [f64; 2],
    /// Of the fraction that arrives at the bottom.
    pub transmittance: [f64; 2],
    /// Of the fraction that the snow absorbs.
    pub absorptance: [f64; 2],
}

/// The interval of each case at each wavelength, the wavelength running fastest, by discrete ordinates.
///
/// `progress` is called with the number of cases that are done.
///
/// # Errors
/// As [`solve_batch`], and for a standard deviation that is out of range or has no value to belong to.
///
/// # Panics
/// If a case has a sample that is none of the samples.
pub fn solve_spread(
    batch: &Batch,
    uncertainty: &Uncertainty,
    options: &OrdinatesOptions,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<Vec<FluxIntervals>, BatchError> {
    batch.check()?;
    let cases_of = batch.cases_of_samples();
    let nothing =
        FluxIntervals { reflectance: [f64::NAN; 2], transmittance: [f64::NAN; 2], absorptance: [f64::NAN; 2] };
    let wavelengths = batch.wavelengths_nm.len();
    let mut intervals = vec![nothing; batch.cases.len() * wavelengths];
    let mut done = 0;
    for (sample, cases) in batch.samples.iter().zip(&cases_of) {
        let Some(first) = cases.first() else { continue };
        let in_case = |error| BatchError { case: Some(*first), error };
        let samples = uncertainty.draw(sample, options.seed).map_err(in_case)?;
        let drawn = |case: &usize| {
            let case = batch.cases[*case];
            (0..DRAWS).map(move |sample| SlabCase { sample, ..case })
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
                let interval = |quantity: fn(&CaseFluxes) -> f64| {
                    interval(fluxes.iter().skip(wavelength).step_by(wavelengths).map(quantity).collect())
                };
                intervals[case * wavelengths + wavelength] = FluxIntervals {
                    reflectance: interval(|at| at.reflectance.value),
                    transmittance: interval(|at| at.transmittance.value),
                    absorptance: interval(|at| at.absorptance.value),
                };
            }
        }
        done += cases.len();
        progress(done);
    }
    Ok(intervals)
}

/// The quantiles of [`ENDS`], linear between order statistics, of which the i-th of n is that of (i + ½)/n.
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
    /// [`DRAWS`] snows.
    ///
    /// # Errors
    /// If a standard deviation is out of range or has no value to belong to.
    fn draw(&self, given: &SnowSample, seed: u64) -> Result<Vec<SnowSample>, TransportError> {
        let mut samples = vec![*given; DRAWS];
        let mut quantity = 0;
        let mut permuted = || {
            quantity += 1;
            permuted(seed, quantity)
        };
        if let Some(size) = self.size {
            let relative = size.relative(given)?;
            let GrainSize { min_um, max_um, .. } = given.grain_size;
            // The factor of the surface area divides all sizes, that of a grain size multiplies them.
            let (least, greatest) = (GRAIN_SIZE.range.least / min_um, GRAIN_SIZE.range.greatest / max_um);
            let is_area = matches!(size, SizeDeviation::SurfaceArea(_));
            let (least, greatest) = if is_area { (greatest.recip(), least.recip()) } else { (least, greatest) };
            let range = ParameterRange { quantity: "factor of the size", least, greatest, unit: "" };
            let factors = log_normal(1.0, relative, &range, &permuted());
            for (sample, factor) in samples.iter_mut().zip(factors) {
                let factor = if is_area { factor.recip() } else { factor };
                sample.grain_size = GrainSize { min_um: min_um * factor, max_um: max_um * factor, ..given.grain_size };
            }
        }
        if self.density_kg_m3 != 0.0 {
            check_deviation("standard deviation of the density", self.density_kg_m3, given.density_kg_m3, "kg/m³")?;
            let densities = log_normal(given.density_kg_m3, self.density_kg_m3, &DENSITY.range, &permuted());
            samples.iter_mut().zip(densities).for_each(|(sample, density)| sample.density_kg_m3 = density);
        }
        for (substance, deviation_ng_g) in &self.mass_fractions_ng_g {
            let mean_ng_g = given.impurities.ng_g(*substance);
            if mean_ng_g <= 0.0 {
                let rule = "needs a mass fraction above 0";
                return Err(TransportError::Combination { quantity: "standard deviation of an impurity", rule });
            }
            check_deviation("standard deviation of a mass fraction", *deviation_ng_g, mean_ng_g, "ng/g")?;
            let fractions = log_normal(mean_ng_g, *deviation_ng_g, &MASS_FRACTION.range, &permuted());
            for (sample, fraction) in samples.iter_mut().zip(fractions) {
                sample.impurities = sample.impurities.with(*substance, fraction);
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

impl SizeDeviation {
    /// The standard deviation over the value.
    fn relative(self, sample: &SnowSample) -> Result<f64, TransportError> {
        let GrainSize { min_um, max_um, measure } = sample.grain_size;
        match self {
            Self::GrainSize(deviation_um) => {
                let mean_um = sample.grain_size.middle_um();
                check_deviation("standard deviation of the grain size", deviation_um, mean_um, "µm")?;
                Ok(deviation_um / mean_um)
            }
            Self::SurfaceArea(deviation_m2_kg) if measure == SizeMeasure::OpticalDiameter && min_um >= max_um => {
                let mean_m2_kg = 6e6 / (ice::density_kg_m3(sample.temperature_c) * max_um);
                let quantity = "standard deviation of the specific surface area";
                check_deviation(quantity, deviation_m2_kg, mean_m2_kg, "m²/kg")?;
                Ok(deviation_m2_kg / mean_m2_kg)
            }
            Self::SurfaceArea(_) => Err(TransportError::Combination {
                quantity: "standard deviation of the specific surface area",
                rule: "needs snow that is given by its specific surface area",
            }),
        }
    }
}

fn check_deviation(
    quantity: &'static str,
    deviation: f64,
    mean: f64,
    unit: &'static str,
) -> Result<(), TransportError> {
    Ok(ParameterRange { quantity, least: 0.0, greatest: MOST_RELATIVE * mean, unit }.check(deviation)?)
}

/// One uniform number in each of [`DRAWS`] intervals of (0, 1), in random order: a column of a Latin hypercube.
fn permuted(seed: u64, quantity: u64) -> Vec<f64> {
    // The inverted seed makes the stream independent of those of rays.
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
    use crate::slab::Incidence;

    fn soot(deviation: f64) -> Uncertainty {
        Uncertainty { mass_fractions_ng_g: vec![(Substance::BlackCarbon, deviation)], ..Uncertainty::default() }
    }

    fn snow() -> SnowSample {
        let mut snow = SnowSample {
            grain_size: GrainSize::from_specific_surface_area(20.0, -5.0).unwrap(),
            ..SnowSample::default()
        };
        snow.impurities = snow.impurities.with(Substance::BlackCarbon, 10.0);
        snow
    }

    /// Moments of the draws: a Latin hypercube has the mean of a single quantity to much less than its deviation/√n.
    #[test]
    fn draws_have_the_given_mean_and_deviation() {
        let all =
            Uncertainty { size: Some(SizeDeviation::SurfaceArea(2.0)), density_kg_m3: 30.0, ice: true, ..soot(5.0) };
        let drawn = all.draw(&snow(), 1).unwrap();
        let area = |sample: &SnowSample| 20.0 * snow().grain_size.max_um / sample.grain_size.max_um;
        let size_um = snow().grain_size.middle_um();
        let by_size = Uncertainty { size: Some(SizeDeviation::GrainSize(0.3 * size_um)), ..Uncertainty::default() };
        let sizes = by_size.draw(&snow(), 1).unwrap().into_iter().map(|sample| sample.grain_size.middle_um()).collect();
        for (values, mean, deviation) in [
            (drawn.iter().map(area).collect::<Vec<_>>(), 20.0, 2.0),
            (sizes, size_um, 0.3 * size_um),
            (drawn.iter().map(|sample| sample.density_kg_m3).collect(), 300.0, 30.0),
            (drawn.iter().map(|sample| sample.impurities.ng_g(Substance::BlackCarbon)).collect(), 10.0, 5.0),
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

    /// Of one quantity on which the result depends monotonically, the interval is the result at that of the quantity.
    #[test]
    fn the_interval_of_one_quantity_is_that_of_its_ends() {
        let case = |sample| SlabCase { sample, thickness_cm: 20.0, incidence: Incidence::Diffuse, ground_albedo: 0.0 };
        let options = OrdinatesOptions { tally_rays: 1 << 12, ..OrdinatesOptions::default() };
        let batch = Batch { samples: vec![snow()], cases: vec![case(0)], wavelengths_nm: vec![450.0, 700.0] };
        let spread = solve_spread(&batch, &soot(5.0), &options, &|_| ()).unwrap();
        // The log-normal distribution of mean 10 and deviation 5, 1.96 deviations of the logarithm from its median.
        let deviation = 1.25_f64.ln().sqrt();
        let median = 10.0 / 1.25_f64.sqrt();
        let ends = [-1.0, 1.0].map(|sign| median * (sign * 1.959_964 * deviation).exp());
        let of = |ng_g: f64| SnowSample { impurities: snow().impurities.with(Substance::BlackCarbon, ng_g), ..snow() };
        let at_ends = Batch { samples: ends.map(of).to_vec(), cases: vec![case(0), case(1)], ..batch };
        let solved = solve_batch(&at_ends, &options, false, &|_| ()).unwrap();
        for (wavelength, interval) in spread.iter().enumerate() {
            let (low, high) = (&solved[wavelength], &solved[2 + wavelength]);
            let width = low.transmittance.value - high.transmittance.value;
            // Within a cell of the hypercube, 1/400 of the probability, which is a tenth of that beyond an end.
            assert!((interval.transmittance[1] - low.transmittance.value).abs() < 0.02 * width, "{interval:?}");
            assert!((interval.transmittance[0] - high.transmittance.value).abs() < 0.02 * width, "{interval:?}");
            assert!(interval.absorptance[0] < interval.absorptance[1]);
        }
    }

    #[test]
    fn deviations_need_a_value() {
        let message =
            |uncertainty: Uncertainty, sample: &SnowSample| uncertainty.draw(sample, 1).unwrap_err().to_string();
        let size = |size| Uncertainty { size: Some(size), ..Uncertainty::default() };
        assert!(message(soot(5.0), &SnowSample::default()).contains("needs a mass fraction above 0"));
        assert!(
            message(size(SizeDeviation::SurfaceArea(2.0)), &SnowSample::default()).contains("needs snow that is given")
        );
        let message = message(size(SizeDeviation::GrainSize(-1.0)), &snow());
        assert!(message.starts_with("standard deviation of the grain size is -1 µm, but must lie in 0–"), "{message}");
    }
}
