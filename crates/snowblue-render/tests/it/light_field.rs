//! The integrators that solve for the light inside snow agree with discrete ordinates, conserve energy, and agree with
//! each other.

use std::f64::consts::TAU;
use std::path::Path;

use glam::Vec3A;
use snowblue_base::Count;
use snowblue_render::SceneFile;
use snowblue_render::files::FilesInMemory;
use snowblue_render::render::{render, render_all};
use snowblue_render::scene::Views;
use snowblue_render::scene::spectrum::Spectrum;
use snowblue_render::{Film, Integrator, Preparation};
use snowblue_stat::Moments;
use snowblue_transport::ordinates::{OrdinatesOptions, solve};
use snowblue_transport::quadrature::Quadrature;
use snowblue_transport::sample::SnowSample;
use snowblue_transport::slab::{Incidence, Slab};

use crate::snow::{self, SNOW, parsed, prepared, radiance, scene_by};

/// Indices of 450, 550 and 700 nm.
const BANDS: [usize; 3] = [5, 15, 30];

fn field(method: &str, text: &str) -> Integrator {
    prepared(&scene_by(method, &format!("{SNOW}{text}"), &[]), None)
}

fn shape(shape: &str, keys: &str) -> String {
    format!("[[object]]\nshape = \"{shape}\"\n{keys}\nmaterial = \"snow\"\n")
}

const SKY: &str = "[environment]\nradiance_w_m2_sr = 1\nilluminant = \"E\"\n";

/// Flux through a level surface towards `up` = ±1 at a point, from its radiance in many directions.
fn flux(integrator: &mut Integrator, target: Vec3A, up: f32) -> [f64; 3] {
    const AZIMUTHS: u32 = 8;
    let rule = Quadrature::half_range(8);
    let mut sums = [0.0; 3];
    for (cos, weight) in rule.cosines.iter().zip(&rule.weights) {
        for azimuth in 0..AZIMUTHS {
            let (sin_azimuth, cos_azimuth) = (TAU * (f64::from(azimuth) + 0.5) / f64::from(AZIMUTHS)).sin_cos();
            let sin = (1.0 - cos * cos).sqrt();
            let towards = Vec3A::new((sin * cos_azimuth) as f32, (sin * sin_azimuth) as f32, up * *cos as f32);
            let radiance = radiance(integrator, target + towards * 3.0, target);
            for (sum, band) in sums.iter_mut().zip(BANDS) {
                *sum += f64::from(radiance.0[band]) * weight * cos * TAU / f64::from(AZIMUTHS);
            }
        }
    }
    sums
}

/// A lamp that touches the snow that it faces has no direct light on the elements of the surface.
#[test]
fn a_lamp_that_touches_the_snow_before_it_is_refused() {
    let prepare = |x_m: f64, look_at: f64| {
        let lamp = format!(
            "[[light]]\ntype = \"rectangle\"\nposition = [{x_m}, 0, 0]\nlook_at = [{look_at}, 0, 0]\n\
             size = [0.05, 0.05]\nradiance_w_m2_sr = 10\n"
        );
        let text = format!("{SNOW}{}{lamp}", shape("box", "size = [0.1, 0.1, 0.1]"));
        Integrator::prepare(&snow::scene_of_few_grains("diffusion", &text, &[])).map(|_| ())
    };
    for refused in [prepare(0.05, -1.0), prepare(0.0, 1.0)] {
        let message = refused.unwrap_err().to_string();
        assert!(message.contains("faces the snow and touches it") && message.contains("0.0001 m"), "{message}");
    }
    assert!(prepare(0.0501, -1.0).is_ok(), "it leaves a gap");
    assert!(prepare(0.05, 1.0).is_ok(), "it faces away");
}

