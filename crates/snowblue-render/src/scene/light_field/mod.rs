//! The light field inside each body of snow of a scene, for the integrators `diffusion` and `hybrid`.
//!
//! The light that enters at the surface ([`surface_light`]) determines the fluence rate inside
//! ([`snowblue_field`]), and that the net flux J through the surface at each wavelength. Snow then sends out
//!
//! L(μ) = Σ R₀(μ, μ₀, Δϕ) F + K(μ) J/π.

mod solid;
mod surface_light;

use std::f32::consts::PI;

use glam::{DVec3, Vec3A};
use snowblue_field::{Diffusion, DiffusionAt, Fluence, GridOptions, SnowBody, SnowOptics, SpectralNodes};
use wide::f32x4;

use crate::geometry::ray::narrow;
use crate::scene::light::Light;
use crate::scene::objects::Objects;
use crate::spectrum::{SAMPLES, Spectrum};

pub(crate) use solid::Solid;
use surface_light::{SurfaceLight, surface_light};

/// Memory of the grid of a body, in MiB.
const MEMORY_MIB: u64 = 1024;
/// Most groups of four spectral nodes.
const MOST_NODES: usize = 16;

/// The light in all snow of a scene.
#[derive(Debug)]
pub(crate) struct LightField {
    bodies: Vec<BodyField>,
    /// The body of each object.
    body_of: Vec<Option<usize>>,
}

/// The light in a body of snow.
pub(crate) struct BodyField {
    body: SnowBody,
    fluence: Fluence,
    nodes: SpectralNodes,
    optics: SnowOptics,
    /// ℓ* times the spectrum of the light that enters: spectra over this are smooth in the absorption.
    scale: Spectrum,
    /// ℓ* at the middle wavelength, in m.
    transport_length_m: f32,
}

impl LightField {
    /// Solves for the light of all bodies. `snow` gives the optics of an object's snow, if it is snow.
    ///
    /// # Errors
    ///
    /// With the object's index and the reason, if a body has no grid.
    pub(crate) fn new(
        objects: &Objects,
        lights: &[Light],
        snow: &dyn Fn(usize) -> Option<SnowOptics>,
    ) -> Result<Self, (usize, String)> {
        let mut field = Self { bodies: Vec::new(), body_of: vec![None; objects.list().len()] };
        for object in 0..objects.list().len() {
            let Some(optics) = snow(object).filter(|_| field.body_of[object].is_none()) else { continue };
            let members = objects.body_of(object);
            for member in members {
                field.body_of[*member] = Some(field.bodies.len());
            }
            let solid = Solid::new(objects, object).ok_or_else(|| (object, "has no end".to_owned()))?;
            let body = BodyField::new(&solid, optics, lights).map_err(|reason| (object, reason))?;
            field.bodies.push(body);
        }
        Ok(field)
    }

    /// The light in the body that an object of snow belongs to.
    #[inline]
    pub(crate) fn of_object(&self, object: usize) -> Option<&BodyField> {
        self.body_of[object].map(|body| &self.bodies[body])
    }
}

impl BodyField {
    fn new(solid: &Solid, optics: SnowOptics, lights: &[Light]) -> Result<Self, String> {
        let thickness_m = snowblue_field::mean_thickness_m(solid).map_err(|error| error.to_string())?;
        let nodes = SpectralNodes::for_thickness(&optics.transport_lengths_m, &optics.absorption_per_m, thickness_m);
        let groups = nodes.indices().len() / snowblue_field::GROUP;
        let shortest_m = optics.transport_lengths_m.iter().copied().fold(f64::INFINITY, f64::min);
        let step_m = snowblue_field::choose_step_m(solid, shortest_m, groups, MEMORY_MIB);
        let step_m = step_m.map_err(|error| error.to_string())?;
        let lengths: Vec<f32x4> = nodes.gather(|index| narrow(optics.transport_lengths_m[index])).collect();
        let absorption: Vec<f32x4> = nodes.gather(|index| narrow(optics.absorption_per_m[index])).collect();
        let diffusion = lengths.into_iter().zip(absorption).map(|(transport_length_m, absorption_per_m)| {
            let everywhere = Diffusion { transport_length_m, absorption_per_m };
            Box::new(move |_| everywhere) as DiffusionAt
        });
        let options = GridOptions { step_m, shift: DVec3::ZERO };
        let body = SnowBody::new(solid, options, diffusion.collect(), optics.half_space.extrapolation());
        let SurfaceLight { groups, reference } = surface_light(solid, &body, lights, &nodes, &optics.half_space);
        let groups: Vec<&[f32x4]> = groups.iter().map(Vec::as_slice).collect();
        let fluence = body.solve(&groups);
        let scale = |index: usize| narrow(optics.transport_lengths_m[index]) * reference.0[index];
        let transport_length_m = narrow(optics.transport_lengths_m[SAMPLES / 2]);
        Ok(Self { body, fluence, nodes, scale: Spectrum(std::array::from_fn(scale)), optics, transport_length_m })
    }

