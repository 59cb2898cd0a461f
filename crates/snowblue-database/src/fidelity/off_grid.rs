//! What look-ups between a table's values cost: random places, looked up and solved directly.
//!
//! The direct solutions use the rays and the seed that the table was filled with. The noise of the grain tally, which both
//! have in common, drops out, and what is left is the error of components and interpolation alone. Only between two values
//! of facetness, whose grains are others, does noise differ: that much of the error is the tally's.

use std::collections::BTreeMap;

use rayon::prelude::*;
use snowblue_color::{Colorimeter, Illuminant, Lab, Observer};
use snowblue_transport::optics::IceTable;
use snowblue_transport::ordinates::{HomogeneousMedium, Peak, Streams};
use snowblue_transport::rng::Stream;
use snowblue_transport::slab::Incidence;
use snowblue_transport::{Demand, GrainTallies, Population, TallyPlan};

use super::{Spread, spread};
use crate::fill::{self, Engine};
use crate::pca::single;
use crate::{Axes, CompressedTable, DatabaseError, PcaSnow, Quantity, Space, TableSample};

/// Relative errors of less light than this are told apart, as no eye sees it.
pub const BRIGHT: f64 = 1e-6;
/// Thicknesses at random, evenly in their logarithm, in cm.
const THICKNESSES_CM: (f64, f64) = (0.01, 100.0);
/// Angles at random, apart for steep and grazing light, in degrees.
const ANGLES_DEG: [(f64, f64); 2] = [(0.0, 80.0), (80.0, 89.0)];
/// Values of facetness between those of the table: each takes a tally.
const KINDS: usize = 3;

/// What is asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OffGrid {
    /// Places for each kind of snow and each range of angles.
    pub places: usize,
    /// Seed of the places.
    pub seed: u64,
    /// Under which colours are compared.
    pub illuminant: Illuminant,
}

/// Errors of look-ups at random thicknesses and angles.
#[derive(Debug, Clone, PartialEq)]
pub struct Interpolation {
    /// Transmittance or reflectance.
    pub quantity: Quantity,
    /// Whether the snow, too, lies between the table's values.
    pub between_samples: bool,
    /// The angles, in degrees.
    pub angles_deg: (f64, f64),
    /// Relative error at each place and wavelength where the value exceeds [`BRIGHT`].
    pub bright: Spread,
    /// Relative error at each place and wavelength.
    pub relative: Spread,
    /// Colour difference at each place, the illuminant being white.
    pub delta_e: Spread,
    /// Where `bright`, `relative` and `delta_e` are worst, in words.
    pub worst: [String; 3],
}

/// One place.
struct Place {
    sample: TableSample,
    thickness_cm: f32,
    angle_deg: f32,
}

/// Transmittance and reflectance, as the table looks them up and as the engine solves them.
struct Answer {
    found: [Vec<f32>; 2],
    solved: [Vec<f64>; 2],
}

/// How the table was filled.
struct Filled<'t> {
    axes: &'t Axes,
    plan: TallyPlan,
    streams: Streams,
    ice: IceTable,
}

/// Compares look-ups with direct solutions, for the table's own samples and, in log space, for samples between them.
///
/// # Errors
/// If the table was not filled by discrete ordinates, or if its wavelengths do not allow colours.
pub fn off_grid(table: &CompressedTable, asked: &OffGrid) -> Result<Vec<Interpolation>, DatabaseError> {
    let options = fill::told_by(&table.metadata)?;
    let Engine::Ordinates { streams, tally_rays } = options.engine else {
        return Err(DatabaseError::Metadata { name: "engine" });
    };
    let mut peak = Peak::default();
    for number in 0..table.axes.samples() {
        peak = peak.max(Peak::of(&table.axes.sample(number, options.ice)?));
    }
    // As many moments as the most grazing place takes; the table's own are among them.
    let grazing = Incidence::Beam { angle_deg: ANGLES_DEG[1].1 };
    let degree = streams.most(&[&table.axes.incidences()[..], &[grazing]].concat(), peak);
    let plan = TallyPlan { degree, rays: tally_rays, seed: options.seed };
    let filled = Filled { axes: &table.axes, plan, streams, ice: options.ice };
    let colorimeter = Colorimeter::new(Observer::Cie1931, asked.illuminant, &table.axes.wavelengths_nm)?;
    let mut rows = Vec::new();
    for between_samples in [false, true] {
        // The paper's form takes the grid's snow alone.
        if between_samples && table.space == Space::Linear {
            continue;
        }
        let places = places(&table.axes, asked, between_samples);
        let answers = answers(table, &filled, &places)?;
        for (places, (answers, angles_deg)) in
            places.chunks_exact(asked.places).zip(answers.chunks_exact(asked.places).zip(angles_deg(&table.axes)))
        {
            for quantity in Quantity::ALL {
                rows.push(Interpolation {
                    between_samples,
                    angles_deg,
                    ..compare(&table.axes, &colorimeter, places, (answers, quantity))
                });
            }
        }
    }
    Ok(rows)
}

