//! Automatic exposure of snow that is looked at from any side: by its vertices, as the pixels of no picture are known.
//!
//! A vertex counts as bright as it looks from an angle of 37° to the normal, cos θ = 0.8, without what the surface
//! reflects of lamps. By lamps, only vertices count where more light leaves than enters.

use std::f64::consts::FRAC_1_PI;

use snowblue_color::LinearRgb;
use snowblue_color::exposure::AutoExposure;
use snowblue_geometry::ray::SurfacePoint;

use super::Surface;
use super::relighting::{LitSnow, LitSurface, Relighting};

/// Lamps outside: the places near them may clip, so that the light through the snow is bright enough.
const OUTSIDE: AutoExposure = AutoExposure { fraction: 0.9, level: 2.8 };
/// Lamps inside: all light has come through the snow.
const INSIDE: AutoExposure = AutoExposure { fraction: 0.98, level: 0.95 };
/// Under a sky: half of the snow is darker than half of white, so that what is lit keeps its shades.
const SKY: AutoExposure = AutoExposure { fraction: 0.5, level: 0.5 };
/// Greatest share of the net flux that enters where lamps are inside.
const ENTERING: f64 = 0.1;
/// Cosine of exit.
const COS_EXIT: f64 = 0.8;

/// Snow under a light, and the factor of the light's strength.
#[derive(Debug, Clone, Copy)]
pub struct WeightedLight<'s> {
    /// The snow under the light.
    pub snow: &'s LitSnow,
    /// The factor.
    pub factor: f64,
}

/// What leaves the surface at a vertex by all lights.
#[derive(Clone, Copy)]
struct VertexLight {
    flux: LinearRgb,
    irradiance: LinearRgb,
}

impl Relighting {
    /// The factor of the display for all light of some lights; none without light.
    #[must_use]
    pub fn exposure_factor(&self, lights: &[WeightedLight]) -> Option<f64> {
        let has_sky = lights.iter().any(|light| light.snow.is_of_sky());
        let (mut pixels, mut entering, mut leaving) = (Vec::new(), 0.0, 0.0);
        for (number, surface) in self.surfaces.iter().enumerate() {
            let escape = surface.baked.snow.escape.at(COS_EXIT);
            for vertex in 0..surface.baked.positions.len() {
                let VertexLight { flux, irradiance: mut exitance } = self.vertex_light(lights, number, vertex);
                let net = flux.luminance();
                if has_sky || net > 0.0 {
                    exitance += flux * escape;
                    pixels.push(exitance * FRAC_1_PI);
                }
                entering += f64::max(-net, 0.0);
                leaving += f64::max(net, 0.0);
            }
        }
        let is_lit = pixels.iter().any(|pixel| pixel.luminance() > 0.0);
        let rule = if has_sky {
            SKY
        } else if entering < ENTERING * leaving {
            INSIDE
        } else {
            OUTSIDE
        };
        is_lit.then(|| rule.factor(pixels))
    }

    fn vertex_light(&self, lights: &[WeightedLight], surface: usize, vertex: usize) -> VertexLight {
        let mut sum = VertexLight { flux: LinearRgb::default(), irradiance: LinearRgb::default() };
        for WeightedLight { snow, factor } in lights {
            let LitSurface { flux, diffuse_irradiance, sky_irradiance, visibility } = &snow.surfaces[surface];
            sum.flux += flux[vertex] * *factor;
            sum.irradiance += diffuse_irradiance[vertex] * *factor;
            if let Some(irradiance) = sky_irradiance.get(vertex) {
                sum.irradiance += *irradiance * *factor;
            } else if snow.is_of_sky() {
                let direct = self.direct_irradiance(snow, &self.surfaces[surface], vertex);
                sum.irradiance += direct * (factor * f64::from(visibility[vertex]));
            }
        }
        sum
    }

    /// The irradiance by the sun at a vertex, visibility aside.
    fn direct_irradiance(&self, snow: &LitSnow, surface: &Surface, vertex: usize) -> LinearRgb {
        let (point, normal) = (surface.baked.positions[vertex].into(), surface.baked.normals[vertex].into());
        let sample = snow.light.central_sample();
        let incident = sample.as_ref().and_then(|sample| sample.incident_at(&SurfacePoint { point, normal }));
        let cos = incident.map_or(0.0, |incident| incident.cos_incidence);
        snow.strength * f64::from(cos)
    }
}

impl LitSnow {
    /// Whether the light is a sky or its sun.
    fn is_of_sky(&self) -> bool {
        self.light.central_sample().is_none_or(|sample| sample.origin.position().is_none())
    }
}
