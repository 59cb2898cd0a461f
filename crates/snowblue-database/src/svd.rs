//! Singular values and right singular vectors of a matrix with many rows and few columns.
//!
//! A Householder QR decomposition reduces M to R. M and R have equal singular values and right singular vectors.
//! One-sided Jacobi rotations then make the columns of R orthogonal: R V = U Σ (Hestenes 1958, doi:10.1137/0106005;
//! Demmel & Veselić 1992, doi:10.1137/0613074). Nothing is squared, so small singular values keep their accuracy.
//!
//! The SVD of nalgebra 0.35 is not used, because it returns wrong singular values for some matrices of low rank
//! (github.com/dimforge/nalgebra/issues/1172).
//!
//! A singular vector is unique up to its sign. Here its first entry of largest magnitude is positive, where magnitudes
//! within 10⁻⁶ of the largest count as equal, so that rounding does not change the sign.

use nalgebra::DMatrix;

/// Sweeps of rotations after which the iteration counts as failed. Convergence is quadratic: ten are plenty.
const MAX_SWEEPS: usize = 60;
/// Two magnitudes are equal within this, relative to the larger.
const SAME_MAGNITUDE: f64 = 1e-6;

/// Singular values and right singular vectors, min(rows, columns) of each.
#[derive(Debug, Clone)]
pub(crate) struct Svd {
    /// σ_1 ≥ σ_2 ≥ …
    pub(crate) singular_values: Vec<f64>,
    /// V, a column for each singular value.
    pub(crate) right_vectors: DMatrix<f64>,
}

impl Svd {
    /// Decomposes a matrix; `None` if it has a value that is not finite.
    pub(crate) fn new(matrix: DMatrix<f64>) -> Option<Self> {
        if !matrix.iter().all(|value| value.is_finite()) {
            return None;
        }
        let mut rotated = matrix.qr().unpack_r();
        let count = rotated.nrows();
        let right_vectors = orthogonalise(&mut rotated)?;
        let mut order: Vec<usize> = (0..rotated.ncols()).collect();
        let norms: Vec<f64> = rotated.column_iter().map(|column| column.norm()).collect();
        order.sort_by(|a, b| norms[*b].total_cmp(&norms[*a]));
        order.truncate(count);
        let mut right_vectors = right_vectors.select_columns(&order);
        for mut vector in right_vectors.column_iter_mut() {
            let limit = vector.amax() * (1.0 - SAME_MAGNITUDE);
            if vector.iter().find(|entry| entry.abs() >= limit).is_some_and(|entry| *entry < 0.0) {
                vector.neg_mut();
            }
        }
        Some(Self { singular_values: order.iter().map(|column| norms[*column]).collect(), right_vectors })
    }
}

/// Rotates pairs of columns until all are orthogonal, and returns the product of the rotations.
fn orthogonalise(columns: &mut DMatrix<f64>) -> Option<DMatrix<f64>> {
    let count = columns.ncols();
    let mut rotations = DMatrix::identity(count, count);
    let relative = f64::EPSILON * (columns.nrows() as f64).sqrt();
    // Columns below the rounding errors of the largest column are noise and need not be orthogonal to each other.
    let absolute = (f64::EPSILON * columns.norm()).powi(2);
    for _ in 0..MAX_SWEEPS {
        let mut is_orthogonal = true;
        for p in 0..count {
            for q in p + 1..count {
                let (left, right) = (columns.column(p), columns.column(q));
                let (norm_p, norm_q, product) = (left.norm(), right.norm(), left.dot(&right));
                if product.abs() <= relative * norm_p * norm_q + absolute {
                    continue;
                }
                is_orthogonal = false;
                let zeta = (norm_q - norm_p) * (norm_q + norm_p) / (2.0 * product);
                let tangent = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
                let cosine = tangent.hypot(1.0).recip();
                for matrix in [&mut *columns, &mut rotations] {
                    rotate(matrix, p, q, Rotation { cosine, sine: tangent * cosine });
                }
            }
        }
        if is_orthogonal {
            return Some(rotations);
        }
    }
    None
}

/// A plane rotation.
#[derive(Debug, Clone, Copy)]
struct Rotation {
    cosine: f64,
    sine: f64,
}

