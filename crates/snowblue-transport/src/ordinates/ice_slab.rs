//! Slabs of clear ice with smooth faces, under light in one direction, and the light of a beam that nothing scatters in
//! a stack of snow and ice.
//!
//! Nothing in ice scatters, so a slab is an operator that is diagonal in the direction. With the cosine μ outside and
//! μ' of the refracted light, Fresnel's reflectance F of a face for one polarisation, and a = exp(−γd/μ'), sums over
//! internal reflections by power give
//!
//! ```text
//! T = (1 − F)² a/(1 − F²a²),     R = F + F a T,
//! 1 − R − T = (1 − F)(1 − a)/(1 − F a),     1 − R + T = (1 − F)(1 + a)/(1 + F a),
//! ```
//!
//! of which the mean over both polarisations is taken. In the network of [`layered`](super::layered), per ordinate, the
//! shunt is μ (1 − R − T)/(1 + R + T), and the bridge is 2μ T/((1 + R)² − T²).
//!
//! Inside the ice, radiance over n² takes the place of radiance outside: n² μ' dμ' = μ dμ. Unit radiance over n² that
//! a plane within the ice emits upwards, with the transmissions a_z above it and a_r below it, leaves the top of the
//! ice as (1 − F) a_z/(1 − F²a²) and the bottom as F a times this.

use super::integrals::transmitted_integral;
use crate::dual::Real;
use crate::optics::polarised;
use crate::quadrature::Quadrature;
use crate::slab::Incidence;

/// A plane in a slab of ice, or all of the slab, under light in one direction.
pub(super) struct IceLight<T> {
    /// μ.
    cosine: T,
    /// μ'.
    cos_refraction: T,
    /// F, of both polarisations.
    reflectances: [T; 2],
    /// a_z.
    above: T,
    /// a_r.
    below: T,
    /// 1 − a.
    absorbed: T,
}

/// The flux through a plane or the fluence rate there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FaceQuantity {
    /// Flux downwards.
    Down,
    /// Flux upwards.
    Up,
    /// Flux downwards less upwards.
    Net,
    /// Fluence rate.
    Fluence,
}

impl FaceQuantity {
    /// Radiance that a plane must emit upwards and downwards in a direction, so that it leaves the stack with the
    /// quantity.
    pub(super) fn emitted<T: Real>(self, cosine: T) -> [T; 2] {
        match self {
            Self::Down => [1.0, 0.0].map(T::from),
            Self::Up => [0.0, 1.0].map(T::from),
            Self::Net => [1.0, -1.0].map(T::from),
            Self::Fluence => [T::from(1.0) / cosine; 2],
        }
    }
}

impl<T: Real> IceLight<T> {
    /// Ice with optical depths of absorption above and below a plane.
    pub(super) fn new(index: f64, cosine: T, [above, below]: [T; 2]) -> Self {
        let (cos_refraction, reflectances) = polarised(cosine, index);
        Self {
            cosine,
            cos_refraction,
            reflectances,
            above: (-above / cos_refraction).exp(),
            below: (-below / cos_refraction).exp(),
            absorbed: -(-(above + below) / cos_refraction).exp_m1(),
        }
    }

    /// Reflectance and transmittance.
    pub(super) fn passed(&self) -> [T; 2] {
        let a = self.above * self.below;
        let transmitted = |f: T| (T::from(1.0) - f) * (T::from(1.0) - f) * a / (T::from(1.0) - f * f * a * a);
        [self.mean(|f| f + f * a * transmitted(f)), self.mean(transmitted)]
    }

    /// The shunt at each face and the bridge between them.
    pub(super) fn elements(&self) -> [T; 2] {
        let a = self.above * self.below;
        let whole = T::from(1.0);
        let lost = self.mean(|f| (whole - f) * self.absorbed / (whole - f * a));
        let crossing = self.mean(|f| (whole - f) * (whole + a) / (whole + f * a));
        let [_, transmitted] = self.passed();
        let sum = -lost + 2.0;
        [self.cosine * lost / sum, self.cosine * transmitted * 2.0 / (sum * (-crossing + 2.0))]
    }

