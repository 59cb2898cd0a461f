//! Path tracer over surfaces: PCASnow, and the light field.
//!
//! L = Σ_k β_k L_lit(x_k), β_{k+1} = β_k ρ(x_k) cos θ / (π p) (Kajiya 1986, "The rendering equation",
//! doi:10.1145/15922.15902; notation of Pharr, Jakob & Humphreys 2023, chapter 13). The density p of the next direction
//! is cos θ / π at a diffuse surface, so that only its reflectance ρ remains, and about that of the reflected light at
//! snow. With a light field, half of the directions are sampled towards bright snow. Long paths end by Russian
//! roulette.
//!
//! Snow by PCASnow transmits light along one straight line, by the curves of a slab, and reflects it as a surface. Snow
//! with a light field ends a path: the field holds the light that comes by other surfaces. The first surface is shaded
//! by its functions, and with `hybrid` also by a random walk ([`hybrid`](super::super::hybrid)); later ones by their
//! mean radiance.
//!
//! Lights with extent are found by sampling them and by the path's next ray, weighted by multiple importance sampling
//! (see [`light`](snowblue_scene::light)).
//!
use std::f32::consts::FRAC_1_PI;

use glam::Vec3A;
use snowblue_geometry::ray::{Ray, SurfacePoint};

use super::open_sky::OpenSky;
use super::scene_lights::SceneLights;
use super::vertex::{Shading, Vertex};
use crate::integrators::first_hit::light_limit_m;
use crate::integrators::hybrid::walk::WalkTracer;
use crate::integrators::pcasnow::snow_vertex::PcaSnow;
use crate::integrators::prepared::{Method, Prepared};
use crate::integrators::russian_roulette::survival_probability;
use crate::integrators::single_scattering::SingleScattering;
use crate::integrators::sparkle::{SparkleReader, SparklingPoint};
use crate::integrators::{FilteredSample, PathSample};
use snowblue_light_field::{LightField, SnowAt};
use snowblue_scene::Scene;
use snowblue_scene::directions::Directions;
use snowblue_scene::light::{IncidentLight, Light, LightSample};
use snowblue_scene::material::Material;
use snowblue_scene::material::diffuse::Diffuse;
use snowblue_scene::objects::{Side, SurfaceInteraction};
use snowblue_scene::queries::{SceneQueries, Statistics};
use snowblue_scene::sampling::Sampler;
use snowblue_scene::spectrum::Spectrum;

/// Traces paths through a scene.
#[derive(Debug)]
pub(crate) struct PathTracer<'a> {
    scene: &'a Scene,
    lights: SceneLights<'a>,
    queries: SceneQueries<'a>,
    /// Snow by PCASnow, or none with a light field.
    pcasnow: Option<PcaSnow<'a>>,
    /// The light field, or none with PCASnow.
    field: Option<&'a LightField>,
    /// Random walks in snow, if there are any.
    walks: Option<WalkTracer<'a>>,
    /// Single scattering in snow, where the light field is read at the surface; none for PCASnow.
    singles: Option<SingleScattering<'a>>,
    /// Sparkle of snow, if there is any.
    sparkle: Option<SparkleReader<'a>>,
    /// Whether paths can hit lights.
    has_area_lights: bool,
    /// Whether the picture is filtered.
    is_filtered: bool,
    /// Skies that nothing hides, for the filter.
    sky: &'a OpenSky,
}

/// Radiance along a camera ray, in W m⁻² sr⁻¹ as a band density.
struct PathRadiance {
    /// Light that leaves the first surface, or a light before it.
    first: Spectrum,
    /// Whether the first surface is snow.
    sees_snow: bool,
    /// Distance to the first surface, in m; none if there is none.
    distance_m: Option<f32>,
    /// Light that comes by further surfaces, if the path has any.
    later: Option<Spectrum>,
    /// What the filter compares, if the first surface is filtered.
    filtered: Option<Compared>,
}

/// What the filter compares: light that leaves a surface, but for its sparkle, and an estimate of it.
struct Compared {
    /// All of it but what comes by further surfaces.
    found: Spectrum,
    /// An estimate of all of it that has little noise.
    reading: Spectrum,
    is_snow: bool,
    normal: Vec3A,
}

/// Light of snow with a light field.
struct SnowLight {
    /// All but the sparkle.
    radiance: Spectrum,
    /// The radiance by the light field alone, for the filter.
    reading: Option<Spectrum>,
    /// What single facets add to it, or take away.
    sparkle: Spectrum,
}