/// Places for the steep angles, then as many for the grazing ones.
fn places(axes: &Axes, asked: &OffGrid, between_samples: bool) -> Vec<Place> {
    let mut random = Stream::new(asked.seed, u64::from(between_samples));
    let kinds: Vec<f64> = (0..KINDS).map(|_| within(&axes.facetness, random.uniform())).collect();
    let mut all = Vec::with_capacity(ANGLES_DEG.len() * asked.places);
    let (first_cm, last_cm) = (axes.thicknesses_cm[0], axes.thicknesses_cm[axes.thicknesses_cm.len() - 1]);
    let thicknesses_cm = (THICKNESSES_CM.0.max(first_cm), THICKNESSES_CM.1.min(last_cm));
    for (low_deg, high_deg) in angles_deg(axes) {
        for number in 0..asked.places {
            let sample = if between_samples {
                between(axes, kinds[number % KINDS], &mut random)
            } else {
                axes.table_sample(choose(axes.samples(), random.uniform()))
            };
            let (thin_cm, thick_cm) = thicknesses_cm;
            all.push(Place {
                sample,
                thickness_cm: single(thin_cm * (thick_cm / thin_cm).powf(random.uniform())),
                angle_deg: single(low_deg + (high_deg - low_deg) * random.uniform()),
            });
        }
    }
    all
}

/// The ranges of angles that a table reaches.
fn angles_deg(axes: &Axes) -> Vec<(f64, f64)> {
    let (Some(first_deg), Some(last_deg)) = (axes.angles_deg.first(), axes.angles_deg.last()) else { return vec![] };
    let reached = ANGLES_DEG.map(|(low_deg, high_deg)| (low_deg.max(*first_deg), high_deg.min(*last_deg)));
    reached.into_iter().filter(|(low_deg, high_deg)| low_deg <= high_deg).collect()
}

/// Snow somewhere between a table's values.
fn between(axes: &Axes, facetness: f64, random: &mut Stream) -> TableSample {
    let grain_size_um = within(&axes.grain_sizes_um, random.uniform());
    let density_kg_m3 = within(&axes.densities_kg_m3, random.uniform());
    let further = axes.further.iter().map(|(property, values)| (*property, within(values, random.uniform()))).collect();
    TableSample { grain_size_um, facetness, density_kg_m3, further }
}

/// A value on or between those of an axis, each interval being as likely as another.
fn within(values: &[f64], share: f64) -> f64 {
    let ways = values.len() - 1;
    if ways == 0 {
        return values[0];
    }
    let below = choose(ways, share);
    values[below] + (share * ways as f64 - below as f64) * (values[below + 1] - values[below])
}

/// A number below `count`.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share is not negative")]
fn choose(count: usize, share: f64) -> usize {
    ((share * count as f64) as usize).min(count - 1)
}

/// Looks all places up and solves them, with one tally for each facetness.
fn answers(table: &CompressedTable, filled: &Filled, places: &[Place]) -> Result<Vec<Answer>, DatabaseError> {
    let mut of_facetness: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
    for (number, place) in places.iter().enumerate() {
        of_facetness.entry(place.sample.facetness.to_bits()).or_default().push(number);
    }
    let mut answers: Vec<Option<Answer>> = places.iter().map(|_| None).collect();
    for numbers in of_facetness.values() {
        let tallies = filled.tallies(&places[numbers[0]].sample)?;
        let answer = |number: &usize| {
            let place = &places[*number];
            let snow = PcaSnow::new(table, &place.sample)?;
            let mut found = [(); 2].map(|()| vec![0.0; table.axes.wavelengths_nm.len()]);
            snow.transmittance(place.thickness_cm, place.angle_deg, &mut found[0]);
            snow.reflectance(place.thickness_cm, place.angle_deg, &mut found[1]);
            Ok((*number, Answer { found, solved: filled.solve(&tallies, place)? }))
        };
        let solved: Result<Vec<(usize, Answer)>, DatabaseError> = numbers.par_iter().map(answer).collect();
        for (number, answer) in solved? {
            answers[number] = Some(answer);
        }
    }
    Ok(answers.into_iter().flatten().collect())
}

