//! Textures: images on surfaces.
//!
//! | shape | texture coordinates |
//! |---|---|
//! | mesh, height field | given by the mesh: (0, 0) is the lower left corner of the image, (1, 1) the upper right |
//! | box, plane | in metres: the image is `width_m` wide, centred on each face, and repeats |
//! | sphere | once around: the centre of the image faces −y, its upper edge is the top of the sphere |
//!
//! Images on the sides of a box are upright as seen from outside. The image on the top is upright as seen from the
//! front (−y). All coordinates are in object space. Interpolation is bilinear and periodic.

use glam::Vec2;
use snowblue_geometry::shape::Shape;
use snowblue_geometry::texture_coordinates::TextureCoordinates;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_base::{KeyPath, Number, ParameterRange, narrow, quantities};
use snowblue_color::transfer::decode_srgb;
use snowblue_geometry::images::DecodedImage;

use crate::error::SceneError;
use crate::objects::{Objects, SurfaceInteraction};
use crate::sources::Sources;

quantities! {
    /// Width of an image on boxes and planes.
    pub TextureScale = ParameterRange::new("width of a texture", 1e-4, 1e5, "m");
}

/// The keys of an image on a surface, among the keys of what has the image.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TextureDescription {
    /// A PNG file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub texture: Option<String>,
    /// Width of the image on boxes and planes, in m; 1 if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub texture_scale_m: Option<Number<TextureScale>>,
}

impl TextureDescription {
    /// The keys.
    pub(crate) const KEYS: [&str; 2] = ["texture", "texture_scale_m"];

    /// Reads the image and decodes it with `pixels`; none if no image is given.
    pub(crate) fn build(
        &self,
        path: &KeyPath,
        sources: &Sources,
        pixels: impl Fn(&DecodedImage) -> Vec<[f32; 3]>,
    ) -> Result<Option<Texture>, SceneError> {
        let Some(file) = &self.texture else {
            return match self.texture_scale_m {
                Some(_) => Err(path.key("texture_scale_m").error("needs a `texture`").into()),
                None => Ok(None),
            };
        };
        let image = DecodedImage::decode(&sources.open(&path.key("texture"), file)?)?;
        let width_m = narrow(self.texture_scale_m.map_or(1.0, Number::get));
        Ok(Some(Texture::new(image.width, with_alpha(&image, pixels(&image), |alpha| alpha), width_m)))
    }
}

/// The pixels of an image in linear sRGB.
pub(crate) fn linear_rgb(image: &DecodedImage) -> Vec<[f32; 3]> {
    let linear = |code: f32| narrow(decode_srgb(f64::from(code)));
    image.encoded_rgb().into_iter().map(|pixel| pixel.map(linear)).collect()
}

/// Colours of the pixels of an image, with a function of their alphas.
pub(crate) fn with_alpha(image: &DecodedImage, colors: Vec<[f32; 3]>, of: impl Fn(f32) -> f32) -> Vec<[f32; 4]> {
    let with_alpha = |(pixel, [r, g, b]): (usize, [f32; 3])| [r, g, b, of(image.alpha_of(pixel))];
    colors.into_iter().enumerate().map(with_alpha).collect()
}

/// An image that repeats.
#[derive(Debug, Clone)]
pub struct Texture {
    width: usize,
    height: usize,
    /// Colours with alpha, row by row from the top.
    pixels: Vec<[f32; 4]>,
    /// Width of the image on shapes with coordinates in metres.
    width_m: f32,
}

impl Texture {
    /// An image with `width` pixels a row, row by row from the top, `width_m` wide on shapes with coordinates in
    /// metres.
    pub(crate) fn new(width: usize, pixels: Vec<[f32; 4]>, width_m: f32) -> Self {
        Self { width, height: pixels.len() / width, pixels, width_m }
    }

    /// Whether the alpha of any pixel is below 1.
    pub(crate) fn has_alpha(&self) -> bool {
        self.pixels.iter().any(|[.., alpha]| *alpha < 1.0)
    }

    /// Memory of the image, in bytes.
    pub(crate) fn bytes(&self) -> f64 {
        size_of_val(self.pixels.as_slice()) as f64
    }

    /// Checks that a shape has texture coordinates; the error says what is missing.
    pub(crate) fn check(shape: &Shape) -> Result<(), String> {
        let Some(mesh) = shape.mesh() else {
            return Ok(());
        };
        match mesh.triangles().uv.iter().find(|uv| !uv.is_finite()) {
            Some(uv) => Err(format!("texture coordinates of a vertex are {}, {}, but must be finite", uv.x, uv.y)),
            None if mesh.triangles().uv.is_empty() => {
                Err("the material has a texture, but the mesh has no texture coordinates".into())
            }
            None => Ok(()),
        }
    }

