//! Options of the discrete-ordinates engine: the number of streams (ordinates), counted in both hemispheres.
//!
//! The error comes from the integration over angle with few directions and from the δ-M forward peak. It grows towards
//! the horizon, where only the topmost grains scatter the beam. Worst relative error of T against 128 streams on the
//! paper's grid (100–500 µm, facetness 0.1–0.9, 200–400 kg/m³, 1–50 cm, 400–700 nm):
//!
//! ```text
//! streams       8        12        16        32        48
//! 0–60°    1.8e-4    1.1e-5    1.5e-6    6.9e-7    3.4e-7
//! 70°      1.6e-4    4.9e-5    9.3e-6    1.4e-6    7.1e-7
//! 80°      2.4e-4    1.1e-4    1.0e-5    3.3e-6    2.2e-6
//! 89°      4.1e-3    1.8e-3    1.1e-3    1.2e-4    2.8e-5
//! 89.5°    7.0e-3    2.3e-3    2.1e-3    2.9e-4    9.0e-5
//! diffuse  2.0e-5    1.6e-6    3.4e-7    7.2e-9    8e-10
//! ```
//!
//! Grains in water, and algae, scatter so far forward (1 − g ≈ 0.004) that they need more streams for equal errors.
//! Worst relative error of T against 128 or 192 streams, saturated snow (in half-saturated snow a third to a tenth of
//! this error), 0.01–50 cm, 400–1200 nm:
//!
//! ```text
//! streams      16        32        48        64        96       128
//! 0°        4.1e-4    2.0e-5    7.0e-6    2.0e-6    3.0e-7    6.0e-8
//! 60°       1.2e-3    5.0e-5    7.0e-6    3.0e-6    2.0e-7    5.0e-8
//! 80°       9.3e-3    1.1e-3    2.4e-4    5.5e-5    6.0e-6    1.2e-6
//! 85°            –    4.6e-3    6.2e-4    2.3e-4    4.4e-5    9.0e-6
//! 89°            –    4.8e-2    1.4e-2    2.8e-3    1.0e-3    5.5e-4
//! diffuse   8.0e-4    1.5e-5    3.0e-6    7.0e-7    1.0e-7    2.0e-8
//! ```
//!
//! In such snow the error of the reflectance is larger than the error of the transmittance: where a thin saturated
//! layer has a reflectance of 10⁻⁴, the reflectance has a relative error of a hundredth at 64 streams.
//!
//! In dry layers of 0.0005–0.5 cm, 16 streams keep 8·10⁻⁵ up to 80° and in diffuse light, and 48 keep 6·10⁻⁵ at 89°.

use std::fmt;

use crate::TransportError;
use crate::medium::TallyPlan;
use crate::quadrature::MAX_NODES;
use crate::sample::SnowSample;
use crate::slab::Incidence;

/// Most streams that are allowed.
pub const MAX_STREAMS: usize = 2 * MAX_NODES;

/// Streams of [`Streams::Auto`] up to [`GRAZING_DEG`] and for diffuse light, for each [`Peak`].
const STEEP_STREAMS: [usize; 2] = [16, 64];
/// Streams of [`Streams::Auto`] beyond [`GRAZING_DEG`].
const GRAZING_STREAMS: [usize; 2] = [48, 128];
/// Angle beyond which a beam takes more streams, in degrees.
const GRAZING_DEG: f64 = 80.0;

/// The number of ordinates, counting both hemispheres.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Streams {
    /// In dry snow 16 up to 80° and for diffuse light, 48 beyond: T within 10⁻⁴ of 128 streams up to 89.5°, within
    /// 4·10⁻⁴ to 89.9°. In wet snow and among algae 64 and 128: T within 10⁻⁴ up to 85°, 6·10⁻⁴ at 89°.
    #[default]
    Auto,
    /// An even number for all angles.
    Exactly(usize),
}

/// Sharpness of the forward peak of the phase function.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Peak {
    /// Forward peak of grains in air.
    #[default]
    Broad,
    /// Forward peak of grains in water and of algae.
    Sharp,
}

/// Incidences with a common number of streams.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StreamGroup {
    /// Number of streams.
    pub streams: usize,
    /// Indices of the incidences.
    pub places: Vec<usize>,
}

