//! The half-space of snow that is tangent to a body at the entry of a walk, as a control variate.
//!
//! With the irradiances F by lights that shine on the entry, the diffuse irradiance H, and a fluence rate that is
//! linear inside, the half-space without absorption has the exact radiance
//!
//! ```text
//! L = Σ R₀ F + H/π + K J/π + ℓ* C ∇φ·t/4π,   J = (φ_s − 4E)/3q,   E = Σ K F + H,
//! φ(z) = φ_s + 3 J z/ℓ* + ∇φ·s,
//! ```
//!
//! at the depth z and the displacement s along the surface, where t is the direction of the ray along the surface and
//! C the mean displacement of the walks that end inside (`WalkEnds`). The walk in the half-space has next-event
//! estimation of the same lights, finds H/π where it leaves, and φ/4π where it ends.
//!
//! φ and its gradient are the values of the body's light field a few ℓ* below the entry, at the depth z′ where walks
//! end. With r = (q + z)/(q + z′), φ(z) = r φ(z′) + 4 (1 − r) E. The mean holds for any values, so neither the light
//! field nor H needs to be accurate here.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3A;
use snowblue_base::narrow;
use snowblue_geometry::ray::Ray;
use snowblue_light_field::{EndDepth, KindOptics, LightWeights, NearLight};
use snowblue_scene::light::IncidentLight;
use snowblue_scene::spectrum::Spectrum;

/// The walk in the half-space.
pub(super) struct TangentHalfSpace<'a> {
    optics: &'a KindOptics,
    end_depth: EndDepth,
    near: &'a NearLight<'a>,
    /// The ray from the entry into the snow.
    entry: Ray,
    /// Outward normal at the entry.
    normal: Vec3A,
    lights: Vec<TangentLight>,
    end: Option<End>,
}

/// A light that shines on the half-space.
pub(super) struct TangentLight {
    /// Its number among the lights of the walk.
    index: usize,
    to_light: Vec3A,
    pub(super) cos_incidence: f32,
    /// F, as a band density.
    pub(super) irradiance: Spectrum,
    /// Light that the walk has found: the sum of the phase function over the scatterings that this light reached, in
    /// 1/sr.
    scattered_per_sr: f32,
}

/// How the walk ends.
enum End {
    /// Out of the half-space.
    Outside,
    /// Inside, at an offset from the entry in m.
    Inside(Vec3A),
}

impl TangentLight {
    /// Light number `index` of the walk.
    pub(super) fn new(index: usize, incident: &IncidentLight, power: Spectrum) -> Self {
        Self {
            index,
            to_light: incident.direction,
            cos_incidence: incident.cos_incidence,
            irradiance: power * incident.irradiance_per_power,
            scattered_per_sr: 0.0,
        }
    }
}

