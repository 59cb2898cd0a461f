//! Textures.

use crate::error::RenderError;
use crate::geometry::ray::narrow;
use crate::images::png_image::PngImage;
use crate::scene::build::sources::Sources;
use crate::scene::description::{KeyPath, TextureDescription};
use crate::scene::material::texture::Texture;

/// Reads the image of a texture; `pixels` decodes it.
pub(super) fn build_texture(
    path: &KeyPath,
    texture: &TextureDescription,
    sources: &Sources,
    pixels: impl Fn(&PngImage) -> Vec<[f32; 3]>,
) -> Result<Texture, RenderError> {
    let image = PngImage::decode(&sources.open(&path.key("texture"), &texture.texture)?)?;
    Ok(Texture::new(image.width, pixels(&image), narrow(texture.texture_scale_m)))
}
