//! Snow as the subsurface parameters of other renderers: a colour and a radius for each of three channels, and an
//! asymmetry.
//!
//! A renderer's random walk has a Henyey–Greenstein medium without a boundary for each channel of a colour space.
//! Snow has a spectrum. The rule from the spectrum to the media:
//!
//! - **Weights.** w_c(λ) is the contribution of light of the wavelength λ to channel c of white: the colour matching
//!   functions of the primaries times the illuminant, adapted to the white of the space, so that Σ w_c = 1. Some
//!   weights are negative.
//! - **Albedo.** Channel c of deep snow under diffuse light is A_c = Σ w_c(λ) R(λ), with R by discrete ordinates. The
//!   co-albedo 1 − α_c is the co-albedo of the Henyey–Greenstein half-space with this albedo, by discrete ordinates
//!   again.
//! - **Length.** The transport mean free path ℓ*_c = Σ w_c(λ) ℓ*(λ), ℓ* = 1/(κ(1 − ωg)), is kept: κ_c = 1/(ℓ*_c (1 −
//!   α_c g)) with one asymmetry g for all channels: the mean asymmetry of the snow, weighted by luminance, but at
//!   most the greatest value that the renderer accepts (similarity, van de Hulst 1980, *Multiple Light Scattering*,
//!   §14.1).
//! - **Colour.** The renderer's own inversion of colours ([`AlbedoInversion`]) is solved for 1 − α_c.
//!
//! [`ChannelLook`] holds the albedo, the transmittance through some depths and the spread of light. These quantities
//! are computed for snow and for the renderer's medium.

mod inversion;

use rayon::prelude::*;
use snowblue_color::{ChromaticAdaptation, Colorimeter, Rgb, RgbSpace};
use snowblue_transport::medium::{GrainTallies, HenyeyGreenstein, Medium, Population, TallyPlan};
use snowblue_transport::monte_carlo::{BeamPlan, NarrowBeam};
use snowblue_transport::ordinates::{MediumFluxes, OrdinatesOptions, Peak, Streams};
use snowblue_transport::sample::SnowSample;
use snowblue_transport::slab::Incidence;
use snowblue_transport::{Demand, PhaseFunction, PhasePlan, TransportError};

pub use inversion::AlbedoInversion;
use inversion::bisect;

/// Thicknesses of the slabs whose transmittance is compared, in cm.
pub const DEPTHS_CM: [f64; 4] = [1.0, 5.0, 15.0, 30.0];

/// Light on deep snow and on slabs: normal incidence and diffuse.
const LIGHTS: [Incidence; 2] = [Incidence::Beam { angle_deg: 0.0 }, Incidence::Diffuse];
/// Wavelength of the index of ice, and of the phase function whose walks give the spread of light, in nm.
const MIDDLE_NM: f64 = 550.0;
/// Walks of a narrow beam. The radius of half of the light has a standard error of 1 %.
const WALKS: u32 = 1 << 15;
/// Streams of Henyey–Greenstein media with g up to 0.9: the albedo within 10⁻⁵.
const HG_STREAMS: usize = 32;
/// Number of walks in a renderer that ends walks. Few of these walks pass the greater depths.
const ENDING_WALKS: u32 = 1 << 17;
/// Least effective number of walks behind a transmittance, for a standard error of 10 %.
const MIN_WALKS: f64 = 100.0;
/// Length of a walk in transport mean free paths. Longer walks carry 8 % of all light. This light leaves some 20
/// transport mean free paths from the entry, and one thousandth of all light within the radius of half of the light.
const WALK_LENGTH: f64 = 300.0;
/// Seed of the walks. Snow and preset use one seed, so that they share their noise.
const SEED: u64 = 1;
/// Least co-albedo of a channel: its half-space is white to 3·10⁻⁷, 4 √(c/3(1 − g)) with g up to 0.9.
const MIN_CO_ALBEDO: f64 = 1e-15;
/// Greatest albedo of a channel.
const MAX_ALBEDO: f64 = 1.0 - 1e-6;

