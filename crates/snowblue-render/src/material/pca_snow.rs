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
//! snow; so `light` and `easiest` then use the path along the normal. For light from other surfaces it is this path
//! too, and in `view` mode the path along the view.
//!
//! A light inside the snow has no exit point before it. The path ends there with θ = 0 and E = I / r², r the distance
//! from X_i: what a shell of snow passes on through a sphere of that radius, were nothing absorbed.
//!
//! `easiest` is the exact answer for a slab under a distant light, where the normal path is the brighter. Before a near
//! light, or beside an edge, the line to the light often is. It does not change with the viewing direction and leaves
//! no face black. But where lines to the light go over from one lit face to the next, the angle at the exit jumps, and
//! brightness with it: up to threefold on a block that shows two faces to the light.
//!
//! Simplified: light leaves alike in all directions; light from other surfaces does not come through from behind;
//! angles of 89–90° count as 89°, the table's last.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3A;
use snowblue_database::PcaSnow;

use crate::chord::{Chord, ChordEnd, Exit, Line};
use crate::light::PointLight;
use crate::material::Shading;
use crate::objects::Surface;
use crate::probe::Probe;
use crate::spectrum::Spectrum;

/// The greatest angle of incidence in the table, in degrees.
pub const GREATEST_ANGLE_DEG: f32 = 89.0;

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
    Easiest,
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
    /// The curves of the sample.
    pub snow: PcaSnow,
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

/// Light that has come through.
struct Passage {
    /// Transmittance.
    transmittance: Spectrum,
    /// Irradiance per radiant intensity where the light went in, in 1/m².
    irradiance_per_intensity: f32,
}

impl PcaSnowMaterial {
    /// The light that comes through and the light that is reflected, from the lights directly.
    pub(crate) fn lit(&self, probe: &mut Probe, surface: &Surface, lights: &[PointLight]) -> Shading {
        let straight = match self.path {
            PathMode::View => surface.direction,
            PathMode::Normal | PathMode::Light | PathMode::Easiest => -surface.normal,
        };
        let straight = probe.chord(surface.object, &line(surface, straight, f32::INFINITY), self.exit);
        let depth_cm = straight.map_or(0.0, |chord| depth_cm(&chord));
        let mut radiance = Spectrum::ZERO;
        for light in lights {
            if let Some(passage) = self.passage(probe, surface, light, straight.as_ref()) {
                match self.emission {
                    Emission::Transmitted => {
                        let factor = passage.irradiance_per_intensity * FRAC_1_PI;
                        radiance.add_product(factor, &passage.transmittance, &light.intensity);
                    }
                    Emission::Relative => radiance.add_product(1.0, &passage.transmittance, &light.relative),
                }
            }
            if let Some(arrival) = light.arrival(surface.point, surface.normal)
                && probe.sees(surface.point, surface.normal, light.position)
            {
                let factor = arrival.irradiance_per_intensity * FRAC_1_PI;
                let reflectance = self.reflectance(depth_cm, arrival.cos_incidence);
                radiance.add_product(factor, &reflectance, &light.intensity);
            }
        }
        Shading { radiance, depth_cm }
    }

    /// Reflectance of snow of this depth for light at this cosine of incidence.
    pub(crate) fn reflectance(&self, depth_cm: f32, cos_incidence: f32) -> Spectrum {
        match self.reflection {
            Reflection::Table => {
                let mut reflectance = Spectrum::ZERO;
                self.snow.reflectance(depth_cm, angle_deg(cos_incidence), &mut reflectance.0);
                reflectance
            }
            Reflection::Constant(share) => Spectrum::constant(share),
        }
    }

    /// The way of a light through the snow to a surface point, by the path of the material's mode.
    fn passage(
        &self,
        probe: &mut Probe,
        surface: &Surface,
        light: &PointLight,
        straight: Option<&Chord>,
    ) -> Option<Passage> {
        let towards_light = |probe: &mut Probe| {
            let way = light.position - surface.point;
            // A light before the face shines on it; what else of the object stands between is not a way to its inside.
            if surface.normal.dot(way) >= 0.0 {
                return None;
            }
            let distance_m = way.length();
            let line = line(surface, way / distance_m, distance_m);
            let chord = probe.chord(surface.object, &line, self.exit)?;
            self.through(probe, surface, light, &chord)
        };
        match self.path {
            PathMode::View | PathMode::Normal => self.through(probe, surface, light, straight?),
            PathMode::Light => towards_light(probe),
            PathMode::Easiest => {
                let normal = straight.and_then(|chord| self.through(probe, surface, light, chord));
                let direct = towards_light(probe);
                match (normal, direct) {
                    (Some(normal), Some(direct)) => {
                        let brighter = self.luminance(&direct, light) > self.luminance(&normal, light);
                        Some(if brighter { direct } else { normal })
                    }
                    (normal, direct) => normal.or(direct),
                }
            }
        }
    }

    /// What comes through along a path, if the light shines on its exit.
    fn through(&self, probe: &mut Probe, surface: &Surface, light: &PointLight, chord: &Chord) -> Option<Passage> {
        let (cos_incidence, irradiance_per_intensity) = match chord.exit {
            ChordEnd::Surface { object, point, normal } => {
                let arrival = light.arrival(point, normal)?;
                if self.emission == Emission::Transmitted
                    && !probe.sees_from_exit(object, point, normal, light.position)
                {
                    return None;
                }
                (arrival.cos_incidence, arrival.irradiance_per_intensity)
            }
            ChordEnd::Inside => (1.0, light.position.distance_squared(surface.point).recip()),
        };
        let mut transmittance = Spectrum::ZERO;
        self.snow.transmittance(depth_cm(chord), angle_deg(cos_incidence), &mut transmittance.0);
        Some(Passage { transmittance, irradiance_per_intensity })
    }

    /// Luminance of the light that came through, for comparison.
    fn luminance(&self, passage: &Passage, light: &PointLight) -> f32 {
        match self.emission {
            Emission::Transmitted => {
                (passage.transmittance * light.intensity).dot(&self.luminance) * passage.irradiance_per_intensity
            }
            Emission::Relative => (passage.transmittance * light.relative).dot(&self.luminance),
        }
    }
}

fn line(surface: &Surface, direction: Vec3A, end_m: f32) -> Line {
    Line { point: surface.point, normal: surface.normal, direction, end_m }
}

fn depth_cm(chord: &Chord) -> f32 {
    100.0 * chord.depth_m
}

/// The angle of a cosine above 0, at most the table's last.
fn angle_deg(cos_incidence: f32) -> f32 {
    cos_incidence.min(1.0).acos().to_degrees().min(GREATEST_ANGLE_DEG)
}
