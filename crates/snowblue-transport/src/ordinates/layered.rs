//! Fluxes at any face of a stack of homogeneous layers on a Lambertian ground.
//!
//! **A stack is equivalent to an electrical ladder network.** With S = I⁺ + I⁻ as the voltage and M D = M (I⁺ − I⁻) as
//! the current, everything beyond a face obeys M D = M H y Hᵀ M S, where the conductance y is a symmetric, positive
//! semidefinite matrix in the modes of the adjacent layer. From φ'' = k² φ a layer of depth τ is a shunt k tanh(kτ/2)
//! at each face and a resistor sinh(kτ)/k between them, so y' at its near face follows from y at its far face by sums
//! of positive terms:
//!
//! ```text
//! z = y + k tanh(kτ/2),     y' = k tanh(kτ/2) + z (z + e)⁻¹ e,     e = k/sinh(kτ),
//! ```
//!
//! and S in the modes crosses the layer by (z + e)⁻¹ e, a product that is accurate however small. This is the adding
//! method (van de Hulst 1980, *Multiple Light Scattering*, ch. 4) for (1 − R)/(1 + R) in place of R, because in snow
//! 1 − R is small and would lose precision as a difference. A face between two media changes y to Q y Qᵀ, Q = V'ᵀ M H.
//!
//! **One source per flux serves all angles.** By reciprocity the downward flux at a face under a beam at μ₀ is the
//! radiance that leaves the top at μ₀ when the face emits isotropic unit radiance upwards. Emission downwards gives
//! the upward flux, and emission to both sides with opposite signs gives the net flux. The amplitudes of S are, above
//! and below the face,
//!
//! ```text
//! (y_lower + y_upper)⁻¹ (v + y_lower h)   and   (y_lower + y_upper)⁻¹ (v − y_upper h),   v = Vᵀ M 1, h = Hᵀ M 1,
//! ```
//!
//! for upward emission. The fluence rate belongs to a face that emits the radiance 1/μ to both sides, whose amplitudes
//! above and below are (y_lower + y_upper)⁻¹ 2 Vᵀ 1. The source function integrated along μ₀, layer by layer, is linear
//! in the amplitudes.
//!
//! **Ice.** A slab of clear ice is a further element of the ladder, diagonal in the ordinates ([`IceLight`]). Seen
//! from the top along μ₀, it shows light from below by its transmittance, and light from above, in the direction −μ₀,
//! by its reflectance. So the line of sight goes down and up, and weights of both directions at each face replace
//! e^{−τ/μ₀}. A plane within the ice emits through both faces of the ice. The unscattered beam is exact at any angle.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::escape::{FaceEscapes, Profile};
use super::homogeneous::{HomogeneousMedium, solver};
use super::ice_slab::{FaceQuantity, IceLight, Unscattered, ice_lights, unscattered};
use super::integrals::rate_over_sinh;
use crate::dual::{Dual, LANES, Real};
use crate::quadrature::Quadrature;
use crate::slab::Incidence;

/// Fluxes through a horizontal face over the flux that falls on the top, direct and diffuse; outside ice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaceFluxes {
    /// Flux downwards.
    pub down: f64,
    /// Flux upwards.
    pub up: f64,
    /// Net flux, downwards less upwards; computed separately, so it is accurate where it is small.
    pub net: f64,
}

/// A layer of a homogeneous medium.
#[derive(Clone, Copy)]
pub struct MediumLayer<'m> {
    /// The solved medium.
    pub medium: &'m HomogeneousMedium,
    /// Optical depth, without δ-M scaling.
    pub optical_depth: f64,
}

/// Homogeneous layers over a Lambertian ground, solved for all faces and some lights.
///
/// Faces are counted from the top, 0, to the ground, the number of layers.
pub struct LayeredMedium<'m> {
    pub(super) layers: Vec<LayerModes<'m>>,
    /// Everything below each face, in the modes of the layer under the face (at the ground, of the layer above).
    pub(super) lower: Vec<Side>,
    /// Everything above each face, in the modes of `lower`.
    pub(super) upper: Vec<Side>,
    /// Radiance of the ground per 1ᵀ M S on it.
    pub(super) ground: f64,
    pub(super) lights: Vec<Response>,
}

