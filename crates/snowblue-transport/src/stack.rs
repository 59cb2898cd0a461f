//! Layers of different snow, and of clear ice, on a ground under light, and their fluxes above, below and at any depth.
//!
//! **Clear ice.** A layer of ice has no bubbles and smooth, parallel faces to air. Light refracts at its faces by
//! Fresnel's equations and is absorbed along its path; nothing scatters it. Multiple reflections between the two
//! faces are summed by power, separately for both polarisations, because the ice is thick compared with the
//! wavelength and the coherence length of the light. The light that leaves the ice is the mean of both polarisations.
//! Between layers light has no polarisation. Neighbouring layers of ice are one slab. The ground is under air as
//! well.

use snowblue_base::ParameterRange;

use crate::error::TransportError;
use crate::ground::GroundAlbedo;
use crate::optics::IceTable;
use crate::parameters::THICKNESS;
use crate::sample::SnowSample;
use crate::slab::{Estimate, Fluxes, Incidence, Radiometry, check_incidences, check_thickness, check_wavelengths};

/// Thickness of a layer of clear ice, in cm: greater than the coherence length of visible light in a band of 10 nm.
///
/// The coherence length λ²/Δλ is 0.05 mm at 700 nm. At 1600 nm it is 0.26 mm, as long as the round trip through the
/// least thickness.
pub const ICE_THICKNESS_RANGE: ParameterRange =
    ParameterRange { quantity: "thickness of ice", least: 0.01, greatest: THICKNESS.range.greatest, unit: "cm" };

/// The word for a layer of clear ice, by the key `kind`.
pub(crate) const ICE_KIND: &str = "ice";

/// Relative rounding by which a depth may exceed the sum of the thicknesses.
const DEPTH_ROUNDING: f64 = 1e-12;

/// A layer of one snow sample, or of clear ice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layer {
    /// The material of the layer.
    pub kind: LayerKind,
    /// Thickness, in cm; infinity for the last layer of a half-space of snow, by ordinates only.
    pub thickness_cm: f64,
}

/// The material of a layer.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "almost all layers are snow")]
pub enum LayerKind {
    /// Snow.
    Snow(SnowSample),
    /// Clear ice, by a table of its absorption.
    Ice(IceTable),
}

/// Layers of snow and ice on a Lambertian ground, under every incidence at every wavelength.
#[derive(Debug, Clone, PartialEq)]
pub struct Stack {
    /// Layers, top first.
    pub layers: Vec<Layer>,
    /// Albedo of the ground.
    pub ground_albedo: GroundAlbedo,
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
    /// Unscattered part of the transmittance: exp(−τ/μ₀), or 2 E₃(τ) for Lambertian light; less the light that ice
    /// reflects and absorbs.
    pub direct: f64,
    /// Fluxes at each of the depths. Automatic streams are chosen for T: just below the top at 80° the fluxes have an
    /// error of 1.5·10⁻⁴.
    pub profile: Vec<DepthFluxes>,
}

/// Fluxes through a horizontal plane in the snow over the incident flux, or the derivative of each of them.
///
/// At a face of ice the fluxes and the fluence rate are given outside the ice: in the snow, or in the air above the
/// top and at the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthFluxes<T = Estimate> {
    /// Flux downwards, direct and diffuse.
    pub down: T,
    /// Flux upwards.
    pub up: T,
    /// Flux downwards less flux upwards: the flux that the snow and the ground below absorb.
    pub net: T,
    /// Fluence rate, from all directions: the actinic flux. It is 1/cos θ for a beam that nothing has scattered, 2
    /// for Lambertian light on one side, and 4 times `down` where light is isotropic. In ice it is the fluence rate
    /// of the refracted light.
    pub fluence: T,
    /// Flux that the snow below this depth absorbs per m of depth, in 1/m. At the ground and at the top of ice under
    /// snow, the absorption of the snow above; at a face of ice to air, the absorption of the ice.
    pub absorbed_per_m: T,
    /// E-folding depth of the layer that `absorbed_per_m` belongs to, in cm: the distance over which light decays by
    /// e far from all faces, 1/(κ k) with the rate k of the slowest mode per optical depth. The e-folding depth of
    /// ice is the inverse of its absorption coefficient.
    pub e_folding_depth_cm: T,
}

