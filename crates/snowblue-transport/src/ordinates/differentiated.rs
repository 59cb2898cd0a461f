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
        let modes = &medium.modes;
        let n = modes.rates.len();
        let mut shapes = DMatrix::zeros(n, medium.basis.ncols());
        for (l, mut shape) in shapes.column_iter_mut().enumerate() {
            let matrix = if l % 2 == 0 { &modes.sums } else { &modes.differences };
            shape.gemv_tr(1.0, matrix, &medium.basis.column(l), 0.0);
        }
        // ε and o, each with its derivatives by all variables.
        let [even, odd] = operator_changes(&scaled, &shapes);
        let squares: Vec<f64> = modes.rates.iter().map(|k| k * k).collect();
        let entry = |i: usize, j: usize| {
            let (even, odd) = (&even[(i, j)], &odd[(i, j)]);
            // A difference of rates, not of their squares, keeps its precision.
            let gap = (modes.rates[j] - modes.rates[i]) * (modes.rates[j] + modes.rates[i]);
            let of = |lane: usize| match i == j {
                true => 0.5 * odd[lane],
                false => quotient(even[lane] + squares[j] * odd[lane], gap),
            };
            Dual::new(0.0, std::array::from_fn(of))
        };
        let rate = |(j, k): (usize, &f64)| {
            let of = |lane: usize| quotient(even[(j, j)][lane] + squares[j] * odd[(j, j)][lane], 2.0 * k);
            Dual::new(*k, std::array::from_fn(of))
        };
        Self {
            rates: modes.rates.iter().enumerate().map(rate).collect(),
            change: DMatrix::from_fn(n, n, entry),
            shapes,
            scaled,
        }
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
        let modes = DifferentiatedModes::new(medium, scaled);
        let n = modes.rates.len();
        // The sum of a matrix and of a half of its change with its transpose.
        let changed = |matrix: &DMatrix<f64>, half: &dyn Fn(&DVector<f64>) -> Vec<Dual>| {
            let halves: Vec<Vec<Dual>> = matrix.column_iter().map(|column| half(&column.into_owned())).collect();
            DMatrix::from_fn(n, n, |i, j| halves[i][j] + halves[j][i] + matrix[(i, j)])
        };
        Self {
            gamma: changed(gamma, &|column| modes.changed(column).into_iter().map(|by| -by).collect()),
            delta: changed(delta, &|column| modes.changed_transposed(column)),
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

/// The changes of E and O with each variable, in the modes.
fn operator_changes(scaled: &Scaled<Dual>, shapes: &DMatrix<f64>) -> [DMatrix<[f64; LANES]>; 2] {
    [0, 1].map(|parity| {
        let mut sum = DMatrix::from_element(shapes.nrows(), shapes.nrows(), [0.0; LANES]);
        for l in (parity..scaled.albedo_moments.len()).step_by(2) {
            // The isotropic direction is an eigenvector of E with the eigenvalue 1 − ω.
            let change = if l == 0 { scaled.one_minus_albedo } else { -scaled.albedo_moments[l] };
            let shape = shapes.column(l);
            let columns = sum.as_mut_slice().chunks_exact_mut(shape.len());
            for (column, entry) in columns.zip(shape.as_slice()) {
                let factor = change.derivatives().map(|derivative| derivative * entry);
                for (sum, one) in column.iter_mut().zip(shape.as_slice()) {
                    sum.iter_mut().zip(factor).for_each(|(sum, factor)| *sum += factor * one);
                }
            }
        }
        sum
    })
}

/// A change over the gap of two modes, or 0 if nothing changes, where there may be no gap.
fn quotient(change: f64, gap: f64) -> f64 {
    if change.is_zero() { 0.0 } else { change / gap }
}
