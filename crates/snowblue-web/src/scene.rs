//! Light fields, pictures and files of scenes, for workers.

use snowblue_base::narrow;
use std::collections::BTreeMap;
use std::sync::Arc;

use glam::Vec3A;
use js_sys::Date;
use serde_json::json;
use snowblue_color::{LinearRgb, Srgb8, ToneCurve};
use snowblue_geometry::ray::Ray;
use snowblue_render::bake::{BakeOptions, BakedObject, LitSnow, LitSurface, Relighting, WeightedLight, glb_bytes};
use snowblue_render::files::FilesInMemory;
use snowblue_render::film::image_file::to_raster;
use snowblue_render::render::{RenderControl, accumulator, all_samples, render_missing};
use snowblue_render::scene::light::Light;
use snowblue_render::scene::spectrum::wavelengths_nm;
use snowblue_render::scene::{IntegratorKind, Views};
use snowblue_render::{Aovs, FilmAccumulator, Integrator, Preparation, SceneDescription};
use wasm_bindgen::prelude::*;

use crate::text;

/// Files that scenes name: OBJ meshes, and the coefficients of the clear sky.
#[wasm_bindgen]
#[derive(Debug, Default)]
pub struct Files(FilesInMemory);

/// The light of lamps, the sun and a sky in all snow of a scene. Each light is solved for separately.
#[wasm_bindgen]
#[derive(Debug)]
pub struct LightField {
    snow: Relighting,
    /// The lights of the last sky, and its JSON.
    sky: (String, Vec<Arc<Light>>),
    /// The snow under each light, by the place of the light.
    solved: BTreeMap<usize, LitSnow>,
    /// The place of the last light.
    last: usize,
}

/// A picture of a scene that gets better with each sample.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Picture {
    integrator: Integrator,
    sums: FilmAccumulator,
}

#[wasm_bindgen]
impl Files {
    /// No file.
    #[wasm_bindgen(constructor)]
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a file by its content.
    pub fn add(&mut self, name: &str, content: &[u8]) {
        self.0.insert(name, content);
    }
}

/// The integrator of a scene for pictures from some views, or for a bake.
fn prepare(description: &SceneDescription, files: &Files, views: Option<Views>) -> Result<Integrator, String> {
    let scene = description.build(&files.0).map_err(text)?;
    Integrator::prepare_with(&scene, Preparation { views, ..Preparation::default() }).map_err(text)
}

/// The light field on the snow of a scene, JSON with the keys of a scene file: the GLB of `snowblue bake`.
///
/// # Errors
///
/// With the error message of the command.
#[wasm_bindgen]
pub fn bake_glb(scene: &str, files: &Files) -> Result<Vec<u8>, JsError> {
    baked(scene, files).map_err(|reason| JsError::new(&reason))
}

fn baked(scene: &str, files: &Files) -> Result<Vec<u8>, String> {
    let mut description: SceneDescription = serde_json::from_str(scene).map_err(text)?;
    description.integrator.kind = IntegratorKind::Diffusion;
    let integrator = prepare(&description, files, None)?;
    let baked = integrator.bake(BakeOptions::default(), &|_| {}).map_err(text)?;
    glb_bytes(&baked, &integrator.provenance()).map_err(text)
}

#[wasm_bindgen]
impl LightField {
    /// Prepares the snow of a scene: JSON with the keys of a scene file. Fewer rays through grains than by default are
    /// faster. Vertices lie at most `cells_per_edge` cells apart, by default two.
    ///
    /// # Errors
    ///
    /// With the error message of the command.
    #[wasm_bindgen(constructor)]
    pub fn new(
        scene: &str,
        files: &Files,
        grain_rays: Option<u32>,
        cells_per_edge: Option<f64>,
    ) -> Result<Self, JsError> {
        Self::prepared(scene, files, grain_rays, cells_per_edge).map_err(|reason| JsError::new(&reason))
    }

    fn prepared(
        scene: &str,
        files: &Files,
        grain_rays: Option<u32>,
        cells_per_edge: Option<f64>,
    ) -> Result<Self, String> {
        let mut description: SceneDescription = serde_json::from_str(scene).map_err(text)?;
        description.integrator.kind = IntegratorKind::Diffusion;
        description.light_field.grain_rays = grain_rays.unwrap_or(description.light_field.grain_rays);
        let integrator = prepare(&description, files, None)?;
        let snow = integrator.into_relighting(cells_per_edge).map_err(text)?;
        let sky = (String::new(), Vec::new());
        Ok(Self { snow, sky, solved: BTreeMap::new(), last: 0 })
    }

