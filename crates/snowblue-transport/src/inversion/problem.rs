//! The variables to retrieve, the known and the measured quantities of each pack of snow, and their checks.

use nalgebra::DMatrix;
use snowblue_base::ParameterRange;

use super::estimation;
use super::measured::{Channels, Measured, Quantity, check_bands};
use super::state::state_range;
use crate::TransportError;
use crate::error::InversionError;
use crate::ground::GroundAlbedo;
use crate::ordinates::OrdinatesOptions;
use crate::slab::Incidence;
use crate::stack::{ICE_THICKNESS_RANGE, Layer, Stack};
use crate::variable::{LayerVariable, Variable};

const DIFFUSE_FRACTION_RANGE: ParameterRange =
    ParameterRange { quantity: "diffuse fraction", least: 0.0, greatest: 1.0, unit: "" };
const PRIOR_DEVIATION_RANGE: ParameterRange =
    ParameterRange { quantity: "standard deviation", least: 1e-6, greatest: 100.0, unit: "" };

/// The variables to retrieve from spectra at common wavelengths, and the covariance of their prior.
#[derive(Debug, Clone, PartialEq)]
pub struct Inversion {
    /// Wavelengths, in nm.
    pub wavelengths_nm: Vec<f64>,
    /// The weight of each wavelength in each band of the measured values, by the response of the sensor and the
    /// light. The weights of a band sum to 1. Without bands, values are measured at the wavelengths.
    pub bands: Option<Vec<Vec<f64>>>,
    /// The variables to retrieve. A variable belongs to one layer or, without a number, to all layers in common, to
    /// the light or to the ground. If the surface area is retrieved, the grains have one optical diameter.
    pub variables: Vec<LayerVariable>,
    /// Covariance of the prior, row by row, of the logarithms of the variables, or the log-odds of saturation, cosine
    /// and ground albedo.
    pub prior_covariance: Vec<f64>,
    /// Options of the engine.
    pub options: OrdinatesOptions,
}

/// Measured spectra of one pack of snow, and its known properties.
#[derive(Debug, Clone, PartialEq)]
pub struct Observation {
    /// Layers, top first; the values of retrieved variables are ignored.
    pub layers: Vec<Layer>,
    /// Albedo of the Lambertian ground.
    pub ground_albedo: GroundAlbedo,
    /// Light on the snow.
    pub illumination: Illumination,
    /// Median of the prior of each variable, in its unit.
    pub prior_medians: Vec<f64>,
    /// The measurements.
    pub measured: Vec<Measured>,
}

/// Light on the snow.
#[derive(Debug, Clone, PartialEq)]
pub enum Illumination {
    /// A beam or Lambertian light.
    Single(Incidence),
    /// The beam of the sun with Lambertian light.
    Mixed {
        /// Angle of the beam from the normal, in degrees.
        angle_deg: f64,
        /// Fraction of the irradiance that is diffuse, at each wavelength.
        diffuse_fractions: Vec<f64>,
    },
}

impl Inversion {
    /// Checks what all packs have in common, and gives the root of the inverse covariance of the prior.
    pub(super) fn check(&self) -> Result<DMatrix<f64>, InversionError> {
        let Self { wavelengths_nm, variables, prior_covariance, options, .. } = self;
        options.streams.check()?;
        if wavelengths_nm.is_empty() {
            return Err(TransportError::Missing { quantity: "wavelength" }.into());
        }
        self.bands.as_ref().map_or(Ok(()), |bands| check_bands(bands, wavelengths_nm.len()))?;
        let n = variables.len();
        if n == 0 {
            return Err(TransportError::Missing { quantity: "quantity to retrieve" }.into());
        }
        for (place, variable) in variables.iter().enumerate() {
            if variables[..place].iter().any(|other| other.overlaps(variable)) {
                return Err(combination(variable.variable.name(), "is to be retrieved twice").into());
            }
        }
        if prior_covariance.len() != n * n {
            let (quantity, count) = ("covariance of the prior", prior_covariance.len());
            return Err(TransportError::Count { quantity, count, expected: "those of a row for each variable" }.into());
        }
        let covariance = DMatrix::from_row_slice(n, n, prior_covariance);
        for (variable, variance) in variables.iter().zip(covariance.diagonal().iter()) {
            let check = PRIOR_DEVIATION_RANGE.check(variance.sqrt());
            check.map_err(|error| TransportError::Prior { parameter: variable.to_string(), error })?;
        }
        let is_symmetric = covariance == covariance.transpose();
        estimation::precision_root(&covariance)
            .filter(|_| is_symmetric)
            .ok_or_else(|| combination("covariance of the prior", "must be symmetric and positive definite").into())
    }

