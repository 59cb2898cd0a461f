//! Derivatives of the fluxes of a homogeneous slab, by the tangent-linear equations of its modes.
//!
//! **Modes.** Where a medium changes E and O by dE and dO, its modes change by
//!
//! ```text
//! ε = Vᵀ dE V,   o = Hᵀ dO H,   d(k_i²) = ε_ii + k_i² o_ii,
//! dV = V X,   dH = −H Xᵀ,   X_ii = o_ii/2,   X_ij = (ε_ij + k_j² o_ij)/(k_j² − k_i²),
//! ```
//!
//! which follows from φ' = (1 + o) ψ, ψ' = (k² + ε) φ with S = V φ and D = −H ψ (Spurr, Kurosu & Chance 2001,
//! doi:10.1016/S0022-4073(00)00055-8, differentiate the usual form of the equations). No two modes have the same rate.
//! Then dΓ = −X Γ − Γ Xᵀ, dΔ = Xᵀ Δ + Δ X, d(Hᵀ M 1) = −X Hᵀ M 1 and d(Vᵀ M 1) = Xᵀ Vᵀ M 1.
//!
//! **Linear systems.** Of A a = v follows A da = dv − dA a: a variable costs a right-hand side of the system whose
//! matrix is already factored.
//!
//! All else is computed by the lines that compute the values, with numbers that have derivatives.

use nalgebra::{DMatrix, DVector};

use super::delta_m::Scaled;
use super::homogeneous::{Direction, HomogeneousMedium, Light, LitSlab, SlabSolution, Transfer, strengths};
use crate::dual::{Dual, LANES, Real};
use crate::slab::Incidence;

/// A homogeneous medium with its derivatives by up to [`LANES`] variables.
pub(super) struct DifferentiatedMedium<'m> {
    medium: &'m HomogeneousMedium,
    scaled: Scaled<Dual>,
    rates: Vec<Dual>,
    /// X for each variable; none where it does not change the modes.
    changes: Vec<Option<DMatrix<f64>>>,
    /// Vᵀ p_l for even l and Hᵀ p_l for odd l: a column for each l.
    shapes: DMatrix<f64>,
    /// Vᵀ M 1.
    entering: Vec<Dual>,
}

impl<'m> DifferentiatedMedium<'m> {
    /// `medium` with the derivatives that `scaled` has by the first `count` variables.
    pub(super) fn new(medium: &'m HomogeneousMedium, scaled: Scaled<Dual>, count: usize) -> Self {
        let modes = &medium.modes;
        let mut shapes = DMatrix::zeros(modes.rates.len(), medium.basis.ncols());
        for (l, mut shape) in shapes.column_iter_mut().enumerate() {
            let matrix = if l % 2 == 0 { &modes.sums } else { &modes.differences };
            shape.gemv_tr(1.0, matrix, &medium.basis.column(l), 0.0);
        }
        let change = |lane: usize| ModeChange::new(&modes.rates, &scaled, &shapes, lane);
        let changes: Vec<Option<ModeChange>> = (0..count).map(change).collect();
        let squares = |lane: usize| changes[lane].as_ref().map(|change| &change.squared_rates);
        let rates = modes.rates.iter().enumerate();
        let rates = rates.map(|(j, k)| {
            Dual::new(*k, by_lane(count, |lane| squares(lane).map_or(0.0, |squares| 0.5 * squares[j] / k)))
        });
        let rates = rates.collect();
        let changes: Vec<Option<DMatrix<f64>>> = changes.into_iter().map(|change| Some(change?.shapes)).collect();
        let entering = with_derivatives(&medium.entering[1], &changes, |change, v| change.tr_mul(v));
        Self { medium, scaled, rates, changes, shapes, entering }
    }

    /// A beam, whose cosine from the normal `cosine` gives derivatives, or Lambertian light.
    pub(super) fn light(&self, incidence: &Incidence, cosine: impl Fn(f64) -> Dual) -> Light<Dual> {
        match incidence {
            Incidence::Beam { angle_deg } => Light::Beam(self.direction(cosine(angle_deg.to_radians().cos()))),
            Incidence::Diffuse => Light::Lambertian,
        }
    }

