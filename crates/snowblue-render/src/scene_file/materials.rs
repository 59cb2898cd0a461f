//! The `[material.NAME]` tables.

use snowblue_database::{CompressedTable, GridSample, PcaSnow};
use toml::de::DeTable;

use crate::chord::Exit;
use crate::error::RenderError;
use crate::material::Material;
use crate::material::diffuse::Diffuse;
use crate::material::pca_snow::{Emission, PathMode, PcaSnowMaterial, Reflection};
use crate::ray::narrow;
use crate::retina::Retina;
use crate::scene_file::Overrides;
use crate::scene_file::section::{SceneText, Section};
use crate::spectrum::wavelengths_nm;

/// A material with its name in the file.
pub(super) type Named = (String, Material);

/// Reads all materials, in alphabetical order.
pub(super) fn read_materials<'text>(
    source: SceneText<'text>,
    root: &'text DeTable<'text>,
    table: &CompressedTable,
    overrides: &Overrides,
    retina: &Retina,
) -> Result<Vec<Named>, RenderError> {
    let Some(value) = root.get("material") else {
        return Ok(Vec::new());
    };
    let Some(entries) = value.get_ref().as_table() else {
        return Err(source.error(&value.span(), "`material` must be written as [material.NAME]"));
    };
    let mut materials = Vec::with_capacity(entries.len());
    for (name, entry) in entries {
        let section = Section::new(source, format!("material.{}", name.get_ref()), entry)?;
        materials.push((name.get_ref().to_string(), read_material(section, table, overrides, retina)?));
    }
    Ok(materials)
}

fn read_material(
    section: Section,
    table: &CompressedTable,
    overrides: &Overrides,
    retina: &Retina,
) -> Result<Material, RenderError> {
    section.required_text("type")?;
    let is_snow = section.choice("type", false, &[("diffuse", false), ("pca_snow", true)])?;
    Ok(if is_snow {
        Material::PcaSnow(Box::new(read_snow(&section, table, overrides, retina)?))
    } else {
        section.only(&["type", "reflectance"])?;
        Material::Diffuse(Diffuse { reflectance: narrow(section.number("reflectance", None, 0.0..=1.0, "")?) })
    })
}

fn read_snow(
    section: &Section,
    table: &CompressedTable,
    overrides: &Overrides,
    retina: &Retina,
) -> Result<PcaSnowMaterial, RenderError> {
    section.only(&[
        "type",
        "grain_size_um",
        "facetness",
        "density_kg_m3",
        "path",
        "exit",
        "emission",
        "reflectance",
    ])?;
    let sample = GridSample {
        grain_size_um: section.number("grain_size_um", None, 20.0..=5000.0, "µm")?,
        facetness: section.number("facetness", None, 0.0..=1.0, "")?,
        density_kg_m3: section.number("density_kg_m3", None, 10.0..=900.0, "kg/m³")?,
    };
    let paths = [
        ("easiest", PathMode::Easiest),
        ("normal", PathMode::Normal),
        ("light", PathMode::Light),
        ("view", PathMode::View),
    ];
    let emissions = [("transmitted", Emission::Transmitted), ("relative", Emission::Relative)];
    let path = section.choice("path", PathMode::default(), &paths)?;
    let reflection = if section.has("reflectance") {
        Reflection::Constant(narrow(section.number("reflectance", None, 0.0..=1.0, "")?))
    } else {
        section.choice("reflectance", Reflection::Table, &[])?
    };
    let snow = PcaSnow::new(table, sample).map_err(|error| section.error(error.to_string()))?;
    let wanted = wavelengths_nm();
    let fits = snow.wavelengths_nm().len() == wanted.len()
        && snow.wavelengths_nm().iter().zip(wanted).all(|(one, other)| (one - other).abs() < 1e-6);
    if overrides.false_color.is_none() && !fits {
        return Err(
            section.error("the table's wavelengths must be 400 to 700 nm in steps of 10 nm, but for false colours")
        );
    }
    Ok(PcaSnowMaterial {
        snow,
        path: overrides.path.unwrap_or(path),
        exit: section.choice("exit", Exit::default(), &[("last", Exit::Last), ("first", Exit::First)])?,
        emission: section.choice("emission", Emission::default(), &emissions)?,
        reflection,
        luminance: retina.luminance(),
    })
}
