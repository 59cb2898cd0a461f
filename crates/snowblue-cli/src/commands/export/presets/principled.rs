//! Presets as a script for Blender, which makes a material with the Principled BSDF.

use super::written::{Written, number, three};

/// The part of the script that makes the material from the values before it.
const MATERIAL: &str = include_str!("principled.py");

/// A script that Blender runs.
pub(super) fn script(written: &Written) -> String {
    let comments: String = written.notes.iter().map(|line| format!("# {line}").trim_end().to_owned() + "\n").collect();
    format!(
        "{comments}
import bpy

SOCKETS = {{
    \"Base Color\": ({color}, 1.0),
    \"Subsurface Weight\": 1.0,
    \"Subsurface Radius\": ({radii}),
    \"Subsurface Scale\": {scale},
    \"Subsurface Anisotropy\": {asymmetry},
    \"IOR\": 1.0,
    \"Specular IOR Level\": 0.0,
    \"Roughness\": 1.0,
}}
{MATERIAL}",
        color = three(written.colors()),
        radii = three(written.relative_radii()),
        scale = number(written.scale()),
        asymmetry = number(written.preset.asymmetry),
    )
}
