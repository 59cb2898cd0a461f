//! The axes of a table: snow, light, thickness and wavelength.

use snowblue_transport::optics::IceTable;
use snowblue_transport::parameters::ANGLE;
use snowblue_transport::sample::SnowSample;
use snowblue_transport::slab::{Incidence, Slab};

use crate::property::{further_properties, unit_in_files};
use crate::{DatabaseError, Property, PropertyAxis, PropertyValue, TableSample};

/// Values along each axis, ascending. The last axis runs fastest in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct Axes {
    /// Mean grain sizes (greatest extension), in µm; each stands for a range of ± 50 µm.
    pub grain_sizes_um: Vec<f64>,
    /// Mean facetness.
    pub facetness: Vec<f64>,
    /// Densities of the dry snow, in kg/m³.
    pub densities_kg_m3: Vec<f64>,
    /// Axes of further properties. Properties without an axis have their default values.
    pub properties: Vec<PropertyAxis>,
    /// Whether the first light is diffuse (Lambertian), before the angles.
    pub diffuse: bool,
    /// Angles of incidence from the normal, in degrees.
    pub angles_deg: Vec<f64>,
    /// Thicknesses, in cm.
    pub thicknesses_cm: Vec<f64>,
    /// Wavelengths, in nm.
    pub wavelengths_nm: Vec<f64>,
}

/// An axis with its name and unit in files.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedAxis {
    /// Name.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Values, ascending.
    pub values: Vec<f64>,
}

/// A value on a named axis.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Coordinate {
    pub(crate) name: &'static str,
    pub(crate) unit: &'static str,
    pub(crate) value: f64,
}

/// The value for diffuse light on the axis of angles in files.
pub const DIFFUSE_ANGLE_DEG: f64 = -1.0;
/// Largest angle of incidence of an axis, in degrees.
const MAX_ANGLE_DEG: f64 = ANGLE.range.greatest;
/// Thicknesses below and above the paper's thicknesses, in cm, for splines that are accurate from 0 cm to 1 m.
const THIN_KNOTS_CM: [f64; 11] = [0.000_5, 0.001, 0.002, 0.004, 0.008, 0.015, 0.03, 0.06, 0.12, 0.25, 0.5];
const THICK_KNOTS_CM: [f64; 2] = [70.0, 100.0];
/// The paper's angles and two more where transmittance curves most, in degrees.
const ANGLES_DEG: [f64; 12] = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 75.0, 80.0, 85.0, 89.0];

/// Greatest absolute value of an axis, in any unit. Single precision, in which look-ups run, holds its square.
const MAX_VALUE: f64 = 1e15;
/// Greatest number of values of a quantity in a table: 2 GiB in memory, 350 times the number in the paper.
const MAX_VALUES: usize = 1 << 28;
/// Greatest number of snow samples in a table. The computation of a sample takes at least a millisecond.
const MAX_SAMPLES: usize = 1 << 22;

impl Axes {
    /// Names and descriptions of the axes that [`preset`](Self::preset) knows.
    pub const PRESETS: [(&'static str, &'static str); 4] = [
        ("paper", "Table 1 of the paper: 24,750 curves"),
        ("default", "The embedded table: the paper's with more thicknesses and angles"),
        ("fine", "The default every 5 nm"),
        ("infrared", "300–2500 nm every 20 nm, one density, also diffuse light"),
    ];

    /// Axes by a name of [`PRESETS`](Self::PRESETS).
    #[must_use]
    pub fn preset(name: &str) -> Option<Self> {
        match name {
            "paper" => Some(Self::paper()),
            "default" => Some(Self::with_thin_and_thick_knots()),
            "fine" => Some(Self::fine()),
            "infrared" => Some(Self::infrared()),
            _ => None,
        }
    }

    /// Table 1 of the paper (Varsa & Baranoski 2024): 225 samples, 24,750 curves of 31 wavelengths.
    ///
    /// ```
    /// # use snowblue_database::Axes;
    /// assert_eq!(Axes::paper().curves(), 24_750);
    /// ```
    #[must_use]
    pub fn paper() -> Self {
        Self {
            grain_sizes_um: steps(100, 500, 50),
            facetness: vec![0.1, 0.3, 0.5, 0.7, 0.9],
            densities_kg_m3: steps(200, 400, 50),
            properties: Vec::new(),
            diffuse: false,
            angles_deg: [steps(0, 80, 10), vec![89.0]].concat(),
            thicknesses_cm: vec![1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0, 15.0, 25.0, 35.0, 50.0],
            wavelengths_nm: steps(400, 700, 10),
        }
    }

