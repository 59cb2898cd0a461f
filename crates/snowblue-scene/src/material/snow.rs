//! The composition of snow, and the place of each kind of snow. Integrators decide how snow is rendered.
//!
//! Snow that varies by a mask is the first sample where the mask is 0 and the second sample where the mask is 1. In
//! between, its properties are in proportion to the mask. Inside a body, the snow is the snow of the nearest point of
//! the surface. Integrators compute with a few kinds of snow ([`SnowKinds`]) and interpolate between these kinds.

use glam::{DVec3, Vec3A};
use snowblue_base::narrow;
use snowblue_geometry::ray::SurfacePoint;
use snowblue_geometry::shape::Shape;
use snowblue_transport::sample::SnowSample;
use snowblue_transport::{Demand, GrainTallies, Population, TallyPlan};

use crate::layering::Layering;
use crate::material::mask::Mask;
use crate::material::relief::ReliefDescription;
use crate::material::sparkle::SparkleDescription;
use crate::objects::{Objects, SurfaceInteraction};
use crate::spectrum::{SAMPLES, wavelengths_nm};

/// Largest relative difference between the mean of the transport and absorption coefficients of two kinds of snow and
/// the coefficients of the snow halfway between both kinds.
const COEFFICIENT_TOLERANCE: f64 = 0.01;
/// Largest relative difference of the decay rate √(3 μ_a μ_tr) of light in this comparison. Through 100 cm of snow,
/// light decays by some e¹⁰.
const DECAY_TOLERANCE: f64 = 0.002;
/// Greatest number of halvings of the range of a mask, which makes at most 65 kinds.
const MAX_HALVINGS: u32 = 6;
/// Number of rays through grains for the comparison of kinds. All kinds use the same rays, so that their differences
/// have less noise.
const COMPARING_RAYS: u32 = 1 << 12;

/// Snow as a material.
#[derive(Debug)]
pub struct SnowMaterial {
    /// The composition of the snow, and the place of each part.
    pub snow: Snow,
    /// The sparkle of the snow, if it is drawn.
    pub sparkle: Option<SparkleDescription>,
    /// The relief of the snow's surface, if it has one.
    pub relief: Option<ReliefDescription>,
}

/// Snow, and the places of its parts.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "there is one for each material")]
pub enum Snow {
    /// The same snow everywhere.
    Uniform(SnowSample),
    /// Layers.
    Layers {
        /// The snow of each layer, top first.
        samples: Vec<SnowSample>,
        /// Where the layers lie.
        layering: Layering,
    },
    /// Snow that varies between two samples.
    Masked {
        /// The mask, which says where each sample lies.
        mask: Mask,
        /// The snow where the mask is 0, and the snow where the mask is 1.
        between: [SnowSample; 2],
    },
}

/// A few kinds of snow, and where each lies.
#[derive(Debug)]
pub struct SnowKinds {
    /// The kinds.
    pub samples: Vec<SnowSample>,
    places: Places,
}

/// The places of kinds of snow.
#[derive(Debug)]
enum Places {
    Everywhere,
    Layers(Layering),
    /// The mask, and the values of the mask at which the kinds lie, ascending from 0 to 1.
    Mask(Mask, Vec<f32>),
}

/// The snow at a place: a mix of two kinds, or one kind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KindMix {
    /// The number of the first kind.
    pub first: usize,
    /// The number of the second kind.
    pub second: usize,
    /// The share of the second kind; 0 if there is one kind.
    pub share: f32,
}

impl Snow {
    /// Checks that a shape has what a mask needs; the error says what is missing.
    pub(crate) fn check(&self, shape: &Shape) -> Result<(), String> {
        match self {
            Self::Uniform(_) | Self::Layers { .. } => Ok(()),
            Self::Masked { mask, .. } => mask.check(shape),
        }
    }

    /// The samples of the snow, at least one: the layers from the top, or the two samples of a mask.
    pub fn samples(&self) -> &[SnowSample] {
        match self {
            Self::Uniform(sample) => std::slice::from_ref(sample),
            Self::Layers { samples, .. } => samples,
            Self::Masked { between, .. } => between,
        }
    }

    /// The kinds of snow.
    pub fn kinds(&self) -> SnowKinds {
        match self {
            Self::Uniform(sample) => SnowKinds { samples: vec![*sample], places: Places::Everywhere },
            Self::Layers { samples, layering } => {
                SnowKinds { samples: samples.clone(), places: Places::Layers(layering.clone()) }
            }
            Self::Masked { mask, between } => {
                let mut kinds = vec![Kind::new(0.0, between)];
                add_kinds(&mut kinds, Kind::new(1.0, between), MAX_HALVINGS, &|at| Kind::new(at, between));
                let values = kinds.iter().map(|kind| narrow(kind.at)).collect();
                let samples = kinds.iter().map(|kind| kind.sample).collect();
                SnowKinds { samples, places: Places::Mask(mask.clone(), values) }
            }
        }
    }
}

