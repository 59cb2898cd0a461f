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

use super::eigen::{Modes, Scaled, legendre_basis};
use super::integrals::{exponential_integrals, hyperbolic_integrals, tanh_over_rate, third_exponential_integral};
use super::options::Streams;
use crate::TransportError;
use crate::dual::Real;
use crate::medium::Scattering;
use crate::quadrature::{Quadrature, legendre_polynomials};
use crate::slab::{Fluxes, Incidence};

/// Fluxes over the incident flux on a horizontal plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MediumFluxes {
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
    pub(super) basis: &'static DMatrix<f64>,
    /// M H.
    pub(super) weighted_differences: DMatrix<f64>,
    /// Γ = Hᵀ M H.
    pub(super) gamma: DMatrix<f64>,
    /// Δ = Vᵀ M V.
    pub(super) delta: DMatrix<f64>,
    /// Hᵀ M 1 and Vᵀ M 1, where 1 is isotropic radiance.
    pub(super) entering: [DVector<f64>; 2],
    /// Refractive index of clear ice with faces to air; none of a medium without faces, as snow.
    pub(super) ice_index: Option<f64>,
}

/// Light on a slab, with the response of each mode to it, which does not depend on thickness.
pub enum ModalLight<T = f64> {
    /// A parallel beam.
    Beam(Direction<T>),
    /// Lambertian light.
    Lambertian,
}

/// The radiance of each mode in one direction.
pub struct Direction<T = f64> {
    pub(super) cos_incidence: T,
    /// Σ over even l of (2l + 1) ω χ_l P_l(μ₀) p_l · v, one for each mode.
    pub(super) even: Vec<T>,
    /// Σ over odd l of (2l + 1) ω χ_l P_l(μ₀) p_l · h, one for each mode, with the differences h.
    pub(super) odd: Vec<T>,
}

/// Transfer of one mode through a slab.
#[derive(Clone, Copy)]
pub(super) struct Transfer<T = f64> {
    /// k tanh(kτ/2).
    pub(super) times_rate: T,
    /// tanh(kτ/2)/k.
    pub(super) over_rate: T,
    /// sech²(kτ/2).
    pub(super) square_sech: T,
    /// e^{−kτ}.
    decay: T,
}

/// A slab under isotropic light from above: the solutions of its linear systems.
pub(super) struct SlabSolution {
    /// Scaled optical depth.
    depth: f64,
    transfers: Vec<Transfer>,
    /// Factors of Δ + diag k t.
    pub(super) symmetric_factor: Cholesky<f64, Dyn>,
    /// Factors of Γ + diag t/k.
    pub(super) antisymmetric_factor: Cholesky<f64, Dyn>,
    /// a.
    pub(super) symmetric: DVector<f64>,
    /// b.
    pub(super) antisymmetric: DVector<f64>,
    /// c: S in the modes at the dark face.
    pub(super) bottom: DVector<f64>,
    /// Δ c: the slope towards the illuminated face.
    bottom_slope: DVector<f64>,
}

/// Amplitudes of one mode in a slab under isotropic light from above.
#[derive(Clone, Copy)]
pub(super) struct Amplitudes<T = f64> {
    /// Of S at the illuminated face: a + (t/k) b.
    top: T,
    /// Slope of the mode there: −(k t a + b).
    top_slope: T,
    /// Of S at the dark face.
    bottom: T,
    /// Slope towards the illuminated face: b − k t a, which is Δ c.
    bottom_slope: T,
    /// Of the wave that decays from the illuminated face: (a + b/k)/(1 + e^{−kτ}); unused where k = 0.
    fading: T,
    /// e^{−kτ}.
    decay: T,
}

/// A slab under isotropic light from above.
pub(super) struct LitSlab<'m, T = f64> {
    pub(super) rates: &'m [T],
    /// Vᵀ M 1.
    pub(super) entering: &'m [T],
    /// Scaled optical depth.
    pub(super) depth: T,
    /// Amplitudes of each mode.
    pub(super) amplitudes: Vec<Amplitudes<T>>,
}