/// One layer of the stack.
pub(super) struct LayerModes<'m> {
    pub(super) medium: &'m HomogeneousMedium,
    /// Scaled optical depth.
    pub(super) depth: f64,
    /// Takes S in the modes from the upper to the lower face; none where the layer is too thin to count.
    pub(super) downwards: Option<Crossing>,
    /// Takes S in the modes from the lower to the upper face.
    upwards: Option<Crossing>,
    /// Change to the modes of the layer below; none if both layers share one medium.
    pub(super) interface: Option<Interface>,
}

/// a ↦ (z + e)⁻¹ e a.
pub(super) struct Crossing {
    pub(super) factor: Cholesky<f64, Dyn>,
    pub(super) bridge: DVector<f64>,
}

/// The change of modes at a face between two media.
pub(super) struct Interface {
    /// V_belowᵀ M H_above.
    down: DMatrix<f64>,
    /// V_aboveᵀ M H_below, the inverse of `down`.
    pub(super) up: DMatrix<f64>,
}

/// Everything on one side of a face.
#[derive(Clone)]
pub(super) struct Side {
    /// y: the current that this side draws from S.
    pub(super) conductance: DMatrix<f64>,
    /// v − y h: the reflection of isotropic light by this side.
    returned: DVector<f64>,
}

/// The response of a stack to one incident light.
pub(super) enum Response {
    /// To a beam.
    Beam(Beam),
    /// To Lambertian light.
    Lambertian,
}

/// The response to a beam.
pub(super) struct Beam {
    pub(super) cosine: f64,
    pub(super) unscattered: Unscattered<f64>,
    /// Fractions that each layer reflects and transmits unscattered.
    pub(super) passed: Vec<[f64; 2]>,
    /// Radiance that each layer adds, at its faces.
    pub(super) escapes: Vec<FaceEscapes>,
}

/// Light from an emitting plane throughout the stack.
pub(super) struct Emission {
    pub(super) emitter: Emitter,
    pub(super) layers: Vec<Profile>,
    /// 1ᵀ M S on the ground.
    pub(super) on_ground: f64,
    /// Amplitudes at the top of the stack.
    top: DVector<f64>,
}

/// A plane that emits such light that the radiance that leaves the top is the value of a quantity at the plane.
#[derive(Clone, Copy)]
pub(super) enum Emitter {
    /// A face.
    Face(usize, FaceQuantity),
    /// A plane within a layer of ice.
    Ice(IcePlane, FaceQuantity),
}

/// A plane within a layer of ice.
#[derive(Clone, Copy)]
pub(super) struct IcePlane {
    /// The number of the layer.
    pub(super) layer: usize,
    pub(super) index: f64,
    /// Optical depths of the ice above and below the plane.
    pub(super) depths: [f64; 2],
    /// Changes of these depths; the plane then emits the change of the radiance.
    pub(super) changes: Option<[f64; 2]>,
}

/// The emissions whose radiance is each flux through a plane.
pub(super) struct FaceEmissions {
    pub(super) down: Emission,
    pub(super) up: Emission,
    pub(super) net: Emission,
}

