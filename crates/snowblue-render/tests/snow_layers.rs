//! Snow of layers: light through slabs agrees with discrete ordinates, layers of the same snow are one, and layers lie
//! where the scene says.

#![allow(clippy::unwrap_used, clippy::cast_possible_truncation, reason = "tests may panic, and rays are single")]

mod snow;

use std::f64::consts::TAU;

use glam::Vec3A;
use snow::{analytic_table, radiance, scene_by};
use snowblue_database::CompressedTable;
use snowblue_database::table::Attribute;
use snowblue_render::scene::Scene;
use snowblue_render::spectrum::{SAMPLES, Spectrum, wavelengths_nm};
use snowblue_transport::layer_file::LayerFile;
use snowblue_transport::ordinates::{OrdinatesOptions, solve_stack};
use snowblue_transport::quadrature::Quadrature;
use snowblue_transport::slab::Incidence;
use snowblue_transport::stack::Stack;

/// A table with ice constants in its metadata. These integrators do not use its curves.
fn table() -> CompressedTable {
    let ice = Attribute::new("ice_constants", "Warren & Brandt 2008");
    CompressedTable { metadata: vec![ice], ..analytic_table() }
}

/// Sooty crust over clean depth hoar, a thin crust, and three layers of which one is thinner than the cells.
const PACKS: [(&str, &str); 3] = [
    (
        "soot",
        "[[layer]]\nthickness_cm = 2\ngrain_size_um = 200\ndensity_kg_m3 = 350\n\
         impurities_ng_g = { black-carbon = 500 }\n\
         [[layer]]\nthickness_cm = 8\ngrain_size_um = 800\ndensity_kg_m3 = 250\n",
    ),
    (
        "thin crust",
        "[[layer]]\nthickness_cm = 0.5\ngrain_size_um = 150\ndensity_kg_m3 = 400\n\
         [[layer]]\nthickness_cm = 9.5\ngrain_size_um = 800\ndensity_kg_m3 = 250\n",
    ),
    (
        "three",
        "[[layer]]\nthickness_cm = 3\nsnow = \"fresh\"\n\
         [[layer]]\nthickness_cm = 0.7\ngrain_size_um = 1000\ndensity_kg_m3 = 500\n\
         [[layer]]\nthickness_cm = 6.3\ngrain_size_um = 600\ndensity_kg_m3 = 300\n",
    ),
];

/// A scene of a body of the layers of a file.
fn layered(integrator: &str, layers: &str, top: &str, text: &str) -> Scene {
    let material = format!("[material.snow]\ntype = \"pca_snow\"\nlayers = \"pack.toml\"\nlayers_top = {top}\n");
    scene_by(integrator, &format!("{material}{text}"), &table(), &[("pack.toml", layers.to_owned())])
}

fn slab(thickness_m: f64, width_m: f64) -> String {
    format!("[[object]]\nshape = \"box\"\nsize = [{width_m}, {width_m}, {thickness_m}]\nmaterial = \"snow\"\n")
}

/// Flux through a level surface towards `up` = ±1 at a point, from its radiance in many directions.
fn flux(scene: &mut Scene, target: Vec3A, up: f32) -> Spectrum {
    const AZIMUTHS: u32 = 8;
    let rule = Quadrature::half_range(8);
    let mut sum = Spectrum::ZERO;
    for (cos, weight) in rule.cosines.iter().zip(&rule.weights) {
        for azimuth in 0..AZIMUTHS {
            let (sin_azimuth, cos_azimuth) = (TAU * (f64::from(azimuth) + 0.5) / f64::from(AZIMUTHS)).sin_cos();
            let sin = (1.0 - cos * cos).sqrt();
            let towards = Vec3A::new((sin * cos_azimuth) as f32, (sin * sin_azimuth) as f32, up * *cos as f32);
            let factor = weight * cos * TAU / f64::from(AZIMUTHS);
            sum += radiance(scene, target + towards * 3.0, target) * factor as f32;
        }
    }
    sum
}

/// Slabs of 10 cm under a beam, at all wavelengths.
#[test]
fn light_through_layers_agrees_with_discrete_ordinates() {
    for (name, pack) in PACKS {
        for angle_deg in [0.0_f64, 60.0] {
            let stack = Stack {
                layers: LayerFile::parse(pack).unwrap().layers,
                ground_albedo: 0.0,
                depths_cm: Vec::new(),
                incidences: vec![Incidence::Beam { angle_deg }],
                wavelengths_nm: wavelengths_nm().to_vec(),
            };
            let known = solve_stack(&stack, &OrdinatesOptions::default()).unwrap();
            let (sin, cos) = angle_deg.to_radians().sin_cos();
            let lamp = format!(
                "[[light]]\ntype = \"directional\"\ndirection = [{sin}, 0, {}]\nirradiance_w_m2 = {}\n\
                 illuminant = \"E\"\n",
                -cos,
                1.0 / cos
            );
            for (integrator, samples) in [("diffusion", 1), ("hybrid", 16)] {
                let mut scene = layered(integrator, pack, "\"surface\"", &format!("{lamp}{}", slab(0.1, 0.8)));
                scene.set_samples_per_pixel(samples);
                let transmitted = flux(&mut scene, Vec3A::new(0.0, 0.0, -0.05), -1.0);
                let reflected = flux(&mut scene, Vec3A::new(0.0, 0.0, 0.05), 1.0);
                for k in (0..SAMPLES).step_by(3) {
                    let (t, r) = (known[k].whole.transmittance.value, known[k].whole.reflectance.value);
                    let errors = [f64::from(transmitted.0[k]) / t - 1.0, f64::from(reflected.0[k]) / r - 1.0];
                    eprintln!("{name} {angle_deg} {integrator} {k}: {t:.5} {r:.5} {:+.4} {:+.4}", errors[0], errors[1]);
                }
            }
        }
    }
}
