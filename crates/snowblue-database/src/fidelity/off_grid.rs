//! Accuracy of look-ups between a table's values: random points, looked up and solved directly.
//!
//! The direct solutions use the rays and the seed by which the table was filled, so the noise of the grain tally
//! cancels and the differences are the errors of compression and interpolation alone. Only between two values of
//! facetness, where the grains differ, do the errors include that noise.

use std::collections::BTreeMap;

use rayon::prelude::*;
use snowblue_color::{Colorimeter, Illuminant, Lab, Observer};
use snowblue_transport::optics::IceTable;
use snowblue_transport::ordinates::{HomogeneousMedium, Peak, Streams};
use snowblue_transport::rng::Stream;
use snowblue_transport::slab::Incidence;
use snowblue_transport::{Demand, GrainTallies, Population, TallyPlan};

use super::spread::{Spread, spread};
use crate::fill::{Engine, FillOptions};
use crate::pca::single;
use crate::{
    Axes, CompressedTable, DatabaseError, Interval, PcaSnow, PropertyAxis, PropertyValue, Quantity, Space, TableSample,
};

/// Value above which [`OffGridErrors::bright`] counts relative errors; less light is invisible.
pub const BRIGHT_VALUE: f64 = 1e-6;
/// Random thicknesses, uniform in their logarithm, in cm.
const THICKNESSES_CM: Interval = Interval { low: 0.01, high: 100.0 };
/// Angle that separates the steep from the grazing range, in degrees.
const GRAZING_DEG: f64 = 80.0;
/// Largest angle of the paper's table, in degrees.
const PAPER_LAST_DEG: f64 = 89.0;
/// Values of facetness between those of the table, each of which needs a tally.
const FACETNESS_VALUES: usize = 3;

/// What to evaluate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OffGridOptions {
    /// Points for each kind of sample and each range of angles.
    pub points: usize,
    /// Seed of the points.
    pub seed: u64,
    /// Illuminant of the colours.
    pub illuminant: Illuminant,
}

/// Errors of look-ups at random thicknesses and angles.
#[derive(Debug, Clone, PartialEq)]
pub struct OffGridErrors {
    /// Transmittance or reflectance.
    pub quantity: Quantity,
    /// Whether the samples, too, lie between the table's values.
    pub between_samples: bool,
    /// The range of angles, in degrees.
    pub angles_deg: Interval,
    /// Relative error at each point and wavelength whose value exceeds [`BRIGHT_VALUE`].
    pub bright: Spread,
    /// Relative error at each point and wavelength.
    pub relative: Spread,
    /// Colour difference at each point, with the illuminant as white.
    pub delta_e: Spread,
    /// The points of the largest errors.
    pub worst: WorstPoints,
}

/// The points of the largest errors, in words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WorstPoints {
    /// Of [`OffGridErrors::bright`].
    pub bright: String,
    /// Of [`OffGridErrors::relative`].
    pub relative: String,
    /// Of [`OffGridErrors::delta_e`].
    pub delta_e: String,
}

struct Point {
    sample: TableSample,
    thickness_cm: f32,
    angle_deg: f32,
}

/// Spectra of one quantity, looked up in the table and solved by the engine.
struct Spectra {
    found: Vec<f32>,
    solved: Vec<f64>,
}

/// Spectra at a point.
struct Answer {
    transmittance: Spectra,
    reflectance: Spectra,
}

/// The relative error at a wavelength of a point.
#[derive(Clone, Copy)]
struct RelativeError {
    point: usize,
    wavelength: usize,
    error: f64,
    solved: f64,
}

/// The engine that filled the table.
struct Solver<'t> {
    axes: &'t Axes,
    plan: TallyPlan,
    streams: Streams,
    ice: IceTable,
}

