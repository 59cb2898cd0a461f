//! Path tracer over surfaces.
//!
//! L = Σ_k β_k L_lit(x_k), β_{k+1} = β_k ρ(x_k) cos θ / (π p) (Kajiya 1986, "The rendering equation",
//! doi:10.1145/15922.15902; notation of Pharr, Jakob & Humphreys 2023, chapter 13). The density p of the next
//! direction is cos θ / π at a diffuse surface, so that only its reflectance ρ remains, and approximately the density
//! of the reflected light at snow. Long paths end by Russian roulette.
//!
//! The method shades snow ([`SnowShader`]). A path continues from snow by PCASnow as from any surface. From snow with a
//! light field it continues if the snow is its first surface: the ray corrects the irradiance of the field, which is a
//! mean over cells. A path ends at later snow with a light field, which contains the light of further surfaces.
//!
//! Lights with extent are found by sampling them and by the path's next ray, weighted by multiple importance sampling
//! (see [`light`](snowblue_scene::light)).
//!
//! The throughput of a path is 1 until its first surface. Light there may be carried as the sensor's response instead
//! of a spectrum, which is much faster to look up ([`light_tables`](super::light_tables)). Light at later surfaces is a
//! spectrum.

use std::f32::consts::FRAC_1_PI;
use std::sync::Arc;

use snowblue_geometry::ray::Ray;
use snowblue_scene::Scene;
use snowblue_scene::directions::Directions;
use snowblue_scene::film::sensor::SensorSample;
use snowblue_scene::light::{IncidentLight, Light, LightSample};
use snowblue_scene::objects::{Side, SurfaceInteraction};
use snowblue_scene::queries::{SceneQueries, Statistics};
use snowblue_scene::sampling::Sampler;
use snowblue_scene::spectrum::Spectrum;
use snowblue_scene::transparency::Segment;

use crate::integrators::camera_terms::CameraTerms;
use crate::integrators::first_hit::light_limit_m;
use crate::integrators::light_tables::{Carried, LightTables, Source};
use crate::integrators::method::Prepared;
use crate::integrators::sample::{FilteredSample, PathSample, survival_probability};
use crate::integrators::snow_shader::SnowShader;
use crate::integrators::surface::{OpenSky, Shading, Surface};

/// Traces paths through a scene.
#[derive(Debug)]
pub(super) struct PathTracer<'a> {
    scene: &'a Scene,
    tables: &'a LightTables,
    queries: SceneQueries<'a>,
    snow: SnowShader<'a>,
    /// Whether paths can hit lights.
    has_area_lights: bool,
    /// Smooth skies that nothing hides, if the picture is filtered.
    open_sky: Option<&'a OpenSky>,
}

/// Light of lamps and skies that leaves a surface.
struct DirectLight<C> {
    /// Light of all lights except smooth skies, and the light from inside of snow.
    steady: C,
    /// Light of samples of smooth skies.
    smooth_sky: C,
    /// Change of the light by single facets of snow, positive or negative.
    sparkle: C,
}

impl<'a> PathTracer<'a> {
    /// Starts with zero counts. The sensor's responses are looked up where `responses` is true.
    pub(super) fn new(prepared: &'a Prepared, snow: SnowShader<'a>, responses: bool) -> Self {
        let Prepared { scene, .. } = prepared;
        Self {
            scene,
            tables: if responses { &prepared.tables } else { &prepared.no_tables },
            queries: SceneQueries::new(scene.objects(), scene.materials()),
            snow,
            has_area_lights: scene.lights().iter().any(|light| light.has_extent()),
            open_sky: prepared.open_sky.as_ref(),
        }
    }

    /// Counts of the queries so far.
    pub(super) fn statistics(&self) -> Statistics {
        self.queries.statistics.plus(self.snow.statistics())
    }

    /// One sample of the radiance along a camera ray, in W m⁻² sr⁻¹ as a band density.
    pub(super) fn radiance(&mut self, camera_ray: &Ray, sampler: &mut Sampler) -> PathSample<Spectrum> {
        self.trace(camera_ray, sampler)
    }

    /// The sensor's response to one sample of the radiance along a camera ray.
    #[inline]
    pub(super) fn response(&mut self, camera_ray: &Ray, sampler: &mut Sampler) -> PathSample<SensorSample> {
        self.trace(camera_ray, sampler)
    }