impl<'a> TangentHalfSpace<'a> {
    /// The half-space at the entry of a ray, with the outward normal there, lit by lights.
    pub(super) fn new(
        (optics, end_depth): (&'a KindOptics, EndDepth),
        near: &'a NearLight<'a>,
        (entry, normal): (Ray, Vec3A),
        lights: Vec<TangentLight>,
    ) -> Self {
        Self { optics, end_depth, near, entry, normal, lights, end: None }
    }

    pub(super) fn has_ended(&self) -> bool {
        self.end.is_some()
    }

    /// The offset from the entry of a point of a ray, in m.
    fn offset(&self, ray: &Ray, distance_m: f32) -> Vec3A {
        ray.offset_from(&self.entry) + ray.direction * distance_m
    }

    /// The depth of a point at an offset from the entry, in m.
    fn depth_m(&self, offset: Vec3A) -> f32 {
        -offset.dot(self.normal)
    }

    /// Moves the walk along a ray. The walk ends if it leaves the half-space.
    pub(super) fn fly(&mut self, ray: &Ray, flight_m: f32) {
        if self.end.is_none() && self.depth_m(self.offset(ray, flight_m)) < 0.0 {
            self.end = Some(End::Outside);
        }
    }

    /// Joins light number `index` to the scattering at the origin of a ray, if the light is within `seen_m` of snow.
    pub(super) fn join(&mut self, index: usize, ray: &Ray, seen_m: f32) {
        if self.end.is_some() {
            return;
        }
        let depth_m = self.depth_m(self.offset(ray, 0.0));
        if let Some(light) = self.lights.iter_mut().find(|light| light.index == index)
            && depth_m < seen_m * light.cos_incidence
        {
            let cos_scattering = f64::from(ray.direction.dot(light.to_light));
            light.scattered_per_sr += narrow(self.optics.surface().half_space().phase().per_sr(cos_scattering));
        }
    }

    /// Ends the walk a transport mean free path along its ray, if the scattering at the origin of the ray lies deep
    /// enough.
    pub(super) fn end_below(&mut self, ray: &Ray) {
        let transport_length_m = self.optics.transport_length_m();
        let least_m = self.end_depth.lengths() * transport_length_m;
        if self.end.is_none() && self.depth_m(self.offset(ray, 0.0)) >= least_m {
            self.end = Some(End::Inside(self.offset(ray, transport_length_m)));
        }
    }

    /// The mean less the result of the walk, in W m⁻² sr⁻¹ as a band density.
    ///
    /// The mean is computed for the shading normal, so that the surface of a mesh looks smooth where the walks in the
    /// body and in the half-space agree.
    pub(super) fn correction(&self, shading_normal: Vec3A) -> Spectrum {
        let mut sum = self.mean(shading_normal);
        self.subtract_found(&mut sum);
        sum
    }

    /// The depth q + z′, which is (φ(z′) − 4E)/3J, in transport mean free paths.
    fn match_depth(&self) -> f32 {
        narrow(self.optics.surface().half_space().extrapolation()) + self.end_depth.match_lengths()
    }

    /// The mean radiance of a half-space with a normal.
    fn mean(&self, normal: Vec3A) -> Spectrum {
        let direction = self.entry.direction;
        let cos_exit = -normal.dot(direction);
        let along = direction + normal * cos_exit;
        let escape = self.optics.surface().escape(cos_exit) / (3.0 * PI * self.match_depth());
        let displacement_m = self.optics.mean_displacement_m(self.end_depth, cos_exit);
        let mut sum = self.near.sum(&LightWeights {
            fluence: escape,
            gradient: along.normalize_or_zero() * (0.25 * FRAC_1_PI * displacement_m),
            diffuse: FRAC_1_PI - 4.0 * escape,
        });
        for TangentLight { to_light, cos_incidence, irradiance, .. } in &self.lights {
            let cos = normal.dot(*to_light);
            if cos <= 0.0 {
                continue;
            }
            let reflection = self.optics.surface().reflection_per_sr(normal, direction, *to_light);
            sum +=
                *irradiance * (cos / cos_incidence * (reflection - 4.0 * escape * self.optics.surface().escape(cos)));
        }
        sum
    }

    /// Subtracts the result of the walk.
    fn subtract_found(&self, sum: &mut Spectrum) {
        let normal = self.normal;
        let (mut weights, mut entering) = (LightWeights { fluence: 0.0, gradient: Vec3A::ZERO, diffuse: 0.0 }, 0.0);
        match self.end {
            Some(End::Inside(offset)) => {
                let depth = narrow(self.optics.surface().half_space().extrapolation())
                    + self.depth_m(offset) / self.optics.transport_length_m();
                let share = depth / self.match_depth();
                weights.fluence = -0.25 * FRAC_1_PI * share;
                weights.gradient = (offset - normal * normal.dot(offset)) * (-0.25 * FRAC_1_PI);
                entering = FRAC_1_PI * (1.0 - share);
                weights.diffuse = -entering;
            }
            Some(End::Outside) | None => weights.diffuse = -FRAC_1_PI,
        }
        *sum += self.near.sum(&weights);
        for TangentLight { cos_incidence, irradiance, scattered_per_sr, .. } in &self.lights {
            let found = scattered_per_sr / cos_incidence + entering * self.optics.surface().escape(*cos_incidence);
            *sum += *irradiance * -found;
        }
    }
}