    /// The wavelengths or bands at which values are measured.
    pub(super) fn channels(&self) -> Channels<'_> {
        Channels::new(&self.wavelengths_nm, self.bands.as_deref())
    }

    /// Checks an observation, and gives the wavelengths that its data need.
    pub(super) fn check_observation(
        &self,
        observation: &Observation,
        channels: &Channels<'_>,
    ) -> Result<Vec<usize>, InversionError> {
        let Observation { layers, illumination, prior_medians, measured, .. } = observation;
        observation.check_layers()?;
        if let Illumination::Mixed { diffuse_fractions, .. } = illumination
            && diffuse_fractions.len() != self.wavelengths_nm.len()
        {
            let (quantity, count) = (DIFFUSE_FRACTION_RANGE.quantity, diffuse_fractions.len());
            let expected = "as many as there are wavelengths";
            return Err(TransportError::Count { quantity, count, expected }.into());
        }
        if prior_medians.len() != self.variables.len() {
            let (quantity, count) = ("median of the prior", prior_medians.len());
            return Err(TransportError::Count { quantity, count, expected: "one for each variable" }.into());
        }
        for (by, median) in self.variables.iter().zip(prior_medians) {
            if let Some(layer) = by.layer {
                let greatest = layers.len() as f64 - 1.0;
                let numbers = ParameterRange { quantity: "number of the layer", least: 0.0, greatest, unit: "" };
                numbers.check(layer as f64)?;
            }
            if by.variable.is_of_layer() && by.of(layers).next().is_none() {
                return Err(combination(by.variable.name(), "cannot be retrieved from clear ice").into());
            }
            self.check_thickness(observation, by)?;
            if by.variable == Variable::CosIncidence && matches!(illumination, Illumination::Single(Incidence::Diffuse))
            {
                return Err(combination("angle", "cannot be retrieved under diffuse light").into());
            }
            let check = observation.range(by).check(*median);
            check.map_err(|error| TransportError::Prior { parameter: by.to_string(), error })?;
        }
        // The known values of retrieved variables are ignored.
        self.stack(observation, prior_medians, &[]).check_pack()?;
        for one in measured {
            one.check(channels)?;
            let is_transmittance = one.quantity == Quantity::Transmittance && one.present().next().is_some();
            if is_transmittance && observation.thickness_cm().is_infinite() {
                return Err(combination("transmittance", "needs a thickness that is finite").into());
            }
        }
        let mut own = Vec::new();
        for channel in (0..channels.len()).filter(|channel| measured.iter().any(|one| one.has_data_at(*channel))) {
            for place in channels.wavelengths_of(channel) {
                let check = self.check_place(observation, place);
                check.map_err(|error| InversionError::at_wavelength(channel, error))?;
                own.push(place);
            }
        }
        Ok(own)
    }

    /// Checks that a thickness, if this variable is one, may be retrieved.
    fn check_thickness(&self, observation: &Observation, by: &LayerVariable) -> Result<(), TransportError> {
        if by.variable != Variable::Thickness {
            return Ok(());
        }
        if by.of(&observation.layers).any(|layer| layer.thickness_cm.is_infinite()) {
            return Err(combination("thickness", "cannot be retrieved for a half-space"));
        }
        let others = self.variables.iter().filter(|other| other.variable == Variable::Thickness).count() > 1;
        if others && observation.deepest_cm() > 0.0 && observation.thickness_cm().is_finite() {
            let rule = "of several layers cannot be retrieved from fluxes at depth, which the ground must not reach";
            return Err(combination("thickness", rule));
        }
        Ok(())
    }

    /// Checks that the model of the snow and its light holds at a wavelength.
    pub(super) fn check_place(&self, observation: &Observation, place: usize) -> Result<(), TransportError> {
        if let Illumination::Mixed { diffuse_fractions, .. } = &observation.illumination {
            DIFFUSE_FRACTION_RANGE.check(diffuse_fractions[place])?;
        }
        let wavelength_nm = self.wavelengths_nm[place];
        // The known value of a retrieved variable is ignored.
        if !self.variables.iter().any(|by| by.variable == Variable::GroundAlbedo) {
            observation.ground_albedo.check_wavelengths(&[wavelength_nm])?;
        }
        observation.layers.iter().try_for_each(|layer| layer.check_wavelengths(&[wavelength_nm]))?;
        self.variables.iter().try_for_each(|by| by.variable.check_at(wavelength_nm))
    }
}

