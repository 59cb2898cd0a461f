//! The few wavelengths at which light is solved for, and its interpolation between them.
//!
//! At any place the logarithm of the fluence rate, over ℓ* and the spectrum of the light that enters, is a smooth
//! and even function of √μ_a, since light decays over a distance as e^{−√(3 μ_a/ℓ*) z}. A cubic spline through a few
//! nodes at equal distances in √μ_a, and through their mirror images at −√μ_a, gives all wavelengths.

use wide::f32x4;

/// Wavelengths of a group.
pub const GROUP: usize = 4;

/// Nodes among some wavelengths.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectralNodes {
    /// Indices of the wavelengths of the nodes, a multiple of four.
    indices: Vec<usize>,
    /// For each wavelength the weight of the value at each node.
    weights: Vec<Vec<f32>>,
}

impl SpectralNodes {
    /// Chooses nodes in `groups` groups of four for the absorption coefficients of all wavelengths, in 1/m. Some
    /// wavelength may serve as several nodes if there are few.
    ///
    /// # Panics
    ///
    /// If there is no wavelength.
    #[must_use]
    pub fn new(absorption_per_m: &[f64], groups: usize) -> Self {
        let roots: Vec<f64> = absorption_per_m.iter().map(|absorption| absorption.sqrt()).collect();
        let mut order: Vec<usize> = (0..roots.len()).collect();
        order.sort_by(|a, b| roots[*a].total_cmp(&roots[*b]));
        let (least, greatest) = (roots[order[0]], roots[order[order.len() - 1]]);
        let count = groups * GROUP;
        let mut indices: Vec<usize> = Vec::with_capacity(count);
        for node in 0..count {
            let wanted = least + (greatest - least) * node as f64 / (count - 1) as f64;
            // Those of less absorption are taken, and each further node needs another wavelength.
            let after = indices.last().map_or(0, |last| 1 + order.iter().position(|index| index == last).unwrap_or(0));
            let left = count - node;
            let end = order.len().saturating_sub(left - 1).max(after + 1).min(order.len());
            let candidates = &order[after.min(order.len() - 1)..end];
            let nearest =
                candidates.iter().min_by(|a, b| (roots[**a] - wanted).abs().total_cmp(&(roots[**b] - wanted).abs()));
            indices.push(*nearest.unwrap_or(&order[order.len() - 1]));
        }
        Self::at(indices, absorption_per_m)
    }

    /// The same nodes for other absorption coefficients, in 1/m.
    #[must_use]
    pub fn with_absorption(&self, absorption_per_m: &[f64]) -> Self {
        Self::at(self.indices.clone(), absorption_per_m)
    }

    fn at(indices: Vec<usize>, absorption_per_m: &[f64]) -> Self {
        let at_nodes: Vec<f64> = indices.iter().map(|index| absorption_per_m[*index].sqrt()).collect();
        let weights = absorption_per_m.iter().map(|absorption| spline_weights(&at_nodes, absorption.sqrt())).collect();
        Self { indices, weights }
    }

    /// Chooses as few groups of nodes as give the light behind a slab of a thickness, in m, with an error of less than
    /// half a percent at all wavelengths: those of transport mean free paths in m and absorption coefficients in 1/m.
    #[must_use]
    pub fn for_thickness(transport_lengths_m: &[f64], absorption_per_m: &[f64], thickness_m: f64) -> Self {
        const ALLOWED: f64 = 5e-3;
        const MOST_GROUPS: usize = 4;
        // Over ℓ*, a slab transmits k/sinh kd, which is 1/d without absorption.
        let light = |index: usize| {
            let k = (3.0 * absorption_per_m[index] / transport_lengths_m[index]).sqrt();
            let depth = k * thickness_m;
            if depth < 1e-6 { -thickness_m.ln() } else { (2.0 * k).ln() - depth - (-(-2.0 * depth).exp()).ln_1p() }
        };
        let error = |nodes: &Self| {
            #[expect(clippy::cast_possible_truncation, reason = "rounding is intended")]
            let at_nodes: Vec<f32> = nodes.indices.iter().map(|index| light(*index) as f32).collect();
            let of_index = |index| (f64::from(nodes.interpolate(index, &at_nodes)) - light(index)).abs();
            (0..absorption_per_m.len()).map(of_index).fold(0.0, f64::max)
        };
        let mut nodes = Self::new(absorption_per_m, 1);
        for groups in 2..=MOST_GROUPS {
            if error(&nodes) > ALLOWED {
                nodes = Self::new(absorption_per_m, groups);
            }
        }
        nodes
    }

    /// Indices of the wavelengths of the nodes, four for each group.
    #[must_use]
    pub fn indices(&self) -> &[usize] {
        &self.indices
    }

    /// Values of all wavelengths at the nodes, in groups.
    pub fn gather(&self, values: impl Fn(usize) -> f32) -> impl Iterator<Item = f32x4> {
        self.indices.as_chunks::<GROUP>().0.iter().map(move |group| f32x4::from(group.map(&values)))
    }

