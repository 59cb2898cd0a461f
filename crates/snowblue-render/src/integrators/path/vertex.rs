//! Surfaces on a path.

use std::f32::consts::PI;

use glam::Vec3A;
use snowblue_geometry::ray::SurfacePoint;

use crate::integrators::pcasnow::snow_vertex::SnowVertex;
use snowblue_light_field::SnowAt;
use snowblue_scene::directions::Directions;
use snowblue_scene::material::deep_snow::DeepSnow;
use snowblue_scene::objects::SurfaceInteraction;
use snowblue_scene::spectrum::Spectrum;

/// A surface on a path, ready to be shaded.
pub(in crate::integrators) struct Vertex<'v, 'a> {
    pub(in crate::integrators) surface: &'v SurfaceInteraction,
    /// The normal that light is reflected by: that for shading with a light field, for PCASnow the geometric one.
    pub(in crate::integrators) normal: Vec3A,
    /// Directions from which the surface reflects light, for samples.
    pub(in crate::integrators) directions: Directions<'a>,
    pub(in crate::integrators) shading: Shading<'v>,
}

/// What a surface reflects and transmits.
pub(in crate::integrators) enum Shading<'a> {
    /// Reflectance of a plain diffuse surface.
    Diffuse(&'a Spectrum),
    /// Reflectance of a textured diffuse surface.
    Textured(Spectrum),
    /// Deep snow.
    Ground(&'a DeepSnow),
    /// Snow by PCASnow.
    Snow(SnowVertex<'a>),
    /// Snow with the light field inside.
    Field(SnowAt<'a>),
}

impl Vertex<'_, '_> {
    /// The point with the normal that light is reflected by.
    #[inline]
    pub(in crate::integrators) fn shading_point(&self) -> SurfacePoint {
        SurfacePoint { point: self.surface.point, normal: self.normal }
    }

    /// Reflectance for light from a direction above the surface, π times the reflection function.
    pub(in crate::integrators) fn reflectance(&self, to_light: Vec3A) -> Spectrum {
        match &self.shading {
            Shading::Diffuse(reflectance) => **reflectance,
            Shading::Textured(reflectance) => *reflectance,
            Shading::Ground(ground) => ground.reflectance(self.normal, self.surface.direction, to_light),
            Shading::Snow(snow) => snow.reflectance(self.normal.dot(to_light).max(0.0)),
            Shading::Field(snow) => {
                let per_sr = snow.optics.surface().reflection_per_sr(self.normal, self.surface.direction, to_light);
                Spectrum::constant(PI * per_sr)
            }
        }
    }
}
