//! The medium of a sample, mixed from tallies of grains in air and in water, particles, and absorption in the pores.

use super::constituents::{Constituents, Grains};
use super::population::Population;
use super::scattering::{HenyeyGreenstein, Medium, Scattering, mix};
use super::tally::{Deviations, TallyPart, TallyPlan, TallyRequest};
use super::tally_errors::{DeviatingGrains, GrainDeviations};
use crate::dual::{Dual, Real};
use crate::optics::ice::IceTable;
use crate::sample::{GrainSize, SnowSample};

/// The samples that one set of tallies must cover.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Demand<'w> {
    /// Wavelengths, in nm.
    pub wavelengths_nm: &'w [f64],
    /// Published absorption of ice.
    pub ice: IceTable,
    /// Size of the largest grain, in µm.
    pub largest_um: f64,
    /// Whether any sample is wet.
    pub wet: bool,
}

/// Tallies of the grains of one population, in air and, for wet snow, in water.
#[derive(Debug, Clone)]
pub struct GrainTallies {
    in_air: GrainTally,
    in_water: Option<GrainTally>,
}

/// The tally of grains in air or in water.
#[derive(Debug, Clone)]
struct GrainTally {
    part: TallyPart,
    /// Greatest effective absorption coefficient of the ice at any wavelength, in 1/m.
    strongest_per_m: f64,
}

impl Demand<'_> {
    /// The demand of one sample.
    #[must_use]
    pub fn of_sample<'w>(sample: &SnowSample, wavelengths_nm: &'w [f64]) -> Demand<'w> {
        Demand {
            wavelengths_nm,
            ice: sample.ice,
            largest_um: sample.grain_size.max_um,
            wet: sample.water_saturation > 0.0,
        }
    }

    /// The demand of some samples of one ice table.
    ///
    /// # Panics
    /// If there are no samples.
    pub(crate) fn of_samples<'a, 'w>(
        samples: impl IntoIterator<Item = &'a SnowSample>,
        wavelengths_nm: &'w [f64],
    ) -> Demand<'w> {
        let demands = samples.into_iter().map(|sample| Demand::of_sample(sample, wavelengths_nm));
        demands.reduce(|all, demand| all.and(&demand)).unwrap_or_else(|| unreachable!("there is a sample"))
    }

    /// The demand of both; they must have equal ice tables and wavelengths.
    #[must_use]
    pub fn and(self, other: &Self) -> Self {
        Self { largest_um: self.largest_um.max(other.largest_um), wet: self.wet || other.wet, ..self }
    }
}

impl GrainTallies {
    /// Traces rays through grains of `population`. The process keeps its last few tallies, so that equal grains are
    /// not traced again.
    #[must_use]
    pub fn new(population: &Population, demand: &Demand, plan: &TallyPlan) -> Self {
        let saturation = if demand.wet { 0.5 } else { 0.0 };
        let sample = SnowSample { ice: demand.ice, water_saturation: saturation, ..SnowSample::default() };
        let constituents: Vec<Constituents> =
            demand.wavelengths_nm.iter().map(|wavelength_nm| Constituents::new(&sample, *wavelength_nm)).collect();
        let tally = |grains: &dyn Fn(&Constituents) -> Grains| {
            let indices = || constituents.iter().map(|constituents| grains(constituents).relative_index);
            let range = indices().fold(f64::INFINITY, f64::min)..=indices().fold(f64::NEG_INFINITY, f64::max);
            let strongest =
                constituents.iter().map(|constituents| grains(constituents).absorption_per_m).fold(0.0, f64::max);
            let request = TallyRequest::new(population, range, strongest * demand.largest_um * 1e-6, plan);
            GrainTally { part: request.part(), strongest_per_m: strongest }
        };
        Self {
            in_air: tally(&|constituents| constituents.in_air),
            in_water: demand.wet.then(|| tally(&|constituents| constituents.in_water)),
        }
    }

    /// The tallies that [`new`](Self::new) gives for grains up to `largest_um` and moments up to `degree`. Neither
    /// may exceed the size or the degree of these tallies.
    pub(crate) fn narrowed(&self, degree: usize, largest_um: f64) -> Self {
        let narrowed = |GrainTally { part, strongest_per_m }: &GrainTally| GrainTally {
            part: part.narrowed(degree, strongest_per_m * largest_um * 1e-6),
            strongest_per_m: *strongest_per_m,
        };
        Self { in_air: narrowed(&self.in_air), in_water: self.in_water.as_ref().map(narrowed) }
    }

