//! Snow.

use std::ops::Range;

use snowblue_base::files::check_formats;
use snowblue_base::toml_table::ParseError;
use snowblue_geometry::images::png_image::PngImage;
use snowblue_geometry::ray::narrow;
use snowblue_transport::layer_file::LayerFile;
use snowblue_transport::sample::SnowKeys;
use snowblue_transport::{Layer, SnowSample, short_number};

use crate::assembling::sources::Sources;
use crate::assembling::texture::build_texture;
use crate::description::{
    LayeredSnowDescription, MaskDescription, MaskedSnowDescription, SnowDescription, SnowMaterialDescription,
};
use crate::error::SceneError;
use crate::file::line_of;
use crate::layering::Layering;
use crate::material::mask::Mask;
use crate::material::snow::{Snow, SnowMaterial};
use crate::spectrum::wavelengths_nm;
use snowblue_base::{KeyError, KeyPath};

/// Builds snow as a material.
pub(super) fn build_snow_material(
    path: &KeyPath,
    SnowMaterialDescription { snow, sparkle, relief }: &SnowMaterialDescription,
    sources: &Sources,
) -> Result<SnowMaterial, SceneError> {
    let snow = build_snow(path, snow, sources)?;
    if let Some(facet_size_um) = sparkle.and_then(|sparkle| sparkle.facet_size_um) {
        // Facets vary with the grains about their mean, so that none is then larger than its grain.
        let sizes_um = snow.samples().iter().map(|sample| sample.grain_size.middle_um());
        let greatest_um = sizes_um.fold(f64::INFINITY, f64::min);
        if facet_size_um > greatest_um {
            let (size, greatest) = (short_number(facet_size_um), short_number(greatest_um));
            let reason = format!("is {size} µm, but must be at most {greatest} µm, the mean size of the grains");
            return Err(path.key("sparkle").key("facet_size_um").error(reason).into());
        }
    }
    if relief.is_some() && !cfg!(feature = "shapes") {
        return Err(path.key("relief").error("is what this build does not make").into());
    }
    Ok(SnowMaterial { snow, sparkle: *sparkle, relief: *relief })
}

/// Builds snow, whose tables of constants must cover the wavelengths of the picture.
fn build_snow(path: &KeyPath, snow: &SnowDescription, sources: &Sources) -> Result<Snow, SceneError> {
    let built = match snow {
        SnowDescription::Uniform(keys) => Snow::Uniform(sample(path, keys)?),
        SnowDescription::Layers(snow) => build_layers(&path.key("layers"), snow, sources)?,
        SnowDescription::Masked(MaskedSnowDescription { mask, between: [first, last] }) => Snow::Masked {
            mask: build_mask(&path.key("mask"), mask, sources)?,
            between: [sample(path, first)?, sample(path, last)?],
        },
    };
    for sample in built.samples() {
        for wavelength_nm in wavelengths_nm() {
            sample.check_wavelength(wavelength_nm).map_err(|error| path.error(format!("has no constants: {error}")))?;
        }
    }
    Ok(built)
}

fn sample(path: &KeyPath, keys: &SnowKeys) -> Result<SnowSample, KeyError> {
    keys.sample().map_err(|error| path.error(error))
}

fn build_layers(path: &KeyPath, snow: &LayeredSnowDescription, sources: &Sources) -> Result<Snow, SceneError> {
    let file = sources.open(path, &snow.layers)?;
    check_formats(&file.path)?;
    let text = file.text();
    let wrong = |span: Range<usize>, reason: String| SceneError::Text {
        path: file.path.clone(),
        line: line_of(&text, span.start),
        reason,
    };
    let parsed = LayerFile::parse(&text);
    let LayerFile { layers, spans, .. } = parsed.map_err(|ParseError { span, reason }| wrong(span, reason))?;
    let sample = |(layer, span): (&Layer, Range<usize>)| {
        let reason = "layer of clear ice has no model in scenes, whose layers must be of snow";
        layer.sample().copied().ok_or_else(|| wrong(span, reason.to_owned()))
    };
    let samples = layers.iter().zip(spans).map(sample).collect::<Result<_, _>>()?;
    Ok(Snow::Layers { samples, layering: Layering::new(&layers, snow.layers_top) })
}

fn build_mask(path: &KeyPath, mask: &MaskDescription, sources: &Sources) -> Result<Mask, SceneError> {
    match mask {
        MaskDescription::Texture(texture) => {
            build_texture(path, texture, sources, PngImage::encoded_rgb).map(Mask::RasterImage)
        }
        MaskDescription::Attribute { attribute, range } => {
            Ok(Mask::Attribute { name: attribute.clone(), range: range.map(narrow) })
        }
    }
}
