//! Single scattering in snow, also exact at edges and rims, where the half-space is inaccurate.
//!
//! The reflection function R₀ holds for a flat, evenly lit half-space. Most of its error near an edge concerns light
//! that scatters once. Along a ray that enters at X, with the scattering at Y and the lights' irradiance E⊥,
//!
//! ```text
//! ∫ κ e^{−κs} P(Y) E⊥(Y) e^{−κ d(Y)} ds,      half-space: d = s μ/μ₀, P and E⊥ of X.
//! ```
//!
//! Both integrals are estimated at one random distance s, so the difference and its noise vanish where the surface is
//! flat. (Habel, Christensen & Jarosz 2013, *Photon beam diffusion*, also separate single scattering.)

use glam::Vec3A;
use snowblue_base::narrow;
use snowblue_geometry::ray::{Ray, SurfacePoint};

use crate::integrators::surroundings::{Flight, SnowBodies, SnowQueries};
use snowblue_light_field::{LightField, SnowAt};
use snowblue_scene::Scene;
use snowblue_scene::light::{IncidentLight, LightSample};
use snowblue_scene::objects::SurfaceInteraction;
use snowblue_scene::queries::Statistics;

/// Traces single scattering.
#[derive(Debug)]
pub(in crate::integrators) struct SingleScattering<'scene> {
    field: &'scene LightField,
    surroundings: SnowQueries<'scene>,
}

/// A scattering at a random distance inside snow.
pub(in crate::integrators) struct ScatteringPoint<'f> {
    snow: SnowAt<'f>,
    distance_m: f32,
    /// The ray, with its origin at the scattering; none if the snow ends before the scattering.
    ray: Option<Ray>,
    direction: Vec3A,
    cos_exit: f32,
}

impl<'scene> SingleScattering<'scene> {
    pub(in crate::integrators) fn new(
        scene: &'scene Scene,
        field: &'scene LightField,
        bodies: &'scene SnowBodies,
    ) -> Self {
        Self { field, surroundings: SnowQueries::new(scene, bodies, &[]) }
    }

    pub(in crate::integrators) fn statistics(&self) -> Statistics {
        self.surroundings.statistics
    }

    /// A scattering along a ray that enters snow, by a random number in [0, 1).
    pub(in crate::integrators) fn point<'f>(
        &mut self,
        snow: SnowAt<'f>,
        surface: &SurfaceInteraction,
        camera_ray: &Ray,
        number: f32,
    ) -> ScatteringPoint<'f> {
        let distance_m = -(1.0 - number).ln() / snow.optics.extinction_per_m();
        let direction = surface.direction;
        let mut ray = *camera_ray;
        let way_out = self.surroundings.enter(surface, &mut ray);
        let flight = way_out.map(|way_out| self.surroundings.fly(surface.object, &ray, distance_m, Some(way_out)));
        let is_inside = matches!(flight, Some(Flight::Free(_)));
        let ray = is_inside.then(|| {
            ray.advance(distance_m);
            ray
        });
        let cos_exit = -surface.normal.dot(direction);
        ScatteringPoint { snow, distance_m, ray, direction, cos_exit }
    }

    /// The single scattering of a light in the body less the single scattering in the half-space, per unit of the
    /// light's power. `incident` is the light on the surface, if the sample is visible there.
    pub(in crate::integrators) fn correction(
        &mut self,
        point: &ScatteringPoint,
        sample: &LightSample,
        incident: Option<&IncidentLight>,
    ) -> f32 {
        let phase = point.snow.optics.surface().half_space().phase();
        let per_sr = |to_light: Vec3A| narrow(phase.per_sr(f64::from(point.direction.dot(to_light))));
        let half_space = incident.map_or(0.0, |incident| {
            let depth =
                point.snow.optics.extinction_per_m() * point.distance_m * point.cos_exit / incident.cos_incidence;
            per_sr(incident.direction) * (-depth).exp() * incident.irradiance_per_power / incident.cos_incidence
        });
        let body = point.ray.map_or(0.0, |ray| {
            let normal = sample.origin.direction_from(ray.origin).direction;
            let Some(incident) = sample.incident_at(&SurfacePoint { point: ray.origin, normal }) else { return 0.0 };
            let depth = self.surroundings.optical_depth(&ray, &sample.origin, &|object| {
                // Unscattered light passes only a few mm of snow: snow of one kind in this body, and hardly any snow
                // of another body.
                self.field.of_object(object).map_or(0.0, |field| {
                    let is_here = std::ptr::eq(field, point.snow.field);
                    if is_here { point.snow.optics } else { field.snow().top() }.extinction_per_m()
                })
            });
            depth.map_or(0.0, |depth| per_sr(normal) * (-depth).exp() * incident.irradiance_per_power)
        });
        body - half_space
    }
}