/// Light of one wavelength does not depend on light of other wavelengths: snow reflects and transmits the blue light of
/// a lamp without red light as it does the blue light of a lamp of all wavelengths.
#[test]
fn a_lamp_without_some_wavelengths_has_its_light_at_the_others() {
    let lamp = "[[light]]\ntype = \"point\"\nposition = [0.02, 0.1, 0.03]\nradiant_intensity_w_sr = 1\n\
                spectrum = \"lamp.csv\"\n";
    let body = shape("box", "size = [0.1, 0.02, 0.1]");
    let last_blue = 10;
    for method in ["diffusion", "hybrid"] {
        for eye in [Vec3A::new(0.02, 1.0, 0.1), Vec3A::new(0.02, -1.0, 0.1)] {
            let [all, blue] = [30, last_blue].map(|last| {
                let rows = (0..=30).map(|k| format!("{},{}\n", 400 + 10 * k, if k <= last { 1.0 } else { 0.0 }));
                let csv = format!("wavelength_nm,value\n{}", rows.collect::<String>());
                let scene = scene_by(method, &format!("{SNOW}{lamp}{body}"), &[("lamp.csv", csv)]);
                radiance(&mut prepared(&scene, None), eye, Vec3A::new(0.01, 0.01 * eye.y, 0.01))
            });
            // Both lamps have 1 W/sr in all.
            let scale = blue.0[0] / all.0[0];
            for k in 0..=last_blue {
                let ratio = blue.0[k] / (scale * all.0[k]);
                assert!((ratio - 1.0).abs() < 0.01, "{method} {eye} {k}: {ratio}");
            }
            assert!(blue.0[last_blue + 1..].iter().all(|light| *light == 0.0));
            assert!((scale / 2.9 - 1.0).abs() < 0.1, "{method} {eye}: {scale}");
        }
    }
}

/// Slabs under a directional light. They are 60 times as wide as thick and the light does not depend on the place.
#[test]
fn diffusion_through_slabs_agrees_with_discrete_ordinates() {
    for (thickness_m, angle_deg) in [(0.004, 0.0), (0.02, 60.0), (0.02, 80.0)] {
        let slab = Slab {
            sample: SnowSample::default(),
            thicknesses_cm: vec![100.0 * thickness_m],
            incidences: vec![Incidence::Beam { angle_deg }],
            wavelengths_nm: vec![450.0, 550.0, 700.0],
        };
        let known = solve(&slab, &OrdinatesOptions::default()).unwrap();
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        let lamp = format!(
            "[[light]]\ntype = \"directional\"\ndirection = [{sin}, 0, {}]\nirradiance_w_m2 = {}\nilluminant = \"E\"\n",
            -cos,
            1.0 / cos
        );
        let width_m = 60.0 * thickness_m;
        let body = shape("box", &format!("size = [{width_m}, {width_m}, {thickness_m}]"));
        let mut integrator = field("diffusion", &format!("{lamp}{body}"));
        let half_m = 0.5 * thickness_m as f32;
        let transmitted = flux(&mut integrator, Vec3A::new(0.0, 0.0, -half_m), -1.0);
        let reflected = flux(&mut integrator, Vec3A::new(0.0, 0.0, half_m), 1.0);
        for (k, known) in known.iter().enumerate() {
            let (t, r) = (known.fluxes.transmittance.value, known.fluxes.reflectance.value);
            // Half a percent of diffusion from two transport mean free paths (4 mm) on, as much for the noise of both
            // tallies of grains, and for the reflectance at 80° that of the phase function at grazing angles.
            let error = (transmitted[k] / t - 1.0, reflected[k] / r - 1.0);
            assert!(error.0.abs() < 0.01 && error.1.abs() < 0.01, "{thickness_m} m, {angle_deg}°, {k}: {error:?}");
        }
    }
}

/// Under a sky of radiance 1 snow that absorbs nothing has the radiance 1 everywhere. At 400 nm this ball absorbs less
/// than 0.1 %.
#[test]
fn white_snow_under_a_white_sky_is_as_bright_as_the_sky() {
    let ball = shape("sphere", "radius = 0.03");
    let block = shape("box", "size = [0.06, 0.04, 0.05]");
    for (method, samples) in [("diffusion", 64), ("hybrid", 64)] {
        for body in [&ball, &block] {
            let mut integrator = field(method, &format!("{SKY}{body}"));
            integrator.set_samples_per_pixel(samples);
            let mut sum = 0.0;
            for direction in snow::directions(24) {
                sum += f64::from(radiance(&mut integrator, direction * 2.0, direction * 0.02).0[0]) / 24.0;
            }
            // Measured to 3·10⁻³; a percent is the aim.
            assert!((sum - 1.0).abs() < 0.01, "{method}: {sum}");
        }
    }
}

