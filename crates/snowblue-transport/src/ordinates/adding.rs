//! Reflection and transmission of diffuse light by layers, for each azimuthal mode, by adding–doubling (van de Hulst
//! 1980, *Multiple Light Scattering*, ch. 4; de Haan, Bosma & Hovenier 1987).
//!
//! Two equal layers with reflection r and transmission t make one layer with
//!
//! ```text
//! t′ = t (1 − r r)⁻¹ t,   r′ = r + t r (1 − r r)⁻¹ t.
//! ```
//!
//! The first layer is thin enough for the implicit midpoint rule, which conserves energy exactly.

use std::f64::consts::PI;

use nalgebra::DMatrix;

use super::eigen::Scaled;
use crate::quadrature::Quadrature;

/// Optical depth of the first layer.
pub(super) const FIRST_DEPTH: f64 = 1.0 / 65_536.0;
/// Most doublings of a half-space.
const MAX_DOUBLINGS: i32 = 64;
/// Transmission of a layer through which no light passes.
const OPAQUE: f64 = 1e-14;

/// Reflection and transmission of diffuse light by a layer, in one azimuthal mode: matrices from radiances of incidence
/// to radiances of exit.
pub(super) struct DiffuseOperators {
    pub(super) reflection: DMatrix<f64>,
    pub(super) transmission: DMatrix<f64>,
}

/// One azimuthal mode of a phase function times 4π, on the nodes: from each direction into the directions of its own
/// hemisphere and of the opposite hemisphere.
pub(super) struct PhaseMatrices {
    pub(super) forward: DMatrix<f64>,
    pub(super) backward: DMatrix<f64>,
}

impl DiffuseOperators {
    /// A thin layer by the implicit midpoint rule: t ± r = (1 + X)⁻¹ (1 − X) with X = ½τ M⁻¹ (1 − ½(p₊ ± p₋) W).
    pub(super) fn thin(phase: &PhaseMatrices, rule: &Quadrature, depth: f64) -> Self {
        let n = rule.order();
        let identity = DMatrix::identity(n, n);
        let half_step = |scattering: DMatrix<f64>| {
            DMatrix::from_fn(n, n, |i, j| {
                let kept = identity[(i, j)] - 0.5 * scattering[(i, j)] * rule.weights[j];
                0.5 * depth * kept / rule.cosines[i]
            })
        };
        let solve = |half_step: DMatrix<f64>| divide(&identity + &half_step, &identity - &half_step);
        let sum = solve(half_step(&phase.forward + &phase.backward));
        let difference = solve(half_step(&phase.forward - &phase.backward));
        Self { reflection: 0.5 * (&sum - &difference), transmission: 0.5 * (sum + difference) }
    }

    /// A layer of an optical depth, which may be infinite.
    pub(super) fn of_depth(phase: &PhaseMatrices, rule: &Quadrature, depth: f64) -> Self {
        let doublings = (0..MAX_DOUBLINGS).find(|count| FIRST_DEPTH * 2.0_f64.powi(*count) >= depth);
        let first = doublings.map_or(FIRST_DEPTH, |count| depth * 2.0_f64.powi(-count));
        let mut layer = Self::thin(phase, rule, first);
        for _ in 0..doublings.unwrap_or(MAX_DOUBLINGS) {
            layer = layer.doubled();
            if layer.transmission.amax() < OPAQUE {
                break;
            }
        }
        layer
    }

    /// This layer on another.
    pub(super) fn on(&self, below: &Self) -> Self {
        let Self { reflection: r, transmission: t } = self;
        let between = divide(DMatrix::identity(r.nrows(), r.nrows()) - r * &below.reflection, t.clone());
        Self { reflection: r + t * (&below.reflection * &between), transmission: &below.transmission * between }
    }

    /// Two of these layers.
    pub(super) fn doubled(&self) -> Self {
        self.on(self)
    }

    /// The radiance per incident flux, in 1/sr: the radiance per incident radiance times 1/(2π μ₀ w).
    pub(super) fn per_flux(mut reflection: DMatrix<f64>, rule: &Quadrature) -> DMatrix<f64> {
        for (mut column, (mu, weight)) in reflection.column_iter_mut().zip(rule.cosines.iter().zip(&rule.weights)) {
            column /= 2.0 * PI * mu * weight;
        }
        reflection
    }
}

impl PhaseMatrices {
    /// Sums over degrees by the addition theorem: Σ (2l + 1) χ_l Λ_l(μ) Λ_l(±μ′).
    pub(super) fn new(medium: &Scaled, mode: usize, rule: &Quadrature) -> Self {
        let n = rule.order();
        let functions = legendre_functions(mode, medium.albedo_moments.len(), rule);
        let mut parities = [DMatrix::zeros(n, n), DMatrix::zeros(n, n)];
        for (step, column) in functions.column_iter().enumerate() {
            let l = mode + step;
            let strength = (2 * l + 1) as f64 * medium.albedo_moments[l];
            parities[step % 2].ger(strength, &column, &column, 1.0);
        }
        let [even, odd] = parities;
        Self { forward: &even + &odd, backward: even - odd }
    }
}

/// √((l − m)!/(l + m)!) P_l^m(μ) at the nodes, a column for each l from m, below `degree` (Abramowitz & Stegun
/// 1964, 8.5.3).
fn legendre_functions(mode: usize, degree: usize, rule: &Quadrature) -> DMatrix<f64> {
    let mut functions = DMatrix::zeros(rule.order(), degree.saturating_sub(mode));
    let m = mode as f64;
    for (i, mu) in rule.cosines.iter().enumerate() {
        let sectoral = |k: usize| (1.0 - mu * mu).sqrt() * ((2 * k - 1) as f64 / (2 * k) as f64).sqrt();
        let (mut before, mut legendre) = (0.0, (1..=mode).map(sectoral).product::<f64>());
        for (step, value) in functions.row_mut(i).iter_mut().enumerate() {
            *value = legendre;
            let l = (mode + step) as f64;
            let next = ((2.0 * l + 1.0) * mu * legendre - (l * l - m * m).sqrt() * before)
                / ((l + 1.0) * (l + 1.0) - m * m).sqrt();
            (before, legendre) = (legendre, next);
        }
    }
    functions
}

/// A⁻¹ B.
fn divide(a: DMatrix<f64>, b: DMatrix<f64>) -> DMatrix<f64> {
    a.lu().solve(&b).unwrap_or_else(|| unreachable!("a layer reflects less than all light"))
}
