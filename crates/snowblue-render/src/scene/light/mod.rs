//! Lights: what they are, how a point of one is drawn, and how light from there reaches a surface.
//!
//! A point of a lamp is a lamp without extent itself, and a direction of the sky a distant one. So whatever is lit asks for
//! one beam after the other:
//!
//! | light | drawn | irradiance E of a surface |
//! |---|---|---|
//! | point, spot | there is but one point | I cos θ / r² |
//! | directional | there is but one direction | E⊥ cos θ |
//! | sphere, rectangle | a point, by the solid angle seen | L cos θ cos θ_l / (r² p), θ_l at the lamp, p per m² |
//! | sky, uniform or an image | a direction | L cos θ / p, p per sr |
//!
//! Where points are drawn in several ways, p is the sum of the ways' densities: the balance heuristic of multiple
//! importance sampling (Veach & Guibas 1995, "Optimally combining sampling techniques for Monte Carlo rendering",
//! doi:10.1145/218380.218498). Lamps hide nothing: they are seen, but light passes through them.

mod beam;
mod image;
mod rectangle;
mod source;
mod sphere;

use std::f32::consts::FRAC_1_PI;

use glam::Vec3A;

use crate::geometry::ray::Ray;
use crate::sampling::{Sampler, cosine_direction, even_direction};
use crate::spectrum::Spectrum;
use crate::spectrum::light_spectrum::LightSpectrum;

pub use beam::SpotCone;
use beam::{EmitterPoint, Falloff};
pub(crate) use beam::{IncidentLight, LightOrigin, LightSample, SurfacePoint, TOUCHING};
pub use image::{Panorama, SkyImage};
pub use rectangle::{RectangleLight, RectanglePlace};
pub(crate) use source::{Arrivals, Source};
pub use sphere::SphereLight;

/// A light without extent that shines alike in all directions, or within a cone.
#[derive(Debug, Clone, Copy)]
pub struct PointLight {
    /// Where it is, in m.
    pub position: Vec3A,
    /// Radiant intensity in W/sr, as a band density: the mean of the samples is the total over 400–700 nm.
    pub intensity: Spectrum,
    /// The shape of its spectrum alone, with luminance Y = 1 on the grid.
    pub relative: Spectrum,
    /// Where it shines; without a cone everywhere.
    pub cone: Option<SpotCone>,
}

/// A light so far away that it shines in one direction, alike everywhere.
#[derive(Debug, Clone, Copy)]
pub struct DirectionalLight {
    /// Unit direction from the scene to the light.
    pub to_light: Vec3A,
    /// Irradiance on a surface that faces it, in W/m², as a band density.
    pub irradiance: Spectrum,
    /// The shape of its spectrum alone, with luminance Y = 1 on the grid.
    pub relative: Spectrum,
}

/// A light that is seen: it has extent, and everywhere the same radiance.
#[derive(Debug, Clone, Copy)]
pub struct DiffuseEmitter<Shape> {
    /// Where it is.
    pub shape: Shape,
    /// Radiance in W m⁻² sr⁻¹, as a band density.
    pub radiance: Spectrum,
    /// The shape of its spectrum alone, with luminance Y = 1 on the grid.
    pub relative: Spectrum,
    /// Whether the camera sees it; the scene is lit by it either way.
    pub visible: bool,
}

/// Alike in all directions.
#[derive(Debug, Clone, Copy)]
pub struct UniformSky;

/// Something that shines.
#[derive(Debug)]
pub enum Light {
    /// Without extent.
    Point(PointLight),
    /// Far away, in one direction.
    Directional(DirectionalLight),
    /// A sphere that shines outwards.
    Sphere(DiffuseEmitter<SphereLight>),
    /// A rectangle that shines from one side.
    Rectangle(DiffuseEmitter<RectangleLight>),
    /// A sky alike in all directions.
    Sky(DiffuseEmitter<UniformSky>),
    /// A sky from an image, and whether the camera sees it.
    Image(Box<SkyImage>, bool),
}

