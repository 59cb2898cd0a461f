//! Light sources: what they emit, how a point of one is sampled, and the light that arrives at a surface.
//!
//! A point of an area light acts as a point light, and a direction of the sky as a distant one. So a surface asks for
//! one `LightSample` after the other:
//!
//! | light | sample | irradiance E of a surface |
//! |---|---|---|
//! | point, spot | the point | I cos θ / r² |
//! | directional | the direction | E⊥ cos θ |
//! | sphere, rectangle | a point, by solid angle | L cos θ cos θ_l / (r² p), θ_l at the light, p per m² |
//! | sky of any kind, sun | a direction | L cos θ / p, p per sr |
//!
//! Where several techniques sample a light, p is the sum of their densities: the balance heuristic of multiple
//! importance sampling (Veach & Guibas 1995, "Optimally combining sampling techniques for Monte Carlo rendering",
//! doi:10.1145/218380.218498). Area lights are visible but occlude nothing.

mod direction_table;
pub(crate) mod dome;
mod image;
mod rectangle;
mod sample;
mod sphere;
mod sun;

use std::f32::consts::FRAC_1_PI;
use std::sync::Arc;

use glam::Vec3A;
use snowblue_geometry::ray::{Ray, SurfacePoint};

use crate::sampling::{Sampler, cosine_direction, uniform_hemisphere_direction};
use crate::spectrum::Spectrum;
use crate::spectrum::light_spectrum::LightSpectrum;

pub use dome::SkyDome;
pub use image::{Panorama, SkyImage};
pub use rectangle::{RectangleLight, RectanglePlace};
pub use sample::SpotCone;
use sample::{EmitterPoint, Falloff};
pub(crate) use sample::{IncidentLight, LightDirection, LightOrigin, LightSample, SHADOW_EPSILON};
pub use sphere::SphereLight;
pub use sun::SunDisc;

/// A point light, isotropic or a spot.
#[derive(Debug, Clone, Copy)]
pub struct PointLight {
    /// Position in m.
    pub position: Vec3A,
    /// Radiant intensity in W/sr, as a band density: the mean of the samples is the total over 400–700 nm.
    pub intensity: Spectrum,
    /// The same spectrum scaled to luminance Y = 1.
    pub relative: Spectrum,
    /// The cone of a spot; none for an isotropic light.
    pub cone: Option<SpotCone>,
}

/// A distant light that shines in one direction.
#[derive(Debug, Clone, Copy)]
pub struct DirectionalLight {
    /// Unit direction from the scene towards the light.
    pub to_light: Vec3A,
    /// Irradiance of a surface that faces it, in W/m², as a band density.
    pub irradiance: Spectrum,
    /// The same spectrum scaled to luminance Y = 1.
    pub relative: Spectrum,
}

/// A light with extent and the same radiance everywhere.
#[derive(Debug, Clone, Copy)]
pub struct DiffuseEmitter<Shape> {
    /// Its shape and position.
    pub shape: Shape,
    /// Radiance in W m⁻² sr⁻¹, as a band density.
    pub radiance: Spectrum,
    /// The same spectrum scaled to luminance Y = 1.
    pub relative: Spectrum,
    /// Whether the camera sees it; it lights the scene in any case.
    pub visible: bool,
}

/// The shape of a sky that is the same in all directions.
#[derive(Debug, Clone, Copy)]
pub struct UniformSky;

/// A light source.
#[derive(Debug)]
pub enum Light {
    /// A point light.
    Point(PointLight),
    /// A distant light.
    Directional(DirectionalLight),
    /// A sphere that emits outwards.
    Sphere(DiffuseEmitter<SphereLight>),
    /// A rectangle that emits from one side.
    Rectangle(DiffuseEmitter<RectangleLight>),
    /// A uniform sky.
    Sky(DiffuseEmitter<UniformSky>),
    /// A sky from an image, and whether the camera sees it.
    Image(Box<SkyImage>, bool),
    /// A clear or overcast sky, and whether the camera sees it.
    Dome(Box<SkyDome>, bool),
    /// The sun, and whether the camera sees it.
    Sun(Box<SunDisc>, bool),
}

