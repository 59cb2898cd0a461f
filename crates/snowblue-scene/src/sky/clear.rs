//! A clear sky with its sun, by the model of [`snowblue_sky`].

use std::borrow::Cow;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_base::files::{FileSource, NamedFile};
use snowblue_base::{KeyPath, Number, ParameterRange, quantities};
use snowblue_sky::{ClearSky, Coefficients, TURBIDITY_RANGE, WAVELENGTHS_NM};

use super::sun::{SunDescription, sun_error};
use crate::air::Air;
use crate::error::SceneError;
use crate::light::Light;
use crate::light::dome::{ClearRadiance, Resampling, SkyDome};
use crate::light::keys::SkyScale;
use crate::light::sun::SunDisc;
use crate::material::deep_snow::deep_albedo;
use crate::sources::Sources;
use crate::values::{Fraction, visible};
use snowblue_transport::SnowSample;

quantities! {
    /// How much haze the air holds.
    pub Turbidity = ParameterRange::new("turbidity", TURBIDITY_RANGE.0, TURBIDITY_RANGE.1, "");
}

/// The lights of the sky, and the air if aerial perspective is on.
#[derive(Default)]
pub(crate) struct BuiltSky {
    pub(crate) lights: Vec<Light>,
    pub(crate) air: Option<Air>,
}

/// Reflectance of the ground if the scene has no snow: soil and rock.
const BARE_GROUND_ALBEDO: f64 = 0.2;

/// A clear sky with its sun, by the model of [`snowblue_sky`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ClearSkyDescription {
    /// Where the sun is.
    pub sun: SunDescription,
    /// How much haze the air holds: 2 is very clear, 3 clear, 6 hazy.
    #[serde(default = "ClearSkyDescription::default_turbidity")]
    pub turbidity: Number<Turbidity>,
    /// Reflectance of the ground below the sky, which brightens it; the albedo of the scene's snow if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ground_albedo: Option<Number<Fraction>>,
    /// Multiplies sun and sky.
    #[serde(default = "ClearSkyDescription::default_scale")]
    pub scale: Number<SkyScale>,
    /// Whether the air lies over what is far away.
    #[serde(default)]
    pub aerial_perspective: bool,
    /// Whether they are visible to the camera.
    #[serde(default = "visible")]
    pub visible: bool,
}

impl ClearSkyDescription {
    /// A clear sky of turbidity 3.
    pub fn new(sun: SunDescription) -> Self {
        Self {
            sun,
            turbidity: Self::default_turbidity(),
            ground_albedo: None,
            scale: Self::default_scale(),
            aerial_perspective: false,
            visible: visible(),
        }
    }

    fn default_turbidity() -> Number<Turbidity> {
        Number::of(3.0)
    }

    fn default_scale() -> Number<SkyScale> {
        Number::of(1.0)
    }

    pub(super) fn build(
        &self,
        path: &KeyPath,
        snow: Option<&SnowSample>,
        sources: &Sources,
    ) -> Result<BuiltSky, SceneError> {
        let albedo = match self.ground_albedo {
            Some(albedo) => [albedo.get(); WAVELENGTHS_NM.len()],
            None => ground_albedo(path, snow)?,
        };
        let coefficients = match Coefficients::embedded() {
            Some(embedded) => Cow::Borrowed(embedded),
            None => Cow::Owned(read_coefficients(path, sources.files)?),
        };
        let path_to_sun = path.key("sun");
        let (position, to_sun) = self.sun.position(&path_to_sun)?;
        let sky = ClearSky::with_coefficients(&coefficients, position.elevation_deg, self.turbidity.get(), &albedo);
        let sky = sky.map_err(|error| sun_error(&path_to_sun, &error))?;
        let resampling = Resampling::new(self.scale.get());
        let sun = SunDisc::new(&sky, to_sun, &resampling);
        let radiance = Arc::new(ClearRadiance { sky, to_sun, resampling });
        let air = self.aerial_perspective.then(|| Air::new(Arc::clone(&radiance)));
        let dome = SkyDome::clear(radiance).ok_or_else(|| path.error("is dark"))?;
        let lights = [Light::new(sun), Light::new(dome)].map(|light| light.with_visibility(self.visible)).into();
        Ok(BuiltSky { lights, air })
    }
}

/// Reads the coefficients of the clear sky among the files of the scene.
fn read_coefficients(path: &KeyPath, files: &dyn FileSource) -> Result<Coefficients, SceneError> {
    let [sky, sun] = Coefficients::FILES.map(|name| NamedFile::read(files, name));
    let coefficients = Coefficients::parse(&sky?.text(), &sun?.text());
    coefficients.map_err(|error| path.error(format!("is clear, but its coefficients cannot be used: {error}")).into())
}

/// Albedo of snow at the wavelengths of the sky; the albedo of bare ground if there is no snow.
fn ground_albedo(path: &KeyPath, snow: Option<&SnowSample>) -> Result<[f64; WAVELENGTHS_NM.len()], SceneError> {
    let Some(sample) = snow else { return Ok([BARE_GROUND_ALBEDO; WAVELENGTHS_NM.len()]) };
    deep_albedo(sample, &WAVELENGTHS_NM).map_err(|error| {
        let reason = format!("is missing, and the albedo of the scene's snow is unknown: {error}");
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
