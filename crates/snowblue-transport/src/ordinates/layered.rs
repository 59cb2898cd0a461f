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
//! radiance that leaves the top at μ₀ when the face emits isotropic unit radiance upwards; emission downwards gives the
//! upward flux, and both with opposite signs the net flux. Its amplitudes are, above and below the face,
//!
//! ```text
//! (y_lower + y_upper)⁻¹ (v + y_lower h)   and   (y_lower + y_upper)⁻¹ (v − y_upper h),   v = Vᵀ M 1, h = Hᵀ M 1,
//! ```
//!
//! for upward emission. The fluence rate belongs to a face that emits the radiance 1/μ to both sides, whose amplitudes
//! above and below are (y_lower + y_upper)⁻¹ 2 Vᵀ 1. The source function integrated along μ₀, layer by layer, is linear
//! in the amplitudes.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::homogeneous::{Direction, HomogeneousMedium, solver};
use super::integrals::{exponential_integrals, hyperbolic_integrals, rate_over_sinh};
use crate::dual::Real;
use crate::slab::Incidence;

/// Fluxes through a horizontal face over the flux that falls on the top, direct and diffuse.
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
    pub(super) layers: Vec<Layer<'m>>,
    /// Everything below each face, in the modes of the layer under it (on the ground, over it).
    pub(super) lower: Vec<Side>,
    /// Everything above each face, in the same modes.
    pub(super) upper: Vec<Side>,
    /// Radiance of the ground per 1ᵀ M S on it.
    pub(super) ground: f64,
    pub(super) lights: Vec<Response>,
}

/// One layer of the stack.
pub(super) struct Layer<'m> {
    pub(super) medium: &'m HomogeneousMedium,
    /// Scaled optical depth.
    pub(super) depth: f64,
    /// Takes S in the modes from the upper to the lower face; none where the layer is too thin to be one.
    pub(super) downwards: Option<Crossing>,
    /// Takes S in the modes from the lower to the upper face.
    upwards: Option<Crossing>,
    /// Change to the modes of the layer below; none if it has the same medium.
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
    /// V_aboveᵀ M H_below, the inverse of the other.
    pub(super) up: DMatrix<f64>,
}

/// Everything on one side of a face.
#[derive(Clone)]
pub(super) struct Side {
    /// y: the current that it draws from S.
    pub(super) conductance: DMatrix<f64>,
    /// v − y h: its reflection of isotropic light.
    returned: DVector<f64>,
}

/// The response of a stack to one incident light.
pub(super) enum Response {
    /// To a beam.
    Beam {
        cosine: f64,
        /// Unscattered fraction at each face.
        clear: Vec<f64>,
        /// Radiance that each layer adds, at its top.
        escape: Vec<Escape>,
    },
    /// To Lambertian light.
    Lambertian,
}

/// Radiance that leaves the top of a layer in one direction, per amplitude of each mode.
pub(super) struct Escape<T: Real = f64> {
    /// Per amplitude of S at the top.
    pub(super) top: DVector<T>,
    /// Per slope of the mode at the top.
    pub(super) top_slope: DVector<T>,
    /// Per amplitude of S at the bottom.
    pub(super) bottom: DVector<T>,
}

/// Amplitudes of the modes of one layer.
pub(super) struct Profile {
    pub(super) top: DVector<f64>,
    pub(super) top_slope: DVector<f64>,
    pub(super) bottom: DVector<f64>,
}

/// Light from an emitting face throughout the stack.
pub(super) struct Emission {
    pub(super) face: usize,
    pub(super) layers: Vec<Profile>,
    /// 1ᵀ M S on the ground.
    pub(super) on_ground: f64,
    /// Amplitudes at the top of the stack.
    top: DVector<f64>,
    /// Radiance that the face itself emits upwards.
    pub(super) emitted: f64,
}

