//! What a glTF says of its materials' colour.

use std::io::Cursor;

use gltf::image::Source;

use super::{GltfFile, Neighbours};
use crate::error::RenderError;
use crate::files::SceneFiles;
use crate::images::png_image::PngImage;
use crate::scene::material::texture::Texture;

/// A material of a glTF.
#[derive(Debug)]
pub struct GltfMaterial {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// Share of red, green and blue light that it reflects, in linear sRGB; with a texture, what multiplies it.
    pub base_colour: [f32; 3],
    /// Number of the texture of its base colour, and of the texture coordinates that this uses.
    texture: Option<(usize, u32)>,
}

impl GltfFile {
    /// A material by its number.
    pub fn material(&self, index: usize) -> Option<GltfMaterial> {
        let material = self.gltf.materials().nth(index)?;
        let surface = material.pbr_metallic_roughness();
        let [r, g, b, _] = surface.base_color_factor();
        let texture = surface.base_color_texture().map(|info| (info.texture().index(), info.tex_coord()));
        Some(GltfMaterial { name: material.name().map(str::to_owned), base_colour: [r, g, b], texture })
    }

    /// The texture of a material's base colour times this colour, if it has one.
    ///
    /// # Errors
    ///
    /// When the colour does not lie in 0–1, or the texture is no PNG, cannot be read, or uses other texture coordinates
    /// than the mesh's first.
    pub fn paint(&self, material: &GltfMaterial, files: &dyn SceneFiles) -> Result<Option<Texture>, RenderError> {
        let name = material.name.as_deref().unwrap_or("without a name");
        let wrong = |reason: &str| self.wrong(format!("base colour of the material \"{name}\": {reason}"));
        if !material.base_colour.iter().all(|share| (0.0..=1.0).contains(share)) {
            let [r, g, b] = material.base_colour;
            return Err(wrong(&format!("it is {r}, {g}, {b}, but must lie in 0–1")));
        }
        let Some((number, coordinates)) = material.texture else {
            return Ok(None);
        };
        if coordinates != 0 {
            return Err(wrong(&format!("TEXCOORD_{coordinates} is used, but must be TEXCOORD_0")));
        }
        let image = self.gltf.textures().nth(number).ok_or_else(|| wrong("the texture is missing"))?.source();
        let bytes = match image.source() {
            Source::Uri { uri, .. } => {
                let neighbours = Neighbours { files, name: &self.name, path: &self.path };
                neighbours.uri(uri, &format!("image {}", image.index()))?
            }
            Source::View { view, .. } => {
                let buffer = self.buffers.get(view.buffer().index());
                let end = view.offset().checked_add(view.length());
                let part = buffer.zip(end).and_then(|(buffer, end)| buffer.get(view.offset()..end));
                part.ok_or_else(|| wrong("the image reaches beyond the end of its buffer"))?.to_vec()
            }
        };
        if bytes.starts_with(&[0xff, 0xd8]) {
            return Err(wrong("the texture is a JPEG, but must be a PNG; or give the material in the scene file"));
        }
        let picture = PngImage::read(Cursor::new(bytes)).map_err(|reason| wrong(&reason))?;
        let tinted = |pixel: [f32; 3]| std::array::from_fn(|channel| pixel[channel] * material.base_colour[channel]);
        let pixels = picture.linear().into_iter().map(tinted).collect();
        Ok(Some(Texture::new(picture.width, pixels, 1.0)))
    }
}