/// A way of sampling a point or a direction of a light.
#[derive(Debug, Clone, Copy)]
pub(crate) enum SamplingTechnique {
    /// Uniform in the solid angle that the light subtends at a surface point.
    SolidAngle(SurfacePoint),
    /// Proportional to the cosine with the normal of a surface point, p = cos θ / π.
    Cosine(SurfacePoint),
    /// Uniform in the hemisphere above a surface point, p = 1 / 2π.
    Hemisphere(SurfacePoint),
    /// Proportional to the luminance of a sky or the sun, or nearly so.
    Luminance,
}

/// The techniques that sample one light, each used once.
pub(crate) type SamplingTechniques = [Option<SamplingTechnique>; 3];

impl PointLight {
    /// An isotropic light of a spectrum and radiant intensity in W/sr, summed over 400–700 nm.
    pub fn new(position: Vec3A, spectrum: &LightSpectrum, radiant_intensity_w_sr: f32) -> Self {
        Self { position, intensity: spectrum.unit * radiant_intensity_w_sr, relative: spectrum.relative, cone: None }
    }
}

impl<Shape> DiffuseEmitter<Shape> {
    /// A light of a spectrum and radiance in W m⁻² sr⁻¹, summed over 400–700 nm.
    pub fn new(shape: Shape, spectrum: &LightSpectrum, radiance_w_m2_sr: f32) -> Self {
        Self { shape, radiance: spectrum.unit * radiance_w_m2_sr, relative: spectrum.relative, visible: true }
    }
}

impl Light {
    /// Whether rays can hit it.
    pub fn has_extent(&self) -> bool {
        !matches!(self, Self::Point(_) | Self::Directional(_))
    }

    /// Whether it is so small that rays do not find it by chance.
    pub(crate) fn is_small(&self) -> bool {
        matches!(self, Self::Point(_) | Self::Directional(_) | Self::Sun(..))
    }

    /// Whether it shines evenly from all sides, so that only rays find it.
    pub(crate) fn is_diffuse(&self) -> bool {
        matches!(self, Self::Sky(_))
    }

    /// Whether it shines from all sides.
    fn is_sky(&self) -> bool {
        matches!(self, Self::Sky(_) | Self::Image(..) | Self::Dome(..))
    }

    /// The one sample of a light without extent.
    #[inline]
    pub(crate) fn delta_sample(&self) -> Option<LightSample> {
        let (origin, falloff) = match self {
            Self::Point(light) => {
                (LightOrigin::Point(light.position), light.cone.map_or(Falloff::Natural, Falloff::Spot))
            }
            Self::Directional(light) => (LightOrigin::Distant(light.to_light), Falloff::Natural),
            _ => return None,
        };
        Some(LightSample { origin, falloff })
    }

    /// The one sample of a light without extent, or a sample of the sun; none for other lights.
    pub(crate) fn small_sample(&self, sampler: &mut Sampler) -> Option<LightSample> {
        match self {
            Self::Sun(..) => self.sample(0, &[Some(SamplingTechnique::Luminance), None, None], sampler),
            _ => self.delta_sample(),
        }
    }

    /// A sample at the light's centre whose irradiance depends on neither distance nor angle; none for a sky.
    pub(crate) fn central_sample(&self) -> Option<LightSample> {
        let origin = match self {
            Self::Sphere(light) => LightOrigin::Point(light.shape.centre),
            Self::Rectangle(light) => LightOrigin::Point(light.shape.centre()),
            Self::Sun(sun, _) => LightOrigin::Distant(sun.to_sun),
            _ => self.delta_sample()?.origin,
        };
        Some(LightSample { origin, falloff: Falloff::None })
    }

    /// The technique that samples a light for reflection, besides the cosine of the path's next ray. A uniform sky has
    /// none: only that ray finds it.
    fn reflection_technique(&self, surface: &SurfacePoint) -> Option<SamplingTechnique> {
        match self {
            Self::Sphere(_) | Self::Rectangle(_) => Some(SamplingTechnique::SolidAngle(*surface)),
            Self::Image(..) | Self::Dome(..) | Self::Sun(..) => Some(SamplingTechnique::Luminance),
            Self::Point(_) | Self::Directional(_) | Self::Sky(_) => None,
        }
    }

