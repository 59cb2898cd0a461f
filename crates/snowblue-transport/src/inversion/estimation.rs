//! Optimal estimation: the most probable state, given data and a prior (Rodgers 2000, *Inverse Methods for
//! Atmospheric Sounding*, ch. 5).
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
//! H⁻¹ is the covariance of the posterior (eq. 5.30) and A = H⁻¹KᵀK the averaging kernel. The search has converged
//! when the undamped step δ is small compared with this covariance, gᵀδ ≪ n (eq. 5.29). This last step is taken
//! without another evaluation.
//!
//! H is never formed. With UᵀU = S_a⁻¹ and the factorisation QR of the rows of K and U, H = RᵀR, and δ is the
//! solution of a linear least-squares problem (Golub 1965, doi:10.1007/BF01436075). The condition number of R is the
//! square root of the condition number of H, so that elements which the data cannot distinguish keep the covariance
//! of their prior.
//!
//! An element at an end of its range is held there if J falls towards the outside. The posterior then describes the
//! other elements: H has the rows and columns of these elements only, and the rows of the held elements in the
//! covariance and the averaging kernel are 0.
//!
//! A model that is linear in exponentials of the state has second derivatives as large as the first derivatives. Once
//! a step has overshot, the second derivatives are included where they shorten the steps: max(0, −Kᵀr) is added to
//! the diagonal of H. Without the second derivatives the steps oscillate where the data require a smaller quantity
//! than the prior.

use nalgebra::{Cholesky, DMatrix, DVector};

/// Greatest gᵀδ, per element of the state, where a search has converged: a thousandth of a standard deviation.
const CONVERGED: f64 = 1e-6;
/// Greatest gᵀδ, per element of the state, where a step did not lower J: the derivatives of an interpolation in the
/// model are discontinuous.
const CONVERGED_WITHOUT_DESCENT: f64 = 1e-4;
const MAX_SOLUTIONS: usize = 80;
const FIRST_DAMPING: f64 = 1e-2;
/// Least damping where J falls by less than a quarter of the fall that its derivatives predict (Fletcher 1971): the
/// model is far from linear over a step, and undamped steps oscillate.
const OVERSHOT_DAMPING: f64 = 0.4;
const MAX_DAMPING: f64 = 1e6;

/// Prior of a state, and the range of each element.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Knowledge {
    pub(super) mean: DVector<f64>,
    /// U, where UᵀU = S_a⁻¹.
    pub(super) precision_root: DMatrix<f64>,
    /// Least value of each element.
    pub(super) least: DVector<f64>,
    /// Greatest value of each element.
    pub(super) greatest: DVector<f64>,
}

/// A search for the most probable state. The caller evaluates the model at [`trial`](Self::trial) and calls
/// [`take`](Self::take) until the search has ended, so that many searches can share the work.
#[derive(Debug, Clone)]
pub(super) struct Search {
    prior: Knowledge,
    best: Option<Evaluated>,
    trial: DVector<f64>,
    /// The fall of J from the best state to the trial, by its derivatives.
    predicted: f64,
    damping: f64,
    /// Whether steps have overshot.
    has_overshot: bool,
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
    /// K.
    jacobian: DMatrix<f64>,
    /// R.
    factor: DMatrix<f64>,
    /// The vector c that minimises |Rδ − c|² where δ minimises J: Qᵀ of the residuals of the data and the prior.
    target: DVector<f64>,
    /// max(0, −Kᵀr).
    second: DVector<f64>,
    /// g.
    descent: DVector<f64>,
}

