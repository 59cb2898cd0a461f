//! Layers of snow on a ground by discrete ordinates, with the standard errors of the grain tallies.
//!
//! Layers with equal grain shapes share a tally, and layers with equal single scattering share their modes.
//! Derivatives are computed with the values, from common modes and linear systems.

use std::slice;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::differentiated::DifferentiatedModes;
use super::eigen::Scaled;
use super::homogeneous::{HomogeneousMedium, Passed};
use super::ice_slab::{FaceQuantity, direct};
use super::layered::{Emission, FaceEmissions, FaceFluxes, IcePlane, LayeredMedium, MediumLayer, Response};
use super::options::{OrdinatesOptions, StreamGroup, Streams};
use super::sensitivity::{Adjoint, DifferentiatedLayer, FluxChange, Sensitivity};
use super::stack_media::{DifferentiatedMedia, Grains, peak};
use crate::TransportError;
use crate::batch::BatchError;
use crate::dual::{Dual, LANES, Real};
use crate::medium::Medium;

use crate::sample::Property;
use crate::slab::{Estimate, Fluxes, Incidence, Radiometry};
use crate::stack::{DepthFluxes, LayerKind, Place, Slice, Slices, Stack, StackDerivatives, StackRadiometry};
use crate::variable::{LayerVariable, Variable};

/// Fluxes of a stack with their derivatives.
#[derive(Debug, Clone, PartialEq)]
pub struct DifferentiatedStack {
    /// Fluxes for each incidence, then each wavelength.
    pub fluxes: Vec<StackRadiometry>,
    /// Derivatives for each incidence and wavelength with respect to each variable of each layer, as
    /// [`LayerVariable::of_layers`] lists the variables; the variable varies fastest.
    pub derivatives: Vec<StackDerivatives>,
}

/// Fluxes of a stack for one incidence at one wavelength.
#[derive(Clone, Default)]
struct StackFluxes {
    reflectance: f64,
    transmittance: f64,
    /// Unscattered part of the transmittance.
    direct: f64,
    /// Fluxes at each depth.
    profile: Vec<ProfilePoint>,
    /// Derivatives by each variable of each layer.
    derivatives: Vec<StackDerivatives>,
    /// Deviations with the grain tallies.
    deviations: Vec<StackDerivatives>,
}

/// A stack of media under some lights, and the emissions of its fluxes.
struct SolvedStack<'m> {
    /// The modes of each layer.
    layers: Vec<&'m HomogeneousMedium>,
    layered: LayeredMedium<'m>,
    /// Emission for the reflectance.
    top: Emission,
    /// Emission for the transmittance.
    bottom: Emission,
    depths: Vec<DepthEmissions>,
}

/// The emissions for the fluxes at one depth.
struct DepthEmissions {
    /// The layer to which the depth belongs.
    layer: usize,
    fluxes: FaceEmissions,
    fluence: Emission,
    /// Emission for the fluence rate just within ice, where the depth is at a face of the ice to air.
    within_ice: Option<Emission>,
    /// The plane at this depth, if the depth is within ice, or at a face and belongs to the ice.
    plane: Option<IcePlane>,
}

/// Changes of fluxes of a stack under one light.
struct StackChanges {
    reflectance: FluxChange,
    transmittance: FluxChange,
    profile: Vec<ProfileChange>,
}

/// Changes of fluxes at one depth.
struct ProfileChange {
    /// The layer to which the depth belongs.
    layer: usize,
    /// Changes of the fluxes downwards and upwards, and of the net flux.
    fluxes: [FluxChange; 3],
    fluence: FluxChange,
    /// Change of the fluence rate just within ice, at a face of the ice to air.
    within_ice: Option<FluxChange>,
    /// For a depth within ice: the index of its slice, and the changes of the fluxes, of the fluence rate, and of the
    /// fluence rate of the absorbed light, per cm by which the plane moves down, and per cm by which the ice gets
    /// thicker.
    within: Option<(usize, [[f64; 5]; 2])>,
    /// Absorption coefficient of the layer, in 1/m.
    absorption_per_m: Dual,
    /// Inverse of the e-folding depth of the layer, in 1/cm.
    rate_per_cm: Dual,
}

/// Fluxes and e-folding depth at one depth.
#[derive(Clone, Copy)]
struct ProfilePoint {
    fluxes: FaceFluxes,
    fluence: f64,
    /// The fluence rate that determines the absorption.
    absorbed_fluence: f64,
    absorption_per_m: f64,
    e_folding_depth_cm: f64,
}

