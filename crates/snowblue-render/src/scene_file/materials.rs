//! The `[material.NAME]` tables.

use snowblue_database::{CompressedTable, DatabaseError, PcaSnow, Property, TableSample};
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

/// Keys of snow that is not dry, clean and at −5 °C.
const WATER_SATURATION: &str = "water_saturation";
const TEMPERATURE_C: &str = "temperature_c";
const IMPURITIES_NG_G: &str = "impurities_ng_g";

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
        WATER_SATURATION,
        TEMPERATURE_C,
        IMPURITIES_NG_G,
        "path",
        "exit",
        "emission",
        "reflectance",
    ])?;
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
    let snow = read_curves(section, table)?;
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

/// The curves of the snow that a material is made of.
fn read_curves(section: &Section, table: &CompressedTable) -> Result<PcaSnow, RenderError> {
    let mut sample = TableSample::new(
        section.number("grain_size_um", None, 20.0..=5000.0, "µm")?,
        section.number("facetness", None, 0.0..=1.0, "")?,
        section.number("density_kg_m3", None, 10.0..=900.0, "kg/m³")?,
    );
    for (key, property, range, unit) in [
        (WATER_SATURATION, Property::WaterSaturation, 0.0..=1.0, ""),
        (TEMPERATURE_C, Property::Temperature, -60.0..=0.0, "°C"),
    ] {
        if section.has(key) {
            sample = sample.with(property, section.number(key, None, range, unit)?);
        }
    }
    if let Some(contents) = section.table(IMPURITIES_NG_G)? {
        let impurities: Vec<Property> = Property::all().filter(|property| property.is_impurity()).collect();
        contents.only(&impurities.iter().map(|impurity| impurity.title()).collect::<Vec<_>>())?;
        for impurity in impurities.into_iter().filter(|impurity| contents.has(impurity.title())) {
            sample = sample.with(impurity, contents.number(impurity.title(), None, 0.0..=1e7, "ng/g")?);
        }
    }
    PcaSnow::new(table, &sample).map_err(|error| section.error_at(key_of(&error), error.to_string()))
}

/// The key of the value that a table does not reach.
fn key_of(error: &DatabaseError) -> &'static str {
    let (DatabaseError::OffGrid { quantity, .. }
    | DatabaseError::OffAxis { quantity, .. }
    | DatabaseError::NoAxis { quantity, .. }) = error
    else {
        return "type";
    };
    match *quantity {
        "grain size" => "grain_size_um",
        "facetness" => "facetness",
        "density" => "density_kg_m3",
        "water saturation" => WATER_SATURATION,
        "temperature" => TEMPERATURE_C,
        _ => IMPURITIES_NG_G,
    }
}
