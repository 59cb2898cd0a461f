//! The lights of a scene, grouped by their spectra.
//!
//! Light is solved for at few wavelengths, and interpolated between them relative to the spectrum of the light. Lights
//! of different spectra therefore have separate solutions.

use std::collections::BTreeMap;
use std::f32::consts::PI;
use std::sync::Arc;

use snowblue_field::{SpectralNodes, VolumeSource};

use snowblue_scene::Scene;
use snowblue_scene::light::Light;
use snowblue_scene::light::emitter::InnerLamp;
use snowblue_scene::objects::Object;
use snowblue_scene::spectrum::Spectrum;

/// Largest difference of proportional spectra, relative to their maximum.
const SAME_SPECTRUM: f32 = 1e-3;

/// A lamp inside snow, or a part of a lamp.
#[derive(Debug, Clone)]
pub struct LampInSnow {
    /// Index of the light in the scene.
    pub(crate) light: usize,
    /// An object of the body that holds the lamp.
    pub(crate) object: usize,
    pub(crate) lamp: InnerLamp,
    /// Whether the middle of the lamp is inside.
    pub(crate) is_whole: bool,
}

impl LampInSnow {
    /// The lamp as a source of diffuse light.
    pub(super) fn source(&self, nodes: &SpectralNodes) -> VolumeSource {
        let InnerLamp { position, radius_m, intensity } = &self.lamp;
        VolumeSource {
            centre: position.as_dvec3(),
            radius_m: f64::from(*radius_m),
            power: nodes.gather(|wavelength| 4.0 * PI * intensity.0[wavelength]).collect(),
        }
    }
}

/// The parts of a light that are inside the snow of a scene. `index` is stored as the index of the light.
///
/// # Errors
///
/// The object that holds the light, if the light is neither a point nor a sphere.
pub(super) fn parts_in_snow(scene: &Scene, index: usize, light: &Light) -> Result<Vec<LampInSnow>, usize> {
    let is_snow = |object: &Object| scene.materials()[object.material].is_snow();
    let position = light.central_sample().and_then(|sample| sample.origin.position());
    let holder = position.and_then(|position| scene.objects().around(position, is_snow));
    match (light.inner_lamp(), holder) {
        (None, None) => Ok(Vec::new()),
        (None, Some(object)) => Err(object),
        (Some(lamp), Some(object)) => Ok(vec![LampInSnow { light: index, object, lamp, is_whole: true }]),
        (Some(lamp), None) => {
            // A body of several objects has the largest cap of these objects.
            let mut caps: BTreeMap<usize, LampInSnow> = BTreeMap::new();
            for (object, snow) in scene.objects().list().iter().enumerate().filter(|(_, object)| is_snow(object)) {
                let holds = |point| scene.objects().holds(object, point);
                let Some(lamp) = lamp.cap_in(&snow.shape, holds) else { continue };
                let body = scene.objects().body_of(object)[0];
                if caps.get(&body).is_none_or(|cap| cap.lamp.radius_m < lamp.radius_m) {
                    caps.insert(body, LampInSnow { light: index, object, lamp, is_whole: false });
                }
            }
            Ok(caps.into_values().collect())
        }
    }
}

/// Lights of proportional spectra.
pub(super) struct Illumination<'a> {
    /// Their indices in the scene.
    pub(super) indices: Vec<usize>,
    pub(super) lights: Vec<&'a Light>,
    /// The lamps, and parts of lamps, among these lights that are inside snow.
    pub(super) lamps: Vec<&'a LampInSnow>,
    /// Their spectrum; none if it varies, as the spectrum of an image does.
    pub(super) spectrum: Option<Spectrum>,
}

/// Groups lights of proportional spectra. Dark lights are left out.
pub(super) fn illuminations<'a>(lights: &'a [Arc<Light>], lamps: &'a [LampInSnow]) -> Vec<Illumination<'a>> {
    let mut found: Vec<Illumination> = Vec::new();
    for (index, light) in lights.iter().enumerate() {
        let spectrum = light.uniform_power().copied();
        // A dark light would be proportional to all others.
        if spectrum.is_some_and(|spectrum| spectrum.maximum() <= 0.0) {
            continue;
        }
        let parts = lamps.iter().filter(|lamp| lamp.light == index);
        let same = |one: &&mut Illumination| match (&one.spectrum, &spectrum) {
            (Some(one), Some(other)) => are_proportional(one, other),
            _ => false,
        };
        match found.iter_mut().find(same) {
            Some(one) => {
                one.indices.push(index);
                one.lights.push(light);
                one.lamps.extend(parts);
            }
            None => {
                let lamps = parts.collect();
                found.push(Illumination { indices: vec![index], lights: vec![light], lamps, spectrum });
            }
        }
    }
    found
}

fn are_proportional(one: &Spectrum, other: &Spectrum) -> bool {
    let [scale, other_scale] = [one, other].map(Spectrum::maximum);
    one.0.iter().zip(other.0).all(|(a, b)| (a * other_scale - b * scale).abs() <= SAME_SPECTRUM * scale * other_scale)
}
