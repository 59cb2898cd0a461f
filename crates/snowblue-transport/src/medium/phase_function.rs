//! The phase function of a sample: the distribution of the directions into which its scatterers turn light.
//!
//! Its integral is 1, also of the light that absorbing grains scatter ([`PhaseFunction::of_scattered_light`]):
//!
//! ```text
//! ∫ p dΩ = 1,   g = ∫ p cos Θ dΩ,   χ_l = ∫ p P_l(cos Θ) dΩ   (Chandrasekhar 1960, §3, with his p over 4π).
//! ```
//!
//! Grains in air, grains in water and particles count by their scattering coefficients. Rays through random grains are
//! counted in bins of equal width in u = sin Θ/2 = √((1 − cos Θ)/2), which are narrow in the forward direction, where
//! phase functions of grains are steep. With cos Θ = 1 − 2u², the solid angle is dΩ = 2π d(cos Θ) = 8π u du. p is
//! linear in u between the middles of the bins. Bins blur p a little; a factor A + B u² restores the norm and the
//! asymmetry of the rays themselves.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::constituents::{Constituents, Grains};
use super::population::Population;
use super::tally::{MAX_RAYS_PER_BATCH, scramble};
use crate::TransportError;
use crate::quadrature::{Quadrature, legendre_polynomials};
use crate::rng::Stream;
use crate::sample::SnowSample;

const BINS: AngleBins = AngleBins(256);
/// Cells of the inverse distribution.
const QUANTILES: usize = 1 << 12;
/// Cells of each half of a bin in which the inverse distribution takes p as constant.
const CELLS_PER_HALF_BIN: usize = 16;
/// Rays per task.
const RAYS_PER_TASK: u32 = 1 << 13;

/// A number of bins of equal width in u.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct AngleBins(pub(crate) usize);

/// u = sin Θ/2 of a scattering angle.
#[inline]
pub(crate) fn half_angle_sine(cos_scattering: f64) -> f64 {
    (0.5 * (1.0 - cos_scattering)).max(0.0).sqrt()
}

impl AngleBins {
    /// The bin of an angle.
    #[inline]
    pub(crate) fn bin(self, cos_scattering: f64) -> usize {
        let position = half_angle_sine(cos_scattering) * self.0 as f64;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0 ≤ position, clamped to the last bin"
        )]
        let bin = (position as usize).min(self.0 - 1);
        bin
    }

    /// Solid angle of a bin, 4π (u₂² − u₁²), in sr.
    pub(crate) fn solid_angle_sr(self, bin: usize) -> f64 {
        let (first, last) = (bin as f64 / self.0 as f64, (bin + 1) as f64 / self.0 as f64);
        4.0 * PI * (last * last - first * first)
    }
}

/// A phase function of random orientation, tabulated.
#[derive(Debug, Clone, PartialEq)]
pub struct PhaseFunction {
    /// p at the middles of the bins, in 1/sr.
    per_sr: Vec<f64>,
    asymmetry: f64,
    /// cos Θ at equal steps of the probability of a smaller angle.
    cosines: Vec<f64>,
}

/// Options of a phase function of grains.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PhasePlan {
    /// Rays through grains.
    pub rays: u32,
    /// Seed of all randomness.
    pub seed: u64,
}

impl Default for PhasePlan {
    /// 1 − g has a standard error of 0.3 % in dry and 0.5 % in wet snow, and p of 15 % in a single bin behind the
    /// grain.
    fn default() -> Self {
        Self { rays: 1 << 16, seed: 1 }
    }
}

/// Sums over rays, weighted by the projected area of the grains.
struct RaySums {
    /// Of the light that is not absorbed.
    bins: Vec<f64>,
    cosine: f64,
    kept: f64,
    /// Of all light.
    weight: f64,
}

impl RaySums {
    fn new() -> Self {
        Self { bins: vec![0.0; BINS.0], cosine: 0.0, kept: 0.0, weight: 0.0 }
    }
}