/// The emissions whose radiance is each flux through a face.
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
        let mut layers: Vec<Layer<'m>> = layers
            .iter()
            .map(|MediumLayer { medium, optical_depth }| Layer {
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

    /// The fluxes through the face of some emissions under a light.
    pub(super) fn face_fluxes(&self, light: &Response, FaceEmissions { down, up, net }: &FaceEmissions) -> FaceFluxes {
        let [down, up, net] = [down, up, net].map(|emission| self.radiance(light, emission));
        FaceFluxes { down, up, net }
    }

    /// The emissions of a face for each flux.
    pub(super) fn emissions(&self, face: usize) -> FaceEmissions {
        let (lower, upper) = (&self.lower[face], &self.upper[face]);
        let [h, v] = &self.medium_at(face).entering;
        let nothing = DVector::zeros(v.len());
        let both = solver(&(&lower.conductance + &upper.conductance), &nothing);
        let (into_lower, into_upper) = (&lower.conductance * h, &upper.conductance * h);
        let emission = |above: DVector<f64>, below: DVector<f64>, emitted: f64| {
            self.emission(face, (both.solve(&above), both.solve(&below)), emitted)
        };
        FaceEmissions {
            down: emission(v + &into_lower, upper.returned.clone(), 1.0),
            up: emission(lower.returned.clone(), v + &into_upper, 0.0),
            net: emission(2.0 * into_lower, -2.0 * into_upper, 1.0),
        }
    }

    /// Fluence rate at a face, from all directions, over the flux that falls on the top, under each of the lights.
    ///
    /// # Panics
    /// If there is no such face.
    #[must_use]
    pub fn fluence_rates(&self, face: usize) -> Vec<f64> {
        let emission = self.fluence_emission(face);
        self.lights.iter().map(|light| self.fluence_rate(light, &emission)).collect()
    }

    /// The fluence rate at the face of an emission under a light.
    pub(super) fn fluence_rate(&self, light: &Response, emission: &Emission) -> f64 {
        self.radiance(light, emission) + light.unscattered_fluence(emission.face)
    }

    /// The emission of a face for the fluence rate.
    pub(super) fn fluence_emission(&self, face: usize) -> Emission {
        let injected = 2.0 * self.medium_at(face).isotropic_sums();
        let nothing = DVector::zeros(injected.len());
        let both = solver(&(&self.lower[face].conductance + &self.upper[face].conductance), &nothing);
        let amplitudes = both.solve(&injected);
        self.emission(face, (amplitudes.clone(), amplitudes), 0.0)
    }

    /// The medium in whose modes a face is described.
    pub(super) fn medium_at(&self, face: usize) -> &'m HomogeneousMedium {
        self.layers[face.min(self.layers.len() - 1)].medium
    }

    /// Extends the amplitudes just above and just below an emitting face over the stack.
    fn emission(&self, face: usize, (mut above, mut below): (DVector<f64>, DVector<f64>), emitted: f64) -> Emission {
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
        Emission { face, layers, on_ground, top: above, emitted }
    }

    /// Radiance of an emission that leaves the top in the direction of a light; for Lambertian light its mean, weighted
    /// with the cosine.
    pub(super) fn radiance(&self, light: &Response, emission: &Emission) -> f64 {
        match light {
            Response::Lambertian => 2.0 * self.layers[0].medium.entering[1].dot(&emission.top),
            Response::Beam { clear, escape, .. } => {
                let scattered = emission.layers.iter().zip(escape).zip(clear);
                scattered.map(|((layer, escape), clear)| clear * escape.radiance(layer)).sum::<f64>()
                    + clear[self.layers.len()] * (self.ground * emission.on_ground)
                    + clear[emission.face] * emission.emitted
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
fn lower_sides(layers: &mut [Layer], albedo: f64) -> Vec<Side> {
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
fn upper_sides(layers: &mut [Layer]) -> Vec<Side> {
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
fn beyond(layer: &Layer, side: Side) -> (Side, Option<Crossing>) {
    let (medium, depth) = (layer.medium, layer.depth);
    // Thinner layers underflow.
    if depth < 1e-100 {
        return (side, None);
    }
    let rates = DVector::from_column_slice(&medium.modes.rates);
    let shunt = rates.map(|k| k * (0.5 * k * depth).tanh());
    let bridge = rates.map(|k| rate_over_sinh(k, depth));
    let mut shunted = side.conductance;
    shunted.set_diagonal(&(shunted.diagonal() + &shunt));
    let factor = solver(&shunted, &bridge);
    let through = &shunted * factor.solve(&DMatrix::from_diagonal(&bridge));
    let mut conductance = 0.5 * (&through + through.transpose());
    conductance.set_diagonal(&(conductance.diagonal() + shunt));
    let [h, v] = &medium.entering;
    let returned = v - &conductance * h;
    (Side { conductance, returned }, Some(Crossing { factor, bridge }))
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
    fn new(layers: &[Layer], incidence: &Incidence) -> Self {
        let Incidence::Beam { angle_deg } = incidence else {
            return Self::Lambertian;
        };
        let cosine = angle_deg.to_radians().cos();
        let mut depth_above = 0.0;
        let mut clear = vec![1.0];
        for layer in layers {
            depth_above += layer.depth;
            clear.push((-depth_above / cosine).exp());
        }
        let escape =
            |layer: &Layer| Escape::new(&layer.medium.direction(cosine), &layer.medium.modes.rates, layer.depth);
        Self::Beam { cosine, clear, escape: layers.iter().map(escape).collect() }
    }

    /// Fluence rate at a face of the light that the layers above have not scattered; that of Lambertian light is in the
    /// amplitudes.
    fn unscattered_fluence(&self, face: usize) -> f64 {
        match self {
            Self::Beam { cosine, clear, .. } => clear[face] / cosine,
            Self::Lambertian => 0.0,
        }
    }
}

impl Escape {
    /// The radiance of a layer with these amplitudes.
    pub(super) fn radiance(&self, layer: &Profile) -> f64 {
        self.top.dot(&layer.top) + self.top_slope.dot(&layer.top_slope) + self.bottom.dot(&layer.bottom)
    }
}

impl<T: Real> Escape<T> {
    /// Radiance that leaves the top of a layer with cosine μ, ∫ J e^{−s/μ} ds/μ, per amplitude of each mode.
    ///
    /// Slow modes in thin layers are a cosh(ks) + a' sinh(ks)/k from the top; the others are a wave that decays from
    /// the top, (a − a'/k)/2, and one that decays from the bottom and makes up the rest of the amplitude there.
    pub(super) fn new(direction: &Direction<T>, rates: &[T], depth: T) -> Self {
        let per_cosine = T::from(1.0) / direction.cos_incidence;
        let unscattered = (-depth * per_cosine).exp();
        let zeros = || DVector::from_element(rates.len(), T::from(0.0));
        let mut escape = Self { top: zeros(), top_slope: zeros(), bottom: zeros() };
        for (j, &k) in rates.iter().enumerate() {
            let (even, odd) = (direction.even[j] * 0.5, direction.odd[j] * 0.5);
            if k.value() < 0.5 && k.value() * depth.value() < 1.0 {
                let (cosh, sinh_over_k) = hyperbolic_integrals(k, depth, per_cosine, unscattered);
                escape.top[j] = even * cosh + odd * k * k * sinh_over_k;
                escape.top_slope[j] = even * sinh_over_k + odd * cosh;
            } else {
                let (near, far) = exponential_integrals(k, depth, per_cosine);
                let growing = (even + odd * k) * far;
                let fading = ((even - odd * k) * near - growing * (-k * depth).exp()) * 0.5;
                escape.top[j] = fading;
                escape.top_slope[j] = -fading / k;
                escape.bottom[j] = growing;
            }
        }
        escape
    }
}
