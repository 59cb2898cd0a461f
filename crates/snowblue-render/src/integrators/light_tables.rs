//! Light that a path carries: spectra, or the sensor's responses to them.
//!
//! Light that has met one surface is the light's power times a reflectance or a transmittance. The sensor's response
//! to it is linear in that spectrum, so for each light and each snow it can be tabulated in place of the spectrum
//! ([`ProjectedTable`]): four numbers instead of 31 wavelengths. Responses from tables agree with responses to
//! spectra within 2·10⁻⁴.

use std::ops::{AddAssign, Mul};
use std::sync::Arc;

use snowblue_base::narrow;
use snowblue_database::lookup::{PROJECTIONS, ProjectedTable};

use crate::integrators::pcasnow::{SnowCurves, SnowVertex};
use crate::integrators::surface::{Shading, Surface};
use snowblue_scene::Scene;
use snowblue_scene::film::sensor::SensorSample;
use snowblue_scene::light::{IncidentLight, Light, LightOrigin, LightSample};
use snowblue_scene::material::Material;
use snowblue_scene::material::diffuse::Diffuse;
use snowblue_scene::spectrum::{SAMPLES, Spectrum};

/// Greatest number of projected tables of a scene. Each table takes about 1 MB and some 5 ms. Light of further lights
/// and materials is computed as spectra.
const MAX_TABLES: usize = 32;

/// Radiance along a path, or the sensor's response to it.
pub(super) trait Carried: Copy + AddAssign + Mul<f32, Output = Self> {
    /// No light.
    const ZERO: Self;

    /// Light that the camera sees directly.
    fn emitted(scene: &Scene, radiance: &Spectrum) -> Self;

    /// Light after reflection: reflectance times power.
    fn reflected(source: &Source, surface: &Surface, incident: &IncidentLight) -> Self;

    /// Light after transmission through snow: transmittance times power.
    fn transmitted(source: &Source, snow: &SnowVertex, depth_cm: f32, cos_incidence: f32) -> Self;

    /// Luminance.
    fn luminance(&self, tables: &LightTables) -> f32;

    /// The difference from other light.
    fn less(self, other: Self) -> Self;
}

/// The light of a light sample, as a source of spectra.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    scene: &'a Scene,
    light: &'a Light,
    origin: &'a LightOrigin,
    table: Option<&'a LightTable>,
}

/// Data that all paths of a rendering share: samples of each light of the scene, and responses to it.
#[derive(Debug)]
pub(super) struct LightTables {
    /// Luminance of one unit at each wavelength.
    luminance: Spectrum,
    /// For each light in turn, its sample if it has no extent.
    delta_samples: Vec<Option<LightSample>>,
    /// For each light in turn, the responses to it, unless it has several spectra.
    lights: Vec<Option<LightTable>>,
}

/// Responses to one light.
#[derive(Debug)]
struct LightTable {
    /// Response to a transmittance or reflectance of 1 at each wavelength, and of 0 at all others.
    weights: [[f32; PROJECTIONS]; SAMPLES],
    /// For each material in turn.
    materials: Vec<MaterialResponse>,
}

/// The response to a light after one material.
#[derive(Debug)]
enum MaterialResponse {
    /// A uniform reflectance.
    Constant(SensorSample),
    /// Uniform snow, and the response for its reflectance if a constant replaces the curves.
    Snow { table: Box<ProjectedTable>, constant_reflectance: Option<SensorSample> },
    /// The spectrum has to be computed.
    Spectral,
}

impl LightTables {
    /// No tables: all light is computed as spectra.
    pub(super) fn none(scene: &Scene) -> Self {
        Self {
            luminance: scene.sensor().luminance(),
            delta_samples: scene.lights().iter().map(|light| light.delta_sample()).collect(),
            lights: Vec::new(),
        }
    }

    /// Tables for all lights and materials that have one spectrum each, with the curves of each material's snow.
    pub(super) fn new(scene: &Scene, curves: &[Option<Arc<SnowCurves>>]) -> Self {
        let mut tables_left = MAX_TABLES;
        let light = |light: &Arc<Light>| Some(LightTable::new(scene, curves, light.uniform_power()?, &mut tables_left));
        Self { lights: scene.lights().iter().map(light).collect(), ..Self::none(scene) }
    }

    /// The one sample of a light without extent.
    #[inline]
    pub(super) fn delta_sample(&self, light: usize) -> Option<&LightSample> {
        self.delta_samples[light].as_ref()
    }
}