/// Fluxes above a stack, at its depths, and below it, for each incidence, then each wavelength.
///
/// The standard errors follow from the covariance of the grain tallies, by the delta method.
///
/// # Errors
/// If a parameter or the number of streams is out of range.
pub fn solve_stack(stack: &Stack, options: &OrdinatesOptions) -> Result<Vec<StackRadiometry>, TransportError> {
    Ok(differentiate_stack(stack, &[], options, true)?.fluxes)
}

/// As [`solve_stack`], without standard errors, which are NaN.
///
/// # Errors
/// If a parameter or the number of streams is out of range.
pub fn solve_stack_without_errors(
    stack: &Stack,
    options: &OrdinatesOptions,
) -> Result<Vec<StackRadiometry>, TransportError> {
    Ok(differentiate_stack(stack, &[], options, false)?.fluxes)
}

/// Fluxes of a stack, and their derivatives with respect to each of `variables` of each layer, of the light and of the
/// ground. Without `errors` the standard errors are NaN; derivatives have none.
///
/// ```
/// use snowblue_transport::ordinates::{OrdinatesOptions, differentiate_stack};
/// use snowblue_transport::{Incidence, Layer, SnowSample, Stack, Substance, Variable};
///
/// let layer = |thickness_cm| Layer::snow(SnowSample::default(), thickness_cm);
/// let stack = Stack {
///     layers: vec![layer(2.0), layer(20.0)],
///     ground_albedo: 0.0.into(),
///     depths_cm: vec![],
///     incidences: vec![Incidence::Diffuse],
///     wavelengths_nm: vec![450.0],
/// };
/// let soot = [Variable::impurity(Substance::BLACK_CARBON)];
/// let options = OrdinatesOptions { tally_rays: 1 << 12, ..OrdinatesOptions::default() };
/// let solved = differentiate_stack(&stack, &soot, &options, false)?;
/// // A mass fraction of soot darkens a thick layer more than a thin one.
/// let [upper, lower] = [0, 1].map(|layer| solved.derivatives[layer].whole.reflectance);
/// assert!(lower < upper && upper < 0.0);
/// // But that of the upper layer weighs more per gram.
/// assert!(upper / 2.0 < lower / 20.0);
/// # Ok::<(), snowblue_transport::TransportError>(())
/// ```
///
/// # Errors
/// As [`solve_stack`], and for a wavelength that the table of a variable's substance does not cover.
pub fn differentiate_stack(
    stack: &Stack,
    variables: &[Variable],
    options: &OrdinatesOptions,
    errors: bool,
) -> Result<DifferentiatedStack, TransportError> {
    let solved = differentiate_stacks(slice::from_ref(stack), variables, options, errors, &|_| ());
    solved.map(|mut one| one.swap_remove(0)).map_err(|wrong| wrong.error)
}

