//! The media of the layers of a stack at a wavelength, with the tallies of their grains.

use super::options::{MAX_STREAMS, OrdinatesOptions, Peak};
use crate::dual::{Dual, LANES, Real};
use crate::medium::{Composition, Demand, GrainDeviations, GrainTallies, Medium, Population, Scattering, directions};
use crate::optics::IceTable;
use crate::sample::{GrainSize, SnowSample};
use crate::stack::{Layer, LayerKind, Stack};
use crate::variable::Variable;

/// Some variables, and the medium of each layer with its derivatives at one wavelength. Without variables the
/// derivatives are deviations of the grain tallies.
pub(super) struct DifferentiatedMedia<'v> {
    pub(super) variables: &'v [Variable],
    pub(super) media: Vec<Medium<Dual>>,
}

/// Tallies of the grains of a stack, and what its layers are made of.
pub(super) struct Grains {
    tallies: Vec<GrainTallies>,
    layers: Vec<LayerMaterial>,
}

/// The material of a layer.
enum LayerMaterial {
    Snow {
        /// The place of its tallies.
        tallies: usize,
        size: GrainSize,
        composition: Box<Composition>,
    },
    Ice(IceTable),
}

/// The sharpest peak of all layers. All layers have one number of streams.
pub(super) fn peak(stack: &Stack) -> Peak {
    stack.layers.iter().filter_map(|layer| layer.sample().map(Peak::of)).max().unwrap_or_default()
}

impl Grains {
    /// Traces rays through the grains of stacks at common wavelengths, also in water if any layer is wet or if wanted.
    /// The tallies of a stack do not depend on the other stacks.
    pub(super) fn of_stacks(stacks: &[Stack], in_water: bool, options: &OrdinatesOptions) -> Vec<Self> {
        // A sample of each kind of grains, with the demand of all layers of that kind and the greatest degree.
        let mut kinds: Vec<(SnowSample, Demand, usize)> = Vec::new();
        let degrees: Vec<usize> =
            stacks.iter().map(|stack| options.plan(&stack.incidences, peak(stack)).degree).collect();
        for (stack, &degree) in stacks.iter().zip(&degrees) {
            for sample in stack.layers.iter().filter_map(Layer::sample) {
                let demand = Demand::of_sample(sample, &stack.wavelengths_nm);
                let demand = Demand { wet: demand.wet || in_water, ..demand };
                match kinds.iter_mut().find(|(other, ..)| other.has_grains_of(sample)) {
                    Some((_, whole, greatest)) => (*whole, *greatest) = (whole.and(&demand), degree.max(*greatest)),
                    None => kinds.push((*sample, demand, degree)),
                }
            }
        }
        let tally = |(sample, demand, degree): (SnowSample, Demand, usize)| {
            let plan = options.plan_of_degree(degree);
            (sample, GrainTallies::new(&Population::of_sample(&sample), &demand, &plan))
        };
        let kinds: Vec<(SnowSample, GrainTallies)> = kinds.into_iter().map(tally).collect();
        stacks.iter().zip(degrees).map(|(stack, degree)| Self::narrowed(stack, &kinds, degree)).collect()
    }