/// Why a sample has no preset.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PresetError {
    /// A parameter of the sample is out of range.
    #[error(transparent)]
    Transport(#[from] TransportError),
    /// The colour of deep snow has no medium.
    #[error(
        "{channel} of deep snow is {albedo:.7} in {space}, but a preset needs a value above 0 and at most \
        {MAX_ALBEDO}"
    )]
    OutsideGamut {
        /// The channel.
        channel: &'static str,
        /// Its value.
        albedo: f64,
        /// The colour space.
        space: RgbSpace,
    },
}

/// A renderer's interpretation of subsurface parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SubsurfaceModel {
    /// OpenPBR 1.1: the radius is the mean free path 1/κ, colours are inverted after van de Hulst, walks have no end.
    OpenPbr,
    /// Principled BSDF in Blender's Cycles, method "Random Walk" of Blender 4.0 to 5.1: the radius is 4π ℓ*, and
    /// walks end after 256 flights. The preset has isotropic scattering, which Cycles uses after ten flights.
    Cycles,
}

/// The optics of a sample that presets are fitted to and compared with.
pub struct SnowReference {
    /// [wavelength]
    spectrum: Vec<SpectralOptics>,
    /// The contribution of each wavelength to X, Y, Z of the light.
    colorimeter: Colorimeter,
    index: f64,
    beam: NarrowBeam,
    /// ℓ* of the beam, in mean free paths.
    beam_transport_length: f64,
}

/// Snow at one wavelength.
#[derive(Debug, Clone)]
struct SpectralOptics {
    one_minus_albedo: f64,
    asymmetry: f64,
    transport_length_m: f64,
    /// Deep snow under normal incidence and diffuse light.
    albedos: [f64; 2],
    transmittances: [f64; DEPTHS_CM.len()],
}

/// Subsurface parameters for one renderer and one colour space.
#[derive(Debug, Clone, PartialEq)]
pub struct RendererPreset {
    /// The colour space of the channels.
    pub space: RgbSpace,
    /// Asymmetry of the Henyey–Greenstein phase function.
    pub asymmetry: f64,
    /// Refractive index of ice at 550 nm. The medium itself has no boundary.
    pub index: f64,
    /// Red, green and blue.
    pub channels: [ChannelPreset; 3],
}

/// Subsurface parameters of one channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChannelPreset {
    /// Subsurface colour: the albedo as the renderer defines it.
    pub color: f64,
    /// Radius as the renderer defines it, in m.
    pub radius_m: f64,
    /// Extinction coefficient of the medium, in 1/m.
    pub extinction_per_m: f64,
    /// Single-scattering co-albedo that the renderer finds for the colour.
    pub one_minus_albedo: f64,
    /// The optics of snow.
    pub snow: ChannelLook,
    /// The optics of the renderer's medium.
    pub preset: ChannelLook,
}

/// A transmittance, or an upper bound of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Transmittance {
    /// Its value.
    Value(f64),
    /// An upper bound, where too few walks pass for an estimate.
    Below(f64),
}

/// The optics of deep snow or of a preset in one channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChannelLook {
    /// Albedo of deep snow under diffuse light.
    pub albedo: f64,
    /// Transmittance of slabs of [`DEPTHS_CM`] over black ground, at normal incidence. A colour outside the space has
    /// a negative channel.
    pub transmittances: [Transmittance; DEPTHS_CM.len()],
    /// Radius about the entry of a narrow beam, at normal incidence, within which half of the reflected light leaves
    /// deep snow, in m.
    pub half_radius_m: f64,
}

impl SubsurfaceModel {
    /// Greatest asymmetry of a preset. OpenPBR lets renderers clamp high asymmetries.
    fn greatest_asymmetry(self) -> f64 {
        match self {
            Self::OpenPbr => 0.9,
            Self::Cycles => 0.0,
        }
    }

    /// The way from a colour to single scattering.
    #[must_use]
    pub fn inversion(self) -> AlbedoInversion {
        match self {
            Self::OpenPbr => AlbedoInversion::VanDeHulst,
            Self::Cycles => AlbedoInversion::Cycles,
        }
    }

    /// Straight flights after which the renderer ends a walk.
    fn most_flights(self) -> Option<u32> {
        match self {
            Self::OpenPbr => None,
            Self::Cycles => Some(256),
        }
    }

