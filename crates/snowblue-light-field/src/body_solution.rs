//! The light in a body of snow: at its surface, inside, and around a point at all wavelengths.
//!
//! The light at all wavelengths is interpolated from the logarithm of the light at the spectral nodes. This
//! interpolation needs an exponential for each wavelength and is not linear: the sum of two spectra is not the
//! spectrum of the sum, and a negative difference has no logarithm. However, the ratio of the light at two points some
//! mean free paths apart varies so little with the wavelength that it can be interpolated linearly. The light around a
//! point ([`NearLight`]) is therefore the light at the point times ratios. It is linear, and the interpolation does
//! not bias a mean over many points.

use std::f32::consts::FRAC_1_PI;
use std::sync::Arc;

use arrayvec::ArrayVec;
use glam::Vec3A;
use snowblue_field::{Fluence, MAX_GROUPS, SurfacePlace, SurfaceValues};
use snowblue_geometry::ray::SurfacePoint;
use snowblue_scene::objects::{Objects, SurfaceInteraction};
use snowblue_scene::sampling::Sampler;
use snowblue_scene::spectrum::Spectrum;
use wide::f32x4;

use crate::bodies::BodySystem;
use crate::body_optics::{BodyOptics, KindOptics};
use crate::direct_light::LightOnBody;
use crate::lit_scene::Illumination;

/// Greatest number of spectral nodes.
const MAX_NODES: usize = MAX_GROUPS * snowblue_field::GROUP;
/// Relative noise to which the irradiance by a sky is smoothed where it is read.
const SKY_NOISE: f32 = 0.01;
/// Depth of the layer below a surface in which cells do not resolve the light, as a share of the size of the cell. It
/// is near 1/π: light that varies from cell to cell decays along a cell divided by π.
const LAYER_CELLS: f32 = 1.0 / 3.0;
/// Least depth of this layer in transport mean free paths, and greatest depth as a share of the thickness of the snow.
/// In cells of up to 10 mean free paths and in thin snow, which light passes, the flux of the cells is better.
const LEAST_DEPTH_LENGTHS: f32 = 3.5;
const LAYER_THICKNESSES: f32 = 0.1;

/// The light in a body of snow.
pub struct BodySolution {
    pub(crate) system: Arc<BodySystem>,
    /// The light by the lights of each spectrum.
    pub(crate) lit: Vec<Arc<LitFluence>>,
}

/// The light at a point of the surface of a body, with the snow there.
#[derive(Clone, Copy)]
pub struct SnowAt<'f> {
    /// The light of the body.
    pub field: &'f BodySolution,
    /// The number of the kind of snow.
    pub kind: usize,
    /// The optics of this kind.
    pub optics: &'f KindOptics,
}

/// The light in a body by lights of one spectrum.
pub(crate) struct LitFluence {
    fluence: Fluence,
    /// The net flux J.
    flux: SurfaceValues,
    /// The exitance of the surface, J + Σ F + H.
    exitance: SurfaceValues,
    /// The irradiance H by uniform skies and other surfaces, if there is any.
    diffuse: Option<SurfaceValues>,
    /// The spectrum of the lights. If it is uniform over each light, it has some light at all wavelengths.
    spectrum: Spectrum,
    /// The fraction of this light that the lights emit.
    emitted: Spectrum,
    /// The irradiance by smooth skies, if the lights are such skies.
    sky: Option<SurfaceValues>,
}

