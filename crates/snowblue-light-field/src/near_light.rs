//! The light around a point inside a body, at all wavelengths.
//!
//! Light at all wavelengths follows from the spectral nodes by its logarithm, which needs an exponential for each
//! wavelength and is not linear: the sum of two spectra is not the spectrum of the sum, and a difference has no
//! logarithm. But the ratio of the light at two points some mean free paths apart varies so little with the wavelength
//! that it interpolates linearly. So light around a point is that at the point times ratios. It is linear, and a mean
//! over many points has no bias by the interpolation.

use arrayvec::ArrayVec;
use glam::Vec3A;
use snowblue_field::MOST_GROUPS;
use snowblue_geometry::ray::SurfacePoint;
use wide::f32x4;

use super::body_field::{BodyField, LitFluence, MOST_NODES};
use snowblue_scene::spectrum::Spectrum;

/// Values at the spectral nodes, in groups.
type Nodes = ArrayVec<f32x4, MOST_GROUPS>;

/// The light around a point inside a body.
pub struct NearLight<'f> {
    field: &'f BodyField,
    /// By lights of each spectrum.
    lit: Vec<NearFluence<'f>>,
}

/// The same by lights of one spectrum.
struct NearFluence<'f> {
    lit: &'f LitFluence,
    /// A spectrum that light around the point is nearly proportional to, and its reciprocal at the nodes.
    spectrum: Spectrum,
    reciprocals: Nodes,
    /// At the point.
    fluence: Nodes,
    /// Per m.
    gradient: [Nodes; 3],
    /// The diffuse irradiance H of the surface near the point.
    diffuse: Nodes,
}

/// Factors of the quantities of a [`NearLight`].
#[derive(Debug, Clone, Copy)]
pub struct LightWeights {
    /// Of the fluence rate at the point.
    pub fluence: f32,
    /// Of its gradient, in m.
    pub gradient: Vec3A,
    /// Of the diffuse irradiance H.
    pub diffuse: f32,
}

impl<'f> NearLight<'f> {
    /// The light around a point below a surface; none if the grid has no cell there.
    pub fn new(field: &'f BodyField, point: Vec3A, surface: &SurfacePoint) -> Option<Self> {
        let lit: Option<Vec<_>> = field.lit.iter().map(|lit| NearFluence::new(field, lit, point, surface)).collect();
        Some(Self { field, lit: lit? })
    }

    /// The fluence rate at another point, in W m⁻² as a band density.
    pub fn fluence(&self, point: Vec3A) -> Spectrum {
        let mut sum = Spectrum::ZERO;
        for near in &self.lit {
            if let Some(groups) = self.field.body.fluence(&near.lit.fluence, point.as_dvec3()) {
                sum += near.spectrum(self.field, groups);
            }
        }
        sum
    }

    /// The diffuse irradiance H of a surface point near by, in W m⁻² as a band density.
    pub fn diffuse_irradiance(&self, surface: &SurfacePoint) -> Spectrum {
        let mut sum = Spectrum::ZERO;
        for near in &self.lit {
            if let Some(groups) = diffuse_irradiance(self.field, near.lit, surface) {
                sum += near.spectrum(self.field, groups);
            }
        }
        sum
    }

    /// A sum of the quantities at the point, in W m⁻² as a band density.
    pub fn sum(&self, weights: &LightWeights) -> Spectrum {
        let mut sum = Spectrum::ZERO;
        for near in &self.lit {
            let group = |k: usize| {
                let [x, y, z] = [0, 1, 2].map(|axis| near.gradient[axis][k] * weights.gradient[axis]);
                let diffuse = near.diffuse.get(k).map_or(f32x4::ZERO, |diffuse| *diffuse * weights.diffuse);
                near.fluence[k] * weights.fluence + x + y + z + diffuse
            };
            sum += near.spectrum(self.field, (0..near.fluence.len()).map(group));
        }
        sum
    }
}

impl<'f> NearFluence<'f> {
    fn new(field: &'f BodyField, lit: &'f LitFluence, point: Vec3A, surface: &SurfacePoint) -> Option<Self> {
        let fluence: Nodes = field.body.fluence(&lit.fluence, point.as_dvec3())?.collect();
        let mut gradient = [(); 3].map(|()| Nodes::new());
        for group in field.body.gradient(&lit.fluence, point.as_dvec3())? {
            gradient.iter_mut().zip(group).for_each(|(axis, values)| axis.push(values));
        }
        let diffuse = diffuse_irradiance(field, lit, surface).into_iter().flatten().collect();
        // Where the grid is too coarse for the last of the light, it is proportional to the light source.
        let is_positive = fluence.iter().all(|values| values.as_array().iter().all(|value| *value > 0.0));
        let spectrum = if is_positive { field.spectrum(fluence.iter().copied(), &lit.spectrum) } else { lit.spectrum };
        let reciprocal = |index: usize| {
            let value = spectrum.0[index];
            if value >= f32::MIN_POSITIVE { value.recip() } else { 0.0 }
        };
        let reciprocals = field.nodes.gather(reciprocal).collect();
        Some(Self { lit, spectrum, reciprocals, fluence, gradient, diffuse })
    }

    /// All wavelengths of a quantity at the nodes.
    fn spectrum(&self, field: &BodyField, groups: impl Iterator<Item = f32x4>) -> Spectrum {
        let mut ratios = [0.0; MOST_NODES];
        let count = field.nodes.indices().len();
        for ((ratios, group), reciprocals) in
            ratios.chunks_exact_mut(snowblue_field::GROUP).zip(groups).zip(&self.reciprocals)
        {
            ratios.copy_from_slice((group * *reciprocals).as_array());
        }
        let value =
            |wavelength: usize| field.nodes.interpolate(wavelength, &ratios[..count]) * self.spectrum.0[wavelength];
        Spectrum(std::array::from_fn(value))
    }
}

/// The diffuse irradiance H of a surface point at the nodes, if there is any.
fn diffuse_irradiance<'f>(
    field: &'f BodyField,
    lit: &'f LitFluence,
    surface: &SurfacePoint,
) -> Option<impl Iterator<Item = f32x4> + use<'f>> {
    field.body.surface_value(lit.diffuse.as_ref()?, surface.point.as_dvec3(), surface.normal.as_dvec3())
}
