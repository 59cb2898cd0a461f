//! The `[[light]]` tables and `[environment]`.

use std::path::Path;

use glam::Vec3A;
use snowblue_color::Illuminant;

use crate::error::RenderError;
use crate::files::FilesIn;
use crate::geometry::ray::narrow;
use crate::scene::file::section::Section;
use crate::scene::file::{GREATEST_COORDINATE_M, Overrides};
use crate::scene::light::{
    DiffuseEmitter, DirectionalLight, Light, Panorama, PointLight, RectangleLight, RectanglePlace, SkyImage,
    SphereLight, SpotCone, UniformSky,
};
use crate::spectrum::light_spectrum::LightSpectrum;

/// Greatest power of a lamp, in any unit.
const GREATEST_POWER: f64 = 1e12;
/// Least and greatest size of a lamp, in m.
const LAMP_SIZE_M: std::ops::RangeInclusive<f64> = 1e-6..=1e5;

type Read<T> = Result<T, RenderError>;

/// What a `[[light]]` can be.
#[derive(Clone, Copy)]
enum Kind {
    Point,
    Spot,
    Directional,
    Sphere,
    Rectangle,
}

/// Reads one lamp; a spectrum file is looked for beside the scene file.
pub(super) fn read_light(section: &Section, scene: &Path, overrides: &Overrides) -> Read<Light> {
    section.required_text("type")?;
    let kinds = [
        ("point", Kind::Point),
        ("spot", Kind::Spot),
        ("directional", Kind::Directional),
        ("sphere", Kind::Sphere),
        ("rectangle", Kind::Rectangle),
    ];
    let kind = section.choice("type", Kind::Point, &kinds)?;
    let keys: &[&str] = match kind {
        Kind::Point => &["position", "radiant_intensity_w_sr"],
        Kind::Spot => &["position", "look_at", "inner_cone_deg", "outer_cone_deg", "radiant_intensity_w_sr"],
        Kind::Directional => &["direction", "irradiance_w_m2"],
        Kind::Sphere => &["position", "radius", "radiance_w_m2_sr", "visible"],
        Kind::Rectangle => &["position", "look_at", "up", "size", "radiance_w_m2_sr", "visible"],
    };
    section.only(&[&["type", "illuminant", "spectrum"], keys].concat())?;
    let lamp = read_spectrum(section, scene, overrides)?;
    let power = |key: &str, unit: &str| section.number(key, None, 0.0..=GREATEST_POWER, unit).map(narrow);
    let place = |key: &str| section.vector(key, None, -GREATEST_COORDINATE_M..=GREATEST_COORDINATE_M, "m");
    Ok(match kind {
        Kind::Point | Kind::Spot => {
            let mut light = PointLight::new(place("position")?, &lamp, power("radiant_intensity_w_sr", "W/sr")?);
            if matches!(kind, Kind::Spot) {
                light.cone = Some(read_cone(section, place("look_at")? - light.position)?);
            }
            Light::Point(light)
        }
        Kind::Directional => {
            let direction = section.vector("direction", None, -1e6..=1e6, "")?;
            let direction = direction.try_normalize().ok_or_else(|| {
                section.error_at("direction", "light.direction is [0, 0, 0], but must point somewhere")
            })?;
            let irradiance = lamp.unit * power("irradiance_w_m2", "W/m²")?;
            Light::Directional(DirectionalLight { to_light: -direction, irradiance, relative: lamp.relative })
        }
        Kind::Sphere => {
            let radius_m = narrow(section.number("radius", None, LAMP_SIZE_M, "m")?);
            let shape = SphereLight { centre: place("position")?, radius_m };
            Light::Sphere(read_glow(section, shape, &lamp)?)
        }
        Kind::Rectangle => {
            let [width_m, height_m] = section.pair("size", LAMP_SIZE_M, "m")?;
            let place = RectanglePlace {
                centre: place("position")?,
                look_at: place("look_at")?,
                up: section.vector("up", Some(Vec3A::Z), -1e6..=1e6, "")?,
                width_m,
                height_m,
            };
            let shape = RectangleLight::new(&place).ok_or_else(|| {
                section.error_at("look_at", "light.look_at must lie off the light's position and up axis")
            })?;
            Light::Rectangle(read_glow(section, shape, &lamp)?)
        }
    })
}

