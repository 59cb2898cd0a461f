//! Fluxes at any face of a pile of homogeneous layers over a Lambertian ground.
//!
//! **A pile is a ladder of conductors.** With S = I⁺ + I⁻ as the voltage and M D = M (I⁺ − I⁻) as the current, all that
//! lies beyond a face answers with M D = M H y Hᵀ M S, where y is a symmetric, positive semidefinite matrix in the
//! modes of the layer at hand. From φ'' = k² φ a layer of depth τ is a shunt k tanh(kτ/2) at each face and a resistor
//! sinh(kτ)/k between them, so that the answer y' at its near face follows from y at its far face by sums alone:
//!
//! ```text
//! z = y + k tanh(kτ/2),     y' = k tanh(kτ/2) + z (z + e)⁻¹ e,     e = k/sinh(kτ),
//! ```
//!
//! and S in the modes crosses the layer by (z + e)⁻¹ e: a product, however small. This is the adding method (van de
//! Hulst 1980, *Multiple Light Scattering*, ch. 4) written for (1 − R)/(1 + R) in place of R, since in snow 1 − R is a
//! small number that must not come as a difference. A face between two media changes y by Q y Qᵀ with Q = V'ᵀ M H.
//!
//! **One source for each flux serves all angles.** By reciprocity the downward flux at a face under a beam at μ₀ is the
//! radiance that leaves the top at μ₀ when the face emits isotropic unit radiance upwards; emission downwards gives the
//! upward flux, and both with opposite signs the net flux. Its amplitudes are, above and below the face,
//!
//! ```text
//! (y_lower + y_upper)⁻¹ (v + y_lower h)   and   (y_lower + y_upper)⁻¹ (v − y_upper h),   v = Vᵀ M 1, h = Hᵀ M 1,
//! ```
//!
//! for upward emission. The source function integrated along μ₀, layer by layer, is linear in the amplitudes.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::homogeneous::{HomogeneousMedium, solver};
use super::integrals::{exponential_integrals, hyperbolic_integrals, rate_over_sinh};
use crate::slab::Incidence;

/// Fluxes through a horizontal face over the flux that falls on the top, direct and diffuse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaceFluxes {
    /// Flux downwards.
    pub down: f64,
    /// Flux upwards.
    pub up: f64,
    /// What goes down for good: the one less the other, found on its own so that it is exact where it is small.
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
    layers: Vec<Layer<'m>>,
    /// What lies below each face, in the modes of the layer under it (on the ground, over it).
    lower: Vec<Side>,
    /// What lies above each face, in the same modes.
    upper: Vec<Side>,
    /// Radiance of the ground per 1ᵀ M S on it.
    ground: f64,
    lights: Vec<Sight>,
}

/// One layer of the pile.
struct Layer<'m> {
    medium: &'m HomogeneousMedium,
    /// Scaled optical depth.
    depth: f64,
    /// S in the modes from the upper to the lower face and back; none where the layer is too thin to be one.
    downwards: Option<Passage>,
    upwards: Option<Passage>,
    /// To the modes of the layer below: Q for what lies above and for what lies below; none if the medium stays.
    seam: Option<Seam>,
}

/// a ↦ (z + e)⁻¹ e a.
struct Passage {
    factor: Cholesky<f64, Dyn>,
    bridge: DVector<f64>,
}

/// The change of modes at a face between two media.
struct Seam {
    /// V_belowᵀ M H_above.
    down: DMatrix<f64>,
    /// V_aboveᵀ M H_below, the inverse of the other.
    up: DMatrix<f64>,
}

/// All that lies to one side of a face.
#[derive(Clone)]
struct Side {
    /// y: what current it draws from S.
    conductance: DMatrix<f64>,
    /// v − y h: what it sends back of isotropic light.
    returned: DVector<f64>,
}

/// How a pile looks from outside in the direction of a light.
enum Sight {
    /// Along a beam.
    Beam {
        /// Unscattered share at each face.
        clear: Vec<f64>,
        /// For each layer the radiance that it adds per amplitude of S on top, slope there, and amplitude below.
        escape: Vec<[DVector<f64>; 3]>,
    },
    /// From everywhere.
    Lambertian,
}

/// Amplitudes of the modes of one layer.
struct Profile {
    top: DVector<f64>,
    top_slope: DVector<f64>,
    bottom: DVector<f64>,
}

