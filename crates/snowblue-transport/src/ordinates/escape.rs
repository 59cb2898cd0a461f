//! Radiance that leaves a layer of snow in one direction: its source function, integrated along the way.

use nalgebra::DVector;

use super::homogeneous::Direction;
use super::integrals::{exponential_integrals, hyperbolic_integrals};
use crate::dual::Real;

/// Radiance that leaves a layer in one direction.
pub(super) struct FaceEscapes<T: Real = f64> {
    /// From its top.
    pub(super) top: Escape<T>,
    /// From its bottom; none if no ice below reflects it.
    pub(super) bottom: Option<Escape<T>>,
}

/// Radiance that leaves a face of a layer in one direction, per amplitude of each mode.
pub(super) struct Escape<T: Real = f64> {
    /// Per amplitude of S at the top.
    pub(super) top: DVector<T>,
    /// Per slope of the mode at the top.
    pub(super) top_slope: DVector<T>,
    /// Per amplitude of S at the bottom.
    pub(super) bottom: DVector<T>,
}

/// The faces of a layer.
#[derive(Clone, Copy)]
enum Face {
    Top,
    Bottom,
}

/// Amplitudes of the modes of one layer.
pub(super) struct Profile {
    pub(super) top: DVector<f64>,
    pub(super) top_slope: DVector<f64>,
    pub(super) bottom: DVector<f64>,
}

impl<T: Real> FaceEscapes<T> {
    /// Radiance that leaves the top of a layer with a cosine, and the bottom if it is seen.
    pub(super) fn new(direction: &Direction<T>, rates: &[T], (depth, sees_bottom): (T, bool)) -> Self {
        Self {
            top: Escape::new(Face::Top, direction, rates, depth),
            bottom: sees_bottom.then(|| Escape::new(Face::Bottom, direction, rates, depth)),
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
    /// Radiance that leaves a face of a layer with cosine μ, ∫ J e^{−s/μ} ds/μ, per amplitude of each mode.
    ///
    /// Slow modes in thin layers are a cosh(ks) + a' sinh(ks)/k from the face. Seen from the bottom, the amplitude is
    /// the amplitude b at the bottom, and the slope is b' = −k sinh(kτ) a − cosh(kτ) a'. The other modes are the sum
    /// of two waves. The first wave, (a − a'/k)/2, decays from the top. The second wave decays from the bottom and
    /// makes up the rest of the amplitude at the bottom.
    fn new(face: Face, direction: &Direction<T>, rates: &[T], depth: T) -> Self {
        let per_cosine = T::from(1.0) / direction.cos_incidence;
        let unscattered = (-depth * per_cosine).exp();
        let mut escape = Self::zeros(rates.len());
        for (j, &k) in rates.iter().enumerate() {
            let (even, odd) = (direction.even[j] * 0.5, direction.odd[j] * 0.5);
            if k.value() < 0.5 && k.value() * depth.value() < 1.0 {
                let (cosh, sinh_over_k) = hyperbolic_integrals(k, depth, per_cosine, unscattered);
                let (amplitude, slope) = (even * cosh + odd * k * k * sinh_over_k, even * sinh_over_k + odd * cosh);
                match face {
                    Face::Top => (escape.top[j], escape.top_slope[j]) = (amplitude, slope),
                    Face::Bottom => {
                        escape.top[j] = -slope * k * (k * depth).sinh();
                        escape.top_slope[j] = -slope * (k * depth).cosh();
                        escape.bottom[j] = amplitude;
                    }
                }
            } else {
                let (near, far) = exponential_integrals(k, depth, per_cosine);
                let [from_face, to_face] = [(even - odd * k) * near, (even + odd * k) * far];
                let [from_top, from_bottom] = match face {
                    Face::Top => [from_face, to_face],
                    Face::Bottom => [to_face, from_face],
                };
                let fading = (from_top - from_bottom * (-k * depth).exp()) * 0.5;
                escape.top[j] = fading;
                escape.top_slope[j] = -fading / k;
                escape.bottom[j] = from_bottom;
            }
        }
        escape
    }

    /// No radiance.
    pub(super) fn zeros(modes: usize) -> Self {
        let zeros = || DVector::from_element(modes, T::from(0.0));
        Self { top: zeros(), top_slope: zeros(), bottom: zeros() }
    }
}
