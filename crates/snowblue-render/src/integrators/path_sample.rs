//! What a sample finds of snow, for the filter of random walks.

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
    /// The part that comes from snow, if a walk was followed there.
    pub(crate) snow: Option<SnowSample<C>>,
}

impl<C> PathSample<C> {
    /// The same sample of another quantity.
    #[inline]
    pub(crate) fn map<T>(&self, of: impl Fn(&C) -> T) -> PathSample<T> {
        let Self { radiance, sees_snow, distance_m, snow } = self;
        let snow = snow.as_ref().map(|snow| snow.map(&of));
        PathSample { radiance: of(radiance), sees_snow: *sees_snow, distance_m: *distance_m, snow }
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

/// Light from snow, by a random walk and by the light field at the surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SnowSample<C> {
    /// The radiance by the walk less the reading.
    pub(crate) residual: C,
    /// The radiance by the light field at the surface.
    pub(crate) reading: C,
    /// Normal of the surface.
    pub(crate) normal: Vec3A,
    /// Distance from the camera, in m.
    pub(crate) distance_m: f32,
}

impl<C> SnowSample<C> {
    /// The same sample of another quantity.
    #[inline]
    pub(crate) fn map<T>(&self, of: impl Fn(&C) -> T) -> SnowSample<T> {
        let Self { residual, reading, normal, distance_m } = self;
        SnowSample { residual: of(residual), reading: of(reading), normal: *normal, distance_m: *distance_m }
    }
}