    #[inline]
    fn trace<C: Carried>(&mut self, camera_ray: &Ray, sampler: &mut Sampler) -> PathSample<C> {
        let mut camera_ray = *camera_ray;
        let (hit, lamps) = self.next_surface(&mut camera_ray, None, sampler);
        let camera_ray = &camera_ray;
        let mut radiance = C::ZERO;
        if self.has_area_lights {
            radiance += C::emitted(self.scene, &lamps);
        }
        let Some(hit) = hit else {
            return PathSample { radiance, sees_snow: false, distance_m: None, filtered: None };
        };
        let surface = self.surface(&hit, sampler);
        let terms = self.snow.camera_terms(&surface, camera_ray, sampler);
        let direct = self.direct_light::<C>(&surface, &terms, sampler);
        let mut light = direct.steady;
        light += direct.smooth_sky;
        if let Some(walked) = self.snow.walk(&surface, camera_ray, sampler) {
            light = C::emitted(self.scene, &walked);
        }
        let later = self.later_light(&surface, &terms, sampler);
        let later = later.map(|later| C::emitted(self.scene, &later));
        // Single facets are sharp in the picture, so the residual leaves sparkle out and the filter does not spread
        // it.
        radiance += light;
        radiance += direct.sparkle;
        later.into_iter().for_each(|later| radiance += later);
        let distance_m = hit.point.distance(camera_ray.origin);
        let filtered = self.open_sky.map(|open_sky| {
            let mut baseline = direct.steady;
            baseline += C::emitted(self.scene, &self.snow.smooth_sky(&surface, &terms, open_sky));
            let is_snow = surface.has_field();
            // The residual is the sample less the baseline, so any baseline is valid. A negative baseline counts as
            // 0.
            if is_snow && baseline.luminance(self.tables) <= 0.0 {
                baseline = C::ZERO;
            }
            later.into_iter().for_each(|later| light += later);
            let residual = light.less(baseline);
            FilteredSample { residual, baseline, is_snow, normal: surface.normal, distance_m }
        });
        let sees_snow = self.scene.materials()[hit.material].looks_like_snow();
        PathSample { radiance, sees_snow, distance_m: Some(distance_m), filtered }
    }

    /// Light that comes to a path's first surface from further surfaces and by rays that hit lights, reflected there.
    /// At snow with a light field, it is the difference of this light from the light of the field's irradiance, which
    /// the other terms contain.
    fn later_light(&mut self, first: &Surface, terms: &CameraTerms, sampler: &mut Sampler) -> Option<Spectrum> {
        let max_bounces = self.scene.integrator().max_bounces.get();
        if max_bounces == 0 && (first.has_field() || !self.has_area_lights) {
            return None;
        }
        let (mut radiance, mut throughput) = (Spectrum::ZERO, Spectrum::ONE);
        let (mut next, mut from) = (self.bounce(first, 0, &mut throughput, sampler), first.directions);
        if let Shading::Field(snow) = &first.shading {
            let from_inside = terms.from_inside.as_ref();
            let diffuse = from_inside.map_or_else(
                || snow.field.diffuse_irradiance(&first.shading_point()),
                |from_inside| from_inside.diffuse_irradiance,
            );
            // The mean throughput of directions is 1, for R₀ belongs to snow that does not absorb.
            radiance.add_product(-FRAC_1_PI, &throughput, &diffuse);
        }
        // Samples of lights at snow with a field are complete. Only rays find uniform skies.
        let mut finds_lamps = !first.has_field();
        for bounce in 1.. {
            let Some(mut ray) = next else { break };
            let (hit, lamps) = self.next_surface(&mut ray, Some((&from, finds_lamps)), sampler);
            radiance.add_product(1.0, &throughput, &lamps);
            let Some(hit) = hit.filter(|_| bounce <= max_bounces) else { break };
            let surface = self.surface(&hit, sampler);
            let DirectLight { mut steady, smooth_sky, .. } =
                self.direct_light::<Spectrum>(&surface, &SnowShader::later_terms(&surface), sampler);
            steady += smooth_sky;
            radiance.add_product(1.0, &throughput, &steady);
            // The last ray only finds lights. The light of snow with a field includes further surfaces.
            let goes_on = !surface.has_field() && (bounce < max_bounces || self.has_area_lights);
            next = if goes_on { self.bounce(&surface, bounce, &mut throughput, sampler) } else { None };
            (from, finds_lamps) = (surface.directions, true);
        }
        Some(radiance)
    }

    /// Samples the next ray of a path at a surface and updates its throughput; none if the path ends.
    fn bounce(&self, surface: &Surface, bounce: u32, throughput: &mut Spectrum, sampler: &mut Sampler) -> Option<Ray> {
        let [u, v, chance, choice] = sampler.next_four();
        let finds_surfaces = bounce < self.scene.integrator().max_bounces.get();
        let (direction, factor) = self.snow.sample_direction(&surface.directions, [u, v, choice], finds_surfaces);
        *throughput *= surface.reflectance(direction) * factor;
        let survival = survival_probability(bounce, throughput);
        if chance >= survival || throughput.maximum() <= 0.0 {
            return None;
        }
        *throughput = *throughput * survival.recip();
        Some(Ray::new(self.queries.off_surface(surface.hit.object, &surface.hit.surface_point()), direction))
    }