/// Light that leaves a surface by lamps and skies, and of snow by its light field.
struct DirectLight {
    /// By the field and by all lights but smooth skies.
    steady: Spectrum,
    /// By samples of smooth skies, unless they are left out.
    of_sky: Spectrum,
    /// What single facets add to it, or take away.
    sparkle: Spectrum,
}

impl DirectLight {
    /// All but the sparkle.
    fn smooth(&self) -> Spectrum {
        let mut light = self.steady;
        light += self.of_sky;
        light
    }
}

impl PathRadiance {
    /// The sample of the path.
    #[inline]
    fn sample(self) -> PathSample<Spectrum> {
        let Self { first: mut radiance, sees_snow, distance_m, later, filtered } = self;
        if let Some(later) = later {
            radiance += later;
        }
        let filtered = filtered.zip(distance_m).map(|(compared, distance_m)| {
            let Compared { mut found, reading, is_snow, normal } = compared;
            if let Some(later) = later {
                found += later;
            }
            let mut residual = found;
            residual += reading * -1.0;
            FilteredSample { residual, reading, is_snow, normal, distance_m }
        });
        PathSample { radiance, sees_snow, distance_m, filtered }
    }
}

impl<'a> PathTracer<'a> {
    /// Starts with zero counts.
    pub(in crate::integrators) fn new(prepared: &'a Prepared) -> Self {
        let Prepared { scene, method, bodies, .. } = prepared;
        let (pcasnow, field, volumes) = match method {
            Method::PcaSnow(curves) => (Some(PcaSnow::new(&scene.integrator().pcasnow, curves)), None, None),
            Method::Diffusion(field) => (None, Some(field), None),
            Method::Hybrid(field, volumes) => (None, Some(field), Some(volumes)),
            Method::Reference(..) => unreachable!("the reference traces no paths over surfaces"),
        };
        Self {
            scene,
            lights: SceneLights::new(scene),
            queries: SceneQueries::new(scene.objects()),
            pcasnow,
            field,
            walks: field.zip(volumes).map(|(field, volumes)| WalkTracer::new(scene, field, bodies, volumes)),
            singles: field.map(|field| SingleScattering::new(scene, field, bodies)),
            sparkle: prepared.sparkle.as_ref().map(|sparkle| SparkleReader::new(scene, sparkle)),
            has_area_lights: scene.lights().iter().any(|light| light.has_extent()),
            is_filtered: scene.description().is_filtered(),
            sky: &prepared.sky,
        }
    }

    /// Counts of the queries so far.
    pub(crate) fn statistics(&self) -> Statistics {
        let walks = self.walks.as_ref().map(WalkTracer::statistics).unwrap_or_default();
        let singles = self.singles.as_ref().map(SingleScattering::statistics).unwrap_or_default();
        self.queries.statistics.plus(walks).plus(singles)
    }

    /// One sample of the radiance along a camera ray, in W m⁻² sr⁻¹ as a band density.
    pub(crate) fn radiance(&mut self, camera_ray: &Ray, sampler: &mut Sampler) -> PathSample<Spectrum> {
        self.trace(camera_ray, sampler).sample()
    }

    #[inline]
    fn trace(&mut self, camera_ray: &Ray, sampler: &mut Sampler) -> PathRadiance {
        let hit = self.queries.camera_hit(camera_ray);
        let mut first = Spectrum::ZERO;
        if self.has_area_lights {
            first += self.hit_lights(camera_ray, hit.as_ref(), None);
        }
        let Some(surface) = hit else {
            return PathRadiance { first, sees_snow: false, distance_m: None, later: None, filtered: None };
        };
        let sees_snow = self.scene.materials()[surface.material].looks_like_snow();
        let distance_m = Some(surface.point.distance(camera_ray.origin));
        let vertex = self.vertex(&surface, sampler);
        if let Shading::Field(snow) = vertex.shading {
            let SnowLight { radiance, reading, sparkle } = self.snow_light(snow, &vertex, camera_ray, sampler);
            // Facets are as sharp as the picture: the filter neither sees nor spreads them.
            first += radiance;
            first += sparkle;
            let of_snow = |reading| Compared { found: radiance, reading, is_snow: true, normal: vertex.normal };
            let filtered = reading.map(of_snow);
            return PathRadiance { first, sees_snow, distance_m, later: None, filtered };
        }
        let sparkling = self.sparkling_curves(&vertex, camera_ray, sampler);
        let direct = self.direct_light(&vertex, sparkling.as_ref(), sampler);
        let light = direct.smooth();
        first += light;
        first += direct.sparkle;
        let filtered = self.is_filtered.then(|| {
            let mut reading = direct.steady;
            reading += self.unhidden_light(&vertex);
            Compared { found: light, reading, is_snow: false, normal: vertex.normal }
        });
        let has_later = self.scene.integrator().max_bounces > 0 || self.has_area_lights;
        let later = has_later.then(|| self.indirect_light(&vertex, sampler));
        PathRadiance { first, sees_snow, distance_m, later, filtered }
    }

