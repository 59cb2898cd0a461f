//! The variables with respect to which fluxes are differentiated.

use std::fmt;
use std::str::FromStr;

use crate::dual::Dual;
use crate::error::{TransportError, find_by_name};
use crate::optics::Substance;
use crate::parameters::{GROUND_ALBEDO, THICKNESS};
use crate::sample::{Property, SnowSample};
use crate::stack::Layer;

/// A quantity with respect to which reflectance, transmittance and fluxes are differentiated, while all other
/// quantities are constant. For a layer of clear ice all derivatives by variables of layers are 0, except the
/// derivative by the thickness.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variable {
    /// A property of snow that [has derivatives](Property::has_derivative). The specific surface area scales all grain
    /// sizes and leaves the shapes as they are. Snow may be free of an impurity.
    Snow(Property),
    /// Thickness, in cm. A half-space has the derivative 0.
    Thickness,
    /// Cosine of the angle of incidence of a beam. Lambertian light has the derivative 0.
    CosIncidence,
    /// Albedo of the ground.
    GroundAlbedo,
}

impl Variable {
    /// Every variable.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let properties = Property::all().filter(|property| property.has_derivative()).map(Self::Snow);
        properties.chain([Self::Thickness, Self::CosIncidence, Self::GroundAlbedo]).collect()
    }

    /// The mass fraction of a substance.
    #[must_use]
    pub const fn impurity(substance: Substance) -> Self {
        Self::Snow(Property::Impurity(substance))
    }

    /// Its name: the key of the parameter, or the name of the substance.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Snow(Property::Impurity(substance)) => substance.name(),
            Self::Snow(property) => property.key(),
            Self::Thickness => THICKNESS.key,
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

    /// Checks that there are derivatives with respect to the variable, and that the tables of the constituents that
    /// it adds cover `wavelength_nm`.
    ///
    /// # Errors
    /// For a property without derivatives, and if a table does not cover the wavelength.
    pub(crate) fn check_at(self, wavelength_nm: f64) -> Result<(), TransportError> {
        let Self::Snow(property) = self else { return Ok(()) };
        if !property.has_derivative() {
            let quantity = property.parameter().range.quantity;
            return Err(TransportError::Combination { quantity, rule: "has no derivatives" });
        }
        let mut sample = SnowSample::default();
        property.set(&mut sample, 1.0);
        sample.check_wavelength(wavelength_nm)
    }
}

/// A variable of one layer, the common variable of all layers, or a variable of the light or of the ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LayerVariable {
    /// The variable.
    pub variable: Variable,
    /// Index of the layer, counted from the top; none for a variable of all layers, of the light or of the ground.
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

    /// Whether both variables change one quantity of a layer, of the light or of the ground.
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.variable == other.variable && (self.layer.is_none() || other.layer.is_none() || self.layer == other.layer)
    }

    /// The layers to which the variable belongs. Clear ice has no variable but its thickness.
    pub(crate) fn of<'l>(&self, layers: &'l [Layer]) -> impl Iterator<Item = &'l Layer> + use<'l> {
        let by = *self;
        layers.iter().enumerate().filter(move |(layer, one)| by.is_of(*layer, one)).map(|(_, one)| one)
    }

    /// Mutable references to the layers to which the variable belongs.
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
        let substance = name.parse::<Substance>().map(Self::impurity);
        substance.or_else(|_| find_by_name("parameter", name, &Self::all(), Self::name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_variable_has_a_name() {
        for variable in Variable::all() {
            assert_eq!(variable.to_string().parse(), Ok(variable));
            assert_eq!(variable.to_string().replace('-', "_").parse(), Ok(variable));
        }
        let message = "size".parse::<Variable>().unwrap_err().to_string();
        assert!(message.starts_with("parameter 'size' is not known; there are ssa_m2_kg, density_kg_m3"), "{message}");
    }
}