    /// Unknowns of a solution at each wavelength.
    #[must_use]
    pub fn node_count(&self) -> usize {
        self.snow.node_count()
    }

    /// Number of objects of snow.
    #[must_use]
    pub fn object_count(&self) -> usize {
        self.snow.objects().len()
    }

    /// Three coordinates of each vertex, in m.
    ///
    /// # Errors
    ///
    /// When there is no such object, as for all further functions of an object.
    pub fn positions(&self, object: usize) -> Result<Vec<f32>, JsError> {
        Ok(self.object(object)?.positions.iter().flat_map(|point| point.to_array()).collect())
    }

    /// Outward unit normals of the vertices.
    ///
    /// # Errors
    ///
    /// See [`positions`](Self::positions).
    pub fn normals(&self, object: usize) -> Result<Vec<f32>, JsError> {
        Ok(self.object(object)?.normals.iter().flat_map(|normal| normal.to_array()).collect())
    }

    /// Three vertices of each triangle, counter-clockwise from outside.
    ///
    /// # Errors
    ///
    /// See [`positions`](Self::positions).
    pub fn triangles(&self, object: usize) -> Result<Vec<u32>, JsError> {
        Ok(self.object(object)?.triangles.concat())
    }

    /// Coefficients of the escape function K: of 1, μ, μ² and μ³.
    ///
    /// # Errors
    ///
    /// See [`positions`](Self::positions).
    pub fn escape_polynomial(&self, object: usize) -> Result<Vec<f32>, JsError> {
        Ok(self.object(object)?.snow.escape.coefficients.iter().map(|one| narrow(*one)).collect())
    }

    /// The table of (μ + μ₀) R₀ with n values along each argument.
    ///
    /// # Errors
    ///
    /// See [`positions`](Self::positions).
    pub fn reflection_table(&self, n: u32) -> Result<Vec<f32>, JsError> {
        Ok(self.object(0)?.half_space.reflection_table(n.max(2) - 1))
    }

    /// Solves for a single lamp, JSON of a light of a scene, and keeps the solution at a place.
    ///
    /// # Errors
    ///
    /// With the error message of the command.
    pub fn light(&mut self, place: usize, lamp: &str) -> Result<(), JsError> {
        let lamp = self.lamp(lamp).map_err(|reason| JsError::new(&reason))?;
        self.solve(place, &lamp);
        Ok(())
    }

    /// Solves for one part of a sky, JSON of the table `[sky]` of a scene: either its sun, or the sky without the
    /// sun. Keeps the solution at a place. `files` holds the coefficients of a clear sky.
    ///
    /// # Errors
    ///
    /// With the error message of the command.
    pub fn light_sky(&mut self, place: usize, sky: &str, is_sun: bool, files: &Files) -> Result<(), JsError> {
        let failed = |reason: String| JsError::new(&reason);
        if self.sky.0 != sky {
            self.sky = (sky.to_owned(), self.lights_of_sky(sky, files).map_err(failed)?);
        }
        let lights = std::mem::take(&mut self.sky.1);
        let light = lights.iter().find(|light| light.is_sky() != is_sun);
        let found = light.map(|light| self.solve(place, light));
        self.sky.1 = lights;
        found.ok_or_else(|| failed("an overcast sky has no sun".to_owned()))
    }

    /// The radiance of the last sky without its sun from each of some unit directions, as linear sRGB, in W m⁻² sr⁻¹
    /// as in a picture.
    #[must_use]
    pub fn sky_radiance(&self, directions: &[f32]) -> Vec<f32> {
        let Some(sky) = self.sky.1.iter().find(|light| light.is_sky()) else { return Vec::new() };
        let from = |direction: &[f32]| self.snow.radiance(sky, Vec3A::from_slice(direction));
        colors(&directions.chunks_exact(3).map(from).collect::<Vec<_>>())
    }

    fn solve(&mut self, place: usize, light: &Arc<Light>) {
        self.solved.insert(place, self.snow.light(light));
        self.last = place;
    }

