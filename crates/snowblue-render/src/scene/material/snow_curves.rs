//! The curves of a material's snow: uniform, or varying between two samples by a mask.
//!
//! Mask 0 is the first sample, mask 1 the second, and properties are interpolated linearly between them. Curves are
//! precomputed at equidistant values of the mask and mixed logarithmically between neighbours. The number of steps
//! doubles until halving them changes the transmittance of 1, 10 and 100 cm (above a millionth) and the reflectance by
//! less than 1 %; they are then halved once more.

use snowblue_database::PcaSnow;
use snowblue_database::lookup::SnowMix;

use crate::geometry::shape::Shape;
use crate::scene::material::texture::Texture;
use crate::scene::objects::{Objects, SurfaceInteraction};
use crate::spectrum::Spectrum;

/// Largest relative difference between a mix and the sample itself.
const TOLERANCE: f32 = 0.01;
/// Smallest transmittance that is compared.
const LEAST_TRANSMITTANCE: f32 = 1e-6;
/// Thicknesses in cm and angles in degrees at which a mix is compared.
const COMPARED: [[f32; 2]; 4] = [[1.0, 0.0], [10.0, 60.0], [10.0, 0.0], [100.0, 0.0]];
/// Most steps. Grain sizes of 100–500 µm take 64; together with densities of 10–900 kg/m³ they take all.
const MOST_STEPS: usize = 1024;

/// A number at each point of a surface.
#[derive(Debug, Clone)]
pub enum Mask {
    /// The first channel of a texture, without decoding.
    RasterImage(Texture),
    /// A vertex attribute of a mesh.
    Attribute {
        /// Name in the mesh file.
        name: String,
        /// The values that map to 0 and to 1.
        range: [f32; 2],
    },
}

/// The curves of a material's snow.
#[derive(Debug)]
pub struct SnowCurves {
    /// One sample, or those at equidistant values of the mask from 0 to 1.
    steps: Vec<PcaSnow>,
    mask: Option<Mask>,
}

impl Mask {
    /// Checks that a shape has what the mask needs; the error says what is missing.
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
    /// Uniform snow.
    pub fn even(snow: PcaSnow) -> Self {
        Self { steps: vec![snow], mask: None }
    }

    /// Snow that varies from `snow_at(0)` to `snow_at(1)`.
    ///
    /// # Errors
    ///
    /// When `snow_at` fails.
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

    /// Checks that a shape has what a mask needs; the error says what is missing.
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

/// The mix of the two samples around a value of the mask, which rounding may have moved beyond 0 to 1.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "kept within the steps")]
fn between(steps: &[PcaSnow], mask: f32) -> SnowMix<'_> {
    let last = steps.len() - 1;
    let place = mask.clamp(0.0, 1.0) * last as f32;
    let step = (place as usize).min(last - 1);
    SnowMix::new(&steps[step], &steps[step + 1], place - step as f32)
}

/// Whether a sample equals the even mix of two others within the tolerance.
fn is_mixture(first: &PcaSnow, second: &PcaSnow, middle: &PcaSnow) -> bool {
    let (mixture, middle) = (SnowMix::new(first, second, 0.5), SnowMix::single(middle));
    COMPARED.iter().all(|&[thickness_cm, angle_deg]| {
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
