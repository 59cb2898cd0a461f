//! Light through snow: Algorithm 1 of Varsa & Baranoski (2024), and the other path modes of
//! [`pca_snow`](crate::scene::material::pca_snow).

use std::f32::consts::FRAC_1_PI;

use super::carried::{Carried, LightTables, Source};
use super::vertex::{SnowVertex, depth_cm};
use crate::geometry::chord::{Chord, ChordEnd, Exit};
use crate::geometry::ray::SurfacePoint;
use crate::sampling::Sampler;
use crate::scene::Scene;
use crate::scene::light::{IncidentLight, Light, LightDirection, LightSample, SamplingTechniques};
use crate::scene::material::pca_snow::Emission;
use crate::scene::objects::Side;
use crate::scene::queries::SceneQueries;

/// A path of light through the snow.
#[derive(Debug, Clone, Copy)]
struct Passage {
    /// Depth of the snow d, in cm.
    depth_cm: f32,
    /// The light that arrives at the entry X_t, visibility aside.
    incident: IncidentLight,
    /// The entry and its side of the surface; none for a light inside the snow.
    entry: Option<(SurfacePoint, Side)>,
}

impl SnowVertex<'_> {
    /// Light from the lights that comes through the snow.
    #[inline]
    pub(super) fn transmitted<C: Carried>(
        &self,
        scene: &Scene,
        tables: &LightTables,
        queries: &mut SceneQueries,
        sampler: &mut Sampler,
    ) -> C {
        let mut transmitted = C::ZERO;
        let emission = self.material.emission;
        for (index, light) in scene.lights.iter().enumerate() {
            let mut add = |sample: &LightSample| {
                let source = Source::new(scene, tables, index, sample, emission);
                if let Some(radiance) = self.through::<C>(tables, queries, &source, sample) {
                    transmitted += radiance;
                }
            };
            match emission {
                Emission::Transmitted => {
                    if let Some(sample) = tables.delta_sample(index) {
                        add(sample);
                        continue;
                    }
                }
                Emission::Relative => {
                    if let Some(sample) = light.central_sample() {
                        add(&sample);
                        continue;
                    }
                }
            }
            let techniques = self.techniques(light);
            for chosen in 0..techniques.len() {
                if let Some(sample) = light.sample(chosen, &techniques, sampler) {
                    add(&sample);
                }
            }
        }
        transmitted
    }

    /// Techniques that sample a light: as seen from the exit of the straight path, and from the point itself for lines
    /// to the light.
    fn techniques(&self, light: &Light) -> SamplingTechniques {
        let exit = match self.straight.map(|chord| chord.exit) {
            Some(ChordEnd::Surface { point, normal, .. }) if self.material.path.uses_straight() => {
                Some(SurfacePoint { point, normal })
            }
            _ => None,
        };
        let inward = SurfacePoint { point: self.surface.point, normal: -self.surface.normal };
        light.techniques_through(exit.as_ref(), self.material.path.uses_lines().then_some(&inward))
    }

    /// Light of one sample that comes through the snow, L = T E / π, by the path mode.
    ///
    /// Of two paths the brighter counts, or the other where the brighter is occluded. They are compared as if an area
    /// light were isotropic: otherwise its emission cosine would split its points between the paths.
    #[inline]
    fn through<C: Carried>(
        &self,
        tables: &LightTables,
        queries: &mut SceneQueries,
        source: &Source,
        sample: &LightSample,
    ) -> Option<C> {
        let mode = self.material.path;
        let straight = self.straight.as_ref().filter(|_| mode.uses_straight());
        let straight = straight.and_then(|chord| self.along_straight(sample, chord));
        let line = if mode.uses_lines() { self.along_line(queries, sample) } else { None };
        let radiance = |passage: &Passage| {
            let IncidentLight { cos_incidence, irradiance_per_power, .. } = passage.incident;
            C::transmitted(source, self, passage.depth_cm, cos_incidence) * (irradiance_per_power * FRAC_1_PI)
        };
        let (Some(straight), Some(line)) = (straight, line) else {
            let only = straight.or(line)?;
            return self.is_lit(queries, sample, &only).then(|| radiance(&only));
        };
        let isotropic = |radiance: &C, passage: &Passage| radiance.luminance(tables) / passage.incident.cos_emission;
        let [mut brighter, mut darker] = [straight, line].map(|passage| (radiance(&passage), passage));
        if isotropic(&darker.0, &darker.1) > isotropic(&brighter.0, &brighter.1) {
            std::mem::swap(&mut brighter, &mut darker);
        }
        [brighter, darker].into_iter().find(|(_, passage)| self.is_lit(queries, sample, passage)).map(|(one, _)| one)
    }

    /// The passage along the straight path, if its exit faces the light.
    #[inline]
    fn along_straight(&self, sample: &LightSample, chord: &Chord) -> Option<Passage> {
        let ChordEnd::Surface { object, point, normal } = chord.exit else {
            return None;
        };
        let exit = SurfacePoint { point, normal };
        let incident = sample.incident_at(&exit)?;
        Some(Passage { depth_cm: depth_cm(chord), incident, entry: Some((exit, Side::Inner(object))) })
    }

    /// The passage along the line to the light.
    #[inline]
    fn along_line(&self, queries: &mut SceneQueries, sample: &LightSample) -> Option<Passage> {
        let LightDirection { direction, distance_m } = sample.origin.direction_from(self.surface.point);
        // A light in front of the surface is reflected. Other parts of the body between them do not count.
        if self.surface.normal.dot(direction) >= 0.0 {
            return None;
        }
        let chord = self.chord(queries, direction, distance_m)?;
        let (incident, entry) = match chord.exit {
            ChordEnd::Surface { object, point, normal } => {
                let exit = SurfacePoint { point, normal };
                let side = if self.material.exit == Exit::Last { Side::Last(object) } else { Side::Inner(object) };
                (sample.incident_along_line(&exit)?, Some((exit, side)))
            }
            ChordEnd::Inside => (sample.incident_inside(self.surface.point)?, None),
        };
        Some(Passage { depth_cm: depth_cm(&chord), incident, entry })
    }

    /// Whether the light reaches the entry of a passage.
    #[inline]
    fn is_lit(&self, queries: &mut SceneQueries, sample: &LightSample, passage: &Passage) -> bool {
        passage.entry.is_none_or(|(entry, side)| {
            self.material.emission == Emission::Relative || sample.is_visible(queries, &entry, side)
        })
    }
}
