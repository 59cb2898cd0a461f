//! Materials.

use std::collections::BTreeMap;

use snowblue_geometry::ray::narrow;

use crate::assembling::snow::build_snow_material;
use crate::assembling::sources::Sources;
use crate::assembling::texture::{build_texture, linear_rgb};
use crate::description::{DiffuseDescription, MaterialDescription};
use crate::error::SceneError;
use crate::material::Material;
use crate::material::diffuse::Diffuse;
use crate::spectrum::Spectrum;
use crate::spectrum::file::SpectrumFile;
use snowblue_base::KeyPath;

/// A material with its name.
pub(super) struct NamedMaterial {
    pub(super) name: String,
    pub(super) material: Material,
}

/// Builds all materials, in alphabetical order.
pub(super) fn build_materials(
    descriptions: &BTreeMap<String, MaterialDescription>,
    sources: &Sources,
) -> Result<Vec<NamedMaterial>, SceneError> {
    let built = descriptions.iter().map(|(name, description)| {
        let path = KeyPath::root("material").key(name);
        let material = match description {
            MaterialDescription::Diffuse(diffuse) => Material::Diffuse(build_diffuse(&path, diffuse, sources)?),
            MaterialDescription::Snow(snow) => Material::Snow(Box::new(build_snow_material(&path, snow, sources)?)),
        };
        Ok(NamedMaterial { name: name.clone(), material })
    });
    built.collect()
}

fn build_diffuse(path: &KeyPath, diffuse: &DiffuseDescription, sources: &Sources) -> Result<Diffuse, SceneError> {
    match diffuse {
        DiffuseDescription::Uniform { reflectance } => Ok(Diffuse::Uniform(Spectrum::constant(narrow(*reflectance)))),
        DiffuseDescription::Color { reflectance_rgb } => Ok(sources.uniform(reflectance_rgb.linear())),
        DiffuseDescription::Spectrum { reflectance_spectrum } => {
            let file = sources.open(&path.key("reflectance_spectrum"), reflectance_spectrum)?;
            let spectrum = SpectrumFile::parse(&file, 1.0)?.resample()?;
            Ok(Diffuse::Uniform(Spectrum(spectrum.map(narrow))))
        }
        DiffuseDescription::Texture(texture) => {
            Ok(sources.textured(build_texture(path, texture, sources, linear_rgb)?))
        }
    }
}