/// Compares look-ups with direct solutions, for the table's own samples and, in log space, for samples between them.
///
/// # Errors
/// If the table was not filled by discrete ordinates, or if its wavelengths do not determine colours.
pub fn evaluate_off_grid(
    table: &CompressedTable,
    options: &OffGridOptions,
) -> Result<Vec<OffGridErrors>, DatabaseError> {
    let fill_options = FillOptions::from_metadata(&table.metadata)?;
    let Engine::Ordinates { streams, tally_rays } = fill_options.engine else {
        return Err(DatabaseError::Metadata { name: "engine" });
    };
    let ice = fill_options.ice;
    let mut peak = Peak::default();
    for number in 0..table.axes.samples() {
        peak = peak.max(Peak::of(&table.axes.sample(number, ice)?));
    }
    // The tally has as many moments as the most grazing point needs, the table's own included.
    let grazing = Incidence::Beam { angle_deg: PAPER_LAST_DEG };
    let degree = streams.most(&[&table.axes.incidences()[..], &[grazing]].concat(), peak);
    let plan = TallyPlan { degree, rays: tally_rays, seed: fill_options.seed };
    let solver = Solver { axes: &table.axes, plan, streams, ice };
    let colorimeter = Colorimeter::new(Observer::Cie1931, options.illuminant, &table.axes.wavelengths_nm)?;
    let mut rows = Vec::new();
    for between_samples in [false, true] {
        // The paper's scheme has only the samples of the grid.
        if between_samples && table.space == Space::Linear {
            continue;
        }
        let points = random_points(&table.axes, options, between_samples);
        let answers = answers(table, &solver, &points)?;
        let in_ranges = points.chunks_exact(options.points).zip(answers.chunks_exact(options.points));
        for ((points, answers), angles_deg) in in_ranges.zip(angle_ranges(&table.axes)) {
            let comparison = Comparison { axes: &table.axes, colorimeter: &colorimeter, points, answers };
            for quantity in Quantity::ALL {
                rows.push(comparison.errors(quantity, between_samples, angles_deg));
            }
        }
    }
    Ok(rows)
}

/// Random points of the steep angles, then as many of the grazing ones.
fn random_points(axes: &Axes, options: &OffGridOptions, between_samples: bool) -> Vec<Point> {
    let mut random = Stream::new(options.seed, u64::from(between_samples));
    let facetness: Vec<f64> = (0..FACETNESS_VALUES).map(|_| interpolate(&axes.facetness, random.uniform())).collect();
    let ranges = angle_ranges(axes);
    let mut all = Vec::with_capacity(ranges.len() * options.points);
    let (first_cm, last_cm) = (axes.thicknesses_cm[0], axes.thicknesses_cm[axes.thicknesses_cm.len() - 1]);
    let (thin_cm, thick_cm) = (THICKNESSES_CM.low.max(first_cm), THICKNESSES_CM.high.min(last_cm));
    for angles_deg in ranges {
        for number in 0..options.points {
            let sample = if between_samples {
                random_sample(axes, facetness[number % FACETNESS_VALUES], &mut random)
            } else {
                axes.table_sample(index(axes.samples(), random.uniform()))
            };
            all.push(Point {
                sample,
                thickness_cm: single(thin_cm * (thick_cm / thin_cm).powf(random.uniform())),
                angle_deg: single(angles_deg.low + (angles_deg.high - angles_deg.low) * random.uniform()),
            });
        }
    }
    all
}

/// The steep and the grazing range of a table's angles.
fn angle_ranges(axes: &Axes) -> Vec<Interval> {
    let (Some(first_deg), Some(last_deg)) = (axes.angles_deg.first(), axes.angles_deg.last()) else { return vec![] };
    let ranges = [
        Interval { low: *first_deg, high: last_deg.min(GRAZING_DEG) },
        Interval { low: first_deg.max(GRAZING_DEG), high: *last_deg },
    ];
    ranges.into_iter().filter(|range| range.low <= range.high).collect()
}

