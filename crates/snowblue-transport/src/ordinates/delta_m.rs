//! δ-M scaling: the forward peak of a phase function, beyond what the quadrature resolves, is taken as unscattered
//! light (Wiscombe 1977, doi:10.1175/1520-0469(1977)034<1408:TDMYRA>2.0.CO;2).

use crate::medium::Scattering;

/// A medium after δ-M scaling for a given quadrature.
pub(crate) struct Scaled {
    pub(crate) one_minus_albedo: f64,
    /// ω χ_l for l = 0 … 2N − 1.
    pub(crate) albedo_moments: Vec<f64>,
    /// Scaled over unscaled optical depth, 1 − ω f.
    pub(crate) depth_ratio: f64,
}

impl Scattering {
    /// δ-M scaling for `streams` ordinates: the truncated fraction is f = χ_streams if the peak is a forward one.
    pub(crate) fn delta_m(&self, streams: usize) -> Scaled {
        let forward = if self.moments[streams - 1] > 0.0 { self.moments[streams].max(0.0) } else { 0.0 };
        let albedo = 1.0 - self.one_minus_albedo;
        let depth_ratio = (1.0 - forward) + forward * self.one_minus_albedo;
        // A medium that only scatters straight forward (n = 1) only absorbs.
        if 1.0 - forward < 1e-12 {
            let albedo_moments = vec![0.0; streams];
            return Scaled { one_minus_albedo: 1.0, albedo_moments, depth_ratio: self.one_minus_albedo };
        }
        let scaled_albedo = albedo * (1.0 - forward) / depth_ratio;
        let albedo_moments =
            self.moments[..streams].iter().map(|chi| scaled_albedo * (chi - forward) / (1.0 - forward)).collect();
        Scaled { one_minus_albedo: self.one_minus_albedo / depth_ratio, albedo_moments, depth_ratio }
    }
}