    /// The paper's axes with thin and thick knots, 75° and 85°, as in the embedded table.
    #[must_use]
    pub fn with_thin_and_thick_knots() -> Self {
        let paper = Self::paper();
        let thicknesses_cm = [&THIN_KNOTS_CM[..], &paper.thicknesses_cm, &THICK_KNOTS_CM].concat();
        Self { thicknesses_cm, angles_deg: ANGLES_DEG.to_vec(), ..paper }
    }

    /// The thicknesses, angles and wavelengths of the embedded table for one sample.
    #[must_use]
    pub fn of_sample(sample: &TableSample) -> Self {
        let axis = |value: &PropertyValue| PropertyAxis { property: value.property, values: vec![value.value] };
        Self {
            grain_sizes_um: vec![sample.grain_size_um],
            facetness: vec![sample.facetness],
            densities_kg_m3: vec![sample.density_kg_m3],
            properties: sample.properties.iter().map(axis).collect(),
            ..Self::with_thin_and_thick_knots()
        }
    }

    /// Table 1 at 5 nm.
    #[must_use]
    pub fn fine() -> Self {
        Self { wavelengths_nm: steps(400, 700, 5), ..Self::with_thin_and_thick_knots() }
    }

    /// Grains, thicknesses and angles of the embedded table at one density, from 300 to 2500 nm. One density is enough,
    /// since transport depends only on the product of density and thickness.
    #[must_use]
    pub fn infrared() -> Self {
        Self {
            densities_kg_m3: vec![300.0],
            diffuse: true,
            wavelengths_nm: steps(300, 2500, 20),
            ..Self::with_thin_and_thick_knots()
        }
    }

    /// Every axis with its name and unit in files, slowest first.
    #[must_use]
    pub fn named(&self) -> Vec<NamedAxis> {
        let axis = |name, unit, values: &[f64]| NamedAxis { name, unit, values: values.to_vec() };
        let of_snow = |property: Property, values: &[f64]| axis(property.name(), unit_in_files(property), values);
        let mut named = vec![
            of_snow(Property::GrainSize, &self.grain_sizes_um),
            of_snow(Property::Facetness, &self.facetness),
            of_snow(Property::Density, &self.densities_kg_m3),
        ];
        named.extend(self.properties.iter().map(|axis| of_snow(axis.property, &axis.values)));
        let diffuse = self.diffuse.then_some(DIFFUSE_ANGLE_DEG);
        let angles_deg: Vec<f64> = diffuse.into_iter().chain(self.angles_deg.iter().copied()).collect();
        named.extend([
            axis("angle", "degree", &angles_deg),
            axis("thickness", "cm", &self.thicknesses_cm),
            axis("wavelength", "nm", &self.wavelengths_nm),
        ]);
        named
    }

