//! Fluxes of a pack at a state of the search, with their derivatives.

use nalgebra::DVector;

use super::measured::Quantity;
use super::problem::{Inversion, Observation};
use crate::TransportError;
use crate::medium::{Demand, GrainTallies, Population};
use crate::ordinates::{DifferentiatedStack, Peak, differentiate_stack};
use crate::parameters::SURFACE_AREA;
use crate::sample::{Property, SnowSample};
use crate::slab::{Fluxes, Incidence};
use crate::stack::{DepthFluxes, ICE_THICKNESS_RANGE, Layer, Stack, StackDerivatives};
use crate::variable::{LayerVariable, Variable};

/// Angle, in degrees, of a beam that needs the streams of grazing light.
const GRAZING_DEG: f64 = 89.0;

/// The values of a pack by the model: each measured quantity at each depth, a row, and at each wavelength or band.
#[derive(Debug, Clone)]
pub(super) struct Model {
    /// The position of each channel among the channels that have a value.
    positions: Vec<Option<usize>>,
    /// Number of channels that have a value.
    solved: usize,
    /// [row][position]
    values: Vec<f64>,
    /// [variable][row][position]
    derivatives: Vec<f64>,
}

impl Model {
    /// The value of the quantity whose first row is `row`. `place` counts the rows of the quantity and, fastest, all
    /// channels. NaN in a channel without a value.
    pub(super) fn value(&self, row: usize, place: usize) -> f64 {
        self.at(row, place).map_or(f64::NAN, |at| self.values[at])
    }

    /// The derivative by a variable.
    pub(super) fn derivative(&self, variable: usize, row: usize, place: usize) -> f64 {
        self.at(row, place).map_or(f64::NAN, |at| self.derivatives[variable * self.values.len() + at])
    }

    fn at(&self, row: usize, place: usize) -> Option<usize> {
        let (further, channel) = (place / self.positions.len(), place % self.positions.len());
        self.positions[channel].map(|position| (row + further) * self.solved + position)
    }
}

impl Inversion {
    /// The model at some values of the variables, at the wavelengths with the indices `used`.
    pub(super) fn model(
        &self,
        observation: &Observation,
        values: &[f64],
        used: &[usize],
    ) -> Result<Model, TransportError> {
        let stack = self.stack(observation, values, used);
        let mut kinds: Vec<Variable> = Vec::new();
        for LayerVariable { variable, .. } in &self.variables {
            if !kinds.contains(variable) {
                kinds.push(*variable);
            }
        }
        let of_layers = LayerVariable::of_layers(&kinds, stack.layers.len());
        let DifferentiatedStack { fluxes, derivatives } = differentiate_stack(&stack, &kinds, &self.options, false)?;
        let lights = observation.illumination.weights(used);
        // The mean over the lights, each of which has all wavelengths.
        let mean = |k: usize, of: &dyn Fn(usize) -> f64| -> f64 {
            lights.iter().enumerate().map(|(light, weights)| weights[k] * of(light * used.len() + k)).sum()
        };
        let rows = observation.rows();
        let channels = self.channels();
        let (solved, weights) = channels.solved(used);
        let of_all = |value: &dyn Fn(Quantity, usize, usize) -> f64| -> Vec<f64> {
            let of_row = |(quantity, depth): &(Quantity, usize)| {
                let (quantity, depth) = (*quantity, *depth);
                let spectrum = (0..used.len()).map(|k| mean(k, &|row| value(quantity, depth, row))).collect::<Vec<_>>();
                match &weights {
                    None => spectrum,
                    Some(weights) => (weights * DVector::from_vec(spectrum)).as_slice().to_vec(),
                }
            };
            rows.iter().flat_map(of_row).collect()
        };
        let by = |by: &LayerVariable| {
            let parts: Vec<usize> = (0..of_layers.len()).filter(|part| by.overlaps(&of_layers[*part])).collect();
            of_all(&|quantity, depth, row| {
                let of_part = |part: &usize| {
                    let StackDerivatives { whole, profile } = &derivatives[row * of_layers.len() + part];
                    quantity.of(whole, profile, depth)
                };
                parts.iter().map(of_part).sum()
            })
        };
        let mut positions = vec![None; channels.len()];
        solved.iter().enumerate().for_each(|(position, channel)| positions[*channel] = Some(position));
        Ok(Model {
            positions,
            solved: solved.len(),
            values: of_all(&|quantity, depth, row| {
                quantity.of(&fluxes[row].whole.fluxes, &fluxes[row].profile, depth).value
            }),
            derivatives: self.variables.iter().flat_map(by).collect(),
        })
    }

