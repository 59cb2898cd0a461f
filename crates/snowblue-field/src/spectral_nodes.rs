//! The few wavelengths at which the light is solved for (nodes), and the interpolation of the light between them.
//!
//! At any place, the logarithm of the fluence rate relative to the spectrum of the incident light is nearly a smooth
//! and even function of √μ_a, since light decays over a distance z as e^{−√(3 μ_a/ℓ*) z}. A cubic spline gives all
//! wavelengths. It passes through a few nodes, and through their mirror images at −√μ_a. The nodes have equal
//! distances in √μ_a or, as only light of low absorption comes through thick snow, in its root.
//!
//! The logarithm also depends on ℓ*, which varies by 3 % from 400 to 700 nm, mostly where μ_a hardly varies. Light
//! behind thin snow is proportional to ℓ*. Light that thick snow reflects hardly depends on ℓ*. The power of ℓ* at a
//! place is computed at the node whose value the other nodes predict worst for a power of 1 ([`KnownFactor`]).
//!
//! In layered snow the light depends on the absorption of each layer. Soot in one layer absorbs blue light more than
//! red light, and ice absorbs red light more than blue light. Two wavelengths may therefore have equal mean μ_a but
//! different light. From one wavelength to the next, however, the point with the coordinates √(wμ_a) of all layers
//! moves along a smooth curve. Here w is the share of a layer in the thickness. The arc length of the curve from the
//! origin replaces √μ_a. If the layers are equal and absorption increases from each wavelength to the next, the arc
//! length is √μ_a.
//!
//! Bodies that exchange light have common nodes. For bodies of different snow, the point has the coordinates of all
//! layers of all bodies, and w is the share of the layer in the thickness of its body. Bodies of nearly equal snow
//! count once.

use wide::f32x4;

/// Number of wavelengths of a group.
pub const GROUP: usize = 4;
/// Greatest number of groups of nodes.
pub const MAX_GROUPS: usize = 4;

/// Values of each group; 0 for groups that are not used.
pub type Groups = [f32x4; MAX_GROUPS];

/// A layer of snow at some wavelengths. Its thickness is measured along a typical vertical line through a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LayerSpectrum<'a> {
    /// Transport mean free paths, in m.
    pub transport_lengths_m: &'a [f64],
    /// Absorption coefficients, in 1/m.
    pub absorption_per_m: &'a [f64],
    /// Thickness, in m.
    pub thickness_m: f64,
}

/// Nodes among some wavelengths.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectralNodes {
    /// Indices of the wavelengths of the nodes, a multiple of four.
    indices: Vec<usize>,
    /// √μ_a of the nodes, or the arc length that replaces it.
    at_nodes: Vec<f64>,
    /// For each node the weight of its value at each wavelength.
    weights: Vec<Vec<f32>>,
}

impl SpectralNodes {
    /// Chooses `groups` groups of four nodes for all wavelengths, by their √μ_a. If there are few wavelengths, one of
    /// them may serve as several nodes.
    fn new(roots: &[f64], groups: usize, spacing: Spacing) -> Self {
        let mut order: Vec<usize> = (0..roots.len()).collect();
        order.sort_by(|a, b| roots[*a].total_cmp(&roots[*b]));
        let (least, greatest) = (roots[order[0]], roots[order[order.len() - 1]]);
        let count = groups * GROUP;
        let mut indices: Vec<usize> = Vec::with_capacity(count);
        for node in 0..count {
            let part = node as f64 / (count - 1) as f64;
            let part = if spacing == Spacing::Growing { part * part } else { part };
            let wanted = least + (greatest - least) * part;
            // Wavelengths of less absorption are taken, and each further node needs another wavelength.
            let after = indices.last().map_or(0, |last| 1 + order.iter().position(|index| index == last).unwrap_or(0));
            let left = count - node;
            let end = order.len().saturating_sub(left - 1).max(after + 1).min(order.len());
            let candidates = &order[after.min(order.len() - 1)..end];
            let nearest =
                candidates.iter().min_by(|a, b| (roots[**a] - wanted).abs().total_cmp(&(roots[**b] - wanted).abs()));
            indices.push(*nearest.unwrap_or(&order[order.len() - 1]));
        }
        let at_nodes: Vec<f64> = indices.iter().map(|index| roots[*index]).collect();
        let of_wavelengths: Vec<Vec<f32>> = roots.iter().map(|root| spline_weights(&at_nodes, *root)).collect();
        let weights = (0..count).map(|node| of_wavelengths.iter().map(|weights| weights[node]).collect()).collect();
        Self { indices, at_nodes, weights }
    }

