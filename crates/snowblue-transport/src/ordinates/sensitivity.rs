//! Derivatives of the fluxes of layers by the adjoint equations: one further solution for each light serves every flux,
//! depth, layer and variable.
//!
//! **The network and its adjoint.** S at all faces solves A x = s, where A is symmetric and sums the conductances of
//! the layers, and s is what an emitting face injects, which no variable changes. A flux is cᵀ x, the radiance that
//! leaves the top, with c by the [`Escape`] of each layer. Of A λ = c follows
//!
//! ```text
//! d(cᵀ x) = dcᵀ x − λᵀ dA x
//! ```
//!
//! (Marchuk 1995, *Adjoint Equations and Analysis of Complex Systems*, ch. 1). By reciprocity λ is the light of the
//! beam itself. The sum of dA over layers is one of small terms in the modes of each: with the amplitudes φ of S at the
//! top t and the bottom b, D = k tanh(kτ/2), e = k/sinh(kτ), and c_s for the slope at the top, a layer adds
//!
//! ```text
//! −λᵀ dA x = −(λ_t + c_s)ᵀ dD φ_t − λ_bᵀ dD φ_b − (λ_t + c_s − λ_b)ᵀ de (φ_t − φ_b)
//!            + (Xλ_t)ᵀ i_t + (Xλ_b)ᵀ i_b + (i_t^λ)ᵀ X φ_t + (i_b^λ)ᵀ X φ_b,
//! ```
//!
//! where i are the currents into the layer, of x and of λ, and X is the change of its modes. Where a layer is thin,
//! e (φ_t − φ_b) follows from the current, and de from r = 1/e.
//!
//! **Everything is an escape.** All terms are linear in the amplitudes of a layer, as its radiance is. So the
//! derivative of a flux is a radiance as well, of an [`Escape`] with derivatives.

use nalgebra::DVector;

use super::differentiated::DifferentiatedModes;
use super::homogeneous::solver;
use super::integrals::{rate_over_sinh, sinh_over_rate};
use super::layered::{Emission, Escape, Layer, LayeredMedium, Profile, Response, cross, ground_radiance};
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
    /// Radiance of each layer at the top of the stack per amplitude of its modes, of a beam.
    unchanged: Option<Vec<Escape>>,
}

/// The derivatives of all fluxes under one light by some variables.
pub(super) struct Sensitivity<'a> {
    adjoint: &'a Adjoint,
    /// Of the radiance of each layer, in the light that arrives at its top.
    escape: Vec<Escape<Dual>>,
    beam: Option<BeamSensitivity<'a>>,
    /// Radiance of the ground per 1ᵀ M S on it.
    ground: Dual,
}

/// What changes of a beam that is not scattered.
struct BeamSensitivity<'a> {
    /// 1/μ, by the cosine.
    per_cosine: Dual,
    /// Unscattered fraction at each face, by the cosine.
    clear: Vec<Dual>,
    /// Relative change of the unscattered fraction below each layer.
    attenuation: Vec<Dual>,
    /// Radiance of each layer at the top of the stack per amplitude of its modes, for those below a layer.
    unchanged: &'a [Escape],
}

/// Whether an emission gives a flux through a face or the fluence rate there.
#[derive(Clone, Copy)]
pub(super) enum FaceQuantity {
    /// A flux downwards, upwards or both.
    Flux,
    /// The fluence rate, to which the beam itself belongs.
    Fluence,
}

/// The derivatives of a flux.
pub(super) struct FluxChange {
    /// By the variables of each layer.
    pub(super) layers: Vec<[f64; LANES]>,
    /// By those of the light and the ground.
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
    /// The derivatives under each of the lights, of which `adjoints` are the solutions, by `variables`, of which
    /// `layers` and `ground_albedo` have the numbers.
    pub(super) fn sensitivities<'a>(
        &self,
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
        (light, adjoint): (&Response, &'a Adjoint),
        layers: &[DifferentiatedLayer],
        ground: Dual,
        variables: &[Variable],
    ) -> Sensitivity<'a> {
        let beam = match light {
            Response::Lambertian => None,
            Response::Beam { cosine, .. } => {
                let per_cosine = Dual::from(1.0) / Variable::CosIncidence.number(*cosine, variables);
                let mut depth_above = 0.0;
                let mut clear_by_cosine = vec![Dual::from(1.0)];
                for layer in &self.layers {
                    depth_above += layer.depth;
                    clear_by_cosine.push((-per_cosine * depth_above).exp());
                }
                let unchanged = adjoint.unchanged.as_deref().unwrap_or_default();
                let attenuation = layers.iter().map(|layer| -layer.depth / *cosine).collect();
                Some(BeamSensitivity { per_cosine, clear: clear_by_cosine, attenuation, unchanged })
            }
        };
        let escapes = layers.iter().zip(&self.layers).zip(&adjoint.layers).enumerate();
        let escape = escapes.map(|(j, ((layer, plain), adjoint))| {
            let own = match &beam {
                Some(BeamSensitivity { per_cosine, clear, .. }) => {
                    let direction = layer.modes.direction(Dual::from(1.0) / *per_cosine);
                    Escape::new(&direction, &layer.modes.rates, layer.depth).times(clear[j])
                }
                None => Escape::zeros(plain.medium.modes.rates.len()),
            };
            adjoint.add_to(own, layer, plain.depth)
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
            Response::Beam { clear, escape, .. } => {
                let unchanged: Vec<Escape> =
                    escape.iter().zip(clear).map(|(escape, clear)| escape.times(*clear)).collect();
                Some((unchanged, clear[self.layers.len()]))
            }
        };
        let last = self.layers.len();
        let ground = &self.medium_at(last).entering[1];
        // What everything below a face injects there: its current is y λ less this.
        let mut injected = match &beam {
            Some((_, clear_at_ground)) => ground * (clear_at_ground * self.ground),
            None => DVector::zeros(ground.len()),
        };
        let mut below = vec![injected.clone()];
        let mut near = Vec::with_capacity(last);
        for (j, layer) in self.layers.iter().enumerate().rev() {
            if let Some(interface) = &layer.interface {
                injected = &interface.up * injected;
            }
            near.push(injected.clone());
            if let Some((unchanged, _)) = &beam {
                let escape = &unchanged[j];
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
            let escape = beam.as_ref().map(|(unchanged, _)| &unchanged[j]);
            let raised = escape.map_or_else(|| top.clone(), |escape| &top + &escape.top_slope);
            let source = escape.map_or_else(|| DVector::zeros(top.len()), |escape| escape.bottom.clone());
            let bottom = cross(layer.downwards.as_ref(), &raised) + layer.received(&(&source + &near[last - 1 - j]));
            let next = layer.interface.as_ref().map_or_else(|| bottom.clone(), |one| one.up.tr_mul(&bottom));
            let onwards = &self.lower[j + 1].conductance * &next - &below[last - 1 - j];
            let bottom_current = -layer.interface.as_ref().map_or_else(|| onwards.clone(), |one| &one.up * &onwards);
            layers.push(AdjointLayer { top, raised, bottom, top_current: current, bottom_current, source });
            (top, current) = (next, onwards);
        }
        Adjoint { layers, on_ground: ground.dot(&top), unchanged: beam.map(|(unchanged, _)| unchanged) }
    }
}

impl Layer<'_> {
    /// e (z + e)⁻¹ i: the current at the upper face of one that is injected at the lower face.
    fn returned(&self, current: &DVector<f64>) -> DVector<f64> {
        let crossing = self.downwards.as_ref();
        crossing.map_or_else(|| current.clone(), |one| one.bridge.component_mul(&one.factor.solve(current)))
    }