/// Light from an emitting face throughout the pile.
struct Glow {
    layers: Vec<Profile>,
    /// Radiance of the ground.
    ground: f64,
    /// Amplitudes at the top of the pile.
    top: DVector<f64>,
    /// Radiance that the face itself sends upwards.
    emitted: f64,
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
                seam: None,
            })
            .collect();
        for j in 1..layers.len() {
            layers[j - 1].seam = Seam::between(layers[j - 1].medium, layers[j].medium);
        }
        let lower = lower_sides(&mut layers, ground_albedo);
        let upper = upper_sides(&mut layers);
        let lights = incidences.iter().map(|incidence| Sight::new(&layers, incidence)).collect();
        Self { lower, upper, ground: 2.0 * ground_albedo / (1.0 + ground_albedo), lights, layers }
    }

    /// Fluxes through a face under each of the lights.
    ///
    /// # Panics
    /// If there is no such face.
    #[must_use]
    pub fn fluxes(&self, face: usize) -> Vec<FaceFluxes> {
        let (lower, upper) = (&self.lower[face], &self.upper[face]);
        let [h, v] = &self.medium_at(face).entering;
        let nothing = DVector::zeros(v.len());
        let both = solver(&(&lower.conductance + &upper.conductance), &nothing);
        let (into_lower, into_upper) = (&lower.conductance * h, &upper.conductance * h);
        let glow = |above: DVector<f64>, below: DVector<f64>, emitted: f64| {
            self.glow(face, (both.solve(&above), both.solve(&below)), emitted)
        };
        let for_down = glow(v + &into_lower, upper.returned.clone(), 1.0);
        let for_up = glow(lower.returned.clone(), v + &into_upper, 0.0);
        let for_net = glow(2.0 * into_lower, -2.0 * into_upper, 1.0);
        let under = |light: &Sight| FaceFluxes {
            down: self.seen(light, &for_down, face),
            up: self.seen(light, &for_up, face),
            net: self.seen(light, &for_net, face),
        };
        self.lights.iter().map(under).collect()
    }

    /// The medium in whose modes a face is described.
    fn medium_at(&self, face: usize) -> &'m HomogeneousMedium {
        self.layers[face.min(self.layers.len() - 1)].medium
    }

    /// Spreads the amplitudes just above and just below an emitting face over the pile.
    fn glow(&self, face: usize, (mut above, mut below): (DVector<f64>, DVector<f64>), emitted: f64) -> Glow {
        let mut layers = Vec::with_capacity(self.layers.len());
        for (j, layer) in self.layers.iter().enumerate().take(face).rev() {
            if let Some(seam) = &layer.seam {
                above = seam.down.tr_mul(&above);
            }
            let top = cross(layer.upwards.as_ref(), &above);
            let top_slope = &self.upper[j].conductance * &top;
            layers.push(Profile { top_slope, bottom: above, top: top.clone() });
            above = top;
        }
        layers.reverse();
        for (layer, side) in self.layers.iter().zip(&self.lower).skip(face) {
            let bottom = cross(layer.downwards.as_ref(), &below);
            let next = layer.seam.as_ref().map_or_else(|| bottom.clone(), |seam| seam.up.tr_mul(&bottom));
            layers.push(Profile { top_slope: -(&side.conductance * &below), top: below, bottom });
            below = next;
        }
        let ground = self.ground * self.medium_at(self.layers.len()).entering[1].dot(&below);
        Glow { layers, ground, top: above, emitted }
    }

    /// Radiance of a glow that leaves the top towards a light; for Lambertian light its mean, weighted with the cosine.
    fn seen(&self, light: &Sight, glow: &Glow, face: usize) -> f64 {
        match light {
            Sight::Lambertian => 2.0 * self.layers[0].medium.entering[1].dot(&glow.top),
            Sight::Beam { clear, escape } => {
                let scattered =
                    glow.layers.iter().zip(escape).zip(clear).map(|((layer, [top, slope, bottom]), clear)| {
                        clear * (top.dot(&layer.top) + slope.dot(&layer.top_slope) + bottom.dot(&layer.bottom))
                    });
                scattered.sum::<f64>() + clear[self.layers.len()] * glow.ground + clear[face] * glow.emitted
            }
        }
    }
}

fn cross(passage: Option<&Passage>, amplitudes: &DVector<f64>) -> DVector<f64> {
    passage
        .map_or_else(|| amplitudes.clone(), |passage| passage.factor.solve(&passage.bridge.component_mul(amplitudes)))
}

