//! The modes of a homogeneous medium: solutions of the equation of transfer that grow or decay exponentially with
//! depth.
//!
//! With S = I⁺ + I⁻ and D = I⁺ − I⁻ at the ordinates (μ_i, w_i), each scaled by √w_i, the azimuth-averaged equation of
//! transfer splits into
//!
//! ```text
//! M dS/dτ = −O D,   O = 1 − Σ_{l odd}  (2l + 1) ω χ_l p_l p_lᵀ,
//! M dD/dτ = −E S,   E = 1 − Σ_{l even} (2l + 1) ω χ_l p_l p_lᵀ,   p_l,i = √w_i P_l(μ_i),   M = diag μ_i,
//! ```
//!
//! with E and O symmetric (Nakajima & Tanaka 1986, doi:10.1016/0022-4073(86)90088-9; Stamnes et al. 1988,
//! doi:10.1364/AO.27.002502). With the Cholesky factors O = L Lᵀ and E = F Fᵀ, the decay rates k are the singular
//! values of Fᵀ M⁻¹ L. The usual method, square roots of the eigenvalues of the square of this matrix, would lose
//! precision of the smallest k, which governs deep snow and vanishes with absorption. The right singular vectors u
//! give V = M⁻¹ L U and H = L⁻ᵀ U, so that S = V φ(τ), D = −H φ'(τ), φ'' = k² φ, and Vᵀ M H = 1.
//!
//! δ-M scaling comes first: the forward peak of the phase function, beyond what the quadrature resolves, is taken as
//! unscattered light (Wiscombe 1977, doi:10.1175/1520-0469(1977)034<1408:TDMYRA>2.0.CO;2).

use std::sync::OnceLock;

use nalgebra::{Cholesky, DMatrix, DVector, DVectorView, Dyn, StorageMut, Vector};

use crate::dual::Real;
use crate::medium::Scattering;
use crate::quadrature::{MAX_NODES, Quadrature, legendre_polynomials};

/// A medium after δ-M scaling for a given quadrature.
pub(crate) struct Scaled<T = f64> {
    pub(crate) one_minus_albedo: T,
    /// ω χ_l for l = 0 … 2N − 1.
    pub(crate) albedo_moments: Vec<T>,
    /// Scaled over unscaled optical depth, 1 − ω f.
    pub(crate) depth_ratio: T,
}

impl<T: Real> Scaled<T> {
    /// δ-M scaling for `streams` ordinates: the truncated fraction is f = χ_streams if the peak is a forward one.
    pub(crate) fn new(medium: &Scattering<T>, streams: usize) -> Self {
        let [nothing, whole] = [0.0, 1.0].map(T::from);
        let is_forward = [streams - 1, streams].into_iter().all(|l| medium.moments[l].value() > 0.0);
        let forward = if is_forward { medium.moments[streams] } else { nothing };
        let albedo = whole - medium.one_minus_albedo;
        let depth_ratio = (whole - forward) + forward * medium.one_minus_albedo;
        // A medium that only scatters straight forward (n = 1) only absorbs.
        if 1.0 - forward.value() < 1e-12 {
            let albedo_moments = vec![nothing; streams];
            return Self { one_minus_albedo: whole, albedo_moments, depth_ratio: medium.one_minus_albedo };
        }
        let scaled_albedo = albedo * (whole - forward) / depth_ratio;
        let scaled = |chi: &T| scaled_albedo * (*chi - forward) / (whole - forward);
        let albedo_moments = medium.moments[..streams].iter().map(scaled).collect();
        Self { one_minus_albedo: medium.one_minus_albedo / depth_ratio, albedo_moments, depth_ratio }
    }
}

/// The modes of a medium on a quadrature; columns belong to modes.
pub(crate) struct Modes {
    /// Decay rates k per scaled optical depth; 0 for the diffusion mode where nothing absorbs.
    pub(crate) rates: Vec<f64>,
    /// V: the shape of S in each mode.
    pub(crate) sums: DMatrix<f64>,
    /// H: the shape of −D per unit slope of the mode.
    pub(crate) differences: DMatrix<f64>,
}