impl Peak {
    /// The sharpest peak of all scatterers of a sample.
    #[must_use]
    pub fn of(sample: &SnowSample) -> Self {
        let is_sharp = sample.impurities.present().any(|(substance, _)| substance.has_sharp_peak());
        if is_sharp || sample.water_saturation > 0.0 { Self::Sharp } else { Self::Broad }
    }
}

impl Streams {
    /// Checks the number.
    ///
    /// # Errors
    /// [`TransportError::Streams`] if it is odd, zero or too large.
    pub fn check(self) -> Result<(), TransportError> {
        match self {
            Self::Auto => Ok(()),
            Self::Exactly(streams) if (2..=MAX_STREAMS).contains(&streams) && streams.is_multiple_of(2) => Ok(()),
            Self::Exactly(streams) => Err(TransportError::Streams { streams, most: MAX_STREAMS }),
        }
    }

    /// Number of streams for one incidence.
    #[must_use]
    pub fn under(self, incidence: &Incidence, peak: Peak) -> usize {
        match (self, incidence) {
            (Self::Exactly(streams), _) => streams,
            (Self::Auto, Incidence::Beam { angle_deg }) if *angle_deg > GRAZING_DEG => GRAZING_STREAMS[peak as usize],
            (Self::Auto, _) => STEEP_STREAMS[peak as usize],
        }
    }

    /// The greatest number of streams for any of the incidences; 0 without incidences.
    #[must_use]
    pub fn most(self, incidences: &[Incidence], peak: Peak) -> usize {
        incidences.iter().map(|incidence| self.under(incidence, peak)).max().unwrap_or(0)
    }

    /// Groups the incidences by the number of streams that they need, fewest streams first.
    #[must_use]
    pub fn groups(self, incidences: &[Incidence], peak: Peak) -> Vec<StreamGroup> {
        let mut groups = std::collections::BTreeMap::<usize, Vec<usize>>::new();
        for (place, incidence) in incidences.iter().enumerate() {
            groups.entry(self.under(incidence, peak)).or_default().push(place);
        }
        groups.into_iter().map(|(streams, places)| StreamGroup { streams, places }).collect()
    }
}

/// Formats as `auto` or the number.
impl fmt::Display for Streams {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => out.write_str("auto"),
            Self::Exactly(streams) => streams.fmt(out),
        }
    }
}

/// Options of the discrete-ordinates engine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrdinatesOptions {
    /// Ordinates, counting both hemispheres.
    pub streams: Streams,
    /// Rays per index node of the grain tally.
    pub tally_rays: u32,
    /// Seed of the grain tally.
    pub seed: u64,
}

impl OrdinatesOptions {
    /// The tally options for snow with a forward peak under some lights.
    pub(crate) fn plan(&self, incidences: &[Incidence], peak: Peak) -> TallyPlan {
        self.plan_of_degree(self.streams.most(incidences, peak))
    }

    pub(super) fn plan_of_degree(&self, degree: usize) -> TallyPlan {
        TallyPlan { degree, rays: self.tally_rays, seed: self.seed }
    }
}

impl Default for OrdinatesOptions {
    fn default() -> Self {
        Self { streams: Streams::default(), tally_rays: crate::medium::DEFAULT_RAYS, seed: 1 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn incidences_are_grouped_by_their_streams() {
        let lights = [0.0, 89.0, 80.0].map(|angle_deg| Incidence::Beam { angle_deg });
        let lights = [&lights[..], &[Incidence::Diffuse]].concat();
        let group = |streams, places: &[usize]| StreamGroup { streams, places: places.to_vec() };
        assert_eq!(Streams::Auto.groups(&lights, Peak::Broad), [group(16, &[0, 2, 3]), group(48, &[1])]);
        assert_eq!(Streams::Auto.groups(&lights, Peak::Sharp), [group(64, &[0, 2, 3]), group(128, &[1])]);
        assert_eq!(Streams::Exactly(8).groups(&lights, Peak::Sharp), [group(8, &[0, 1, 2, 3])]);
        assert_eq!(Streams::Auto.most(&lights, Peak::Broad), 48);
        assert!(Streams::Exactly(7).check().is_err() && Streams::Exactly(0).check().is_err());
    }
}
