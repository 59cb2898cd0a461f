//! Derivatives of the fluxes of layers by the adjoint equations: one further solution for each light serves every flux,
//! depth, layer and variable.
//!
//! **The network and its adjoint.** S at all faces solves A x = s. A is symmetric and sums the conductances of the
//! layers. s is the current that an emitting face injects, which no variable changes. A flux is cᵀ x, the radiance
//! that leaves the top, with c by the [`Escape`] of each layer. From A λ = c follows
//!
//! ```text
//! d(cᵀ x) = dcᵀ x − λᵀ dA x
//! ```
//!
//! (Marchuk 1995, *Adjoint Equations and Analysis of Complex Systems*, ch. 1). By reciprocity λ is the light of the
//! beam itself. The sum of dA over layers is a sum of small terms in the modes of each layer: with the amplitudes φ
//! of S at the top t and the bottom b, D = k tanh(kτ/2), e = k/sinh(kτ), and c_s for the slope at the top, a layer
//! adds
//!
//! ```text
//! −λᵀ dA x = −(λ_t + c_s)ᵀ dD φ_t − λ_bᵀ dD φ_b − (λ_t + c_s − λ_b)ᵀ de (φ_t − φ_b)
//!            + (Xλ_t)ᵀ i_t + (Xλ_b)ᵀ i_b + (i_t^λ)ᵀ X φ_t + (i_b^λ)ᵀ X φ_b,
//! ```
//!
//! where i are the currents into the layer, of x and of λ, and X is the change of its modes. Where a layer is thin,
//! e (φ_t − φ_b) follows from the current, and de from r = 1/e.
//!
//! In ice dD and de are the changes of the elements of the ice itself, and X is 0. Radiance that is not scattered on
//! its way through the stack, down and up between layers of ice, has its own derivative: the light in the beam's
//! direction at each face, weighted with the fractions of the beam that arrive there.
//!
//! **Everything is an escape.** All terms are linear in the amplitudes of a layer, as its radiance is. So the
//! derivative of a flux is a radiance as well, of an [`Escape`] with derivatives.

use nalgebra::DVector;

use super::differentiated::DifferentiatedModes;
use super::escape::{Escape, FaceEscapes, Profile};
use super::homogeneous::{HomogeneousMedium, solver};
use super::ice_slab::{Unscattered, ice_lights, unscattered};
use super::integrals::{rate_over_sinh, sinh_over_rate};
use super::layered::{Beam, Emission, LayerModes, LayeredMedium, Response, cross, ground_radiance};
use crate::dual::{Dual, LANES, Real};
use crate::variable::Variable;

/// A layer with its derivatives.
pub(super) struct DifferentiatedLayer<'m> {
    pub(super) modes: &'m DifferentiatedModes,
    /// Scaled optical depth.
    pub(super) depth: Dual,
}

/// The adjoint solution for one light, which serves all variables.
pub(super) struct Adjoint {
    /// λ in each layer.
    layers: Vec<AdjointLayer>,
    /// 1ᵀ M λ on the ground.
    on_ground: f64,
}

/// The derivatives of all fluxes under one light by some variables.
pub(super) struct Sensitivity<'a> {
    adjoint: &'a Adjoint,
    /// Derivatives of the radiance of each layer, as it arrives at the top of the stack.
    escape: Vec<Escape<Dual>>,
    beam: Option<BeamSensitivity<'a>>,
    /// Radiance of the ground per 1ᵀ M S on it.
    ground: Dual,
}

/// Changes of a beam that is not scattered.
struct BeamSensitivity<'a> {
    beam: &'a Beam,
    /// μ, with the derivative by the cosine.
    cosine: Dual,
    /// Unscattered fractions at each face, with derivatives by the cosine.
    unscattered: Unscattered<Dual>,
    /// Fractions that each layer reflects and transmits unscattered, with derivatives by the variables of the layer.
    /// For snow the second number is the relative change of the transmitted fraction, with the value 1.
    passed: Vec<[Dual; 2]>,
}

/// The derivatives of a flux.
pub(super) struct FluxChange {
    /// Derivatives by the variables of each layer.
    pub(super) layers: Vec<[f64; LANES]>,
    /// Derivatives by the variables of the light and the ground.
    pub(super) whole: [f64; LANES],
}

/// The adjoint solution in one layer.
struct AdjointLayer {
    /// λ_t.
    top: DVector<f64>,
    /// λ_t + c_s.
    raised: DVector<f64>,
    /// λ_b.
    bottom: DVector<f64>,
    /// i_t^λ.
    top_current: DVector<f64>,
    /// i_b^λ.
    bottom_current: DVector<f64>,
    /// c_b.
    source: DVector<f64>,
}

