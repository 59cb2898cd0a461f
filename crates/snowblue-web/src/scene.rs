//! Light fields and pictures of scenes, for workers.

use std::fmt::Write as _;
use std::io;
use std::path::PathBuf;

use js_sys::Date;
use snowblue_color::LinearRgb;
use snowblue_database::fill::{FillOptions, fill};
use snowblue_database::{Axes, CompressedTable, Space};
use snowblue_render::bake::{BakedObject, LitSurface, Relighting};
use snowblue_render::files::{FilesInMemory, SceneFiles};
use snowblue_render::film::image_file::to_raster;
use snowblue_render::render::{RenderControl, accumulator, all_samples, render_missing};
use snowblue_render::scene::IntegratorKind;
use snowblue_render::scene::description::MaterialDescription;
use snowblue_render::scene::light::Light;
use snowblue_render::{Aovs, FilmAccumulator, SampleBlock, SceneDescription};
use wasm_bindgen::prelude::*;

use crate::snow::text;

/// Rays through grains for the curves of PCASnow: 0.4 % in the transmittance of 15 cm.
const TABLE_RAYS: u32 = 1 << 16;
/// Principal components of these curves, in log space. The embedded table has six, which keep T within 0.5 %.
const COMPONENTS: usize = 8;

/// Files that scenes name: meshes, and the coefficients of the clear sky.
#[wasm_bindgen]
#[derive(Debug, Default)]
pub struct Files(FilesInMemory);

/// The light of one lamp, the sun or a sky at a time in all snow of a scene.
#[wasm_bindgen]
#[derive(Debug)]
pub struct LightField {
    description: SceneDescription,
    table: CompressedTable,
    snow: Relighting,
    /// The lights of the last sky, and its JSON.
    sky: (String, Vec<Light>),
    /// The strength of the last light.
    strength: LinearRgb,
    lit: Vec<LitSurface>,
}

/// A picture of a scene that gets better with each sample.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Picture {
    scene: snowblue_render::Scene,
    sums: FilmAccumulator,
}

/// Finds meshes as Wavefront OBJ, the simplest format.
struct ObjFiles<'m>(&'m Files);

impl SceneFiles for ObjFiles<'_> {
    fn read(&self, name: &str) -> io::Result<Vec<u8>> {
        self.0.0.read(name)
    }

    fn display_name(&self, name: &str) -> PathBuf {
        format!("{name}.obj").into()
    }
}

#[wasm_bindgen]
impl Files {
    /// No file.
    #[wasm_bindgen(constructor)]
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a mesh of triangles: three coordinates of each vertex, and three vertices of each triangle.
    pub fn add_mesh(&mut self, name: &str, positions: &[f32], triangles: &[u32]) {
        let mut obj = String::new();
        // Writing to a string cannot fail.
        for vertex in positions.chunks_exact(3) {
            let _ = writeln!(obj, "v {} {} {}", vertex[0], vertex[1], vertex[2]);
        }
        for triangle in triangles.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|corner| u64::from(triangle[corner]) + 1);
            let _ = writeln!(obj, "f {a} {b} {c}");
        }
        self.0.insert(name, obj);
    }

    /// Adds a file by its content.
    pub fn add(&mut self, name: &str, content: &[u8]) {
        self.0.insert(name, content);
    }
}

/// A scene of a description.
fn build(
    description: &SceneDescription,
    table: &CompressedTable,
    files: &Files,
) -> Result<snowblue_render::Scene, String> {
    description.build(table, &ObjFiles(files)).map_err(text)
}

/// The curves of the snow of a scene; only PCASnow reads them, so that others have next to none. Scenes of several
/// kinds of snow are refused when they are built.
fn table(description: &SceneDescription) -> Result<CompressedTable, String> {
    let snow = description.materials.values().find_map(|material| match material {
        MaterialDescription::PcaSnow(snow) => Some(snow.sample_at(0.0)),
        MaterialDescription::Diffuse(_) | MaterialDescription::LayeredSnow(_) => None,
    });
    let mut axes = Axes::of_sample(&snow.ok_or("the scene has no snow without layers")?);
    let (mut rays, mut components) = (TABLE_RAYS, COMPONENTS);
    if description.integrator.kind != IntegratorKind::PcaSnow {
        (axes.angles_deg, axes.thicknesses_cm, rays, components) = (vec![0.0], vec![1.0, 2.0], 16, 1);
    }
    let full = fill(&axes, &FillOptions::by_ordinates(rays), &|_| ()).map_err(text)?;
    CompressedTable::new(&full, Space::Log, components).map_err(text)
}

