//! Comparison of draws with their densities, and of irradiances with closed forms.

#![expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bins of a histogram")]

use std::f64::consts::{PI, TAU};
use std::sync::{Arc, LazyLock};

use glam::Vec3A;
use snowblue_color::LinearRgb;
use snowblue_geometry::ray::{Ray, SurfacePoint};
use snowblue_sky::{ClearSky, SUN_RADIUS_RAD, WAVELENGTHS_NM};
use snowblue_stat::{Moments, chi_squared_p_value, sidak_level, z_p_value};
use snowblue_transport::PhaseFunction;
use snowblue_transport::ordinates::HalfSpace;

use super::dome::{ClearRadiance, Resampling, SkyDome};
use super::emitter::Emitter;
use super::image::SkyImage;
use super::rectangle::{RectangleLight, RectangleLightDescription};
use super::sphere::SphereLight;
use super::sun::SunDisc;
use super::techniques::SamplingTechnique;
use super::*;
use crate::directions::{Directions, ReflectionTable};
use crate::sampling::{Sampler, cosine_direction};
use crate::spectrum::Spectrum;
use crate::spectrum::light_spectrum::LightSpectrum;
use snowblue_base::{KeyPath, Number, Numbers, narrow};

/// Approximate probability that a test function fails by chance.
const LEVEL: f64 = 1e-3;

/// Independent numbers: pixels have scrambles of their own.
fn sampler(seed: u32, draw: u32) -> Sampler {
    Sampler::new(seed, draw, 0)
}

fn numbers(seed: u32, draw: u32) -> [f32; 2] {
    let [u, v, ..] = sampler(seed, draw).next_four();
    [u, v]
}

fn place() -> SurfacePoint {
    SurfacePoint { point: Vec3A::new(0.1, -0.2, 0.0), normal: Vec3A::new(0.36, 0.48, 0.8) }
}

/// A sphere of radiance 1.
fn sphere(centre: Vec3A, radius_m: f32) -> SphereLight {
    SphereLight { centre, radius_m, emission: Spectrum::ONE }
}

/// A rectangle of radiance 1 with a centre, the point that it faces, and its size.
fn rectangle(centre: Vec3A, look_at: Vec3A, up: Vec3A, size: [f64; 2]) -> RectangleLight {
    let [position, look_at, up] = [centre, look_at, up].map(|place| place.as_dvec3().to_array());
    let keys = RectangleLightDescription {
        position: Numbers::of(position),
        look_at: Numbers::of(look_at),
        up: Numbers::of(up),
        size: Numbers::of(size),
        radiance_w_m2_sr: Number::of(1.0),
        visible: true,
    };
    RectangleLight::new(&keys, &LightSpectrum::EQUAL_ENERGY).unwrap()
}

fn ball() -> Light {
    Light::new(sphere(Vec3A::new(0.4, 0.5, 0.9), 0.6))
}

fn panel() -> Light {
    Light::new(rectangle(Vec3A::new(0.3, 0.4, 0.7), Vec3A::new(0.2, 0.1, 0.0), Vec3A::Z, [1.6, 0.7]))
}

/// A coarse sky with a dark half, bright spots and a seam.
fn image() -> Light {
    let value = |k: u32| if k % 8 > 5 { 0.0 } else { f64::from(k * 37 % 11) };
    let pixels = (0..32).map(|k| LinearRgb { r: value(k), g: value(k), b: value(k) }).collect();
    let panorama = Panorama { width: 8, height: 4, pixels };
    Light::new(SkyImage::new(&panorama, 0.1, 70.0).unwrap())
}

/// A clear sky with its sun at 20° in the south-west.
fn clear_sky() -> (ClearSky, Vec3A) {
    let (elevation, azimuth) = (20f64.to_radians(), 230f64.to_radians());
    let to_sun = glam::DVec3::new(elevation.cos() * azimuth.sin(), elevation.cos() * azimuth.cos(), elevation.sin());
    (ClearSky::new(20.0, 2.5, &[0.8; WAVELENGTHS_NM.len()]).unwrap(), to_sun.as_vec3a())
}

