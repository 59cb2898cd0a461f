//! Fluxes of a homogeneous slab from its modes, for any thickness and any angle.
//!
//! **One illumination serves all angles.** By reciprocity the plane albedo and the transmittance for a beam at μ₀ are
//! the radiances that leave the slab in the direction μ₀ when isotropic light of unit radiance falls on it (van de
//! Hulst 1980, *Multiple Light Scattering*, §3.2; Chandrasekhar 1960, §52). Integrating the source function along μ₀
//! gives them at any angle, and no particular solution for the beam is needed.
//!
//! **No difference of nearly equal numbers.** Isotropic light from above is a half of symmetric plus a half of
//! antisymmetric light. With t_j = tanh(k_j τ/2), Γ = Hᵀ M H and Δ = Vᵀ M V the two amplitudes solve
//!
//! ```text
//! (Δ + diag k t) a = Vᵀ M 1,     (Γ + diag t/k) b = Hᵀ M 1,
//! ```
//!
//! both symmetric, positive definite and regular at k = 0, and what arrives at the far side is
//! c = a − (t/k) b = (Δ + diag k t)⁻¹ sech²(k τ/2) b: a product of positive quantities that may be as small as it likes.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::eigen::{Modes, legendre_basis};
use super::phase::{Scaled, Scattering};
use super::quadrature::{Quadrature, legendre_polynomials};

/// Fluxes over the incident flux on a horizontal plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fluxes {
    /// Reflectance: what leaves on top.
    pub reflectance: f64,
    /// Total transmittance, direct and diffuse.
    pub transmittance: f64,
    /// The part of the transmittance that met nothing: exp(−τ/μ₀) for a beam, 2 E₃(τ) for Lambertian light.
    pub direct: f64,
}

/// A homogeneous medium, solved once for all thicknesses and angles.
pub struct HomogeneousMedium {
    scaled: Scaled,
    modes: Modes,
    /// √((2l + 1) w_i) P_l(μ_i): a column for each l.
    basis: DMatrix<f64>,
    /// Γ = Hᵀ M H.
    gamma: DMatrix<f64>,
    /// Δ = Vᵀ M V.
    delta: DMatrix<f64>,
    /// Hᵀ M 1 and Vᵀ M 1, where 1 is isotropic radiance.
    entering: [DVector<f64>; 2],
}

/// Light that falls on a slab, and how each mode answers to it, independent of thickness.
pub enum Light {
    /// A parallel beam.
    Beam(Direction),
    /// Lambertian light.
    Lambertian,
}

/// How each mode shines into one direction.
pub struct Direction {
    cos_incidence: f64,
    /// Σ over even l of (2l + 1) ω χ_l P_l(μ₀) p_l · v, one for each mode.
    even: Vec<f64>,
    /// The same over odd l with the differences h.
    odd: Vec<f64>,
}

/// A slab under isotropic light from above: amplitudes of each mode.
struct Amplitudes {
    /// Of S at the lit face: a + (t/k) b.
    top: DVector<f64>,
    /// Slope of the mode there: −(k t a + b).
    top_slope: DVector<f64>,
    /// Of S at the dark face.
    bottom: DVector<f64>,
    /// Slope towards the lit face: b − k t a, which is Δ c.
    bottom_slope: DVector<f64>,
    /// Of the wave that fades from the lit face: (a + b/k)/(1 + e^{−kτ}); of no use where k = 0.
    fading: DVector<f64>,
}

impl HomogeneousMedium {
    /// Solves the eigenproblem of `medium` on `streams` ordinates, an even number that counts both hemispheres.
    ///
    /// # Panics
    /// If `streams` is odd or zero, or `medium` has fewer than `streams + 1` moments.
    #[must_use]
    pub fn new(medium: &Scattering, streams: usize) -> Self {
        assert!(streams >= 2 && streams.is_multiple_of(2), "streams must be even and positive, but are {streams}");
        let rule = Quadrature::half_range(streams / 2);
        let scaled = medium.delta_m(streams);
        let basis = legendre_basis(streams, rule);
        let modes = Modes::new(&scaled, rule, &basis);
        let weigh = |matrix: &DMatrix<f64>| {
            let mut weighed = matrix.clone();
            for (mut row, mu) in weighed.row_iter_mut().zip(&rule.cosines) {
                row *= *mu;
            }
            weighed
        };
        let (sums, differences) = (weigh(&modes.sums), weigh(&modes.differences));
        let isotropic = DVector::from_iterator(rule.order(), rule.weights.iter().map(|weight| weight.sqrt()));
        Self {
            gamma: modes.differences.tr_mul(&differences),
            delta: modes.sums.tr_mul(&sums),
            entering: [differences.tr_mul(&isotropic), sums.tr_mul(&isotropic)],
            scaled,
            modes,
            basis,
        }
    }

