//! The media of the layers of a stack at a wavelength, with the tallies of their grains.

use super::options::{MAX_STREAMS, OrdinatesOptions, Peak};
use crate::dual::{Dual, LANES, Real};
use crate::medium::{Composition, Demand, GrainDeviations, GrainTallies, Medium, Population, Scattering, directions};
use crate::optics::IceTable;
use crate::sample::SnowSample;
use crate::stack::{Layer, LayerKind, Stack};
use crate::variable::Variable;

/// Variables, no more than a [`Dual`] has derivatives, and the composition of each layer with its derivatives.
pub(super) struct Differentiation<'v> {
    pub(super) variables: &'v [Variable],
    /// None of ice.
    compositions: Vec<Option<Composition<Dual>>>,
}

/// Some variables, and the medium of each layer with its derivatives at one wavelength. Without variables the
/// derivatives are deviations of the grain tallies.
pub(super) struct DifferentiatedMedia<'v> {
    pub(super) variables: &'v [Variable],
    pub(super) media: Vec<Medium<Dual>>,
}

/// Tallies of the grains of a stack.
pub(super) struct Grains {
    tallies: Vec<GrainTallies>,
    /// The tallies of each layer; none of ice.
    kind_of_layer: Vec<Option<usize>>,
}

impl<'v> Differentiation<'v> {
    pub(super) fn new(stack: &Stack, variables: &'v [Variable]) -> Self {
        let of = |sample: &SnowSample| Composition::new(sample).differentiated(variables);
        Self { variables, compositions: stack.layers.iter().map(|layer| layer.sample().map(of)).collect() }
    }
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
        for stack in stacks {
            let degree = options.plan(&stack.incidences, peak(stack)).degree;
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
        stacks.iter().map(|stack| Self::narrowed(stack, &kinds, options)).collect()
    }

    /// The part of the tallies of each kind of grains that the layers of a stack need.
    fn narrowed(stack: &Stack, kinds: &[(SnowSample, GrainTallies)], options: &OrdinatesOptions) -> Self {
        let degree = options.plan(&stack.incidences, peak(stack)).degree;
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
        let place = |kind: Option<usize>| present.binary_search(&kind?).ok();
        Self { tallies, kind_of_layer: kind_of_layer.into_iter().map(place).collect() }
    }

    /// The medium of each layer at a wavelength.
    pub(super) fn media(&self, stack: &Stack, wavelength_nm: f64) -> Vec<Medium> {
        let layers = stack.layers.iter().zip(&self.kind_of_layer);
        let medium = |(layer, kind): (&Layer, &Option<usize>)| match (&layer.kind, kind) {
            (LayerKind::Snow(sample), Some(kind)) => self.tallies[*kind].medium(sample, wavelength_nm),
            (LayerKind::Snow(_), None) => unreachable!("snow has tallies"),
            (LayerKind::Ice(table), _) => clear_ice(*table, wavelength_nm),
        };
        layers.map(medium).collect()
    }

    /// The medium of each layer at a wavelength, with deviations of the tallies. `exactly` has no variables.
    pub(super) fn deviated_media<'v>(
        &self,
        stack: &Stack,
        wavelength_nm: f64,
        Differentiation { variables, compositions }: &Differentiation<'v>,
    ) -> Vec<DifferentiatedMedia<'v>> {
        let layers = || stack.layers.iter().zip(&self.kind_of_layer);
        let deviations = |(layer, kind): (&Layer, &Option<usize>)| {
            let (sample, tallies) = (layer.sample()?, &self.tallies[(*kind)?]);
            Some(tallies.deviations(&sample.grain_size, &Composition::new(sample).at(wavelength_nm)))
        };
        let deviations: Vec<Option<GrainDeviations>> = layers().map(deviations).collect();
        let directions = directions(deviations.iter().flatten());
        let along = |directions: &[_]| {
            let media =
                layers().zip(compositions).zip(&deviations).map(|(((layer, kind), composition), deviations)| {
                    match (&layer.kind, kind, composition, deviations) {
                        (LayerKind::Snow(_), Some(kind), Some(composition), Some(deviations)) => {
                            self.tallies[*kind].deviated_medium(&composition.at(wavelength_nm), deviations, directions)
                        }
                        (LayerKind::Snow(_), ..) => unreachable!("snow has tallies and a composition"),
                        (LayerKind::Ice(table), ..) => clear_ice(*table, wavelength_nm),
                    }
                });
            DifferentiatedMedia { variables, media: media.collect() }
        };
        directions.chunks(LANES).map(along).collect()
    }

    /// The medium of each layer at a wavelength, with derivatives.
    pub(super) fn differentiated_media<'v>(
        &self,
        stack: &Stack,
        wavelength_nm: f64,
        Differentiation { variables, compositions }: &Differentiation<'v>,
    ) -> DifferentiatedMedia<'v> {
        let layers = stack.layers.iter().zip(&self.kind_of_layer).zip(compositions);
        let medium = |((layer, kind), composition): ((&Layer, &Option<usize>), &Option<Composition<Dual>>)| match (
            &layer.kind,
            kind,
            composition,
        ) {
            (LayerKind::Snow(sample), Some(kind), Some(composition)) => {
                self.tallies[*kind].medium_of(&sample.grain_size, &composition.at(wavelength_nm))
            }
            (LayerKind::Snow(_), ..) => unreachable!("snow has tallies and a composition"),
            (LayerKind::Ice(table), ..) => clear_ice(*table, wavelength_nm),
        };
        DifferentiatedMedia { variables, media: layers.map(medium).collect() }
    }
}

/// Ice that only absorbs.
fn clear_ice<T: Real>(table: IceTable, wavelength_nm: f64) -> Medium<T> {
    Medium {
        extinction_per_m: T::from(table.absorption_per_m(wavelength_nm)),
        scattering: Scattering { one_minus_albedo: T::from(1.0), moments: vec![T::from(0.0); MAX_STREAMS + 1] },
    }
}
