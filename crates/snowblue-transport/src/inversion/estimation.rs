//! Optimal estimation: the most probable state, given data and what was known of it before (Rodgers 2000, *Inverse
//! Methods for Atmospheric Sounding*, ch. 5).
//!
//! With residuals r of the data in units of their standard deviations, their derivatives −K, and a normal prior of mean
//! x_a and covariance S_a, the state x minimises
//!
//! ```text
//! J(x) = |r(x)|² + (x − x_a)ᵀ S_a⁻¹ (x − x_a)                    (eq. 5.3),
//! ```
//!
//! by the damped steps of Levenberg (1944) and Marquardt (1963, doi:10.1137/0111030)
//!
//! ```text
//! (H + λ diag H) δ = g,   H = KᵀK + S_a⁻¹,   g = Kᵀ r − S_a⁻¹ (x − x_a).
//! ```
//!
//! H⁻¹ is the covariance of the posterior (eq. 5.30) and A = H⁻¹KᵀK the averaging kernel. The search has converged when
//! the undamped step δ is far smaller than that covariance, gᵀδ ≪ n (eq. 5.29). That step is taken at last, without
//! another evaluation.
//!
//! A model that is linear in exponentials of the state has second derivatives as large as the first. Once a step has
//! overshot, steps include them where that makes them shorter: max(0, −Kᵀr) on the diagonal of H. Else they would go to
//! and fro where the data say that a quantity is smaller than the prior has it.

use nalgebra::{Cholesky, DMatrix, DVector};

/// Greatest gᵀδ, per element of the state, where a search has converged: a thousandth of a standard deviation.
const CONVERGED: f64 = 1e-6;
/// The same where a step did not lower J: at a kink of an interpolation in the model.
const KINKED: f64 = 1e-4;
const MOST_SOLUTIONS: usize = 80;
const FIRST_DAMPING: f64 = 1e-2;
/// Least damping where J falls by less than a quarter of what its derivatives predict (Fletcher 1971): the model is
/// more curved than K says, and undamped steps go to and fro.
const WARY_DAMPING: f64 = 0.4;
const GREATEST_DAMPING: f64 = 1e6;

/// What is known of a state before the measurement.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Knowledge {
    pub(super) mean: DVector<f64>,
    /// S_a⁻¹.
    pub(super) precision: DMatrix<f64>,
    /// Least value of each element.
    pub(super) least: DVector<f64>,
    /// Greatest value of each element.
    pub(super) greatest: DVector<f64>,
}

/// A search for the most probable state. Whoever drives it evaluates the model at [`trial`](Self::trial) and calls
/// [`take`](Self::take) until it has ended, so that many searches can share the work.
#[derive(Debug, Clone)]
pub(super) struct Search {
    prior: Knowledge,
    best: Option<Evaluated>,
    trial: DVector<f64>,
    /// The fall of J from the best state to the trial, by its derivatives.
    predicted: f64,
    damping: f64,
    /// Whether steps have overshot.
    is_bent: bool,
    solutions: usize,
    end: Option<End>,
}

/// How a search has ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    Converged,
    NotConverged,
}

/// J and its derivatives at a state.
#[derive(Debug, Clone)]
struct Evaluated {
    state: DVector<f64>,
    data_cost: f64,
    prior_cost: f64,
    /// KᵀK.
    information: DMatrix<f64>,
    /// H.
    curvature: DMatrix<f64>,
    /// max(0, −Kᵀr).
    second: DVector<f64>,
    /// g.
    descent: DVector<f64>,
}

/// The most probable state and what is known of it.
#[derive(Debug, Clone)]
pub(super) struct Posterior {
    pub(super) state: DVector<f64>,
    pub(super) covariance: DMatrix<f64>,
    pub(super) averaging_kernel: DMatrix<f64>,
    /// |r|².
    pub(super) data_cost: f64,
    /// (x − x_a)ᵀ S_a⁻¹ (x − x_a).
    pub(super) prior_cost: f64,
    /// Whether each element is at an end of its range, and the data and the prior would have it beyond.
    pub(super) is_at_end: Vec<bool>,
    /// Number of states at which the model was evaluated.
    pub(super) solutions: usize,
    pub(super) end: End,
}

