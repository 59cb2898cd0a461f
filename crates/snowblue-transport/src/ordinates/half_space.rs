//! The half-space that scatters without absorption: the functions that the diffusion of light needs at the surface of
//! snow.
//!
//! Deep inside snow, the fluence rate φ diffuses. At the surface, under the irradiance F of a beam at μ₀, it obeys
//!
//! ```text
//! φ + q ℓ* ∂φ/∂n = 4 K(μ₀) F,        ℓ* = 1/(κ(1 − g)),
//! L(μ) = R₀(μ, μ₀, Δφ) F + K(μ) J/π,  J: net flux out,
//! ```
//!
//! with the escape function K, 2∫ K μ dμ = 1, the extrapolation length q and the reflection function R₀ (Sobolev 1975,
//! *Light Scattering in Planetary Atmospheres*, ch. 2; Kokhanovsky & Zege 2004, doi:10.1364/AO.43.001589).
//!
//! Adding–doubling gives these functions for each azimuthal mode. A thick layer with the depth τ transmits the fraction
//! T = (4/3)/((1 − g)τ + 2q) of Lambertian light, with the angular distribution K.
//! Its reflection is less than the reflection of the half-space by T K(μ) K(μ₀)/π. The error of both relations is the
//! light that has not yet diffused.
//!
//! **Single scattering is exact.** The modes come from δ-M scaled moments, and single scattering p/(μ + μ₀) is taken
//! out of each mode and put back with p itself, over 1 − f for the scaled depth (Nakajima & Tanaka 1988,
//! doi:10.1016/0022-4073(88)90031-3). The remaining radiance is smooth.

use snowblue_base::narrow;
use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};

use super::adding::{DiffuseOperators, FIRST_DEPTH, PhaseMatrices};
use super::eigen::Scaled;
use crate::medium::{PhaseFunction, Scattering};
use crate::optics::lagrange;
use crate::quadrature::Quadrature;

/// Gauss nodes of a hemisphere.
const NODES: usize = 24;
/// Azimuthal modes of multiple scattering. With more, R₀ of dry snow changes by less than 10⁻³ for cosines above 0.05.
const MODES: usize = 12;
/// Cells of the reflection table in √μ and in √μ₀.
const CELLS: usize = 64;
/// Cells of the escape function in √μ.
const ESCAPE_CELLS: usize = 256;
/// Depth in transport mean free paths where light has diffused: the next mode has decayed by more than e⁻⁴⁰.
const DIFFUSE_DEPTH: f64 = 40.0;

/// Functions of the conservative half-space of a phase function.
#[derive(Debug, Clone, PartialEq)]
pub struct HalfSpace {
    phase: PhaseFunction,
    /// 1/(1 − f), with the forward fraction f of δ-M scaling.
    single_factor: f64,
    extrapolation: f64,
    /// K at equal steps of √μ.
    escape: Vec<f32>,
    /// [step of √μ][step of √μ₀]
    multiple: Vec<Modes>,
}

/// (μ + μ₀) times multiple scattering, in 1/sr: the factor of cos mΔφ in each mode m; odd modes lack the factor
/// √((1 − μ²)(1 − μ₀²)), without which they are smooth at μ = 1.
type Modes = [f32; MODES];