    /// The exposure in stops of a view of the snow from any side, under the lights at the first places with their
    /// strengths multiplied by some factors; none without light.
    #[must_use]
    pub fn exposure_stops(&self, factors: &[f64]) -> Option<f64> {
        self.snow.exposure_factor(&self.weighted(factors)).map(f64::log2)
    }

    fn weighted(&self, factors: &[f64]) -> Vec<WeightedLight<'_>> {
        let weighted =
            |(place, factor): (usize, &f64)| Some(WeightedLight { snow: self.solved.get(&place)?, factor: *factor });
        factors.iter().enumerate().filter_map(weighted).collect()
    }

    /// The light that leaves the snow where a ray meets it, towards the origin of the ray, as JSON; none beside the
    /// snow. `ray` has three coordinates of its origin and three of its direction. `factors` is as in
    /// [`exposure_stops`](Self::exposure_stops), and directions of a sky are as in
    /// [`sky_radiance`](Self::sky_radiance). The colour is the colour in a picture with a tone curve whose light is
    /// multiplied by a factor.
    ///
    /// # Errors
    ///
    /// With the error message of the command, when there is no such tone curve.
    #[expect(clippy::too_many_arguments, reason = "JavaScript passes arrays and numbers one by one")]
    pub fn probe(
        &self,
        ray: &[f32],
        factors: &[f64],
        directions: &[f32],
        exposure: f64,
        tone: &str,
    ) -> Result<Option<String>, JsError> {
        let tone: ToneCurve = tone.parse().map_err(|reason| JsError::new(&text(reason)))?;
        let [x, y, z, across, along, up] = *ray else { return Err(JsError::new("a ray has six numbers")) };
        let (origin, towards) = (Vec3A::new(x, y, z), Vec3A::new(across, along, up));
        let Some(place) = self.snow.place_along(&Ray::new(origin, towards.normalize())) else {
            return Ok(None);
        };
        let directions: Vec<Vec3A> = directions.chunks_exact(3).map(Vec3A::from_slice).collect();
        let radiance = self.snow.radiance_towards(origin, place, &self.weighted(factors), &directions);
        let color = self.snow.color(&radiance);
        let shown = Srgb8::encode(tone.displayed(color * exposure));
        let answer = json!({
            "wavelengths_nm": wavelengths_nm(),
            "radiance": radiance.0,
            "linear_rgb": [color.r, color.g, color.b],
            "srgb": [shown.r, shown.g, shown.b],
        });
        Ok(Some(answer.to_string()))
    }

    /// The net flux J by the last light at each vertex, as linear sRGB, and the visibility V of a lamp or the sun.
    ///
    /// # Errors
    ///
    /// See [`positions`](Self::positions).
    pub fn flux_and_visibility(&self, object: usize) -> Result<Vec<f32>, JsError> {
        let LitSurface { flux, visibility, .. } = self.on_snow(object)?;
        let four = |(LinearRgb { r, g, b }, visibility): (&LinearRgb, &f32)| {
            let [r, g, b] = [*r, *g, *b].map(narrow);
            [r, g, b, *visibility]
        };
        Ok(flux.iter().zip(visibility).flat_map(four).collect())
    }

    /// The irradiance H by other surfaces under the last light at each vertex, as linear sRGB.
    ///
    /// # Errors
    ///
    /// See [`positions`](Self::positions).
    pub fn diffuse_irradiance(&self, object: usize) -> Result<Vec<f32>, JsError> {
        Ok(colors(&self.on_snow(object)?.diffuse_irradiance))
    }

    /// The irradiance V F by a sky as the last light at each vertex, as linear sRGB; empty for a lamp and the sun.
    ///
    /// # Errors
    ///
    /// See [`positions`](Self::positions).
    pub fn sky_irradiance(&self, object: usize) -> Result<Vec<f32>, JsError> {
        Ok(colors(&self.on_snow(object)?.sky_irradiance))
    }

    /// Linear sRGB of the last lamp's radiant intensity, or of the irradiance of a surface that faces the sun.
    #[must_use]
    pub fn strength_rgb(&self) -> Vec<f32> {
        self.solved.get(&self.last).map_or_else(Vec::new, |snow| colors(&[snow.strength]))
    }

    fn object(&self, object: usize) -> Result<&BakedObject, JsError> {
        self.snow.objects().nth(object).ok_or_else(|| JsError::new(&format!("there is no object {object}")))
    }

    fn on_snow(&self, object: usize) -> Result<&LitSurface, JsError> {
        let surface = self.solved.get(&self.last).and_then(|snow| snow.surfaces.get(object));
        surface.ok_or_else(|| JsError::new(&format!("object {object} is not lit")))
    }

    /// A lamp by the rules of scenes.
    fn lamp(&self, lamp: &str) -> Result<Arc<Light>, String> {
        let scene: SceneDescription = serde_json::from_str(&format!(r#"{{ "light": [{lamp}] }}"#)).map_err(text)?;
        let lights = self.snow.lights(scene.lights, None, &FilesInMemory::default()).map_err(text)?;
        lights.into_iter().next().ok_or_else(|| "there is no lamp".to_owned())
    }

    /// The lights of a sky by the rules of scenes.
    fn lights_of_sky(&self, sky: &str, files: &Files) -> Result<Vec<Arc<Light>>, String> {
        let scene: SceneDescription = serde_json::from_str(&format!(r#"{{ "sky": {sky} }}"#)).map_err(text)?;
        self.snow.lights(Vec::new(), scene.sky, &files.0).map_err(text)
    }
}

#[wasm_bindgen]
impl Picture {
    /// A picture without samples: JSON with the keys of a scene file.
    ///
    /// # Errors
    ///
    /// With the error message of the command.
    #[wasm_bindgen(constructor)]
    pub fn new(scene: &str, files: &Files) -> Result<Self, JsError> {
        Self::unfinished(scene, files).map_err(|reason| JsError::new(&reason))
    }

    fn unfinished(scene: &str, files: &Files) -> Result<Self, String> {
        let description: SceneDescription = serde_json::from_str(scene).map_err(text)?;
        Ok(Self::without_samples(prepare(&description, files, Some(Views::All))?))
    }

    fn without_samples(integrator: Integrator) -> Self {
        let scene = integrator.scene();
        let sums = accumulator(scene, Aovs::default(), &all_samples(scene).window());
        Self { integrator, sums }
    }

    /// A first picture of the scene: few pixels with a sample each, and coarse cells of snow. None for `pcasnow`,
    /// which has no cells, and for snow that needs finer cells.
    ///
    /// # Errors
    ///
    /// With the error message of the command.
    pub fn coarse(scene: &str, files: &Files) -> Result<Option<Self>, JsError> {
        Self::coarse_picture(scene, files).map_err(|reason| JsError::new(&reason))
    }

    fn coarse_picture(scene: &str, files: &Files) -> Result<Option<Self>, String> {
        let description: SceneDescription = serde_json::from_str(scene).map_err(text)?;
        let scene = description.build(&files.0).map_err(text)?;
        Ok(Integrator::prepare_coarse(&scene, &|_| {}).ok().flatten().map(Self::without_samples))
    }

    /// Width in pixels.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.scene().film().width.get()
    }

    /// Height in pixels.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.scene().film().height.get()
    }

    /// Mean number of samples of a pixel so far; at most the number of samples of the scene.
    #[must_use]
    pub fn samples(&self) -> u32 {
        let all = all_samples(self.scene());
        let missing = self.sums.missing_count(&all);
        let pixels = u64::from(self.width()) * u64::from(self.height());
        u32::try_from((all.count() - missing) / pixels.max(1)).unwrap_or(u32::MAX)
    }

    /// Adds samples for about a number of milliseconds, and returns the number of samples of each pixel.
    pub fn add(&mut self, milliseconds: f64) -> u32 {
        let end = Date::now() + milliseconds;
        let control = RenderControl { report: &|_| {}, stop: &|| Date::now() >= end };
        render_missing(&self.integrator, &all_samples(self.integrator.scene()), &mut self.sums, control);
        self.samples()
    }

    /// The pixels for a display: RGBA of 8 bits.
    #[must_use]
    pub fn display(&self) -> wasm_bindgen::Clamped<Vec<u8>> {
        let raster = to_raster(&self.sums.film(), self.scene().film().exposure);
        wasm_bindgen::Clamped(raster.bytes().chunks_exact(3).flat_map(|rgb| [rgb[0], rgb[1], rgb[2], 255]).collect())
    }

    fn scene(&self) -> &snowblue_render::Scene {
        self.integrator.scene()
    }
}

fn colors(colors: &[LinearRgb]) -> Vec<f32> {
    colors.iter().flat_map(|color| [color.r, color.g, color.b].map(narrow)).collect()
}
