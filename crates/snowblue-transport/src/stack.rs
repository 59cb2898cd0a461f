//! Layers of different snow on a ground under light, and their fluxes above, below and at any depth.

use snowblue_base::{Parameter, ParameterRange};

use crate::TransportError;
use crate::sample::SnowSample;
use crate::slab::{
    Estimate, Incidence, Radiometry, THICKNESS_RANGE, check_incidences, check_thickness, check_wavelengths,
};

/// Albedo of the ground.
pub const GROUND_ALBEDO_RANGE: ParameterRange =
    ParameterRange { quantity: "ground albedo", least: 0.0, greatest: 1.0, unit: "" };

/// Albedo of the ground.
pub const GROUND_ALBEDO: Parameter = Parameter {
    key: "ground_albedo",
    title: "Ground albedo",
    range: GROUND_ALBEDO_RANGE,
    default: 0.0,
    text: "Albedo of the ground under the snow",
    effect: "It is the fraction of light that a matt ground sends back; 0 is no ground.",
    source: "Stamnes et al. 1988, doi:10.1364/AO.27.002502",
};

/// Relative rounding by which a depth may exceed the sum of the thicknesses.
const DEPTH_ROUNDING: f64 = 1e-12;

/// A layer of one snow sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layer {
    /// The snow.
    pub sample: SnowSample,
    /// Thickness, in cm; infinity for the last layer of a half-space, by ordinates only.
    pub thickness_cm: f64,
}

/// Layers of snow on a Lambertian ground, under every incidence at every wavelength.
#[derive(Debug, Clone, PartialEq)]
pub struct Stack {
    /// Layers, top first.
    pub layers: Vec<Layer>,
    /// Albedo of the ground, 0–1; with 0 the stack acts as a free slab.
    pub ground_albedo: f64,
    /// Depths below the top at which to compute fluxes, in cm.
    pub depths_cm: Vec<f64>,
    /// Incident light.
    pub incidences: Vec<Incidence>,
    /// Wavelengths, in nm.
    pub wavelengths_nm: Vec<f64>,
}

/// Fluxes of a stack for one incidence and wavelength.
#[derive(Debug, Clone, PartialEq)]
pub struct StackRadiometry {
    /// Fluxes of the whole stack over the incident flux: R leaves the top, T arrives at the ground (including light
    /// that the ground has reflected before), and the snow absorbs 1 − R − (1 − albedo) T.
    pub whole: Radiometry,
    /// Unscattered part of the transmittance: exp(−τ/μ₀), or 2 E₃(τ) for Lambertian light.
    pub direct: f64,
    /// Fluxes at each of the depths. Automatic streams are chosen for T: just below the top at 80° these are off by
    /// 1.5·10⁻⁴.
    pub profile: Vec<DepthFluxes>,
}

/// Fluxes through a horizontal plane in the snow over the incident flux.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthFluxes {
    /// Depth below the top, in cm.
    pub depth_cm: f64,
    /// Flux downwards, direct and diffuse.
    pub down: Estimate,
    /// Flux upwards.
    pub up: Estimate,
    /// Downwards less upwards: the flux that the snow and the ground below absorb.
    pub net: Estimate,
    /// Fluence rate, from all directions: the actinic flux. It is 1/cos θ for a beam that nothing has scattered, 2 for
    /// Lambertian light on one side, and 4 times `down` where light is isotropic.
    pub fluence: Estimate,
    /// Flux that the snow below this depth (at the ground, above it) absorbs per m of depth, in 1/m.
    pub absorbed_per_m: Estimate,
    /// E-folding depth of the snow below this depth (at the ground, above it), in cm: the distance over which light
    /// decays by e far from all faces, 1/(κ k) with the rate k of the slowest mode per optical depth.
    pub e_folding_depth_cm: Estimate,
}

/// A part of a layer between two depths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Slice {
    /// Index of the layer.
    pub(crate) layer: usize,
    /// Thickness of the slice, in cm.
    pub(crate) thickness_cm: f64,
}

/// A stack cut at its depths.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Slices {
    /// Slices, top first.
    pub(crate) slices: Vec<Slice>,
    /// The face at each depth, counted from the top.
    pub(crate) faces: Vec<usize>,
}

impl Stack {
    /// Checks every layer, the ground, and every depth, angle and wavelength.
    ///
    /// # Errors
    /// Reports the first quantity that is missing or lies outside its range.
    pub fn check(&self) -> Result<(), TransportError> {
        if self.layers.is_empty() {
            return Err(TransportError::Missing { quantity: "layer" });
        }
        for (index, layer) in self.layers.iter().enumerate() {
            layer.check(index + 1 == self.layers.len())?;
            check_wavelengths(&self.wavelengths_nm, &layer.sample)?;
        }
        GROUND_ALBEDO_RANGE.check(self.ground_albedo)?;
        let bottom_cm = self.thickness_cm();
        for depth_cm in &self.depths_cm {
            if !(0.0..=bottom_cm * (1.0 + DEPTH_ROUNDING)).contains(depth_cm) {
                let depths = ParameterRange { quantity: "depth", least: 0.0, greatest: bottom_cm, unit: "cm" };
                depths.check(*depth_cm)?;
            }
        }
        check_incidences(&self.incidences)
    }

    /// Thickness of all layers, in cm.
    #[must_use]
    pub fn thickness_cm(&self) -> f64 {
        self.layers.iter().map(|layer| layer.thickness_cm).sum()
    }

