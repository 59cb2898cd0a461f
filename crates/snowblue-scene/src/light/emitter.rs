//! What a kind of light says of itself: the interface between the file of each kind and all that uses lights.

use std::f32::consts::PI;
use std::fmt::Debug;

use glam::Vec3A;
use snowblue_geometry::ray::Ray;
use snowblue_geometry::shape::Shape;

use crate::light::sample::{LightOrigin, SpotCone};
use crate::spectrum::Spectrum;

/// A kind of light.
///
/// A light without extent needs the first three methods only; one with extent samples itself, and one with a surface or
/// a disc says what rays hit. A light whose spectrum varies over it says what it emits.
pub(crate) trait Emitter: Debug + Send + Sync + 'static {
    /// What the light is called.
    fn name(&self) -> &'static str;

    /// Where the light is, and whether it has an extent.
    fn light_type(&self) -> LightType;

    /// The power of every origin, as of [`le`](Self::le); none if origins differ.
    fn uniform(&self) -> Option<&Spectrum>;

    /// The power of an origin: radiant intensity in W/sr of a point, irradiance of a facing surface in W/m² of a
    /// direction, radiance in W m⁻² sr⁻¹ of all others, as a band density.
    fn le(&self, _origin: &LightOrigin) -> Spectrum {
        self.uniform().copied().unwrap_or(Spectrum::ZERO)
    }

    /// A point or direction of a light with extent as seen from a point, by two numbers in [0, 1); none if the light
    /// does not shine there. An even sky is not asked.
    fn sample_li(&self, _from: Vec3A, _numbers: [f32; 2]) -> Option<LightOrigin> {
        None
    }

    /// Density of [`sample_li`](Self::sample_li) in directions from that point, in 1/sr.
    fn pdf_li(&self, _from: Vec3A, _origin: &LightOrigin) -> f32 {
        0.0
    }

    /// Where a ray hits the emitting side of a surface before `limit_m`, or a disc.
    fn hit(&self, _ray: &Ray, _limit_m: f32) -> Option<LightOrigin> {
        None
    }

    /// The irradiance of a facing surface by a disc, in W/m² as a band density.
    fn normal_irradiance(&self) -> Spectrum {
        Spectrum::ZERO
    }

    /// Whether it is a sky without edges. What it brings to a surface is as smooth as what hides it.
    fn is_smooth_sky(&self) -> bool {
        false
    }

    /// The light as a lamp inside snow; none if it cannot be one.
    fn inner_lamp(&self) -> Option<InnerLamp> {
        None
    }
}

/// Where a light is. How it is sampled and seen follows from this.
#[derive(Debug, Clone, Copy)]
pub(crate) enum LightType {
    /// A point in m, and the cone in which it shines if it is a spot.
    DeltaPosition(Vec3A, Option<SpotCone>),
    /// One direction: a unit vector from the scene towards the light.
    DeltaDirection(Vec3A),
    /// A surface.
    Area {
        /// Its middle, in m.
        centre: Vec3A,
        /// Its area as it is seen over π, in m².
        spread_m2: f32,
    },
    /// A disc of directions about a unit vector towards the light, so small that rays do not find it by chance.
    Disc(Vec3A),
    /// All directions.
    Infinite,
    /// All directions, and all alike, so that the cosine of a surface samples it best.
    UniformInfinite,
}

/// Depths, each half of the one before, at which the middle of a lamp in a thin body is sought.
const MAX_HALVINGS: i32 = 8;

/// A lamp inside snow: a ball that shines in all directions, or a point.
#[derive(Debug, Clone)]
pub struct InnerLamp {
    /// Its centre, in m.
    pub position: Vec3A,
    /// Its radius in m, 0 for a point.
    pub radius_m: f32,
    /// Radiant intensity in W/sr, as a band density.
    pub intensity: Spectrum,
}

impl InnerLamp {
    /// A sphere of a radiance in W m⁻² sr⁻¹, as a band density.
    pub(crate) fn sphere(position: Vec3A, radius_m: f32, radiance: Spectrum) -> Self {
        Self { position, radius_m, intensity: radiance * (PI * radius_m * radius_m) }
    }

    /// The part of a sphere that reaches into a body from outside, as a lamp of its power: if it is h deep in, the cap
    /// that level snow cuts off a sphere of radius r sends out h/2r of its light. In a thin body the lamp lies in its
    /// middle. `holds` says whether a point is inside the body.
    pub fn cap_in(&self, body: &Shape, holds: impl Fn(Vec3A) -> bool) -> Option<Self> {
        let surface = body.nearest(self.position)?;
        let height_m = self.radius_m - surface.point.distance(self.position);
        if height_m <= 0.0 {
            return None;
        }
        let depths_m = (1..=MAX_HALVINGS).map(|halvings| height_m * 0.5_f32.powi(halvings));
        let mut places = depths_m.map(|depth_m| (depth_m, surface.point - surface.normal * depth_m));
        let (depth_m, position) = places.find(|(_, position)| holds(*position))?;
        Some(Self { position, radius_m: depth_m, intensity: self.intensity * (depth_m / self.radius_m) })
    }
}