/// What lies below each face, from the ground up; leaves each layer its way down.
///
/// The ground's y is Δ − 4A/(1 + A) v vᵀ, since it sends 2A 1 1ᵀ M I⁺ back.
fn lower_sides(layers: &mut [Layer], albedo: f64) -> Vec<Side> {
    let bottom = layers[layers.len() - 1].medium;
    let [_, v] = &bottom.entering;
    let mut conductance = bottom.delta.clone();
    conductance.ger(-4.0 * albedo / (1.0 + albedo), v, v, 1.0);
    let mut sides = vec![Side { conductance, returned: v * (2.0 * albedo / (1.0 + albedo)) }];
    for layer in layers.iter_mut().rev() {
        let below = &sides[sides.len() - 1];
        let near = layer.seam.as_ref().map_or_else(|| below.clone(), |seam| below.changed(&seam.up));
        let (side, passage) = beyond(layer, near);
        layer.downwards = passage;
        sides.push(side);
    }
    sides.reverse();
    sides
}

/// What lies above each face, from the open sky (y = Δ) down; leaves each layer its way up.
fn upper_sides(layers: &mut [Layer]) -> Vec<Side> {
    let top = layers[0].medium;
    let mut sides = vec![Side { conductance: top.delta.clone(), returned: DVector::zeros(top.delta.nrows()) }];
    for layer in layers.iter_mut() {
        let (side, passage) = beyond(layer, sides[sides.len() - 1].clone());
        layer.upwards = passage;
        sides.push(layer.seam.as_ref().map_or_else(|| side.clone(), |seam| side.changed(&seam.down)));
    }
    sides
}

/// Takes a side across a layer, and tells how amplitudes cross back towards it.
fn beyond(layer: &Layer, side: Side) -> (Side, Option<Passage>) {
    let (medium, depth) = (layer.medium, layer.depth);
    // Below, nothing of the layer is left in double precision.
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
    (Side { conductance, returned }, Some(Passage { factor, bridge }))
}

impl Seam {
    fn between(above: &HomogeneousMedium, below: &HomogeneousMedium) -> Option<Self> {
        let overlap = |sums: &HomogeneousMedium, differences: &HomogeneousMedium| {
            sums.modes.sums.tr_mul(&differences.weighted_differences)
        };
        (!std::ptr::eq(above, below)).then(|| Self { down: overlap(below, above), up: overlap(above, below) })
    }
}

impl Side {
    /// The same in the modes of another medium.
    fn changed(&self, seam: &DMatrix<f64>) -> Self {
        Self { conductance: seam * &self.conductance * seam.transpose(), returned: seam * &self.returned }
    }
}

impl Sight {
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
        Self::Beam { clear, escape: layers.iter().map(|layer| escape(layer, cosine)).collect() }
    }
}

/// Radiance that leaves the top of a layer with cosine μ, ∫ J e^{−s/μ} ds/μ, per amplitude of each mode.
///
/// Slow modes in thin layers are a cosh(ks) + a' sinh(ks)/k from the top; the others are a wave that fades from the
/// top, (a − a'/k)/2, and one that fades from the bottom and makes up the rest of the amplitude there.
fn escape(layer: &Layer, cosine: f64) -> [DVector<f64>; 3] {
    let direction = layer.medium.direction(cosine);
    let (depth, per_cosine) = (layer.depth, 1.0 / cosine);
    let unscattered = (-depth * per_cosine).exp();
    let rates = &layer.medium.modes.rates;
    let mut weights = [(); 3].map(|()| DVector::zeros(rates.len()));
    for (j, &k) in rates.iter().enumerate() {
        let (even, odd) = (0.5 * direction.even[j], 0.5 * direction.odd[j]);
        if k < 0.5 && k * depth < 1.0 {
            let (cosh, sinh_over_k) = hyperbolic_integrals(k, depth, per_cosine, unscattered);
            weights[0][j] = even * cosh + odd * k * k * sinh_over_k;
            weights[1][j] = even * sinh_over_k + odd * cosh;
        } else {
            let (near, far) = exponential_integrals(k, depth, per_cosine);
            let growing = (even + odd * k) * far;
            let fading = 0.5 * ((even - odd * k) * near - growing * (-k * depth).exp());
            weights[0][j] = fading;
            weights[1][j] = -fading / k;
            weights[2][j] = growing;
        }
    }
    weights
}