impl HalfSpace {
    /// Solves the half-space of a phase function.
    #[must_use]
    pub fn new(phase: &PhaseFunction) -> Self {
        let rule = Quadrature::half_range(NODES);
        let moments = phase.moments(2 * NODES);
        let scaled = Scaled::new(&Scattering { one_minus_albedo: 0.0, moments }, 2 * NODES);
        let to_grid = interpolation(rule, CELLS);
        let mut multiple = vec![[0.0; MODES]; (CELLS + 1) * (CELLS + 1)];
        let (mut escape, mut extrapolation) = (DVector::zeros(NODES), 0.0);
        let doublings = doublings(&scaled);
        for mode in 0..MODES {
            let matrices = PhaseMatrices::new(&scaled, mode, rule);
            let mut layer = DiffuseOperators::thin(&matrices, rule, FIRST_DEPTH);
            (0..doublings).for_each(|_| layer = layer.doubled());
            let mut reflection = DiffuseOperators::per_flux(layer.reflection, rule);
            if mode == 0 {
                let radiances = layer.transmission.column_sum();
                let transmittance =
                    2.0 * (0..NODES).map(|i| rule.weights[i] * rule.cosines[i] * radiances[i]).sum::<f64>();
                escape = radiances / transmittance;
                extrapolation = 0.5 * (4.0 / (3.0 * transmittance) - transport_depth(&scaled, doublings));
                reflection.ger(transmittance / PI, &escape, &escape, 1.0);
            }
            let smooth = DMatrix::from_fn(NODES, NODES, |i, j| {
                let (mu, other) = (rule.cosines[i], rule.cosines[j]);
                let sines = if mode % 2 == 1 { ((1.0 - mu * mu) * (1.0 - other * other)).sqrt() } else { 1.0 };
                let twice = if mode == 0 { 1.0 } else { 2.0 };
                let single = matrices.backward[(i, j)] / (4.0 * PI);
                twice * ((mu + other) * reflection[(i, j)] - single) / sines
            });
            let table = &to_grid * smooth * to_grid.transpose();
            for (modes, value) in multiple.iter_mut().zip(&table) {
                modes[mode] = narrow(*value);
            }
        }
        let escape = (interpolation(rule, ESCAPE_CELLS) * escape).iter().map(|value| narrow(*value)).collect();
        Self { phase: phase.clone(), single_factor: 1.0 / scaled.depth_ratio, extrapolation, escape, multiple }
    }

    /// The escape function K(μ), which is proportional to the radiance that leaves a half-space with its source far
    /// inside; 2∫ K μ dμ = 1. The cosine from the normal lies in 0–1.
    ///
    /// Light that comes from deep inside snow is darker at the limb, as the sun is: by more than a factor of 2.
    /// ```
    /// # use snowblue_transport::{PhaseFunction, ordinates::HalfSpace};
    /// let snow = HalfSpace::new(&PhaseFunction::henyey_greenstein(0.75));
    /// assert!(snow.escape(1.0) > 2.0 * snow.escape(0.05));
    /// // A surface of deep, clean snow under a high sun is nearly as bright from all sides; 1/π is Lambert's.
    /// let lambert = std::f64::consts::FRAC_1_PI;
    /// assert!((snow.reflection(0.7, 1.0, 0.0) / lambert - 1.0).abs() < 0.2);
    /// ```
    #[inline]
    #[must_use]
    pub fn escape(&self, cos: f64) -> f64 {
        let (cell, part) = place(cos, ESCAPE_CELLS);
        let (first, last) = (f64::from(self.escape[cell]), f64::from(self.escape[cell + 1]));
        first + part * (last - first)
    }

    /// The extrapolation length q, in transport mean free paths 1/(κ(1 − g)): 0.7104 for isotropic scattering.
    #[must_use]
    pub fn extrapolation(&self) -> f64 {
        self.extrapolation
    }

    /// The phase function.
    #[must_use]
    pub fn phase(&self) -> &PhaseFunction {
        &self.phase
    }

    /// The reflection function R₀ in 1/sr: the radiance that leaves in the direction μ, per irradiance F = E⊥ μ₀ of a
    /// beam on the surface.
    ///
    /// Both angles are measured from the normal; their cosines lie in 0–1 and are not both 0. `cos_azimuth` is the
    /// cosine of the angle between the directions of propagation of the incident and the leaving light, projected on
    /// the surface: 1 for light that continues away from the light source, −1 for light that returns towards it. The
    /// cosine of the scattering angle is −μμ₀ + √((1 − μ²)(1 − μ₀²)) cos Δφ.
    #[inline]
    #[must_use]
    pub fn reflection(&self, cos_exit: f64, cos_incidence: f64, cos_azimuth: f64) -> f64 {
        let sines = ((1.0 - cos_exit * cos_exit) * (1.0 - cos_incidence * cos_incidence)).max(0.0).sqrt();
        let single = self.single_factor * self.phase.per_sr(sines * cos_azimuth - cos_exit * cos_incidence);
        let modes = self.multiple_modes(cos_exit, cos_incidence);
        // cos mφ by Chebyshev's recurrence.
        let (mut before, mut cosine) = (cos_azimuth, 1.0);
        let mut multiple = [0.0, 0.0];
        for (mode, value) in modes.into_iter().enumerate() {
            multiple[mode % 2] += value * cosine;
            (before, cosine) = (cosine, 2.0 * cos_azimuth * cosine - before);
        }
        // The truncated modes of a narrow peak may sum to less than nothing where there is next to no light.
        (single + multiple[0] + sines * multiple[1]).max(0.0) / (cos_exit + cos_incidence)
    }