    /// The value at wavelength number `wavelength` of the spline through values at the nodes.
    #[inline]
    #[must_use]
    pub fn interpolate(&self, wavelength: usize, nodes: &[f32]) -> f32 {
        self.weights[wavelength].iter().zip(nodes).map(|(weight, value)| weight * value).sum()
    }
}

/// The weights of the nodes' values in the cubic spline through them and their mirror images, at `x`. Nodes that
/// coincide count once.
fn spline_weights(nodes: &[f64], x: f64) -> Vec<f32> {
    let mut order: Vec<usize> = (0..nodes.len()).collect();
    order.sort_by(|a, b| nodes[*a].total_cmp(&nodes[*b]));
    let mut distinct: Vec<usize> = Vec::new();
    for k in order {
        let node = &nodes[k];
        if *node > distinct.last().map_or(0.0, |last| nodes[*last]) || distinct.is_empty() {
            distinct.push(k);
        }
    }
    let mirrored = distinct.iter().rev().filter(|k| nodes[**k] > 0.0).map(|k| (-nodes[*k], *k));
    let points: Vec<(f64, usize)> = mirrored.chain(distinct.iter().map(|k| (nodes[*k], *k))).collect();
    let at: Vec<f64> = points.iter().map(|(x, _)| *x).collect();
    let weight = |place: usize| {
        let unit: Vec<f64> = points.iter().map(|(_, k)| if *k == place { 1.0 } else { 0.0 }).collect();
        #[expect(clippy::cast_possible_truncation, reason = "rounding is intended")]
        let weight = natural_spline(&at, &unit, x) as f32;
        weight
    };
    (0..nodes.len()).map(weight).collect()
}

/// The natural cubic spline through some points (Press et al. 2007, *Numerical Recipes*, section 3.3).
fn natural_spline(x: &[f64], y: &[f64], at: f64) -> f64 {
    let n = x.len();
    if n == 1 {
        return y[0];
    }
    let (mut second, mut scratch) = (vec![0.0; n], vec![0.0; n]);
    for i in 1..n - 1 {
        let share = (x[i] - x[i - 1]) / (x[i + 1] - x[i - 1]);
        let pivot = share * second[i - 1] + 2.0;
        second[i] = (share - 1.0) / pivot;
        let change = (y[i + 1] - y[i]) / (x[i + 1] - x[i]) - (y[i] - y[i - 1]) / (x[i] - x[i - 1]);
        scratch[i] = (6.0 * change / (x[i + 1] - x[i - 1]) - share * scratch[i - 1]) / pivot;
    }
    for i in (0..n - 1).rev() {
        second[i] = second[i] * second[i + 1] + scratch[i];
    }
    second[0] = 0.0;
    let i = x.partition_point(|node| *node < at).clamp(1, n - 1);
    let width = x[i] - x[i - 1];
    let (a, b) = ((x[i] - at) / width, (at - x[i - 1]) / width);
    a * y[i - 1] + b * y[i] + ((a * a * a - a) * second[i - 1] + (b * b * b - b) * second[i]) * width * width / 6.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Absorption of snow of 400 µm and 300 kg/m³ at 400–700 nm (specification of the light field, coarse fit).
    fn absorption() -> Vec<f64> {
        (0..31).map(|k| 4e-4 * (f64::from(k) * 0.21).exp()).collect()
    }

    /// The largest error of the logarithm of the light behind a slab, over all wavelengths.
    fn worst(groups: usize, thickness_m: f64) -> f64 {
        let absorption = absorption();
        let nodes = SpectralNodes::new(&absorption, groups);
        assert_eq!((nodes.indices()[0], nodes.indices()[4 * groups - 1]), (0, 30));
        let light = |index: usize| {
            let k: f64 = (3.0 * absorption[index] / 0.002_f64).sqrt();
            (k / (k * thickness_m).sinh()).ln()
        };
        #[expect(clippy::cast_possible_truncation, reason = "rounding is intended")]
        let at_nodes: Vec<f32> = nodes.indices().iter().map(|index| light(*index) as f32).collect();
        let error = |index: usize| (f64::from(nodes.interpolate(index, &at_nodes)) - light(index)).abs();
        (0..31).map(error).fold(0.0, f64::max)
    }

    #[test]
    fn few_nodes_give_the_light_behind_a_slab() {
        for (groups, thickness_m, allowed) in [(1, 0.05, 2e-3), (1, 0.15, 5e-3), (2, 0.15, 5e-4), (2, 0.6, 2e-3)] {
            let error = worst(groups, thickness_m);
            assert!(error < allowed, "{groups} {thickness_m}: {error}");
        }
    }

    #[test]
    fn few_wavelengths_are_nodes_several_times() {
        let nodes = SpectralNodes::new(&[0.1, 0.2], 1);
        assert_eq!(nodes.indices().len(), 4);
        let values: Vec<f32> = nodes.indices().iter().map(|index| [3.0, 5.0][*index]).collect();
        assert!(
            (nodes.interpolate(0, &values) - 3.0).abs() < 1e-6 && (nodes.interpolate(1, &values) - 5.0).abs() < 1e-6
        );
    }
}
