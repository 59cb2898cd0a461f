//! The variables with respect to which fluxes are differentiated.

use std::fmt;
use std::str::FromStr;

use crate::dual::Dual;
use crate::error::{TransportError, find_by_name};
use crate::optics::Substance;
use crate::parameters::{DENSITY, GROUND_ALBEDO, SURFACE_AREA, THICKNESS, WATER_SATURATION};
use crate::sample::SnowSample;
use crate::stack::Layer;

/// A quantity with respect to which reflectance, transmittance and fluxes are differentiated; all others stay as they
/// are. A layer of clear ice has the derivative 0 by all that is of layers but the thickness.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variable {
    /// Specific surface area of the grains, in m²/kg, which scales all grain sizes and leaves the shapes as they are.
    SurfaceArea,
    /// Density of the dry snow, in kg/m³.
    Density,
    /// Thickness, in cm. A half-space has the derivative 0.
    Thickness,
    /// Fraction of the pore volume that water fills.
    WaterSaturation,
    /// Mass fraction of a substance, in ng/g. Snow may be free of it.
    MassFraction(Substance),
    /// Cosine of the angle of incidence of a beam. Lambertian light has the derivative 0.
    CosIncidence,
    /// Albedo of the ground.
    GroundAlbedo,
}

impl Variable {
    /// Every variable.
    pub const ALL: [Self; 11] = [
        Self::SurfaceArea,
        Self::Density,
        Self::Thickness,
        Self::WaterSaturation,
        Self::MassFraction(Substance::BlackCarbon),
        Self::MassFraction(Substance::SaharanDust),
        Self::MassFraction(Substance::ColoradoDust),
        Self::MassFraction(Substance::BrownCarbon),
        Self::MassFraction(Substance::SnowAlgae),
        Self::CosIncidence,
        Self::GroundAlbedo,
    ];

    /// Its name: the key of the parameter, or the name of the substance.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::SurfaceArea => SURFACE_AREA.key,
            Self::Density => DENSITY.key,
            Self::Thickness => THICKNESS.key,
            Self::WaterSaturation => WATER_SATURATION.key,
            Self::MassFraction(substance) => substance.name(),
            Self::CosIncidence => "cos_angle",
            Self::GroundAlbedo => GROUND_ALBEDO.key,
        }
    }

    /// Whether the variable belongs to a layer, and not to the light or the ground.
    #[must_use]
    pub fn is_of_layer(self) -> bool {
        !matches!(self, Self::CosIncidence | Self::GroundAlbedo)
    }

    /// The value of this variable with its derivatives with respect to `variables`: 1 for itself, 0 for others.
    pub(crate) fn number(self, value: f64, variables: &[Self]) -> Dual {
        let by = |lane: usize| if variables.get(lane) == Some(&self) { 1.0 } else { 0.0 };
        Dual::new(value, std::array::from_fn(by))
    }

    /// Checks that the tables of the water or the substance that this variable adds cover `wavelength_nm`.
    ///
    /// # Errors
    /// [`TransportError::Range`] if a table does not cover it.
    pub(crate) fn check_wavelength(self, wavelength_nm: f64) -> Result<(), TransportError> {
        let mut sample = SnowSample::default();
        match self {
            Self::WaterSaturation => sample.water_saturation = 1.0,
            Self::MassFraction(substance) => sample.impurities = sample.impurities.with(substance, 1.0),
            _ => return Ok(()),
        }
        sample.check_wavelength(wavelength_nm)
    }
}

/// A variable of one layer of several, the common one of all layers, or one of the light or the ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LayerVariable {
    /// The variable.
    pub variable: Variable,
    /// Index of the layer, counted from the top; none of all layers, the light or the ground.
    pub layer: Option<usize>,
}

impl LayerVariable {
    /// Each of `variables` of each layer, the layer running fastest.
    #[must_use]
    pub fn of_layers(variables: &[Variable], layers: usize) -> Vec<Self> {
        let of = |variable: &Variable| -> Vec<Self> {
            if !variable.is_of_layer() {
                return vec![Self { variable: *variable, layer: None }];
            }
            (0..layers).map(|layer| Self { variable: *variable, layer: Some(layer) }).collect()
        };
        variables.iter().flat_map(of).collect()
    }

    /// Whether both change the same quantity of a layer, the light or the ground.
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.variable == other.variable && (self.layer.is_none() || other.layer.is_none() || self.layer == other.layer)
    }

    /// Those of all layers to which the variable belongs. Clear ice has no variable but its thickness.
    pub(crate) fn of<'l>(&self, layers: &'l [Layer]) -> impl Iterator<Item = &'l Layer> + use<'l> {
        let by = *self;
        layers.iter().enumerate().filter(move |(layer, one)| by.is_of(*layer, one)).map(|(_, one)| one)
    }

    /// The same, to change them.
    pub(crate) fn of_mut<'l>(&self, layers: &'l mut [Layer]) -> impl Iterator<Item = &'l mut Layer> + use<'l> {
        let by = *self;
        layers.iter_mut().enumerate().filter(move |(layer, one)| by.is_of(*layer, one)).map(|(_, one)| one)
    }

    fn is_of(self, layer: usize, one: &Layer) -> bool {
        self.layer.is_none_or(|only| only == layer) && (self.variable == Variable::Thickness || !one.is_ice())
    }
}

/// The variable of all layers, the light or the ground.
impl From<Variable> for LayerVariable {
    fn from(variable: Variable) -> Self {
        Self { variable, layer: None }
    }
}

/// Formats the name, with the number of the layer.
impl fmt::Display for LayerVariable {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.layer {
            Some(layer) => write!(out, "{} of layer {layer}", self.variable),
            None => self.variable.fmt(out),
        }
    }
}

/// Formats the name.
impl fmt::Display for Variable {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.name())
    }
}

impl FromStr for Variable {
    type Err = TransportError;

    fn from_str(name: &str) -> Result<Self, TransportError> {
        let substance = name.parse::<Substance>().map(Self::MassFraction);
        substance.or_else(|_| find_by_name("parameter", name, &Self::ALL, Self::name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_variable_has_a_name() {
        for variable in Variable::ALL {
            assert_eq!(variable.to_string().parse(), Ok(variable));
            assert_eq!(variable.to_string().replace('-', "_").parse(), Ok(variable));
        }
        let substances = Variable::ALL.iter().filter(|variable| matches!(variable, Variable::MassFraction(_)));
        assert_eq!(substances.count(), Substance::ALL.len());
        let message = "size".parse::<Variable>().unwrap_err().to_string();
        assert!(message.starts_with("parameter 'size' is not known; there are ssa_m2_kg, density_kg_m3"), "{message}");
    }
}