/// The wavelengths between the few that are solved for follow from these, though ℓ* differs between them.
#[test]
fn a_small_ball_under_a_white_sky_is_white_at_all_wavelengths() {
    let thin = "[material.thin]\ntype = \"snow\"\ndensity_kg_m3 = 50\n";
    let ball = "[[object]]\nshape = \"sphere\"\nradius = 0.05\nmaterial = \"thin\"\n";
    for method in ["diffusion", "hybrid"] {
        let mut integrator = prepared(&scene_by(method, &format!("{SNOW}{thin}{SKY}{ball}"), &[]), None);
        integrator.set_samples_per_pixel(4);
        let Spectrum(values) = radiance(&mut integrator, Vec3A::new(0.3, -2.0, 0.4), Vec3A::ZERO);
        // Absorption takes 0.1 % at 550 nm and 0.4 % at 700 nm. A spline without ℓ* has 1.011 at 470 nm.
        let is_white = |(k, value): (usize, &f32)| (if k < 16 { 0.998 } else { 0.994 }..1.001).contains(value);
        assert!(values.iter().enumerate().all(is_white), "{method}: {values:?}");
    }
}

/// A white plane that covers the dips of a rough surface encloses light in gaps far narrower than a cell. Most of the
/// light leaves them through the snow beside. Under a sky of radiance 1 nothing is brighter than the sky.
#[test]
fn snow_with_covered_dips_is_not_brighter_than_the_sky() {
    const POINTS: u8 = 16;
    let white = "[material.white]\ntype = \"diffuse\"\nreflectance = 0.99\n";
    let plane = "[[object]]\nshape = \"plane\"\nposition = [0, 0, -0.015]\nmaterial = \"white\"\n";
    let drift = shape("drift", "size = [1.2, 1.2, 0.3]\nrelief = 0.03\nseed = 7");
    let mut scene = scene_by("diffusion", &format!("{SNOW}{SKY}{white}{plane}{drift}"), &[]);
    scene.set_max_bounces(Count::of(8));
    let mut integrator = prepared(&scene, None);
    integrator.set_samples_per_pixel(4);
    let place = |k: u8| 1.1 * (f32::from(k) / f32::from(POINTS) - 0.5);
    let [mut least, mut greatest] = [1.0_f32; 2];
    for (row, column) in (0..POINTS).flat_map(|row| (0..POINTS).map(move |column| (row, column))) {
        let target = Vec3A::new(place(column), place(row), 0.0);
        let Spectrum(values) = radiance(&mut integrator, target + Vec3A::new(0.3, -0.5, 1.0), target);
        least = values.into_iter().fold(least, f32::min);
        greatest = values.into_iter().fold(greatest, f32::max);
    }
    // Where the plane meets the snow, cells do not resolve the light. Elsewhere snow reflects 0.9 or more.
    assert!(least > 0.5 && greatest < 1.5, "{least} {greatest}");
}

#[test]
fn a_plane_of_snow_has_the_albedo_of_deep_snow() {
    let slab = Slab {
        sample: SnowSample::default(),
        // The light of 700 nm falls by e every 3 cm.
        thicknesses_cm: vec![300.0],
        incidences: vec![Incidence::Diffuse],
        wavelengths_nm: vec![450.0, 550.0, 700.0],
    };
    let known = solve(&slab, &OrdinatesOptions::default()).unwrap();
    for method in ["diffusion", "pcasnow", "reference"] {
        let mut integrator = field(method, &format!("{SKY}{}", shape("plane", "")));
        integrator.set_samples_per_pixel(64);
        let reflected = flux(&mut integrator, Vec3A::ZERO, 1.0);
        for (k, known) in known.iter().enumerate() {
            // Half a percent of the light that is absorbed by diffusion, and noise of 64 samples of a sky that is even.
            let error = reflected[k] / (std::f64::consts::PI * known.fluxes.reflectance.value) - 1.0;
            assert!(error.abs() < 2e-3, "{method}, {k}: {error}");
        }
    }
}

/// The integrators reflect light by the same law, at a low sun, where it is far from Lambert's.
#[test]
fn a_plane_of_snow_looks_the_same_by_all_integrators() {
    let sun = "[[light]]\ntype = \"directional\"\ndirection = [1, 0, -0.15]\nirradiance_w_m2 = 1\nilluminant = \"E\"\n";
    let mut integrators =
        ["diffusion", "reference"].map(|method| field(method, &format!("{sun}{}", shape("plane", ""))));
    let towards_sun = Vec3A::new(3.0, 0.0, 0.45);
    let [ahead, above] = [towards_sun, Vec3A::Z].map(|eye| {
        let [one, other] = integrators.each_mut().map(|integrator| radiance(integrator, eye, Vec3A::ZERO).0);
        for (one, other) in one.iter().zip(other) {
            assert!((one / other - 1.0).abs() < 1e-5, "{one} {other}");
        }
        one[5]
    });
    assert!(ahead > 3.0 * above, "{ahead} {above}");
}