impl Observation {
    /// The known value of a variable; NaN for the cosine of diffuse light, for a ground with a spectrum, and for the
    /// common value of layers with different values.
    #[must_use]
    pub fn known(&self, by: LayerVariable) -> f64 {
        let of_layers = |value: &dyn Fn(&Layer) -> f64| {
            let mut values = by.of(&self.layers).map(value);
            let first = values.next().unwrap_or(f64::NAN);
            if values.all(|other| other.total_cmp(&first).is_eq()) { first } else { f64::NAN }
        };
        match by.variable {
            Variable::Snow(property) => {
                of_layers(&|layer| layer.sample().map_or(f64::NAN, |sample| property.get(sample)))
            }
            Variable::Thickness => of_layers(&|layer| layer.thickness_cm),
            Variable::CosIncidence => match self.illumination.incidences()[0] {
                Incidence::Beam { angle_deg } => angle_deg.to_radians().cos(),
                Incidence::Diffuse => f64::NAN,
            },
            Variable::GroundAlbedo => match self.ground_albedo {
                GroundAlbedo::Grey(albedo) => albedo,
                GroundAlbedo::Spectrum(_) => f64::NAN,
            },
        }
    }

    /// The range of a variable. Thicknesses that would raise the ground above a measured flux are excluded.
    #[must_use]
    pub fn range(&self, by: &LayerVariable) -> ParameterRange {
        let mut range = state_range(by.variable);
        if by.variable == Variable::Thickness && by.of(&self.layers).any(Layer::is_ice) {
            range.least = ICE_THICKNESS_RANGE.least;
        }
        if by.variable != Variable::Thickness || self.thickness_cm().is_infinite() {
            return range;
        }
        let own_cm: f64 = by.of(&self.layers).map(|layer| layer.thickness_cm).sum();
        let rest_cm = self.thickness_cm() - own_cm;
        let least = (self.deepest_cm() - rest_cm) / by.of(&self.layers).count() as f64;
        ParameterRange { least: range.least.max(least), ..range }
    }

    fn check_layers(&self) -> Result<(), TransportError> {
        let mut stack = self.stack(Vec::new());
        stack.depths_cm.clear();
        stack.check_pack()
    }

    /// The pack with its known properties.
    pub(super) fn stack(&self, wavelengths_nm: Vec<f64>) -> Stack {
        Stack {
            layers: self.layers.clone(),
            ground_albedo: self.ground_albedo.clone(),
            depths_cm: self.measured.iter().flat_map(|measured| &measured.depths_cm).copied().collect(),
            incidences: self.illumination.incidences(),
            wavelengths_nm,
        }
    }

    /// The scale errors that are not 0, in the order of the elements of the state.
    pub(super) fn scale_errors(&self) -> Vec<f64> {
        self.measured.iter().map(|measured| measured.scale_error).filter(|scale_error| *scale_error > 0.0).collect()
    }

    fn thickness_cm(&self) -> f64 {
        self.layers.iter().map(|layer| layer.thickness_cm).sum()
    }

    /// Depth of the deepest measured flux, in cm; 0 if there is none.
    fn deepest_cm(&self) -> f64 {
        self.measured.iter().flat_map(|measured| &measured.depths_cm).copied().fold(0.0, f64::max)
    }
}

impl Illumination {
    /// The beam, if there is one, then diffuse light, if there is some.
    pub(super) fn incidences(&self) -> Vec<Incidence> {
        match self {
            Self::Single(incidence) => vec![*incidence],
            Self::Mixed { angle_deg, .. } => vec![Incidence::Beam { angle_deg: *angle_deg }, Incidence::Diffuse],
        }
    }

    /// The weight of each incidence at some wavelengths.
    pub(super) fn weights(&self, places: &[usize]) -> Vec<Vec<f64>> {
        match self {
            Self::Single(_) => vec![vec![1.0; places.len()]],
            Self::Mixed { diffuse_fractions, .. } => {
                let diffuse: Vec<f64> = places.iter().map(|place| diffuse_fractions[*place]).collect();
                vec![diffuse.iter().map(|fraction| 1.0 - fraction).collect(), diffuse]
            }
        }
    }
}

fn combination(quantity: &'static str, rule: &'static str) -> TransportError {
    TransportError::Combination { quantity, rule }
}
