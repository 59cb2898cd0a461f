//! Systems x = b + M x of which only products with M are known, by GMRES with restarts (Saad & Schultz 1986; Saad 2003,
//! *Iterative Methods for Sparse Linear Systems*, algorithm 6.9), for groups of four systems at once.
//!
//! Light that goes back and forth between surfaces that absorb little decays by some per cent from one reflection to
//! the next. To sum its series takes hundreds of products; GMRES takes some ten.

use wide::{f32x4, f64x4};

use crate::vectors::{narrow, ratio, sum, wide};

/// Vectors of the basis, which are kept in memory.
const BASIS: usize = 12;

/// Relative accuracy of a product at the least.
const LEAST_ACCURACY: f64 = 1e-2;

/// Vectors of all groups of systems.
type Vectors = Vec<Vec<f32x4>>;

/// Gives M v for the vectors v of all groups, to a relative accuracy.
pub type Product<'p> = &'p mut dyn FnMut(&[Vec<f32x4>], f64) -> Vec<Vec<f32x4>>;

/// Solves x = b + M x for each group of four systems, from x = 0, until the residual of each system is below
/// `tolerance` of its b, or after `most_products` products.
///
/// `product` computes M v to a relative accuracy. The smaller the residual has become, the less accurate it may be
/// (Simoncini & Szyld 2003, "Theory of inexact Krylov subspace methods", doi:10.1137/S1064827502406415).
pub fn solve_fixed_point(
    constant: &[Vec<f32x4>],
    product: Product,
    tolerance: f64,
    most_products: usize,
) -> Vec<Vec<f32x4>> {
    let goal: Vec<f64x4> = norms(constant).into_iter().map(|norm| norm * f64x4::splat(tolerance)).collect();
    let is_above =
        |residual: &[f64x4]| residual.iter().zip(&goal).any(|(residual, goal)| residual.simd_gt(*goal).any());
    let accuracy = |residual: &[f64x4]| {
        let times_goal = residual.iter().zip(&goal).flat_map(|(residual, goal)| ratio(*residual, *goal).to_array());
        times_goal.fold(1.0, f64::max).recip().min(LEAST_ACCURACY)
    };
    let mut solution: Vectors = constant.iter().map(|group| vec![f32x4::ZERO; group.len()]).collect();
    let mut norm = norms(constant);
    let mut products = 0;
    while is_above(&norm) && products < most_products {
        let mut residual = constant.to_vec();
        if products > 0 {
            add(&mut residual, &solution, -1.0);
            add(&mut residual, &product(&solution, tolerance), 1.0);
            products += 1;
            norm = norms(&residual);
        }
        let mut problems: Vec<LeastSquares> = norm.iter().map(|norm| LeastSquares::new(*norm)).collect();
        let mut basis = vec![divided(&residual, &norm)];
        while basis.len() <= BASIS && products < most_products && is_above(&norm) {
            let last = &basis[basis.len() - 1];
            let mut next = last.clone();
            add(&mut next, &product(last, accuracy(&norm)), -1.0);
            products += 1;
            // The coefficients of each group in the basis, and the part of it that is new.
            let mut columns: Vec<Vec<f64x4>> = vec![Vec::with_capacity(basis.len()); next.len()];
            for vectors in &basis {
                for ((next, vector), column) in next.iter_mut().zip(vectors).zip(&mut columns) {
                    let share = dot(next, vector);
                    add_multiple(next, vector, -share);
                    column.push(share);
                }
            }
            let lengths = norms(&next);
            let columns = columns.into_iter().zip(&lengths);
            norm = problems
                .iter_mut()
                .zip(columns)
                .map(|(problem, (column, length))| problem.add(column, *length))
                .collect();
            basis.push(divided(&next, &lengths));
        }
        for (group, problem) in problems.iter().enumerate() {
            for (vectors, share) in basis.iter().zip(problem.solution()) {
                add_multiple(&mut solution[group], &vectors[group], share);
            }
        }
    }
    solution
}

/// The least-squares problems of four systems: the coefficients y that make the residual |β e₁ − H y| least, by Givens
/// rotations of the upper Hessenberg matrix H.
struct LeastSquares {
    /// The columns of H, rotated to an upper triangle.
    columns: Vec<Vec<f64x4>>,
    /// Cosine and sine of each rotation.
    rotations: Vec<[f64x4; 2]>,
    /// β e₁, rotated. The last value is the residual.
    right: Vec<f64x4>,
}

impl LeastSquares {
    fn new(norm: f64x4) -> Self {
        Self { columns: Vec::new(), rotations: Vec::new(), right: vec![norm] }
    }

