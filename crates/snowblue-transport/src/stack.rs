//! Layers of different snow on a ground under light, and their fluxes above, below and at any depth.

use snowblue_base::{Parameter, ParameterRange};

use crate::TransportError;
use crate::sample::SnowSample;
use crate::slab::{
    Estimate, FluxDerivatives, Incidence, Radiometry, THICKNESS_RANGE, check_incidences, check_thickness,
    check_wavelengths,
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

/// Derivatives of the fluxes of a stack with respect to one quantity, per unit of it.
#[derive(Debug, Clone, PartialEq)]
pub struct StackDerivatives {
    /// Of the whole stack.
    pub whole: FluxDerivatives,
    /// At each of the depths, which stay where they are below the top as faces move. At the depth of a face the
    /// derivatives are those in the snow below it, at the ground above it.
    pub profile: Vec<DepthDerivatives>,
}

/// Derivatives of [`DepthFluxes`] with respect to one quantity, per unit of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthDerivatives {
    /// Of the flux downwards.
    pub down: f64,
    /// Of the flux upwards.
    pub up: f64,
    /// Of the net flux.
    pub net: f64,
    /// Of the fluence rate.
    pub fluence: f64,
    /// Of the flux that is absorbed per m of depth, in 1/m.
    pub absorbed_per_m: f64,
    /// Of the e-folding depth, in cm.
    pub e_folding_depth_cm: f64,
}

/// A part of a layer between two depths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Slice {
    /// Index of the layer.
    pub(crate) layer: usize,
    /// Thickness of the slice, in cm.
    pub(crate) thickness_cm: f64,
    /// Its top and its bottom.
    pub(crate) ends: [SliceEnd; 2],
}

/// Where a slice ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SliceEnd {
    /// At the bottom of as many layers.
    Face(usize),
    /// At one of the depths, wherever faces are.
    Depth,
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
        self.check_pack()?;
        self.layers.iter().try_for_each(|layer| check_wavelengths(&self.wavelengths_nm, &layer.sample))
    }

    /// Checks all but the wavelengths.
    pub(crate) fn check_pack(&self) -> Result<(), TransportError> {
        if self.layers.is_empty() {
            return Err(TransportError::Missing { quantity: "layer" });
        }
        for (index, layer) in self.layers.iter().enumerate() {
            layer.check(index + 1 == self.layers.len())?;
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

    /// The layers, cut at every depth below the top. At the depth of a face a slice has no thickness.
    pub(crate) fn slices(&self) -> Slices {
        let mut cuts: Vec<f64> = self.depths_cm.iter().copied().filter(|cut_cm| *cut_cm > 0.0).collect();
        cuts.sort_by(f64::total_cmp);
        cuts.dedup();
        // The face at each cut.
        let mut faces_at_cuts = Vec::with_capacity(cuts.len());
        let mut slices = Vec::new();
        let mut bottom_cm = 0.0;
        for (layer, Layer { thickness_cm, .. }) in self.layers.iter().enumerate() {
            let (mut top_cm, mut top) = (bottom_cm, SliceEnd::Face(layer));
            bottom_cm += thickness_cm;
            let is_last = layer + 1 == self.layers.len();
            let mut slice = |to_cm: f64, bottom: SliceEnd| {
                // Beyond the last face there is only rounding.
                let thickness_cm = (to_cm - top_cm).max(0.0);
                slices.push(Slice { layer, thickness_cm, ends: [top, bottom] });
                (top_cm, top) = (to_cm, bottom);
                slices.len()
            };
            while let Some(cut_cm) = cuts.get(faces_at_cuts.len()).filter(|cut_cm| **cut_cm < bottom_cm || is_last) {
                faces_at_cuts.push(slice(cut_cm.min(bottom_cm), SliceEnd::Depth));
            }
            slice(bottom_cm, SliceEnd::Face(layer + 1));
        }
        let face = |depth_cm: &f64| {
            let cut = cuts.partition_point(|cut_cm| cut_cm < depth_cm);
            if *depth_cm > 0.0 { faces_at_cuts[cut] } else { 0 }
        };
        let faces = self.depths_cm.iter().map(face).collect();
        Slices { slices, faces }
    }
}

impl Slice {
    /// The derivative of the thickness with respect to that of a layer: faces below it move down, depths do not.
    pub(crate) fn growth(&self, layer: usize) -> f64 {
        let [top, bottom] = self.ends.map(|end| match end {
            SliceEnd::Face(layers) if layers > layer => 1.0,
            SliceEnd::Face(_) | SliceEnd::Depth => 0.0,
        });
        bottom - top
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
        use SliceEnd::{Depth, Face};
        let Slices { slices, faces } = stack(&[2.0, 3.0], &[5.0, 0.0, 1.0, 2.0, 4.0, 1.0]).slices();
        let expected = [
            (0, 1.0, [Face(0), Depth]),
            (0, 1.0, [Depth, Face(1)]),
            (1, 0.0, [Face(1), Depth]),
            (1, 2.0, [Depth, Depth]),
            (1, 1.0, [Depth, Depth]),
            (1, 0.0, [Depth, Face(2)]),
        ];
        assert_eq!(slices, expected.map(|(layer, thickness_cm, ends)| Slice { layer, thickness_cm, ends }));
        assert_eq!(faces, [5, 0, 1, 3, 4, 1]);
        // The first layer's thickness moves the second between its cuts.
        let growths: Vec<f64> = slices.iter().map(|slice| slice.growth(0)).collect();
        assert_eq!(growths, [0.0, 1.0, -1.0, 0.0, 0.0, 1.0]);
        let growth: f64 = slices.iter().map(|slice| slice.growth(1)).sum();
        assert!((growth - 1.0).abs() < 1e-15);
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
        let last = slices[slices.len() - 1];
        assert!(last.layer == 1 && last.thickness_cm.is_infinite());
        assert_eq!(faces, [1, 3]);
    }
}