impl Modes {
    /// Solves `medium` on the directions of `rule`.
    ///
    /// None if E or O is not positive definite. The basis is orthonormal for the lower degrees only, so this can
    /// happen for phase functions with a peak that the rule does not resolve, but never for phase functions of snow.
    pub(crate) fn new(medium: &Scaled, rule: &Quadrature) -> Option<Self> {
        let n = rule.order();
        let basis = legendre_basis(n);
        let mut odd = DMatrix::identity(n, n);
        for l in (1..medium.albedo_moments.len()).step_by(2) {
            let column = basis.column(l);
            odd.ger(-medium.albedo_moments[l], &column, &column, 1.0);
        }
        let lower = factor(odd)?;
        let root = even_root(medium, basis)?;
        let mut product = lower.clone();
        for (mut row, mu) in product.row_iter_mut().zip(&rule.cosines) {
            row /= *mu;
        }
        let scaled_lower = product.clone();
        let (rates, right) = singular_values(root * product);
        let sums = scaled_lower * &right;
        let differences = lower.tr_solve_lower_triangular(&right)?;
        Some(Self { rates, sums, differences })
    }
}

/// √((2l + 1) w_i) P_l(μ_i) on a half-range rule of N nodes, a column for each l below 2N; computed once and cached.
pub(crate) fn legendre_basis(order: usize) -> &'static DMatrix<f64> {
    static BASES: [OnceLock<DMatrix<f64>>; MAX_NODES] = [const { OnceLock::new() }; MAX_NODES];
    BASES[order - 1].get_or_init(|| {
        let rule = Quadrature::half_range(order);
        let mut basis = DMatrix::zeros(order, 2 * order);
        let mut polynomials = vec![0.0; 2 * order];
        for (i, (mu, weight)) in rule.cosines.iter().zip(&rule.weights).enumerate() {
            legendre_polynomials(*mu, &mut polynomials);
            for (l, value) in polynomials.iter().enumerate() {
                basis[(i, l)] = ((2 * l + 1) as f64 * weight).sqrt() * value;
            }
        }
        basis
    })
}

/// Fᵀ with E = F Fᵀ, accurate in its smallest eigenvalue.
///
/// The isotropic direction p_0 is an eigenvector of E with eigenvalue 1 − ω, which may be tiny. A reflection that maps
/// the first axis to p_0 isolates this entry, so it is never the difference of two numbers near 1.
fn even_root(medium: &Scaled, basis: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = basis.nrows();
    let Mirrored { mirror, columns } = mirrored_basis(basis);
    let mut rest = DMatrix::identity(n - 1, n - 1);
    for l in (2..medium.albedo_moments.len()).step_by(2) {
        let tail = columns.view((1, l), (n - 1, 1));
        let tail = tail.column(0);
        rest.ger(-medium.albedo_moments[l], &tail, &tail, 1.0);
    }
    // F in the place of Fᵀ: its columns are contiguous.
    let mut root = DMatrix::zeros(n, n);
    root[(0, 0)] = medium.one_minus_albedo.sqrt();
    if n > 1 {
        root.view_mut((1, 1), (n - 1, n - 1)).copy_from(&factor(rest)?);
    }
    for mut column in root.column_iter_mut() {
        reflect(mirror, &mut column);
    }
    Some(root.transpose())
}

/// The basis after the reflection that maps the first axis to p_0.
struct Mirrored {
    /// The normal of the reflection; not normalized.
    mirror: DVector<f64>,
    columns: DMatrix<f64>,
}

/// The reflected basis of a half-range rule, computed once and cached.
fn mirrored_basis(basis: &DMatrix<f64>) -> &'static Mirrored {
    static BASES: [OnceLock<Mirrored>; MAX_NODES] = [const { OnceLock::new() }; MAX_NODES];
    BASES[basis.nrows() - 1].get_or_init(|| {
        let mut mirror: DVector<f64> = basis.column(0).into_owned();
        mirror[0] -= 1.0;
        let mut columns = basis.clone();
        columns.column_iter_mut().for_each(|mut column| reflect(&mirror, &mut column));
        Mirrored { mirror, columns }
    })
}