fn dome() -> Light {
    let (sky, to_sun) = clear_sky();
    let resampling = Resampling::new(1.0);
    Light::new(SkyDome::clear(Arc::new(ClearRadiance { sky, to_sun, resampling })).unwrap())
}

fn sun() -> Light {
    let (sky, to_sun) = clear_sky();
    Light::new(SunDisc::new(&sky, to_sun, &Resampling::new(1.0)))
}

/// The density per sr of a technique in a direction from the place; 0 where the direction misses the light.
fn density_per_sr(light: &Light, technique: &SamplingTechnique, direction: Vec3A) -> f64 {
    let ray = Ray::new(place().point, direction);
    let origin = light.origin_on(&ray, f32::INFINITY);
    origin.map_or(0.0, |origin| {
        f64::from(light.density(technique, &origin)) * f64::from(origin.area_per_solid_angle(ray.origin))
    })
}

/// Directions drawn by the reflection of snow towards a viewer who sees the place at a cosine.
fn reflected(cos_exit: f32) -> SamplingTechnique<'static> {
    static TABLE: LazyLock<ReflectionTable> =
        LazyLock::new(|| ReflectionTable::new(&HalfSpace::new(&PhaseFunction::henyey_greenstein(0.8))));
    let normal = place().normal;
    let to_viewer = normal * cos_exit + normal.any_orthonormal_vector() * (1.0 - cos_exit * cos_exit).sqrt();
    SamplingTechnique::OfSurface(Directions::Reflected(TABLE.at(place(), -to_viewer)))
}

fn techniques() -> [(&'static str, Light, SamplingTechnique<'static>); 8] {
    [
        ("reflected, grazing", image(), reflected(0.1)),
        ("reflected, steep", image(), reflected(0.8)),
        ("ball", ball(), SamplingTechnique::OfLight(place().point)),
        ("panel", panel(), SamplingTechnique::OfLight(place().point)),
        ("cosine", image(), SamplingTechnique::OfSurface(Directions::Cosine(place()))),
        ("hemisphere", image(), SamplingTechnique::OfSurface(Directions::Hemisphere(place()))),
        ("image", image(), SamplingTechnique::OfLight(place().point)),
        ("dome", dome(), SamplingTechnique::OfLight(place().point)),
    ]
}

#[test]
fn irradiance_falls_with_the_square_of_the_distance_and_the_cosine() {
    let source = LightSource::Point(PointLightDescription {
        position: Numbers::of([0.0, 0.0, 2.0]),
        radiant_intensity_w_sr: Number::of(40.0),
    });
    let lamp = source.keys().light(&KeyPath::default(), &LightSpectrum::EQUAL_ENERGY).unwrap();
    assert!((lamp.strength().mean() - 40.0).abs() < 1e-4);
    let sample = lamp.delta_sample().unwrap();
    let above = sample.incident_at(&SurfacePoint { point: Vec3A::ZERO, normal: Vec3A::Z }).unwrap();
    assert!((above.irradiance_per_power - 0.25).abs() < 1e-6);
    let aside = sample.incident_at(&SurfacePoint { point: Vec3A::new(2.0, 0.0, 0.0), normal: Vec3A::Z }).unwrap();
    assert!((aside.cos_incidence - 0.5f32.sqrt()).abs() < 1e-6);
    assert!((aside.irradiance_per_power - 0.5f32.sqrt() / 8.0).abs() < 1e-6);
    assert!(sample.incident_at(&SurfacePoint { point: Vec3A::ZERO, normal: Vec3A::NEG_Z }).is_none());
}