    /// Chooses the least number of groups of nodes with which the light behind each body, divided by ℓ*, has an error
    /// of less than half a percent at all wavelengths, or else four groups. A body is given by its layers; a body of
    /// uniform snow has one layer.
    ///
    /// # Panics
    ///
    /// If there is no body, a body of no layer, or no wavelength.
    #[must_use]
    pub fn for_bodies(bodies: &[Vec<LayerSpectrum>]) -> Self {
        const ALLOWED: f64 = 5e-3;
        let bodies = thickest_of_each_snow(bodies);
        let roots = roots(&bodies);
        // The transmittance of a slab divided by ℓ* is k/sinh kd, which is 1/d without absorption.
        let of_layer = |layer: &LayerSpectrum, index: usize| {
            let k = (3.0 * layer.absorption_per_m[index] / layer.transport_lengths_m[index]).sqrt();
            let (thickness_m, depth) = (layer.thickness_m, k * layer.thickness_m);
            if depth < 1e-6 { -thickness_m.ln() } else { (2.0 * k).ln() - depth - (-(-2.0 * depth).exp()).ln_1p() }
        };
        let is_there = |layer: &&LayerSpectrum| layer.thickness_m > 0.0;
        let has_error = |nodes: &Self, layers: &[LayerSpectrum]| {
            let light =
                |index: usize| -> f64 { layers.iter().filter(is_there).map(|layer| of_layer(layer, index)).sum() };
            let at_nodes: Vec<f32> = nodes.indices.iter().map(|index| single(light(*index))).collect();
            let mut values = vec![0.0; roots.len()];
            nodes.add_interpolated(&at_nodes, &mut values);
            values.iter().enumerate().any(|(index, value)| (f64::from(*value) - light(index)).abs() > ALLOWED)
        };
        let mut nodes = Self::new(&roots, 1, Spacing::Equal);
        for (groups, spacing) in (2..=MAX_GROUPS).flat_map(|groups| Spacing::ALL.map(|spacing| (groups, spacing))) {
            if bodies.iter().any(|layers| has_error(&nodes, layers)) {
                nodes = Self::new(&roots, groups, spacing);
            }
        }
        nodes
    }

    /// Indices of the wavelengths of the nodes, four for each group.
    #[must_use]
    pub fn indices(&self) -> &[usize] {
        &self.indices
    }

    /// Number of groups of four nodes.
    #[must_use]
    pub fn group_count(&self) -> usize {
        self.indices.len() / GROUP
    }

    /// Values of all wavelengths at the nodes, in groups.
    pub fn gather(&self, values: impl Fn(usize) -> f32) -> impl Iterator<Item = f32x4> {
        self.indices.as_chunks::<GROUP>().0.iter().map(move |group| f32x4::from(group.map(&values)))
    }

    /// Adds the spline through values at the nodes to a sum at each wavelength.
    #[inline]
    pub fn add_interpolated(&self, at_nodes: &[f32], sums: &mut [f32]) {
        for (value, weights) in at_nodes.iter().zip(&self.weights) {
            sums.iter_mut().zip(weights).for_each(|(sum, weight)| *sum += weight * value);
        }
    }
}

/// Distances of the nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Spacing {
    /// Equal distances in √μ_a.
    Equal,
    /// Distances that grow with √μ_a.
    Growing,
}

impl Spacing {
    const ALL: [Self; 2] = [Self::Equal, Self::Growing];
}

/// A factor with a known spectrum that enters the values at a place with some power.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownFactor {
    /// For each wavelength, the logarithm of the factor minus the spline through its logarithms at the nodes.
    lacking: Vec<f32>,
    /// The weights of the logarithms of values at the nodes, whose weighted sum is the power.
    power_weights: Vec<f32>,
}

