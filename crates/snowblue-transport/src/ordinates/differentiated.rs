//! Derivatives of the fluxes of a homogeneous slab, by the tangent-linear equations of its modes.
//!
//! **Modes.** Where a medium changes E and O by dE and dO, its modes change by
//!
//! ```text
//! ε = Vᵀ dE V,   o = Hᵀ dO H,   d(k_i²) = ε_ii + k_i² o_ii,
//! dV = V X,   dH = −H Xᵀ,   X_ii = o_ii/2,   X_ij = (ε_ij + k_j² o_ij)/(k_j² − k_i²),
//! ```
//!
//! which follows from φ' = (1 + o) ψ, ψ' = (k² + ε) φ with S = V φ and D = −H ψ. Spurr, Kurosu & Chance 2001, J.
//! Quant. Spectrosc. Radiat. Transfer 68, 689, differentiate the usual form of the equations. No two modes have equal
//! rates. Then dΓ = −X Γ − Γ Xᵀ, dΔ = Xᵀ Δ + Δ X, d(Hᵀ M 1) = −X Hᵀ M 1 and d(Vᵀ M 1) = Xᵀ Vᵀ M 1.
//!
//! **Linear systems.** A a = v implies A da = dv − dA a: each variable costs one right-hand side of the system, whose
//! matrix is already factored.
//!
//! All other quantities are computed by the code that computes the values, with numbers that have derivatives.

use std::ops::Mul;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::eigen::Scaled;
use super::homogeneous::{
    Direction, HomogeneousMedium, LitSlab, ModalLight, SlabSolution, Transfer, decay_rate, strengths,
};
use crate::dual::{Dual, LANES, Real};
use crate::slab::Incidence;

/// The modes of a medium with their derivatives by up to [`LANES`] variables.
pub(super) struct DifferentiatedModes {
    pub(super) scaled: Scaled<Dual>,
    pub(super) rates: Vec<Dual>,
    /// X, with the value 0.
    change: DMatrix<Dual>,
    /// Vᵀ p_l for even l and Hᵀ p_l for odd l: a column for each l.
    shapes: DMatrix<f64>,
}

/// A homogeneous medium with its derivatives by up to [`LANES`] variables.
pub(super) struct DifferentiatedMedium {
    modes: DifferentiatedModes,
    /// Γ.
    gamma: DMatrix<Dual>,
    /// Δ.
    delta: DMatrix<Dual>,
    /// Hᵀ M 1 and Vᵀ M 1.
    entering: [Vec<Dual>; 2],
}

impl DifferentiatedModes {
    /// The modes of `medium` with the derivatives of `scaled`.
    pub(super) fn new(medium: &HomogeneousMedium, scaled: Scaled<Dual>) -> Self {
        Self::with_changes(medium, scaled).0
    }

    /// The modes with their derivatives, and the change of the modes with each variable.
    fn with_changes(medium: &HomogeneousMedium, scaled: Scaled<Dual>) -> (Self, [Option<ModeChange>; LANES]) {
        let modes = &medium.modes;
        let n = modes.rates.len();
        let mut shapes = DMatrix::zeros(n, medium.basis.ncols());
        for (l, mut shape) in shapes.column_iter_mut().enumerate() {
            let matrix = if l % 2 == 0 { &modes.sums } else { &modes.differences };
            shape.gemv_tr(1.0, matrix, &medium.basis.column(l), 0.0);
        }
        let changes: [Option<ModeChange>; LANES] =
            std::array::from_fn(|lane| ModeChange::new(&modes.rates, &scaled, &shapes, lane));
        let by_change =
            |of: &dyn Fn(&ModeChange) -> f64| changes.each_ref().map(|change| change.as_ref().map_or(0.0, of));
        let change = DMatrix::from_fn(n, n, |i, j| Dual::new(0.0, by_change(&|change| change.shapes[(i, j)])));
        let rate = |(j, k): (usize, &f64)| Dual::new(*k, by_change(&|change| 0.5 * change.squared_rates[j] / k));
        let rates = modes.rates.iter().enumerate().map(rate).collect();
        (Self { rates, scaled, change, shapes }, changes)
    }