/// Derivatives of the fluxes of a stack with respect to one quantity, per unit of it.
#[derive(Debug, Clone, PartialEq)]
pub struct StackDerivatives {
    /// Derivatives of the fluxes of the whole stack.
    pub whole: Fluxes<f64>,
    /// Derivatives at each of the depths. Depths below the top stay fixed as faces move. At a face the derivatives
    /// belong to the snow below the face; at the ground and at the top of ice they belong to the snow above. A depth
    /// at the ground under ice moves with the ground.
    pub profile: Vec<DepthFluxes<f64>>,
}

/// A part of a layer between two depths, or a slab of ice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Slice {
    /// Index of the layer; for several layers of ice, of the first one.
    pub(crate) layer: usize,
    /// Whether the slice is ice, with all neighbouring ice.
    pub(crate) is_ice: bool,
    /// Thickness of the slice, in cm.
    pub(crate) thickness_cm: f64,
    /// Its top and its bottom.
    pub(crate) ends: [SliceEnd; 2],
}

/// Where a slice ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SliceEnd {
    /// At the bottom of this number of layers.
    Face(usize),
    /// At one of the depths, which do not move with faces.
    Depth,
}

/// A stack cut at its depths.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Slices {
    /// Slices, top first. Ice is in one piece with neighbouring ice.
    pub(crate) slices: Vec<Slice>,
    /// Where each depth is.
    pub(crate) places: Vec<Place>,
}

/// Where a depth is in a cut stack.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Place {
    /// At a face, counted from the top.
    Face(usize),
    /// Within a slice of ice, at a depth in cm below its top.
    Ice {
        /// Index of the slice.
        slice: usize,
        /// Depth below its top, in cm.
        depth_cm: f64,
    },
}

impl Stack {
    /// Checks every layer, the ground, and every depth, angle and wavelength.
    ///
    /// # Errors
    /// Reports the first quantity that is missing or lies outside its range.
    pub fn check(&self) -> Result<(), TransportError> {
        self.check_pack()?;
        self.ground_albedo.check_wavelengths(&self.wavelengths_nm)?;
        self.layers.iter().try_for_each(|layer| layer.check_wavelengths(&self.wavelengths_nm))
    }