    /// (μ + μ₀) R₀ in 1/sr, which is smooth, for texture look-ups: at equal steps of √μ, of √μ₀ and, fastest, of the
    /// sine of half the azimuth, all from 0 to 1.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "a table of single precision")]
    pub fn reflection_table(&self, steps: u32) -> Vec<f32> {
        let squares = || (0..=steps).map(|step| (f64::from(step) / f64::from(steps)).powi(2));
        // At grazing angles on both sides the product has a limit, which this offset approaches.
        let cosines = || squares().map(|cos| cos.max(1e-4));
        let mut table = Vec::new();
        for exit in cosines() {
            for incidence in cosines() {
                let value = |square: f64| (exit + incidence) * self.reflection(exit, incidence, 1.0 - 2.0 * square);
                table.extend(squares().map(|square| value(square) as f32));
            }
        }
        table
    }

    /// The modes of multiple scattering, bilinear in √μ and √μ₀.
    #[inline]
    fn multiple_modes(&self, cos_exit: f64, cos_incidence: f64) -> [f64; MODES] {
        let ((row, down), (column, across)) = (place(cos_exit, CELLS), place(cos_incidence, CELLS));
        let corner = row * (CELLS + 1) + column;
        let mut modes = [0.0; MODES];
        for (place, weight) in [
            (corner, (1.0 - down) * (1.0 - across)),
            (corner + 1, (1.0 - down) * across),
            (corner + CELLS + 1, down * (1.0 - across)),
            (corner + CELLS + 2, down * across),
        ] {
            for (sum, value) in modes.iter_mut().zip(&self.multiple[place]) {
                *sum += weight * f64::from(*value);
            }
        }
        modes
    }
}

/// How often the first layer is doubled until light has diffused.
fn doublings(medium: &Scaled) -> i32 {
    (0..64).find(|doublings| transport_depth(medium, *doublings) > DIFFUSE_DEPTH).unwrap_or(64)
}

/// Depth of the doubled layer in transport mean free paths.
fn transport_depth(medium: &Scaled, doublings: i32) -> f64 {
    (1.0 - medium.albedo_moments[1]) * FIRST_DEPTH * 2.0_f64.powi(doublings)
}

/// The matrix from values at the nodes to values at equal steps of √μ, by the polynomial through all nodes.
fn interpolation(rule: &Quadrature, cells: usize) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(cells + 1, NODES);
    for (step, mut row) in matrix.row_iter_mut().enumerate() {
        let root = step as f64 / cells as f64;
        row.iter_mut().zip(lagrange(&rule.cosines, root * root)).for_each(|(entry, weight)| *entry = weight);
    }
    matrix
}

