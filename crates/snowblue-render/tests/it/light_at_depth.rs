//! Light deep in a wide pack against the fluxes of discrete ordinates and Bohren's theory (1983, "Colors of snow,
//! frozen waterfalls, and icebergs"), and the energy of a day.

use glam::Vec3A;
use snowblue_base::files::FilesInMemory;
use snowblue_color::{Colorimeter, DominantWavelength, Illuminant, Observer};
use snowblue_geometry::ray::SurfacePoint;
use snowblue_sky::{ClearSky, WAVELENGTHS_NM};
use snowblue_transport::layer_file::LayerFile;
use snowblue_transport::ordinates::{OrdinatesOptions, solve_stack};
use snowblue_transport::slab::Incidence;
use snowblue_transport::stack::{Layer, Stack, StackRadiometry};

use snowblue_render::{Integrator, Preparation};
use snowblue_scene::Scene;
use snowblue_scene::spectrum::wavelengths_nm;

use crate::snow::parsed;

const SNOW: &str = "[material.snow]\ntype = \"snow\"\nlayers = \"pack.toml\"\n\
     [material.black]\ntype = \"diffuse\"\nreflectance = 0\n";

/// The snow, for the scene and for discrete ordinates.
const PACK: &str = "[[layer]]\nthickness_cm = 20\ngrain_size_um = 300\nfacetness = 0.3\ndensity_kg_m3 = 300\n";

fn scene(text: &str) -> Scene {
    let head = "[film]\nwidth = 640\nheight = 640\n[integrator]\ntype = \"diffusion\"\nsamples_per_pixel = 1\n";
    let description = parsed(format!("{head}{SNOW}{text}"));
    description.build(&files()).unwrap()
}

fn files() -> FilesInMemory {
    FilesInMemory::from([("pack.toml", PACK)])
}

/// The fluxes in a pack of a thickness over a black ground, for each wavelength.
fn pack(thickness_cm: f64, depths_cm: &[f64], incidence: Incidence) -> Vec<StackRadiometry> {
    let stack = Stack {
        layers: vec![Layer { thickness_cm, ..LayerFile::parse(PACK).unwrap().layers[0] }],
        ground_albedo: 0.0.into(),
        depths_cm: depths_cm.to_vec(),
        incidences: vec![incidence],
        wavelengths_nm: wavelengths_nm().to_vec(),
    };
    solve_stack(&stack, &OrdinatesOptions::default()).unwrap()
}

/// Dominant wavelength and excitation purity of a spectrum of equal-energy light.
fn color(spectrum: &[f64]) -> DominantWavelength {
    let colorimeter = Colorimeter::new(Observer::Cie1931, Illuminant::E, &wavelengths_nm()).unwrap();
    let white = colorimeter.xyz(&[1.0; 31]).chromaticity();
    DominantWavelength::of(colorimeter.xyz(spectrum).chromaticity(), white, Observer::Cie1931).unwrap().unwrap()
}

#[test]
fn deep_in_a_wide_pack_light_has_the_fluxes_and_the_colour_of_discrete_ordinates() {
    let scene = scene(
        "[camera]\nposition = [0, -4, 2]\nlook_at = [0, 0, 0]\n\
         [environment]\nradiance_w_m2_sr = 0.3183098861837907\nilluminant = \"E\"\n\
         [[object]]\nshape = \"box\"\nsize = [2.4, 2.4, 0.6]\nposition = [0, 0, -0.3]\nmaterial = \"snow\"\n\
         [[object]]\nshape = \"plane\"\nposition = [0, 0, -0.602]\nmaterial = \"black\"\n",
    );
    let integrator = Integrator::prepare(&scene).unwrap();
    let field = integrator.light_field().unwrap().of_object(0).unwrap();
    let depths_cm = [5.0, 10.0, 20.0, 30.0];
    let known = pack(60.0, &depths_cm, Incidence::Diffuse);
    for (place, depth_cm) in depths_cm.into_iter().enumerate() {
        #[expect(clippy::cast_possible_truncation, reason = "a coordinate")]
        let at = field.fluence(Vec3A::new(0.013, 0.007, -0.01 * depth_cm as f32));
        // Diffuse light of the fluence rate φ has the fluxes φ/4 ∓ J/2 downwards and upwards, φ/2 together.
        let found: Vec<f64> = at.0.iter().map(|value| 0.5 * f64::from(*value)).collect();
        let fluxes: Vec<f64> =
            known.iter().map(|one| one.profile[place].down.value + one.profile[place].up.value).collect();
        // Blue, to 480 nm. Cells inside are as wide as a third of their depth: light that decays within a cell is too
        // strong there, by 3 % at 550 nm and up to 60 % in the last of the red.
        for (found, expected) in found.iter().zip(&fluxes).take(9) {
            assert!((found / expected - 1.0).abs() < 0.012, "{depth_cm} cm: {found} {expected}");
        }
        let (found, expected) = (color(&found), color(&fluxes));
        assert!((found.wavelength_nm - expected.wavelength_nm).abs() < 0.5, "{depth_cm} cm: {found:?} {expected:?}");
        let purity = found.excitation_purity / expected.excitation_purity;
        assert!((purity - 1.0).abs() < 0.12, "{depth_cm} cm: {found:?} {expected:?}");
    }
    // Bohren's rate of decay K = √(3 μ_a/ℓ*) holds far from all faces.
    let optics = &field.snow().spectra(0.6)[0];
    let [above, below] = [0.15, 0.25].map(|depth_m| field.fluence(Vec3A::new(0.013, 0.007, -depth_m)));
    for k in 0..9 {
        let rate = (3.0 * optics.absorption_per_m[k] / optics.transport_lengths_m[k]).sqrt();
        // Light that the black ground at 60 cm takes makes it decay faster: sinh K(0.6 m − z).
        let expected = ((0.6 - 0.15) * rate).sinh() / ((0.6 - 0.25) * rate).sinh();
        let found = f64::from(above.0[k] / below.0[k]);
        // The ground is beyond the snow by the extrapolation length, 1 mm of 350.
        assert!((found / expected - 1.0).abs() < 0.01, "{k}: {found} {expected}");
    }
}