    /// X u.
    pub(super) fn changed(&self, vector: &DVector<f64>) -> Vec<Dual> {
        product(&self.change, vector.as_slice())
    }

    /// Xᵀ u.
    pub(super) fn changed_transposed(&self, vector: &DVector<f64>) -> Vec<Dual> {
        transposed_product(&self.change, vector.as_slice())
    }

    pub(super) fn direction(&self, cos_incidence: Dual) -> Direction<Dual> {
        let strengths = strengths(&self.scaled.albedo_moments, cos_incidence);
        let sums = |parity: usize| {
            let mut sums = vec![Dual::from(0.0); self.rates.len()];
            for l in (parity..strengths.len()).step_by(2) {
                sums.iter_mut().zip(&self.shapes.column(l)).for_each(|(sum, shape)| *sum += strengths[l] * *shape);
            }
            let values: Vec<f64> = sums.iter().map(|sum| sum.value()).collect();
            (sums, values)
        };
        let ((even, even_values), (odd, odd_values)) = (sums(0), sums(1));
        let (by_sums, by_differences) =
            (transposed_product(&self.change, &even_values), product(&self.change, &odd_values));
        Direction {
            cos_incidence,
            even: even.into_iter().zip(by_sums).map(|(even, by)| even + by).collect(),
            odd: odd.into_iter().zip(by_differences).map(|(odd, by)| odd - by).collect(),
        }
    }

    /// The decay rate, as [`HomogeneousMedium::decay_rate`].
    pub(super) fn decay_rate(&self) -> Dual {
        decay_rate(self.scaled.depth_ratio, &self.rates)
    }

    /// The scaled optical depth of a thickness in cm of a medium with this extinction coefficient.
    pub(super) fn depth(&self, extinction_per_m: Dual, thickness_cm: Dual) -> Dual {
        if thickness_cm.value().is_infinite() {
            return Dual::from(f64::INFINITY);
        }
        extinction_per_m * thickness_cm * 0.01 * self.scaled.depth_ratio
    }
}

impl DifferentiatedMedium {
    /// `medium` with the derivatives of `scaled`.
    pub(super) fn new(medium: &HomogeneousMedium, scaled: Scaled<Dual>) -> Self {
        let HomogeneousMedium { gamma, delta, entering: [h, v], .. } = medium;
        let (modes, changes) = DifferentiatedModes::with_changes(medium, scaled);
        let n = modes.rates.len();
        // Half of dΓ and of dΔ, to which its transpose is added.
        let halves = |half: &dyn Fn(&DMatrix<f64>) -> DMatrix<f64>| {
            changes.each_ref().map(|change| change.as_ref().map(|ModeChange { shapes: x, .. }| half(x)))
        };
        let symmetric = |matrix: &DMatrix<f64>, halves: &[Option<DMatrix<f64>>; LANES]| {
            let by = |i: usize, j: usize| {
                halves.each_ref().map(|half| half.as_ref().map_or(0.0, |half| half[(i, j)] + half[(j, i)]))
            };
            DMatrix::from_fn(n, n, |i, j| Dual::new(matrix[(i, j)], by(i, j)))
        };
        Self {
            gamma: symmetric(gamma, &halves(&|x| -(x * gamma))),
            delta: symmetric(delta, &halves(&|x| delta * x)),
            entering: [
                h.iter().zip(modes.changed(h)).map(|(h, by)| -by + *h).collect(),
                v.iter().zip(modes.changed_transposed(v)).map(|(v, by)| by + *v).collect(),
            ],
            modes,
        }
    }

    /// A beam, whose cosine from the normal `cosine` gives derivatives, or Lambertian light.
    pub(super) fn light(&self, incidence: &Incidence, cosine: impl Fn(f64) -> Dual) -> ModalLight<Dual> {
        match incidence {
            Incidence::Beam { angle_deg } => {
                ModalLight::Beam(self.modes.direction(cosine(angle_deg.to_radians().cos())))
            }
            Incidence::Diffuse => ModalLight::Lambertian,
        }
    }