/// A way of drawing a point or a direction of a light.
#[derive(Debug, Clone, Copy)]
pub(crate) enum SamplingTechnique {
    /// Evenly over the solid angle of a lamp, seen from a place.
    SolidAngle(SurfacePoint),
    /// By the cosine with the normal of a place, p = cos θ / π.
    Cosine(SurfacePoint),
    /// Evenly over the directions above a place, p = 1 / 2π.
    Hemisphere(SurfacePoint),
    /// By the brightness of an image.
    Brightness,
}

/// A few techniques together.
pub(crate) type SamplingTechniques = [Option<SamplingTechnique>; 3];

impl PointLight {
    /// A lamp of this spectrum and radiant intensity in W/sr, summed over the grid of 400–700 nm.
    pub fn new(position: Vec3A, lamp: &LightSpectrum, radiant_intensity_w_sr: f32) -> Self {
        Self { position, intensity: lamp.unit * radiant_intensity_w_sr, relative: lamp.relative, cone: None }
    }
}

impl<Shape> DiffuseEmitter<Shape> {
    /// A lamp of this spectrum and radiance in W m⁻² sr⁻¹, summed over the grid of 400–700 nm.
    pub fn new(shape: Shape, lamp: &LightSpectrum, radiance_w_m2_sr: f32) -> Self {
        Self { shape, radiance: lamp.unit * radiance_w_m2_sr, relative: lamp.relative, visible: true }
    }
}

impl Light {
    /// Whether rays can meet it.
    pub fn has_extent(&self) -> bool {
        !matches!(self, Self::Point(_) | Self::Directional(_))
    }

    /// The light as a whole, if it comes from one point or direction.
    pub(crate) fn single(&self) -> Option<LightSample> {
        let (origin, power, cone) = match self {
            Self::Point(light) => (LightOrigin::Point(light.position), light.intensity, light.cone),
            Self::Directional(light) => (LightOrigin::Distant(light.to_light), light.irradiance, None),
            _ => return None,
        };
        Some(LightSample { origin, power, falloff: cone.map_or(Falloff::Natural, Falloff::Within) })
    }

    /// The light's spectrum with luminance 1 from its middle, as a radiance whatever the distance; none of a sky.
    pub(crate) fn relative_from_middle(&self) -> Option<LightSample> {
        let origin = match self {
            Self::Sphere(lamp) => LightOrigin::Point(lamp.shape.centre),
            Self::Rectangle(lamp) => LightOrigin::Point(lamp.shape.centre()),
            _ => self.single()?.origin,
        };
        Some(LightSample { origin, power: self.relative(&origin), falloff: Falloff::None })
    }

    /// How light that a surface reflects is drawn, beside the cosine of the path's next ray; that ray alone meets a
    /// uniform sky.
    fn technique_towards(&self, place: &SurfacePoint) -> Option<SamplingTechnique> {
        match self {
            Self::Sphere(_) | Self::Rectangle(_) => Some(SamplingTechnique::SolidAngle(*place)),
            Self::Image(..) => Some(SamplingTechnique::Brightness),
            Self::Point(_) | Self::Directional(_) | Self::Sky(_) => None,
        }
    }

    /// One beam of a light with extent for a surface to reflect; the path's next ray brings the rest.
    pub(crate) fn reflected_beam(&self, place: &SurfacePoint, sampler: &mut Sampler) -> Option<LightSample> {
        let technique = self.technique_towards(place)?;
        self.beam(0, &[Some(technique), Some(SamplingTechnique::Cosine(*place)), None], sampler)
    }

