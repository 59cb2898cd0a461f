//! Snow in PCASnow: a point of its surface, with its curves and the straight path through the snow.

mod curves;
mod transmission;

use std::sync::Arc;

use glam::Vec3A;
use snowblue_database::lookup::SnowMix;
use snowblue_geometry::body::{Chord, Line};
use snowblue_scene::material::snow::SnowKinds;
use snowblue_scene::objects::SurfaceInteraction;
use snowblue_scene::queries::SceneQueries;
use snowblue_scene::spectrum::Spectrum;
use snowblue_scene::{PathMode, PcaSnowSettings};

pub(super) use curves::{SnowCurves, TableCurves};

/// PCASnow: its settings, and the curves of the snow of each material.
#[derive(Debug, Clone, Copy)]
pub(in crate::integrators) struct PcaSnow<'a> {
    settings: &'a PcaSnowSettings,
    curves: &'a [Option<Arc<SnowCurves>>],
}

/// Snow at a point X_i of its surface.
#[derive(Debug)]
pub(in crate::integrators) struct SnowVertex<'a> {
    pub(in crate::integrators) settings: &'a PcaSnowSettings,
    kinds: &'a SnowKinds,
    curves: SnowMix<'a>,
    pub(in crate::integrators) surface: &'a SurfaceInteraction,
    /// The path through the snow that does not depend on the light.
    pub(in crate::integrators) straight: Option<Chord>,
}

impl<'a> PcaSnow<'a> {
    pub(in crate::integrators) fn new(settings: &'a PcaSnowSettings, curves: &'a [Option<Arc<SnowCurves>>]) -> Self {
        Self { settings, curves }
    }

    /// The snow at a hit on snow.
    #[inline]
    pub(in crate::integrators) fn at<'v>(
        &self,
        surface: &'v SurfaceInteraction,
        queries: &mut SceneQueries,
    ) -> SnowVertex<'v>
    where
        'a: 'v,
    {
        let Some(curves) = &self.curves[surface.material] else { unreachable!("all snow has curves") };
        let kinds = curves.kinds();
        let curves = curves.at(queries.objects(), surface);
        let mut snow = SnowVertex { settings: self.settings, kinds, curves, surface, straight: None };
        snow.straight = snow.chord(queries, straight_direction(self.settings.path, surface), f32::INFINITY);
        snow
    }
}

/// Direction of the path through snow that does not depend on the light.
#[inline]
pub(in crate::integrators) fn straight_direction(path: PathMode, surface: &SurfaceInteraction) -> Vec3A {
    match path {
        PathMode::View => surface.direction,
        PathMode::Normal | PathMode::Light | PathMode::Brightest => -surface.normal,
    }
}

impl SnowVertex<'_> {
    /// The kinds of the snow, and where they lie.
    pub(in crate::integrators) fn kinds(&self) -> &SnowKinds {
        self.kinds
    }

    /// Index of its material in the scene.
    #[inline]
    pub(in crate::integrators) fn material_index(&self) -> usize {
        self.surface.material
    }

    /// Depth of the snow behind the point, in cm, which determines its reflectance.
    #[inline]
    pub(in crate::integrators) fn depth_cm(&self) -> f32 {
        self.straight.as_ref().map_or(0.0, depth_cm)
    }

    /// Angle of incidence to look up, in degrees.
    #[inline]
    pub(in crate::integrators) fn look_up_angle_deg(&self, cos_incidence: f32) -> f32 {
        self.curves.look_up_angle_deg(cos_incidence)
    }

    /// Reflectance for light at a cosine of incidence.
    pub(in crate::integrators) fn reflectance(&self, cos_incidence: f32) -> Spectrum {
        let angle_deg = self.look_up_angle_deg(cos_incidence);
        curves::reflectance(self.settings, &self.curves, self.depth_cm(), angle_deg)
    }

    /// Transmittance of a depth for light at a cosine of incidence.
    pub(in crate::integrators) fn transmittance(&self, depth_cm: f32, cos_incidence: f32) -> Spectrum {
        let mut transmittance = Spectrum::ZERO;
        self.curves.transmittance(depth_cm, self.look_up_angle_deg(cos_incidence), &mut transmittance.0);
        transmittance
    }

    /// A straight path from the point through the snow.
    #[inline]
    pub(in crate::integrators) fn chord(
        &self,
        queries: &mut SceneQueries,
        direction: Vec3A,
        end_m: f32,
    ) -> Option<Chord> {
        let SurfaceInteraction { object, point, normal, .. } = *self.surface;
        queries.chord(object, &Line { point, normal, direction, end_m })
    }
}

/// Depth of a path in cm, the unit of the table.
#[inline]
pub(in crate::integrators) fn depth_cm(chord: &Chord) -> f32 {
    100.0 * chord.depth_m
}