    /// Radiance that leaves a surface point by diffusion, K(μ) J/π, in W m⁻² sr⁻¹ as a band density. It is negative
    /// where the surface is lit: it lacks what does not return of the light that the reflection function reflects.
    pub(crate) fn diffuse_radiance(&self, point: Vec3A, normal: Vec3A, cos_exit: f32) -> Spectrum {
        let flux = self.flux(point, normal);
        flux * (narrow(self.optics.half_space.escape(f64::from(cos_exit))) / PI)
    }

    /// The reflection function R₀, in 1/sr.
    #[inline]
    pub(crate) fn reflection_per_sr(&self, cos_exit: f32, cos_incidence: f32, cos_azimuth: f32) -> f32 {
        let [exit, incidence, azimuth] = [cos_exit, cos_incidence, cos_azimuth].map(f64::from);
        narrow(self.optics.half_space.reflection(exit, incidence, azimuth))
    }

    /// Transport mean free path at the middle wavelength, in m.
    #[inline]
    pub(crate) fn transport_length_m(&self) -> f32 {
        self.transport_length_m
    }

    /// The fluence rate inside, in W m⁻² as a band density.
    pub(crate) fn fluence(&self, point: Vec3A) -> Spectrum {
        self.body
            .fluence(&self.fluence, point.as_dvec3(), DVec3::ZERO)
            .map_or(Spectrum::ZERO, |groups| self.spectrum(groups))
    }

    /// The net flux outwards through the surface, in W m⁻² as a band density.
    fn flux(&self, point: Vec3A, normal: Vec3A) -> Spectrum {
        let groups = self.body.flux(&self.fluence, point.as_dvec3(), normal.as_dvec3());
        groups.map_or(Spectrum::ZERO, |groups| self.spectrum(groups))
    }

    /// All wavelengths of a quantity at the spectral nodes: by its logarithm, or directly where it is not positive.
    fn spectrum(&self, groups: impl Iterator<Item = f32x4>) -> Spectrum {
        let mut at_nodes = [0.0; MOST_NODES];
        for (values, group) in at_nodes.chunks_exact_mut(snowblue_field::GROUP).zip(groups) {
            values.copy_from_slice(group.as_array());
        }
        let indices = self.nodes.indices();
        let at_nodes = &mut at_nodes[..indices.len()];
        let is_positive = at_nodes.iter().all(|value| *value > 0.0);
        for (value, index) in at_nodes.iter_mut().zip(indices) {
            let scale = self.scale.0[*index];
            *value = if scale > 0.0 { *value / scale } else { 0.0 };
            if is_positive {
                *value = value.max(f32::MIN_POSITIVE).ln();
            }
        }
        let value = |wavelength: usize| {
            let value = self.nodes.interpolate(wavelength, at_nodes);
            (if is_positive { value.exp() } else { value }) * self.scale.0[wavelength]
        };
        Spectrum(std::array::from_fn(value))
    }
}

impl std::fmt::Debug for BodyField {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("BodyField").field("nodes", &self.body.node_count()).finish_non_exhaustive()
    }
}