    /// The pack with some values of the variables.
    pub(super) fn stack(&self, observation: &Observation, values: &[f64], used: &[usize]) -> Stack {
        let mut stack = observation.stack(used.iter().map(|place| self.wavelengths_nm[*place]).collect());
        for (by, value) in self.variables.iter().zip(values) {
            match by.variable {
                Variable::GroundAlbedo => stack.ground_albedo = (*value).into(),
                Variable::CosIncidence => {
                    stack.incidences[0] = Incidence::Beam { angle_deg: value.acos().to_degrees() };
                }
                Variable::Thickness => by.of_mut(&mut stack.layers).for_each(|layer| {
                    // Within the range in spite of rounding.
                    let least_cm = if layer.is_ice() { ICE_THICKNESS_RANGE.least } else { 0.0 };
                    layer.thickness_cm = value.max(least_cm);
                }),
                Variable::Snow(property) => {
                    let samples = by.of_mut(&mut stack.layers).filter_map(Layer::sample_mut);
                    samples.for_each(|sample| property.set(sample, *value));
                }
            }
        }
        stack
    }

    /// Traces rays through the coarsest grains, which serve all steps. The process keeps the tallies.
    pub(super) fn prepare_tallies<'o>(&self, observations: impl Iterator<Item = &'o Observation>, used: &[usize]) {
        let areas: Vec<&LayerVariable> =
            self.variables.iter().filter(|by| by.variable == Variable::Snow(Property::SurfaceArea)).collect();
        if areas.is_empty() || used.is_empty() {
            return;
        }
        let wavelengths_nm: Vec<f64> = used.iter().map(|place| self.wavelengths_nm[*place]).collect();
        let retrieves = |variable: Variable| self.variables.iter().any(|by| by.variable == variable);
        let is_wet = retrieves(Variable::Snow(Property::WaterSaturation));
        let has_peak = |by: &LayerVariable| match by.variable {
            Variable::Snow(Property::Impurity(substance)) => substance.has_sharp_peak(),
            _ => false,
        };
        let adds_peak = is_wet || self.variables.iter().any(has_peak);
        let mut known: Vec<SnowSample> = Vec::new();
        for observation in observations {
            let peaks = observation.layers.iter().filter_map(|layer| layer.sample().map(Peak::of));
            let peak = if adds_peak { Peak::Sharp } else { peaks.max().unwrap_or_default() };
            let mut incidences = observation.illumination.incidences();
            if retrieves(Variable::CosIncidence) {
                incidences.push(Incidence::Beam { angle_deg: GRAZING_DEG });
            }
            for sample in areas.iter().flat_map(|by| by.of(&observation.layers)).filter_map(Layer::sample) {
                let mut coarsest = *sample;
                Property::SurfaceArea.set(&mut coarsest, SURFACE_AREA.range.least);
                if known.iter().any(|sample| sample.has_grains_of(&coarsest)) {
                    continue;
                }
                known.push(coarsest);
                let demand = Demand::of_sample(&coarsest, &wavelengths_nm);
                let demand = Demand { wet: demand.wet || is_wet, ..demand };
                let plan = self.options.plan(&incidences, peak);
                drop(GrainTallies::new(&Population::of_sample(&coarsest), &demand, &plan));
            }
        }
    }
}

impl Observation {
    /// Each measured quantity at each depth, with the index of the depth among the depths of all quantities.
    fn rows(&self) -> Vec<(Quantity, usize)> {
        let mut depths = 0;
        let mut rows = Vec::new();
        for measured in &self.measured {
            rows.extend((0..measured.rows()).map(|row| (measured.quantity, depths + row)));
            depths += measured.depths_cm.len();
        }
        rows
    }
}

impl Quantity {
    /// Selects the value, or the derivative, of this quantity from the fluxes of the whole stack and at the depths.
    fn of<T: Copy>(self, whole: &Fluxes<T>, profile: &[DepthFluxes<T>], depth: usize) -> T {
        match self {
            Self::Albedo => whole.reflectance,
            Self::Transmittance => whole.transmittance,
            Self::Down => profile[depth].down,
            Self::Up => profile[depth].up,
            Self::Net => profile[depth].net,
            Self::Fluence => profile[depth].fluence,
        }
    }
}
