//! Lambertian surfaces: radiance L = ρ E / π in all directions. Light passes straight on where they are not opaque.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_base::toml_table::Table;
use snowblue_base::{KeyPath, Number, ParseError, narrow};

use crate::error::SceneError;
use crate::material::texture::{Texture, TextureDescription, linear_rgb};
use crate::objects::{Objects, SurfaceInteraction};
use crate::sources::Sources;
use crate::spectrum::Spectrum;
use crate::spectrum::file::SpectrumFile;
use crate::spectrum::upsampling::Upsampling;
use crate::values::{ColorDescription, Fraction, only_one};

/// A Lambertian surface, by one of four notations of its reflectance.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DiffuseDescription {
    /// The fraction of the light that is reflected at all wavelengths, 0–1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reflectance: Option<Number<Fraction>>,
    /// The colour under daylight: `[r, g, b]` in linear sRGB, or "#rrggbb" in encoded sRGB.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reflectance_rgb: Option<ColorDescription>,
    /// A CSV file with the columns `wavelength_nm,value`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reflectance_spectrum: Option<String>,
    /// The share of light that the surface does not let pass straight on, 0–1; 1 if absent. It multiplies the alpha of
    /// the image.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub opacity: Option<Number<Fraction>>,
    /// An image in encoded sRGB.
    #[serde(flatten, skip_deserializing)]
    #[schemars(!skip_deserializing)]
    pub texture: TextureDescription,
}

impl DiffuseDescription {
    /// A grey surface.
    pub fn grey(reflectance: Number<Fraction>) -> Self {
        Self { reflectance: Some(reflectance), ..Self::default() }
    }

    pub(super) fn read(mut table: Table) -> Result<Self, ParseError> {
        let texture = table.split(&TextureDescription::KEYS).read()?;
        Ok(Self { texture, ..table.read()? })
    }

    pub(super) fn build(&self, path: &KeyPath, sources: &Sources) -> Result<Diffuse, SceneError> {
        let is_given = [
            ("reflectance", self.reflectance.map(drop)),
            ("reflectance_rgb", self.reflectance_rgb.map(drop)),
            ("reflectance_spectrum", self.reflectance_spectrum.as_ref().map(drop)),
            ("texture", self.texture.texture.as_ref().map(drop)),
        ];
        only_one(path, is_given)?;
        if let Some(texture) = self.texture.build(path, sources, linear_rgb)? {
            return Ok(Diffuse::textured(texture, sources.upsampling));
        }
        if let Some(color) = &self.reflectance_rgb {
            return Ok(Diffuse::colored(color.linear(), sources.upsampling));
        }
        if let Some(file) = &self.reflectance_spectrum {
            let file = sources.open(&path.key("reflectance_spectrum"), file)?;
            return Ok(Diffuse::Uniform(Spectrum(SpectrumFile::parse(&file, 1.0)?.resample()?.map(narrow))));
        }
        let reflectance = narrow(self.reflectance.map_or(0.0, Number::get));
        Ok(Diffuse::Uniform(Spectrum::constant(reflectance)))
    }
}

/// A surface with the same diffuse reflection on both sides.
#[derive(Debug)]
pub enum Diffuse {
    /// Uniform reflectance.
    Uniform(Spectrum),
    /// Reflectance from a texture.
    Textured(Box<ReflectanceTexture>),
}

/// A texture whose colours are reflectances, and whose alpha is an opacity.
#[derive(Debug)]
pub struct ReflectanceTexture {
    /// Linear sRGB.
    texture: Texture,
    has_alpha: bool,
    upsampling: Upsampling,
}

impl Diffuse {
    /// The reflectance of a colour in linear sRGB.
    pub(crate) fn colored(color: [f32; 3], upsampling: Upsampling) -> Self {
        Self::Uniform(upsampling.spectrum(color))
    }

    /// Reflectance from a texture in linear sRGB.
    pub(crate) fn textured(texture: Texture, upsampling: Upsampling) -> Self {
        Self::Textured(Box::new(ReflectanceTexture { has_alpha: texture.has_alpha(), texture, upsampling }))
    }

    /// Reflectance at a hit.
    pub fn reflectance(&self, objects: &Objects, surface: &SurfaceInteraction) -> Spectrum {
        match self {
            Self::Uniform(reflectance) => *reflectance,
            Self::Textured(texture) => {
                let [r, g, b, _] = texture.texture.at(objects, surface);
                texture.upsampling.spectrum([r, g, b])
            }
        }
    }

    /// Whether the texture has an alpha below 1 anywhere.
    pub(super) fn has_alpha(&self) -> bool {
        matches!(self, Self::Textured(texture) if texture.has_alpha)
    }

    /// The alpha of the texture at a hit; 1 without a texture.
    pub(super) fn alpha(&self, objects: &Objects, surface: &SurfaceInteraction) -> f32 {
        match self {
            Self::Textured(texture) if texture.has_alpha => texture.texture.at(objects, surface)[3],
            Self::Uniform(_) | Self::Textured(_) => 1.0,
        }
    }
}
