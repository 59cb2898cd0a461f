//! Layers of snow on a ground, and the light on them.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use snowblue_transport::optics::WavelengthRange;
use snowblue_transport::ordinates::{OrdinatesOptions, solve, solve_stack, solve_without_errors};
use snowblue_transport::sample::{SnowKeys, SnowSample};
use snowblue_transport::slab::{Incidence, Radiometry, Slab};
use snowblue_transport::stack::{self, Stack};

use crate::text;

/// A layer of snow.
#[derive(Debug, Clone, Deserialize)]
#[serde(try_from = "Map<String, Value>")]
struct Layer {
    thickness_cm: f64,
    snow: SnowKeys,
}

/// Layers on a ground under light, and the accuracy of the solution.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Sample {
    layers: Vec<Layer>,
    #[serde(default)]
    ground_albedo: f64,
    angle_deg: Angle,
    tally_rays: Option<u32>,
}

/// Reflectance, transmittance and absorptance of a sample at each wavelength.
#[derive(Debug, Serialize)]
pub(crate) struct Curves {
    pub(crate) wavelengths_nm: Vec<f64>,
    pub(crate) reflectance: Vec<f64>,
    pub(crate) transmittance: Vec<f64>,
    pub(crate) absorptance: Vec<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Angle {
    Degrees(f64),
    Word(String),
}

/// Reads the keys of the snow beside the thickness. An error names its key.
impl TryFrom<Map<String, Value>> for Layer {
    type Error = String;

    fn try_from(mut keys: Map<String, Value>) -> Result<Self, String> {
        let thickness_cm = keys.remove("thickness_cm").as_ref().and_then(Value::as_f64);
        let snow = serde_path_to_error::deserialize::<_, SnowKeys>(Value::Object(keys)).map_err(|error| {
            let (path, message) = (error.path(), error.inner().to_string());
            if message.starts_with("is ") { format!("{path} {message}") } else { format!("{path}: {message}") }
        })?;
        Ok(Self { thickness_cm: thickness_cm.ok_or("thickness_cm must be a number")?, snow })
    }
}

impl Layer {
    /// The snow.
    fn sample(&self) -> Result<SnowSample, String> {
        self.snow.sample().map_err(|wrong| text(wrong.error))
    }
}

impl Sample {
    /// Reflectance, transmittance and absorptance at each wavelength; without `errors` the standard errors may be NaN.
    pub(crate) fn rows(&self, wavelengths_nm: Vec<f64>, errors: bool) -> Result<Vec<Radiometry>, String> {
        let options = self.options();
        let Stack { layers, ground_albedo, incidences, .. } = self.stack()?;
        let single = if let [layer] = &*layers { layer.sample().zip(Some(layer.thickness_cm)) } else { None };
        if let (Some((sample, thickness_cm)), true) = (single, ground_albedo == 0.0.into()) {
            let slab = Slab { sample: *sample, thicknesses_cm: vec![thickness_cm], incidences, wavelengths_nm };
            let solve = if errors { solve } else { solve_without_errors };
            return solve(&slab, &options).map_err(text);
        }
        let stack = Stack { layers, ground_albedo, depths_cm: Vec::new(), incidences, wavelengths_nm };
        let solved = solve_stack(&stack, &options).map_err(text)?;
        Ok(solved.into_iter().map(|answer| answer.whole).collect())
    }

    /// The stack, without depths and wavelengths.
    pub(crate) fn stack(&self) -> Result<Stack, String> {
        let layer = |layer: &Layer| Ok(stack::Layer::snow(layer.sample()?, layer.thickness_cm));
        Ok(Stack {
            layers: self.layers.iter().map(layer).collect::<Result<_, String>>()?,
            ground_albedo: self.ground_albedo.into(),
            depths_cm: Vec::new(),
            incidences: vec![self.angle_deg.incidence()?],
            wavelengths_nm: Vec::new(),
        })
    }

    /// The wavelengths that the table of ice covers.
    pub(crate) fn wavelength_range(&self) -> Result<WavelengthRange, String> {
        let layer = self.layers.first().ok_or("there is no layer")?;
        Ok(layer.sample()?.ice.wavelength_range())
    }

    pub(crate) fn options(&self) -> OrdinatesOptions {
        let default = OrdinatesOptions::default();
        OrdinatesOptions { tally_rays: self.tally_rays.unwrap_or(default.tally_rays), ..default }
    }
}

impl Curves {
    pub(crate) fn of(rows: &[Radiometry]) -> Self {
        let values = |of: fn(&Radiometry) -> f64| rows.iter().map(of).collect();
        Self {
            wavelengths_nm: values(|row| row.wavelength_nm),
            reflectance: values(|row| row.fluxes.reflectance.value),
            transmittance: values(|row| row.fluxes.transmittance.value),
            absorptance: values(|row| row.fluxes.absorptance.value),
        }
    }
}

impl Angle {
    fn incidence(&self) -> Result<Incidence, String> {
        match self {
            Self::Degrees(angle_deg) => Ok(Incidence::Beam { angle_deg: *angle_deg }),
            Self::Word(word) => word.parse().map_err(text),
        }
    }
}
