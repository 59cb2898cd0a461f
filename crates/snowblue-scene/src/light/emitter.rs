//! The interface between the file of each kind of light and the code that uses lights.

use std::f32::consts::PI;
use std::fmt::Debug;
use std::sync::Arc;

use glam::Vec3A;
use snowblue_geometry::ray::Ray;
use snowblue_geometry::shape::Shape;

use crate::light::direction_table::DirectionTable;
use crate::light::sample::{LightOrigin, SpotCone};
use crate::spectrum::Spectrum;

/// A kind of light.
///
/// A light without extent needs only the first three methods. A light with extent implements the sampling of itself,
/// and a light with a surface or a disc implements hits of rays. A light whose spectrum varies over its extent
/// implements [`le`](Self::le).
pub(crate) trait Emitter: Debug + Send + Sync + 'static {
    /// What the light is called.
    fn name(&self) -> &'static str;

    /// Where the light is, and whether it has an extent.
    fn light_type(&self) -> LightType;

    /// The power of all origins, as defined by [`le`](Self::le); none if the power differs between origins.
    fn uniform(&self) -> Option<&Spectrum> {
        None
    }

    /// The brightness of each direction by which a distant light is sampled.
    fn table(&self) -> Option<&DirectionTable> {
        None
    }

    /// The power of an origin, as a band density: for a point the radiant intensity in W/sr, for a direction the
    /// irradiance of a facing surface in W/m², for all other origins the radiance in W m⁻² sr⁻¹.
    fn le(&self, _origin: &LightOrigin) -> Spectrum {
        self.uniform().copied().unwrap_or(Spectrum::ZERO)
    }

    /// A sampled point or direction of a light with extent as seen from a point, by two numbers in [0, 1); none if
    /// the light does not shine there. A uniform sky is never sampled this way.
    fn sample_li(&self, _from: Vec3A, numbers: [f32; 2]) -> Option<LightOrigin> {
        self.table().map(|table| LightOrigin::Distant(table.sample(numbers)))
    }

    /// Density of [`sample_li`](Self::sample_li) over the directions from the same point, in 1/sr.
    fn pdf_li(&self, _from: Vec3A, origin: &LightOrigin) -> f32 {
        self.table().map_or(0.0, |table| table.density_per_sr(origin.direction()))
    }

    /// The point where a ray hits the emitting side of a surface before `limit_m`, or the direction in which it hits
    /// a disc.
    fn hit(&self, _ray: &Ray, _limit_m: f32) -> Option<LightOrigin> {
        None
    }

    /// Points at a distance in m before a flat emitting side, spread over this side.
    fn points_before(&self, _distance_m: f32) -> Vec<Vec3A> {
        Vec::new()
    }

    /// The irradiance of a facing surface by a disc, in W/m² as a band density.
    fn normal_irradiance(&self) -> Spectrum {
        Spectrum::ZERO
    }

    /// Whether the light is a sky without edges. Its irradiance of a surface is then as smooth as the occlusion of
    /// the sky.
    fn is_smooth_sky(&self) -> bool {
        false
    }

    /// The light as the sum of a light that rays find by chance and a light that they do not; none if rays find the
    /// whole light, or none of it.
    fn parts(&self) -> Option<[Arc<dyn Emitter>; 2]> {
        None
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
        /// Its apparent area over π, in m².
        spread_m2: f32,
    },
    /// Few directions about a unit vector towards the light, so few that rays do not find them by chance.
    Disc(Vec3A),
    /// All directions.
    Infinite,
    /// All directions with the same radiance, so that sampling by the cosine at a surface is best.
    UniformInfinite,
}

/// Number of depths at which the middle of a lamp in a thin body is sought. Each depth is half of the depth before.
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

    /// The part of a sphere that reaches into a body from outside, as a lamp with the power of this part. If a sphere
    /// of radius r reaches a depth h into level snow, the cap in the snow emits the fraction h/2r of the sphere's
    /// light. In a thin body the lamp lies in the middle of the body. `holds` says whether a point is inside the
    /// body.
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