impl<'m> LayeredMedium<'m> {
    /// Solves `layers`, top first, on a ground of the given albedo, under each of `incidences`.
    ///
    /// # Panics
    /// If there is no layer or the media differ in their number of streams.
    #[must_use]
    pub fn new(layers: &[MediumLayer<'m>], ground_albedo: f64, incidences: &[Incidence]) -> Self {
        let mut layers: Vec<LayerModes<'m>> = layers
            .iter()
            .map(|MediumLayer { medium, optical_depth }| LayerModes {
                medium,
                depth: optical_depth * medium.scaled.depth_ratio,
                downwards: None,
                upwards: None,
                interface: None,
            })
            .collect();
        for j in 1..layers.len() {
            layers[j - 1].interface = Interface::between(layers[j - 1].medium, layers[j].medium);
        }
        let lower = lower_sides(&mut layers, ground_albedo);
        let upper = upper_sides(&mut layers);
        let lights = incidences.iter().map(|incidence| Response::new(&layers, incidence)).collect();
        Self { lower, upper, ground: ground_radiance(ground_albedo), lights, layers }
    }

    /// Fluxes through a face under each of the lights.
    ///
    /// # Panics
    /// If there is no such face.
    #[must_use]
    pub fn fluxes(&self, face: usize) -> Vec<FaceFluxes> {
        let emissions = self.emissions(face);
        self.lights.iter().map(|light| self.face_fluxes(light, &emissions)).collect()
    }

    /// The fluxes of some emissions under a light.
    pub(super) fn face_fluxes(&self, light: &Response, FaceEmissions { down, up, net }: &FaceEmissions) -> FaceFluxes {
        let [down, up, net] = [down, up, net].map(|emission| self.radiance(light, emission));
        FaceFluxes { down, up, net }
    }

    /// The emissions of a face for each flux.
    pub(super) fn emissions(&self, face: usize) -> FaceEmissions {
        let (lower, upper) = (&self.lower[face], &self.upper[face]);
        let [h, v] = &self.medium_at(face).entering;
        let both = self.solver_at(face);
        let (into_lower, into_upper) = (&lower.conductance * h, &upper.conductance * h);
        let emission = |above: DVector<f64>, below: DVector<f64>, quantity: FaceQuantity| {
            self.emission(face, (both.solve(&above), both.solve(&below)), Emitter::Face(face, quantity))
        };
        FaceEmissions {
            down: emission(v + &into_lower, upper.returned.clone(), FaceQuantity::Down),
            up: emission(lower.returned.clone(), v + &into_upper, FaceQuantity::Up),
            net: emission(2.0 * into_lower, -2.0 * into_upper, FaceQuantity::Net),
        }
    }

    /// Fluence rate at a face, from all directions, over the flux that falls on the top, under each of the lights.
    ///
    /// # Panics
    /// If there is no such face.
    #[must_use]
    pub fn fluence_rates(&self, face: usize) -> Vec<f64> {
        let emission = self.fluence_emission(face);
        self.lights.iter().map(|light| self.radiance(light, &emission)).collect()
    }

    /// The emission of a face for the fluence rate.
    pub(super) fn fluence_emission(&self, face: usize) -> Emission {
        let injected = 2.0 * self.medium_at(face).isotropic_sums();
        let amplitudes = self.solver_at(face).solve(&injected);
        self.emission(face, (amplitudes.clone(), amplitudes), Emitter::Face(face, FaceQuantity::Fluence))
    }

    /// The emissions of a plane within ice for each flux.
    pub(super) fn ice_emissions(&self, plane: IcePlane) -> FaceEmissions {
        let of = |quantity: FaceQuantity| self.ice_emission(plane, quantity);
        FaceEmissions { down: of(FaceQuantity::Down), up: of(FaceQuantity::Up), net: of(FaceQuantity::Net) }
    }

    /// The emission of a plane within ice for one quantity: the sum of the emissions of both faces of the ice.
    pub(super) fn ice_emission(&self, plane: IcePlane, quantity: FaceQuantity) -> Emission {
        let emitter = Emitter::Ice(plane, quantity);
        let rule = Quadrature::half_range(self.layers[0].medium.modes.rates.len());
        let emitted: Vec<[f64; 2]> = rule.cosines.iter().map(|mu| emitter.emitted(*mu)).collect();
        let from_face = |side: usize| {
            let face = emitter.faces()[side];
            let medium = self.medium_at(face);
            let radiances = emitted.iter().zip(&rule.weights).map(|(radiance, weight)| radiance[side] * weight.sqrt());
            let radiances = DVector::from_iterator(rule.order(), radiances);
            let fluxes =
                DVector::from_iterator(rule.order(), radiances.iter().zip(&rule.cosines).map(|(i, mu)| i * mu));
            let h = medium.weighted_differences.tr_mul(&radiances) * if side == 0 { 1.0 } else { -1.0 };
            let (v, both) = (medium.modes.sums.tr_mul(&fluxes), self.solver_at(face));
            let above = both.solve(&(&v + &self.lower[face].conductance * &h));
            let below = both.solve(&(v - &self.upper[face].conductance * h));
            self.emission(face, (above, below), emitter)
        };
        from_face(0).plus(&from_face(1))
    }

    /// Factors of y_lower + y_upper at a face.
    fn solver_at(&self, face: usize) -> Cholesky<f64, Dyn> {
        let (lower, upper) = (&self.lower[face].conductance, &self.upper[face].conductance);
        solver(&(lower + upper), &DVector::zeros(lower.nrows()))
    }

    /// The medium in whose modes a face is described.
    pub(super) fn medium_at(&self, face: usize) -> &'m HomogeneousMedium {
        self.layers[face.min(self.layers.len() - 1)].medium
    }

