//! The `[material.NAME]` tables.

use std::path::Path;

use snowblue_color::{LinearRgb, Srgb8};
use snowblue_database::CompressedTable;
use snowblue_transport::monte_carlo::Volume;
use toml::de::DeTable;

use crate::error::RenderError;
use crate::files::{FilesIn, SceneFile};
use crate::geometry::ray::narrow;
use crate::images::png_image::PngImage;
use crate::scene::file::Overrides;
use crate::scene::file::section::{SceneText, Section};
use crate::scene::file::snow::{read_snow, read_volume};
use crate::scene::material::Material;
use crate::scene::material::diffuse::Diffuse;
use crate::scene::material::texture::Texture;
use crate::spectrum::file::SpectrumFile;
use crate::spectrum::upsampling::Upsampling;
use crate::spectrum::{SAMPLES, Spectrum, wavelengths_nm};

/// Width of a picture on shapes that are measured in metres.
pub(super) const TEXTURE_SCALE_M: &str = "texture_scale_m";
/// What a diffuse material can reflect, each by itself.
const REFLECTANCES: [&str; 4] = ["reflectance", "reflectance_rgb", "reflectance_spectrum", "texture"];

/// A material with its name in the file.
pub(super) type Named = (String, Material);

/// What materials are made from.
pub(super) struct Workshop<'scene> {
    /// The scene file: other files are looked for beside it.
    pub(super) scene: &'scene Path,
    pub(super) table: &'scene CompressedTable,
    pub(super) overrides: &'scene Overrides,
    /// Those of the picture.
    pub(super) wavelengths_nm: [f64; SAMPLES],
    upsampling: Upsampling,
}

impl<'scene> Workshop<'scene> {
    /// For the wavelengths of an eye, or those of the table in false colour.
    pub(super) fn new(scene: &'scene Path, table: &'scene CompressedTable, overrides: &'scene Overrides) -> Self {
        let of_table = table.axes.wavelengths_nm.first_chunk().filter(|_| overrides.false_color.is_some());
        Self {
            scene,
            table,
            overrides,
            wavelengths_nm: of_table.copied().unwrap_or_else(wavelengths_nm),
            upsampling: if overrides.false_color.is_some() { Upsampling::grey() } else { Upsampling::reflectance() },
        }
    }

    /// Paint of one colour in linear sRGB.
    pub(super) fn even(&self, colour: [f32; 3]) -> Diffuse {
        Diffuse::Even(self.upsampling.spectrum(colour))
    }

    /// Paint of the colours of a texture in linear sRGB.
    pub(super) fn painted(&self, texture: Texture) -> Diffuse {
        Diffuse::painted(texture, self.upsampling)
    }
}

/// Reads all materials, in alphabetical order.
pub(super) fn read_materials<'text>(
    source: SceneText<'text>,
    root: &'text DeTable<'text>,
    workshop: &Workshop,
) -> Result<Vec<Named>, RenderError> {
    let mut materials = Vec::new();
    for (name, section, is_snow) in sections(source, root)? {
        let material = if is_snow {
            Material::PcaSnow(Box::new(read_snow(&section, workshop)?))
        } else {
            Material::Diffuse(read_diffuse(&section, workshop)?)
        };
        materials.push((name, material));
    }
    Ok(materials)
}

/// The snow of each material, in the same order, for light to walk through.
pub(super) fn read_volumes<'text>(
    source: SceneText<'text>,
    root: &'text DeTable<'text>,
    workshop: &Workshop,
) -> Result<Vec<Option<Volume>>, RenderError> {
    let mut volumes: Vec<Option<Volume>> = Vec::new();
    for (_, section, is_snow) in sections(source, root)? {
        let volume = is_snow.then(|| read_volume(&section, workshop)).transpose()?;
        let nodes = |volume: &Volume| volume.nodes().len();
        if let (Some(one), Some(other)) = (&volume, volumes.iter().flatten().next())
            && nodes(one) != nodes(other)
        {
            let reason =
                "the reference takes snow with particles, or more than half full of water, and other snow apart";
            return Err(section.error(reason));
        }
        volumes.push(volume);
    }
    Ok(volumes)
}