impl Search {
    /// A search that starts at the mean of the prior.
    pub(super) fn new(prior: Knowledge) -> Self {
        let trial = prior.mean.clone();
        Self {
            prior,
            best: None,
            trial,
            predicted: 0.0,
            damping: FIRST_DAMPING,
            is_bent: false,
            solutions: 0,
            end: None,
        }
    }

    /// The state at which the model is to be evaluated next.
    pub(super) fn trial(&self) -> &DVector<f64> {
        &self.trial
    }

    pub(super) fn has_ended(&self) -> bool {
        self.end.is_some()
    }

    /// Takes the residuals r at the trial and the derivatives K of the model. Returns whether the trial is the best
    /// state so far.
    pub(super) fn take(&mut self, residuals: &DVector<f64>, jacobian: &DMatrix<f64>) -> bool {
        self.solutions += 1;
        let from_mean = &self.trial - &self.prior.mean;
        let pull = &self.prior.precision * &from_mean;
        let (data_cost, prior_cost) = (residuals.norm_squared(), from_mean.dot(&pull));
        let fall = self.best.as_ref().map(|best| best.data_cost + best.prior_cost - data_cost - prior_cost);
        let is_better = fall.is_none_or(|fall| fall > 0.0);
        if is_better {
            self.damping = match fall {
                Some(fall) if fall < 0.25 * self.predicted && self.is_bent => WARY_DAMPING.max(2.0 * self.damping),
                Some(fall) if fall > 0.75 * self.predicted => 0.1 * self.damping,
                _ => self.damping,
            };
            self.is_bent |= fall.is_some_and(|fall| fall < 0.25 * self.predicted);
            let information = jacobian.tr_mul(jacobian);
            let data_descent = jacobian.tr_mul(residuals);
            self.best = Some(Evaluated {
                state: self.trial.clone(),
                data_cost,
                prior_cost,
                curvature: &information + &self.prior.precision,
                second: data_descent.map(|descent| (-descent).max(0.0)),
                information,
                descent: data_descent - pull,
            });
        } else {
            self.is_bent = true;
            self.damping *= 10.0;
        }
        self.advance(is_better);
        is_better
    }

    /// Ends the search, or chooses the next trial.
    fn advance(&mut self, is_better: bool) {
        let Some(best) = &mut self.best else { return };
        let free = best.free(&self.prior);
        let curvature = best.bent(self.is_bent);
        let full = best.step(curvature.clone(), &free, 0.0);
        let decrement = full.dot(&best.descent) / full.len() as f64;
        let trial = self.prior.within(&(&best.state + best.step(curvature.clone(), &free, self.damping)));
        let step = &trial - &best.state;
        self.predicted = 2.0 * best.descent.dot(&step) - step.dot(&(&curvature * &step));
        self.end = if decrement <= CONVERGED {
            best.state = self.prior.within(&(&best.state + full));
            Some(End::Converged)
        } else if !is_better && decrement <= KINKED {
            Some(End::Converged)
        } else {
            let is_stuck = self.damping > GREATEST_DAMPING || trial == best.state;
            (is_stuck || self.solutions >= MOST_SOLUTIONS).then_some(End::NotConverged)
        };
        self.trial = trial;
    }

    /// What the search has found; before any evaluation, the prior.
    pub(super) fn posterior(self) -> Posterior {
        let best = self.best.unwrap_or_else(|| Evaluated::of_prior(&self.prior));
        let covariance = inverse(&best.curvature);
        Posterior {
            averaging_kernel: &covariance * &best.information,
            covariance,
            data_cost: best.data_cost,
            prior_cost: best.prior_cost,
            is_at_end: best.free(&self.prior).into_iter().map(|is_free| !is_free).collect(),
            state: best.state,
            solutions: self.solutions,
            end: self.end.unwrap_or(End::Converged),
        }
    }
}

