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
//! by its functions, and with `hybrid` also by a random walk ([`hybrid`](super::hybrid)); later ones by their
//! mean radiance.
//!
//! Lights with extent are found by sampling them and by the path's next ray, weighted by multiple importance sampling
//! (see [`light`](snowblue_scene::light)).
//!
//! The throughput of a path is 1 until its first surface. Light there may be carried as the sensor's response instead
//! of a spectrum, which is much faster to look up ([`carried`]). Light at later surfaces is a spectrum.

pub(super) mod carried;
pub(super) mod vertex;

use std::f32::consts::FRAC_1_PI;

use glam::Vec3A;
use snowblue_geometry::ray::{Ray, SurfacePoint};
use snowblue_light_field::{LightField, SnowAt};
use snowblue_scene::Scene;
use snowblue_scene::directions::Directions;
use snowblue_scene::film::sensor::SensorSample;
use snowblue_scene::light::{IncidentLight, Light, LightSample};
use snowblue_scene::material::Material;
use snowblue_scene::material::diffuse::Diffuse;
use snowblue_scene::objects::{Side, SurfaceInteraction};
use snowblue_scene::queries::{SceneQueries, Statistics};
use snowblue_scene::sampling::Sampler;
use snowblue_scene::spectrum::Spectrum;

use crate::integrators::first_hit::light_limit_m;
use crate::integrators::hybrid::WalkTracer;
use crate::integrators::path::carried::{Carried, LightTables, Source};
use crate::integrators::path::vertex::{OpenSky, Shading, Vertex};
use crate::integrators::path_sample::survival_probability;
use crate::integrators::prepared::{Method, Prepared};
use crate::integrators::single_scattering::SingleScattering;
use crate::integrators::snow_vertex::PcaSnow;
use crate::integrators::sparkle::{SparkleReader, SparklingPoint};
use crate::integrators::{FilteredSample, PathSample};

/// Traces paths through a scene.
#[derive(Debug)]
pub(crate) struct PathTracer<'a> {
    scene: &'a Scene,
    tables: &'a LightTables,
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
struct PathRadiance<C> {
    /// Light that leaves the first surface, or a light before it.
    first: C,
    /// Whether the first surface is snow.
    sees_snow: bool,
    /// Distance to the first surface, in m; none if there is none.
    distance_m: Option<f32>,
    /// Light that comes by further surfaces, if the path has any.
    later: Option<Spectrum>,
    /// What the filter compares, if the first surface is filtered.
    filtered: Option<Compared<C>>,
}

/// What the filter compares: light that leaves a surface, but for its sparkle, and an estimate of it.
struct Compared<C> {
    /// All of it but what comes by further surfaces.
    found: C,
    /// An estimate of all of it that has little noise.
    reading: C,
    is_snow: bool,
    normal: Vec3A,
}

/// Light of snow with a light field.
struct SnowLight<C> {
    /// All but the sparkle.
    radiance: C,
    /// The radiance by the light field alone, for the filter.
    reading: Option<C>,
    /// What single facets add to it, or take away.
    sparkle: C,
}

/// Light that leaves a surface by lamps and skies, and of snow by its light field.
struct DirectLight<C> {
    /// By the field and by all lights but smooth skies.
    steady: C,
    /// By samples of smooth skies, unless they are left out.
    of_sky: C,
    /// What single facets add to it, or take away.
    sparkle: C,
}

impl<C: Carried> DirectLight<C> {
    /// All but the sparkle.
    fn smooth(&self) -> C {
        let mut light = self.steady;
        light += self.of_sky;
        light
    }
}

impl<C: Carried> PathRadiance<C> {
    /// The sample of the path.
    #[inline]
    fn sample(self, carried: impl Fn(Spectrum) -> C) -> PathSample<C> {
        let Self { first: mut radiance, sees_snow, distance_m, later, filtered } = self;
        let later = later.map(carried);
        if let Some(later) = later {
            radiance += later;
        }
        let filtered = filtered.zip(distance_m).map(|(compared, distance_m)| {
            let Compared { mut found, reading, is_snow, normal } = compared;
            if let Some(later) = later {
                found += later;
            }
            FilteredSample { residual: found.less(reading), reading, is_snow, normal, distance_m }
        });
        PathSample { radiance, sees_snow, distance_m, filtered }
    }
}