    /// Prepares a beam whose cosine from the normal is `cos_incidence`, in (0, 1].
    #[must_use]
    pub fn beam(&self, cos_incidence: f64) -> Light {
        let count = self.basis.ncols();
        let mut polynomials = vec![0.0; count];
        legendre_polynomials(cos_incidence, &mut polynomials);
        let shape = |parity: usize, modes: &DMatrix<f64>| {
            let mut source = DVector::zeros(self.basis.nrows());
            for l in (parity..count).step_by(2) {
                let strength = ((2 * l + 1) as f64).sqrt() * self.scaled.albedo_moments[l] * polynomials[l];
                source.axpy(strength, &self.basis.column(l), 1.0);
            }
            modes.tr_mul(&source).as_slice().to_vec()
        };
        let (even, odd) = (shape(0, &self.modes.sums), shape(1, &self.modes.differences));
        Light::Beam(Direction { cos_incidence, even, odd })
    }

    /// Fluxes of a slab of `optical_depth` (unscaled) under each of `lights`.
    #[must_use]
    pub fn fluxes(&self, optical_depth: f64, lights: &[Light]) -> Vec<Fluxes> {
        let depth = optical_depth * self.scaled.depth_ratio;
        let amplitudes = self.amplitudes(depth);
        let entering = &self.entering[1];
        let under = |light: &Light| match light {
            Light::Beam(direction) => {
                let (reflectance, scattered) = self.leaving(&amplitudes, depth, direction);
                Fluxes {
                    reflectance,
                    transmittance: scattered + (-depth / direction.cos_incidence).exp(),
                    direct: (-optical_depth / direction.cos_incidence).exp(),
                }
            }
            Light::Lambertian => Fluxes {
                reflectance: 2.0 * entering.dot(&amplitudes.top) - 1.0,
                transmittance: 2.0 * entering.dot(&amplitudes.bottom),
                direct: 2.0 * third_exponential_integral(optical_depth),
            },
        };
        lights.iter().map(under).collect()
    }

    fn amplitudes(&self, depth: f64) -> Amplitudes {
        let rates = &self.modes.rates;
        let per_mode = |f: &dyn Fn(f64) -> f64| DVector::from_iterator(rates.len(), rates.iter().map(|k| f(*k)));
        let times_rate = per_mode(&|k| k * (0.5 * k * depth).tanh());
        let over_rate = per_mode(&|k| 0.5 * depth * tanh_over_argument(0.5 * k * depth));
        let antisymmetric = solver(&self.gamma, &over_rate).solve(&self.entering[0]);
        let symmetric_solver = solver(&self.delta, &times_rate);
        let symmetric = symmetric_solver.solve(&self.entering[1]);
        let passed = per_mode(&|k| square_sech(0.5 * k * depth)).component_mul(&antisymmetric);
        let bottom = symmetric_solver.solve(&passed);
        let fading = per_mode(&|k| 1.0 / (1.0 + (-k * depth).exp()))
            .component_mul(&(&symmetric + antisymmetric.component_div(&per_mode(&|k| k))));
        Amplitudes {
            top: &symmetric + over_rate.component_mul(&antisymmetric),
            top_slope: -(times_rate.component_mul(&symmetric) + &antisymmetric),
            bottom_slope: &self.delta * &bottom,
            bottom,
            fading,
        }
    }

    /// Scattered radiance that leaves the lit and the dark face in `direction`.
    fn leaving(&self, amplitudes: &Amplitudes, depth: f64, direction: &Direction) -> (f64, f64) {
        let per_cosine = 1.0 / direction.cos_incidence;
        let unscattered = (-depth * per_cosine).exp();
        let (mut reflected, mut transmitted) = (0.0, 0.0);
        for (j, &k) in self.modes.rates.iter().enumerate() {
            let (even, odd) = (0.5 * direction.even[j], 0.5 * direction.odd[j]);
            if k < 0.5 && k * depth < 1.0 {
                let (cosh, sinh_over_k) = hyperbolic_integrals(k, depth, per_cosine, unscattered);
                let from_face = |amplitude: f64, slope: f64| {
                    amplitude * (even * cosh + odd * k * k * sinh_over_k) + slope * (even * sinh_over_k + odd * cosh)
                };
                reflected += from_face(amplitudes.top[j], amplitudes.top_slope[j]);
                transmitted += from_face(amplitudes.bottom[j], amplitudes.bottom_slope[j]);
            } else {
                let (near, far) = exponential_integrals(k, depth, per_cosine);
                let fading = amplitudes.fading[j];
                let growing = amplitudes.bottom[j] - fading * (-k * depth).exp();
                reflected += (even - odd * k) * fading * near + (even + odd * k) * growing * far;
                transmitted += (even + odd * k) * fading * far + (even - odd * k) * growing * near;
            }
        }
        (reflected, transmitted)
    }
}

