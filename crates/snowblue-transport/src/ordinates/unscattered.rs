//! Light of a beam that nothing scatters in a stack of snow and slabs of ice, which goes down and up between these.

use super::ice_slab::IceLight;
use super::integrals::transmitted_integral;
use crate::dual::Real;
use crate::slab::Incidence;

/// Fractions of a beam that arrive at each face unscattered, outside ice. By reciprocity they are the weights with
/// which radiance at the face is seen from the top.
pub(super) struct Unscattered<T> {
    /// Downwards; the weight of radiance upwards.
    pub(super) down: Vec<T>,
    /// Upwards, reflected by ice; the weight of radiance downwards.
    pub(super) up: Vec<T>,
}

impl<T: Real> Unscattered<T> {
    /// Of layers that reflect and transmit these fractions.
    pub(super) fn new(layers: &[[T; 2]]) -> Self {
        let whole = T::from(1.0);
        // What everything below a face reflects.
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

/// The unscattered part of the light that falls on the top of layers and passes them, of which the index of ice, or
/// none of snow, and the optical depth are given.
pub(super) fn direct(layers: &[(Option<f64>, f64)], incidence: &Incidence) -> f64 {
    let depth: f64 = layers.iter().filter(|(index, _)| index.is_none()).map(|(_, depth)| depth).sum();
    // The transmittance of the ice alone, with what it reflects through the snow.
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
