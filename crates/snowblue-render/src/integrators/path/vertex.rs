//! Surfaces on a path.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::Vec3A;
use snowblue_database::lookup::SnowMix;

use crate::geometry::chord::{Chord, Line};
use crate::geometry::ray::{SurfacePoint, narrow};
use crate::integrators::path::snow_curves::SnowCurves;
use crate::light_field::SnowAt;
use crate::scene::objects::SurfaceInteraction;
use crate::scene::queries::SceneQueries;
use crate::scene::{PathMode, PcaSnowSettings};
use crate::spectrum::Spectrum;

/// A surface on a path, ready to be shaded.
pub(super) struct Vertex<'a> {
    pub(super) surface: &'a SurfaceInteraction,
    /// The normal that light is reflected by: that for shading with a light field, for PCASnow the geometric one.
    pub(super) normal: Vec3A,
    pub(super) shading: Shading<'a>,
}

/// What a surface reflects and transmits.
pub(super) enum Shading<'a> {
    /// Reflectance of a plain diffuse surface.
    Diffuse(&'a Spectrum),
    /// Reflectance of a textured diffuse surface.
    Textured(Spectrum),
    /// Snow by PCASnow.
    Snow(SnowVertex<'a>),
    /// Snow with the light field inside.
    Field(SnowAt<'a>),
}

/// PCASnow: its settings, and the curves of the snow of each material.
#[derive(Debug, Clone, Copy)]
pub(super) struct PcaSnow<'a> {
    settings: &'a PcaSnowSettings,
    curves: &'a [Option<Arc<SnowCurves>>],
}

/// Snow at a point X_i of its surface.
#[derive(Debug)]
pub(super) struct SnowVertex<'a> {
    pub(super) settings: &'a PcaSnowSettings,
    curves: SnowMix<'a>,
    pub(super) surface: &'a SurfaceInteraction,
    /// The path through the snow that does not depend on the light.
    pub(super) straight: Option<Chord>,
}

impl Vertex<'_> {
    /// The point with the normal that light is reflected by.
    #[inline]
    pub(super) fn shading_point(&self) -> SurfacePoint {
        SurfacePoint { point: self.surface.point, normal: self.normal }
    }

    /// Reflectance for light from a direction above the surface, π times the reflection function.
    pub(super) fn reflectance(&self, to_light: Vec3A) -> Spectrum {
        let (normal, direction) = (self.normal, self.surface.direction);
        let cos_incidence = normal.dot(to_light).max(0.0);
        match &self.shading {
            Shading::Diffuse(reflectance) => **reflectance,
            Shading::Textured(reflectance) => *reflectance,
            Shading::Snow(snow) => snow.reflectance(cos_incidence),
            Shading::Field(snow) => {
                let cos_exit = -normal.dot(direction);
                // Both directions of propagation, projected on the surface.
                let incident = normal * cos_incidence - to_light;
                let exitant = -direction - normal * cos_exit;
                let lengths = (incident.length_squared() * exitant.length_squared()).sqrt();
                let cos_azimuth = if lengths > 1e-12 { incident.dot(exitant) / lengths } else { 0.0 };
                let cos_azimuth = cos_azimuth.clamp(-1.0, 1.0);
                Spectrum::constant(PI * snow.optics.reflection_per_sr(cos_exit, cos_incidence, cos_azimuth))
            }
        }
    }
}

impl<'a> PcaSnow<'a> {
    pub(super) fn new(settings: &'a PcaSnowSettings, curves: &'a [Option<Arc<SnowCurves>>]) -> Self {
        Self { settings, curves }
    }

    /// The snow at a hit on snow.
    #[inline]
    pub(super) fn vertex<'v>(&self, surface: &'v SurfaceInteraction, queries: &mut SceneQueries) -> SnowVertex<'v>
    where
        'a: 'v,
    {
        let Some(curves) = &self.curves[surface.material] else { unreachable!("all snow has curves") };
        let curves = curves.at(queries.objects(), surface);
        let mut snow = SnowVertex { settings: self.settings, curves, surface, straight: None };
        snow.straight = snow.chord(queries, self.settings.path.straight_direction(surface), f32::INFINITY);
        snow
    }
}

impl PathMode {
    /// Direction of the path that does not depend on the light.
    #[inline]
    pub(crate) fn straight_direction(self, surface: &SurfaceInteraction) -> Vec3A {
        match self {
            Self::View => surface.direction,
            Self::Normal | Self::Light | Self::Brightest => -surface.normal,
        }
    }

    /// Whether light comes along that path.
    #[inline]
    pub(super) fn uses_straight(self) -> bool {
        match self {
            Self::View | Self::Normal | Self::Brightest => true,
            Self::Light => false,
        }
    }

    /// Whether light comes along lines to the light.
    #[inline]
    pub(super) fn uses_lines(self) -> bool {
        match self {
            Self::Light | Self::Brightest => true,
            Self::View | Self::Normal => false,
        }
    }
}

impl SnowVertex<'_> {
    /// Index of its material in the scene.
    #[inline]
    pub(super) fn material_index(&self) -> usize {
        self.surface.material
    }

    /// Depth of the snow behind the point, in cm, which determines its reflectance.
    #[inline]
    pub(super) fn depth_cm(&self) -> f32 {
        self.straight.as_ref().map_or(0.0, depth_cm)
    }

    /// Angle of incidence to look up, in degrees.
    #[inline]
    pub(super) fn look_up_angle_deg(&self, cos_incidence: f32) -> f32 {
        self.curves.look_up_angle_deg(cos_incidence)
    }

    /// Reflectance for light at a cosine of incidence.
    pub(super) fn reflectance(&self, cos_incidence: f32) -> Spectrum {
        if let Some(reflectance) = self.settings.reflectance {
            return Spectrum::constant(narrow(reflectance));
        }
        let mut reflectance = Spectrum::ZERO;
        self.curves.reflectance(self.depth_cm(), self.look_up_angle_deg(cos_incidence), &mut reflectance.0);
        reflectance
    }

    /// Transmittance of a depth for light at a cosine of incidence.
    pub(super) fn transmittance(&self, depth_cm: f32, cos_incidence: f32) -> Spectrum {
        let mut transmittance = Spectrum::ZERO;
        self.curves.transmittance(depth_cm, self.look_up_angle_deg(cos_incidence), &mut transmittance.0);
        transmittance
    }

    /// A straight path from the point through the snow.
    #[inline]
    pub(super) fn chord(&self, queries: &mut SceneQueries, direction: Vec3A, end_m: f32) -> Option<Chord> {
        let SurfaceInteraction { object, point, normal, .. } = *self.surface;
        queries.chord(object, &Line { point, normal, direction, end_m }, self.settings.exit)
    }
}

/// Depth of a path in cm, the unit of the table.
#[inline]
pub(super) fn depth_cm(chord: &Chord) -> f32 {
    100.0 * chord.depth_m
}