    /// Extends the amplitudes just above and just below an emitting face over the stack.
    fn emission(
        &self,
        face: usize,
        (mut above, mut below): (DVector<f64>, DVector<f64>),
        emitter: Emitter,
    ) -> Emission {
        let mut layers = Vec::with_capacity(self.layers.len());
        for (j, layer) in self.layers.iter().enumerate().take(face).rev() {
            if let Some(interface) = &layer.interface {
                above = interface.down.tr_mul(&above);
            }
            let top = cross(layer.upwards.as_ref(), &above);
            let top_slope = &self.upper[j].conductance * &top;
            layers.push(Profile { top_slope, bottom: above, top: top.clone() });
            above = top;
        }
        layers.reverse();
        for (layer, side) in self.layers.iter().zip(&self.lower).skip(face) {
            let bottom = cross(layer.downwards.as_ref(), &below);
            let next =
                layer.interface.as_ref().map_or_else(|| bottom.clone(), |interface| interface.up.tr_mul(&bottom));
            layers.push(Profile { top_slope: -(&side.conductance * &below), top: below, bottom });
            below = next;
        }
        let on_ground = self.medium_at(self.layers.len()).entering[1].dot(&below);
        Emission { emitter, layers, on_ground, top: above }
    }

    /// Radiance of an emission that leaves the top in the direction of a light; for Lambertian light its mean, weighted
    /// with the cosine.
    pub(super) fn radiance(&self, light: &Response, emission: &Emission) -> f64 {
        match light {
            Response::Lambertian => 2.0 * self.layers[0].medium.entering[1].dot(&emission.top),
            Response::Beam(Beam { cosine, unscattered: Unscattered { down, up }, escapes, .. }) => {
                let scattered = emission.layers.iter().zip(escapes).enumerate().map(|(j, (layer, escape))| {
                    let from_bottom = escape.bottom.as_ref().map_or(0.0, |bottom| up[j + 1] * bottom.radiance(layer));
                    down[j] * escape.top.radiance(layer) + from_bottom
                });
                let [upper, lower] = emission.emitter.faces();
                let [upwards, downwards] = emission.emitter.emitted(*cosine);
                scattered.sum::<f64>()
                    + down[self.layers.len()] * (self.ground * emission.on_ground)
                    + down[upper] * upwards
                    + up[lower] * downwards
            }
        }
    }
}

impl Emission {
    /// The sum of both emissions.
    fn plus(mut self, other: &Self) -> Self {
        for (own, other) in self.layers.iter_mut().zip(&other.layers) {
            own.top += &other.top;
            own.top_slope += &other.top_slope;
            own.bottom += &other.bottom;
        }
        self.top += &other.top;
        self.on_ground += other.on_ground;
        self
    }
}

impl Emitter {
    /// The faces through which radiance leaves upwards and downwards.
    pub(super) fn faces(&self) -> [usize; 2] {
        match self {
            Self::Face(face, _) => [*face; 2],
            Self::Ice(IcePlane { layer, .. }, _) => [*layer, layer + 1],
        }
    }

    /// The radiance emitted through these faces, upwards and downwards, in one direction.
    pub(super) fn emitted(&self, cosine: f64) -> [f64; 2] {
        match self {
            Self::Ice(plane @ IcePlane { changes: Some(changes), .. }, quantity) => {
                let depth = |side: usize| Dual::new(plane.depths[side], [changes[side]; LANES]);
                let light = IceLight::new(plane.index, Dual::from(cosine), [depth(0), depth(1)]);
                light.leaving(*quantity).map(|radiance| radiance.derivatives()[0])
            }
            _ => self.radiances(cosine),
        }
    }

    /// The radiance as [`emitted`](Self::emitted), for an emitter without changes of depths.
    pub(super) fn radiances<T: Real>(&self, cosine: T) -> [T; 2] {
        match self {
            Self::Face(_, quantity) => quantity.emitted(cosine),
            Self::Ice(IcePlane { index, depths, .. }, quantity) => {
                IceLight::new(*index, cosine, depths.map(T::from)).leaving(*quantity)
            }
        }
    }
}

pub(super) fn cross(crossing: Option<&Crossing>, amplitudes: &DVector<f64>) -> DVector<f64> {
    crossing.map_or_else(
        || amplitudes.clone(),
        |crossing| crossing.factor.solve(&crossing.bridge.component_mul(amplitudes)),
    )
}