/// The cell of a cosine in a table with equal steps of √μ, and the place within the cell.
#[inline]
fn place(cos: f64, cells: usize) -> (usize, f64) {
    let position = cos.max(0.0).sqrt() * cells as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 ≤ position")]
    let cell = (position as usize).min(cells - 1);
    (cell, position - cell as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ordinates::HomogeneousMedium;
    use crate::rng::{Stream, unit_circle};
    use crate::{PhasePlan, SnowSample};
    use glam::DVec3;

    fn snow() -> PhaseFunction {
        PhaseFunction::of_sample(&SnowSample::default(), 550.0, &PhasePlan { rays: 1 << 14, seed: 1 }).unwrap()
    }

    fn functions() -> [PhaseFunction; 3] {
        [PhaseFunction::isotropic(), PhaseFunction::henyey_greenstein(0.7), snow()]
    }

    /// Chandrasekhar's H function for isotropic scattering without absorption: 1/H(μ) = ½ ∫ μ′ H(μ′)/(μ + μ′) dμ′
    /// (Chandrasekhar 1960, §38, eq. 10 with ω = 1).
    fn h_function() -> impl Fn(f64) -> f64 {
        let rule = Quadrature::half_range(64);
        let at = |mu: f64, values: &[f64]| {
            let terms = rule.cosines.iter().zip(&rule.weights).zip(values);
            2.0 / terms.map(|((x, weight), h)| weight * x * h / (mu + x)).sum::<f64>()
        };
        let mut values = vec![1.0; rule.order()];
        for _ in 0..300 {
            values = rule.cosines.iter().zip(&values).map(|(mu, h)| 0.5 * (h + at(*mu, &values))).collect();
        }
        move |mu| at(mu, &values)
    }

    #[test]
    fn the_escape_function_has_its_norm() {
        let rule = Quadrature::half_range(64);
        for phase in functions() {
            let half_space = HalfSpace::new(&phase);
            let flux = |(mu, weight): (&f64, &f64)| 2.0 * weight * mu * half_space.escape(*mu);
            let norm: f64 = rule.cosines.iter().zip(&rule.weights).map(flux).sum();
            // Linear interpolation with 256 cells.
            assert!((norm - 1.0).abs() < 1e-5, "{norm}");
        }
    }

    /// A half-space that does not absorb reflects all light.
    #[test]
    fn all_light_is_reflected() {
        let rule = Quadrature::half_range(64);
        for phase in functions() {
            let half_space = HalfSpace::new(&phase);
            for cos_incidence in [0.02, 0.1, 0.4, 0.8, 1.0] {
                let mut albedo = 0.0;
                for (mu, weight) in rule.cosines.iter().zip(&rule.weights) {
                    for step in 0..128 {
                        let cos_azimuth = (PI * (f64::from(step) + 0.5) / 128.0).cos();
                        albedo += weight * mu * half_space.reflection(*mu, cos_incidence, cos_azimuth) * PI / 64.0;
                    }
                }
                // Bilinear interpolation, and noise in p that 48 moments leave out.
                assert!((albedo - 1.0).abs() < 1e-3, "{cos_incidence}: {albedo}");
            }
        }
    }

    #[test]
    fn reflection_is_reciprocal() {
        for phase in functions() {
            let half_space = HalfSpace::new(&phase);
            for (mu, other) in [(0.05, 0.9), (0.3, 0.31), (1.0, 0.2)] {
                for cos_azimuth in [-1.0, 0.2, 1.0] {
                    let forward = half_space.reflection(mu, other, cos_azimuth);
                    let reversed = half_space.reflection(other, mu, cos_azimuth);
                    // Single precision.
                    assert!((forward / reversed - 1.0).abs() < 1e-6, "{mu} {other}: {forward} {reversed}");
                }
            }
        }
    }

    /// K = (√3/4) H, R₀ = H(μ) H(μ₀)/4π(μ + μ₀), and q of Milne's problem (Chandrasekhar 1960, §27.3 and §47).
    #[test]
    fn isotropic_scattering_has_its_closed_forms() {
        let (half_space, h) = (HalfSpace::new(&PhaseFunction::isotropic()), h_function());
        assert!((half_space.extrapolation() - 0.710_446).abs() < 2e-6, "{}", half_space.extrapolation());
        for mu in [0.01, 0.05, 0.2, 0.5, 0.8, 1.0] {
            let escape = half_space.escape(mu) / (0.25 * 3.0_f64.sqrt() * h(mu));
            // Polynomials through 24 nodes, where K goes as μ ln μ.
            assert!((escape - 1.0).abs() < 1e-4, "{mu}: {escape}");
            for other in [0.01, 0.4, 1.0] {
                let expected = h(mu) * h(other) / (4.0 * PI * (mu + other));
                let ratio = half_space.reflection(mu, other, 0.3) / expected;
                // Bilinear interpolation with 64 cells.
                assert!((ratio - 1.0).abs() < 2e-4, "{mu} {other}: {ratio}");
            }
        }
    }

    /// Similarity: in transport mean free paths, q depends little on the phase function.
    #[test]
    fn extrapolation_lengths_are_similar() {
        for phase in functions() {
            let extrapolation = HalfSpace::new(&phase).extrapolation();
            assert!((0.71..0.72).contains(&extrapolation), "{extrapolation}");
        }
    }

    /// A thick slab of the discrete-ordinates engine, which has no half-space, transmits K(μ₀) T.
    #[test]
    fn thick_slabs_transmit_by_the_escape_function() {
        for phase in functions() {
            let half_space = HalfSpace::new(&phase);
            let medium = Scattering { one_minus_albedo: 0.0, moments: phase.moments(64) };
            let medium = HomogeneousMedium::new(&medium, 64);
            let depth = 30.0 / (1.0 - phase.asymmetry());
            let lambertian = 4.0 / 3.0 / (30.0 + 2.0 * half_space.extrapolation());
            for mu in [0.02, 0.1, 0.3, 0.6, 1.0] {
                let found = medium.fluxes(depth, &[medium.beam(mu)])[0].transmittance;
                let ratio = half_space.escape(mu) * lambertian / found;
                // 24 against 32 nodes; most at grazing angles.
                assert!((ratio - 1.0).abs() < 3e-4, "{mu}: {ratio}");
            }
        }
    }

    /// Random walks with next-event estimation towards the eye at each scattering: radiance away from the light
    /// source less radiance towards it. Deep light does not depend on the azimuth, so walks of 100 scatterings
    /// suffice.
    #[test]
    fn azimuths_agree_with_random_walks() {
        let phase = PhaseFunction::henyey_greenstein(0.7);
        let half_space = HalfSpace::new(&phase);
        for (cos_exit, cos_incidence) in [(0.4_f64, 0.6_f64), (0.8, 0.3)] {
            let eye = |side: f64| DVec3::new(side * (1.0 - cos_exit * cos_exit).sqrt(), 0.0, -cos_exit);
            let differences: Vec<f64> = (0..1 << 16)
                .map(|ray| {
                    let mut stream = Stream::new(5, ray);
                    let mut direction = DVec3::new((1.0 - cos_incidence * cos_incidence).sqrt(), 0.0, cos_incidence);
                    let (mut depth, mut difference) = (0.0, 0.0);
                    for _ in 0..100 {
                        depth -= stream.uniform().ln() * direction.z;
                        if depth < 0.0 {
                            break;
                        }
                        let towards = |side: f64| phase.per_sr(direction.dot(eye(side)));
                        difference += (towards(1.0) - towards(-1.0)) * (-depth / cos_exit).exp() / cos_exit;
                        let cosine = phase.sample_cos(stream.uniform());
                        let (across, along) = direction.any_orthonormal_pair();
                        let (cos_turn, sin_turn) = unit_circle(stream.uniform());
                        let sideways = (1.0 - cosine * cosine).max(0.0).sqrt();
                        direction = direction * cosine + (across * cos_turn + along * sin_turn) * sideways;
                        direction = direction.normalize();
                    }
                    difference
                })
                .collect();
            let count = differences.len() as f64;
            let mean = differences.iter().sum::<f64>() / count;
            let variance = differences.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
            let sigma = (variance / count).sqrt();
            let reflection = |cos_azimuth| half_space.reflection(cos_exit, cos_incidence, cos_azimuth);
            let expected = reflection(1.0) - reflection(-1.0);
            assert!((mean - expected).abs() < 4.0 * sigma, "{mean} ± {sigma}, expected {expected}");
            // The test would notice a wrong sign, and multiple scattering left out.
            assert!(sigma < 0.02 * expected, "{sigma} {expected}");
        }
    }
}
