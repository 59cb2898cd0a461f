//! A light of a scene, and the techniques that sample it.
//!
//! Where several techniques sample a light, p is the sum of their densities: the balance heuristic of multiple
//! importance sampling (Veach & Guibas 1995, "Optimally combining sampling techniques for Monte Carlo rendering",
//! doi:10.1145/218380.218498).

use std::sync::Arc;

use glam::Vec3A;
use snowblue_geometry::ray::{Ray, SurfacePoint};

use crate::directions::Directions;
use crate::light::emitter::{Emitter, InnerLamp, LightType};
use crate::light::sample::{Falloff, LightOrigin, LightSample};
use crate::light::sun;
use crate::sampling::Sampler;
use crate::spectrum::Spectrum;

/// The viewpoint for distant lights, which are the same from everywhere.
const ANYWHERE: Vec3A = Vec3A::ZERO;

/// A light of a scene.
#[derive(Debug, Clone)]
pub struct Light {
    emitter: Arc<dyn Emitter>,
    light_type: LightType,
    is_visible: bool,
}

/// A way of sampling a point or a direction of a light.
#[derive(Debug, Clone, Copy)]
pub enum SamplingTechnique<'a> {
    /// The technique of the light itself, as seen from a point.
    OfLight(Vec3A),
    /// Directions above a surface.
    OfSurface(Directions<'a>),
}

/// The techniques that sample one light, each used once.
pub type SamplingTechniques<'a> = [Option<SamplingTechnique<'a>>; 3];

/// The hit of a ray on a light with extent.
#[derive(Debug, Clone, Copy)]
pub struct LightHit {
    /// Radiance along the ray, as a band density.
    pub radiance: Spectrum,
    /// Distance along the ray in m, infinite for a sky.
    pub distance_m: f32,
}

impl Light {
    /// A light that the camera sees if it has an extent.
    pub(crate) fn new(emitter: impl Emitter) -> Self {
        Self { light_type: emitter.light_type(), emitter: Arc::new(emitter), is_visible: true }
    }

    /// The same light, visible to the camera or not. The light illuminates the scene in any case.
    pub(crate) fn with_visibility(self, is_visible: bool) -> Self {
        Self { is_visible, ..self }
    }

    /// The lights of which each is found by rays, or is small: the light itself, or two lights that add up to it.
    pub fn parts(light: &Arc<Self>) -> Vec<Arc<Self>> {
        match light.emitter.parts() {
            Some(parts) => {
                let of_part = |emitter: Arc<dyn Emitter>| Self { light_type: emitter.light_type(), emitter, ..**light };
                parts.into_iter().map(of_part).map(Arc::new).collect()
            }
            None => vec![Arc::clone(light)],
        }
    }

