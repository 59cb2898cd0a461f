//! Snow as a surface that lets light through: PCASnow (Varsa & Baranoski 2024, Algorithm 1 and Figure 4).
//!
//! From the point X_i that is seen, a straight path through the object gives a depth d and an exit point X_t; θ is the
//! angle there between the outward normal and the light. The light that comes through is
//!
//! L(λ) = T(λ; d, θ) E(λ) / π, with E = I V cos θ / r² at X_t,
//!
//! V being 1 where X_t sees the light and 0 elsewhere: all objects hide it, snow as well, but for the others of the same
//! body. Light reflected at X_i is R(λ; d, θ_i) E_i / π with the same d, so that a slab never gives back more than it
//! gets.
//!
//! Which d that is for reflection needs no choice: a light that shines on X_i from outside has, on the line to it, no
//! snow; so `light` and `brightest` then use the path along the normal. For light from other surfaces it is this path
//! too, and in `view` mode the path along the view.
//!
//! A light inside the snow has no exit point before it. The path ends there with θ = 0 and E = I / r², r the distance
//! from X_i: what a shell of snow passes on through a sphere of that radius, were nothing absorbed.
//!
//! A lamp with extent is many points, and a sky many directions: all this holds for each of them, and each has its own way
//! (I = L cos θ_l dA for a point of a lamp, E = L cos θ dω for a direction). Some are drawn,
//! as seen from X_t and from X_i, and weighed by their density.
//!
//! `brightest` is the exact answer for a slab under a distant light, where the normal path is the brighter. Before a near
//! light, or beside an edge, the line to the light often is. It does not change with the viewing direction and leaves
//! no face black. But where lines to the light go over from one lit face to the next, the angle at the exit jumps, and
//! brightness with it, by T cos θ of the one face over that of the other: threefold where a block shows two faces to a near
//! lamp. And the better of two ways for every direction is more than their mean: a block of a few centimetres under a sky
//! returns, beside its edges, up to half as much again as it gets. `normal` and `view` return no more than all of it, but for
//! the table's rounding: a thousandth from 1 mm of snow on.
//!
//! Simplified: light leaves alike in all directions; light from other surfaces does not come through from behind;
//! angles from the table's last to 90° count as the last.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3A;
use snowblue_database::lookup::SnowMix;

use crate::geometry::chord::{Chord, ChordEnd, Exit, Line};
use crate::sampling::Sampler;
use crate::scene::light::{IncidentLight, Light, LightSample, SamplingTechniques, SurfacePoint};
use crate::scene::material::snow_curves::SnowCurves;
use crate::scene::objects::Side;
use crate::scene::objects::{Objects, SurfaceInteraction};
use crate::scene::queries::SceneQueries;
use crate::spectrum::Spectrum;

/// Which straight path stands for all paths of light through the snow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PathMode {
    /// On along the viewing ray, as in the paper. Snow seen obliquely looks thicker than it is, and where the exit does
    /// not face the light there is none.
    View,
    /// Along the inward normal: exact for a slab, from every viewing direction.
    Normal,
    /// Along the line to the light.
    Light,
    /// Of `Normal` and `Light` the one through which more light comes, by luminance.
    #[default]
    Brightest,
}

impl PathMode {
    /// All modes.
    pub const ALL: [Self; 4] = [Self::Brightest, Self::Normal, Self::Light, Self::View];

    /// Its name in scene files and options.
    pub fn name(self) -> &'static str {
        match self {
            Self::View => "view",
            Self::Normal => "normal",
            Self::Light => "light",
            Self::Brightest => "brightest",
        }
    }
}

/// What light enters at the exit point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Emission {
    /// The light's irradiance: distance, angle and shadows count.
    #[default]
    Transmitted,
    /// The paper's simpler form: the light's relative spectrum with luminance 1, as a radiance, whatever its distance
    /// and whatever stands in between.
    Relative,
}

/// What the snow reflects.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Reflection {
    /// The table's reflectance for depth and angle.
    #[default]
    Table,
    /// A constant share, the paper's local model. Thin snow then gives back more light than it gets.
    Constant(f32),
}

