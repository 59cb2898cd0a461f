//! Lamps without extent, for four places at a time.

use glam::Vec3A;
use wide::f32x4;

use super::{Light, SpotCone};
use crate::geometry::lanes::{LaneMask, RayPacket4, SurfacePoints4, Vec3x4};
use crate::scene::objects::Side;
use crate::scene::queries::SceneQueries;

/// Where the light of a lamp without extent comes from.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Source {
    /// A point, that may shine in a cone only.
    Point(Vec3A, Option<SpotCone>),
    /// A direction.
    Distant(Vec3A),
}

/// How light reaches some places, were nothing in between.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Arrivals {
    /// The places that it reaches.
    pub(crate) which: LaneMask,
    /// Cosines between the normals and the directions of the light.
    pub(crate) cos_incidence: f32x4,
    /// Irradiance per unit of the lamp's power.
    pub(crate) irradiance_per_power: f32x4,
}

/// The ways from some points to a lamp.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ways {
    /// Unit directions.
    pub(crate) direction: Vec3x4,
    /// Distances in m, infinite to what is far away.
    pub(crate) distance_m: f32x4,
}

impl Source {
    /// That of a light, if it has no extent.
    pub(crate) fn of(light: &Light) -> Option<Self> {
        match light {
            Light::Point(lamp) => Some(Self::Point(lamp.position, lamp.cone)),
            Light::Directional(lamp) => Some(Self::Distant(lamp.to_light)),
            Light::Sphere(_) | Light::Rectangle(_) | Light::Sky(_) | Light::Image(..) => None,
        }
    }

    /// The ways there.
    #[inline]
    pub(crate) fn ways(&self, from: Vec3x4) -> Ways {
        match *self {
            Self::Point(position, _) => {
                let way = Vec3x4::splat(position) - from;
                let distance_m = way.length();
                Ways { direction: way / distance_m, distance_m }
            }
            Self::Distant(direction) => {
                Ways { direction: Vec3x4::splat(direction), distance_m: f32x4::splat(f32::INFINITY) }
            }
        }
    }

    /// How its light reaches some places.
    #[inline]
    pub(crate) fn arrivals(&self, places: &SurfacePoints4, which: LaneMask) -> Arrivals {
        let way = self.ways(places.point);
        let cos_incidence = places.normal.dot(way.direction);
        let irradiance_per_power = match self {
            Self::Point(_, cone) => {
                let share =
                    |cone: SpotCone| f32x4::new(std::array::from_fn(|lane| cone.share(-way.direction.lane(lane))));
                let within = cone.map_or(f32x4::ONE, share);
                cos_incidence * within / (way.distance_m * way.distance_m)
            }
            Self::Distant(_) => cos_incidence,
        };
        let arrives = cos_incidence.simd_gt(f32x4::ZERO) & irradiance_per_power.simd_gt(f32x4::ZERO);
        Arrivals { which: which & arrives.to_bitmask(), cos_incidence, irradiance_per_power }
    }

    /// The places that nothing hides it from, on one side or the other of an object's surface.
    #[inline]
    pub(crate) fn reaches(
        &self,
        probe: &mut SceneQueries,
        (places, side): (&SurfacePoints4, Side),
        which: LaneMask,
    ) -> LaneMask {
        if which == 0 {
            return 0;
        }
        let origin = places.off_surface(probe.objects().reach_m(side.object()));
        let Ways { direction, distance_m } = self.ways(origin);
        probe.free((&RayPacket4::new(origin, direction), distance_m), side, which)
    }
}
