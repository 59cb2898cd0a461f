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
    /// Traces rays through the grains, also in water if any layer is wet or if wanted.
    pub(super) fn new(stack: &Stack, in_water: bool, options: &OrdinatesOptions) -> Self {
        let plan = options.plan(&stack.incidences, peak(stack));
        // A sample of each kind of grains, with the demand of all layers of that kind.
        let mut kinds: Vec<(SnowSample, Demand)> = Vec::new();
        let mut kind_of_layer = Vec::new();
        for layer in &stack.layers {
            let Some(sample) = layer.sample() else {
                kind_of_layer.push(None);
                continue;
            };
            let demand = Demand::of_sample(sample, &stack.wavelengths_nm);
            let demand = Demand { wet: demand.wet || in_water, ..demand };
            let kind = kinds.iter().position(|(other, _)| other.has_grains_of(sample)).unwrap_or(kinds.len());
            match kinds.get_mut(kind) {
                Some((_, whole)) => *whole = whole.and(&demand),
                None => kinds.push((*sample, demand)),
            }
            kind_of_layer.push(Some(kind));
        }
        let tallies =
            kinds.iter().map(|(sample, demand)| GrainTallies::new(&Population::of_sample(sample), demand, &plan));
        Self { tallies: tallies.collect(), kind_of_layer }
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