/// Snow with its ways of transmitting and reflecting.
#[derive(Debug)]
pub struct PcaSnowMaterial {
    /// The curves of the snow.
    pub curves: SnowCurves,
    /// Which path is taken.
    pub path: PathMode,
    /// Where the path ends.
    pub exit: Exit,
    /// What light enters.
    pub emission: Emission,
    /// What is reflected.
    pub reflection: Reflection,
    /// Luminance of one unit at each wavelength, to compare two paths.
    pub luminance: Spectrum,
}

/// Snow where a ray hit it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SnowHit<'hit> {
    material: &'hit PcaSnowMaterial,
    curves: SnowMix<'hit>,
    surface: &'hit SurfaceInteraction,
}

/// What comes through at a hit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Through {
    /// Radiance towards the eye, in W m⁻² sr⁻¹ as a band density.
    pub(crate) radiance: Spectrum,
    /// Depth of snow behind the point, in cm, on which its reflectance rests.
    pub(crate) depth_cm: f32,
}

/// A way of light through the snow.
#[derive(Debug, Clone, Copy)]
struct Passage {
    /// Depth of the snow, in cm.
    depth_cm: f32,
    /// How the light meets the snow where it goes in, if nothing hides it.
    arrival: IncidentLight,
    /// Where that is, and on which side of which object; nowhere for a light inside.
    entry: Option<(SurfacePoint, Side)>,
}

impl PcaSnowMaterial {
    /// The snow at a hit.
    #[inline]
    pub(crate) fn hit<'hit>(&'hit self, objects: &Objects, surface: &'hit SurfaceInteraction) -> SnowHit<'hit> {
        SnowHit { material: self, curves: self.curves.at(objects, surface), surface }
    }
}