/// Least error of the predicted logarithm at a node from which a power is computed. Below it, the power matters
/// little.
const MIN_LACKING: f64 = 1e-3;

impl KnownFactor {
    /// A factor by its values at all wavelengths.
    #[must_use]
    pub fn new(nodes: &SpectralNodes, factor: &[f64]) -> Self {
        let logarithms: Vec<f64> = factor.iter().map(|factor| factor.ln()).collect();
        let at_nodes: Vec<f64> = nodes.indices.iter().map(|index| logarithms[*index]).collect();
        let predicted = |weights: &[f32]| -> f64 {
            weights.iter().zip(&at_nodes).map(|(weight, at)| f64::from(*weight) * at).sum()
        };
        let mut lacking = logarithms;
        for (at, weights) in at_nodes.iter().zip(&nodes.weights) {
            lacking.iter_mut().zip(weights).for_each(|(lacking, weight)| *lacking -= f64::from(*weight) * at);
        }
        // The value at each node minus the value that the other nodes predict for it.
        let differences = (0..at_nodes.len()).map(|node| {
            let mut others = nodes.at_nodes.clone();
            let at = others.remove(node);
            let mut weights = spline_weights(&others, at);
            weights.insert(node, 0.0);
            weights.iter_mut().for_each(|weight| *weight = -*weight);
            weights[node] = 1.0;
            (predicted(&weights), weights)
        });
        let greatest = differences.max_by(|(one, _), (other, _)| one.abs().total_cmp(&other.abs()));
        let (difference, mut power_weights) = greatest.unwrap_or_default();
        let inverse = if difference.abs() > MIN_LACKING { difference.recip() } else { 0.0 };
        power_weights.iter_mut().for_each(|weight| *weight = single(f64::from(*weight) * inverse));
        Self { lacking: lacking.into_iter().map(single).collect(), power_weights }
    }

    /// The power of the factor in some values, from the logarithms of the values at the nodes.
    ///
    /// Where light has decayed, the error of the spline exceeds the variation of the factor, and limits apply. Behind
    /// a slab of thickness d the light is ℓ* k / sinh kd with k ∝ ℓ*^{−1/2}. The power is 1 where kd is small, and ½
    /// (1 + kd) where kd is large. Behind and inside snow, the range of the logarithms replaces kd.
    #[must_use]
    pub fn power(&self, logarithms: &[f32]) -> f32 {
        let sum: f32 = self.power_weights.iter().zip(logarithms).map(|(weight, logarithm)| weight * logarithm).sum();
        let [least, greatest] = [f32::min, f32::max].map(|of| logarithms.iter().copied().reduce(of).unwrap_or(0.0));
        let range = greatest - least;
        sum.clamp((range - 0.5).min(1.0), 1.0 + 0.5 * range)
    }

    /// The logarithm of the factor minus the spline through its logarithms at the nodes, at each wavelength for a
    /// power of 1.
    #[inline]
    #[must_use]
    pub fn lacking(&self) -> &[f32] {
        &self.lacking
    }
}

/// Greatest ratio of the absorption coefficients of nearly equal snow.
const LIKE: f64 = 1.25;

/// The layers of each body. Of several one-layer bodies of nearly equal snow, only the thickest body is kept.
fn thickest_of_each_snow<'b, 'a>(bodies: &'b [Vec<LayerSpectrum<'a>>]) -> Vec<&'b [LayerSpectrum<'a>]> {
    let mut chosen: Vec<&[LayerSpectrum]> = Vec::new();
    for body in bodies {
        let like = chosen.iter_mut().find(|other| match (&body[..], &other[..]) {
            ([one], [other]) => one.is_like(other),
            (one, other) => one == other,
        });
        match like {
            Some(other) if other[0].thickness_m < body[0].thickness_m => *other = body,
            Some(_) => {}
            None => chosen.push(body),
        }
    }
    chosen
}

impl LayerSpectrum<'_> {
    /// Whether this layer and another layer absorb nearly equally at each wavelength.
    fn is_like(&self, other: &Self) -> bool {
        let mut pairs = self.absorption_per_m.iter().zip(other.absorption_per_m);
        pairs.all(|(one, other)| one.max(*other) <= LIKE * one.min(*other))
    }
}