    /// The layer below each of the depths, at the ground the last; layers of no thickness are none.
    ///
    /// # Panics
    /// If there is no layer.
    #[must_use]
    pub fn layers_at_depths(&self) -> Vec<&Layer> {
        let slices = self.slices();
        slices.faces.iter().map(|face| &self.layers[slices.layer_below(*face)]).collect()
    }

    /// The layers, cut at every depth.
    pub(crate) fn slices(&self) -> Slices {
        let mut cuts = self.depths_cm.clone();
        cuts.sort_by(f64::total_cmp);
        let mut faces_cm = vec![0.0];
        let mut slices = Vec::new();
        let mut bottom_cm = 0.0;
        for (layer, Layer { thickness_cm, .. }) in self.layers.iter().enumerate() {
            let mut top_cm = bottom_cm;
            bottom_cm += thickness_cm;
            for cut_cm in cuts.iter().copied().filter(|cut_cm| *cut_cm < bottom_cm) {
                if cut_cm > top_cm {
                    slices.push(Slice { layer, thickness_cm: cut_cm - top_cm });
                    faces_cm.push(cut_cm);
                    top_cm = cut_cm;
                }
            }
            slices.push(Slice { layer, thickness_cm: bottom_cm - top_cm });
            faces_cm.push(bottom_cm);
        }
        // The first face not above the depth; beyond the last face there is only rounding.
        let face = |depth_cm: &f64| faces_cm.partition_point(|face_cm| face_cm < depth_cm).min(slices.len());
        let faces = self.depths_cm.iter().map(face).collect();
        Slices { slices, faces }
    }
}

impl Slices {
    /// Index of the layer below a face, at the ground of the last; slices of no thickness are none.
    pub(crate) fn layer_below(&self, face: usize) -> usize {
        let is_thick = |slice: &&Slice| slice.thickness_cm > 0.0;
        let (above, below) = self.slices.split_at(face);
        let slice = below.iter().find(is_thick).or_else(|| above.iter().rev().find(is_thick));
        slice.unwrap_or(&self.slices[self.slices.len() - 1]).layer
    }
}

impl Layer {
    /// Checks the snow and the thickness, which may be infinite if this is the last layer.
    ///
    /// # Errors
    /// Reports the first quantity that lies outside its range.
    pub fn check(&self, is_last: bool) -> Result<(), TransportError> {
        self.sample.check()?;
        let check = if is_last { check_thickness } else { |thickness_cm| THICKNESS_RANGE.check(thickness_cm) };
        Ok(check(self.thickness_cm)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stack(thicknesses_cm: &[f64], depths_cm: &[f64]) -> Stack {
        let layer = |thickness_cm: &f64| Layer { sample: SnowSample::default(), thickness_cm: *thickness_cm };
        Stack {
            layers: thicknesses_cm.iter().map(layer).collect(),
            ground_albedo: 0.0,
            depths_cm: depths_cm.to_vec(),
            incidences: vec![Incidence::Diffuse],
            wavelengths_nm: vec![500.0],
        }
    }

    #[test]
    fn slices_end_at_faces_and_depths() {
        let Slices { slices, faces } = stack(&[2.0, 3.0], &[5.0, 0.0, 1.0, 2.0, 4.0, 1.0]).slices();
        let expected = [(0, 1.0), (0, 1.0), (1, 2.0), (1, 1.0)];
        assert_eq!(slices, expected.map(|(layer, thickness_cm)| Slice { layer, thickness_cm }));
        assert_eq!(faces, [4, 0, 1, 2, 3, 1]);
        // Layers of no thickness lie below no depth.
        let slices = stack(&[0.0, 2.0, 0.0, 3.0, 0.0], &[0.0, 1.0, 2.0, 3.0, 5.0]).slices();
        let layers: Vec<usize> = slices.faces.iter().map(|face| slices.layer_below(*face)).collect();
        assert_eq!(layers, [1, 1, 3, 3, 3]);
        // The sum of three tenths rounds to above 0.3, which leaves a last slice of no thickness.
        let Slices { slices, faces } = stack(&[0.1, 0.1, 0.1], &[0.3]).slices();
        assert_eq!((slices.len(), faces[0]), (4, 3));
    }

    #[test]
    fn depths_lie_in_the_snow() {
        assert_eq!(stack(&[0.1, 0.7], &[0.8]).check(), Ok(()));
        let message = stack(&[1.0, 2.0], &[3.1]).check().unwrap_err().to_string();
        assert_eq!(message, "depth is 3.1 cm, but must lie in 0–3 cm");
        let bright = Stack { ground_albedo: 1.5, ..stack(&[1.0], &[]) };
        assert!(bright.check().unwrap_err().to_string().starts_with("ground albedo is 1.5"));
        assert!(stack(&[], &[]).check().is_err());
    }

    #[test]
    fn only_the_last_layer_is_a_half_space() {
        assert_eq!(stack(&[1.0, f64::INFINITY], &[0.5, 1e9]).check(), Ok(()));
        let message = stack(&[f64::INFINITY, 1.0], &[]).check().unwrap_err().to_string();
        assert_eq!(message, "thickness is inf cm, but must lie in 0–100000 cm");
        let Slices { slices, faces } = stack(&[1.0, f64::INFINITY], &[0.5, 4.0]).slices();
        assert_eq!(slices.last(), Some(&Slice { layer: 1, thickness_cm: f64::INFINITY }));
        assert_eq!(faces, [1, 3]);
    }
}