impl LayeredMedium<'_> {
    /// The derivatives by `variables` under each of the lights. `adjoints` are the adjoint solutions for the lights;
    /// `layers` and `ground_albedo` have derivatives by the variables.
    pub(super) fn sensitivities<'a>(
        &'a self,
        adjoints: &'a [Adjoint],
        layers: &[DifferentiatedLayer],
        ground_albedo: Dual,
        variables: &[Variable],
    ) -> Vec<Sensitivity<'a>> {
        let ground = ground_radiance(ground_albedo);
        let lights = self.lights.iter().zip(adjoints);
        lights.map(|light| self.sensitivity(light, layers, ground, variables)).collect()
    }

    fn sensitivity<'a>(
        &self,
        (light, adjoint): (&'a Response, &'a Adjoint),
        layers: &[DifferentiatedLayer],
        ground: Dual,
        variables: &[Variable],
    ) -> Sensitivity<'a> {
        let beam = match light {
            Response::Lambertian => None,
            Response::Beam(beam) => {
                let cosine = Variable::CosIncidence.number(beam.cosine, variables);
                let by_cosine: Vec<[Dual; 2]> = self.layers.iter().map(|layer| layer.unscattered(cosine)).collect();
                let passed = layers.iter().zip(&self.layers).map(|(layer, plain)| match plain.medium.ice_index {
                    Some(_) => unscattered(plain.medium.ice_index, layer.depth, Dual::from(beam.cosine)),
                    None => [Dual::from(0.0), -layer.depth / beam.cosine],
                });
                let unscattered = Unscattered::new(&by_cosine);
                Some(BeamSensitivity { beam, cosine, unscattered, passed: passed.collect() })
            }
        };
        let escapes = layers.iter().zip(&self.layers).zip(&adjoint.layers).enumerate();
        let escape = escapes.map(|(j, ((layer, plain), adjoint))| {
            let own = match &beam {
                Some(BeamSensitivity { cosine, unscattered: Unscattered { down, up }, .. }) => {
                    let (rates, sees_bottom) = (&layer.modes.rates, up[j + 1].value() > 0.0);
                    let faces = FaceEscapes::new(&layer.modes.direction(*cosine), rates, (layer.depth, sees_bottom));
                    faces.seen([down[j], up[j + 1]])
                }
                None => Escape::zeros(plain.medium.modes.rates.len()),
            };
            adjoint.add_to(own, layer, plain)
        });
        Sensitivity { adjoint, escape: escape.collect(), beam, ground }
    }

    /// The adjoint solution for each of the lights.
    pub(super) fn adjoints(&self) -> Vec<Adjoint> {
        self.lights.iter().map(|light| self.adjoint(light)).collect()
    }

    fn adjoint(&self, light: &Response) -> Adjoint {
        let beam = match light {
            Response::Lambertian => None,
            Response::Beam(Beam { unscattered: Unscattered { down, up }, escapes, .. }) => {
                let seen = escapes.iter().enumerate().map(|(j, faces)| faces.seen([down[j], up[j + 1]]));
                Some((seen.collect::<Vec<Escape>>(), down[self.layers.len()]))
            }
        };
        let last = self.layers.len();
        let ground = &self.medium_at(last).entering[1];
        // The current that everything below a face injects there. The current of this side is y λ less the injected
        // current.
        let mut injected = match &beam {
            Some((_, at_ground)) => ground * (at_ground * self.ground),
            None => DVector::zeros(ground.len()),
        };
        let mut below = vec![injected.clone()];
        let mut near = Vec::with_capacity(last);
        for (j, layer) in self.layers.iter().enumerate().rev() {
            if let Some(interface) = &layer.interface {
                injected = &interface.up * injected;
            }
            near.push(injected.clone());
            if let Some((seen, _)) = &beam {
                let escape = &seen[j];
                injected = &escape.top - &self.lower[j].conductance * &escape.top_slope
                    + layer.returned(&(&escape.bottom + &injected));
            } else {
                injected = layer.returned(&injected);
            }
            below.push(injected.clone());
        }
        let nothing = DVector::zeros(injected.len());
        let both = solver(&(&self.lower[0].conductance + &self.upper[0].conductance), &nothing);
        let above = if beam.is_some() { injected } else { injected + 2.0 * &self.layers[0].medium.entering[1] };
        let mut top = both.solve(&above);
        let mut current = &self.lower[0].conductance * &top - &below[last];
        let mut layers = Vec::with_capacity(last);
        for (j, layer) in self.layers.iter().enumerate() {
            let escape = beam.as_ref().map(|(seen, _)| &seen[j]);
            let raised = escape.map_or_else(|| top.clone(), |escape| &top + &escape.top_slope);
            let source = escape.map_or_else(|| DVector::zeros(top.len()), |escape| escape.bottom.clone());
            let bottom = cross(layer.downwards.as_ref(), &raised) + layer.received(&(&source + &near[last - 1 - j]));
            let next = layer.interface.as_ref().map_or_else(|| bottom.clone(), |one| one.up.tr_mul(&bottom));
            let onwards = &self.lower[j + 1].conductance * &next - &below[last - 1 - j];
            let bottom_current = -layer.interface.as_ref().map_or_else(|| onwards.clone(), |one| &one.up * &onwards);
            layers.push(AdjointLayer { top, raised, bottom, top_current: current, bottom_current, source });
            (top, current) = (next, onwards);
        }
        Adjoint { layers, on_ground: ground.dot(&top) }
    }
}