    /// The light of the smooth skies and of the snow around that a surface reflects, roughly: as if nothing hid the
    /// snow, and nothing else the skies.
    fn unhidden_light(&self, vertex: &Vertex) -> Spectrum {
        let mut light = self.sky.reflected(vertex);
        if let Some(field) = self.field {
            let snow = field.snow_seen_from(&vertex.shading_point());
            light = light * (1.0 - snow.share);
            light += vertex.reflectance(vertex.normal) * snow.irradiance * FRAC_1_PI;
        }
        light
    }

    /// Light from snow, by the light field at the surface or by a random walk, and its sparkle.
    fn snow_light(&mut self, snow: SnowAt, vertex: &Vertex, camera_ray: &Ray, sampler: &mut Sampler) -> SnowLight {
        let sparkling = self
            .sparkle
            .as_ref()
            .and_then(|sparkle| sparkle.at((vertex.surface, snow.kind, vertex.normal), camera_ray));
        let direct = if self.walks.is_none() || self.is_filtered {
            self.field_light(snow, vertex, (camera_ray, sparkling.as_ref()), sampler)
        } else {
            let sparkle = sparkling.map_or(Spectrum::ZERO, |sparkling| self.sparkle_light(&sparkling, vertex, sampler));
            DirectLight { steady: Spectrum::ZERO, of_sky: Spectrum::ZERO, sparkle }
        };
        let reading = self.is_filtered.then(|| {
            let mut reading = direct.steady;
            let of_sky = snow.field.sky_irradiance(&vertex.shading_point()) * FRAC_1_PI;
            reading += of_sky;
            // The residual is what is found beside the reading, whatever that is. A negative reading counts as none.
            if self.lights.luminance(&reading) > 0.0 { reading } else { Spectrum::ZERO }
        });
        let radiance = match &mut self.walks {
            Some(walks) => walks.walk(snow, vertex.surface, camera_ray, sampler),
            None => direct.smooth(),
        };
        SnowLight { radiance, reading, sparkle: direct.sparkle }
    }