/// The most probable state, with its covariance and averaging kernel.
#[derive(Debug, Clone)]
pub(super) struct Posterior {
    pub(super) state: DVector<f64>,
    pub(super) covariance: DMatrix<f64>,
    pub(super) averaging_kernel: DMatrix<f64>,
    /// |r|².
    pub(super) data_cost: f64,
    /// (x − x_a)ᵀ S_a⁻¹ (x − x_a).
    pub(super) prior_cost: f64,
    /// Whether each element is held at an end of its range.
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
            has_overshot: false,
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
        let evaluated = Evaluated::new(&self.prior, self.trial.clone(), residuals, jacobian);
        let fall = self.best.as_ref().map(|best| best.cost() - evaluated.cost());
        let is_better = fall.is_none_or(|fall| fall > 0.0);
        if is_better {
            self.damping = match fall {
                Some(fall) if fall < 0.25 * self.predicted && self.has_overshot => {
                    OVERSHOT_DAMPING.max(2.0 * self.damping)
                }
                Some(fall) if fall > 0.75 * self.predicted => 0.1 * self.damping,
                _ => self.damping,
            };
            self.has_overshot |= fall.is_some_and(|fall| fall < 0.25 * self.predicted);
            self.best = Some(evaluated);
        } else {
            self.has_overshot = true;
            self.damping *= 10.0;
        }
        self.advance(is_better);
        is_better
    }

    /// Ends the search, or chooses the next trial.
    fn advance(&mut self, is_better: bool) {
        let Some(best) = &mut self.best else { return };
        let free = best.free(&self.prior);
        let second = if self.has_overshot { best.second.clone() } else { DVector::zeros(best.second.len()) };
        let full = best.step(&free, &second);
        let decrement = full.dot(&best.descent) / full.len() as f64;
        let damped = &second + (best.curvature() + &second) * self.damping;
        let trial = self.prior.within(&(&best.state + best.step(&free, &damped)));
        let step = &trial - &best.state;
        let curved = (&best.factor * &step).norm_squared() + step.component_mul(&step).dot(&second);
        self.predicted = 2.0 * best.descent.dot(&step) - curved;
        self.end = if !decrement.is_finite() || trial.iter().any(|element| element.is_nan()) {
            Some(End::NotConverged)
        } else if decrement <= CONVERGED {
            best.state = self.prior.within(&(&best.state + full));
            Some(End::Converged)
        } else if !is_better && decrement <= CONVERGED_WITHOUT_DESCENT {
            Some(End::Converged)
        } else {
            let is_stuck = self.damping > MAX_DAMPING || trial == best.state;
            (is_stuck || self.solutions >= MAX_SOLUTIONS).then_some(End::NotConverged)
        };
        self.trial = trial;
    }

    /// The posterior that the search has found; before any evaluation, the prior.
    pub(super) fn posterior(self) -> Posterior {
        let best = self.best.unwrap_or_else(|| {
            let n = self.prior.mean.len();
            Evaluated::new(&self.prior, self.prior.mean.clone(), &DVector::zeros(0), &DMatrix::zeros(0, n))
        });
        let free = best.free(&self.prior);
        let (covariance, averaging_kernel) = best.posterior(&self.prior, &free);
        Posterior {
            averaging_kernel,
            covariance,
            data_cost: best.data_cost,
            prior_cost: best.prior_cost,
            is_at_end: (0..best.state.len()).map(|i| !free.contains(&i)).collect(),
            state: best.state,
            solutions: self.solutions,
            end: self.end.unwrap_or(End::Converged),
        }
    }
}

impl Knowledge {
    /// The state with each element clamped to its range.
    fn within(&self, state: &DVector<f64>) -> DVector<f64> {
        state.zip_zip_map(&self.least, &self.greatest, f64::clamp)
    }
}

impl Evaluated {
    fn new(prior: &Knowledge, state: DVector<f64>, residuals: &DVector<f64>, jacobian: &DMatrix<f64>) -> Self {
        let from_mean = &prior.precision_root * (&state - &prior.mean);
        let data_descent = jacobian.tr_mul(residuals);
        let descent = &data_descent - prior.precision_root.tr_mul(&from_mean);
        let right = DVector::from_iterator(
            residuals.len() + from_mean.len(),
            residuals.iter().copied().chain(from_mean.iter().map(|element| -element)),
        );
        let (factor, target) = triangular(&[jacobian.clone(), prior.precision_root.clone()], &right);
        Self {
            data_cost: residuals.norm_squared(),
            prior_cost: from_mean.norm_squared(),
            jacobian: jacobian.clone(),
            factor,
            target,
            second: data_descent.map(|descent| (-descent).max(0.0)),
            descent,
            state,
        }
    }