impl PhaseFunction {
    /// The phase function of scattering by the grains and particles of a sample, as if ice did not absorb, from rays
    /// through random grains.
    ///
    /// Grains send most light forward, the more so in water, whose refractive index is close to the index of ice:
    /// ```
    /// # use snowblue_transport::{PhaseFunction, PhasePlan, SnowSample};
    /// let plan = PhasePlan { rays: 1 << 12, seed: 1 };
    /// let dry = PhaseFunction::of_sample(&SnowSample::default(), 550.0, &plan)?;
    /// let soaked = SnowSample { water_saturation: 1.0, ..SnowSample::default() };
    /// let soaked = PhaseFunction::of_sample(&soaked, 550.0, &plan)?;
    /// assert!(dry.asymmetry() > 0.65 && soaked.asymmetry() > 0.99);
    /// # Ok::<(), snowblue_transport::TransportError>(())
    /// ```
    ///
    /// # Errors
    /// If a parameter of the sample is out of range, or the tables do not cover the wavelength.
    pub fn of_sample(sample: &SnowSample, wavelength_nm: f64, plan: &PhasePlan) -> Result<Self, TransportError> {
        sample.check()?;
        sample.check_wavelength(wavelength_nm)?;
        Ok(Self::with_absorption(sample, wavelength_nm, plan, 0.0))
    }

    /// The phase function of the light that grains and particles scatter and do not absorb.
    ///
    /// # Panics
    /// If the sample or the wavelength is out of range.
    pub(crate) fn of_scattered_light(sample: &SnowSample, wavelength_nm: f64, plan: &PhasePlan) -> Self {
        Self::with_absorption(sample, wavelength_nm, plan, 1.0)
    }

    /// The phase function with absorption by the ice times a factor.
    fn with_absorption(sample: &SnowSample, wavelength_nm: f64, plan: &PhasePlan, factor: f64) -> Self {
        let constituents = Constituents::new(sample, wavelength_nm);
        let population = Population::of_sample(sample);
        let total_per_m = constituents.scatterer_extinction_per_m();
        let (mut per_sr, mut scattered, mut along) = (vec![0.0; BINS.0], 0.0, 0.0);
        let present = |grains: &Grains| grains.extinction_per_m > 0.0;
        let kinds: Vec<Grains> =
            [constituents.in_air, constituents.in_water].into_iter().filter(|grains| present(grains)).collect();
        for grains in &kinds {
            let share = PhasePlan { rays: plan.rays.div_ceil(if kinds.len() > 1 { 2 } else { 1 }), ..*plan };
            let absorption_per_m = factor * grains.absorption_per_m;
            let sizes: Vec<(f64, f64)> = sample.grain_size.by_area_um().collect();
            let kept = |ice_path: f64| {
                let optical_path = absorption_per_m * 1e-6 * ice_path;
                sizes.iter().map(|(size_um, weight)| weight * (-optical_path * size_um).exp()).sum()
            };
            let sums = trace(&population, grains.relative_index, &share, kept);
            let fraction = grains.extinction_per_m / total_per_m / sums.weight;
            scattered += fraction * sums.kept;
            along += fraction * sums.cosine;
            for (bin, (value, sum)) in per_sr.iter_mut().zip(&sums.bins).enumerate() {
                *value += fraction * sum / BINS.solid_angle_sr(bin);
            }
        }
        for particle in &constituents.particles {
            let fraction = particle.scattering_per_m / total_per_m;
            scattered += fraction;
            along += fraction * particle.asymmetry;
            for (bin, value) in per_sr.iter_mut().enumerate() {
                *value += fraction * henyey_greenstein_per_sr(particle.asymmetry, cosine(middle(bin)));
            }
        }
        Self::new(per_sr, along / scattered)
    }

    /// The phase function of Henyey & Greenstein (1941), (1 − g²)/(1 + g² − 2g cos Θ)^{3/2}/4π.
    ///
    /// The bins resolve it for g between −0.98 and 0.98.
    #[must_use]
    pub fn henyey_greenstein(asymmetry: f64) -> Self {
        let values = (0..BINS.0).map(|bin| henyey_greenstein_per_sr(asymmetry, cosine(middle(bin))));
        Self::new(values.collect(), asymmetry)
    }

    /// Equal scattering into all directions.
    #[must_use]
    pub fn isotropic() -> Self {
        Self::henyey_greenstein(0.0)
    }

    /// The phase function p(Θ), in 1/sr, for the cosine of a scattering angle.
    #[inline]
    #[must_use]
    pub fn per_sr(&self, cos_scattering: f64) -> f64 {
        interpolate(&self.per_sr, half_angle_sine(cos_scattering))
    }

    /// Asymmetry parameter g, the mean cosine of the scattering angle.
    #[must_use]
    pub fn asymmetry(&self) -> f64 {
        self.asymmetry
    }

