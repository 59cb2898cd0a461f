//! Light that single facets of grains reflect before it enters them.
//!
//! A convex body in random orientation has the distribution of normals of a sphere, so its outside reflects as a
//! sphere does (van de Hulst 1957, *Light Scattering by Small Particles*). A mirror of this shape scatters evenly in
//! all directions. The remaining factor is Fresnel's reflectance F at half the angle between the light and the eye.
//! On a rough grain facets also shade each other:
//!
//! ```text
//! p_ext(Θ) = s F(i) A(i)/4π,   i = (π − Θ)/2,   cos i = sin Θ/2,
//! A(i) = ∫ D(N·m) G₂(N) dω_N,
//! ```
//!
//! Here s is the share of grains in air in the extinction. For facets with the normal m, A is the mean over the
//! orientations N of the grain's surface. The distribution D of facets is GGX; G₂ is the fraction of the facets that
//! is both lit and seen, by Smith with correlated heights (Heitz 2014, JCGT 3(2), eqs. 71, 72 and 99). A is 1 on a
//! smooth grain. p_ext is the part of the phase function of a sample which single facets mirror.

use std::f64::consts::{PI, TAU};

use super::constituents::Constituents;
use super::phase_function::half_angle_sine;
use crate::TransportError;
use crate::grain::ROUGHNESS_PER_FACETNESS;
use crate::grain::microsurface::SMOOTH_BELOW_ROUGHNESS;
use crate::optics::fresnel;
use crate::sample::SnowSample;

/// Cells of the table of A in √cos i.
const CELLS: usize = 32;
/// Steps of the integral over orientations, in slope and in azimuth. Twice as many change A by less than 10⁻³.
const STEPS: [u16; 2] = [64, 64];

/// The part of the scattering by a sample that is the first reflection, by one facet, from the outside of grains in
/// air.
#[derive(Debug, Clone, PartialEq)]
pub struct ExternalReflection {
    /// Extinction by grains in air over the extinction by all scatterers.
    share: f64,
    /// Refractive index of ice.
    index: f64,
    /// A at equal steps of √cos i.
    areas: Vec<f64>,
}

impl ExternalReflection {
    /// The external reflection of a sample at a wavelength, with the mean facetness of its grains.
    ///
    /// Grains reflect 2 % of the light that meets them head on:
    /// ```
    /// # use snowblue_transport::{SnowSample, TruncatedNormal, medium::ExternalReflection};
    /// let smooth = SnowSample { facetness: TruncatedNormal::exactly(0.0), ..SnowSample::default() };
    /// let grains = ExternalReflection::of_sample(&smooth, 550.0)?;
    /// let evenly = 0.25 * std::f64::consts::FRAC_1_PI;
    /// assert!((grains.per_sr(-1.0) / evenly - 0.018).abs() < 1e-3);
    /// # Ok::<(), snowblue_transport::TransportError>(())
    /// ```
    ///
    /// # Errors
    /// If a parameter of the sample is out of range, or the tables do not cover the wavelength.
    pub fn of_sample(sample: &SnowSample, wavelength_nm: f64) -> Result<Self, TransportError> {
        let [reflection] = Self::at_wavelengths(sample, [wavelength_nm])?;
        Ok(reflection)
    }

    /// The external reflections of a sample at some wavelengths, as by [`of_sample`](Self::of_sample). A does not
    /// depend on the wavelength.
    ///
    /// # Errors
    /// As [`of_sample`](Self::of_sample).
    pub fn at_wavelengths<const N: usize>(
        sample: &SnowSample,
        wavelengths_nm: [f64; N],
    ) -> Result<[Self; N], TransportError> {
        sample.check()?;
        for wavelength_nm in wavelengths_nm {
            sample.check_wavelength(wavelength_nm)?;
        }
        let areas = areas(ROUGHNESS_PER_FACETNESS * sample.facetness.mean_of(|facetness| facetness));
        Ok(wavelengths_nm.map(|wavelength_nm| {
            let constituents = Constituents::new(sample, wavelength_nm);
            let share = constituents.in_air.extinction_per_m / constituents.scatterer_extinction_per_m();
            Self { share, index: constituents.in_air.relative_index, areas: areas.clone() }
        }))
    }

    /// p_ext, in 1/sr, for the cosine of a scattering angle.
    #[inline]
    #[must_use]
    pub fn per_sr(&self, cos_scattering: f64) -> f64 {
        let cos_incidence = half_angle_sine(cos_scattering).min(1.0);
        self.share * fresnel(cos_incidence, self.index).reflectance * self.area(cos_incidence) / (4.0 * PI)
    }

    /// s: the share of grains in air in the extinction.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.share
    }

    /// A: area of the facets that are lit and seen, over the area on a smooth grain, for a cosine of incidence on the
    /// facets.
    #[inline]
    #[must_use]
    pub fn area(&self, cos_incidence: f64) -> f64 {
        let position = cos_incidence.clamp(0.0, 1.0).sqrt() * CELLS as f64;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 ≤ position ≤ CELLS")]
        let cell = (position as usize).min(CELLS - 1);
        self.areas[cell] + (position - cell as f64) * (self.areas[cell + 1] - self.areas[cell])
    }

    /// The greatest value of [`area`](Self::area).
    #[must_use]
    pub fn greatest_area(&self) -> f64 {
        self.areas.iter().copied().fold(0.0, f64::max)
    }
}

/// The table of A for a roughness.
fn areas(roughness: f64) -> Vec<f64> {
    (0..=CELLS).map(|cell| area((cell as f64 / CELLS as f64).powi(2), roughness)).collect()
}