    /// Radiance that leaves the top and the bottom for a quantity at the plane.
    pub(super) fn leaving(&self, quantity: FaceQuantity) -> [T; 2] {
        let [up, down] = quantity.emitted(self.cos_refraction);
        let [up, down] = [up * self.above, down * self.below];
        let a = self.above * self.below;
        let out =
            |near: T, far: T| self.mean(|f| (T::from(1.0) - f) / (T::from(1.0) - f * f * a * a) * (near + f * a * far));
        [out(up, down), out(down, up)]
    }

    fn mean(&self, of: impl Fn(T) -> T) -> T {
        let [s, p] = self.reflectances.map(of);
        (s + p) * 0.5
    }
}

/// Light at each ordinate in ice of an optical depth.
pub(super) fn ice_lights<T: Real>(index: f64, order: usize, depth: T) -> impl Iterator<Item = IceLight<T>> {
    let cosines = Quadrature::half_range(order).cosines.iter();
    cosines.map(move |mu| IceLight::new(index, T::from(*mu), [depth, T::from(0.0)]))
}

/// Fractions of a beam that arrive at each face unscattered, outside ice. By reciprocity they are the weights with
/// which radiance at the face is seen from the top.
pub(super) struct Unscattered<T> {
    /// Downwards; the weight of radiance upwards.
    pub(super) down: Vec<T>,
    /// Upwards, reflected by ice; the weight of radiance downwards.
    pub(super) up: Vec<T>,
}

impl<T: Real> Unscattered<T> {
    /// The unscattered fractions for layers with these reflected and transmitted fractions.
    pub(super) fn new(layers: &[[T; 2]]) -> Self {
        let whole = T::from(1.0);
        // The reflectance of everything below each face.
        let mut below = vec![T::from(0.0)];
        for &[reflected, transmitted] in layers.iter().rev() {
            let next = below[below.len() - 1];
            below.push(reflected + transmitted * transmitted * next / (whole - reflected * next));
        }
        below.reverse();
        let mut down = vec![whole];
        for (&[reflected, transmitted], next) in layers.iter().zip(&below[1..]) {
            down.push(down[down.len() - 1] * transmitted / (whole - reflected * *next));
        }
        let up = down.iter().zip(below).map(|(down, below)| *down * below).collect();
        Self { down, up }
    }
}

/// Fractions of the unscattered light in one direction that snow, or ice with an index, reflects and transmits.
pub(super) fn unscattered<T: Real>(ice_index: Option<f64>, depth: T, cosine: T) -> [T; 2] {
    let ice = ice_index.map(|index| IceLight::new(index, cosine, [depth, T::from(0.0)]).passed());
    ice.unwrap_or_else(|| [T::from(0.0), (-depth / cosine).exp()])
}

/// The unscattered part of the light that falls on the top of the layers and passes them. `layers` has the refractive
/// index of ice, or none for snow, and the optical depth of each layer.
pub(super) fn direct(layers: &[(Option<f64>, f64)], incidence: &Incidence) -> f64 {
    let depth: f64 = layers.iter().filter(|(index, _)| index.is_none()).map(|(_, depth)| depth).sum();
    // The transmittance of the ice alone, including light that the ice reflects through the snow.
    let through_ice = |cosine: f64| {
        if layers.iter().all(|(index, _)| index.is_none()) {
            return 1.0;
        }
        let passed: Vec<[f64; 2]> = layers.iter().map(|(index, depth)| unscattered(*index, *depth, cosine)).collect();
        let down = Unscattered::new(&passed).down;
        let ratios = layers.iter().zip(down.windows(2)).filter(|((index, _), _)| index.is_some());
        ratios.map(|(_, faces)| if faces[0] > 0.0 { faces[1] / faces[0] } else { 1.0 }).product::<f64>()
    };
    match incidence {
        Incidence::Beam { angle_deg } => {
            let cosine = angle_deg.to_radians().cos();
            (-depth / cosine).exp() * through_ice(cosine)
        }
        Incidence::Diffuse => 2.0 * transmitted_integral(depth, through_ice),
    }
}
