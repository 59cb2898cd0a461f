//! Snow tables, scenes, prepared integrators and estimates for tests.

use std::fmt::Write;
use std::path::Path;

use glam::{DVec3, Vec3A};
use snowblue_color::Illuminant;
use snowblue_database::pca::Components;
use snowblue_database::{Axes, CompressedTable, PcaSnow, Space, TableSample, fill};
use snowblue_render::SceneFile;
use snowblue_render::raster::PixelPosition;
use snowblue_render::render::pixel_radiance;
use snowblue_render::scene::camera::View;
use snowblue_render::scene::description::{LightDescription, LightSource, Numbers, SceneDescription};
use snowblue_render::scene::spectrum::light_spectrum::LightSpectrum;
use snowblue_render::scene::spectrum::{SAMPLES, Spectrum, wavelengths_nm};
use snowblue_render::scene::{IntegratorKind, LightFieldSettings, Scene};
use snowblue_render::{Integrator, Preparation};
use snowblue_stat::{Moments, t_p_value};

/// The sample of the tables.
pub(crate) const SAMPLE: TableSample = TableSample::new(400.0, 0.3, 300.0);

/// Snow of that sample. Further keys can follow.
pub(crate) const SNOW: &str =
    "[material.snow]\ntype = \"snow\"\ngrain_size_um = 400\nfacetness = 0.3\ndensity_kg_m3 = 300\n";

/// Camera, film and integrator of an image of one pixel by PCASnow.
pub(crate) const CAMERA: &str = "[camera]\nposition = [0, -9, 0]\nlook_at = [0, 0, 0]\n[film]\nwidth = 1\nheight = 1\n\
    [integrator]\nsamples_per_pixel = 1\nmax_bounces = 0\ntype = \"pcasnow\"\n";

/// Extinction of [`analytic_table`] at a wavelength, in 1/cm.
pub(crate) fn extinction_per_cm(wavelength: usize) -> f64 {
    0.02 + 0.001 * wavelength as f64
}

/// A table with T = exp(−σ h (1 + θ/100°)) and R = 1/4. Its interpolation, linear in ln T over thickness and angle, is
/// exact. It shows depths and angles in radiance.
pub(crate) fn analytic_table() -> CompressedTable {
    let axes = Axes {
        grain_sizes_um: vec![SAMPLE.grain_size_um],
        facetness: vec![SAMPLE.facetness],
        densities_kg_m3: vec![SAMPLE.density_kg_m3],
        properties: vec![],
        diffuse: false,
        angles_deg: vec![0.0, 89.0],
        thicknesses_cm: vec![0.001, 10.0, 100.0],
        wavelengths_nm: wavelengths_nm().to_vec(),
    };
    let mut coefficients = Vec::new();
    for angle in &axes.angles_deg {
        coefficients.extend(axes.thicknesses_cm.iter().map(|thickness| (-thickness * (1.0 + angle / 100.0)) as f32));
    }
    CompressedTable {
        transmittance: component(coefficients, (0..SAMPLES).map(|k| extinction_per_cm(k) as f32).collect()),
        reflectance: component(vec![0.25f32.ln(); 6], vec![1.0; SAMPLES]),
        axes,
        space: Space::Log,
        metadata: Vec::new(),
    }
}

/// [`analytic_table`] for several grain sizes d: T = exp(−σ h (1 + θ/100°) √(400 µm/d)). The reflectance is higher for
/// fine grains and blue light.
pub(crate) fn analytic_table_of_grains() -> CompressedTable {
    let mut table = analytic_table();
    let one = std::mem::take(&mut table.transmittance.coefficients);
    table.axes.grain_sizes_um = vec![200.0, 400.0, 800.0];
    let finer: Vec<f32> = table.axes.grain_sizes_um.iter().map(|size_um| (400.0 / size_um).sqrt() as f32).collect();
    table.transmittance.coefficients =
        finer.iter().flat_map(|finer| one.iter().map(move |coefficient| coefficient * finer)).collect();
    let blue = (0..SAMPLES).map(|k| -0.05 - 0.01 * k as f32).collect();
    table.reflectance = component(finer.iter().flat_map(|finer| [finer.recip(); 6]).collect(), blue);
    table
}

/// One principal component.
fn component(coefficients: Vec<f32>, basis: Vec<f32>) -> Components {
    Components { count: 1, coefficients, basis, singular_values: vec![1.0] }
}

