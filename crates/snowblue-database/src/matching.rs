//! Finds snow whose transmitted light has a target colour, except for its luminance.
//!
//! The chromaticities of light through snow lie close to one curve, from the chromaticity of the bare light to deep
//! blue. Thicker snow, denser snow and finer grains all move the chromaticity along this curve in the same direction,
//! since deep in snow ln T is proportional to h √(σ_a κ (1 − g)). One *free parameter* is therefore enough to match a
//! colour. Several samples match a colour; they differ in transmitted luminance. Free parameters are fitted in order.
//! A parameter is fitted only if the fit of the previous parameter ends at a limit of its range.
//!
//! The fit minimises ΔE*ab with both colours scaled to L* = 50, since at the luminance of a dark target all hues look
//! alike. It scans the range, then repeatedly the interval around the best value. All light is solved by discrete
//! ordinates, with one grain tally for all samples.

use std::fmt;

use rayon::prelude::*;
use snowblue_color::lab::MIDDLE_GREY;
use snowblue_color::{ColorDifference, Colorimeter, Lab, Xyz};
use snowblue_transport::ordinates::{OrdinatesOptions, Peak};
use snowblue_transport::sample::{Property, SnowSample};
use snowblue_transport::slab::{Incidence, Slab};
use snowblue_transport::{Demand, GrainTallies, Population, TallyPlan};

use crate::DatabaseError;
use crate::fidelity::PERCEPTIBLE_DELTA_E;

/// A closed interval of a quantity, in the quantity's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// Range of mean grain sizes, in µm: very fine to coarse snow (Fierz et al. 2009: below 0.2 mm and 1–2 mm).
pub const GRAIN_SIZES_UM: Interval = Interval { low: 100.0, high: 2000.0 };
/// Range of densities of a snowpack, in kg/m³ (Varsa & Baranoski 2024, "Background").
pub const DENSITIES_KG_M3: Interval = Interval { low: 100.0, high: 450.0 };
/// Range of thicknesses, in cm: the paper's.
pub const THICKNESSES_CM: Interval = Interval { low: 0.0, high: 100.0 };

/// Alternatives that match the target colour: mean grain sizes in µm or, where the grain size is given, densities in
/// kg/m³.
const OTHER_SIZES_UM: [f64; 4] = [100.0, 200.0, 500.0, 1000.0];
const OTHER_DENSITIES_KG_M3: [f64; 3] = [100.0, 200.0, 400.0];

/// Steps of the first scan of a range, and of each finer scan.
const COARSE_STEPS: u32 = 64;
const FINE_STEPS: u32 = 16;
/// Width of the last scanned interval, relative to the upper end of the range.
const TOLERANCE: f64 = 1e-7;
/// Smallest improvement in ΔE for which a parameter changes.
const MIN_IMPROVEMENT: f64 = 1e-4;
/// Smallest luminance of a colour, relative to the bare light: 10⁻¹² of full sun (10⁵ lx) is a ten-thousandth of
/// starlight (10⁻³ lx).
const MIN_LUMINANCE: f64 = 1e-12;

/// A free parameter and its range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeParameter {
    /// The property of the snow; none for the thickness.
    pub property: Option<Property>,
    /// The range, in the unit of the parameter.
    pub range: Interval,
}

/// The target colour, with the observer and the light.
#[derive(Debug, Clone, Copy)]
pub struct Target<'c> {
    /// The colour. Its luminance is not matched.
    pub color: Xyz,
    /// The white of CIELAB.
    pub white: Xyz,
    /// Converts transmittance to colour.
    pub colorimeter: &'c Colorimeter,
}

/// The sample to start from, and the parameters to fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// The sample. Parameters that are not free keep their values.
    pub sample: SnowSample,
    /// Thickness in cm, unless it is free.
    pub thickness_cm: f64,
    /// The light.
    pub incidence: Incidence,
    /// The free parameters, in the order of fitting.
    pub free: Vec<FreeParameter>,
}