    /// The radius of a mean free path, both in m. Cycles divides radii by 4π for the transport mean free path.
    fn radius_m(self, mean_free_path_m: f64) -> f64 {
        match self {
            Self::OpenPbr => mean_free_path_m,
            Self::Cycles => 4.0 * std::f64::consts::PI * mean_free_path_m,
        }
    }
}

impl SnowReference {
    /// Computes the optics of a sample on the wavelengths of a colorimeter, whose light is white.
    ///
    /// # Errors
    /// If a parameter of the sample or the number of streams is out of range.
    pub fn new(
        sample: &SnowSample,
        colorimeter: &Colorimeter,
        options: &OrdinatesOptions,
    ) -> Result<Self, TransportError> {
        sample.check()?;
        options.streams.check()?;
        let wavelengths_nm = colorimeter.wavelengths_nm();
        wavelengths_nm.iter().try_for_each(|nm| sample.check_wavelength(*nm))?;
        let peak = Peak::of(sample);
        let degree = options.streams.most(&LIGHTS, peak);
        let plan = TallyPlan { degree, rays: options.tally_rays, seed: options.seed };
        let demand = Demand::of_sample(sample, wavelengths_nm);
        let tallies = GrainTallies::new(&Population::of_sample(sample), &demand, &plan);
        let optics = |nm: &f64| SpectralOptics::new(&tallies.medium(sample, *nm), options.streams, peak);
        let spectrum = wavelengths_nm.par_iter().map(optics).collect();
        let middle = tallies.medium(sample, MIDDLE_NM).scattering;
        let phase = PhaseFunction::of_sample(sample, MIDDLE_NM, &PhasePlan::default())?;
        let phase = phase.with_asymmetry(middle.asymmetry());
        Ok(Self {
            spectrum,
            colorimeter: colorimeter.clone(),
            index: sample.ice.index(MIDDLE_NM),
            beam_transport_length: 1.0 / (1.0 - (1.0 - middle.one_minus_albedo) * middle.asymmetry()),
            beam: NarrowBeam::new(&phase, LIGHTS[0], &[], &beam_plan(&phase)),
        })
    }

    /// The albedo of deep snow under diffuse light in a colour space: red, green and blue.
    ///
    /// # Errors
    /// If a channel is not between 0 and 1.
    pub fn albedo(&self, space: RgbSpace) -> Result<[f64; 3], PresetError> {
        let weights = self.weights(space);
        let albedo = std::array::from_fn(|channel| self.mean(&weights, channel, |optics| optics.albedos[1]));
        let is_inside = |albedo: f64| albedo > 0.0 && albedo < MAX_ALBEDO;
        match ["red", "green", "blue"].into_iter().zip(albedo).find(|(_, albedo)| !is_inside(*albedo)) {
            Some((channel, albedo)) => Err(PresetError::OutsideGamut { channel, albedo, space }),
            None => Ok(albedo),
        }
    }

    /// The preset for a renderer in a colour space.
    ///
    /// # Errors
    /// If a channel of deep snow is not between 0 and 1.
    pub fn preset(&self, space: RgbSpace, model: SubsurfaceModel) -> Result<RendererPreset, PresetError> {
        let weights = self.weights(space);
        let luminance = self.colorimeter.weights();
        let mean_asymmetry: f64 =
            self.spectrum.iter().zip(luminance).map(|(optics, weight)| weight.y * optics.asymmetry).sum();
        let asymmetry = mean_asymmetry.min(model.greatest_asymmetry());
        let mut media = Vec::new();
        for (channel, albedo) in self.albedo(space)?.into_iter().enumerate() {
            let wanted = co_albedo(albedo, asymmetry);
            let color = model.inversion().color(wanted, asymmetry);
            let one_minus_albedo = model.inversion().one_minus_albedo(color, asymmetry);
            let transport_length_m = self.mean(&weights, channel, |optics| optics.transport_length_m);
            // Uses the wanted albedo: the renderer keeps the extinction, whatever albedo it finds for the colour.
            let mean_free_path_m = transport_length_m * (1.0 - (1.0 - wanted) * asymmetry);
            media.push((color, ChannelMedium { one_minus_albedo, asymmetry, mean_free_path_m }));
        }
        let looks = looks(&media.iter().map(|(_, medium)| *medium).collect::<Vec<_>>(), model);
        let channels = std::array::from_fn(|channel| {
            let (color, medium) = media[channel];
            ChannelPreset {
                color,
                radius_m: model.radius_m(medium.mean_free_path_m),
                extinction_per_m: 1.0 / medium.mean_free_path_m,
                one_minus_albedo: medium.one_minus_albedo,
                snow: self.look(&weights, channel),
                preset: looks[channel],
            }
        });
        Ok(RendererPreset { space, asymmetry, index: self.index, channels })
    }