    /// What a path's ray meets of this light before `limit_m`, times the share of it that beams did not bring. The ray
    /// comes from the camera, or from a place with the density of its cosine.
    pub(crate) fn met(&self, ray: &Ray, limit_m: f32, from: Option<&SurfacePoint>) -> Option<Spectrum> {
        let origin = self.origin_on(ray, limit_m)?;
        let Some(place) = from else {
            return self.is_visible().then(|| self.radiance(&origin));
        };
        let own = self.density(&SamplingTechnique::Cosine(*place), &origin);
        let other = self.technique_towards(place).map_or(0.0, |technique| self.density(&technique, &origin));
        let share = if other > 0.0 { own / (own + other) } else { 1.0 };
        Some(self.radiance(&origin) * share)
    }

    /// All that a ray meets of this light before `limit_m`, seen by the camera or not, and how far away, in m.
    pub(crate) fn met_whole(&self, ray: &Ray, limit_m: f32) -> Option<(Spectrum, f32)> {
        let origin = self.origin_on(ray, limit_m)?;
        Some((self.radiance(&origin), origin.way(ray.origin).distance_m))
    }

    /// The point or direction of a light with extent that a ray meets before `limit_m`.
    fn origin_on(&self, ray: &Ray, limit_m: f32) -> Option<LightOrigin> {
        match self {
            Self::Point(_) | Self::Directional(_) => None,
            Self::Sphere(lamp) => lamp.shape.met(ray, limit_m).map(LightOrigin::EmitterPoint),
            Self::Rectangle(lamp) => lamp.shape.met(ray, limit_m).map(LightOrigin::EmitterPoint),
            Self::Sky(_) | Self::Image(..) if limit_m < f32::INFINITY => None,
            Self::Sky(_) | Self::Image(..) => Some(LightOrigin::Distant(ray.direction)),
        }
    }

    /// How light for snow is drawn that goes in at `exit`, or on the way from a point along its line, or both.
    pub(crate) fn techniques_through(
        &self,
        exit: Option<&SurfacePoint>,
        lines: Option<&SurfacePoint>,
    ) -> SamplingTechniques {
        match self {
            Self::Point(_) | Self::Directional(_) => [None; 3],
            Self::Sphere(_) | Self::Rectangle(_) => {
                [exit, lines, None].map(|place| place.copied().map(SamplingTechnique::SolidAngle))
            }
            // Lines that leave at a side can do so with the full cosine though they graze their own surface.
            Self::Sky(_) | Self::Image(..) => [
                exit.copied().map(SamplingTechnique::Cosine),
                lines.copied().map(SamplingTechnique::Hemisphere),
                matches!(self, Self::Image(..)).then_some(SamplingTechnique::Brightness),
            ],
        }
    }

    /// One beam, drawn by one of several techniques that are used once each.
    pub(crate) fn beam(
        &self,
        chosen: usize,
        techniques: &SamplingTechniques,
        sampler: &mut Sampler,
    ) -> Option<LightSample> {
        let technique = techniques[chosen].as_ref()?;
        let [u, v, ..] = sampler.next_four();
        let origin = self.draw(technique, [u, v])?;
        let density: f32 = techniques.iter().flatten().map(|technique| self.density(technique, &origin)).sum();
        let spread_m2 = match self {
            Self::Sphere(lamp) => lamp.shape.radius_m * lamp.shape.radius_m,
            Self::Rectangle(lamp) => lamp.shape.area_m2() * FRAC_1_PI,
            _ => 0.0,
        };
        let falloff = Falloff::Drawn { density, spread_m2 };
        (density > 0.0).then(|| LightSample { origin, power: self.radiance(&origin), falloff })
    }