    fn direction(&self, cos_incidence: Dual) -> Direction<Dual> {
        let strengths = strengths(&self.scaled.albedo_moments, cos_incidence);
        let shape = |parity: usize, changed: fn(&DMatrix<f64>, &DVector<f64>) -> DVector<f64>| {
            let sum = |j: usize| {
                let terms = (parity..strengths.len()).step_by(2).map(|l| strengths[l] * self.shapes[(j, l)]);
                terms.fold(Dual::from(0.0), |sum, term| sum + term)
            };
            let sums: Vec<Dual> = (0..self.rates.len()).map(sum).collect();
            let values = DVector::from_iterator(sums.len(), sums.iter().map(|sum| sum.value()));
            let by_modes = with_derivatives(&values, &self.changes, changed);
            sums.into_iter().zip(by_modes).map(|(sum, by_modes)| sum + (by_modes - by_modes.value())).collect()
        };
        let even = shape(0, |change, values| change.tr_mul(values));
        let odd = shape(1, |change, values| -(change * values));
        Direction { cos_incidence, even, odd }
    }

    /// A slab of (unscaled) `optical_depth` under isotropic light from above.
    pub(super) fn lit(&self, optical_depth: Dual) -> LitSlab<'_, Dual> {
        let is_half_space = optical_depth.value().is_infinite();
        let depth = if is_half_space { optical_depth } else { optical_depth * self.scaled.depth_ratio };
        let values = self.medium.modes.rates.iter().map(|k| Transfer::new(*k, depth.value()));
        let solution = self.medium.solve_slab(&values.collect::<Vec<_>>());
        let transfers: Vec<Transfer<Dual>> = self.rates.iter().map(|k| Transfer::new(*k, depth)).collect();
        let tangents = (0..self.changes.len()).map(|lane| self.tangent(&solution, &transfers, lane));
        let tangents: Vec<SlabTangent> = tangents.collect();
        let amplitudes = transfers.iter().zip(&self.rates).enumerate().map(|(j, (transfer, k))| {
            let number = |values: &DVector<f64>, of: fn(&SlabTangent) -> &DVector<f64>| {
                Dual::new(values[j], by_lane(tangents.len(), |lane| of(&tangents[lane])[j]))
            };
            let numbers = [
                number(&solution.symmetric, |tangent| &tangent.symmetric),
                number(&solution.antisymmetric, |tangent| &tangent.antisymmetric),
                number(&solution.bottom, |tangent| &tangent.bottom),
                number(&solution.bottom_slope, |tangent| &tangent.bottom_slope),
            ];
            transfer.amplitudes(*k, depth, numbers)
        });
        let amplitudes = amplitudes.collect();
        LitSlab { rates: &self.rates, entering: &self.entering, depth, amplitudes }
    }

    /// The derivatives of the solutions by one variable.
    fn tangent(&self, solution: &SlabSolution, transfers: &[Transfer<Dual>], lane: usize) -> SlabTangent {
        let of = |f: fn(&Transfer<Dual>) -> Dual| {
            DVector::from_iterator(transfers.len(), transfers.iter().map(|mode| f(mode).derivatives()[lane]))
        };
        let HomogeneousMedium { gamma, delta, entering: [h, v], .. } = self.medium;
        let SlabSolution { symmetric: a, antisymmetric: b, bottom: c, bottom_slope, .. } = solution;
        let change = self.changes[lane].as_ref();
        // dΔ u.
        let changed_delta =
            |x: &DMatrix<f64>, u: &DVector<f64>, delta_u: &DVector<f64>| x.tr_mul(delta_u) + delta * (x * u);
        let mut for_b = -of(|mode| mode.over_rate).component_mul(b);
        let by_depth = of(|mode| mode.times_rate);
        let mut for_a = -by_depth.component_mul(a);
        let mut slope_at_c = DVector::zeros(c.len());
        if let Some(x) = change {
            for_b += x * (gamma * b - h) + gamma * x.tr_mul(b);
            for_a += x.tr_mul(v) - changed_delta(x, a, &(delta * a));
            slope_at_c = changed_delta(x, c, bottom_slope);
        }
        let antisymmetric = solution.antisymmetric_factor.solve(&for_b);
        let symmetric = solution.symmetric_factor.solve(&for_a);
        let square_sech = DVector::from_iterator(c.len(), transfers.iter().map(|mode| mode.square_sech.value()));
        let passed = of(|mode| mode.square_sech).component_mul(b) + square_sech.component_mul(&antisymmetric);
        let bottom = solution.symmetric_factor.solve(&(passed - by_depth.component_mul(c) - &slope_at_c));
        SlabTangent { bottom_slope: delta * &bottom + slope_at_c, symmetric, antisymmetric, bottom }
    }
}

