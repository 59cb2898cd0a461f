//! The curves of the snow of one material: everywhere the same, or between two snows, as a mask says.
//!
//! A mask of 0 is the first snow, 1 the second; in between every property lies in proportion between theirs. Such snow
//! is taken out of the table beforehand, at so many even steps of the mask that halving them changes the transmittance
//! of 1, 10 and 100 cm by less than 1 % wherever more than a millionth comes through, and reflectance as little; at a
//! hit the logarithms of the two neighbours are mixed. The steps are then halved once more.

use snowblue_database::PcaSnow;
use snowblue_database::lookup::SnowMix;

use crate::geometry::shape::Shape;
use crate::scene::material::texture::Texture;
use crate::scene::objects::{Objects, SurfaceInteraction};
use crate::spectrum::Spectrum;

/// Mixtures differ from the snow in between by less than this, as a share.
const TOLERANCE: f32 = 0.01;
/// Transmittance below this is not compared.
const LEAST_TRANSMITTANCE: f32 = 1e-6;
/// Where snows are compared: thicknesses in cm and angles in degrees.
const COMPARED: [(f32, f32); 4] = [(1.0, 0.0), (10.0, 60.0), (10.0, 0.0), (100.0, 0.0)];
/// Steps end here. Grains of 100–500 µm take 64, together with densities of 10–900 kg/m³ as many as these.
const MOST_STEPS: usize = 1024;

/// A number for each place of a surface.
#[derive(Debug, Clone)]
pub enum Mask {
    /// The first channel of a picture, as its file has it.
    RasterImage(Texture),
    /// A value that meshes have at their vertices.
    Attribute {
        /// Its name in the mesh file.
        name: String,
        /// The value that counts as 0, and the one that counts as 1.
        range: [f32; 2],
    },
}

/// The curves of a material's snow.
#[derive(Debug)]
pub struct SnowCurves {
    /// One snow, or those at even steps of the mask from 0 to 1.
    steps: Vec<PcaSnow>,
    mask: Option<Mask>,
}

impl Mask {
    /// Whether a shape has what the mask needs, or what is missing.
    pub(crate) fn check(&self, shape: &Shape) -> Result<(), String> {
        let Self::Attribute { name, range: [low, high] } = self else {
            return Texture::check(shape);
        };
        let attributes = shape.mesh().map(|mesh| &mesh.triangles().attributes);
        let Some(values) = attributes.and_then(|attributes| attributes.get(name)) else {
            let known =
                attributes.map(|attributes| attributes.keys().map(String::as_str).collect::<Vec<_>>().join(", "));
            let known = known.filter(|known| !known.is_empty()).unwrap_or_else(|| "none".into());
            return Err(format!("the mask is the attribute \"{name}\", but those of the object are: {known}"));
        };
        let within = |value: &&f32| (low.min(*high)..=low.max(*high)).contains(*value);
        match values.iter().find(|value| !within(value)) {
            Some(value) => Err(format!("attribute \"{name}\" is {value} at a vertex, but must lie in {low} to {high}")),
            None => Ok(()),
        }
    }

    fn at(&self, objects: &Objects, surface: &SurfaceInteraction) -> f32 {
        match self {
            Self::RasterImage(texture) => texture.at(objects, surface)[0],
            Self::Attribute { name, range: [low, high] } => {
                (objects.attribute(name, surface).unwrap_or(*low) - low) / (high - low)
            }
        }
    }
}

impl SnowCurves {
    /// The same snow everywhere.
    pub fn even(snow: PcaSnow) -> Self {
        Self { steps: vec![snow], mask: None }
    }

    /// Snow that varies from `snow_at(0)` to `snow_at(1)`.
    ///
    /// # Errors
    ///
    /// When there is no such snow at a mixture.
    pub(crate) fn varying<E>(mask: Mask, snow_at: impl Fn(f64) -> Result<PcaSnow, E>) -> Result<Self, E> {
        let mut steps = vec![snow_at(0.0)?, snow_at(1.0)?];
        loop {
            let count = steps.len() - 1;
            let middles = (0..count).map(|step| snow_at((step as f64 + 0.5) / count as f64));
            let middles = middles.collect::<Result<Vec<_>, E>>()?;
            let fine = steps.windows(2).zip(&middles).all(|(ends, middle)| is_mixture(&ends[0], &ends[1], middle));
            let last = steps.pop();
            steps = steps.into_iter().zip(middles).flat_map(|(step, middle)| [step, middle]).chain(last).collect();
            if fine || 2 * count >= MOST_STEPS {
                return Ok(Self { steps, mask: Some(mask) });
            }
        }
    }

    /// The snow, if it is the same everywhere.
    pub(crate) fn single(&self) -> Option<&PcaSnow> {
        self.steps.first().filter(|_| self.mask.is_none())
    }

    /// Wavelengths of the curves, in nm.
    pub fn wavelengths_nm(&self) -> &[f64] {
        self.steps[0].wavelengths_nm()
    }

    /// Whether a shape has what a mask needs, or what is missing.
    pub(crate) fn check(&self, shape: &Shape) -> Result<(), String> {
        self.mask.as_ref().map_or(Ok(()), |mask| mask.check(shape))
    }

    /// The snow at a hit.
    #[inline]
    pub(crate) fn at(&self, objects: &Objects, surface: &SurfaceInteraction) -> SnowMix<'_> {
        match &self.mask {
            None => SnowMix::single(&self.steps[0]),
            Some(mask) => between(&self.steps, mask.at(objects, surface)),
        }
    }
}

/// The mixture of the two steps around a mask's value, which rounding may have taken out of 0 to 1.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "kept within the steps")]
fn between(steps: &[PcaSnow], mask: f32) -> SnowMix<'_> {
    let last = steps.len() - 1;
    let place = mask.clamp(0.0, 1.0) * last as f32;
    let step = (place as usize).min(last - 1);
    SnowMix::new(&steps[step], &steps[step + 1], place - step as f32)
}

/// Whether snow is, but for the tolerance, the mixture of two others in halves.
fn is_mixture(first: &PcaSnow, second: &PcaSnow, middle: &PcaSnow) -> bool {
    let (mixture, middle) = (SnowMix::new(first, second, 0.5), SnowMix::single(middle));
    COMPARED.iter().all(|&(thickness_cm, angle_deg)| {
        let [mut mixed, mut own] = [Spectrum::ZERO; 2];
        let near = |mixed: &Spectrum, own: &Spectrum| {
            let mut pairs = mixed.0.iter().zip(&own.0).filter(|(_, own)| **own > LEAST_TRANSMITTANCE);
            pairs.all(|(mixed, own)| (mixed - own).abs() < TOLERANCE * own)
        };
        mixture.transmittance(thickness_cm, angle_deg, &mut mixed.0);
        middle.transmittance(thickness_cm, angle_deg, &mut own.0);
        let transmits_alike = near(&mixed, &own);
        mixture.reflectance(thickness_cm, angle_deg, &mut mixed.0);
        middle.reflectance(thickness_cm, angle_deg, &mut own.0);
        transmits_alike && near(&mixed, &own)
    })
}