/// Radiance of a ground of an albedo A per 1ᵀ M S on it, 2A/(1 + A).
pub(super) fn ground_radiance<T: Real>(albedo: T) -> T {
    albedo * 2.0 / (albedo + 1.0)
}

/// The sides below each face, computed from the ground up; sets `downwards` of each layer.
///
/// The ground's y is Δ − 4A/(1 + A) v vᵀ, since it reflects 2A 1 1ᵀ M I⁺.
fn lower_sides(layers: &mut [LayerModes], albedo: f64) -> Vec<Side> {
    let bottom = layers[layers.len() - 1].medium;
    let [_, v] = &bottom.entering;
    let mut conductance = bottom.delta.clone();
    let ground = ground_radiance(albedo);
    conductance.ger(-2.0 * ground, v, v, 1.0);
    let mut sides = vec![Side { conductance, returned: v * ground }];
    for layer in layers.iter_mut().rev() {
        let below = &sides[sides.len() - 1];
        let near = layer.interface.as_ref().map_or_else(|| below.clone(), |interface| below.changed(&interface.up));
        let (side, crossing) = beyond(layer, near);
        layer.downwards = crossing;
        sides.push(side);
    }
    sides.reverse();
    sides
}

/// The sides above each face, computed from the open sky (y = Δ) down; sets `upwards` of each layer.
fn upper_sides(layers: &mut [LayerModes]) -> Vec<Side> {
    let top = layers[0].medium;
    let mut sides = vec![Side { conductance: top.delta.clone(), returned: DVector::zeros(top.delta.nrows()) }];
    for layer in layers.iter_mut() {
        let (side, crossing) = beyond(layer, sides[sides.len() - 1].clone());
        layer.upwards = crossing;
        sides.push(layer.interface.as_ref().map_or_else(|| side.clone(), |interface| side.changed(&interface.down)));
    }
    sides
}

/// Takes a side across a layer, with the operator that takes amplitudes back towards it.
fn beyond(layer: &LayerModes, side: Side) -> (Side, Option<Crossing>) {
    let Some([shunt, bridge]) = layer.elements() else {
        return (side, None);
    };
    let mut shunted = side.conductance;
    shunted.set_diagonal(&(shunted.diagonal() + &shunt));
    let factor = solver(&shunted, &bridge);
    let through = &shunted * factor.solve(&DMatrix::from_diagonal(&bridge));
    let mut conductance = 0.5 * (&through + through.transpose());
    conductance.set_diagonal(&(conductance.diagonal() + shunt));
    let [h, v] = &layer.medium.entering;
    let returned = v - &conductance * h;
    (Side { conductance, returned }, Some(Crossing { factor, bridge }))
}

impl LayerModes<'_> {
    /// The shunt at each face and the bridge between them; none where snow is too thin to be a layer.
    fn elements(&self) -> Option<[DVector<f64>; 2]> {
        let Self { medium, depth, .. } = self;
        if let Some(index) = medium.ice_index {
            let elements: Vec<[f64; 2]> = ice_lights(index, medium.modes.rates.len(), *depth)
                .map(|light: IceLight<f64>| light.elements())
                .collect();
            return Some([0, 1].map(|i| DVector::from_iterator(elements.len(), elements.iter().map(|both| both[i]))));
        }
        // Thinner layers underflow.
        if *depth < 1e-100 {
            return None;
        }
        let rates = DVector::from_column_slice(&medium.modes.rates);
        Some([rates.map(|k| k * (0.5 * k * depth).tanh()), rates.map(|k| rate_over_sinh(k, *depth))])
    }

    /// Fractions of the unscattered light in one direction that the layer reflects and transmits.
    pub(super) fn unscattered<T: Real>(&self, cosine: T) -> [T; 2] {
        unscattered(self.medium.ice_index, T::from(self.depth), cosine)
    }
}

impl Interface {
    fn between(above: &HomogeneousMedium, below: &HomogeneousMedium) -> Option<Self> {
        let overlap = |sums: &HomogeneousMedium, differences: &HomogeneousMedium| {
            sums.modes.sums.tr_mul(&differences.weighted_differences)
        };
        (!std::ptr::eq(above, below)).then(|| Self { down: overlap(below, above), up: overlap(above, below) })
    }
}

impl Side {
    /// The side in the modes of another medium, with the change of modes Q.
    fn changed(&self, q: &DMatrix<f64>) -> Self {
        Self { conductance: q * &self.conductance * q.transpose(), returned: q * &self.returned }
    }
}