    /// The name of the light: its `type` in a scene file, `sun` or `sky`.
    pub fn name(&self) -> &'static str {
        self.emitter.name()
    }

    /// Whether the light shines from all sides.
    pub fn is_sky(&self) -> bool {
        matches!(self.light_type, LightType::Infinite | LightType::UniformInfinite)
    }

    /// The radiant intensity of a point in W/sr, or the irradiance of a surface that faces a distant light or the sun
    /// in W/m², as a band density. For other lights the strength is zero: their radiance depends on the place that it
    /// reaches.
    pub fn strength(&self) -> Spectrum {
        match self.light_type {
            LightType::DeltaPosition(..) | LightType::DeltaDirection(_) => {
                self.uniform_power().copied().unwrap_or(Spectrum::ZERO)
            }
            LightType::Disc(_) => self.emitter.normal_irradiance(),
            LightType::Area { .. } | LightType::Infinite | LightType::UniformInfinite => Spectrum::ZERO,
        }
    }

    /// Whether rays can hit the light.
    #[inline]
    pub fn has_extent(&self) -> bool {
        self.delta_sample().is_none()
    }

    /// Whether the light is so small that rays do not find it by chance.
    pub fn is_small(&self) -> bool {
        matches!(self.light_type, LightType::Disc(_)) || !self.has_extent()
    }

    /// The variance, across one axis, of the direction from which the light comes to a point, in rad². It is the
    /// variance of a disc of the light's size. None for a sky.
    #[inline]
    pub fn angular_variance(&self, point: Vec3A) -> Option<f32> {
        match self.light_type {
            LightType::DeltaPosition(..) | LightType::DeltaDirection(_) => Some(0.0),
            LightType::Area { centre, spread_m2 } => Some(0.25 * spread_m2 / centre.distance_squared(point)),
            LightType::Disc(_) => Some(sun::angular_variance()),
            LightType::Infinite | LightType::UniformInfinite => None,
        }
    }

    /// Whether the light shines evenly from all sides, so that only rays find it.
    pub fn is_diffuse(&self) -> bool {
        matches!(self.light_type, LightType::UniformInfinite)
    }

    /// Whether the light is a sky without edges: a model of the sky, without its sun, and not an image.
    pub fn is_smooth_sky(&self) -> bool {
        self.emitter.is_smooth_sky()
    }

    /// Points at a distance in m before a flat emitting side, spread over this side; none for other lights.
    pub fn points_before(&self, distance_m: f32) -> Vec<Vec3A> {
        self.emitter.points_before(distance_m)
    }

    /// The light as a lamp inside snow; none if it cannot be one.
    pub fn inner_lamp(&self) -> Option<InnerLamp> {
        self.emitter.inner_lamp()
    }

    /// The only sample of a light without extent.
    #[inline]
    pub fn delta_sample(&self) -> Option<LightSample> {
        let (origin, falloff) = match self.light_type {
            LightType::DeltaPosition(position, cone) => {
                (LightOrigin::Point(position), cone.map_or(Falloff::Natural, Falloff::Spot))
            }
            LightType::DeltaDirection(to_light) => (LightOrigin::Distant(to_light), Falloff::Natural),
            LightType::Area { .. } | LightType::Disc(_) | LightType::Infinite | LightType::UniformInfinite => {
                return None;
            }
        };
        Some(LightSample { origin, falloff })
    }

    /// The only sample of a light without extent, or a sample of the sun; none for other lights.
    pub fn small_sample(&self, sampler: &mut Sampler) -> Option<LightSample> {
        match self.light_type {
            LightType::Disc(_) => self.sample(0, &[Some(SamplingTechnique::OfLight(ANYWHERE)), None, None], sampler),
            LightType::DeltaPosition(..) | LightType::DeltaDirection(_) => self.delta_sample(),
            LightType::Area { .. } | LightType::Infinite | LightType::UniformInfinite => None,
        }
    }

    /// A sample at the light's centre whose irradiance depends on neither distance nor angle; none for a sky.
    pub fn central_sample(&self) -> Option<LightSample> {
        let origin = match self.light_type {
            LightType::DeltaPosition(centre, _) | LightType::Area { centre, .. } => LightOrigin::Point(centre),
            LightType::DeltaDirection(to_light) | LightType::Disc(to_light) => LightOrigin::Distant(to_light),
            LightType::Infinite | LightType::UniformInfinite => return None,
        };
        Some(LightSample { origin, falloff: Falloff::None })
    }

    /// The technique that samples a light for reflection at a point, in addition to the path's next ray. A uniform sky
    /// has no such technique: only the next ray finds it.
    fn reflection_technique(&self, point: Vec3A) -> Option<SamplingTechnique<'static>> {
        match self.light_type {
            LightType::Area { .. } | LightType::Disc(_) | LightType::Infinite => {
                Some(SamplingTechnique::OfLight(point))
            }
            LightType::DeltaPosition(..) | LightType::DeltaDirection(_) | LightType::UniformInfinite => None,
        }
    }

    /// One sample of a light with extent for reflection at a surface. It is combined with the path's next ray, which
    /// has the density of `directions` ([`hit_radiance`](Self::hit_radiance)).
    pub fn sample_for_reflection(&self, directions: &Directions, sampler: &mut Sampler) -> Option<LightSample> {
        let technique = self.reflection_technique(directions.point())?;
        self.sample(0, &[Some(technique), Some(SamplingTechnique::OfSurface(*directions)), None], sampler)
    }

    /// Samples of a light with extent as seen from a surface, which are combined: one sample by the light's own
    /// technique, and for a sky one sample by `directions`.
    pub fn samples_at(&self, directions: &Directions, sampler: &mut Sampler) -> [Option<LightSample>; 2] {
        let of_surface = self.is_sky().then_some(SamplingTechnique::OfSurface(*directions));
        let techniques = [self.reflection_technique(directions.point()), of_surface, None];
        [0, 1].map(|chosen| self.sample(chosen, &techniques, sampler))
    }

    /// Radiance of this light along a path's ray before `limit_m`, weighted against
    /// [`sample_for_reflection`](Self::sample_for_reflection). The ray starts at the camera, or at a surface with the
    /// density of `from`.
    pub fn hit_radiance(&self, ray: &Ray, limit_m: f32, from: Option<&Directions>) -> Option<Spectrum> {
        let origin = self.origin_on(ray, limit_m)?;
        let Some(directions) = from else {
            return self.is_visible.then(|| self.power(&origin));
        };
        let own = self.density(&SamplingTechnique::OfSurface(*directions), &origin);
        let technique = self.reflection_technique(directions.point());
        let other = technique.map_or(0.0, |technique| self.density(&technique, &origin));
        let weight = if other > 0.0 { own / (own + other) } else { 1.0 };
        Some(self.power(&origin) * weight)
    }

    /// Unweighted radiance of this light along a ray before `limit_m`, and the distance of the light in m. Visibility
    /// to the camera does not matter.
    pub fn full_hit_radiance(&self, ray: &Ray, limit_m: f32) -> Option<LightHit> {
        let origin = self.origin_on(ray, limit_m)?;
        Some(LightHit { radiance: self.power(&origin), distance_m: origin.direction_from(ray.origin).distance_m })
    }

    /// The point or direction of a light with extent that a ray hits before `limit_m`.
    #[inline]
    pub(super) fn origin_on(&self, ray: &Ray, limit_m: f32) -> Option<LightOrigin> {
        let is_open = limit_m == f32::INFINITY;
        match self.light_type {
            LightType::DeltaPosition(..) | LightType::DeltaDirection(_) => None,
            LightType::Area { .. } => self.emitter.hit(ray, limit_m),
            LightType::Disc(_) => self.emitter.hit(ray, limit_m).filter(|_| is_open),
            LightType::Infinite | LightType::UniformInfinite => is_open.then_some(LightOrigin::Distant(ray.direction)),
        }
    }

    /// The techniques that sample light for snow. The light enters at `exit`, along the line from the point `lines`,
    /// or both.
    pub fn techniques_through(
        &self,
        exit: Option<&SurfacePoint>,
        lines: Option<&SurfacePoint>,
    ) -> SamplingTechniques<'static> {
        let distant = Some(SamplingTechnique::OfLight(ANYWHERE));
        match self.light_type {
            LightType::DeltaPosition(..) | LightType::DeltaDirection(_) => [None; 3],
            LightType::Area { .. } => {
                [exit, lines, None].map(|surface| surface.map(|surface| SamplingTechnique::OfLight(surface.point)))
            }
            LightType::Disc(_) => [distant, None, None],
            // A line may leave through a side with the full cosine, although it grazes the surface where it starts.
            LightType::Infinite | LightType::UniformInfinite => [
                exit.map(|surface| SamplingTechnique::OfSurface(Directions::Cosine(*surface))),
                lines.map(|surface| SamplingTechnique::OfSurface(Directions::Hemisphere(*surface))),
                distant.filter(|_| !self.is_diffuse()),
            ],
        }
    }

    /// One sample by technique number `chosen` among several techniques that are used once each.
    pub fn sample(&self, chosen: usize, techniques: &SamplingTechniques, sampler: &mut Sampler) -> Option<LightSample> {
        let technique = techniques[chosen].as_ref()?;
        let [u, v, ..] = sampler.next_four();
        let origin = self.sample_origin(technique, [u, v])?;
        let density: f32 = techniques.iter().flatten().map(|technique| self.density(technique, &origin)).sum();
        let spread_m2 = if let LightType::Area { spread_m2, .. } = self.light_type { spread_m2 } else { 0.0 };
        let falloff = Falloff::Sampled { density, spread_m2 };
        (density > 0.0).then_some(LightSample { origin, falloff })
    }

    pub(super) fn sample_origin(&self, technique: &SamplingTechnique, numbers: [f32; 2]) -> Option<LightOrigin> {
        match technique {
            SamplingTechnique::OfLight(from) => self.emitter.sample_li(*from, numbers),
            SamplingTechnique::OfSurface(directions) => Some(LightOrigin::Distant(directions.sample(numbers))),
        }
    }

    /// Density with which a technique samples an origin: per m² for an area light, per sr for directions.
    pub(super) fn density(&self, technique: &SamplingTechnique, origin: &LightOrigin) -> f32 {
        let (point, density_per_sr) = match technique {
            SamplingTechnique::OfLight(from) => (*from, self.emitter.pdf_li(*from, origin)),
            SamplingTechnique::OfSurface(directions) => {
                let point = directions.point();
                (point, directions.density_per_sr(origin.direction_from(point).direction))
            }
        };
        density_per_sr / origin.area_per_solid_angle(point)
    }

    /// The power of an origin if the power is the same for all origins of the light; none otherwise.
    pub fn uniform_power(&self) -> Option<&Spectrum> {
        self.emitter.uniform()
    }

    /// The power of an origin, as a band density: radiant intensity for a point light, irradiance for a directional
    /// light, radiance for all other lights.
    #[inline]
    pub fn power(&self, origin: &LightOrigin) -> Spectrum {
        self.emitter.le(origin)
    }

    /// Whether a camera ray meets the light before `limit_m` as a lamp or the sun. The exposure of a picture does not
    /// depend on such pixels. A sky is part of the picture.
    pub fn is_seen_as_emitter(&self, ray: &Ray, limit_m: f32) -> bool {
        !self.is_sky() && self.is_visible && self.origin_on(ray, limit_m).is_some()
    }
}

/// The irradiance of level ground by skies, the sun and distant lights, in W/m² as a band density.
pub fn irradiance_by_sky(lights: &[Arc<Light>]) -> Spectrum {
    /// Samples of a light with extent.
    const SAMPLES: u32 = 1 << 12;
    let ground = SurfacePoint { point: Vec3A::ZERO, normal: Vec3A::Z };
    let directions = Directions::Cosine(ground);
    let mut sum = Spectrum::ZERO;
    for light in lights {
        let mut add = |sample: &LightSample, share: f32| {
            if let Some(incident) = sample.incident_at(&ground) {
                sum += light.power(&sample.origin) * (share * incident.irradiance_per_power);
            }
        };
        match light.light_type {
            LightType::DeltaPosition(..) | LightType::Area { .. } => {}
            LightType::DeltaDirection(_) => light.delta_sample().iter().for_each(|sample| add(sample, 1.0)),
            LightType::Disc(_) | LightType::Infinite | LightType::UniformInfinite => {
                for index in 0..SAMPLES {
                    let samples = light.samples_at(&directions, &mut Sampler::new(0, 0, index));
                    samples.iter().flatten().for_each(|sample| add(sample, (SAMPLES as f32).recip()));
                }
            }
        }
    }
    sum
}