    /// The contribution of each wavelength to each channel of white: [wavelength][channel].
    fn weights(&self, space: RgbSpace) -> Vec<[f64; 3]> {
        let adaptation = ChromaticAdaptation { from_white: self.colorimeter.white(), to_white: space.white() };
        let channels = |Rgb { r, g, b }| [r, g, b];
        self.colorimeter.weights().iter().map(|xyz| channels(space.from_xyz(adaptation.apply(*xyz)))).collect()
    }

    /// A quantity in one channel: its sum over wavelengths with the weights of the channel.
    fn mean(&self, weights: &[[f64; 3]], channel: usize, quantity: impl Fn(&SpectralOptics) -> f64) -> f64 {
        self.spectrum.iter().zip(weights).map(|(optics, weight)| weight[channel] * quantity(optics)).sum()
    }

    /// The optics of snow in one channel.
    fn look(&self, weights: &[[f64; 3]], channel: usize) -> ChannelLook {
        let mean = |quantity: &dyn Fn(&SpectralOptics) -> f64| self.mean(weights, channel, quantity);
        let [normal, albedo] = [0, 1].map(|light| mean(&|optics| optics.albedos[light]));
        let kept = |events: u32| mean(&|optics| kept(optics.one_minus_albedo, events));
        // Fraction of the channel's light that is left after each number of events. The radius scales with the
        // transport mean free path of the channel.
        let by_events: Vec<f64> = (0..=self.beam.most_events()).map(kept).collect();
        let radius = self.beam.radius(0.5 * normal, |events| by_events[events as usize]);
        let length_m = mean(&|optics| optics.transport_length_m) / self.beam_transport_length;
        ChannelLook {
            albedo,
            transmittances: std::array::from_fn(|depth| {
                Transmittance::Value(mean(&|optics| optics.transmittances[depth]))
            }),
            half_radius_m: radius.map_or(f64::INFINITY, |radius| radius * length_m),
        }
    }
}

impl SpectralOptics {
    fn new(medium: &Medium, streams: Streams, peak: Peak) -> Self {
        let scattering = &medium.scattering;
        let albedo = 1.0 - scattering.one_minus_albedo;
        let (albedos, transmittances) = fluxes(medium, streams, peak);
        Self {
            one_minus_albedo: scattering.one_minus_albedo,
            asymmetry: scattering.asymmetry(),
            transport_length_m: 1.0 / (medium.extinction_per_m * (1.0 - albedo * scattering.asymmetry())),
            albedos,
            transmittances,
        }
    }
}

/// A renderer's medium in one channel.
#[derive(Debug, Clone, Copy)]
struct ChannelMedium {
    one_minus_albedo: f64,
    asymmetry: f64,
    mean_free_path_m: f64,
}

impl ChannelMedium {
    fn medium(self) -> Medium {
        let scattering = HenyeyGreenstein { one_minus_albedo: self.one_minus_albedo, asymmetry: self.asymmetry };
        Medium { extinction_per_m: 1.0 / self.mean_free_path_m, scattering: scattering.scattering(HG_STREAMS) }
    }

    /// Fluxes of a medium whose walks have no end: the albedos and the transmittances.
    fn fluxes(self) -> ([f64; 2], [f64; DEPTHS_CM.len()]) {
        fluxes(&self.medium(), Streams::Exactly(HG_STREAMS), Peak::Broad)
    }
}

