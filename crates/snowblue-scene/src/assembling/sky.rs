//! Sun and sky.

use std::borrow::Cow;
use std::sync::Arc;

use glam::{DVec3, Vec3A};
use snowblue_base::files::{FileSource, NamedFile};
use snowblue_geometry::ray::narrow;
use snowblue_sky::{
    ClearSky, Coefficients, DateTime, Place, SkyError, SunPosition, WAVELENGTHS_NM, overcast_illuminance_lx,
    sun_position,
};

use crate::air::Air;
use crate::assembling::light::spectrum;
use crate::assembling::sources::Sources;
use crate::description::{
    ClearSkyDescription, ObjectDescription, OvercastSkyDescription, OvercastStrength, SceneDescription, SkyDescription,
    SunDescription,
};
use crate::error::SceneError;
use crate::light::Light;
use crate::light::dome::{ClearRadiance, Resampling, SkyDome};
use crate::light::sun::SunDisc;
use crate::material::Material;
use crate::material::deep_snow::deep_albedo;
use crate::spectrum::light_spectrum::lumens_per_watt_of_luminance_one;
use snowblue_base::{KeyError, KeyPath};

/// Reflectance of the ground if the scene has no snow: that of soil and rock.
const BARE_GROUND_ALBEDO: f64 = 0.2;

/// The lights of the sky, and the air if it is seen.
#[derive(Default)]
pub(super) struct BuiltSky {
    pub(super) lights: Vec<Light>,
    pub(super) air: Option<Air>,
}

/// Builds the sky.
pub(super) fn build_sky(
    description: &SceneDescription,
    materials: &[Material],
    sources: &Sources,
) -> Result<BuiltSky, SceneError> {
    let path = KeyPath::root("sky");
    match &description.sky {
        None => Ok(BuiltSky::default()),
        Some(SkyDescription::Clear(clear)) => {
            let albedo = match clear.ground_albedo {
                Some(albedo) => [albedo; WAVELENGTHS_NM.len()],
                None => snow_albedo(&path, description, materials)?,
            };
            let coefficients = match Coefficients::embedded() {
                Some(embedded) => Cow::Borrowed(embedded),
                None => Cow::Owned(read_coefficients(&path, sources.files)?),
            };
            Ok(clear_sky(&path, clear, (&coefficients, &albedo))?)
        }
        Some(SkyDescription::Overcast(overcast)) => {
            Ok(BuiltSky { lights: vec![overcast_sky(&path, overcast, sources)?], air: None })
        }
    }
}

/// Reads the coefficients of the clear sky among the files of the scene.
fn read_coefficients(path: &KeyPath, files: &dyn FileSource) -> Result<Coefficients, SceneError> {
    let [sky, sun] = Coefficients::FILES.map(|name| NamedFile::read(files, name));
    let coefficients = Coefficients::parse(&sky?.text(), &sun?.text());
    coefficients.map_err(|error| path.error(format!("is clear, but its coefficients cannot be used: {error}")).into())
}

fn clear_sky(
    path: &KeyPath,
    clear: &ClearSkyDescription,
    (coefficients, albedo): (&Coefficients, &[f64; WAVELENGTHS_NM.len()]),
) -> Result<BuiltSky, KeyError> {
    let (position, to_sun) = place_sun(&path.key("sun"), &clear.sun)?;
    let sky = ClearSky::with_coefficients(coefficients, position.elevation_deg, clear.turbidity, albedo);
    let sky = sky.map_err(|error| sun_error(&path.key("sun"), &error))?;
    let resampling = Resampling::new(clear.scale);
    let sun = SunDisc::new(&sky, to_sun, &resampling);
    let radiance = Arc::new(ClearRadiance { sky, to_sun, resampling });
    let air = clear.aerial_perspective.then(|| Air::new(Arc::clone(&radiance)));
    let dome = SkyDome::clear(radiance).ok_or_else(|| path.error("is dark"))?;
    let lights = [Light::new(sun), Light::new(dome)].map(|light| light.with_visibility(clear.visible)).into();
    Ok(BuiltSky { lights, air })
}