    /// The medium of a sample within the demand at a wavelength.
    ///
    /// # Panics
    /// If the sample is wet and the demand is not.
    #[must_use]
    pub fn medium(&self, sample: &SnowSample, wavelength_nm: f64) -> Medium {
        self.medium_of(&sample.grain_size, &Constituents::new(sample, wavelength_nm))
    }

    /// The medium of constituents, with grains of some sizes.
    ///
    /// # Panics
    /// If a grain is in water and the demand is not.
    pub(crate) fn medium_of<T: Real>(&self, size: &GrainSize, constituents: &Constituents<T>) -> Medium<T> {
        let scattering = |part: &TallyPart, grains: &Grains<T>| {
            part.scattering(size, grains.relative_index, grains.absorption_per_m)
        };
        self.mixed(
            constituents,
            self.kinds(constituents).map(|kind| kind.map(|(part, grains)| scattering(part, grains))),
        )
    }

    /// The deviations of grains in air and in water with each batch of the tallies. All tallies use common scrambles of
    /// the sequence, so their batches correspond.
    pub(crate) fn deviations(&self, size: &GrainSize, constituents: &Constituents) -> GrainDeviations {
        let of_kind = |(part, grains): (&TallyPart, &Grains)| {
            let (scattering, deviations) = part.deviations(size, grains.relative_index, grains.absorption_per_m);
            DeviatingGrains { extinction_per_m: grains.extinction_per_m, scattering, deviations }
        };
        GrainDeviations(self.kinds(constituents).map(|kind| kind.map(of_kind)))
    }

    /// The medium of grains whose deviations are known.
    pub(crate) fn medium_of_deviations(
        &self,
        constituents: &Constituents,
        GrainDeviations(grains): &GrainDeviations,
    ) -> Medium {
        self.mixed(constituents, grains.each_ref().map(|kind| kind.as_ref().map(|kind| kind.scattering.clone())))
    }

    /// The medium with the deviations of its grains in some directions.
    pub(crate) fn deviated_medium(
        &self,
        constituents: &Constituents<Dual>,
        GrainDeviations(grains): &GrainDeviations,
        directions: &[Deviations],
    ) -> Medium<Dual> {
        self.mixed(constituents, grains.each_ref().map(|kind| kind.as_ref().map(|kind| kind.along(directions))))
    }

    /// The grains in air and in water, if there are any, with their tallies.
    fn kinds<'c, T: Real>(
        &self,
        Constituents { in_air, in_water, .. }: &'c Constituents<T>,
    ) -> [Option<(&TallyPart, &'c Grains<T>)>; 2] {
        let is_dry = in_water.extinction_per_m.is_zero();
        assert!(is_dry || self.in_water.is_some(), "the tallies do not cover wet snow");
        [(Some(&self.in_air), in_air), (self.in_water.as_ref(), in_water)].map(|(tally, grains)| {
            tally.filter(|_| !grains.extinction_per_m.is_zero()).map(|tally| (&tally.part, grains))
        })
    }

    /// The mixture of grains in air and in water, which scatter in this way, with the other constituents.
    fn mixed<T: Real>(
        &self,
        constituents: &Constituents<T>,
        [in_air, in_water]: [Option<Scattering<T>>; 2],
    ) -> Medium<T> {
        let mut parts = Vec::new();
        for (scattering, grains) in [(in_air, constituents.in_air), (in_water, constituents.in_water)] {
            parts.extend(scattering.map(|scattering| Medium { extinction_per_m: grains.extinction_per_m, scattering }));
        }
        // A single scatterer needs no sums, which would round.
        if parts.len() == 1 && constituents.particles.is_empty() && constituents.pore_absorption_per_m.is_zero() {
            return parts.swap_remove(0);
        }
        let degree = self.in_air.part.degree();
        for particle in &constituents.particles {
            let Scattering { moments, .. } =
                HenyeyGreenstein { one_minus_albedo: 0.0, asymmetry: particle.asymmetry }.scattering(degree);
            let moments = moments.into_iter().map(T::from).collect();
            let scattering = Scattering { one_minus_albedo: T::from(0.0), moments };
            parts.push(Medium { extinction_per_m: particle.scattering_per_m, scattering });
        }
        mix(&parts, constituents.pore_absorption_per_m)
    }
}
