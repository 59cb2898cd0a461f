//! Bidirectional reflectance and transmittance of layers of snow on a Lambertian ground, at any direction.
//!
//! For each azimuthal mode the layers are added from the ground up ([`adding`](super::adding)). The directions of
//! incident and leaving light are further nodes of the quadrature with next to no weight, so that no radiance is
//! interpolated (de Haan, Bosma & Hovenier 1987, A&A 183, 371).
//!
//! **Single scattering is exact.** The modes come from δ-M scaled moments. Single scattering of each layer is taken out
//! of them and put back with the phase function itself, over 1 − ωf for the scaled depth (Nakajima & Tanaka 1988,
//! doi:10.1016/0022-4073(88)90031-3). The remaining radiance is smooth, except near the beam behind a few mean free
//! paths of wet snow, where light is scattered several times within the forward peak: there the transmission is up to
//! a tenth too great. Light that is not scattered is left out.

use std::f64::consts::PI;
use std::slice;

use nalgebra::DMatrix;
use rayon::prelude::*;
use snowblue_base::ParameterRange;

use super::adding::{DiffuseOperators, PhaseMatrices};
use super::eigen::Scaled;
use super::integrals::exponential_integrals;
use super::options::{OrdinatesOptions, Streams};
use super::solve_stack::solve_stack;
use super::stack_media::Grains;
use crate::TransportError;
use crate::medium::{PhaseFunction, PhasePlan};
use crate::monte_carlo::{Distribution, Patch, PatchGrid};
use crate::parameters::ANGLE;
use crate::quadrature::Quadrature;
use crate::slab::{Estimate, Incidence, Slab};
use crate::stack::{Layer, Stack, StackRadiometry};

/// Nodes of a hemisphere for [`Streams::Auto`], and azimuthal modes.
const NODES: usize = 24;
/// Weight of the nodes of incident and leaving light.
const NO_WEIGHT: f64 = 1e-10;
/// Least number of zenith angles of all rings of patches, and of each ring.
const ZENITHS: usize = 30;
const ZENITHS_PER_RING: usize = 2;
/// Least number of azimuths of all sectors of patches.
const AZIMUTHS: usize = 36;
/// Rays through the grains of each layer for their phase function.
const PHASE_RAYS: u32 = 1 << 17;

/// Directions in which light leaves a stack: each zenith angle at each azimuth.
#[derive(Debug, Clone, PartialEq)]
pub struct Views {
    /// Angles from the normal, in degrees.
    pub zeniths_deg: Vec<f64>,
    /// Azimuths from the direction in which the beam travels, in degrees: 0 is forward, 180 is back to the source.
    pub azimuths_deg: Vec<f64>,
}

/// Bidirectional reflectance and transmittance of a stack for one incidence at one wavelength.
#[derive(Debug, Clone, PartialEq)]
pub struct BidirectionalLight {
    /// Radiance that leaves the top over the incident flux, in 1/sr; the azimuth varies fastest.
    pub reflection: Vec<f64>,
    /// Scattered radiance downwards at the ground over the incident flux, in 1/sr.
    pub transmission: Vec<f64>,
}

/// A layer for radiances.
struct ScatteringLayer {
    scaled: Scaled,
    /// Scaled optical depth.
    depth: f64,
    /// The phase function of the light that the medium scatters.
    phase: PhaseFunction,
    /// ω/(1 − ωf).
    single_factor: f64,
}