    /// The part of the tallies of each kind of grains that the layers of a stack need, up to a degree.
    fn narrowed(stack: &Stack, kinds: &[(SnowSample, GrainTallies)], degree: usize) -> Self {
        let kind = |sample: &SnowSample| kinds.iter().position(|(other, _)| other.has_grains_of(sample));
        let kind_of_layer: Vec<Option<usize>> = stack.layers.iter().map(|layer| kind(layer.sample()?)).collect();
        let mut present: Vec<usize> = kind_of_layer.iter().flatten().copied().collect();
        present.sort_unstable();
        present.dedup();
        let narrowed = |kind: &usize| {
            let own = stack.layers.iter().zip(&kind_of_layer).filter(|(_, of_layer)| **of_layer == Some(*kind));
            let sizes_um = own.filter_map(|(layer, _)| Some(layer.sample()?.grain_size.max_um));
            kinds[*kind].1.narrowed(degree, sizes_um.fold(0.0, f64::max))
        };
        let tallies = present.iter().map(narrowed).collect();
        let material = |(layer, kind): (&Layer, &Option<usize>)| match (&layer.kind, kind) {
            (LayerKind::Snow(sample), Some(kind)) => LayerMaterial::Snow {
                tallies: present.partition_point(|one| one < kind),
                size: sample.grain_size,
                composition: Box::new(Composition::new(sample)),
            },
            (LayerKind::Snow(_), None) => unreachable!("snow has tallies"),
            (LayerKind::Ice(table), _) => LayerMaterial::Ice(*table),
        };
        Self { tallies, layers: stack.layers.iter().zip(&kind_of_layer).map(material).collect() }
    }

    /// The medium of each layer at a wavelength.
    pub(super) fn media(&self, wavelength_nm: f64) -> Vec<Medium> {
        let medium = |layer: &LayerMaterial| match layer {
            LayerMaterial::Snow { tallies, size, composition } => {
                self.tallies[*tallies].medium_of(size, &composition.at(wavelength_nm))
            }
            LayerMaterial::Ice(table) => clear_ice(*table, wavelength_nm),
        };
        self.layers.iter().map(medium).collect()
    }

    /// The medium of each layer at a wavelength, with deviations of the tallies.
    pub(super) fn deviated_media(&self, wavelength_nm: f64) -> Vec<DifferentiatedMedia<'static>> {
        let deviations = |layer: &LayerMaterial| match layer {
            LayerMaterial::Snow { tallies, size, composition } => {
                Some(self.tallies[*tallies].deviations(size, &composition.at(wavelength_nm)))
            }
            LayerMaterial::Ice(_) => None,
        };
        let deviations: Vec<Option<GrainDeviations>> = self.layers.iter().map(deviations).collect();
        let directions = directions(deviations.iter().flatten());
        let along = |directions: &[_]| {
            let medium = |(layer, deviations): (&LayerMaterial, &Option<GrainDeviations>)| match (layer, deviations) {
                (LayerMaterial::Snow { tallies, composition, .. }, Some(deviations)) => {
                    let exactly = composition.differentiated(&[]);
                    self.tallies[*tallies].deviated_medium(&exactly.at(wavelength_nm), deviations, directions)
                }
                (LayerMaterial::Snow { .. }, None) => unreachable!("snow has deviations"),
                (LayerMaterial::Ice(table), _) => clear_ice(*table, wavelength_nm),
            };
            let media = self.layers.iter().zip(&deviations).map(medium).collect();
            DifferentiatedMedia { variables: &[], media }
        };
        directions.chunks(LANES).map(along).collect()
    }

    /// The medium of each layer at a wavelength, with derivatives by some variables, no more than a [`Dual`] has.
    pub(super) fn differentiated_media<'v>(
        &self,
        wavelength_nm: f64,
        variables: &'v [Variable],
    ) -> DifferentiatedMedia<'v> {
        let medium = |layer: &LayerMaterial| match layer {
            LayerMaterial::Snow { tallies, size, composition } => {
                self.tallies[*tallies].medium_of(size, &composition.differentiated(variables).at(wavelength_nm))
            }
            LayerMaterial::Ice(table) => clear_ice(*table, wavelength_nm),
        };
        DifferentiatedMedia { variables, media: self.layers.iter().map(medium).collect() }
    }
}

/// Ice that only absorbs.
fn clear_ice<T: Real>(table: IceTable, wavelength_nm: f64) -> Medium<T> {
    Medium {
        extinction_per_m: T::from(table.absorption_per_m(wavelength_nm)),
        scattering: Scattering { one_minus_albedo: T::from(1.0), moments: vec![T::from(0.0); MAX_STREAMS + 1] },
    }
}