    /// The phase function with another asymmetry, near its own: p times A + B u², which keeps the norm. This gives
    /// the phase function the asymmetry of a medium from more rays.
    #[must_use]
    pub fn with_asymmetry(self, asymmetry: f64) -> Self {
        Self::new(self.per_sr, asymmetry)
    }

    /// The Legendre moments χ_0 = 1, χ_1 = g, … χ_`degree`, for degrees up to some 256.
    #[must_use]
    pub fn moments(&self, degree: usize) -> Vec<f64> {
        let (mut moments, mut polynomials) = (vec![0.0; degree + 1], vec![0.0; degree + 1]);
        for (cos_scattering, fraction) in fractions(&self.per_sr) {
            legendre_polynomials(cos_scattering, &mut polynomials);
            for (moment, polynomial) in moments.iter_mut().zip(&polynomials) {
                *moment += fraction * polynomial;
            }
        }
        moments
    }

    /// The cosine of a random scattering angle for a uniform number in 0–1.
    #[inline]
    #[must_use]
    pub fn sample_cos(&self, number: f64) -> f64 {
        let position = number * QUANTILES as f64;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number in 0–1")]
        let cell = (position as usize).min(QUANTILES - 1);
        let (first, last) = (self.cosines[cell], self.cosines[cell + 1]);
        first + (position - cell as f64) * (last - first)
    }

    /// Multiplies values at the middles of the bins by A + B u² for the norm 1 and the given asymmetry.
    ///
    /// The asymmetry of a peak within one bin cannot be changed: the peak keeps the asymmetry that the bin gives.
    fn new(mut per_sr: Vec<f64>, asymmetry: f64) -> Self {
        let tilted: Vec<f64> = per_sr.iter().enumerate().map(|(bin, value)| value * middle(bin).powi(2)).collect();
        // ∫ p dΩ and ∫ p (1 − cos Θ) dΩ.
        let integrals = |values: &[f64]| {
            fractions(values).fold((0.0, 0.0), |(sum, back), (cosine, part)| (sum + part, back + part * (1.0 - cosine)))
        };
        let ((sum, back), (tilted_sum, tilted_back)) = (integrals(&per_sr), integrals(&tilted));
        let determinant = sum * tilted_back - back * tilted_sum;
        let level = (tilted_back - tilted_sum * (1.0 - asymmetry)) / determinant;
        let tilt = (sum * (1.0 - asymmetry) - back) / determinant;
        let (level, tilt) =
            if level > 0.0 && level + tilt > 0.0 && tilt.is_finite() { (level, tilt) } else { (1.0 / sum, 0.0) };
        for (value, tilted) in per_sr.iter_mut().zip(&tilted) {
            *value = level * *value + tilt * tilted;
        }
        let asymmetry = 1.0 - (level * back + tilt * tilted_back);
        let cosines = inverse_distribution(&per_sr);
        Self { per_sr, asymmetry, cosines }
    }
}

/// Traces rays through random grains of one relative index, which keep a fraction of the light by its path through ice.
fn trace(population: &Population, relative_index: f64, plan: &PhasePlan, kept: impl Fn(f64) -> f64 + Sync) -> RaySums {
    let tasks: Vec<u32> = (0..plan.rays.max(1)).step_by(RAYS_PER_TASK as usize).collect();
    let task = |first: u32| {
        let mut sums = RaySums::new();
        let batch = first / MAX_RAYS_PER_BATCH;
        let scramble = scramble(plan.seed, batch as usize);
        for ray in first..(first + RAYS_PER_TASK).min(plan.rays.max(1)) {
            let mut stream = Stream::on_sequence(plan.seed, ray.into(), ray % MAX_RAYS_PER_BATCH, scramble);
            let (scattered, weight) = population.scatter(relative_index, &mut stream);
            let part = weight * kept(scattered.ice_path);
            sums.bins[BINS.bin(scattered.cos_scattering)] += part;
            sums.cosine += part * scattered.cos_scattering;
            sums.kept += part;
            sums.weight += weight;
        }
        sums
    };
    let parts: Vec<RaySums> = tasks.into_par_iter().map(task).collect();
    let mut sums = RaySums::new();
    for part in parts {
        sums.bins.iter_mut().zip(&part.bins).for_each(|(sum, term)| *sum += term);
        sums.cosine += part.cosine;
        sums.kept += part.kept;
        sums.weight += part.weight;
    }
    sums
}

fn henyey_greenstein_per_sr(g: f64, cos_scattering: f64) -> f64 {
    (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cos_scattering).powf(1.5))
}

