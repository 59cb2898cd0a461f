//! What discrete ordinates need to know of a medium: single-scattering co-albedo and Legendre moments.
//!
//! The phase function is p(cos Θ) = Σ (2l + 1) χ_l P_l(cos Θ), so χ_0 = 1 and χ_1 = g. Its forward peak, beyond what
//! the quadrature resolves, is taken as unscattered light (δ-M: Wiscombe 1977,
//! doi:10.1175/1520-0469(1977)034<1408:TDMYRA>2.0.CO;2).

use super::eigen::resolves;
use super::streams::Streams;
use crate::TransportError;

/// Optical properties of a medium per unit of optical depth.
#[derive(Debug, Clone, PartialEq)]
pub struct Scattering {
    /// 1 − ω, the chance that an extinction event absorbs. Snow's is as small as 3·10⁻⁸, so it is carried instead
    /// of the albedo ω, which would lose it to rounding.
    pub one_minus_albedo: f64,
    /// Legendre moments χ_0 = 1, χ_1 = g, … of the phase function of the scattered light.
    pub moments: Vec<f64>,
}

/// A medium after δ-M scaling for a given quadrature.
pub(crate) struct Scaled {
    pub(crate) one_minus_albedo: f64,
    /// ω χ_l for l = 0 … 2N − 1.
    pub(crate) albedo_moments: Vec<f64>,
    /// Scaled over unscaled optical depth, 1 − ω f.
    pub(crate) depth_ratio: f64,
}

impl Scattering {
    /// Henyey & Greenstein (1941): χ_l = g^l, with as many moments as `streams` needs.
    #[must_use]
    pub fn henyey_greenstein(one_minus_albedo: f64, g: f64, streams: usize) -> Self {
        let moments = std::iter::successors(Some(1.0), |chi| Some(chi * g)).take(streams + 1).collect();
        Self { one_minus_albedo, moments }
    }

    /// Asymmetry parameter g = χ_1, the mean cosine of the scattering angle.
    #[must_use]
    pub fn asymmetry(&self) -> f64 {
        self.moments[1]
    }

    /// Checks that an albedo and moments are possible, and that `streams` ordinates can carry them: a peak that is far
    /// narrower than they resolve, and not forward, leaves a discrete medium that creates light.
    ///
    /// # Errors
    /// [`TransportError::OutOfRange`], [`TransportError::Streams`] or [`TransportError::Unresolved`].
    pub fn check(&self, streams: usize) -> Result<(), TransportError> {
        Streams::Exactly(streams).check()?;
        TransportError::check("co-albedo", self.one_minus_albedo, (0.0, 1.0), "")?;
        TransportError::check("number of moments", self.moments.len() as f64, (streams as f64 + 1.0, 1e9), "")?;
        self.moments.iter().try_for_each(|chi| TransportError::check("moment", *chi, (-1.0, 1.0), ""))?;
        if resolves(&self.delta_m(streams), streams) { Ok(()) } else { Err(TransportError::Unresolved { streams }) }
    }

    /// δ-M scaling for `streams` ordinates: the truncated fraction is f = χ_streams if the peak is a forward one.
    pub(crate) fn delta_m(&self, streams: usize) -> Scaled {
        let forward = if self.moments[streams - 1] > 0.0 { self.moments[streams].max(0.0) } else { 0.0 };
        let albedo = 1.0 - self.one_minus_albedo;
        let depth_ratio = (1.0 - forward) + forward * self.one_minus_albedo;
        // A medium that only scatters straight on (n = 1) absorbs and does nothing else.
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
