//! Presets as MaterialX 1.39: `open_pbr_surface` and `standard_surface`.

use std::fmt::Write as _;

use super::written::{ColorSpace, Written, number, three};

/// A surface by OpenPBR 1.1.
pub(super) fn open_pbr(written: &Written) -> String {
    let color = ("subsurface_color", Value::Color(written.colors()));
    let inputs = [
        ("subsurface_weight", Value::Number(1.0)),
        color,
        ("subsurface_radius", Value::Number(written.scale())),
        ("subsurface_radius_scale", Value::Factors(written.relative_radii())),
        ("subsurface_scatter_anisotropy", Value::Number(written.preset.asymmetry)),
        // Without weight, the interface has the index 1 and does not refract.
        ("specular_weight", Value::Number(0.0)),
        ("specular_roughness", Value::Number(1.0)),
        ("specular_ior", Value::Number(written.preset.index)),
    ];
    document(written, "open_pbr_surface", &inputs)
}

/// A surface by Autodesk Standard Surface 1.0.1.
pub(super) fn standard_surface(written: &Written) -> String {
    let inputs = [
        ("base_color", Value::Color(written.colors())),
        ("subsurface", Value::Number(1.0)),
        ("subsurface_color", Value::Color(written.colors())),
        ("subsurface_radius", Value::Factors(written.relative_radii())),
        ("subsurface_scale", Value::Number(written.scale())),
        ("subsurface_anisotropy", Value::Number(written.preset.asymmetry)),
        ("specular", Value::Number(0.0)),
        ("specular_roughness", Value::Number(1.0)),
        ("specular_IOR", Value::Number(written.preset.index)),
    ];
    document(written, "standard_surface", &inputs)
}

/// A value of an input.
enum Value {
    Number(f64),
    /// A colour in the space of the preset.
    Color([f64; 3]),
    /// A factor for each channel, which no change of colour space may mix.
    Factors([f64; 3]),
}

/// A document with one material of one surface shader.
fn document(written: &Written, node: &str, inputs: &[(&str, Value)]) -> String {
    let space = color_space_name(written.color_space);
    let mut text = format!("<?xml version=\"1.0\"?>\n{}<materialx version=\"1.39\">\n", comment(&written.notes));
    // Writing to a string cannot fail.
    let _ = writeln!(text, "  <{node} name=\"snow_surface\" type=\"surfaceshader\">");
    for (name, value) in inputs {
        let value = match value {
            Value::Number(value) => format!("type=\"float\" value=\"{}\"", number(*value)),
            Value::Color(values) => format!("type=\"color3\" value=\"{}\" colorspace=\"{space}\"", three(*values)),
            Value::Factors(values) => format!("type=\"color3\" value=\"{}\"", three(*values)),
        };
        let _ = writeln!(text, "    <input name=\"{name}\" {value} />");
    }
    let _ = writeln!(text, "  </{node}>");
    text.push_str("  <surfacematerial name=\"Snow\" type=\"material\">\n");
    text.push_str("    <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"snow_surface\" />\n");
    text.push_str("  </surfacematerial>\n</materialx>\n");
    text
}

/// The name of a colour space in MaterialX. The name of Rec. 2020 comes from OpenColorIO's configurations for ACES.
fn color_space_name(space: ColorSpace) -> &'static str {
    match space {
        ColorSpace::AcesCg => "acescg",
        ColorSpace::SrgbLinear => "lin_rec709",
        ColorSpace::Rec2020 => "lin_rec2020",
    }
}

/// A comment of XML, in which two hyphens must not follow each other.
fn comment(lines: &[String]) -> String {
    // The second replacement is for three hyphens in a row.
    let apart = |line: &String| format!("  {line}").trim_end().replace("--", "- -").replace("--", "- -");
    let text: String = lines.iter().map(|line| apart(line) + "\n").collect();
    format!("<!--\n{text}-->\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_comment_never_ends_early() {
        let text = comment(&["a --> b".to_owned(), "---".to_owned()]);
        let content = text.strip_prefix("<!--").and_then(|text| text.strip_suffix("-->\n")).unwrap();
        assert!(!content.contains("--") && content.contains("a - -> b"), "{content}");
    }
}