/// A random sample between a table's values.
fn random_sample(axes: &Axes, facetness: f64, random: &mut Stream) -> TableSample {
    let grain_size_um = interpolate(&axes.grain_sizes_um, random.uniform());
    let density_kg_m3 = interpolate(&axes.densities_kg_m3, random.uniform());
    let value = |PropertyAxis { property, values }: &PropertyAxis| PropertyValue {
        property: *property,
        value: interpolate(values, random.uniform()),
    };
    TableSample { grain_size_um, facetness, density_kg_m3, properties: axes.properties.iter().map(value).collect() }
}

/// The value at a fraction of an axis on which all intervals have the same length.
fn interpolate(values: &[f64], fraction: f64) -> f64 {
    let intervals = values.len() - 1;
    if intervals == 0 {
        return values[0];
    }
    let below = index(intervals, fraction);
    values[below] + (fraction * intervals as f64 - below as f64) * (values[below + 1] - values[below])
}

/// The index at a fraction of `count` elements.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a fraction is not negative")]
fn index(count: usize, fraction: f64) -> usize {
    ((fraction * count as f64) as usize).min(count - 1)
}

/// Looks up and solves all points, with one tally for each facetness.
fn answers(table: &CompressedTable, solver: &Solver, points: &[Point]) -> Result<Vec<Answer>, DatabaseError> {
    let mut by_facetness: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
    for (number, point) in points.iter().enumerate() {
        by_facetness.entry(point.sample.facetness.to_bits()).or_default().push(number);
    }
    let mut answers: Vec<Option<Answer>> = points.iter().map(|_| None).collect();
    for numbers in by_facetness.values() {
        let tallies = solver.tallies(&points[numbers[0]].sample)?;
        let answer = |number: &usize| {
            let point = &points[*number];
            let snow = PcaSnow::new(table, &point.sample)?;
            let mut answer = solver.solve(&tallies, point)?;
            snow.transmittance(point.thickness_cm, point.angle_deg, &mut answer.transmittance.found);
            snow.reflectance(point.thickness_cm, point.angle_deg, &mut answer.reflectance.found);
            Ok((*number, answer))
        };
        let solved: Result<Vec<(usize, Answer)>, DatabaseError> = numbers.par_iter().map(answer).collect();
        for (number, answer) in solved? {
            answers[number] = Some(answer);
        }
    }
    Ok(answers.into_iter().flatten().collect())
}

impl Solver<'_> {
    /// The tallies with which the table was filled, for the facetness of a sample.
    fn tallies(&self, sample: &TableSample) -> Result<GrainTallies, DatabaseError> {
        let wavelengths_nm = &self.axes.wavelengths_nm;
        let mut demand = Demand::of_sample(&sample.snow(self.ice)?, wavelengths_nm);
        for number in 0..self.axes.samples() {
            demand = demand.and(&Demand::of_sample(&self.axes.sample(number, self.ice)?, wavelengths_nm));
        }
        Ok(GrainTallies::new(&Population::of_sample(&sample.snow(self.ice)?), &demand, &self.plan))
    }

    /// Solves a point at every wavelength. The look-up is left at 0.
    fn solve(&self, tallies: &GrainTallies, point: &Point) -> Result<Answer, DatabaseError> {
        let sample = point.sample.snow(self.ice)?;
        let incidence = Incidence::Beam { angle_deg: f64::from(point.angle_deg) };
        let streams = self.streams.under(&incidence, Peak::of(&sample));
        let solved = |wavelength_nm: &f64| {
            let medium = tallies.medium(&sample, *wavelength_nm, None);
            let modes = HomogeneousMedium::new(&medium.scattering, streams);
            let optical_depth = medium.extinction_per_m * f64::from(point.thickness_cm) * 0.01;
            let fluxes = modes.fluxes(optical_depth, &[modes.light(&incidence)]);
            (fluxes[0].transmittance, fluxes[0].reflectance)
        };
        let (transmittance, reflectance) = self.axes.wavelengths_nm.iter().map(solved).unzip();
        let spectra = |solved: Vec<f64>| Spectra { found: vec![0.0; solved.len()], solved };
        Ok(Answer { transmittance: spectra(transmittance), reflectance: spectra(reflectance) })
    }
}