/// The closed form is the mean over samples of the disc, and agrees with the model, where the lower half of the disc is
/// a little dimmer.
#[test]
fn the_irradiance_by_the_sun_is_that_of_its_disc() {
    const DRAWS: u32 = 4096;
    let (sky, to_sun) = clear_sky();
    let (light, facing) = (sun(), SurfacePoint { point: Vec3A::ZERO, normal: to_sun });
    let mut sampled = Spectrum::ZERO;
    for draw in 0..DRAWS {
        let sample = light.small_sample(&mut Sampler::new(7, 0, draw)).unwrap();
        let incident = sample.incident_at(&facing).unwrap();
        sampled += light.power(&sample.origin) * (incident.irradiance_per_power / DRAWS as f32);
    }
    let irradiance = light.strength();
    for (index, wavelength_nm) in [(0, 400.0), (15, 550.0), (30, 700.0)] {
        let value = f64::from(irradiance.0[index]);
        assert!(
            (f64::from(sampled.0[index]) / value - 1.0).abs() < 3e-3,
            "{wavelength_nm}: {value} {}",
            sampled.0[index]
        );
        // A band density is a quantity per nm times 310 nm.
        let model = 310.0 * sky.sun_irradiance(wavelength_nm);
        assert!((model / value - 1.0).abs() < 5e-3, "{wavelength_nm}: {value} {model}");
    }
}

#[test]
fn directions_are_drawn_with_their_density() {
    const BINS: (usize, usize) = (12, 24);
    const WITHIN: usize = 40;
    const DRAWS: u32 = 100_000;
    for (name, light, technique) in techniques() {
        let mut expected = vec![0.0; BINS.0 * BINS.1];
        let (down, around) = (BINS.0 * WITHIN, BINS.1 * WITHIN);
        for (row, column) in (0..down).flat_map(|row| (0..around).map(move |column| (row, column))) {
            let z = 1.0 - 2.0 * (row as f64 + 0.5) / down as f64;
            let (sin, cos) = (TAU * (column as f64 + 0.5) / around as f64).sin_cos();
            let radius = (1.0 - z * z).sqrt();
            let direction = Vec3A::new(narrow(radius * cos), narrow(radius * sin), narrow(z));
            expected[row / WITHIN * BINS.1 + column / WITHIN] +=
                density_per_sr(&light, &technique, direction) * 4.0 * PI / (down * around) as f64;
        }
        // The edge of a lamp goes through some 1,000 of 460,800 cells of 2.7e-5 sr, half in and half out by chance.
        let total: f64 = expected.iter().sum();
        assert!((total - 1.0).abs() < 3e-3, "{name}: the density adds up to {total}");
        let mut found = vec![0u32; BINS.0 * BINS.1];
        for draw in 0..DRAWS {
            let origin = light.sample_origin(&technique, numbers(5, draw)).unwrap();
            let direction = origin.direction_from(place().point).direction;
            let turn = f64::from(direction.y).atan2(f64::from(direction.x)).rem_euclid(TAU) / TAU;
            let row = ((0.5 - 0.5 * f64::from(direction.z)) * BINS.0 as f64) as usize;
            let column = (turn * BINS.1 as f64) as usize;
            found[row.min(BINS.0 - 1) * BINS.1 + column.min(BINS.1 - 1)] += 1;
        }
        let (mut chi_squared, mut bins, mut rare, mut rare_found) = (0.0, 0.0, 0.0, 0u32);
        for (share, &count) in expected.iter().zip(&found) {
            let mean = share * f64::from(DRAWS);
            if mean < 20.0 {
                (rare, rare_found) = (rare + mean, rare_found + count);
                continue;
            }
            (chi_squared, bins) = (chi_squared + (f64::from(count) - mean).powi(2) / mean, bins + 1.0);
        }
        assert!(f64::from(rare_found) < rare + 6.0 * rare.sqrt() + 6.0, "{name}: {rare_found} for {rare}");
        let p = chi_squared_p_value(chi_squared, bins - 1.0);
        assert!(p > sidak_level(LEVEL, 8), "{name}: χ² = {chi_squared} in {bins} bins, p = {p}");
    }
}