#[test]
fn a_slab_absorbs_over_a_day_what_discrete_ordinates_say() {
    let thickness_m = 0.2;
    let (mut found, mut expected) = ([0.0; 31], [0.0; 31]);
    let mut earlier: Option<Integrator> = None;
    // The sky by rings: what a ring sends is absorbed as at its angle.
    let rings = [0, 1, 2, 3, 4, 5].map(|ring| {
        let angle_deg = 7.5 + 15.0 * f64::from(ring);
        (angle_deg, pack(20.0, &[], Incidence::Beam { angle_deg }))
    });
    // Elevations of the sun at 46.5° N in March, in the morning and at noon; the afternoon is the same.
    for elevation_deg in [12.0, 41.0] {
        let text = format!(
            "[camera]\nposition = [0, -4, 2]\nlook_at = [0, 0, 0]\n[film]\nwidth = 64\nheight = 64\n\
             [integrator]\ntype = \"diffusion\"\nsamples_per_pixel = 1\n{SNOW}\
             [sky]\nsun = {{ elevation_deg = {elevation_deg}, azimuth_deg = 130 }}\nground_albedo = 0.9\n\
             [[object]]\nshape = \"box\"\nsize = [1, 1, {thickness_m}]\nposition = [0, 0, -0.1]\n\
             material = \"snow\"\n\
             [[object]]\nshape = \"plane\"\nposition = [0, 0, -0.202]\nmaterial = \"black\"\n"
        );
        let description = parsed(text);
        let scene = description.build(&files()).unwrap();
        let preparation = Preparation { earlier: earlier.take(), ..Preparation::default() };
        let integrator = Integrator::prepare_with(&scene, preparation).unwrap();
        let field = integrator.light_field().unwrap().of_object(0).unwrap();
        let point = |z: f32, k: u8| {
            let (sin, cos) = f32::from(k).sin_cos();
            Vec3A::new(0.03 * f32::from(k).sqrt() * cos, 0.03 * f32::from(k).sqrt() * sin, z)
        };
        // Light is sampled at each surface element: the mean over some places has less noise.
        for k in 1..=32 {
            let [top, bottom] = [(0.0, Vec3A::Z), (-0.2, Vec3A::NEG_Z)]
                .map(|(z, normal)| field.flux(&SurfacePoint { point: point(z, k), normal }));
            for (sum, (top, bottom)) in found.iter_mut().zip(top.0.iter().zip(bottom.0)) {
                *sum -= f64::from(top + bottom) / 32.0;
            }
        }
        let sky = ClearSky::new(elevation_deg, 3.0, &[0.9; WAVELENGTHS_NM.len()]).unwrap();
        let sun = pack(20.0, &[], Incidence::Beam { angle_deg: 90.0 - elevation_deg });
        for (k, nm) in wavelengths_nm().into_iter().enumerate() {
            let absorbed = |one: &StackRadiometry| one.whole.fluxes.absorptance.value;
            expected[k] += 310.0 * sky.sun_irradiance(nm) * elevation_deg.to_radians().sin() * absorbed(&sun[k]);
            for (angle_deg, ring) in &rings {
                let (mut irradiance, cells) = (0.0, 16);
                for polar in 0..cells {
                    let angle = (angle_deg - 7.5 + 15.0 * (f64::from(polar) + 0.5) / f64::from(cells)).to_radians();
                    for turn in 0..4 * cells {
                        let azimuth = std::f64::consts::TAU * (f64::from(turn) + 0.5) / f64::from(4 * cells);
                        let (sin_el, cos_el) = elevation_deg.to_radians().sin_cos();
                        let cos_sun = angle.cos() * sin_el + angle.sin() * azimuth.cos() * cos_el;
                        let solid_angle = angle.sin() * 15f64.to_radians() / f64::from(cells) * std::f64::consts::TAU
                            / f64::from(4 * cells);
                        irradiance += sky.radiance(nm, angle.cos(), cos_sun) * angle.cos() * solid_angle;
                    }
                }
                expected[k] += 310.0 * irradiance * absorbed(&ring[k]);
            }
        }
        earlier = Some(integrator);
    }
    let total = found.iter().sum::<f64>() / expected.iter().sum::<f64>();
    assert!((total - 1.0).abs() < 0.02, "{total}");
}