impl LitFluence {
    /// Prepares the light inside a body for reads. `direct` and `diffuse`, H, are the light at its surface, and
    /// `spectrum` is the spectrum of the lights, as stored.
    pub(crate) fn new(
        illumination: &Illumination,
        direct: &LightOnBody,
        diffuse: &[Vec<f32x4>],
        fluence: Fluence,
        spectrum: Spectrum,
    ) -> Self {
        let cells = &direct.system.cells;
        let is_of_sky = illumination.lights.iter().all(|light| light.is_smooth_sky());
        let sky = is_of_sky.then(|| {
            let mut sky = direct.irradiance.clone();
            cells.denoise(&mut sky, SKY_NOISE);
            cells.smooth(&sky)
        });
        let fraction = |emitted: Spectrum| Spectrum(std::array::from_fn(|k| emitted.0[k] / spectrum.0[k]));
        let emitted = illumination.spectrum.map_or(Spectrum::ONE, fraction);
        let is_dark = diffuse.iter().flatten().all(|values| *values == f32x4::ZERO);
        let [flux, exitance] = direct.flux_and_exitance(diffuse, &fluence);
        let [flux, exitance] = cells.smooth_light(&flux, &exitance);
        Self { diffuse: (!is_dark).then(|| cells.smooth(diffuse)), exitance, flux, fluence, sky, spectrum, emitted }
    }
}

impl BodySolution {
    /// The light at a hit, with the snow there. In a mix, the sampler chooses one of the kinds.
    #[inline]
    pub fn at(&self, objects: &Objects, surface: &SurfaceInteraction, sampler: &mut Sampler) -> SnowAt<'_> {
        let mix = self.snow().kinds.at_surface(objects, surface);
        let kind = mix.draw(|| sampler.next_four()[0]);
        SnowAt { field: self, kind, optics: &self.snow().optics[kind] }
    }

    /// The snow.
    pub fn snow(&self) -> &Arc<BodyOptics> {
        &self.system.snow
    }

    /// The irradiance H by uniform skies and other surfaces, in W m⁻² as a band density.
    pub fn diffuse_irradiance(&self, surface: &SurfacePoint) -> Spectrum {
        self.at_surface(surface, |lit| lit.diffuse.as_ref())
    }

    /// The irradiance by smooth skies, in W m⁻² as a band density. It is sampled when the light field is computed, and
    /// smoothed over the size of a cell.
    pub fn sky_irradiance(&self, surface: &SurfacePoint) -> Spectrum {
        self.at_surface(surface, |lit| lit.sky.as_ref())
    }

    /// Radiance that leaves a surface point, equal in all directions: the exitance divided by π.
    pub fn mean_radiance(&self, surface: &SurfacePoint) -> Spectrum {
        self.exitance(surface) * FRAC_1_PI
    }

    /// The fluence rate inside, in W m⁻² as a band density.
    pub fn fluence(&self, point: Vec3A) -> Spectrum {
        self.sum(|lit| self.system.cells.fluence(&lit.fluence, point.as_dvec3()))
    }

    /// Size of the cells at the surface, in m.
    pub fn surface_step_m(&self) -> f64 {
        self.system.cells.surface_step_m()
    }

    /// The exitance of the surface, net flux plus irradiance, in W m⁻² as a band density.
    pub(crate) fn exitance(&self, surface: &SurfacePoint) -> Spectrum {
        self.at_surface(surface, |lit| Some(&lit.exitance))
    }

    /// The net flux outwards through the surface, in W m⁻² as a band density.
    pub fn flux(&self, surface: &SurfacePoint) -> Spectrum {
        self.at_surface(surface, |lit| Some(&lit.flux))
    }

    /// A quantity at a point of the surface; 0 if there is no cell near the point.
    fn at_surface(&self, surface: &SurfacePoint, values: impl Fn(&LitFluence) -> Option<&SurfaceValues>) -> Spectrum {
        let exists = self.lit.iter().any(|lit| values(lit).is_some());
        let place = exists.then(|| self.system.place(surface)).flatten();
        place.map_or(Spectrum::ZERO, |place| self.at_place(&place, values))
    }

    /// A quantity at a place of the surface: the sum over the lights of all spectra that have it.
    fn at_place(&self, place: &SurfacePlace, values: impl Fn(&LitFluence) -> Option<&SurfaceValues>) -> Spectrum {
        self.sum(|lit| Some(self.groups(values(lit)?, place)))
    }

    /// The sum over the lights of all spectra of a quantity at the spectral nodes.
    fn sum<'f, G: Iterator<Item = f32x4>>(&'f self, groups: impl Fn(&'f LitFluence) -> Option<G>) -> Spectrum {
        let mut sum = Spectrum::ZERO;
        for lit in &self.lit {
            if let Some(groups) = groups(lit) {
                sum += self.spectrum(groups, &lit.spectrum) * lit.emitted;
            }
        }
        sum
    }

    /// A quantity at a place of the surface for each group of spectral nodes.
    fn groups(&self, values: &SurfaceValues, place: &SurfacePlace) -> impl Iterator<Item = f32x4> + use<> {
        let groups = self.system.cells.value_at(values, place);
        groups.into_iter().take(self.system.nodes.group_count())
    }

    /// Interpolates a quantity from the spectral nodes to all wavelengths, in light of a spectrum. The logarithm is
    /// interpolated, or the quantity itself if a value is not positive.
    fn spectrum(&self, groups: impl Iterator<Item = f32x4>, light: &Spectrum) -> Spectrum {
        let BodySystem { nodes, transport_length, .. } = &*self.system;
        let mut values: Nodes = groups.collect();
        let is_positive = are_positive(&values);
        for (values, light) in values.iter_mut().zip(nodes.gather(|index| light.0[index])) {
            *values = light.simd_gt(f32x4::ZERO).select(*values / light, f32x4::ZERO);
            if is_positive {
                *values = values.max(f32x4::splat(f32::MIN_POSITIVE)).ln();
            }
        }
        let mut spectrum = Spectrum::ZERO;
        let at_nodes: ArrayVec<f32, MAX_NODES> = values.iter().flat_map(|values| values.to_array()).collect();
        nodes.add_interpolated(&at_nodes, &mut spectrum.0);
        if is_positive {
            let power = transport_length.power(&at_nodes);
            let exponents = spectrum.0.iter_mut().zip(transport_length.lacking());
            exponents.for_each(|(exponent, lacking)| *exponent += power * lacking);
            exponentiate(&mut spectrum.0);
        }
        spectrum * *light
    }
}