/// Cholesky factors of a positive definite matrix with something non-negative added on its diagonal.
fn solver(matrix: &DMatrix<f64>, diagonal: &DVector<f64>) -> Cholesky<f64, Dyn> {
    let mut sum = matrix.clone();
    for (i, value) in diagonal.iter().enumerate() {
        sum[(i, i)] += value;
    }
    Cholesky::new(sum).unwrap_or_else(|| unreachable!("the modes' Gram matrices are positive definite"))
}

/// tanh(x)/x, which is 1 at 0.
fn tanh_over_argument(x: f64) -> f64 {
    if x < 1e-4 { 1.0 - x * x / 3.0 } else { x.tanh() / x }
}

/// 1/cosh²(x) without overflow.
fn square_sech(x: f64) -> f64 {
    let e = (-2.0 * x).exp();
    4.0 * e / ((1.0 + e) * (1.0 + e))
}

/// ∫₀^τ e^{−qs} cosh(ks) q ds and ∫₀^τ e^{−qs} sinh(ks)/k q ds, for k < 1 ≤ q.
fn hyperbolic_integrals(k: f64, depth: f64, q: f64, unscattered: f64) -> (f64, f64) {
    let x = k * depth;
    let sinh_over_k = if x < 1e-4 { depth * (1.0 + x * x / 6.0) } else { x.sinh() / k };
    let (cosh, norm) = (x.cosh(), q / (q * q - k * k));
    let first = norm * (q - unscattered * (q * cosh + k * k * sinh_over_k));
    let second = norm * (1.0 - unscattered * (cosh + q * sinh_over_k));
    (first, second)
}

/// ∫₀^τ e^{−qs} e^{−ks} q ds and ∫₀^τ e^{−qs} e^{−k(τ−s)} q ds; q = k is a regular point.
fn exponential_integrals(k: f64, depth: f64, q: f64) -> (f64, f64) {
    let near = -q / (q + k) * (-(q + k) * depth).exp_m1();
    let gap = (q - k).abs() * depth;
    let mean = if gap < 1e-8 { 1.0 - 0.5 * gap } else { -(-gap).exp_m1() / gap };
    (near, q * depth * (-q.min(k) * depth).exp() * mean)
}

/// E₃(τ) = ∫₀¹ μ e^{−τ/μ} dμ by Gauss–Legendre in u with μ = u², scaled so that the tail keeps its relative precision.
fn third_exponential_integral(tau: f64) -> f64 {
    // With 1/μ = 1 + t: E₃ = e^{−τ} ∫₀^∞ e^{−τt} (1 + t)⁻³ dt, and t = y/((1 + τ)(1 − y)) brings the range to (0, 1).
    let rule = Quadrature::half_range(48);
    let integral: f64 = rule
        .cosines
        .iter()
        .zip(&rule.weights)
        .map(|(y, weight)| {
            let t = y / ((1.0 + tau) * (1.0 - y));
            let jacobian = 1.0 / ((1.0 + tau) * (1.0 - y) * (1.0 - y));
            weight * jacobian * (-tau * t).exp() / (1.0 + t).powi(3)
        })
        .sum();
    (-tau).exp() * integral
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponential_integral_matches_abramowitz_and_stegun_table_5_4() {
        // E₃(0) = 1/2 exactly; E₃(1) = .1096920 (Table 5.4, 7 figures); E₃(5) from E₁(5) = .001148296 by recurrence.
        for (tau, expected, tolerance) in [(0.0, 0.5, 1e-12), (1.0, 0.109_692_0, 5e-8), (5.0, 8.778e-4, 5e-8)] {
            assert!((third_exponential_integral(tau) - expected).abs() < tolerance, "{tau}");
        }
    }

    #[test]
    fn integrals_agree_at_the_degenerate_point_and_between_forms() {
        let (k, depth) = (0.4, 2.0);
        for q in [1.0, 1.7, 30.0] {
            let (cosh, sinh) = hyperbolic_integrals(k, depth, q, (-q * depth).exp());
            let (near, far) = exponential_integrals(k, depth, q);
            assert!((cosh - k * sinh - near).abs() < 1e-14, "e^(−ks) = cosh − sinh");
            let growing = (k * depth).exp() * far;
            assert!((cosh + k * sinh - growing).abs() < 1e-14, "e^(ks) = cosh + sinh");
        }
        let (_, exact) = exponential_integrals(2.0, depth, 2.0);
        assert!((exact - 4.0 * (-4.0_f64).exp()).abs() < 1e-16);
    }
}
