//! Base colours of glTF materials.

use snowblue_base::files::{FileError, FileSource};
use snowblue_geometry::images::PngImage;
use snowblue_geometry::mesh_files::gltf::GltfFile;

use crate::material::texture::Texture;
use crate::material::texture::linear_rgb;

/// A material of a glTF.
#[derive(Debug)]
pub(super) struct GltfMaterial {
    /// Its name, if it has one.
    pub(super) name: Option<String>,
    /// Base colour factor, in linear sRGB: the reflectance, or the factor of the texture.
    pub(super) base_colour: [f32; 3],
    texture: Option<BaseColourTexture>,
}

/// The texture of a base colour.
#[derive(Debug, Clone, Copy)]
struct BaseColourTexture {
    /// Index of the texture in the file.
    index: usize,
    /// Index of its set of texture coordinates.
    uv_set: u32,
}

/// A material by its index.
pub(super) fn gltf_material(file: &GltfFile, index: usize) -> Option<GltfMaterial> {
    let material = file.document().materials().nth(index)?;
    let surface = material.pbr_metallic_roughness();
    let [r, g, b, _] = surface.base_color_factor();
    let texture = surface
        .base_color_texture()
        .map(|info| BaseColourTexture { index: info.texture().index(), uv_set: info.tex_coord() });
    Some(GltfMaterial { name: material.name().map(str::to_owned), base_colour: [r, g, b], texture })
}

/// The texture of a material's base colour, multiplied by the base colour factor, if it has one.
///
/// # Errors
///
/// When the factor does not lie in 0–1, or the texture is not a PNG, cannot be read, or uses another set of texture
/// coordinates than `TEXCOORD_0`.
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
    let Some(BaseColourTexture { index, uv_set }) = material.texture else {
        return Ok(None);
    };
    if uv_set != 0 {
        return Err(wrong(&format!("the texture uses TEXCOORD_{uv_set}, but must use TEXCOORD_0")));
    }
    let texture = file.document().textures().nth(index).ok_or_else(|| wrong("the texture is missing"))?;
    let bytes = file.image(&texture.source(), files)?;
    if bytes.starts_with(&[0xff, 0xd8]) {
        return Err(wrong("the texture is a JPEG, but must be a PNG (or define the material in the scene file)"));
    }
    let image = PngImage::read(&bytes).map_err(|reason| wrong(&reason))?;
    let tinted = |pixel: [f32; 3]| std::array::from_fn(|channel| pixel[channel] * material.base_colour[channel]);
    let pixels = linear_rgb(&image).into_iter().map(tinted).collect();
    Ok(Some(Texture::new(image.width, pixels, 1.0)))
}
