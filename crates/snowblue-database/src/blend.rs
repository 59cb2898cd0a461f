//! One snow as a table knows it: which of the table's samples make it up, and how much of each.
//!
//! The paper takes the grid's own values alone. In log space the coefficients of the samples around are interpolated, by
//! cubics ([`crate::cubic`]) in the logarithm of the grain size, in facetness, in the square root of an impurity's mass
//! fraction (absorption goes in proportion to the fraction, and ln T with the root of absorption), and in what else the
//! table has an axis of. Nothing is extrapolated.
//!
//! Density is exact in dry snow, clean or not: κ is in proportion to it and scattering is not touched, so that snow of
//! density ρ and thickness h is snow of density ρ' and thickness h ρ/ρ'. In wet snow the water between the grains goes
//! another way than the grains, and density is interpolated like the rest.

use snowblue_transport::sample::SnowSample;

use crate::pca::Components;
use crate::{Axes, CompressedTable, DatabaseError, Property, TableSample, cubic};

/// Samples of a table by their numbers, each with its weight, and how much thickness_scale the snow seems in their density.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Blend {
    pub(crate) samples: Vec<(usize, f64)>,
    pub(crate) thickness_scale: f64,
}

/// How finely two values on an axis are told apart, relative to them.
const SAME: f64 = 1e-9;

impl Blend {
    /// The one sample of the table that this snow is.
    ///
    /// # Errors
    /// [`DatabaseError::OffGrid`] if a value is not on its axis, [`DatabaseError::NoAxis`] if it has none.
    pub(crate) fn on_grid(axes: &Axes, sample: &TableSample) -> Result<Self, DatabaseError> {
        check_properties(axes, sample)?;
        let mut number = 0;
        for (name, unit, values, value) in places(axes, sample) {
            let known = || values.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
            let place = values.iter().position(|known| same(*known, value));
            let place = place.ok_or_else(|| DatabaseError::OffGrid { quantity: name, value, known: known(), unit })?;
            number = number * values.len() + place;
        }
        Ok(Self { samples: vec![(number, 1.0)], thickness_scale: 1.0 })
    }

    /// The samples around this snow.
    ///
    /// # Errors
    /// [`DatabaseError::OffAxis`] if a value lies beyond its axis, [`DatabaseError::NoAxis`] if it has none, or if the
    /// density is none that snow has.
    pub(crate) fn between(axes: &Axes, sample: &TableSample) -> Result<Self, DatabaseError> {
        check_properties(axes, sample)?;
        SnowSample { density_kg_m3: sample.density_kg_m3, ..SnowSample::default() }.check()?;
        let dry = sample.property(Property::WaterSaturation) <= 0.0;
        let mut blend = Self { samples: vec![(0, 1.0)], thickness_scale: 1.0 };
        for (axis, (name, unit, values, value)) in places(axes, sample).into_iter().enumerate() {
            let weights = if axis == DENSITY_AXIS && dry {
                let (place, known) = nearest(values, value);
                blend.thickness_scale = if same(known, value) { 1.0 } else { value / known };
                vec![(place, 1.0)]
            } else {
                weights(values, value, coordinate(axes, axis)).ok_or_else(|| DatabaseError::OffAxis {
                    quantity: name,
                    value,
                    covered: covered(values, unit),
                    unit,
                })?
            };
            let beside = |(number, share): (usize, f64)| {
                weights.iter().map(move |(place, weight)| (number * values.len() + place, share * weight))
            };
            blend.samples = blend.samples.iter().copied().flat_map(beside).collect();
        }
        Ok(blend)
    }

    /// The coefficients of this snow's curves, without Lambertian light: [angle][thickness][component].
    pub(crate) fn coefficients(&self, table: &CompressedTable, components: &Components) -> Vec<f64> {
        let per_light = table.axes.thicknesses_cm.len() * components.count;
        let per_sample = table.axes.curves_per_sample() * components.count;
        // Lambertian light, which stands first, is not looked up.
        let skipped = if table.axes.diffuse { per_light } else { 0 };
        let mut blended = vec![0.0; per_sample - skipped];
        for (number, weight) in &self.samples {
            let one = &components.coefficients[number * per_sample + skipped..(number + 1) * per_sample];
            blended.iter_mut().zip(one).for_each(|(sum, value)| *sum += weight * f64::from(*value));
        }
        blended
    }
}

/// The density's place among the axes of samples.
const DENSITY_AXIS: usize = 2;

/// Every axis of samples, slowest first, with its name and unit for messages, its values and the sample's.
fn places<'a>(axes: &'a Axes, sample: &TableSample) -> Vec<(&'static str, &'static str, &'a [f64], f64)> {
    let mut places = vec![
        ("grain size", " µm", &axes.grain_sizes_um[..], sample.grain_size_um),
        ("facetness", "", &axes.facetness[..], sample.facetness),
        ("density", " kg/m³", &axes.densities_kg_m3[..], sample.density_kg_m3),
    ];
    for (property, values) in &axes.further {
        places.push((property.title(), property.unit_beside(), values, sample.property(*property)));
    }
    places
}

/// A property that the table has no axis of must have its usual value.
fn check_properties(axes: &Axes, sample: &TableSample) -> Result<(), DatabaseError> {
    for (property, value) in &sample.further {
        let has = axes.further.iter().any(|(other, _)| other == property);
        if !has && !same(*value, property.usual()) {
            let (quantity, unit, usual) = (property.title(), property.unit_beside(), property.usual());
            return Err(DatabaseError::NoAxis { quantity, value: *value, unit, usual });
        }
    }
    Ok(())
}

/// In what a value is interpolated.
fn coordinate(axes: &Axes, axis: usize) -> fn(f64) -> f64 {
    match axis {
        0 => f64::ln,
        1 | DENSITY_AXIS => |value| value,
        further => match axes.further[further - DENSITY_AXIS - 1].0 {
            Property::Impurity(_) => f64::sqrt,
            Property::WaterSaturation | Property::Temperature => |value| value,
        },
    }
}

/// What each value of an axis counts at `value`; nothing beyond the axis.
fn weights(values: &[f64], value: f64, coordinate: fn(f64) -> f64) -> Option<Vec<(usize, f64)>> {
    if let Some(place) = values.iter().position(|known| same(*known, value)) {
        return Some(vec![(place, 1.0)]);
    }
    if !(values[0]..=values[values.len() - 1]).contains(&value) {
        return None;
    }
    let knots: Vec<f64> = values.iter().map(|value| coordinate(*value)).collect();
    Some(cubic::weights(&knots, coordinate(value)))
}

/// The value of an axis that is nearest by ratio, and its place.
fn nearest(values: &[f64], value: f64) -> (usize, f64) {
    let far = |known: f64| (known / value).ln().abs();
    let places = values.iter().copied().enumerate();
    places.min_by(|(_, a), (_, b)| far(*a).total_cmp(&far(*b))).unwrap_or((0, value))
}

/// What an axis covers, in words.
fn covered(values: &[f64], unit: &str) -> String {
    match values {
        [only] => format!("has {only}{unit} alone"),
        [low, .., high] => format!("covers {low}–{high}{unit}"),
        [] => "has none".to_owned(),
    }
}

fn same(one: f64, other: f64) -> bool {
    (one - other).abs() <= SAME * one.abs()
}