    fn draw(&self, technique: &SamplingTechnique, numbers: [f32; 2]) -> Option<LightOrigin> {
        let [u, v] = numbers;
        match (technique, self) {
            (SamplingTechnique::SolidAngle(place), Self::Sphere(lamp)) => {
                lamp.shape.draw(place.point, numbers).map(LightOrigin::EmitterPoint)
            }
            (SamplingTechnique::SolidAngle(place), Self::Rectangle(lamp)) => {
                lamp.shape.draw(place.point, numbers).map(LightOrigin::EmitterPoint)
            }
            (SamplingTechnique::Cosine(place), _) => Some(LightOrigin::Distant(cosine_direction(place.normal, u, v))),
            (SamplingTechnique::Hemisphere(place), _) => Some(LightOrigin::Distant(even_direction(place.normal, u, v))),
            (SamplingTechnique::Brightness, Self::Image(image, _)) => Some(LightOrigin::Distant(image.draw(numbers))),
            _ => None,
        }
    }

    /// Density with which a technique draws an origin: per m² of a lamp, per sr of directions.
    fn density(&self, technique: &SamplingTechnique, origin: &LightOrigin) -> f32 {
        let (point, density_per_sr) = match technique {
            SamplingTechnique::SolidAngle(place) => (place.point, self.solid_angle_density_per_sr(place.point, origin)),
            SamplingTechnique::Cosine(SurfacePoint { point, normal }) => {
                (*point, normal.dot(origin.way(*point).direction).max(0.0) * FRAC_1_PI)
            }
            SamplingTechnique::Hemisphere(SurfacePoint { point, normal }) => {
                let above = normal.dot(origin.way(*point).direction) > 0.0;
                (*point, if above { 0.5 * FRAC_1_PI } else { 0.0 })
            }
            SamplingTechnique::Brightness => match (self, origin) {
                (Self::Image(image, _), LightOrigin::Distant(direction)) => return image.density_per_sr(*direction),
                _ => return 0.0,
            },
        };
        density_per_sr / origin.own_per_solid_angle(point)
    }

    fn solid_angle_density_per_sr(&self, from: Vec3A, origin: &LightOrigin) -> f32 {
        match self {
            Self::Sphere(lamp) => lamp.shape.density_per_sr(from),
            Self::Rectangle(lamp) => lamp.shape.density_per_sr(from, origin.own_per_solid_angle(from)),
            _ => 0.0,
        }
    }

    /// The spectrum of what comes from there with luminance 1.
    pub(crate) fn relative(&self, origin: &LightOrigin) -> Spectrum {
        match (self, origin) {
            (Self::Point(PointLight { relative, .. }), _)
            | (Self::Directional(DirectionalLight { relative, .. }), _)
            | (Self::Sphere(DiffuseEmitter { relative, .. }), _)
            | (Self::Rectangle(DiffuseEmitter { relative, .. }), _)
            | (Self::Sky(DiffuseEmitter { relative, .. }), _) => *relative,
            (Self::Image(image, _), LightOrigin::Distant(direction)) => image.relative(*direction),
            (Self::Image(..), _) => Spectrum::ZERO,
        }
    }

    /// What comes from there, in W m⁻² sr⁻¹; nothing of a light without extent.
    fn radiance(&self, origin: &LightOrigin) -> Spectrum {
        match (self, origin) {
            (Self::Point(_) | Self::Directional(_), _) => Spectrum::ZERO,
            (Self::Sphere(DiffuseEmitter { radiance, .. }), _)
            | (Self::Rectangle(DiffuseEmitter { radiance, .. }), _)
            | (Self::Sky(DiffuseEmitter { radiance, .. }), _) => *radiance,
            (Self::Image(image, _), LightOrigin::Distant(direction)) => image.radiance(*direction),
            (Self::Image(..), _) => Spectrum::ZERO,
        }
    }

    fn is_visible(&self) -> bool {
        match self {
            Self::Point(_) | Self::Directional(_) => false,
            Self::Sphere(DiffuseEmitter { visible, .. })
            | Self::Rectangle(DiffuseEmitter { visible, .. })
            | Self::Sky(DiffuseEmitter { visible, .. })
            | Self::Image(_, visible) => *visible,
        }
    }
}

#[cfg(test)]
mod tests;