/// The closest snow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Match {
    /// The sample.
    pub sample: SnowSample,
    /// Its thickness in cm.
    pub thickness_cm: f64,
    /// The transmitted light, where the bare light has Y = 1.
    pub light: Xyz,
    /// The difference of this light from the target.
    pub difference: ColorDifference,
}

/// The parameters that are given and not searched for.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Given {
    /// The thickness, or the range to search, in cm.
    pub thickness_cm: Option<Interval>,
    /// Whether the grain size is given.
    pub grain_size: bool,
    /// Whether the density is given.
    pub density: bool,
}

impl Problem {
    /// Searches first for the thickness, then for the grain size, then for the density, unless they are given.
    #[must_use]
    pub fn new(sample: SnowSample, incidence: Incidence, given: Given) -> Self {
        let range = given.thickness_cm.unwrap_or(THICKNESSES_CM);
        let free = [
            (range.low < range.high, None, range),
            (!given.grain_size, Some(Property::GrainSize), GRAIN_SIZES_UM),
            (!given.density, Some(Property::Density), DENSITIES_KG_M3),
        ];
        let free = free.into_iter().filter(|(is_free, ..)| *is_free);
        let free = free.map(|(_, property, range)| FreeParameter { property, range }).collect();
        Self { sample, thickness_cm: range.high, incidence, free }
    }
}

impl Match {
    /// Whether the difference is imperceptible with both colours at L* = 50.
    #[must_use]
    pub fn within_reach(&self) -> bool {
        self.difference.at_middle_grey <= PERCEPTIBLE_DELTA_E
    }

    /// How the target differs from the transmitted light, both at L* = 50.
    #[must_use]
    pub fn deviation(&self, target: &Target) -> Deviation {
        let lab = |color: Xyz| Lab::from_xyz(color.with_luminance(MIDDLE_GREY), target.white);
        let (wanted, found) = (lab(target.color), lab(self.light));
        Deviation {
            word: direction(wanted, found),
            distance: self.difference.at_middle_grey,
            delta_a: wanted.a - found.a,
            delta_b: wanted.b - found.b,
        }
    }
}

/// The difference of a target from the closest light, both at L* = 50.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// Comparison of the target with the closest light, such as "redder".
    pub word: &'static str,
    /// ΔE*ab.
    pub distance: f64,
    /// Δa*.
    pub delta_a: f64,
    /// Δb*.
    pub delta_b: f64,
}

/// Formats as "redder than the closest light, at a distance of …".
impl fmt::Display for Deviation {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { word, distance, delta_a, delta_b } = self;
        write!(
            out,
            "{word} than the closest light, at a distance of ΔE*ab {distance:.1} at L* = 50 (a* {delta_a:+.1}, \
             b* {delta_b:+.1})"
        )
    }
}

/// CIELAB hue angles of daylight through snow, with a margin, in degrees: cyan to blue.
const BLUES_DEG: Interval = Interval { low: 190.0, high: 305.0 };
/// Hue angles in degrees at which a name begins, and the names.
const HUES_DEG: [(f64, &str); 5] =
    [(0.0, "redder"), (60.0, "yellower"), (105.0, "greener"), (BLUES_DEG.high, "more purple"), (350.0, "redder")];

/// Comparison of the target with the light found: the name of the target's hue, unless that hue is blue.
fn direction(wanted: Lab, found: Lab) -> &'static str {
    let more_chroma = wanted.chroma() - found.chroma();
    let apart = (wanted.a - found.a).hypot(wanted.b - found.b);
    let mostly_chroma = more_chroma.abs() >= std::f64::consts::FRAC_1_SQRT_2 * apart;
    let hue_deg = wanted.hue_deg();
    if mostly_chroma && more_chroma < 0.0 {
        return "paler";
    }
    if (BLUES_DEG.low..BLUES_DEG.high).contains(&hue_deg) {
        let turned = found.a * wanted.b - found.b * wanted.a;
        return match (mostly_chroma, turned > 0.0) {
            (true, _) => "more saturated",
            (false, true) => "more purple",
            (false, false) => "greener",
        };
    }
    let named = HUES_DEG.iter().rev().find(|(from_deg, _)| hue_deg >= *from_deg);
    named.map_or(HUES_DEG[0].1, |(_, name)| name)
}

