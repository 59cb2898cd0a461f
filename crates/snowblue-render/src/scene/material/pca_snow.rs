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
//! The depth for reflection is that of the straight path: along the view in mode `view`, else along the inward normal.
//! On the line to a light that shines on X_i from outside there is no snow, so `light` and `brightest` use the normal
//! too. The same depth applies to light from other surfaces.
//!
//! On the line to a light inside the snow there is no exit point. The path then ends at the light, with θ = 0 and E = I
//! / r², where r is its distance from X_i: what a shell of snow transmits through a sphere of that radius without
//! absorption.
//!
//! A light with extent consists of points, and a sky of directions. Each has its own path, with I = L cos θ_l dA for a
//! point and E = L cos θ dω for a direction. Samples are drawn as seen from X_t and from X_i, and weighted by their
//! density.
//!
//! `brightest` is exact for a slab under a distant light, where the normal path is the brighter. Near a light, or
//! beside an edge, the line to the light is often brighter. The result does not depend on the viewing direction and
//! leaves no face black. Two errors remain. Where lines to the light change from one lit face to the next, T cos θ is
//! discontinuous: by a factor of three where a block shows two faces to a near light. And the brighter path for every
//! direction exceeds the mean: beside its edges, a block of a few centimetres under a sky returns up to 1.5 times what
//! it receives. `normal` and `view` return no more than they receive, within the rounding of the table (a thousandth
//! from 1 mm of snow).
//!
//! Simplified: transmitted light leaves the snow diffusely; light from other surfaces does not enter from behind;
//! angles beyond the table's last are looked up at the last.

use glam::Vec3A;
use serde::{Deserialize, Serialize};
use snowblue_database::lookup::SnowMix;

use crate::geometry::chord::Exit;
use crate::scene::material::snow_curves::SnowCurves;
use crate::scene::objects::SurfaceInteraction;
use crate::spectrum::Spectrum;

/// The straight path that stands for all paths of light through the snow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PathMode {
    /// Along the viewing ray, as in the paper. Snow seen obliquely looks thicker than it is, and black where the exit
    /// does not face the light.
    View,
    /// Along the inward normal: exact for a slab, from every viewing direction.
    Normal,
    /// Along the line to the light.
    Light,
    /// The brighter of `Normal` and `Light`, by luminance.
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
    pub(crate) fn uses_straight(self) -> bool {
        self != Self::Light
    }

    /// Whether light comes along lines to the light.
    #[inline]
    pub(crate) fn uses_lines(self) -> bool {
        matches!(self, Self::Light | Self::Brightest)
    }
}

/// Which light counts where the straight path leaves the snow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Emission {
    /// The irradiance of the light there, with distance, angle and shadows.
    #[default]
    Transmitted,
    /// The paper's simpler form: the light's relative spectrum with luminance 1, as a radiance, without
    /// distance or shadows.
    Relative,
}

/// What the snow reflects.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Reflection {
    /// The table's reflectance for depth and angle.
    #[default]
    Table,
    /// A constant, the paper's local model. Thin snow then reflects and transmits more light than it receives.
    Constant(f32),
}

/// Snow with its modes of transmission and reflection.
#[derive(Debug)]
pub struct PcaSnowMaterial {
    /// The curves of the snow.
    pub curves: SnowCurves,
    /// Which path is taken.
    pub path: PathMode,
    /// Where the path ends.
    pub exit: Exit,
    /// Which light is transmitted.
    pub emission: Emission,
    /// What is reflected.
    pub reflection: Reflection,
}

impl PcaSnowMaterial {
    /// Reflectance of snow of a depth for light at a cosine of incidence.
    pub(crate) fn reflectance(&self, curves: &SnowMix, depth_cm: f32, cos_incidence: f32) -> Spectrum {
        match self.reflection {
            Reflection::Table => {
                let mut reflectance = Spectrum::ZERO;
                curves.reflectance(depth_cm, curves.look_up_angle_deg(cos_incidence), &mut reflectance.0);
                reflectance
            }
            Reflection::Constant(reflectance) => Spectrum::constant(reflectance),
        }
    }
}