/// Rotates columns `p` and `q`.
fn rotate(matrix: &mut DMatrix<f64>, p: usize, q: usize, rotation: Rotation) {
    let Rotation { cosine, sine } = rotation;
    for row in 0..matrix.nrows() {
        let (a, b) = (matrix[(row, p)], matrix[(row, q)]);
        matrix[(row, p)] = cosine * a - sine * b;
        matrix[(row, q)] = sine * a + cosine * b;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A repeatable number within ± 1.
    fn next(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Checks that V has orthonormal columns and that the columns of M V are orthogonal with norms σ.
    fn check(matrix: &DMatrix<f64>) {
        let svd = Svd::new(matrix.clone()).unwrap();
        let v = &svd.right_vectors;
        assert_eq!(v.ncols(), matrix.nrows().min(matrix.ncols()));
        let identity = DMatrix::identity(v.ncols(), v.ncols());
        assert!((v.transpose() * v - identity).amax() < 1e-14);
        let rounding = 1e-14 * matrix.norm();
        let product = matrix * v;
        for (column, sigma) in product.column_iter().zip(&svd.singular_values) {
            assert!((column.norm() - sigma).abs() <= rounding, "{} {sigma}", column.norm());
        }
        let gram = product.transpose() * &product;
        for (i, j) in (0..v.ncols()).flat_map(|i| (0..i).map(move |j| (i, j))) {
            assert!(gram[(i, j)].abs() <= rounding * svd.singular_values[0], "{i} {j}");
        }
        let squares: f64 = svd.singular_values.iter().map(|sigma| sigma * sigma).sum();
        assert!((squares.sqrt() - matrix.norm()).abs() <= rounding);
        assert!(svd.singular_values.windows(2).all(|pair| pair[0] >= pair[1]));
    }

    #[test]
    fn random_matrices_of_any_shape_are_decomposed() {
        let mut state = 1;
        for (rows, columns) in [(1, 1), (40, 7), (200, 31), (5, 9), (3, 1), (1, 4)] {
            check(&DMatrix::from_fn(rows, columns, |_, _| next(&mut state)));
        }
    }

    #[test]
    fn matrices_of_low_rank_are_decomposed() {
        for (rows, columns) in [(3, 5), (6, 21), (30, 30), (40, 31)] {
            check(&DMatrix::from_element(rows, columns, 1.0));
            check(&DMatrix::from_fn(rows, columns, |i, j| (i as f64 + 1.0) * (j as f64 + 2.0)));
            check(&DMatrix::zeros(rows, columns));
        }
        check(&DMatrix::from_row_slice(3, 3, &[1.0, 2.0, 2.0, 2.0, -1.0, -1.0, 2.0, 1.0, -1.0]));
    }

    #[test]
    fn singular_values_are_found_over_twelve_orders_of_magnitude() {
        let mut state = 2;
        let mut orthogonal = |n: usize| DMatrix::from_fn(n, n, |_, _| next(&mut state)).qr().q();
        let (u, v) = (orthogonal(60), orthogonal(7));
        let sigma: [f64; 7] = [1e3, 1.0, 0.5, 1e-2, 1e-5, 1e-7, 1e-9];
        let matrix =
            u.columns(0, 7) * DMatrix::from_fn(7, 7, |i, j| if i == j { sigma[i] } else { 0.0 }) * v.transpose();
        let svd = Svd::new(matrix).unwrap();
        for (found, expected) in svd.singular_values.iter().zip(sigma) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }

    #[test]
    fn signs_follow_the_largest_entry() {
        let mut state = 3;
        let matrix = DMatrix::from_fn(50, 6, |_, _| next(&mut state));
        let svd = Svd::new(matrix.clone()).unwrap();
        for vector in svd.right_vectors.column_iter() {
            assert!(vector[vector.icamax()] > 0.0);
        }
        let negated = Svd::new(-matrix).unwrap();
        assert!((svd.right_vectors - negated.right_vectors).amax() < 1e-12);
    }

    #[test]
    fn values_that_are_not_finite_are_refused() {
        assert!(Svd::new(DMatrix::from_element(4, 2, f64::NAN)).is_none());
    }
}
