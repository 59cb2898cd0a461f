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

use nalgebra::{DMatrix, DVector, Dyn};

use super::delta_m::Scaled;
use super::homogeneous::{Direction, HomogeneousMedium, Light, LitSlab, SlabSolution, Transfer, strengths};
use crate::dual::{Dual, LANES, Real};
use crate::slab::Incidence;

/// A homogeneous medium with its derivatives by up to [`LANES`] variables.
pub(super) struct DifferentiatedMedium<'m> {
    medium: &'m HomogeneousMedium,
    scaled: Scaled<Dual>,
    rates: Vec<Dual>,
    /// Number of variables.
    count: usize,
    /// X of each variable, one below the other; 0 where it does not change the modes.
    changes: DMatrix<f64>,
    /// Xᵀ of each variable, one below the other.
    transposed_changes: DMatrix<f64>,
    /// Vᵀ p_l for even l and Hᵀ p_l for odd l: a column for each l.
    shapes: DMatrix<f64>,
    /// Vᵀ M 1.
    entering: Vec<Dual>,
}

impl<'m> DifferentiatedMedium<'m> {
    /// `medium` with the derivatives that `scaled` has by the first `count` variables.
    pub(super) fn new(medium: &'m HomogeneousMedium, scaled: Scaled<Dual>, count: usize) -> Self {
        let modes = &medium.modes;
        let n = modes.rates.len();
        let mut shapes = DMatrix::zeros(n, medium.basis.ncols());
        for (l, mut shape) in shapes.column_iter_mut().enumerate() {
            let matrix = if l % 2 == 0 { &modes.sums } else { &modes.differences };
            shape.gemv_tr(1.0, matrix, &medium.basis.column(l), 0.0);
        }
        let (mut changes, mut transposed_changes) = (DMatrix::zeros(n * count, n), DMatrix::zeros(n * count, n));
        let mut squared_rates = vec![[0.0; LANES]; n];
        for lane in 0..count {
            if let Some(change) = ModeChange::new(&modes.rates, &scaled, &shapes, lane) {
                changes.rows_mut(n * lane, n).copy_from(&change.shapes);
                transposed_changes.rows_mut(n * lane, n).copy_from(&change.shapes.transpose());
                squared_rates.iter_mut().zip(change.squared_rates).for_each(|(lanes, rate)| lanes[lane] = rate);
            }
        }
        let rates = modes.rates.iter().zip(squared_rates);
        let rates = rates.map(|(k, squares)| Dual::new(*k, squares.map(|square| 0.5 * square / k))).collect();
        let mut differentiated =
            Self { medium, scaled, rates, count, changes, transposed_changes, shapes, entering: Vec::new() };
        let entering = &medium.entering[1];
        differentiated.entering = with_derivatives(entering, &differentiated.transposed_changes(entering));
        differentiated
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
        let shape = |parity: usize, changed: &dyn Fn(&DVector<f64>) -> DMatrix<f64>| -> Vec<Dual> {
            let sum = |j: usize| {
                let terms = (parity..strengths.len()).step_by(2).map(|l| strengths[l] * self.shapes[(j, l)]);
                terms.fold(Dual::from(0.0), |sum, term| sum + term)
            };
            let sums: Vec<Dual> = (0..self.rates.len()).map(sum).collect();
            let values = DVector::from_iterator(sums.len(), sums.iter().map(|sum| sum.value()));
            let by_modes = with_derivatives(&DVector::zeros(values.len()), &changed(&values));
            sums.into_iter().zip(by_modes).map(|(sum, by_modes)| sum + by_modes).collect()
        };
        let even = shape(0, &|values| self.transposed_changes(values));
        let odd = shape(1, &|values| -self.changes(values));
        Direction { cos_incidence, even, odd }
    }