/// With a constant density in each pixel, weights are up to ½ / ⅛ = 4 times the mean beside the edges of the sun, and
/// ¼ / ¹⁄₆₄ = 16 times the mean beside its corners.
#[test]
fn samples_of_an_image_with_a_small_sun_weigh_alike() {
    let value = |k: usize| if (30..33).contains(&(k / 256)) && (100..103).contains(&(k % 256)) { 1e4 } else { 1.0 };
    let pixels = (0..256 * 128).map(|k| LinearRgb { r: value(k), g: value(k), b: value(k) }).collect();
    let sky = SkyImage::new(&Panorama { width: 256, height: 128, pixels }, 1.0, 70.0).unwrap();
    let weight = |draw: u32| {
        let origin = sky.sample_li(place().point, numbers(11, draw)).unwrap();
        LightSpectrum::luminance(&sky.le(&origin)) / sky.pdf_li(place().point, &origin)
    };
    let weights: Vec<f32> = (0..10_000).map(weight).collect();
    let mean = weights.iter().sum::<f32>() / weights.len() as f32;
    // Interpolation is linear in the polar angle, and the density is linear in its cosine. Within rows of 1.4° at 45°
    // from the zenith, the difference is 1.2 % where the light falls to nothing. Near the poles single precision adds
    // some percent.
    let unlike = weights.iter().filter(|weight| (*weight / mean - 1.0).abs() > 0.02).count();
    assert!(unlike < weights.len() / 500, "{unlike}");
}

/// Irradiance E of a plane under a sphere that is fully above the plane: π L sin²α cos θ.
fn irradiance_of_ball(at: &SurfacePoint, centre: Vec3A, radius_m: f32) -> f64 {
    let way = (centre - at.point).as_dvec3();
    PI * f64::from(radius_m).powi(2) / way.length_squared() * way.normalize().dot(at.normal.as_dvec3())
}

/// E under a polygon above the plane (Lambert 1760): L/2 Σ Γ · n, Γ the angle of an edge along the normal of its plane.
fn irradiance_of_polygon(at: &SurfacePoint, corners: [Vec3A; 4]) -> f64 {
    let ways = corners.map(|corner| (corner - at.point).as_dvec3().normalize());
    let edge = |k: usize| {
        let (one, next) = (ways[k], ways[(k + 1) % 4]);
        one.dot(next).acos() * one.cross(next).normalize().dot(at.normal.as_dvec3())
    };
    0.5 * (0..4).map(edge).sum::<f64>().abs()
}

#[test]
fn each_way_and_both_together_meet_the_closed_forms() {
    let at = SurfacePoint { point: Vec3A::new(0.1, -0.2, 0.0), normal: Vec3A::Z };
    let (centre, radius_m) = (Vec3A::new(0.4, 0.5, 0.9), 0.6);
    let middle = Vec3A::new(0.3, 0.4, 0.7);
    let corners = [(-0.8, -0.35), (0.8, -0.35), (0.8, 0.35), (-0.8, 0.35)];
    let corners = corners.map(|(x, y)| middle + Vec3A::new(x, y, 0.0));
    let panel = rectangle(middle, middle.with_z(0.0), Vec3A::Y, [1.6, 0.7]);
    let cases = [
        (Light::new(sphere(centre, radius_m)), irradiance_of_ball(&at, centre, radius_m)),
        (Light::new(panel), irradiance_of_polygon(&at, corners)),
    ];
    for (light, expected) in cases {
        let by_cosine = Directions::Cosine(at);
        let alone = [Some(SamplingTechnique::OfLight(at.point)), None, None];
        let irradiance = |sample: Option<LightSample>| {
            let of = |sample: LightSample| {
                Some(sample.incident_at(&at)?.irradiance_per_power * light.power(&sample.origin).0[0])
            };
            sample.and_then(of).unwrap_or(0.0)
        };
        let mut ways = [Moments::default(); 3];
        for draw in 0..20_000 {
            let [u, v] = numbers(7, draw);
            let ray = Ray::new(at.point, cosine_direction(at.normal, u, v));
            let hit = |from| f64::from(light.hit_radiance(&ray, f32::INFINITY, from).map_or(0.0, |hit| hit.0[0])) * PI;
            ways[0].push(f64::from(irradiance(light.sample(0, &alone, &mut sampler(8, draw)))));
            ways[1].push(hit(None));
            let sampled = light.sample_for_reflection(&by_cosine, &mut sampler(8, draw));
            ways[2].push(f64::from(irradiance(sampled)) + hit(Some(&by_cosine)));
        }
        for way in ways {
            let p = z_p_value((way.mean() - expected) / way.standard_error());
            assert!(p > sidak_level(LEVEL, 6), "{} ± {} for {expected}", way.mean(), way.standard_error());
        }
        assert!(ways[2].variance() < ways[1].variance(), "together they are better than the cosine alone");
    }
}