    /// Checks all but the wavelengths.
    pub(crate) fn check_pack(&self) -> Result<(), TransportError> {
        if self.layers.is_empty() {
            return Err(TransportError::Missing { quantity: "layer" });
        }
        for (index, layer) in self.layers.iter().enumerate() {
            layer.check(index + 1 == self.layers.len())?;
        }
        for pair in self.layers.windows(2) {
            if let [LayerKind::Ice(above), LayerKind::Ice(below)] = [pair[0].kind, pair[1].kind]
                && above != below
            {
                let rule = "of neighbouring layers of ice must be one, as they are one slab";
                return Err(TransportError::Combination { quantity: "ice table", rule });
            }
        }
        self.ground_albedo.check()?;
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

    /// The layer below each of the depths; at the ground, the last layer. Layers of zero thickness do not count.
    ///
    /// # Panics
    /// If there is no layer.
    #[must_use]
    pub fn layers_at_depths(&self) -> Vec<&Layer> {
        let slices = self.slices();
        slices.places.iter().map(|place| &self.layers[slices.layer_at(*place)]).collect()
    }

    /// The layers, cut at every depth below the top in snow. At the depth of a face a slice has no thickness.
    pub(crate) fn slices(&self) -> Slices {
        let mut cuts: Vec<f64> = self.depths_cm.iter().copied().filter(|cut_cm| *cut_cm > 0.0).collect();
        cuts.sort_by(f64::total_cmp);
        cuts.dedup();
        let mut places_of_cuts = Vec::with_capacity(cuts.len());
        let mut slices = Vec::new();
        let (mut layer, mut top_cm) = (0, 0.0);
        // Neighbouring layers of ice are one piece.
        for piece in self.layers.chunk_by(|above, below| above.is_ice() && below.is_ice()) {
            let (next, is_ice) = (layer + piece.len(), piece[0].is_ice());
            let bottom_cm = piece.iter().fold(top_cm, |sum, layer| sum + layer.thickness_cm);
            let rounding_cm = DEPTH_ROUNDING * bottom_cm;
            // A cut at the ground, or at the top of ice, is above it.
            let is_above = |cut_cm: f64| match self.layers.get(next) {
                None => true,
                Some(below) => cut_cm < bottom_cm || (below.is_ice() && cut_cm <= bottom_cm + rounding_cm),
            };
            let own: Vec<f64> =
                cuts[places_of_cuts.len()..].iter().copied().take_while(|cut_cm| is_above(*cut_cm)).collect();
            if is_ice {
                let top = slices.len();
                places_of_cuts.extend(own.iter().map(|cut_cm| match cut_cm {
                    _ if *cut_cm <= top_cm + rounding_cm => Place::Face(top),
                    _ if *cut_cm >= bottom_cm - rounding_cm => Place::Face(top + 1),
                    _ => Place::Ice { slice: top, depth_cm: cut_cm - top_cm },
                }));
            }
            let (mut from_cm, mut from) = (top_cm, SliceEnd::Face(layer));
            for cut_cm in own.iter().filter(|_| !is_ice) {
                // Beyond the last face there is only rounding.
                let to_cm = cut_cm.min(bottom_cm);
                let thickness_cm = (to_cm - from_cm).max(0.0);
                slices.push(Slice { layer, is_ice, thickness_cm, ends: [from, SliceEnd::Depth] });
                (from_cm, from) = (to_cm, SliceEnd::Depth);
                places_of_cuts.push(Place::Face(slices.len()));
            }
            let ends = [from, SliceEnd::Face(next)];
            slices.push(Slice { layer, is_ice, thickness_cm: (bottom_cm - from_cm).max(0.0), ends });
            (layer, top_cm) = (next, bottom_cm);
        }
        let place = |depth_cm: &f64| {
            let cut = cuts.partition_point(|cut_cm| cut_cm < depth_cm);
            if *depth_cm > 0.0 { places_of_cuts[cut] } else { Place::Face(0) }
        };
        let places = self.depths_cm.iter().map(place).collect();
        Slices { slices, places }
    }
}

impl Slice {
    /// The derivative of the thickness of the slice with respect to the thickness of a layer. Faces below the layer
    /// move down; depths do not move.
    pub(crate) fn growth(&self, layer: usize) -> f64 {
        let [top, bottom] = self.ends.map(|end| match end {
            SliceEnd::Face(layers) if layers > layer => 1.0,
            SliceEnd::Face(_) | SliceEnd::Depth => 0.0,
        });
        bottom - top
    }

    /// Whether its top moves down with the thickness of a layer.
    pub(crate) fn moves_with(&self, layer: usize) -> bool {
        matches!(self.ends[0], SliceEnd::Face(layers) if layers > layer)
    }
}

impl Slices {
    /// Index of the layer to which a place belongs: the layer below a face, but the layer above at the ground and at
    /// the top of ice. Slices of zero thickness do not count.
    pub(crate) fn layer_at(&self, place: Place) -> usize {
        self.slices[self.slice_at(place)].layer
    }

    /// The slice of ice to which a place belongs, with the depth below its top, in cm.
    pub(crate) fn ice_at(&self, place: Place) -> Option<(usize, f64)> {
        let slice = self.slice_at(place);
        let Slice { is_ice, thickness_cm, .. } = self.slices[slice];
        let depth_cm = match place {
            Place::Ice { depth_cm, .. } => depth_cm,
            Place::Face(face) if face <= slice => 0.0,
            Place::Face(_) => thickness_cm,
        };
        is_ice.then_some((slice, depth_cm))
    }

    fn slice_at(&self, place: Place) -> usize {
        let face = match place {
            Place::Ice { slice, .. } => return slice,
            Place::Face(face) => face,
        };
        let is_thick = |slice: &usize| self.slices[*slice].thickness_cm > 0.0;
        let below = (face..self.slices.len()).find(is_thick);
        let is_beyond_snow = |slice: &usize| *slice > face && self.slices[*slice].is_ice;
        let above = || (0..face).rev().find(is_thick);
        below.filter(|slice| !is_beyond_snow(slice)).or_else(above).or(below).unwrap_or(self.slices.len() - 1)
    }
}

impl Layer {
    /// A layer of snow.
    #[must_use]
    pub fn snow(sample: SnowSample, thickness_cm: f64) -> Self {
        Self { kind: LayerKind::Snow(sample), thickness_cm }
    }

    /// A layer of clear ice.
    #[must_use]
    pub fn ice(table: IceTable, thickness_cm: f64) -> Self {
        Self { kind: LayerKind::Ice(table), thickness_cm }
    }

