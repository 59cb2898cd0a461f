//! A slab of clear ice with smooth faces, under light in one direction.
//!
//! Nothing in it scatters, so a slab is an operator that is diagonal in the direction. With the cosine μ outside and μ'
//! of the refracted light, Fresnel's reflectance F of a face for one polarisation, and a = exp(−γd/μ'), sums over
//! internal reflections by power give
//!
//! ```text
//! T = (1 − F)² a/(1 − F²a²),     R = F + F a T,
//! 1 − R − T = (1 − F)(1 − a)/(1 − F a),     1 − R + T = (1 − F)(1 + a)/(1 + F a),
//! ```
//!
//! of which the mean over both polarisations is taken. In
//! the network of [`layered`](super::layered), per ordinate, the shunt is μ (1 − R − T)/(1 + R + T), and the bridge is
//! 2μ T/((1 + R)² − T²).
//!
//! Inside, radiance over n² is what its flux is outside: n² μ' dμ' = μ dμ. Unit radiance over n² that a plane within
//! the ice emits upwards, with the transmissions a_z above it and a_r below it, leaves the top as
//! (1 − F) a_z/(1 − F²a²) and the bottom as F a times this.

use crate::dual::Real;
use crate::optics::polarised;
use crate::quadrature::Quadrature;

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
