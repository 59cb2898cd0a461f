//! An overcast sky.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_base::toml_table::Table;
use snowblue_base::{KeyPath, Number, ParseError, narrow};
use snowblue_sky::overcast_illuminance_lx;

use super::sun::{SunDescription, sun_error};
use crate::error::SceneError;
use crate::light::Light;
use crate::light::dome::SkyDome;
use crate::light::keys::Irradiance;
use crate::sources::Sources;
use crate::spectrum::emission::EmissionSpectrum;
use crate::spectrum::light_spectrum::lumens_per_watt_of_luminance_one;
use crate::values::{only_one, visible};

/// An overcast sky, whose strength is an irradiance or follows from the elevation of the sun behind the clouds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OvercastSkyDescription {
    /// The shape of its spectrum.
    #[serde(flatten, skip_deserializing)]
    #[schemars(!skip_deserializing)]
    pub spectrum: EmissionSpectrum,
    /// Irradiance of level ground over 400–700 nm, in W/m².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub irradiance_w_m2: Option<Number<Irradiance>>,
    /// Where the sun is behind the clouds, instead of an irradiance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sun: Option<SunDescription>,
    /// Whether it is visible to the camera.
    #[serde(default = "visible")]
    pub visible: bool,
}

/// The strength of the light, given as an irradiance or by the sun.
enum Strength<'sky> {
    Irradiance(f64),
    Sun(&'sky SunDescription),
}

impl OvercastSkyDescription {
    pub(super) fn read(mut table: Table) -> Result<Self, ParseError> {
        let spectrum = table.split(&EmissionSpectrum::KEYS).read()?;
        Ok(Self { spectrum, ..table.read()? })
    }

    pub(super) fn build(&self, path: &KeyPath, sources: &Sources) -> Result<Light, SceneError> {
        let strength = only_one(
            path,
            [
                ("irradiance_w_m2", self.irradiance_w_m2.map(|irradiance| Strength::Irradiance(irradiance.get()))),
                ("sun", self.sun.as_ref().map(Strength::Sun)),
            ],
        )?;
        let spectrum = self.spectrum.build(path, sources)?;
        let irradiance = match strength {
            Strength::Irradiance(irradiance_w_m2) => spectrum.unit * narrow(irradiance_w_m2),
            Strength::Sun(sun) => {
                let path = path.key("sun");
                let (position, _) = sun.position(&path)?;
                let illuminance_lx =
                    overcast_illuminance_lx(position.elevation_deg).map_err(|error| sun_error(&path, &error))?;
                spectrum.relative * narrow(illuminance_lx / lumens_per_watt_of_luminance_one())
            }
        };
        let dome =
            SkyDome::overcast(&irradiance).ok_or_else(|| path.key("irradiance_w_m2").error("is 0: the sky is dark"))?;
        Ok(Light::new(dome).with_visibility(self.visible))
    }
}