    /// Axes from their values by the names of [`Axes::named`], further properties in the given order.
    ///
    /// # Errors
    /// The name of a missing axis.
    pub(crate) fn from_named<'n>(values: impl IntoIterator<Item = (&'n str, Vec<f64>)>) -> Result<Self, &'static str> {
        let mut values: Vec<(&str, Vec<f64>)> = values.into_iter().collect();
        let mut required = |name: &'static str| -> Result<Vec<f64>, &'static str> {
            let index = values.iter().position(|(other, _)| *other == name).ok_or(name)?;
            Ok(values.remove(index).1)
        };
        let mut axes = Self {
            grain_sizes_um: required("grain_size")?,
            facetness: required("facetness")?,
            densities_kg_m3: required("density")?,
            properties: Vec::new(),
            diffuse: false,
            angles_deg: required("angle")?,
            thicknesses_cm: required("thickness")?,
            wavelengths_nm: required("wavelength")?,
        };
        axes.diffuse = axes.angles_deg.first().is_some_and(|angle_deg| is_diffuse(*angle_deg));
        if axes.diffuse {
            axes.angles_deg.remove(0);
        }
        let property = |name: &str| further_properties().find(|property| property.name() == name);
        let axis = |(name, values)| Some(PropertyAxis { property: property(name)?, values });
        axes.properties = values.into_iter().filter_map(axis).collect();
        Ok(axes)
    }

    /// The values of a curve on all axes but the wavelength, slowest first.
    #[must_use]
    pub(crate) fn coordinates(&self, curve: usize) -> Vec<Coordinate> {
        let mut named = self.named();
        named.pop();
        let mut rest = curve;
        let mut coordinates: Vec<Coordinate> = named
            .iter()
            .rev()
            .map(|NamedAxis { name, unit, values }| {
                let value = values[rest % values.len()];
                rest /= values.len();
                Coordinate { name, unit, value }
            })
            .collect();
        coordinates.reverse();
        coordinates
    }

    /// Number of curves.
    #[must_use]
    pub fn curves(&self) -> usize {
        self.samples() * self.curves_per_sample()
    }

    /// Number of snow samples: sizes × facetness × densities × values of every further property.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.grains() * self.samples_per_grain()
    }

    /// Number of kinds of grain: sizes × facetness. The facetness runs faster.
    #[must_use]
    pub fn grains(&self) -> usize {
        self.grain_sizes_um.len() * self.facetness.len()
    }

    /// Number of samples of one kind of grain, which are contiguous.
    #[must_use]
    pub fn samples_per_grain(&self) -> usize {
        let properties: usize = self.properties.iter().map(|axis| axis.values.len()).product();
        self.densities_kg_m3.len() * properties
    }

    /// Number of curves of one sample, which are contiguous: lights × thicknesses.
    #[must_use]
    pub fn curves_per_sample(&self) -> usize {
        self.incidences().len() * self.thicknesses_cm.len()
    }

    /// The lights: diffuse light if there is any, then the angles.
    #[must_use]
    pub fn incidences(&self) -> Vec<Incidence> {
        let beams = self.angles_deg.iter().map(|angle_deg| Incidence::Beam { angle_deg: *angle_deg });
        self.diffuse.then_some(Incidence::Diffuse).into_iter().chain(beams).collect()
    }

    /// Replaces the lights, in any order.
    pub fn set_incidences(&mut self, incidences: &[Incidence]) {
        self.diffuse = incidences.contains(&Incidence::Diffuse);
        let angle_deg = |incidence: &Incidence| match incidence {
            Incidence::Beam { angle_deg } => Some(*angle_deg),
            Incidence::Diffuse => None,
        };
        self.angles_deg = incidences.iter().filter_map(angle_deg).collect();
    }

    /// Adds or replaces the axis of a property.
    pub fn set_property(&mut self, axis: PropertyAxis) {
        match axis.property {
            Property::GrainSize => self.grain_sizes_um = axis.values,
            Property::Facetness => self.facetness = axis.values,
            Property::Density => self.densities_kg_m3 = axis.values,
            property => match self.properties.iter_mut().find(|other| other.property == property) {
                Some(other) => *other = axis,
                None => self.properties.push(axis),
            },
        }
    }

    /// Sample number `number` with the given ice constants, not checked.
    ///
    /// # Errors
    /// If there is no range of grain sizes around the mean.
    pub fn sample(&self, number: usize, ice: IceTable) -> Result<SnowSample, DatabaseError> {
        self.table_sample(number).snow(ice)
    }

    /// Sample number `number` as values on the axes.
    #[must_use]
    pub fn table_sample(&self, number: usize) -> TableSample {
        let mut rest = number;
        let mut next = |values: &[f64]| {
            let value = values[rest % values.len()];
            rest /= values.len();
            value
        };
        // From the fastest axis to the slowest.
        let value = |axis: &PropertyAxis| PropertyValue { property: axis.property, value: next(&axis.values) };
        let properties: Vec<PropertyValue> = self.properties.iter().rev().map(value).collect();
        let (density_kg_m3, facetness) = (next(&self.densities_kg_m3), next(&self.facetness));
        TableSample { grain_size_um: next(&self.grain_sizes_um), facetness, density_kg_m3, properties }
    }

    /// The sample, light and thickness of a curve, in words.
    #[must_use]
    pub fn describe(&self, curve: usize) -> String {
        let word = |Coordinate { name, unit, value }: Coordinate| match name {
            "grain_size" => format!("{value} µm"),
            "density" => format!("{value} kg/m³"),
            "thickness" => format!("{value} cm"),
            "angle" if is_diffuse(value) => "diffuse".to_owned(),
            "angle" => format!("{value}°"),
            _ if unit == "1" => format!("{} {value}", name.replace('_', " ")),
            _ => format!("{} {value} {unit}", name.replace('_', " ")),
        };
        let words: Vec<String> = self.coordinates(curve).into_iter().map(word).collect();
        words.join(", ")
    }

    /// Checks that every axis has finite values in ascending order, that there is a light and at least two
    /// thicknesses, all above 0 cm, that no property occurs twice, that a table on these axes is not too large, and
    /// that every sample, angle and wavelength is in the model's range.
    ///
    /// # Errors
    /// The first axis or quantity that fails a check.
    pub fn check(&self, ice: IceTable) -> Result<(), DatabaseError> {
        self.check_order()?;
        let mut slab = Slab {
            sample: self.sample(0, ice)?,
            thicknesses_cm: self.thicknesses_cm.clone(),
            incidences: self.incidences(),
            wavelengths_nm: self.wavelengths_nm.clone(),
        };
        slab.check()?;
        // Ranges are intervals, which may depend on the sample, so the ends of an ascending axis stand for all values.
        for values in [&mut slab.thicknesses_cm, &mut slab.wavelengths_nm] {
            let inner = 1..values.len() - 1;
            values.drain(inner.start..inner.end.max(inner.start));
        }
        slab.incidences.truncate(1);
        (1..self.samples()).try_for_each(|number| {
            slab.sample = self.sample(number, ice)?;
            Ok(slab.check()?)
        })
    }

    /// Checks that all axes ascend in single precision, in which look-ups run, that no value is beyond ±10¹⁵, and
    /// that the table is not too large. The model's range is not checked, so that tables of other models pass.
    ///
    /// # Errors
    /// [`DatabaseError::Axis`] or [`DatabaseError::AxisRange`] for the first axis that fails a check, or
    /// [`DatabaseError::TooManyValues`].
    pub fn check_order(&self) -> Result<(), DatabaseError> {
        #[expect(clippy::cast_possible_truncation, reason = "what single precision makes of values is checked")]
        let ascends = |pair: &[f64]| (pair[0] as f32) < (pair[1] as f32);
        for NamedAxis { name, values, .. } in self.named() {
            let why = match values.windows(2).find(|pair| !ascends(pair)) {
                Some(pair) if pair[0] < pair[1] => {
                    format!("{} is too close to {}", short(pair[1]), short(pair[0]))
                }
                Some(pair) => format!("{} follows {}", short(pair[1]), short(pair[0])),
                None if values.is_empty() => "it is empty".to_owned(),
                None if !values.iter().all(|value| value.abs() <= MAX_VALUE) => {
                    format!("it has a value beyond ±{MAX_VALUE:e}")
                }
                None => continue,
            };
            return Err(DatabaseError::Axis { name, why });
        }
        let wrong = |name, what| Err(DatabaseError::AxisRange { name, what });
        for (number, axis) in self.properties.iter().enumerate() {
            if self.properties[..number].iter().any(|other| other.property == axis.property) {
                return wrong(axis.property.name(), "one list of values");
            }
        }
        // A thickness of 0 is not a knot: its transmittance is 1.
        if self.thicknesses_cm.len() < 2 || !ascends(&[0.0, self.thicknesses_cm[0]]) {
            return wrong("thickness", "two values or more, all above 0 cm");
        }
        let beams = |within: &dyn Fn(f64) -> bool| self.angles_deg.iter().all(|angle_deg| within(*angle_deg));
        if !beams(&|angle_deg| (0.0..=MAX_ANGLE_DEG).contains(&angle_deg)) {
            return wrong("angle", "values in 0–89.99°");
        }
        self.check_size()
    }

    /// Checks that the numbers of samples and values of a table on these axes are within the limits.
    fn check_size(&self) -> Result<(), DatabaseError> {
        let lengths: Vec<usize> = self.named().iter().map(|axis| axis.values.len()).collect();
        // The last three axes do not describe the snow. The products may overflow any integer type.
        let product = |lengths: &[usize]| lengths.iter().map(|length| *length as f64).product::<f64>();
        let (samples, values) = (product(&lengths[..lengths.len() - 3]), product(&lengths));
        if samples <= MAX_SAMPLES as f64 && values <= MAX_VALUES as f64 {
            return Ok(());
        }
        let lengths: Vec<String> = lengths.iter().map(usize::to_string).collect();
        Err(DatabaseError::TooManyValues {
            lengths: lengths.join(" × "),
            samples: short(samples),
            values: short(values),
            most_samples: MAX_SAMPLES,
            most_values: MAX_VALUES,
        })
    }
}