/// Replaces numbers by their exponentials.
fn exponentiate(values: &mut [f32]) {
    for chunk in values.chunks_mut(snowblue_field::GROUP) {
        let mut group = [0.0; snowblue_field::GROUP];
        group[..chunk.len()].copy_from_slice(chunk);
        chunk.copy_from_slice(&f32x4::from(group).exp().to_array()[..chunk.len()]);
    }
}

/// Light from inside snow at a point of its surface, in W m⁻² sr⁻¹ as a band density: a constant and, in wide cells,
/// less a factor times the directed light that enters at the point. It may be negative where the surface is lit: it
/// subtracts the light that the reflection function reflects but that does not return.
pub struct LightFromInside {
    /// The irradiance H by uniform skies and other surfaces, whose light the radiance includes, in W m⁻².
    pub diffuse_irradiance: Spectrum,
    /// The radiance where no directed light enters.
    pub radiance: Spectrum,
    /// Decrease of the radiance for each unit of Σ K F, in 1/sr; none where the cells resolve the light that enters.
    pub decrease_per_sr: Option<Spectrum>,
}

/// The uppermost layer of snow at a point of the surface. The cells do not resolve how light varies along the surface
/// in this layer, but they resolve it below.
///
/// In the layer, light depends on the depth only, as in a half-space. The flux J through the surface follows from the
/// fluence rate φ at the bottom of the layer and from the light E that enters at the point
/// ([`KindOptics::fluence_factors`]). Light that varies within a cell changes J as it does in deep snow, if the wave
/// number of its variation is the reciprocal of the layer's depth. For a layer that is thick beside the decay of
/// light, J is −a E, with the absorptance a of deep snow.
struct TopLayer {
    /// The fluence rate at the bottom of the layer.
    fluence: Spectrum,
    /// Factors of E and of J in the fluence rate at the bottom.
    factors: [Spectrum; 2],
}

impl TopLayer {
    /// The net flux outwards through the surface, for the light E that enters.
    fn flux(&self, entering: &Spectrum) -> Spectrum {
        let [of_entering, of_flux] = &self.factors;
        let flux = |k: usize| (self.fluence.0[k] - of_entering.0[k] * entering.0[k]) / of_flux.0[k];
        Spectrum(std::array::from_fn(flux))
    }