/// A small image of a turned block that a lamp lights from behind.
fn backlit(method: &str, turn_deg: f64, settings: &str, seed: u32) -> Film {
    let (sin, cos) = turn_deg.to_radians().sin_cos();
    let turned = |x: f64, y: f64, z: f64| format!("[{}, {}, {z}]", cos * x - sin * y, sin * x + cos * y);
    let text = format!(
        "[camera]\nposition = {}\nlook_at = [0, 0, 0]\nvertical_fov_deg = 12\n\
         [film]\nwidth = 8\nheight = 8\n[integrator]\nmax_bounces = 0\nsamples_per_pixel = 64\nseed = {seed}\n\
         type = \"{method}\"\n{settings}\n\
         [[light]]\ntype = \"point\"\nposition = {}\nradiant_intensity_w_sr = 4\nilluminant = \"E\"\n{SNOW}{}",
        turned(0.3, -1.6, 0.4),
        turned(0.0, 0.6, 0.1),
        shape("box", &format!("size = [0.3, 0.06, 0.3]\nrotation_deg = [0, 0, {turn_deg}]"))
    );
    let scene = parsed(text).build(&FilesInMemory::default()).unwrap();
    render(&scene).unwrap().film
}

/// Means of 4×4 pixels.
fn cells(film: &Film) -> [f64; 4] {
    let mean = |cell: usize| {
        let (left, top) = (cell % 2 * 4, cell / 2 * 4);
        (0..16).map(|k| film.pixels()[(top + k / 4) * 8 + left + k % 4].y).sum::<f64>() / 16.0
    };
    [0, 1, 2, 3].map(mean)
}

#[test]
fn light_depends_neither_on_the_size_of_the_cells_nor_on_their_orientation() {
    let lit = |turn_deg: f64, step_mm: u32| {
        cells(&backlit("diffusion", turn_deg, &format!("[light_field]\nstep_mm = {step_mm}"), 1))
    };
    let known = lit(0.0, 6);
    for (turn_deg, step_mm) in [(0.0, 3), (30.0, 6), (77.0, 6)] {
        for (cell, known) in lit(turn_deg, step_mm).iter().zip(known) {
            assert!((cell / known - 1.0).abs() < 0.02, "{turn_deg}° {step_mm} mm: {cell} {known}");
        }
    }
}

/// A plain walk that ends inside or leaves has a standard deviation of its mean and more: 12 % after 64 samples.
#[test]
fn walks_have_little_noise_on_flat_faces() {
    let films = [1, 2, 3, 4].map(|seed| backlit("hybrid", 0.0, "filter = false", seed));
    let mut noise: Vec<f64> = Vec::new();
    for pixel in 0..64 {
        let values = films.each_ref().map(|film| film.pixels()[pixel].y);
        let mean = values.iter().sum::<f64>() / 4.0;
        if mean > 0.0 {
            noise.push((values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / 3.0).sqrt() / mean);
        }
    }
    noise.sort_by(f64::total_cmp);
    assert!(noise[noise.len() / 2] < 0.01, "{:?}", noise[noise.len() / 2]);
}

