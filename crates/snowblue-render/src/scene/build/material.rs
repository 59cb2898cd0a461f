//! Materials.

use std::collections::BTreeMap;

use snowblue_transport::SnowSample;
use snowblue_transport::monte_carlo::Volume;

use crate::error::RenderError;
use crate::geometry::ray::narrow;
use crate::images::png_image::PngImage;
use crate::scene::build::snow::{build_layered_snow, build_snow, build_volume, uniform_sample};
use crate::scene::build::sources::Sources;
use crate::scene::build::texture::build_texture;
use crate::scene::description::{DiffuseDescription, KeyPath, MaterialDescription};
use crate::scene::integrator::IntegratorKind;
use crate::scene::material::Material;
use crate::scene::material::diffuse::Diffuse;
use crate::spectrum::Spectrum;
use crate::spectrum::file::SpectrumFile;

/// A material with its name.
pub(super) struct NamedMaterial {
    pub(super) name: String,
    pub(super) material: Material,
}

/// Builds all materials, in alphabetical order.
pub(super) fn build_materials(
    descriptions: &BTreeMap<String, MaterialDescription>,
    sources: &Sources,
    integrator: IntegratorKind,
) -> Result<Vec<NamedMaterial>, RenderError> {
    let built = descriptions.iter().map(|(name, description)| {
        let path = KeyPath::root("material").key(name);
        let material = match description {
            MaterialDescription::Diffuse(diffuse) => Material::Diffuse(build_diffuse(&path, diffuse, sources)?),
            MaterialDescription::PcaSnow(snow) => Material::PcaSnow(Box::new(build_snow(&path, snow, sources)?)),
            MaterialDescription::LayeredSnow(snow) => {
                Material::LayeredSnow(build_layered_snow(&path, snow, sources, integrator)?)
            }
        };
        Ok(NamedMaterial { name: name.clone(), material })
    });
    built.collect()
}

/// The layers of snow of each material, in the same order, for the integrators that walk through them.
pub(super) fn build_volumes<'a>(
    snow: &[Vec<SnowSample>],
    names: impl Iterator<Item = &'a String>,
    sources: &Sources,
    integrator: IntegratorKind,
) -> Result<Vec<Vec<Volume>>, RenderError> {
    let mut volumes: Vec<Vec<Volume>> = Vec::new();
    if matches!(integrator, IntegratorKind::PcaSnow | IntegratorKind::Diffusion) {
        return Ok(volumes);
    }
    for (layers, name) in snow.iter().zip(names) {
        let path = KeyPath::root("material").key(name);
        let of_layers: Result<Vec<Volume>, _> =
            layers.iter().map(|sample| build_volume(&path, sample, sources, integrator)).collect();
        let of_layers = of_layers?;
        let nodes = |volume: &Volume| volume.nodes().len();
        if let (Some(one), Some(other)) = (of_layers.first(), volumes.iter().flatten().next())
            && nodes(one) != nodes(other)
        {
            let reason = "does not fit the other snow: the reference takes snow with particles, or more than half \
                          full of water, and other snow in separate scenes";
            return Err(path.error(reason).into());
        }
        volumes.push(of_layers);
    }
    Ok(volumes)
}

/// The snow of each material, in the same order, layer by layer: none of other materials, nor for PCASnow.
pub(super) fn snow_samples(
    descriptions: &BTreeMap<String, MaterialDescription>,
    materials: &[Material],
    sources: &Sources,
    integrator: IntegratorKind,
) -> Result<Vec<Vec<SnowSample>>, RenderError> {
    if integrator == IntegratorKind::PcaSnow {
        return Ok(Vec::new());
    }
    let of_material =
        |((name, description), material): ((&String, &MaterialDescription), &_)| match (description, material) {
            (MaterialDescription::PcaSnow(snow), _) => {
                uniform_sample(&KeyPath::root("material").key(name), snow, sources).map(|sample| vec![sample])
            }
            (_, Material::LayeredSnow(snow)) => Ok(snow.samples.clone()),
            _ => Ok(Vec::new()),
        };
    descriptions.iter().zip(materials).map(of_material).collect()
}

fn build_diffuse(path: &KeyPath, diffuse: &DiffuseDescription, sources: &Sources) -> Result<Diffuse, RenderError> {
    match diffuse {
        DiffuseDescription::Uniform { reflectance } => Ok(Diffuse::Uniform(Spectrum::constant(narrow(*reflectance)))),
        DiffuseDescription::Color { reflectance_rgb } => Ok(sources.uniform(reflectance_rgb.linear())),
        DiffuseDescription::Spectrum { reflectance_spectrum } => {
            let file = sources.open(&path.key("reflectance_spectrum"), reflectance_spectrum)?;
            let spectrum = SpectrumFile::parse(&file, 1.0)?.resample(&sources.wavelengths_nm)?;
            Ok(Diffuse::Uniform(Spectrum(spectrum.map(narrow))))
        }
        DiffuseDescription::Texture(texture) => {
            Ok(sources.textured(build_texture(path, texture, sources, PngImage::linear_rgb)?))
        }
    }
}