    /// A slab of a thickness under isotropic light from above, whose systems have been solved.
    pub(super) fn lit(&self, extinction_per_m: Dual, thickness_cm: Dual, solution: &SlabSolution) -> LitSlab<'_, Dual> {
        let rates = &self.modes.rates;
        let depth = self.modes.depth(extinction_per_m, thickness_cm);
        let transfers: Vec<Transfer<Dual>> = rates.iter().map(|k| Transfer::new(*k, depth)).collect();
        let of = |f: fn(&Transfer<Dual>) -> Dual| transfers.iter().map(f).collect::<Vec<Dual>>();
        let SlabSolution { symmetric_factor, antisymmetric_factor, symmetric, antisymmetric, bottom, .. } = solution;
        let [h, v] = &self.entering;
        let b = solved(&self.gamma, &of(|mode| mode.over_rate), antisymmetric_factor, h, antisymmetric);
        let times_rate = of(|mode| mode.times_rate);
        let a = solved(&self.delta, &times_rate, symmetric_factor, v, symmetric);
        let passed: Vec<Dual> = transfers.iter().zip(&b).map(|(mode, b)| mode.square_sech * *b).collect();
        let c = solved(&self.delta, &times_rate, symmetric_factor, &passed, bottom);
        let slope = product(&self.delta, &c);
        let modes = rates.iter().zip(&transfers).enumerate();
        LitSlab {
            rates,
            entering: v,
            depth,
            amplitudes: modes.map(|(j, (k, mode))| mode.amplitudes(*k, [a[j], b[j], c[j], slope[j]])).collect(),
        }
    }
}

/// The solution of (A + diag d) a = v with its derivatives, from the factors of the matrix and the solution.
fn solved(
    matrix: &DMatrix<Dual>,
    diagonal: &[Dual],
    factor: &Cholesky<f64, Dyn>,
    right: &[Dual],
    solution: &DVector<f64>,
) -> Vec<Dual> {
    let product = product(matrix, solution.as_slice());
    let residual = right.iter().zip(product).zip(diagonal.iter().zip(solution));
    let mut numbers: Vec<Dual> = residual.map(|((v, product), (d, a))| *v - product - *d * *a).collect();
    // Substitutes for all variables at once, while nalgebra substitutes one column after another.
    let lower = factor.l_dirty();
    for (j, column) in lower.column_iter().enumerate() {
        numbers[j] = numbers[j] / column[j];
        for i in j + 1..numbers.len() {
            numbers[i] = numbers[i] - numbers[j] * column[i];
        }
    }
    for (j, column) in lower.column_iter().enumerate().rev() {
        for i in j + 1..numbers.len() {
            numbers[j] = numbers[j] - numbers[i] * column[i];
        }
        numbers[j] = numbers[j] / column[j];
    }
    numbers.into_iter().zip(solution).map(|(number, a)| Dual::new(*a, *number.derivatives())).collect()
}

/// A u.
fn product<T: Copy>(matrix: &DMatrix<Dual>, vector: &[T]) -> Vec<Dual>
where
    Dual: Mul<T, Output = Dual>,
{
    let mut sums = vec![Dual::from(0.0); matrix.nrows()];
    for (column, number) in matrix.column_iter().zip(vector) {
        sums.iter_mut().zip(&column).for_each(|(sum, entry)| *sum += *entry * *number);
    }
    sums
}

/// Aᵀ u.
fn transposed_product(matrix: &DMatrix<Dual>, vector: &[f64]) -> Vec<Dual> {
    let sum = |column: nalgebra::DVectorView<Dual>| {
        let terms = column.iter().zip(vector).map(|(entry, number)| *entry * *number);
        terms.fold(Dual::from(0.0), |sum, term| sum + term)
    };
    matrix.column_iter().map(sum).collect()
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