/// The light that a body sends into one direction under a lamp from another is that with both exchanged.
#[test]
fn lamp_and_camera_can_be_exchanged() {
    let directions = [Vec3A::new(0.8, -0.6, 0.0), Vec3A::new(0.36, 0.48, 0.8)];
    let lit = |method: &str, to_lamp: Vec3A, to_camera: Vec3A| {
        let text = format!(
            "[camera]\nposition = {:?}\nlook_at = [0, 0, 0]\nvertical_fov_deg = 0.35\n\
             [film]\nwidth = 24\nheight = 24\n[integrator]\nmax_bounces = 0\nsamples_per_pixel = 64\n\
             type = \"{method}\"\n[[light]]\ntype = \"directional\"\ndirection = {:?}\nirradiance_w_m2 = 1\n\
             illuminant = \"E\"\n{SNOW}{}",
            (to_camera * 20.0).to_array(),
            (-to_lamp).to_array(),
            shape("box", "size = [0.08, 0.03, 0.05]")
        );
        Integrator::prepare(&parsed(text).build(&FilesInMemory::default()).unwrap()).unwrap()
    };
    for (method, seeds) in [("diffusion", 4), ("hybrid", 6)] {
        let [there, back] = [[0, 1], [1, 0]].map(|[lamp, camera]| {
            let mut integrator = lit(method, directions[lamp], directions[camera]);
            let mut totals = Moments::default();
            for seed in 1..=seeds {
                integrator.set_seed(seed);
                totals.push(render_all(&integrator, &|_| {}).film.pixels().iter().map(|xyz| xyz.y).sum());
            }
            totals
        });
        // Diffusion errs by 2 % at the edges of so small a block. The rest is noise: at edges, light that a grain
        // scatters forwards is found rarely.
        let error = there.standard_error().hypot(back.standard_error());
        let difference = (there.mean() - back.mean()).abs();
        assert!(difference < 0.02 * back.mean() + 3.0 * error, "{method}: {there:?} {back:?}");
        assert!(error < 0.02 * back.mean(), "{method}: {error}");
    }
}

/// The number of nodes of the only body of a scene.
fn node_count(settings: &str) -> Result<usize, String> {
    let text = format!(
        "{}[light_field]\n{settings}\n{SNOW}{SKY}{}",
        "[camera]\nposition = [0, -9, 0]\nlook_at = [0, 0, 0]\n[integrator]\ntype = \"diffusion\"\n",
        shape("box", "size = [0.3, 0.3, 0.1]")
    );
    let file = SceneFile::parse(text, Path::new("block.toml")).map_err(|error| error.to_string())?;
    let scene = file.build().map_err(|error| error.to_string())?;
    let integrator = Integrator::prepare(&scene).map_err(|error| error.located(&file).to_string())?;
    Ok(integrator.light_field().unwrap().statistics().nodes)
}

#[test]
fn the_size_of_cells_and_the_memory_can_be_set() {
    let [coarse, fine] = ["step_mm = 20", "step_mm = 12"].map(|settings| node_count(settings).unwrap());
    // The surface has most nodes, (20/12)² = 2.8 times as many.
    assert!(fine > 2 * coarse && fine < 5 * coarse, "{coarse} {fine}");
    let too_fine = node_count("step_mm = 0.5\nmemory_mib = 64").unwrap_err();
    let too_coarse = node_count("step_mm = 400").unwrap_err();
    assert!(too_fine.contains("\"box\" has cells of 0.5 mm, but only cells of at least "), "{too_fine}");
    assert!(too_fine.contains(" mm fit into 64 MiB"), "{too_fine}");
    assert!(too_coarse.contains("\"box\" has cells of 400 mm, but its snow needs cells of at most "), "{too_coarse}");
    for message in [too_fine, too_coarse] {
        assert!(message.starts_with("block.toml:") && !message.contains('\n'), "{message}");
    }
}

/// A lamp in the middle of a ball sends out through the surface what the snow does not absorb: by diffusion,
/// J = D φ′ with φ = A sinh(κ_e r)/r + φ₀. In blue light hardly any is lost: 4π I = 4π R² J.
#[test]
fn a_lamp_in_the_middle_of_a_ball_shines_through() {
    for (method, samples) in [("diffusion", 1), ("hybrid", 512)] {
        let lamp =
            "[[light]]\ntype = \"point\"\nposition = [0, 0, 0]\nradiant_intensity_w_sr = 1\nilluminant = \"E\"\n";
        let mut integrator = field(method, &format!("{lamp}{}", shape("sphere", "radius = 0.05")));
        integrator.set_samples_per_pixel(samples);
        let intensity = f64::from(integrator.scene().lights()[0].strength().0[0]);
        // The flux through the surface is the mean of π L over the projected area of the ball, from anywhere.
        let (mut sum, count) = (0.0, 64);
        for k in 0..count {
            let (radius, turn) = (0.05 * ((f64::from(k) + 0.5) / f64::from(count)).sqrt(), 2.4 * f64::from(k));
            let at = Vec3A::new((radius * turn.cos()) as f32, 0.0, (radius * turn.sin()) as f32);
            let forward = Vec3A::new(0.0, 1.0, 0.0);
            sum += f64::from(radiance(&mut integrator, at - forward * 2.0, at).0[0]) / f64::from(count);
        }
        // Absorption at 400 nm in 5 cm of snow is below 0.1 %; the rest is the grid, and at most 2 % of noise.
        let ratio = sum * std::f64::consts::PI * 0.05_f64.powi(2) / intensity;
        assert!((ratio - 1.0).abs() < 0.04, "{method}: {ratio}");
    }
}