    /// Decrease of the flux for each unit of light that enters.
    fn decrease(&self) -> Spectrum {
        let [of_entering, of_flux] = &self.factors;
        Spectrum(std::array::from_fn(|k| of_entering.0[k] / of_flux.0[k]))
    }
}

impl SnowAt<'_> {
    /// The radiance that leaves a surface point without the reflection of directed light, (H + K(μ) J)/π.
    pub fn light_from_inside(&self, surface: &SurfacePoint, cos_exit: f32) -> LightFromInside {
        let escape = self.optics.surface().escape(cos_exit) * FRAC_1_PI;
        let Some(place) = self.field.system.place(surface) else {
            let dark = Spectrum::ZERO;
            return LightFromInside { diffuse_irradiance: dark, radiance: dark, decrease_per_sr: None };
        };
        let diffuse = self.field.at_place(&place, |lit| lit.diffuse.as_ref());
        let (flux, decrease_per_sr) = match self.top_layer(surface, &place) {
            Some(layer) => (layer.flux(&diffuse), Some(layer.decrease() * escape)),
            None => (self.field.at_place(&place, |lit| Some(&lit.flux)), None),
        };
        let mut radiance = diffuse * FRAC_1_PI;
        radiance += flux * escape;
        LightFromInside { diffuse_irradiance: diffuse, radiance, decrease_per_sr }
    }

    /// The layer that the cells do not resolve; none in small cells, in thin snow, and in snow of several layers.
    fn top_layer(&self, surface: &SurfacePoint, place: &SurfacePlace) -> Option<TopLayer> {
        let [size_m, thickness_m] = self.field.system.cells.size_and_thickness_m(place);
        let depth_m = LAYER_CELLS * size_m;
        let is_resolved = depth_m < LEAST_DEPTH_LENGTHS * self.optics.transport_length_m();
        let BodyOptics { kinds, optics } = &**self.field.snow();
        let has_layers = kinds.are_layers() && optics.len() > 1;
        if is_resolved || has_layers || depth_m > LAYER_THICKNESSES * thickness_m {
            return None;
        }
        let fluence = self.field.fluence(surface.point - surface.normal * depth_m);
        Some(TopLayer { fluence, factors: self.optics.fluence_factors(depth_m) })
    }
}

/// Values at the spectral nodes, in groups.
type Nodes = ArrayVec<f32x4, MAX_GROUPS>;

/// Whether the values at all nodes are above 0.
fn are_positive(nodes: &Nodes) -> bool {
    nodes.iter().all(|values| values.simd_gt(f32x4::ZERO).all())
}

/// The light around a point inside a body.
pub struct NearLight<'f> {
    field: &'f BodySolution,
    /// The light by the lights of each spectrum.
    lit: Vec<NearFluence<'f>>,
    /// Fluence rate that the field lacks around the point, because the light that enters varies within a cell.
    lacking: Spectrum,
}

/// The light around a point by lights of one spectrum.
struct NearFluence<'f> {
    lit: &'f LitFluence,
    /// A spectrum that light around the point is nearly proportional to, and its reciprocal at the nodes.
    spectrum: Spectrum,
    reciprocals: Nodes,
    /// Fluence rate at the point.
    fluence: Nodes,
    /// Gradient of the fluence rate at the point, per m.
    gradient: [Nodes; 3],
    /// The diffuse irradiance H of the surface near the point.
    diffuse: Nodes,
}

/// Factors of the quantities of a [`NearLight`].
#[derive(Debug, Clone, Copy)]
pub struct LightWeights {
    /// Factor of the fluence rate at the point.
    pub fluence: f32,
    /// Factor of the gradient of the fluence rate, in m.
    pub gradient: Vec3A,
    /// Factor of the diffuse irradiance H.
    pub diffuse: f32,
}