/// Bidirectional reflectance and transmittance for each incidence, then each wavelength. By Lambertian light the
/// radiances do not depend on the azimuth.
///
/// ```
/// use snowblue_transport::ordinates::{OrdinatesOptions, Views, bidirectional};
/// use snowblue_transport::{Incidence, Layer, SnowSample, Stack};
///
/// let stack = Stack {
///     layers: vec![Layer::snow(SnowSample::default(), f64::INFINITY)],
///     ground_albedo: 0.0.into(),
///     depths_cm: vec![],
///     incidences: vec![Incidence::Beam { angle_deg: 60.0 }],
///     wavelengths_nm: vec![1030.0],
/// };
/// let views = Views { zeniths_deg: vec![60.0], azimuths_deg: vec![0.0, 180.0] };
/// let options = OrdinatesOptions { tally_rays: 1 << 12, ..OrdinatesOptions::default() };
/// let [forward, backward] = bidirectional(&stack, &views, &options)?[0].reflection[..] else { panic!() };
/// // Snow under a low sun is brightest towards the sun.
/// assert!(forward > 1.2 * backward);
/// # Ok::<(), snowblue_transport::TransportError>(())
/// ```
///
/// # Errors
/// If a parameter, an angle or the number of streams is out of range, and for layers of clear ice.
pub fn bidirectional(
    stack: &Stack,
    views: &Views,
    options: &OrdinatesOptions,
) -> Result<Vec<BidirectionalLight>, TransportError> {
    stack.check()?;
    options.streams.check()?;
    views.check()?;
    if stack.layers.iter().any(|layer| layer.sample().is_none()) {
        let rule = "has no bidirectional reflectance: give layers of snow only";
        return Err(TransportError::Combination { quantity: "clear ice", rule });
    }
    let streams = match options.streams {
        Streams::Auto => 2 * NODES,
        Streams::Exactly(streams) => streams,
    };
    let options = OrdinatesOptions { streams: Streams::Exactly(streams), ..*options };
    let grains = Grains::of_stacks(slice::from_ref(stack), false, &options).swap_remove(0);
    let at = |wavelength_nm: &f64| {
        let media = grains.media(*wavelength_nm);
        let layers = stack.layers.iter().zip(&media).filter_map(|(layer, medium)| {
            let scaled = Scaled::new(&medium.scattering, streams);
            let plan = PhasePlan { rays: PHASE_RAYS, seed: options.seed };
            let phase = PhaseFunction::of_scattered_light(layer.sample()?, *wavelength_nm, &plan);
            Some(ScatteringLayer {
                depth: medium.extinction_per_m * layer.thickness_cm * 0.01 * scaled.depth_ratio,
                phase: phase.with_asymmetry(medium.scattering.asymmetry()),
                single_factor: (1.0 - medium.scattering.one_minus_albedo) / scaled.depth_ratio,
                scaled,
            })
        });
        light(&layers.collect::<Vec<_>>(), stack.ground_albedo.at(*wavelength_nm), &stack.incidences, views)
    };
    // [wavelength][incidence]
    let spectra: Vec<Vec<BidirectionalLight>> = stack.wavelengths_nm.par_iter().map(at).collect();
    let of_incidence = |place: usize| spectra.iter().map(move |spectrum| spectrum[place].clone());
    Ok((0..stack.incidences.len()).flat_map(of_incidence).collect())
}

/// BRDF and BTDF on patches of the hemispheres for each thickness, then each incidence, then each wavelength. The mean
/// over a patch is a sum of radiances at some of its directions. Patches have no standard errors: they are NaN.
///
/// # Errors
/// As [`bidirectional()`], and if the number of patches is out of range.
pub fn distribute(
    slab: &Slab,
    patches: PatchGrid,
    options: &OrdinatesOptions,
) -> Result<Vec<Distribution>, TransportError> {
    slab.check()?;
    patches.check()?;
    let steps = AZIMUTHS.div_ceil(patches.sectors);
    let zeniths = ZENITHS.div_ceil(patches.rings).max(ZENITHS_PER_RING);
    let (zeniths_deg, azimuths_deg) = patches.directions_deg(zeniths, steps);
    let views = Views { zeniths_deg, azimuths_deg };
    let mut distributions = Vec::new();
    for thickness_cm in &slab.thicknesses_cm {
        let stack = Stack {
            layers: vec![Layer::snow(slab.sample, *thickness_cm)],
            ground_albedo: 0.0.into(),
            depths_cm: Vec::new(),
            incidences: slab.incidences.clone(),
            wavelengths_nm: slab.wavelengths_nm.clone(),
        };
        let light = bidirectional(&stack, &views, options)?;
        let hemisphere = |radiances: &[f64]| -> Vec<Patch> {
            let per_ring = zeniths * views.azimuths_deg.len();
            let mean = |index: usize| {
                let rings =
                    radiances[index / patches.sectors * per_ring..][..per_ring].chunks(views.azimuths_deg.len());
                let sector = rings.flat_map(|ring| &ring[index % patches.sectors * steps..][..steps]);
                Estimate { value: sector.sum::<f64>() / (zeniths * steps) as f64, standard_error: f64::NAN }
            };
            (0..patches.count()).map(|index| patches.patch(index, mean(index))).collect()
        };
        for (StackRadiometry { whole, direct, .. }, light) in solve_stack(&stack, options)?.into_iter().zip(&light) {
            distributions.push(Distribution {
                thickness_cm: *thickness_cm,
                incidence: whole.incidence,
                wavelength_nm: whole.wavelength_nm,
                patches,
                reflection: hemisphere(&light.reflection),
                transmission: hemisphere(&light.transmission),
                reflectance: whole.fluxes.reflectance,
                transmittance: whole.fluxes.transmittance,
                direct: Estimate { value: direct, standard_error: 0.0 },
            });
        }
    }
    Ok(distributions)
}