/// Derivatives of a [`SlabSolution`] by one variable.
struct SlabTangent {
    symmetric: DVector<f64>,
    antisymmetric: DVector<f64>,
    bottom: DVector<f64>,
    bottom_slope: DVector<f64>,
}

/// The change of modes with one variable.
struct ModeChange {
    /// d(k²) of each mode.
    squared_rates: Vec<f64>,
    /// X.
    shapes: DMatrix<f64>,
}

impl ModeChange {
    /// None if the variable does not change the medium.
    fn new(rates: &[f64], scaled: &Scaled<Dual>, shapes: &DMatrix<f64>, lane: usize) -> Option<Self> {
        // The isotropic direction is an eigenvector of E with the eigenvalue 1 − ω.
        let isotropic = -scaled.one_minus_albedo.derivatives()[lane];
        let others = scaled.albedo_moments.iter().skip(1).map(|moment| moment.derivatives()[lane]);
        let moments: Vec<f64> = std::iter::once(isotropic).chain(others).collect();
        if moments.iter().all(|moment| moment.is_zero()) {
            return None;
        }
        let n = rates.len();
        let product = |parity: usize| {
            let mut product = DMatrix::zeros(n, n);
            for l in (parity..moments.len()).step_by(2) {
                product.ger(-moments[l], &shapes.column(l), &shapes.column(l), 1.0);
            }
            product
        };
        let (even, odd) = (product(0), product(1));
        let squares: Vec<f64> = rates.iter().map(|k| k * k).collect();
        let entry = |i: usize, j: usize| {
            // A difference of rates, not of their squares, keeps its precision.
            let gap = (rates[j] - rates[i]) * (rates[j] + rates[i]);
            if i == j { 0.5 * odd[(i, i)] } else { (even[(i, j)] + squares[j] * odd[(i, j)]) / gap }
        };
        Some(Self {
            squared_rates: (0..n).map(|i| even[(i, i)] + squares[i] * odd[(i, i)]).collect(),
            shapes: DMatrix::from_fn(n, n, entry),
        })
    }
}

/// A number for each of the first `count` variables.
fn by_lane(count: usize, of: impl Fn(usize) -> f64) -> [f64; LANES] {
    std::array::from_fn(|lane| if lane < count { of(lane) } else { 0.0 })
}

/// Numbers whose derivatives by each variable are a linear function of them.
fn with_derivatives(
    values: &DVector<f64>,
    changes: &[Option<DMatrix<f64>>],
    changed: fn(&DMatrix<f64>, &DVector<f64>) -> DVector<f64>,
) -> Vec<Dual> {
    let derivatives: Vec<Option<DVector<f64>>> =
        changes.iter().map(|change| Some(changed(change.as_ref()?, values))).collect();
    let of = |j: usize| by_lane(changes.len(), |lane| derivatives[lane].as_ref().map_or(0.0, |of| of[j]));
    values.iter().enumerate().map(|(j, value)| Dual::new(*value, of(j))).collect()
}