/// The light beside a sphere that is half inside a block does not break down where its middle leaves the snow: what it
/// sends into the snow stays a source inside. Of the light by the reference, rings around it have 1.13 with the middle
/// 1 mm below the surface, 0.75 with the middle 1 mm above, and would have 0.4 without that source.
#[test]
fn a_sphere_half_in_snow_shines_with_its_middle_above_the_surface_too() {
    let beside = |height_m: f64| {
        let lamp = format!(
            "[[light]]\ntype = \"sphere\"\nposition = [0, 0, {height_m}]\nradius = 0.04\nradiance_w_m2_sr = 1\n\
             illuminant = \"E\"\n"
        );
        let body = shape("box", "size = [0.6, 0.6, 0.2]\nposition = [0, 0, -0.1]");
        let mut integrator = field("hybrid", &format!("{lamp}{body}"));
        integrator.set_samples_per_pixel(256);
        // Rings around the lamp, seen from above.
        let places = (0..48).map(|k| {
            let (radius, turn) = (0.045 + 0.002 * f64::from(k), 2.4 * f64::from(k));
            (radius, Vec3A::new((radius * turn.cos()) as f32, (radius * turn.sin()) as f32, 0.0))
        });
        let weighted =
            places.map(|(radius, at)| radius * f64::from(radiance(&mut integrator, at + Vec3A::Z, at).0[15]));
        weighted.sum::<f64>()
    };
    let ratio = beside(0.001) / beside(-0.001);
    assert!((0.58..0.75).contains(&ratio), "{ratio}");
}

/// Two lamps of different spectra give the sum of both, at every wavelength.
#[test]
fn lamps_of_different_spectra_add_up() {
    let lamp = |illuminant: &str, at: &str| {
        format!(
            "[[light]]\ntype = \"point\"\nposition = [{at}]\nradiant_intensity_w_sr = 1\n\
             illuminant = \"{illuminant}\"\n"
        )
    };
    let (blue, sky) = (lamp("LED-B5", "0, 0.3, 0"), lamp("A", "0.2, 0.4, 0.1"));
    let behind = |lamps: &str| {
        let body = shape("box", "size = [0.2, 0.1, 0.2]");
        radiance(&mut field("diffusion", &format!("{lamps}{body}")), Vec3A::NEG_Y, Vec3A::NEG_Y * 0.05)
    };
    let (one, other, both) = (behind(&blue), behind(&sky), behind(&format!("{blue}{sky}")));
    for k in 0..31 {
        let sum = one.0[k] + other.0[k];
        assert!((both.0[k] / sum - 1.0).abs() < 1e-4, "{k}: {} {sum}", both.0[k]);
    }
}

#[test]
fn what_the_field_cannot_do_is_named() {
    let error = |text: &str| {
        let scene = scene_by("hybrid", &format!("{SNOW}{text}"), &[]);
        Integrator::prepare(&scene).unwrap_err().to_string()
    };
    let lamp = "[[light]]\ntype = \"spot\"\nposition = [0, 0, 0]\nlook_at = [0, 0, 1]\nradiant_intensity_w_sr = 1\n";
    let inside = error(&format!("{lamp}{}", shape("sphere", "radius = 0.1")));
    assert!(inside.contains("light[0] lies inside the snow"), "{inside}");
    let fine = "[light_field]\nstep_mm = 5\n";
    let huge = error(&format!("{fine}{SKY}{}", shape("box", "size = [1000, 1000, 1000]\nposition = [0, 0, 600]")));
    assert!(huge.contains("MiB") && huge.contains("mm"), "{huge}");
}