/// Reflects a vector in the plane with a normal.
fn reflect<S: StorageMut<f64, Dyn>>(mirror: &DVector<f64>, vector: &mut Vector<f64, Dyn, S>) {
    let square = mirror.norm_squared();
    if square > 0.0 {
        let along = 2.0 * mirror.dot(vector) / square;
        vector.axpy(-along, mirror, 1.0);
    }
}

/// The lower Cholesky factor of a positive definite matrix.
fn factor(matrix: DMatrix<f64>) -> Option<DMatrix<f64>> {
    Cholesky::new(matrix).map(Cholesky::unpack)
}

/// Singular values and right singular vectors by one-sided Jacobi rotations (Hestenes 1958, doi:10.1137/0106005).
///
/// Rotations make the columns of `matrix` orthogonal; their lengths are then the singular values. Small singular
/// values keep their relative precision (Demmel & Veselić 1992, doi:10.1137/0613074).
fn singular_values(mut matrix: DMatrix<f64>) -> (Vec<f64>, DMatrix<f64>) {
    let n = matrix.ncols();
    let mut right = DMatrix::identity(n, n);
    let (columns, rotated) = (matrix.as_mut_slice(), right.as_mut_slice());
    match n {
        // The usual number of streams, for which the compiler unrolls the loops.
        8 => orthogonalize(columns, rotated, 8),
        n => orthogonalize(columns, rotated, n),
    }
    (matrix.column_iter().map(|column| column.norm()).collect(), right)
}

/// Rotates the `n` columns of a square matrix until they are orthogonal, and the columns of `right` with them.
#[inline(always)]
fn orthogonalize(matrix: &mut [f64], right: &mut [f64], n: usize) {
    const MAX_SWEEPS: usize = 40;
    // The rounding of an inner product of n terms.
    let tolerance = f64::EPSILON * n as f64;
    let mut storage = [0.0; MAX_NODES];
    let squares = &mut storage[..n];
    for _ in 0..MAX_SWEEPS {
        let mut rotated = false;
        // Squared lengths are updated through the sweep, and recomputed before the next.
        for (square, column) in squares.iter_mut().zip(matrix.chunks_exact(n)) {
            *square = DVectorView::from_slice(column, n).norm_squared();
        }
        for p in 0..n {
            for q in p + 1..n {
                let (head, tail) = matrix.split_at_mut(q * n);
                let (a, b) = (&mut head[p * n..p * n + n], &mut tail[..n]);
                let (alpha, beta, gamma) = (squares[p], squares[q], inner_product(a, b));
                if gamma * gamma <= tolerance * tolerance * alpha * beta || gamma.abs() < f64::MIN_POSITIVE {
                    continue;
                }
                rotated = true;
                let zeta = (beta - alpha) / (2.0 * gamma);
                let tangent = zeta.signum() / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
                let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
                let sine = cosine * tangent;
                rotate(a, b, cosine, sine);
                let (head, tail) = right.split_at_mut(q * n);
                rotate(&mut head[p * n..p * n + n], &mut tail[..n], cosine, sine);
                squares[p] = (alpha - tangent * gamma).max(0.0);
                squares[q] = beta + tangent * gamma;
            }
        }
        if !rotated {
            break;
        }
    }
}

/// An inner product, summed in two lanes.
#[inline]
fn inner_product(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 2];
    let (pairs_a, pairs_b) = (a.chunks_exact(2), b.chunks_exact(2));
    let rest: f64 = pairs_a.remainder().iter().zip(pairs_b.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in pairs_a.zip(pairs_b) {
        lanes[0] += x[0] * y[0];
        lanes[1] += x[1] * y[1];
    }
    lanes[0] + lanes[1] + rest
}

#[inline]
fn rotate(a: &mut [f64], b: &mut [f64], cosine: f64, sine: f64) {
    for (a, b) in a.iter_mut().zip(b) {
        (*a, *b) = (cosine * *a - sine * *b, sine * *a + cosine * *b);
    }
}
