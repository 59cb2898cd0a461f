//! Fluxes of a homogeneous slab from its modes, for any thickness and any angle.
//!
//! **One solution serves all angles.** By reciprocity the plane albedo and the transmittance for a beam at μ₀ are
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
//! both symmetric, positive definite and regular at k = 0, and the amplitude at the far side is c = a − (t/k) b = (Δ +
//! diag k t)⁻¹ sech²(k τ/2) b: a product of positive quantities, accurate however small.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use snowblue_base::ParameterRange;

use super::delta_m::Scaled;
use super::eigen::{Modes, legendre_basis};
use super::integrals::{
    exponential_integrals, hyperbolic_integrals, square_sech, tanh_over_rate, third_exponential_integral,
};
use super::streams::check_streams;
use crate::TransportError;
use crate::medium::Scattering;
use crate::quadrature::{Quadrature, legendre_polynomials};
use crate::slab::Incidence;

/// Fluxes over the incident flux on a horizontal plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fluxes {
    /// Reflectance.
    pub reflectance: f64,
    /// Total transmittance, direct and diffuse.
    pub transmittance: f64,
    /// Unscattered part of the transmittance: exp(−τ/μ₀) for a beam, 2 E₃(τ) for Lambertian light.
    pub direct: f64,
}

/// A homogeneous medium, solved once for all thicknesses and angles.
pub struct HomogeneousMedium {
    pub(super) scaled: Scaled,
    pub(super) modes: Modes,
    /// √((2l + 1) w_i) P_l(μ_i): a column for each l.
    basis: &'static DMatrix<f64>,
    /// M H.
    pub(super) weighted_differences: DMatrix<f64>,
    /// Γ = Hᵀ M H.
    gamma: DMatrix<f64>,
    /// Δ = Vᵀ M V.
    pub(super) delta: DMatrix<f64>,
    /// Hᵀ M 1 and Vᵀ M 1, where 1 is isotropic radiance.
    pub(super) entering: [DVector<f64>; 2],
}

/// Light on a slab, with the response of each mode to it, which does not depend on thickness.
pub enum Light {
    /// A parallel beam.
    Beam(Direction),
    /// Lambertian light.
    Lambertian,
}

/// The radiance of each mode in one direction.
pub struct Direction {
    pub(super) cos_incidence: f64,
    /// Σ over even l of (2l + 1) ω χ_l P_l(μ₀) p_l · v, one for each mode.
    pub(super) even: Vec<f64>,
    /// The same over odd l with the differences h.
    pub(super) odd: Vec<f64>,
}

/// A slab under isotropic light from above: amplitudes of each mode.
struct Amplitudes {
    /// Of S at the illuminated face: a + (t/k) b.
    top: DVector<f64>,
    /// Slope of the mode there: −(k t a + b).
    top_slope: DVector<f64>,
    /// Of S at the dark face.
    bottom: DVector<f64>,
    /// Slope towards the illuminated face: b − k t a, which is Δ c.
    bottom_slope: DVector<f64>,
    /// Of the wave that decays from the illuminated face: (a + b/k)/(1 + e^{−kτ}); unused where k = 0.
    fading: DVector<f64>,
}

/// Scattered radiance that leaves a slab in one direction.
struct LeavingRadiance {
    /// From the illuminated face.
    reflected: f64,
    /// From the dark face.
    transmitted: f64,
}

impl HomogeneousMedium {
    /// Checks that `medium` has a valid albedo and moments, and that `streams` ordinates resolve its phase function.
    /// With too few ordinates for a narrow peak that is not forward, the discrete medium would create light.
    ///
    /// # Errors
    /// [`TransportError::Range`], [`TransportError::Streams`] or [`TransportError::Unresolved`].
    pub fn check(medium: &Scattering, streams: usize) -> Result<(), TransportError> {
        check_streams(streams)?;
        let within = |quantity, least, greatest| ParameterRange { quantity, least, greatest, unit: "" };
        within("co-albedo", 0.0, 1.0).check(medium.one_minus_albedo)?;
        within("number of moments", streams as f64 + 1.0, 1e9).check(medium.moments.len() as f64)?;
        medium.moments.iter().try_for_each(|chi| within("moment", -1.0, 1.0).check(*chi))?;
        let modes = Modes::new(&medium.delta_m(streams), Quadrature::half_range(streams / 2));
        modes.map(drop).ok_or(TransportError::Unresolved { streams })
    }