    /// J.
    fn cost(&self) -> f64 {
        self.data_cost + self.prior_cost
    }

    /// The diagonal of H.
    fn curvature(&self) -> DVector<f64> {
        DVector::from_iterator(self.state.len(), self.factor.column_iter().map(|column| column.norm_squared()))
    }

    /// The elements that are not held at an end of their range.
    fn free(&self, prior: &Knowledge) -> Vec<usize> {
        let is_free = |i: &usize| {
            let (x, descent) = (self.state[*i], self.descent[*i]);
            !(x <= prior.least[*i] && descent < 0.0 || x >= prior.greatest[*i] && descent > 0.0)
        };
        (0..self.state.len()).filter(is_free).collect()
    }

    /// The step δ with `added` on the diagonal of H; 0 for elements that are held.
    fn step(&self, free: &[usize], added: &DVector<f64>) -> DVector<f64> {
        let roots = DVector::from_iterator(free.len(), free.iter().map(|i| added[*i].sqrt()));
        let (factor, target) =
            triangular(&[self.factor.select_columns(free), DMatrix::from_diagonal(&roots)], &self.target);
        let solved = factor.solve_upper_triangular(&target);
        let mut step = DVector::zeros(self.state.len());
        for (k, i) in free.iter().enumerate() {
            step[*i] = solved.as_ref().map_or(f64::NAN, |solved| solved[k]);
        }
        step
    }

    /// Covariance and averaging kernel of the free elements, with 0 in the rows of the held elements.
    fn posterior(&self, prior: &Knowledge, free: &[usize]) -> (DMatrix<f64>, DMatrix<f64>) {
        let (n, of_free) = (self.state.len(), free.len());
        let factors = stacked(&[self.jacobian.select_columns(free), prior.precision_root.select_columns(free)]).qr();
        let (orthogonal, factor) = factors.unpack();
        let unknown = || DMatrix::from_element(of_free, of_free, f64::NAN);
        let inverse = factor.solve_upper_triangular(&DMatrix::identity(of_free, of_free)).unwrap_or_else(unknown);
        let covariance = &inverse * inverse.transpose();
        // H⁻¹KᵀK, where the rows of Q that belong to K have H⁻¹Kᵀ = R⁻¹Qᵀ.
        let kernel = &inverse * orthogonal.rows(0, self.jacobian.nrows()).tr_mul(&self.jacobian);
        let (mut all, mut rows) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
        for (k, i) in free.iter().enumerate() {
            rows.row_mut(*i).copy_from(&kernel.row(k));
            free.iter().enumerate().for_each(|(l, j)| all[(*i, *j)] = covariance[(k, l)]);
        }
        (all, rows)
    }
}

/// U with UᵀU = S⁻¹, if S is positive definite.
pub(super) fn precision_root(covariance: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    // A diagonal of 1: deviations may differ by orders of magnitude.
    let scales = covariance.diagonal().map(|variance| 1.0 / variance.sqrt());
    let n = scales.len();
    let correlation = DMatrix::from_fn(n, n, |i, j| covariance[(i, j)] * scales[i] * scales[j]);
    let lower = Cholesky::new(correlation)?.unpack();
    let root = lower.solve_lower_triangular(&DMatrix::from_diagonal(&scales))?;
    root.iter().all(|entry| entry.is_finite()).then_some(root)
}

/// The rows of several matrices in one matrix.
fn stacked(parts: &[DMatrix<f64>]) -> DMatrix<f64> {
    let mut stacked = DMatrix::zeros(parts.iter().map(DMatrix::nrows).sum(), parts[0].ncols());
    let mut first = 0;
    for part in parts {
        stacked.rows_mut(first, part.nrows()).copy_from(part);
        first += part.nrows();
    }
    stacked
}

