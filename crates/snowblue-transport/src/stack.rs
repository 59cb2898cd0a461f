//! The question, and its answer, for layers of different snow on a ground: what comes back, what arrives below, and the
//! fluxes at any depth.

use crate::TransportError;
use crate::sample::SnowSample;
use crate::slab::{Estimate, Incidence, Radiometry, check_incidences, check_thickness, check_wavelengths};

/// A depth may exceed the sum of the thicknesses by this share: their rounding.
const DEPTH_ROUNDING: f64 = 1e-12;

/// Snow of one kind, and how thick it lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layer {
    /// The snow.
    pub sample: SnowSample,
    /// Thickness, in cm.
    pub thickness_cm: f64,
}

/// Layers of snow over a Lambertian ground, under every light at every wavelength.
#[derive(Debug, Clone, PartialEq)]
pub struct Stack {
    /// Layers, top first.
    pub layers: Vec<Layer>,
    /// Albedo of the ground, 0–1; over 0 a stack is a free slab.
    pub ground_albedo: f64,
    /// Depths below the top at which fluxes are asked for, in cm.
    pub depths_cm: Vec<f64>,
    /// Directions of the light.
    pub incidences: Vec<Incidence>,
    /// Wavelengths, in nm.
    pub wavelengths_nm: Vec<f64>,
}

/// What a stack does to light of one wavelength from one direction.
#[derive(Debug, Clone, PartialEq)]
pub struct StackRadiometry {
    /// Fluxes over the incident flux for the whole thickness: what leaves on top, what arrives at the ground (again and
    /// again, where the ground sends it back), and what stays in the snow, 1 − R − (1 − albedo) T.
    pub whole: Radiometry,
    /// The part of the transmittance that met no grain: exp(−τ/μ₀), or 2 E₃(τ) for Lambertian light.
    pub direct: f64,
    /// Fluxes at each of the depths. Automatic streams keep T, not these: just under the top at 80° they are off by 1.5·10⁻⁴.
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
    /// Downwards less upwards: what the snow and the ground below take up.
    pub net: Estimate,
    /// E-folding depth of the snow that begins at this depth (at the ground, that ends there), in cm: the way on which
    /// light of any origin fades by e far from all faces, 1/(κ k) with the slowest mode's rate k per optical depth.
    pub e_folding_depth_cm: Estimate,
}

impl Stack {
    /// Checks every layer, the ground, and every depth, angle and wavelength.
    ///
    /// # Errors
    /// The first quantity that is missing or lies outside its range.
    pub fn check(&self) -> Result<(), TransportError> {
        if self.layers.is_empty() {
            return Err(TransportError::Nothing { quantity: "layer" });
        }
        for layer in &self.layers {
            layer.check()?;
            check_wavelengths(&self.wavelengths_nm, &layer.sample)?;
        }
        TransportError::check("ground albedo", self.ground_albedo, (0.0, 1.0), "")?;
        let bottom_cm = self.thickness_cm();
        for depth_cm in &self.depths_cm {
            let within = (0.0..=bottom_cm * (1.0 + DEPTH_ROUNDING)).contains(depth_cm);
            let range = (0.0, if within { *depth_cm } else { bottom_cm });
            TransportError::check("depth", *depth_cm, range, " cm")?;
        }
        check_incidences(&self.incidences)
    }

    /// Thickness of all layers, in cm.
    #[must_use]
    pub fn thickness_cm(&self) -> f64 {
        self.layers.iter().map(|layer| layer.thickness_cm).sum()
    }

    /// The layers cut at every depth asked for: the number of the layer and the thickness of the slice.
    ///
    /// The second list has the number of the face at each depth, counted from the top.
    pub(crate) fn slices(&self) -> (Vec<(usize, f64)>, Vec<usize>) {
        let mut cuts = self.depths_cm.clone();
        cuts.sort_by(f64::total_cmp);
        let mut faces_cm = vec![0.0];
        let mut slices = Vec::new();
        let mut bottom_cm = 0.0;
        for (number, layer) in self.layers.iter().enumerate() {
            let mut top_cm = bottom_cm;
            bottom_cm += layer.thickness_cm;
            for cut_cm in cuts.iter().copied().filter(|cut_cm| *cut_cm < bottom_cm) {
                if cut_cm > top_cm {
                    slices.push((number, cut_cm - top_cm));
                    faces_cm.push(cut_cm);
                    top_cm = cut_cm;
                }
            }
            slices.push((number, bottom_cm - top_cm));
            faces_cm.push(bottom_cm);
        }
        // The first face not above the depth; beyond the last there is only rounding.
        let face = |depth_cm: &f64| faces_cm.partition_point(|face_cm| face_cm < depth_cm).min(slices.len());
        let faces = self.depths_cm.iter().map(face).collect();
        (slices, faces)
    }
}

impl Layer {
    /// Checks the snow and the thickness.
    ///
    /// # Errors
    /// The first quantity that lies outside its range.
    pub fn check(&self) -> Result<(), TransportError> {
        self.sample.check()?;
        check_thickness(self.thickness_cm)
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
        let (slices, faces) = stack(&[2.0, 3.0], &[5.0, 0.0, 1.0, 2.0, 4.0, 1.0]).slices();
        assert_eq!(slices, [(0, 1.0), (0, 1.0), (1, 2.0), (1, 1.0)]);
        assert_eq!(faces, [4, 0, 1, 2, 3, 1]);
        // The sum of three tenths lies above .3, which is thus cut off as the last slice but nothing.
        let (slices, faces) = stack(&[0.1, 0.1, 0.1], &[0.3]).slices();
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
}