    /// A slab of (unscaled) `optical_depth` under isotropic light from above, whose systems have been solved.
    pub(super) fn lit(&self, optical_depth: Dual, solution: &SlabSolution) -> LitSlab<'_, Dual> {
        let is_half_space = optical_depth.value().is_infinite();
        let depth = if is_half_space { optical_depth } else { optical_depth * self.scaled.depth_ratio };
        let transfers: Vec<Transfer<Dual>> = self.rates.iter().map(|k| Transfer::new(*k, depth)).collect();
        let tangents = self.tangents(solution, &transfers);
        let amplitudes = transfers.iter().zip(&self.rates).enumerate().map(|(j, (transfer, k))| {
            let number = |values: &DVector<f64>, tangents: &DMatrix<f64>| {
                Dual::new(values[j], by_lane(self.count, |lane| tangents[(j, lane)]))
            };
            let numbers = [
                number(&solution.symmetric, &tangents.symmetric),
                number(&solution.antisymmetric, &tangents.antisymmetric),
                number(&solution.bottom, &tangents.bottom),
                number(&solution.bottom_slope, &tangents.bottom_slope),
            ];
            transfer.amplitudes(*k, numbers)
        });
        let amplitudes = amplitudes.collect();
        LitSlab { rates: &self.rates, entering: &self.entering, depth, amplitudes }
    }

    /// The derivatives of the solutions of a slab:
    ///
    /// ```text
    /// (Γ + diag t/k) db = Γ Xᵀ b − X (t/k) b − d(t/k) b,
    /// (Δ + diag k t) da = Xᵀ k t a − Δ X a − d(k t) a,
    /// (Δ + diag k t) dc = d(sech² b) − dΔ c − d(k t) c,     dΔ c = Xᵀ Δ c + Δ X c.
    /// ```
    fn tangents(&self, solution: &SlabSolution, transfers: &[Transfer<Dual>]) -> SlabTangents {
        let SlabSolution { symmetric: a, antisymmetric: b, bottom: c, .. } = solution;
        let n = transfers.len();
        // Row by row, the derivatives of a factor of each mode times an amplitude.
        let changed = |factor: fn(&Transfer<Dual>) -> Dual, amplitude: &DVector<f64>| {
            DMatrix::from_fn(n, self.count, |j, lane| factor(&transfers[j]).derivatives()[lane] * amplitude[j])
        };
        let times = |factor: fn(&Transfer) -> f64, amplitude: &DVector<f64>| {
            DVector::from_iterator(
                n,
                solution.transfers.iter().zip(amplitude).map(|(mode, value)| factor(mode) * value),
            )
        };
        let HomogeneousMedium { gamma, delta, .. } = self.medium;
        let over_rate = times(|mode| mode.over_rate, b);
        let mut antisymmetric = gamma * self.transposed_changes(b) - self.changes(&over_rate);
        antisymmetric -= changed(|mode| mode.over_rate, b);
        solution.antisymmetric_factor.solve_mut(&mut antisymmetric);
        let times_rate = times(|mode| mode.times_rate, a);
        let mut symmetric = self.transposed_changes(&times_rate) - delta * self.changes(a);
        symmetric -= changed(|mode| mode.times_rate, a);
        solution.symmetric_factor.solve_mut(&mut symmetric);
        let change_of_slope = self.transposed_changes(&solution.bottom_slope) + delta * self.changes(c);
        let mut bottom = antisymmetric.clone();
        for (mut row, mode) in bottom.row_iter_mut().zip(&solution.transfers) {
            row *= mode.square_sech;
        }
        bottom += changed(|mode| mode.square_sech, b) - changed(|mode| mode.times_rate, c) - &change_of_slope;
        solution.symmetric_factor.solve_mut(&mut bottom);
        let bottom_slope = delta * &bottom + change_of_slope;
        SlabTangents { symmetric, antisymmetric, bottom, bottom_slope }
    }

    /// X u: a column for each variable.
    fn changes(&self, vector: &DVector<f64>) -> DMatrix<f64> {
        self.columns(&self.changes * vector)
    }

    /// Xᵀ u: a column for each variable.
    fn transposed_changes(&self, vector: &DVector<f64>) -> DMatrix<f64> {
        self.columns(&self.transposed_changes * vector)
    }

    fn columns(&self, stacked: DVector<f64>) -> DMatrix<f64> {
        stacked.reshape_generic(Dyn(self.rates.len()), Dyn(self.count))
    }
}

/// Derivatives of a [`SlabSolution`]: a column for each variable.
struct SlabTangents {
    symmetric: DMatrix<f64>,
    antisymmetric: DMatrix<f64>,
    bottom: DMatrix<f64>,
    bottom_slope: DMatrix<f64>,
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

/// Numbers with their derivatives, which have a column for each variable.
fn with_derivatives(values: &DVector<f64>, derivatives: &DMatrix<f64>) -> Vec<Dual> {
    let of = |j: usize| by_lane(derivatives.ncols(), |lane| derivatives[(j, lane)]);
    values.iter().enumerate().map(|(j, value)| Dual::new(*value, of(j))).collect()
}