/// Reflectance and total transmittance of a slab.
#[derive(Debug, Clone, Copy)]
pub(super) struct Passed<T = f64> {
    pub(super) reflectance: T,
    pub(super) transmittance: T,
}

/// Decay rate of light far from all faces: the rate of the slowest mode per (unscaled) optical depth.
pub(super) fn decay_rate<T: Real>(depth_ratio: T, rates: &[T]) -> T {
    let slowest = rates.iter().copied().reduce(|a, b| if b.value() < a.value() { b } else { a });
    depth_ratio * slowest.unwrap_or_else(|| unreachable!("there is a mode"))
}

impl HomogeneousMedium {
    /// Checks that `medium` has a valid albedo and moments, and that `streams` ordinates resolve its phase function.
    /// With too few ordinates for a narrow peak that is not forward, the discrete medium would create light.
    ///
    /// # Errors
    /// [`TransportError::Range`], [`TransportError::Streams`] or [`TransportError::Unresolved`].
    pub fn check(medium: &Scattering, streams: usize) -> Result<(), TransportError> {
        Streams::Exactly(streams).check()?;
        let within = |quantity, least, greatest| ParameterRange { quantity, least, greatest, unit: "" };
        within("co-albedo", 0.0, 1.0).check(medium.one_minus_albedo)?;
        within("number of moments", streams as f64 + 1.0, 1e9).check(medium.moments.len() as f64)?;
        medium.moments.iter().try_for_each(|chi| within("moment", -1.0, 1.0).check(*chi))?;
        let modes = Modes::new(&Scaled::new(medium, streams), Quadrature::half_range(streams / 2));
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
        let scaled = Scaled::new(medium, streams);
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
            ice_index: None,
        }
    }

    /// Clear ice of a refractive index, for layers whose optical depth is the optical depth of absorption. Each
    /// ordinate outside the ice takes the place of a mode: V = 1 and H = M⁻¹. The rates are 1, the rate of light
    /// along the normal.
    pub(super) fn ice(index: f64, streams: usize) -> Self {
        let rule = Quadrature::half_range(streams / 2);
        let n = rule.order();
        let diagonal = |of: &dyn Fn(f64) -> f64| {
            DMatrix::from_diagonal(&DVector::from_iterator(n, rule.cosines.iter().map(|mu| of(*mu))))
        };
        let isotropic = DVector::from_iterator(n, rule.weights.iter().map(|weight| weight.sqrt()));
        let (identity, delta, gamma) = (DMatrix::identity(n, n), diagonal(&|mu| mu), diagonal(&f64::recip));
        Self {
            scaled: Scaled { one_minus_albedo: 1.0, albedo_moments: vec![0.0; streams], depth_ratio: 1.0 },
            modes: Modes { rates: vec![1.0; n], sums: identity.clone(), differences: gamma.clone() },
            basis: legendre_basis(n),
            entering: [isotropic.clone(), &delta * isotropic],
            weighted_differences: identity,
            gamma,
            delta,
            ice_index: Some(index),
        }
    }

    /// Prepares a beam whose cosine from the normal is `cos_incidence`, in (0, 1].
    #[must_use]
    pub fn beam(&self, cos_incidence: f64) -> ModalLight {
        ModalLight::Beam(self.direction(cos_incidence))
    }

    /// Prepares a beam or Lambertian light.
    #[must_use]
    pub fn light(&self, incidence: &Incidence) -> ModalLight {
        match incidence {
            Incidence::Beam { angle_deg } => self.beam(angle_deg.to_radians().cos()),
            Incidence::Diffuse => ModalLight::Lambertian,
        }
    }

    pub(super) fn direction(&self, cos_incidence: f64) -> Direction {
        let strengths = strengths(&self.scaled.albedo_moments, cos_incidence);
        let shape = |parity: usize, modes: &DMatrix<f64>| {
            let mut source = DVector::zeros(self.basis.nrows());
            for l in (parity..strengths.len()).step_by(2) {
                source.axpy(strengths[l], &self.basis.column(l), 1.0);
            }
            modes.tr_mul(&source).as_slice().to_vec()
        };
        let (even, odd) = (shape(0, &self.modes.sums), shape(1, &self.modes.differences));
        Direction { cos_incidence, even, odd }
    }

    /// Vᵀ 1: the fluence rate of each mode.
    pub(super) fn isotropic_sums(&self) -> DVector<f64> {
        self.modes.sums.tr_mul(&self.basis.column(0))
    }

    /// Decay rate of light far from all faces: the rate of the slowest mode per (unscaled) optical depth.
    #[must_use]
    pub fn decay_rate(&self) -> f64 {
        decay_rate(self.scaled.depth_ratio, &self.modes.rates)
    }

    /// Fluxes of a slab of (unscaled) `optical_depth`, which may be infinite, under each of `lights`.
    #[must_use]
    pub fn fluxes<'l>(
        &self,
        optical_depth: f64,
        lights: impl IntoIterator<Item = &'l ModalLight>,
    ) -> Vec<MediumFluxes> {
        let depth = optical_depth * self.scaled.depth_ratio;
        let solution = self.solve_slab(depth);
        let slab = self.lit(&solution);
        let under = |light: &ModalLight| {
            let Passed { reflectance, transmittance } = slab.passed(light);
            let direct = match light {
                ModalLight::Beam(direction) => (-optical_depth / direction.cos_incidence).exp(),
                ModalLight::Lambertian => 2.0 * third_exponential_integral(optical_depth),
            };
            MediumFluxes { reflectance, transmittance, direct }
        };
        lights.into_iter().map(under).collect()
    }

    /// A slab under isotropic light from above, whose systems have been solved.
    pub(super) fn lit(&self, solution: &SlabSolution) -> LitSlab<'_> {
        let SlabSolution { symmetric: a, antisymmetric: b, bottom: c, bottom_slope: slope, .. } = solution;
        let modes = self.modes.rates.iter().zip(&solution.transfers).enumerate();
        LitSlab {
            rates: &self.modes.rates,
            entering: self.entering[1].as_slice(),
            depth: solution.depth,
            amplitudes: modes.map(|(j, (k, mode))| mode.amplitudes(*k, [a[j], b[j], c[j], slope[j]])).collect(),
        }
    }

    /// Solves the linear systems of a slab of a scaled optical depth.
    pub(super) fn solve_slab(&self, depth: f64) -> SlabSolution {
        let transfers: Vec<Transfer> = self.modes.rates.iter().map(|k| Transfer::new(*k, depth)).collect();
        let of = |f: fn(&Transfer) -> f64| DVector::from_iterator(transfers.len(), transfers.iter().map(f));
        let antisymmetric_factor = solver(&self.gamma, &of(|mode| mode.over_rate));
        let antisymmetric = antisymmetric_factor.solve(&self.entering[0]);
        let symmetric_factor = solver(&self.delta, &of(|mode| mode.times_rate));
        let symmetric = symmetric_factor.solve(&self.entering[1]);
        let bottom = symmetric_factor.solve(&of(|mode| mode.square_sech).component_mul(&antisymmetric));
        let bottom_slope = &self.delta * &bottom;
        SlabSolution {
            depth,
            transfers,
            symmetric_factor,
            antisymmetric_factor,
            symmetric,
            antisymmetric,
            bottom,
            bottom_slope,
        }
    }
}