    /// The surface where a ray ends, and the radiance from the lights that it hits before. The ray starts at the
    /// camera, or at a surface with the density of `from`, where it finds all lights or only uniform skies.
    #[inline]
    fn next_surface(
        &mut self,
        ray: &mut Ray,
        from: Option<(&Directions, bool)>,
        sampler: &mut Sampler,
    ) -> (Option<SurfaceInteraction>, Spectrum) {
        let Self { scene, queries, has_area_lights, .. } = self;
        let mut radiance = Spectrum::ZERO;
        let visit = |segment: &Segment| {
            if *has_area_lights {
                radiance += hit_lights(scene, segment, from);
            }
        };
        let number = || sampler.next_four()[0];
        let Statistics { camera_rays, indirect_rays, .. } = &mut queries.statistics;
        *(if from.is_none() { camera_rays } else { indirect_rays }) += 1;
        let hit = queries.hit(ray, number, visit);
        (hit, radiance)
    }

    #[inline]
    fn surface<'v>(&mut self, hit: &'v SurfaceInteraction, sampler: &mut Sampler) -> Surface<'v, 'a>
    where
        'a: 'v,
    {
        let Self { scene, snow, queries, .. } = self;
        Surface::new(scene, hit, || snow.at(hit, queries, sampler))
    }

    /// Light of lamps and skies that leaves a surface: reflected light, with the terms of snow for the camera, and
    /// light transmitted through snow.
    #[inline]
    fn direct_light<C: Carried>(
        &mut self,
        surface: &Surface,
        terms: &CameraTerms,
        sampler: &mut Sampler,
    ) -> DirectLight<C> {
        let (scene, tables) = (self.scene, self.tables);
        let transmitted = SnowShader::transmitted(surface, scene, tables, &mut self.queries, sampler);
        let mut light = DirectLight { steady: transmitted, smooth_sky: C::ZERO, sparkle: C::ZERO };
        let mut sparkle = terms.sparkling.as_ref().map(|_| Spectrum::ZERO);
        let mut spectra = terms.from_inside.as_ref().map(|from_inside| [from_inside.radiance, Spectrum::ZERO]);
        for (index, source) in scene.lights().iter().enumerate().filter(|(_, light)| terms.count(light)) {
            let mut add = |sample: &LightSample| {
                let incident = self.visible(surface, sample);
                if let Some(incident) = &incident {
                    if terms.has_reflection {
                        let reflected = C::reflected(&Source::new(scene, tables, index, sample), surface, incident);
                        let sum = if source.is_smooth_sky() { &mut light.smooth_sky } else { &mut light.steady };
                        *sum += reflected * (incident.irradiance_per_power * FRAC_1_PI);
                    }
                    if let Some(sparkle) = &mut sparkle
                        && let Some(change) = self.snow.sparkle(terms, surface, (source, sample), incident)
                    {
                        *sparkle += change;
                    }
                }
                if let Some(spectra) = &mut spectra {
                    let spectrum = &mut spectra[usize::from(source.is_smooth_sky())];
                    let entering = incident.as_ref();
                    let entering =
                        entering.and_then(|incident| terms.change_from_inside(surface, (source, sample), incident));
                    let scattered = self.snow.single_scattering(terms, surface, (source, sample), incident);
                    entering.into_iter().chain(scattered).for_each(|change| *spectrum += change);
                }
            };
            match tables.delta_sample(index) {
                Some(sample) => add(sample),
                None => surface.samples_of(source, sampler).iter().flatten().for_each(add),
            }
        }
        if let Some(sparkle) = &sparkle {
            light.sparkle = C::emitted(scene, sparkle);
        }
        if let Some([steady, smooth_sky]) = &spectra {
            light.steady += C::emitted(scene, steady);
            light.smooth_sky += C::emitted(scene, smooth_sky);
        }
        light
    }

    /// The incident light of a light sample at a surface; none if the sample is occluded.
    #[inline]
    fn visible(&mut self, surface: &Surface, sample: &LightSample) -> Option<IncidentLight> {
        let mut incident = sample.incident_at(&surface.shading_point())?;
        let (point, side) = (surface.hit.surface_point(), Side::Outer(surface.hit.object));
        incident.irradiance_per_power *= sample.transmittance(&mut self.queries, &point, side);
        (incident.irradiance_per_power > 0.0).then_some(incident)
    }
}

/// Radiance from the lights that a segment of a ray hits. Light samples do not find a light in the mirror of a pane.
/// Without them, the sun there would be noise, so that only the camera sees it.
fn hit_lights(
    scene: &Scene,
    Segment { ray, hit, is_mirrored }: &Segment,
    from: Option<(&Directions, bool)>,
) -> Spectrum {
    let limit_m = hit.as_ref().map_or(f32::INFINITY, |hit| light_limit_m(ray, hit));
    let of_light = |light: &Arc<Light>| match from {
        Some((_, false)) if !light.is_diffuse() => None,
        from if !is_mirrored => light.hit_radiance(ray, limit_m, from.map(|(directions, _)| directions)),
        Some(_) if light.is_small() => None,
        _ => light.full_hit_radiance(ray, limit_m).map(|hit| hit.radiance),
    };
    let mut radiance = Spectrum::ZERO;
    scene.lights().iter().filter_map(of_light).for_each(|emitted| radiance += emitted);
    radiance
}