impl Response {
    fn new(layers: &[LayerModes], incidence: &Incidence) -> Self {
        let Incidence::Beam { angle_deg } = incidence else {
            return Self::Lambertian;
        };
        let cosine = angle_deg.to_radians().cos();
        let passed: Vec<[f64; 2]> = layers.iter().map(|layer| layer.unscattered(cosine)).collect();
        let unscattered = Unscattered::new(&passed);
        let escapes = layers.iter().zip(&unscattered.up[1..]).map(|(layer, up)| {
            let direction = layer.medium.direction(cosine);
            FaceEscapes::new(&direction, &layer.medium.modes.rates, (layer.depth, *up > 0.0))
        });
        Self::Beam(Beam { cosine, escapes: escapes.collect(), unscattered, passed })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::HenyeyGreenstein;

    const STREAMS: usize = 16;
    const LIGHTS: [Incidence; 4] = [
        Incidence::Beam { angle_deg: 0.0 },
        Incidence::Beam { angle_deg: 53.0 },
        Incidence::Beam { angle_deg: 89.0 },
        Incidence::Diffuse,
    ];

    /// Where neither snow nor ice absorbs, the net flux is equal at every face and within the ice, and the light that
    /// is not reflected reaches the ground.
    #[test]
    fn net_flux_is_constant_where_ice_does_not_absorb() {
        let scattering = HenyeyGreenstein { one_minus_albedo: 0.0, asymmetry: 0.7 }.scattering(STREAMS);
        let (snow, ice) = (HomogeneousMedium::new(&scattering, STREAMS), HomogeneousMedium::ice(1.31, STREAMS));
        let layers = [(&ice, 0.0), (&snow, 0.3), (&ice, 0.0), (&snow, 0.0), (&ice, 0.0), (&snow, 40.0), (&ice, 0.0)];
        let layers = layers.map(|(medium, optical_depth)| MediumLayer { medium, optical_depth });
        for albedo in [0.0, 0.7, 1.0] {
            let layered = LayeredMedium::new(&layers, albedo, &LIGHTS);
            let reflected = layered.fluxes(0);
            let arriving = layered.fluxes(layers.len());
            let plane = IcePlane { layer: 2, index: 1.31, depths: [0.0; 2], changes: None };
            let within = layered.ice_emissions(plane);
            for (number, light) in layered.lights.iter().enumerate() {
                let (top, ground) = (reflected[number], arriving[number]);
                let net = (1.0 - albedo) * ground.down;
                // Thousands of reflections of light near 1, each with its rounding.
                assert!((1.0 - top.up - net).abs() < 1e-11, "{albedo} {number}: {top:?} {ground:?}");
                let faces = (0..=layers.len()).map(|face| layered.fluxes(face)[number]);
                for at in faces.chain([layered.face_fluxes(light, &within)]) {
                    assert!((at.net - net).abs() < 1e-11, "{albedo} {number}: {at:?} {net}");
                    assert!((at.down - at.up - net).abs() < 1e-11, "{albedo} {number}: {at:?} {net}");
                }
            }
        }
    }

    /// By reciprocity light passes a stack with ice equally in both directions, under Lambertian light; under a beam
    /// the scattered light does not, but a beam through clear layers does.
    #[test]
    fn a_beam_passes_clear_layers_in_both_directions() {
        let black = HenyeyGreenstein { one_minus_albedo: 1.0, asymmetry: 0.0 }.scattering(STREAMS);
        let (air, ice) = (HomogeneousMedium::new(&black, STREAMS), HomogeneousMedium::ice(1.31, STREAMS));
        let layers = [(&ice, 0.2), (&air, 0.3), (&ice, 0.5), (&air, 0.1), (&ice, 0.05)];
        let layers = layers.map(|(medium, optical_depth)| MediumLayer { medium, optical_depth });
        let reversed: Vec<MediumLayer> = layers.iter().rev().copied().collect();
        let [down, up] = [&layers[..], &reversed].map(|layers| LayeredMedium::new(layers, 0.0, &LIGHTS).fluxes(5));
        for (number, (down, up)) in down.iter().zip(&up).enumerate() {
            assert!((down.down / up.down - 1.0).abs() < 1e-13, "{number}: {down:?} {up:?}");
        }
    }
}
