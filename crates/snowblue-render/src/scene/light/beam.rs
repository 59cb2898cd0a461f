//! Light from one point of a lamp or from one direction, and how it reaches a surface.

use std::f32::consts::PI;

use glam::Vec3A;

use crate::scene::objects::Side;
use crate::scene::queries::SceneQueries;
use crate::spectrum::Spectrum;

/// Share of the way to a lamp, just before it, on which nothing hides it, lest a surface that it lies on does by rounding.
pub(crate) const TOUCHING: f32 = 1e-4;

/// A point of a lamp's surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct EmitterPoint {
    /// The point.
    pub(super) position: Vec3A,
    /// Unit normal on the bright side.
    pub(super) normal: Vec3A,
}

/// Where light comes from.
#[derive(Debug, Clone, Copy)]
pub(crate) enum LightOrigin {
    /// A lamp without extent.
    Point(Vec3A),
    /// A point of a lamp with extent.
    EmitterPoint(EmitterPoint),
    /// A direction from far away.
    Distant(Vec3A),
}

/// A surface point with its normal.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SurfacePoint {
    /// The point.
    pub(crate) point: Vec3A,
    /// Unit normal on the side that is lit.
    pub(crate) normal: Vec3A,
}

/// Light from one point or direction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LightSample {
    /// Where it comes from.
    pub(crate) origin: LightOrigin,
    /// Radiant intensity of a point, radiance of a patch or direction, irradiance of a distant lamp, as a band density.
    pub(crate) power: Spectrum,
    /// How the irradiance of a surface follows from the power.
    pub(super) falloff: Falloff,
}

/// How irradiance follows from a beam's power.
#[derive(Debug, Clone, Copy)]
pub(super) enum Falloff {
    /// By the cosine and, of a point, the square of the distance.
    Natural,
    /// The same of a point that shines within a cone.
    Within(SpotCone),
    /// As that of an origin that was drawn.
    Drawn {
        /// Density with which it was drawn, per m² of a lamp or per sr of directions.
        density: f32,
        /// The area of the lamp over π, in m²; 0 for directions.
        spread_m2: f32,
    },
    /// None: E = π times the power wherever the light arrives, so that what is white shows the power as a radiance.
    None,
}

/// A cone of light: full about its axis, fading towards its rim as KHR_lights_punctual of glTF has it (Khronos Group
/// 2020), by the square of a straight line in the cosine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpotCone {
    axis: Vec3A,
    cos_rim: f32,
    rise: f32,
}

impl SpotCone {
    /// A cone about the unit vector `axis`, full within half an opening of `inner_deg` and dark beyond `outer_deg`.
    pub fn new(axis: Vec3A, inner_deg: f32, outer_deg: f32) -> Self {
        /// Least difference of the cosines, of the same source.
        const LEAST: f32 = 1e-3;
        let [cos_inner, cos_rim] = [inner_deg, outer_deg].map(|angle_deg| angle_deg.to_radians().cos());
        Self { axis, cos_rim, rise: (cos_inner - cos_rim).max(LEAST).recip() }
    }

    /// What goes in a direction, as a share of what goes along the axis.
    pub(super) fn share(&self, direction: Vec3A) -> f32 {
        let linear = ((self.axis.dot(direction) - self.cos_rim) * self.rise).clamp(0.0, 1.0);
        linear * linear
    }
}

/// How a beam reaches a surface, were nothing in between.
#[derive(Debug, Clone, Copy)]
pub(crate) struct IncidentLight {
    /// Cosine between the normal and the direction of the light, above 0.
    pub(crate) cos_incidence: f32,
    /// Irradiance per unit of the beam's power.
    pub(crate) irradiance_per_power: f32,
    /// Cosine at the lamp between its normal and the direction of the place; 1 for lights without a surface.
    pub(crate) cos_emission: f32,
}

/// The way from a point to a beam's origin.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LightDirection {
    /// Unit direction.
    pub(crate) direction: Vec3A,
    /// Distance in m, infinite to what is far away.
    pub(crate) distance_m: f32,
}

impl LightOrigin {
    /// The way there.
    pub(crate) fn way(&self, from: Vec3A) -> LightDirection {
        let way = self.towards(from);
        if let Self::Distant(_) = self {
            return LightDirection { direction: way, distance_m: f32::INFINITY };
        }
        let distance_m = way.length();
        LightDirection { direction: way / distance_m, distance_m }
    }

