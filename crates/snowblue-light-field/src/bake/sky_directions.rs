//! The irradiance by a sky at many points, as a sum over common directions.
//!
//! At points without an obstacle there is no noise, so that a flat face is uniform. The irradiance E of the open sky
//! is a sum over many directions k, which needs no ray. Rays along a few of these directions give the visible part V:
//!
//! ```text
//! V E,   E = Σ_k E_k cos θ_k,   V = Σ_seen E_k cos θ_k / Σ_tried E_k cos θ_k,
//! ```
//!
//! with the irradiance E_k of a surface that faces direction k. Sampling errors therefore affect only the hidden part.

use glam::Vec3A;
use snowblue_geometry::ray::SurfacePoint;
use snowblue_scene::light::{Light, LightSample};
use snowblue_scene::objects::Side;
use snowblue_scene::queries::SceneQueries;
use snowblue_scene::sampling::Sampler;
use snowblue_scene::spectrum::Spectrum;

/// Number of samples of the sky. Each sample has directions by radiance and a direction by solid angle. On
/// level ground and walls under clear and overcast skies, their sum is within 0.1 % of the sum over eight times as
/// many samples.
const SAMPLES: u16 = 2048;
/// Number of samples whose visibility is tested.
const TRIED_SAMPLES: u16 = 128;

/// A sky as directions from which light comes, with `N` channels.
#[derive(Debug)]
pub(super) struct SkyDirections<const N: usize> {
    /// The directions of the first samples, whose visibility is tested.
    tried: Vec<SkyDirection<N>>,
    others: Vec<SkyDirection<N>>,
}

#[derive(Debug)]
struct SkyDirection<const N: usize> {
    sample: LightSample,
    towards: Vec3A,
    /// E_k in each channel.
    irradiance: [f32; N],
}

impl<const N: usize> SkyDirections<N> {
    /// The directions of a sky above the horizon, with the channels of their light.
    pub(super) fn new(sky: &Light, channels: impl Fn(&Spectrum) -> [f32; N]) -> Self {
        let [tried, others] = [0..TRIED_SAMPLES, TRIED_SAMPLES..SAMPLES]
            .map(|samples| samples.flat_map(|index| directions(sky, &channels, index)).collect());
        Self { tried, others }
    }

    /// V E at a point on one side of an object's surface.
    pub(super) fn irradiance(&self, queries: &mut SceneQueries, surface: &SurfacePoint, side: Side) -> [f32; N] {
        let [mut seen, mut tried, mut open] = [[0.0; N]; 3];
        for direction in &self.tried {
            if let Some(irradiance) = direction.on(surface) {
                add(&mut tried, irradiance);
                let transmittance = direction.sample.transmittance(queries, surface, side);
                add(&mut seen, irradiance.map(|irradiance| irradiance * transmittance));
            }
        }
        self.others.iter().filter_map(|direction| direction.on(surface)).for_each(|one| add(&mut open, one));
        std::array::from_fn(|channel| {
            let all = tried[channel] + open[channel];
            // If no tried direction brings light in a channel, all light of the channel counts as hidden.
            if tried[channel] > 0.0 { all * (seen[channel] / tried[channel]) } else { 0.0 }
        })
    }
}

impl<const N: usize> SkyDirection<N> {
    /// The irradiance of a surface, if it faces the direction.
    #[inline]
    fn on(&self, surface: &SurfacePoint) -> Option<[f32; N]> {
        let cos = surface.normal.dot(self.towards);
        (cos > 0.0).then(|| self.irradiance.map(|irradiance| irradiance * cos))
    }
}

/// The directions of a sample. The directions of all samples together have the irradiance of the sky.
fn directions<const N: usize>(
    sky: &Light,
    channels: &impl Fn(&Spectrum) -> [f32; N],
    index: u16,
) -> Vec<SkyDirection<N>> {
    let ground = SurfacePoint { point: Vec3A::ZERO, normal: Vec3A::Z };
    let techniques = sky.techniques_through(None, Some(&ground));
    let mut sampler = Sampler::new(3, 0, index.into());
    let mut direction = |chosen: usize| {
        let sample = sky.sample(chosen, &techniques, &mut sampler)?;
        let towards = sample.origin.direction_from(Vec3A::ZERO).direction;
        let facing = sample.incident_at(&SurfacePoint { point: Vec3A::ZERO, normal: towards })?;
        let share = facing.irradiance_per_power / f32::from(SAMPLES);
        Some(SkyDirection { sample, towards, irradiance: channels(&(sky.power(&sample.origin) * share)) })
    };
    [0, 1, 2].into_iter().filter_map(&mut direction).collect()
}

fn add<const N: usize>(sum: &mut [f32; N], irradiance: [f32; N]) {
    sum.iter_mut().zip(irradiance).for_each(|(sum, irradiance)| *sum += irradiance);
}