impl LightTable {
    fn new(scene: &Scene, curves: &[Option<Arc<SnowCurves>>], power: &Spectrum, tables_left: &mut usize) -> Self {
        let weights = scene.sensor().weights_of(power);
        let of_material = |(number, material): (usize, &Material)| match material {
            Material::Diffuse(Diffuse::Uniform(reflectance), _) => {
                MaterialResponse::Constant(sum(&weights, reflectance))
            }
            Material::Diffuse(Diffuse::Textured(_), _) | Material::Glass(_) | Material::Ground(_) => {
                MaterialResponse::Spectral
            }
            Material::Snow(_) => {
                let curves = curves.get(number).and_then(Option::as_deref).filter(|_| *tables_left > 0);
                let Some(table) = curves.and_then(SnowCurves::single).and_then(|snow| snow.project(&weights)) else {
                    return MaterialResponse::Spectral;
                };
                *tables_left -= 1;
                let constant = scene.integrator().pcasnow.reflectance;
                let constant_reflectance =
                    constant.map(|reflectance| sum(&weights, &Spectrum::constant(narrow(reflectance.get()))));
                MaterialResponse::Snow { table: Box::new(table), constant_reflectance }
            }
        };
        Self { materials: scene.materials().iter().enumerate().map(of_material).collect(), weights }
    }
}

/// Response to a spectrum times the light.
fn sum(weights: &[[f32; PROJECTIONS]; SAMPLES], spectrum: &Spectrum) -> SensorSample {
    spectrum.0.iter().zip(weights).map(|(value, weights)| SensorSample::from_array(*weights) * *value).sum()
}

impl<'a> Source<'a> {
    /// A sample of light number `light`.
    #[inline]
    pub(super) fn new(scene: &'a Scene, tables: &'a LightTables, light: usize, sample: &'a LightSample) -> Self {
        let table = tables.lights.get(light).and_then(Option::as_ref);
        Self { scene, light: &scene.lights()[light], origin: &sample.origin, table }
    }

    fn power(&self) -> Spectrum {
        self.light.power(self.origin)
    }

    /// Response to a reflectance or transmittance times the power.
    fn response(&self, spectrum: &Spectrum) -> SensorSample {
        match self.table {
            Some(table) => sum(&table.weights, spectrum),
            None => self.scene.sensor().sample(&(*spectrum * self.power())),
        }
    }

    #[inline]
    fn material(&self, material: usize) -> &'a MaterialResponse {
        self.table.map_or(&MaterialResponse::Spectral, |table| &table.materials[material])
    }
}

impl Carried for Spectrum {
    const ZERO: Self = Self::ZERO;

    fn emitted(_: &Scene, radiance: &Spectrum) -> Self {
        *radiance
    }

    fn reflected(source: &Source, surface: &Surface, incident: &IncidentLight) -> Self {
        surface.reflectance(incident.direction) * source.power()
    }

    fn transmitted(source: &Source, snow: &SnowVertex, depth_cm: f32, cos_incidence: f32) -> Self {
        snow.transmittance(depth_cm, cos_incidence) * source.power()
    }

    fn luminance(&self, tables: &LightTables) -> f32 {
        self.dot(&tables.luminance)
    }

    fn less(mut self, other: Self) -> Self {
        self += other * -1.0;
        self
    }
}

impl Carried for SensorSample {
    const ZERO: Self = Self::ZERO;

    fn emitted(scene: &Scene, radiance: &Spectrum) -> Self {
        scene.sensor().sample(radiance)
    }

    #[inline]
    fn reflected(source: &Source, surface: &Surface, incident: &IncidentLight) -> Self {
        match (source.material(surface.hit.material), &surface.shading) {
            (MaterialResponse::Constant(response), _)
            | (MaterialResponse::Snow { constant_reflectance: Some(response), .. }, _) => *response,
            (MaterialResponse::Snow { table, .. }, Shading::Snow(snow)) => {
                let angle_deg = snow.look_up_angle_deg(incident.cos_incidence);
                Self::from_array(table.reflectance(snow.depth_cm(), angle_deg))
            }
            _ => source.response(&surface.reflectance(incident.direction)),
        }
    }

    #[inline]
    fn transmitted(source: &Source, snow: &SnowVertex, depth_cm: f32, cos_incidence: f32) -> Self {
        match source.material(snow.material_index()) {
            MaterialResponse::Snow { table, .. } if depth_cm <= table.last_thickness_cm() => {
                Self::from_array(table.transmittance(depth_cm, snow.look_up_angle_deg(cos_incidence)))
            }
            _ => source.response(&snow.transmittance(depth_cm, cos_incidence)),
        }
    }

    #[inline]
    fn luminance(&self, _: &LightTables) -> f32 {
        SensorSample::luminance(*self)
    }

    #[inline]
    fn less(self, other: Self) -> Self {
        let ([x, y, z], [less_x, less_y, less_z]) = (self.xyz(), other.xyz());
        Self::from_array([x - less_x, y - less_y, z - less_z, self.magnitude() + other.magnitude()])
    }
}