    /// The direction there: as long as the way to a lamp, of unit length to what is far away.
    #[inline]
    fn towards(&self, from: Vec3A) -> Vec3A {
        match *self {
            Self::Point(position) | Self::EmitterPoint(EmitterPoint { position, .. }) => position - from,
            Self::Distant(direction) => direction,
        }
    }

    /// Area of the lamp per solid angle seen from a point, r² / cos θ_l in m²/sr: r² for a lamp without extent, 1 for a
    /// direction, and infinite from behind.
    pub(super) fn own_per_solid_angle(&self, from: Vec3A) -> f32 {
        match self {
            Self::Point(position) => position.distance_squared(from),
            Self::EmitterPoint(patch) => {
                let way = from - patch.position;
                let squared = way.length_squared();
                let towards = patch.normal.dot(way);
                if towards > 0.0 { squared * squared.sqrt() / towards } else { f32::INFINITY }
            }
            Self::Distant(_) => 1.0,
        }
    }
}

impl LightSample {
    /// How it reaches a place, or none if it comes from below the horizon or from behind the lamp.
    #[inline]
    pub(crate) fn arrival(&self, place: &SurfacePoint) -> Option<IncidentLight> {
        if place.normal.dot(self.origin.towards(place.point)) <= 0.0 {
            return None;
        }
        let way = self.origin.way(place.point);
        let cos_incidence = place.normal.dot(way.direction);
        let irradiance_per_power = match self.falloff {
            Falloff::None => PI,
            Falloff::Natural => cos_incidence / self.origin.own_per_solid_angle(place.point),
            Falloff::Within(cone) => {
                cos_incidence * cone.share(-way.direction) / self.origin.own_per_solid_angle(place.point)
            }
            Falloff::Drawn { density, .. } => cos_incidence / (density * self.origin.own_per_solid_angle(place.point)),
        };
        let cos_emission = match &self.origin {
            LightOrigin::EmitterPoint(patch) => patch.normal.dot((place.point - patch.position).normalize()),
            LightOrigin::Point(_) | LightOrigin::Distant(_) => 1.0,
        };
        (cos_incidence > 0.0 && cos_emission > 0.0 && irradiance_per_power > 0.0).then_some(IncidentLight {
            cos_incidence,
            irradiance_per_power,
            cos_emission,
        })
    }

    /// How it reaches the place where the line to it leaves a body.
    ///
    /// Each point of a lamp then shines on a place of its own. Lest a lamp at the surface shine without bound, r² counts
    /// as r² + A/π: the irradiance of all points together is at most π L, as on the axis of a disc of the same area.
    pub(crate) fn arrival_on_line(&self, place: &SurfacePoint) -> Option<IncidentLight> {
        let mut arrival = self.arrival(place)?;
        if let (LightOrigin::EmitterPoint(patch), Falloff::Drawn { spread_m2, .. }) = (self.origin, self.falloff) {
            let squared = patch.position.distance_squared(place.point);
            arrival.irradiance_per_power *= squared / (squared + spread_m2);
        }
        Some(arrival)
    }

    /// Its arrival from within at a place that faces it, bounded alike.
    pub(crate) fn arrival_within(&self, point: Vec3A) -> Option<IncidentLight> {
        let arrival = self.arrival_on_line(&SurfacePoint { point, normal: self.origin.way(point).direction })?;
        // It faces the light, whatever rounding makes of that.
        Some(IncidentLight { cos_incidence: 1.0, ..arrival })
    }

    /// Whether nothing hides it from a place, on one side or the other of an object's surface.
    pub(crate) fn reaches(&self, probe: &mut SceneQueries, place: &SurfacePoint, side: Side) -> bool {
        let from = probe.off_surface(side.object(), place.point, place.normal);
        match self.origin {
            LightOrigin::Point(position) => probe.sees(from, side, position),
            LightOrigin::EmitterPoint(patch) => probe.sees(from, side, patch.position.lerp(place.point, TOUCHING)),
            LightOrigin::Distant(direction) => probe.sees_far(from, side, direction),
        }
    }
}