/// As [`differentiate_stack`], of many stacks at common wavelengths. Grains that differ only in size share the rays
/// that are traced through them. The numbers of a stack do not depend on other stacks, to the last bit.
///
/// `progress` is called from any thread with the number of stacks done.
///
/// # Errors
/// As [`differentiate_stack`], with the place of the stack.
///
/// # Panics
/// If the wavelengths of the stacks differ.
pub fn differentiate_stacks(
    stacks: &[Stack],
    variables: &[Variable],
    options: &OrdinatesOptions,
    errors: bool,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<Vec<DifferentiatedStack>, BatchError> {
    options.streams.check()?;
    for (place, stack) in stacks.iter().enumerate() {
        assert_eq!(stack.wavelengths_nm, stacks[0].wavelengths_nm, "stacks need common wavelengths");
        stack.check().map_err(|error| BatchError { case: Some(place), error })?;
    }
    for variable in variables {
        let wavelengths_nm = stacks.first().map_or(&[][..], |stack| &stack.wavelengths_nm);
        wavelengths_nm.iter().try_for_each(|wavelength_nm| variable.check_at(*wavelength_nm))?;
    }
    let in_water = variables.contains(&Variable::Snow(Property::WaterSaturation));
    let grains = Grains::of_stacks(stacks, in_water, options);
    let done = AtomicUsize::new(0);
    let solve = |(stack, grains): (&Stack, &Grains)| {
        let solved = solve_with_grains(stack, grains, variables, (options.streams, errors));
        progress(done.fetch_add(1, Ordering::Relaxed) + 1);
        solved
    };
    Ok(stacks.par_iter().zip(&grains).map(solve).collect())
}

/// The fluxes and derivatives of a stack whose grains are tallied.
fn solve_with_grains(
    stack: &Stack,
    grains: &Grains,
    variables: &[Variable],
    (streams, errors): (Streams, bool),
) -> DifferentiatedStack {
    let slices = stack.slices();
    let at = |wavelength_nm: &f64| {
        let media = grains.media(*wavelength_nm);
        let by = |variables| grains.differentiated_media(*wavelength_nm, variables);
        let mut differentiated: Vec<DifferentiatedMedia> = variables.chunks(LANES).map(by).collect();
        if errors {
            differentiated.extend(grains.deviated_media(*wavelength_nm));
        }
        let all = stack_fluxes((stack, &slices), *wavelength_nm, &media, &differentiated, streams);
        let answer = |(incidence, mut fluxes): (&Incidence, StackFluxes)| {
            let derivatives = std::mem::take(&mut fluxes.derivatives);
            (fluxes.radiometry(stack, *incidence, *wavelength_nm, errors), derivatives)
        };
        stack.incidences.iter().zip(all).map(answer).collect()
    };
    // [wavelength][incidence]
    let spectra: Vec<Vec<(StackRadiometry, Vec<StackDerivatives>)>> = stack.wavelengths_nm.par_iter().map(at).collect();
    let mut answer = DifferentiatedStack { fluxes: Vec::new(), derivatives: Vec::new() };
    for place in 0..stack.incidences.len() {
        for (fluxes, derivatives) in spectra.iter().map(|spectrum| &spectrum[place]) {
            answer.fluxes.push(fluxes.clone());
            answer.derivatives.extend_from_slice(derivatives);
        }
    }
    answer
}

impl StackFluxes {
    /// The fluxes, with standard errors from the deviations if there are `errors`.
    fn radiometry(&self, stack: &Stack, incidence: Incidence, wavelength_nm: f64, errors: bool) -> StackRadiometry {
        let estimate = |value: f64, deviation: &dyn Fn(&StackDerivatives) -> f64| {
            let variance = self.deviations.iter().map(|one| deviation(one).powi(2)).sum::<f64>();
            Estimate { value, standard_error: if errors { variance.sqrt() } else { f64::NAN } }
        };
        let at_depth = |(number, at): (usize, &ProfilePoint)| {
            let of = |value: f64, quantity: fn(&DepthFluxes<f64>) -> f64| {
                estimate(value, &|one| quantity(&one.profile[number]))
            };
            DepthFluxes {
                down: of(at.fluxes.down, |one| one.down),
                up: of(at.fluxes.up, |one| one.up),
                net: of(at.fluxes.net, |one| one.net),
                fluence: of(at.fluence, |one| one.fluence),
                absorbed_per_m: of(at.absorption_per_m * at.absorbed_fluence, |one| one.absorbed_per_m),
                e_folding_depth_cm: of(at.e_folding_depth_cm, |one| one.e_folding_depth_cm),
            }
        };
        let Self { reflectance, transmittance, .. } = *self;
        let values = Passed { reflectance, transmittance }.fluxes(stack.ground_albedo.at(wavelength_nm)).to_array();
        let flux = |place: usize| estimate(values[place], &|one| one.whole.to_array()[place]);
        StackRadiometry {
            whole: Radiometry {
                thickness_cm: stack.thickness_cm(),
                incidence,
                wavelength_nm,
                fluxes: Fluxes::from([0, 1, 2].map(flux)),
            },
            direct: self.direct,
            profile: self.profile.iter().enumerate().map(at_depth).collect(),
        }
    }
}

/// Fluxes of a stack with layers of these media under each incidence, and their derivatives.
fn stack_fluxes(
    (stack, cut): (&Stack, &Slices),
    wavelength_nm: f64,
    media: &[Medium],
    differentiated: &[DifferentiatedMedia],
    streams: Streams,
) -> Vec<StackFluxes> {
    let mut all = vec![StackFluxes::default(); stack.incidences.len()];
    let ground_albedo = stack.ground_albedo.at(wavelength_nm);
    // Layers with equal single scattering, such as one snow at several densities, share their modes.
    let ice_index = |layer: usize| match stack.layers[layer].kind {
        LayerKind::Snow(_) => None,
        LayerKind::Ice(table) => Some(table.index(wavelength_nm)),
    };
    let is_alike = |one: usize, other: usize| {
        ice_index(one) == ice_index(other) && media[one].scattering == media[other].scattering
    };
    let first_alike = |layer: usize| (0..layer).find(|other| is_alike(*other, layer)).unwrap_or(layer);
    let optical_depth = |slice: &Slice| media[slice.layer].extinction_per_m * slice.thickness_cm * 0.01;
    for StreamGroup { streams, places } in streams.groups(&stack.incidences, peak(stack)) {
        let modes: Vec<Option<HomogeneousMedium>> = (0..media.len())
            .map(|layer| {
                (first_alike(layer) == layer).then(|| match ice_index(layer) {
                    Some(index) => HomogeneousMedium::ice(index, streams),
                    None => HomogeneousMedium::new(&media[layer].scattering, streams),
                })
            })
            .collect();
        let modes =
            |layer: usize| modes[first_alike(layer)].as_ref().unwrap_or_else(|| unreachable!("it is the first"));
        let layers: Vec<&HomogeneousMedium> = (0..media.len()).map(modes).collect();
        let slices: Vec<MediumLayer> = cut
            .slices
            .iter()
            .map(|slice| MediumLayer { medium: layers[slice.layer], optical_depth: optical_depth(slice) })
            .collect();
        let incidences: Vec<Incidence> = places.iter().map(|place| stack.incidences[*place]).collect();
        let depths: Vec<_> = slices.iter().map(|slice| (slice.medium.ice_index, slice.optical_depth)).collect();
        let layered = LayeredMedium::new(&slices, ground_albedo, &incidences);
        let solved = SolvedStack::new(layers, layered, cut, media);
        for (light, place) in solved.layered.lights.iter().zip(&places) {
            let direct = direct(&depths, &stack.incidences[*place]);
            all[*place] = StackFluxes { direct, ..solved.fluxes(light, media) };
        }
        let adjoints = if differentiated.is_empty() { Vec::new() } else { solved.layered.adjoints() };
        for by in differentiated {
            let scaled = |medium: &Medium<Dual>| Scaled::new(&medium.scattering, streams);
            let modes = solved.layers.iter().zip(&by.media);
            let modes: Vec<DifferentiatedModes> =
                modes.map(|(modes, medium)| DifferentiatedModes::new(modes, scaled(medium))).collect();
            let sensitivities = by.sensitivities(ground_albedo, cut, &modes, (&solved.layered, &adjoints));
            let lights = solved.layered.lights.iter().zip(&sensitivities);
            for (light, place) in lights.zip(&places) {
                let changes = solved.changes(light, &modes, &by.media);
                let fluxes = &mut all[*place];
                for (lane, variable) in by.variables.iter().enumerate() {
                    for by in LayerVariable::of_layers(&[*variable], stack.layers.len()) {
                        let derivatives = changes.by(Some(&by), lane, fluxes, (ground_albedo, cut));
                        fluxes.derivatives.push(derivatives);
                    }
                }
                for lane in if by.variables.is_empty() { 0..LANES } else { 0..0 } {
                    let deviations = changes.by(None, lane, fluxes, (ground_albedo, cut));
                    fluxes.deviations.push(deviations);
                }
            }
        }
    }
    all
}

impl<'m> SolvedStack<'m> {
    fn new(layers: Vec<&'m HomogeneousMedium>, layered: LayeredMedium<'m>, cut: &Slices, media: &[Medium]) -> Self {
        let depth = |place: &Place| {
            let layer = cut.layer_at(*place);
            let plane = cut.ice_at(*place).zip(layers[layer].ice_index).map(|((slice, depth_cm), index)| {
                let depths_cm = [depth_cm, cut.slices[slice].thickness_cm - depth_cm];
                let depths = depths_cm.map(|depth_cm| media[layer].extinction_per_m * 0.01 * depth_cm.max(0.0));
                IcePlane { layer: slice, index, depths, changes: None }
            });
            let fluence = |plane: IcePlane| layered.ice_emission(plane, FaceQuantity::Fluence);
            match (place, plane) {
                (Place::Ice { .. }, Some(plane)) => DepthEmissions {
                    layer,
                    fluxes: layered.ice_emissions(plane),
                    fluence: fluence(plane),
                    within_ice: None,
                    plane: Some(plane),
                },
                (Place::Ice { slice: face, .. } | Place::Face(face), plane) => DepthEmissions {
                    layer,
                    fluxes: layered.emissions(*face),
                    fluence: layered.fluence_emission(*face),
                    within_ice: plane.map(fluence),
                    plane,
                },
            }
        };
        Self {
            top: layered.emissions(0).up,
            bottom: layered.emissions(cut.slices.len()).down,
            depths: cut.places.iter().map(depth).collect(),
            layers,
            layered,
        }
    }

    /// The fluxes under a light, without the unscattered part.
    fn fluxes(&self, light: &Response, media: &[Medium]) -> StackFluxes {
        let at_depth = |DepthEmissions { layer, fluxes, fluence, within_ice, .. }: &DepthEmissions| {
            let Medium { extinction_per_m, scattering } = &media[*layer];
            let fluence = self.layered.radiance(light, fluence);
            ProfilePoint {
                fluxes: self.layered.face_fluxes(light, fluxes),
                fluence,
                absorbed_fluence: within_ice.as_ref().map_or(fluence, |within| self.layered.radiance(light, within)),
                absorption_per_m: extinction_per_m * scattering.one_minus_albedo,
                e_folding_depth_cm: 1.0 / (self.layers[*layer].decay_rate() * (extinction_per_m * 0.01)),
            }
        };
        StackFluxes {
            reflectance: self.layered.radiance(light, &self.top),
            transmittance: self.layered.radiance(light, &self.bottom),
            profile: self.depths.iter().map(at_depth).collect(),
            ..StackFluxes::default()
        }
    }

    /// The changes of all fluxes under a light, whose layers have these modes and media.
    fn changes(
        &self,
        (light, sensitivity): (&Response, &Sensitivity),
        modes: &[DifferentiatedModes],
        media: &[Medium<Dual>],
    ) -> StackChanges {
        let flux = |emission: &Emission| sensitivity.change(emission);
        let at_depth = |depth: &DepthEmissions| {
            let DepthEmissions { layer, fluxes: FaceEmissions { down, up, net }, fluence, within_ice, plane } = depth;
            let Medium { extinction_per_m, scattering } = &media[*layer];
            let within = plane.map(|plane| {
                let per_cm = extinction_per_m.value() * 0.01;
                let of_plane = |changes| self.changes_of_plane(light, plane, changes);
                let by = match within_ice {
                    None => [of_plane([per_cm, -per_cm]), of_plane([0.0, per_cm])],
                    // The plane is at a face and moves with it.
                    Some(_) => {
                        let is_top = plane.depths[0] <= 0.0;
                        let [.., absorbed] = of_plane(if is_top { [0.0, per_cm] } else { [per_cm, 0.0] });
                        [[0.0; 5], [0.0, 0.0, 0.0, 0.0, absorbed]]
                    }
                };
                (plane.layer, by)
            });
            ProfileChange {
                layer: *layer,
                fluxes: [down, up, net].map(flux),
                fluence: flux(fluence),
                within_ice: within_ice.as_ref().map(flux),
                within,
                absorption_per_m: *extinction_per_m * scattering.one_minus_albedo,
                rate_per_cm: modes[*layer].decay_rate() * (*extinction_per_m * 0.01),
            }
        };
        StackChanges {
            reflectance: flux(&self.top),
            transmittance: flux(&self.bottom),
            profile: self.depths.iter().map(at_depth).collect(),
        }
    }

    /// Changes of the fluxes (downwards, upwards, net) and of the fluence rate, twice, at a plane within ice as the
    /// optical depths above and below the plane change. For all light from outside the ice does not change.
    fn changes_of_plane(&self, light: &Response, plane: IcePlane, changes: [f64; 2]) -> [f64; 5] {
        let plane = IcePlane { changes: Some(changes), ..plane };
        let change = |quantity| self.layered.radiance(light, &self.layered.ice_emission(plane, quantity));
        let [down, up, fluence] = [FaceQuantity::Down, FaceQuantity::Up, FaceQuantity::Fluence].map(change);
        [down, up, down - up, fluence, fluence]
    }
}

impl DifferentiatedMedia<'_> {
    /// The derivatives under each light.
    fn sensitivities<'a>(
        &self,
        ground_albedo: f64,
        cut: &Slices,
        modes: &[DifferentiatedModes],
        (layered, adjoints): (&'a LayeredMedium<'_>, &'a [Adjoint]),
    ) -> Vec<Sensitivity<'a>> {
        let Self { variables, media } = self;
        let slice = |slice: &Slice| {
            let thickness_cm = Variable::Thickness.number(slice.thickness_cm, variables);
            let modes = &modes[slice.layer];
            DifferentiatedLayer { modes, depth: modes.depth(media[slice.layer].extinction_per_m, thickness_cm) }
        };
        let slices: Vec<DifferentiatedLayer> = cut.slices.iter().map(slice).collect();
        let ground_albedo = Variable::GroundAlbedo.number(ground_albedo, variables);
        layered.sensitivities(adjoints, &slices, ground_albedo, variables)
    }
}