impl Answer {
    fn of(&self, quantity: Quantity) -> &Spectra {
        match quantity {
            Quantity::Transmittance => &self.transmittance,
            Quantity::Reflectance => &self.reflectance,
        }
    }
}

/// Answers at some points.
struct Comparison<'c> {
    axes: &'c Axes,
    colorimeter: &'c Colorimeter,
    points: &'c [Point],
    answers: &'c [Answer],
}

impl Comparison<'_> {
    /// The errors of one quantity.
    fn errors(&self, quantity: Quantity, between_samples: bool, angles_deg: Interval) -> OffGridErrors {
        let all = self.relative_errors(quantity);
        let bright: Vec<RelativeError> =
            all.iter().filter(|relative_error| relative_error.solved > BRIGHT_VALUE).copied().collect();
        let spread_of =
            |errors: &[RelativeError]| spread(errors.iter().map(|relative_error| relative_error.error.abs()));
        let (relative_spread, bright_spread) = (spread_of(&all), spread_of(&bright));
        let lab = |values: &[f64]| Lab::from_xyz(self.colorimeter.xyz(values), self.colorimeter.white());
        let delta_e = spread(self.answers.iter().map(|answer| {
            let spectra = answer.of(quantity);
            let found: Vec<f64> = spectra.found.iter().map(|value| f64::from(*value)).collect();
            lab(&found).delta_e_1976(lab(&spectra.solved))
        }));
        let worst = WorstPoints {
            bright: self.describe(bright.get(bright_spread.worst_curve).unwrap_or(&all[0])),
            relative: self.describe(&all[relative_spread.worst_curve]),
            delta_e: self.points[delta_e.worst_curve].describe(),
        };
        OffGridErrors {
            quantity,
            between_samples,
            angles_deg,
            bright: bright_spread,
            relative: relative_spread,
            delta_e,
            worst,
        }
    }

    fn relative_errors(&self, quantity: Quantity) -> Vec<RelativeError> {
        let at_point = |(point, answer): (usize, &Answer)| {
            let spectra = answer.of(quantity);
            let pairs = spectra.found.iter().zip(&spectra.solved).enumerate();
            let error = |(wavelength, (found, solved)): (usize, (&f32, &f64))| RelativeError {
                point,
                wavelength,
                error: f64::from(*found) / solved - 1.0,
                solved: *solved,
            };
            pairs.map(error).collect::<Vec<_>>()
        };
        self.answers.iter().enumerate().flat_map(at_point).collect()
    }

    fn describe(&self, error: &RelativeError) -> String {
        format!("{}, {} nm", self.points[error.point].describe(), self.axes.wavelengths_nm[error.wavelength])
    }
}

impl Point {
    /// The point in words, as by [`Axes::describe`].
    fn describe(&self) -> String {
        let single_value = |value: f64| vec![round(value)];
        let axis = |value: &PropertyValue| PropertyAxis { property: value.property, values: single_value(value.value) };
        let axes = Axes {
            grain_sizes_um: single_value(self.sample.grain_size_um),
            facetness: single_value(self.sample.facetness),
            densities_kg_m3: single_value(self.sample.density_kg_m3),
            properties: self.sample.properties.iter().map(axis).collect(),
            diffuse: false,
            angles_deg: single_value(f64::from(self.angle_deg)),
            thicknesses_cm: single_value(f64::from(self.thickness_cm)),
            wavelengths_nm: vec![0.0],
        };
        axes.describe(0)
    }
}

/// Rounds to four significant digits.
fn round(value: f64) -> f64 {
    let unit = 10_f64.powi(3 - integer(value.abs().max(1e-9).log10().floor()));
    (value * unit).round() / unit
}

#[expect(clippy::cast_possible_truncation, reason = "an integer of two digits")]
fn integer(value: f64) -> i32 {
    value as i32
}
