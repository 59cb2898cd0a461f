//! Solves systems x = b + M x of which only the residual c = b + M x − x is known for each x, by Anderson's method
//! (Walker & Ni 2011, "Anderson acceleration for fixed-point iterations", doi:10.1137/10078356X), for groups of four
//! systems at once.
//!
//! Light that is reflected back and forth between surfaces of low absorption decays by some per cent from one
//! reflection to the next. The sum of its series takes hundreds of reflections. Anderson's method takes about ten
//! evaluations, as GMRES does. Unlike in GMRES, each c may be inexact, since the next c is computed from the x that
//! was found.

use wide::{f32x4, f64x4};

use crate::vectors::{narrow, ratio, sum, wide};

/// Vectors of all groups of systems.
type Vectors = Vec<Vec<f32x4>>;

/// Computes the residual b + M x − x from the x of all groups.
pub type Missing<'p> = &'p mut dyn FnMut(&[Vec<f32x4>]) -> Vec<Vec<f32x4>>;

/// Stopping criteria and history of the iteration for a fixed point.
#[derive(Debug, Clone, Copy)]
pub struct FixedPointOptions {
    /// Greatest error of each system: the root mean square of the residual relative to x, where x is above the root
    /// mean square of all its elements, or relative to this root mean square.
    pub tolerance: f64,
    /// Greatest number of evaluations of the residual.
    pub most_estimates: usize,
    /// Number of steps that are remembered. Each step takes two vectors.
    pub history: usize,
}

/// Length of the new part of a step, relative to the whole step, below which the new part is rounding error.
const MIN_NEW: f64 = 1e-6;
/// Least length with a reciprocal in single precision.
const MIN_LENGTH: f64 = 1e-37;

/// A step of x, and the decrease of the residual by it. The decreases of all steps are orthogonal and of length 1.
struct Step {
    step: Vectors,
    gain: Vectors,
}

/// Solves x = b + M x for each group of four systems from a start.
pub fn solve_fixed_point(start: Vectors, missing: Missing, options: FixedPointOptions) -> Vectors {
    let mut solution = start;
    let mut steps: Vec<Step> = Vec::new();
    // The last step, and the residual before it.
    let mut last: Option<(Vectors, Vectors)> = None;
    for _ in 0..options.most_estimates {
        let mut rest = missing(&solution);
        if let Some((step, before)) = last.take() {
            if steps.len() == options.history.max(1) {
                steps.remove(0);
            }
            steps.push(Step::new(step, before, &rest, &steps));
        }
        let missed = rest.clone();
        let mut step: Vectors = rest.iter().map(|group| vec![f32x4::ZERO; group.len()]).collect();
        for known in &steps {
            for (group, rest) in rest.iter_mut().enumerate() {
                let part = dot(rest, &known.gain[group]);
                add_multiple(rest, &known.gain[group], -part);
                add_multiple(&mut step[group], &known.step[group], part);
            }
        }
        add(&mut step, &rest);
        add(&mut solution, &step);
        if error(&missed, &solution) <= options.tolerance {
            break;
        }
        last = Some((step, missed));
    }
    solution
}

impl Step {
    /// A step with the residuals before and after it, made orthogonal to other steps.
    fn new(mut step: Vectors, before: Vectors, after: &[Vec<f32x4>], others: &[Self]) -> Self {
        let mut gain = before;
        for (group, gain) in gain.iter_mut().enumerate() {
            let step = &mut step[group];
            let length = dot(gain, gain).sqrt();
            add_multiple(gain, &after[group], f64x4::splat(-1.0));
            for other in others {
                let part = dot(gain, &other.gain[group]);
                add_multiple(gain, &other.gain[group], -part);
                add_multiple(step, &other.step[group], -part);
            }
            // In systems that are solved, the rest is rounding error and is discarded.
            let new = dot(gain, gain).sqrt();
            let is_new = new.simd_gt(length * f64x4::splat(MIN_NEW)) & new.simd_gt(f64x4::splat(MIN_LENGTH));
            let inverse = narrow(is_new.select(ratio(f64x4::ONE, new), f64x4::ZERO));
            gain.iter_mut().chain(step.iter_mut()).for_each(|value| *value *= inverse);
        }
        Self { step, gain }
    }
}

