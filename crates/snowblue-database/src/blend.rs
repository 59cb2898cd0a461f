//! A snow sample as a weighted sum of a table's samples.
//!
//! The paper takes only the samples of the grid. In log space the coefficients of the neighbouring samples are
//! interpolated by cubics ([`crate::cubic`]): in the logarithm of the grain size, in facetness, in the square root of
//! an impurity's mass fraction (absorption is proportional to the fraction, and ln T to the root of absorption), and in
//! the value of every other property that the table has an axis of. Nothing is extrapolated.
//!
//! Density is exact in dry snow, also with impurities: extinction is proportional to it and scattering does not change,
//! so snow of density ρ and thickness h is equivalent to snow of density ρ' and thickness h ρ/ρ'. In wet snow the
//! fractions of ice and water change with density, and density is interpolated like the other properties.

use snowblue_base::unit_suffix;
use snowblue_transport::sample::SnowSample;
use snowblue_transport::{Parameter, ParameterRange};

use crate::pca::Components;
use crate::{Axes, CompressedTable, DatabaseError, Property, PropertyAxis, PropertyValue, TableSample, cubic};

/// A sample of a table, or a value of an axis, with its weight.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Weighted {
    index: usize,
    weight: f64,
}

/// Weighted samples of a table.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Blend {
    samples: Vec<Weighted>,
    /// Ratio of the thickness at the density of these samples to the thickness of the snow.
    pub(crate) thickness_scale: f64,
}

/// An axis of samples, and the sample's value.
struct SampleAxis<'axes> {
    property: Property,
    values: &'axes [f64],
    value: f64,
}

/// Largest relative difference of two values that count as equal.
const SAME: f64 = 1e-9;

impl Blend {
    /// The sample with a given number.
    pub(crate) fn one(number: usize) -> Self {
        Self { samples: vec![Weighted { index: number, weight: 1.0 }], thickness_scale: 1.0 }
    }

    /// The table's sample that equals `sample`.
    ///
    /// # Errors
    /// [`DatabaseError::OffGrid`] if a value is not on its axis, [`DatabaseError::NoAxis`] if a property has no axis.
    pub(crate) fn on_grid(axes: &Axes, sample: &TableSample) -> Result<Self, DatabaseError> {
        check_properties(axes, sample)?;
        let mut number = 0;
        for SampleAxis { property, values, value } in sample_axes(axes, sample) {
            let ParameterRange { quantity, unit, .. } = property.parameter().range;
            let known = || values.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
            let index = values.iter().position(|known| same(*known, value));
            let index = index.ok_or_else(|| DatabaseError::OffGrid { quantity, value, known: known(), unit })?;
            number = number * values.len() + index;
        }
        Ok(Self::one(number))
    }

    /// The table's samples around `sample`.
    ///
    /// # Errors
    /// [`DatabaseError::OffAxis`] if a value is beyond its axis, [`DatabaseError::NoAxis`] if a property has no axis,
    /// or an error if the density is out of the model's range.
    pub(crate) fn between(axes: &Axes, sample: &TableSample) -> Result<Self, DatabaseError> {
        check_properties(axes, sample)?;
        SnowSample { density_kg_m3: sample.density_kg_m3, ..SnowSample::default() }.check()?;
        let is_dry = sample.property(Property::WaterSaturation) <= 0.0;
        let mut blend = Self::one(0);
        for SampleAxis { property, values, value } in sample_axes(axes, sample) {
            let ParameterRange { quantity, unit, .. } = property.parameter().range;
            let weights = if property == Property::Density && is_dry {
                let index = nearest(values, value);
                blend.thickness_scale = if same(values[index], value) { 1.0 } else { value / values[index] };
                vec![Weighted { index, weight: 1.0 }]
            } else {
                weights(values, value, coordinate(property)).ok_or_else(|| DatabaseError::OffAxis {
                    quantity,
                    value,
                    covered: covered(values, unit),
                    unit,
                })?
            };
            let neighbours = |sample: Weighted| {
                weights.iter().map(move |value| Weighted {
                    index: sample.index * values.len() + value.index,
                    weight: sample.weight * value.weight,
                })
            };
            blend.samples = blend.samples.iter().copied().flat_map(neighbours).collect();
        }
        Ok(blend)
    }