impl LayerModes<'_> {
    /// e (z + e)⁻¹ i: the current at the upper face that a current injected at the lower face causes.
    fn returned(&self, current: &DVector<f64>) -> DVector<f64> {
        let crossing = self.downwards.as_ref();
        crossing.map_or_else(|| current.clone(), |one| one.bridge.component_mul(&one.factor.solve(current)))
    }

    /// (z + e)⁻¹ i: S at the lower face that a current injected there causes, while S is 0 at the upper face.
    fn received(&self, current: &DVector<f64>) -> DVector<f64> {
        self.downwards.as_ref().map_or_else(|| DVector::zeros(current.len()), |one| one.factor.solve(current))
    }
}

impl AdjointLayer {
    /// Adds −λᵀ dA of a layer to the derivatives of its escape.
    fn add_to(&self, mut escape: Escape<Dual>, layer: &DifferentiatedLayer, plain: &LayerModes) -> Escape<Dual> {
        let LayerModes { medium: HomogeneousMedium { ice_index, modes, .. }, depth, .. } = plain;
        if let Some(index) = ice_index {
            for (j, light) in ice_lights(*index, modes.rates.len(), layer.depth).enumerate() {
                let [shunt, bridge] = light.elements();
                let through = bridge * (self.top[j] - self.bottom[j]);
                escape.top[j] += -shunt * self.top[j] - through;
                escape.bottom[j] += -shunt * self.bottom[j] + through;
            }
            return escape;
        }
        let Self { top, raised, bottom, top_current, bottom_current, source } = self;
        let [top_change, bottom_change] = [top, bottom].map(|vector| layer.modes.changed(vector));
        let [by_top, by_bottom] = [top_current, bottom_current].map(|vector| layer.modes.changed_transposed(vector));
        for (j, &k) in layer.modes.rates.iter().enumerate() {
            let shunt = k * (k * 0.5 * layer.depth).tanh();
            let d = shunt.value();
            let (mut at_top, mut at_slope) = (by_top[j] - shunt * raised[j], -top_change[j]);
            let mut at_bottom = by_bottom[j] - shunt * bottom[j] + bottom_change[j] * d;
            if k.value() * *depth < 1.0 {
                // Of the current e (φ_t − φ_b) = −φ'_t − D φ_t.
                let resistance = sinh_over_rate(k, layer.depth);
                let through = resistance * (d * bottom[j] - source[j] - bottom_current[j]);
                at_top += (bottom_change[j] - through) * d;
                at_slope += bottom_change[j] - through;
            } else {
                let bridge = rate_over_sinh(k, layer.depth);
                let through = bottom_change[j] * bridge.value() + bridge * (raised[j] - bottom[j]);
                at_top += -through;
                at_bottom += through;
            }
            escape.top[j] += at_top;
            escape.top_slope[j] += at_slope;
            escape.bottom[j] += at_bottom;
        }
        escape
    }
}

impl Escape<Dual> {
    /// The derivatives of the radiance of a layer with these amplitudes.
    fn change(&self, layer: &Profile) -> Dual {
        let terms = self.top.iter().zip(&layer.top).chain(self.top_slope.iter().zip(&layer.top_slope));
        let terms = terms.chain(self.bottom.iter().zip(&layer.bottom));
        terms.fold(Dual::from(0.0), |sum, (escape, amplitude)| sum + *escape * *amplitude)
    }
}

impl<T: Real> FaceEscapes<T> {
    /// The radiance that arrives at the top of the stack, where these fractions of the radiance from both faces
    /// arrive.
    fn seen(&self, [top, bottom]: [T; 2]) -> Escape<T> {
        let mut seen = self.top.times(top);
        if let Some(escape) = &self.bottom {
            let Escape { top, top_slope, bottom } = escape.times(bottom);
            seen.top += top;
            seen.top_slope += top_slope;
            seen.bottom += bottom;
        }
        seen
    }
}

