//! Base colours and transparency of glTF materials.

use gltf::material::AlphaMode;
use gltf::texture::WrappingMode;
use snowblue_base::files::{FileError, FileSource};
use snowblue_base::{Quantity, RangeError};
use snowblue_geometry::images::PngImage;
use snowblue_geometry::mesh_files::gltf::GltfFile;

use crate::material::glass::PaneIndex;
use crate::material::texture::{Texture, linear_rgb, with_alpha};
use crate::values::Fraction;

/// A material of a glTF.
#[derive(Debug)]
pub(super) struct GltfMaterial {
    /// Its name, if it has one.
    pub(super) name: Option<String>,
    /// Base colour factor, in linear sRGB: the reflectance, or the factor of the texture.
    pub(super) base_colour: [f32; 3],
    /// Index of the texture of the base colour in the file.
    texture: Option<usize>,
    /// Alpha factor: the opacity, or the factor of the alpha of the texture.
    alpha: f32,
    alpha_mode: AlphaMode,
    /// The least opacity of a surface that is there, if the alpha masks it.
    alpha_cutoff: f32,
    /// The share of light that passes the surface where it is opaque.
    pub(super) transmission: f32,
    /// Whether the share varies by a texture, which is not read.
    pub(super) has_transmission_texture: bool,
    /// Refractive index.
    pub(super) ior: f32,
    /// Properties that are not read.
    pub(super) unread: Vec<&'static str>,
}

/// A material by its index.
pub(super) fn gltf_material(file: &GltfFile, index: usize) -> Option<GltfMaterial> {
    let material = file.document().materials().nth(index)?;
    let surface = material.pbr_metallic_roughness();
    let [r, g, b, alpha] = surface.base_color_factor();
    let transmission = material.transmission();
    let texture = surface.base_color_texture().map(|info| info.texture());
    let repeats = |texture: &gltf::Texture| {
        let sampler = texture.sampler();
        [sampler.wrap_s(), sampler.wrap_t()] == [WrappingMode::Repeat; 2]
    };
    let unread = [
        ("metalness", surface.metallic_factor() > 0.0),
        ("gloss", surface.roughness_factor() < 1.0),
        ("a normal map", material.normal_texture().is_some()),
        ("emission", material.emissive_factor() != [0.0; 3]),
        ("a texture that does not repeat", !texture.as_ref().is_none_or(repeats)),
    ];
    Some(GltfMaterial {
        name: material.name().map(str::to_owned),
        base_colour: [r, g, b],
        texture: texture.map(|texture| texture.index()),
        unread: unread.into_iter().filter(|(_, is_so)| *is_so).map(|(what, _)| what).collect(),
        alpha,
        alpha_mode: material.alpha_mode(),
        alpha_cutoff: material.alpha_cutoff().unwrap_or(0.5),
        transmission: transmission.as_ref().map_or(0.0, |transmission| transmission.transmission_factor()),
        has_transmission_texture: transmission.is_some_and(|found| found.transmission_texture().is_some()),
        ior: material.ior().unwrap_or(1.5),
    })
}

impl GltfMaterial {
    /// The opacity of the surface where the alpha of its texture is `alpha`.
    pub(super) fn opacity(&self, alpha: f32) -> f32 {
        let alpha = alpha * self.alpha;
        match self.alpha_mode {
            AlphaMode::Opaque => 1.0,
            AlphaMode::Mask if alpha < self.alpha_cutoff => 0.0,
            AlphaMode::Mask => 1.0,
            AlphaMode::Blend => alpha,
        }
    }
}

/// The texture of a material's base colour, multiplied by the base colour factor, if it has one.
///
/// # Errors
///
/// When a factor or the refractive index is out of range, or the texture is neither a PNG nor a JPEG or cannot be read.
pub(super) fn base_colour_texture(
    file: &GltfFile,
    material: &GltfMaterial,
    files: &dyn FileSource,
) -> Result<Option<Texture>, FileError> {
    let name = material.name.as_deref().unwrap_or("unnamed");
    let wrong = |reason: &str| file.wrong(format!("base colour of the material \"{name}\": {reason}"));
    if !material.base_colour.iter().all(|factor| (0.0..=1.0).contains(factor)) {
        let [r, g, b] = material.base_colour;
        return Err(wrong(&format!("factor is {r}, {g}, {b}, but must lie in 0–1")));
    }
    for (what, value, range) in [
        ("alpha", material.alpha, Fraction::RANGE),
        ("transmission", material.transmission, Fraction::RANGE),
        ("refractive index", material.ior, PaneIndex::RANGE),
    ] {
        let outside =
            |error: RangeError| file.wrong(format!("{what} of the material \"{name}\" {}", error.after_key()));
        range.check(value.into()).map_err(outside)?;
    }
    let Some(index) = material.texture else {
        return Ok(None);
    };
    let texture = file.document().textures().nth(index).ok_or_else(|| wrong("the texture is missing"))?;
    let source = texture.source().ok_or_else(|| wrong("the texture has no image that is a PNG or JPEG"))?;
    let bytes = file.image(&source, files)?;
    let is_jpeg = bytes.starts_with(&[0xff, 0xd8]);
    let image = if is_jpeg { PngImage::read_jpeg(&bytes) } else { PngImage::read(&bytes) };
    let image = image.map_err(|reason| wrong(&reason))?;
    let tinted = |pixel: [f32; 3]| std::array::from_fn(|channel| pixel[channel] * material.base_colour[channel]);
    let colors = linear_rgb(&image).into_iter().map(tinted).collect();
    let pixels = with_alpha(&image, colors, |alpha| material.opacity(alpha));
    Ok(Some(Texture::new(image.width, pixels, 1.0)))
}