    /// Adds a column: its coefficients, and the length of the part that is new. Returns the residual.
    fn add(&mut self, mut column: Vec<f64x4>, length: f64x4) -> f64x4 {
        for (k, [cos, sin]) in self.rotations.iter().enumerate() {
            let [upper, lower] = [column[k], column[k + 1]];
            column[k] = *cos * upper + *sin * lower;
            column[k + 1] = *cos * lower - *sin * upper;
        }
        let last = column.len() - 1;
        let radius = (column[last] * column[last] + length * length).sqrt();
        let [cos, sin] = [ratio(column[last], radius), ratio(length, radius)];
        column[last] = radius;
        let right = self.right[last];
        self.right[last] = cos * right;
        self.right.push(-sin * right);
        self.columns.push(column);
        self.rotations.push([cos, sin]);
        (sin * right).abs()
    }

    fn solution(&self) -> Vec<f64x4> {
        let count = self.columns.len();
        let mut solution = self.right[..count].to_vec();
        for k in (0..count).rev() {
            solution[k] = ratio(solution[k], self.columns[k][k]);
            for row in 0..k {
                let known = solution[k];
                solution[row] -= self.columns[k][row] * known;
            }
        }
        solution
    }
}

fn dot(one: &[f32x4], other: &[f32x4]) -> f64x4 {
    sum(one, |row, value| wide(*value) * wide(other[row]))
}

fn norms(vectors: &[Vec<f32x4>]) -> Vec<f64x4> {
    vectors.iter().map(|vector| dot(vector, vector).sqrt()).collect()
}

fn divided(vectors: &[Vec<f32x4>], lengths: &[f64x4]) -> Vectors {
    let of_group = |(vector, length): (&Vec<f32x4>, &f64x4)| {
        let inverse = narrow(ratio(f64x4::ONE, *length));
        vector.iter().map(|value| *value * inverse).collect()
    };
    vectors.iter().zip(lengths).map(of_group).collect()
}

/// Adds a multiple of the vectors of all groups.
fn add(vectors: &mut [Vec<f32x4>], others: &[Vec<f32x4>], factor: f64) {
    vectors.iter_mut().zip(others).for_each(|(vector, other)| add_multiple(vector, other, f64x4::splat(factor)));
}

fn add_multiple(vector: &mut [f32x4], other: &[f32x4], factor: f64x4) {
    let factor = narrow(factor);
    vector.iter_mut().zip(other).for_each(|(value, other)| *value += *other * factor);
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROWS: usize = 60;

    /// Light along a tube of patches that pass all light on but for a loss, in other shares to either side: the sum of
    /// its reflections converges slowly.
    fn along_tube(loss: f32, values: &[f32x4]) -> Vec<f32x4> {
        let at = |row: usize| values.get(row).copied().unwrap_or(f32x4::ZERO);
        let row = |row: usize| (at(row.wrapping_sub(1)) * 0.45 + at(row + 1) * 0.55) * (1.0 - loss);
        (0..ROWS).map(row).collect()
    }

    /// The four systems of a group have different light, and the groups different losses.
    #[test]
    fn light_along_a_tube_is_in_balance() {
        let losses = [0.0, 0.02, 0.5];
        let dark = f32x4::ZERO;
        let mut constant = vec![vec![dark; ROWS]; losses.len()];
        for group in &mut constant {
            group[0] = f32x4::new([1.0, 0.0, 0.0, 1e-3]);
            group[ROWS - 1] = f32x4::new([0.0, 2.0, 0.0, 5.0]);
        }
        let mut count = 0;
        let mut product = |values: &[Vec<f32x4>], _| {
            count += 1;
            values.iter().zip(losses).map(|(values, loss)| along_tube(loss, values)).collect()
        };
        let solution = solve_fixed_point(&constant, &mut product, 1e-4, 1000);
        for ((solution, constant), loss) in solution.iter().zip(&constant).zip(losses) {
            let balance = along_tube(loss, solution).into_iter().zip(constant).zip(solution);
            let (mut square, mut light_square) = ([0.0; 4], [0.0; 4]);
            for ((reflected, constant), value) in balance {
                let missed = (reflected + *constant - *value).to_array();
                (0..4).for_each(|k| square[k] += missed[k] * missed[k]);
                (0..4).for_each(|k| light_square[k] += constant.to_array()[k].powi(2));
            }
            for (square, light_square) in square.into_iter().zip(light_square) {
                assert!(square.sqrt() <= 2e-4 * light_square.sqrt(), "{loss}: {square} {light_square}");
            }
        }
        // To sum reflections without loss, as many as patches squared would be needed.
        assert!(count < 200, "{count} products");
    }

    #[test]
    fn the_number_of_products_is_limited() {
        let mut count = 0;
        let constant = [vec![f32x4::ONE; ROWS]];
        let mut product = |values: &[Vec<f32x4>], _| {
            count += 1;
            vec![along_tube(0.0, &values[0])]
        };
        solve_fixed_point(&constant, &mut product, 1e-9, 5);
        assert_eq!(count, 5);
    }
}
