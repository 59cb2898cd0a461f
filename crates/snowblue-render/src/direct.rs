//! Light straight from lamps without extent, as colours from the start: a short way for pictures that ask for no more.
//!
//! Where light comes from such lamps alone and none goes from surface to surface, a point of even paint or snow has one colour
//! for each lamp, times its irradiance. The colours of snow are looked up as such
//! ([`WeighedSnow`](snowblue_database::lookup::WeighedSnow)), four numbers instead of 31 wavelengths. They are those of the long
//! way to 2·10⁻⁴. Single wavelengths in false colour go the long way: small differences of such sums would tell them apart.

use std::f32::consts::FRAC_1_PI;

use snowblue_database::lookup::{SUMS, WeighedSnow};

use crate::light::{Beam, Place};
use crate::material::Material;
use crate::material::diffuse::Diffuse;
use crate::material::pca_snow::{Emission, Passage, PcaSnowMaterial, Reflection, angle_deg, depth_cm};
use crate::objects::Surface;
use crate::probe::{Probe, Side};
use crate::retina::Colour;
use crate::scene::{Integrator, Scene};
use crate::spectrum::{SAMPLES, Spectrum};

/// The lamps of a scene, and what each material makes of their colours.
#[derive(Debug)]
pub(crate) struct DirectLight {
    lamps: Vec<Lamp>,
    /// For each material in turn, what it makes of each lamp.
    finishes: Vec<Vec<Finish>>,
}

/// One lamp.
#[derive(Debug)]
struct Lamp {
    beam: Beam,
    /// The colour of one unit at each wavelength of what is made of its light.
    weights: [[f32; SUMS]; SAMPLES],
}

/// A material in the light of one lamp.
#[derive(Debug)]
enum Finish {
    /// The colour that it reflects.
    Diffuse(Colour),
    /// Snow.
    Snow(Box<WeighedSnow>),
}

impl DirectLight {
    /// The short way for a scene, if it is enough: for lamps without extent, no bounces, and materials that are the same
    /// everywhere.
    pub(crate) fn of(scene: &Scene) -> Option<Self> {
        let settings = &scene.integrator;
        if settings.integrator != Integrator::Path || settings.max_bounces > 0 || !scene.retina.is_eye() {
            return None;
        }
        let lamp = |beam: Beam| Lamp { beam, weights: scene.retina.weights_of(&beam.power) };
        let lamps = scene.lights.iter().map(|light| light.single().map(lamp)).collect::<Option<Vec<_>>>()?;
        let finishes = |material: &Material| lamps.iter().map(|lamp| Finish::of(material, lamp)).collect();
        let finishes = scene.materials.iter().map(finishes).collect::<Option<Vec<_>>>()?;
        Some(Self { lamps, finishes })
    }

    /// The colour of the light that leaves a surface point of a scene towards the eye.
    pub(crate) fn leaving(&self, scene: &Scene, probe: &mut Probe, surface: &Surface) -> Colour {
        let finishes = &self.finishes[surface.material];
        match &scene.materials[surface.material] {
            Material::Diffuse(_) => self.reflected(probe, surface, |_, lamp| match &finishes[lamp] {
                Finish::Diffuse(colour) => *colour,
                Finish::Snow(_) => Colour::ZERO,
            }),
            Material::PcaSnow(snow) => self.leaving_snow(probe, (snow, finishes), surface),
        }
    }

    fn leaving_snow(
        &self,
        probe: &mut Probe,
        (snow, finishes): (&PcaSnowMaterial, &[Finish]),
        surface: &Surface,
    ) -> Colour {
        let hit = snow.hit(probe.objects(), surface);
        let straight = hit.straight(probe);
        let depth_cm = straight.as_ref().map_or(0.0, depth_cm);
        let mut sum = self.reflected(probe, surface, |cos_incidence, lamp| match (&finishes[lamp], snow.reflection) {
            (Finish::Snow(curves), Reflection::Table) => {
                Colour::from_array(curves.reflectance(depth_cm, angle_deg(cos_incidence)))
            }
            (_, Reflection::Constant(share)) => self.lamps[lamp].colour_of(&Spectrum::constant(share)),
            (Finish::Diffuse(_), Reflection::Table) => Colour::ZERO,
        });
        for (lamp, finish) in self.lamps.iter().zip(finishes) {
            let Finish::Snow(curves) = finish else { continue };
            let light = |passage: &Passage| {
                let transmittance = if passage.depth_cm <= curves.most_cm() {
                    Colour::from_array(curves.transmittance(passage.depth_cm, passage.angle_deg()))
                } else {
                    let mut spectrum = Spectrum::ZERO;
                    hit.curves().transmittance(passage.depth_cm, passage.angle_deg(), &mut spectrum.0);
                    lamp.colour_of(&spectrum)
                };
                transmittance * (passage.arrival.irradiance_per_power * FRAC_1_PI)
            };
            sum += hit.through(probe, (&lamp.beam, straight.as_ref()), light, |light| light.y).unwrap_or_default();
        }
        sum
    }

    /// L = R E / π of all lamps that shine on a surface; `colour` is R in the light of one of them.
    #[inline]
    fn reflected(&self, probe: &mut Probe, surface: &Surface, colour: impl Fn(f32, usize) -> Colour) -> Colour {
        let place = Place { point: surface.point, normal: surface.normal };
        let mut sum = Colour::ZERO;
        for (number, lamp) in self.lamps.iter().enumerate() {
            if let Some(arrival) = lamp.beam.arrival(&place)
                && lamp.beam.reaches(probe, &place, Side::Outer(surface.object))
            {
                sum += colour(arrival.cos_incidence, number) * (arrival.irradiance_per_power * FRAC_1_PI);
            }
        }
        sum
    }
}

impl Lamp {
    /// The colour of its light after a share of each wavelength is left.
    fn colour_of(&self, shares: &Spectrum) -> Colour {
        shares.0.iter().zip(self.weights).map(|(share, weights)| Colour::from_array(weights) * *share).sum()
    }
}

impl Finish {
    fn of(material: &Material, lamp: &Lamp) -> Option<Self> {
        match material {
            Material::Diffuse(Diffuse::Even(reflectance)) => Some(Self::Diffuse(lamp.colour_of(reflectance))),
            Material::Diffuse(Diffuse::Painted(_)) => None,
            Material::PcaSnow(snow) if snow.emission == Emission::Relative => None,
            Material::PcaSnow(snow) => Some(Self::Snow(Box::new(snow.curves.the_one()?.weighed(&lamp.weights)?))),
        }
    }
}
