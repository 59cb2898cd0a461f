//! The light in all bodies of a scene, by lights of each spectrum.

use snowblue_field::SolveOptions;

use super::body_field::LitFluence;
use super::exchange::{Balance, Exchange, JoinedPatches};
use super::field_scene::FieldScene;
use super::gather::{GatheredPaths, LightsAround, SnowPlace, Surroundings};
use super::illumination::Illumination;
use super::prepared_body::{Lighting, PreparedBody};
use super::surface_light::NOISE;
use snowblue_scene::objects::SurfaceInteraction;
use snowblue_scene::spectrum::Spectrum;

/// Most diffuse surfaces between two pieces of snow.
const MOST_GATHER_SURFACES: u32 = 8;

/// Solves for the light of each of some illuminations in all bodies.
pub(super) fn solve(
    scene: &FieldScene,
    illuminations: &[&Illumination],
    prepared: &[PreparedBody],
    body_of: &[Option<usize>],
) -> Vec<Vec<LitFluence>> {
    if illuminations.is_empty() {
        return Vec::new();
    }
    let patches = JoinedPatches::new(prepared);
    let paths = gathered_paths(scene, illuminations, (prepared, &patches), body_of);
    let exchange = paths.iter().any(GatheredPaths::reach_snow).then(|| Exchange::new(prepared, &patches, &paths));
    let solve = |(number, illumination): (usize, &&Illumination)| {
        let lightings: Vec<Lighting> = prepared.iter().map(|body| body.lighting(illumination, body_of)).collect();
        let steady = paths.iter().map(|paths| paths.steady(number).clone()).collect();
        let balance = match &exchange {
            Some(exchange) => exchange.balance(&lightings, steady, scene),
            None => Balance { diffuse: steady, fluences: Vec::new() },
        };
        let spectrum = illumination.spectrum.unwrap_or_else(|| mean_spectrum(&lightings));
        let is_of_sky = illumination.lights.iter().all(|light| light.is_smooth_sky());
        let Balance { diffuse, fluences } = balance;
        let bodies = prepared.iter().zip(&lightings).zip(diffuse).enumerate();
        let lit = bodies.map(|(number, ((prepared, lighting), mut diffuse))| {
            prepared.body.denoise(&mut diffuse, NOISE);
            let options = SolveOptions { start: fluences.get(number), ..SolveOptions::default() };
            let solution = prepared.solve(lighting, &diffuse, options);
            let sky = is_of_sky.then_some(&lighting.entering.irradiance);
            prepared.lit(solution, &diffuse, sky, spectrum)
        });
        lit.collect()
    };
    illuminations.iter().enumerate().map(solve).collect()
}

/// What the surface of each body sees besides lamps.
fn gathered_paths(
    scene: &FieldScene,
    illuminations: &[&Illumination],
    (prepared, patches): (&[PreparedBody], &JoinedPatches),
    body_of: &[Option<usize>],
) -> Vec<GatheredPaths> {
    let place_at = |hit: &SurfaceInteraction| {
        let number = body_of[hit.object]?;
        let surface = hit.surface_point();
        let (point, normal) = (surface.point.as_dvec3(), surface.normal.as_dvec3());
        let body = &prepared[number].body;
        let place = body.surface_place(point, normal)?;
        Some(SnowPlace { body: u32::try_from(number).ok()?, place, patch: patches.at(number, body, &place) })
    };
    let lit = illuminations.iter().map(|illumination| {
        let mut sky = Spectrum::ZERO;
        let skies = illumination.lights.iter().filter(|light| light.is_diffuse());
        skies.filter_map(|light| light.uniform_power()).for_each(|radiance| sky += *radiance);
        LightsAround { lights: &illumination.lights, sky }
    });
    let around = Surroundings {
        lit: lit.collect(),
        reflectance: scene.reflectance,
        most_surfaces: scene.max_bounces.min(MOST_GATHER_SURFACES),
        place_at: &place_at,
    };
    prepared.iter().map(|body| GatheredPaths::new(&body.solid, &body.body, &body.nodes, &around)).collect()
}

/// The spectrum of the light on all bodies; white if there is none.
fn mean_spectrum(lightings: &[Lighting]) -> Spectrum {
    let mut sum = Spectrum::ZERO;
    lightings.iter().for_each(|lighting| sum += lighting.entering.spectrum);
    if sum.maximum() > 0.0 { sum } else { Spectrum::ONE }
}