    /// The three channels and the alpha at a hit.
    pub(crate) fn at(&self, objects: &Objects, surface: &SurfaceInteraction) -> [f32; 4] {
        self.value(match objects.texture_coordinates_at(surface) {
            TextureCoordinates::Image(place) => place,
            TextureCoordinates::Metres(place) => {
                let height_m = self.width_m * self.height as f32 / self.width as f32;
                0.5 + place / Vec2::new(self.width_m, height_m)
            }
        })
    }

    fn value(&self, place: Vec2) -> [f32; 4] {
        let (columns, right) = neighbours(place.x, self.width);
        let (rows, down) = neighbours(1.0 - place.y, self.height);
        let mut value = [0.0; 4];
        for (row, share_down) in [(rows[0], 1.0 - down), (rows[1], down)] {
            for (column, share_right) in [(columns[0], 1.0 - right), (columns[1], right)] {
                let pixel = self.pixels[row * self.width + column];
                value.iter_mut().zip(pixel).for_each(|(sum, channel)| *sum += share_down * share_right * channel);
            }
        }
        value
    }
}

/// The pixels on both sides of a coordinate in a periodic image, and the weight of the second pixel.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "kept within the pixels")]
fn neighbours(place: f32, count: usize) -> ([usize; 2], f32) {
    let from_first = (place - place.floor()) * count as f32 - 0.5 + count as f32;
    let before = from_first.floor();
    let pixel = before as usize % count;
    ([pixel, (pixel + 1) % count], from_first - before)
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;

    use super::*;

    #[test]
    fn textures_are_decoded_as_srgb() {
        // The value 188 of 255 is a linear 0.5 (IEC 61966-2-1).
        let image =
            DecodedImage { width: 2, height: 1, channels: 1, values: vec![188.0 / 255.0, 1.0], alpha: Vec::new() };
        let [half, white] = linear_rgb(&image)[..] else { panic!("two pixels") };
        assert!((half[2] - 0.5).abs() < 0.003 && (white[0] - 1.0).abs() < 1e-6);
    }

    fn close(one: Vec2, other: (f32, f32)) -> bool {
        (one - Vec2::from(other)).length() < 1e-6
    }

    #[test]
    fn pixels_are_met_in_their_middles_and_joined_by_straight_lines() {
        let grey = |value: f32| [value; 4];
        // Two rows of three: 0 1 2 above 3 4 5.
        let texture = Texture::new(3, (0..6).map(|value| grey(value as f32)).collect(), 1.0);
        let at = |x: f32, y: f32| texture.value(Vec2::new(x, y))[0];
        for (x, y, expected) in [
            (1.0 / 6.0, 0.75, 0.0),
            (5.0 / 6.0, 0.75, 2.0),
            (0.5, 0.25, 4.0),
            (0.5, 0.5, 2.5),
            (1.0 / 3.0, 0.25, 3.5),
            // Half-way over the right edge to the first pixel again, and the same point some periods away.
            (1.0, 0.75, 1.0),
            (-7.0, 3.75, 1.0),
        ] {
            assert!((at(x, y) - expected).abs() < 1e-5, "{x}, {y}: {}", at(x, y));
        }
    }

    #[test]
    fn sides_of_a_box_are_seen_upright_and_a_sphere_from_its_front() {
        let on_box = |own: [f32; 3], normal: Vec3A| match TextureCoordinates::on_box(own.into(), normal) {
            TextureCoordinates::Metres(place) => place,
            TextureCoordinates::Image(_) => panic!("a box is measured in metres"),
        };
        assert!(close(on_box([0.2, -1.0, 0.3], Vec3A::NEG_Y), (0.2, 0.3)));
        assert!(close(on_box([0.2, 1.0, 0.3], Vec3A::Y), (-0.2, 0.3)), "from behind, right is left");
        assert!(close(on_box([1.0, 0.2, 0.3], Vec3A::X), (0.2, 0.3)));
        assert!(close(on_box([0.2, 0.3, 1.0], Vec3A::Z), (0.2, 0.3)));
        let on_sphere = |own: Vec3A| match TextureCoordinates::on_sphere(own) {
            TextureCoordinates::Image(place) => place,
            TextureCoordinates::Metres(_) => panic!("a picture goes once around a sphere"),
        };
        assert!(close(on_sphere(Vec3A::NEG_Y), (0.5, 0.5)) && close(on_sphere(Vec3A::X), (0.75, 0.5)));
        assert!((on_sphere(Vec3A::Z).y - 1.0).abs() < 1e-6);
    }
}
