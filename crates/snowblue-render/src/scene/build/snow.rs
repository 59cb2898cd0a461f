//! Snow: for PCASnow its curves from the table, for the reference integrator its grains.

use std::fmt::Display;

use snowblue_database::{DatabaseError, PcaSnow, fill};
use snowblue_field::SnowOptics;
use snowblue_transport::SnowSample;
use snowblue_transport::layer_file::{LayerFile, LayerFileError};
use snowblue_transport::monte_carlo::{GrainPlan, Volume};

use crate::error::RenderError;
use crate::files::check_formats;
use crate::geometry::ray::narrow;
use crate::images::png_image::PngImage;
use crate::scene::build::sources::Sources;
use crate::scene::build::texture::build_texture;
use crate::scene::description::{
    DescriptionError, KeyPath, LayeredSnowDescription, MaskDescription, PcaSnowDescription,
};
use crate::scene::file::line_of;
use crate::scene::integrator::IntegratorKind;
use crate::scene::layering::Layering;
use crate::scene::material::layered_snow::LayeredSnow;
use crate::scene::material::pca_snow::{Emission, PcaSnowMaterial, Reflection};
use crate::scene::material::snow_curves::{Mask, SnowCurves};
use crate::spectrum::wavelengths_nm;

/// Scattering events for short walks.
const SHORT_WALK_GRAINS: u32 = 1 << 18;

/// Builds snow for PCASnow.
pub(super) fn build_snow(
    path: &KeyPath,
    snow: &PcaSnowDescription,
    sources: &Sources,
) -> Result<PcaSnowMaterial, RenderError> {
    let curves = curves(path, snow, sources)?;
    let wanted = wavelengths_nm();
    let fits = curves.wavelengths_nm().len() == wanted.len()
        && curves.wavelengths_nm().iter().zip(wanted).all(|(one, other)| (one - other).abs() < 1e-6);
    if !sources.is_false_color && !fits {
        let reason = "needs a table of the wavelengths 400 to 700 nm in steps of 10 nm, except for false colours";
        return Err(path.error(reason).into());
    }
    Ok(PcaSnowMaterial {
        curves,
        path: snow.path,
        exit: snow.exit,
        emission: snow.emission,
        reflection: snow.reflectance.map_or(Reflection::Table, |share| Reflection::Constant(narrow(share))),
    })
}

/// Builds snow of layers from their file.
pub(super) fn build_layered_snow(
    path: &KeyPath,
    snow: &LayeredSnowDescription,
    sources: &Sources,
    integrator: IntegratorKind,
) -> Result<LayeredSnow, RenderError> {
    let path = path.key("layers");
    if !integrator.has_light_field() {
        let reason = format!(
            "applies to the integrators diffusion and hybrid only, but type is \"{}\" in [integrator]",
            integrator.name()
        );
        return Err(path.error(reason).into());
    }
    let file = sources.open(&path, &snow.layers)?;
    check_formats(&file.path)?;
    let text = file.text();
    let LayerFile { layers, .. } = LayerFile::parse(&text).map_err(|LayerFileError { span, reason }| {
        let line = line_of(&text, span.map_or(0, |span| span.start));
        RenderError::Layers { path: file.path.clone(), line, reason }
    })?;
    let samples = layers.iter().map(|layer| layer.sample).collect();
    Ok(LayeredSnow { samples, layering: Layering::new(&layers, snow.layers_top) })
}

/// Builds snow for random walks: long ones of the reference integrator, or short ones.
pub(super) fn build_volume(
    path: &KeyPath,
    sample: &SnowSample,
    sources: &Sources,
    integrator: IntegratorKind,
) -> Result<Volume, RenderError> {
    let volume = if integrator == IntegratorKind::Reference {
        Volume::new(sample, &sources.wavelengths_nm, &GrainPlan::default())
    } else {
        Volume::with_one_index(sample, &sources.wavelengths_nm, &GrainPlan { grains: SHORT_WALK_GRAINS, seed: 1 })
    };
    volume.map_err(|error| no_snow(path, &error))
}

/// Builds snow for the integrator that solves for the light inside.
pub(super) fn build_optics(
    path: &KeyPath,
    sample: &SnowSample,
    sources: &Sources,
    rays: u32,
) -> Result<SnowOptics, RenderError> {
    SnowOptics::new(sample, &sources.wavelengths_nm, rays).map_err(|error| no_snow(path, &error))
}

/// The sample of snow that is the same everywhere and follows no rule of PCASnow alone.
pub(super) fn uniform_sample(
    path: &KeyPath,
    snow: &PcaSnowDescription,
    sources: &Sources,
) -> Result<SnowSample, RenderError> {
    let keys = [
        ("mask", snow.mask.is_some()),
        ("reflectance", snow.reflectance.is_some()),
        ("emission", snow.emission != Emission::Transmitted),
    ];
    if let Some((key, _)) = keys.into_iter().find(|(_, is_given)| *is_given) {
        return Err(path
            .key(key)
            .error("applies to the integrator pcasnow only: set type = \"pcasnow\" in [integrator]")
            .into());
    }
    surface_sample(snow, sources).map_err(|reason| no_snow(path, &reason))
}

/// The sample of snow at a mask of 0, or why it is unknown.
pub(super) fn surface_sample(snow: &PcaSnowDescription, sources: &Sources) -> Result<SnowSample, String> {
    let ice = fill::ice_from_metadata(&sources.table.metadata);
    let ice = ice.map_err(|_| "the table does not name its ice (ice_constants)".to_owned())?;
    snow.sample_at(0.0).snow(ice).map_err(|error| error.to_string())
}

/// An error about snow that only PCASnow can render.
fn no_snow(path: &KeyPath, error: &dyn Display) -> RenderError {
    path.error(format!("cannot be rendered by this integrator: {error}")).into()
}

/// The curves of the snow that a material is made of.
fn curves(path: &KeyPath, snow: &PcaSnowDescription, sources: &Sources) -> Result<SnowCurves, RenderError> {
    let snow_at =
        |mask: f64| PcaSnow::new(sources.table, &snow.sample_at(mask)).map_err(|error| off_table(path, &error));
    match &snow.mask {
        None => Ok(snow_at(0.0).map(SnowCurves::even)?),
        Some(mask) => Ok(SnowCurves::varying(build_mask(&path.key("mask"), mask, sources)?, snow_at)?),
    }
}

fn build_mask(path: &KeyPath, mask: &MaskDescription, sources: &Sources) -> Result<Mask, RenderError> {
    match mask {
        MaskDescription::Texture(texture) => {
            build_texture(path, texture, sources, PngImage::encoded_rgb).map(Mask::RasterImage)
        }
        MaskDescription::Attribute { attribute, range } => {
            Ok(Mask::Attribute { name: attribute.clone(), range: range.map(narrow) })
        }
    }
}

/// An error about snow that the table does not hold, at the key of the property.
fn off_table(path: &KeyPath, error: &DatabaseError) -> DescriptionError {
    let (DatabaseError::OffGrid { quantity, .. }
    | DatabaseError::OffAxis { quantity, .. }
    | DatabaseError::NoAxis { quantity, .. }) = error
    else {
        return path.error(format!("cannot be taken from the table: {error}"));
    };
    let key = match *quantity {
        "grain size" => "grain_size_um",
        "facetness" => "facetness",
        "density" => "density_kg_m3",
        "water saturation" => "water_saturation",
        "temperature" => "temperature_c",
        _ => "impurities_ng_g",
    };
    path.key(key).error(format!("is not in the table: {error}"))
}
