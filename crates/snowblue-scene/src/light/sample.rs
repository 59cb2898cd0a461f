//! One point of a light, or one direction of a distant light, and the light that arrives from there at a surface.

use std::f32::consts::PI;

use glam::Vec3A;
use snowblue_geometry::ray::SurfacePoint;

use crate::objects::Side;
use crate::queries::SceneQueries;

/// Shadow rays end short of a light by this fraction of the distance, so that rounding does not make a surface
/// occlude a light that lies on it.
pub const SHADOW_EPSILON: f32 = 1e-4;

/// A point on the surface of an area light.
#[derive(Debug, Clone, Copy)]
pub struct EmitterPoint {
    /// The point, in m.
    pub position: Vec3A,
    /// Unit normal of the side that emits.
    pub normal: Vec3A,
}

/// Where light comes from.
#[derive(Debug, Clone, Copy)]
pub enum LightOrigin {
    /// A point light, in m.
    Point(Vec3A),
    /// A point on an area light.
    Emitter(EmitterPoint),
    /// Unit direction towards a distant light or a point of the sky.
    Distant(Vec3A),
}

/// Light from one origin.
#[derive(Debug, Clone, Copy)]
pub struct LightSample {
    /// The origin of the light.
    pub origin: LightOrigin,
    /// How the irradiance of a surface follows from the power of the light.
    pub(super) falloff: Falloff,
}

/// How irradiance follows from the [power](super::Light::power) of a light.
#[derive(Debug, Clone, Copy)]
pub(super) enum Falloff {
    /// By the cosine, and for a point by the square of the distance.
    Natural,
    /// As `Natural`, for a point light that shines within a cone.
    Spot(SpotCone),
    /// For a sampled origin: the cosine over the density of the sample.
    Sampled {
        /// Density of the sample, per m² of an area light or per sr of directions.
        density: f32,
        /// Area of the light over π, in m²; 0 for directions.
        spread_m2: f32,
    },
    /// None: E = π times the power, so that a white surface shows the power as a radiance.
    None,
}

/// A cone of light, full within the inner angle and dark beyond the outer angle. Between the two angles, the falloff
/// is the square of a linear function of the cosine, as in KHR_lights_punctual of glTF (Khronos Group 2020).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SpotCone {
    axis: Vec3A,
    cos_outer: f32,
    slope: f32,
}

impl SpotCone {
    /// A cone about the unit vector `axis`, full up to `inner_deg` from the axis and dark beyond `outer_deg`.
    pub(crate) fn new(axis: Vec3A, inner_deg: f32, outer_deg: f32) -> Self {
        /// Smallest difference of the two cosines, from the specification of KHR_lights_punctual.
        const MIN_DIFFERENCE: f32 = 1e-3;
        let [cos_inner, cos_outer] = [inner_deg, outer_deg].map(|angle_deg| angle_deg.to_radians().cos());
        Self { axis, cos_outer, slope: (cos_inner - cos_outer).max(MIN_DIFFERENCE).recip() }
    }

    /// Intensity in a direction as a fraction of the intensity along the axis.
    pub(super) fn fraction(&self, direction: Vec3A) -> f32 {
        let linear = ((self.axis.dot(direction) - self.cos_outer) * self.slope).clamp(0.0, 1.0);
        linear * linear
    }
}

/// Light that arrives at a surface point, without regard to visibility.
#[derive(Debug, Clone, Copy)]
pub struct IncidentLight {
    /// Unit direction towards the light.
    pub direction: Vec3A,
    /// Cosine between the normal and the direction towards the light, above 0.
    pub cos_incidence: f32,
    /// Irradiance per unit of the light's power.
    pub irradiance_per_power: f32,
    /// Cosine between the normal of the light and the direction towards the surface; 1 for lights without a surface.
    pub cos_emission: f32,
}

/// Direction and distance from a point towards a light.
#[derive(Debug, Clone, Copy)]
pub struct LightDirection {
    /// Unit direction.
    pub direction: Vec3A,
    /// Distance in m, infinite for distant lights.
    pub distance_m: f32,
}

impl LightOrigin {
    /// Direction and distance from a point towards the light.
    #[inline]
    pub fn direction_from(&self, point: Vec3A) -> LightDirection {
        let offset = self.offset_from(point);
        if let Self::Distant(_) = self {
            return LightDirection { direction: offset, distance_m: f32::INFINITY };
        }
        let distance_m = offset.length();
        LightDirection { direction: offset / distance_m, distance_m }
    }

    /// Unit direction from the origin of coordinates. The direction of a distant light is the same from everywhere.
    pub(super) fn direction(&self) -> Vec3A {
        self.direction_from(Vec3A::ZERO).direction
    }

