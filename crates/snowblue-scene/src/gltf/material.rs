//! Base colours and transparency of glTF materials.

use gltf::material::AlphaMode;
use gltf::texture::WrappingMode;
use snowblue_base::files::{FileError, FileSource};
use snowblue_base::{Quantity, RangeError};
use snowblue_geometry::images::DecodedImage;
use snowblue_geometry::mesh_files::gltf::GltfFile;

use crate::material::glass::PaneIndex;
use crate::material::texture::{Texture, linear_rgb, with_alpha};
use crate::values::Fraction;

/// Refractive index of a material that states none (Khronos Group 2020, KHR_materials_ior).
pub(super) const DEFAULT_INDEX: f32 = 1.5;

/// The properties of a material that are not read.
pub(super) fn unread(material: &gltf::Material) -> impl Iterator<Item = &'static str> {
    let surface = material.pbr_metallic_roughness();
    let sampler = surface.base_color_texture().map(|info| info.texture().sampler());
    let edges = sampler.map(|sampler| [sampler.wrap_s(), sampler.wrap_t()]);
    let all = [
        ("metalness", surface.metallic_factor() > 0.0),
        ("gloss", surface.roughness_factor() < 1.0),
        ("a normal map", material.normal_texture().is_some()),
        ("emission", material.emissive_factor().iter().any(|factor| *factor > 0.0)),
        ("a texture that does not repeat", edges.is_some_and(|edges| edges != [WrappingMode::Repeat; 2])),
    ];
    all.into_iter().filter(|(_, is_so)| *is_so).map(|(what, _)| what)
}

/// The opacity of a surface where the alpha of its texture is `alpha`.
pub(super) fn opacity(material: &gltf::Material, alpha: f32) -> f32 {
    let [.., factor] = material.pbr_metallic_roughness().base_color_factor();
    let alpha = alpha * factor;
    match material.alpha_mode() {
        AlphaMode::Opaque => 1.0,
        AlphaMode::Mask if alpha < material.alpha_cutoff().unwrap_or(0.5) => 0.0,
        AlphaMode::Mask => 1.0,
        AlphaMode::Blend => alpha,
    }
}

/// The texture of a material's base colour, multiplied by the base colour factor, if it has one.
///
/// # Errors
///
/// When a factor or the refractive index is out of range, or the texture is neither a PNG nor a JPEG or cannot be read.
pub(super) fn base_colour_texture(
    file: &GltfFile,
    material: &gltf::Material,
    files: &dyn FileSource,
) -> Result<Option<Texture>, FileError> {
    let name = material.name().unwrap_or("unnamed");
    let surface = material.pbr_metallic_roughness();
    let [base_colour @ .., alpha] = surface.base_color_factor();
    let wrong = |reason: &str| file.wrong(format!("base colour of the material \"{name}\": {reason}"));
    if !base_colour.iter().all(|factor| (0.0..=1.0).contains(factor)) {
        let [r, g, b] = base_colour;
        return Err(wrong(&format!("factor is {r}, {g}, {b}, but must lie in 0–1")));
    }
    for (what, value, range) in [
        ("alpha", alpha, Fraction::RANGE),
        ("transmission", material.transmission().map_or(0.0, |found| found.transmission_factor()), Fraction::RANGE),
        ("refractive index", material.ior().unwrap_or(DEFAULT_INDEX), PaneIndex::RANGE),
    ] {
        let outside =
            |error: RangeError| file.wrong(format!("{what} of the material \"{name}\" {}", error.after_key()));
        range.check(value.into()).map_err(outside)?;
    }
    let Some(info) = surface.base_color_texture() else { return Ok(None) };
    let source = info.texture().source();
    let source = source.ok_or_else(|| wrong("the texture has no image that is a PNG or JPEG"))?;
    let bytes = file.image(&source, files)?;
    let image = DecodedImage::read(&bytes).map_err(|reason| wrong(&reason))?;
    let tinted = |pixel: [f32; 3]| std::array::from_fn(|channel| pixel[channel] * base_colour[channel]);
    let colors = linear_rgb(&image).into_iter().map(tinted).collect();
    let pixels = with_alpha(&image, colors, |alpha| opacity(material, alpha));
    Ok(Some(Texture::new(image.width, pixels, 1.0)))
}