/// √(2l + 1) ω χ_l P_l(μ₀) for each l.
pub(super) fn strengths<T: Real>(albedo_moments: &[T], cos_incidence: T) -> Vec<T> {
    let mut strengths = vec![T::from(0.0); albedo_moments.len()];
    legendre_polynomials(cos_incidence, &mut strengths);
    for (l, (strength, moment)) in strengths.iter_mut().zip(albedo_moments).enumerate() {
        *strength = *moment * ((2 * l + 1) as f64).sqrt() * *strength;
    }
    strengths
}

impl<T: Real> Passed<T> {
    /// Absorptance of the snow over a ground of this albedo, where the transmittance is the downward flux on the
    /// ground.
    pub(super) fn absorbed(self, ground_albedo: T) -> T {
        T::from(1.0) - self.reflectance - (T::from(1.0) - ground_albedo) * self.transmittance
    }

    /// Reflectance, transmittance and absorptance over a ground of this albedo.
    pub(super) fn fluxes(self, ground_albedo: T) -> Fluxes<T> {
        Fluxes::from([self.reflectance, self.transmittance, self.absorbed(ground_albedo)])
    }
}

impl<T: Real> Transfer<T> {
    pub(super) fn new(k: T, depth: T) -> Self {
        let (over_rate, tanh) = tanh_over_rate(k, depth);
        let decay = (-k * depth).exp();
        let square_sech = decay * 4.0 / ((decay + 1.0) * (decay + 1.0));
        Self { times_rate: k * tanh, over_rate, square_sech, decay }
    }