/// A(i) for a roughness: the mean over slopes t by GGX, t² = α² u/(1 − u) with u uniform, and over azimuths.
fn area(cos_incidence: f64, roughness: f64) -> f64 {
    if roughness < SMOOTH_BELOW_ROUGHNESS {
        return 1.0;
    }
    let sin_incidence = (1.0 - cos_incidence * cos_incidence).sqrt();
    // Smith's Λ for GGX.
    let hidden = |cos: f64| 0.5 * ((1.0 + roughness * roughness * (1.0 / (cos * cos) - 1.0)).sqrt() - 1.0);
    let [slopes, azimuths] = STEPS.map(f64::from);
    let mut sum = 0.0;
    for slope in 0..STEPS[0] {
        let u = (f64::from(slope) + 0.5) / slopes;
        let cos = 1.0 / (1.0 + roughness * roughness * u / (1.0 - u)).sqrt();
        let sin = (1.0 - cos * cos).sqrt();
        for azimuth in 0..STEPS[1] {
            let across = sin * (TAU * (f64::from(azimuth) + 0.5) / azimuths).cos();
            // Cosines from N to the light and to the eye, on both sides of m.
            let [light, eye] = [1.0, -1.0].map(|side| cos * cos_incidence + side * across * sin_incidence);
            if light > 0.0 && eye > 0.0 {
                sum += 1.0 / (cos * (1.0 + hidden(light) + hidden(eye)));
            }
        }
    }
    sum / (slopes * azimuths)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::{PhaseFunction, PhasePlan, Population};
    use crate::rng::Stream;
    use crate::sample::TruncatedNormal;
    use crate::{Impurities, Substance};

    /// Cosines of the scattering angles at which bins begin and end.
    const EDGES: [f64; 9] = [-1.0, -0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75, 1.0];

    /// For each bin, p_ext over the bin by rays through grains, with its standard error, and by the equation.
    fn bins(sphericity: f64, facetness: f64) -> Vec<[f64; 3]> {
        const RAYS: u64 = 1 << 20;
        let index = 1.311;
        let law = TruncatedNormal::exactly;
        let sample = SnowSample { sphericity: law(sphericity), facetness: law(facetness), ..SnowSample::default() };
        let population = Population::of_sample(&sample);
        let mut hits = [[0.0; 2]; 8];
        for ray in 0..RAYS {
            let (scattered, weight) = population.scatter(index, &mut Stream::new(11, ray));
            // Light that never was in the ice.
            if scattered.ice_path <= 0.0 {
                let bin = EDGES[1..8].iter().filter(|edge| scattered.cos_scattering >= **edge).count();
                hits[bin][0] += weight;
                hits[bin][1] += weight * weight;
            }
        }
        let grains = ExternalReflection { share: 1.0, index, areas: areas(ROUGHNESS_PER_FACETNESS * facetness) };
        let expected = |bin: usize| {
            let [first, last] = [EDGES[bin], EDGES[bin + 1]];
            let steps = 4096;
            let cosine = |step: i32| first + (f64::from(step) + 0.5) / f64::from(steps) * (last - first);
            let sum: f64 = (0..steps).map(|step| grains.per_sr(cosine(step))).sum();
            sum * 2.0 * PI * (last - first) / f64::from(steps)
        };
        let rays = RAYS as f64;
        hits.iter()
            .enumerate()
            .map(|(bin, [sum, squares])| [sum / rays, squares.sqrt() / rays, expected(bin)])
            .collect()
    }

    /// Rays through smooth spheroids, whatever their shape: 4 standard errors of the rays.
    #[test]
    fn smooth_grains_of_any_shape_reflect_as_spheres() {
        for sphericity in [1.0, 0.7] {
            for [found, error, expected] in bins(sphericity, 0.0) {
                assert!((found - expected).abs() < 4.0 * error, "{sphericity}: {found} ± {error}, {expected}");
                // The rays resolve a difference of a tenth.
                assert!(error < 0.025 * expected, "{error} {expected}");
            }
        }
    }

    /// The equation leaves out reflections by two and more facets, which the rays include. The equation is no more
    /// than 4 standard errors above the rays in any bin, and less by at most a tenth in all. The documentation states
    /// this tenth; no law gives it.
    #[test]
    fn rough_grains_reflect_as_their_single_facets() {
        for facetness in [0.2, 0.5, 1.0] {
            let bins = bins(0.8, facetness);
            for [found, error, expected] in &bins {
                assert!(expected - found < 4.0 * error, "{facetness}: {found} ± {error}, {expected}");
            }
            let total = |column: usize| bins.iter().map(|bin| bin[column]).sum::<f64>();
            let further = 1.0 - total(2) / total(0);
            assert!((0.0..0.1).contains(&further), "{facetness}: {further}");
        }
    }

    /// In snow of every kind the external reflection is a part of the phase function: it does not exceed the phase
    /// function, within the noise of the rays (15 % in a bin; here over bins of some 8°).
    #[test]
    fn it_is_a_part_of_the_phase_function() {
        let wet = SnowSample { water_saturation: 0.5, ..SnowSample::default() };
        let impurities = Impurities::none().with(Substance::SAHARAN_DUST, 1e6);
        for sample in [SnowSample::default(), wet, SnowSample { impurities, ..SnowSample::default() }] {
            let phase = PhaseFunction::of_sample(&sample, 550.0, &PhasePlan::default()).unwrap();
            let part = ExternalReflection::of_sample(&sample, 550.0).unwrap();
            for degree in (4..=176).step_by(4) {
                let cosine = |offset: i32| f64::from(degree + offset).to_radians().cos();
                let all: f64 = (-4..=4).map(|offset| phase.per_sr(cosine(offset))).sum();
                let reflected: f64 = (-4..=4).map(|offset| part.per_sr(cosine(offset))).sum();
                assert!(reflected < all, "{degree}°: {reflected} {all}");
            }
        }
    }
}