/// Albedos of deep snow under [`LIGHTS`], and transmittances of [`DEPTHS_CM`] at normal incidence.
fn fluxes(medium: &Medium, streams: Streams, peak: Peak) -> ([f64; 2], [f64; DEPTHS_CM.len()]) {
    let mut thicknesses_cm = vec![f64::INFINITY];
    thicknesses_cm.extend(DEPTHS_CM);
    let found = medium.fluxes(&thicknesses_cm, &LIGHTS, streams, peak);
    let at = |thickness: usize, light: usize| -> MediumFluxes { found[LIGHTS.len() * thickness + light] };
    ([0, 1].map(|light| at(0, light).reflectance), std::array::from_fn(|depth| at(depth + 1, 0).transmittance))
}

/// Walks that are long enough to compute the radius of half of the light.
fn beam_plan(phase: &PhaseFunction) -> BeamPlan {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "g is at most 0.998")]
    let most_flights = (WALK_LENGTH / (1.0 - phase.asymmetry())).ceil() as u32;
    BeamPlan { walks: WALKS, most_flights, seed: SEED }
}

/// The fraction of light that is left after some events: (1 − c)ⁿ for the co-albedo c.
fn kept(one_minus_albedo: f64, events: u32) -> f64 {
    (f64::from(events) * (-one_minus_albedo).ln_1p()).exp()
}

/// The co-albedo of the Henyey–Greenstein half-space whose albedo under diffuse light is `albedo`, between 0 and
/// [`MAX_ALBEDO`], by bisection of its logarithm.
fn co_albedo(albedo: f64, asymmetry: f64) -> f64 {
    let of = |one_minus_albedo: f64| ChannelMedium { one_minus_albedo, asymmetry, mean_free_path_m: 1.0 }.fluxes().0[1];
    let [low, high] = bisect([MIN_CO_ALBEDO.ln(), 0.0], |logarithm| of(logarithm.exp()) > albedo);
    (0.5 * (low + high)).exp()
}

/// The optics of the media of three channels in a renderer. The media differ in extinction and absorption only.
fn looks(media: &[ChannelMedium], model: SubsurfaceModel) -> Vec<ChannelLook> {
    let phase = PhaseFunction::henyey_greenstein(media[0].asymmetry);
    let depth = |medium: &ChannelMedium, cm: f64| 1e-2 * cm / medium.mean_free_path_m;
    let Some(most_flights) = model.most_flights() else {
        let beam = NarrowBeam::new(&phase, LIGHTS[0], &[], &beam_plan(&phase));
        let look = |medium: &ChannelMedium| {
            let ([normal, albedo], transmittances) = medium.fluxes();
            let radius = beam.radius(0.5 * normal, |events| kept(medium.one_minus_albedo, events));
            let half_radius_m = radius.map_or(f64::INFINITY, |radius| radius * medium.mean_free_path_m);
            ChannelLook { albedo, transmittances: transmittances.map(Transmittance::Value), half_radius_m }
        };
        return media.iter().map(look).collect();
    };
    // Walks with an end have no ordinates.
    let plan = BeamPlan { walks: ENDING_WALKS, most_flights, seed: SEED };
    let diffuse = NarrowBeam::new(&phase, LIGHTS[1], &[], &plan);
    let look = |medium: &ChannelMedium| {
        let depths = DEPTHS_CM.map(|cm| depth(medium, cm));
        let beam = NarrowBeam::new(&phase, LIGHTS[0], &depths, &plan);
        let kept = |events: u32| kept(medium.one_minus_albedo, events);
        let radius = beam.radius(0.5 * beam.reflectance(kept), kept);
        let (_, without_end) = medium.fluxes();
        let transmittance = |depth: usize| {
            // Where absorption removes the light of the longest walks, their end does not matter.
            if kept(most_flights) < 1e-3 * without_end[depth] {
                Transmittance::Value(without_end[depth])
            } else if beam.effective_walks(depth, kept) >= MIN_WALKS {
                Transmittance::Value(beam.transmittance(depth, kept))
            } else {
                Transmittance::Below(without_end[depth].min(MIN_WALKS / f64::from(ENDING_WALKS)))
            }
        };
        ChannelLook {
            albedo: diffuse.reflectance(kept),
            transmittances: std::array::from_fn(transmittance),
            half_radius_m: radius.map_or(f64::INFINITY, |radius| radius * medium.mean_free_path_m),
        }
    };
    media.iter().map(look).collect()
}

