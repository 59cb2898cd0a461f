//! Snow for tests: one with a simple law, to tell depths and angles from light, and one as it is.

#![allow(dead_code, reason = "every test file uses some of it")]
#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]
#![allow(clippy::cast_possible_truncation, reason = "tables and rays are in single precision")]

use std::path::Path;

use glam::Vec3A;
use snowblue_database::pca::Components;
use snowblue_database::{Axes, CompressedTable, PcaSnow, Space, TableSample, fill};
use snowblue_render::camera::{PinholeCamera, View};
use snowblue_render::light::{Light, PointLight};
use snowblue_render::render::pixel_radiance;
use snowblue_render::scene::Scene;
use snowblue_render::scene_file::Overrides;
use snowblue_render::spectrum::{SAMPLES, Spectrum, wavelengths_nm};

/// The sample that both tables hold.
pub(crate) const SAMPLE: TableSample = TableSample::new(400.0, 0.3, 300.0);

/// A pca_snow material of that sample, ready for more keys.
pub(crate) const SNOW: &str =
    "[material.snow]\ntype = \"pca_snow\"\ngrain_size_um = 400\nfacetness = 0.3\ndensity_kg_m3 = 300\n";

/// A camera, which every scene must have, for a picture of one pixel.
pub(crate) const CAMERA: &str = "[camera]\nposition = [0, -9, 0]\nlook_at = [0, 0, 0]\n[film]\nwidth = 1\nheight = 1\n\
    [integrator]\nsamples_per_pixel = 1\nmax_bounces = 0\n";

/// Extinction of the simple law at a wavelength, in 1/cm.
pub(crate) fn extinction_per_cm(wavelength: usize) -> f64 {
    0.02 + 0.001 * wavelength as f64
}

/// Snow with T = exp(−σ h (1 + θ/100°)) and R = 1/4: both are exact in the table's own interpolation, which is linear
/// in ln T over thickness and angle.
pub(crate) fn simple_law() -> CompressedTable {
    let axes = Axes {
        grain_sizes_um: vec![SAMPLE.grain_size_um],
        facetness: vec![SAMPLE.facetness],
        densities_kg_m3: vec![SAMPLE.density_kg_m3],
        further: vec![],
        diffuse: false,
        angles_deg: vec![0.0, 89.0],
        thicknesses_cm: vec![0.001, 10.0, 100.0],
        wavelengths_nm: wavelengths_nm().to_vec(),
    };
    let mut coefficients = Vec::new();
    for angle in &axes.angles_deg {
        coefficients.extend(axes.thicknesses_cm.iter().map(|thickness| (-thickness * (1.0 + angle / 100.0)) as f32));
    }
    let components = |coefficients: Vec<f32>, basis: Vec<f32>| Components {
        count: 1,
        coefficients,
        basis,
        singular_values: vec![1.0],
    };
    CompressedTable {
        transmittance: components(coefficients, (0..SAMPLES).map(|k| extinction_per_cm(k) as f32).collect()),
        reflectance: components(vec![0.25f32.ln(); 6], vec![1.0; SAMPLES]),
        axes,
        space: Space::Log,
        metadata: Vec::new(),
    }
}

/// The sample's own curves, by discrete ordinates.
pub(crate) fn real() -> CompressedTable {
    let axes = Axes {
        grain_sizes_um: vec![SAMPLE.grain_size_um],
        facetness: vec![SAMPLE.facetness],
        densities_kg_m3: vec![SAMPLE.density_kg_m3],
        ..Axes::with_thin_and_thick_knots()
    };
    let options = fill::FillOptions::by_ordinates(1 << 14);
    let (table, _) = fill::fill(&axes, &options, &|_, _| {}).unwrap();
    CompressedTable::new(&table, Space::Log, 3).unwrap()
}

/// Reads a scene given as text; `files` are put beside it.
pub(crate) fn scene(text: &str, table: &CompressedTable, files: &[(&str, String)]) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    for (name, content) in files {
        std::fs::write(folder.path().join(name), content).unwrap();
    }
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, format!("{CAMERA}{text}")).unwrap();
    load(&path, table)
}

/// Reads a scene file.
pub(crate) fn load(path: &Path, table: &CompressedTable) -> Scene {
    Scene::load(path, table, &Overrides::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// The light seen from `eye` on looking at `target`, through an opening of a hundred-thousandth of a degree.
pub(crate) fn seen(scene: &mut Scene, eye: Vec3A, target: Vec3A) -> Spectrum {
    let up = (target - eye).any_orthogonal_vector();
    let view = View { position: eye, look_at: target, up, vertical_fov_deg: 1e-5 };
    scene.camera = PinholeCamera::new(&view, 1.0).unwrap();
    pixel_radiance(scene, 0, 0)
}

/// The scene's first light, a lamp without extent.
pub(crate) fn lamp(scene: &mut Scene) -> &mut PointLight {
    let Light::Point(lamp) = &mut scene.lights[0] else { panic!("the first light is a point") };
    lamp
}

/// The curves of the sample.
pub(crate) fn curves(table: &CompressedTable) -> PcaSnow {
    PcaSnow::new(table, &SAMPLE).unwrap()
}

/// Directions spread evenly over the sphere.
pub(crate) fn directions(count: usize) -> impl Iterator<Item = Vec3A> {
    (0..count).map(move |k| {
        let z = 1.0 - 2.0 * (k as f32 + 0.5) / count as f32;
        let turn = 2.399_963 * k as f32;
        let radius = (1.0 - z * z).sqrt();
        Vec3A::new(radius * turn.cos(), radius * turn.sin(), z)
    })
}