impl SnowHit<'_> {
    /// The path through the snow that does not depend on the light.
    fn straight(&self, probe: &mut SceneQueries) -> Option<Chord> {
        let direction = match self.material.path {
            PathMode::View => self.surface.direction,
            PathMode::Normal | PathMode::Light | PathMode::Brightest => -self.surface.normal,
        };
        self.chord(probe, direction, f32::INFINITY)
    }

    /// The light that comes through, from the lights directly.
    pub(crate) fn lit_through(&self, probe: &mut SceneQueries, lights: &[Light], sampler: &mut Sampler) -> Through {
        let straight = self.straight(probe);
        let mut through = Through { radiance: Spectrum::ZERO, depth_cm: straight.as_ref().map_or(0.0, depth_cm) };
        for light in lights {
            let whole = match self.material.emission {
                Emission::Transmitted => light.single(),
                Emission::Relative => light.relative_from_middle(),
            };
            if let Some(beam) = whole {
                through.radiance += self.through(probe, &beam, straight.as_ref()).unwrap_or(Spectrum::ZERO);
                continue;
            }
            let techniques = self.techniques(light, straight.as_ref());
            for chosen in 0..techniques.len() {
                if let Some(mut beam) = light.beam(chosen, &techniques, sampler) {
                    if self.material.emission == Emission::Relative {
                        beam.power = light.relative(&beam.origin);
                    }
                    through.radiance += self.through(probe, &beam, straight.as_ref()).unwrap_or(Spectrum::ZERO);
                }
            }
        }
        through
    }

    /// How points of a light are drawn: as they are seen where the fixed path goes in, and from the point itself for the
    /// lines to the light.
    fn techniques(&self, light: &Light, straight: Option<&Chord>) -> SamplingTechniques {
        let exit = match straight.map(|chord| chord.exit) {
            Some(ChordEnd::Surface { point, normal, .. }) if self.material.path != PathMode::Light => {
                Some(SurfacePoint { point, normal })
            }
            _ => None,
        };
        let has_lines = matches!(self.material.path, PathMode::Light | PathMode::Brightest);
        let lines = has_lines.then_some(SurfacePoint { point: self.surface.point, normal: -self.surface.normal });
        light.techniques_through(exit.as_ref(), lines.as_ref())
    }

    /// Reflectance of snow of this depth for light at this cosine of incidence.
    pub(crate) fn reflectance(&self, depth_cm: f32, cos_incidence: f32) -> Spectrum {
        match self.material.reflection {
            Reflection::Table => {
                let mut reflectance = Spectrum::ZERO;
                let angle_deg = self.curves.look_up_angle_deg(cos_incidence);
                self.curves.reflectance(depth_cm, angle_deg, &mut reflectance.0);
                reflectance
            }
            Reflection::Constant(share) => Spectrum::constant(share),
        }
    }

    /// What comes of a beam through the snow to the point, by the path of the material's mode.
    ///
    /// Two ways are compared as if the point of the lamp shone alike in all directions, lest its slant towards one exit or the
    /// other split a lamp's points between the paths; the darker one counts where the brighter is hidden.
    fn through(&self, probe: &mut SceneQueries, beam: &LightSample, straight: Option<&Chord>) -> Option<Spectrum> {
        let mode = self.material.path;
        let along = straight.filter(|_| mode != PathMode::Light).and_then(|chord| self.along(beam, chord));
        let has_lines = matches!(mode, PathMode::Light | PathMode::Brightest);
        let line = if has_lines { self.towards_light(probe, beam) } else { None };
        let (Some(along), Some(line)) = (along, line) else {
            let only = along.or(line)?;
            return self.lets_in(probe, beam, &only).then(|| self.light(beam, &only));
        };
        let (light_along, light_on_line) = (self.light(beam, &along), self.light(beam, &line));
        let seen =
            |light: &Spectrum, passage: &Passage| light.dot(&self.material.luminance) / passage.arrival.cos_emission;
        let prefers_line = seen(&light_on_line, &line) > seen(&light_along, &along);
        if self.lets_in(probe, beam, if prefers_line { &line } else { &along }) {
            return Some(if prefers_line { light_on_line } else { light_along });
        }
        let is_darker_lit = self.lets_in(probe, beam, if prefers_line { &along } else { &line });
        is_darker_lit.then_some(if prefers_line { light_along } else { light_on_line })
    }

    /// L = T E / π.
    fn light(&self, beam: &LightSample, passage: &Passage) -> Spectrum {
        let mut transmittance = Spectrum::ZERO;
        let angle_deg = self.curves.look_up_angle_deg(passage.arrival.cos_incidence);
        self.curves.transmittance(passage.depth_cm, angle_deg, &mut transmittance.0);
        transmittance * beam.power * (passage.arrival.irradiance_per_power * FRAC_1_PI)
    }

    /// The way along a path that does not depend on the light, if the exit faces it.
    fn along(&self, beam: &LightSample, chord: &Chord) -> Option<Passage> {
        let ChordEnd::Surface { object, point, normal } = chord.exit else {
            return None;
        };
        let place = SurfacePoint { point, normal };
        let arrival = beam.arrival(&place)?;
        Some(Passage { depth_cm: depth_cm(chord), arrival, entry: Some((place, Side::Inner(object))) })
    }

    /// The way on the line to the light.
    fn towards_light(&self, probe: &mut SceneQueries, beam: &LightSample) -> Option<Passage> {
        let way = beam.origin.way(self.surface.point);
        // A light before the face shines on it; what else of the object stands between is not a way to its inside.
        if self.surface.normal.dot(way.direction) >= 0.0 {
            return None;
        }
        let chord = self.chord(probe, way.direction, way.distance_m)?;
        let (arrival, entry) = match chord.exit {
            ChordEnd::Surface { object, point, normal } => {
                let place = SurfacePoint { point, normal };
                let side = if self.material.exit == Exit::Last { Side::Last(object) } else { Side::Inner(object) };
                (beam.arrival_on_line(&place)?, Some((place, side)))
            }
            ChordEnd::Inside => (beam.arrival_within(self.surface.point)?, None),
        };
        Some(Passage { depth_cm: depth_cm(&chord), arrival, entry })
    }

    /// A straight path from the point through the snow.
    fn chord(&self, probe: &mut SceneQueries, direction: Vec3A, end_m: f32) -> Option<Chord> {
        let SurfaceInteraction { object, point, normal, .. } = *self.surface;
        probe.chord(object, &Line { point, normal, direction, end_m }, self.material.exit)
    }

    /// Whether a beam shines on the place where a way leaves the snow.
    fn lets_in(&self, probe: &mut SceneQueries, beam: &LightSample, passage: &Passage) -> bool {
        passage.entry.is_none_or(|(place, side)| {
            self.material.emission == Emission::Relative || beam.reaches(probe, &place, side)
        })
    }
}

/// The depth of a path in cm, the table's unit.
fn depth_cm(chord: &Chord) -> f32 {
    100.0 * chord.depth_m
}