impl Knowledge {
    /// The state within the ranges that is nearest in each element.
    fn within(&self, state: &DVector<f64>) -> DVector<f64> {
        state.zip_zip_map(&self.least, &self.greatest, f64::clamp)
    }
}

impl Evaluated {
    fn of_prior(prior: &Knowledge) -> Self {
        let n = prior.mean.len();
        Self {
            state: prior.mean.clone(),
            data_cost: 0.0,
            prior_cost: 0.0,
            information: DMatrix::zeros(n, n),
            curvature: prior.precision.clone(),
            second: DVector::zeros(n),
            descent: DVector::zeros(n),
        }
    }

    /// Which elements may follow the descent: not those at an end of their range from which it leads out.
    fn free(&self, prior: &Knowledge) -> Vec<bool> {
        let is_free = |i: usize| {
            let (x, descent) = (self.state[i], self.descent[i]);
            !(x <= prior.least[i] && descent < 0.0 || x >= prior.greatest[i] && descent > 0.0)
        };
        (0..self.state.len()).map(is_free).collect()
    }

    /// H, perhaps with the second derivatives of the model.
    fn bent(&self, is_bent: bool) -> DMatrix<f64> {
        if is_bent { &self.curvature + DMatrix::from_diagonal(&self.second) } else { self.curvature.clone() }
    }

    /// δ, with 0 for elements that are not free.
    fn step(&self, mut curvature: DMatrix<f64>, free: &[bool], damping: f64) -> DVector<f64> {
        let mut descent = self.descent.clone();
        for i in 0..free.len() {
            curvature[(i, i)] *= 1.0 + damping;
            if !free[i] {
                descent[i] = 0.0;
                for j in (0..free.len()).filter(|j| *j != i) {
                    curvature[(i, j)] = 0.0;
                    curvature[(j, i)] = 0.0;
                }
            }
        }
        solve(curvature, &descent)
    }
}

/// The inverse of a symmetric positive definite matrix.
pub(super) fn inverse(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let (balanced, scales) = balanced(matrix.clone());
    let inverse = Cholesky::new(balanced).map(|factor| factor.inverse());
    let inverse = inverse.unwrap_or_else(|| DMatrix::from_element(matrix.nrows(), matrix.ncols(), f64::NAN));
    DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| inverse[(i, j)] * scales[i] * scales[j])
}

fn solve(matrix: DMatrix<f64>, right: &DVector<f64>) -> DVector<f64> {
    let (balanced, scales) = balanced(matrix);
    let factor = Cholesky::new(balanced);
    factor.map_or_else(
        || DVector::zeros(right.len()),
        |factor| factor.solve(&right.component_mul(&scales)).component_mul(&scales),
    )
}