impl StackChanges {
    /// The derivatives by a variable of a layer, or with all media.
    fn by(
        &self,
        by: Option<&LayerVariable>,
        lane: usize,
        fluxes: &StackFluxes,
        (ground_albedo, cut): (f64, &Slices),
    ) -> StackDerivatives {
        let of = |change: &FluxChange| change.by(by, lane, cut);
        let number = |value: f64, derivative: f64| Dual::new(value, [derivative; LANES]);
        let passed = Passed {
            reflectance: number(fluxes.reflectance, of(&self.reflectance)),
            transmittance: number(fluxes.transmittance, of(&self.transmittance)),
        };
        let is_ground = f64::from(u8::from(by.is_some_and(|by| by.variable == Variable::GroundAlbedo)));
        let whole = passed.fluxes(number(ground_albedo, is_ground));
        let points = fluxes.profile.iter().zip(&self.profile);
        StackDerivatives {
            whole: whole.map(|number| number.derivatives()[lane]),
            profile: points.map(|(point, change)| change.by(by, lane, (point, cut), &of)).collect(),
        }
    }
}

impl FluxChange {
    /// The derivative by a variable of a layer, which sums over slices, by a variable of the light or of the ground,
    /// or with all media.
    fn by(&self, by: Option<&LayerVariable>, lane: usize, cut: &Slices) -> f64 {
        let Some(by) = by else { return self.layers.iter().map(|slice| slice[lane]).sum() };
        let Some(layer) = by.layer else { return self.whole[lane] };
        let weight = |slice: &Slice| match by.variable {
            Variable::Thickness => slice.growth(layer),
            _ => f64::from(u8::from(slice.layer == layer)),
        };
        let slices = cut.slices.iter().map(weight).zip(&self.layers);
        slices.filter(|(weight, _)| weight.abs() > 0.0).map(|(weight, slice)| weight * slice[lane]).sum()
    }
}