/// Light of layers, top first, under each incidence.
fn light(
    layers: &[ScatteringLayer],
    ground_albedo: f64,
    incidences: &[Incidence],
    views: &Views,
) -> Vec<BidirectionalLight> {
    let nodes = layers[0].scaled.albedo_moments.len() / 2;
    let cosine = |degrees: &f64| degrees.to_radians().cos();
    let beam = |incidence: &Incidence| match incidence {
        Incidence::Beam { angle_deg } => Some(cosine(angle_deg)),
        Incidence::Diffuse => None,
    };
    // The nodes of the quadrature, then the views, then the beams.
    let mut rule = Quadrature::half_range(nodes).clone();
    rule.cosines.extend(views.zeniths_deg.iter().map(cosine));
    let first_beam = rule.cosines.len();
    rule.cosines.extend(incidences.iter().filter_map(beam));
    rule.weights.resize(rule.cosines.len(), NO_WEIGHT);
    let solve = |mode| mode_light(layers, if mode == 0 { ground_albedo } else { 0.0 }, (mode, first_beam), &rule);
    let modes: Vec<[DMatrix<f64>; 2]> = (0..nodes).into_par_iter().map(solve).collect();
    let mut beams = first_beam..;
    let under = |incidence: &Incidence| {
        let beam = if *incidence == Incidence::Diffuse { None } else { beams.next() };
        let radiance = |side: usize, view: usize, azimuth_deg: f64| {
            let Some(beam) = beam else {
                let flux = |node: usize| rule.weights[node] * rule.cosines[node];
                return 2.0 * (0..nodes).map(|node| modes[0][side][(view, node)] * flux(node)).sum::<f64>();
            };
            let azimuth = azimuth_deg.to_radians();
            let term = |(mode, of_mode): (usize, &[DMatrix<f64>; 2])| {
                let twice = if mode == 0 { 1.0 } else { 2.0 };
                twice * (mode as f64 * azimuth).cos() * of_mode[side][(view, beam)]
            };
            let [mu, incident] = [view, beam].map(|node| rule.cosines[node]);
            let sines = ((1.0 - mu * mu) * (1.0 - incident * incident)).max(0.0).sqrt();
            let cos_scattering = sines * azimuth.cos() + if side == 0 { -mu * incident } else { mu * incident };
            let single = layers.iter().zip(single_scattering(layers, mu, incident));
            let single =
                single.map(|(layer, sides)| sides[side] * layer.single_factor * layer.phase.per_sr(cos_scattering));
            single.sum::<f64>() + modes.iter().enumerate().map(term).sum::<f64>()
        };
        let all = |side: usize| {
            let of_view = |view| views.azimuths_deg.iter().map(move |azimuth_deg| radiance(side, view, *azimuth_deg));
            (nodes..first_beam).flat_map(of_view).collect()
        };
        BidirectionalLight { reflection: all(0), transmission: all(1) }
    };
    incidences.iter().map(under).collect()
}

/// Reflection and transmission in one azimuthal mode, per incident flux; of beams without single scattering.
fn mode_light(
    layers: &[ScatteringLayer],
    ground_albedo: f64,
    (mode, first_beam): (usize, usize),
    rule: &Quadrature,
) -> [DMatrix<f64>; 2] {
    let n = rule.order();
    let ground = DMatrix::from_fn(n, n, |_, j| 2.0 * ground_albedo * rule.cosines[j] * rule.weights[j]);
    let mut whole = DiffuseOperators { reflection: ground, transmission: DMatrix::identity(n, n) };
    let phases: Vec<PhaseMatrices> = layers.iter().map(|layer| PhaseMatrices::new(&layer.scaled, mode, rule)).collect();
    for (layer, phase) in layers.iter().zip(&phases).rev() {
        whole = DiffuseOperators::of_depth(phase, rule, layer.depth).on(&whole);
    }
    let mut sides = [whole.reflection, whole.transmission].map(|operator| DiffuseOperators::per_flux(operator, rule));
    for beam in first_beam..n {
        for view in 0..first_beam {
            let factors = single_scattering(layers, rule.cosines[view], rule.cosines[beam]);
            for ([reflected, transmitted], phase) in factors.into_iter().zip(&phases) {
                sides[0][(view, beam)] -= reflected * phase.backward[(view, beam)] / (4.0 * PI);
                sides[1][(view, beam)] -= transmitted * phase.forward[(view, beam)] / (4.0 * PI);
            }
        }
    }
    sides
}

/// Light that each layer scatters once, per phase function and incident flux: out of the top and of the bottom.
fn single_scattering(layers: &[ScatteringLayer], mu: f64, incident: f64) -> Vec<[f64; 2]> {
    let mut below: f64 = layers.iter().map(|layer| layer.depth).sum();
    let (mut above, whole) = (0.0, below);
    let of_layer = |layer: &ScatteringLayer| {
        let (slant, depth) = (1.0 / mu + 1.0 / incident, layer.depth);
        let reflected = -(-above * slant).exp() * (-depth * slant).exp_m1() / (mu + incident);
        above += depth;
        below = if whole.is_finite() { whole - above } else { f64::INFINITY };
        let (_, through) = exponential_integrals(1.0 / mu, depth, 1.0 / incident);
        let transmitted = ((depth - above) / incident - below / mu).exp() * through / mu;
        [reflected, if whole.is_finite() { transmitted } else { 0.0 }]
    };
    layers.iter().map(of_layer).collect()
}