impl Filled<'_> {
    /// The tallies that the table was filled with, of the grains of one facetness.
    fn tallies(&self, sample: &TableSample) -> Result<GrainTallies, DatabaseError> {
        let wavelengths_nm = &self.axes.wavelengths_nm;
        let mut demand = Demand::of_sample(&sample.snow(self.ice)?, wavelengths_nm);
        for number in 0..self.axes.samples() {
            demand = demand.and(&Demand::of_sample(&self.axes.sample(number, self.ice)?, wavelengths_nm));
        }
        Ok(GrainTallies::new(&Population::of_sample(&sample.snow(self.ice)?), &demand, &self.plan))
    }

    /// Transmittance and reflectance at every wavelength.
    fn solve(&self, tallies: &GrainTallies, place: &Place) -> Result<[Vec<f64>; 2], DatabaseError> {
        let sample = place.sample.snow(self.ice)?;
        let incidence = Incidence::Beam { angle_deg: f64::from(place.angle_deg) };
        let streams = self.streams.under(&incidence, Peak::of(&sample));
        let solved = |wavelength_nm: &f64| {
            let medium = tallies.medium(&sample, *wavelength_nm, None);
            let modes = HomogeneousMedium::new(&medium.scattering, streams);
            let optical_depth = medium.extinction_per_m * f64::from(place.thickness_cm) * 0.01;
            let fluxes = modes.fluxes(optical_depth, &[modes.light(&incidence)]);
            (fluxes[0].transmittance, fluxes[0].reflectance)
        };
        let (transmittance, reflectance) = self.axes.wavelengths_nm.iter().map(solved).unzip();
        Ok([transmittance, reflectance])
    }
}

/// Errors of one quantity over some places; whose angles and snow they are the caller knows.
fn compare(
    axes: &Axes,
    colorimeter: &Colorimeter,
    places: &[Place],
    (answers, quantity): (&[Answer], Quantity),
) -> Interpolation {
    let which = usize::from(quantity == Quantity::Reflectance);
    let pairs = || {
        answers.iter().enumerate().flat_map(|(place, answer)| {
            let pairs = answer.found[which].iter().zip(&answer.solved[which]).enumerate();
            pairs.map(move |(w, (found, solved))| ((place, w), f64::from(*found) / solved - 1.0, *solved))
        })
    };
    let relative = spread(pairs().map(|(_, error, _)| error.abs()));
    let bright: Vec<_> = pairs().filter(|(.., solved)| *solved > BRIGHT).collect();
    let bright_spread = spread(bright.iter().map(|(_, error, _)| error.abs()));
    let lab = |values: &[f64]| Lab::from_xyz(colorimeter.xyz(values), colorimeter.white());
    let delta_e = spread(answers.iter().map(|answer| {
        let found: Vec<f64> = answer.found[which].iter().map(|value| f64::from(*value)).collect();
        lab(&found).delta_e_1976(lab(&answer.solved[which]))
    }));
    let wavelengths = axes.wavelengths_nm.len();
    let at = |(place, w): (usize, usize)| format!("{}, {} nm", places[place].describe(), axes.wavelengths_nm[w]);
    let worst = [
        at(bright.get(bright_spread.worst_curve).map_or((0, 0), |(place, ..)| *place)),
        at((relative.worst_curve / wavelengths, relative.worst_curve % wavelengths)),
        places[delta_e.worst_curve].describe(),
    ];
    Interpolation {
        quantity,
        between_samples: false,
        angles_deg: (0.0, 0.0),
        bright: bright_spread,
        relative,
        delta_e,
        worst,
    }
}

impl Place {
    /// The place in words, as [`Axes::describe`] would say.
    fn describe(&self) -> String {
        let one = |value: f64| vec![round(value)];
        let axes = Axes {
            grain_sizes_um: one(self.sample.grain_size_um),
            facetness: one(self.sample.facetness),
            densities_kg_m3: one(self.sample.density_kg_m3),
            further: self.sample.further.iter().map(|(property, value)| (*property, one(*value))).collect(),
            diffuse: false,
            angles_deg: one(f64::from(self.angle_deg)),
            thicknesses_cm: one(f64::from(self.thickness_cm)),
            wavelengths_nm: vec![0.0],
        };
        axes.describe(0)
    }
}

/// Four figures, for words.
fn round(value: f64) -> f64 {
    let unit = 10_f64.powi(3 - whole(value.abs().max(1e-9).log10().floor()));
    (value * unit).round() / unit
}

#[expect(clippy::cast_possible_truncation, reason = "a whole number of two figures")]
fn whole(value: f64) -> i32 {
    value as i32
}