    /// The coefficients of this snow's curves, without diffuse light: [angle][thickness][component].
    pub(crate) fn coefficients(&self, table: &CompressedTable, components: &Components) -> Vec<f64> {
        let per_light = table.axes.thicknesses_cm.len() * components.count;
        let per_sample = table.axes.curves_per_sample() * components.count;
        // Diffuse light comes first and is not looked up.
        let skipped = if table.axes.diffuse { per_light } else { 0 };
        let mut blended = vec![0.0; per_sample - skipped];
        for Weighted { index, weight } in &self.samples {
            let coefficients = &components.coefficients[index * per_sample + skipped..(index + 1) * per_sample];
            blended.iter_mut().zip(coefficients).for_each(|(sum, value)| *sum += weight * f64::from(*value));
        }
        blended
    }
}

/// Every axis of samples, slowest first.
fn sample_axes<'a>(axes: &'a Axes, sample: &TableSample) -> Vec<SampleAxis<'a>> {
    let axis = |property, values: &'a [f64], value| SampleAxis { property, values, value };
    let mut all = vec![
        axis(Property::GrainSize, &axes.grain_sizes_um, sample.grain_size_um),
        axis(Property::Facetness, &axes.facetness, sample.facetness),
        axis(Property::Density, &axes.densities_kg_m3, sample.density_kg_m3),
    ];
    let further =
        |PropertyAxis { property, values }: &'a PropertyAxis| axis(*property, values, sample.property(*property));
    all.extend(axes.properties.iter().map(further));
    all
}

/// Checks that properties without an axis have their default values.
fn check_properties(axes: &Axes, sample: &TableSample) -> Result<(), DatabaseError> {
    for PropertyValue { property, value } in &sample.properties {
        let has = axes.properties.iter().any(|other| other.property == *property);
        let Parameter { range: ParameterRange { quantity, unit, .. }, default, .. } = property.parameter();
        if !has && !same(*value, default) {
            return Err(DatabaseError::NoAxis { quantity, value: *value, unit, default });
        }
    }
    Ok(())
}

/// The function of a property's value in which it is interpolated.
fn coordinate(property: Property) -> fn(f64) -> f64 {
    match property {
        Property::GrainSize => f64::ln,
        Property::Impurity(_) => f64::sqrt,
        _ => |value| value,
    }
}

/// The weights of an axis's values at `value`; `None` beyond the axis.
fn weights(values: &[f64], value: f64, coordinate: fn(f64) -> f64) -> Option<Vec<Weighted>> {
    if let Some(index) = values.iter().position(|known| same(*known, value)) {
        return Some(vec![Weighted { index, weight: 1.0 }]);
    }
    if !(values[0]..=values[values.len() - 1]).contains(&value) {
        return None;
    }
    let knots: Vec<f64> = values.iter().map(|value| coordinate(*value)).collect();
    let weights = cubic::weights(&knots, coordinate(value)).into_iter();
    Some(weights.map(|(index, weight)| Weighted { index, weight }).collect())
}

/// The index of the value that is nearest by ratio.
fn nearest(values: &[f64], value: f64) -> usize {
    let distance = |index: &usize| (values[*index] / value).ln().abs();
    (0..values.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
}

/// The range of an axis, in words.
fn covered(values: &[f64], unit: &str) -> String {
    let unit = unit_suffix(unit);
    match values {
        [only] => format!("has only {only}{unit}"),
        [low, .., high] => format!("covers {low}–{high}{unit}"),
        [] => "has none".to_owned(),
    }
}

fn same(one: f64, other: f64) -> bool {
    (one - other).abs() <= SAME * one.abs()
}