impl<T: Real> Escape<T> {
    fn times(&self, factor: T) -> Self {
        let Self { top, top_slope, bottom } = self;
        let [top, top_slope, bottom] = [top, top_slope, bottom].map(|vector| vector.map(|number| number * factor));
        Self { top, top_slope, bottom }
    }
}

impl Sensitivity<'_> {
    /// The derivatives of the flux that is the radiance of an emission.
    pub(super) fn change(&self, emission: &Emission) -> FluxChange {
        let own: Vec<Dual> = self.escape.iter().zip(&emission.layers).map(|(one, layer)| one.change(layer)).collect();
        let mut whole = own.iter().fold(Dual::from(0.0), |sum, own| sum + *own);
        // The ground draws Δ − 4A/(1 + A) v vᵀ.
        whole += self.ground * (2.0 * self.adjoint.on_ground * emission.on_ground);
        let mut layers = own;
        if let Some(beam) = &self.beam {
            let Unscattered { down, up } = &beam.unscattered;
            let ([upper, lower], [upwards, downwards]) =
                (emission.emitter.faces(), emission.emitter.radiances(beam.cosine));
            whole += down[upper] * upwards + up[lower] * downwards;
            whole += down[layers.len()] * self.ground * emission.on_ground;
            let changes = beam.changes(emission, self.ground.value() * emission.on_ground);
            layers.iter_mut().zip(changes).for_each(|(layer, change)| *layer += change);
        }
        let derivatives = |number: &Dual| *number.derivatives();
        FluxChange { layers: layers.iter().map(derivatives).collect(), whole: derivatives(&whole) }
    }
}

impl BeamSensitivity<'_> {
    /// The change of the light that passes each layer unscattered, by the layer's own variables, where the ground
    /// emits the radiance `from_ground`.
    fn changes(&self, emission: &Emission, from_ground: f64) -> Vec<Dual> {
        let Beam { cosine, unscattered: Unscattered { down, up }, escapes, passed } = self.beam;
        let count = passed.len();
        let ([upper, lower], [upwards, downwards]) = (emission.emitter.faces(), emission.emitter.emitted(*cosine));
        let added: Vec<[f64; 2]> = escapes
            .iter()
            .zip(&emission.layers)
            .map(|(faces, layer)| {
                [faces.top.radiance(layer), faces.bottom.as_ref().map_or(0.0, |bottom| bottom.radiance(layer))]
            })
            .collect();
        // Just above each face the radiance downwards is r u + s, where u is the radiance upwards.
        let emitted_down = |face: usize| if face == lower { downwards } else { 0.0 };
        let emitted_up = |face: usize| if face == upper { upwards } else { 0.0 };
        let mut above = vec![[0.0, 0.0]];
        for (j, (&[reflected, transmitted], added)) in passed.iter().zip(&added).enumerate() {
            let [r, s] = below_face(above[j], emitted_up(j), emitted_down(j));
            let share = transmitted / (1.0 - reflected * r);
            let next = reflected + transmitted * share * r;
            above.push([next, share * (s + r * added[0]) + added[1]]);
        }
        let mut changes = vec![Dual::from(0.0); count];
        let mut upwards_below = from_ground;
        for j in (0..count).rev() {
            // Upwards at the lower face of the layer, and downwards at its upper face.
            upwards_below += emitted_up(j + 1);
            let [r, s] = below_face(above[j], emitted_up(j), emitted_down(j));
            let [reflected, transmitted] = passed[j];
            let upwards_above = (transmitted * upwards_below + reflected * s + added[j][0]) / (1.0 - reflected * r);
            let downwards_above = r * upwards_above + s;
            let [by_reflected, by_transmitted] = self.passed[j];
            if reflected > 0.0 {
                changes[j] = by_reflected * (down[j] * downwards_above + up[j + 1] * upwards_below)
                    + by_transmitted * (down[j] * upwards_below + up[j + 1] * downwards_above);
            } else {
                // Light that does not pass a half-space does not change either.
                let passing = down[j + 1] * upwards_below + up[j] * downwards_above;
                if passing.abs() > 0.0 {
                    changes[j] = by_transmitted * passing;
                }
            }
            upwards_below = upwards_above;
        }
        changes
    }
}

/// The relation of light downwards to light upwards just below an emitting face, from the relation just above the
/// face.
fn below_face([r, s]: [f64; 2], emitted_up: f64, emitted_down: f64) -> [f64; 2] {
    [r, s + r * emitted_up + emitted_down]
}