/// Reads where a spot shines.
fn read_cone(section: &Section, way: Vec3A) -> Read<SpotCone> {
    let axis = way.try_normalize();
    let axis = axis.ok_or_else(|| section.error_at("look_at", "light.look_at must lie off the light's position"))?;
    let outer_deg = section.number("outer_cone_deg", Some(45.0), 0.1..=90.0, "deg")?;
    let inner_deg = section.number("inner_cone_deg", Some(0.0), 0.0..=outer_deg, "deg")?;
    Ok(SpotCone::new(axis, narrow(inner_deg), narrow(outer_deg)))
}

/// Reads the sky; its image and its spectrum file are looked for beside the scene file.
pub(super) fn read_environment(section: &Section, scene: &Path, overrides: &Overrides) -> Read<Light> {
    let Some(file) = section.text("image")? else {
        section.only(&["radiance_w_m2_sr", "illuminant", "spectrum", "visible"])?;
        let lamp = read_spectrum(section, scene, overrides)?;
        return Ok(Light::Sky(read_glow(section, UniformSky, &lamp)?));
    };
    section.only(&["image", "scale", "rotation_deg", "visible"])?;
    let path = scene.with_file_name(file);
    if !path.is_file() {
        return Err(section.error_at("image", format!("image {} does not exist", path.display())));
    }
    let scale = narrow(section.number("scale", Some(1.0), 1e-9..=1e9, "")?);
    let rotation_deg = narrow(section.number("rotation_deg", Some(0.0), -360.0..=360.0, "deg")?);
    let visible = section.flag("visible", true)?;
    let panorama = Panorama::read_exr(&FilesIn::beside(scene), file)?;
    let image = SkyImage::new(&panorama, scale, rotation_deg, overrides.false_color.is_none())
        .map_err(|reason| RenderError::ReadImage { path, reason })?;
    Ok(Light::Image(Box::new(image), visible))
}

fn read_glow<Shape>(section: &Section, shape: Shape, lamp: &LightSpectrum) -> Read<DiffuseEmitter<Shape>> {
    let radiance = section.number("radiance_w_m2_sr", None, 0.0..=GREATEST_POWER, "W/(m² sr)")?;
    let mut glow = DiffuseEmitter::new(shape, lamp, narrow(radiance));
    glow.visible = section.flag("visible", true)?;
    Ok(glow)
}

/// The spectrum by name or from a file; in false colour all lamps are alike.
fn read_spectrum(section: &Section, scene: &Path, overrides: &Overrides) -> Read<LightSpectrum> {
    let name = section.text("illuminant")?;
    let lamp = match section.text("spectrum")? {
        Some(_) if name.is_some() => {
            return Err(section.error_at("spectrum", "a light has either `illuminant` or `spectrum`, not both"));
        }
        Some(file) => {
            let path = scene.with_file_name(file);
            if !path.is_file() {
                return Err(section.error_at("spectrum", format!("spectrum {} does not exist", path.display())));
            }
            LightSpectrum::read(&FilesIn::beside(scene), file)?
        }
        None => {
            let illuminant = name.unwrap_or("D65").parse().and_then(|one: Illuminant| LightSpectrum::illuminant(one));
            let what = section.full_name("illuminant");
            illuminant.map_err(|error| section.error_at("illuminant", format!("{what}: {error}")))?
        }
    };
    Ok(if overrides.false_color.is_some() { LightSpectrum::EQUAL_ENERGY } else { lamp })
}