    /// Position of the light in m; none for a distant light.
    pub fn position(&self) -> Option<Vec3A> {
        match *self {
            Self::Point(position) | Self::Emitter(EmitterPoint { position, .. }) => Some(position),
            Self::Distant(_) => None,
        }
    }

    /// The vector from a point to the light; a unit vector for distant lights.
    #[inline]
    fn offset_from(&self, point: Vec3A) -> Vec3A {
        match *self {
            Self::Point(position) | Self::Emitter(EmitterPoint { position, .. }) => position - point,
            Self::Distant(direction) => direction,
        }
    }

    /// Area of the light per solid angle seen from a point, r² / cos θ_l in m²/sr: r² for a point light, 1 for a
    /// direction, and infinite from behind.
    #[inline]
    pub(super) fn area_per_solid_angle(&self, point: Vec3A) -> f32 {
        match self {
            Self::Point(position) => position.distance_squared(point),
            Self::Emitter(emitter) => {
                let offset = point - emitter.position;
                let squared = offset.length_squared();
                let along_normal = emitter.normal.dot(offset);
                if along_normal > 0.0 { squared * squared.sqrt() / along_normal } else { f32::INFINITY }
            }
            Self::Distant(_) => 1.0,
        }
    }
}

impl LightSample {
    /// The light that arrives at a surface point; none from below the horizon or from behind the light.
    #[inline]
    pub fn incident_at(&self, surface: &SurfacePoint) -> Option<IncidentLight> {
        if surface.normal.dot(self.origin.offset_from(surface.point)) <= 0.0 {
            return None;
        }
        let LightDirection { direction, .. } = self.origin.direction_from(surface.point);
        let cos_incidence = surface.normal.dot(direction);
        let area_per_solid_angle = || self.origin.area_per_solid_angle(surface.point);
        let irradiance_per_power = match self.falloff {
            Falloff::None => PI,
            Falloff::Natural => cos_incidence / area_per_solid_angle(),
            Falloff::Spot(cone) => cos_incidence * cone.fraction(-direction) / area_per_solid_angle(),
            Falloff::Sampled { density, .. } => cos_incidence / (density * area_per_solid_angle()),
        };
        let cos_emission = match &self.origin {
            LightOrigin::Emitter(emitter) => emitter.normal.dot((surface.point - emitter.position).normalize()),
            LightOrigin::Point(_) | LightOrigin::Distant(_) => 1.0,
        };
        (cos_incidence > 0.0 && cos_emission > 0.0 && irradiance_per_power > 0.0).then_some(IncidentLight {
            direction,
            cos_incidence,
            irradiance_per_power,
            cos_emission,
        })
    }

    /// The light that arrives at the point where the line towards the light leaves a body.
    ///
    /// Each point of an area light then illuminates its own exit point, so that the irradiance by a light at the
    /// surface would be unbounded. Therefore r² is replaced by r² + A/π, with the area A of the light. The irradiance
    /// by all points together is then at most π L, as on the axis of a disc of area A.
    #[inline]
    pub fn incident_along_line(&self, surface: &SurfacePoint) -> Option<IncidentLight> {
        let mut incident = self.incident_at(surface)?;
        if let (LightOrigin::Emitter(emitter), Falloff::Sampled { spread_m2, .. }) = (self.origin, self.falloff) {
            let squared = emitter.position.distance_squared(surface.point);
            incident.irradiance_per_power *= squared / (squared + spread_m2);
        }
        Some(incident)
    }

    /// The light that arrives at a point inside a body, on a surface that faces the light, with the bound of
    /// [`incident_along_line`](Self::incident_along_line).
    #[inline]
    pub fn incident_inside(&self, point: Vec3A) -> Option<IncidentLight> {
        let normal = self.origin.direction_from(point).direction;
        let incident = self.incident_along_line(&SurfacePoint { point, normal })?;
        // The cosine is exactly 1, without rounding.
        Some(IncidentLight { cos_incidence: 1.0, ..incident })
    }

    /// The share of the light that passes other surfaces on the way to a point on one side of an object's surface.
    #[inline]
    pub fn transmittance(&self, queries: &mut SceneQueries, surface: &SurfacePoint, side: Side) -> f32 {
        let from = queries.off_surface(side.object(), surface);
        match self.origin {
            LightOrigin::Point(position) => queries.transmittance_to(from, side, position),
            LightOrigin::Emitter(emitter) => {
                queries.transmittance_to(from, side, emitter.position.lerp(surface.point, SHADOW_EPSILON))
            }
            LightOrigin::Distant(direction) => queries.transmittance_to_distant(from, side, direction),
        }
    }
}