/// Luminances of the pixels of a scene with or without the filter, by samples per pixel and seed.
fn luminances(text: &str) -> impl FnMut(bool, [u32; 2]) -> Vec<f64> + use<> {
    let mut integrators = [false, true].map(|filter| {
        let text = text.replace("[integrator]\n", &format!("[integrator]\nfilter = {filter}\n"));
        let scene = parsed(text).build(&FilesInMemory::default()).unwrap();
        let preparation = Preparation { views: Some(Views::Camera), ..Preparation::default() };
        Integrator::prepare_with(&scene, preparation).unwrap()
    });
    move |is_filtered, [samples, seed]| {
        let integrator = &mut integrators[usize::from(is_filtered)];
        integrator.set_samples_per_pixel(samples);
        integrator.set_seed(seed);
        render_all(integrator, &|_| {}).film.pixels().iter().map(|pixel| pixel.y).collect()
    }
}

/// At few samples, the filter leaves a fraction of the noise of random walks and of samples of a sky, and takes no
/// light away.
#[test]
fn filtered_pictures_have_less_noise_and_the_same_light() {
    const LAMP: &str = "[[light]]\ntype = \"point\"\nposition = [0.5, -1, 0.5]\nradiant_intensity_w_sr = 5\n";
    // The sun stands behind: the camera sees snow in the light of the sky.
    const CLEAR: &str = "[sky]\nsun = { elevation_deg = 30, azimuth_deg = 60 }\nturbidity = 3\n";
    for (method, light, least_gain) in [("hybrid", LAMP, 2.5), ("hybrid", CLEAR, 4.0), ("diffusion", CLEAR, 2.0)] {
        let mut luminances = luminances(&format!(
            "[camera]\nposition = [0, -2, 0.6]\nlook_at = [0, 0, 0]\nvertical_fov_deg = 3.2\n\
             [film]\nwidth = 32\nheight = 32\n[integrator]\ntype = \"{method}\"\n{SNOW}{}{light}",
            shape("sphere", "radius = 0.05")
        ));
        let truth = luminances(false, [384, 2]);
        let error = |picture: &[f64]| -> f64 {
            picture.iter().zip(&truth).map(|(value, truth)| (value - truth).powi(2)).sum::<f64>().sqrt()
        };
        let filtered = [1, 2, 3, 4].map(|seed| luminances(true, [8, seed]));
        // The noise of the truth is an eighth of that of 8 samples.
        let gain = error(&luminances(false, [8, 1])) / error(&filtered[0]);
        assert!(gain > least_gain, "{method}, {light}: {gain}");
        let light_of = |picture: &Vec<f64>| picture.iter().sum::<f64>();
        let ratio = filtered.iter().map(light_of).sum::<f64>() / 4.0 / light_of(&truth);
        // Pictures by walks of 8 samples deviate by up to 2 %, their mean by 1 %.
        assert!((ratio - 1.0).abs() < 0.02, "{method}, {light}: {ratio}");
    }
}

/// A block of snow and a box on a floor or on a plain of snow under the sun and the sky: with few samples the filter
/// leaves a fraction of the noise of floors, and as much light.
#[test]
fn floors_and_plains_have_less_noise_and_the_same_light() {
    const CUBE: &str = "[[object]]\nshape = \"box\"\nmaterial = \"floor\"\nsize = [0.06, 0.06, 0.06]\n\
                        position = [0.15, -0.1, 0.03]\n";
    const SKY: &str = "[sky]\nsun = { elevation_deg = 30, azimuth_deg = 60 }\nturbidity = 3\n";
    let block = shape("box", "size = [0.16, 0.08, 0.2]\nposition = [0, 0, 0.1]");
    let content = format!("{block}[material.floor]\ntype = \"diffuse\"\nreflectance = 0.4\n{CUBE}{SKY}");
    for (method, floor, least_gain) in [("hybrid", "floor", 2.0), ("hybrid", "snow", 2.0), ("diffusion", "floor", 2.0)]
    {
        let mut picture = luminances(&format!(
            "[camera]\nposition = [0.5, -0.9, 0.35]\nlook_at = [0, 0, 0.05]\nvertical_fov_deg = 28\n\
             [film]\nwidth = 40\nheight = 30\n[integrator]\ntype = \"{method}\"\n{SNOW}{content}\
             [[object]]\nshape = \"plane\"\nmaterial = \"{floor}\"\n"
        ));
        let truth = picture(false, [128, 2]);
        // The upper part shows the floor alone, up to the horizon.
        let error = |picture: &[f64]| -> f64 {
            let pixels = picture.iter().zip(&truth).take(40 * 6);
            pixels.map(|(value, truth)| (value / truth - 1.0).powi(2)).sum::<f64>().sqrt()
        };
        let filtered = picture(true, [8, 1]);
        let gain = error(&picture(false, [8, 1])) / error(&filtered);
        assert!(gain > least_gain, "{method} on {floor}: {gain}");
        let ratio = filtered.iter().sum::<f64>() / truth.iter().sum::<f64>();
        // Of 1,200 pixels with a noise of some 10 % each.
        assert!((ratio - 1.0).abs() < 0.01, "{method} on {floor}: {ratio}");
    }
}