/// Finds the closest snow, then alternatives with other grain sizes or else densities.
///
/// Omits alternatives that transmit no light or that transmit light equal to an earlier match.
///
/// # Errors
/// [`DatabaseError::DarkTarget`] if the target has no luminance, [`DatabaseError::NoLight`] if the first match
/// transmits no light, [`DatabaseError::Transport`] if a parameter is out of the model's range.
pub fn closest(target: &Target, problem: &Problem, options: &OrdinatesOptions) -> Result<Vec<Match>, DatabaseError> {
    if target.color.y <= 0.0 {
        return Err(DatabaseError::DarkTarget);
    }
    let alternatives = alternatives(problem);
    for problem in std::iter::once(problem).chain(&alternatives) {
        problem.check(target.colorimeter.wavelengths_nm())?;
    }
    options.streams.check()?;
    let search = Search::new(target, problem, options);
    let mut found = vec![search.closest(problem)?];
    for other in &alternatives {
        match search.closest(other) {
            Ok(new) if found.iter().all(|earlier| earlier.light != new.light) => found.push(new),
            Ok(_) | Err(DatabaseError::NoLight { .. }) => {}
            Err(error) => return Err(error),
        }
    }
    Ok(found)
}

/// The problem with other values of its second free parameter, if there is a second free parameter.
fn alternatives(problem: &Problem) -> Vec<Problem> {
    let Some(second) = problem.free.get(1) else { return Vec::new() };
    let values: &[f64] = match second.property {
        Some(Property::GrainSize) => &OTHER_SIZES_UM,
        Some(Property::Density) => &OTHER_DENSITIES_KG_M3,
        _ => &[],
    };
    let with = |value: &f64| {
        let mut other = problem.clone();
        other.set(second.property, *value);
        other.free.remove(1);
        other
    };
    values.iter().map(with).collect()
}

impl Problem {
    /// Sets a property, or the thickness.
    fn set(&mut self, property: Option<Property>, value: f64) {
        match property {
            None => self.thickness_cm = value,
            Some(property) => property.set(&mut self.sample, value),
        }
    }

    /// Checks the sample and both ends of every range.
    fn check(&self, wavelengths_nm: &[f64]) -> Result<(), DatabaseError> {
        let slab = |problem: &Self| Slab {
            sample: problem.sample,
            thicknesses_cm: vec![problem.thickness_cm],
            incidences: vec![problem.incidence],
            wavelengths_nm: wavelengths_nm.to_vec(),
        };
        slab(self).check()?;
        for free in &self.free {
            for end in [free.range.low, free.range.high] {
                let mut at_end = self.clone();
                at_end.set(free.property, end);
                slab(&at_end).check()?;
            }
        }
        Ok(())
    }
}

/// A search with one grain tally for every sample.
struct Search<'t> {
    target: &'t Target<'t>,
    incidence: Incidence,
    tallies: GrainTallies,
    options: OrdinatesOptions,
}

/// The best value of a free parameter.
struct BestValue {
    value: f64,
    found: Match,
}

impl<'t> Search<'t> {
    fn new(target: &'t Target<'t>, problem: &Problem, options: &OrdinatesOptions) -> Self {
        let demand = Demand::of_sample(&problem.sample, target.colorimeter.wavelengths_nm());
        // The range of sizes extends beyond their mean.
        let demand = Demand { largest_um: demand.largest_um.max(1.5 * GRAIN_SIZES_UM.high), ..demand };
        let plan = TallyPlan {
            degree: options.streams.most(&[problem.incidence], Peak::of(&problem.sample)),
            rays: options.tally_rays,
            seed: options.seed,
        };
        let tallies = GrainTallies::new(&Population::of_sample(&problem.sample), &demand, &plan);
        Self { target, incidence: problem.incidence, tallies, options: *options }
    }