    /// One sample of a light with extent for reflection at a surface. It counts together with the path's next ray
    /// ([`hit_radiance`](Self::hit_radiance)).
    pub(crate) fn sample_for_reflection(&self, surface: &SurfacePoint, sampler: &mut Sampler) -> Option<LightSample> {
        let technique = self.reflection_technique(surface)?;
        self.sample(0, &[Some(technique), Some(SamplingTechnique::Cosine(*surface)), None], sampler)
    }

    /// Samples of a light with extent as seen from a surface, which count together: one for each technique.
    pub(crate) fn samples_at(&self, surface: &SurfacePoint, sampler: &mut Sampler) -> [Option<LightSample>; 2] {
        let cosine = self.is_sky().then_some(SamplingTechnique::Cosine(*surface));
        let techniques = [self.reflection_technique(surface), cosine, None];
        [0, 1].map(|chosen| self.sample(chosen, &techniques, sampler))
    }

    /// Radiance that a path's ray finds from this light before `limit_m`, weighted against
    /// [`sample_for_reflection`](Self::sample_for_reflection). The ray starts at the camera, or at a surface with the
    /// density of its cosine.
    pub(crate) fn hit_radiance(&self, ray: &Ray, limit_m: f32, from: Option<&SurfacePoint>) -> Option<Spectrum> {
        let origin = self.origin_on(ray, limit_m)?;
        let Some(surface) = from else {
            return self.is_visible_to_camera().then(|| self.power(&origin));
        };
        let own = self.density(&SamplingTechnique::Cosine(*surface), &origin);
        let other = self.reflection_technique(surface).map_or(0.0, |technique| self.density(&technique, &origin));
        let weight = if other > 0.0 { own / (own + other) } else { 1.0 };
        Some(self.power(&origin) * weight)
    }

    /// Unweighted radiance that a ray finds from this light before `limit_m`, and its distance in m. Visibility to the
    /// camera does not matter.
    pub(crate) fn full_hit_radiance(&self, ray: &Ray, limit_m: f32) -> Option<LightHit> {
        let origin = self.origin_on(ray, limit_m)?;
        Some(LightHit { radiance: self.power(&origin), distance_m: origin.direction_from(ray.origin).distance_m })
    }

    /// The point or direction of a light with extent that a ray hits before `limit_m`.
    fn origin_on(&self, ray: &Ray, limit_m: f32) -> Option<LightOrigin> {
        match self {
            Self::Point(_) | Self::Directional(_) => None,
            Self::Sphere(light) => light.shape.hit(ray, limit_m).map(LightOrigin::Emitter),
            Self::Rectangle(light) => light.shape.hit(ray, limit_m).map(LightOrigin::Emitter),
            _ if limit_m < f32::INFINITY => None,
            Self::Sky(_) | Self::Image(..) | Self::Dome(..) => Some(LightOrigin::Distant(ray.direction)),
            Self::Sun(sun, _) => sun.holds(ray.direction).then_some(LightOrigin::Distant(ray.direction)),
        }
    }

    /// The techniques that sample light for snow, which enters at `exit` or along the line from the point `lines`, or
    /// both.
    pub(crate) fn techniques_through(
        &self,
        exit: Option<&SurfacePoint>,
        lines: Option<&SurfacePoint>,
    ) -> SamplingTechniques {
        match self {
            Self::Point(_) | Self::Directional(_) => [None; 3],
            Self::Sphere(_) | Self::Rectangle(_) => {
                [exit, lines, None].map(|surface| surface.copied().map(SamplingTechnique::SolidAngle))
            }
            Self::Sun(..) => [Some(SamplingTechnique::Luminance), None, None],
            // A line that leaves through a side may do so with the full cosine, although it grazes its own surface.
            Self::Sky(_) | Self::Image(..) | Self::Dome(..) => [
                exit.copied().map(SamplingTechnique::Cosine),
                lines.copied().map(SamplingTechnique::Hemisphere),
                (!self.is_diffuse()).then_some(SamplingTechnique::Luminance),
            ],
        }
    }