    /// Solves the eigenproblem of `medium` on `streams` ordinates, an even number that counts both hemispheres.
    ///
    /// # Panics
    /// If [`HomogeneousMedium::check`] refuses the medium or the streams, which it never does for the moments of snow.
    #[must_use]
    pub fn new(medium: &Scattering, streams: usize) -> Self {
        assert!(streams >= 2 && streams.is_multiple_of(2), "streams must be even and positive, but are {streams}");
        let rule = Quadrature::half_range(streams / 2);
        let scaled = medium.delta_m(streams);
        let basis = legendre_basis(rule.order());
        let modes = Modes::new(&scaled, rule);
        let modes = modes.unwrap_or_else(|| panic!("{streams} streams cannot resolve the phase function"));
        let times_cosine = |matrix: &DMatrix<f64>| {
            let mut product = matrix.clone();
            for (mut row, mu) in product.row_iter_mut().zip(&rule.cosines) {
                row *= *mu;
            }
            product
        };
        let (sums, differences) = (times_cosine(&modes.sums), times_cosine(&modes.differences));
        let isotropic = DVector::from_iterator(rule.order(), rule.weights.iter().map(|weight| weight.sqrt()));
        Self {
            gamma: modes.differences.tr_mul(&differences),
            delta: modes.sums.tr_mul(&sums),
            entering: [differences.tr_mul(&isotropic), sums.tr_mul(&isotropic)],
            weighted_differences: differences,
            scaled,
            modes,
            basis,
        }
    }

    /// Prepares a beam whose cosine from the normal is `cos_incidence`, in (0, 1].
    #[must_use]
    pub fn beam(&self, cos_incidence: f64) -> Light {
        Light::Beam(self.direction(cos_incidence))
    }

    /// Prepares a beam or Lambertian light.
    #[must_use]
    pub fn light(&self, incidence: &Incidence) -> Light {
        match incidence {
            Incidence::Beam { angle_deg } => self.beam(angle_deg.to_radians().cos()),
            Incidence::Diffuse => Light::Lambertian,
        }
    }

    pub(super) fn direction(&self, cos_incidence: f64) -> Direction {
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
        Direction { cos_incidence, even, odd }
    }

    /// Decay rate of light far from all faces: the rate of the slowest mode per (unscaled) optical depth.
    #[must_use]
    pub fn decay_rate(&self) -> f64 {
        self.scaled.depth_ratio * self.modes.rates.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Fluxes of a slab of (unscaled) `optical_depth`, which may be infinite, under each of `lights`.
    #[must_use]
    pub fn fluxes<'l>(&self, optical_depth: f64, lights: impl IntoIterator<Item = &'l Light>) -> Vec<Fluxes> {
        let depth = optical_depth * self.scaled.depth_ratio;
        let amplitudes = self.amplitudes(depth);
        let entering = &self.entering[1];
        let under = |light: &Light| match light {
            Light::Beam(direction) => {
                let LeavingRadiance { reflected, transmitted } = self.leaving(&amplitudes, depth, direction);
                Fluxes {
                    reflectance: reflected,
                    transmittance: transmitted + (-depth / direction.cos_incidence).exp(),
                    direct: (-optical_depth / direction.cos_incidence).exp(),
                }
            }
            Light::Lambertian => Fluxes {
                reflectance: 2.0 * entering.dot(&amplitudes.top) - 1.0,
                transmittance: 2.0 * entering.dot(&amplitudes.bottom),
                direct: 2.0 * third_exponential_integral(optical_depth),
            },
        };
        lights.into_iter().map(under).collect()
    }

    fn amplitudes(&self, depth: f64) -> Amplitudes {
        let rates = &self.modes.rates;
        let per_mode = |f: &dyn Fn(f64) -> f64| DVector::from_iterator(rates.len(), rates.iter().map(|k| f(*k)));
        let times_rate = per_mode(&|k| k * (0.5 * k * depth).tanh());
        let over_rate = per_mode(&|k| tanh_over_rate(k, depth));
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

    /// Scattered radiance that leaves both faces in `direction`.
    fn leaving(&self, amplitudes: &Amplitudes, depth: f64, direction: &Direction) -> LeavingRadiance {
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
        LeavingRadiance { reflected, transmitted }
    }
}

/// Cholesky factors of a positive definite matrix plus a non-negative diagonal.
pub(super) fn solver(matrix: &DMatrix<f64>, diagonal: &DVector<f64>) -> Cholesky<f64, Dyn> {
    let mut sum = matrix.clone();
    for (i, value) in diagonal.iter().enumerate() {
        sum[(i, i)] += value;
    }
    Cholesky::new(sum).unwrap_or_else(|| unreachable!("the modes' Gram matrices are positive definite"))
}
