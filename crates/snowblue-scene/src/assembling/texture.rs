//! Textures.

use snowblue_color::transfer::decode_srgb;
use snowblue_geometry::images::png_image::PngImage;
use snowblue_geometry::ray::narrow;

use crate::assembling::sources::Sources;
use crate::description::TextureDescription;
use crate::error::SceneError;
use crate::material::texture::Texture;
use snowblue_base::KeyPath;

/// Reads the image of a texture; `pixels` decodes it.
pub(super) fn build_texture(
    path: &KeyPath,
    texture: &TextureDescription,
    sources: &Sources,
    pixels: impl Fn(&PngImage) -> Vec<[f32; 3]>,
) -> Result<Texture, SceneError> {
    let image = PngImage::decode(&sources.open(&path.key("texture"), &texture.texture)?)?;
    Ok(Texture::new(image.width, pixels(&image), narrow(texture.texture_scale_m)))
}

/// The pixels of an image in linear sRGB.
pub(super) fn linear_rgb(image: &PngImage) -> Vec<[f32; 3]> {
    let linear = |code: f32| narrow(decode_srgb(f64::from(code)));
    image.encoded_rgb().into_iter().map(|pixel| pixel.map(linear)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn textures_are_decoded_as_srgb() {
        // The value 188 of 255 is a linear 0.5 (IEC 61966-2-1).
        let image = PngImage { width: 2, height: 1, channels: 1, values: vec![188.0 / 255.0, 1.0] };
        let [half, white] = linear_rgb(&image)[..] else { panic!("two pixels") };
        assert!((half[2] - 0.5).abs() < 0.003 && (white[0] - 1.0).abs() < 1e-6);
    }
}