fn overcast_sky(path: &KeyPath, overcast: &OvercastSkyDescription, sources: &Sources) -> Result<Light, SceneError> {
    let lamp = spectrum(path, &overcast.lamp, sources)?;
    let irradiance = match &overcast.strength {
        OvercastStrength::Irradiance { irradiance_w_m2 } => lamp.unit * narrow(*irradiance_w_m2),
        OvercastStrength::Sun { sun } => {
            let path = path.key("sun");
            let (position, _) = place_sun(&path, sun)?;
            let illuminance_lx =
                overcast_illuminance_lx(position.elevation_deg).map_err(|error| sun_error(&path, &error))?;
            lamp.relative * narrow(illuminance_lx / lumens_per_watt_of_luminance_one())
        }
    };
    let dome =
        SkyDome::overcast(&irradiance).ok_or_else(|| path.key("irradiance_w_m2").error("is 0: the sky is dark"))?;
    Ok(Light::new(dome).with_visibility(overcast.visible))
}

/// An error about the sun at its path, which names it: `sky.sun elevation is -3°`.
fn sun_error(path: &KeyPath, error: &SkyError) -> KeyError {
    path.error(error.to_string().trim_start_matches("sun "))
}

/// The position of the sun, and the unit direction towards it. y points north and x east.
fn place_sun(path: &KeyPath, sun: &SunDescription) -> Result<(SunPosition, Vec3A), KeyError> {
    let position = match sun {
        SunDescription::Direction { towards } => {
            let [x, y, z] = *towards;
            let elevation_deg = z.atan2(x.hypot(y)).to_degrees();
            SunPosition { elevation_deg, azimuth_deg: x.atan2(y).to_degrees().rem_euclid(360.0) }
        }
        SunDescription::Angles { elevation_deg, azimuth_deg } => {
            SunPosition { elevation_deg: *elevation_deg, azimuth_deg: *azimuth_deg }
        }
        SunDescription::Place { latitude_deg, longitude_deg, date, time, utc_offset_h } => {
            let clock: Result<DateTime, _> = format!("{date}T{time}Z").parse();
            let clock = clock.map_err(|_| {
                let reason = format!("is \"{time}\" on \"{date}\", but must be like \"14:30\" on \"2026-02-01\"");
                path.key("time").error(reason)
            })?;
            let place = Place { latitude_deg: *latitude_deg, longitude_deg: *longitude_deg };
            let position = sun_position(place, DateTime { utc_offset_h: *utc_offset_h, ..clock });
            position.map_err(|error| path.error(error.to_string()))?
        }
    };
    let [elevation, azimuth] = [position.elevation_deg, position.azimuth_deg].map(f64::to_radians);
    let direction = DVec3::new(elevation.cos() * azimuth.sin(), elevation.cos() * azimuth.cos(), elevation.sin());
    Ok((position, direction.as_vec3a()))
}

/// Albedo of the first snow that an object is made of at the wavelengths of the sky; that of bare ground if there is
/// none.
fn snow_albedo(
    path: &KeyPath,
    description: &SceneDescription,
    materials: &[Material],
) -> Result<[f64; WAVELENGTHS_NM.len()], SceneError> {
    let of_object = |object: &ObjectDescription| {
        let mut named = description.materials.keys().zip(materials);
        let (_, material) = named.find(|(name, _)| **name == object.common.material)?;
        material.snow()?.samples().first()
    };
    let Some(sample) = description.objects.iter().find_map(of_object) else {
        return Ok([BARE_GROUND_ALBEDO; WAVELENGTHS_NM.len()]);
    };
    deep_albedo(sample, &WAVELENGTHS_NM).map_err(|error| {
        let reason = format!("is missing, and that of the scene's snow is unknown: {error}");
        path.key("ground_albedo").error(reason).into()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowblue_base::files::FilesIn;

    #[test]
    fn coefficients_that_are_files_are_those_that_are_embedded() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../snowblue-sky/data");
        let read = |folder: &str| read_coefficients(&KeyPath::root("sky"), &FilesIn::new(folder));
        assert_eq!(Some(&read(folder).unwrap()), Coefficients::embedded());
        let missing = read("/nowhere").unwrap_err().to_string();
        assert!(missing.contains("cannot read /nowhere/hosek_wilkie_2012_spectral.csv"), "{missing}");
    }
}