/// The table of the sample by discrete ordinates.
pub(crate) fn computed_table() -> CompressedTable {
    let axes = Axes {
        grain_sizes_um: vec![SAMPLE.grain_size_um],
        facetness: vec![SAMPLE.facetness],
        densities_kg_m3: vec![SAMPLE.density_kg_m3],
        ..Axes::with_thin_and_thick_knots()
    };
    let options = fill::FillOptions::by_ordinates(1 << 14);
    let table = fill::fill(&axes, &options, &|_| {}).unwrap();
    CompressedTable::new(&table, Space::Log, 3).unwrap()
}

/// [`CAMERA`] with another integrator.
pub(crate) fn camera_of(method: &str) -> String {
    CAMERA.replace("pcasnow", method)
}

/// Settings of PCASnow.
pub(crate) fn pcasnow(keys: &str) -> String {
    format!("[integrator.pcasnow]\n{keys}\n")
}

/// Builds a scene from text for PCASnow; `files` are those that it names, or else come from the file system.
pub(crate) fn scene(text: &str, files: &[(&str, String)]) -> Scene {
    scene_by("pcasnow", text, files)
}

/// The same for an integrator.
pub(crate) fn scene_by(method: &str, text: &str, files: &[(&str, String)]) -> Scene {
    built(&description(method, text), files)
}

/// The same with few rays through grains, which saves time: for scenes that are compared with each other only.
pub(crate) fn scene_of_few_grains(method: &str, text: &str, files: &[(&str, String)]) -> Scene {
    scene_of_grains(1 << 12, method, text, files)
}

/// The same with as many rays through grains as users have.
pub(crate) fn scene_of_many_grains(method: &str, text: &str, files: &[(&str, String)]) -> Scene {
    scene_of_grains(LightFieldSettings::default().grain_rays, method, text, files)
}

fn scene_of_grains(grain_rays: u32, method: &str, text: &str, files: &[(&str, String)]) -> Scene {
    let mut description = description(method, text);
    description.light_field.grain_rays = grain_rays;
    built(&description, files)
}

fn description(method: &str, text: &str) -> SceneDescription {
    let text = format!("{}{text}", camera_of(method));
    parsed(text)
}

/// The description of a scene. Its 2¹⁵ rays through grains, instead of the usual 2¹⁸, save half a second each time, and
/// change the light by some tenths of a percent.
pub(crate) fn parsed(text: impl Into<String>) -> SceneDescription {
    let mut file = SceneFile::parse(text, "scene.toml").unwrap_or_else(|error| panic!("{error}"));
    file.description.light_field.grain_rays = 1 << 15;
    file.description
}

fn built(description: &SceneDescription, files: &[(&str, String)]) -> Scene {
    let files = |name: &str| match files.iter().find(|(other, _)| *other == name) {
        Some((_, content)) => Ok(content.clone().into_bytes()),
        None => std::fs::read(name),
    };
    description.build(&files).unwrap_or_else(|error| panic!("{error}"))
}

/// Reads a scene file whose snow is rendered by PCASnow.
pub(crate) fn load(path: &Path) -> Scene {
    let mut file = SceneFile::open(path).unwrap_or_else(|error| panic!("{error}"));
    file.description.integrator.kind = IntegratorKind::PcaSnow;
    file.build().unwrap_or_else(|error| panic!("{error}"))
}

/// Prepares the integrator of a scene; without a table, that of the scene or the embedded one serves PCASnow.
pub(crate) fn prepared(scene: &Scene, table: Option<&CompressedTable>) -> Integrator {
    let preparation = Preparation { table, ..Preparation::default() };
    let integrator = Integrator::prepare_with(scene, preparation).unwrap_or_else(|error| panic!("{error}"));
    let is_solved = integrator.notes().iter().any(|note| note.contains("its curves are solved for"));
    assert!(table.is_none() || !is_solved, "all curves are those of the table");
    integrator
}

/// PCASnow for a [`scene`] from text.
pub(crate) fn integrator(text: &str, table: Option<&CompressedTable>, files: &[(&str, String)]) -> Integrator {
    prepared(&scene(text, files), table)
}

/// The radiance from `target` to a camera at `eye`, with a field of view of 1e-5 degrees.
pub(crate) fn radiance(integrator: &mut Integrator, eye: Vec3A, target: Vec3A) -> Spectrum {
    let up = (target - eye).any_orthogonal_vector();
    let view = View { position: eye, look_at: target, up, vertical_fov_deg: 1e-5 };
    assert!(integrator.set_view(&view));
    pixel_radiance(integrator, PixelPosition { x: 0, y: 0 })
}

