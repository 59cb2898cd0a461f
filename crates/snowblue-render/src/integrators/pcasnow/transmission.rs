//! PCASnow: snow that transmits light along one straight line (Varsa & Baranoski 2024, Algorithm 1 and Figure 4).
//!
//! From the visible point X_i a straight path through the object gives a depth d and an exit point X_t. θ is the angle
//! at X_t between the outward normal and the direction of the light. The transmitted radiance is
//!
//! L(λ) = T(λ; d, θ) E(λ) / π, with E = I V cos θ / r² at X_t.
//!
//! V is the visibility of the light from X_t. All objects occlude it, snow included, except the other objects of the
//! same body. Light reflected at X_i is R(λ; d, θ_i) E_i / π with the same d, so that a slab never returns more light
//! than it receives.
//!
//! The depth for reflection is the depth of the straight path: along the view in mode `view`, else along the inward
//! normal. On the line to a light that shines on X_i from outside there is no snow, so `light` and `brightest` use
//! the normal too. The same depth applies to light from other surfaces.
//!
//! On the line to a light inside the snow there is no exit point. The path then ends at the light, with θ = 0 and E =
//! I / r², where r is the distance of the light from X_i. A shell of snow without absorption transmits this
//! irradiance through a sphere of radius r.
//!
//! A light with extent consists of points, and a sky of directions. Each has its own path, with I = L cos θ_l dA for a
//! point and E = L cos θ dω for a direction. Samples are drawn as seen from X_t and from X_i, and weighted by their
//! density.
//!
//! `brightest` is exact for a slab under a distant light, where the normal path is the brighter path. Near a light,
//! or beside an edge, the line to the light is often brighter. The result does not depend on the viewing direction
//! and leaves no face black. Two errors remain. Where lines to the light change from one lit face to the next, T cos
//! θ is discontinuous: by a factor of three where a block shows two faces to a near light. And the choice of the
//! brighter path for every direction exceeds the mean: beside its edges, a block of a few centimetres under a sky
//! returns up to 1.5 times the light that it receives. `normal` and `view` return no more light than they receive,
//! within the rounding of the table (a thousandth from 1 mm of snow).
//!
//! Simplified: transmitted light leaves the snow diffusely; light from other surfaces does not enter from behind;
//! angles beyond the last angle of the table are looked up at the last angle.

use std::f32::consts::FRAC_1_PI;

use snowblue_geometry::body::{Chord, ChordEnd};
use snowblue_geometry::ray::SurfacePoint;
use snowblue_scene::Scene;
use snowblue_scene::light::{IncidentLight, Light, LightDirection, LightSample, SamplingTechniques};
use snowblue_scene::objects::Side;
use snowblue_scene::queries::SceneQueries;
use snowblue_scene::sampling::Sampler;

use crate::integrators::light_tables::{Carried, LightTables, Source};
use crate::integrators::pcasnow::{SnowVertex, depth_cm};

/// A path of light through the snow.
#[derive(Debug, Clone, Copy)]
struct Passage {
    /// Depth of the snow d, in cm.
    depth_cm: f32,
    /// The incident light at the entry X_t, without the visibility.
    incident: IncidentLight,
    /// The entry and its side of the surface; none for a light inside the snow.
    entry: Option<(SurfacePoint, Side)>,
}

impl SnowVertex<'_> {
    /// Light of all lights that the snow transmits.
    #[inline]
    pub(in crate::integrators) fn transmitted<C: Carried>(
        &self,
        scene: &Scene,
        tables: &LightTables,
        queries: &mut SceneQueries,
        sampler: &mut Sampler,
    ) -> C {
        let mut transmitted = C::ZERO;
        for (index, light) in scene.lights().iter().enumerate() {
            let mut add = |sample: &LightSample| {
                let source = Source::new(scene, tables, index, sample);
                if let Some(radiance) = self.through::<C>(tables, queries, &source, sample) {
                    transmitted += radiance;
                }
            };
            if let Some(sample) = tables.delta_sample(index) {
                add(sample);
                continue;
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
    fn techniques(&self, light: &Light) -> SamplingTechniques<'static> {
        let exit = match self.straight.map(|chord| chord.exit) {
            Some(ChordEnd::Surface { point, normal, .. }) if self.settings.path.uses_straight() => {
                Some(SurfacePoint { point, normal })
            }
            _ => None,
        };
        let inward = SurfacePoint { point: self.surface.point, normal: -self.surface.normal };
        light.techniques_through(exit.as_ref(), self.settings.path.uses_lines().then_some(&inward))
    }

    /// Light of one sample that the snow transmits, L = T E / π, by the path mode.
    ///
    /// Of two paths the brighter path counts, or the darker path where the brighter path is occluded. Paths are
    /// compared as if an area light were isotropic: otherwise the emission cosine would split the points of the light
    /// between the paths.
    #[inline]
    fn through<C: Carried>(
        &self,
        tables: &LightTables,
        queries: &mut SceneQueries,
        source: &Source,
        sample: &LightSample,
    ) -> Option<C> {
        let mode = self.settings.path;
        let straight = self.straight.as_ref().filter(|_| mode.uses_straight());
        let straight = straight.and_then(|chord| self.along_straight(sample, chord));
        let line = if mode.uses_lines() { self.along_line(queries, sample) } else { None };
        let radiance = |passage: &Passage| {
            let IncidentLight { cos_incidence, irradiance_per_power, .. } = passage.incident;
            C::transmitted(source, self, passage.depth_cm, cos_incidence) * (irradiance_per_power * FRAC_1_PI)
        };
        let (Some(straight), Some(line)) = (straight, line) else {
            let only = straight.or(line)?;
            let share = self.share_at_entry(queries, sample, &only);
            return (share > 0.0).then(|| radiance(&only) * share);
        };
        let isotropic = |radiance: &C, passage: &Passage| radiance.luminance(tables) / passage.incident.cos_emission;
        let [mut brighter, mut darker] = [straight, line].map(|passage| (radiance(&passage), passage));
        if isotropic(&darker.0, &darker.1) > isotropic(&brighter.0, &brighter.1) {
            std::mem::swap(&mut brighter, &mut darker);
        }
        [brighter, darker].into_iter().find_map(|(radiance, passage)| {
            let share = self.share_at_entry(queries, sample, &passage);
            (share > 0.0).then(|| radiance * share)
        })
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
                (sample.incident_along_line(&exit)?, Some((exit, Side::Last(object))))
            }
            ChordEnd::Inside => (sample.incident_inside(self.surface.point)?, None),
        };
        Some(Passage { depth_cm: depth_cm(&chord), incident, entry })
    }

    /// The share of the light that reaches the entry of a passage.
    #[inline]
    fn share_at_entry(&self, queries: &mut SceneQueries, sample: &LightSample, passage: &Passage) -> f32 {
        passage.entry.map_or(1.0, |(entry, side)| sample.transmittance(queries, &entry, side))
    }
}