/// A matrix with a diagonal of 1, and the factors of its rows and columns. Data may be known a million times better
/// than the prior.
fn balanced(matrix: DMatrix<f64>) -> (DMatrix<f64>, DVector<f64>) {
    let scales = matrix.diagonal().map(|entry| 1.0 / entry.sqrt());
    let balanced = DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)] * scales[i] * scales[j]);
    (balanced, scales)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDE: f64 = 1e6;

    fn prior(mean: &[f64], deviation: f64, [least, greatest]: [f64; 2]) -> Knowledge {
        let n = mean.len();
        Knowledge {
            mean: DVector::from_row_slice(mean),
            precision: DMatrix::identity(n, n) / (deviation * deviation),
            least: DVector::from_element(n, least),
            greatest: DVector::from_element(n, greatest),
        }
    }

    /// Searches with residuals and derivatives of the model.
    fn found(prior: Knowledge, model: impl Fn(&DVector<f64>) -> (DVector<f64>, DMatrix<f64>)) -> Posterior {
        let mut search = Search::new(prior);
        while !search.has_ended() {
            let (residuals, jacobian) = model(search.trial());
            search.take(&residuals, &jacobian);
        }
        search.posterior()
    }

    /// Rosenbrock's (1960) function has its minimum at (1, 1).
    #[test]
    fn finds_the_minimum_of_rosenbrocks_function() {
        let posterior = found(prior(&[-1.2, 1.0], WIDE, [-9.0, 9.0]), |x| {
            let residuals = DVector::from_row_slice(&[-10.0 * (x[1] - x[0] * x[0]), x[0] - 1.0]);
            (residuals, DMatrix::from_row_slice(2, 2, &[-20.0 * x[0], 10.0, -1.0, 0.0]))
        });
        assert!(posterior.end == End::Converged && posterior.solutions < 50, "{posterior:?}");
        // The square roots of the greatest gᵀH⁻¹g, 2·10⁻⁶, and of the greatest element of H⁻¹, 4.
        assert!((&posterior.state - DVector::from_element(2, 1.0)).amax() < 3e-3, "{posterior:?}");
    }

    /// A line y = 2 + 3x at x = 0 … 4, with a prior: the posterior is that of Bayesian linear regression.
    #[test]
    fn a_linear_model_has_the_posterior_of_bayesian_regression() {
        let jacobian = DMatrix::from_fn(5, 2, |i, j| if j == 0 { 1.0 } else { i as f64 });
        let data = jacobian.clone() * DVector::from_row_slice(&[2.0, 3.0]);
        let posterior = found(prior(&[1.0, 1.0], 0.5, [-9.0, 9.0]), |x| (&data - &jacobian * x, jacobian.clone()));
        // Σ1 = 5, Σx = 10, Σx² = 30; S_a⁻¹ = 4: H = [[9, 10], [10, 34]], whose determinant is 206.
        let expected = DMatrix::from_row_slice(2, 2, &[34.0, -10.0, -10.0, 9.0]) / 206.0;
        assert!((&posterior.covariance - &expected).amax() < 1e-14);
        let kernel = DMatrix::identity(2, 2) - &expected * 4.0;
        assert!((&posterior.averaging_kernel - &kernel).amax() < 1e-14);
        // x̂ = x_a + A (x − x_a), Rodgers 2000, eq. 3.8.
        let state = DVector::from_element(2, 1.0) + kernel * DVector::from_row_slice(&[1.0, 2.0]);
        assert!((&posterior.state - state).amax() < 1e-12 && posterior.is_at_end == [false, false]);
    }

    #[test]
    fn elements_stay_in_their_ranges_and_say_so() {
        let posterior = found(prior(&[3.0, 1.0], WIDE, [0.0, 9.0]), |x| {
            (
                DVector::from_row_slice(&[-x[0] - 1.0 - 0.5 * x[1], 2.0 - x[1]]),
                DMatrix::from_row_slice(2, 2, &[1.0, 0.5, 0.0, 1.0]),
            )
        });
        assert!(posterior.is_at_end == [true, false] && posterior.end == End::Converged, "{posterior:?}");
        // At x₀ = 0 the second minimises (1 + x/2)² + (2 − x)², within the square root of gᵀδ.
        assert!(posterior.state[0].abs() < f64::MIN_POSITIVE && (posterior.state[1] - 1.2).abs() < 1.5e-3);
    }

    /// A model that answers with nothing but noise cannot converge.
    #[test]
    fn what_does_not_converge_is_said_to() {
        let posterior = found(prior(&[0.0], WIDE, [-9.0, 9.0]), |x| {
            (DVector::from_element(1, 1.0 + x[0].abs()), DMatrix::from_element(1, 1, 1.0))
        });
        assert_eq!(posterior.end, End::NotConverged);
    }

    #[test]
    fn before_any_data_the_posterior_is_the_prior() {
        let posterior = Search::new(prior(&[1.0, 2.0], 0.5, [0.0, 9.0])).posterior();
        assert_eq!(posterior.state, DVector::from_row_slice(&[1.0, 2.0]));
        assert!((posterior.covariance - DMatrix::identity(2, 2) * 0.25).amax() < 1e-15);
        assert!(posterior.averaging_kernel.amax() < f64::MIN_POSITIVE);
    }
}