/// A mean over independent images and its standard error.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Estimate {
    pub(crate) mean: f64,
    pub(crate) standard_error: f64,
}

/// Number of images of an estimate. Samples within an image are not independent, so they cannot give its error.
const SEEDS: u32 = 16;

/// Relative rounding error of a radiance in single precision.
const ROUNDING: f64 = 3e-5;

impl Estimate {
    /// The estimate from independent values.
    pub(crate) fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut moments = Moments::default();
        values.into_iter().for_each(|value| moments.push(value));
        Self { mean: moments.mean(), standard_error: moments.standard_error() }
    }

    /// The p-value of a true mean of `exact`.
    pub(crate) fn p_value(&self, exact: f64) -> f64 {
        let error = self.standard_error.hypot(ROUNDING * exact);
        t_p_value((self.mean - exact) / error, f64::from(SEEDS - 1))
    }
}

/// Estimates of [`radiance`] at three wavelengths, from 16 images with `samples` samples each.
pub(crate) fn estimate(
    integrator: &mut Integrator,
    eye: Vec3A,
    target: Vec3A,
    samples: u32,
    bands: [usize; 3],
) -> [Estimate; 3] {
    integrator.set_samples_per_pixel(samples);
    let pictures: Vec<Spectrum> = (1..=SEEDS)
        .map(|seed| {
            integrator.set_seed(seed);
            radiance(integrator, eye, target)
        })
        .collect();
    bands.map(|k| Estimate::of(pictures.iter().map(|picture| f64::from(picture.0[k]))))
}

/// A point light.
pub(crate) struct PointLamp {
    /// Its position, in m.
    pub(crate) position: Vec3A,
    /// Its radiant intensity in W/sr, as a band density.
    pub(crate) intensity: Spectrum,
}

/// The scene's first light, a point light with the spectrum of an illuminant.
pub(crate) fn point_light(scene: &Scene) -> PointLamp {
    let LightDescription { spectrum, source: LightSource::Point(lamp) } = &scene.description().lights[0] else {
        panic!("the first light is a point")
    };
    let illuminant = spectrum.illuminant.unwrap_or(Illuminant::D65);
    let intensity = LightSpectrum::illuminant(illuminant).unwrap().unit * lamp.radiant_intensity_w_sr.get() as f32;
    PointLamp { position: DVec3::from(lamp.position.get()).as_vec3a(), intensity }
}

/// The same scene with the first light at another position.
pub(crate) fn with_light_at(scene: &Scene, at: Vec3A, files: &[(&str, String)]) -> Scene {
    let mut description = scene.description().clone();
    let LightSource::Point(lamp) = &mut description.lights[0].source else { panic!("the first light is a point") };
    lamp.position = Numbers::of(at.as_dvec3().to_array());
    built(&description, files)
}

/// The curves of the sample in a table.
pub(crate) fn curves(table: &CompressedTable) -> PcaSnow {
    PcaSnow::new(table, &SAMPLE).unwrap()
}

/// Directions evenly distributed over the sphere.
pub(crate) fn directions(count: usize) -> impl Iterator<Item = Vec3A> {
    (0..count).map(move |k| {
        let z = 1.0 - 2.0 * (k as f32 + 0.5) / count as f32;
        let turn = 2.399_963 * k as f32;
        let radius = (1.0 - z * z).sqrt();
        Vec3A::new(radius * turn.cos(), radius * turn.sin(), z)
    })
}

/// A block as a PLY file: half its size along y and z, in m, and places along x with a value of the attribute "age".
pub(crate) fn block_of_ages([y, z]: [f32; 2], ages: &[(f32, f32)]) -> String {
    let quads = 4 * (ages.len() - 1) + 2;
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         property float age\nelement face {quads}\nproperty list uchar int vertex_indices\nend_header\n",
        4 * ages.len()
    );
    for (x, age) in ages {
        for (y, z) in [(-y, -z), (y, -z), (y, z), (-y, z)] {
            writeln!(text, "{x} {y} {z} {age}").unwrap();
        }
    }
    for section in 0..ages.len() - 1 {
        for side in 0..4 {
            let [a, b] = [side, (side + 1) % 4].map(|corner| 4 * section + corner);
            writeln!(text, "4 {a} {} {} {b}", a + 4, b + 4).unwrap();
        }
    }
    let last = 4 * (ages.len() - 1);
    writeln!(text, "4 0 1 2 3\n4 {} {} {} {}", last + 3, last + 2, last + 1, last).unwrap();
    text
}