/// In thick snow of wide cells, light that enters at a point decreases the light from inside there, also the light of a
/// sky. The place where a wedge is thick enough does not show.
#[test]
fn the_light_of_a_sky_on_a_wedge_has_no_step() {
    const WIDTH: usize = 80;
    let mut picture = luminances(&format!(
        "[camera]\nposition = [0, -0.2, 6]\nlook_at = [0, 0, 0.15]\nvertical_fov_deg = 3\n\
         [film]\nwidth = {WIDTH}\nheight = 20\n[integrator]\n[light_field]\nstep_mm = 60\n\
         [sky]\ntype = \"overcast\"\nirradiance_w_m2 = 100\n{SNOW}{}",
        shape("heights", "heights = [[0, 1], [0, 1]]\nsize = [2, 2, 0.3]\nbottom = -0.1")
    ));
    let light = picture(true, [4, 1]);
    let column = |x: usize| light.iter().skip(x).step_by(WIDTH).sum::<f64>();
    let step = (1..WIDTH).map(|x| (column(x) / column(x - 1) - 1.0).abs()).fold(0.0, f64::max);
    assert!(step < 0.02, "{step}");
}

/// With few samples no pixel of snow is a black dot among the snow around it, and the light is that of the walks.
#[test]
fn pictures_of_few_samples_have_no_black_dots() {
    const SIDE: usize = 112;
    let lamp = |position: [f64; 3]| {
        format!("[[light]]\ntype = \"point\"\nposition = {position:?}\nradiant_intensity_w_sr = 10\n")
    };
    let boxes = shape("box", "size = [0.08, 0.03, 0.04]\nposition = [0, 0.01, -0.02]")
        + &shape("box", "size = [0.02, 0.02, 0.05]\nposition = [0.02, -0.03, 0.01]")
        + &lamp([0.3, -0.5, 0.4]);
    let ball = shape("sphere", "radius = 0.05") + &lamp([0.05, 0.4, 0.1]);
    for (content, position) in [(boxes, [0.42, -1.4, 0.7]), (ball, [0.0, -1.1, 0.33])] {
        let mut picture = luminances(&format!(
            "[camera]\nposition = {position:?}\nlook_at = [0, 0, 0]\nvertical_fov_deg = 6\n\
             [film]\nwidth = {SIDE}\nheight = {SIDE}\n[integrator]\n{SNOW}{content}"
        ));
        let raw = picture(false, [32, 2]);
        for samples in [4, 8, 16] {
            let filtered = picture(true, [samples, 1]);
            let around =
                |pixel: usize| [1, SIDE - 1, SIDE, SIDE + 1].into_iter().flat_map(move |k| [pixel - k, pixel + k]);
            for pixel in (1..SIDE - 1).flat_map(|row| (1..SIDE - 1).map(move |column| SIDE * row + column)) {
                // Pixels whose neighbours all show snow. Silhouettes are noisy by what they cover.
                if raw[pixel].min(around(pixel).map(|other| raw[other]).fold(f64::INFINITY, f64::min)) > 0.0 {
                    let mut others: Vec<f64> = around(pixel).map(|other| filtered[other]).collect();
                    others.sort_by(f64::total_cmp);
                    let ratio = 2.0 * filtered[pixel] / (others[3] + others[4]);
                    assert!(ratio > 0.1, "{samples} samples, pixel {pixel}: {ratio} of the median around it");
                }
            }
            let [light, truth] = [&filtered, &raw].map(|picture| picture.iter().sum::<f64>());
            // Pixels of walks deviate by some 60 % after 4 samples: 3,000 of them by 1 %.
            assert!((light / truth - 1.0).abs() < 0.03, "{samples} samples: {light} of {truth}");
        }
    }
}