    /// The amplitudes of the mode with the rate k for a, b, c and Δ c.
    pub(super) fn amplitudes(&self, k: T, [a, b, c, slope]: [T; 4]) -> Amplitudes<T> {
        Amplitudes {
            top: a + self.over_rate * b,
            top_slope: -(self.times_rate * a + b),
            bottom: c,
            bottom_slope: slope,
            fading: T::from(1.0) / (self.decay + 1.0) * (a + b / k),
            decay: self.decay,
        }
    }
}

impl<T: Real> LitSlab<'_, T> {
    /// By reciprocity, the reflectance and transmittance under a light.
    pub(super) fn passed(&self, light: &ModalLight<T>) -> Passed<T> {
        match light {
            ModalLight::Beam(direction) => self.leaving(direction),
            ModalLight::Lambertian => {
                let flux = |amplitude: fn(&Amplitudes<T>) -> T| {
                    let terms = self.entering.iter().zip(&self.amplitudes).map(|(v, mode)| *v * amplitude(mode));
                    terms.fold(T::from(0.0), T::add) * 2.0
                };
                Passed { reflectance: flux(|mode| mode.top) - 1.0, transmittance: flux(|mode| mode.bottom) }
            }
        }
    }

    /// Radiance that leaves both faces in a direction.
    fn leaving(&self, direction: &Direction<T>) -> Passed<T> {
        let depth = self.depth;
        let per_cosine = T::from(1.0) / direction.cos_incidence;
        let unscattered = (-depth * per_cosine).exp();
        let (mut reflected, mut transmitted) = (T::from(0.0), T::from(0.0));
        for (j, (&k, mode)) in self.rates.iter().zip(&self.amplitudes).enumerate() {
            let (even, odd) = (direction.even[j] * 0.5, direction.odd[j] * 0.5);
            if k.value() < 0.5 && k.value() * depth.value() < 1.0 {
                let (cosh, sinh_over_k) = hyperbolic_integrals(k, depth, per_cosine, unscattered);
                let from_face = |amplitude: T, slope: T| {
                    amplitude * (even * cosh + odd * k * k * sinh_over_k) + slope * (even * sinh_over_k + odd * cosh)
                };
                reflected += from_face(mode.top, mode.top_slope);
                transmitted += from_face(mode.bottom, mode.bottom_slope);
            } else {
                let (near, far) = exponential_integrals(k, depth, per_cosine);
                let growing = mode.bottom - mode.fading * mode.decay;
                reflected += (even - odd * k) * mode.fading * near + (even + odd * k) * growing * far;
                transmitted += (even + odd * k) * mode.fading * far + (even - odd * k) * growing * near;
            }
        }
        Passed { reflectance: reflected, transmittance: transmitted + unscattered }
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