#[wasm_bindgen]
impl LightField {
    /// Prepares the snow of a scene: JSON with the keys of a scene file. Fewer rays through grains than by default are
    /// faster. Vertices lie at most `edge_mm` apart, by default two cells.
    ///
    /// # Errors
    ///
    /// In the words of the command.
    #[wasm_bindgen(constructor)]
    pub fn new(scene: &str, files: &Files, grain_rays: Option<u32>, edge_mm: Option<f64>) -> Result<Self, JsError> {
        Self::prepared(scene, files, grain_rays, edge_mm).map_err(|reason| JsError::new(&reason))
    }

    fn prepared(scene: &str, files: &Files, grain_rays: Option<u32>, edge_mm: Option<f64>) -> Result<Self, String> {
        let mut description: SceneDescription = serde_json::from_str(scene).map_err(text)?;
        description.integrator.kind = IntegratorKind::Diffusion;
        description.light_field.grain_rays = grain_rays.unwrap_or(description.light_field.grain_rays);
        description.check().map_err(text)?;
        let table = table(&description)?;
        let scene = build(&description, &table, files)?;
        let snow = Relighting::new(scene, edge_mm.map(|edge_mm| 1e-3 * edge_mm)).map_err(text)?;
        let (sky, strength) = ((String::new(), Vec::new()), LinearRgb { r: 0.0, g: 0.0, b: 0.0 });
        Ok(Self { description, table, snow, sky, strength, lit: Vec::new() })
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

    /// Solves for a lamp, JSON of a light of a scene, without any other.
    ///
    /// # Errors
    ///
    /// In the words of the command.
    pub fn light(&mut self, lamp: &str) -> Result<(), JsError> {
        let lamp = self.lamp(lamp).map_err(|reason| JsError::new(&reason))?;
        self.solve(&lamp);
        Ok(())
    }

    /// Solves for a part of a sky, JSON of the table `[sky]` of a scene, without the other: its sun, or the sky without
    /// the sun. `files` holds the coefficients of a clear sky.
    ///
    /// # Errors
    ///
    /// In the words of the command.
    pub fn light_sky(&mut self, sky: &str, is_sun: bool, files: &Files) -> Result<(), JsError> {
        let failed = |reason: String| JsError::new(&reason);
        if self.sky.0 != sky {
            self.sky = (sky.to_owned(), self.lights_of_sky(sky, files).map_err(failed)?);
        }
        let lights = std::mem::take(&mut self.sky.1);
        let light = lights.iter().find(|light| light.is_sky() != is_sun);
        let found = light.map(|light| self.solve(light));
        self.sky.1 = lights;
        found.ok_or_else(|| failed("an overcast sky has no sun".to_owned()))
    }

    /// The radiance of the last sky without its sun as linear sRGB, in W m⁻² sr⁻¹ as a picture has it, from each of
    /// some unit directions.
    #[must_use]
    pub fn sky_radiance(&self, directions: &[f32]) -> Vec<f32> {
        let Some(sky) = self.sky.1.iter().find(|light| light.is_sky()) else { return Vec::new() };
        let from = |direction: &[f32]| self.snow.radiance(sky, glam::Vec3A::from_slice(direction));
        colors(&directions.chunks_exact(3).map(from).collect::<Vec<_>>())
    }

    fn solve(&mut self, light: &Light) {
        self.strength = self.snow.strength(light);
        self.lit = self.snow.light(light);
    }

    /// The net flux J at each vertex, as linear sRGB.
    ///
    /// # Errors
    ///
    /// See [`positions`](Self::positions).
    pub fn flux(&self, object: usize) -> Result<Vec<f32>, JsError> {
        Ok(colors(&self.on_snow(object)?.flux))
    }

    /// The irradiance H by other surfaces at each vertex, as linear sRGB.
    ///
    /// # Errors
    ///
    /// See [`positions`](Self::positions).
    pub fn diffuse_irradiance(&self, object: usize) -> Result<Vec<f32>, JsError> {
        Ok(colors(&self.on_snow(object)?.diffuse_irradiance))
    }

    /// The irradiance V F by a sky at each vertex, as linear sRGB; empty for a lamp and the sun.
    ///
    /// # Errors
    ///
    /// See [`positions`](Self::positions).
    pub fn sky_irradiance(&self, object: usize) -> Result<Vec<f32>, JsError> {
        Ok(colors(&self.on_snow(object)?.sky_irradiance))
    }

    /// The visibility V of the lamp or the sun at each vertex.
    ///
    /// # Errors
    ///
    /// See [`positions`](Self::positions).
    pub fn visibility(&self, object: usize) -> Result<Vec<f32>, JsError> {
        Ok(self.on_snow(object)?.visibility.clone())
    }

    /// Linear sRGB of the lamp's radiant intensity, or of the irradiance of a surface that faces the sun.
    #[must_use]
    pub fn strength_rgb(&self) -> Vec<f32> {
        colors(&[self.strength])
    }

    fn object(&self, object: usize) -> Result<&BakedObject, JsError> {
        self.snow.objects().nth(object).ok_or_else(|| JsError::new(&format!("there is no object {object}")))
    }

    fn on_snow(&self, object: usize) -> Result<&LitSurface, JsError> {
        self.lit.get(object).ok_or_else(|| JsError::new(&format!("object {object} is not lit")))
    }

    /// The scene with another value of a key.
    fn with(&self, key: &str, value: serde_json::Value) -> Result<SceneDescription, String> {
        let mut document = serde_json::to_value(&self.description).map_err(text)?;
        document[key] = value;
        serde_json::from_value(document).map_err(text)
    }

    /// A lamp by the rules of the scene's lights.
    fn lamp(&self, lamp: &str) -> Result<Light, String> {
        let lamp: serde_json::Value = serde_json::from_str(lamp).map_err(text)?;
        let lamps = self.with("light", vec![lamp].into())?.lights;
        let lights = self.snow.lights(lamps, None, &self.table, &FilesInMemory::default()).map_err(text)?;
        lights.into_iter().next().ok_or_else(|| "there is no lamp".to_owned())
    }

    /// The lights of a sky by the rules of the scene's.
    fn lights_of_sky(&self, sky: &str, files: &Files) -> Result<Vec<Light>, String> {
        let description = self.with("sky", serde_json::from_str(sky).map_err(text)?)?;
        self.snow.lights(Vec::new(), description.sky, &self.table, &ObjFiles(files)).map_err(text)
    }
}

#[wasm_bindgen]
impl Picture {
    /// A picture without samples: JSON with the keys of a scene file.
    ///
    /// # Errors
    ///
    /// In the words of the command.
    #[wasm_bindgen(constructor)]
    pub fn new(scene: &str, files: &Files) -> Result<Self, JsError> {
        Self::unfinished(scene, files).map_err(|reason| JsError::new(&reason))
    }

