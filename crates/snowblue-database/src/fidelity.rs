//! Accuracy of compression: rebuilt curves against the originals, by root mean square error and by colour difference
//! (ΔE*ab, CIELAB 1976).

use rayon::prelude::*;
use snowblue_color::{Colorimeter, Illuminant, Lab, Observer};

use crate::pca::{Components, Decomposition, MAX_COMPONENTS};
use crate::{DatabaseError, Quantity, Space, Table};

/// Errors of one rebuilt curve.
#[derive(Debug, Clone, Copy, PartialEq)]
struct CurveError {
    rmse: f64,
    delta_e: f64,
    negative: usize,
}

/// Errors of a compressed table against the full table.
#[derive(Debug, Clone, PartialEq)]
pub struct Fidelity {
    /// Root mean square error of each curve over its wavelengths.
    pub rmse: Spread,
    /// Colour difference of each curve under the illuminant, with the illuminant as white.
    pub delta_e: Spread,
    /// Fraction of the curves whose ΔE exceeds [`PERCEPTIBLE_DELTA_E`].
    pub perceptible_fraction: f64,
    /// Number of rebuilt values below zero, over all curves and wavelengths.
    pub negative_values: usize,
}

/// Largest errors that compression may cause in any curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Criteria {
    /// Colour difference ΔE*ab (CIELAB 1976).
    pub max_delta_e: f64,
    /// Root mean square error.
    pub max_rmse: f64,
    /// The illuminants, each of which is the white of its colours.
    pub illuminants: Vec<Illuminant>,
}

/// The fewest components that keep both quantities within the criteria, which is how the paper chooses l'.
///
/// # Errors
/// [`DatabaseError::Criteria`] if no number of components meets the criteria, or if the wavelengths do not determine
/// colours.
pub fn fewest_components(table: &Table, space: Space, criteria: &Criteria) -> Result<usize, DatabaseError> {
    let decompositions: Vec<(Quantity, Decomposition)> = Quantity::ALL
        .into_iter()
        .map(|quantity| Ok((quantity, Decomposition::new(table, quantity, space)?)))
        .collect::<Result<_, DatabaseError>>()?;
    // Colours are compared only if a criterion needs them, since infrared light has none.
    let lights: Vec<Option<Illuminant>> = if criteria.max_delta_e.is_finite() {
        criteria.illuminants.iter().copied().map(Some).collect()
    } else {
        vec![None]
    };
    let mut failing = Quantity::Transmittance;
    let max = decompositions
        .iter()
        .map(|(_, decomposition)| decomposition.singular_values().len())
        .min()
        .unwrap_or(0)
        .min(MAX_COMPONENTS);
    // Both quantities are evaluated for each number, since errors need not decrease with every component.
    'counts: for count in 1..=max {
        for (quantity, decomposition) in &decompositions {
            let components = decomposition.keep(table, *quantity, count)?;
            for illuminant in &lights {
                let found = evaluate(table, *quantity, &components, space, *illuminant)?;
                if found.rmse.worst > criteria.max_rmse || found.delta_e.worst > criteria.max_delta_e {
                    failing = *quantity;
                    continue 'counts;
                }
            }
        }
        return Ok(count);
    }
    Err(DatabaseError::Criteria { quantity: failing.name(), max })
}

/// Compares every rebuilt curve of a quantity with the original. Without an illuminant, colour differences are 0.
///
/// # Errors
/// If the wavelengths do not determine colours under `illuminant`.
pub fn evaluate(
    table: &Table,
    quantity: Quantity,
    components: &Components,
    space: Space,
    illuminant: Option<Illuminant>,
) -> Result<Fidelity, DatabaseError> {
    let colorimeter = |illuminant| Colorimeter::new(Observer::Cie1931, illuminant, &table.axes.wavelengths_nm);
    let colorimeter = illuminant.map(colorimeter).transpose()?;
    let wavelengths = table.axes.wavelengths_nm.len();
    let curves: Vec<&[f64]> = table.curves(quantity).collect();
    let errors: Vec<CurveError> = curves
        .par_iter()
        .enumerate()
        .map(|(number, curve)| {
            let mut rebuilt = vec![0.0; wavelengths];
            components.rebuild(number, space, &mut rebuilt);
            let squares: f64 = curve.iter().zip(&rebuilt).map(|(a, b)| (a - b).powi(2)).sum();
            let differ = |colorimeter: &Colorimeter| {
                let lab = |values: &[f64]| Lab::from_xyz(colorimeter.xyz(values), colorimeter.white());
                lab(curve).delta_e_1976(lab(&rebuilt))
            };
            CurveError {
                rmse: (squares / wavelengths as f64).sqrt(),
                delta_e: colorimeter.as_ref().map_or(0.0, differ),
                negative: rebuilt.iter().filter(|value| **value < 0.0).count(),
            }
        })
        .collect();
    let visible = errors.iter().filter(|error| error.delta_e > PERCEPTIBLE_DELTA_E).count();
    Ok(Fidelity {
        rmse: spread(errors.iter().map(|error| error.rmse)),
        delta_e: spread(errors.iter().map(|error| error.delta_e)),
        perceptible_fraction: visible as f64 / errors.len() as f64,
        negative_values: errors.iter().map(|error| error.negative).sum(),
    })
}

/// ΔE*ab below which an average observer sees no difference (Varsa & Baranoski 2024, after Kravchenko et al. 2017).
pub const PERCEPTIBLE_DELTA_E: f64 = 2.3;

/// Statistics of one measure over all curves or points.
#[derive(Debug, Clone, PartialEq)]
pub struct Spread {
    /// Largest value.
    pub worst: f64,
    /// Number of the curve or point with the largest value.
    pub worst_curve: usize,
    /// 99th percentile.
    pub percentile_99: f64,
    /// Mean.
    pub mean: f64,
}

/// Worst, 99th percentile (nearest rank) and mean; zeros if there are no values.
pub(super) fn spread(values: impl Iterator<Item = f64>) -> Spread {
    let mut ranked: Vec<(f64, usize)> = values.enumerate().map(|(i, value)| (value, i)).collect();
    if ranked.is_empty() {
        return Spread { worst: 0.0, worst_curve: 0, percentile_99: 0.0, mean: 0.0 };
    }
    let mean = ranked.iter().map(|(value, _)| value).sum::<f64>() / ranked.len() as f64;
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (worst, worst_curve) = ranked[ranked.len() - 1];
    let rank = (ranked.len() * 99).div_ceil(100) - 1;
    Spread { worst, worst_curve, percentile_99: ranked[rank].0, mean }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_of_a_hundred_numbers_is_exact() {
        let spread = spread((0..100).rev().map(f64::from));
        assert_eq!((spread.worst_curve, spread.worst.to_bits()), (0, 99.0_f64.to_bits()));
        assert!((spread.percentile_99 - 98.0).abs() < 1e-12 && (spread.mean - 49.5).abs() < 1e-12);
    }
}