impl<'f> NearLight<'f> {
    /// The light around the point at a depth below a surface, in transport mean free paths; none if the grid has no
    /// cell there. `entering` is the directed light Σ K F that enters at the surface.
    pub fn new(snow: SnowAt<'f>, surface: &SurfacePoint, depth: f32, entering: &Spectrum) -> Option<Self> {
        let SnowAt { field, optics, .. } = snow;
        let depth_m = depth * optics.transport_length_m();
        let point = surface.point - surface.normal * depth_m;
        let place = field.system.place(surface)?;
        let lit: Option<Vec<_>> = field.lit.iter().map(|lit| NearFluence::new(field, lit, point, &place)).collect();
        let mut lacking = Spectrum::ZERO;
        if let Some(layer) = snow.top_layer(surface, &place) {
            let mut entering = *entering;
            entering += field.at_place(&place, |lit| lit.diffuse.as_ref());
            let [of_entering, of_flux] = optics.fluence_factors(depth_m);
            lacking = field.fluence(point) * -1.0;
            lacking += of_entering * entering;
            lacking += of_flux * layer.flux(&entering);
        }
        Some(Self { field, lit: lit?, lacking })
    }

    /// The fluence rate at another point, in W m⁻² as a band density.
    pub fn fluence(&self, point: Vec3A) -> Spectrum {
        let mut sum = self.lacking;
        for near in &self.lit {
            if let Some(groups) = self.field.system.cells.fluence(&near.lit.fluence, point.as_dvec3()) {
                sum += near.spectrum(self.field, groups);
            }
        }
        sum
    }

    /// The diffuse irradiance H of a surface point near by, in W m⁻² as a band density.
    pub fn diffuse_irradiance(&self, surface: &SurfacePoint) -> Spectrum {
        let Some(place) = self.field.system.place(surface) else { return Spectrum::ZERO };
        let mut sum = Spectrum::ZERO;
        for near in &self.lit {
            if let Some(diffuse) = &near.lit.diffuse {
                sum += near.spectrum(self.field, self.field.groups(diffuse, &place));
            }
        }
        sum
    }

    /// A sum of the quantities at the point, in W m⁻² as a band density.
    pub fn sum(&self, weights: &LightWeights) -> Spectrum {
        let mut sum = self.lacking * weights.fluence;
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
    fn new(field: &'f BodySolution, lit: &'f LitFluence, point: Vec3A, place: &SurfacePlace) -> Option<Self> {
        let fluence: Nodes = field.system.cells.fluence(&lit.fluence, point.as_dvec3())?.collect();
        let mut gradient = [(); 3].map(|()| Nodes::new());
        for group in field.system.cells.gradient(&lit.fluence, point.as_dvec3())? {
            gradient.iter_mut().zip(group).for_each(|(axis, values)| axis.push(values));
        }
        let diffuse = lit.diffuse.as_ref().map(|diffuse| field.groups(diffuse, place));
        // Where the grid is too coarse for the remaining light, the spectrum of the light source is used.
        let is_positive = are_positive(&fluence);
        let spectrum = if is_positive { field.spectrum(fluence.iter().copied(), &lit.spectrum) } else { lit.spectrum };
        let reciprocal = |index: usize| {
            let value = spectrum.0[index];
            if value >= f32::MIN_POSITIVE { value.recip() } else { 0.0 }
        };
        let reciprocals = field.system.nodes.gather(reciprocal).collect();
        let diffuse = diffuse.into_iter().flatten().collect();
        Some(Self { lit, spectrum, reciprocals, fluence, gradient, diffuse })
    }

    /// Interpolates a quantity from the nodes to all wavelengths.
    fn spectrum(&self, field: &BodySolution, groups: impl Iterator<Item = f32x4>) -> Spectrum {
        let ratios = groups.zip(&self.reciprocals).flat_map(|(group, reciprocals)| (group * *reciprocals).to_array());
        let ratios: ArrayVec<f32, MAX_NODES> = ratios.collect();
        let mut spectrum = Spectrum::ZERO;
        field.system.nodes.add_interpolated(&ratios, &mut spectrum.0);
        spectrum * self.spectrum * self.lit.emitted
    }
}