/// √μ_a or the arc length that replaces it, at each wavelength.
fn roots(bodies: &[&[LayerSpectrum]]) -> Vec<f64> {
    if let [[only]] = bodies {
        return only.absorption_per_m.iter().map(|absorption| absorption.sqrt()).collect();
    }
    let layers = bodies.iter().flat_map(|layers| {
        let whole_m: f64 = layers.iter().map(|layer| layer.thickness_m).sum();
        layers.iter().map(move |layer| (layer.thickness_m / whole_m, layer.absorption_per_m))
    });
    let layers: Vec<(f64, &[f64])> = layers.collect();
    let mut length = 0.0;
    let root = |index: usize| {
        let step = |(share, absorption_per_m): &(f64, &[f64])| {
            let place = |index: usize| (share * absorption_per_m[index]).sqrt();
            let before = if index == 0 { 0.0 } else { place(index - 1) };
            (place(index) - before).powi(2)
        };
        length += layers.iter().map(step).sum::<f64>().sqrt();
        length
    };
    (0..layers[0].1.len()).map(root).collect()
}

/// Distance below which two nodes count as one, divided by the mean distance of nodes. A spline through nearly
/// coincident nodes would be steep wherever their values differ a little.
const NEAR: f64 = 0.3;

/// The weights of the nodes' values in the cubic spline through the nodes and their mirror images, at `x`. Of nearly
/// coincident nodes, only the first counts.
fn spline_weights(nodes: &[f64], x: f64) -> Vec<f32> {
    let mut order: Vec<usize> = (0..nodes.len()).collect();
    order.sort_by(|a, b| nodes[*a].total_cmp(&nodes[*b]));
    let range = order.last().map_or(0.0, |last| nodes[*last] - nodes[order[0]]);
    let near = NEAR * range / nodes.len().saturating_sub(1).max(1) as f64;
    let mut distinct: Vec<usize> = Vec::new();
    for k in order {
        if distinct.last().is_none_or(|last| nodes[k] - nodes[*last] > near) {
            distinct.push(k);
        }
    }
    let mirrored = distinct.iter().rev().filter(|k| nodes[**k] > 0.0).map(|k| (-nodes[*k], *k));
    let points: Vec<(f64, usize)> = mirrored.chain(distinct.iter().map(|k| (nodes[*k], *k))).collect();
    let at: Vec<f64> = points.iter().map(|(x, _)| *x).collect();
    let weight = |place: usize| {
        let unit: Vec<f64> = points.iter().map(|(_, k)| if *k == place { 1.0 } else { 0.0 }).collect();
        single(natural_spline(&at, &unit, x))
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

#[expect(clippy::cast_possible_truncation, reason = "rounding is intended")]
fn single(value: f64) -> f32 {
    value as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Absorption of snow of 400 µm and 300 kg/m³ at 400–700 nm (specification of the light field, coarse fit).
    fn absorption() -> Vec<f64> {
        (0..31).map(|k| 4e-4 * (f64::from(k) * 0.21).exp()).collect()
    }

    fn interpolated(nodes: &SpectralNodes, at_nodes: &[f32]) -> [f32; 31] {
        let mut values = [0.0; 31];
        nodes.add_interpolated(at_nodes, &mut values);
        values
    }

    /// The largest error of the logarithm of the light behind a slab, over all wavelengths.
    fn worst(groups: usize, thickness_m: f64) -> f64 {
        let absorption = absorption();
        let roots: Vec<f64> = absorption.iter().map(|absorption| absorption.sqrt()).collect();
        let nodes = SpectralNodes::new(&roots, groups, Spacing::Equal);
        assert_eq!((nodes.indices()[0], nodes.indices()[4 * groups - 1]), (0, 30));
        let light = |index: usize| {
            let k: f64 = (3.0 * absorption[index] / 0.002_f64).sqrt();
            (k / (k * thickness_m).sinh()).ln()
        };
        #[expect(clippy::cast_possible_truncation, reason = "rounding is intended")]
        let at_nodes: Vec<f32> = nodes.indices().iter().map(|index| light(*index) as f32).collect();
        let error = |(index, value)| (f64::from(value) - light(index)).abs();
        interpolated(&nodes, &at_nodes).into_iter().enumerate().map(error).fold(0.0, f64::max)
    }

    #[test]
    fn few_nodes_give_the_light_behind_a_slab() {
        for (groups, thickness_m, allowed) in [(1, 0.05, 2e-3), (1, 0.15, 5e-3), (2, 0.15, 5e-4), (2, 0.6, 2e-3)] {
            let error = worst(groups, thickness_m);
            assert!(error < allowed, "{groups} {thickness_m}: {error}");
        }
    }

    /// Light that snow reflects does not depend on ℓ*. Light behind thin snow is proportional to ℓ*.
    #[test]
    fn a_known_factor_is_found_in_any_power() {
        let roots: Vec<f64> = absorption().iter().map(|absorption| absorption.sqrt()).collect();
        // ℓ* grows by 3.5 %, most of it where μ_a is least.
        let lengths: Vec<f64> = (0..31).map(|k| (0.035 * (1.0 - (-0.1 * f64::from(k)).exp())).exp()).collect();
        for groups in [1, 2, 4] {
            let nodes = SpectralNodes::new(&roots, groups, Spacing::Equal);
            let factor = KnownFactor::new(&nodes, &lengths);
            for power in [0.0, 0.4, 1.0] {
                let light = |index: usize| power * lengths[index].ln() - 0.3 * absorption()[index];
                let at_nodes: Vec<f32> = nodes.indices().iter().map(|index| single(light(*index))).collect();
                let found = factor.power(&at_nodes);
                assert!((f64::from(found) - power).abs() < 0.05, "{groups} {power}: {found}");
                for (index, value) in interpolated(&nodes, &at_nodes).into_iter().enumerate() {
                    let value = value + found * factor.lacking()[index];
                    // The error of the spline through four nodes alone is 7·10⁻⁴.
                    assert!((f64::from(value) - light(index)).abs() < 1e-3, "{groups} {power} {index}: {value}");
                }
            }
        }
    }

    /// Behind slabs the power exceeds 1 where light decays, and the spline has an error where light decays fast.
    #[test]
    fn light_behind_slabs_keeps_its_colour_though_the_factor_varies() {
        let lengths: Vec<f64> = (0..31).map(|k| 0.002 * (0.035 * (1.0 - (-0.1 * f64::from(k)).exp())).exp()).collect();
        let absorption = absorption();
        for thickness_m in [0.01, 0.03, 0.1, 0.2, 0.3, 0.6, 1.0, 2.0] {
            let layer = LayerSpectrum { transport_lengths_m: &lengths, absorption_per_m: &absorption, thickness_m };
            let nodes = SpectralNodes::for_bodies(&[vec![layer]]);
            let factor = KnownFactor::new(&nodes, &lengths);
            let light = |index: usize| {
                let k = (3.0 * absorption[index] / lengths[index]).sqrt();
                (lengths[index] * k / (k * thickness_m).sinh()).ln()
            };
            let at_nodes: Vec<f32> = nodes.indices().iter().map(|index| single(light(*index))).collect();
            let power = factor.power(&at_nodes);
            for (index, value) in interpolated(&nodes, &at_nodes).into_iter().enumerate() {
                let value = value + power * factor.lacking()[index];
                // Half a percent by the choice of nodes, and the error of the power.
                let error = (f64::from(value) - light(index)).abs();
                assert!(error < 7e-3, "{thickness_m} m, {index}: {error}, power {power}");
            }
        }
    }

    /// Algae absorb equally at all wavelengths below 560 nm, so that many of the nodes nearly coincide.
    #[test]
    fn nodes_that_nearly_coincide_do_not_make_the_spline_steep() {
        let root = |k: f64| if k < 16.0 { 1.88 + 1e-5 * k * k } else { 0.8 + 0.3 * (0.6 * k).sin() };
        let roots: Vec<f64> = (0..31).map(|k| root(f64::from(k))).collect();
        for groups in 1..=MAX_GROUPS {
            for spacing in Spacing::ALL {
                let weights = SpectralNodes::new(&roots, groups, spacing).weights;
                for index in 0..31 {
                    let sum: f32 = weights.iter().map(|of_node| of_node[index].abs()).sum();
                    assert!(sum < 3.0, "{groups} {spacing:?} {index}: {weights:?}");
                }
            }
        }
    }

    #[test]
    fn few_wavelengths_are_nodes_several_times() {
        let nodes = SpectralNodes::new(&[0.3, 0.4], 1, Spacing::Equal);
        assert_eq!(nodes.indices().len(), 4);
        let values: Vec<f32> = nodes.indices().iter().map(|index| [3.0, 5.0][*index]).collect();
        let found = interpolated(&nodes, &values);
        assert!((found[0] - 3.0).abs() < 1e-6 && (found[1] - 5.0).abs() < 1e-6);
    }

    /// With 50 ng/g of soot in a crust over clean snow, blue and orange light have equal mean absorption, but the
    /// light behind the snow differs. Wavelengths that lie apart in one body may nearly coincide in another body.
    #[test]
    fn snow_of_different_colour_has_nodes_for_all() {
        let clean = absorption();
        let with_soot = |ng_g: f64| -> Vec<f64> {
            let soot = |k: i32| 0.01 * ng_g * (550.0 / (400.0 + 10.0 * f64::from(k))).powf(1.2);
            (0..).zip(&clean).map(|(k, clean)| clean + soot(k)).collect()
        };
        let lengths = vec![0.002; 31];
        let layer = |absorption_per_m, thickness_m| LayerSpectrum {
            transport_lengths_m: &lengths,
            absorption_per_m,
            thickness_m,
        };
        let check = |bodies: &[Vec<LayerSpectrum>]| {
            let nodes = SpectralNodes::for_bodies(bodies);
            for layers in bodies {
                let light = |index: usize| {
                    let decay = |layer: &LayerSpectrum| {
                        let k = (3.0 * layer.absorption_per_m[index] / 0.002_f64).sqrt();
                        k / (k * layer.thickness_m).sinh()
                    };
                    layers.iter().map(decay).product::<f64>().ln()
                };
                #[expect(clippy::cast_possible_truncation, reason = "rounding is intended")]
                let at_nodes: Vec<f32> = nodes.indices().iter().map(|index| light(*index) as f32).collect();
                for (index, value) in interpolated(&nodes, &at_nodes).into_iter().enumerate() {
                    let error = f64::from(value) - light(index);
                    assert!(error.abs() < 5e-3, "{index}: {error}");
                }
            }
        };
        let sooty: Vec<Vec<f64>> = [20.0, 50.0, 100.0, 110.0, 150.0, 300.0].map(with_soot).into();
        for dirty in &sooty {
            check(&[vec![layer(dirty, 0.02), layer(&clean, 0.08)]]);
            for [dirty_m, clean_m] in [[0.2, 0.2], [0.19, 0.2], [0.05, 0.3]] {
                check(&[vec![layer(dirty, dirty_m)], vec![layer(&clean, clean_m)]]);
            }
        }
        // Equal snow in several layers or bodies has the nodes of one layer.
        let whole = vec![layer(&clean, 0.1)];
        let halves = vec![layer(&clean, 0.03), layer(&clean, 0.07)];
        for (one, other) in roots(&[&halves]).iter().zip(roots(&[&whole])) {
            assert!((one / other - 1.0).abs() < 1e-12, "{one} {other}");
        }
        let bodies = [vec![layer(&clean, 0.02)], whole.clone(), vec![layer(&clean, 0.05)]];
        assert_eq!(SpectralNodes::for_bodies(&bodies), SpectralNodes::for_bodies(&[whole]));
        // Many bodies of nearly equal snow do not outweigh a body of other snow.
        let many: Vec<Vec<f64>> = (0..50).map(|k| with_soot(500.0 + f64::from(k))).collect();
        let alike = many.iter().map(|snow| vec![layer(snow, 0.3)]);
        check(&alike.chain([vec![layer(&clean, 0.5)]]).collect::<Vec<_>>());
    }
}