/// Whether a table can have an axis of this name.
pub(crate) fn is_axis(name: &str) -> bool {
    let always = ["grain_size", "facetness", "density", "angle", "thickness", "wavelength"];
    always.contains(&name) || further_properties().any(|property| property.name() == name)
}

/// Whether an angle in a file means diffuse light.
pub(crate) fn is_diffuse(angle_deg: f64) -> bool {
    angle_deg.to_bits() == DIFFUSE_ANGLE_DEG.to_bits()
}

/// Formats a number, with an exponent where it would be long.
fn short(value: f64) -> String {
    if value == 0.0 || (1e-4..1e7).contains(&value.abs()) { value.to_string() } else { format!("{value:e}") }
}

fn steps(first: u32, last: u32, step: usize) -> Vec<f64> {
    (first..=last).step_by(step).map(f64::from).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowblue_transport::optics::Substance;

    fn wet_and_sooty() -> Axes {
        Axes {
            properties: vec![
                PropertyAxis { property: Property::WaterSaturation, values: vec![0.0, 0.1] },
                PropertyAxis { property: Property::Impurity(Substance::BLACK_CARBON), values: vec![0.0, 10.0, 100.0] },
            ],
            diffuse: true,
            ..Axes::paper()
        }
    }

    #[test]
    fn axes_ascend_in_single_precision() {
        let message = |thicknesses_cm: &[f64]| {
            let axes = Axes { thicknesses_cm: thicknesses_cm.to_vec(), ..Axes::paper() };
            axes.check_order().map_err(|error| error.to_string())
        };
        assert_eq!(message(&[1e-3, 2.0, 1e15]), Ok(()));
        for (thicknesses_cm, expected) in [
            (&[1.0, 2.0, 2.0][..], "2 follows 2"),
            (&[1.0, 2.0, 2.0 + 1e-9], "is too close to 2"),
            (&[1.0, f64::NAN], "follows 1"),
            (&[1.0, 1e300], "beyond ±1e15"),
            (&[1.0, f64::INFINITY], "beyond ±1e15"),
            (&[1e-300, 1.0], "above 0 cm"),
        ] {
            let error = message(thicknesses_cm).unwrap_err();
            assert!(error.contains(expected), "{thicknesses_cm:?}: {error}");
        }
    }

    #[test]
    fn sample_numbers_and_curve_descriptions_agree() {
        let axes = wet_and_sooty();
        assert_eq!((axes.samples(), axes.curves_per_sample()), (225 * 6, 11 * 11));
        // The last sample and the previous sample.
        let last = axes.sample(axes.samples() - 1, IceTable::default()).unwrap();
        assert_eq!(
            (last.grain_size.max_um.to_bits(), last.density_kg_m3.to_bits()),
            (550_f64.to_bits(), 400_f64.to_bits())
        );
        assert_eq!(last.impurities.to_string(), "black-carbon=100");
        let before = axes.sample(axes.samples() - 4, IceTable::default()).unwrap();
        assert_eq!(
            (before.water_saturation.to_bits(), before.impurities.to_string()),
            (0_f64.to_bits(), "black-carbon=100".to_owned())
        );
        assert_eq!(
            axes.describe(axes.curves() - 1),
            "500 µm, facetness 0.9, 400 kg/m³, water saturation 0.1, black carbon 100 ng g-1, 89°, 50 cm"
        );
        assert!(axes.describe(0).ends_with("black carbon 0 ng g-1, diffuse, 1 cm"));
    }

    #[test]
    fn axes_beyond_the_range_of_the_model_are_refused() {
        wet_and_sooty().check(IceTable::default()).unwrap();
        let temperature = |values| PropertyAxis { property: Property::Temperature, values };
        let message = |axes: Axes| axes.check(IceTable::default()).unwrap_err().to_string();
        let infrared = Axes { wavelengths_nm: vec![500.0, 2600.0], ..wet_and_sooty() };
        assert!(message(infrared).contains("wavelength is 2600 nm"));
        let twice = Axes { properties: vec![temperature(vec![-5.0]), temperature(vec![-5.0])], ..Axes::paper() };
        assert_eq!(message(twice), "the axis temperature must have one list of values");
        let warm = Axes { properties: vec![temperature(vec![-5.0, 5.0])], ..Axes::paper() };
        assert!(message(warm).contains("temperature is 5 °C"));
        Axes::infrared().check(IceTable::default()).unwrap();
    }

    #[test]
    fn a_table_that_nobody_could_compute_is_refused() {
        let long = |low: f64| (0..2000).map(|step| low + 0.01 * f64::from(step)).collect::<Vec<_>>();
        let axes = Axes { grain_sizes_um: long(100.0), densities_kg_m3: long(100.0), ..Axes::paper() };
        let message = axes.check(IceTable::default()).unwrap_err().to_string();
        let expected = "the axes have 2000 × 5 × 2000 × 10 × 11 × 31 values: 2e7 samples and 6.82e10 values of a \
                        quantity, but must have at most 4194304 and 268435456";
        assert_eq!(message, expected);
    }
}
