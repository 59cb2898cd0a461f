//! Materials of snow.

use snowblue_database::{DatabaseError, PcaSnow, Property, TableSample, fill};
use snowblue_transport::monte_carlo::{GrainPlan, Volume};
use snowblue_transport::range::ParameterRange;
use snowblue_transport::sample;

use crate::error::RenderError;
use crate::geometry::chord::Exit;
use crate::geometry::ray::narrow;
use crate::images::png_image::PngImage;
use crate::scene::file::materials::{TEXTURE_SCALE_M, Workshop, read_texture};
use crate::scene::file::section::Section;
use crate::scene::material::pca_snow::{Emission, PathMode, PcaSnowMaterial, Reflection};
use crate::scene::material::snow_curves::{Mask, SnowCurves};
use crate::spectrum::wavelengths_nm;

const GRAIN_SIZE_UM: &str = "grain_size_um";
const FACETNESS: &str = "facetness";
const DENSITY_KG_M3: &str = "density_kg_m3";
/// Keys of snow that is not dry, clean and at −5 °C.
const WATER_SATURATION: &str = "water_saturation";
const TEMPERATURE_C: &str = "temperature_c";
const IMPURITIES_NG_G: &str = "impurities_ng_g";

/// Reads snow, which may vary between two values of each of its properties.
pub(super) fn read_snow(section: &Section, workshop: &Workshop) -> Result<PcaSnowMaterial, RenderError> {
    section.only(&[
        "type",
        GRAIN_SIZE_UM,
        FACETNESS,
        DENSITY_KG_M3,
        WATER_SATURATION,
        TEMPERATURE_C,
        IMPURITIES_NG_G,
        "mask",
        "path",
        "exit",
        "emission",
        "reflectance",
    ])?;
    let paths = PathMode::ALL.map(|mode| (mode.name(), mode));
    let emissions = [("transmitted", Emission::Transmitted), ("relative", Emission::Relative)];
    let path = section.choice("path", PathMode::default(), &paths)?;
    let reflection = if section.has("reflectance") {
        Reflection::Constant(narrow(section.number("reflectance", None, 0.0..=1.0, "")?))
    } else {
        Reflection::Table
    };
    let curves = read_curves(section, workshop)?;
    let wanted = wavelengths_nm();
    let fits = curves.wavelengths_nm().len() == wanted.len()
        && curves.wavelengths_nm().iter().zip(wanted).all(|(one, other)| (one - other).abs() < 1e-6);
    if workshop.overrides.false_color.is_none() && !fits {
        return Err(
            section.error("the table's wavelengths must be 400 to 700 nm in steps of 10 nm, but for false colours")
        );
    }
    Ok(PcaSnowMaterial {
        curves,
        path: workshop.overrides.path.unwrap_or(path),
        exit: section.choice("exit", Exit::default(), &[("last", Exit::Last), ("first", Exit::First)])?,
        emission: section.choice("emission", Emission::default(), &emissions)?,
        reflection,
    })
}

/// The values of snow where a mask is 0 and where it is 1.
struct Range {
    grain_size_um: [f64; 2],
    facetness: [f64; 2],
    density_kg_m3: [f64; 2],
    further: Vec<(Property, [f64; 2])>,
}

