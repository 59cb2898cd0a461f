//! δ-M scaling: the forward peak of a phase function, beyond what the quadrature resolves, is taken as unscattered
//! light (Wiscombe 1977, doi:10.1175/1520-0469(1977)034<1408:TDMYRA>2.0.CO;2).

use crate::dual::Real;
use crate::medium::Scattering;

/// A medium after δ-M scaling for a given quadrature.
pub(crate) struct Scaled<T = f64> {
    pub(crate) one_minus_albedo: T,
    /// ω χ_l for l = 0 … 2N − 1.
    pub(crate) albedo_moments: Vec<T>,
    /// Scaled over unscaled optical depth, 1 − ω f.
    pub(crate) depth_ratio: T,
}

impl<T: Real> Scaled<T> {
    /// δ-M scaling for `streams` ordinates: the truncated fraction is f = χ_streams if the peak is a forward one.
    pub(crate) fn new(medium: &Scattering<T>, streams: usize) -> Self {
        let [nothing, whole] = [0.0, 1.0].map(T::from);
        let is_forward = [streams - 1, streams].into_iter().all(|l| medium.moments[l].value() > 0.0);
        let forward = if is_forward { medium.moments[streams] } else { nothing };
        let albedo = whole - medium.one_minus_albedo;
        let depth_ratio = (whole - forward) + forward * medium.one_minus_albedo;
        // A medium that only scatters straight forward (n = 1) only absorbs.
        if 1.0 - forward.value() < 1e-12 {
            let albedo_moments = vec![nothing; streams];
            return Self { one_minus_albedo: whole, albedo_moments, depth_ratio: medium.one_minus_albedo };
        }
        let scaled_albedo = albedo * (whole - forward) / depth_ratio;
        let scaled = |chi: &T| scaled_albedo * (*chi - forward) / (whole - forward);
        let albedo_moments = medium.moments[..streams].iter().map(scaled).collect();
        Self { one_minus_albedo: medium.one_minus_albedo / depth_ratio, albedo_moments, depth_ratio }
    }
}