impl ProfileChange {
    /// The derivatives by a variable, or with all media. `of` gives the derivative of a flux from its change.
    fn by(
        &self,
        by: Option<&LayerVariable>,
        lane: usize,
        (point, cut): (&ProfilePoint, &Slices),
        of: &dyn Fn(&FluxChange) -> f64,
    ) -> DepthFluxes<f64> {
        let [down, up, net] = self.fluxes.each_ref().map(of);
        let fluence = of(&self.fluence);
        let mut changes = [down, up, net, fluence, self.within_ice.as_ref().map_or(fluence, of)];
        if let (
            Some((slice, [by_place, by_thickness])),
            Some(LayerVariable { variable: Variable::Thickness, layer: Some(layer) }),
        ) = (&self.within, by)
        {
            let slice = &cut.slices[*slice];
            let (by_own, is_above) = (slice.growth(*layer), slice.moves_with(*layer));
            for (change, (by_place, by_thickness)) in changes.iter_mut().zip(by_place.iter().zip(by_thickness)) {
                *change += by_thickness * by_own - if is_above { *by_place } else { 0.0 };
            }
        }
        let [down, up, net, fluence, absorbed_fluence] = changes;
        // A thickness changes no medium.
        let is_own = by.is_none_or(|by| by.layer == Some(self.layer));
        let own = |number: &Dual| if is_own { number.derivatives()[lane] } else { 0.0 };
        let absorption_per_m = Dual::new(point.absorption_per_m, [own(&self.absorption_per_m); LANES]);
        let absorbed_per_m = absorption_per_m * Dual::new(point.absorbed_fluence, [absorbed_fluence; LANES]);
        let rate_per_cm = Dual::new(self.rate_per_cm.value(), [own(&self.rate_per_cm); LANES]);
        let e_folding_depth_cm = Dual::from(1.0) / rate_per_cm;
        DepthFluxes {
            down,
            up,
            net,
            fluence,
            absorbed_per_m: absorbed_per_m.derivatives()[lane],
            e_folding_depth_cm: e_folding_depth_cm.derivatives()[lane],
        }
    }
}
