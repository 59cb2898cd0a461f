//! Presets as UsdShade: one material with `UsdPreviewSurface` for every renderer, and OpenPBR for renderers that know
//! it.

use snowblue_color::RgbSpace;
use snowblue_database::preset::PresetError;

use super::written::{ColorSpace, Written, number, three};

/// A layer with the material `/Snow`.
///
/// # Errors
/// If the albedo of deep snow lies outside linear sRGB, the space of `UsdPreviewSurface`.
pub(super) fn material(written: &Written) -> Result<String, PresetError> {
    let albedo = written.reference.albedo(RgbSpace::Srgb)?;
    // Text in three quotation marks cannot contain quotation marks and backslashes. No note has such a character.
    let notes = written.notes.join("\n").replace(['\\', '"'], "'");
    let space = color_space_name(written.color_space);
    Ok(format!(
        r#"#usda 1.0
(
    defaultPrim = "Snow"
    doc = """{notes}
UsdPreviewSurface has no subsurface scattering: a diffuse surface with the albedo of deep snow, in linear sRGB."""
    metersPerUnit = {metres}
    upAxis = "Y"
)

def Material "Snow"
{{
    token outputs:surface.connect = </Snow/Preview.outputs:surface>
    token outputs:mtlx:surface.connect = </Snow/OpenPBR.outputs:out>

    def Shader "Preview"
    {{
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor = ({albedo}) (
            colorSpace = "lin_rec709_scene"
        )
        int inputs:useSpecularWorkflow = 1
        color3f inputs:specularColor = (0, 0, 0)
        float inputs:roughness = 1
        float inputs:ior = {index}
        token outputs:surface
    }}

    def Shader "OpenPBR"
    {{
        uniform token info:id = "ND_open_pbr_surface_surfaceshader"
        float inputs:subsurface_weight = 1
        color3f inputs:subsurface_color = ({color}) (
            colorSpace = "{space}"
        )
        float inputs:subsurface_radius = {scale}
        color3f inputs:subsurface_radius_scale = ({radii}) (
            colorSpace = "data"
        )
        float inputs:subsurface_scatter_anisotropy = {asymmetry}
        float inputs:specular_weight = 0
        float inputs:specular_roughness = 1
        float inputs:specular_ior = {index}
        token outputs:out
    }}
}}
"#,
        metres = written.unit.metres(),
        albedo = three(albedo),
        index = number(written.preset.index),
        color = three(written.colors()),
        scale = number(written.scale()),
        radii = three(written.relative_radii()),
        asymmetry = number(written.preset.asymmetry),
    ))
}

/// The name of a colour space in USD.
fn color_space_name(space: ColorSpace) -> &'static str {
    match space {
        ColorSpace::AcesCg => "lin_ap1_scene",
        ColorSpace::SrgbLinear => "lin_rec709_scene",
        ColorSpace::Rec2020 => "lin_rec2020_scene",
    }
}