/// R of the rows of some matrices, and the first elements of Qᵀ of a right-hand side, which is 0 below its end.
fn triangular(parts: &[DMatrix<f64>], right: &DVector<f64>) -> (DMatrix<f64>, DVector<f64>) {
    let stacked = stacked(parts);
    let mut right = right.clone().resize_vertically(stacked.nrows(), 0.0);
    let n = stacked.ncols();
    let factors = stacked.qr();
    factors.q_tr_mul(&mut right);
    (factors.unpack_r(), right.rows(0, n).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDE: f64 = 1e6;

    fn prior(mean: &[f64], deviation: f64, [least, greatest]: [f64; 2]) -> Knowledge {
        let n = mean.len();
        Knowledge {
            mean: DVector::from_row_slice(mean),
            precision_root: DMatrix::identity(n, n) / deviation,
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

    /// For a line y = 2 + 3x at x = 0 … 4 with a prior, the posterior agrees with Bayesian linear regression.
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
        // At x₀ = 0 the second element minimises (1 + x/2)² + (2 − x)², within the square root of gᵀδ.
        assert!(posterior.state[0].abs() < f64::MIN_POSITIVE && (posterior.state[1] - 1.2).abs() < 1.5e-3);
        // With the first element held, H = 1/2² + 1². The second follows both true elements by H⁻¹ (1/2, 1/2² + 1²).
        let covariance = DMatrix::from_row_slice(2, 2, &[0.0, 0.0, 0.0, 0.8]);
        let kernel = DMatrix::from_row_slice(2, 2, &[0.0, 0.0, 0.4, 1.0]);
        // The prior has 10⁻¹² of the weight of the data.
        assert!((&posterior.covariance - covariance).amax() < 1e-11, "{posterior:?}");
        assert!((&posterior.averaging_kernel - kernel).amax() < 1e-11, "{posterior:?}");
    }

    /// The data determine the sum of two elements to 10⁻⁹ and do not determine their difference, which keeps the
    /// variance of the prior. H is singular to rounding; R has the condition number 1.4·10⁹, of which rounding leaves
    /// 3·10⁻⁷.
    #[test]
    fn elements_that_act_alike_keep_their_prior() {
        const PRECISION: f64 = 1e9;
        let posterior = found(prior(&[1.0, 1.0], 1.0, [-9.0, 9.0]), |x| {
            let residuals = DVector::from_fn(3, |i, _| PRECISION * (i + 1) as f64 * (3.0 - x[0] - x[1]));
            (residuals, DMatrix::from_fn(3, 2, |i, _| PRECISION * (i + 1) as f64))
        });
        assert_eq!(posterior.end, End::Converged, "{posterior:?}");
        assert!((&posterior.state - DVector::from_element(2, 1.5)).amax() < 1e-6, "{posterior:?}");
        let half = DMatrix::from_row_slice(2, 2, &[0.5, -0.5, -0.5, 0.5]);
        assert!((&posterior.covariance - &half).amax() < 1e-6, "{posterior:?}");
        assert!((&posterior.averaging_kernel - half.abs()).amax() < 1e-6, "{posterior:?}");
    }

    #[test]
    fn a_model_without_a_value_does_not_converge() {
        let posterior = found(prior(&[0.5], 1.0, [-9.0, 9.0]), |x| {
            (DVector::from_element(1, f64::NAN * x[0]), DMatrix::from_element(1, 1, 1.0))
        });
        assert_eq!(posterior.end, End::NotConverged);
    }

    #[test]
    fn a_matrix_that_is_not_positive_definite_has_no_root() {
        let covariance = |entry: f64| DMatrix::from_row_slice(2, 2, &[4.0, entry, entry, 1e-8]);
        assert_eq!(precision_root(&covariance(2e-4)), None);
        let root = precision_root(&covariance(1e-4)).unwrap();
        assert!((root.tr_mul(&root) * covariance(1e-4) - DMatrix::identity(2, 2)).amax() < 1e-9);
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
