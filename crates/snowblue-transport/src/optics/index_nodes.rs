//! Interpolation in the refractive index of ice.
//!
//! Ray paths depend on the wavelength through the index alone, and that varies little: 1.3194 to 1.3069 over 400–700
//! nm. Scattering is therefore computed at a few Chebyshev nodes in n, with common random numbers, and interpolated by
//! Lagrange's polynomial.
//!
//! The error with three nodes is below max|Π(n − n_i)| · f'''/6, and the product is 6·10⁻⁸ over the visible range. For
//! T ∝ 1/(1 − g) with dg/dn = −0.9 that is 2·10⁻⁶ of T; for T = e^{−x} with x = 8 ∝ √(1 − g) it is 2·10⁻⁵.

use std::f64::consts::PI;

use super::ice::IceTable;
use super::spectral_table::WavelengthRange;
use crate::dual::Real;

/// Greatest mean distance of the nodes; 400–700 nm then take three.
const STEP: f64 = 0.006_25;

/// Indices at which scattering is computed, and their weights for any other index.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct IndexNodes(Vec<f64>);

impl IndexNodes {
    /// Nodes for some wavelengths: Chebyshev nodes, or the indices at the wavelengths if these are not more numerous.
    pub(crate) fn new(ice: IceTable, wavelengths_nm: &[f64]) -> Self {
        let mut own: Vec<f64> = wavelengths_nm.iter().map(|wavelength_nm| ice.index(*wavelength_nm)).collect();
        own.sort_by(f64::total_cmp);
        own.dedup();
        let between = Self::between(own[0], own[own.len() - 1]);
        if own.len() <= between.0.len() { Self(own) } else { between }
    }

    /// Chebyshev nodes between two indices, with a mean distance of at most [`STEP`].
    pub(crate) fn between(low: f64, high: f64) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a range of indices is some 0.1 wide"
        )]
        let count = ((high - low) / STEP).ceil() as usize + 1;
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        Self((0..count).map(|i| middle - half * (PI * (i as f64 + 0.5) / count as f64).cos()).collect())
    }

    /// The indices.
    pub(crate) fn nodes(&self) -> &[f64] {
        &self.0
    }

    /// The wavelengths in `range`, in nm, at which ice has the indices; its index decreases over `range`.
    pub(crate) fn wavelengths_nm(&self, ice: IceTable, range: WavelengthRange) -> Vec<f64> {
        let wavelength = |n: &f64| {
            let (mut low, mut high) = (range.first_nm, range.last_nm);
            // Bisects to double precision.
            for _ in 0..64 {
                let middle = 0.5 * (low + high);
                if ice.index(middle) > *n { low = middle } else { high = middle }
            }
            high
        };
        self.0.iter().map(wavelength).collect()
    }

    /// Lagrange's weights of the nodes at index `n`.
    pub(crate) fn weights(&self, n: f64) -> Vec<f64> {
        lagrange(&self.0, n)
    }
}

/// Lagrange's weights of any nodes at `x`.
pub(crate) fn lagrange<T: Real>(nodes: &[f64], x: T) -> Vec<T> {
    let weight = |(i, node): (usize, &f64)| {
        let others = nodes.iter().enumerate().filter(|(j, _)| *j != i);
        others.map(|(_, other)| (x - *other) / (node - other)).fold(T::from(1.0), T::mul)
    };
    nodes.iter().enumerate().map(weight).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn visible_light_takes_three_nodes() {
        let ice = IceTable::WarrenBrandt2008;
        let visible: Vec<f64> = (40..=70).map(|ten| 10.0 * f64::from(ten)).collect();
        assert_eq!(IndexNodes::new(ice, &visible).nodes().len(), 3);
        assert_eq!(IndexNodes::new(ice, &[550.0, 550.0]).nodes(), [ice.index(550.0)]);
        assert_eq!(IndexNodes::new(ice, &[400.0, 700.0]).nodes(), [ice.index(700.0), ice.index(400.0)]);
    }

    #[test]
    fn wavelengths_have_the_indices_of_the_nodes() {
        let ice = IceTable::WarrenBrandt2008;
        let nodes = IndexNodes::new(ice, &(30..=250).map(|ten| 10.0 * f64::from(ten)).collect::<Vec<_>>());
        for (n, wavelength_nm) in nodes.nodes().iter().zip(nodes.wavelengths_nm(ice, ice.wavelength_range())) {
            assert!((ice.index(wavelength_nm) - n).abs() < 1e-14, "{n}");
        }
    }

    #[test]
    fn lagrange_reproduces_polynomials() {
        let nodes = [1.30, 1.31, 1.33];
        let weights = lagrange(&nodes, 1.325);
        let square: f64 = weights.iter().zip(nodes).map(|(w, n)| w * n * n).sum();
        assert!((square - 1.325 * 1.325).abs() < 1e-14);
    }
}
