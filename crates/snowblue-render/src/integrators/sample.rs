//! Samples of paths, with the surface properties that the filter needs, and Russian roulette: the only rule by which
//! paths over surfaces end at random.

use glam::Vec3A;
use snowblue_scene::air::AirBetween;
use snowblue_scene::spectrum::Spectrum;

/// A sample of one path.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PathSample<C> {
    /// The radiance along the camera ray, or the sensor's response to it.
    pub(crate) radiance: C,
    /// Whether the first surface is snow.
    pub(crate) sees_snow: bool,
    /// Distance to the first surface, in m; none if there is none.
    pub(crate) distance_m: Option<f32>,
    /// Values for the filter, if the first surface is filtered.
    pub(crate) filtered: Option<FilteredSample<C>>,
}

impl<C: Copy> PathSample<C> {
    /// Maps the light of the sample to another quantity.
    #[inline]
    pub(crate) fn map<T>(&self, of: impl Fn(&C) -> T) -> PathSample<T> {
        let Self { radiance, sees_snow, distance_m, filtered } = self;
        let filtered = filtered.as_ref().map(|filtered| filtered.map(&of));
        PathSample { radiance: of(radiance), sees_snow: *sees_snow, distance_m: *distance_m, filtered }
    }
}

impl PathSample<Spectrum> {
    /// The sample after its light has crossed air.
    pub(crate) fn through(&self, AirBetween { transmittance, added }: &AirBetween) -> Self {
        let mut sample = self.map(|light| *light * *transmittance);
        sample.radiance += *added;
        sample
    }
}

/// Light that leaves a surface, and an estimate of this light with little noise.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FilteredSample<C> {
    /// The light less the baseline.
    pub(crate) residual: C,
    /// At snow, the radiance by the light field at the surface. At other surfaces, the light by samples of lamps and
    /// of the sun, and the light of skies and snow as if nothing hid the snow and only snow hid the skies.
    pub(crate) baseline: C,
    /// Whether the surface is snow with a light field.
    pub(crate) is_snow: bool,
    /// Normal of the surface.
    pub(crate) normal: Vec3A,
    /// Distance from the camera, in m.
    pub(crate) distance_m: f32,
}

impl<C: Copy> FilteredSample<C> {
    /// Maps the light of the sample to another quantity.
    #[inline]
    pub(crate) fn map<T>(&self, of: impl Fn(&C) -> T) -> FilteredSample<T> {
        let Self { residual, baseline, is_snow, normal, distance_m } = *self;
        FilteredSample { residual: of(&residual), baseline: of(&baseline), is_snow, normal, distance_m }
    }
}

/// Bounces before Russian roulette begins.
const SAFE_BOUNCES: u32 = 4;

/// Probability that a path with a throughput survives a bounce.
pub(super) fn survival_probability(bounce: u32, throughput: &Spectrum) -> f32 {
    if bounce < SAFE_BOUNCES { 1.0 } else { throughput.maximum().min(1.0) }
}