    /// One sample by technique number `chosen` of several that are used once each.
    pub(crate) fn sample(
        &self,
        chosen: usize,
        techniques: &SamplingTechniques,
        sampler: &mut Sampler,
    ) -> Option<LightSample> {
        let technique = techniques[chosen].as_ref()?;
        let [u, v, ..] = sampler.next_four();
        let origin = self.sample_origin(technique, [u, v])?;
        let density: f32 = techniques.iter().flatten().map(|technique| self.density(technique, &origin)).sum();
        let spread_m2 = match self {
            Self::Sphere(light) => light.shape.radius_m * light.shape.radius_m,
            Self::Rectangle(light) => light.shape.area_m2() * FRAC_1_PI,
            _ => 0.0,
        };
        let falloff = Falloff::Sampled { density, spread_m2 };
        (density > 0.0).then_some(LightSample { origin, falloff })
    }

    fn sample_origin(&self, technique: &SamplingTechnique, numbers: [f32; 2]) -> Option<LightOrigin> {
        let [u, v] = numbers;
        match (technique, self) {
            (SamplingTechnique::SolidAngle(surface), Self::Sphere(light)) => {
                light.shape.sample(surface.point, numbers).map(LightOrigin::Emitter)
            }
            (SamplingTechnique::SolidAngle(surface), Self::Rectangle(light)) => {
                light.shape.sample(surface.point, numbers).map(LightOrigin::Emitter)
            }
            (SamplingTechnique::Cosine(surface), _) => {
                Some(LightOrigin::Distant(cosine_direction(surface.normal, u, v)))
            }
            (SamplingTechnique::Hemisphere(surface), _) => {
                Some(LightOrigin::Distant(uniform_hemisphere_direction(surface.normal, u, v)))
            }
            (SamplingTechnique::Luminance, Self::Image(image, _)) => Some(LightOrigin::Distant(image.sample(numbers))),
            (SamplingTechnique::Luminance, Self::Dome(dome, _)) => Some(LightOrigin::Distant(dome.sample(numbers))),
            (SamplingTechnique::Luminance, Self::Sun(sun, _)) => Some(LightOrigin::Distant(sun.sample(numbers))),
            _ => None,
        }
    }

    /// Density with which a technique samples an origin: per m² of an area light, per sr of directions.
    fn density(&self, technique: &SamplingTechnique, origin: &LightOrigin) -> f32 {
        let (point, density_per_sr) = match technique {
            SamplingTechnique::SolidAngle(surface) => {
                (surface.point, self.solid_angle_density_per_sr(surface.point, origin))
            }
            SamplingTechnique::Cosine(SurfacePoint { point, normal }) => {
                (*point, normal.dot(origin.direction_from(*point).direction).max(0.0) * FRAC_1_PI)
            }
            SamplingTechnique::Hemisphere(SurfacePoint { point, normal }) => {
                let above = normal.dot(origin.direction_from(*point).direction) > 0.0;
                (*point, if above { 0.5 * FRAC_1_PI } else { 0.0 })
            }
            SamplingTechnique::Luminance => match (self, origin) {
                (Self::Image(image, _), LightOrigin::Distant(direction)) => return image.density_per_sr(*direction),
                (Self::Dome(dome, _), LightOrigin::Distant(direction)) => return dome.density_per_sr(*direction),
                (Self::Sun(sun, _), LightOrigin::Distant(direction)) => return sun.density_per_sr(*direction),
                _ => return 0.0,
            },
        };
        density_per_sr / origin.area_per_solid_angle(point)
    }

    fn solid_angle_density_per_sr(&self, from: Vec3A, origin: &LightOrigin) -> f32 {
        match self {
            Self::Sphere(light) => light.shape.density_per_sr(from),
            Self::Rectangle(light) => light.shape.density_per_sr(from, origin.area_per_solid_angle(from)),
            _ => 0.0,
        }
    }

    /// The power of an origin that is the same for all origins of the light; none if they differ.
    pub(crate) fn uniform_power(&self) -> Option<&Spectrum> {
        match self {
            Self::Point(PointLight { intensity, .. }) => Some(intensity),
            Self::Directional(DirectionalLight { irradiance, .. }) => Some(irradiance),
            Self::Sphere(DiffuseEmitter { radiance, .. })
            | Self::Rectangle(DiffuseEmitter { radiance, .. })
            | Self::Sky(DiffuseEmitter { radiance, .. }) => Some(radiance),
            Self::Image(..) | Self::Dome(..) | Self::Sun(..) => None,
        }
    }

