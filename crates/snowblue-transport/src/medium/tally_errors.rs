//! Deviations of media with the rays of their grain tallies, for standard errors by the delta method.
//!
//! The deviations d_b of the co-albedo and of the moments with each batch of rays have the covariance Σ_b d_b d_bᵀ. A
//! flux with the gradient ∇f has the variance Σ_b (d_bᵀ ∇f)²: a sum of squares of derivatives, which is equal for any
//! orthonormal directions in place of the batches.
//!
//! By similarity (van de Hulst 1980, *Multiple Light Scattering*, ch. 14) fluxes depend on the co-albedo and on the
//! asymmetry most, and less and less on higher moments. The directions are orthogonalized from the deviations of the
//! co-albedo and of three moments. Deviations of higher moments count as far as they go along with these quantities.

use super::scattering::Scattering;
use super::tally::Deviations;
use crate::dual::Dual;

/// Highest degree of a moment whose whole variance counts.
const DEGREE: usize = 3;
/// Fraction of the variance of a quantity that needs no further direction.
const NEGLIGIBLE: f64 = 0.01;

/// The deviations of grains in air and in water.
pub(crate) struct GrainDeviations(pub(super) [Option<DeviatingGrains>; 2]);

/// Scattering by grains in air or in water, with its deviations.
pub(super) struct DeviatingGrains {
    /// Extinction coefficient, in 1/m.
    pub(super) extinction_per_m: f64,
    pub(super) scattering: Scattering,
    /// Of the co-albedo and of the moments from χ_1.
    pub(super) deviations: Vec<Deviations>,
}

/// Orthonormal directions for the deviations of some media with common batches.
pub(crate) fn directions<'d>(media: impl Iterator<Item = &'d GrainDeviations> + Clone) -> Vec<Deviations> {
    let mut directions: Vec<Deviations> = Vec::new();
    for quantity in 0..=DEGREE {
        for GrainDeviations(kinds) in media.clone() {
            let mut whole = Deviations::default();
            for DeviatingGrains { extinction_per_m, deviations, .. } in kinds.iter().flatten() {
                add(&mut whole, *extinction_per_m, &deviations[quantity.min(deviations.len() - 1)]);
            }
            let mut rest = whole;
            for direction in &directions {
                let along = dot(&rest, direction);
                add(&mut rest, -along, direction);
            }
            let square = dot(&rest, &rest);
            if square > NEGLIGIBLE * dot(&whole, &whole) {
                directions.push(rest.map(|deviation| deviation / square.sqrt()));
            }
        }
    }
    directions
}

impl DeviatingGrains {
    /// The scattering with its deviations in some directions, no more than a [`Dual`] has derivatives.
    pub(super) fn along(&self, directions: &[Deviations]) -> Scattering<Dual> {
        let Self { scattering, deviations, .. } = self;
        let number = |value: f64, deviations: &Deviations| {
            Dual::new(value, std::array::from_fn(|lane| directions.get(lane).map_or(0.0, |one| dot(deviations, one))))
        };
        let moments = scattering.moments.iter().zip(deviations).skip(1);
        Scattering {
            one_minus_albedo: number(scattering.one_minus_albedo, &deviations[0]),
            moments: std::iter::once(Dual::from(1.0)).chain(moments.map(|(chi, by)| number(*chi, by))).collect(),
        }
    }
}

fn add(sums: &mut Deviations, factor: f64, terms: &Deviations) {
    sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += factor * term);
}

fn dot(one: &Deviations, other: &Deviations) -> f64 {
    one.iter().zip(other).map(|(one, other)| one * other).sum()
}