/// A kind of snow at a value of a mask.
#[derive(Debug, Clone, PartialEq)]
struct Kind {
    at: f64,
    sample: SnowSample,
    /// The transport and absorption coefficients μ_tr and μ_a at the first, the middle and the last wavelength, in 1/m.
    coefficients: [[f64; 2]; 3],
}

impl Kind {
    fn new(at: f64, between: &[SnowSample; 2]) -> Self {
        let (sample, wavelengths_nm) = (SnowSample::between(between, at), wavelengths_nm());
        let demand = Demand::of_sample(&sample, &wavelengths_nm);
        let plan = TallyPlan { degree: 1, rays: COMPARING_RAYS, seed: 1 };
        let tallies = GrainTallies::new(&Population::of_sample(&sample), &demand, &plan);
        let coefficients = [0, SAMPLES / 2, SAMPLES - 1].map(|index| {
            let medium = tallies.medium(&sample, wavelengths_nm[index]);
            let lost = medium.scattering.one_minus_albedo;
            let transport_per_m = medium.extinction_per_m * (1.0 - (1.0 - lost) * medium.scattering.asymmetry());
            [transport_per_m, medium.extinction_per_m * lost]
        });
        Self { at, sample, coefficients }
    }

    /// Whether the kind is the even mix of two other kinds, within the tolerances.
    fn is_mean_of(&self, first: &Self, last: &Self) -> bool {
        let decay = |[transport, absorption]: [f64; 2]| (transport * absorption).sqrt();
        let is_near = |mean: f64, value: f64, tolerance: f64| (mean - value).abs() <= tolerance * value;
        let mut ends = first.coefficients.iter().zip(&last.coefficients).zip(&self.coefficients);
        ends.all(|((one, other), own)| {
            (0..2).all(|k| is_near(0.5 * (one[k] + other[k]), own[k], COEFFICIENT_TOLERANCE))
                && is_near(0.5 * (decay(*one) + decay(*other)), decay(*own), DECAY_TOLERANCE)
        })
    }
}

/// Adds the kinds after the last added kind up to `last`. Halves the interval until its middle is the mean of its
/// ends.
fn add_kinds(kinds: &mut Vec<Kind>, last: Kind, halvings: u32, kind_at: &dyn Fn(f64) -> Kind) {
    let first = &kinds[kinds.len() - 1];
    let middle = kind_at(0.5 * (first.at + last.at));
    if halvings > 0 && !middle.is_mean_of(first, &last) {
        add_kinds(kinds, middle, halvings - 1, kind_at);
        add_kinds(kinds, last, halvings - 1, kind_at);
    } else {
        kinds.push(last);
    }
}

impl KindMix {
    /// One kind alone.
    const fn one(kind: usize) -> Self {
        Self { first: kind, second: kind, share: 0.0 }
    }

    /// One of the two kinds, chosen by a number in [0, 1) with the probability of its share.
    #[inline]
    pub fn pick(&self, number: f32) -> usize {
        if number < self.share { self.second } else { self.first }
    }

    /// One of the kinds. The number in [0, 1) is drawn only where two kinds are mixed.
    #[inline]
    pub fn draw(&self, number: impl FnOnce() -> f32) -> usize {
        if self.share > 0.0 { self.pick(number()) } else { self.first }
    }
}

impl SnowKinds {
    /// Whether there is one kind only.
    #[inline]
    pub fn is_uniform(&self) -> bool {
        self.samples.len() == 1
    }

    /// Whether the kinds are layers.
    pub fn are_layers(&self) -> bool {
        matches!(self.places, Places::Layers(_))
    }

    /// The range of depths of each kind, in m, if the kinds are layers; otherwise each kind lies at all depths.
    pub fn ranges_m(&self) -> Vec<[f64; 2]> {
        match &self.places {
            Places::Layers(layering) => layering.ranges_m().collect(),
            Places::Everywhere | Places::Mask(..) => vec![[f64::NEG_INFINITY, f64::INFINITY]; self.samples.len()],
        }
    }

    /// The snow at a hit.
    #[inline]
    pub fn at_surface(&self, objects: &Objects, surface: &SurfaceInteraction) -> KindMix {
        match &self.places {
            Places::Everywhere => KindMix::one(0),
            Places::Layers(layering) => {
                KindMix::one(layering.at_surface(objects, surface.object, &surface.surface_point()))
            }
            Places::Mask(mask, values) => mix_at(values, mask.at(objects, surface)),
        }
    }