    /// The snow; none of ice.
    #[must_use]
    pub fn sample(&self) -> Option<&SnowSample> {
        match &self.kind {
            LayerKind::Snow(sample) => Some(sample),
            LayerKind::Ice(_) => None,
        }
    }

    /// The snow, to change it; none of ice.
    pub fn sample_mut(&mut self) -> Option<&mut SnowSample> {
        match &mut self.kind {
            LayerKind::Snow(sample) => Some(sample),
            LayerKind::Ice(_) => None,
        }
    }

    /// Whether it is clear ice.
    #[must_use]
    pub fn is_ice(&self) -> bool {
        self.sample().is_none()
    }

    /// Checks the snow and the thickness, which may be infinite if this is the last layer, of snow.
    ///
    /// # Errors
    /// Reports the first quantity that lies outside its range.
    pub fn check(&self, is_last: bool) -> Result<(), TransportError> {
        let Some(sample) = self.sample() else {
            return Ok(ICE_THICKNESS_RANGE.check(self.thickness_cm)?);
        };
        sample.check()?;
        let check = if is_last { check_thickness } else { |thickness_cm| THICKNESS.range.check(thickness_cm) };
        Ok(check(self.thickness_cm)?)
    }

    /// Checks that there are wavelengths and that the tables of all constituents of the layer cover them.
    pub(crate) fn check_wavelengths(&self, wavelengths_nm: &[f64]) -> Result<(), TransportError> {
        match &self.kind {
            LayerKind::Snow(sample) => check_wavelengths(wavelengths_nm, sample),
            LayerKind::Ice(table) => {
                check_wavelengths(wavelengths_nm, &SnowSample { ice: *table, ..SnowSample::default() })
            }
        }
    }
}

/// Checks the word for the kind of a layer that is not snow, and that no `property` of snow, by its key, is given for
/// it.
///
/// # Errors
/// For an unknown kind, and for a property.
pub fn check_kind(kind: &str, property: Option<&str>) -> Result<(), TransportError> {
    if kind != ICE_KIND {
        return Err(TransportError::LayerKind { name: kind.to_owned() });
    }
    property.map_or(Ok(()), |key| Err(TransportError::IceProperty { key: key.to_owned() }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stack(thicknesses_cm: &[f64], depths_cm: &[f64]) -> Stack {
        let layer = |thickness_cm: &f64| Layer::snow(SnowSample::default(), *thickness_cm);
        Stack {
            layers: thicknesses_cm.iter().map(layer).collect(),
            ground_albedo: 0.0.into(),
            depths_cm: depths_cm.to_vec(),
            incidences: vec![Incidence::Diffuse],
            wavelengths_nm: vec![500.0],
        }
    }

    #[test]
    fn slices_end_at_faces_and_depths() {
        use SliceEnd::{Depth, Face};
        let Slices { slices, places } = stack(&[2.0, 3.0], &[5.0, 0.0, 1.0, 2.0, 4.0, 1.0]).slices();
        let expected = [
            (0, 1.0, [Face(0), Depth]),
            (0, 1.0, [Depth, Face(1)]),
            (1, 0.0, [Face(1), Depth]),
            (1, 2.0, [Depth, Depth]),
            (1, 1.0, [Depth, Depth]),
            (1, 0.0, [Depth, Face(2)]),
        ];
        assert_eq!(
            slices,
            expected.map(|(layer, thickness_cm, ends)| Slice { layer, is_ice: false, thickness_cm, ends })
        );
        assert_eq!(places, [5, 0, 1, 3, 4, 1].map(Place::Face));
        // The first layer's thickness moves the second between its cuts.
        let growths: Vec<f64> = slices.iter().map(|slice| slice.growth(0)).collect();
        assert_eq!(growths, [0.0, 1.0, -1.0, 0.0, 0.0, 1.0]);
        let growth: f64 = slices.iter().map(|slice| slice.growth(1)).sum();
        assert!((growth - 1.0).abs() < 1e-15);
        // Layers of no thickness lie below no depth.
        let slices = stack(&[0.0, 2.0, 0.0, 3.0, 0.0], &[0.0, 1.0, 2.0, 3.0, 5.0]).slices();
        let layers: Vec<usize> = slices.places.iter().map(|place| slices.layer_at(*place)).collect();
        assert_eq!(layers, [1, 1, 3, 3, 3]);
        // The sum of three tenths rounds to above 0.3, which leaves a last slice of no thickness.
        let Slices { slices, places } = stack(&[0.1, 0.1, 0.1], &[0.3]).slices();
        assert_eq!((slices.len(), places[0]), (4, Place::Face(3)));
    }

    #[test]
    fn depths_lie_in_the_snow() {
        assert_eq!(stack(&[0.1, 0.7], &[0.8]).check(), Ok(()));
        let message = stack(&[1.0, 2.0], &[3.1]).check().unwrap_err().to_string();
        assert_eq!(message, "depth is 3.1 cm, but must lie in 0–3 cm");
        let bright = Stack { ground_albedo: 1.5.into(), ..stack(&[1.0], &[]) };
        assert!(bright.check().unwrap_err().to_string().starts_with("ground albedo is 1.5"));
        assert!(stack(&[], &[]).check().is_err());
    }

    #[test]
    fn only_the_last_layer_is_a_half_space() {
        assert_eq!(stack(&[1.0, f64::INFINITY], &[0.5, 1e9]).check(), Ok(()));
        let message = stack(&[f64::INFINITY, 1.0], &[]).check().unwrap_err().to_string();
        assert_eq!(message, "thickness is inf cm, but must lie in 0–100000 cm");
        let Slices { slices, places } = stack(&[1.0, f64::INFINITY], &[0.5, 4.0]).slices();
        let last = slices[slices.len() - 1];
        assert!(last.layer == 1 && last.thickness_cm.is_infinite());
        assert_eq!(places, [1, 3].map(Place::Face));
    }

    /// Ice is not cut, neighbouring ice is one slab, and depths at its faces are in the snow beside it.
    #[test]
    fn ice_is_in_one_piece() {
        use SliceEnd::{Depth, Face};
        let mut pack = stack(&[2.0, 0.5, 0.25, 3.0, 1.0], &[0.0, 2.0, 2.25, 2.5, 2.75, 5.75, 6.0, 6.75]);
        for layer in [1, 2, 4] {
            pack.layers[layer].kind = LayerKind::Ice(IceTable::default());
        }
        let slices = pack.slices();
        let expected = [
            (0, false, 2.0, [Face(0), Depth]),
            (0, false, 0.0, [Depth, Face(1)]),
            (1, true, 0.75, [Face(1), Face(3)]),
            (3, false, 0.0, [Face(3), Depth]),
            (3, false, 3.0, [Depth, Depth]),
            (3, false, 0.0, [Depth, Face(4)]),
            (4, true, 1.0, [Face(4), Face(5)]),
        ];
        let expected = expected.map(|(layer, is_ice, thickness_cm, ends)| Slice { layer, is_ice, thickness_cm, ends });
        assert_eq!(slices.slices, expected);
        let ice = |slice: usize, depth_cm: f64| Place::Ice { slice, depth_cm };
        let face = Place::Face;
        assert_eq!(
            slices.places,
            [face(0), face(1), ice(2, 0.25), ice(2, 0.5), face(4), face(5), ice(6, 0.25), face(7)]
        );
        let layers: Vec<usize> = slices.places.iter().map(|place| slices.layer_at(*place)).collect();
        assert_eq!(layers, [0, 0, 1, 1, 3, 3, 4, 4]);
        let ice: Vec<Option<(usize, f64)>> = slices.places.iter().map(|place| slices.ice_at(*place)).collect();
        let (none, inner) = (None, [Some((2, 0.25)), Some((2, 0.5))]);
        assert_eq!(ice, [none, none, inner[0], inner[1], none, none, Some((6, 0.25)), Some((6, 1.0))]);
        let on_top = Stack { layers: pack.layers[4..].to_vec(), depths_cm: vec![0.0], ..pack };
        let slices = on_top.slices();
        assert_eq!((slices.places[0], slices.ice_at(slices.places[0])), (face(0), Some((0, 0.0))));
    }

    #[test]
    fn ice_is_neither_thin_nor_endless() {
        let ice = |thickness_cm| Layer::ice(IceTable::default(), thickness_cm);
        assert_eq!(ice(0.01).check(false), Ok(()));
        for thickness_cm in [0.0, 0.009, f64::INFINITY] {
            let message = ice(thickness_cm).check(true).unwrap_err().to_string();
            assert!(message.starts_with("thickness of ice is"), "{message}");
        }
    }
}