#[cfg(test)]
mod tests {
    use snowblue_color::{Illuminant, Observer};
    use snowblue_transport::optics::{Impurities, Substance};

    use super::*;

    fn colorimeter() -> Colorimeter {
        let wavelengths_nm: Vec<f64> = (40..=70).map(|ten| 10.0 * f64::from(ten)).collect();
        Colorimeter::new(Observer::Cie1931, Illuminant::D65, &wavelengths_nm).unwrap()
    }

    fn value(transmittance: Transmittance) -> f64 {
        match transmittance {
            Transmittance::Value(value) => value,
            Transmittance::Below(bound) => panic!("a value below {bound}"),
        }
    }

    fn options() -> OrdinatesOptions {
        OrdinatesOptions { tally_rays: 1 << 12, ..OrdinatesOptions::default() }
    }

    /// A grey medium with the Henyey–Greenstein phase function instead of snow.
    fn grey(one_minus_albedo: f64, asymmetry: f64) -> SnowReference {
        let medium = ChannelMedium { one_minus_albedo, asymmetry, mean_free_path_m: 1e-3 };
        let optics = SpectralOptics::new(&medium.medium(), Streams::Exactly(HG_STREAMS), Peak::Broad);
        let phase = PhaseFunction::henyey_greenstein(asymmetry);
        let plan = BeamPlan { walks: 1 << 12, ..beam_plan(&phase) };
        SnowReference {
            spectrum: vec![optics; 31],
            colorimeter: colorimeter(),
            index: 1.31,
            beam: NarrowBeam::new(&phase, LIGHTS[0], &[], &plan),
            beam_transport_length: 1.0 / (1.0 - (1.0 - one_minus_albedo) * asymmetry),
        }
    }

    /// The preset of a grey medium with the renderer's own phase function is that medium, in every channel of every
    /// space.
    #[test]
    fn a_grey_medium_comes_back() {
        for (one_minus_albedo, space) in [(1e-5, RgbSpace::Srgb), (1e-3, RgbSpace::Rec2020), (0.1, RgbSpace::AcesCg)] {
            let preset = grey(one_minus_albedo, 0.7).preset(space, SubsurfaceModel::OpenPbr).unwrap();
            for channel in &preset.channels {
                // The weights sum to 1 up to rounding. 1 − A = 0.01 then has 12 correct digits. The relative error of
                // 1 − α is twice as large.
                assert!((channel.one_minus_albedo / one_minus_albedo - 1.0).abs() < 1e-9, "{space} {channel:?}");
                assert!((1e-3 * channel.extinction_per_m - 1.0).abs() < 1e-9, "{space} {channel:?}");
                assert!((1e3 * channel.radius_m - 1.0).abs() < 1e-9);
                // Van de Hulst's colour is the albedo to within 1 % of the difference to white or to black.
                let missing = (1.0 - channel.snow.albedo).min(channel.snow.albedo);
                assert!((channel.color - channel.snow.albedo).abs() < 0.01 * missing, "{channel:?}");
            }
            assert!((preset.asymmetry - 0.7).abs() < 1e-12);
        }
    }