#[test]
fn a_small_far_rectangle_is_drawn_by_area_as_it_is_by_solid_angle() {
    // 2e-4 m² over r² = 4 m² and, below the limit of solid angles, over 4e6 m².
    for distance_m in [2.0, 2000.0] {
        let patch = rectangle(Vec3A::new(0.0, 0.0, distance_m), Vec3A::ZERO, Vec3A::Y, [0.02, 0.01]);
        let origin = patch.sample_li(Vec3A::ZERO, [0.3, 0.6]).unwrap();
        let density = patch.pdf_li(Vec3A::ZERO, &origin);
        let expected = distance_m * distance_m / 2e-4;
        assert!((density / expected - 1.0).abs() < 1e-4, "{density} for {expected}");
    }
}

#[test]
fn the_sky_image_is_upright_and_seen_from_within() {
    let mut pixels = vec![LinearRgb::default(); 32];
    // Second row from the top, right of the middle.
    pixels[8 + 5] = LinearRgb { r: 1.0, g: 1.0, b: 1.0 };
    let panorama = Panorama { width: 8, height: 4, pixels };
    let brightest = |rotation_deg: f32| {
        let image = SkyImage::new(&panorama, 1.0, rotation_deg).unwrap();
        let looks = (0..16).map(|k| {
            let turn = narrow(TAU) * (k as f32 + 0.5) / 16.0;
            Vec3A::new(turn.cos(), turn.sin(), 0.41).normalize()
        });
        let radiance = |look: &Vec3A| image.le(&LightOrigin::Distant(*look)).0[0];
        looks.max_by(|a, b| radiance(a).total_cmp(&radiance(b))).unwrap()
    };
    let seen = brightest(0.0);
    assert!(seen.y > 0.0 && seen.x > 0.0, "right of +y, seen from within, is +x: {seen}");
    let turned = brightest(90.0);
    assert!(turned.x < 0.0 && turned.y > 0.0, "a quarter turn brings +x to +y: {turned}");
    // Pixels that single precision could not sum are refused.
    let refused = SkyImage::new(&panorama, 2e12, 0.0).unwrap_err();
    assert_eq!(refused, "pixel 5, 1 is 2.0e12 with its scale, but must be at most 1e12; `max_radiance` limits it");
}

#[test]
fn a_lamp_at_the_surface_shines_no_more_than_its_radiance() {
    let at = SurfacePoint { point: Vec3A::ZERO, normal: Vec3A::Z };
    for gap_m in [1e-4, 1e-2, 1.0] {
        let light = Light::new(sphere(Vec3A::new(0.0, 0.0, 0.1 + gap_m), 0.1));
        let from = SurfacePoint { point: Vec3A::new(0.0, 0.0, -0.3), normal: Vec3A::Z };
        let lines = [Some(SamplingTechnique::OfLight(from.point)), None, None];
        let mut mean = Moments::default();
        for draw in 0..4_000 {
            let sample = light.sample(0, &lines, &mut sampler(3, draw)).unwrap();
            let way = sample.origin.direction_from(from.point).direction;
            let exit = SurfacePoint { point: from.point + way * (0.3 / way.z), ..at };
            mean.push(
                sample.incident_along_line(&exit).map_or(0.0, |incident| f64::from(incident.irradiance_per_power)),
            );
        }
        assert!(mean.mean() < PI, "{} at {gap_m} m", mean.mean());
        assert!(mean.standard_error() < 0.02 * mean.mean(), "{mean:?}");
    }
}