    fn unfinished(scene: &str, files: &Files) -> Result<Self, String> {
        let description: SceneDescription = serde_json::from_str(scene).map_err(text)?;
        description.check().map_err(text)?;
        let scene = build(&description, &table(&description)?, files)?;
        let sums = accumulator(&scene, Aovs::default(), &all_samples(&scene).window());
        Ok(Self { scene, sums })
    }

    /// Width in pixels.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.scene.film().width
    }

    /// Height in pixels.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.scene.film().height
    }

    /// Samples of each pixel so far, on average; at most those of the scene.
    #[must_use]
    pub fn samples(&self) -> u32 {
        let all = all_samples(&self.scene);
        let missing: u64 = self.sums.coverage().missing_from(&all).iter().map(SampleBlock::count).sum();
        let pixels = u64::from(self.width()) * u64::from(self.height());
        u32::try_from((all.count() - missing) / pixels.max(1)).unwrap_or(u32::MAX)
    }

    /// Adds samples for about some milliseconds, and returns how many each pixel has.
    pub fn add(&mut self, milliseconds: f64) -> u32 {
        let end = Date::now() + milliseconds;
        let control = RenderControl { progress: &|_| {}, stop: &|| Date::now() >= end };
        render_missing(&self.scene, &all_samples(&self.scene), &mut self.sums, control);
        self.samples()
    }

    /// The pixels for a display: RGBA of 8 bits.
    #[must_use]
    pub fn display(&self) -> wasm_bindgen::Clamped<Vec<u8>> {
        let raster = to_raster(&self.sums.film(), self.scene.film().exposure);
        wasm_bindgen::Clamped(raster.bytes().chunks_exact(3).flat_map(|rgb| [rgb[0], rgb[1], rgb[2], 255]).collect())
    }

    /// The exposure of the display, in stops.
    #[must_use]
    pub fn exposure_stops(&self) -> f64 {
        self.sums.film().display_factor(self.scene.film().exposure).log2()
    }
}

fn colors(colors: &[LinearRgb]) -> Vec<f32> {
    colors.iter().flat_map(|color| [color.r, color.g, color.b].map(narrow)).collect()
}

#[expect(clippy::cast_possible_truncation, reason = "attributes have single precision")]
fn narrow(value: f64) -> f32 {
    value as f32
}