impl Range {
    /// Reads all of them, and the name of a key that has two values, if one has.
    fn read<'key>(section: &Section) -> Result<(Self, Option<&'key str>), RenderError> {
        let mut varies = None;
        let mut read = |key: &'static str, range: ParameterRange| {
            varies = varies.or(section.is_list(key).then_some(key));
            section.one_or_two(key, range.inclusive(), range.unit)
        };
        let mut range = Self {
            grain_size_um: read(GRAIN_SIZE_UM, sample::GRAIN_SIZE_RANGE)?,
            facetness: read(FACETNESS, sample::FACETNESS_RANGE)?,
            density_kg_m3: read(DENSITY_KG_M3, sample::DENSITY_RANGE)?,
            further: Vec::new(),
        };
        if section.has(WATER_SATURATION) {
            range.further.push((Property::WaterSaturation, read(WATER_SATURATION, sample::WATER_SATURATION_RANGE)?));
        }
        if section.has(TEMPERATURE_C) {
            range.further.push((Property::Temperature, read(TEMPERATURE_C, sample::TEMPERATURE_RANGE)?));
        }
        if let Some(contents) = section.table(IMPURITIES_NG_G)? {
            let impurities: Vec<Property> = Property::all().filter(|property| property.is_impurity()).collect();
            contents.only(&impurities.iter().map(|impurity| impurity.title()).collect::<Vec<_>>())?;
            let fractions = sample::MASS_FRACTION_RANGE;
            for impurity in impurities.into_iter().filter(|impurity| contents.has(impurity.title())) {
                varies = varies.or(contents.is_list(impurity.title()).then_some(IMPURITIES_NG_G));
                range
                    .further
                    .push((impurity, contents.one_or_two(impurity.title(), fractions.inclusive(), fractions.unit)?));
            }
        }
        Ok((range, varies))
    }

    /// The snow where the mask has a value.
    fn at(&self, mask: f64) -> TableSample {
        let mix = |[first, second]: [f64; 2]| first + mask * (second - first);
        let sample = TableSample::new(mix(self.grain_size_um), mix(self.facetness), mix(self.density_kg_m3));
        self.further.iter().fold(sample, |sample, (property, values)| sample.with(*property, mix(*values)))
    }
}

/// Snow that was read as a material, as a volume for light to walk through.
pub(super) fn read_volume(section: &Section, workshop: &Workshop) -> Result<Volume, RenderError> {
    for key in ["mask", "reflectance", "emission"] {
        if section.has(key) && section.text(key).ok().flatten() != Some("transmitted") {
            let reason = format!("{} is not for the reference, where light walks", section.full_name(key));
            return Err(section.error_at(key, reason));
        }
    }
    let (range, _) = Range::read(section)?;
    let made = |error: &DatabaseError| section.error(error.to_string());
    let ice = fill::ice_from_metadata(&workshop.table.metadata).map_err(|error| made(&error))?;
    let sample = range.at(0.0).snow(ice).map_err(|error| made(&error))?;
    let volume = Volume::new(&sample, &workshop.wavelengths_nm, &GrainPlan::default());
    volume.map_err(|error| section.error(error.to_string()))
}

/// The curves of the snow that a material is made of.
fn read_curves(section: &Section, workshop: &Workshop) -> Result<SnowCurves, RenderError> {
    let (range, varies) = Range::read(section)?;
    let snow_at = |mask: f64| {
        let snow = PcaSnow::new(workshop.table, &range.at(mask));
        snow.map_err(|error| section.error_at(key_of(&error), error.to_string()))
    };
    match (varies, section.table("mask")?) {
        (None, None) => snow_at(0.0).map(SnowCurves::even),
        (Some(_), Some(mask)) => SnowCurves::varying(read_mask(&mask, workshop)?, snow_at),
        (Some(key), None) => {
            let reason = format!("{} has two values, but the material has no `mask`", section.full_name(key));
            Err(section.error_at(key, reason))
        }
        (None, Some(_)) => {
            Err(section.error_at("mask", "a mask needs a key with two values, as grain_size_um = [100, 500]"))
        }
    }
}

fn read_mask(section: &Section, workshop: &Workshop) -> Result<Mask, RenderError> {
    match section.text("attribute")? {
        None => {
            section.only(&["texture", TEXTURE_SCALE_M])?;
            read_texture(section, workshop.scene, PngImage::encoded_rgb).map(Mask::RasterImage)
        }
        Some(name) => {
            section.only(&["attribute", "range"])?;
            let range = if section.has("range") { section.pair("range", -1e9..=1e9, "")? } else { [0.0, 1.0] };
            if (range[1] - range[0]).abs() <= 0.0 {
                return Err(section.error_at("range", format!("{} must have two ends", section.full_name("range"))));
            }
            Ok(Mask::Attribute { name: name.to_owned(), range })
        }
    }
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
        "grain size" => GRAIN_SIZE_UM,
        "facetness" => FACETNESS,
        "density" => DENSITY_KG_M3,
        "water saturation" => WATER_SATURATION,
        "temperature" => TEMPERATURE_C,
        _ => IMPURITIES_NG_G,
    }
}