/// u at the middle of a bin.
fn middle(bin: usize) -> f64 {
    (bin as f64 + 0.5) / BINS.0 as f64
}

/// cos Θ = 1 − 2u².
fn cosine(u: f64) -> f64 {
    1.0 - 2.0 * u * u
}

/// Linear in u between the middles of the bins, constant beyond the first and the last.
#[inline]
fn interpolate(values: &[f64], u: f64) -> f64 {
    let position = (u * BINS.0 as f64 - 0.5).clamp(0.0, (BINS.0 - 1) as f64);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 ≤ position ≤ 255")]
    let bin = (position as usize).min(BINS.0 - 2);
    values[bin] + (position - bin as f64) * (values[bin + 1] - values[bin])
}

/// cos Θ and p dΩ at three Gauss nodes in each half of a bin, where p is linear: exact for the norm and the asymmetry.
fn fractions(values: &[f64]) -> impl Iterator<Item = (f64, f64)> {
    let rule = Quadrature::half_range(3);
    let width = 0.5 / BINS.0 as f64;
    let nodes = move |half| rule.cosines.iter().zip(&rule.weights).map(move |(x, w)| ((half as f64 + x) * width, w));
    (0..2 * BINS.0)
        .flat_map(nodes)
        .map(move |(u, weight)| (cosine(u), interpolate(values, u) * 8.0 * PI * u * weight * width))
}