fn dot(one: &[f32x4], other: &[f32x4]) -> f64x4 {
    sum(one, |row, value| wide(*value) * wide(other[row]))
}

/// The greatest error of all systems, by the residuals of x.
fn error(missed: &[Vec<f32x4>], solution: &[Vec<f32x4>]) -> f64 {
    let of_group = |(missed, solution): (&Vec<f32x4>, &Vec<f32x4>)| {
        let mean_square = dot(solution, solution) / f64x4::splat(solution.len() as f64);
        let squares = sum(missed, |row, missed| {
            let [missed, value] = [wide(*missed), wide(solution[row])];
            ratio(missed * missed, (value * value).max(mean_square))
        });
        (squares / f64x4::splat(missed.len() as f64)).sqrt().to_array()
    };
    // An error that is not a number counts as not converged.
    let errors = missed.iter().zip(solution).flat_map(of_group);
    errors.fold(0.0, |greatest, error| if error.is_nan() { f64::INFINITY } else { greatest.max(error) })
}

/// Adds the vectors of all groups.
fn add(vectors: &mut [Vec<f32x4>], others: &[Vec<f32x4>]) {
    vectors.iter_mut().zip(others).for_each(|(vector, other)| add_multiple(vector, other, f64x4::ONE));
}

fn add_multiple(vector: &mut [f32x4], other: &[f32x4], factor: f64x4) {
    let factor = narrow(factor);
    vector.iter_mut().zip(other).for_each(|(value, other)| *value += *other * factor);
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROWS: usize = 60;

    /// Light along a tube of patches. Each patch passes on all light except for a loss, in different shares to the two
    /// sides. The sum of the reflections converges slowly.
    fn along_tube(loss: f32, values: &[f32x4]) -> Vec<f32x4> {
        let at = |row: usize| values.get(row).copied().unwrap_or(f32x4::ZERO);
        let row = |row: usize| (at(row.wrapping_sub(1)) * 0.45 + at(row + 1) * 0.55) * (1.0 - loss);
        (0..ROWS).map(row).collect()
    }

    /// The four systems of a group have different light, and the groups different losses.
    #[test]
    fn light_along_a_tube_is_in_balance() {
        let losses = [0.0, 0.02, 0.5];
        let dark = vec![vec![f32x4::ZERO; ROWS]; losses.len()];
        let mut constant = dark.clone();
        for group in &mut constant {
            group[0] = f32x4::new([1.0, 0.0, 0.0, 1e-3]);
            group[ROWS - 1] = f32x4::new([0.0, 2.0, 0.0, 5.0]);
        }
        for start in [constant.clone(), dark] {
            let mut count = 0;
            let mut missing = |values: &[Vec<f32x4>]| {
                count += 1;
                let of_group = |((values, loss), constant): ((&Vec<f32x4>, f32), &Vec<f32x4>)| {
                    let reflected = along_tube(loss, values).into_iter().zip(constant).zip(values);
                    reflected.map(|((reflected, constant), value)| *constant + reflected - *value).collect()
                };
                values.iter().zip(losses).zip(&constant).map(of_group).collect()
            };
            let options = FixedPointOptions { tolerance: 1e-5, most_estimates: 1000, history: 12 };
            let solution = solve_fixed_point(start, &mut missing, options);
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
            // Without loss, a sum of reflections would need as many terms as the square of the number of patches.
            assert!(count < 200, "{count} estimates");
        }
    }

    #[test]
    fn the_number_of_estimates_is_limited() {
        let mut count = 0;
        let mut missing = |values: &[Vec<f32x4>]| {
            count += 1;
            let reflected = along_tube(0.0, &values[0]);
            vec![reflected.into_iter().zip(&values[0]).map(|(reflected, value)| reflected - *value).collect()]
        };
        let options = FixedPointOptions { tolerance: 1e-9, most_estimates: 5, history: 5 };
        solve_fixed_point(vec![vec![f32x4::ONE; ROWS]], &mut missing, options);
        assert_eq!(count, 5);
    }
}