    /// The snow at a point of the surface of the body of an object.
    pub fn at_surface_point(&self, objects: &Objects, object: usize, surface: &SurfacePoint) -> KindMix {
        match &self.places {
            Places::Layers(layering) => KindMix::one(layering.at_surface(objects, object, surface)),
            Places::Everywhere | Places::Mask(..) => self.at_point(objects, object, surface.point),
        }
    }

    /// The snow at a point in the body of an object.
    pub fn at_point(&self, objects: &Objects, object: usize, point: Vec3A) -> KindMix {
        match &self.places {
            Places::Everywhere => KindMix::one(0),
            Places::Layers(layering) => KindMix::one(layering.at_point(objects, object, point)),
            Places::Mask(mask, values) => {
                let nearest = objects.nearest(object, point);
                nearest.map_or(KindMix::one(0), |surface| mix_at(values, mask.at(objects, &surface)))
            }
        }
    }

    /// The share of each kind in the snow of a box in the body of an object, given by centre and size in m. The shares
    /// add up to 1.
    pub fn shares(&self, objects: &Objects, object: usize, cell: [DVec3; 2]) -> Vec<(usize, f32)> {
        match &self.places {
            Places::Everywhere => vec![(0, 1.0)],
            Places::Layers(layering) => layering.shares(objects, object, cell).into_iter().enumerate().collect(),
            Places::Mask(..) => {
                let KindMix { first, second, share } = self.at_point(objects, object, cell[0].as_vec3a());
                vec![(first, 1.0 - share), (second, share)]
            }
        }
    }
}

/// The mix of the two kinds around a value of a mask.
fn mix_at(values: &[f32], value: f32) -> KindMix {
    let second = values.partition_point(|other| *other < value).clamp(1, values.len() - 1);
    let first = second - 1;
    let share = (value - values[first]) / (values[second] - values[first]);
    KindMix { first, second, share: share.clamp(0.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use snowblue_transport::optics::{IceTable, Impurities, Substance};
    use snowblue_transport::sample::SnowKeys;

    use super::*;

    #[test]
    fn kinds_of_a_mask_lie_close_where_the_snow_changes_much() {
        let sizes = |size_um: f64| SnowKeys { grain_size_um: Some(vec![size_um]), ..SnowKeys::default() };
        let snow = |keys: SnowKeys| keys.sample().unwrap();
        let mask = || Mask::Attribute { name: "age".to_owned(), range: [0.0, 1.0] };
        let varied = Snow::Masked { mask: mask(), between: [snow(sizes(100.0)), snow(sizes(1600.0))] };
        let SnowKinds { samples, places: Places::Mask(_, values) } = varied.kinds() else {
            panic!("a mask has kinds at its values")
        };
        assert_eq!((values[0].to_bits(), values[values.len() - 1].to_bits()), (0.0_f32.to_bits(), 1.0_f32.to_bits()));
        assert!(values.windows(2).all(|pair| pair[0] < pair[1]) && (6..=65).contains(&values.len()), "{values:?}");
        // Scattering goes as 1/size: fine snow needs more kinds than coarse snow.
        assert!(values[values.len() / 2] < 0.3, "{values:?}");
        let middle = samples.iter().zip(&values).find(|(_, at)| (**at - 0.25).abs() < 1e-6);
        assert!(middle.is_none_or(|(sample, _)| (sample.grain_size.middle_um() - 475.0).abs() < 1e-3));
        // Nearly equal snow needs no kinds in between.
        let even = Snow::Masked { mask: mask(), between: [snow(sizes(400.0)), snow(sizes(420.0))] };
        assert_eq!(even.kinds().samples.len(), 2);
    }

    #[test]
    fn between_two_samples_every_property_is_in_proportion() {
        let clean = SnowSample::default();
        let dirty = SnowSample {
            density_kg_m3: 500.0,
            water_saturation: 0.2,
            impurities: Impurities::none().with(Substance::BLACK_CARBON, 100.0),
            ice: IceTable::default(),
            ..clean
        };
        let middle = SnowSample::between(&[clean, dirty], 0.25);
        assert!((middle.density_kg_m3 - 350.0).abs() < 1e-9 && (middle.water_saturation - 0.05).abs() < 1e-12);
        assert_eq!(middle.impurities, Impurities::none().with(Substance::BLACK_CARBON, 25.0));
        assert_eq!(
            (SnowSample::between(&[clean, dirty], 0.0), SnowSample::between(&[clean, dirty], 1.0)),
            (clean, dirty)
        );
    }

    #[test]
    fn a_value_of_a_mask_lies_between_two_kinds() {
        let values = [0.0, 0.25, 1.0];
        assert_eq!(mix_at(&values, 0.0), KindMix { first: 0, second: 1, share: 0.0 });
        assert_eq!(mix_at(&values, 0.625), KindMix { first: 1, second: 2, share: 0.5 });
        assert_eq!(mix_at(&values, 1.0), KindMix { first: 1, second: 2, share: 1.0 });
    }
}