#[test]
fn the_sun_is_sampled_with_its_density_and_gives_its_irradiance() {
    let light = sun();
    let to_sun = clear_sky().1.as_dvec3();
    let technique = SamplingTechnique::OfLight(Vec3A::ZERO);
    // Midpoint rule in sin² of the angle to the centre: equal steps in sin² have equal solid angles everywhere.
    const RINGS: u32 = 4_000;
    let sin_squared = SUN_RADIUS_RAD.sin().powi(2);
    let (side, _) = to_sun.any_orthonormal_pair();
    let ring_sr = PI * sin_squared / f64::from(RINGS);
    let (mut total, mut irradiance) = (0.0, 0.0);
    for ring in 0..RINGS {
        let sin = ((f64::from(ring) + 0.5) / f64::from(RINGS) * sin_squared).sqrt();
        let direction = (to_sun * (1.0 - sin * sin).sqrt() + side * sin).as_vec3a();
        let origin = LightOrigin::Distant(direction);
        total += f64::from(light.density(&technique, &origin)) * ring_sr;
        irradiance += f64::from(light.power(&origin).0[15]) * ring_sr;
    }
    // Single precision of directions moves them by 10⁻⁷ of 5·10⁻³ rad.
    assert!((total - 1.0).abs() < 1e-3, "{total}");
    // The radiance is everywhere the radiance at the elevation of the centre, and its profile is linear between 32
    // steps.
    let expected = 310.0 * clear_sky().0.sun_irradiance(550.0);
    assert!((irradiance / expected - 1.0).abs() < 1e-3, "{irradiance} for {expected}");
    // The mean over samples is the same, with little noise: the density follows the radiance.
    let mut mean = Moments::default();
    let mut inner = 0;
    for draw in 0..2_000 {
        let origin = light.sample_origin(&technique, numbers(11, draw)).unwrap();
        let LightOrigin::Distant(direction) = origin else { panic!("the sun is a distant light") };
        let sin = direction.as_dvec3().cross(to_sun).length();
        assert!(sin < SUN_RADIUS_RAD * 1.001, "{sin}");
        inner += u32::from(sin < 0.5 * SUN_RADIUS_RAD);
        mean.push(f64::from(light.power(&origin).0[15] / light.density(&technique, &origin)));
    }
    assert!((mean.mean() / expected - 1.0).abs() < 3e-3, "{} for {expected}", mean.mean());
    assert!(mean.variance().sqrt() < 0.05 * mean.mean(), "{mean:?}");
    // A quarter of an even disc lies within half of the radius; with limb darkening more.
    assert!((520..640).contains(&inner), "{inner}");
}

/// An even sky with a sun of two pixels, 10⁴ times as bright.
fn sunny_image() -> SkyImage {
    let mut pixels = vec![LinearRgb { r: 0.4, g: 0.5, b: 0.6 }; 64 * 32];
    pixels[8 * 64 + 20..][..2].fill(LinearRgb { r: 5e3, g: 5e3, b: 5e3 });
    SkyImage::new(&Panorama { width: 64, height: 32, pixels }, 1.0, 30.0).unwrap()
}

#[test]
fn the_faint_and_the_bright_part_of_an_image_add_up_to_it() {
    let whole = Arc::new(Light::new(sunny_image()).with_visibility(false));
    let [faint, bright] = &Light::parts(&whole)[..] else { panic!("two parts") };
    assert!(!faint.is_small() && bright.is_small() && !bright.is_sky());
    let mut brightest: f32 = 0.0;
    for draw in 0..4_000 {
        let technique = SamplingTechnique::OfLight(Vec3A::ZERO);
        let origins = [&whole, bright].map(|light| light.sample_origin(&technique, numbers(3, draw)).unwrap());
        for origin in origins {
            let [whole, faint, bright] = [&whole, faint, bright].map(|light| light.power(&origin));
            brightest = brightest.max(faint.0[15]);
            for k in 0..31 {
                assert!((faint.0[k] + bright.0[k] - whole.0[k]).abs() <= 1e-5 * whole.0[k], "{whole:?}");
            }
        }
    }
    // In the row of the sun, at a polar angle of 48°, a pixel has 0.74/0.64 of the mean solid angle. Two of 2,048
    // pixels of 5,000 and the sky of 0.48 have a mean of 6.1. Rays find four times as much at most, 51 times the sky.
    let sky = whole.power(&LightOrigin::Distant(Vec3A::NEG_Z)).0[15];
    assert!((45.0..55.0).contains(&(brightest / sky)), "{}", brightest / sky);
    // An image without a sun, and other skies, are one part.
    for light in [image(), dome(), ball()] {
        assert_eq!(Light::parts(&Arc::new(light)).len(), 1);
    }
}