/// cos Θ at equal steps of the probability of a smaller angle. Within a small cell p is constant, so the probability is
/// linear in cos Θ.
fn inverse_distribution(per_sr: &[f64]) -> Vec<f64> {
    let cells = 2 * CELLS_PER_HALF_BIN * BINS.0;
    let at = |cell: f64| cell / cells as f64;
    let probability = |cell: usize| {
        let middle = cell as f64 + 0.5;
        interpolate(per_sr, at(middle)) * 8.0 * PI * at(middle) / cells as f64
    };
    let total: f64 = (0..cells).map(probability).sum();
    let mut cosines = Vec::with_capacity(QUANTILES + 1);
    let mut below = 0.0;
    for cell in 0..cells {
        let (first, last) = (cosine(at(cell as f64)), cosine(at((cell + 1) as f64)));
        let within = probability(cell) / total;
        while cosines.len() < QUANTILES && cosines.len() as f64 <= (below + within) * QUANTILES as f64 {
            let part = ((cosines.len() as f64 / QUANTILES as f64 - below) / within).clamp(0.0, 1.0);
            // A cell without probability adds no angle.
            cosines.push(if within > 0.0 { first + part * (last - first) } else { first });
        }
        below += within;
    }
    let last = (0..cells).rfind(|cell| probability(*cell) > 0.0).unwrap_or(0);
    cosines.resize(QUANTILES + 1, cosine(at((last + 1) as f64)));
    cosines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::LANES;
    use crate::medium::{Composition, directions};
    use crate::{Demand, GrainTallies, Impurities, Substance, TallyPlan};

    #[test]
    fn bins_cover_the_sphere_and_contain_their_angles() {
        let bins = AngleBins(128);
        let sphere_sr: f64 = (0..128).map(|bin| bins.solid_angle_sr(bin)).sum();
        assert!((sphere_sr - 4.0 * PI).abs() < 1e-13);
        assert!((bins.bin(1.0), bins.bin(-1.0)) == (0, 127));
        // u² = 1/4 at 60°.
        assert!(bins.bin(0.5 + 1e-9) == 63 && bins.bin(0.5 - 1e-9) == 64);
    }

    fn samples() -> [SnowSample; 3] {
        let wet = SnowSample { water_saturation: 0.3, ..SnowSample::default() };
        let impurities = Impurities::none().with(Substance::BLACK_CARBON, 1e6);
        [SnowSample::default(), wet, SnowSample { impurities, ..SnowSample::default() }]
    }

    fn functions() -> Vec<PhaseFunction> {
        let plan = PhasePlan { rays: 1 << 14, seed: 3 };
        let grains = samples().map(|sample| PhaseFunction::of_sample(&sample, 500.0, &plan).unwrap());
        let formulas = [-0.4, 0.0, 0.7, 0.95].map(PhaseFunction::henyey_greenstein);
        grains.into_iter().chain(formulas).collect()
    }

    /// By the midpoint rule in Θ, which does not depend on the bins.
    #[test]
    fn every_phase_function_has_norm_one_and_its_asymmetry() {
        let count = 1_u32 << 16;
        for function in functions() {
            let (mut norm, mut along) = (0.0, 0.0);
            for step in 0..count {
                let (sine, cosine) = (PI * (f64::from(step) + 0.5) / f64::from(count)).sin_cos();
                let fraction = function.per_sr(cosine) * 2.0 * PI * sine * PI / f64::from(count);
                norm += fraction;
                along += fraction * cosine;
            }
            // 85 steps in the narrowest bin, on which p is linear in sin Θ/2.
            assert!((norm - 1.0).abs() < 1e-5 && (along - function.asymmetry()).abs() < 1e-5, "{norm} {along}");
        }
    }

    #[test]
    fn henyey_greenstein_has_the_moments_of_its_formula() {
        for g in [-0.4_f64, 0.0, 0.7, 0.95] {
            let moments = PhaseFunction::henyey_greenstein(g).moments(48);
            for (l, moment) in moments.iter().enumerate() {
                // Linear interpolation over bins of 1/256, where p has a width of (1 − g)/2√g.
                let expected = g.powi(i32::try_from(l).unwrap());
                assert!((moment - expected).abs() < 1e-3, "{g} {l}: {moment} {expected}");
            }
            assert!((moments[0] - 1.0).abs() < 1e-12 && (moments[1] - g).abs() < 1e-12);
        }
    }

    /// The asymmetry agrees with the ordinates' tally of this sample, from other rays, within 4 σ. σ² is twice the
    /// variance of the tally: once for the tally and once for the rays here.
    #[test]
    fn the_asymmetry_is_that_of_the_tally() {
        for sample in samples() {
            let demand = Demand::of_sample(&sample, &[500.0]);
            let plan = TallyPlan { degree: 2, rays: 1 << 18, seed: 1 };
            let tallies = GrainTallies::new(&Population::of_sample(&sample), &demand, &plan);
            let expected = tallies.medium(&sample, 500.0).scattering.asymmetry();
            let composition = Composition::new(&sample);
            let deviations = tallies.deviations(&sample.grain_size, &composition.at(500.0));
            let exactly = composition.differentiated(&[]).at(500.0);
            let square = |directions: &[_]| {
                let medium = tallies.deviated_medium(&exactly, &deviations, directions);
                medium.scattering.moments[1].squared_gradient()
            };
            let directions = directions(std::iter::once(&deviations));
            let deviation = directions.chunks(LANES).map(square).sum::<f64>().sqrt();
            let function = PhaseFunction::of_sample(&sample, 500.0, &PhasePlan { rays: 1 << 18, seed: 9 });
            let found = function.unwrap().asymmetry();
            assert!((found - expected).abs() < 4.0 * 2.0_f64.sqrt() * deviation, "{found} {expected} ± {deviation}");
            // 0.2 % of 1 − g.
            assert!(deviation < 2e-3 * (1.0 - expected), "{deviation}");
        }
    }

    #[test]
    fn the_asymmetry_can_be_set() {
        let function = PhaseFunction::henyey_greenstein(0.7).with_asymmetry(0.71);
        let moments = function.moments(1);
        assert!((function.asymmetry() - 0.71).abs() < 1e-12);
        assert!((moments[0] - 1.0).abs() < 1e-12 && (moments[1] - 0.71).abs() < 1e-12);
    }

    /// The mean of 2²⁰ equally spaced quantiles.
    #[test]
    fn sampled_cosines_have_the_asymmetry_as_their_mean() {
        let count = 1_u32 << 20;
        for function in functions() {
            let cosine = |i: u32| function.sample_cos((f64::from(i) + 0.5) / f64::from(count));
            let mean = (0..count).map(cosine).sum::<f64>() / f64::from(count);
            let g = function.asymmetry();
            // Linear interpolation between 2¹² quantiles.
            assert!((mean - g).abs() < 2e-4 * (1.0 - g), "{mean} {g}");
            assert!((0..count).map(cosine).all(|cosine| (-1.0..=1.0).contains(&cosine)));
        }
    }

    /// Half of isotropic scattering turns by less than 90°, and cosines are uniform.
    #[test]
    fn isotropic_cosines_are_uniform() {
        let function = PhaseFunction::isotropic();
        for number in [0.0, 0.1, 0.5, 0.87, 1.0] {
            assert!((function.sample_cos(number) - (1.0 - 2.0 * number)).abs() < 1e-6, "{number}");
        }
        assert!((function.per_sr(0.3) - 0.25 / PI).abs() < 1e-12);
    }
}