impl Views {
    fn check(&self) -> Result<(), TransportError> {
        let zenith = ParameterRange { quantity: "view zenith", ..ANGLE.range };
        self.zeniths_deg.iter().try_for_each(|zenith_deg| zenith.check(*zenith_deg))?;
        let azimuth = ParameterRange { quantity: "view azimuth", least: -360.0, greatest: 360.0, unit: "°" };
        Ok(self.azimuths_deg.iter().try_for_each(|azimuth_deg| azimuth.check(*azimuth_deg))?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::HenyeyGreenstein;
    use crate::ordinates::HalfSpace;
    use crate::ordinates::integrals::third_exponential_integral;

    fn layer(one_minus_albedo: f64, asymmetry: f64, optical_depth: f64) -> ScatteringLayer {
        let scattering = HenyeyGreenstein { one_minus_albedo, asymmetry }.scattering(2 * NODES);
        let scaled = Scaled::new(&scattering, 2 * NODES);
        let single_factor = (1.0 - one_minus_albedo) / scaled.depth_ratio;
        let depth = optical_depth * scaled.depth_ratio;
        ScatteringLayer { scaled, depth, phase: PhaseFunction::henyey_greenstein(asymmetry), single_factor }
    }

    const BEAM: Incidence = Incidence::Beam { angle_deg: 60.0 };

    /// The flux of radiances at the nodes of a rule, in the zenith angles of `views`, at equal steps of azimuth.
    fn flux(radiances: &[f64], rule: &Quadrature, azimuths: usize) -> f64 {
        let rings = radiances.chunks(azimuths).zip(rule.cosines.iter().zip(&rule.weights));
        rings.map(|(ring, (mu, weight))| 2.0 * PI * mu * weight * ring.iter().sum::<f64>() / azimuths as f64).sum()
    }

    /// Where nothing absorbs, layers that differ reflect or transmit all light, on any ground.
    #[test]
    fn light_is_conserved() {
        let rule = Quadrature::half_range(32);
        let zeniths_deg = rule.cosines.iter().map(|mu| mu.acos().to_degrees()).collect();
        let views = Views { zeniths_deg, azimuths_deg: (0..48).map(|step| 7.5 * f64::from(step)).collect() };
        let layers = [layer(0.0, 0.7, 0.4), layer(0.0, 0.0, 0.3), layer(0.0, 0.85, 2.0)];
        let incidences = [BEAM, Incidence::Beam { angle_deg: 0.0 }, Incidence::Diffuse];
        for ground_albedo in [0.0, 0.6] {
            let solved = light(&layers, ground_albedo, &incidences, &views);
            for (place, BidirectionalLight { reflection, transmission }) in solved.iter().enumerate() {
                let [up, down] = [reflection, transmission].map(|radiances| flux(radiances, rule, 48));
                // Unscattered light: of the beams by Lambert's law, of Lambertian light 2 E₃.
                let depth = 2.7;
                let direct = match incidences[place] {
                    Incidence::Beam { angle_deg } => (-depth / angle_deg.to_radians().cos()).exp(),
                    Incidence::Diffuse => 2.0 * third_exponential_integral(depth),
                };
                let sum = up + (1.0 - ground_albedo) * (down + direct);
                assert!((sum - 1.0).abs() < 2e-3, "{ground_albedo} {place}: {sum}");
            }
        }
    }

    /// A thick layer without absorption is [`HalfSpace`].
    #[test]
    fn a_deep_layer_is_the_half_space() {
        for asymmetry in [0.0, 0.75] {
            let half_space = HalfSpace::new(&PhaseFunction::henyey_greenstein(asymmetry));
            let views = Views { zeniths_deg: vec![0.0, 40.0, 75.0], azimuths_deg: vec![0.0, 70.0, 180.0] };
            let solved = light(&[layer(0.0, asymmetry, f64::INFINITY)], 0.0, &[BEAM], &views);
            for (place, found) in solved[0].reflection.iter().enumerate() {
                let (mu, azimuth) = (views.zeniths_deg[place / 3].to_radians().cos(), views.azimuths_deg[place % 3]);
                let expected = half_space.reflection(mu, 0.5, azimuth.to_radians().cos());
                // Its 12 modes and bilinear tables.
                assert!((found / expected - 1.0).abs() < 2e-3, "{asymmetry} {place}: {found} {expected}");
            }
        }
    }
}