    /// The facets of snow by PCASnow that sparkles.
    fn sparkling_curves(&self, vertex: &Vertex, camera_ray: &Ray, sampler: &mut Sampler) -> Option<SparklingPoint<'a>> {
        let (Some(sparkle), Shading::Snow(snow)) = (&self.sparkle, &vertex.shading) else { return None };
        let kind = snow.kinds().at_surface(self.scene.objects(), vertex.surface);
        let kind = if kind.is_mixed() { kind.pick(sampler.next_four()[0]) } else { kind.first };
        sparkle.at((vertex.surface, kind, vertex.normal), camera_ray)
    }

    /// The change of the light that leaves a surface by its sparkle in the light of one sample that arrives there.
    fn sparkle_change(
        &mut self,
        sparkling: &SparklingPoint,
        vertex: &Vertex,
        (light, sample): (&Light, &LightSample),
        incident: &IncidentLight,
    ) -> Option<Spectrum> {
        // No more than what the curves of PCASnow reflect in all.
        let most_per_sr = match &vertex.shading {
            Shading::Snow(snow) => FRAC_1_PI * snow.reflectance(incident.cos_incidence).minimum(),
            Shading::Field(_) | Shading::Ground(_) | Shading::Diffuse(_) | Shading::Textured(_) => f32::INFINITY,
        };
        let change = self.sparkle.as_mut()?.change(sparkling, light, sample, most_per_sr)?;
        Some(change * light.power(&sample.origin) * incident.irradiance_per_power)
    }

    /// The change of the light that leaves a surface by its sparkle in all lights.
    fn sparkle_light(&mut self, sparkling: &SparklingPoint, vertex: &Vertex, sampler: &mut Sampler) -> Spectrum {
        let directions = vertex.directions;
        let mut sparkle = Spectrum::ZERO;
        for (index, source) in self.scene.lights().iter().enumerate().filter(|(_, light)| !light.is_sky()) {
            for sample in self.samples_of_light(index, &directions, sampler).into_iter().flatten() {
                if let Some(incident) = self.visible(vertex, &sample)
                    && let Some(change) = self.sparkle_change(sparkling, vertex, (source, &sample), &incident)
                {
                    sparkle += change;
                }
            }
        }
        sparkle
    }

    /// Samples of a light as seen from a surface, which count together; none of a diffuse light.
    fn samples_of_light(
        &self,
        light: usize,
        directions: &Directions,
        sampler: &mut Sampler,
    ) -> [Option<LightSample>; 2] {
        let source = &self.scene.lights()[light];
        match self.lights.delta_sample(light) {
            Some(sample) => [Some(*sample), None],
            None if source.is_diffuse() => [None, None],
            None => source.samples_at(directions, sampler),
        }
    }

    /// Light that comes to a path's first surface from further surfaces and by rays that hit lights, reflected there.
    fn indirect_light(&mut self, first: &Vertex, sampler: &mut Sampler) -> Spectrum {
        let max_bounces = self.scene.integrator().max_bounces;
        let (mut radiance, mut throughput) = (Spectrum::ZERO, Spectrum::ONE);
        let Some(mut ray) = self.bounce(first, 0, &mut throughput, sampler) else { return radiance };
        let mut from = first.directions;
        for bounce in 1.. {
            let hit = self.queries.indirect_hit(&ray);
            if self.has_area_lights {
                radiance.add_product(1.0, &throughput, &self.hit_lights(&ray, hit.as_ref(), Some(&from)));
            }
            let Some(surface) = hit.filter(|_| bounce <= max_bounces) else { break };
            let vertex = self.vertex(&surface, sampler);
            if let Shading::Field(snow) = vertex.shading {
                radiance.add_product(1.0, &throughput, &snow.field.mean_radiance(&surface.surface_point()));
                break;
            }
            let direct = self.direct_light(&vertex, None, sampler).smooth();
            radiance.add_product(1.0, &throughput, &direct);
            // The last ray finds lights only.
            if bounce == max_bounces && !self.has_area_lights {
                break;
            }
            match self.bounce(&vertex, bounce, &mut throughput, sampler) {
                Some(next) => (ray, from) = (next, vertex.directions),
                None => break,
            }
        }
        radiance
    }

    /// Samples the next ray of a path at a surface and updates its throughput; none if the path ends.
    fn bounce(&self, vertex: &Vertex, bounce: u32, throughput: &mut Spectrum, sampler: &mut Sampler) -> Option<Ray> {
        let [u, v, chance, choice] = sampler.next_four();
        let (surface, directions) = (vertex.surface.surface_point(), vertex.directions);
        // The last ray finds lights only.
        let (direction, factor) = match self.field {
            Some(field) if bounce < self.scene.integrator().max_bounces => {
                field.sample_reflection(&directions, [u, v, choice])
            }
            _ => directions.sample_weighted([u, v]),
        };
        *throughput *= vertex.reflectance(direction) * factor;
        let survival = survival_probability(bounce, throughput);
        if chance >= survival || throughput.maximum() <= 0.0 {
            return None;
        }
        *throughput = *throughput * survival.recip();
        Some(Ray { origin: self.queries.off_surface(vertex.surface.object, &surface), direction })
    }

    /// Light that snow with a light field sends out: what it reflects of the lights, and what comes from inside.
    fn field_light(
        &mut self,
        snow: SnowAt,
        vertex: &Vertex,
        (camera_ray, sparkling): (&Ray, Option<&SparklingPoint>),
        sampler: &mut Sampler,
    ) -> DirectLight {
        let (surface, directions) = (vertex.shading_point(), vertex.directions);
        let cos_exit = -surface.normal.dot(vertex.surface.direction);
        let diffuse = snow.diffuse_radiance(&surface, cos_exit);
        let mut light = DirectLight { steady: diffuse, of_sky: Spectrum::ZERO, sparkle: Spectrum::ZERO };
        let [number, ..] = sampler.next_four();
        let point = self.singles.as_mut().map(|singles| singles.point(snow, vertex.surface, camera_ray, number));
        for index in 0..self.scene.lights().len() {
            let source = &self.scene.lights()[index];
            if source.is_smooth_sky() && self.walks.is_some() {
                // The walk samples it.
                continue;
            }
            for sample in self.samples_of_light(index, &directions, sampler).into_iter().flatten() {
                let incident = self.visible(vertex, &sample);
                let part = if source.is_smooth_sky() { &mut light.of_sky } else { &mut light.steady };
                if let Some(incident) = &incident {
                    *part += reflected(vertex, source, &sample, incident);
                    if let Some(sparkling) = sparkling
                        && let Some(change) = self.sparkle_change(sparkling, vertex, (source, &sample), incident)
                    {
                        light.sparkle += change;
                    }
                }
                if let (Some(singles), Some(point)) = (&mut self.singles, &point) {
                    // The half-space that the ray enters is that of the geometric normal.
                    let on_plane = incident.and_then(|_| sample.incident_at(&vertex.surface.surface_point()));
                    let factor = singles.correction(point, &sample, on_plane.as_ref());
                    *part += source.power(&sample.origin) * factor;
                }
            }
        }
        light
    }

    /// Radiance from the lights that a ray hits before a surface.
    fn hit_lights(&self, ray: &Ray, hit: Option<&SurfaceInteraction>, from: Option<&Directions>) -> Spectrum {
        let limit_m = hit.map_or(f32::INFINITY, |surface| light_limit_m(ray, surface));
        let mut radiance = Spectrum::ZERO;
        for emitted in self.scene.lights().iter().filter_map(|light| light.hit_radiance(ray, limit_m, from)) {
            radiance += emitted;
        }
        radiance
    }

    #[inline]
    fn vertex<'v>(&mut self, surface: &'v SurfaceInteraction, sampler: &mut Sampler) -> Vertex<'v, 'a>
    where
        'a: 'v,
    {
        let (scene, field) = (self.scene, self.field.and_then(|all| all.of_object(surface.object)));
        let mut normal = surface.normal;
        let mut directions = Directions::Cosine(surface.surface_point());
        let shading = match (&scene.materials()[surface.material], field, &self.pcasnow) {
            (Material::Diffuse(Diffuse::Uniform(reflectance)), ..) => Shading::Diffuse(reflectance),
            (Material::Diffuse(diffuse), ..) => Shading::Textured(diffuse.reflectance(scene.objects(), surface)),
            (Material::Ground(ground), ..) => {
                directions = ground.surface().directions(surface.surface_point(), surface.direction);
                Shading::Ground(ground)
            }
            (Material::Snow(_), Some(field), _) => {
                let snow = field.at(scene.objects(), surface, sampler);
                normal = surface.shading_normal;
                directions = snow
                    .optics
                    .surface()
                    .directions(SurfacePoint { normal, ..surface.surface_point() }, surface.direction);
                Shading::Field(snow)
            }
            (Material::Snow(_), None, Some(pcasnow)) => Shading::Snow(pcasnow.vertex(surface, &mut self.queries)),
            (Material::Snow(_), None, None) => unreachable!("all snow has a light field or curves"),
        };
        Vertex { surface, normal, directions, shading }
    }

    /// Light from the lights that leaves a surface: transmitted by snow and reflected.
    #[inline]
    fn direct_light(
        &mut self,
        vertex: &Vertex,
        sparkling: Option<&SparklingPoint>,
        sampler: &mut Sampler,
    ) -> DirectLight {
        let transmitted = match &vertex.shading {
            Shading::Snow(snow) => snow.transmitted(&self.lights, &mut self.queries, sampler),
            Shading::Field(_) | Shading::Ground(_) | Shading::Diffuse(_) | Shading::Textured(_) => Spectrum::ZERO,
        };
        let mut light = DirectLight { steady: transmitted, of_sky: Spectrum::ZERO, sparkle: Spectrum::ZERO };
        let directions = vertex.directions;
        for index in 0..self.scene.lights().len() {
            let sample = match self.lights.delta_sample(index) {
                Some(sample) => Some(*sample),
                None => self.scene.lights()[index].sample_for_reflection(&directions, sampler),
            };
            if let Some(sample) = sample
                && let Some(incident) = self.visible(vertex, &sample)
            {
                let source = &self.scene.lights()[index];
                let part = if source.is_smooth_sky() { &mut light.of_sky } else { &mut light.steady };
                *part += reflected(vertex, source, &sample, &incident);
                if let Some(sparkling) = sparkling
                    && let Some(change) = self.sparkle_change(sparkling, vertex, (source, &sample), &incident)
                {
                    light.sparkle += change;
                }
            }
        }
        light
    }

    /// A light sample as it arrives at a surface, unless it is occluded.
    #[inline]
    fn visible(&mut self, vertex: &Vertex, sample: &LightSample) -> Option<IncidentLight> {
        let incident = sample.incident_at(&vertex.shading_point())?;
        let surface = vertex.surface.surface_point();
        sample.is_visible(&mut self.queries, &surface, Side::Outer(vertex.surface.object)).then_some(incident)
    }
}

/// Reflected light of one light sample that arrives at a surface, L = R E / π.
#[inline]
fn reflected(vertex: &Vertex, light: &Light, sample: &LightSample, incident: &IncidentLight) -> Spectrum {
    let factor = incident.irradiance_per_power * FRAC_1_PI;
    vertex.reflectance(incident.direction) * light.power(&sample.origin) * factor
}