impl<'a> PathTracer<'a> {
    /// Starts with zero counts. The sensor's responses are looked up where `responses` is true.
    pub(in crate::integrators) fn new(prepared: &'a Prepared, responses: bool) -> Self {
        let Prepared { scene, method, bodies, .. } = prepared;
        let (pcasnow, field, volumes) = match method {
            Method::PcaSnow(curves) => (Some(PcaSnow::new(&scene.integrator().pcasnow, curves)), None, None),
            Method::Diffusion(field) => (None, Some(field), None),
            Method::Hybrid(field, volumes) => (None, Some(field), Some(volumes)),
            Method::Reference(..) => unreachable!("the reference traces no paths over surfaces"),
        };
        Self {
            scene,
            tables: if responses { &prepared.tables } else { &prepared.no_tables },
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
        self.trace::<Spectrum>(camera_ray, sampler).sample(|light| light)
    }

    /// The sensor's response to one sample of the radiance along a camera ray.
    #[inline]
    pub(crate) fn response(&mut self, camera_ray: &Ray, sampler: &mut Sampler) -> PathSample<SensorSample> {
        let sensor = self.scene.sensor();
        self.trace::<SensorSample>(camera_ray, sampler).sample(|light| sensor.sample(&light))
    }

    #[inline]
    fn trace<C: Carried>(&mut self, camera_ray: &Ray, sampler: &mut Sampler) -> PathRadiance<C> {
        let hit = self.queries.camera_hit(camera_ray);
        let mut first = C::ZERO;
        if self.has_area_lights {
            first += C::emitted(self.scene, &self.hit_lights(camera_ray, hit.as_ref(), None));
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
        let direct = self.direct_light::<C>(&vertex, sparkling.as_ref(), sampler);
        let light = direct.smooth();
        first += light;
        first += direct.sparkle;
        let filtered = self.is_filtered.then(|| {
            let mut reading = direct.steady;
            reading += self.unhidden_light(&vertex);
            Compared { found: light, reading, is_snow: false, normal: vertex.normal }
        });
        let has_later = self.scene.integrator().max_bounces.get() > 0 || self.has_area_lights;
        let later = has_later.then(|| self.indirect_light(&vertex, sampler));
        PathRadiance { first, sees_snow, distance_m, later, filtered }
    }

    /// The light of the smooth skies and of the snow around that a surface reflects, roughly: as if nothing hid the
    /// snow, and nothing else the skies.
    fn unhidden_light<C: Carried>(&self, vertex: &Vertex) -> C {
        let mut light = self.sky.reflected(vertex);
        if let Some(field) = self.field {
            let snow = field.snow_seen_from(&vertex.shading_point());
            light = light * (1.0 - snow.share);
            light += vertex.reflectance(vertex.normal) * snow.irradiance * FRAC_1_PI;
        }
        C::emitted(self.scene, &light)
    }

    /// Light from snow, by the light field at the surface or by a random walk, and its sparkle.
    fn snow_light<C: Carried>(
        &mut self,
        snow: SnowAt,
        vertex: &Vertex,
        camera_ray: &Ray,
        sampler: &mut Sampler,
    ) -> SnowLight<C> {
        let sparkling = self
            .sparkle
            .as_ref()
            .and_then(|sparkle| sparkle.at((vertex.surface, snow.kind, vertex.normal), camera_ray));
        let direct = if self.walks.is_none() || self.is_filtered {
            self.field_light::<C>(snow, vertex, (camera_ray, sparkling.as_ref()), sampler)
        } else {
            let sparkle = sparkling.map_or(C::ZERO, |sparkling| self.sparkle_light(&sparkling, vertex, sampler));
            DirectLight { steady: C::ZERO, of_sky: C::ZERO, sparkle }
        };
        let reading = self.is_filtered.then(|| {
            let mut reading = direct.steady;
            let of_sky = snow.field.sky_irradiance(&vertex.shading_point()) * FRAC_1_PI;
            reading += C::emitted(self.scene, &of_sky);
            // The residual is what is found beside the reading, whatever that is. A negative reading counts as none.
            if reading.luminance(self.tables) > 0.0 { reading } else { C::ZERO }
        });
        let radiance = match &mut self.walks {
            Some(walks) => C::emitted(self.scene, &walks.walk(snow, vertex.surface, camera_ray, sampler)),
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
    fn sparkle_light<C: Carried>(&mut self, sparkling: &SparklingPoint, vertex: &Vertex, sampler: &mut Sampler) -> C {
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
        C::emitted(self.scene, &sparkle)
    }

    /// Samples of a light as seen from a surface, which count together; none of a diffuse light.
    fn samples_of_light(
        &self,
        light: usize,
        directions: &Directions,
        sampler: &mut Sampler,
    ) -> [Option<LightSample>; 2] {
        let source = &self.scene.lights()[light];
        match self.tables.delta_sample(light) {
            Some(sample) => [Some(*sample), None],
            None if source.is_diffuse() => [None, None],
            None => source.samples_at(directions, sampler),
        }
    }

    /// Light that comes to a path's first surface from further surfaces and by rays that hit lights, reflected there.
    fn indirect_light(&mut self, first: &Vertex, sampler: &mut Sampler) -> Spectrum {
        let max_bounces = self.scene.integrator().max_bounces.get();
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
            let direct = self.direct_light::<Spectrum>(&vertex, None, sampler).smooth();
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
            Some(field) if bounce < self.scene.integrator().max_bounces.get() => {
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
    fn field_light<C: Carried>(
        &mut self,
        snow: SnowAt,
        vertex: &Vertex,
        (camera_ray, sparkling): (&Ray, Option<&SparklingPoint>),
        sampler: &mut Sampler,
    ) -> DirectLight<C> {
        let (surface, directions) = (vertex.shading_point(), vertex.directions);
        let cos_exit = -surface.normal.dot(vertex.surface.direction);
        // Light that is computed as spectra, and responses: each without the light of smooth skies, and of it alone.
        let mut radiances = [snow.diffuse_radiance(&surface, cos_exit), Spectrum::ZERO];
        let (mut lights, mut sparkle) = ([C::ZERO; 2], Spectrum::ZERO);
        let [number, ..] = sampler.next_four();
        let point = self.singles.as_mut().map(|singles| singles.point(snow, vertex.surface, camera_ray, number));
        for index in 0..self.scene.lights().len() {
            let source = &self.scene.lights()[index];
            let part = usize::from(source.is_smooth_sky());
            if source.is_smooth_sky() && self.walks.is_some() {
                // The walk samples it.
                continue;
            }
            for sample in self.samples_of_light(index, &directions, sampler).into_iter().flatten() {
                let incident = self.visible(vertex, &sample);
                if let Some(incident) = &incident {
                    lights[part] += self.reflected::<C>(vertex, index, &sample, incident);
                    if let Some(sparkling) = sparkling
                        && let Some(change) = self.sparkle_change(sparkling, vertex, (source, &sample), incident)
                    {
                        sparkle += change;
                    }
                }
                if let (Some(singles), Some(point)) = (&mut self.singles, &point) {
                    // The half-space that the ray enters is that of the geometric normal.
                    let on_plane = incident.and_then(|_| sample.incident_at(&vertex.surface.surface_point()));
                    let factor = singles.correction(point, &sample, on_plane.as_ref());
                    radiances[part] += source.power(&sample.origin) * factor;
                }
            }
        }
        let [steady, of_sky] = [0, 1].map(|part| {
            let mut light = lights[part];
            light += C::emitted(self.scene, &radiances[part]);
            light
        });
        let sparkle = if sparkling.is_some() { C::emitted(self.scene, &sparkle) } else { C::ZERO };
        DirectLight { steady, of_sky, sparkle }
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
    fn direct_light<C: Carried>(
        &mut self,
        vertex: &Vertex,
        sparkling: Option<&SparklingPoint>,
        sampler: &mut Sampler,
    ) -> DirectLight<C> {
        let transmitted = match &vertex.shading {
            Shading::Snow(snow) => snow.transmitted(self.scene, self.tables, &mut self.queries, sampler),
            Shading::Field(_) | Shading::Ground(_) | Shading::Diffuse(_) | Shading::Textured(_) => C::ZERO,
        };
        let mut light = DirectLight { steady: transmitted, of_sky: C::ZERO, sparkle: C::ZERO };
        let directions = vertex.directions;
        for index in 0..self.scene.lights().len() {
            let sample = match self.tables.delta_sample(index) {
                Some(sample) => Some(*sample),
                None => self.scene.lights()[index].sample_for_reflection(&directions, sampler),
            };
            if let Some(sample) = sample
                && let Some(incident) = self.visible(vertex, &sample)
            {
                let source = &self.scene.lights()[index];
                let part = if source.is_smooth_sky() { &mut light.of_sky } else { &mut light.steady };
                *part += self.reflected::<C>(vertex, index, &sample, &incident);
                if let Some(sparkling) = sparkling
                    && let Some(change) = self.sparkle_change(sparkling, vertex, (source, &sample), &incident)
                {
                    light.sparkle += C::emitted(self.scene, &change);
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

    /// Reflected light of one light sample that arrives at a surface, L = R E / π.
    #[inline]
    fn reflected<C: Carried>(
        &self,
        vertex: &Vertex,
        light: usize,
        sample: &LightSample,
        incident: &IncidentLight,
    ) -> C {
        let source = Source::new(self.scene, self.tables, light, sample);
        C::reflected(&source, vertex, incident) * (incident.irradiance_per_power * FRAC_1_PI)
    }
}