    /// (z + e)⁻¹ i: S at the lower face of a current that is injected there, while it is 0 at the upper face.
    fn received(&self, current: &DVector<f64>) -> DVector<f64> {
        self.downwards.as_ref().map_or_else(|| DVector::zeros(current.len()), |one| one.factor.solve(current))
    }
}

impl AdjointLayer {
    /// Adds −λᵀ dA of a layer of a scaled `depth` to the derivatives of its escape.
    fn add_to(&self, mut escape: Escape<Dual>, layer: &DifferentiatedLayer, depth: f64) -> Escape<Dual> {
        let Self { top, raised, bottom, top_current, bottom_current, source } = self;
        let [top_change, bottom_change] = [top, bottom].map(|vector| layer.modes.changed(vector));
        let [by_top, by_bottom] = [top_current, bottom_current].map(|vector| layer.modes.changed_transposed(vector));
        for (j, &k) in layer.modes.rates.iter().enumerate() {
            let shunt = k * (k * 0.5 * layer.depth).tanh();
            let d = shunt.value();
            let (mut at_top, mut at_slope) = (by_top[j] - shunt * raised[j], -top_change[j]);
            let mut at_bottom = by_bottom[j] - shunt * bottom[j] + bottom_change[j] * d;
            if k.value() * depth < 1.0 {
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

impl<T: Real> Escape<T> {
    fn zeros(modes: usize) -> Self {
        let zeros = || DVector::from_element(modes, T::from(0.0));
        Self { top: zeros(), top_slope: zeros(), bottom: zeros() }
    }

    fn times(&self, factor: T) -> Self {
        let Self { top, top_slope, bottom } = self;
        let [top, top_slope, bottom] = [top, top_slope, bottom].map(|vector| vector.map(|number| number * factor));
        Self { top, top_slope, bottom }
    }
}

impl Sensitivity<'_> {
    /// The derivatives of the flux that is the radiance of an emission.
    pub(super) fn change(&self, emission: &Emission, quantity: FaceQuantity) -> FluxChange {
        let own: Vec<Dual> = self.escape.iter().zip(&emission.layers).map(|(one, layer)| one.change(layer)).collect();
        let mut whole = own.iter().fold(Dual::from(0.0), |sum, own| sum + *own);
        // The ground draws Δ − 4A/(1 + A) v vᵀ.
        whole += self.ground * (2.0 * self.adjoint.on_ground * emission.on_ground);
        let mut layers = own;
        if let Some(BeamSensitivity { per_cosine, clear, attenuation, unchanged }) = &self.beam {
            let emitted = match quantity {
                FaceQuantity::Flux => Dual::from(emission.emitted),
                FaceQuantity::Fluence => *per_cosine,
            };
            let from_face = clear[emission.face] * emitted;
            let from_ground = clear[layers.len()] * self.ground * emission.on_ground;
            whole += from_face + from_ground;
            // Radiance that comes from below each layer.
            let mut beyond = from_ground.value();
            for j in (0..layers.len()).rev() {
                if j + 1 == emission.face {
                    beyond += from_face.value();
                }
                // Light that does not pass a half-space does not change either.
                if beyond.abs() > 0.0 {
                    layers[j] += attenuation[j] * beyond;
                }
                beyond += unchanged[j].radiance(&emission.layers[j]);
            }
        }
        let derivatives = |number: &Dual| *number.derivatives();
        FluxChange { layers: layers.iter().map(derivatives).collect(), whole: derivatives(&whole) }
    }
}