    /// The power of an origin: radiant intensity of a point light, irradiance of a directional light, radiance of all
    /// others, as a band density.
    pub(crate) fn power(&self, origin: &LightOrigin) -> Spectrum {
        match (self, origin) {
            (Self::Image(image, _), LightOrigin::Distant(direction)) => image.radiance(*direction),
            (Self::Dome(dome, _), LightOrigin::Distant(direction)) => dome.radiance(*direction),
            (Self::Sun(sun, _), LightOrigin::Distant(direction)) => sun.radiance(*direction),
            _ => self.uniform_power().copied().unwrap_or(Spectrum::ZERO),
        }
    }

    /// The spectrum of an origin scaled to luminance Y = 1.
    pub(crate) fn relative(&self, origin: &LightOrigin) -> Spectrum {
        match (self, origin) {
            (Self::Point(PointLight { relative, .. }), _)
            | (Self::Directional(DirectionalLight { relative, .. }), _)
            | (Self::Sphere(DiffuseEmitter { relative, .. }), _)
            | (Self::Rectangle(DiffuseEmitter { relative, .. }), _)
            | (Self::Sky(DiffuseEmitter { relative, .. }), _) => *relative,
            (Self::Image(image, _), LightOrigin::Distant(direction)) => image.relative(*direction),
            (Self::Dome(..) | Self::Sun(..), _) => {
                let power = self.power(origin);
                let luminance = LightSpectrum::luminance(&power);
                if luminance > 0.0 { power * luminance.recip() } else { Spectrum::ZERO }
            }
            (Self::Image(..), _) => Spectrum::ZERO,
        }
    }

    /// Whether a camera ray meets it before `limit_m` as a lamp or the sun, on which the exposure of a picture does not
    /// depend. A sky is part of the picture.
    pub(crate) fn is_seen_as_emitter(&self, ray: &Ray, limit_m: f32) -> bool {
        let is_emitter = matches!(self, Self::Sphere(_) | Self::Rectangle(_) | Self::Sun(..));
        is_emitter && self.is_visible_to_camera() && self.origin_on(ray, limit_m).is_some()
    }

    fn is_visible_to_camera(&self) -> bool {
        match self {
            Self::Point(_) | Self::Directional(_) => false,
            Self::Sphere(DiffuseEmitter { visible, .. })
            | Self::Rectangle(DiffuseEmitter { visible, .. })
            | Self::Sky(DiffuseEmitter { visible, .. })
            | Self::Image(_, visible)
            | Self::Dome(_, visible)
            | Self::Sun(_, visible) => *visible,
        }
    }
}

/// The irradiance of level ground by skies, the sun and distant lights, in W/m² as a band density.
pub(crate) fn irradiance_by_sky(lights: &[Arc<Light>]) -> Spectrum {
    /// Samples of a light with extent.
    const SAMPLES: u32 = 1 << 12;
    let ground = SurfacePoint { point: Vec3A::ZERO, normal: Vec3A::Z };
    let mut sum = Spectrum::ZERO;
    for light in lights {
        let mut add = |sample: &LightSample, share: f32| {
            if let (LightOrigin::Distant(_), Some(incident)) = (sample.origin, sample.incident_at(&ground)) {
                sum += light.power(&sample.origin) * (share * incident.irradiance_per_power);
            }
        };
        match light.delta_sample() {
            Some(sample) => add(&sample, 1.0),
            None if light.is_sky() || matches!(**light, Light::Sun(..)) => {
                for index in 0..SAMPLES {
                    let samples = light.samples_at(&ground, &mut Sampler::new(0, 0, index));
                    samples.iter().flatten().for_each(|sample| add(sample, (SAMPLES as f32).recip()));
                }
            }
            None => {}
        }
    }
    sum
}

/// What a ray finds of a light with extent.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LightHit {
    /// Radiance along the ray, as a band density.
    pub(crate) radiance: Spectrum,
    /// Distance along the ray in m, infinite for a sky.
    pub(crate) distance_m: f32,
}

#[cfg(test)]
mod tests;
