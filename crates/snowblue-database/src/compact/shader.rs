//! The text of functions for shaders.

use std::fmt::{self, Write as _};

use snowblue_color::{LinearRgb, Xyz};

use super::chebyshev::Chebyshev2;
use super::{CompactSnow, least_root};

/// A shading language.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShaderLanguage {
    /// WebGPU Shading Language.
    Wgsl,
    /// OpenGL Shading Language 3.30, OpenGL ES 3.00, WebGL 2, and later; Godot's shaders.
    Glsl,
    /// Open Shading Language.
    Osl,
}

/// Differences between the languages.
struct Syntax {
    vector: &'static str,
    /// Declares a variable that does not change: before a number, and before a vector.
    let_number: &'static str,
    let_vector: &'static str,
    components: [&'static str; 3],
    /// The power of two of a vector.
    exp2: [&'static str; 2],
}

impl ShaderLanguage {
    fn syntax(self) -> Syntax {
        let (letters, vector_power) = ([".x", ".y", ".z"], ["exp2(", ")"]);
        match self {
            Self::Wgsl => Syntax {
                vector: "vec3f",
                let_number: "let",
                let_vector: "let",
                components: letters,
                exp2: vector_power,
            },
            Self::Glsl => Syntax {
                vector: "vec3",
                let_number: "float",
                let_vector: "vec3",
                components: letters,
                exp2: vector_power,
            },
            Self::Osl => Syntax {
                vector: "color",
                let_number: "float",
                let_vector: "color",
                components: ["[0]", "[1]", "[2]"],
                exp2: ["pow(color(2), ", ")"],
            },
        }
    }

    fn signature(self, name: &str) -> String {
        match self {
            Self::Wgsl => format!("fn {name}(thickness_m: f32, cos_incidence: f32) -> vec3f {{"),
            Self::Glsl => format!("vec3 {name}(float thickness_m, float cos_incidence) {{"),
            Self::Osl => format!("color {name}(float thickness_m, float cos_incidence)\n{{"),
        }
    }
}

impl CompactSnow {
    /// Two functions, `snow_transmittance` and `snow_reflectance`, of the thickness in m and the cosine of the angle of
    /// incidence. They return linear sRGB, where the light itself has luminance 1.
    #[must_use]
    pub fn functions(&self, language: ShaderLanguage) -> String {
        let mut text = String::new();
        self.write_functions(&mut text, language).expect("a string can be written to");
        text
    }

    fn write_functions(&self, text: &mut String, language: ShaderLanguage) -> fmt::Result {
        let Syntax { let_number, vector, .. } = language.syntax();
        for (name, polynomial) in [("transmittance", &self.transmittance), ("reflectance", &self.reflectance)] {
            let what = if name == "transmittance" { "goes through" } else { "is reflected by" };
            writeln!(
                text,
                "// Light that {what} snow, as linear sRGB: thickness in m, cosine of the angle of incidence."
            )?;
            writeln!(text, "{}", language.signature(&format!("snow_{name}")))?;
            // Light from behind the surface.
            writeln!(text, "    if (cos_incidence <= 0.0) {{ return {vector}(0.0); }}")?;
            writeln!(text, "    {let_number} h = max(thickness_m, 0.0);")?;
            let per_octave = 2.0 / self.range.greatest_logarithm() * std::f64::consts::LN_2;
            let one_per_scale = 1.0 / self.range.scale_m;
            writeln!(
                text,
                "    {let_number} x = min({} * log2(1.0 + {} * h) - 1.0, 1.0);",
                Number(per_octave),
                Number(one_per_scale)
            )?;
            let per_root = 2.0 / (1.0 - least_root());
            writeln!(
                text,
                "    {let_number} y = clamp({} * sqrt(cos_incidence) - {}, -1.0, 1.0);",
                Number(per_root),
                Number(1.0 + per_root * least_root())
            )?;
            write_sum(text, language, polynomial)?;
            self.write_result(text, language, name)?;
            writeln!(text, "}}")?;
        }
        Ok(())
    }

    /// The colour of the logarithms.
    fn write_result(&self, text: &mut String, language: ShaderLanguage, name: &str) -> fmt::Result {
        let Syntax { let_vector, vector, components, exp2: [power, end], .. } = language.syntax();
        if name == "transmittance" {
            let decay = Vector(vector, self.decay_per_m);
            writeln!(text, "    {let_vector} xyz = {power}sum - h * {decay}{end};")?;
        } else {
            let scale = Number(self.range.scale_m);
            writeln!(text, "    {let_vector} xyz = (h / (h + {scale})) * {power}sum{end};")?;
        }
        let column = |xyz: Xyz| {
            let LinearRgb { r, g, b } = LinearRgb::from_xyz(xyz);
            Vector(vector, [r, g, b])
        };
        let [x, y, z] = components;
        writeln!(
            text,
            "    return xyz{x} * {}\n        + xyz{y} * {}\n        + xyz{z} * {};",
            column(Xyz { x: 1.0, ..Xyz::default() }),
            column(Xyz { y: 1.0, ..Xyz::default() }),
            column(Xyz { z: 1.0, ..Xyz::default() })
        )
    }
}

/// The sum of Chebyshev polynomials by Clenshaw's recurrence, which is stable in single precision.
fn write_sum(text: &mut String, language: ShaderLanguage, polynomial: &Chebyshev2) -> fmt::Result {
    let Syntax { let_number, let_vector, vector, .. } = language.syntax();
    let rows = &polynomial.rows;
    for order in 2..polynomial.longest_row() {
        let before = |order: usize| match order {
            0 => "1.0".to_owned(),
            1 => "y".to_owned(),
            _ => format!("t{order}"),
        };
        writeln!(text, "    {let_number} t{order} = 2.0 * y * {} - {};", before(order - 1), before(order - 2))?;
    }
    for (order, row) in rows.iter().enumerate().rev() {
        let name = if order == 0 { "sum".to_owned() } else { format!("b{order}") };
        write!(text, "    {let_vector} {name} = {}", Vector(vector, row[0]))?;
        for (degree, coefficients) in row.iter().enumerate().skip(1) {
            let factor = if degree == 1 { "y".to_owned() } else { format!("t{degree}") };
            let [x, y, z] = *coefficients;
            if x.to_bits() == y.to_bits() && y.to_bits() == z.to_bits() {
                write!(text, "\n        + {factor} * {}", Number(x))?;
            } else {
                write!(text, "\n        + {factor} * {}", Vector(vector, *coefficients))?;
            }
        }
        let factor = if order == 0 { "x" } else { "2.0 * x" };
        if order + 1 < rows.len() {
            write!(text, "\n        + {factor} * b{}", order + 1)?;
        }
        if order + 2 < rows.len() {
            write!(text, " - b{}", order + 2)?;
        }
        writeln!(text, ";")?;
    }
    Ok(())
}

/// A number of a shader, in nine digits at most: always with a point or an exponent.
struct Number(f64);

/// Three numbers, with the name of their type.
struct Vector(&'static str, [f64; 3]);

impl fmt::Display for Number {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [all_digits, nine_digits] = [format!("{:?}", self.0), format!("{:.8e}", self.0)];
        formatter.write_str(if all_digits.len() < nine_digits.len() { &all_digits } else { &nine_digits })
    }
}

impl fmt::Display for Vector {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(name, [x, y, z]) = self;
        write!(formatter, "{name}({}, {}, {})", Number(*x), Number(*y), Number(*z))
    }
}