    /// Henyey & Greenstein's phase function changes the blue behind snow by up to 1 % at depth, and widens the circle
    /// of half of the light by up to 10 %.
    #[test]
    fn a_preset_has_the_albedo_and_the_transport_length_of_snow() {
        let reference = SnowReference::new(&SnowSample::default(), &colorimeter(), &options()).unwrap();
        for space in RgbSpace::ALL {
            let preset = reference.preset(space, SubsurfaceModel::OpenPbr).unwrap();
            let weights = reference.weights(space);
            for (channel, found) in preset.channels.iter().enumerate() {
                let length_m = reference.mean(&weights, channel, |optics| optics.transport_length_m);
                let reduced = 1.0 - (1.0 - found.one_minus_albedo) * preset.asymmetry;
                assert!((found.extinction_per_m * reduced * length_m - 1.0).abs() < 1e-9);
                assert!((found.preset.albedo - found.snow.albedo).abs() < 1e-9, "{found:?}");
                let ratio = found.preset.half_radius_m / found.snow.half_radius_m;
                assert!((0.9..1.1).contains(&ratio), "{ratio}");
            }
            let blue = preset.channels[2];
            for (preset, snow) in blue.preset.transmittances.into_iter().zip(blue.snow.transmittances) {
                let [preset, snow] = [preset, snow].map(value);
                assert!((preset / snow - 1.0).abs() < 0.03, "{space}: {preset} {snow}");
            }
        }
    }

    /// Cycles loses the light of long walks, 4/√(3π·256) of diffuse light without absorption.
    #[test]
    fn cycles_loses_the_light_of_long_walks() {
        let preset = grey(1e-5, 0.7).preset(RgbSpace::Srgb, SubsurfaceModel::Cycles).unwrap();
        for channel in &preset.channels {
            let ChannelPreset { snow, preset, .. } = channel;
            let lost = 4.0 / (3.0 * std::f64::consts::PI * 256.0).sqrt();
            // Absorption removes a part of the reflected light, which belongs to short walks.
            assert!((1.0 - preset.albedo - lost).abs() < 0.2 * lost, "{preset:?}");
            assert!(snow.albedo - preset.albedo > 0.05);
            assert!((channel.radius_m * channel.extinction_per_m / (4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-12);
            // The light that diffuses through a thickness of L steps ℓ* within N flights, over all light that
            // diffuses through it, is 1 + 2 Σ (−1)ᵏ exp(−k²π²N/3L²), with 0.71 ℓ* added to L on each side: the times
            // of first passage through a slab.
            for (depth, cm) in DEPTHS_CM.into_iter().enumerate() {
                let steps = 1e-2 * cm * channel.extinction_per_m + 2.0 * 0.7104;
                let decay = std::f64::consts::PI.powi(2) * 256.0 / (3.0 * steps * steps);
                let term = |k: i32| 2.0 * (-1.0_f64).powi(k) * (-f64::from(k * k) * decay).exp();
                let passed = 1.0 + (1..100).map(term).sum::<f64>();
                let snow = value(snow.transmittances[depth]);
                match preset.transmittances[depth] {
                    Transmittance::Value(preset) => {
                        let ratio = preset / snow;
                        // In 1 cm, 3 ℓ*, isotropic scattering differs by up to 2 % from the grey medium. The rest is
                        // the noise of walks.
                        let noise = 4.0 * (passed / (f64::from(ENDING_WALKS) * snow)).sqrt();
                        assert!((ratio - passed).abs() < 0.02 + noise, "{cm} cm: {ratio}, {passed}");
                    }
                    Transmittance::Below(bound) => assert!(passed * snow < bound && cm > 5.0, "{cm} cm: {passed}"),
                }
            }
        }
    }

    #[test]
    fn no_medium_is_white_or_black() {
        let mut reference = grey(1e-3, 0.7);
        for albedo in [1.0, 1.1, 0.0, -0.1, f64::NAN, 1.5] {
            reference.spectrum.iter_mut().for_each(|optics| optics.albedos[1] = albedo);
            assert!(reference.albedo(RgbSpace::Srgb).is_err(), "{albedo}");
        }
        let message = reference.preset(RgbSpace::Srgb, SubsurfaceModel::OpenPbr).unwrap_err().to_string();
        assert!(message.starts_with("red of deep snow is 1.5000000 in sRGB"), "{message}");
        let dirty =
            SnowSample { impurities: Impurities::none().with(Substance::BLACK_CARBON, 1e5), ..SnowSample::default() };
        let dirty = SnowReference::new(&dirty, &colorimeter(), &options()).unwrap();
        let black = dirty.preset(RgbSpace::AcesCg, SubsurfaceModel::OpenPbr).unwrap();
        assert!(black.channels.iter().all(|channel| channel.color < 0.3 && channel.color > 0.2), "{black:?}");
    }
}