/// The tables of the materials with their names, and whether they are snow.
fn sections<'text>(
    source: SceneText<'text>,
    root: &'text DeTable<'text>,
) -> Result<Vec<(String, Section<'text>, bool)>, RenderError> {
    let Some(value) = root.get("material") else {
        return Ok(Vec::new());
    };
    let Some(entries) = value.get_ref().as_table() else {
        return Err(source.error(&value.span(), "`material` must be written as [material.NAME]"));
    };
    let mut sections = Vec::with_capacity(entries.len());
    for (name, entry) in entries {
        let section = Section::new(source, format!("material.{}", name.get_ref()), entry)?;
        section.required_text("type")?;
        let is_snow = section.choice("type", false, &[("diffuse", false), ("pca_snow", true)])?;
        sections.push((name.get_ref().to_string(), section, is_snow));
    }
    Ok(sections)
}

fn read_diffuse(section: &Section, workshop: &Workshop) -> Result<Diffuse, RenderError> {
    section.only(&[&REFLECTANCES[..], &["type", TEXTURE_SCALE_M]].concat())?;
    let given: Vec<&str> = REFLECTANCES.into_iter().filter(|key| section.has(key)).collect();
    if let &[first, second, ..] = &given[..] {
        return Err(
            section.error_at(second, format!("a diffuse material has either `{first}` or `{second}`, not both"))
        );
    }
    if section.has(TEXTURE_SCALE_M) && given != ["texture"] {
        return Err(section.error_at(TEXTURE_SCALE_M, format!("`{TEXTURE_SCALE_M}` needs a `texture`")));
    }
    match given.first() {
        Some(&"reflectance_rgb") => Ok(workshop.even(read_colour(section)?)),
        Some(&"reflectance_spectrum") => {
            let file = SpectrumFile::parse(&existing(section, "reflectance_spectrum", workshop.scene)?, 1.0)?;
            Ok(Diffuse::Even(Spectrum(file.resample(&workshop.wavelengths_nm)?.map(narrow))))
        }
        Some(&"texture") => Ok(workshop.painted(read_texture(section, workshop.scene, PngImage::linear_rgb)?)),
        _ => Ok(Diffuse::Even(Spectrum::constant(narrow(section.number("reflectance", None, 0.0..=1.0, "")?)))),
    }
}

/// Linear sRGB from three numbers, which are it, or from `#rrggbb`, which is encoded.
fn read_colour(section: &Section) -> Result<[f32; 3], RenderError> {
    let key = "reflectance_rgb";
    let Some(text) = section.text(key).ok().flatten() else {
        return section.vector(key, None, 0.0..=1.0, "").map(Into::into);
    };
    let code: Result<Srgb8, _> = text.parse();
    let wrong = |error| section.error_at(key, format!("{}: {error}", section.full_name(key)));
    let LinearRgb { r, g, b } = code.map_err(wrong)?.decode();
    Ok([r, g, b].map(narrow))
}

/// A picture from the key `texture`, with `texture_scale_m` beside it.
pub(super) fn read_texture(
    section: &Section,
    scene: &Path,
    pixels: impl Fn(&PngImage) -> Vec<[f32; 3]>,
) -> Result<Texture, RenderError> {
    let width_m = narrow(section.number(TEXTURE_SCALE_M, Some(1.0), 1e-4..=1e5, "m")?);
    let picture = PngImage::decode(&existing(section, "texture", scene)?)?;
    Ok(Texture::new(picture.width, pixels(&picture), width_m))
}

/// The file beside the scene that a key names.
pub(super) fn existing(section: &Section, key: &str, scene: &Path) -> Result<SceneFile, RenderError> {
    let path = scene.with_file_name(section.required_text(key)?);
    if path.is_file() {
        return SceneFile::read(&FilesIn::beside(scene), section.required_text(key)?);
    }
    Err(section.error_at(key, format!("{} {} does not exist", section.full_name(key), path.display())))
}