    /// Fits the free parameters in order until the fit of a parameter ends inside its range.
    fn closest(&self, problem: &Problem) -> Result<Match, DatabaseError> {
        let mut problem = problem.clone();
        let mut best = self.evaluate_thicknesses(&problem, &[problem.thickness_cm])[0];
        for free in problem.free.clone() {
            let BestValue { value, found } = self.scan(&problem, free);
            if found.difference.at_middle_grey < best.difference.at_middle_grey - MIN_IMPROVEMENT {
                problem.set(free.property, value);
                best = found;
            }
            if free.range.low < value && value < free.range.high {
                break;
            }
        }
        if best.light.y >= MIN_LUMINANCE {
            Ok(best)
        } else {
            Err(DatabaseError::NoLight { thickness_cm: best.thickness_cm })
        }
    }

    /// Finds the best value of a free parameter with all further parameters fixed.
    fn scan(&self, problem: &Problem, free: FreeParameter) -> BestValue {
        let mut values = coarse_values(free.range);
        loop {
            let found = self.evaluate(problem, free.property, &values);
            let delta = |number: &usize| found[*number].difference.at_middle_grey;
            let best = (0..values.len()).min_by(|a, b| delta(a).total_cmp(&delta(b))).unwrap_or_default();
            let (below, above) = (values[best.saturating_sub(1)], values[(best + 1).min(values.len() - 1)]);
            if above - below <= TOLERANCE * free.range.high {
                return BestValue { value: values[best], found: found[best] };
            }
            values = (0..=FINE_STEPS).map(|i| below + (above - below) * f64::from(i) / f64::from(FINE_STEPS)).collect();
            // Rounding must not move the end of the range into its interior.
            values[FINE_STEPS as usize] = above;
        }
    }

    fn evaluate(&self, problem: &Problem, property: Option<Property>, values: &[f64]) -> Vec<Match> {
        if property.is_none() {
            return self.evaluate_thicknesses(problem, values);
        }
        let with = |value: &f64| {
            let mut other = problem.clone();
            other.set(property, *value);
            self.evaluate_thicknesses(&other, &[other.thickness_cm])
        };
        values.iter().flat_map(with).collect()
    }

    /// The light through several thicknesses of a sample.
    fn evaluate_thicknesses(&self, problem: &Problem, thicknesses_cm: &[f64]) -> Vec<Match> {
        let sample = problem.sample;
        let (streams, peak) = (self.options.streams, Peak::of(&sample));
        let at = |wavelength_nm: &f64| -> Vec<f64> {
            let medium = self.tallies.medium(&sample, *wavelength_nm);
            let fluxes = medium.fluxes(thicknesses_cm, &[self.incidence], streams, peak);
            fluxes.into_iter().map(|fluxes| fluxes.transmittance).collect()
        };
        let by_wavelength: Vec<Vec<f64>> = self.target.colorimeter.wavelengths_nm().par_iter().map(at).collect();
        let matched = |(number, thickness_cm): (usize, &f64)| {
            let spectrum: Vec<f64> = by_wavelength.iter().map(|values| values[number]).collect();
            let light = self.target.colorimeter.xyz(&spectrum);
            let difference = if light.y >= MIN_LUMINANCE {
                ColorDifference::between(light, self.target.color, self.target.white)
            } else {
                ColorDifference::INFINITE
            };
            Match { sample, thickness_cm: *thickness_cm, light, difference }
        };
        thicknesses_cm.iter().enumerate().map(matched).collect()
    }
}

/// Values over a range: its low end, and equal steps of the logarithm from a thousandth of its high end.
fn coarse_values(range: Interval) -> Vec<f64> {
    let Interval { low, high } = range;
    if low >= high {
        return vec![low];
    }
    let first = low.max(1e-3 * high);
    let step = |i: u32| first * (high / first).powf(f64::from(i) / f64::from(COARSE_STEPS));
    let mut values: Vec<f64> = (0..COARSE_STEPS).map(step).collect();
    values.push(high);
    if low < first {
        values.insert(0, low);
    } else {
        values[0] = low;
    }
    values
}
